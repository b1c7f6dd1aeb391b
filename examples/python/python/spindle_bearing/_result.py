"""Answers over arrays of loads."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ._errors import optional

if TYPE_CHECKING:
    import pandas

    from . import _core
    from ._spindle import Spindle

Array = NDArray[np.float64]
CONTACTS = ["q_i_n", "q_o_n", "p_i_pa", "p_o_pa", "alpha_i_rad", "alpha_o_rad"]


class Table:
    """A table of `cargo replay`: fields of numbers, fields of words, so many lines for each load."""

    def __init__(self, table: _core.Table) -> None:
        columns, self.lines, self.numbers, words = table
        self.columns = [name for name, _ in columns]
        self.places = {name: i for i, name in enumerate(name for name, is_word in columns if not is_word)}
        names = [name for name, is_word in columns if is_word]
        self.words = {name: words[i :: len(names)] for i, name in enumerate(names)}

    def figures(self, first: str, count: int = 1) -> Array:
        """So many columns from this one on: (loads, lines, count)."""
        place = self.places[first]
        return self.numbers[:, place : place + count].reshape(-1, self.lines, count)

    def frame(self) -> pandas.DataFrame:
        pandas = optional("pandas", "to_frame()")
        frame = pandas.DataFrame(self.words | {name: self.numbers[:, place] for name, place in self.places.items()}, columns=self.columns)
        return frame.astype({name: int for name in ("row", "ball") if name in self.places})


class Row:
    """A row of balls, over all loads.

    Arrays of contacts are (n, balls, 2): at the inner and at the outer race.
    """

    def __init__(self, tables: list[Table], number: int, first_ball: int, balls: int) -> None:
        _, self._rows, self._frequencies, self._of_contacts = tables
        self._number, self._of_balls = number, slice(first_ball, first_ball + balls)

    def _figures(self, first: str, count: int) -> Array:
        return self._rows.figures(first, count)[:, self._number]

    def _contacts(self, inner: str) -> Array:
        return self._of_contacts.figures(inner, 2)[:, self._of_balls]

    @property
    def force(self) -> Array:
        """Load on the inner ring in the row's own frame, N and N m: (n, 5)."""
        return self._figures("fx_n", 5)

    @property
    def preload(self) -> Array:
        """Preload, N: (n,)."""
        return self._figures("preload_n", 1)[:, 0]

    @property
    def stiffness(self) -> Array:
        """Stiffness between shaft and housing at the row, N/m, N, N m/rad: (n, 5, 5)."""
        return self._figures("k_row_x_x", 25).reshape(-1, 5, 5)

    @property
    def displacement(self) -> Array:
        """Displacement of the shaft at the row, m and rad: (n, 5)."""
        return self._figures("dx_m", 5)

    @property
    def life(self) -> Array:
        """Basic rating life by ISO/TS 16281 under each load, h: (n,); infinite at rest or without load."""
        return self._figures("l10_h", 1)[:, 0]

    @property
    def frequencies(self) -> dict[str, Array]:
        """Frequencies at which damage of the cage, the outer and inner race and a ball is heard, Hz: (n,) each."""
        names = ["cage", "outer_race", "inner_race", "ball"]
        return dict(zip(names, self._frequencies.figures("cage_hz", 4)[:, self._number].T))

    @property
    def contact_force(self) -> Array:
        """Contact forces, N: (n, balls, 2)."""
        return self._contacts("q_i_n")

    @property
    def pressure(self) -> Array:
        """Peak contact pressures, Pa: (n, balls, 2)."""
        return self._contacts("p_i_pa")

    @property
    def contact_angle(self) -> Array:
        """Contact angles, rad: (n, balls, 2)."""
        return self._contacts("alpha_i_rad")


class Result:
    """Answers to an array of n loads.

    Figures of a load without an answer are not numbers (NaN), and `error` says why.

    Attributes
    ----------
    loads : ndarray (n, 5)
        Loads, N and N m.
    rpm : ndarray (n,)
        Speeds of the shaft, 1/min.
    status : ndarray of str (n,)
        `converged`, `precision-limit` (as close as the precision allows), or why there is no answer.
    error : ndarray of str (n,)
        Why there is no answer, in words; empty where there is one.
    iterations : ndarray (n,)
        Passes over all balls.
    displacement : ndarray (n, 5)
        Displacement of the shaft at x = 0, m and rad.
    stiffness : ndarray (n, 5, 5)
        Exact stiffness there: the change of load with displacement, N/m, N, N m/rad.
    life : ndarray (n,)
        Basic rating life of all rows under each load, h; infinite at rest or without load.
    limits : ndarray of str (n,)
        Physical limits that are passed, with blanks between them.
    reaction : ndarray (n, 5) or None
        Loads that hold the displacements of `given`, N and N m.
    rows : list of Row
        The rows of balls.
    balls : list of dict of ndarray (n, balls)
        States of the balls of each row, by the columns of `cargo replay --balls`. The loads are solved once more for them.

    Notes
    -----
    A load of a pair of rows with 20 balls takes 3 kB. `Spindle.replay` takes 0.5 kB, and `Spindle.life` keeps no record.
    """

    def __init__(self, spindle: Spindle, records: Array, ask: dict[str, Any]) -> None:
        self._spindle, self._records, self._ask = spindle, records, ask
        self._more: dict[tuple[str, float | None], Table] = {}
        wanted = [("results", []), ("rows", []), ("frequencies", []), ("balls", CONTACTS)]
        tables, refusals = self._solve(wanted)
        self._ask = {**ask, "progress": None}
        results = tables[0]
        self._more["results", None], self._more["rows", None], self._more["frequencies", None] = tables[:3]
        self.loads, self.rpm = records[:, 1:6], records[:, 6]
        self.status = np.array(results.words["status"], dtype=str)
        self.limits = np.array(results.words["limits"], dtype=str)
        self.error = np.full(len(records), "", dtype=object)
        for number, words in refusals:
            self.error[number] = words
        self.iterations = results.figures("iterations")[:, 0, 0]
        self.displacement = results.figures("dx_m", 5)[:, 0]
        self.stiffness = results.figures("k_x_x", 25).reshape(-1, 5, 5)
        self.life = results.figures("l10_h")[:, 0, 0]
        held = "reaction_fx_n" in results.places
        self.reaction = results.figures("reaction_fx_n", 5)[:, 0] if held else None
        counts = [row[0] for row in spindle._core.rows]
        firsts = np.cumsum([0, *counts])
        self.rows = [Row(tables, i, firsts[i], count) for i, count in enumerate(counts)]

    def _solve(self, tables: list[tuple[str, list[str]]], at: float | None = None) -> tuple[list[Table], list[tuple[int, str]]]:
        ask = self._ask
        found, refusals = self._spindle._core.solve(self._records, tables, ask["options"], (at, ask["threads"], ask["progress"]))
        return list(map(Table, found)), refusals

    def _table(self, name: str, at: float | None = None) -> Table:
        if (name, at) not in self._more:
            self._more[name, at] = self._solve([(name, [])], at)[0][0]
        return self._more[name, at]

    @property
    def balls(self) -> list[dict[str, Array]]:
        table = self._table("balls")
        names = [name for name in table.places if name not in ("time_s", "row", "ball")]
        return [{name: table.figures(name)[:, row._of_balls, 0] for name in names} for row in self.rows]

    def at(self, x: float) -> Array:
        """Displacement of the shaft at the position `x` (m), m and rad: (n, 5). The loads are solved once more for it."""
        return self._table("noses", float(x)).figures("dx_m", 5)[:, 0]

    def compliance(self, x: float) -> Array:
        """Compliance at the position `x` (m), displacement per load, m/N, 1/N, rad/(N m): (n, 5, 5)."""
        return self._table("noses", float(x)).figures("c_x_x", 25).reshape(-1, 5, 5)

    def to_frame(self, table: str = "results") -> pandas.DataFrame:
        """A table of `cargo replay`, with its names and units: `results`, `rows`, `balls`, `frequencies`, `noses`."""
        return self._table(table).frame()

    def plot(self, over: Array | None = None):
        """Draws displacements and stiffness over the loads' numbers, or over an array (n,).

        Returns
        -------
        matplotlib.figure.Figure
        """
        plt = optional("matplotlib.pyplot", "plot()")
        along = np.arange(len(self.loads)) if over is None else over
        figure, (above, below) = plt.subplots(2, 1, sharex=True, layout="constrained")
        for i, axis in enumerate("xyz"):
            above.plot(along, 1e6 * self.displacement[:, i], label=f"d{axis}")
            below.plot(along, 1e-6 * self.stiffness[:, i, i], label=f"k_{axis}_{axis}")
        above.set_ylabel("displacement at x = 0 / um")
        below.set_ylabel("stiffness / N/um")
        above.legend()
        below.legend()
        return figure

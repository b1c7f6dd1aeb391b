"""Spindles and bearings."""

from __future__ import annotations

import csv
import json
import os
import sys
import warnings
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
import tomli_w
from numpy.typing import ArrayLike

from . import _core, _records
from ._errors import SpindleError, optional
from ._result import Result, Table

if TYPE_CHECKING:
    import pandas

OPTIONS = """
        **options
            Those of `cargo replay`, by the same names: `precision` ("f64", "f32"), `attitude` ("raceless", "outer", "inner"),
            `motion` ("full", "centrifugal", "static"), `freedoms` (5, or 3 with the tilts locked), `given` (displacements at
            x = 0 in the place of loads, such as {"tz": 0}; m, rad), `tolerance` (largest change of the stiffness along the
            last step), `cold` (each load from scratch), `peak_pressure` (MPa) and `friction`, above which `limits` marks.
        threads : int, optional
            Threads; all cores without it. Answers do not depend on it.
        progress : bool
            Show a bar, by tqdm if it is installed."""


def _with_options(method):
    method.__doc__ = (method.__doc__ or "").replace("\n        OPTIONS", OPTIONS)
    return method


class Spindle:
    """A spindle, or a bearing alone.

    Parameters
    ----------
    keys : dict
        The keys of a file, such as ``{"name": "pair", "preload_n": 294, "row": [{"bearing": "gmn:S6014C", ..}, ..]}``. Files
        of bearings are looked for in the current folder.

    Attributes
    ----------
    name : str
        Its name.
    doubts : list of str
        Figures that are taken as they stand, and seem to be meant otherwise. They are warnings when it is read.

    Raises
    ------
    SpindleError
        Keys that make no spindle, with file, line and column.
    """

    def __init__(self, keys: Mapping[str, Any]) -> None:
        if not isinstance(keys, Mapping):
            raise SpindleError(f"a dict of keys is due, and this is a {type(keys).__name__}: Spindle.read(path) reads a file")
        try:
            text = tomli_w.dumps(keys)
        except (TypeError, ValueError, AttributeError) as error:
            raise SpindleError(f"the keys are no TOML: {error}") from None
        self._take(_core.Spindle.parse("keys", text, None))

    def _take(self, core: _core.Spindle) -> None:
        self._core = core
        self.name, self.doubts = core.name, core.doubts
        for doubt in core.doubts:
            warnings.warn(doubt, stacklevel=3)

    @classmethod
    def read(cls, path: str | os.PathLike[str]) -> Spindle:
        """Reads the file of `cargo replay` and of the board, or takes a bearing of the catalogue, such as "gmn:S6014C".

        Raises
        ------
        SpindleError
            A file that is no spindle, with line and column.
        """
        spindle = cls.__new__(cls)
        spindle._take(_core.Spindle.read(path))
        return spindle

    def __reduce__(self):
        return _unpickled, (type(self), *self._core.state())

    def __repr__(self) -> str:
        return f"<Spindle {self.name!r}: {len(self._core.rows)} rows>"

    @_with_options
    def solve(
        self,
        loads: ArrayLike | None = None,
        rpm: ArrayLike = 0.0,
        temperatures: ArrayLike | None = None,
        *,
        threads: int | None = None,
        progress: bool = False,
        **options: Any,
    ) -> Result:
        """Solves an array of loads. All arrays are broadcast.

        Parameters
        ----------
        loads : array_like (n, 5) or (5,), optional
            Axial and radial forces and moments, N and N m. Or `fx`, `fy`, `fz`, `my`, `mz` by name, each a number or (n,).
        rpm : array_like (n,) or a number
            Speed of the shaft, 1/min.
        temperatures : array_like (n, 2) or (2,), optional
            Temperatures of the inner and the outer side, deg C, of a spindle with `[heat]`; its reference without them.
        OPTIONS

        Returns
        -------
        Result
            Answers; where there is none, its figures are NaN.

        Raises
        ------
        SpindleError
            Arrays or options that do not fit each other or the spindle.

        Notes
        -----
        Loads are solved in blocks of 500, each from a cold start, and within a block each from the one before it.
        """
        named = {name: options.pop(name) for name in _records.LOADS if name in options}
        records = _records.of_arrays(self._core, loads, named, rpm, temperatures)
        with _Bar(progress, len(records)) as bar:
            return Result(self, records, {"options": options, "threads": _threads(threads), "progress": bar})

    @_with_options
    def replay(
        self,
        df: pandas.DataFrame,
        columns: Mapping[str, str] | None = None,
        table: str = "results",
        *,
        threads: int | None = None,
        progress: bool = False,
        **options: Any,
    ) -> pandas.DataFrame:
        """Solves a recording, as `cargo replay` does.

        Parameters
        ----------
        df : pandas.DataFrame
            Columns `fx_n`, `fy_n`, `fz_n`, `my_nm`, `mz_nm`, `speed_rpm`; `time_s`, without which rows are counted;
            `t_inner_c` and `t_outer_c` of a spindle with `[heat]`.
        columns : dict, optional
            The frame's own names of them, such as ``{"fx_n": "Fz [N]"}``. Units stay.
        table : str
            `results`, `rows`, `noses`, `balls` or `frequencies`.
        OPTIONS

        Returns
        -------
        pandas.DataFrame
            The table of `cargo replay`, with its names and units.

        Raises
        ------
        SpindleError
            Columns that are missing, in another unit or no numbers, and options that do not fit.
        """
        records = _records.of_frame(self._core, df, columns, _held(options))
        with _Bar(progress, len(records)) as bar:
            tables, _ = self._core.solve(records, [(table, [])], options, (None, _threads(threads), bar))
        return Table(tables[0]).frame()

    @_with_options
    def life(
        self,
        df: pandas.DataFrame,
        columns: Mapping[str, str] | None = None,
        *,
        threads: int | None = None,
        progress: bool = False,
        **options: Any,
    ) -> dict[str, Any]:
        """Sums over a recording: rating life, worst pressure, least preload, time beyond limits.

        Parameters
        ----------
        df, columns
            As of `replay`.
        OPTIONS
            Besides, `pauses` ("end", "hold"): how long a record counts before a pause of the logger.

        Returns
        -------
        dict
            As of `cargo replay --summary=json`, SI units; `notes` has remarks about times.
        """
        records = _records.of_frame(self._core, df, columns, _held(options))
        with _Bar(progress, len(records)) as bar:
            text, notes = self._core.life(records, options, _threads(threads), bar)
        return {**json.loads(text), "notes": notes}

    def limits(
        self,
        df: pandas.DataFrame,
        columns: Mapping[str, str] | None = None,
        *,
        board: str = "f405",
        commission: tuple[float, float] | None = None,
    ) -> pandas.DataFrame:
        """Alarms that the board's monitor would raise over a recording.

        Parameters
        ----------
        df, columns
            As of `replay`; readings of the probes besides, `probe_NAME_um`.
        board : str
            "f405" or "h743".
        commission : (float, float), optional
            Learn from the first time on, and do not end commissioning before the second one, s.

        Returns
        -------
        pandas.DataFrame
            As of `cargo replay --limits`; ``attrs["notes"]`` has remarks.
        """
        probes = any(f"probe_{name}_um" in {*df.columns, *(columns or {})} for name in self._core.probes)
        records = _records.of_frame(self._core, df, columns, set(), probes)
        return _frame(*self._core.limits(records, board, _window(commission)))

    def response(
        self,
        df: pandas.DataFrame,
        columns: Mapping[str, str] | None = None,
        *,
        commission: tuple[float, float] | None = None,
    ) -> pandas.DataFrame:
        """Preload that the board's monitor measures with the probes, and their gains, second by second.

        Parameters
        ----------
        df, columns, commission
            As of `limits`.

        Returns
        -------
        pandas.DataFrame
            As of `cargo replay --response`; ``attrs["notes"]`` has findings.
        """
        records = _records.of_frame(self._core, df, columns, set(), True)
        return _frame(*self._core.response(records, _window(commission)))

    def sensitivity(
        self,
        *,
        rpm: float | None = None,
        t_inner: float | None = None,
        t_outer: float | None = None,
        **loads: float,
    ) -> pandas.DataFrame:
        """What 1 um of each row's closure, 1 N of the spring and 1 K on either side do.

        Parameters
        ----------
        rpm, t_inner, t_outer, fx, fy, fz, my, mz : float, optional
            The state, 1/min, deg C, N and N m; idling, at rest and cold without them.

        Returns
        -------
        pandas.DataFrame
            As of `cargo replay --sensitivity`: changes of each row's preload, N, and of the displacements at noses and
            probes, um.
        """
        if unknown := set(loads) - {*_records.LOADS}:
            raise SpindleError(f"there is no {unknown.pop()}: give {', '.join(_records.LOADS)}, rpm, t_inner or t_outer")
        loads_of = [loads.get(name) for name in _records.LOADS]
        return _frame(self._core.sensitivity([None, *loads_of, rpm, t_inner, t_outer]), []).set_index("change")

    def plot(self):
        """Draws shaft, rows, noses.

        Returns
        -------
        matplotlib.figure.Figure
        """
        plt = optional("matplotlib.pyplot", "plot()")
        figure, axes = plt.subplots(layout="constrained")
        for start, end, outer, inner in self._core.sections:
            for sign in (1, -1):
                heights = [sign * 500 * inner, sign * 500 * outer]
                axes.fill_between([1e3 * start, 1e3 * end], *heights, color="0.85", edgecolor="0.4")
        for _, position, pitch, ball, facing in self._core.rows:
            for sign in (1, -1):
                centre = (1e3 * position, sign * 500 * pitch)
                axes.add_patch(plt.Circle(centre, 500 * ball, facecolor="white", edgecolor="black"))
                axes.annotate(facing, centre, ha="center", va="center", size=7)
        for name, position in self._core.noses.items():
            axes.annotate(name, (1e3 * position, 0), ha="center")
            axes.plot(1e3 * position, 0, "kx")
        axes.axhline(0, color="black", lw=0.5, ls="-.")
        axes.set(xlabel="x / mm", ylabel="radius / mm", title=self.name, aspect="equal")
        return figure


def _unpickled(cls: type[Spindle], path: str, text: str | None, designs: dict[str, str]) -> Spindle:
    spindle = cls.__new__(cls)
    spindle._core = _core.Spindle.read(path) if text is None else _core.Spindle.parse(path, text, designs)
    spindle.name, spindle.doubts = spindle._core.name, spindle._core.doubts
    return spindle


def _held(options: Mapping[str, Any]) -> set[str]:
    return {*options.get("given", {}), *(("ty", "tz") if options.get("freedoms") == 3 else ())}


def _threads(threads: int | None) -> int:
    if threads is None:
        return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    if not isinstance(threads, int) or threads < 1:
        raise SpindleError(f"threads={threads!r}: give a number from 1 on, or leave it out for all cores")
    return threads


def _window(commission: tuple[float, float] | None) -> str | None:
    return None if commission is None else ":".join(map(str, commission))


def _frame(text: str, notes: list[str]) -> pandas.DataFrame:
    pandas = optional("pandas", "a table")
    names, *lines = csv.reader(text.splitlines())
    fields = zip(*lines) if lines else [()] * len(names)
    frame = pandas.DataFrame({name: _figures(field) for name, field in zip(names, fields)})
    frame.attrs["notes"] = notes
    return frame


def _figures(field: tuple[str, ...]) -> list[float] | tuple[str, ...]:
    try:
        return [float(text or "nan") for text in field]
    except ValueError:
        return field


class _Bar:
    """Shows how many loads are solved: by tqdm, or in words."""

    def __init__(self, wanted: bool, total: int) -> None:
        self.wanted, self.total = wanted, total

    def __enter__(self):
        if not self.wanted:
            return None
        try:
            from tqdm.auto import tqdm
        except ImportError:
            return lambda done: print(f"{done} of {self.total} loads are solved", file=sys.stderr)
        self.bar = tqdm(total=self.total, unit="loads")
        return lambda done: self.bar.update(done - self.bar.n)

    def __exit__(self, *_: object) -> None:
        if hasattr(self, "bar"):
            self.bar.close()

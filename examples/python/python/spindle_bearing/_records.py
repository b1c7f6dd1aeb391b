"""Loads, speeds and temperatures of arrays and frames as records."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core
from ._errors import SpindleError

if TYPE_CHECKING:
    import pandas

# Columns of a record, in the order of the compiled part; probes follow.
COLUMNS = ["time_s", "fx_n", "fy_n", "fz_n", "my_nm", "mz_nm", "speed_rpm", "t_inner_c", "t_outer_c"]
LOADS = ["fx", "fy", "fz", "my", "mz"]
FREEDOMS = ["dx", "dy", "dz", "ty", "tz"]
PROBES = 4


def numbers(name: str, given: ArrayLike) -> NDArray[np.float64]:
    """An array of real numbers, or words that say why it is none."""
    try:
        array = np.asarray(given)
        if array.dtype.kind in "biufO":
            return array.astype(float, copy=False)
    except (TypeError, ValueError) as error:
        raise SpindleError(f"{name} is no array of numbers: {error}") from None
    found = repr(str(array.ravel()[0])) if array.dtype.kind in "US" and array.size else array.dtype
    raise SpindleError(f"{name} has {found}, and numbers are due")


def of_arrays(
    core: _core.Spindle,
    loads: ArrayLike | None,
    named: Mapping[str, ArrayLike],
    rpm: ArrayLike,
    temperatures: ArrayLike | None,
) -> NDArray[np.float64]:
    """Records of arrays, which are broadcast."""
    parts: dict[str, NDArray[np.float64]] = {}
    if loads is not None:
        if named:
            raise SpindleError(f"loads has {', '.join(named)} already: give loads, or {', '.join(LOADS)} by name")
        array = numbers("loads", loads)
        if array.ndim not in (1, 2) or array.shape[-1] != 5:
            turned = ": turn it (loads.T)" if array.ndim == 2 and array.shape[0] == 5 else ""
            raise SpindleError(f"loads has the shape {array.shape}, and (n, 5) is due, fx, fy, fz (N), my, mz (N m){turned}")
        parts.update(zip(LOADS, np.moveaxis(array, -1, 0)))
    else:
        parts.update({name: numbers(name, given) for name, given in named.items()})
    parts["rpm"] = numbers("rpm", rpm)
    reference = core.reference
    if temperatures is not None:
        if reference is None:
            raise SpindleError("temperatures are for spindles with [heat]: add that with reference_c, or leave them out")
        array = numbers("temperatures", temperatures)
        if array.ndim not in (1, 2) or array.shape[-1] != 2:
            raise SpindleError(f"temperatures has the shape {array.shape}, and (n, 2) is due: inner and outer side, deg C")
        parts["temperatures"], parts["t_outer"] = np.moveaxis(array, -1, 0)
    for name, array in parts.items():
        if array.ndim > 1:
            raise SpindleError(f"{name} has the shape {array.shape}, and a number or (n,) is due")
    lengths = {name: array.size for name, array in parts.items() if array.ndim and array.size != 1}
    if len(set(lengths.values())) > 1:
        found = ", ".join(f"{name} {length}" for name, length in lengths.items())
        raise SpindleError(f"lengths differ ({found}): give as many of each, or one number")
    count = next(iter(lengths.values()), 1)
    records = np.full((count, len(COLUMNS) + PROBES), np.nan)
    records[:, 0] = np.arange(count)
    records[:, 7:9] = np.nan if reference is None else reference
    for i, name in enumerate([*LOADS, "rpm", "temperatures", "t_outer"], 1):
        records[:, i] = parts.get(name, records[:, i] if i > 6 else 0.0)
    return records


def of_frame(
    core: _core.Spindle,
    frame: pandas.DataFrame,
    columns: Mapping[str, str] | None,
    given: set[str],
    probes: bool = False,
) -> NDArray[np.float64]:
    """Records of a frame; a load is not needed where its displacement is given."""
    if not hasattr(frame, "columns"):
        raise SpindleError(f"a pandas.DataFrame is due, and this is a {type(frame).__name__}: solve() takes arrays")
    of_probes = [f"probe_{name}_um" for name in core.probes] if probes else []
    all_names = [*COLUMNS, *of_probes]
    mapping = dict(columns or {})
    for ours, theirs in mapping.items():
        if ours not in all_names:
            raise SpindleError(f"columns: {ours!r} is none of {', '.join(all_names)}")
        if theirs not in frame.columns:
            raise SpindleError(f"columns: the frame has no {theirs!r}: it has {', '.join(map(str, frame.columns))}")
    own = [name for name in frame.columns if name not in mapping.values()]
    if twice := [name for name in all_names if list(frame.columns).count(mapping.get(name, name)) > 1]:
        raise SpindleError(f"the frame has the column {twice[0]} twice: rename one")
    others = [one for one in _core.due_columns([name for name in own if isinstance(name, str)]) if one[1] not in [*frame.columns, *mapping]]
    if others:
        raise SpindleError("\n".join(f"`{name}`: {what}" for name, _, what in others))
    source = {name: mapping.get(name, name) for name in all_names}
    is_warm = core.reference is not None
    held = {load for load, freedom in zip(COLUMNS[1:6], FREEDOMS) if freedom in given}
    needed = [*(name for name in COLUMNS[1:7] if name not in held), *(COLUMNS[7:9] if is_warm else [])]
    lacking = [name for name in needed if source[name] not in frame.columns]
    if lacking:
        names = ", ".join(map(str, frame.columns))
        raise SpindleError(f"the frame has no {', '.join(lacking)}: it has {names}; rename them, or give columns={{{lacking[0]!r}: ..}}")
    if not is_warm and any(source[name] in frame.columns for name in COLUMNS[7:9]):
        raise SpindleError("t_inner_c and t_outer_c are for spindles with [heat]: add that with reference_c, or drop these columns")
    if of_probes and not any(source[name] in frame.columns for name in of_probes):
        raise SpindleError(f"the frame has no {', '.join(of_probes)}: add one for each [[probe]]")
    if len(frame) == 0:
        raise SpindleError("the frame has no row")
    records = np.full((len(frame), len(COLUMNS) + PROBES), np.nan)
    records[:, 0] = np.arange(len(frame))
    records[:, 1:6] = 0.0
    for i, name in enumerate(all_names):
        if source[name] in frame.columns:
            column = frame[source[name]]
            hint = ": give seconds, such as (df.t - df.t.iloc[0]).dt.total_seconds()" if i == 0 else ': read the file with decimal=","?'
            if column.dtype.kind in "mM":
                raise SpindleError(f"{source[name]} has {column.dtype}, and numbers are due{hint}")
            try:
                records[:, i] = column.to_numpy(dtype=float, na_value=np.nan)
            except (TypeError, ValueError) as error:
                raise SpindleError(f"{source[name]} is no column of numbers: {error}{hint}") from None
    return records

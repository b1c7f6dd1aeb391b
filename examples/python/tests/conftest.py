"""The project's files, and `cargo replay` beside the package."""

import functools
import io
import pathlib
import subprocess

import pandas as pd
import pytest

import spindle_bearing as sb

ROOT = pathlib.Path(__file__).parents[3]
FOLDER = ROOT / "examples" / "spindle_file"
RECORDS = ROOT / "examples" / "cli" / "records"
SPINDLES = sorted([*FOLDER.glob("spindles/*.toml"), *FOLDER.glob("bearings/*.toml")])
LOADS = ["fx_n", "fy_n", "fz_n", "my_nm", "mz_nm"]


@functools.cache
def record(name):
    return pd.read_csv(RECORDS / f"{name}.csv", float_precision="round_trip")


def recording(spindle, name, every):
    """A recording as a frame with the columns that the spindle takes; none if it lacks temperatures."""
    frame = record(name).iloc[::every]
    temperatures = ["t_inner_c", "t_outer_c"]
    if spindle._core.reference is None:
        return frame.drop(columns=temperatures, errors="ignore")
    return frame if set(temperatures) <= set(frame.columns) else None


def cargo_replay(*arguments, stdin=None):
    """Standard output of `cargo replay`."""
    command = ["cargo", "replay", *map(str, arguments)]
    text = None if stdin is None else stdin.to_csv(index=False)
    done = subprocess.run(command, cwd=ROOT, input=text, text=True, stdout=subprocess.PIPE, check=True)
    return done.stdout


def table(text):
    words = {name: str for name in ("status", "limits", "nose", "unit")}
    frame = pd.read_csv(io.StringIO(text), float_precision="round_trip", dtype=words)
    return frame.fillna({"limits": "", "unit": ""})


@pytest.fixture
def pair():
    return sb.Spindle.read(FOLDER / "spindles" / "7014c_back_to_back.toml")

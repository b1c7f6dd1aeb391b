"""Answers have the bits of `cargo replay`, which solves the same blocks."""

import json

import numpy as np
import pytest
from conftest import FOLDER, LOADS, SPINDLES, cargo_replay, recording, table

import spindle_bearing as sb

pytestmark = pytest.mark.filterwarnings("ignore::UserWarning")


def same(found, expected, single=False):
    assert list(found.columns) == list(expected.columns)
    for name in found.columns:
        if found[name].dtype.kind not in "if":
            assert list(found[name]) == list(expected[name]), name
            continue
        # A life is in single precision, and an endless one has no figure there.
        is_life = name.startswith("l10_")
        # Results have copies of the recording, in double precision.
        is_copy = "status" in found.columns and name in [*LOADS, "time_s", "speed_rpm", "t_inner_c", "t_outer_c"]
        kind = np.float32 if is_life or single and not is_copy else np.float64
        one, other = found[name].to_numpy(kind), expected[name].to_numpy(kind)
        if is_life:
            one = np.where(np.isinf(one), np.nan, one)
        assert (np.isnan(one) == np.isnan(other)).all(), name
        numbers = ~np.isnan(one)
        assert one[numbers].tobytes() == other[numbers].tobytes(), name


@pytest.mark.parametrize("precision", ["f32", "f64"])
@pytest.mark.parametrize("path", SPINDLES, ids=lambda path: path.stem)
def test_tables_are_those_of_cargo_replay(path, precision, tmp_path):
    spindle = sb.Spindle.read(path)
    compared = 0
    for name, every in [("milling_cycle", 13), ("milling_nose", 17), ("warm_up", 2)]:
        frame = recording(spindle, name, every)
        if frame is None:
            continue
        compared += 1
        files = {"balls": "--balls", "frequencies": "--frequencies"}
        if spindle._core.sections or "[[row]]" in path.read_text():
            files["rows"] = "--rows"
        if spindle._core.noses:
            files["noses"] = "--nose"
        outputs = [part for of, option in files.items() for part in (option, tmp_path / of)]
        text = cargo_replay(path, "-", "--precision", precision, *outputs, stdin=frame)
        single = precision == "f32"
        same(spindle.replay(frame, precision=precision), table(text), single)
        temperatures = frame[["t_inner_c", "t_outer_c"]] if spindle._core.reference is not None else None
        result = spindle.solve(frame[LOADS], frame.speed_rpm, temperatures, precision=precision)
        same(result.to_frame().drop(columns="time_s"), table(text).drop(columns="time_s"), single)
        for of in files:
            expected = table((tmp_path / of).read_text()).drop(columns="time_s")
            same(result.to_frame(of).drop(columns="time_s"), expected, single)
    assert compared


@pytest.mark.parametrize("options", [
    {"motion": "static"}, {"motion": "centrifugal", "freedoms": 3}, {"attitude": "outer", "given": {"dx": 5e-6}, "cold": True},
    {"tolerance": 1e-3, "peak_pressure": 1500.0, "friction": 0.01},
], ids=str)
def test_options_are_those_of_cargo_replay(pair, options):
    frame = recording(pair, "milling_cycle", 40)
    words = []
    for name, value in options.items():
        value = ",".join(f"{u}={x}" for u, x in value.items()) if isinstance(value, dict) else value
        words += [f"--{name.replace('_', '-')}"] + ([] if value is True else [str(value)])
    text = cargo_replay(FOLDER / "spindles" / "7014c_back_to_back.toml", "-", *words, stdin=frame)
    same(pair.replay(frame, **options), table(text), False)


@pytest.mark.parametrize("path", SPINDLES, ids=lambda path: path.stem)
def test_sums_alarms_and_changes_are_those_of_cargo_replay(path):
    spindle = sb.Spindle.read(path)
    frame = recording(spindle, "milling_cycle", 11)
    frame = recording(spindle, "warm_up", 2) if frame is None else frame
    life = spindle.life(frame)
    assert life.pop("notes") == []
    assert life == json.loads(cargo_replay(path, "-", "--summary=json", stdin=frame))
    if not len(spindle._core.rows) > 1:
        return
    for board in ["f405", "h743"]:
        expected = cargo_replay(path, "-", "--limits", "--board", board, stdin=frame)
        same(spindle.limits(frame, board=board), table(expected))
    found = spindle.sensitivity(fy=300, rpm=9000).reset_index()
    same(found, table(cargo_replay(path, "--sensitivity", "--fy", "300", "--speed", "9000")))


def test_the_measured_preload_is_that_of_cargo_replay(tmp_path):
    path = FOLDER / "spindles" / "probed_pair.toml"
    spindle = sb.Spindle.read(path)
    frame = recording(spindle, "milling_nose", 2)
    frame = frame.assign(probe_axial_um=-frame.fx_n / 50, probe_nose_um=frame.fy_n / 25)
    cargo_replay(path, "-", "--response", tmp_path / "response.csv", "--commission", "1:3", stdin=frame)
    found = spindle.response(frame, commission=(1, 3))
    same(found, table((tmp_path / "response.csv").read_text()))
    assert any("not commissioned" in note for note in found.attrs["notes"])

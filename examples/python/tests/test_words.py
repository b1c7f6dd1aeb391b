"""What is wrong is told with what to do."""

import numpy as np
import pandas as pd
import pytest
from conftest import FOLDER, record

import spindle_bearing as sb

PAIR = FOLDER / "spindles" / "7014c_back_to_back.toml"
WARM = FOLDER / "spindles" / "milling_spindle.toml"
PROBED = FOLDER / "spindles" / "probed_pair.toml"


def solve(*arguments, **named):
    return lambda: sb.Spindle.read(PAIR).solve(*arguments, **named)


def warm(**named):
    return lambda: sb.Spindle.read(WARM).solve(**named)


def replay(change, path=PAIR, **named):
    return lambda: sb.Spindle.read(path).replay(change(record("milling_cycle")[:20]), **named)


def rows(**changes):
    row = {"bearing": "gmn:S6014C", "position_mm": 0.0, "facing": "+x"}
    other = {**row, "position_mm": 27.0, "facing": "-x", **changes}
    return lambda: sb.Spindle({"name": "pair", "preload_n": 240.0, "row": [row, other]})


WRONG = {
    # Arrays.
    "four columns": (solve(np.zeros((3, 4))), r"loads has the shape \(3, 4\), and \(n, 5\) is due"),
    "turned": (solve(np.zeros((5, 3))), r"turn it \(loads.T\)"),
    "a cube": (solve(np.zeros((2, 3, 5))), r"\(2, 3, 5\)"),
    "a number for loads": (solve(3.0), r"the shape \(\), and \(n, 5\) is due"),
    "words for loads": (solve([["a"] * 5]), "loads has 'a', and numbers are due"),
    "ragged": (solve([[1, 2, 3, 4, 5], [1, 2]]), "loads is no array of numbers"),
    "complex": (solve(fy=[1j]), "fy has complex128, and numbers are due"),
    "none among numbers": (solve(fy=[1.0, {}]), "fy is no array of numbers"),
    "loads twice": (solve(np.zeros((3, 5)), fy=1.0), "loads has fy already: give loads, or fx, fy"),
    "lengths": (solve(fy=[1, 2, 3], rpm=[1, 2]), r"lengths differ \(fy 3, rpm 2\): give as many"),
    "a matrix of speeds": (solve(rpm=np.zeros((2, 2))), r"rpm has the shape \(2, 2\), and a number or \(n,\) is due"),
    "dates": (solve(rpm=np.array(["2026-01-01"], dtype="M8[s]")), "rpm has .*, and numbers are due"),
    "temperatures of a cold one": (solve(temperatures=[20, 20]), r"for spindles with \[heat\]: add that"),
    "one temperature": (warm(temperatures=[20.0, 30, 40]), r"the shape \(3,\), and \(n, 2\) is due"),
    "kelvin": (warm(temperatures=[293.0, 293.0]), "record 0: 293 is above 200 deg C; is it in kelvin"),
    # Options.
    "a name that is wrong": (solve(tolerence=1e-3), "there is no option tolerence: they are precision"),
    "a precision": (solve(precision="float32"), 'precision="float32" is none of f32, f64'),
    "a tolerance": (solve(tolerance=2.0), "tolerance 2: it is 0 to 1"),
    "a tolerance in words": (solve(tolerance="small"), "tolerance=small: must be real number, not str"),
    "freedoms": (solve(freedoms=4), "freedoms 4: they are 3 or 5"),
    "given what there is not": (solve(given={"rx": 0.0}), "give dx, dy, dz .m., ty or tz .rad. a number"),
    "given twice": (solve(given={"tz": 0.0}, freedoms=3), "it is held already, by given or freedoms 3"),
    "attitude at rest": (solve(motion="static", attitude="outer"), "attitude makes no difference without"),
    "threads": (solve(threads=0), "threads=0: give a number from 1 on"),
    # Frames.
    "a list": (lambda: sb.Spindle.read(PAIR).replay([1, 2]), "a pandas.DataFrame is due, and this is a list"),
    "a column less": (replay(lambda df: df.drop(columns="fz_n")), "the frame has no fz_n: it has time_s, fx_n"),
    "kilonewtons": (replay(lambda df: df.rename(columns={"fx_n": "fx_kn"})), "`fx_kn`: .*`fx_n` is due, in N: multiply by 1000"),
    "milliseconds": (replay(lambda df: df.rename(columns={"time_s": "time_ms"})), "`time_ms`: .*`time_s` is due, in s: divide by 1000"),
    "decimal commas": (replay(lambda df: df.assign(fx_n="1,5")), r'fx_n is no column of numbers: .*1,5.*decimal=","'),
    "clock times": (replay(lambda df: df.assign(time_s=pd.Timestamp("2026-01-01"))), "time_s has datetime64.*: give seconds"),
    "twice": (replay(lambda df: pd.concat([df, df[["fx_n"]]], axis=1)), "the frame has the column fx_n twice: rename one"),
    "no row": (replay(lambda df: df[:0]), "the frame has no row"),
    "no temperatures": (replay(lambda df: df, path=WARM), "the frame has no t_inner_c, t_outer_c"),
    "temperatures": (replay(lambda df: df.assign(t_inner_c=20)), r"for spindles with \[heat\]"),
    "a mapping to nothing": (replay(lambda df: df, columns={"fx_n": "F"}), "the frame has no 'F': it has"),
    "a mapping of nothing": (replay(lambda df: df, columns={"f": "fx_n"}), "columns: 'f' is none of time_s, fx_n"),
    "a table": (replay(lambda df: df, table="result"), '"result" is none of results, rows'),
    "no probes": (lambda: sb.Spindle.read(PAIR).response(record("milling_cycle")[:9]), r"has no \[\[probe\]\]; add one with name"),
    "no readings": (lambda: sb.Spindle.read(PROBED).response(record("milling_nose")),
                    "the frame has no probe_axial_um, probe_nose_um: add one for each"),
    "a board": (lambda: sb.Spindle.read(PAIR).limits(record("milling_cycle"), board="f4"), 'board="f4" is none of f405, h743'),
    "commissioning": (lambda: sb.Spindle.read(PROBED).limits(record("milling_nose"), commission=(3, 1)), "give seconds FROM:TO"),
    "time that falls": (lambda: sb.Spindle.read(PAIR).limits(record("milling_cycle")[::-1]), "must not fall: cut the recording there"),
    "no state": (lambda: sb.Spindle.read(PAIR).sensitivity(fw=3.0), "there is no fw: give fx"),
    "a hot state": (lambda: sb.Spindle.read(PAIR).sensitivity(t_inner=30.0), r"t_inner is for spindles with \[heat\]"),
    # Files and keys.
    "no file": (lambda: sb.Spindle.read("nowhere.toml"), "nowhere.toml: cannot be read"),
    "no bearing": (lambda: sb.Spindle.read("gmn:S6014"), "did you mean gmn:S6014C"),
    "no keys": (lambda: sb.Spindle("pair.toml"), r"a dict of keys is due, and this is a str: Spindle.read\(path\)"),
    "no TOML": (rows(position_mm=None), "the keys are no TOML"),
    "a wrong key": (rows(postion_mm=1.0), "unknown field `postion_mm`.*did you mean `position_mm`"),
    "a facing": (rows(facing="x"), '"x" is none of "\\+x", "-x"'),
    "a bearing that is not there": (rows(bearing="7014.toml"), "7014.toml: cannot be read"),
}


@pytest.mark.parametrize("wrong", WRONG)
def test_words_say_what_to_do(wrong):
    act, words = WRONG[wrong]
    with pytest.raises(sb.SpindleError, match=words) as told:
        act()
    assert isinstance(told.value, ValueError)


def test_an_error_of_a_file_has_its_place(tmp_path):
    path = tmp_path / "pair.toml"
    path.write_text(PAIR.read_text().replace("preload_n = 294", 'preload_n = "294 N"').replace("../bearings", str(FOLDER / "bearings")))
    with pytest.raises(sb.SpindleError) as told:
        sb.Spindle.read(path)
    line = 1 + path.read_text()[: path.read_text().index('"294 N"')].count("\n")
    assert (told.value.file, told.value.line) == (str(path), line) and told.value.column > 1
    assert str(told.value).startswith(f"{path}: line {line}, column ")

"""Recipes of docs/recordings.md, on files in the layout of other programs: the frame has the numbers that went in, or there is an error."""

import re

import numpy as np
import openpyxl
import pandas as pd
import pytest
import pyuff
import scipy.io
from conftest import ROOT
from nptdms import ChannelObject, RootObject, TdmsWriter

PAGE = (ROOT / "docs" / "recordings.md").read_text(encoding="utf-8")
IMPORTS, *RECIPES = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)
# A file that each recipe opens, and no other one.
FILES = ["slot.txt", "run.lvm", "press.txt", "press_info.txt", "run.tdms", "run.uff", "run.mat", "wrist.csv", "run.xlsx", "tek0001.csv",
         "F0000CH", "scope_1.csv", "NewFile1.csv", "logger.csv", "historian.csv", "plc.csv", "stend.csv", "zhuzhou.csv", "rcd.csv"]

COUNT = 24
TIME = np.arange(COUNT) / 1000
X, Y, Z = (start + np.arange(COUNT) / 8 for start in (100.5, -20.25, 41.0))
MY, MZ = np.arange(COUNT) / 16, 2 - np.arange(COUNT) / 32
RPM = 9000.0 + np.arange(COUNT)


@pytest.fixture
def recipe(tmp_path, monkeypatch, pair):
    """Runs the recipe of a file, with changes that its user would make; without further numbers, an error is due."""
    monkeypatch.chdir(tmp_path)

    def run(file, *changes, error=None, **wanted):
        (code,) = [one for one in RECIPES if f'"{file}' in one]
        for old, new in changes:
            assert old in code
            code = code.replace(old, new)
        names = {}
        if error is not None:
            with pytest.raises(error):
                exec(IMPORTS + code, names)
            return
        exec(IMPORTS + code, names)
        wanted = {"my_nm": 0.0, "mz_nm": 0.0, "time_s": TIME, **wanted}
        assert len(wanted) == 7
        for name, numbers in wanted.items():
            found = names["df"][name].astype(float)
            np.testing.assert_allclose(found, np.broadcast_to(numbers, COUNT), rtol=1e-12, atol=1e-9, err_msg=name)
        assert set(pair.replay(names["df"]).status) <= {"converged", "precision-limit"}

    return run


def text_of(columns, sep="\t", comma=False, trailing=""):
    """Rows of columns that end with a separator or do not, with a decimal comma or a point."""
    rows = "".join(sep.join(f"{x:.10g}" for x in row) + trailing + "\n" for row in zip(*columns))
    return rows.replace(".", ",") if comma else rows


def write(file, text, encoding="cp1252", end="\n"):
    with open(file, "w", encoding=encoding, newline=end) as out:
        out.write(text)


def test_recipes_are_short_and_each_is_run():
    for code in [IMPORTS, *RECIPES]:
        assert 3 <= len([line for line in code.splitlines() if line.strip()]) <= 8, code
    assert [[file for file in FILES if f'"{file}' in code] for code in RECIPES] == [[file] for file in FILES]


def dynoware(unit="N", names="Time\tFx\tFy\tFz\tMz", cells=(X, Y, Z, MZ), trailing="", comma=False):
    units = "\t".join(["s", *[unit] * (names.count("\t") - 1), "N·m"])
    preamble = "DynoWare Data Export\nFile Name:\tslot.dwd\nDate:\t12.03.2024\nTime:\t10:21:33\nSampling rate [Hz]:\t1000\n"
    return f"{preamble}Measuring time [s]:\t1\n\n{names}{trailing}\n{units}{trailing}\n" + text_of([TIME, *cells], comma=comma, trailing=trailing)


def test_dynoware(recipe):
    wanted = {"fx_n": -Z, "fy_n": -X, "fz_n": -Y, "speed_rpm": 8000}
    rows = text_of([TIME, X, Y, Z, MZ])
    only_rows_end_with_tabs = dynoware().replace(rows, text_of([TIME, X, Y, Z, MZ], trailing="\t"))
    single_sensors_besides = dynoware(names="Time\tFx12\tFx34\tFx\tFy\tFz\tMz", cells=(MY, MY, X, Y, Z, MZ))
    for text in (dynoware() + "\n\n", dynoware(trailing="\t"), only_rows_end_with_tabs, single_sensors_besides):
        write("slot.txt", text, end="\r\n")
        recipe("slot.txt", **wanted)
    write("slot.txt", dynoware(names="Zeit\tFx\tFy\tFz\tMz", comma=True))
    recipe("slot.txt", ("Time", "Zeit"), ('sep="\\t"', 'sep="\\t", decimal=","'), **wanted)
    recipe("slot.txt", ("Time", "Zeit"), error=ValueError)


def test_dynoware_in_kilonewtons_is_an_error_until_its_user_says_so(recipe):
    write("slot.txt", dynoware(unit="kN", cells=(X / 1000, Y / 1000, Z / 1000, MZ)))
    recipe("slot.txt", error=KeyError)
    recipe("slot.txt", ("-raw", "-1000 * raw"), ('"N"', '"kN"'), fx_n=-Z, fy_n=-X, fz_n=-Y, speed_rpm=8000)
    no_units = dynoware().replace("s\tN\tN\tN\tN·m\n", "")
    twice = dynoware(names="Time\tFx\tFx\tFy\tFz\tMz", cells=(X, Y, Y, Z, MZ))
    cycles = dynoware() + "Cycle No.:\t2\n" + dynoware().split("\n\n")[1]
    for text, error in ((no_units, KeyError), (twice, ValueError), (cycles, ValueError)):
        write("slot.txt", text)
        recipe("slot.txt", error=error)


def lvm(kind, unit="kN", comma=False, sep="\t"):
    """Channels Fx, Fy, Fz with one column of time, with one each, or without."""
    own = {"One": [[], []], "No": [[], []], "Multi": [[TIME], ["X_Value"]]}[kind]
    gap = [""] * len(own[0])
    spread = lambda tag, cells: sep.join([tag, cells[0], *gap, cells[1], *gap, cells[2], "", ""])
    head = ["LabVIEW Measurement", "Writer_Version\t2", f"X_Columns\t{kind}", "***End_of_Header***", "", spread("Channels", ["3", "", ""])]
    head += [spread("Samples", [str(COUNT)] * 3), spread("Date", ["2025/11/14"] * 3), spread("Y_Unit_Label", ["N", "N", unit])]
    head += [spread("X0", ["0.0E+0"] * 3), spread("Delta_X", ["0,001" if comma else "0.001"] * 3), "***End_of_Header***" + 4 * sep]
    names = sep.join(["X_Value", "Fx", *own[1], "Fy", *own[1], "Fz", "Comment"])
    cells = [X, *own[0], Y, *own[0], Z / 1000 if unit == "kN" else Z]
    rows = text_of(cells if kind == "No" else [TIME, *cells], sep, comma)
    rows = sep + rows.replace("\n", "\n" + sep)[: -len(sep)] if kind == "No" else rows.replace("\n", sep + "begins\n", 1)
    return "\n".join([*head, names, rows])


def test_lvm(recipe):
    wanted = {"fx_n": Z, "fy_n": X, "fz_n": Y, "speed_rpm": 12000}
    for kind in ("One", "Multi"):
        for sep in ("\t", ","):
            write("run.lvm", lvm(kind, sep=sep), end="\r\n")
            recipe("run.lvm", ('"\\t"', repr(sep)), **wanted)
        write("run.lvm", lvm(kind, comma=True))
        recipe("run.lvm", ('decimal="."', 'decimal=","'), **wanted)
        recipe("run.lvm", error=ValueError)
    write("run.lvm", lvm("No", comma=True))
    recipe("run.lvm", ('decimal="."', 'decimal=","'), error=AssertionError)
    (line,) = re.findall(r"With `X_Columns No`, `(.*?)` gives", PAGE)
    recipe("run.lvm", ('decimal="."', 'decimal=","'), ("assert raw", f"{line}\nassert raw"), **wanted)
    write("run.lvm", lvm("One", unit="N"))
    recipe("run.lvm", error=KeyError)
    recipe("run.lvm", ("1000 * ", ""), ("kN", "N"), **wanted)
    write("run.lvm", lvm("One") + lvm("One").split("\n\n")[1])
    recipe("run.lvm", error=ValueError)
    late = [TIME, X, TIME, Y, TIME + 0.0005, Z]
    write("run.lvm", lvm("Multi").split("Comment")[0] + "Comment\n" + text_of(late))
    recipe("run.lvm", error=AssertionError)


def test_catman(recipe):
    wanted = {"fx_n": X, "fy_n": Y, "fz_n": Z, "my_nm": MY, "mz_nm": MZ, "speed_rpm": RPM}
    names = ["Zeit  1 - Standardmessrate", "Fx", "Fy", "Fz", "My", "Mz", "Drehzahl", "T_Lager"]
    units = ["s", "kN", "kN", "kN", "Nm", "Nm", "1/min", "°C"]
    cells = [TIME, X / 1000, Y / 1000, Z / 1000, MY, MZ, RPM, 20 + MY]
    above = "catman-Datei\tDauerlauf\nKommentar:\tvoll geölt\n" + "".join(f"{n}\t{u}\t50\n" for n, u in zip(names, units))
    info = above + "\t".join(names) + "\n" + "\t".join(units)
    for file, head in (("press.txt", "\t".join(f"{n} [{u}]" for n, u in zip(names, units))), ("press_info.txt", info)):
        for trailing in ("", "\t"):
            write(file, f"{head}{trailing}\n" + text_of(cells, comma=True, trailing=trailing), end="\r\n")
            recipe(file, **wanted)
        write(file, head + "\n" + text_of(cells))
        recipe(file, (', decimal=","', ""), **wanted)
        write(file, head.replace("kN", "N") + "\n" + text_of(cells, comma=True))
        recipe(file, error=KeyError)
        write(file, head + "\n" + text_of([part[:-4] for part in cells], comma=True) + "\t\t\t0,5\t\t\t\t\n")
        recipe(file, error=AssertionError)


def tdms(unit="kN", steps=(0.001, 0.001, 0.001), kind=float, time=False):
    parts = {"Fx": (X, "N"), "Fy": (Y, "N"), "Fz": (Z / 1000 if unit == "kN" else Z, unit), "Time": (TIME, "s")}
    with TdmsWriter("run.tdms") as writer:
        for group, scale in (("Idle", 0.0), ("Cutting", 1.0)):
            for (name, (cells, own)), step in zip(parts.items(), [*steps, 0.001][: 3 + time]):
                rate = {} if time else {"wf_increment": step, "wf_start_offset": 0.0}
                channel = ChannelObject(group, name, (scale * cells).astype(kind), {"unit_string": own, **rate})
                writer.write_segment([RootObject({"author": "daq"}), channel])


def test_tdms(recipe):
    wanted = {"fx_n": Z, "fy_n": X, "fz_n": Y, "speed_rpm": 9000}
    tdms()
    recipe("run.tdms", **wanted)
    recipe("run.tdms", ('["Cutting"]', '["Turning"]'), error=KeyError)
    tdms(steps=(0.001, 0.001, 0.002))
    recipe("run.tdms", error=ValueError)
    tdms(unit="N")
    recipe("run.tdms", error=KeyError)
    recipe("run.tdms", ('1000 * raw["Fz", "kN"]', 'raw["Fz", "N"]'), **wanted)
    tdms(unit="N", kind=np.int16)
    whole = {"fx_n": 1000 * np.trunc(Z), "fy_n": np.trunc(X), "fz_n": np.trunc(Y), "speed_rpm": 9000}
    recipe("run.tdms", ('"kN"', '"N"'), **whole)
    tdms(time=True)
    recipe("run.tdms", error=KeyError)
    recipe("run.tdms", ("rates =", "# rates ="), ("((step", "# ((step"), ('step * np.arange(len(raw["Fx", "N"]))', 'raw["Time", "s"]'), **wanted)


def uff(directions=(1, 2, 3), unit="N", kind=1, late=0.0, binary=0, seconds="s"):
    sets = [pyuff.prepare_151(model_name="plate", description="", db_app="", program="")]
    for way, cells in zip(directions, [X, Y, Z, Z]):
        sets.append(pyuff.prepare_58(
            binary=binary, func_type=kind, rsp_node=12, rsp_dir=way, ref_node=12, ref_dir=way, abscissa_spacing=1, abscissa_axis_units_lab=seconds,
            ordinate_axis_units_lab=unit, orddenom_spec_data_type=0, x=TIME + late * (way == 3), data=cells))
    pyuff.UFF("run.uff").write_sets(sets, mode="overwrite")


def test_uff58(recipe):
    for binary in (0, 1):
        uff(binary=binary)
        recipe("run.uff", fx_n=-Z, fy_n=Y, fz_n=X, speed_rpm=6000)
    for wrong in ({"directions": (1, 2, -3)}, {"unit": "kN"}, {"kind": 2}, {"seconds": "ms"}, {"directions": (1, 2, 3, 3)}, {"late": 0.5}):
        uff(**wrong)
        recipe("run.uff", error=(AssertionError, KeyError))


def test_mat(recipe):
    wanted = {"fx_n": Z, "fy_n": X, "fz_n": Y, "speed_rpm": RPM}
    forces = np.stack([X, Y, Z], 1)
    run = {"rate_hz": 1000, "force": {"data": forces / 1000, "unit": "kN"}, "speed": {"data": RPM, "unit": "rpm"}}
    scipy.io.savemat("run.mat", {"run": run, "note": "slot"})
    recipe("run.mat", **wanted)
    scipy.io.savemat("run.mat", {"run": {**run, "force": {"data": forces.astype(np.int16), "unit": "N"}}}, do_compression=True)
    recipe("run.mat", error=AssertionError)
    recipe("run.mat", ("kN", "N"), fx_n=1000 * np.trunc(Z), fy_n=1000 * np.trunc(X), fz_n=1000 * np.trunc(Y), speed_rpm=RPM)


def test_ati(recipe):
    wanted = {"fx_n": Z, "fy_n": X, "fz_n": Y, "my_nm": MY, "mz_nm": MZ, "speed_rpm": 3000, "time_s": np.arange(COUNT) / 7000}
    names = "Status (hex), RDT Sequence, F/T Sequence, Fx, Fy, Fz, Tx, Ty, Tz, Time\n"
    units = "Force Units: N\nCounts per Unit Force: 1000000.0\nTorque Units: Nm\nCounts per Unit Torque: 1000000.0\n"
    head = 'Start Time: 10/15/24 3:04 PM\nRDT Sample Rate: 7000\n"PLEASE NOTE: the rate is read when the program starts."\n'
    counts = [np.round(1e6 * part).astype(int) for part in (X, Y, Z, MY, MZ, MZ)]
    rows = "".join(f"0, {4711 + i}, {3 * i}, {', '.join(map(str, row))}, 3:04 PM\n" for i, row in enumerate(zip(*counts)))
    write("wrist.csv", head + units + names + rows, end="\r\n")
    recipe("wrist.csv", **wanted)
    write("wrist.csv", head + units.replace("\nCounts", ", Counts").replace("00.0", "00") + names + rows.replace(", ", ","))
    recipe("wrist.csv", **wanted)
    for old, new in (("Units: N\n", "Units: lbf\n"), ("Force: 1000000.0", "Force: 100.0"), ("Nm", "Nmm"), ("7000", "1000"),
                     ("\n0, 4713", "\n80010000, 4713"), (f"{counts[2][5]}", f"{Z[5]}")):
        assert old in head + units + names + rows
        write("wrist.csv", (head + units + names + rows).replace(old, new))
        recipe("wrist.csv", error=AssertionError)


def test_excel(recipe):
    def sheet(unit="kN", hole=None):
        book = openpyxl.Workbook()
        page = book.create_sheet("Data")
        for row in (["Slot 4", None, "12.03.2024"], [], ["Time", "Fx", "Fy", "Fz", "n"], ["ms", "N", "N", unit, "rpm"]):
            page.append(row)
        for i, row in enumerate(zip(1000 * TIME, X, Y, Z / 1000, RPM)):
            page.append([None if (i, j) == hole else f"{cell}" if j == 1 else float(cell) for j, cell in enumerate(row)])
        return book

    sheet().save("run.xlsx")
    recipe("run.xlsx", fx_n=Z, fy_n=X, fz_n=Y, speed_rpm=RPM)
    for wrong, error in (({"unit": "N"}, KeyError), ({"hole": (3, 2)}, AssertionError), ({"hole": (0, 0)}, AssertionError)):
        sheet(**wrong).save("run.xlsx")
        recipe("run.xlsx", error=error)


VOLTS = [TIME - 0.002, X / 500, Y / 500]
SCOPE = {"time_s": VOLTS[0], "fx_n": 0, "fy_n": X, "fz_n": Y, "speed_rpm": 10000}


def test_tektronix(recipe):
    short = "Model,TBS1052C\n\nHorizontal Units,S\nSample Interval,0.001\nVertical Units,V,V\nProbe Attenuation,1,1\nLabel,\n"
    long = ("Model,MDO4014B-3\nFirmware Version,3.22\n\nWaveform Type,ANALOG,,\nPoint Format,Y,,\nHorizontal Units,s,,\nGating,0.0% to 100.0%,,\n"
            "Probe Attenuation,1,1\nVertical Units,V,V\nVertical Scale,2,2\n,\n,,\n,,\nLabel,Fx,Fy\n")
    for head in (short, long):
        write("tek0001.csv", head + "TIME,CH1,CH2\n" + text_of(VOLTS, ","), end="\r\n")
        recipe("tek0001.csv", **SCOPE)
        for old, new in (("Units,V,V", "Units,V,A"), ("Attenuation,1,1", "Attenuation,10,1")):
            write("tek0001.csv", head.replace(old, new) + "TIME,CH1,CH2\n" + text_of(VOLTS, ","))
            recipe("tek0001.csv", error=AssertionError)


def test_older_tektronix(recipe):
    tags = ["Record Length,24", "Sample Interval,1e-3", ",", ",", "Source,CH{}", "Vertical Units,{}", "Horizontal Units,s", "Probe Atten,1.0e+00"]

    def channel(i, unit="V", late=0.0):
        left = [tag.format(i if "CH" in tag else unit) for tag in tags] + [","] * (COUNT - len(tags))
        rows = text_of([VOLTS[0] + late, VOLTS[i]], ",", trailing=",").splitlines()
        write(f"F0000CH{i}.CSV", "".join(f"{a},,{b}\n" for a, b in zip(left, rows)), end="\r\n")

    channel(1), channel(2)
    recipe("F0000CH", **SCOPE)
    for wrong in ({"unit": "A"}, {"late": 0.1}):
        channel(2, **wrong)
        recipe("F0000CH", error=AssertionError)


def test_keysight_and_rigol(recipe):
    write("scope_1.csv", "x-axis,1,2\nsecond,Volt,Volt\n" + text_of(VOLTS, ","), end="\r\n")
    recipe("scope_1.csv", **SCOPE)
    write("scope_1.csv", "x-axis,1,2\nsecond,Volt,Ampere\n" + text_of(VOLTS, ","))
    recipe("scope_1.csv", error=KeyError)
    rows = text_of([np.arange(COUNT), *VOLTS[1:]], ",", trailing=",")
    for unit, wanted in (("Volt", SCOPE), ("Unknown", {"error": AssertionError})):
        write("NewFile1.csv", f"X,CH1,CH2,Start,Increment,\nSequence,Volt,{unit},-2.000000e-03,1.000000e-03\n" + rows, end="\r\n")
        recipe("NewFile1.csv", **wanted)


ROWS = [";".join(f"{cell:.10g}" for cell in row) for row in zip(X, Y, Z, RPM)]
LOADS = {"fx_n": X, "fy_n": Y, "fz_n": Z, "speed_rpm": RPM}


def stamps(file, start, step, form, head="Time;Fx [N];Fy [N];Fz [N];n [rpm]\n", sep=";"):
    times = pd.Timestamp(start) + pd.to_timedelta(step * np.arange(COUNT), unit="s")
    write(file, (head + "".join(f"{form(time)};{row}\n" for time, row in zip(times, ROWS))).replace(";", sep))


def test_clock_times(recipe):
    for mark in ".,":
        stamps("logger.csv", "2025-11-14 23:59:59.5", 0.1, lambda time: f"{time:%H:%M:%S}{mark}{time.microsecond // 1000:03}")
        recipe("logger.csv", time_s=TIME * 100, **LOADS)
    stamps("logger.csv", "2025-10-26 02:59:59", 0.1, lambda time: f"{time - pd.Timedelta(hours=int(time.hour == 3)):%H:%M:%S.%f}")
    recipe("logger.csv", error=AssertionError)
    head = "Timestamp;Fx_N;Fy_N;Fz_N;n_rpm\n"
    forms = [str, lambda time: time.isoformat() + "+01:00", lambda time: time.tz_localize("UTC").tz_convert("Europe/Berlin").isoformat()]
    for form in forms:
        stamps("historian.csv", "2025-10-26 00:59:59.5", 0.1, form, head, ",")
        recipe("historian.csv", time_s=TIME * 100, **LOADS)
    stamps("historian.csv", "2025-03-11", 0.1, lambda time: f"{time:%d.%m.%Y %H:%M:%S.%f}", head, ",")
    recipe("historian.csv", error=ValueError)
    recipe("historian.csv", ('"ISO8601", utc=True', '"%d.%m.%Y %H:%M:%S.%f"'), time_s=TIME * 100, **LOADS)


def test_whole_seconds(recipe):
    form = lambda time: f"{time:%d.%m.%Y %H:%M:%S}"
    for start in (0.0, 0.2, 0.8):
        stamps("plc.csv", pd.Timestamp("2025-11-14 23:59:58") + pd.Timedelta(start, "s"), 0.2, form)
        recipe("plc.csv", time_s=start + 200 * TIME, **LOADS)
    text = open("plc.csv").read().splitlines(keepends=True)
    write("plc.csv", "".join(text[:9] + text[11:]))
    recipe("plc.csv", error=AssertionError)


def test_names_of_other_alphabets(recipe):
    text = "Время, с;Осевая сила, кН;Сила Y, Н;Сила Z, Н;Момент Y, Н·м;Момент Z, Н·м;Обороты, об/мин\n"
    text += text_of([TIME, X / 1000, Y, Z, MY, MZ, RPM], ";", comma=True)
    write("stend.csv", text, "cp1251", "\r\n")
    recipe("stend.csv", **LOADS | {"my_nm": MY, "mz_nm": MZ})
    recipe("stend.csv", ("cp1251", "cp1252"), error=KeyError)
    write("stend.csv", text.replace("кН", "Н"), "cp1251")
    recipe("stend.csv", error=KeyError)
    names = "时间（ms）,轴向力（N）,径向力Y（N）,径向力Z（N）,主轴转速（r/min）\n"
    write("zhuzhou.csv", names + "0,5,100,5,41,25,20,5,9000\n" * COUNT, "gb18030")
    recipe("zhuzhou.csv", error=pd.errors.ParserWarning)
    write("zhuzhou.csv", names + text_of([1000 * TIME, X, Y, Z, RPM], ","), "gb18030")
    recipe("zhuzhou.csv", **LOADS)
    recipe("zhuzhou.csv", ("gb18030", "cp1252"), error=(KeyError, UnicodeDecodeError))


def test_a_rotating_frame_is_turned_into_the_standing_one(recipe):
    for degrees, wanted in ((36.0, {"fx_n": X, "fy_n": Y, "fz_n": Z, "speed_rpm": 6000}), (60.0, {"error": AssertionError})):
        angle = np.deg2rad(degrees * np.arange(COUNT) - 12.5)
        cells = [TIME, np.cos(angle) * Y + np.sin(angle) * Z, np.cos(angle) * Z - np.sin(angle) * Y, X, MZ, degrees * np.arange(COUNT) % 360]
        rows = "".join(",".join(f"{cell:.17g}" for cell in row) + "\n" for row in zip(*cells))
        write("rcd.csv", "t [s],Fx [N],Fy [N],Fz [N],Mz [Nm],angle [deg]\n" + rows)
        recipe("rcd.csv", **wanted)

"""`many_recordings.py`: its table is that of one process, on any cluster."""

import csv
import os
import pathlib
import runpy
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
from conftest import FOLDER, record
from distributed import LocalCluster

import spindle_bearing as sb

SCRIPT = pathlib.Path(__file__).parents[1] / "many_recordings.py"
PAIR = FOLDER / "spindles" / "7014c_back_to_back.toml"


@pytest.fixture(scope="module")
def recordings(tmp_path_factory):
    """Recordings, some of which give no figures."""
    folder, frame = tmp_path_factory.mktemp("recordings"), record("milling_cycle")[8000:13000]
    for i in range(24):
        frame.assign(fy_n=(1 + 0.1 * i) * frame.fy_n).to_csv(folder / f"{i:02}.csv", index=False)
    frame.rename(columns={"fx_n": "fx_kn"}).to_csv(folder / "07.csv", index=False)
    frame.assign(fx_n=np.nan).to_csv(folder / "10.csv", index=False)
    frame[::-1].to_csv(folder / "14.csv", index=False)
    (folder / "19.csv").write_text("")
    return [*map(str, sorted(folder.glob("*.csv"))), str(folder / "none.csv"), str(folder / "03.csv")]


@pytest.fixture(scope="module")
def expected(recordings):
    """The table of this process."""
    script, spindle = runpy.run_path(str(SCRIPT)), sb.Spindle.read(PAIR)
    lines = [script["COLUMNS"], *(script["figures"](recording, spindle) for recording in recordings)]
    return [["" if field is None else str(field) for field in line] for line in lines]


def table(path):
    with open(path, newline="") as file:
        return list(csv.reader(file))


def script(*arguments):
    return subprocess.Popen([sys.executable, SCRIPT, PAIR, *map(str, arguments)], stderr=subprocess.PIPE, text=True)


def test_what_gives_no_figures_has_its_words(expected):
    words = {pathlib.Path(line[0]).stem: line[4] for line in expected[1:] if not line[1]}
    assert sorted(words) == ["07", "10", "14", "19", "none"]
    assert "`fx_n` is due, in N: multiply by 1000" in words["07"] and "must not fall" in words["14"]
    assert "EmptyDataError" in words["19"] and "No such file" in words["none"]
    assert len(expected) == 27 and float(expected[24][2]) > float(expected[1][2]) > 1000 and "overload" in expected[24][3]


def test_a_worker_that_is_killed_takes_no_line_with_it(recordings, expected, tmp_path):
    out = tmp_path / "table.csv"
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
        running = script(*recordings, "--scheduler", cluster.scheduler_address, "--out", out)
        while not out.exists() or len(table(out)) < 5:
            assert running.poll() is None
            time.sleep(0.01)
        victim = cluster.workers[0].pid
        os.kill(victim, signal.SIGKILL)
        assert len(table(out)) < 20
        _, shown = running.communicate(timeout=120)
        assert cluster.workers[0].pid != victim
    assert running.returncode == 0 and "26/26" in shown
    assert table(out) == expected


def test_a_folder_has_a_cluster_of_its_own(recordings, expected, tmp_path):
    out = tmp_path / "table.csv"
    running = script(pathlib.Path(recordings[0]).parent, "--out", out)
    _, shown = running.communicate(timeout=120)
    assert running.returncode == 0, shown
    assert table(out) == expected[:25]

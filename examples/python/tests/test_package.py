"""What the package adds to the library: arrays, pickles, forks, threads, Ctrl-C, panics."""

import multiprocessing
import os
import pathlib
import pickle
import shutil
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest
from conftest import FOLDER, LOADS, record

import spindle_bearing as sb


def forces(count):
    return {"fy": np.linspace(0, 500, count), "rpm": 12000}


def stiffness(spindle):
    return spindle.solve(**forces(700), threads=2).stiffness


def test_arrays_are_broadcast(pair):
    named = pair.solve(fx=[100.0], fy=[0, 250, 500], rpm=12000)
    plain = pair.solve([[100, 0, 0, 0, 0], [100, 250, 0, 0, 0], [100, 500, 0, 0, 0]], [12000] * 3)
    assert named.stiffness.tobytes() == plain.stiffness.tobytes()
    assert named.loads.tolist() == plain.loads.tolist() and named.rpm.tolist() == [12000] * 3
    assert pair.solve([100, 0, 0, 0, 0]).displacement.shape == (1, 5)
    assert pair.solve(rpm=[0, 10000]).stiffness.shape == (2, 5, 5)
    assert pair.solve(np.empty((0, 5))).displacement.shape == (0, 5)


def test_figures_have_their_shapes_and_fit_each_other(pair):
    result = pair.solve(fx=50.0, fy=np.linspace(0, 400, 9), rpm=15000)
    assert set(result.status) <= {"converged", "precision-limit"} and not any(result.error)
    for i, row in enumerate(result.rows):
        assert row.contact_force.shape == row.pressure.shape == row.contact_angle.shape == (9, 20, 2)
        assert row.force.shape == row.displacement.shape == (9, 5) and row.stiffness.shape == (9, 5, 5)
        assert (row.preload > 0).all() and (row.life > result.life).all()
        assert (row.contact_force == np.stack([result.balls[i][name] for name in ("q_i_n", "q_o_n")], -1)).all()
        assert row.frequencies["cage"][0] == pytest.approx(0.42 * 250, rel=0.1)
    assert np.allclose(result.rows[0].force[:, 1] + result.rows[1].force[:, 1], result.loads[:, 1])
    # Without displacement of the point that is looked at, both are inverse to each other.
    assert np.allclose(result.compliance(0.0) @ result.stiffness, np.eye(5), atol=1e-9)
    lever = result.at(-0.1) - result.displacement
    assert np.allclose(lever[:, 1], -0.1 * result.displacement[:, 4], rtol=1e-3)
    held = pair.solve(fy=200.0, given={"tz": 0.0})
    assert held.displacement[0, 4] == 0.0 and abs(held.reaction[0, 4]) > 0.1 and result.reaction is None


def test_loads_without_an_answer_say_why(pair):
    result = pair.solve(fy=[100.0, np.nan, 1e12, 100.0], rpm=9000)
    assert [bool(words) for words in result.error] == [False, True, True, False]
    assert np.isnan(result.displacement).any(axis=1).tolist() == [False, True, True, False]
    assert np.isnan(result.rows[0].pressure[1:3]).all() and result.status[1] == "not-finite"
    assert result.to_frame().status.tolist() == result.status.tolist()


def test_a_dict_is_the_file_of_the_same_keys(pair):
    design = {"bearing": str(FOLDER / "bearings" / "7014c.toml")}
    rows = [{**design, "position_mm": 0.0, "facing": "+x"}, {**design, "position_mm": 27.0, "facing": "-x"}]
    keys = {"name": "7014C back to back", "arrangement": "back-to-back", "preload_n": 294.0, "row": rows}
    assert stiffness(sb.Spindle(keys)).tobytes() == stiffness(pair).tobytes()
    alone = sb.Spindle({"name": "B", "balls": 16, "ball_diameter_mm": 6.35, "pitch_diameter_mm": 36.0, "inner_groove_factor": 0.515,
                        "outer_groove_factor": 0.525, "contact_angle_deg": 15.0})
    assert not alone.solve(fx=100.0).error[0]


def test_threads_make_no_difference(pair):
    one, three = (pair.solve(**forces(3001), threads=threads) for threads in (1, 3))
    assert one.to_frame("balls").equals(three.to_frame("balls"))


def test_a_pickle_has_the_bearings_files_inside(tmp_path):
    for path in FOLDER.glob("*/7014c*.toml"):
        (tmp_path / path.parent.name).mkdir(exist_ok=True)
        shutil.copy(path, tmp_path / path.parent.name)
    spindle = sb.Spindle.read(tmp_path / "spindles" / "7014c_back_to_back.toml")
    carried = pickle.dumps(spindle)
    shutil.rmtree(tmp_path / "bearings")
    shutil.rmtree(tmp_path / "spindles")
    assert stiffness(pickle.loads(carried)).tobytes() == stiffness(spindle).tobytes()
    named = sb.Spindle.read("gmn:S6014C")
    assert pickle.loads(pickle.dumps(named)).name == named.name


@pytest.mark.filterwarnings("ignore::DeprecationWarning")
@pytest.mark.parametrize("method", ["fork", "spawn"])
def test_other_processes_have_the_same_answers(pair, method):
    here = stiffness(pair)
    with multiprocessing.get_context(method).Pool(2) as pool:
        for there in pool.map(stiffness, [pair] * 4):
            assert there.tobytes() == here.tobytes()


def test_other_threads_run_meanwhile(pair):
    ticks, done = 0, threading.Event()
    solving = threading.Thread(target=lambda: (pair.solve(**forces(20000), threads=1), done.set()))
    solving.start()
    while not done.wait(0.001):
        ticks += 1
    solving.join()
    assert ticks > 50


@pytest.mark.parametrize("work", ["solve", "life", "limits"])
def test_ctrl_c_stops(work):
    path = FOLDER / "spindles" / "7014c_back_to_back.toml"
    # A shell that runs the tests in the background has them ignore Ctrl-C.
    code = f"""
import numpy as np, pandas as pd, signal, spindle_bearing as sb
signal.signal(signal.SIGINT, signal.default_int_handler)
spindle = sb.Spindle.read({str(path)!r})
frame = pd.DataFrame(dict.fromkeys({LOADS}, 0.0), index=range(3_000_000)).assign(speed_rpm=9000.0, time_s=np.arange(3_000_000) / 1000)
frame.fx_n = 400 * np.sin(np.arange(3_000_000))
print("begins", flush=True)
spindle.solve(frame[{LOADS}][:1_000_000], 9000, threads=1) if {work!r} == "solve" else spindle.{work}(frame)
"""
    process = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert process.stdout.readline() == "begins\n"
    time.sleep(1.5)
    assert process.poll() is None
    process.send_signal(signal.SIGINT)
    began = time.monotonic()
    _, told = process.communicate(timeout=60)
    assert "KeyboardInterrupt" in told and process.returncode != 0
    assert time.monotonic() - began < 10


def test_progress_is_shown(pair, capsys, monkeypatch):
    pair.solve(**forces(2000), progress=True)
    assert "2000/2000" in capsys.readouterr().err
    monkeypatch.setitem(sys.modules, "tqdm.auto", None)
    pair.solve(**forces(2000), progress=True)
    assert "2000 of 2000 loads are solved" in capsys.readouterr().err


def test_a_panic_becomes_an_exception(pair):
    with pytest.raises(RuntimeError, match="a fault of spindle_bearing, please report it: as told"):
        sb._core.panic()
    assert not pair.solve(fy=100.0).error[0]


def test_doubts_are_warnings(tmp_path):
    path = FOLDER / "spindles" / "7014c_back_to_back.toml"
    text = path.read_text().replace("294", "0.294").replace("../bearings", str(FOLDER / "bearings"))
    (tmp_path / "doubtful.toml").write_text(text)
    with pytest.warns(UserWarning, match="is it in N"):
        assert sb.Spindle.read(tmp_path / "doubtful.toml").doubts


def test_frames_have_names_of_their_own(pair):
    frame = record("milling_cycle")[:600]
    other = frame.rename(columns={"fx_n": "Fz [N]", "speed_rpm": "n"})
    mapped = pair.replay(other, columns={"fx_n": "Fz [N]", "speed_rpm": "n"})
    assert mapped.equals(pair.replay(frame))


def test_plots_are_drawn(pair, tmp_path):
    import matplotlib

    matplotlib.use("Agg")
    spindle = sb.Spindle.read(FOLDER / "spindles" / "elastic_spindle.toml")
    spindle.plot().savefig(tmp_path / "spindle.png")
    result = pair.solve(**forces(50))
    result.plot(result.loads[:, 1]).savefig(tmp_path / "result.png")
    assert all(os.path.getsize(tmp_path / name) > 5000 for name in ("spindle.png", "result.png"))


def test_what_is_not_installed_is_named(pair, monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib.pyplot", None)
    with pytest.raises(ImportError, match="pip install matplotlib"):
        pair.plot()


def test_the_page_of_the_package_runs():
    page = pathlib.Path(__file__).parents[1].joinpath("README.md").read_text()
    blocks = page.split("```python\n")[1:]
    code = "\n".join(block.split("```")[0] for block in blocks)
    exec(compile(code, "README.md", "exec"), {})

#!/usr/bin/env python3
"""Life, worst pressure and alarms of many recordings, one line of CSV each, by the workers of dask.distributed.

    pip install './examples/python[engine]'
    python examples/python/many_recordings.py spindle.toml recordings/ --out table.csv
    python examples/python/many_recordings.py spindle.toml https://server/a.csv b.csv --scheduler tcp://server:8786

A folder stands for all files `*.csv` below it. Lines have the order in which the recordings are given, and are written as soon as those
before them are. A recording without figures has its words in the last column, and remarks on its times and ticks stand there, too.
Workers of a scheduler need the package, and read paths and URLs themselves.
"""

import argparse
import csv
import pathlib
import sys

import pandas as pd
from distributed import Client, as_completed
from tqdm import tqdm

import spindle_bearing as sb

COLUMNS = ["recording", "l10_h", "worst_pressure_mpa", "alarms", "words"]


def figures(recording, spindle):
    """A line of the table."""
    try:
        df = pd.read_csv(recording)  # another program's file: its recipe goes here
        life = spindle.life(df, threads=1)
        alarms = spindle.limits(df)
        raised = dict.fromkeys(alarms.alarm[alarms.event == "raised"])
        pressures = [row["worst_pressure_pa"] for row in life["rows"] if row["worst_pressure_pa"] is not None]
        notes = [*life["notes"], *alarms.attrs["notes"]]
        if life["without_answer"]:
            notes.append(f"{life['without_answer']} of {life['records']} records without an answer")
        return [recording, life["l10_h"], 1e-6 * max(pressures) if pressures else None, " ".join(raised), "; ".join(notes)]
    except Exception as error:
        return without(recording, error)


def without(recording, error):
    words = " ".join(str(error).split())
    return [recording, None, None, None, f"{type(error).__name__}: {words}"]


def listed(paths):
    for path in paths:
        if pathlib.Path(path).is_dir():
            yield from map(str, sorted(pathlib.Path(path).rglob("*.csv")))
        else:
            yield path


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("spindle", help="file of a spindle, or a bearing of the catalogue")
    parser.add_argument("recordings", nargs="+", help="folders, files, URLs")
    parser.add_argument("--scheduler", help="address of a scheduler; a cluster on this machine without it")
    parser.add_argument("--out", help="file of the table; standard output without it")
    arguments = parser.parse_args()
    recordings = list(listed(arguments.recordings))
    if not recordings:
        parser.error("no *.csv in these folders")
    spindle = sb.Spindle.read(arguments.spindle)
    # A process solves on one core: as many of them as there are cores.
    cluster = {"address": arguments.scheduler} if arguments.scheduler else {"threads_per_worker": 1, "dashboard_address": None}
    out = open(arguments.out, "w", encoding="utf-8") if arguments.out else sys.stdout
    table = csv.writer(out, lineterminator="\n")
    table.writerow(COLUMNS)
    with out, Client(**cluster) as client:
        # The spindle goes with each call: what is scattered is lost with its worker. A recording that is named twice is read twice.
        futures = client.map(figures, recordings, spindle=spindle, pure=False)
        numbers, lines, written = {future: i for i, future in enumerate(futures)}, {}, 0
        for future in tqdm(as_completed(futures), total=len(futures), unit="recordings"):
            number = numbers[future]
            # A recording that ends its workers ends no run.
            failed = future.exception()
            lines[number] = without(recordings[number], failed) if failed else future.result()
            while written in lines:
                table.writerow(lines.pop(written))
                written += 1
            out.flush()


if __name__ == "__main__":
    main()

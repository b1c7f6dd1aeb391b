#!/usr/bin/env python3
"""A table of stiffness from `cargo replay` as a bearing of ROSS, the rotor dynamics package.

Make a table over speed, at the load that the rotor puts on the bearing:

    cargo replay examples/spindle_file/bearings/7014c.toml --table speed=1000:18000:500 fx=300 fy=50 >k.csv

Then, in a program that uses ROSS:

    from ross_bearing import bearing_element
    bearing = bearing_element("k.csv", node=3)

The table's frame has x along the shaft, which turns from y towards z. ROSS has z along the shaft, which turns
from x towards y. So ROSS's x is the table's y, its y is the table's z, and its z is the table's x: both frames are
right-handed, and the shaft turns the same way. Stiffness is N/m in both; ROSS's frequency is the speed of the shaft
in rad/s; outside of the table's speeds ROSS extrapolates.

A ball bearing gives no damping here: `cxx` is what you know of it, N s/m. Tilting stiffness is left out, which
`BearingElement` has no place for. `python3 ross_bearing.py --check` tests the recipe, without ROSS.
"""

import csv
import math
import sys

# ROSS's coefficient, and the table's column: its force, then its displacement.
COEFFICIENTS = {"kxx": "k_y_y", "kxy": "k_y_z", "kyx": "k_z_y", "kyy": "k_z_z", "kzz": "k_x_x"}
LOADS = ("fx_n", "fy_n", "fz_n", "my_nm", "mz_nm")


def read_table(path, load=None):
    """Coefficients by ROSS's names, and `frequency` in rad/s, as lists over rising speed.

    `load` picks one load of a table that has several, such as {"fy_n": 250}.
    """
    load = load or {}
    unknown = sorted(set(load) - set(LOADS))
    if unknown:
        raise ValueError(f"{unknown[0]} is no load; loads are {', '.join(LOADS)}")
    found, loads = {}, set()
    with open(path, newline="", encoding="utf-8") as file:
        rows = csv.DictReader(file)
        for name in ["status", "speed_rpm", *LOADS, *COEFFICIENTS.values()]:
            if name not in (rows.fieldnames or ()):
                raise ValueError(f"{path}: the column {name} is missing; is this a table of cargo replay?")
        for row in rows:
            if any(float(row[name]) != wanted for name, wanted in load.items()):
                continue
            line = f"{path}: line {rows.line_num}"
            if not row[COEFFICIENTS["kxx"]]:
                raise ValueError(f"{line}: no stiffness ({row['status']}); leave this speed out")
            loads.add(tuple(float(row[name]) for name in LOADS))
            if len(loads) > 1:
                raise ValueError(f"{line}: another load than above; pick one with load={{...}}")
            speed = float(row["speed_rpm"])
            if speed in found:
                raise ValueError(f"{line}: {speed} rpm is there twice")
            found[speed] = {name: float(row[column]) for name, column in COEFFICIENTS.items()}
    if not found:
        raise ValueError(f"{path}: no row has this load")
    if min(found) < 0:
        raise ValueError(f"{path}: speeds must not be negative: ROSS turns its shaft about +z")
    speeds = sorted(found)
    table = {name: [found[speed][name] for speed in speeds] for name in COEFFICIENTS}
    table["frequency"] = [speed * math.pi / 30 for speed in speeds]
    return table


def bearing_element(path, node, load=None, cxx=0.0, element=None, **others):
    """ROSS's `BearingElement` at a node. `element` is the class to make it of; `others` go to it as they are."""
    if element is None:
        from ross import BearingElement as element
    table = read_table(path, load)
    # One speed is a constant; between two or more, ROSS interpolates.
    if len(table["frequency"]) == 1:
        del table["frequency"]
        table = {name: values[0] for name, values in table.items()}
    return element(n=node, cxx=cxx, **table, **others)


def check():
    """Tests the mapping with a stand-in for ROSS's class, and with physics that no renaming of axes changes."""
    import os
    import tempfile
    from types import SimpleNamespace as Element

    freedoms = ("x", "y", "z", "ty", "tz")
    stiffness = [f"k_{a}_{b}" for a in freedoms for b in freedoms]
    header = ["time_s", "status", *stiffness, "limits", *LOADS, "speed_rpm"]
    folder = tempfile.TemporaryDirectory()
    path = os.path.join(folder.name, "table.csv")

    def line(speed, fy=0, start=0):
        return [0, "converged", *range(start, start + 25), "", 300, fy, 0, 0, 0, speed]

    def write(rows, head=header):
        with open(path, "w", newline="", encoding="utf-8") as file:
            csv.writer(file).writerows([head, *rows])

    def bearing(**named):
        return bearing_element(path, 3, element=Element, **named)

    def refused(words, rows, head=header, **named):
        write(rows, head)
        try:
            bearing(**named)
        except ValueError as error:
            assert words in str(error), error
        else:
            raise AssertionError(f"not refused: {words}")

    # Out of order; the k-th column of a row is its start plus k, rows x y z ty tz by columns x y z ty tz.
    rows = [line(speed, fy, 1000 * speed + fy) for fy in (0, 250) for speed in (60, 0, 90, 30)]
    write(rows)
    found = bearing(load={"fy_n": 250}, cxx=5.0, tag="front")
    assert (found.n, found.cxx, found.tag) == (3, 5.0, "front")
    assert all(math.isclose(a, b * math.pi) for a, b in zip(found.frequency, (0, 1, 2, 3), strict=True))
    for name, column in {"kzz": 0, "kxx": 6, "kxy": 7, "kyx": 11, "kyy": 12}.items():
        assert getattr(found, name) == [1000 * speed + 250 + column for speed in (0, 30, 60, 90)], name

    refused("another load than above", rows)
    refused("no row has this load", rows, load={"fy_n": 1})
    refused("speed is no load", rows, load={"speed": 1})
    refused("30.0 rpm is there twice", [line(30), line(30)])
    refused("must not be negative", [line(-30)])
    refused("line 2: no stiffness (unseated)", [[0, "unseated", *[""] * 26, 300, 0, 0, 0, 0, 30]])
    refused("the column speed_rpm is missing", [], header[:5])
    refused("the column k_y_z is missing", [], [name for name in header if name != "k_y_z"])
    write([line(30)])
    constant = bearing()
    folder.cleanup()
    assert not hasattr(constant, "frequency")

    # ROSS's axes in the table's frame, where x, y and z are these. Both frames are right-handed, and the shaft turns
    # the same way in both: the table's from y to z about x, ROSS's from x to y about z.
    x, y, z = (1, 0, 0), (0, 1, 0), (0, 0, 1)
    ross = {"x": y, "y": z, "z": x}

    def cross(a, b):
        return tuple(a[i - 2] * b[i - 1] - a[i - 1] * b[i - 2] for i in range(3))

    assert cross(y, z) == x and cross(ross["x"], ross["y"]) == ross["z"] == x
    # Stiffness turns as a tensor does: along the axes a and b it is a K b.
    matrix = [[5 * row + column for column in range(3)] for row in range(3)]
    for name in COEFFICIENTS:
        a, b = (ross[axis] for axis in name[1:])
        turned = sum(a[i] * matrix[i][j] * b[j] for i in range(3) for j in range(3))
        assert getattr(constant, name) == turned, name
    print("ross_bearing.py: the recipe maps as it should")


if __name__ == "__main__":
    if sys.argv[1:] == ["--check"]:
        check()
    else:
        sys.exit("usage: ross_bearing.py --check; or import it, as its first lines tell")

#!/usr/bin/env python3
"""Flexibility at the noses of a spindle, held against an elastic shaft of ROSS, the rotor dynamics package.

    python3.11 -m venv venv && venv/bin/pip install "ross-rotordynamics==2.3.0" "plotly<6"
    cargo test -p judge --test all -- --ignored written_for_ross
    venv/bin/python ross_shaft.py host_tests/judge/cases/ross_shafts.csv target/ross_shafts/*.json
    venv/bin/python ross_shaft.py --check           # tests the recipe against closed forms

The test writes solved sets of `host_tests/judge/cases/elastic.json`, a file each. The table has a line for each: the set, the
diagonal of ROSS's flexibility, and the largest difference of all 25 elements. One above 1e-9 ends the recipe with an
error. `cargo test` holds the library against the table, without ROSS.

A file has the shaft, each row's stiffness at its load, and the flexibilities to be checked:

    {"youngs_modulus": 206e9, "poissons_ratio": 0.3, "sections": [[from, to, outer diameter, inner diameter], ...],
     "rows": [{"position": 0.0, "stiffness": 5x5}, ...], "noses": [{"position": -0.06, "flexibility": 5x5}, ...]}

All is SI and in the shaft's frame: Fx, Fy, Fz, My, Mz by dx, dy, dz, ty, tz; x is along the shaft, tilts are
right-handed. A row's stiffness includes its support; a sleeve on a spring is condensed, and may have one row only. ROSS
has no rigid shaft: sections must join, and cover all rows and noses.

ROSS has z along the shaft: its x, y, z are y, z, x here. Both frames are right-handed, so no sign changes. Its elements
bend with shear (Cowper's factor). Its bearings do not resist tilting, so rows are added to its stiffness matrix.
"""

import datetime
import itertools
import json
import pathlib
import sys

import numpy as np

TOLERANCE = 1e-9
# Closer points share a node, m: rounded positions do not make a node each.
SAME = 1e-12
# Shortest element, m. It swamps its neighbours' stiffness: flexibilities lose 6e-11 at 1e-5 m, and 2e-8 at 1e-7 m.
SHORTEST = 1e-5
# ROSS's freedoms of a node are x, y, z, alpha, beta, theta: dx is z, dy is x, dz is y, ty is alpha, tz is beta.
FREEDOMS, NODE = np.array([2, 0, 1, 3, 4]), 6


def flexibilities(spindle):
    """ROSS's flexibility at each nose."""
    import ross

    sections, rows, noses = sorted(spindle["sections"]), spindle["rows"], spindle["noses"]
    if not (sections and rows and noses):
        raise ValueError("sections, rows or noses are missing")
    for left, right in itertools.pairwise(sections):
        if abs(right[0] - left[1]) > SAME:
            raise ValueError(f"sections do not join: one ends at {left[1]} m, the next starts at {right[0]} m")
    positions = [place["position"] for place in rows + noses]
    if min(positions) < sections[0][0] - SAME or max(positions) > sections[-1][1] + SAME:
        raise ValueError("a row or a nose is outside of the sections")
    nodes = []
    for point in sorted([end for section in sections for end in section[:2]] + positions):
        if not nodes or point - nodes[-1] >= SHORTEST:
            nodes.append(point)
        elif point - nodes[-1] > SAME:
            raise ValueError(f"{nodes[-1]} m and {point} m are too close for elements of stiffness")

    material = ross.Material("shaft", rho=7850, E=spindle["youngs_modulus"], Poisson=spindle["poissons_ratio"])
    elements = []
    for start, end in itertools.pairwise(nodes):
        outer, inner = next(section[2:] for section in sections if section[1] > (start + end) / 2)
        elements.append(ross.ShaftElement(L=end - start, idl=inner, odl=outer, material=material))
    stiffness = ross.Rotor(elements).K(0)
    at = [NODE * np.argmin(np.abs(np.array(nodes) - position)) + FREEDOMS for position in positions]
    for row, own in zip(rows, at):
        stiffness[np.ix_(own, own)] += np.reshape(row["stiffness"], (5, 5))
    # Nothing holds the torsion, and nothing couples with it.
    torsion = np.arange(NODE - 1, len(stiffness), NODE)
    stiffness[torsion, torsion] += np.max(stiffness[torsion, torsion])
    flexibility = np.linalg.inv(stiffness)
    return [flexibility[np.ix_(own, own)] for own in at[len(rows) :]]


def difference(nose, flexibility):
    """Largest difference of a nose from ROSS's flexibility, relative to sqrt(C_ii C_jj)."""
    size = np.sqrt(np.diag(flexibility))
    off = np.reshape(nose["flexibility"], (5, 5)) - flexibility
    return float(np.max(np.abs(off) / np.outer(size, size)))


def check():
    """Tests the recipe on a prismatic shaft with one row: the row's flexibility, and a cantilever's."""
    modulus, poisson, outer, inner, row = 2.06e11, 0.3, 0.07, 0.03, 0.04
    area, bending, m = np.pi / 4 * (outer**2 - inner**2), np.pi / 64 * (outer**4 - inner**4), (inner / outer) ** 2
    kappa = 6 * (1 + poisson) * (1 + m) ** 2 / ((7 + 6 * poisson) * (1 + m) ** 2 + (20 + 12 * poisson) * m)
    size = np.sqrt([1e8, 4e8, 3e8, 2e5, 1e5])
    stiffness = np.outer(size, size) * (np.eye(5) + 0.1 * np.triu(np.ones((5, 5)), 1) - 0.2 * np.tri(5, k=-1))
    noses, sections = [], [[-0.06, 0.2, outer, inner]]
    for position in sections[0][:2]:
        by, length = position - row, abs(position - row)
        lateral = length**3 / 3 / bending + length * 2 * (1 + poisson) / kappa / area
        beam = np.diag([length / area, lateral, lateral, length / bending, length / bending])
        beam[1, 4] = beam[4, 1] = by * length / 2 / bending
        beam[2, 3] = beam[3, 2] = -by * length / 2 / bending
        carry = np.eye(5)
        carry[1, 4], carry[2, 3] = by, -by
        noses.append({"position": position, "flexibility": carry @ np.linalg.inv(stiffness) @ carry.T + beam / modulus})
    rows = [{"position": row, "stiffness": stiffness}]
    spindle = {"youngs_modulus": modulus, "poissons_ratio": poisson, "sections": sections, "rows": rows, "noses": noses}
    found = flexibilities(spindle)
    worst = max(map(difference, noses, found))
    assert worst < 1e-11, worst
    for nose in noses:
        nose["flexibility"] = nose["flexibility"].T
    assert min(map(difference, noses, found)) > 1e-3
    print(f"ross_shaft.py: ROSS agrees with closed forms to {worst:.1e}")


def main(table, paths):
    import ross

    axes, worst = ("x", "y", "z", "ty", "tz"), []
    lines = [f"# Flexibility at noses by ROSS {ross.__version__}, made by ross_shaft.py on {datetime.date.today()}."]
    lines.append(",".join(["set", *(f"ross_{axis}_{axis}" for axis in axes), "difference"]))
    for path in map(pathlib.Path, paths):
        try:
            spindle = json.loads(path.read_text(encoding="utf-8"))
            for nose, flexibility in zip(spindle["noses"], flexibilities(spindle), strict=True):
                worst.append(difference(nose, flexibility))
                diagonal = [f"{c:.12e}" for c in np.diag(flexibility)]
                lines.append(",".join([path.stem, *diagonal, f"{worst[-1]:.1e}"]))
        except (OSError, ValueError, KeyError) as error:
            sys.exit(f"{path}: {error!r}")
    # Not a number fails, too.
    if not all(one <= TOLERANCE for one in worst):
        sys.exit(f"a difference is above {TOLERANCE:.0e}: {worst}")
    pathlib.Path(table).write_text("\n".join(lines) + "\n", encoding="utf-8")
    print(f"{table}: {len(worst)} noses, largest relative difference {max(worst):.1e}")


if __name__ == "__main__":
    if sys.argv[1:] == ["--check"]:
        check()
    elif len(sys.argv) > 2:
        main(sys.argv[1], sys.argv[2:])
    else:
        sys.exit("usage: ross_shaft.py TABLE FILE..., or --check")

"""Elastic shafts and tables for rotor programs beside ROSS, the program for rotors: its beam elements, its bearings.

ROSS has z along the shaft, which turns from x towards y: its x, y, z are y, z, x here. Both frames are right-handed, so no sign changes.
"""

import itertools
import json
import pathlib

import numpy as np
import pytest
import ross

import spindle_bearing as sb

ROOT = pathlib.Path(__file__).parents[4]
SETS = json.loads((ROOT / "host_tests" / "judge" / "cases" / "elastic.json").read_text())
# Rows in a sleeve move together, which ROSS's rows cannot.
WITHOUT_SLEEVE = [number for number, case in enumerate(SETS) if "spring_force" not in case]
# Of all 25 elements, relative to sqrt(C_ii C_jj). The largest found is 4.5e-13: short elements swamp their neighbours' stiffness.
TOLERANCE = 1e-11
# Our dx, dy, dz, ty, tz among the six freedoms of ROSS's nodes: x, y, z, about x, about y, about z.
FREEDOMS, NODE = np.array([2, 0, 1, 3, 4]), 6


def material(keys):
    found = {"youngs_modulus_gpa": 1e-9 * keys["E"], "poissons_ratio": keys["nu"]}
    return {**found, "density_kg_m3": keys["rho"]} if "rho" in keys else found


def row(keys):
    """A row of a set as that of a spindle's file."""
    bearing = keys["bearing"]
    design = {"name": "row", "balls": bearing["balls"], "contact_angle_deg": float(bearing["contact_angle_deg"])}
    design |= {f"{name}_mm": 1e3 * bearing[name] for name in ("ball_diameter", "pitch_diameter")}
    design |= {name: bearing[name] for name in ("inner_groove_factor", "outer_groove_factor")}
    growth = zip(("axial_growth_um", "radial_growth_um", "ball_growth_um"), keys["growth"])
    units = {"axial_n_per_um": 1e-6, "radial_n_per_um": 1e-6, "tilting_nm_per_rad": 1.0}
    support = zip(units.items(), keys.get("support") or [None] * 3)
    return {
        "design": {**design, "ring": material(bearing["ring"]), "ball": material(bearing["ball"])},
        "position_mm": 1e3 * keys["position"],
        "facing": "+x" if keys["facing"] == 1 else "-x",
        "preload_offset_um": 1e6 * keys["preload_offset"],
        "support": {name: unit * value for (name, unit), value in support if value is not None},
    } | {name: 1e6 * value for name, value in growth}


def spindle(case):
    shaft, names = case["shaft"], ("from_mm", "to_mm", "outer_mm", "inner_mm")
    sections = [dict(zip(names, (1e3 * value for value in section))) for section in shaft["sections"]]
    shaft = {"youngs_modulus_gpa": 1e-9 * shaft["youngs_modulus"], "poissons_ratio": shaft["poissons_ratio"], "sections": sections}
    return sb.Spindle({"name": "set", "row": [row(keys) for keys in case["rows"]], "shaft": shaft})


def flexibility(case, rows):
    """ROSS's flexibility at the nose, with these stiffnesses of the rows."""
    shaft, places = case["shaft"], [*(keys["position"] for keys in case["rows"]), case["nose"]]
    nodes = sorted({*places, *(end for section in shaft["sections"] for end in section[:2])})
    steel = ross.Material("shaft", rho=7850, E=shaft["youngs_modulus"], Poisson=shaft["poissons_ratio"])
    elements = []
    for start, end in itertools.pairwise(nodes):
        outer, inner = next(section[2:] for section in shaft["sections"] if section[0] <= start and end <= section[1])
        elements.append(ross.ShaftElement(L=end - start, idl=inner, odl=outer, material=steel))
    stiffness = ross.Rotor(elements).K(0)
    at = [NODE * nodes.index(place) + FREEDOMS for place in places]
    for of_row, own in zip(rows, at):
        # ROSS's own bearings do not resist tilting.
        stiffness[np.ix_(own, own)] += of_row
    # Nothing holds the torsion, and nothing couples with it.
    torsion = np.arange(NODE - 1, len(stiffness), NODE)
    stiffness[torsion, torsion] += stiffness.max()
    return np.linalg.inv(stiffness)[np.ix_(at[-1], at[-1])]


def difference(ours, theirs):
    size = np.sqrt(np.diag(theirs))
    return np.max(np.abs(ours - theirs) / np.outer(size, size))


@pytest.mark.filterwarnings("ignore::UserWarning")
@pytest.mark.parametrize("number", WITHOUT_SLEEVE)
def test_the_nose_gives_way_as_that_of_ross(number):
    case = SETS[number]
    result = spindle(case).solve(case["load"], case["speed_rpm"], attitude=case["attitude"])
    assert not result.error[0]
    ours, rows = result.compliance(case["nose"])[0], [of.stiffness[0] for of in result.rows]
    assert difference(ours, flexibility(case, rows)) < TOLERANCE
    # A row of which one element is off by a millionth is seen.
    rows[0] = rows[0] * (1 + 1e-6 * (np.arange(25).reshape(5, 5) == 6))
    assert difference(ours, flexibility(case, rows)) > TOLERANCE


def test_rotor_programs_are_given_their_axes(monkeypatch):
    page = (ROOT / "docs" / "host.md").read_text()
    block = page.split("## Tables for rotor programs")[1].split("```python\n")[1].split("```")[0]
    names = {}
    monkeypatch.chdir(ROOT)
    # A load between the axes couples them.
    exec(compile(block.replace("fy=50", "fy=50, fz=30"), "host.md", "exec"), names)
    turn = np.eye(3)[[1, 2, 0]]
    assert np.linalg.det(turn) == pytest.approx(1)
    for speed, ours in zip(names["rpm"] * np.pi / 30, names["k"]):
        theirs, turned = names["bearing"].K(speed), turn @ ours[:3, :3] @ turn.T
        # ROSS couples no radial with the axial direction. Where it is given a value, its interpolation is off by 7e-8 of the largest.
        assert np.allclose(theirs[:2, :2], turned[:2, :2], rtol=0, atol=1e-6 * turned.max())
        assert theirs[2, 2] == pytest.approx(turned[2, 2], rel=1e-6) and abs(turned[0, 1]) > 1e6

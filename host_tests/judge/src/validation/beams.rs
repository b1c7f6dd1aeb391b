//! Sets on a uniform shaft, and the same beams in closed form.

use super::case::{Case, with, with_matrix};
use crate::reference::spindle::stiffnesses;
use solvers::Answer;
use spindle_bearing::{Material, Section, Support};
use spindle_file::plan::{ElasticShaft, ShaftEnd};

/// The section from the nose to the last row, and its material, if the shaft is elastic.
fn section(case: &Case, last: f64) -> Option<(Section, Material)> {
    let or = |column: &str, other| case.get(column).copied().unwrap_or(other);
    let outer = 1e-3 * case.get("outer_mm")?;
    let section = Section {
        from: 1e-3 * or("nose_mm", 0.0),
        to: last,
        outer,
        inner: 1e-3 * or("inner_mm", 0.0),
    };
    let steel = Material::STEEL;
    let material = Material {
        youngs_modulus: 1e9 * or("youngs_modulus_gpa", 1e-9 * steel.youngs_modulus),
        ..steel
    };
    Some((section, material))
}

/// The shaft of a case, if it is elastic, with the supports of its rows. The last row stands at `last`, m.
pub fn shaft(case: &Case, rows: usize, last: f64) -> Option<ElasticShaft> {
    let (section, material) = section(case, last)?;
    let or_rigid = |column: &str| case.get(column).copied().unwrap_or(f64::INFINITY);
    let support = Support {
        radial: 1e6 * or_rigid("support_n_per_um"),
        tilting: or_rigid("support_nm_per_rad"),
        ..Support::RIGID
    };
    Some(ElasticShaft {
        material,
        ..ElasticShaft::of(vec![section], vec![support; rows])
    })
}

/// The nose of a case and `x = 0`, if it has a nose.
pub fn ends(case: &Case) -> Vec<ShaftEnd> {
    let nose = case.get("nose_mm").map(|mm| 1e-3 * mm);
    let positions = nose.into_iter().flat_map(|nose| [nose, 0.0]);
    positions.map(ShaftEnd::rigid).collect()
}

/// The case with its flexibility at the nose; on an elastic shaft, with the shaft's part of it and with textbook beams.
pub fn with_nose(mut case: Case, answer: &Answer, last: f64) -> Case {
    let [at_nose, at_row] = answer.at.as_slice() else {
        return case;
    };
    let c = at_nose.compliance;
    case = with(case, ["nose_n_per_m"], [1.0 / c[1][1]]);
    case = with_matrix(case, "c_nose", c);
    let Some((section, material)) = section(&case, last) else {
        return case;
    };
    // Held at the first row, the shaft is a cantilever.
    let held = carried(&at_row.compliance, section.from);
    let cantilever = std::array::from_fn(|i| std::array::from_fn(|j| c[i][j] - held[i][j]));
    case = with_matrix(case, "cantilever", cantilever);
    with_textbook(case, &section, &material, answer)
}

/// Flexibility `x` further along a rigid shaft: `T C T^T`.
fn carried(c: &[[f64; 5]; 5], x: f64) -> [[f64; 5]; 5] {
    let mut c = *c;
    for row in &mut c {
        row[1] += x * row[4];
        row[2] -= x * row[3];
    }
    for j in 0..5 {
        c[1][j] += x * c[4][j];
        c[2][j] -= x * c[3][j];
    }
    c
}

/// Stiffness at the first end of a beam on springs (Euler and Bernoulli; with shear, Timoshenko).
///
/// Springs are positions and stiffnesses, in order. Deflection `w`, slope `psi`, moment `M` and shear force `Q` go from end to
/// end for a unit of `w`, a unit of `psi` and a unit force at the first end: `psi' = M/EI`, `M' = -Q`, `w' = psi + Q / kappa GA`;
/// a spring adds `k w` to `Q`. At the other end, `M = Q = 0`.
pub fn nose_on_springs(shaft: &ElasticShaft, springs: &[(f64, f64)], with_shear: bool) -> f64 {
    let mut units = [
        [1.0, 0.0, 0.0, 0.0],
        [0.0, 1.0, 0.0, 0.0],
        [0.0, 0.0, 0.0, -1.0],
    ];
    for section in &shaft.sections {
        let [_, bending, shear] = stiffnesses(section, &shaft.material);
        let slip = if with_shear { 1.0 / shear } else { 0.0 };
        let inside = springs
            .iter()
            .filter(|(x, _)| (section.from..section.to).contains(x));
        let mut from = section.from;
        for (to, spring) in inside.copied().chain([(section.to, 0.0)]) {
            let l = to - from;
            for [w, psi, m, q] in &mut units {
                *w += l * (*psi + *q * slip + l / bending * (*m / 2.0 - l * *q / 6.0));
                *psi += l / bending * (*m - l * *q / 2.0);
                *m -= l * *q;
                *q += spring * *w;
            }
            from = to;
        }
    }
    let [[_, _, m_w, q_w], [_, _, m_psi, q_psi], [_, _, m, q]] = units;
    (m_w * q_psi - m_psi * q_w) / (m_psi * q - m * q_psi)
}

/// Tip of a cantilever, and overhanging end of a beam on two springs, under a force or a moment there (Timoshenko).
///
/// Deflection by a force `P`, overhang `a`, rows `l` apart:
///
/// - cantilever: `P a^3 / 3EI + P a / kappa GA`;
/// - beam: `P a^2 (a + l) / 3EI + P (a + a^2 / l) / kappa GA`, and what the springs yield under their reactions.
fn with_textbook(case: Case, section: &Section, material: &Material, answer: &Answer) -> Case {
    let (a, l) = (-section.from, section.to);
    let [tension, bending, shear] = stiffnesses(section, material);
    let beam = a * a * (a + l) / (3.0 * bending) + (a + a * a / l) / shear;
    let reactions = [(a + l) / l, a / l];
    let springs = answer.rows.iter().map(|row| row.stiffness_on_shaft[1][1]);
    let sunk = reactions.iter().zip(springs).map(|(r, k)| r * r / k);
    let columns = [
        "overhang",
        "tip_x_x",
        "tip_y_y",
        "tip_tz_tz",
        "tip_y_tz",
        "tip_z_ty",
        "two_springs_y_y",
    ];
    let values = [
        a / section.outer,
        a / tension,
        a.powi(3) / (3.0 * bending) + a / shear,
        a / bending,
        -a * a / (2.0 * bending),
        a * a / (2.0 * bending),
        beam + sunk.sum::<f64>(),
    ];
    with(case, columns, values)
}

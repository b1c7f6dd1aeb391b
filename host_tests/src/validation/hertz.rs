//! Contact constants: closed forms, elliptic integrals to 30 digits, and the fits of Brewe and Hamrock.

use super::figure::{
    Axis, BLUE, Curve, Dash, Figure, GREEN, INK, Marker, Panel, Pen, Plane, VERMILION,
};
use super::statement::{Measure, Statement, shown, with_digits};
use super::{Block, COMMAND, Chapter, Progress, Table};
use crate::cases::{self, B218, B7005C, SKF6205, rad_per_s};
use crate::compare::{Equilibrium, stiffness_error, worse};
use crate::reference::Attitude;
use anyhow::Context;
use serde::Deserialize;
use spindle_bearing::{Design, FreeContact, HertzContact, Material, elliptic_integrals};
use std::f64::consts::PI;

/// Folder of the committed values; `hertz.py` beside them made them.
const FOLDER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/cases");

/// `K(m)` and `E(m)`, rounded from 30 digits.
#[derive(Debug, Deserialize)]
struct Integrals {
    m: f64,
    k: f64,
    e: f64,
}

/// A contact of two curvatures and compliance 1, rounded from 30 digits.
#[derive(Debug, Deserialize)]
struct Contact {
    rolling: f64,
    across: f64,
    kappa: f64,
    e: f64,
    load_deflection: f64,
}

fn read<T: for<'de> Deserialize<'de>>(name: &str) -> anyhow::Result<Vec<T>> {
    let path = format!("{FOLDER}/{name}");
    let advice = || format!("cannot read {path}; `git checkout {path}` brings it back");
    let mut reader = csv::Reader::from_path(&path).with_context(advice)?;
    reader
        .deserialize()
        .collect::<Result<_, _>>()
        .with_context(advice)
}

fn off(found: f64, truth: f64) -> f64 {
    (found / truth - 1.0).abs()
}

/// Contact compliance `1/E*` of steel on steel.
fn steel() -> f64 {
    let Material {
        youngs_modulus,
        poissons_ratio,
        ..
    } = Material::STEEL;
    2.0 * (1.0 - poissons_ratio * poissons_ratio) / youngs_modulus
}

/// Load-deflection constant, contact radius over `Q^(1/3)`, and peak pressure at 1000 N of two spheres
/// of the relative radius `r` (Johnson, Contact Mechanics, 1985, 4.2).
fn spheres(r: f64, compliance: f64) -> [f64; 3] {
    let modulus = 1.0 / compliance;
    [
        4.0 / 3.0 * modulus * r.sqrt(),
        (3.0 * r / (4.0 * modulus)).cbrt(),
        (6.0 * 1000.0 * modulus * modulus / (PI.powi(3) * r * r)).cbrt(),
    ]
}

/// The library's contact of relative curvatures so close to each other that it counts as round.
fn nearly_round(curvature: f64, excess: f64, compliance: f64) -> HertzContact {
    let half = 0.5 * excess;
    HertzContact::new(
        curvature * (1.0 + half),
        curvature * (1.0 - half),
        compliance,
    )
}

fn errors_of_round(r: f64) -> [f64; 3] {
    let contact = nearly_round(1.0 / r, 1e-5, steel());
    let [k, a, p] = spheres(r, steel());
    let mean = (contact.semi_major * contact.semi_minor).sqrt();
    [
        off(contact.load_deflection, k),
        off(mean, a),
        off(contact.peak_pressure(1000.0), p),
    ]
}

fn closed_forms() -> (Table, Vec<Statement>) {
    // Two balls of the 218, and one on a plane.
    let d = B218.ball_diameter;
    let sphere = errors_of_round(0.25 * d).into_iter().fold(0.0, worse);
    let plane = errors_of_round(0.5 * d).into_iter().fold(0.0, worse);
    let excess = [1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-8, 1e-12];
    let [round, ..] = spheres(1.0, 1.0);
    let departure = |e: f64| nearly_round(1.0, e, 1.0).load_deflection / round - 1.0;
    let rows = excess.iter().map(|&e| {
        let (contact, d) = (nearly_round(1.0, e, 1.0), departure(e));
        let small = d.abs() < 1e-10;
        vec![
            shown(e),
            format!("{:.6}", contact.ellipticity),
            if small {
                "below 1e-10".to_owned()
            } else {
                with_digits(d, 3)
            },
        ]
    });
    let table = Table {
        caption: "From an ellipse to a circle (the library's search ends at `kappa` = 1.000001): contact of the \
                  curvatures `1 + e/2` and `1 - e/2`, and how far its \
                  load-deflection constant is from that of spheres of the same sum of curvatures."
            .to_owned(),
        head: ["e", "kappa", "K over the spheres' - 1"].map(str::to_owned).into(),
        rows: rows.collect(),
    };
    let rounding = excess[4..]
        .iter()
        .fold(0.0, |m, &e| worse(m, departure(e).abs()));
    let statements = vec![
        Statement::ours(
            "A contact that is nearly round (curvatures 1e-5 apart) has the load-deflection constant, the size and \
             the peak pressure of a sphere on a sphere.",
            vec![Measure::rounding(
                "largest relative difference, two balls of the 218",
                sphere,
                "",
                2e-11,
            )],
        ),
        Statement::ours(
            "Likewise of a sphere on a plane.",
            vec![Measure::rounding(
                "largest relative difference, a ball of the 218",
                plane,
                "",
                2e-11,
            )],
        ),
        Statement::ours(
            "As `kappa` goes to 1, the constant comes to that of spheres with the square of the \
             difference of curvatures, and nothing breaks where the formulas become 0/0.",
            vec![
                Measure::within(
                    "departure at `e` = 0.1 over that at 0.01",
                    departure(0.1) / departure(0.01),
                    "",
                    99.0,
                    101.0,
                ),
                Measure::within(
                    "at 0.01 over that at 0.001",
                    departure(0.01) / departure(0.001),
                    "",
                    99.0,
                    101.0,
                ),
                Measure::rounding(
                    "largest departure for `e` from 1e-5 to 1e-12",
                    rounding,
                    "",
                    1e-10,
                ),
            ],
        ),
    ];
    (table, statements)
}

fn thirty_digits() -> anyhow::Result<Vec<Statement>> {
    let integrals: Vec<Integrals> = read("elliptic_integrals.csv")?;
    let contacts: Vec<Contact> = read("hertz_contacts.csv")?;
    let mut worst = [0.0; 2];
    for row in &integrals {
        let (k, e) = elliptic_integrals(row.m);
        worst = [
            worse(worst[0], off(k, row.k)),
            worse(worst[1], off(e, row.e)),
        ];
    }
    let mut by = [0.0; 3];
    for row in &contacts {
        let found = HertzContact::new(row.rolling, row.across, 1.0);
        let errors = [
            off(found.ellipticity, row.kappa),
            off(found.elliptic_e, row.e),
            off(found.load_deflection, row.load_deflection),
        ];
        for (worst, e) in by.iter_mut().zip(errors) {
            *worst = worse(*worst, e);
        }
    }
    Ok(vec![
        Statement::ours(
            format!(
                "The complete elliptic integrals are those of {} values computed to 30 digits, up to \
                 `m = 1 - 2^-20`.",
                integrals.len()
            ),
            vec![
                Measure::count("values", integrals.len(), 15),
                Measure::rounding("largest relative difference of `K(m)`", worst[0], "", 1e-15),
                Measure::rounding("of `E(m)`", worst[1], "", 2e-15),
            ],
        ),
        Statement::ours(
            format!(
                "Ellipticity, elliptic integral and load-deflection constant are those of {} contacts computed to \
                 30 digits, with curvatures from 9:8 to 256:1.",
                contacts.len()
            ),
            vec![
                Measure::count("contacts", contacts.len(), 11),
                Measure::rounding("largest relative difference of `kappa`", by[0], "", 1e-13),
                Measure::rounding("of `E`", by[1], "", 1e-13),
                Measure::rounding("of the load-deflection constant", by[2], "", 1e-13),
            ],
        ),
    ])
}

/// `kappa`, `E` and `K` by the fits of Brewe and Hamrock, J. Lubr. Technol. 99 (1977), for a ratio of
/// curvatures.
fn fits(ratio: f64) -> [f64; 3] {
    [
        1.0339 * ratio.powf(0.636),
        1.0003 + 0.5968 / ratio,
        1.5277 + 0.6023 * ratio.ln(),
    ]
}

/// Errors of the fits at a ratio of curvatures, %: of `kappa`, `E`, `K`, and of the load-deflection
/// constant that they make.
fn errors_of_fits(ratio: f64) -> [f64; 4] {
    let exact = HertzContact::new(ratio, 1.0, 1.0);
    let kappa = exact.ellipticity;
    let (k, e) = elliptic_integrals(1.0 - 1.0 / (kappa * kappa));
    let constant = |kappa: f64, e: f64, k: f64| kappa * (e / k.powi(3)).sqrt();
    let [fitted_kappa, fitted_e, fitted_k] = fits(ratio);
    let error = |fit: f64, exact: f64| 100.0 * (fit / exact - 1.0);
    [
        error(fitted_kappa, kappa),
        error(fitted_e, e),
        error(fitted_k, k),
        error(
            constant(fitted_kappa, fitted_e, fitted_k),
            constant(kappa, e, k),
        ),
    ]
}

/// A bearing's two ratios of curvatures, rolling over across.
fn ratios(design: &Design) -> [f64; 2] {
    let cos = match design.free_contact {
        FreeContact::Angle(angle) => angle.cos(),
        FreeContact::DiametralClearance(clearance) => {
            1.0 - clearance / (2.0 * design.centre_distance())
        }
    };
    let gamma = design.ball_diameter * cos / design.pitch_diameter;
    let ratio = |gamma: f64, f: f64| 2.0 / (1.0 - gamma) / (2.0 - 1.0 / f);
    [
        ratio(gamma, design.inner_groove_factor),
        ratio(-gamma, design.outer_groove_factor),
    ]
}

struct Fitted {
    name: &'static str,
    ratios: [f64; 2],
    /// Error of the inner and of the outer constant, %.
    constants: [f64; 2],
    /// Errors of displacement and stiffness, %.
    displacement: f64,
    stiffness: f64,
    /// Of contact angles, degrees, and of contact forces, % of the largest.
    angle: f64,
    force: f64,
}

fn on_bearings() -> anyhow::Result<Vec<Fitted>> {
    let bearings = [
        (
            "218, 17,800 N, 10,000 rpm",
            B218,
            16,
            [17_800.0, 0.0, 0.0, 0.0, 0.0],
            10_000.0,
        ),
        (
            "B7005C, `Mz` = 3 N m, 20,000 rpm",
            B7005C,
            16,
            [1000.0, 200.0, 0.0, 0.0, 3.0],
            20_000.0,
        ),
        (
            "6205, 100 N, 10,000 rpm",
            SKF6205,
            9,
            [100.0, 0.0, 0.0, 0.0, 0.0],
            10_000.0,
        ),
    ];
    bearings
        .into_iter()
        .map(|(name, design, balls, load, rpm)| {
            let exact = cases::reference(&design, balls);
            let fitted = exact.clone().with_fitted_contacts();
            let solve = |r: &crate::reference::Reference| {
                r.search(load, rad_per_s(rpm), Attitude::Raceless)
                    .map(|s| Equilibrium::from(&s))
                    .with_context(|| name.to_owned())
            };
            let (a, b) = (solve(&fitted)?, solve(&exact)?);
            let e = a.errors(&b, design.ball_diameter, 0.5 * design.pitch_diameter);
            let ((ki, ko), (fi, fo)) = (exact.hertz_constants(), fitted.hertz_constants());
            Ok(Fitted {
                name,
                ratios: ratios(&design),
                constants: [100.0 * (fi / ki - 1.0), 100.0 * (fo / ko - 1.0)],
                displacement: 100.0 * e.displacement,
                stiffness: 100.0 * stiffness_error(&a.stiffness, &b.stiffness),
                angle: e.contact_angle.to_degrees(),
                force: 100.0 * e.force,
            })
        })
        .collect()
}

fn brewe_hamrock() -> anyhow::Result<Vec<Block>> {
    let sample: Vec<f64> = (0..=120)
        .map(|i| 1.05 * (100.0_f64 / 1.05).powf(f64::from(i) / 120.0))
        .collect();
    let errors: Vec<[f64; 4]> = sample.iter().map(|r| errors_of_fits(*r)).collect();
    let fitted = on_bearings()?;
    let pens = [
        (Pen(BLUE, Dash::Long, Marker::Square), "kappa", 0),
        (Pen(GREEN, Dash::Short, Marker::Disc), "E", 1),
        (
            Pen(VERMILION, Dash::Dots, Marker::Triangle),
            "K (integral)",
            2,
        ),
        (
            Pen(INK, Dash::Solid, Marker::None),
            "load-deflection constant",
            3,
        ),
    ];
    let mut curves: Vec<Curve> = pens
        .iter()
        .enumerate()
        .map(|(i, (pen, _, column))| {
            let points = sample
                .iter()
                .zip(&errors)
                .map(|(r, e)| (r.log10(), e[*column]));
            Curve::through(*pen, points.collect(), 3 * i, 8)
        })
        .collect();
    let ring = Pen(INK, Dash::None, Marker::Ring);
    let places = fitted.iter().flat_map(|f| f.ratios);
    curves.push(Curve {
        pen: ring,
        line: Vec::new(),
        marks: places.map(|r| (r.log10(), errors_of_fits(r)[3])).collect(),
    });
    let mut legend: Vec<_> = pens
        .iter()
        .map(|(pen, name, _)| (*pen, (*name).to_owned()))
        .collect();
    legend.push((ring, "contacts of 218, B7005C, 6205".to_owned()));
    let figure = Figure {
        name: "brewe_hamrock",
        title: "Fits of Brewe and Hamrock (1977): errors against exact Hertz constants".to_owned(),
        caption: format!(
            "Errors of the fits of Brewe and Hamrock against the ratio of curvatures, rolling over across; rings: the \
             load-deflection constants of the six contacts of the bearings here. Regenerate with `{COMMAND}`."
        ),
        legend,
        columns: 1,
        panels: vec![Panel {
            title: String::new(),
            plane: Plane::Straight {
                x: Axis::logarithmic("ratio of curvatures, rolling over across"),
                y: Axis::from_zero("error / %"),
            },
            curves,
            nodes: Vec::new(),
        }],
    };
    let rows = fitted.iter().map(|f| {
        vec![
            f.name.to_owned(),
            with_digits(f.ratios[0], 4),
            format!("{:+.2}", f.constants[0]),
            with_digits(f.ratios[1], 4),
            format!("{:+.2}", f.constants[1]),
            with_digits(f.displacement, 3),
            with_digits(f.angle, 3),
            with_digits(f.force, 3),
            with_digits(f.stiffness, 3),
        ]
    });
    let table = Table {
        caption: "What the fits do to bearings: error of the contact constants, and largest errors of displacement \
                  (of its largest component), contact angles, contact forces (of the largest) and stiffness \
                  (in units of its diagonal)."
            .to_owned(),
        head: [
            "",
            "ratio, inner",
            "Ki / %",
            "outer",
            "Ko / %",
            "displacement / %",
            "angle / \u{b0}",
            "force / %",
            "stiffness / %",
        ]
        .map(str::to_owned)
        .into(),
        rows: rows.collect(),
    };
    let (least, most) = errors.iter().fold(
        (f64::INFINITY, f64::NEG_INFINITY),
        |(l, h): (f64, f64), e| (l.min(e[3]), h.max(e[3])),
    );
    let [.., near_circle] = errors_of_fits(1.05);
    let [.., long] = errors_of_fits(100.0);
    let of_bearings = fitted.iter().flat_map(|f| f.constants);
    let (b_least, b_most) = of_bearings.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), c| {
        (l.min(c), h.max(c))
    });
    // The fit as the reference build has it, against the fit as it is here.
    let same = fitted.iter().fold(0.0, |m, f| {
        (0..2).fold(m, |m, i| {
            worse(m, (errors_of_fits(f.ratios[i])[3] - f.constants[i]).abs())
        })
    });
    let largest = |of: fn(&Fitted) -> f64| fitted.iter().map(of).fold(0.0, worse);
    let statements = vec![
        Statement::ours(
            "On the contacts of the bearings here, the fits make the load-deflection constant too large by \
             0.2 % to 2.4 %.",
            vec![
                Measure::within("least error", b_least, "%", 0.15, 0.25),
                Measure::within("largest", b_most, "%", 2.35, 2.45),
                Measure::rounding("two programs of the fits apart", same, "%", 1e-9),
            ],
        ),
        Statement::ours(
            "Elsewhere they can be further off: most towards the circle, which they miss, and again where the \
             ellipse is very long.",
            vec![
                Measure::within(
                    "error at a ratio of curvatures of 1.05",
                    near_circle,
                    "%",
                    7.0,
                    9.0,
                ),
                Measure::within("at 100", long, "%", 5.0, 7.0),
                Measure::within("least from 1.05 to 100", least, "%", -1.0, 0.0),
                Measure::at_most("largest", most, "%", near_circle),
            ],
        ),
        Statement::ours(
            "Contact angles and forces hardly feel that; displacement and stiffness do.",
            vec![
                Measure::within(
                    "largest error of a contact angle",
                    largest(|f| f.angle),
                    "\u{b0}",
                    0.0,
                    0.1,
                ),
                Measure::within("of a contact force", largest(|f| f.force), "%", 0.0, 0.5),
                Measure::within(
                    "of the displacement",
                    largest(|f| f.displacement),
                    "%",
                    0.1,
                    3.0,
                ),
                Measure::within("of the stiffness", largest(|f| f.stiffness), "%", 0.1, 3.0),
            ],
        ),
    ];
    Ok(vec![
        Block::Figure(figure),
        Block::Table(table),
        Block::Statements(statements),
    ])
}

/// The chapter.
///
/// # Errors
///
/// The committed values cannot be read.
pub fn chapter(_progress: &dyn Progress) -> anyhow::Result<Chapter> {
    let (table, closed) = closed_forms();
    let mut blocks = vec![
        Block::Text(
            "Spheres: Johnson, Contact Mechanics (1985), 4.2. The values to 30 digits are in \
             `host_tests/cases/elliptic_integrals.csv` and `hertz_contacts.csv`, made by \
             `cd host_tests/cases && python3 hertz.py` (Python with mpmath 1.3, 50 digits; the integrals by \
             tanh-sinh quadrature of their definitions, where the library uses the arithmetic-geometric \
             mean). They are rounded to doubles before they are compared."
                .to_owned(),
        ),
        Block::Table(table),
        Block::Statements(closed),
        Block::Statements(thirty_digits()?),
    ];
    blocks.extend(brewe_hamrock()?);
    Ok(Chapter {
        title: "Contact constants",
        blocks,
    })
}

//! Cases of a run, solved: a table with the columns of `cargo replay`.

use super::beams;
use super::book::{Chapter, Program, Run, Table, Values};
use super::case::{Case, with, with_matrix};
use crate::cases::{rad_per_s, reference};
use crate::reference::{Reference, Task};
use anyhow::{Context, anyhow};
use rayon::prelude::*;
use solvers::dispatch::Precision;
use solvers::{Balls, with_solver};
use spindle_bearing::{
    Design, Facing, FreeContact, HertzContact, LifeRating, Material, Preload, RatingLife,
    elliptic_integrals,
};
use spindle_file::catalogue;
use spindle_file::designs::DesignFile;
use spindle_file::plan::{Plan, Question, Row};
use spindle_file::spindles::SpindleFile;
use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};

/// A run and its cases.
#[derive(Debug, Clone)]
pub struct Solved {
    /// Name of the run.
    pub name: String,
    /// Its cases, in the order of the file.
    pub cases: Vec<Case>,
}

/// Solves all runs of a chapter.
///
/// # Errors
///
/// A run that is no run, or a case without a solution; the message names it.
pub fn solve(chapter: &Chapter) -> anyhow::Result<Vec<Solved>> {
    let runs = chapter.run.par_iter().map(|keys| {
        let mut all = chapter.common.clone();
        for (key, value) in keys {
            match (all.get_mut(key).and_then(toml::Value::as_table_mut), value) {
                (Some(table), toml::Value::Table(more)) => table.extend(more.clone()),
                _ => {
                    all.insert(key.clone(), value.clone());
                }
            }
        }
        let run: Run = all.try_into().context(chapter.title.clone())?;
        let cases = of_run(&run).with_context(|| format!("{}: {}", chapter.title, run.name))?;
        Ok(Solved {
            name: run.name,
            cases,
        })
    });
    runs.collect()
}

fn of_run(run: &Run) -> anyhow::Result<Vec<Case>> {
    let cases = given(run)?;
    let solved: anyhow::Result<Vec<Vec<Case>>> = cases
        .into_par_iter()
        .map(|case| match run.table {
            Some(Table::EllipticIntegrals) => Ok(vec![with_integrals(case)]),
            Some(Table::HertzContacts) => Ok(vec![with_contact(case)]),
            Some(Table::Spheres) => Ok(vec![of_spheres(case)]),
            Some(Table::Fits) => Ok(vec![of_fits(case)]),
            Some(Table::SpindleCad) => Ok(vec![of_spindle_cad(case)?]),
            Some(Table::Fag) => of_fag(run, case),
            Some(Table::GmnS60 | Table::Ntn | Table::Snfa | Table::Nsk) | None => {
                of_bearing(run, case)
            }
        })
        .collect();
    let mut solved = solved?.concat();
    if run.each_ball {
        solved.sort_by(|a, b| a["azimuth_rad"].total_cmp(&b["azimuth_rad"]));
    }
    Ok(solved)
}

/// Cases as they are given: rows of a table, or a load; in all combinations with the values.
fn given(run: &Run) -> anyhow::Result<Vec<Case>> {
    let text = match run.table {
        Some(Table::GmnS60) => Some(catalogue::GMN_S60),
        Some(Table::Ntn) => Some(include_str!("../../makers/ntn.csv")),
        Some(Table::Fag) => Some(include_str!("../../makers/fag.csv")),
        Some(Table::Snfa) => Some(include_str!("../../makers/snfa.csv")),
        Some(Table::Nsk) => Some(include_str!("../../makers/nsk.csv")),
        Some(Table::EllipticIntegrals) => Some(include_str!("../../cases/elliptic_integrals.csv")),
        Some(Table::HertzContacts) => Some(include_str!("../../cases/hertz_contacts.csv")),
        Some(Table::Spheres | Table::Fits | Table::SpindleCad) | None => None,
    };
    let cases = match text {
        Some(text) => rows(run, text)?,
        None => {
            let [fx, fy, fz, my, mz] = run.load;
            let columns = ["fx_n", "fy_n", "fz_n", "my_nm", "mz_nm", "speed_rpm"];
            vec![with(Case::new(), columns, [fx, fy, fz, my, mz, 0.0])]
        }
    };
    Ok(combinations(cases, &run.values))
}

/// Rows of a table.
fn rows(run: &Run, text: &str) -> anyhow::Result<Vec<Case>> {
    let mut reader = csv::ReaderBuilder::new()
        .comment(Some(b'#'))
        .from_reader(text.as_bytes());
    let rows = reader.deserialize::<BTreeMap<String, String>>();
    rows.map(|row| {
        let level = format!("_{}", run.level.as_deref().unwrap_or_default());
        let row = row?;
        let stand_in = row.get("gmn_design").map(|name| gmn(name)).transpose()?;
        let row = row.into_iter().filter_map(|(name, text)| {
            let unit = if name.ends_with("_n_per_um") {
                1e6
            } else {
                1.0
            };
            let name = match run.level {
                Some(_) => name.replace(&level, ""),
                None => name,
            };
            Some((name, unit * text.parse::<f64>().ok()?))
        });
        Ok(row.chain(stand_in.into_iter().flatten()).collect())
    })
    .collect()
}

/// Columns of a bearing of GMN's by its name in the catalogue.
fn gmn(name: &str) -> anyhow::Result<[(String, f64); 3]> {
    let found = catalogue::gmn_s60()
        .into_iter()
        .find(|one| one.name() == name);
    let found = found.with_context(|| format!("no bearing {name}"))?;
    let columns = [
        ("balls", found.balls as f64),
        ("ball_mm", found.ball_mm),
        ("pitch_mm", found.pitch_mm),
    ];
    Ok(columns.map(|(column, value)| (column.to_owned(), value)))
}

fn combinations(mut cases: Vec<Case>, values: &BTreeMap<String, Values>) -> Vec<Case> {
    for (column, values) in values {
        let values = values.list();
        let with = |value: &f64| {
            let case = |case: &Case| {
                let mut case = case.clone();
                case.insert(column.clone(), *value);
                case
            };
            cases.iter().map(case).collect::<Vec<_>>()
        };
        cases = values.iter().flat_map(with).collect();
    }
    cases
}

/// A case with its equilibrium, or one case for each ball of it.
fn of_bearing(run: &Run, case: Case) -> anyhow::Result<Vec<Case>> {
    let (design, balls, rating) = bearing(run, &case)?;
    let value = |column: &str| case.get(column).copied();
    let load = ["fx_n", "fy_n", "fz_n", "my_nm", "mz_nm"].map(|c| value(c).unwrap_or(0.0));
    let omega = rad_per_s(value("speed_rpm").unwrap_or(0.0));
    let variant: Option<fn(Reference) -> Reference> = match run.by {
        Program::Solver | Program::SolverAtRest => None,
        Program::FittedContacts => Some(Reference::with_fitted_contacts),
        Program::WrongSign => Some(Reference::with_gyroscopic_moment_reversed),
        Program::NoFrictionMoment => Some(Reference::without_friction_moment),
    };
    if let Some(variant) = variant {
        let found = variant(reference(&design, balls))
            .solve(&Task::new(load, omega, run.attitude))
            .context("no equilibrium of the reference build")?;
        let case = with_equilibrium(case, found.displacement, found.stiffness);
        let ball = &found.balls[0];
        let angles = [ball.azimuth, ball.alpha_i, ball.alpha_o];
        return Ok(vec![with_ball(case, angles, [ball.q_i, ball.q_o])]);
    }

    let plan = plan(run, &case, design, balls);
    let last = plan.rows.last().map_or(0.0, |row| row.position);
    let question = Question {
        ends: beams::ends(&case),
        ..Question::load(load, omega)
    };
    let motion = match run.by {
        Program::SolverAtRest => Balls::Static,
        _ => run.attitude.into(),
    };
    let answer = with_solver(&plan, motion, Precision::F64, |solver| {
        solver.solve(&question)
    })?
    .map_err(|status| anyhow!("{load:?} N, N m, {omega} rad/s: {status}"))?;
    let case = beams::with_nose(case, &answer, last);

    let mut case = with_equilibrium(case, answer.displacement, answer.stiffness);
    let side: f64 = answer.rows.iter().map(|row| 0.5 * row.preload).sum();
    case = with(case, ["side_n"], [side]);
    if let Some(makers) = case.get("axial_n_per_um") {
        let ratio = case["k_x_x"] / makers;
        case = with(case, ["axial_over_makers"], [ratio]);
    }
    let balls = &answer.rows.first().context("a set without rows")?.balls;
    if let Some(rating) = rating {
        let weight = rating.weight_of(balls.iter().map(|ball| (ball.q_i, ball.q_o)));
        let life = RatingLife::of_weight(weight, omega);
        case = with(case, ["l10_mrev"], [life.million_revolutions]);
    }
    let of_ball = balls.iter().map(|ball| {
        let angles = [ball.azimuth, ball.alpha_i, ball.alpha_o];
        with_ball(case.clone(), angles, [ball.q_i, ball.q_o])
    });
    let wanted = if run.each_ball { balls.len() } else { 1 };
    Ok(of_ball.take(wanted).collect())
}

/// The spindle of a case.
fn plan(run: &Run, case: &Case, design: Design, balls: usize) -> Plan {
    let facings = run.facings.as_deref().unwrap_or("+");
    let position = |i: usize| match run.positions_mm.get(i) {
        Some(mm) => 1e-3 * mm,
        None => design.pitch_diameter * i as f64,
    };
    let preload = case.get("preload_n").copied();
    let row = |(i, facing): (usize, char)| Row {
        balls,
        design,
        position: position(i),
        facing: match facing {
            '-' => Facing::MinusX,
            _ => Facing::PlusX,
        },
        preload: preload.map_or(Preload::Closure(0.0), Preload::Force),
    };
    Plan {
        shaft: beams::shaft(case, facings.len(), position(facings.len() - 1)),
        ..Plan::of(facings.chars().enumerate().map(row).collect())
    }
}

/// Design, number of balls and load rating of a case.
fn bearing(run: &Run, case: &Case) -> anyhow::Result<(Design, usize, Option<LifeRating<f64>>)> {
    let needed = |column: &str| {
        let value = case.get(column).copied();
        value.with_context(|| format!("no column {column}"))
    };
    if run.bearing.is_empty() {
        let angle = needed("contact_angle_deg")?.to_radians();
        let [ball, pitch] = [1e-3 * needed("ball_mm")?, 1e-3 * needed("pitch_mm")?];
        let mut design = Design::angular_contact(ball, pitch, angle);
        if let Ok(factor) = needed("groove_factor") {
            design.inner_groove_factor = factor;
            design.outer_groove_factor = factor;
        }
        return Ok((design, needed("balls")? as usize, None));
    }
    let in_file = || DesignFile::read(format!("{}/{}", env!("CARGO_MANIFEST_DIR"), run.bearing));
    let file = catalogue::find(&run.bearing).unwrap_or_else(in_file)?;
    let mut design = file.design;
    if let Ok(clearance) = needed("diametral_clearance_um") {
        design.free_contact = FreeContact::DiametralClearance(1e-6 * clearance);
    }
    if let Ok(first) = needed("first_ball_deg") {
        design.first_ball = first.to_radians();
    }
    let rating = file.dynamic_load_rating.map(|_| file.rating());
    Ok((design, file.balls, rating))
}

fn with_equilibrium(case: Case, u: [f64; 5], k: [[f64; 5]; 5]) -> Case {
    let case = with(case, ["dx_m", "dy_m", "dz_m", "ty_rad", "tz_rad"], u);
    with_matrix(case, "k", k)
}

/// SpindleCAD's lathe spindle with its third row at `third_row_mm`: stiffness at the nose (`x = 0`).
fn of_spindle_cad(case: Case) -> anyhow::Result<Case> {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/makers/spindlecad.toml");
    let mut plan = SpindleFile::read(file)?.plan;
    plan.rows[2].position = 1e-3 * case["third_row_mm"];
    let shaft = plan.shaft.clone().context("the spindle has no shaft")?;
    let beam = |with_shear| {
        let stiffness = [226.3e6, 226.3e6, 226.3e6, 2170e6];
        let springs = plan.rows.iter().map(|row| row.position).zip(stiffness);
        beams::nose_on_springs(&shaft, &springs.collect::<Vec<_>>(), with_shear)
    };
    let beams = [false, true].map(beam);
    let nose = |plan: &Plan| {
        let answer = with_solver(plan, Balls::Static, Precision::F64, |solver| {
            solver.load([0.0; 5], 0.0)
        })?;
        let answer = answer.map_err(|status| anyhow!("SpindleCAD's spindle: {status}"))?;
        anyhow::Ok(1.0 / answer.at[0].compliance[1][1])
    };
    let elastic = nose(&plan)?;
    if let Some(shaft) = &mut plan.shaft {
        shaft.sections.clear();
    }
    let case = with(case, ["bending_n_per_m", "timoshenko_n_per_m"], beams);
    let ours = [nose(&plan)?, elastic];
    Ok(with(case, ["rigid_n_per_m", "elastic_n_per_m"], ours))
}

/// A pair of FAG's, with the axial load at which a row of ours lifts off.
fn of_fag(run: &Run, case: Case) -> anyhow::Result<Vec<Case>> {
    let (design, balls, _) = bearing(run, &case)?;
    let plan = plan(run, &case, design, balls);
    // Bisection: 30 halvings leave 1e-8 of the preload.
    let [mut held, mut lifted] = [1.0, 8.0].map(|times| times * case["preload_n"]);
    with_solver(&plan, Balls::Static, Precision::F64, |solver| {
        for _ in 0..30 {
            let load = 0.5 * (held + lifted);
            let answer = solver.load([load, 0.0, 0.0, 0.0, 0.0], 0.0);
            let answer = answer.map_err(|status| anyhow!("{load} N: {status}"))?;
            match answer.rows.iter().all(|row| row.preload > 0.0) {
                true => held = load,
                false => lifted = load,
            }
        }
        anyhow::Ok(())
    })??;
    of_bearing(run, with(case, ["our_unloading_n"], [lifted]))
}

fn with_ball(case: Case, [azimuth, inner, outer]: [f64; 3], [q_i, q_o]: [f64; 2]) -> Case {
    let columns = [
        "azimuth_rad",
        "alpha_i_rad",
        "alpha_o_rad",
        "q_i_n",
        "q_o_n",
    ];
    let values = [azimuth.rem_euclid(TAU), inner, outer, q_i, q_o];
    with(case, columns, values)
}

fn with_integrals(case: Case) -> Case {
    let (k, e) = elliptic_integrals(case["m"]);
    with(case, ["our_k", "our_e"], [k, e])
}

fn with_contact(case: Case) -> Case {
    let contact = HertzContact::new(case["rolling"], case["across"], 1.0);
    let columns = ["our_kappa", "our_e", "our_load_deflection"];
    let HertzContact {
        ellipticity,
        elliptic_e,
        load_deflection,
        ..
    } = contact;
    with(case, columns, [ellipticity, elliptic_e, load_deflection])
}

/// Steel contact of the relative curvatures `(1 + excess/2) / r` and `(1 - excess/2) / r`, and spheres of that radius
/// (Johnson, Contact Mechanics, 1985, 4.2).
fn of_spheres(case: Case) -> Case {
    let (r, half) = (case["radius_m"], 0.5 * case["excess"]);
    let Material {
        youngs_modulus,
        poissons_ratio,
        ..
    } = Material::STEEL;
    let modulus = youngs_modulus / (2.0 * (1.0 - poissons_ratio * poissons_ratio));
    let contact = HertzContact::new((1.0 + half) / r, (1.0 - half) / r, 1.0 / modulus);
    let mean_radius = (contact.semi_major * contact.semi_minor).sqrt();
    let ours = [
        contact.load_deflection,
        mean_radius,
        contact.peak_pressure(1000.0),
    ];
    let pressed = 6.0 * 1000.0 * modulus * modulus / (PI.powi(3) * r * r);
    let spheres = [
        4.0 / 3.0 * modulus * r.sqrt(),
        (3.0 * r / (4.0 * modulus)).cbrt(),
        pressed.cbrt(),
    ];
    let columns = ["our_load_deflection", "our_radius", "our_pressure"];
    let case = with(case, columns, ours);
    with(case, ["load_deflection", "radius", "pressure"], spheres)
}

/// Ellipticity, integrals and load-deflection constant for a ratio of curvatures, and the fits of Brewe and Hamrock,
/// J. Lubr. Technol. 99 (1977).
fn of_fits(case: Case) -> Case {
    let ratio = case["ratio"];
    let kappa = HertzContact::new(ratio, 1.0, 1.0).ellipticity;
    let (k, e) = elliptic_integrals(1.0 - 1.0 / (kappa * kappa));
    let constants = |kappa: f64, e: f64, k: f64| [kappa, e, k, kappa * (e / k.powi(3)).sqrt()];
    let exact = constants(kappa, e, k);
    let fitted = constants(
        1.0339 * ratio.powf(0.636),
        1.0003 + 0.5968 / ratio,
        1.5277 + 0.6023 * ratio.ln(),
    );
    let case = with(case, ["kappa", "e", "k", "load_deflection"], exact);
    let columns = ["fit_kappa", "fit_e", "fit_k", "fit_load_deflection"];
    with(case, columns, fitted)
}

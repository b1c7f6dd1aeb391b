//! Spindles that are warm: rings, balls, and the length of shaft and housing.

use super::solves::{self, Answer, Balls, Question, ask};
use cli::telemetry::simulated::MONITOR;
use judge::compare::stiffness_error;
use solvers::dispatch::Precision;
use spindle_bearing::{Expansion, Growth, Speed};
use spindle_file::designs::SHIPPED;
use spindle_file::loads::LoadRow;
use spindle_file::spindles::SpindleFile;
use spindle_firmware::spindle;
use std::path::Path;

const LOAD: [f64; 5] = [60.0, 150.0, -40.0, 0.5, 1.0];

/// Rows of 7014C by position (mm), facing and further keys, with heat.
fn text(top: &str, rows: &[(f64, &str, &str)]) -> String {
    let mut text = format!("name = \"s\"\n{top}");
    for (x, facing, more) in rows {
        text += &format!(
            "[[row]]\nbearing = \"7014c.toml\"\nposition_mm = {x}\nfacing = \"{facing}\"\n{more}"
        );
    }
    text + "[heat]\nreference_c = 20\n"
}

fn parsed(text: &str) -> SpindleFile {
    SpindleFile::parse("s.toml", text, Path::new(SHIPPED)).unwrap()
}

fn at(load: [f64; 5], speed_rpm: f64, temperatures: [f64; 2]) -> LoadRow {
    LoadRow {
        time_s: 0.0,
        load,
        speed_rpm,
        temperatures: Some(temperatures),
        probes: [None; 4],
    }
}

fn solved(file: &SpindleFile, row: &LoadRow) -> Answer {
    ask(&file.plan, Balls::Free, Precision::F64, &file.question(row)).unwrap()
}

/// Shaft side 20 K warmer, 200 mm between the rows: figures of the model page.
#[test]
fn a_warm_shaft_unloads_a_pair_back_to_back_and_loads_one_face_to_face() {
    for (facings, preload) in [(["+x", "-x"], 976.7), (["-x", "+x"], 6286.6)] {
        let [first, second] = facings;
        let file = parsed(&text(
            "preload_n = 294\n",
            &[(0.0, first, ""), (200.0, second, "")],
        ));
        let answer = solved(&file, &at([0.0; 5], 0.0, [40.0, 20.0]));
        for row in &answer.rows {
            assert!(
                (row.preload / preload - 1.0).abs() < 1e-4,
                "{}",
                row.preload
            );
        }
    }
}

/// Rows, loads and nose further along the axis: lengths count from further away.
#[test]
fn the_point_that_lengths_are_counted_from_moves_the_axial_displacement_alone() {
    let at_distance = |mm: f64| {
        let rows = [
            (mm, "+x", ""),
            (mm + 30.0, "+x", ""),
            (mm + 200.0, "-x", ""),
        ];
        let top = "preload_n = 294\n";
        let file = text(top, &rows) + "shaft_per_k = 12e-6\nhousing_per_k = 23e-6\n";
        let file = file
            + &format!(
                "[load]\nposition_mm = {mm}\n[nose]\nposition_mm = {}\n",
                mm - 60.0
            );
        solved(&parsed(&file), &at(LOAD, 9000.0, [45.0, 35.0]))
    };
    let [near, far] = [0.0, 3000.0].map(at_distance);
    let grown = 3.0 * (12e-6 * 25.0 - 23e-6 * 15.0);
    let (a, b) = (&near.at[0], &far.at[0]);
    let moved = b.displacement[0] - a.displacement[0];
    assert!((moved / -grown - 1.0).abs() < 1e-9, "{moved:e} {grown:e}");
    for i in 1..5 {
        let off = (b.displacement[i] - a.displacement[i]).abs();
        assert!(off < 1e-9 * a.displacement[1].abs(), "{i}: {off:e}");
    }
    let of_stiffness = stiffness_error(&b.stiffness, &a.stiffness);
    assert!(of_stiffness < 1e-8, "{of_stiffness:e}");
    for (a, b) in near.rows.iter().zip(&far.rows) {
        assert!((b.preload / a.preload - 1.0).abs() < 1e-10);
        let moved = b.displacement[0] - a.displacement[0];
        assert!((moved / -grown - 1.0).abs() < 1e-9, "{moved:e}");
    }
}

/// A displacement that is given counts from x = 0, too.
#[test]
fn a_displacement_that_was_the_answer_can_be_given() {
    let file = parsed(&text(
        "preload_n = 294\n",
        &[(500.0, "+x", ""), (700.0, "-x", "")],
    ));
    let row = at([300.0, 0.0, 0.0, 0.0, 0.0], 0.0, [40.0, 20.0]);
    let free = solved(&file, &row);
    let mut question = file.question(&row);
    question.held[0] = Some(free.displacement[0]);
    let given = ask(&file.plan, Balls::Static, Precision::F64, &question).unwrap();
    assert!(
        (given.load[0] / 300.0 - 1.0).abs() < 1e-9,
        "{}",
        given.load[0]
    );
    assert_eq!(given.displacement[0], free.displacement[0]);
}

/// The spring keeps its force, and the rows that it pushes share it by the length between them.
#[test]
fn two_sprung_rows_share_the_force_of_their_spring_by_the_length_between_them() {
    let spring = "spring = true\n";
    let rows = [
        (0.0, "+x", ""),
        (200.0, "-x", spring),
        (230.0, "-x", spring),
    ];
    let file = text("", &rows).replace("7014c", "b7005c") + "[spring]\nforce_n = 300\n";
    let file = parsed(&file);
    let row = at([0.0; 5], 0.0, [35.0, 20.0]);
    let [_, a, b] = <[_; 3]>::try_from(solved(&file, &row).rows).unwrap();
    assert!(((a.force[0] + b.force[0]) / 300.0 - 1.0).abs() < 1e-10);
    // The shaft's end goes on in +x, away from the balls of a row that faces -x.
    assert!(
        a.force[0] > b.force[0] + 20.0,
        "{:?} {:?}",
        a.force,
        b.force
    );
    let design = &file.plan.rows[1].design;
    let rings = Growth::by_heat(design, &Expansion::STEEL, [15.0, 0.0, 7.5]);
    let mut alone = solves::solver(design, 16, Precision::F64, Balls::Static);
    let [at_a, at_b] = [a, b].map(|row| {
        let load = [row.force[0], 0.0, 0.0, 0.0, 0.0];
        alone
            .answer(&Question::load(load, 0.0).grown(rings))
            .displacement[0]
    });
    let length = 0.03 * 11.5e-6 * 15.0;
    assert!(
        ((at_a - at_b) / length - 1.0).abs() < 1e-8,
        "{:e}",
        at_a - at_b
    );
}

#[test]
fn the_firmware_s_rows_grow_as_those_of_a_file_do() {
    let text = "name = \"s\"\n\
        [[row]]\nbearing = \"b7005c.toml\"\nposition_mm = 30\nfacing = \"+x\"\n\
        [[row]]\nbearing = \"b7005c.toml\"\nposition_mm = 130\nfacing = \"-x\"\n\
        [shaft]\nbore_mm = 10\n[heat]\nreference_c = 20\n";
    let (rpm, [inner, outer]) = (14_000.0, [41.0, 33.0]);
    let question = parsed(text).question(&at([0.0; 5], rpm, [inner, outer]));
    assert_eq!(spindle::ROWS, 2);
    let omega = Speed::rpm(rpm).as_rad_per_s() as f32;
    let warmer = [inner, outer].map(|t| (t - 20.0) as f32);
    for (row, growth) in MONITOR.rows.iter().zip(&question.growth) {
        let [per_inner, per_outer] = row.heat;
        let found = row.rotation * (omega * omega) + per_inner * warmer[0] + per_outer * warmer[1];
        let figures = [
            (found.axial, growth.axial),
            (found.radial, growth.radial),
            (found.ball, growth.ball),
        ];
        for (found, growth) in figures {
            assert!(growth.abs() > 1e-7);
            assert!(
                (f64::from(found) / growth - 1.0).abs() < 1e-6,
                "{found:e} {growth:e}"
            );
        }
    }
}

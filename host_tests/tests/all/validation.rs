//! The validation book: every statement of `docs/validation.md` holds, and all its figures are there.

use host_tests::cases::{self, B218, rad_per_s};
use host_tests::dispatch::Attitude;
use host_tests::reference;
use host_tests::validation::statement::{Statement, Verdict};
use host_tests::validation::{self, Chapter, FIGURES, PAGE, gyroscope, page, rules};
use spindle_bearing::BallState;
use std::collections::BTreeSet;
use std::path::Path;
use std::sync::LazyLock;

static BOOK: LazyLock<Vec<Chapter>> =
    LazyLock::new(|| validation::book(&()).unwrap_or_else(|e| panic!("{e:#}")));

fn chapter(title: &str) -> &'static Chapter {
    BOOK.iter()
        .find(|c| c.title.contains(title))
        .unwrap_or_else(|| panic!("no chapter about {title:?}"))
}

fn assert_holds(title: &str) {
    let statements: Vec<&Statement> = chapter(title).statements().collect();
    assert!(!statements.is_empty(), "{title}: nothing stated");
    let complaints: Vec<String> = statements.iter().filter_map(|s| s.complaint()).collect();
    assert!(complaints.is_empty(), "\n{}", complaints.join("\n"));
}

#[test]
fn contact_angles_and_forces_around_the_bearing_are_as_stated() {
    assert_holds("around the bearing");
}

#[test]
fn stiffness_against_speed_is_as_stated() {
    assert_holds("Stiffness against speed");
}

#[test]
fn the_218_under_axial_load_is_as_stated() {
    assert_holds("under axial load");
}

#[test]
fn the_6205_with_clearance_is_as_stated() {
    assert_holds("Clearance");
}

#[test]
fn the_study_solver_is_as_stated() {
    assert_holds("study's solver");
}

#[test]
fn comparisons_with_others_are_as_stated() {
    assert_holds("Against others");
}

#[test]
fn the_gyroscopic_moment_is_as_stated() {
    assert_holds("gyroscopic moment, by");
}

#[test]
fn the_frozen_tangent_is_as_stated() {
    assert_holds("Frozen");
}

#[test]
fn contact_constants_are_as_stated() {
    assert_holds("Contact constants");
}

#[test]
fn makers_figures_are_as_stated() {
    assert_holds("Makers");
}

#[test]
fn every_item_of_the_study_is_on_the_page() {
    let sources: BTreeSet<&str> = BOOK
        .iter()
        .flat_map(Chapter::statements)
        .filter_map(|s| s.source)
        .collect();
    let items: BTreeSet<&str> = [
        "item 1", "item 2", "item 3", "item 4", "item 5", "item 6", "item 7",
    ]
    .into();
    assert_eq!(sources, items);
}

#[test]
fn a_claim_that_does_not_hold_says_what_does() {
    for s in BOOK.iter().flat_map(Chapter::statements) {
        assert_eq!(s.verdict != Verdict::Holds, s.remark.is_some(), "{s:?}");
    }
}

/// Their content is the program's to make: what they say is tested above.
#[test]
fn the_page_has_every_chapter_and_figure_and_no_other() {
    let again = "; run `cargo reports validation`";
    let committed = std::fs::read_to_string(PAGE).unwrap_or_else(|e| panic!("{PAGE}: {e}{again}"));
    for page in [&committed, &page::page(&BOOK)] {
        for chapter in BOOK.iter() {
            let heading = format!("\n## {}\n", chapter.title);
            assert!(page.contains(&heading), "{PAGE}: no {heading:?}{again}");
        }
        for figure in BOOK.iter().flat_map(Chapter::figures) {
            let link = format!("(validation/{}.svg)", figure.name);
            assert_eq!(page.matches(&link).count(), 1, "{PAGE}: {link}{again}");
        }
    }
    let mut names = BTreeSet::new();
    for figure in BOOK.iter().flat_map(Chapter::figures) {
        let name = format!("{}.svg", figure.name);
        assert!(Path::new(FIGURES).join(&name).is_file(), "{name}{again}");
        assert!(names.insert(name.clone()), "two figures are called {name}");
    }
    for file in std::fs::read_dir(FIGURES).unwrap() {
        let name = file.unwrap().file_name().into_string().unwrap();
        assert!(names.contains(&name), "{name} is on no page; remove it");
    }
}

// ---------------------------------------------------------------------------------------------
// The checks can fail

#[test]
fn the_table_is_not_reproduced_by_another_rule() {
    for attitude in [Attitude::Raceless, Attitude::Inner] {
        let rows = rules::rows_of_table(attitude, &()).unwrap();
        let rows: Vec<_> = rows.into_iter().map(|(row, _)| row).collect();
        assert!(!rules::reproduces_the_table(&rows).holds(), "{attitude:?}");
    }
}

/// A ball as a program with the wrong sign of the gyroscopic moment has it.
fn ball_with_the_wrong_sign(rpm: f64) -> BallState<f64> {
    let solution = cases::reference(&B218, 16)
        .with_gyroscopic_moment_reversed()
        .search(
            [17_800.0, 0.0, 0.0, 0.0, 0.0],
            rad_per_s(rpm),
            reference::Attitude::Outer,
        )
        .unwrap();
    let b = &solution.balls[0];
    BallState {
        azimuth: 0.0,
        alpha_i: b.alpha_i,
        alpha_o: b.alpha_o,
        q_i: b.q_i,
        q_o: b.q_o,
        delta_i: b.delta_i,
        delta_o: b.delta_o,
        centrifugal_force: b.fc,
        gyroscopic_moment: b.mg,
    }
}

#[test]
fn the_integration_tells_a_gyroscopic_moment_of_the_wrong_sign() {
    for rpm in [6_000.0, 10_000.0, 15_000.0] {
        let ball = ball_with_the_wrong_sign(rpm);
        let check = gyroscope::Check::of("wrong sign", &B218, Attitude::Outer, rpm, ball);
        // The ball rolls as it should, and needs the couple the other way round.
        let error = check.couple_error();
        assert!((error - 2.0).abs() < 1e-6, "{rpm} rpm: {error}");
        // Its contact forces balance the friction that the program has, not that of the motion.
        let [right, _] = check.motion_error(1.0);
        let [wrong, _] = check.motion_error(-1.0);
        assert!(
            right > 1e-3 && wrong < 1e-7,
            "{rpm} rpm: {right:e}, {wrong:e}"
        );
        assert!(!gyroscope::statements(&[check])[0].holds());
    }
}

//! Inputs of the fuzz targets, without a fuzzer: kept ones, and random ones. A kept one is small, and is there for an end, a motion, a
//! number of rows, a mark, an answer or an alarm that no other one has.

use cli::random::Random;
use judge::laws::{Ends, log, port, spindles};
use rayon::prelude::*;
use spindle_monitor::retained::Recovery;
use std::fs;
use std::panic::{self, AssertUnwindSafe};
use std::path::Path;

/// Replays random inputs of a target. One that breaks a law is written into its corpus.
fn draw(target: &str, runs: u64, replay: impl Fn(&[u8]) -> Ends + Sync) {
    (0..runs).into_par_iter().for_each(|seed| {
        let mut random = Random::seeded(seed);
        let length = random.below(512);
        let input: Vec<u8> = (0..length).map(|_| random.bits() as u8).collect();
        if let Err(cause) = panic::catch_unwind(AssertUnwindSafe(|| replay(&input))) {
            let corpus = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/corpus");
            let path = corpus.join(target).join(format!("random-{seed}"));
            fs::write(&path, &input).unwrap();
            eprintln!("{} breaks a law", path.display());
            panic::resume_unwind(cause);
        }
    });
}

#[test]
fn random_spindles_break_no_law() {
    draw("spindles", 40_000, spindles::replay);
}

#[test]
fn random_bytes_at_the_port_break_no_law() {
    draw("port", 10_000, port::replay);
}

#[test]
fn random_images_of_the_log_break_no_law() {
    draw("log", 40_000, log::replay);
}

/// Replays the kept inputs of a target; all the ways in which their solves ended.
fn replayed(target: &str, replay: impl Fn(&[u8]) -> Ends) -> Ends {
    let corpus = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/corpus");
    let mut ends = Ends::new();
    for input in fs::read_dir(corpus.join(target)).unwrap() {
        let path = input.unwrap().path();
        // The last one printed is the one that fails.
        println!("{}", path.display());
        ends.extend(replay(&fs::read(path).unwrap()));
    }
    ends
}

/// Ends of a solve, in the order of their names.
const ENDS: [&str; 9] = [
    "converged",
    "diverged",
    "indeterminate",
    "iteration-limit",
    "not-finite",
    "out-of-range",
    "precision-limit",
    "unloaded",
    "unseated",
];

#[test]
fn kept_runs_of_a_spindle_break_no_law_and_end_in_every_way() {
    let ends = replayed("spindles", spindles::replay);
    assert_eq!(ends, ENDS.into_iter().chain(["design", "rows"]).collect());
}

#[test]
fn kept_bytes_at_the_port_break_no_law_and_raise_marks_and_alarms() {
    let ends = replayed("port", port::replay);
    let expected = [
        "availability",
        "corrupt",
        "deadline",
        "done",
        "estimate",
        "late",
        "missing",
        "no-estimate",
        "no-such-occurrence",
        "not-at-standstill",
        "not-finite",
        "not-in-service",
        "order",
        "overload",
        "peak-pressure",
        "preload-loss",
        "range",
        "rate",
        "sensor",
        "speed-missing",
        "speed-range",
        "speed-rate",
        "stuck",
        "temperature",
        "unloaded-balls",
    ];
    assert_eq!(ends, expected.into());
}

#[test]
fn kept_images_of_the_log_break_no_law_and_are_recovered_in_every_way() {
    let ends = replayed("log", log::replay);
    let [_, recoveries @ ..] = Recovery::ALL;
    let recoveries = recoveries.into_iter().map(Recovery::name);
    assert_eq!(ends, recoveries.chain(["last-number"]).collect());
}

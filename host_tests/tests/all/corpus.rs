//! Kept inputs of the fuzz targets, without a fuzzer. One is small, and is there for an end, a motion or a number of rows
//! that no other one has.

use laws::{Ends, solves, spindles};
use std::fs;
use std::path::Path;

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
fn kept_runs_of_a_bearing_break_no_law_and_end_in_every_way() {
    let ends = replayed("solves", solves::replay);
    assert_eq!(ends, ENDS.into_iter().chain(["design"]).collect());
}

#[test]
fn kept_runs_of_a_spindle_break_no_law_and_end_in_every_way() {
    let ends = replayed("spindles", spindles::replay);
    assert_eq!(ends, ENDS.into_iter().chain(["design", "rows"]).collect());
}

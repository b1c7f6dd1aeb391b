//! `cargo replay --sensitivity`, against files with another closure, another spring or another temperature.

use crate::replay::{replayed, scratch};

/// Figures by the name of their change, of this spindle with more options.
fn figures(name: &str, text: &str, more: &[&str]) -> Vec<(String, Vec<f64>)> {
    let path = scratch(name);
    std::fs::write(&path, text).unwrap();
    let args: Vec<&str> = [path.to_str().unwrap(), "--sensitivity"]
        .into_iter()
        .chain(more.iter().copied())
        .collect();
    let (status, out, err) = replayed(&args, "");
    assert_eq!(status, 0, "{err}");
    let lines = out.lines().skip(1).map(|line| {
        let (name, figures) = line.split_once(',').unwrap();
        let figures = figures.split(',').map(|x| x.parse().unwrap());
        (name.to_owned(), figures.collect())
    });
    lines.collect()
}

const LOADS: [&str; 6] = ["--fx", "40", "--fy", "120", "--speed", "9000"];

/// Two rows, the second one face to face with the first, or under a spring.
fn spindle(second: &str, closure: f64) -> String {
    format!(
        "name = \"s\"\n[heat]\nreference_c = 20\n[nose]\nposition_mm = -40\n[[row]]\nbearing = \"gmn:S6005C\"\nposition_mm = 0\n\
         facing = \"+x\"\npreload_offset_um = {closure}\nsupport = {{ axial_n_per_um = 300, radial_n_per_um = 300 }}\n[[row]]\n\
         bearing = \"gmn:S6005C\"\nposition_mm = 90\nfacing = \"-x\"\n{second}\n"
    )
}

/// The change of all figures by this step, of the first lines of both.
fn difference(low: &[(String, Vec<f64>)], high: &[(String, Vec<f64>)], step: f64) -> Vec<f64> {
    let pairs = low[0].1.iter().zip(&high[0].1);
    pairs.map(|(low, high)| (high - low) / step).collect()
}

/// Preloads of both rows and displacements, each to half a percent of the largest one of its kind.
fn assert_like(found: &[f64], truth: &[f64], name: &str) {
    let largest = |all: &[f64]| all.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    let sizes = [largest(&truth[..2]), largest(&truth[2..])];
    for (i, (found, truth)) in found.iter().zip(truth).enumerate() {
        let size = sizes[usize::from(i >= 2)];
        assert!(
            (found - truth).abs() < 5e-3 * size,
            "{name}: {found}, not {truth}"
        );
    }
}

#[test]
fn a_micrometre_and_a_kelvin_do_what_the_table_says() {
    let second = "preload_offset_um = 9";
    let at = |closure: f64, more: &[&str]| {
        let more: Vec<&str> = LOADS.iter().chain(more).copied().collect();
        figures("closed.toml", &spindle(second, closure), &more)
    };
    let middle = at(9.0, &[]);
    let names: Vec<&str> = middle.iter().map(|(name, _)| name.as_str()).collect();
    let expected = [
        "as it is",
        "1 K at the inner side",
        "1 K at the outer side",
        "1 um of closure of row 0",
        "1 um of closure of row 1",
    ];
    assert_eq!(names, expected);
    let truth = difference(&at(8.9, &[]), &at(9.1, &[]), 0.2);
    assert_like(&middle[3].1, &truth, "closure");
    let [cold, warm] = ["19.5", "20.5"].map(|t| at(9.0, &["--t_inner", t]));
    assert_like(&middle[1].1, &difference(&cold, &warm, 1.0), "heat");
}

#[test]
fn a_newton_of_spring_does_what_the_table_says() {
    let at = |force: &str| {
        let second = format!("spring = true\n[spring]\nforce_n = {force}");
        figures("sprung.toml", &spindle(&second, 0.0), &LOADS)
    };
    let (name, found) = at("200").pop().unwrap();
    assert_eq!(name, "1 N of spring");
    assert_like(&found, &difference(&at("199"), &at("201"), 2.0), &name);
}

#[test]
fn a_table_of_changes_has_no_recording() {
    let text = spindle("preload_offset_um = 9", 9.0);
    let path = scratch("alone.toml");
    std::fs::write(&path, text).unwrap();
    let (status, _, err) = replayed(&[path.to_str().unwrap(), "-", "--sensitivity"], "");
    assert!(status == 2 && err.contains("cannot be used with"), "{err}");
}

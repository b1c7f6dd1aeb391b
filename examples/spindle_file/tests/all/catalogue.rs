//! Bearings by name.

use spindle_file::catalogue::{find, gmn_s60, list};
use spindle_file::designs::{DesignFile, SHIPPED};
use spindle_file::spindles::SpindleFile;
use std::path::Path;

fn named(name: &str) -> DesignFile {
    match find(name) {
        Some(Ok(file)) => file,
        Some(Err(error)) => panic!("{error}"),
        None => panic!("{name} is no name of a catalogue"),
    }
}

#[test]
fn every_bearing_of_the_catalogue_can_be_built_and_is_listed() {
    let list = list();
    for listed in gmn_s60() {
        let file = named(&listed.name());
        assert_eq!(file.balls, listed.balls);
        file.design.check(file.balls).unwrap();
        assert!(list.contains(&listed.name()), "{}", listed.name());
    }
    for (name, balls) in [
        ("project:b7005c", 16),
        ("project:b7005c-hybrid", 16),
        ("project:7014c", 20),
        ("project:b218", 16),
        ("project:skf6205", 9),
    ] {
        let file = named(name);
        assert_eq!(file.balls, balls);
        file.design.check(balls).unwrap();
        assert!(list.contains(name), "{name}");
    }
    let files = std::fs::read_dir(SHIPPED).unwrap().count();
    assert_eq!(list.matches("\nproject:").count(), files);
}

#[test]
fn capital_letters_and_blanks_make_no_difference() {
    let written = named("gmn:S6014C");
    for name in ["gmn:s6014c", "GMN:S 6014 C", "gmn: s 6014 c"] {
        assert_eq!(named(name).design, written.design);
    }
    let [mm, balls] = [1e3 * written.design.ball_diameter, written.balls as f64];
    assert!((mm - 11.906).abs() < 1e-9 && balls == 21.0);
}

#[test]
fn a_name_that_is_not_there_is_told_with_its_neighbours() {
    for (wrong, right) in [
        ("gmn:S6014", "gmn:S6014C"),
        ("project:7005c", "project:b7005c"),
    ] {
        let Some(Err(error)) = find(wrong) else {
            panic!("{wrong} has been found");
        };
        let told = error.to_string();
        assert!(told.starts_with(wrong) && told.contains(right), "{told}");
        assert!(told.contains("cargo replay --list"), "{told}");
    }
    assert!(find("b7005c.toml").is_none() && find("").is_none());
}

#[test]
fn rows_of_a_spindle_may_name_bearings_of_the_catalogue() {
    let text = |bearing: &str| {
        format!(
            "name = \"pair\"\npreload_n = 240\n[[row]]\nbearing = \"{bearing}\"\nposition_mm = 0\nfacing = \"+x\"\n\
             [[row]]\nbearing = \"{bearing}\"\nposition_mm = 27\nfacing = \"-x\"\n"
        )
    };
    let folder = Path::new("nowhere");
    let file = SpindleFile::parse("pair.toml", &text("gmn:S6014C"), folder).unwrap();
    assert_eq!(file.plan.rows[1].balls, 21);
    let error = SpindleFile::parse("pair.toml", &text("gmn:S6014D"), folder).unwrap_err();
    assert!(error.to_string().contains("gmn:S6014C"), "{error}");
}

#[test]
fn a_spindle_is_made_of_texts_alone() {
    let text =
        "name = \"one\"\n[[row]]\nbearing = \"own.toml\"\nposition_mm = 0\nfacing = \"+x\"\n";
    let own = std::fs::read_to_string(format!("{SHIPPED}/7014c.toml")).unwrap();
    let mut asked = Vec::new();
    let mut read = |name: &str| {
        asked.push(name.to_owned());
        Ok(("memory".to_owned(), own.clone()))
    };
    let file = SpindleFile::of("one.toml", text, &mut read).unwrap();
    assert_eq!(file.designs()[0].design, named("project:7014c").design);
    let alone = SpindleFile::of("own.toml", &own, &mut read).unwrap();
    assert!(alone.is_bearing && asked == ["own.toml"]);
}

//! Pages that are written by hand: their figures are those that were measured, and the tests that they name are there.

use judge::cases::B7005C;
use spindle_bearing::{
    Arrangement, Bearing, Facing, Material, Mounted, Preload, Settings, Shaft, Speed, Support,
};
use spindle_file::mounting::{DynSolver, DynSpindle};
use spindle_file::plan::MOST_BALLS;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

const GUIDE: &str = include_str!("../../../../docs/guide.md");
const FRONT: &str = include_str!("../../../../docs/crate.md");
const SAFETY: &str = include_str!("../../../../docs/safety.md");
const RTIC: &str = include_str!("../../../../examples/rtic/main.rs");
const FIGURES: &str = include_str!("../../../../docs/report_figures.json");

/// Cells of the row of a page's table that begins with this one.
fn row<'p>(page: &'p str, first: &str) -> Vec<&'p str> {
    let start = format!("| {first} | ");
    let line = page.lines().find_map(|line| line.strip_prefix(&start));
    line.unwrap_or_else(|| panic!("no row {first}"))
        .trim_end_matches(" |")
        .split(" | ")
        .collect()
}

/// Figures of the row that begins with this cell.
fn figures(page: &str, first: &str) -> Vec<f64> {
    let figure = |cell: &str| cell.replace(',', "").parse().unwrap();
    row(page, first).into_iter().map(figure).collect()
}

/// Figures of the pages are rounded.
fn assert_measured(found: &[f64], measured: &[f64], what: &str) {
    assert_eq!(found.len(), measured.len(), "{what}");
    for (found, measured) in found.iter().zip(measured) {
        let error = (found / measured - 1.0).abs();
        assert!(error < 0.02, "{what}: {found}, measured {measured}");
    }
}

#[test]
fn costs_in_the_docs_of_the_crate_are_those_that_were_measured() {
    let measured: BTreeMap<String, f64> = serde_json::from_str(FIGURES).unwrap();
    let of = |scene: &str, what: &str| measured[&format!("Cortex-M4F, f32, {scene}: {what}")];
    const TICK: &str = "warm tick, cycles, median";
    for (rows, scene) in [
        ("one row", "full"),
        ("two rows", "pair"),
        ("two rows, one under a spring", "sprung-pair"),
        ("four rows", "four-rows"),
        ("two rows on an elastic shaft", "elastic-pair"),
        ("four rows on an elastic shaft", "elastic-four-rows"),
    ] {
        let solves = [TICK, "warm, cycles, median", "cold, cycles, median"];
        let solves = solves.map(|what| of(scene, what));
        assert_measured(&figures(GUIDE, rows), &solves, rows);
    }
    for (rows, scene) in [
        ("one", "full"),
        ("two", "pair"),
        ("four", "four-rows"),
        ("two on an elastic shaft and supports", "elastic-pair"),
        ("four on an elastic shaft and supports", "elastic-four-rows"),
    ] {
        let costs = [TICK, "flash", "state", "stack"].map(|what| of(scene, what));
        assert_measured(&figures(FRONT, rows), &costs, rows);
    }
}

/// The tick of the application for RTIC takes its solve and the margins of both rows, and a third more.
#[test]
fn the_application_for_rtic_has_the_time_for_its_solve() {
    let measured: BTreeMap<String, f64> = serde_json::from_str(FIGURES).unwrap();
    let of =
        |scene: &str| measured[&format!("Cortex-M4F, f32, {scene}: warm tick, cycles, median")];
    let (_, reload) = RTIC.split_once("set_reload(").unwrap();
    let (cycles, _) = reload.split_once(" - 1)").unwrap();
    let cycles: f64 = cycles.replace('_', "").parse().unwrap();
    let margins = of("limits") - of("full");
    let needed = of("pair") + 2.0 * margins;
    assert!(cycles > 4.0 / 3.0 * needed, "{cycles} for {needed}");
}

/// Preload of each row of a rigid shaft, N, at rest and without loads.
fn preloads(rows: &[Mounted<'_, f64, MOST_BALLS>], supports: &[Support<f64>]) -> Vec<String> {
    let shaft = Shaft::<f64, 0>::new(&[], &Material::STEEL).unwrap();
    let spindle = DynSpindle::of_rows(Arrangement::BackToBack, rows, None, &shaft, supports);
    let (spindle, mut solver) = (spindle.unwrap(), DynSolver::<f64>::new());
    let found = solver.solve(&spindle, [0.0; 5], Speed::rpm(0.0), &Settings::default());
    let found = found.unwrap();
    let rows = found.rows().map(|row| format!("{:.0}", row.preload()));
    rows.collect()
}

#[test]
fn preload_by_force_is_as_the_guide_says() {
    let bearing = Bearing::<f64, MOST_BALLS>::with_balls(&B7005C, 15).unwrap();
    let preload = Preload::Force(300.0);
    let row_at = |x, facing| Mounted::new(&bearing, x, facing).with(preload);
    let [front, second] = [0.0, 0.02].map(|x| row_at(x, Facing::PlusX));
    let [rear, last] = [0.12, 0.14].map(|x| row_at(x, Facing::MinusX));
    let said = |first| row(GUIDE, first)[0];
    let pair = [front, rear];

    assert_eq!(said("a pair"), format!("{} N", preloads(&pair, &[])[0]));
    for (axial, what) in [
        (5e8, "a pair, each outer ring held axially by 500 N/um"),
        (1e8, "a pair, each held axially by 100 N/um"),
    ] {
        let housing = Support {
            axial,
            ..Support::RIGID
        };
        let held = preloads(&pair, &[housing; 2]);
        assert_eq!(said(what), format!("{} N", held[0]), "{what}");
    }
    let three = preloads(&[front, second, rear], &[]).join(", ") + " N";
    assert_eq!(said("two rows in tandem against a third (TBT)"), three);
    let four = preloads(&[front, second, rear, last], &[]);
    assert_eq!(
        said("two rows against two (QBC)"),
        format!("{} N each", four[0])
    );
    assert!(four.iter().all(|row| *row == four[0]));
}

/// Sources in a folder, as one text.
fn sources(folder: &Path) -> String {
    let entries = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path());
    let text = entries.map(|path| match path.extension() {
        None if path.is_dir() => sources(&path),
        Some(extension) if extension == "rs" => fs::read_to_string(path).unwrap(),
        _ => String::new(),
    });
    text.collect()
}

#[test]
fn each_test_that_the_page_on_safety_names_is_there() {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folders = [
        "tests/all",
        "../../examples/firmware/tests",
        "../../examples/firmware/twin/src",
        "../../examples/cli/src",
        "../../examples/cli/tests",
        "../../examples/monitor/src",
        "../../examples/monitor/tests",
        "../../examples/spindle_file/tests",
    ];
    let tests = folders.map(|folder| sources(&here.join(folder))).concat();
    let names = SAFETY.split('`').skip(1).step_by(2);
    let names = names.filter(|name| name.matches('_').count() > 3);
    let missing = names
        .clone()
        .filter(|name| !tests.contains(&format!("fn {name}()")));
    assert_eq!(missing.collect::<Vec<_>>(), [""; 0]);
    assert!(names.count() > 20);
}

/// Text files below a folder, but for what is built.
fn texts(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_str().unwrap();
        if path.is_dir() {
            if !matches!(name, "target" | ".git" | "corpus") {
                texts(&path, found);
            }
        } else if [".md", ".rs", ".toml", ".py", ".sh", ".x"]
            .iter()
            .any(|ending| name.ends_with(ending))
            || path
                .parent()
                .is_some_and(|folder| folder.file_name().is_some_and(|name| name == ".ci"))
        {
            found.push(path);
        }
    }
}

/// Words that look like a path, of letters, digits and `_-./`, with a slash; not what is built in `target`.
fn paths(text: &str) -> impl Iterator<Item = &str> {
    let is_of_path = |c: char| c.is_ascii_alphanumeric() || "_-./".contains(c);
    text.split(move |c| !is_of_path(c))
        .map(|word| word.trim_end_matches(['.', '/', '-']))
        .filter(|word| word.contains('/') && !word.split('/').any(|part| part == "target"))
}

/// In every file, paths from the project's folder; in pages, links and names in backticks besides, from the page's folder, too.
#[test]
fn no_path_leads_nowhere() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"))
        .ancestors()
        .nth(2)
        .unwrap();
    let (mut files, mut missing, mut count) = (Vec::new(), Vec::new(), 0);
    texts(root, &mut files);
    for file in &files {
        let text = fs::read_to_string(file).unwrap();
        let here = file.parent().unwrap();
        let from_root = ["docs/", "examples/", "host_tests/", ".ci/", ".cargo/"];
        let named = paths(&text).filter(|word| from_root.iter().any(|top| word.starts_with(top)));
        let mut named: Vec<&str> = named.collect();
        if file.extension().is_some_and(|ending| ending == "md") {
            let links = text
                .split("](")
                .skip(1)
                .filter_map(|rest| rest.split(')').next());
            let links = links.filter(|link| !link.contains(':') && !link.starts_with('#'));
            named.extend(links.map(|link| link.split('#').next().unwrap()));
            let endings = [".rs", ".toml", ".csv", ".json", ".md", ".py", ".x"];
            let quoted = text.split('`').skip(1).step_by(2).flat_map(paths);
            named.extend(quoted.filter(|word| endings.iter().any(|ending| word.ends_with(ending))));
        }
        for name in named {
            count += 1;
            if !root.join(name).exists() && !here.join(name).exists() {
                missing.push(format!(
                    "{}: {name}",
                    file.strip_prefix(root).unwrap().display()
                ));
            }
        }
    }
    assert_eq!(missing, [""; 0]);
    assert!(count > 300, "{count}");
}

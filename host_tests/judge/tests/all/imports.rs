//! Data flows one way: no module imports another one that imports it, be it by way of others. A module that imports its own
//! parts is one with them.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// Reads the modules of a folder, each with the paths that it imports. Every folder of `bin` is a crate.
fn read(folder: &Path, root: &str, parent: &str, modules: &mut BTreeMap<String, Vec<String>>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = match path.file_stem().unwrap().to_str().unwrap() {
            "lib" | "main" | "mod" => parent.to_owned(),
            stem => format!("{parent}::{stem}"),
        };
        if path.is_dir() {
            let is_crate = parent.ends_with("::bin");
            read(&path, if is_crate { &name } else { root }, &name, modules);
            continue;
        }
        let (above, _) = name.rsplit_once("::").unwrap_or_default();
        let text = fs::read_to_string(&path).unwrap();
        let text = text.replace("\npub use ", "\nuse ");
        let paths = modules.entry(name.clone()).or_default();
        for line in text.split("\nuse ").skip(1) {
            let (tree, _) = line.split_once(';').unwrap();
            let tree = tree.replacen("super::", &format!("{above}::"), 1);
            let tree = tree.replacen("crate::", &format!("{root}::"), 1);
            let (start, names) = tree.split_once('{').unwrap_or((&tree, ""));
            let names = names.split([',', '{', '}']);
            paths.extend(names.map(|name| format!("{start}{}::", name.trim())));
        }
    }
}

/// The project's folder.
fn project() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .ancestors()
        .nth(2)
        .unwrap()
}

/// Every package but the library, and the packages of the project that it may use.
const PACKAGES: [(&str, &[&str]); 12] = [
    ("examples/monitor", &["mock", "spindle-bearing"]),
    (
        "examples/monitor/mock",
        &["spindle-bearing", "spindle-monitor"],
    ),
    ("examples/rtic", &["spindle-bearing"]),
    (
        "examples/spindle_file",
        &["solvers", "spindle-bearing", "spindle-monitor"],
    ),
    (
        "examples/spindle_file/solvers",
        &["spindle-bearing", "spindle_file"],
    ),
    (
        "examples/firmware",
        &["mock", "spindle-bearing", "spindle-monitor", "spindle_file"],
    ),
    (
        "examples/firmware/twin",
        &["spindle-bearing", "spindle-monitor", "spindle_firmware"],
    ),
    (
        "examples/cli",
        &[
            "mock",
            "solvers",
            "spindle-bearing",
            "spindle-monitor",
            "spindle_file",
            "spindle_firmware",
            "twin",
        ],
    ),
    ("examples/python", &["cli", "solvers", "spindle_file"]),
    (
        "host_tests/judge",
        &[
            "cli",
            "mock",
            "solvers",
            "spindle-bearing",
            "spindle-monitor",
            "spindle_file",
            "spindle_firmware",
        ],
    ),
    (
        "host_tests/lab",
        &[
            "cli",
            "judge",
            "solvers",
            "spindle-bearing",
            "spindle-monitor",
            "spindle_file",
            "spindle_firmware",
            "twin",
        ],
    ),
    ("host_tests/judge/fuzz", &["judge"]),
];

/// Folders of packages below `folder`.
fn packages(folder: &Path, found: &mut BTreeSet<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.ends_with("Cargo.toml") {
            found.insert(folder.to_owned());
        } else if path.is_dir() && !path.ends_with("target") {
            packages(&path, found);
        }
    }
}

/// Names of the project's packages that a table of a manifest asks for, those of its inner tables, too.
fn asked_for(table: &toml::Table, found: &mut BTreeSet<String>) {
    for (name, value) in table {
        let Some(inner) = value.as_table() else {
            continue;
        };
        if inner.get("path").is_some_and(toml::Value::is_str) && name != "lib" {
            found.insert(name.clone());
        } else {
            asked_for(inner, found);
        }
    }
}

#[test]
fn packages_use_only_those_below_them() {
    let mut found = BTreeSet::new();
    for street in ["examples", "host_tests"] {
        packages(&project().join(street), &mut found);
    }
    let known = PACKAGES.map(|(folder, _)| project().join(folder));
    assert_eq!(found, BTreeSet::from(known));
    for (folder, allowed) in PACKAGES {
        let manifest = fs::read_to_string(project().join(folder).join("Cargo.toml")).unwrap();
        let mut used = BTreeSet::new();
        asked_for(&toml::from_str(&manifest).unwrap(), &mut used);
        let allowed = allowed.iter().map(|name| (*name).to_owned()).collect();
        assert_eq!(used, allowed, "{folder}");
    }
}

/// Layers of the library, from the top: CONTRIBUTING.md draws them.
const LAYERS: [&[&str]; 8] = [
    &["matrices"],
    &["spindle"],
    &["solver"],
    &["results"],
    &["rows"],
    &["ball"],
    &["real", "linalg", "growth"],
    &[
        "bearing",
        "design",
        "hertz",
        "const_math",
        "serialize",
        "sqrt",
        "status",
        "tuning",
    ],
];

/// Layers of the monitor, from the top: what goes out on the wire is made of the domain, which knows nothing of it.
const OF_MONITOR: [&[&str]; 7] = [
    &["reports", "probes"],
    &["outbox"],
    &["telemetry"],
    &["tracker"],
    &["settings", "self_check", "retained"],
    &[
        "watch",
        "life",
        "temperature",
        "plausibility",
        "log",
        "command",
        "response",
        "pairs",
    ],
    &[
        "judgement",
        "loads",
        "record",
        "framing",
        "marks",
        "board",
        "tick",
        "cost",
    ],
];

/// The layer of a module, counted from the top, if it is in one.
fn layer(module: &str) -> Option<usize> {
    let (layers, module) = match module.strip_prefix("monitor::") {
        Some(module) => (&OF_MONITOR[..], module),
        None => (&LAYERS[..], module.strip_prefix("library::")?),
    };
    let name = module.split("::").next()?;
    layers.iter().position(|layer| layer.contains(&name))
}

#[test]
fn imports_do_not_go_round() {
    let mut modules = BTreeMap::new();
    for (folder, root) in [
        ("src", "library"),
        ("examples/monitor/src", "monitor"),
        ("examples/monitor/mock/src", "mock"),
        ("examples/spindle_file/src", "spindle_file"),
        ("examples/spindle_file/solvers/src", "solvers"),
        ("examples/firmware/src", "firmware"),
        ("examples/firmware/twin/src", "twin"),
        ("examples/cli/src", "cli"),
        ("examples/python/src", "python"),
        ("host_tests/judge/src", "judge"),
        ("host_tests/lab/src", "lab"),
    ] {
        read(&project().join(folder), root, root, &mut modules);
    }
    let mut imports = BTreeSet::new();
    for (from, paths) in &modules {
        for path in paths {
            let within = |to: &&String| path.starts_with(&format!("{to}::"));
            let to = modules.keys().filter(within).max_by_key(|to| to.len());
            imports.extend(to.filter(|to| *to != from).map(|to| (from, to)));
        }
    }
    let up = |(from, to): &&(&String, &String)| layer(from) > layer(to) && layer(to).is_some();
    let up: Vec<_> = imports.iter().filter(up).collect();
    assert!(up.is_empty(), "imports go up: {up:#?}");
    // An import is in no circle if its module is not imported, or imports nothing.
    let mut before = usize::MAX;
    while imports.len() < before {
        before = imports.len();
        let (from, to): (BTreeSet<_>, BTreeSet<_>) = imports.iter().copied().unzip();
        imports.retain(|(one, other)| to.contains(one) && from.contains(other));
    }
    assert!(imports.is_empty(), "imports go round: {imports:#?}");
}

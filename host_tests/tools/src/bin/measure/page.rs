//! The page: docs/report.md, and the times of a machine in docs/report_host.md.

use crate::host::Limit;
use crate::image::{Motion, name};
use crate::milling;
use crate::plan::{BALLS, CORES, OTHERS, TOLERANCES, USUAL};
use crate::profile::Part;
use crate::rows::{At, Rows, Start};
use crate::scenes::{self, SCENES, Scene};
use crate::terminal::thousands;
use crate::ticks;
use crate::workload::EVERYDAY_BALLS;
use host_tests::campaign::report::table;
use host_tests::dispatch::Precision;
use spindle_bearing::Real;
use tools::report::FULL;
use tools::timing::{Class, Core};

const LABEL: &str = "modelled, +-15 %, no wait states";

fn cell(value: f64) -> String {
    if value.is_nan() {
        "-".to_owned()
    } else {
        thousands(value)
    }
}

fn error(value: f64) -> String {
    if value.is_nan() {
        "-".to_owned()
    } else {
        format!("{value:.1e}")
    }
}

fn at(core: Option<Core>, precision: Precision, motion: Motion, balls: usize) -> At {
    At {
        core,
        precision,
        motion,
        balls,
        start: None,
    }
}

impl At {
    fn from(self, start: Start) -> Self {
        Self {
            start: Some(start),
            ..self
        }
    }
}

/// The solver that the targets are about.
fn usual(core: Core, precision: Precision) -> At {
    at(Some(core), precision, USUAL, 16)
}

/// The solver on all cores.
pub fn main_table(rows: &Rows) -> String {
    let lines: Vec<Vec<String>> = CORES
        .iter()
        .map(|(core, precision)| {
            let at = usual(*core, *precision);
            let cycles = |start, stat| cell(rows.get(&at.from(start), "cycles", stat));
            let any = at_any(*precision).from(Start::Cold);
            vec![
                format!("{}, {}", core.name(), name(*precision)),
                cycles(Start::Warm, "median"),
                cycles(Start::Cold, "median"),
                cycles(Start::Cold, "99 %"),
                cell(rows.get(&at.from(Start::Cold), "cycles an iteration", "mean")),
                error(rows.get(&any, "stiffness error", "median")),
                error(rows.get(&any, "stiffness error", "99 %")),
                cell(rows.get(&at, "flash", "value")),
                cell(rows.get(&at, "state", "value")),
                cell(rows.get(&at, "worst stack", "value")),
            ]
        })
        .collect();
    table(
        &[
            "core, precision",
            "warm tick",
            "cold",
            "cold, 99 %",
            "an iteration",
            "error of K",
            "99 %",
            "flash / B",
            "state / B",
            "stack / B",
        ],
        &lines,
    )
}

/// The table that the README shows: what users of a Cortex-M4F ask first.
pub fn readme_table(rows: &Rows) -> String {
    let names = ["one bearing", "a pair", "four rows"];
    let mut lines: Vec<Vec<String>> = names
        .iter()
        .zip(scenes::ROWS)
        .filter_map(|(name, (scene, _))| Some((name, scenes::scene(scene)?)))
        .map(|(name, scene)| {
            let get = |what| of_scene(rows, scene, Precision::F32, what);
            let cycles = get(WARM);
            let mut line = vec![(*name).to_owned(), cell(cycles), time(cycles)];
            line.extend([FLASH, STATE, STACK].map(|what| cell(get(what))));
            line
        })
        .collect();
    let tick = ticks::median(rows);
    let mut line = vec![
        "a tick of the monitor of a pair".to_owned(),
        cell(tick),
        time(tick),
    ];
    line.extend([const { String::new() }; 3]);
    lines.push(line);
    table(
        &[
            "warm",
            "cycles",
            "at 168 MHz",
            "flash / B",
            "state / B",
            "stack / B",
        ],
        &lines,
    )
}

/// Of so many cycles at 168 MHz.
fn time(cycles: f64) -> String {
    format!("{:.2} ms", cycles / 168e3)
}

fn at_any(precision: Precision) -> At {
    at(None, precision, USUAL, 16)
}

/// The page, without times of a host.
pub fn page(rows: &Rows, cases: usize) -> String {
    let mut text = format!(
        "<!-- Made by `cargo reports`. -->\n\n# Error against run time\n\n\
         Cycles are **{LABEL}**: instructions counted exactly on an emulated core, times the cycles of \
         `host_tests/tools/src/timing.rs`, which names its sources. Nothing was calibrated on silicon, and the \
         Cortex-M7, whose timings Arm does not publish, is the coarser model of the two. Every point is \
         of {cases} mixed cases: random bearings, loads and speeds, mostly at speed. A warm tick \
         follows a solve with every load 1 % and the speed 0.5 % larger or smaller. The call around a \
         solve is measured by itself and taken off. Errors are against the reference build at 1e-13. \
         Every answer of an emulated core was compared with the host's: they are the same bits.\n\n\
         ## In short\n\n16 balls, five freedoms, raceway control free, default tolerance.\n\n{}\n\
         ![Error of the stiffness over cycles](report_pareto.svg)\n\n",
        main_table(rows)
    );
    text += &costs(rows);
    text += &advice(rows);
    text += &errors(rows);
    text += &limits(rows);
    text += &breakdown(rows);
    text += &others(rows);
    text += &memory(rows);
    text += &scenes(rows);
    text += &ticks::section(rows);
    text += "\n";
    text += &study(rows);
    text += "## Again\n\n`cargo reports` makes this page, its figures and [the times on a host](report_host.md) \
             again; all but the times are the same figures every time. `cargo reports --json FILE` writes \
             every figure as a row. `cargo reports profile` shows one solver function by function. \
             `cargo reports --check` holds instructions and flash to `docs/report_figures.json`, and \
             `cargo reports --accept` takes new ones.\n";
    // Tables end in a line of their own.
    text.replace("\n\n\n", "\n\n")
}

fn advice(rows: &Rows) -> String {
    let cycles =
        |core, precision, start| rows.get(&usual(core, precision).from(start), "cycles", "median");
    let soft = cycles(Core::M4f, Precision::F64, Start::Warm);
    let single = cycles(Core::M4f, Precision::F32, Start::Warm);
    let m7 = cycles(Core::M7, Precision::F64, Start::Warm);
    let m7_single = cycles(Core::M7, Precision::F32, Start::Warm);
    format!(
        "## Which precision\n\n\
         - **Cortex-M4F: `f32`.** Doubles are worked out in software there: a warm tick takes {:.0} times \
         as long ({} cycles, {:.1} ms at 168 MHz, against {:.2} ms). That is for an occasional check of a \
         single-precision result, not for a control loop. What single precision costs is in the table of \
         errors below: the stiffness is good to about a millionth, and far better than the model is.\n\
         - **Cortex-M7 with the FPU for doubles: either.** `f64` takes {:.1} times as long as `f32` there; \
         take it where the solutions are differentiated or summed up over time, `f32` where cycles count.\n\
         - **Host: `f64`.** There is little to gain from `f32`.\n\n",
        soft / single,
        cell(soft),
        soft / 168e3,
        single / 168e3,
        m7 / m7_single,
    )
}

fn errors(rows: &Rows) -> String {
    let mut lines = Vec::new();
    for (motion, balls) in [(USUAL, 7), (USUAL, 16), (USUAL, 30)]
        .into_iter()
        .chain(OTHERS.map(|motion| (motion, 16)))
    {
        for precision in [Precision::F32, Precision::F64] {
            for start in Start::ALL {
                let at = at(None, precision, motion, balls).from(start);
                let both = |metric: &str| {
                    format!(
                        "{} / {}",
                        error(rows.get(&at, metric, "median")),
                        error(rows.get(&at, metric, "99 %"))
                    )
                };
                lines.push(vec![
                    format!(
                        "{}, {balls} balls, {}, {}",
                        motion.name(),
                        name(precision),
                        start.name()
                    ),
                    both("displacement error"),
                    both("force error"),
                    both("stiffness error"),
                    format!(
                        "{} / {}",
                        cell(rows.get(&at, "iterations", "median")),
                        cell(rows.get(&at, "iterations", "99 %"))
                    ),
                    format!(
                        "{} of {}",
                        cell(rows.get(&at, "answers solved", "value")),
                        cell(rows.get(&at, "cases", "value"))
                    ),
                    cell(rows.get(&at, "answers of another equilibrium", "value")),
                ]);
            }
        }
    }
    format!(
        "## Errors\n\nMedian / 99th percentile, at the default tolerance. Displacements are relative to \
         the largest component, forces to the largest, stiffness to its diagonal \
         (`host_tests/src/compare.rs`). At speed there may be several \
         equilibria: an answer of another one than double precision found is compared with its own, and \
         counted in the last column. Inner race control is not for loads that lift balls off the inner \
         race, and many of these do; a warm tick needs a cold solve before it.\n\n{}\n",
        table(
            &[
                "solver",
                "displacement",
                "forces",
                "stiffness",
                "iterations",
                "solved",
                "other"
            ],
            &lines
        )
    )
}

fn limits(rows: &Rows) -> String {
    let mut text = String::from(
        "## What accuracy costs\n\n![Errors over tolerance](report_tolerance.svg)\n\n\
         Error of the stiffness (median / 99th percentile) and cycles (median) at a tolerance. 16 balls, \
         raceway control free.\n\n",
    );
    for start in Start::ALL {
        let mut lines = Vec::new();
        let limits = TOLERANCES.iter().map(|t| Limit::Tolerance(*t));
        for limit in limits.chain([Limit::Default]) {
            let mut line = vec![match limit {
                Limit::Default => {
                    let of = |precision| limit.settings(precision).0;
                    let (f32, f64) = (of(Precision::F32), of(Precision::F64));
                    format!("default, {f32:.0e} and {f64:.0e}")
                }
                Limit::Tolerance(t) => format!("{t:e}"),
            }];
            for precision in [Precision::F32, Precision::F64] {
                let at = at_any(precision).from(start);
                let metric = limit.metric("stiffness error");
                line.push(format!(
                    "{} / {}",
                    error(rows.get(&at, &metric, "median")),
                    error(rows.get(&at, &metric, "99 %"))
                ));
            }
            for (core, precision) in CORES {
                let at = usual(core, precision).from(start);
                line.push(cell(rows.get(&at, &limit.metric("cycles"), "median")));
            }
            lines.push(line);
        }
        text += &format!(
            "### {}\n\n{}\n",
            if start == Start::Cold { "Cold" } else { "Warm" },
            table(
                &[
                    "tolerance",
                    "error, f32",
                    "error, f64",
                    "M4F, f32",
                    "M4F, f64",
                    "M7, f32",
                    "M7, f64"
                ],
                &lines
            )
        );
    }
    text
}

fn breakdown(rows: &Rows) -> String {
    let columns = [
        (Core::M4f, Precision::F32, Start::Cold),
        (Core::M4f, Precision::F32, Start::Warm),
        (Core::M7, Precision::F64, Start::Cold),
        (Core::M7, Precision::F64, Start::Warm),
    ];
    let head = |what| {
        let mut head = vec![what];
        head.extend(["M4F, f32, cold", "warm", "M7, f64, cold", "warm"]);
        head
    };
    let line = |first: &str, metric: &str| {
        let mut line = vec![first.to_owned()];
        line.extend(columns.map(|(core, precision, start)| {
            cell(rows.get(&usual(core, precision).from(start), metric, "mean"))
        }));
        line
    };
    let parts: Vec<_> = Part::ALL
        .iter()
        .map(|part| line(part.name(), &format!("cycles of {}", part.name())))
        .chain([line(
            "an iteration, all but start and rest",
            "cycles an iteration",
        )])
        .collect();
    let classes: Vec<_> = Class::ALL
        .iter()
        .map(|class| line(class.name(), &format!("instructions: {}", class.name())))
        .collect();
    format!(
        "## Where the cycles go\n\n![Breakdown of a solve](report_breakdown.svg)\n\n\
         Cycles of a solve, mean of the mixed cases, 16 balls. The parts are told by the debug \
         information, through inlining.\n\n{}\n\
         Instructions of a solve by class, mean; those that a condition skips are counted.\n\n{}\n",
        table(&head("part"), &parts),
        table(&head("instructions"), &classes)
    )
}

fn others(rows: &Rows) -> String {
    let mut lines = Vec::new();
    let mut add = |core: Core, precision: Precision, motion: Motion, balls: usize| {
        let at = at(Some(core), precision, motion, balls);
        let cycles = |start, stat| cell(rows.get(&at.from(start), "cycles", stat));
        lines.push(vec![
            format!(
                "{}, {balls} balls, {}, {}",
                motion.name(),
                core.name(),
                name(precision)
            ),
            cycles(Start::Warm, "median"),
            cycles(Start::Warm, "99 %"),
            cycles(Start::Cold, "median"),
            cycles(Start::Cold, "99 %"),
            cell(rows.get(&at.from(Start::Cold), "cycles an iteration", "mean")),
        ]);
    };
    for (core, precision) in CORES {
        for balls in BALLS {
            add(core, precision, USUAL, balls);
        }
    }
    for motion in OTHERS {
        add(Core::M4f, Precision::F32, motion, 16);
        add(Core::M7, Precision::F64, motion, 16);
    }
    format!(
        "## Ball counts, scenes, rules of attitude\n\n![Cycles over ball count](report_balls.svg)\n\n\
         Cycles, {LABEL}.\n\n{}\n",
        table(
            &["solver", "warm", "99 %", "cold", "99 %", "an iteration"],
            &lines
        )
    )
}

fn memory(rows: &Rows) -> String {
    let mut lines = Vec::new();
    let mut add = |at: At| {
        lines.push(vec![
            format!(
                "{}, {} balls, {}, {}",
                at.motion.name(),
                at.balls,
                at.core.map_or("", Core::name),
                name(at.precision)
            ),
            cell(rows.get(&at, "flash", "value")),
            cell(rows.get(&at, "state", "value")),
            cell(rows.get(&at, "constants", "value")),
            cell(rows.get(&at, "worst stack", "value")),
        ]);
    };
    for (core, precision) in CORES {
        add(usual(core, precision));
    }
    for balls in [7, 30] {
        add(at(Some(Core::M4f), Precision::F32, USUAL, balls));
    }
    for motion in OTHERS {
        add(at(Some(Core::M4f), Precision::F32, motion, 16));
    }
    let mut symbols: Vec<_> = rows
        .all()
        .iter()
        .filter(|r| {
            r.core == Core::M4f.name()
                && r.precision == "f32"
                && r.balls == 16
                && r.attitude == Some(USUAL.name())
        })
        .filter_map(|r| Some((r.value, r.metric.strip_prefix("flash of ")?)))
        .map(|(value, symbol)| vec![format!("`{symbol}`"), cell(value)])
        .collect();
    symbols.truncate(20);
    format!(
        "## Memory\n\nBytes. Flash is what a solve reaches, code and constants, soft arithmetic included, less the call around it; \
         the bearing's constants are flash or RAM, as the program wants; state is the solver with its \
         balls; the stack is the deepest of a few dozen solves, cold and warm, beyond the caller's.\n\n{}\n\
         Flash by symbol, Cortex-M4F, f32; inlined functions are part of who called them, `Solver::solve` \
         of `measured_solve`.\n\n{}\n",
        table(
            &["solver", "flash", "state", "constants", "worst stack"],
            &lines
        ),
        table(&["symbol", "bytes"], &symbols)
    )
}

/// What is told of a scene.
#[derive(Debug, Clone, Copy)]
enum Figure {
    Bytes(&'static str),
    Cycles(Start),
}

const FLASH: Figure = Figure::Bytes("flash");
const STATE: Figure = Figure::Bytes("state");
const STACK: Figure = Figure::Bytes("worst stack");
const WARM: Figure = Figure::Cycles(Start::Warm);
const COLD: Figure = Figure::Cycles(Start::Cold);

/// A figure of a scene; NaN if there is none.
fn of_scene(rows: &Rows, scene: &Scene, precision: Precision, what: Figure) -> f64 {
    match what {
        Figure::Bytes(metric) => scene.figure(rows, precision, None, metric, "value"),
        Figure::Cycles(start) => scene.figure(rows, precision, Some(start), "cycles", "median"),
    }
}

fn scenes(rows: &Rows) -> String {
    let doubles: Vec<&Scene> = SCENES.iter().filter(|scene| scene.double).collect();
    let measured = SCENES
        .iter()
        .map(|scene| (scene, Precision::F32))
        .chain(doubles.iter().map(|scene| (*scene, Precision::F64)));
    let lines: Vec<Vec<String>> = measured
        .map(|(scene, precision)| {
            let get = |what| cell(of_scene(rows, scene, precision, what));
            let solved =
                |start| cell(scene.figure(rows, precision, Some(start), "answers solved", "value"));
            let mut line = vec![format!("{}, {}", scene.name, name(precision))];
            line.extend([FLASH, STATE, STACK, WARM, COLD].map(get));
            line.push(format!("{} / {}", solved(Start::Warm), solved(Start::Cold)));
            line
        })
        .collect();
    let largest: Vec<Vec<String>> = SCENES
        .iter()
        .map(|scene| {
            let symbols: Vec<String> = rows
                .all()
                .iter()
                .filter(|r| r.scene == scene.name && r.precision == "f32")
                .filter_map(|r| Some((r.metric.strip_prefix("flash of ")?, r.value)))
                .take(4)
                .map(|(symbol, value)| format!("`{}` {}", short(symbol), cell(value)))
                .collect();
            vec![scene.name.to_owned(), symbols.join(", ")]
        })
        .collect();
    let doubles: Vec<String> = doubles.iter().map(|s| format!("`{}`", s.name)).collect();
    format!(
        "## Scenes\n\nA firmware with one scene alone has nothing of what the scene leaves out. {}, 16 balls; \
         cycles are medians, {LABEL}. All scenes solve the same mixed cases, less the loads for which they \
         have no freedom, and at rest less the speed; `preloaded` is given the axial displacement that \
         `{FULL}` finds for the cold case. `displacement` asks for no stiffness, `balls` and `limits` for the \
         states of all balls or for the limits that are passed, besides. The last column says how many were solved, warm and cold; only \
         these count. Doubles, in software here, are measured of {} only, and of the first {} cases, to keep \
         the report short. Flash is code and constants that a solve reaches, without the call around it; \
         not the bearing's constants.\n\n{}\n\
         ### What leaving out saves\n\nAgainst `{FULL}`, f32; less than nothing is a cost.\n\n{}\n\
         ### What was promised\n\nf32; cycles are medians.\n\n{}\n\
         ### Rows and balls\n\nOne bearing, a clamped pair and two of these, back to back: cycles of a warm tick and \
         from nothing, f32, medians; bytes with 16 balls.\n\n{}\n\
         ### Largest symbols\n\nBytes of flash, f32; inlined functions are part of who called them, \
         `Solver::solve` of `measured_solve`.\n\n{}\n",
        scenes::CORE.name(),
        doubles.join(", "),
        scenes::DOUBLE_CASES,
        table(
            &[
                "scene",
                "flash / B",
                "state / B",
                "stack / B",
                "warm tick / cycles",
                "cold / cycles",
                "solved"
            ],
            &lines
        ),
        savings(rows),
        promises(rows),
        over_rows(rows),
        table(&["scene", "symbols"], &largest)
    )
}

/// Cycles over rows and balls of a shaft.
fn over_rows(rows: &Rows) -> String {
    let [few, many] = scenes::OTHER_BALLS;
    let counts = [few, EVERYDAY_BALLS, many];
    let mut header = vec!["rows".to_owned()];
    header.extend(counts.map(|balls| format!("{balls} balls, warm")));
    header.extend(counts.map(|balls| format!("{balls} balls, cold")));
    header.extend(["flash / B", "state / B", "stack / B"].map(str::to_owned));
    let lines: Vec<Vec<String>> = scenes::ROWS
        .iter()
        .filter_map(|(name, number)| Some((scenes::scene(name)?, number)))
        .map(|(scene, number)| {
            let mut line = vec![number.to_string()];
            for start in [Start::Warm, Start::Cold] {
                line.extend(counts.map(|balls| {
                    let single = Precision::F32;
                    cell(scene.figure_with(balls, rows, single, Some(start), "cycles", "median"))
                }));
            }
            for what in [FLASH, STATE, STACK] {
                line.push(cell(of_scene(rows, scene, Precision::F32, what)));
            }
            line
        })
        .collect();
    let header: Vec<&str> = header.iter().map(String::as_str).collect();
    table(&header, &lines)
}

fn savings(rows: &Rows) -> String {
    let Some(whole) = scenes::scene(FULL) else {
        return String::new();
    };
    let lines: Vec<Vec<String>> = SCENES
        .iter()
        .filter(|scene| scene.name != FULL)
        .map(|scene| {
            let mut line = vec![scene.name.to_owned(), scene.without.to_owned()];
            for what in [FLASH, STATE, WARM, COLD] {
                let get = |scene| of_scene(rows, scene, Precision::F32, what);
                let saved = get(whole) - get(scene);
                line.push(cell(saved));
                line.push(format!("{:.0}", 100.0 * saved / get(whole)));
            }
            line
        })
        .collect();
    table(
        &[
            "scene",
            "without",
            "flash / B",
            "%",
            "state / B",
            "%",
            "warm tick",
            "%",
            "cold",
            "%",
        ],
        &lines,
    )
}

/// What a scene was to take at most: so much, or this share of the whole solver's.
#[derive(Debug, Clone, Copy)]
enum Most {
    Of(f64),
    Share(f64),
    /// So much beyond the whole solver.
    Beyond(f64),
}

const PROMISES: [(&str, Figure, Most); 10] = [
    ("axial-static", FLASH, Most::Of(1024.0)),
    ("axial-static", WARM, Most::Of(600.0)),
    ("static", FLASH, Most::Of(4096.0)),
    ("static", WARM, Most::Share(0.5)),
    ("static", COLD, Most::Share(0.5)),
    ("translations-full", WARM, Most::Share(0.75)),
    ("translations-full", COLD, Most::Share(0.75)),
    ("pair", FLASH, Most::Beyond(4096.0)),
    ("pair", WARM, Most::Of(38_000.0)),
    ("four-rows", WARM, Most::Of(74_000.0)),
];

fn promises(rows: &Rows) -> String {
    let get = |name, what| {
        scenes::scene(name).map_or(f64::NAN, |scene| {
            of_scene(rows, scene, Precision::F32, what)
        })
    };
    let lines: Vec<Vec<String>> = PROMISES
        .iter()
        .map(|(name, what, most)| {
            let value = get(name, *what);
            let whole = get(FULL, *what);
            let (limit, told) = match most {
                Most::Of(limit) => (*limit, cell(*limit)),
                Most::Beyond(more) => (
                    whole + more,
                    format!("{}: {} beyond `{FULL}`", cell(whole + more), cell(*more)),
                ),
                Most::Share(share) => {
                    let limit = share * whole;
                    (limit, format!("{}: {} of `{FULL}`", cell(limit), share))
                }
            };
            vec![
                format!("{name}, {}", what.name()),
                told,
                match most {
                    Most::Of(_) | Most::Beyond(_) => cell(value),
                    Most::Share(_) => format!("{}: {:.2}", cell(value), value / whole),
                },
                if value <= limit {
                    "reached"
                } else {
                    "not reached"
                }
                .to_owned(),
            ]
        })
        .collect();
    table(&["what", "at most", "is", "so"], &lines)
}

impl Figure {
    const fn name(self) -> &'static str {
        match self {
            Self::Bytes(metric) => metric,
            Self::Cycles(Start::Warm) => "cycles of a warm tick",
            Self::Cycles(Start::Cold) => "cycles from nothing",
        }
    }
}

/// A symbol without the modules of its parts: `a::b::C<T>::d` is `C<T>::d`.
fn short(symbol: &str) -> String {
    let is_name = |c: char| c.is_alphanumeric() || c == '_';
    let mut out = String::new();
    let mut rest = symbol;
    while let Some(c) = rest.chars().next() {
        let word = rest.find(|c| !is_name(c)).unwrap_or(rest.len());
        let behind = &rest[word..];
        let is_module = rest[..word].chars().all(|c| !c.is_uppercase());
        // Modules are in front of another name.
        if word > 0
            && is_module
            && let Some(next) = behind.strip_prefix("::")
        {
            rest = next;
        } else {
            let taken = if word > 0 { word } else { c.len_utf8() };
            out.push_str(&rest[..taken]);
            rest = &rest[taken..];
        }
    }
    out
}

/// What the full scene takes on a Cortex-M4F in single precision, and what others make of it.
fn costs(rows: &Rows) -> String {
    let full = usual(Core::M4f, Precision::F32);
    let warm = full.from(Start::Warm);
    let cold = full.from(Start::Cold);
    let rest = at(Some(Core::M4f), Precision::F32, Motion::Static, 16);
    let rough = Limit::Tolerance(1e-3);
    let of = |name: &str, what| {
        scenes::scene(name).map_or(f64::NAN, |scene| {
            of_scene(rows, scene, Precision::F32, what)
        })
    };
    let mut lines: Vec<Vec<String>> = Vec::new();
    let mut line = |what: &str, cycles: String, error_of_k: f64| {
        lines.push(vec![what.to_owned(), cycles, error(error_of_k)]);
    };
    let k = |limit: Limit, start| {
        let at = at_any(Precision::F32).from(start);
        rows.get(&at, &limit.metric("stiffness error"), "99 %")
    };
    line(
        "an iteration, warm",
        cell(rows.get(&warm, "cycles an iteration", "mean")),
        f64::NAN,
    );
    for limit in milling::LIMITS {
        let figure = |what, stat| milling::figure(rows, limit, what, stat);
        line(
            &limit.metric("warm tick, milling cycle at 1 kHz"),
            cell(figure("cycles", "median")),
            figure("stiffness error", "99 %"),
        );
    }
    for limit in [Limit::Default, rough] {
        line(
            &limit.metric("warm tick, mixed cases"),
            cell(rows.get(&warm, &limit.metric("cycles"), "median")),
            k(limit, Start::Warm),
        );
    }
    line(
        "cold solve, mixed cases",
        cell(rows.get(&cold, "cycles", "median")),
        k(Limit::Default, Start::Cold),
    );
    line(
        "the same, 99 %",
        cell(rows.get(&cold, "cycles", "99 %")),
        f64::NAN,
    );
    for start in [Start::Warm, Start::Cold] {
        let at = at_any(Precision::F32);
        let error = At {
            motion: Motion::Static,
            ..at.from(start)
        };
        line(
            &format!("at rest, {}", start.name()),
            cell(rows.get(&rest.from(start), "cycles", "median")),
            rows.get(&error, "stiffness error", "99 %"),
        );
    }
    for (what, name) in [
        ("outer race control", "outer"),
        ("inner race control", "inner"),
        ("centrifugal force alone", "centrifugal"),
        ("without tilts", "translations-full"),
        ("one ball for all", "axial-full"),
        ("one ball for all, at rest", "axial-static"),
    ] {
        line(
            &format!("warm tick, {what}"),
            cell(of(name, WARM)),
            f64::NAN,
        );
    }
    let bytes: Vec<Vec<String>> = [
        ("flash, full scene", of(FULL, FLASH)),
        ("flash, at rest with all freedoms", of("static", FLASH)),
        (
            "flash, one ball for all, at rest",
            of("axial-static", FLASH),
        ),
        ("state, full scene", rows.get(&full, "state", "value")),
        (
            "worst stack, full scene",
            rows.get(&full, "worst stack", "value"),
        ),
        (
            "state and worst stack, full scene",
            rows.get(&full, "state", "value") + rows.get(&full, "worst stack", "value"),
        ),
    ]
    .iter()
    .map(|(what, bytes)| vec![(*what).to_owned(), cell(*bytes)])
    .collect();
    format!(
        "## What a solve costs\n\nCortex-M4F, single precision, 16 balls, raceway control free unless said otherwise, \
         at the default tolerance of {:.0e} unless said otherwise. Ticks of the milling cycle are those of a B7005C over \
         `host_tests/records/milling_cycle.csv`, a state every millisecond; {} of {} have no answer. The other figures are \
         medians of the mixed cases.\n\n{}\n{}\n",
        f32::TOLERANCE,
        cell(milling::figure(rows, Limit::Default, "no answer", "value")),
        cell(milling::figure(rows, Limit::Default, "ticks", "value")),
        table(&["what", "cycles", "error of K, 99 %"], &lines),
        table(&["what", "bytes"], &bytes),
    )
}

/// A figure of somebody on the host.
fn host(rows: &Rows, who: &str, start: &str, metric: &str, stat: &str) -> f64 {
    rows.all()
        .iter()
        .find(|r| {
            r.core == "host"
                && r.precision == who
                && r.start == Some(start)
                && r.metric == metric
                && r.stat == stat
        })
        .map_or(f64::NAN, |r| r.value)
}

const WHO: [(&str, &str, &str); 7] = [
    ("ours, f64, cold", "f64", "cold"),
    ("ours, f64, warm", "f64", "warm"),
    ("ours, f32, cold", "f32", "cold"),
    ("ours, f32, warm", "f32", "warm"),
    ("study's scheme, step factors 0.1", "study's scheme", "cold"),
    ("the same without step factors", "nested Newton", "cold"),
    ("reference build", "reference build", "cold"),
];

fn study(rows: &Rows) -> String {
    let lines: Vec<Vec<String>> = WHO[..6]
        .iter()
        .map(|(label, who, start)| {
            let get = |metric, stat| host(rows, who, start, metric, stat);
            let passes = |stat| cell(get("passes a ball", stat));
            let ratio = get("passes a ball", "median")
                / host(rows, "f64", "cold", "passes a ball", "median");
            vec![
                (*label).to_owned(),
                passes("median"),
                passes("99 %"),
                if ratio < 10.0 {
                    format!("{ratio:.1}")
                } else {
                    cell(ratio)
                },
                error(match *who {
                    "f64" | "f32" => {
                        let (precision, from) = match (*who, *start) {
                            ("f64", "cold") => (Precision::F64, Start::Cold),
                            ("f64", _) => (Precision::F64, Start::Warm),
                            (_, "cold") => (Precision::F32, Start::Cold),
                            _ => (Precision::F32, Start::Warm),
                        };
                        rows.get(&at_any(precision).from(from), "stiffness error", "median")
                    }
                    _ => get("stiffness error", "median"),
                }),
                cell(get("answers", "value")),
                cell(get("no answer", "value")),
            ]
        })
        .collect();
    format!(
        "## The study's scheme beside ours\n\n![Ball passes](report_study.svg)\n\n\
         The study moves the ring by a tenth of Newton's step, and settles every ball by tenths of its \
         own before each. A pass is one linearisation of a ball; an iteration of ours condenses every ball once. \
         The same cases, one run; times are on [the page of a host](report_host.md).\n\n{}\n",
        table(
            &[
                "scheme",
                "passes a ball",
                "99 %",
                "over f64 cold",
                "error of K",
                "answers",
                "none"
            ],
            &lines
        )
    )
}

/// Times of this machine.
pub fn host_page(rows: &Rows) -> String {
    let lines: Vec<Vec<String>> = WHO
        .iter()
        .map(|(label, who, start)| {
            let get = |metric, stat| host(rows, who, start, metric, stat);
            let ratio = |stat| {
                let ratio = get("time over f64 cold", stat);
                if ratio < 100.0 {
                    format!("{ratio:.2}")
                } else {
                    cell(ratio)
                }
            };
            let us = |stat| format!("{:.1}", 1e6 * get("time", stat));
            vec![
                (*label).to_owned(),
                us("median"),
                us("99 %"),
                ratio("5 %"),
                ratio("median"),
                ratio("95 %"),
                cell(get("time of the reference build", "median")),
            ]
        })
        .collect();
    format!(
        "<!-- Made by `cargo reports`; other on every machine and in every run. -->\n\n\
         # Times on a host\n\nOf one run on {}, one thread, 16 balls, raceway control free, the mixed cases \
         of [the report](report.md) of which all of f64, f32 and the reference build know the equilibrium. \
         Ratios are taken case by case to ours in double precision from nothing; their spread is over the \
         cases. The last column is the time of the reference build over that of the row, median of the cases. The study's scheme and the reference build are written for clarity, not for speed.\n\n{}",
        std::env::consts::ARCH,
        table(
            &[
                "who",
                "time / us",
                "99 %",
                "ratio, 5 %",
                "median",
                "95 %",
                "reference build over it"
            ],
            &lines
        )
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn symbols_lose_their_modules() {
        for (symbol, expected) in [
            ("measured_solve", "measured_solve"),
            (
                "<spindle_bearing::a::Full<A> as spindle_bearing::a::Motion>::cold",
                "<Full<A> as Motion>::cold",
            ),
            ("libm::math::atan2f::atan2f", "atan2f"),
        ] {
            assert_eq!(short(symbol), expected);
        }
    }
}

//! Scenes and designs that must not compile, and what the compiler says to them.
//!
//! Every item is compiled in its good form, where it must pass, and in its bad form, where it must be refused. So it is
//! refused for nothing else. Only the library's own words are compared: the compiler's words change from release to
//! release.

use rayon::prelude::*;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// A type, good and bad, and what is said to the bad one.
const SOLVERS: [[&str; 3]; 4] = [
    [
        "Solver<f32, 16, Centrifugal<InnerRaceControl>>",
        "Solver<f32, 16, Centrifugal<Static>>",
        "is not an attitude rule; choose `RacewayControlFree`, `OuterRaceControl` or `InnerRaceControl`",
    ],
    [
        "AxialSolver<f32, OuterRaceControl>",
        "AxialSolver<f32, f64>",
        "is not a motion of the balls; a motion is `Static`, `Centrifugal<A>`, or an attitude rule `A` alone",
    ],
    [
        "Solver<f32, 16, OuterRaceControl>",
        "Solver<f32, 16, Static<OuterRaceControl>>",
        "struct takes 0 generic arguments",
    ],
    [
        "Solver<f32, 16, RacewayControlFree, 3>",
        "Solver<f32, 16, RacewayControlFree, 2>",
        "the inner ring has 3 freedoms (tilts locked) or 5; one, along the axis, is that of `AxialSolver`",
    ],
];

/// A change of a design of so many balls, and what is said to it.
const DESIGNS: [(usize, &str, &str); 6] = [
    (
        16,
        "inner_groove_factor: 0.5",
        "inner groove factor fi must be 0.501 to 0.7",
    ),
    (16, "ball_diameter: 7.1e-3", "ball diameter D must be"),
    (
        16,
        "free_contact: FreeContact::DiametralClearance(1e-3)",
        "diametral clearance Pd must be",
    ),
    (
        16,
        "free_contact: FreeContact::Angle(15.0)",
        "free contact angle alpha0 must be 0 to 1.4 rad",
    ),
    (
        9,
        "ring: Material { poissons_ratio: 0.6, ..Material::STEEL }",
        "Poisson's ratio nu of the rings must be 0 to 0.5",
    ),
    (2, "first_ball: 0.0", "ball count N must be 3 to 1000"),
];

/// A spindle that the compiler makes.
const SPINDLE: &str = "\
static BEARING: Bearing<f32, 16> = Bearing::<f32, 16>::const_new(&Design::angular_contact(6.35e-3, 36e-3, 0.26));
static SHAFT: Shaft<f32, 0> = Shaft::<f32, 0>::const_new(&[], &Material::STEEL);
static BELT: [ShaftLoad<f32>; 1] = [ShaftLoad { position: 0.15, load: [0.0, 0.0, -80.0, 0.0, 0.0] }];
const FRONT: Mounted<f32, 16> = Mounted::new(&BEARING, 0.0, Facing::PlusX);
const REAR: Mounted<f32, 16> = Mounted::new(&BEARING, 0.1, Facing::MinusX);
const HOUSING: Support<f32> = Support { radial: 4e8, ..Support::RIGID };
pub static CLAMPED: ElasticSpindle<f32, 2, 16> = Spindle::<f32, 2, 16>::const_new(
    Arrangement::BackToBack,
    [FRONT, REAR.with(Preload::Force(200.0))],
)
.const_elastic(&SHAFT, [HOUSING; 2])
.const_with_loads(&BELT);
pub static SPRUNG: SprungSpindle<f32, 2, 16> = SprungSpindle::<f32, 2, 16>::const_sprung(
    Arrangement::ByRows,
    [FRONT, REAR.with(Preload::Spring)],
    200.0,
);";

/// A part of that, another one in its place, and what is said to it.
#[rustfmt::skip]
const SPINDLES: [[&str; 3]; 16] = [
    ["0.1, Facing", "1e4, Facing", "a row must be within 4096 of its radii Rp of x = 0"],
    ["0.1, Facing", "f32::NAN, Facing", "a row must be within 4096 of its radii Rp of x = 0"],
    ["0.1, Facing", "1e-3, Facing", "two rows are nearer to each other than half a ball's diameter: check the positions"],
    ["0.1, Facing", "-0.1, Facing", "back to back, rows at smaller x face +x and rows at larger x face -x"],
    ["BackToBack", "Tandem", "in tandem, all rows face one way"],
    ["Force(200.0)", "Force(0.0)", "force of a preload must be above 0"],
    ["Force(200.0)", "Force(1e9)", "above 0, and at most that which presses all balls of a row"],
    ["Force(200.0)", "Closure(1e-3)", "closure e of a row must be at most a quarter of the distance L0 of the groove centres"],
    ["Force(200.0)", "Spring", "a row slides, but there is no spring: build the spindle by `Spindle::sprung`"],
    ["Preload::Spring", "Preload::Force(200.0)", "there is a spring, but no row slides: hold a row by `Preload::Spring`"],
    ["[FRONT, REAR.with(Preload::Spring", "[FRONT.with(Preload::Spring), REAR.with(Preload::Spring", "all rows slide under the spring"],
    ["[FRONT, REAR.with(Preload::Spring", "[FRONT.with(Preload::Force(9.0)), REAR.with(Preload::Spring", "a row is preloaded, but no clamped row faces it"],
    ["radial: 4e8", "radial: 4e4", "axial and radial stiffness of a support must be 1e5 N/m at least"],
    ["position: 0.15", "position: 1e4", "a constant load must be within 4096 radii Rp of x = 0"],
    ["-80.0", "-1e9", "a constant load must be at most that which presses all balls"],
    [".const_with_loads(&BELT)", ".const_with_loads(&BELT).const_with_loads(&BELT)", "the shaft has constant loads already"],
];

/// Every item in its good and its bad form, and what is said to the bad one.
fn items() -> impl Iterator<Item = ([String; 2], String)> {
    let solvers = SOLVERS.into_iter().map(|[good, bad, said]| {
        let item = |solver: &str| {
            let (name, _) = solver.split_once('<').unwrap_or_default();
            format!("pub fn solver() -> {solver} {{ {name}::of() }}")
        };
        ([good, bad].map(item), said.to_owned())
    });
    let designs = DESIGNS.into_iter().map(|(balls, change, said)| {
        let item = |balls: usize, change| {
            format!(
                "pub static BEARING: Bearing<f32, {balls}> = Bearing::<f32, {balls}>::const_new(&Design \
                 {{ {change}, ..Design::angular_contact(6.35e-3, 36e-3, 0.26) }});"
            )
        };
        let good = item(balls.max(3), "first_ball: 0.0");
        ([good, item(balls, change)], said.to_owned())
    });
    let spindles = SPINDLES.into_iter().map(|[part, other, said]| {
        let bad = SPINDLE.replace(part, other);
        ([SPINDLE.to_owned(), bad], said.to_owned())
    });
    // The library adds no method to a number. Of any precision, a root would be that of the magnitude.
    let numbers = [
        [
            "pub fn number(x: f32) -> f32 { x.max(1.0) }",
            "pub fn number(x: f32) -> f32 { x.at_least(1.0) }",
        ],
        [
            "pub fn root<T: Real>(x: T) -> f64 { f64::sqrt(x.into()) }",
            "pub fn root<T: Real>(x: T) -> T { x.sqrt() }",
        ],
    ];
    let numbers = numbers.map(|items| (items.map(str::to_owned), "no method named".to_owned()));
    solvers.chain(designs).chain(spindles).chain(numbers)
}

/// The library, compiled for programs to link.
fn library(folder: &Path) -> PathBuf {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let status = Command::new(cargo)
        .args(["build", "--quiet", "-p", "spindle-bearing", "--lib"])
        .args(["--offline", "--target-dir"])
        .arg(folder)
        .current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."))
        .status();
    assert!(status.unwrap().success(), "the library does not build");
    folder.join("debug/libspindle_bearing.rlib")
}

/// Compiles an item by this name, with code, since some errors come with that; the error is the compiler's words if it refuses.
fn compile(name: &str, item: &str, library: &Path) -> Result<(), String> {
    let rustc = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let mut compiler = Command::new(rustc)
        .args(["--edition", "2024", "--crate-type", "lib"])
        .args(["--emit", "asm", "--crate-name", name, "--out-dir"])
        .arg(library.with_file_name("items"))
        .arg("-L")
        .arg(library.with_file_name("deps"))
        .arg("--extern")
        .arg(format!("spindle_bearing={}", library.display()))
        .arg("-")
        .stdin(Stdio::piped())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let program = format!("#![allow(unused)]\nuse spindle_bearing::*;\n{item}");
    let mut input = compiler.stdin.take().unwrap();
    input.write_all(program.as_bytes()).unwrap();
    drop(input);
    let output = compiler.wait_with_output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    output.status.success().then_some(()).ok_or(said)
}

#[test]
fn what_makes_no_sense_does_not_compile_and_is_told_why() {
    let library = library(&Path::new(env!("CARGO_TARGET_TMPDIR")).join("compile_fail"));
    let items: Vec<_> = items().collect();
    // Some bad forms are of one good form.
    let mut good: Vec<&String> = items.iter().map(|([good, _], _)| good).collect();
    good.sort();
    good.dedup();
    good.par_iter().enumerate().for_each(|(number, good)| {
        let compiled = compile(&format!("good_{number}"), good, &library);
        compiled.unwrap_or_else(|said| panic!("{good}\n{said}"));
    });
    let items = items.par_iter().enumerate();
    items.for_each(|(number, ([_, bad], expected))| {
        let name = format!("item_{number}");
        let said = compile(&name, bad, &library).expect_err(bad);
        // Line breaks depend on the width that the compiler prints for.
        let said = said.split_whitespace().collect::<Vec<_>>().join(" ");
        for part in expected.split("; ") {
            assert!(said.contains(part), "{bad}: {part:?} is not in\n{said}");
        }
    });
}

//! Spindle files that are wrong in one place: the firmware's build and `cargo replay` refuse them with one message, at its line
//! and column.

use solvers::dispatch::Precision;
use solvers::{Balls, with_solver};
use spindle_file::designs::SHIPPED;
use spindle_file::mounting::board;
use spindle_file::spindles::SpindleFile;
use spindle_monitor::tick::Core;
use std::path::Path;

/// A file with every section.
const GOOD: &str = r#"name = "all sections"
arrangement = "back-to-back"
preload_n = 250

[[row]]
position_mm = 30
facing = "+x"
radial_growth_um = 1
support = { axial_n_per_um = 400, radial_n_per_um = 300 }

[row.design]
name = "B7005C"
balls = 16
ball_diameter_mm = 6.35
pitch_diameter_mm = 36
inner_groove_factor = 0.515
outer_groove_factor = 0.525
contact_angle_deg = 15
dynamic_load_rating_n = 14000
bore_mm = 25

[[row]]
bearing = "b7005c.toml"
position_mm = 130
facing = "-x"
support = { axial_n_per_um = 400, radial_n_per_um = 300 }

[shaft]
grow_with_speed = true
sections = [
    { from_mm = 0, to_mm = 22, outer_mm = 32, inner_mm = 10 },
    { from_mm = 22, to_mm = 160, outer_mm = 25, inner_mm = 10 },
]

[heat]
reference_c = 20

[load]
position_mm = -20

[[constant_load]]
position_mm = 150
fy_n = -100

[nose]
position_mm = 0

[nose.tool]
position_mm = -40

[monitor]
loads = "bridges"

[monitor.bridges]
counts = [[500, 0, 0, 0, 0], [0, 500, 0, 0, 0], [0, 0, 500, 0, 0], [0, 0, 0, 2e4, 0], [0, 0, 0, 0, 2e4]]

[monitor.plausible]
fx_n = [-1700, 1700]

[monitor.alarm.overload]
limit = 90
"#;

/// Text, the text in its place, line and column of the refusal, and how its message begins. `monitor_keys` has those of `[monitor]`.
type Mutation = (&'static str, &'static str, usize, usize, &'static str);

#[rustfmt::skip]
const MUTATIONS: [Mutation; 117] = [
    ("name = \"all sections\"", "", 1, 1, "the key `name` is missing; add a line such as `name ="),
    ("arrangement = \"back-to-back\"", "arrangement = \"DB\"", 2, 15, "\"DB\" is none of \"back-to-back\", \"face-to-face\", \"tandem\","),
    ("arrangement = \"back-to-back\"", "arrangement = \"face-to-face\"", 25, 10, "row 1 faces -x, which is not face-to-face: face to face,"),
    ("preload_n = 250", "preload_n = -250", 3, 13, "row 0: preload force of the pair (N) is -250, but must be"),
    ("preload_n = 250", "preload_n = 1e9", 3, 13, "row 0: preload force of the pair (N) is 1000000000, but"),
    ("preload_n = 250", "preload_n = 0", 3, 13, "row 0: preload force of the pair (N) is 0, but must be"),
    ("preload_n = 250", "preload_n = \"250\"", 3, 13, "invalid type: string \"250\", expected a number"),
    ("preload_n = 250", "preload = 250", 3, 1, "unknown field `preload`"),
    ("preload_n = 250", "preload_n = nan", 3, 13, "`preload_n` is nan, and no number; give one, or leave it"),
    ("preload_n = 250", "mounted_preload_n = -9", 3, 21, "row 0: preload force of the pair (N) is -9, but must be"),
    ("preload_n = 250", "mounted_preload_n = 1e9", 3, 21, "row 0: preload force of the pair (N) is 1000000000, but"),
    ("preload_n = 250", "mounted_preload_n = 0", 3, 21, "row 0: preload force of the pair (N) is 0, but must be"),
    ("preload_n = 250", "preload_n = 250\nmounted_preload_n = 250", 4, 21, "the preload is `preload_n`, as ground, or"),
    ("position_mm = 30", "position_mm = 130", 24, 15, "row 1: another row is 0 mm away, nearer than half a"),
    ("position_mm = 30", "position_mm = 1e9", 5, 1, "row 0 stands in no section of [shaft], and"),
    ("position_mm = 30", "position_mm = \"30\"", 6, 15, "invalid type: string \"30\", expected a number"),
    ("position_mm = 30", "position_mm = 30\npreload_offset_um = 3", 7, 21, "`preload_n` above preloads all clamped rows; remove that"),
    ("position_mm = 30", "position_mm = 30\nspring = true", 7, 10, "row 0 slides, but there is no spring: add [spring] with"),
    ("position_mm = 30", "", 5, 1, "this row lacks `position_mm`; add a line such as"),
    ("radial_growth_um = 1", "radial_growth_um = 1000000", 8, 20, "`radial_growth_um` is 1000000, but must lie between -1000"),
    ("radial_growth_um = 1", "radial_growth_mm = 1", 8, 1, "unknown field `radial_growth_mm`"),
    ("facing = \"+x\"", "facing = \"-x\"", 25, 10, "row 1 faces -x, which is not back-to-back: back to back,"),
    ("facing = \"+x\"", "facing = \"x\"", 7, 10, "\"x\" is none of \"+x\", \"-x\""),
    ("facing = \"-x\"", "facing = \"+x\"", 25, 10, "row 1 faces +x, which is not back-to-back: back to back, rows at smaller x face +x and rows at larger x face -x; rows count from 0"),
    ("axial_n_per_um = 400, radial", "axial_n_per_um = 0, radial", 9, 30, "row 0: `axial_n_per_um` is 0, but must be 0.1 at least;"),
    ("axial_n_per_um = 400, radial", "axial_n_per_um = -4, radial", 9, 30, "row 0: `axial_n_per_um` is -4, but must be 0.1 at least;"),
    ("axial_n_per_um = 400, radial", "axial_n_per_um = 0.01, radial", 9, 30, "row 0: `axial_n_per_um` is 0.01, but must be 0.1 at"),
    ("axial_n_per_um = 400, radial", "axial_n_per_mm = 400, radial", 9, 13, "unknown field `axial_n_per_mm`"),
    ("balls = 16", "balls = 16.5", 13, 9, "`balls` is 16.5, but must be a whole number from 3 to 64"),
    ("balls = 16", "balls = 65", 13, 9, "`balls` is 65, but must be a whole number from 3 to 64"),
    ("balls = 16", "balls = 40", 14, 20, "`ball_diameter_mm` is 6.35, but must lie between 0.1 and"),
    ("ball_diameter_mm = 6.35", "ball_diameter_mm = 0.00635", 14, 20, "`ball_diameter_mm` is 0.00635, but must lie between 0.1"),
    ("ball_diameter_mm = 6.35", "ball_diameter_mm = -6.35", 14, 20, "`ball_diameter_mm` is -6.35, but must lie between 0.1 and"),
    ("ball_diameter_mm = 6.35", "ball_diameter_in = 0.25", 14, 1, "unknown field `ball_diameter_in`"),
    ("pitch_diameter_mm = 36", "pitch_diameter_mm = 6", 15, 21, "`pitch_diameter_mm` is 6, but must lie between 6.4135 and"),
    ("ball_diameter_mm = 6.35", "ball_diameter_mm = 6350", 14, 20, "`ball_diameter_mm` is 6350, but must lie between 0.1 and"),
    ("bore_mm = 25", "bore_mm = 36", 15, 21, "`pitch_diameter_mm` is 36, but must be above `bore_mm`, which is 36:"),
    ("bore_mm = 25", "bore_mm = 47\noutside_mm = 25", 21, 14, "`outside_mm` is 25, but must be above `bore_mm`, which is 47:"),
    ("position_mm = -20", "position_mm = -200", 39, 15, "`position_mm` of the load is -200, 200 mm off the spindle, whose sections"),
    ("radial_growth_um = 1", "ball = { density_kg_m3 = 3200 }", 8, 8, "`ball` is for a `bearing`; move it into [row.design]"),
    ("name = \"B7005C\"\n", "", 11, 1, "the key `name` is missing; add a line such as"),
    ("inner_groove_factor = 0.515", "inner_groove_factor = 0.5", 16, 23, "`inner_groove_factor` is 0.5, but must lie between 0.501"),
    ("inner_groove_factor = 0.515", "inner_groove_factor = 51.5", 16, 23, "`inner_groove_factor` is 51.5, but must lie between 0.501"),
    ("contact_angle_deg = 15", "contact_angle_deg = 95", 18, 21, "`contact_angle_deg` is 95, but must lie between 0 and"),
    ("contact_angle_deg = 15", "contact_angle_deg = 15\ndiametral_clearance_um = 10", 19, 26, "`contact_angle_deg` and `diametral_clearance_um` say the"),
    ("dynamic_load_rating_n = 14000", "dynamic_load_rating_n = -1", 19, 25, "`dynamic_load_rating_n` is -1, but must lie between 1 and"),
    ("dynamic_load_rating_n = 14000", "dynamic_load_rating_kn = 14", 19, 1, "unknown field `dynamic_load_rating_kn`"),
    ("bore_mm = 25", "bore_mm = -25", 20, 11, "`bore_mm` is -25, but must lie between 0.1 and 100000"),
    ("bore_mm = 25", "bore_mm = 25\nring.youngs_modulus_gpa = 206e9", 21, 27, "`ring.youngs_modulus_gpa` is 206000000000, but must lie"),
    ("bore_mm = 25", "bore_mm = 25\nball.density_kg_m3 = 7.8", 21, 22, "`ball.density_kg_m3` is 7.8, but must lie between 100 and"),
    ("bore_mm = 25", "bore_mm = 25\nload.position_mm = 3", 5, 1, "a row has no loads: [load] and [[constant_load]] are the"),
    ("bearing = \"b7005c.toml\"", "bearing = \"b7005.toml\"", 23, 11, ""),
    ("bearing = \"b7005c.toml\"", "bearing = \"b7005c.toml\"\nrow = 3", 24, 1, "unknown field `row`"),
    ("grow_with_speed = true", "grow_with_speed = 1", 29, 19, "invalid type: integer `1`, expected a boolean"),
    ("grow_with_speed = true", "grow_with_speed = true\nbore_mm = 10", 29, 19, "rings grow by `grow_with_speed` or by `bore_mm`; remove"),
    ("grow_with_speed = true", "bore_mm = 40", 29, 11, "`bore_mm` is 40, but must lie between 0 and the diameter"),
    ("to_mm = 22, outer", "to_mm = 23, outer", 32, 17, "section 1 (`from_mm` = 22, `to_mm` = 160) overlaps"),
    ("to_mm = 22, outer", "to_mm = -22, outer", 31, 28, "section 0: `to_mm` is -22, but must lie between 0.001 and"),
    ("to_mm = 22, outer", "to_mm = 22000, outer", 32, 17, "section 1 (`from_mm` = 22, `to_mm` = 160) overlaps"),
    ("outer_mm = 32, inner_mm = 10", "outer_mm = 32, inner_mm = 40", 31, 58, "section 0: `inner_mm` is 40, but must lie between 0 and"),
    ("outer_mm = 32, inner_mm = 10", "outer_mm = 0, inner_mm = 10", 31, 43, "section 0: `outer_mm` is 0, but must lie between 0.1 and"),
    ("outer_mm = 32, inner_mm = 10", "outer_mm = 32000, inner_mm = 10", 31, 43, "section 0: `outer_mm` is 32000, but must lie between 0.1"),
    ("outer_mm = 25, inner_mm = 10", "outer_mm = 0.025, inner_mm = 0.01", 32, 45, "section 1: `outer_mm` is 0.025, but must lie between 0.1"),
    ("outer_mm = 32, inner_mm = 10", "outer_mm = 32, bore_mm = 10", 31, 47, "unknown field `bore_mm`"),
    ("sections = [", "youngs_modulus_gpa = 206e9\nsections = [", 30, 22, "`youngs_modulus_gpa` of [shaft] is 206000000000, but must"),
    ("sections = [", "poissons_ratio = 0.6\nsections = [", 30, 18, "`poissons_ratio` of [shaft] is 0.6, but must lie between"),
    ("from_mm = 22, to_mm = 160", "from_mm = 22, to_mm = 100", 22, 1, "row 1 stands in no section of [shaft], and"),
    ("reference_c = 20", "", 35, 1, "[heat] lacks `reference_c`; add a line such as"),
    ("reference_c = 20", "reference_c = 293", 36, 15, "reference_c: 293 is above 200 deg C; is it in kelvin or"),
    ("reference_c = 20", "reference_c = 20\nshaft_per_k = 11.5", 37, 15, "`shaft_per_k` is 11.5, but must lie between -0.0001 and"),
    ("position_mm = -20", "position_mm = 1e9", 39, 15, "`position_mm` is 1000000000, but must lie between -100000"),
    ("position_mm = -20", "position_m = -20", 39, 1, "unknown field `position_m`"),
    ("position_mm = 150\nfy_n = -100", "position_mm = 1e9\nfy_n = -100", 42, 15, "`position_mm` is 1000000000, but must lie between -100000"),
    ("fy_n = -100", "fy_n = 1e12", 43, 8, "`fy_n` is 1000000000000, but must lie between -1000000000"),
    ("fy_n = -100", "fy_kn = 1", 43, 1, "unknown field `fy_kn`"),
    ("position_mm = 150\nfy_n = -100", "fy_n = -100", 41, 1, "missing field `position_mm`"),
    ("[nose]\nposition_mm = 0", "[nose]\nposition_mm = 1e9", 46, 15, "`position_mm` is 1000000000, but must lie between -100000"),
    ("[nose]\nposition_mm = 0", "[nose]\nradial_um_per_kn = 2", 45, 1, "[nose] lacks `position_mm`; add a line such as"),
    ("[nose]\nposition_mm = 0", "[nose]\nposition_mm = 0\nradial_um_per_kn = 2", 47, 20, "`radial_um_per_kn` is for a rigid shaft, and the"),
    ("position_mm = -40", "position_mm = 1e9", 49, 15, "`position_mm` is 1000000000, but must lie between -100000"),
    ("position_mm = -40", "position = 4", 49, 1, "unknown field `position`"),
    ("[[500, 0, 0, 0, 0], [0, 500", "[[1e308, 0, 0, 0, 0], [0, 500", 55, 10, "these bridges do not tell five loads apart"),
    ("fx_n = [-1700, 1700]", "fx_n = [-1e300, 1e300]", 58, 8, "the range"),
    ("limit = 90", "limit = 1e-300", 61, 9, "`alarm.overload.limit`"),
    ("limit = 90", "limit = 1e300", 61, 9, "`alarm.overload.limit`"),
    ("bore_mm = 25", "bore_mm = 25\nmonitor.period_ms = 2", 21, 1, "[monitor] is a spindle's: move it to a file with a"),
    ("bore_mm = 25", "bore_mm = 25\nball.density_kg_m3 = 7.8e6", 21, 22, "`ball.density_kg_m3` is 7800000, but must lie between 100"),
    ("reference_c = 20", "reference_c = 20\nring_per_k = nan", 37, 14, "`ring_per_k` is nan, and no number; give one, or leave it"),
    ("position_mm = 30", "position_mm = 30\nspring = 1", 7, 10, "invalid type: integer `1`, expected a boolean"),
    ("facing = \"+x\"", "facing = +x", 7, 10, "string values must be quoted, expected literal string"),
    ("[heat]", "[heat", 35, 6, "unclosed table, expected `]`"),
    ("[nose.tool]", "[nose.\"to ol\"]", 48, 7, "the name of a nose has letters, digits, `-` and `_`, and"),
    ("[[constant_load]]", "[constant_load]", 41, 1, "invalid type: map, expected a sequence"),
    ("arrangement = \"back-to-back\"", "arrangement = \"tandem\"", 25, 10, "row 1 faces -x, which is not tandem"),
    ("position_mm = 30", "position_mm = 127", 24, 15, "row 1: another row is 3 mm away, nearer than half a ball's diameter, 3.175"),
    ("preload_n = 250\n\n[[row]]", "spring.force_n = 0\n\n[[row]]\nspring = true", 3, 18, "row 0: force of the spring (N) is 0, but must be above 0"),
    ("preload_n = 250\n\n[[row]]", "preload_n = 250\nspring.force_n = 9\n\n[[row]]\nspring = true", 27, 10, "row 1 is preloaded, but no clamped row faces it"),
    ("[shaft]", "[spring]\nforce_n = 100\n[shaft]", 29, 11, "there is a spring, but no row slides: say"),
    ("radial_n_per_um = 300 }\n\n[row", "tilting_nm_per_rad = nan }\n\n[row", 9, 56, "`tilting_nm_per_rad` is nan, and no number"),
    ("radial_n_per_um = 300 }\n\n[row", "tilting_nm_per_rad = 0.9 }\n\n[row", 9, 56, "row 0: `tilting_nm_per_rad` is 0.9, but must be 1 at least"),
    ("balls = 16", "balls =", 13, 8, ""),
    ("balls = 16", "balls = 2", 13, 9, "`balls` is 2, but must be a whole number from 3 to 64"),
    ("balls = 16\n", "", 11, 1, "the key `balls` is missing; add a line such as `balls = 16`"),
    ("contact_angle_deg = 15\n", "", 11, 1, "the contact angle is missing; add a line such as"),
    ("bore_mm = 25", "bore_mm = 25\nball.poissons_ratio = 0.7", 21, 23, "`ball.poissons_ratio` is 0.7, but must lie between"),
    ("bore_mm = 25", "bore_mm = 25\nring.density_kg_m3 = 7850", 21, 6, "unknown field `density_kg_m3`"),
    ("bore_mm = 25", "bore_mm = 25\nballs = 9", 21, 1, "duplicate key"),
    ("outer_mm = 32, inner_mm = 10", "outer_mm = 32, inner_mm = nan", 31, 58, "`inner_mm` is nan, and no number"),
    ("to_mm = 22, outer", "outer", 31, 5, "missing field `to_mm`"),
    ("[nose.tool]\nposition_mm = -40", "[nose.tool]", 48, 7, "[nose.tool] lacks `position_mm`"),
    ("position_mm = -40", "position_mm = -40\naxial_um_per_kn = 2", 50, 19, "`axial_um_per_kn` is for a rigid shaft"),
    ("[nose]\nposition_mm", "[nose]\npositon_mm", 46, 14, "invalid type: integer `0`, expected `position_mm`, `radial_um_per_kn`, `axial_um_per_kn`, or a nose by name, such as"),
    ("[nose.tool]", "[nose.nose]", 48, 7, "the name of a nose has letters, digits, `-` and `_`, and is not `nose`"),
    ("preload_n = 250\n\n[[row]]", "mounted_preload_n = 250\n\n[[row]]\npreload_offset_um = 3", 3, 21, "`mounted_preload_n` finds the closure of all rows"),
    ("preload_n = 250\n\n[[row]]", "mounted_preload_n = 250\n\n[[row]]\nspring = true", 3, 21, "`mounted_preload_n` finds the closure of all rows"),
    ("facing = \"+x\"\n", "", 5, 1, "this row lacks `facing`; add a line such as `facing = \"+x\"`"),
    ("bearing = \"b7005c.toml\"\n", "", 22, 1, "this row lacks `bearing`"),
];

fn refusal(refused: Result<(), impl ToString>) -> String {
    refused.map_or_else(|error| error.to_string(), |()| "accepted".to_owned())
}

/// Messages of the build and of a replay.
pub fn refusals(text: &str) -> [String; 2] {
    let file = match SpindleFile::parse("s.toml", text, Path::new(SHIPPED)) {
        Ok(file) => file,
        // Both read it so.
        Err(error) => return [error.to_string(), error.to_string()],
    };
    let built = board::plan(&file, Some(Core::STM32F405)).map(|_| ());
    let replayed = with_solver(&file.plan, Balls::Free, Precision::F64, |_| ());
    let replayed = replayed.map_err(|error| file.explain(&error));
    [refusal(built), refusal(replayed)]
}

#[test]
fn a_wrong_file_is_refused_where_it_is_wrong() {
    assert_eq!(refusals(GOOD), ["accepted", "accepted"]);
    let mut wrong = String::new();
    for (from, to, line, column, words) in MUTATIONS {
        assert!(GOOD.contains(from), "{from}");
        let [built, replayed] = refusals(&GOOD.replacen(from, to, 1));
        let start = format!("s.toml: line {line}, column {column}: {words}");
        if !built.starts_with(&start) || built != replayed {
            wrong += &format!("{to}\n{built}\n{replayed}\n{start}\n");
        }
    }
    assert!(wrong.is_empty(), "{wrong}");
}

/// A step of 80 balls and a row of 40 take 163,400 cycles of the Cortex-M4F, and 123,000 of the Cortex-M7.
#[test]
fn a_tick_is_held_against_the_core_that_it_is_for() {
    let (from, to) = (
        "balls = 16\nball_diameter_mm = 6.35",
        "balls = 40\nball_diameter_mm = 2.5",
    );
    assert!(GOOD.contains(from));
    let text = GOOD.replacen(from, to, 1);
    let file = SpindleFile::parse("s.toml", &text, Path::new(SHIPPED)).unwrap();
    let refused = |core| refusal(board::plan(&file, core).map(|_| ()));
    let words =
        "a tick of 1 ms on the STM32F405 has no time for parts of a solve with 2 rows of 40 balls";
    assert!(refused(Some(Core::STM32F405)).contains(words));
    assert_eq!(refused(Some(Core::STM32H743)), "accepted");
    // A host has all the time.
    assert_eq!(refused(None), "accepted");
}

/// Probes share the time of a tick with the solves: an STM32F405 takes in a load step of two probes, and not of four.
#[test]
fn probes_are_held_against_the_core_that_they_are_for() {
    let two = std::fs::read_to_string(format!("{SHIPPED}/../spindles/probed_pair.toml")).unwrap();
    let more = ["left", "right"].map(|name| {
        format!(
            "[[probe]]\nname = \"{name}\"\nposition_mm = -5\nangle_deg = 90\naccuracy_um = 0.2\n\n"
        )
    });
    let four = two.replacen("[[probe]]", &(more.concat() + "[[probe]]"), 1);
    let spindles = Path::new(SHIPPED).join("../spindles");
    let refused = |text: &str, core| {
        let file = SpindleFile::parse("s.toml", text, &spindles);
        refusal(board::plan(&file.unwrap(), Some(core)).map(|_| ()))
    };
    let words = "or of its probes: give a longer `period_ms` in [monitor], or fewer probes";
    assert_eq!(refused(&two, Core::STM32F405), "accepted");
    assert!(refused(&four, Core::STM32F405).contains(words));
    assert_eq!(refused(&four, Core::STM32H743), "accepted");
    let slower = four.replacen("[[probe]]", "[monitor]\nperiod_ms = 2\n\n[[probe]]", 1);
    assert_eq!(refused(&slower, Core::STM32F405), "accepted");
}

/// A load that is too large for the bearings, a bearing's file with a monitor, a spring without anything to hold.
#[test]
fn a_refusal_of_the_solver_has_its_place() {
    for (from, to, place) in [
        (
            "fy_n = -100",
            "fy_n = 1e8",
            "line 43, column 8: constant load 0",
        ),
        (
            "position_mm = 150",
            "position_mm = 9e4",
            "line 42, column 15: `position_mm` of the load is 90000, 89840 mm off the spindle",
        ),
    ] {
        let [built, replayed] = refusals(&GOOD.replacen(from, to, 1));
        assert!(built.starts_with(&format!("s.toml: {place}")), "{built}");
        assert_eq!(built, replayed);
    }
    let bearing = std::fs::read_to_string(format!("{SHIPPED}/7014c.toml")).unwrap();
    let path = std::env::temp_dir().join(format!("bearing-{}.toml", std::process::id()));
    let lines = bearing.lines().count();
    std::fs::write(&path, bearing + "\n[monitor]\nperiod_ms = 2\n").unwrap();
    let told = SpindleFile::read(&path).unwrap_err().to_string();
    std::fs::remove_file(&path).unwrap();
    let place = format!("line {}, column 1: [monitor] is a spindle's", lines + 2);
    assert!(told.contains(&place), "{told}");
}

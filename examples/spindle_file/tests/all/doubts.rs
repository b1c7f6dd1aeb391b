//! Mistakes that people make in a spindle's file: each is refused, or told in a line with its place; real spindles are asked nothing.

use crate::wrong_files::refusals;
use spindle_file::catalogue::{GMN_S60, gmn_s60};
use spindle_file::designs::SHIPPED;
use spindle_file::spindles::SpindleFile;
use std::path::Path;

/// A milling spindle with all that a file may say.
const GOOD: &str = r#"name = "milling spindle with all keys"
arrangement = "back-to-back"
mounted_preload_n = 350

[[row]]
position_mm = 0
facing = "+x"
radial_growth_um = 2
support = { axial_n_per_um = 250, radial_n_per_um = 300, tilting_nm_per_rad = 1e6 }

[row.design]
name = "7010C"
bore_mm = 50
outside_mm = 80
balls = 18
ball_diameter_mm = 8.731
pitch_diameter_mm = 65
inner_groove_factor = 0.52
outer_groove_factor = 0.53
contact_angle_deg = 15
inner_shoulder_deg = 45
outer_shoulder_deg = 46
dynamic_load_rating_n = 26500
ring = { youngs_modulus_gpa = 206, poissons_ratio = 0.3 }
ball = { youngs_modulus_gpa = 310, poissons_ratio = 0.26, density_kg_m3 = 3200 }

[[row]]
bearing = "gmn:S6010C"
ball = { youngs_modulus_gpa = 315, poissons_ratio = 0.27, density_kg_m3 = 3250 }
position_mm = 17
facing = "+x"

[[row]]
bearing = "gmn:S6010C"
position_mm = 150
facing = "-x"

[shaft]
youngs_modulus_gpa = 208
sections = [
    { from_mm = -70, to_mm = -12, outer_mm = 75, inner_mm = 16 },
    { from_mm = -12, to_mm = 130, outer_mm = 50, inner_mm = 16 },
    { from_mm = 130, to_mm = 240, outer_mm = 45, inner_mm = 16 },
]
grow_with_speed = true

[heat]
reference_c = 20
shaft_per_k = 11.5e-6

[load]
position_mm = -110

[[constant_load]]
position_mm = 215
fy_n = -351

[nose]
position_mm = -70

[nose.wheel]
position_mm = -111

[[probe]]
name = "axial"
position_mm = -40
direction = "x"
accuracy_um = 0.1

[[probe]]
name = "radial"
position_mm = 232
angle_deg = 90

[monitor.plausible]
fx_n = [-1500, 1500]
my_nm = [-60, 60]
speed_rpm = 18000

[monitor.alarm.peak-pressure]
limit = 2.1

[monitor.alarm.preload-loss]
limit = 70
"#;

/// A pair, one row of which slides under a spring.
const SPRUNG: &str = r#"name = "a pair under a spring"

[[row]]
bearing = "7014c.toml"
position_mm = 0
facing = "+x"

[[row]]
bearing = "7014c.toml"
position_mm = 200
facing = "-x"
spring = true

[spring]
force_n = 500

[shaft]
bore_mm = 40

[load]
position_mm = -60

[nose]
position_mm = -30
"#;

/// A pair of deep groove bearings, by closures.
const DEEP: &str = r#"name = "a pair of 6205 with a ground spacer"

[[row]]
bearing = "skf6205.toml"
position_mm = 0
facing = "+x"
preload_offset_um = 120

[[row]]
position_mm = 40
facing = "-x"

[row.design]
name = "6205"
balls = 9
ball_diameter_mm = 7.938
pitch_diameter_mm = 39.04
inner_groove_factor = 0.52
outer_groove_factor = 0.52
diametral_clearance_um = 10
"#;

/// Text, the text in its place, and words of the line about it: a key, its value and what is usual or what to do. `wrong_files` has
/// more of those that are refused.
type Mistake = (&'static str, &'static str, &'static str, &'static str);

#[rustfmt::skip]
const MISTAKES: [Mistake; 100] = [
    (GOOD, "dynamic_load_rating_n = 26500", "dynamic_load_rating_n = 26.5", "`dynamic_load_rating_n` is 26.5, and usual are"),
    (GOOD, "dynamic_load_rating_n = 26500", "dynamic_load_rating_n = 2700", "`dynamic_load_rating_n` is 2700, and usual are"),
    (GOOD, "dynamic_load_rating_n = 26500", "dynamic_load_rating_n = 26500000", "`dynamic_load_rating_n` is 26500000, and usual are"),
    (GOOD, "contact_angle_deg = 15", "contact_angle_deg = 0.2618", "`contact_angle_deg` is 0.2618, and usual are 1 to 90: is it in radians?"),
    (GOOD, "contact_angle_deg = 15", "contact_angle_deg = 0.436", "`contact_angle_deg` is 0.436"),
    (GOOD, "contact_angle_deg = 15", "contact_angle_deg = -15", "`contact_angle_deg` is -15"),
    (GOOD, "contact_angle_deg = 15", "diametral_clearance_um = 0.02", "`diametral_clearance_um` is 0.02"),
    (GOOD, "contact_angle_deg = 15", "diametral_clearance_um = 20000", "`diametral_clearance_um` is 20000"),
    (GOOD, "contact_angle_deg = 15", "contact_angle_deg = 50", "`inner_shoulder_deg` is 45"),
    (GOOD, "mounted_preload_n = 350", "mounted_preload_n = 0.35", "`mounted_preload_n` is 0.35, and usual are"),
    (GOOD, "mounted_preload_n = 350", "mounted_preload_n = 350000", "350000"),
    (GOOD, "mounted_preload_n = 350", "preload_n = 0.35", "`preload_n` is 0.35, and usual are"),
    (GOOD, "mounted_preload_n = 350", "preload_n = 17.5", "`preload_n` is 17.5"),
    (GOOD, "mounted_preload_n = 350", "preload_n = 350000", "350000"),
    (GOOD, "mounted_preload_n = 350", "", "no row has a preload"),
    (GOOD, "radial_n_per_um = 300", "radial_n_per_um = 300e6", "`radial_n_per_um` is 300000000, and usual are 1 to 20000"),
    (GOOD, "radial_n_per_um = 300", "radial_n_per_um = 0.3", "`radial_n_per_um` is 0.3, and usual are 1 to 20000"),
    (GOOD, "radial_n_per_um = 300", "radial_n_per_um = 300000", "`radial_n_per_um` is 300000, and usual are 1 to 20000"),
    (GOOD, "axial_n_per_um = 250", "axial_n_per_um = 2.5e8", "`axial_n_per_um` is 250000000, and usual are 1 to 20000"),
    (GOOD, "axial_n_per_um = 250", "axial_n_per_um = 0.25", "`axial_n_per_um` is 0.25, and usual are 1 to 20000"),
    (GOOD, "axial_n_per_um = 250", "axial_n_per_um = 250000", "`axial_n_per_um` is 250000"),
    (GOOD, "tilting_nm_per_rad = 1e6", "tilting_nm_per_rad = 1e9", "`tilting_nm_per_rad` is 1000000000, and usual are"),
    (GOOD, "position_mm = -40", "position_mm = -400", "`position_mm` of the probe axial is -400"),
    (GOOD, "position_mm = -40", "position_mm = -130", "`position_mm` of the probe axial is -130"),
    (GOOD, "position_mm = -40", "position_mm = -40000", "`position_mm` of the probe axial is -40000"),
    (GOOD, "position_mm = 232", "position_mm = 332", "`position_mm` of the probe radial is 332"),
    (GOOD, "position_mm = -110", "position_mm = -110e3", "`position_mm`"),
    (GOOD, "position_mm = 215", "position_mm = 415", "`position_mm` of a constant load is 415"),
    (GOOD, "position_mm = 215", "position_mm = -315", "`position_mm` of a constant load is -315"),
    (GOOD, "fy_n = -351", "fy_n = -0.351", "`fy_n` is -0.351, and usual are"),
    (GOOD, "fy_n = -351", "fy_n = -351000", "`fy_n` is -351000, and usual are"),
    (GOOD, "position_mm = -111", "position_mm = -1110", "`position_mm` of [nose.wheel] is -1110"),
    (GOOD, "[nose]\nposition_mm = -70", "[nose]\nposition_mm = -700", "`position_mm` of [nose] is -700"),
    (GOOD, "pitch_diameter_mm = 65", "pitch_diameter_mm = 85", "`pitch_diameter_mm` is 85, but must be below `outside_mm`, which is 80"),
    (GOOD, "pitch_diameter_mm = 65", "pitch_diameter_mm = 78", "`outside_mm` is 80, and"),
    (GOOD, "pitch_diameter_mm = 65", "pitch_diameter_mm = 650", "`pitch_diameter_mm` is 650"),
    (GOOD, "bore_mm = 50", "bore_mm = 5", "`bore_mm` is 5, and"),
    (GOOD, "bore_mm = 50", "bore_mm = 60", "`bore_mm` is 60, and"),
    (GOOD, "outside_mm = 80", "outside_mm = 70", "`outside_mm` is 70, and"),
    (GOOD, "outside_mm = 80", "outside_mm = 800", "`outside_mm` is 800, and"),
    (GOOD, "balls = 18", "balls = 6", "`balls` is 6, which"),
    (GOOD, "ball_diameter_mm = 8.731", "ball_diameter_mm = 0.34375", "`balls` is 18, which"),
    (GOOD, "ball_diameter_mm = 8.731", "ball_diameter_mm = 4.3655", "`dynamic_load_rating_n`"),
    (GOOD, "ball_diameter_mm = 8.731", "ball_diameter_mm = 8,731", "s.toml"),
    (GOOD, "inner_groove_factor = 0.52", "inner_groove_radius_mm = 0.52", "`inner_groove_radius_mm` is 0.52"),
    (GOOD, "outer_groove_factor = 0.53", "outer_groove_factor = 0.053", "`outer_groove_factor` is 0.053"),
    (GOOD, "outer_groove_factor = 0.53", "outer_groove_radius_mm = 9.26", "`outer_groove_radius_mm` is 9.26"),
    (GOOD, "inner_shoulder_deg = 45", "inner_shoulder_deg = 0.785", "`inner_shoulder_deg` is 0.785"),
    (GOOD, "outer_shoulder_deg = 46", "outer_shoulder_deg = 146", "`outer_shoulder_deg` is 146"),
    (GOOD, "ring = { youngs_modulus_gpa = 206", "ring = { youngs_modulus_gpa = 2060", "`ring.youngs_modulus_gpa` is 2060"),
    (GOOD, "ring = { youngs_modulus_gpa = 206", "ring = { youngs_modulus_gpa = 0.206", "`ring.youngs_modulus_gpa` is 0.206"),
    (GOOD, "ring = { youngs_modulus_gpa = 206", "ring = { youngs_modulus_gpa = 30", "`ring.youngs_modulus_gpa` is 30"),
    (GOOD, "poissons_ratio = 0.3 }", "poissons_ratio = 3 }", "`ring.poissons_ratio` is 3"),
    (GOOD, "poissons_ratio = 0.3 }", "poissons_ratio = 0.03 }", "`ring.poissons_ratio` is 0.03"),
    (GOOD, "density_kg_m3 = 3200", "density_kg_m3 = 320", "`ball.density_kg_m3` is 320"),
    (GOOD, "density_kg_m3 = 3200", "density_kg_m3 = 32000", "`ball.density_kg_m3` is 32000"),
    (GOOD, "density_kg_m3 = 3200", "density_kg_m3 = 7850", "`density_kg_m3` = 7850"),
    (GOOD, "ball = { youngs_modulus_gpa = 310, poissons_ratio = 0.26, density", "ball = { density", "`density_kg_m3` = 3200"),
    (GOOD, "ball = { youngs_modulus_gpa = 315", "ball = { youngs_modulus_gpa = 3150", "`ball.youngs_modulus_gpa` is 3150"),
    (GOOD, "density_kg_m3 = 3250", "density_kg_m3 = 3.25", "`ball.density_kg_m3` is 3.25"),
    (GOOD, "bearing = \"gmn:S6010C\"", "bearing = \"S7010C\"", "did you mean gmn:S6010C"),
    (GOOD, "bearing = \"gmn:S6010C\"", "bearing = \"gmn:S7010C\"", "did you mean gmn:S6010C"),
    (GOOD, "bearing = \"gmn:S6010C\"", "bearing = \"7010C\"", "did you mean"),
    (GOOD, "bearing = \"gmn:S6010C\"", "bearing = \"gmn:S6020C\"", "`outer_mm` of the section at row 1 is 50"),
    (GOOD, "bearing = \"gmn:S6010C\"", "bearing = \"gmn:S6005C\"", "`outer_mm` of the section at row 1 is 50"),
    (GOOD, "position_mm = 17", "position_mm = 1.7", "row "),
    (GOOD, "position_mm = 150", "position_mm = 15", "row "),
    (GOOD, "position_mm = 17", "position_mm = 7", "row 1: `position_mm` is 7"),
    (GOOD, "radial_growth_um = 2", "radial_growth_um = 200", "`radial_growth_um` is 200"),
    (GOOD, "youngs_modulus_gpa = 208", "youngs_modulus_gpa = 20.8", "`youngs_modulus_gpa` is 20.8"),
    (GOOD, "to_mm = 130, outer_mm = 50", "to_mm = 130, outer_mm = 500", "`outer_mm` of the section at row 0 is 500"),
    (GOOD, "to_mm = 130, outer_mm = 50", "to_mm = 130, outer_mm = 25", "`outer_mm` of the section at row 0 is 25"),
    (GOOD, "reference_c = 20", "reference_c = 68", "`reference_c` is 68"),
    (GOOD, "shaft_per_k = 11.5e-6", "shaft_per_k = 6.4e-5", "`shaft_per_k` is 0.000064"),
    (GOOD, "accuracy_um = 0.1", "accuracy_um = 0.0001", "`accuracy_um` is 0.0001"),
    (GOOD, "accuracy_um = 0.1", "accuracy_um = 100", "`accuracy_um` is 100"),
    (GOOD, "accuracy_um = 0.1", "accuracy_um = 0", "`accuracy_um` is 0"),
    (GOOD, "direction = \"x\"", "direction = \"y\"", "direction"),
    (GOOD, "fx_n = [-1500, 1500]", "fx_n = [-1.5, 1.5]", "`plausible.fx_n` is 1.5"),
    (GOOD, "fx_n = [-1500, 1500]", "fx_n = [-1500e3, 1500e3]", "`plausible.fx_n`"),
    (GOOD, "my_nm = [-60, 60]", "my_nm = [-0.06, 0.06]", "`plausible.my_nm`"),
    (GOOD, "my_nm = [-60, 60]", "my_nm = [-60000, 60000]", "`plausible.my_nm`"),
    (GOOD, "speed_rpm = 18000", "speed_rpm = 18", "`plausible.speed_rpm` is 18"),
    (GOOD, "speed_rpm = 18000", "speed_rpm = 180000", "`plausible.speed_rpm` is 180000"),
    (GOOD, "limit = 2.1", "limit = 2100", "`alarm.peak-pressure.limit` is 2100"),
    (GOOD, "limit = 2.1", "limit = 2.1e9", "`alarm.peak-pressure.limit`"),
    (GOOD, "limit = 70", "limit = 0.7", "`alarm.preload-loss.limit` is 0.7"),
    (GOOD, "[monitor.alarm.preload-loss]", "[monitor.alarm.preload_loss]", "unknown field"),
    (GOOD, "[[constant_load]]", "[[load]]", "s.toml"),
    (SPRUNG, "[[row]]", "[[rows]]", "did you mean [[row]]?"),
    (SPRUNG, "force_n = 500", "force_n = 0.5", "`force_n` is 0.5"),
    (SPRUNG, "force_n = 500", "force_n = 500000", "force"),
    (SPRUNG, "bore_mm = 40", "bore_mm = 70", "`bore_mm` of [shaft] is 70"),
    (SPRUNG, "[load]\nposition_mm = -60", "[load]\nposition_mm = -600", "`position_mm` of the load is -600"),
    (SPRUNG, "[nose]\n", "[nose]\nradial_um_per_kn = -2\n", "`radial_um_per_kn` is -2, but must be 0 at least"),
    (SPRUNG, "[nose]\nposition_mm = -30", "[nose]\nposition_mm = -30000", "`position_mm` of [nose] is -30000"),
    (SPRUNG, "position_mm = 200", "position_mm = 2", "row"),
    (DEEP, "preload_offset_um = 120", "preload_offset_um = 0.012", "`preload_offset_um` is 0.012"),
    (DEEP, "preload_offset_um = 120", "preload_offset_um = 120000", "preload_offset_um"),
    (DEEP, "diametral_clearance_um = 10", "diametral_clearance_um = 0.01", "`diametral_clearance_um` is 0.01"),
];

fn read(text: &str) -> Result<SpindleFile, String> {
    let read = SpindleFile::parse("s.toml", text, Path::new(SHIPPED));
    read.map_err(|error| error.to_string())
}

/// All that `cargo replay` and the firmware's build say of a file.
fn told(text: &str) -> Vec<String> {
    let doubts = read(text).map_or_else(|_| Vec::new(), |file| file.doubts);
    let refused = refusals(text).into_iter().filter(|told| told != "accepted");
    doubts.into_iter().chain(refused).collect()
}

#[test]
fn each_mistake_is_told_with_its_place() {
    let mut silent = String::new();
    for text in [GOOD, SPRUNG, DEEP] {
        assert_eq!(told(text), Vec::<String>::new());
    }
    for (good, from, to, words) in MISTAKES {
        assert!(good.contains(from), "{from}");
        let text = good.replacen(from, to, 1);
        // The line that is wrong, or the table that lacks one.
        let told = told(&text);
        if !told
            .iter()
            .any(|line| line.starts_with("s.toml: line ") && line.contains(words))
        {
            silent += &format!("{to}\n  {words}\n  {}\n", told.join("\n  "));
        }
    }
    assert!(silent.is_empty(), "{silent}");
}

/// Rows of a layout: places in widths of a bearing and in distances of the supports, facings, and whether they slide.
type Layout = (&'static str, &'static [(f64, f64, &'static str, bool)]);

#[rustfmt::skip]
const LAYOUTS: [Layout; 9] = [
    ("back-to-back", &[(0.0, 0.0, "+x", false), (1.0, 0.0, "-x", false)]),
    ("back-to-back", &[(0.0, 0.0, "+x", false), (0.0, 1.0, "-x", false)]),
    ("face-to-face", &[(0.0, 0.0, "-x", false), (0.0, 1.0, "+x", false)]),
    ("back-to-back", &[(0.0, 0.0, "+x", false), (1.0, 0.0, "+x", false), (2.5, 0.0, "-x", false)]),
    ("back-to-back", &[(0.0, 0.0, "+x", false), (1.0, 0.0, "+x", false), (0.0, 1.0, "-x", false), (1.0, 1.0, "-x", false)]),
    ("back-to-back", &[
        (0.0, 0.0, "+x", false), (1.0, 0.0, "+x", false), (2.0, 0.0, "+x", false), (3.0, 0.0, "+x", false),
        (0.0, 1.0, "-x", false), (1.0, 1.0, "-x", false), (2.0, 1.0, "-x", false), (3.0, 1.0, "-x", false),
    ]),
    ("back-to-back", &[(0.0, 0.0, "+x", false), (0.0, 1.0, "-x", true)]),
    ("back-to-back", &[(0.0, 0.0, "+x", false), (1.0, 0.0, "+x", false), (0.0, 1.0, "-x", true), (1.0, 1.0, "-x", true)]),
    ("by-rows", &[(0.0, 0.0, "+x", false), (1.0, 0.0, "-x", false), (0.0, 1.0, "+x", false), (1.0, 1.0, "-x", false)]),
];

/// A spindle with bearings of GMN's table, of this layout and variant.
fn real(row: &csv::StringRecord, layout: &Layout, variant: usize) -> String {
    let number = |i: usize| row[i].parse::<f64>().unwrap();
    let ([pitch, bore, outside], name) = ([3, 11, 12].map(number), row[0].replace(' ', ""));
    // Light, medium, strong.
    let preload = number(5 + variant % 3);
    let (arrangement, rows) = layout;
    let (width, apart) = (0.5 * (outside - bore), (1.5 + (variant % 4) as f64) * pitch);
    let place =
        |(widths, distances, ..): &(f64, f64, &str, bool)| widths * width + distances * apart;
    let last = rows.iter().map(place).fold(0.0, f64::max);
    let (front, rear) = (-1.2 * width, last + 1.5 * width);
    // From a tool holder to a boring bar, which is as long as the shaft.
    let tool = front - [0.5, 0.99, 0.7, 0.95][variant % 4] * (rear - front);
    let stiffness = [80.0, 250.0, 600.0, 1500.0][variant % 4];
    let sprung = rows.iter().any(|row| row.3);
    let mut text = format!("name = \"{name} {variant}\"\narrangement = \"{arrangement}\"\n");
    text += &match (sprung, variant % 2) {
        (true, _) => String::new(),
        (_, 0) => format!("preload_n = {preload}\n"),
        _ => format!("mounted_preload_n = {preload}\n"),
    };
    for row in *rows {
        let (at, facing, slides) = (place(row), row.2, row.3);
        text += &format!(
            "[[row]]\nbearing = \"gmn:{name}\"\nposition_mm = {at}\nfacing = \"{facing}\"\nspring = {slides}\n"
        );
        if variant.is_multiple_of(2) {
            text += "ball = { youngs_modulus_gpa = 310, poissons_ratio = 0.26, density_kg_m3 = 3200 }\n";
        }
        if !variant.is_multiple_of(3) {
            text += &format!(
                "support = {{ axial_n_per_um = {stiffness}, radial_n_per_um = {} }}\n",
                0.6 * stiffness
            );
        }
    }
    if sprung {
        text += &format!("[spring]\nforce_n = {preload}\n");
    }
    let (hole, nose) = (0.4 * bore, 1.3 * bore);
    text += &match variant % 3 {
        0 => String::new(),
        1 => format!("[shaft]\nbore_mm = {hole}\n"),
        _ => format!(
            "[shaft]\ngrow_with_speed = true\nsections = [ {{ from_mm = {front}, to_mm = {}, outer_mm = {nose}, inner_mm = {hole} }}, \
             {{ from_mm = {}, to_mm = {rear}, outer_mm = {bore}, inner_mm = {hole} }} ]\n",
            -0.5 * width,
            -0.5 * width
        ),
    };
    let (pulley, force) = (rear - 0.3 * width, [2.0, 20.0, 0.2][variant % 3] * bore);
    let most = 60.0 * bore;
    text + &format!(
        "[load]\nposition_mm = {tool}\n[[constant_load]]\nposition_mm = {pulley}\nfy_n = {}\n[nose]\nposition_mm = {front}\n\
         [nose.tool]\nposition_mm = {tool}\n[[probe]]\nname = \"a\"\nposition_mm = {front}\ndirection = \"x\"\n\
         [heat]\nreference_c = 20\n[monitor.plausible]\nfx_n = [-{most}, {most}]\nfy_n = [-{most}, {most}]\nfz_n = [-{most}, {most}]\n\
         speed_rpm = {}\n",
        -force,
        (6e5 / pitch).round()
    )
}

/// Bores of 20 to 120 mm, two contact angles, two to eight rows, every preload, steel and ceramic balls, springs, belts, long tools.
#[test]
fn a_real_spindle_is_asked_nothing() {
    let mut reader = csv::ReaderBuilder::new()
        .comment(Some(b'#'))
        .from_reader(GMN_S60.as_bytes());
    let (mut asked, mut count) = (String::new(), 0);
    for row in reader.records().map(Result::unwrap) {
        if !(20.0..=120.0).contains(&row[11].parse::<f64>().unwrap()) {
            continue;
        }
        for (i, layout) in LAYOUTS.iter().enumerate() {
            for variant in i..i + 12 {
                let text = real(&row, layout, variant);
                count += 1;
                match read(&text) {
                    Ok(file) if file.doubts.is_empty() => {}
                    Ok(file) => asked += &format!("{text}{}\n", file.doubts.join("\n")),
                    Err(error) => asked += &format!("{text}{error}\n"),
                }
            }
        }
    }
    assert!(count > 2000, "{count}");
    assert!(asked.is_empty(), "{}", &asked[..asked.len().min(5000)]);
}

/// Files that come with the project, and the catalogue.
#[test]
fn no_file_of_the_project_is_asked_anything() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folders = ["bearings", "spindles"];
    let folders = folders.map(|folder| root.join(folder));
    let mut files: Vec<_> = folders
        .iter()
        .flat_map(|folder| std::fs::read_dir(folder).unwrap())
        .map(|file| file.unwrap().path())
        .collect();
    files.push(root.join("../firmware/spindle.toml"));
    files.retain(|file| file.extension().is_some_and(|ending| ending == "toml"));
    assert!(files.len() > 10, "{files:?}");
    for file in files {
        let doubts = SpindleFile::read(&file)
            .unwrap_or_else(|error| panic!("{error}"))
            .doubts;
        assert!(doubts.is_empty(), "{doubts:?}");
    }
    for listed in gmn_s60() {
        assert_eq!(listed.design().unwrap().doubts, Vec::<String>::new());
    }
}

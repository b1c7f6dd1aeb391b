//! Spindle files with an elastic shaft: their keys, and that their loads act where they stand.

use super::solves::{Answer, Balls, ask};
use cli::random::Random;
use judge::cases::B7005C;
use solvers::dispatch::Precision;
use solvers::with_solver;
use spindle_bearing::{
    Arrangement, Bearing, Growth, Material, Preload, Section, Settings, Shaft, ShaftLoad, Speed,
    Spindle, SpindleSolver, Support,
};
use spindle_file::designs::{DesignFileError, SHIPPED};
use spindle_file::loads::LoadRow;
use spindle_file::spindles::SpindleFile;
use std::path::Path;

const LOAD: [f64; 5] = [60.0, 150.0, -40.0, 0.5, 1.0];
const RPM: f64 = 12_000.0;

const ROWS: &str = "name = \"s\"\narrangement = \"back-to-back\"\npreload_n = 200\n\
    [[row]]\nbearing = \"b7005c.toml\"\nposition_mm = 0\nfacing = \"+x\"\n\
    [[row]]\nbearing = \"b7005c.toml\"\nposition_mm = 100\nfacing = \"-x\"\n";
const SUPPORT: &str = "support = { axial_n_per_um = 500, radial_n_per_um = 400 }\n";
const SECTIONS: &str = "[shaft]\nyoungs_modulus_gpa = 210\npoissons_ratio = 0.28\nsections = [\n\
    { from_mm = 0, to_mm = 130, outer_mm = 25, inner_mm = 8 },\n\
    { from_mm = -40, to_mm = 0, outer_mm = 30 },\n]\n";
const LOADS: &str =
    "[load]\nposition_mm = -50\n[[constant_load]]\nposition_mm = 120\nfx_n = 5\nfz_n = -80\n";
const NOSES: &str = "[nose]\nposition_mm = -40\n[nose.tool]\nposition_mm = -90\n";

fn parsed(text: &str) -> Result<SpindleFile, DesignFileError> {
    SpindleFile::parse("s.toml", text, Path::new(SHIPPED))
}

fn at_speed() -> LoadRow {
    LoadRow {
        time_s: 0.0,
        load: LOAD,
        speed_rpm: RPM,
        temperatures: None,
        probes: [None; 4],
    }
}

fn solved(text: &str) -> Answer {
    let file = parsed(text).unwrap();
    let question = file.question(&at_speed());
    ask(&file.plan, Balls::Free, Precision::F64, &question).unwrap()
}

/// Displacement and stiffness at `x = 0` and at the noses, forces, stiffness and motion of the rows.
fn figures(answer: &Answer) -> Vec<Vec<f64>> {
    let mut figures = vec![answer.displacement.to_vec()];
    figures.push(answer.stiffness.as_flattened().to_vec());
    for at in &answer.at {
        figures.push(at.displacement.to_vec());
        figures.push(at.stiffness.as_flattened().to_vec());
        figures.push(at.compliance.as_flattened().to_vec());
    }
    for row in &answer.rows {
        figures.push(row.force.to_vec());
        figures.push(row.stiffness_on_shaft.as_flattened().to_vec());
        figures.push(row.displacement.to_vec());
    }
    figures
}

/// Figures differ by this part of the largest one of their kind.
fn assert_close(found: &[Vec<f64>], truth: &[Vec<f64>], bound: f64) {
    assert_eq!(found.len(), truth.len());
    for (found, truth) in found.iter().zip(truth) {
        let largest = |x: &mut dyn Iterator<Item = f64>| x.fold(0.0, |a: f64, x| a.max(x.abs()));
        let off = largest(&mut found.iter().zip(truth).map(|(a, b)| a - b));
        let size = largest(&mut truth.iter().copied());
        assert!(off <= bound * size, "{found:?}\nnot\n{truth:?}");
    }
}

/// Recorded loads at `[load]` are those of a library's load there, in the file's own frame.
#[test]
fn a_file_means_what_the_library_is_told() {
    let text = format!(
        "{}{SECTIONS}grow_with_speed = true\n{LOADS}{NOSES}",
        ROWS.replacen("[[row]]\n", &format!("[[row]]\n{SUPPORT}"), 1)
    );
    let file = parsed(&text).unwrap();
    // The larger bore where two sections meet.
    let omega = Speed::rpm(RPM).as_rad_per_s();
    let growth = [Growth::by_rotation(&B7005C, 0.008, omega); 2];
    assert_eq!(file.question(&at_speed()).growth, growth);

    let section = |[from, to, outer, inner]: [f64; 4]| Section {
        from,
        to,
        outer,
        inner,
    };
    let sections = [[0.0, 0.13, 0.025, 0.008], [-0.04, 0.0, 0.03, 0.0]].map(section);
    let material = Material {
        youngs_modulus: 210e9,
        poissons_ratio: 0.28,
        ..Material::STEEL
    };
    let shaft = Shaft::<f64, 2>::new(&sections, &material).unwrap();
    let support = Support {
        axial: 500e6,
        radial: 400e6,
        ..Support::RIGID
    };
    let load = |position, load| ShaftLoad { position, load };
    let loads = [load(-0.05, LOAD), load(0.12, [5.0, 0.0, -80.0, 0.0, 0.0])];
    let bearing = Bearing::<f64, 16>::new(&B7005C).unwrap();
    let rigid = Spindle::pair(
        Arrangement::BackToBack,
        &bearing,
        0.1,
        Preload::Force(200.0),
    );
    let spindle = rigid.unwrap().elastic(&shaft, [support, Support::RIGID]);
    let spindle = spindle.unwrap().with_loads(&loads).unwrap();
    let mut solver = SpindleSolver::new();
    let at = Speed::rpm(RPM).with_growth(growth);
    let solution = solver.solve(&spindle, [0.0; 5], at, &Settings::default());
    let solution = solution.unwrap();
    let mut truth = vec![solution.displacement.to_vec()];
    truth.push(solution.stiffness().as_flattened().to_vec());
    for nose in [-0.04, -0.09] {
        truth.push(solution.displacement_at(nose).to_vec());
        truth.push(solution.stiffness_at(nose).as_flattened().to_vec());
        truth.push(solution.compliance_at(nose).as_flattened().to_vec());
    }
    for row in solution.rows() {
        truth.push(row.force.to_vec());
        truth.push(row.stiffness_on_shaft().as_flattened().to_vec());
        truth.push(solution.displacement_at(row.position).to_vec());
    }
    assert_close(&figures(&solved(&text)), &truth, 1e-9);
}

#[test]
fn a_load_in_two_halves_is_the_load() {
    let whole = format!("{ROWS}{SUPPORT}{SECTIONS}{LOADS}{NOSES}");
    let half = "[[constant_load]]\nposition_mm = 120\nfx_n = 2.5\nfz_n = -40\n";
    let halves = whole.replace("fx_n = 5\nfz_n = -80\n", "fx_n = 2.5\nfz_n = -40\n") + half;
    assert_close(&figures(&solved(&halves)), &figures(&solved(&whole)), 1e-9);
}

/// The stiffest shaft, and one without sections on rigid supports, are the rigid shaft.
#[test]
fn a_very_stiff_shaft_is_a_rigid_one() {
    let rigid = figures(&solved(&format!("{ROWS}{LOADS}{NOSES}")));
    let stiff = SECTIONS
        .replace("= 210", "= 1e4")
        .replace("outer_mm = 25", "outer_mm = 1000")
        .replace("outer_mm = 30", "outer_mm = 1000");
    for (text, bound) in [
        (format!("{ROWS}{stiff}{LOADS}{NOSES}"), 1e-4),
        (format!("{ROWS}support = {{}}\n{LOADS}{NOSES}"), 1e-9),
        (
            format!("{ROWS}[shaft]\nsections = []\n{LOADS}{NOSES}"),
            1e-9,
        ),
    ] {
        assert_close(&figures(&solved(&text)), &rigid, bound);
    }
    let bent = figures(&solved(&format!("{ROWS}{SECTIONS}{LOADS}{NOSES}")));
    assert!(bent[3][6] < 0.9 * rigid[3][6]);
}

#[test]
fn keys_of_a_shaft_that_need_sections_say_so_and_sections_are_64_at_most() {
    let section = |i| format!("{{ from_mm = {i}, to_mm = {}, outer_mm = 9 }},", i + 1);
    let many: String = (0..65).map(section).collect();
    for (shaft, wanted) in [
        (
            "youngs_modulus_gpa = 206",
            "`youngs_modulus_gpa` is for `sections`: add them",
        ),
        (
            "grow_with_speed = true",
            "`grow_with_speed` takes the bores of `sections`",
        ),
        ("bore_mm = -1", "`bore_mm` is -1, but must lie between 0"),
        (
            "",
            "[shaft] lacks `bore_mm`; add a line such as `bore_mm = 40`, or `sections`",
        ),
        (
            &format!("sections = [{many}]"),
            "has 65 sections, and 64 at most",
        ),
    ] {
        let message = parsed(&format!("{ROWS}[shaft]\n{shaft}\n")).unwrap_err();
        assert!(
            message.to_string().contains(wanted),
            "{message}\nwithout: {wanted}"
        );
    }
}

/// Whatever a value becomes, the file is refused, or the spindle is, or it is solved.
#[test]
fn wild_values_end_in_an_answer_or_a_message() {
    let good = format!("{ROWS}{SUPPORT}{SECTIONS}grow_with_speed = true\n{LOADS}{NOSES}");
    let wild = [
        "nan", "inf", "-inf", "1e308", "-1e308", "5e-324", "0", "-0.0", "-1", "1e6", "true", "[]",
        "{}", "\"x\"", "[{}]", "",
    ];
    let places: Vec<usize> = good.match_indices("= ").map(|(at, _)| at + 2).collect();
    let mut solved = 0;
    for seed in 0..400 {
        let mut random = Random::seeded(seed);
        let mut text = good.clone();
        // From the end, so that the places before stay.
        for at in places.iter().rev() {
            if random.below(places.len()) < 2 {
                let rest = &good[*at..];
                let end = at + rest.find([',', '\n', '}']).unwrap_or(rest.len());
                text.replace_range(*at..end, wild[random.below(wild.len())]);
            }
        }
        let Ok(file) = parsed(&text) else { continue };
        for precision in [Precision::F32, Precision::F64] {
            let answer = with_solver(&file.plan, Balls::Free, precision, |solver| {
                solver.solve(&file.question(&at_speed()))
            });
            solved += usize::from(matches!(answer, Ok(Ok(_))));
        }
    }
    assert!(solved > 100, "{solved}");
}

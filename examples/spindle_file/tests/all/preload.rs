//! The law of a spindle's preload, and settings of its probes, from a file to the monitor's.

use spindle_bearing::{Facing, Preload, Settings, Speed, Static};
use spindle_file::designs::SHIPPED;
use spindle_file::mounting::preload::response;
use spindle_file::mounting::{DynSolver, Parts, closed};
use spindle_file::spindles::SpindleFile;
use spindle_monitor::ResponseSettings;
use spindle_monitor::preload::{PreloadBy, PreloadLaw};
use std::path::Path;

const HEAT: &str = "[heat]\nreference_c = 20\n";
const PROBE: &str =
    "[[probe]]\nname = \"nose\"\nposition_mm = -10\nangle_deg = 0\naccuracy_um = 0.3\n";

/// A pair on an elastic shaft, with this line above all tables and these lines in both rows.
fn pair(top: &str, row: &str, after: &str) -> String {
    let row = |x: f64, facing: &str| {
        format!(
            "[[row]]\nbearing = \"b7005c.toml\"\nposition_mm = {x}\nfacing = \"{facing}\"\n{row}\
             support = {{ axial_n_per_um = 400, radial_n_per_um = 300 }}\n"
        )
    };
    let rows = row(30.0, "+x") + &row(130.0, "-x");
    let shaft =
        "[shaft]\nsections = [{ from_mm = 0, to_mm = 160, outer_mm = 25, inner_mm = 10 }]\n";
    format!("name = \"s\"\n{top}{rows}{shaft}{after}{PROBE}")
}

fn file(text: &str) -> SpindleFile {
    SpindleFile::parse("s.toml", text, Path::new(SHIPPED)).unwrap_or_else(|e| panic!("{e}"))
}

fn settings(text: &str) -> ResponseSettings<1> {
    let settings = response(&file(text)).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(settings.check(), Ok(()));
    settings
}

fn law(text: &str) -> PreloadLaw {
    settings(text).preload.expect("rows that oppose each other")
}

/// Preload of the spindle at rest, cold, without a load, all rows closed by so much more.
fn pressed(text: &str, closure: f64) -> f64 {
    let file = file(text);
    let plan = closed(&file.plan).unwrap();
    let parts = Parts::<f64>::of(&plan).unwrap();
    let spindle = parts.spindle(&plan).unwrap();
    let mut growth = spindle_file::mounting::growths(&[]);
    for growth in &mut growth {
        growth.axial = closure;
    }
    let mut solver = DynSolver::<f64, Static>::of();
    let at = Speed::rad_per_s(0.0).with_growth(growth);
    let solution = solver
        .solve(&spindle, [0.0; 5], at, &Settings::DEFAULT)
        .unwrap();
    let rows = solution.rows().zip(spindle.facings());
    rows.filter(|(_, facing)| *facing == Facing::PlusX)
        .map(|(row, _)| row.preload())
        .sum()
}

#[test]
fn the_preload_is_the_one_that_the_files_key_names() {
    assert_eq!(law(&pair("preload_n = 250\n", "", "")).force, 250.0);
    let mounted = pair("mounted_preload_n = 220\n", "", "");
    assert!((law(&mounted).force - 220.0).abs() < 0.01);
    let closed_by = pair("", "preload_offset_um = 8\n", "");
    assert!((f64::from(law(&closed_by).force) / pressed(&closed_by, 0.0) - 1.0).abs() < 1e-5);
    let sprung = pair("preload_n = 250\n", "", "")
        .replace("preload_n = 250\n", "")
        .replacen("facing = \"-x\"\n", "facing = \"-x\"\nspring = true\n", 1)
        + "[spring]\nforce_n = 180\n";
    let spring = PreloadLaw {
        force: 180.0,
        by: PreloadBy::Spring,
    };
    assert_eq!(law(&sprung), spring);
    let idle = "[monitor.idle]\nfx_n = 200\n";
    let tandem = pair("", "", idle).replace("\"-x\"", "\"+x\"");
    let file = SpindleFile::parse("s.toml", &tandem, Path::new(SHIPPED)).unwrap();
    assert_eq!(response::<1>(&file).unwrap().preload, None);
}

/// Of a mounted preload, the law is that of the spindle on its supports; of rows ground for a force, that of these rows on rigid seats.
#[test]
fn closures_give_the_preload_that_the_law_says() {
    let mounted = pair("mounted_preload_n = 220\n", "", "");
    let ground = pair("preload_n = 250\n", "", "");
    let rigid = ground.replace(
        "support = { axial_n_per_um = 400, radial_n_per_um = 300 }\n",
        "",
    );
    let (before, after) = rigid.split_once("[shaft]").unwrap();
    let (_, probe) = after.split_once("[[probe]]").unwrap();
    let rigid = format!("{before}[[probe]]{probe}");
    for (text, seated) in [(&mounted, &mounted), (&ground, &rigid)] {
        let law = law(text);
        for i in -30..=16 {
            let ln = 0.1 * i as f32;
            let [closure, slope] = law.closure(ln).map(f64::from);
            let truth = (f64::from(law.newtons(ln)), pressed(seated, closure));
            assert!((truth.1 / truth.0 - 1.0).abs() < 3e-3, "{ln}: {truth:?}");
            let [before, after] = [-1e-8, 1e-8].map(|by| pressed(seated, closure + by));
            let by_differences = 2e-8 / (after / before).ln();
            assert!(
                (slope / by_differences - 1.0).abs() < 0.03,
                "{ln}: {slope} {by_differences}"
            );
        }
    }
    let rows = file(&mounted).plan.rows;
    assert!(
        rows.iter()
            .all(|row| matches!(row.preload, Preload::Closure(_)))
    );
}

/// A heavy preload has a law as far as the rows bear it, and rows that do not press each other have none.
#[test]
fn a_heavy_preload_has_a_law_and_none_has_none() {
    let heavy = law(&pair("preload_n = 2500\n", "", ""));
    let [closure, slope] = heavy.closure(1.6);
    assert!(closure > 0.0 && slope > 0.0 && heavy.force == 2500.0);
    let idle = "[monitor.idle]\nfx_n = 200\n";
    assert_eq!(settings(&pair("", "", idle)).preload, None);
}

#[test]
fn accuracies_are_the_files() {
    let text = pair("preload_n = 250\n", "", "");
    let usual = settings(&text);
    assert_eq!((usual.heat, usual.load_error, usual.gain), (0.0, 0.02, 0.1));
    assert_eq!(usual.probes[0].accuracy, 0.3);
    // Some 100 N/um at the nose.
    let compliance = usual.probes[0].compliance;
    assert!(compliance > 0.005 && compliance < 0.1, "{compliance}");
    let warm = settings(&pair("preload_n = 250\n", "", HEAT));
    assert_eq!(warm.heat, 0.3);
    let PreloadBy::Closure { rows, heat, .. } = warm.preload.unwrap().by else {
        panic!("clamped rows");
    };
    assert!(rows == 0b11 && heat[0] > 0.0 && heat[1] < 0.0, "{heat:?}");
    let said = pair(
        "preload_n = 250\n",
        "",
        &format!("{HEAT}accuracy_k = 1.5\n"),
    );
    assert_eq!(settings(&said).heat, 1.5);
    let said = text + "[monitor.probes]\nload_error_percent = 5\ngain_percent = 20\n";
    let said = settings(&said);
    assert_eq!((said.load_error, said.gain), (0.05, 0.2));
}

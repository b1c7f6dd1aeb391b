//! `cargo replay --response`: a recording with probes, of a spindle that loses preload.

use crate::replay::{ran, replayed, scratch};
use spindle_file::designs::SHIPPED;
use spindle_file::dispatch::Precision;
use spindle_file::loads::LoadRow;
use spindle_file::solvers::{Balls, with_solver};
use spindle_file::spindles::SpindleFile;
use std::f64::consts::TAU;
use std::path::Path;

pub const PROBES: &str = "
[[probe]]
name = \"axial\"
position_mm = -10
direction = \"x\"
[[probe]]
name = \"nose\"
position_mm = -10
angle_deg = 30
";
const CUT: [f64; 5] = [-90.0, 270.0, 135.0, 6.75, -13.5];

fn text(preload: f64, probes: &str) -> String {
    let row = |x: f64, facing: &str| {
        format!(
            "[[row]]\nbearing = \"{SHIPPED}/b7005c.toml\"\nposition_mm = {x}\nfacing = \"{facing}\"\n\
             support = {{ axial_n_per_um = 400, radial_n_per_um = 300 }}\n"
        )
    };
    let rows = row(30.0, "+x") + &row(130.0, "-x");
    let shaft =
        "[shaft]\nsections = [{ from_mm = 0, to_mm = 160, outer_mm = 25, inner_mm = 10 }]\n";
    format!("name = \"s\"\npreload_n = {preload}\n{rows}{shaft}{probes}")
}

/// Displacements at the probes without a load and in the cut, um.
fn seen(preload: f64, speed_rpm: f64) -> [[f64; 2]; 2] {
    let file = SpindleFile::parse("s.toml", &text(preload, PROBES), Path::new(SHIPPED)).unwrap();
    let solved = with_solver(&file.plan, Balls::Free, Precision::F64, |solver| {
        [[0.0; 5], CUT].map(|load| {
            let row = LoadRow {
                time_s: 0.0,
                load,
                speed_rpm,
                temperatures: None,
                probes: [None; 4],
            };
            let answer = solver.answer(&file.question_at_probes(&row));
            [0, 1].map(|i| file.probes[i].sees(&answer.at[i].displacement))
        })
    });
    solved.unwrap()
}

/// Half a second of cutting each second, of a spindle that has so much of its 250 N from a time on. No load is stuck.
pub fn recording(rpm: f64, seconds: u32, (preload, change): (f64, f64)) -> String {
    let truth = [250.0, preload].map(|preload| seen(preload, rpm));
    let mut csv =
        "time_s,fx_n,fy_n,fz_n,my_nm,mz_nm,speed_rpm,probe_axial_um,probe_nose_um\n".to_owned();
    for i in 0..1000 * seconds {
        let time = f64::from(i) / 1e3;
        let cuts = (time - 0.3).rem_euclid(1.0) < 0.5;
        let [x, y] = truth[usize::from(time >= change)][usize::from(cuts)];
        let turn = TAU * time * rpm / 60.0;
        let runout = 3.0 * (turn.cos() + (2.0 * turn).sin());
        let load = CUT.map(|load| if cuts { load } else { 0.0 });
        let noise = 1e-3 * f64::from(i % 7);
        let load = load.map(|load| (load + noise).to_string()).join(",");
        csv += &format!(
            "{time},{load},{rpm},{:.4},{:.4}\n",
            1.02 * x + runout + 40.0,
            y - runout
        );
    }
    csv
}

/// Exit status, messages and the file.
fn response(spindle: &str, args: &[&str], csv: &str, name: &str) -> (i32, String, String) {
    let [file, out] = ["toml", "csv"].map(|end| scratch(&format!("{name}.{end}")));
    std::fs::write(&file, spindle).unwrap();
    let all = [
        file.to_str().unwrap(),
        "-",
        "--response",
        out.to_str().unwrap(),
    ];
    let (status, results, told) = replayed(&[&all[..], args].concat(), csv);
    assert_eq!(results, "");
    let text = std::fs::read_to_string(&out).unwrap_or_default();
    (status, told, text)
}

#[test]
fn a_recording_with_probes_tells_a_loss_of_preload() {
    let csv = recording(12_007.0, 14, (100.0, 8.0));
    let spindle = text(250.0, PROBES);
    let (status, told, text) = response(&spindle, &["--commission", "0:8"], &csv, "loss");
    assert_eq!(status, 0, "{told}");
    let mut lines = text.lines();
    assert_eq!(
        lines.next(),
        Some("time_s,probe,ratio,ratio_error,steps,state")
    );
    let truth = [100.0, 250.0].map(|preload| seen(preload, 12_007.0));
    for (i, line) in lines.enumerate() {
        let fields: Vec<&str> = line.split(',').collect();
        let (second, probe) = (i / 2 + 1, i % 2);
        assert_eq!(fields[0], second.to_string());
        assert_eq!(fields[1], ["axial", "nose"][probe]);
        if second < 8 {
            assert_eq!((fields[2], fields[3], fields[5]), ("", "", "learning"));
        }
        if second >= 10 {
            let [now, was] = truth.map(|[idle, cut]| cut[probe] - idle[probe]);
            let ratio: f64 = fields[2].parse().unwrap();
            let error: f64 = fields[3].parse().unwrap();
            assert!((ratio / (now / was) - 1.0).abs() < 0.003, "{line}");
            assert!(error < 0.02, "{line}");
            assert_eq!(fields[5], "stiffness-loss");
        }
    }
    assert_eq!(text.lines().count(), 1 + 2 * 14);
    let plotted = ran(env!("CARGO_BIN_EXE_plot"), &["-"], text.as_bytes());
    assert_eq!((plotted.0, &*plotted.2), (0, ""));
    assert!(plotted.1.contains("axial") && plotted.1.contains("nose"));
    // The reference is complete after 20 engagements.
    let csv = recording(12_007.0, 25, (100.0, 22.0));
    let (_, _, text) = response(&spindle, &[], &csv, "learning");
    for (second, state) in [(20, "learning"), (22, "ok"), (25, "stiffness-loss")] {
        let is_of = |line: &&str| line.starts_with(&format!("{second},"));
        let lines: Vec<_> = text.lines().filter(is_of).collect();
        assert!(
            lines.len() == 2 && lines.iter().all(|line| line.ends_with(state)),
            "{lines:?}"
        );
    }
}

#[test]
fn a_response_says_what_it_lacks() {
    let csv = recording(30_000.0, 2, (100.0, 8.0));
    let (status, told, text_) =
        response(&text(250.0, PROBES), &["--commission", "0:1"], &csv, "lack");
    assert_eq!(status, 0, "{told}");
    assert_eq!(told.matches("runout at 30000 rpm").count(), 1, "{told}");
    assert!(
        told.contains(
            "probe axial: 0 load steps until 1 s, where a reference needs 6; widen --commission"
        ),
        "{told}"
    );
    assert!(text_.contains("\n2,nose,,,0,learning\n"), "{text_}");
    let (status, told, _) = response(&text(250.0, ""), &[], &csv, "none");
    assert_eq!(status, 2);
    assert!(told.contains("has no [[probe]]; add one with"), "{told}");
    let other = csv.replace("probe_", "sensor_");
    let (status, told, _) = response(&text(250.0, PROBES), &[], &other, "other");
    assert_eq!(status, 2);
    assert!(
        told.contains("there is no column probe_axial_um; add one"),
        "{told}"
    );
    let (status, told, _) = response(
        &text(250.0, PROBES),
        &["--commission", "5:1"],
        &csv,
        "order",
    );
    assert_eq!(status, 2);
    assert!(
        told.contains("give seconds FROM:TO, such as 0:10"),
        "{told}"
    );
}

//! `cargo replay --response`: recordings with probes, of a spindle that is another one than its file's.

use crate::replay::{ran, replayed, scratch};
use cli::truth::Truth;
use spindle_file::designs::SHIPPED;
use spindle_file::spindles::SpindleFile;
use std::path::Path;

pub const PROBES: &str = "
[[probe]]
name = \"axial\"
position_mm = -10
direction = \"x\"
accuracy_um = 0.2
[[probe]]
name = \"nose\"
position_mm = -10
angle_deg = 30
accuracy_um = 0.2
";
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

/// So many seconds of a spindle whose file says 250 N.
pub fn recording(truth: Truth, seconds: f64) -> String {
    let file = SpindleFile::parse("s.toml", &text(250.0, PROBES), Path::new(SHIPPED)).unwrap();
    truth.recording(&file, seconds).unwrap()
}

/// Exit status, messages and the file, by columns.
struct Written {
    status: i32,
    told: String,
    text: String,
}

impl Written {
    fn of(spindle: &str, args: &[&str], csv: &str, name: &str) -> Self {
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
        Self { status, told, text }
    }

    /// The field of a column in the line of a second.
    fn at(&self, second: u32, column: &str) -> &str {
        let mut lines = self.text.lines();
        let column = lines
            .next()
            .unwrap()
            .split(',')
            .position(|one| one == column);
        let line = lines.find(|line| line.starts_with(&format!("{second},")));
        line.unwrap().split(',').nth(column.unwrap()).unwrap()
    }

    fn number(&self, second: u32, column: &str) -> f64 {
        self.at(second, column).parse().unwrap()
    }
}

#[test]
fn a_recording_tells_the_preload_and_its_loss() {
    let truth = Truth {
        preload: [220.0, 170.0],
        change: 60.0,
        ..Truth::SOUND
    };
    let written = Written::of(
        &text(250.0, PROBES),
        &["--commission", "2:55"],
        &recording(truth, 80.0),
        "loss",
    );
    let Written {
        status,
        told,
        text: csv,
    } = &written;
    assert_eq!(*status, 0, "{told}");
    assert!(csv.starts_with(
        "time_s,state,preload_n,preload_error_n,change_percent,change_error_percent,steps,\
         gain_axial,gain_error_axial,state_axial,gain_nose,gain_error_nose,state_nose\n"
    ));
    assert_eq!(csv.lines().count(), 81);
    for second in [1, 30, 54] {
        assert_eq!(written.at(second, "state"), "learning");
        assert_eq!(written.at(second, "change_percent"), "");
    }
    assert!(told.contains("replay: commissioned at 55"), "{told}");
    assert!(told.contains("replay: probe axial: 1."), "{told}");
    for (second, preload, change, state) in
        [(59, 220.0, 0.0, "ok"), (79, 170.0, -22.7, "preload-loss")]
    {
        let (found, error) = (
            written.number(second, "preload_n"),
            written.number(second, "preload_error_n"),
        );
        assert!(
            (found - preload).abs() < (2.5 * error).min(12.0),
            "{found} +- {error}"
        );
        let found = written.number(second, "change_percent");
        assert!((found - change).abs() < 5.0, "{found}");
        assert_eq!(written.at(second, "state"), state);
        for (probe, gain) in [("axial", 1.05), ("nose", 0.97)] {
            let found = written.number(second, &format!("gain_{probe}"));
            assert!((found - gain).abs() < 0.04, "{probe}: {found}");
            assert_eq!(written.at(second, &format!("state_{probe}")), "ok");
        }
    }
    let plotted = ran(env!("CARGO_BIN_EXE_plot"), &["-"], csv.as_bytes());
    assert_eq!((plotted.0, &*plotted.2), (0, ""));
}

#[test]
fn commissioning_says_what_it_lacks() {
    let short = recording(Truth::SOUND, 20.0);
    let written = Written::of(
        &text(250.0, PROBES),
        &["--commission", "0:30"],
        &short,
        "short",
    );
    assert_eq!(written.status, 0, "{}", written.told);
    let is_told =
        |written: &Written, words: &str| assert!(written.told.contains(words), "{}", written.told);
    is_told(&written, "steps before commissioning, which takes 200");
    is_told(&written, "the recording ends before 30 s");
    assert_eq!(written.at(20, "state"), "learning");
    // One cut alone, then others.
    let truth = Truth {
        one_until: 50.0,
        ..Truth::SOUND
    };
    let csv = recording(truth, 90.0);
    let lines: Vec<&str> = csv.split_inclusive('\n').take(48_000).collect();
    let written = Written::of(&text(250.0, PROBES), &[], &lines.concat(), "one");
    is_told(
        &written,
        "loads of another direction or size: preload known to ",
    );
    let written = Written::of(&text(250.0, PROBES), &[], &csv, "others");
    is_told(&written, "replay: commissioned at ");
    assert_eq!(written.at(89, "state"), "ok");
    // A window outside of the recording alone is refused.
    for window in ["90:95", "-9:-5"] {
        let written = Written::of(
            &text(250.0, PROBES),
            &["--commission", window],
            &short,
            "outside",
        );
        assert_eq!(written.status, 2, "{}", written.told);
        is_told(&written, "outside of it");
    }
}

#[test]
fn a_probe_at_fault_keeps_nothing_from_the_other_one() {
    let of = |gains: [f64; 2], name: &str| {
        let truth = Truth {
            gains,
            ..Truth::SOUND
        };
        Written::of(&text(250.0, PROBES), &[], &recording(truth, 70.0), name)
    };
    let millimetres = of([0.001, 0.97], "mm");
    let told = millimetres.told.split("replay: probe axial: ").nth(1);
    let ratio = told.and_then(|told| told.split(' ').next()?.parse::<f64>().ok());
    assert!(
        ratio.is_some_and(|ratio| ratio.abs() < 0.01),
        "{}",
        millimetres.told
    );
    let negative = of([1.05, -0.97], "negative");
    assert!(
        negative.told.contains("replay: probe nose: -0.9"),
        "{}",
        negative.told
    );
    for (written, bad, good) in [
        (&millimetres, "axial", "nose"),
        (&negative, "nose", "axial"),
    ] {
        assert_eq!(written.at(69, &format!("state_{bad}")), "probe");
        assert!(written.number(69, &format!("gain_error_{good}")) < 0.05);
    }
    assert_eq!(negative.at(69, "state"), "ok");
}

#[test]
fn a_response_says_what_is_missing() {
    let fast = Truth {
        rpm: 30_000.0,
        ..Truth::SOUND
    };
    let csv = recording(fast, 2.0);
    let written = Written::of(&text(250.0, PROBES), &[], &csv, "lack");
    let Written { status, told, .. } = &written;
    assert_eq!(*status, 0, "{told}");
    let line = "at 1000 Hz, 30000 rpm stands still: 1250 Hz does not";
    assert_eq!(told.matches(line).count(), 1, "{told}");
    assert_eq!(written.at(2, "state"), "learning");
    let Written { status, told, .. } = Written::of(&text(250.0, ""), &[], &csv, "none");
    assert_eq!(status, 2);
    assert!(told.contains("has no [[probe]]; add one with"), "{told}");
    let other = csv.replace("probe_", "sensor_");
    let Written { status, told, .. } = Written::of(&text(250.0, PROBES), &[], &other, "other");
    assert_eq!(status, 2);
    assert!(
        told.contains("there is no column probe_axial_um; add one"),
        "{told}"
    );
    let args = ["--commission", "5:1"];
    let Written { status, told, .. } = Written::of(&text(250.0, PROBES), &args, &csv, "order");
    assert_eq!(status, 2);
    assert!(
        told.contains("give seconds FROM:TO, such as 0:10"),
        "{told}"
    );
}

/// At another rate, with another tick.
#[test]
fn a_slow_logger_tells_it_too() {
    let truth = Truth {
        rpm: 12_007.0,
        step: 0.004,
        half: 0.6,
        ..Truth::SOUND
    };
    let written = Written::of(&text(250.0, PROBES), &[], &recording(truth, 150.0), "slow");
    assert_eq!(written.at(149, "state"), "ok", "{}", written.told);
    let found = written.number(149, "preload_n");
    assert!((found - 220.0).abs() < 15.0, "{found}");
}

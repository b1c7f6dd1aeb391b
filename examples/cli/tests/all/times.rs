//! Times of a recording: records of one time share the time to the next one, and a time is a number.

use crate::malformed::{HEADER, warmed};
use crate::replay::{replayed, scratch};

const SPINDLE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../firmware/spindle.toml");

/// A heavy cut for nine tenths of each of these seconds, then idling; the times are those of `stamp`.
fn cut(seconds: u32, stamp: impl Fn(f64) -> String) -> String {
    let mut text = HEADER.to_owned();
    for i in 0..10 * seconds {
        let load = if i % 10 < 9 {
            "-300,900,450,22,-45"
        } else {
            "0,0,0,0,0"
        };
        text += &format!("{},{load},12000\n", stamp(0.1 * f64::from(i)));
    }
    text
}

fn in_tenths() -> String {
    cut(20, |time| format!("{time:.1}"))
}

fn in_seconds() -> String {
    cut(20, |time| format!("{}", (time + 1e-6).floor()))
}

fn life(text: &str) -> (f64, f64, String) {
    let (status, out, err) = replayed(&[SPINDLE, "-", "--summary=json"], &warmed(text));
    assert_eq!(status, 0, "{err}");
    let summary: serde_json::Value = serde_json::from_str(&out).unwrap();
    let figure = |key: &str| summary[key].as_f64().unwrap();
    (figure("l10_h"), figure("duration_s"), err)
}

#[test]
fn records_of_one_time_share_the_time_to_the_next_one() {
    let ((tenths, whole, plain), (seconds, duration, told)) =
        (life(&in_tenths()), life(&in_seconds()));
    assert!(
        (seconds / tenths - 1.0).abs() < 1e-6,
        "{seconds} h, not {tenths} h"
    );
    assert!(
        (duration - whole).abs() < 1e-6,
        "{duration} s, not {whole} s"
    );
    let line = "replay: standard input: 200 records have the time of another one, the first at 0 s: records of one time share the \
                time to the next one";
    assert!(
        told.contains(line) && !plain.contains("of one time"),
        "{told}"
    );
    // The last second may have fewer records: each has what those before had.
    let mut short: Vec<_> = in_seconds().lines().map(str::to_owned).collect();
    short.truncate(1 + 194);
    let (_, duration, _) = life(&(short.join("\n") + "\n"));
    assert!((duration - 19.4).abs() < 1e-6, "{duration}");
}

/// A logger that pauses for a minute within two of its seconds.
#[test]
fn a_pause_is_not_shared() {
    let paused = |stamp: fn(f64) -> f64| {
        cut(20, |time| {
            let pause = if time > 9.95 { 60.0 } else { 0.0 };
            format!("{:.1}", pause + stamp(time))
        })
    };
    let [(tenths, whole, _), (seconds, duration, told)] =
        [paused(|time| time), paused(|time| (time + 1e-6).floor())].map(|text| life(&text));
    assert!(
        (seconds / tenths - 1.0).abs() < 0.01,
        "{seconds} h, not {tenths} h"
    );
    assert!(
        (duration - whole).abs() < 0.2,
        "{duration} s, not {whole} s"
    );
    assert_eq!(told.matches("the logger pauses").count(), 1, "{told}");
}

#[test]
fn alarms_do_not_depend_on_how_times_are_stamped() {
    let limits = |text: &str| {
        let (status, out, err) = replayed(&[SPINDLE, "-", "--limits"], &warmed(text));
        assert_eq!(status, 0, "{err}");
        (out, err)
    };
    let ((tenths, _), (seconds, told)) = (limits(&in_tenths()), limits(&in_seconds()));
    assert!(tenths.lines().count() > 2, "{tenths}");
    assert_eq!(tenths, seconds);
    assert!(
        told.contains("200 records have the time of another one"),
        "{told}"
    );
}

/// A time that is none is refused with its line, as a word is, whatever is asked for.
#[test]
fn a_time_is_a_finite_number() {
    let recording = |time: &str| {
        let rows =
            ["0", "0.1", time, "0.3"].map(|time| format!("{time},50,300,-40,1,2,9000,1.0\n"));
        warmed(&format!(
            "{},probe_nose_um\n{}",
            HEADER.trim_end(),
            rows.concat()
        ))
    };
    let probes = std::fs::read_to_string(SPINDLE)
        .unwrap()
        .replace("../spindle_file/bearings/b7005c.toml", "project:b7005c")
        + "\n[[probe]]\nname = \"nose\"\nposition_mm = 0\nangle_deg = 0\n";
    let [spindle, out] = ["times.toml", "times.csv"].map(scratch);
    std::fs::write(&spindle, probes).unwrap();
    let [spindle, out] = [&spindle, &out].map(|path| path.to_str().unwrap());
    for time in ["nan", "inf", "-inf", "1e400", "1e16"] {
        let fault = format!(
            "line 4, column 1 (time_s): \"{time}\" is no time; give seconds from -1e15 to 1e15"
        );
        for args in [&[][..], &["--summary"], &["--limits"], &["--response", out]] {
            let args = [&[spindle, "-"], args].concat();
            let (status, table, err) = replayed(&args, &recording(time));
            assert_eq!(status, 0, "{args:?} {err}");
            assert!(err.contains("rows read 3, refused 1"), "{args:?} {err}");
            if !args.contains(&"--limits") {
                assert!(err.contains(&fault), "{args:?} {err}");
            }
            assert!(!table.contains("NaN"), "{table}");
        }
    }
    for path in [spindle, out] {
        std::fs::remove_file(path).unwrap();
    }
}

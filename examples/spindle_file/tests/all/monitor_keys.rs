//! Keys of `[monitor]`: their page, every key from text to number, refusals by line and column.

use spindle_file::designs::SHIPPED;
use spindle_file::monitors::{KeyRow, OF_ALARM, Sensors, keys};
use spindle_file::plan::MOST_ROWS;
use spindle_file::spindles::SpindleFile;
use spindle_monitor::tick::Core;
use spindle_monitor::{Alarm, MonitorSettings};
use std::collections::BTreeSet;
use std::f64::consts::PI;
use std::path::Path;

/// The shipped pair, with heat.
const PAIR: &str = "\
name = \"pair\"
[heat]
reference_c = 20
[[row]]
bearing = \"b7005c.toml\"
position_mm = 30
facing = \"+x\"
[[row]]
bearing = \"b7005c.toml\"
position_mm = 130
facing = \"-x\"
";
const COUNTS: &str = "counts = [[500, 0, 0, 0, 0], [0, 500, 0, 0, 0], [0, 0, 500, 0, 0], \
    [0, 0, 0, 2e4, 0], [0, 0, 0, 0, 2e4], [300, 300, 300, 0, 0]]";

type Settings = MonitorSettings<MOST_ROWS>;

fn read(text: &str) -> Result<(Settings, Sensors), String> {
    let file = SpindleFile::parse("s.toml", &format!("{PAIR}{text}"), Path::new(SHIPPED));
    file.map(|file| (file.settings(&Core::STM32F405), file.sensors))
        .map_err(|error| error.to_string())
}

/// The settings of a file with this line in `[monitor]`.
fn with(key: &str, value: &str) -> (Settings, Sensors) {
    let bridges = match key {
        "bridges.tare_samples" => format!("loads = \"bridges\"\nbridges.{COUNTS}\n"),
        "bridges.counts" => "loads = \"bridges\"\n".to_owned(),
        "loads" => format!("bridges.{COUNTS}\n"),
        _ => String::new(),
    };
    let text = format!("[monitor]\n{bridges}{key} = {value}\n");
    read(&text).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

fn path_of(row: &KeyRow) -> String {
    let (table, key) = &row.path;
    [table.as_str(), key]
        .join(".")
        .trim_start_matches('.')
        .to_owned()
}

/// Tables of the page, under the headings that they stand below.
fn tables() -> Vec<(String, Vec<String>)> {
    let mut tables: Vec<(String, Vec<String>)> = Vec::new();
    for row in keys() {
        let heading = match row.path.0.as_str() {
            "" => "## `[monitor]`".to_owned(),
            table => format!("## `[monitor.{table}]`"),
        };
        if tables.iter().all(|(of, _)| *of != heading) {
            let head = [
                "| key | unit | default | meaning |",
                "| --- | --- | --- | --- |",
            ];
            tables.push((heading.clone(), head.map(str::to_owned).to_vec()));
        }
        let KeyRow {
            path: (_, key),
            unit,
            default,
            meaning,
        } = row;
        let line = format!("| `{key}` | {unit} | {default} | {meaning} |");
        let table = tables.iter_mut().find(|(of, _)| *of == heading).unwrap();
        table.1.push(line.replace("|  |", "| |"));
    }
    let mut alarms = vec!["| key | meaning |".to_owned(), "| --- | --- |".to_owned()];
    alarms.extend(OF_ALARM.map(|(key, meaning)| format!("| `{key}` | {meaning} |")));
    let levels = [
        "| alarm | unit | `limit` | `clear` | `hold_ms` | `at_once` |".to_owned(),
        "| --- | --- | --- | --- | --- | --- |".to_owned(),
    ];
    let of_alarm = |alarm: Alarm| {
        let usual = alarm.usual();
        let at_once = usual
            .at_once
            .map_or("never".to_owned(), |level| format!("`{level}`"));
        format!(
            "| `{alarm}` | {} | `{}` | `{}` | `{}` | {at_once} |",
            alarm.level_of(),
            usual.limit,
            usual.clear,
            usual.hold_ms
        )
    };
    let levels = levels.into_iter().chain(Alarm::ALL.map(of_alarm));
    let of_alarms = "## `[monitor.alarm.NAME]`".to_owned();
    tables.push((of_alarms.clone(), alarms));
    tables.push((of_alarms, levels.collect()));
    tables
}

/// The page has its text, and its tables from the reader.
#[test]
fn the_page_of_keys_is_the_readers() {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/monitor_keys.md");
    let page = std::fs::read_to_string(page).unwrap();
    let (mut tables, mut made) = (tables(), String::new());
    let (mut heading, mut is_in_table) = ("", false);
    for line in page.lines() {
        if line.starts_with("## ") {
            heading = line;
        }
        if !line.starts_with('|') {
            is_in_table = false;
            made += line;
            made.push('\n');
        } else if !std::mem::replace(&mut is_in_table, true) {
            let found = tables.iter().position(|(of, _)| of == heading);
            let (_, table) = tables.remove(found.unwrap_or_else(|| panic!("{line}")));
            made += &(table.join("\n") + "\n");
        }
    }
    assert!(tables.is_empty(), "the page lacks {tables:?}");
    let new = Path::new(env!("CARGO_TARGET_TMPDIR")).join("monitor_keys.md");
    std::fs::write(&new, &made).unwrap();
    assert!(
        made == page,
        "the keys have changed: copy {} to docs",
        new.display()
    );
}

/// Values in code are what the reader has without them.
#[test]
fn a_default_of_the_page_is_that_of_the_reader() {
    let silent = read("").unwrap();
    let mut values = 0;
    for row in keys() {
        let value = row
            .default
            .strip_prefix('`')
            .and_then(|x| x.strip_suffix('`'));
        let Some(value) = value.filter(|value| !value.contains('`')) else {
            continue;
        };
        let path = path_of(&row);
        let mut found = match path.as_str() {
            "loads" => read(&format!("[monitor]\nloads = {value}")).unwrap(),
            path => with(path, value),
        };
        if path.starts_with("bridges") {
            found.1.bridges = None;
            found.0.plausibility.speed_stuck_after = 0;
        }
        assert_eq!(found, silent, "{path} = {value}");
        values += 1;
    }
    assert_eq!(values, 2 + 5 + 7 + 7 + 5 + 1 + 2 + 3);
    // Of a pair.
    assert_eq!(silent.0.telemetry.balls_us, 200_000);
}

fn assert_near(found: f64, truth: f64, key: &str) {
    let off = (found - truth).abs();
    assert!(
        found == truth || off <= 6e-8 * truth.abs(),
        "{key}: {found}, not {truth}"
    );
}

/// A key, its text, what it sets, and the value in SI units.
type Said = (
    &'static str,
    &'static str,
    fn(&Settings, &Sensors) -> f64,
    f64,
);

const RAD: f64 = PI / 30.0;

#[rustfmt::skip]
const KEYS: [Said; 42] = [
    ("period_ms", "2", |m, _| m.tick.period_us.into(), 2000.0),
    ("loads", "\"bridges\"", |m, _| m.plausibility.speed_stuck_after.into(), 10_000.0),
    ("plausible.fx_n", "[-100, 900]", |m, _| m.plausibility.load[0][1].into(), 900.0),
    ("plausible.fx_n", "[-100, 900]", |m, _| m.plausibility.load[0][0].into(), -100.0),
    ("plausible.fx_n", "[-100, 900]", |m, _| m.plausibility.load_rate[0].into(), 2e5),
    ("plausible.fx_n", "[-1000, 900]", |m, _| m.overload[0].into(), 1000.0),
    ("plausible.fx_n", "[-1000, 900]", |m, _| m.accuracy[0].into(), 10.0),
    ("plausible.fy_n", "[-1, 2]", |m, _| m.plausibility.load[1][1].into(), 2.0),
    ("plausible.fz_n", "[-1, 3]", |m, _| m.plausibility.load[2][1].into(), 3.0),
    ("plausible.my_nm", "[-1, 4]", |m, _| m.plausibility.load[3][1].into(), 4.0),
    ("plausible.mz_nm", "[-1, 5]", |m, _| m.plausibility.load[4][1].into(), 5.0),
    ("plausible.stuck_after", "7", |m, _| m.plausibility.stuck_after.into(), 7.0),
    ("plausible.missing_ms", "70", |m, _| m.plausibility.missing_after_us.into(), 7e4),
    ("plausible.fresh_ms", "30", |m, _| m.plausibility.fresh_us.into(), 3e4),
    ("plausible.residual_counts", "12", |m, _| m.plausibility.residual.unwrap_or(0.0).into(), 12.0),
    ("plausible.speed_rpm", "20000", |m, _| m.plausibility.speed.into(), 2e4 * RAD),
    ("plausible.speed_rpm_per_ms", "100", |m, _| m.plausibility.speed_rate.into(), 1e5 * RAD),
    ("plausible.deceleration_rpm_per_s", "9000", |m, _| m.plausibility.deceleration.into(), 9e3 * RAD),
    ("plausible.speed_stuck_after", "60", |m, _| m.plausibility.speed_stuck_after.into(), 60.0),
    ("plausible.speed_difference_rpm", "60", |m, _| m.plausibility.speed_difference[0].into(), 60.0 * RAD),
    ("plausible.speed_difference_percent", "3", |m, _| m.plausibility.speed_difference[1].into(), 0.03),
    ("temperatures.range_c", "[0, 90]", |m, _| m.temperatures.map_or(0.0, |t| t.range[1].into()), 90.0),
    ("temperatures.difference_k", "30", |m, _| m.temperatures.map_or(0.0, |t| t.difference.into()), 30.0),
    ("temperatures.rate_k_per_s", "0.5", |m, _| m.temperatures.map_or(0.0, |t| t.rate.into()), 0.5),
    ("temperatures.noise_k", "0.2", |m, _| m.temperatures.map_or(0.0, |t| t.noise.into()), 0.2),
    ("temperatures.missing_ms", "3000", |m, _| m.temperatures.map_or(0.0, |t| t.missing_after_us.into()), 3e6),
    ("temperatures.hold_ms", "90000", |m, _| m.temperatures.map_or(0.0, |t| t.hold_us.into()), 9e7),
    ("temperatures.warm_c", "[50, 30]", |m, _| m.temperatures.map_or(0.0, |t| (t.warm[0] - t.warm[1]).into()), 20.0),
    ("tachometer.pulses_per_revolution", "60", |_, s| s.tachometer.pulses_per_revolution.into(), 60.0),
    ("tachometer.count_above_rpm", "6000", |_, s| s.tachometer.count_above.into(), 6e3 * RAD),
    ("tachometer.period_below_rpm", "900", |_, s| s.tachometer.period_below.into(), 900.0 * RAD),
    ("tachometer.gate_ms", "4", |_, s| s.tachometer.gate_us.into(), 4e3),
    ("tachometer.standstill_ms", "800", |_, s| s.tachometer.standstill_us.into(), 8e5),
    ("bridges.counts", "[[500, 0, 0, 0, 0], [0, 500, 0, 0, 0], [0, 0, 500, 0, 0], [0, 0, 0, 2e4, 0], [0, 0, 0, 1, 2e4]]",
        |_, s| s.bridges.as_ref().map_or(0.0, |of| of.counts[4][3]), 1.0),
    ("bridges.tare_samples", "200", |_, s| s.tare_samples.into(), 200.0),
    ("probes.load_error_percent", "3", |_, s| s.load_error.into(), 0.03),
    ("probes.gain_percent", "5", |_, s| s.gain.into(), 0.05),
    ("telemetry.estimate_ms", "10", |m, _| m.telemetry.estimate_us.into(), 1e4),
    ("telemetry.balls_ms", "100", |m, _| m.telemetry.balls_us.into(), 1e5),
    ("telemetry.health_ms", "2000", |m, _| m.telemetry.health_us.into(), 2e6),
    ("telemetry.standing_ms", "1.001", |m, _| m.telemetry.standing_us.into(), 1001.0),
    ("telemetry.standing_ms", "1.0016", |m, _| m.telemetry.standing_us.into(), 1002.0),
];

/// Keys of five loads each, what they set, and its size in the unit of the file.
type OfLoads = (
    &'static str,
    &'static str,
    fn(&Settings, &Sensors) -> [f32; 5],
    f64,
);

const OF_LOADS: [OfLoads; 4] = [
    ("idle.", "", |_, s| s.idle, 1.0),
    (
        "plausible.",
        "_per_ms",
        |m, _| m.plausibility.load_rate,
        1e3,
    ),
    ("overload.", "", |m, _| m.overload, 1.0),
    ("accuracy.", "", |m, _| m.accuracy, 1.0),
];

/// Units of alarms in a file; the others are 1.
const UNITS: [(Alarm, f64); 9] = [
    (Alarm::PreloadChange, 0.01),
    (Alarm::StiffnessLoss, 0.01),
    (Alarm::StiffnessGain, 0.01),
    (Alarm::PeakPressure, 1e9),
    (Alarm::ContactAngle, PI / 180.0),
    (Alarm::PreloadLoss, 0.01),
    (Alarm::Overload, 0.01),
    (Alarm::LifeUsed, 0.01),
    (Alarm::Availability, 0.01),
];

#[test]
fn every_key_sets_its_value_in_si_units() {
    let mut left: BTreeSet<String> = keys().iter().map(path_of).collect();
    let (silent, quiet) = read("").unwrap();
    for (key, text, value, truth) in KEYS {
        let (settings, sensors) = with(key, text);
        assert_near(value(&settings, &sensors), truth, key);
        assert_ne!(value(&silent, &quiet), truth, "{key}");
        left.remove(key);
    }
    for (before, behind, loads, size) in OF_LOADS {
        for (i, load) in ["fx_n", "fy_n", "fz_n", "my_nm", "mz_nm"]
            .into_iter()
            .enumerate()
        {
            let (key, said) = (format!("{before}{load}{behind}"), 3 + i);
            let (settings, sensors) = with(&key, &said.to_string());
            let mut truth = loads(&silent, &quiet);
            truth[i] = (size * said as f64) as f32;
            assert_eq!(loads(&settings, &sensors), truth, "{key}");
            left.remove(&key);
        }
    }
    assert!(left.is_empty(), "without a test: {left:?}");
    for (i, alarm) in Alarm::ALL.into_iter().enumerate() {
        let unit = UNITS.iter().find(|(of, _)| *of == alarm);
        let unit = unit.map_or(1.0, |(_, unit)| *unit);
        let table = "limit = 12\nclear = 11.5\nhold_ms = 77\nat_once = 90";
        let text = format!("[monitor.alarm.{alarm}]\n{table}");
        let found = read(&text).unwrap().0.alarms[i];
        let name = alarm.name();
        assert_eq!(found.hold_us, 77_000, "{name}");
        assert_near(found.raise.into(), 12.0 * unit, name);
        assert_near(found.clear.into(), 11.5 * unit, name);
        assert_near(found.at_once.unwrap().into(), 90.0 * unit, name);
        // A time without a measurement grows by itself.
        match found.worse {
            None => assert!(matches!(alarm, Alarm::Sensor | Alarm::Temperature)),
            Some(worse) => assert_near(worse.into(), 3.0 * unit, name),
        }
    }
}

/// The loads that counts stand for give back each load.
#[test]
fn loads_by_counts_give_back_each_load() {
    let (_, counts) = COUNTS.split_once(" = ").unwrap();
    let bridges = with("bridges.counts", counts).1.bridges.unwrap();
    for i in 0..5 {
        for j in 0..5 {
            let pairs = bridges.loads.iter().zip(&bridges.counts);
            let product: f64 = pairs.map(|(loads, counts)| loads[i] * counts[j]).sum();
            let largest = bridges.counts.iter().map(|of| of[j].abs());
            let unit = largest.fold(0.0, f64::max) / 500.0;
            let truth = f64::from(u8::from(i == j));
            assert!((product - truth).abs() < 1e-13 * unit, "{i} {j}: {product}");
        }
    }
}

/// Levels that are not said go with the limit.
#[test]
fn a_limit_takes_the_other_levels_along() {
    let alarm = |alarm: Alarm, text: &str| {
        let (settings, _) = read(&format!("[monitor.alarm]\n{text}")).unwrap();
        settings.alarms[alarm as usize]
    };
    let pressure = alarm(Alarm::PeakPressure, "peak-pressure.limit = 1.6");
    let levels = [pressure.raise, pressure.clear, pressure.at_once.unwrap()];
    for (found, truth) in levels.into_iter().zip([1.6e9, 1.52e9, 2.0e9]) {
        assert_near(found.into(), truth, "peak-pressure");
    }
    let angle = alarm(Alarm::ContactAngle, "contact-angle.limit = -1");
    assert_near(angle.raise.into(), -PI / 180.0, "contact-angle");
    assert_near(angle.clear.into(), -3.0 * PI / 180.0, "contact-angle");
}

/// Formulas of the defaults, on bearings with ratings of their own and in closed form.
#[test]
fn ranges_follow_from_ratings_and_pitch_diameters() {
    let pair = PAIR.replace("b7005c.toml", "gmn:S6014C");
    let listed = SpindleFile::parse("s.toml", &pair, Path::new(SHIPPED)).unwrap();
    let pitch = listed.plan.rows[0].design.pitch_diameter;
    let alone = SpindleFile::read("gmn:S6014C").unwrap();
    let [listed, alone] = [listed, alone].map(|file| file.settings(&Core::STM32F405));
    let [of_pair, of_one] =
        [&listed, &alone].map(|of| of.plausibility.load.map(|[_, high]| f64::from(high)));
    assert_near(of_pair[1], 2.0 * of_one[0], "two rows");
    assert_near(of_one[4], 1.4 * pitch * of_one[0], "moment");
    let rotation = f64::from(alone.plausibility.speed) / RAD;
    assert_near(rotation * 1e3 * pitch, 1.8e6, "n dm");
    let rated = PAIR.replacen("bearing = \"b7005c.toml\"", "design.name = \"r\"\ndesign.balls = 16\ndesign.ball_diameter_mm = 6.35\n\
        design.pitch_diameter_mm = 36\ndesign.inner_groove_factor = 0.515\ndesign.outer_groove_factor = 0.525\n\
        design.contact_angle_deg = 15\ndesign.dynamic_load_rating_n = 10000", 2);
    let rated = SpindleFile::parse("s.toml", &rated, Path::new(SHIPPED)).unwrap();
    let [low, _] = rated.settings(&Core::STM32F405).plausibility.load[2];
    assert_near(low.into(), -1200.0, "6 % of 2 C");
}

/// Text, the place of its fault counted from the end of the spindle, and words of the message.
#[rustfmt::skip]
const WRONG: [(&str, usize, usize, &str); 42] = [
    ("[monitor.plausible]\nfx_n = [-1000, 1000, 3000]", 2, 8, "invalid length 3, expected an array of length 2"),
    ("[monitor.temperatures]\nwarm_c = [40]", 2, 10, "invalid length 1, expected an array of length 2"),
    ("[monitor]\nloads = \"bridges\"\nbridges.counts = [[1, 0, 0, 0, 0, 7]]", 3, 19, "invalid length 6, expected an array of length 5"),
    ("[monitor.plausible]\nfx_n = [1000, 1000.00001]", 2, 8, "give the lowest value first"),
    ("[monitor.alarm.slip]\nlimit = 0.07\nclear = 0.06999999999", 3, 9, "the alarm slip: `clear` must be below `limit`"),
    ("[monitor.alarm.contact-angle]\nlimit = -1e8", 2, 9, "must lie between -90 and 90"),
    ("[monitor]\nplausible = 3", 2, 13, "`plausible` is a table of keys"),
    ("[monitor]\n\"plausible.fx_n\" = [1, 2]", 2, 1, "unknown field `plausible.fx_n`"),
    ("[monitor]\nalarm.slip.limits = 3", 2, 12, "unknown field `limits`, expected one of `limit`, `clear`, `hold_ms`, `at_once`"),
    ("[monitor]\nplausible.stuck_after.limit = 3", 2, 11, "invalid type: map, expected a number"),
    ("[monitor]\nperiod = 1", 2, 1, "unknown field `period`"),
    ("[monitor]\nperiod_ms = 0.5", 2, 13, "`period_ms` is 0.5, but must lie between 1 and 10"),
    ("[monitor]\nperiod_ms = \"1\"", 2, 13, "expected a number"),
    ("[monitor]\nperiod_ms = nan", 2, 13, "`period_ms` is nan"),
    ("[monitor]\nloads = \"wire\"", 2, 9, "\"wire\" is none of \"records\", \"bridges\""),
    ("[monitor]\nloads = \"bridges\"", 2, 9, "lacks `counts`"),
    ("[monitor.bridges]\ntare_samples = 5", 2, 16, "is for `loads = \"bridges\"`"),
    ("[monitor]\nloads = \"records\"\nbridges.counts = [[1, 0, 0, 0, 0]]", 3, 18, "is for `loads = \"bridges\"`"),
    ("[monitor]\nloads = \"bridges\"\nbridges.counts = [[1, 0, 0, 0, 0]]", 3, 18, "of 1 bridges, but must be of 5 to 8"),
    ("[monitor]\nloads = \"bridges\"\nbridges.counts = [[1, 0, 0, 0]]", 3, 19, "length"),
    ("[monitor]\nloads = \"bridges\"\nbridges.counts = [[1,1,1,1,1],[1,1,1,1,1],[1,1,1,1,1],[1,1,1,1,1],[1,1,1,1,1]]", 3, 18, "do not tell five loads apart"),
    ("[monitor.plausible]\nfx_n = [5, -5]", 2, 8, "from 5 to -5; give the lowest value first"),
    ("[monitor.plausible]\nfx_n = [5, 5]", 2, 8, "from 5 to 5; give the lowest value first"),
    ("[monitor]\nperiod_ms = 8\nplausible.fresh_ms = 7", 3, 22, "`fresh_ms` must be `period_ms` at least"),
    ("[monitor.alarm.peak-pressure]\nclear = 2", 2, 9, "peak-pressure: `clear` must be below `limit`"),
    ("[monitor.plausible]\nfx_n = [0, inf]", 2, 12, "`fx_n` is inf"),
    ("[monitor.plausible]\nfx_n = 1700", 2, 8, "invalid type"),
    ("[monitor.plausible]\nfy_n_per_ms = 0", 2, 15, "must lie between"),
    ("[monitor.plausible]\nstuck_after = 2.5", 2, 15, "must be a whole number between 0 and 65535"),
    ("[monitor.plausible]\nstuck_after = 1", 2, 15, "0, for never, or at least 2"),
    ("[monitor.plausible]\nmissing_ms = 5\n[monitor]\nperiod_ms = 8", 4, 13, "`missing_ms` must be `period_ms` at least"),
    ("[monitor.plausible]\nspeed_difference_percent = 0\nspeed_difference_rpm = 0", 3, 24, "must not both be 0"),
    ("[monitor.idle]\nfx_n = 4000", 2, 8, "must be within its plausible range"),
    ("[monitor.accuracy]\nmz_nm = -1", 2, 9, "must lie between 0 and"),
    ("[monitor.alarm.peak-pressure]\nclear = 2.1", 2, 9, "peak-pressure: `clear` must be below `limit`"),
    ("[monitor.alarm.overload]\nlimit = 0", 2, 9, "`alarm.overload.limit` is 0, but must lie between"),
    ("[monitor.alarm.slip]\nat_once = 0.01", 2, 11, "slip: `at_once` must be `limit` at least"),
    ("[monitor.alarm.noise]\nlimit = 1", 1, 16, "unknown field `noise`"),
    ("[monitor.temperatures]\nwarm_c = [40, 130]", 2, 10, "`warm_c` must be within `range_c`"),
    ("[monitor.temperatures]\nhold_ms = 1000", 2, 11, "`hold_ms` must be `missing_ms` at least"),
    ("[monitor.tachometer]\ncount_above_rpm = 100", 2, 19, "`period_below_rpm` must be below `count_above_rpm`"),
    ("[monitor.telemetry]\nballs_ms = 0", 2, 12, "must lie between 0.001 and 4000000"),
];

#[test]
fn wrong_text_is_refused_where_it_stands() {
    let above = PAIR.lines().count();
    for (text, line, column, words) in WRONG {
        let told = read(text).expect_err(text);
        let place = format!("s.toml: line {}, column {column}: ", above + line);
        assert!(
            told.starts_with(&place) && told.contains(words),
            "{text}\n{told}"
        );
    }
    let cold = PAIR.replace("[heat]\nreference_c = 20\n", "");
    let text = format!("{cold}[monitor.temperatures]\nnoise_k = 1");
    let told = SpindleFile::parse("s.toml", &text, Path::new(SHIPPED))
        .unwrap_err()
        .to_string();
    assert!(
        told.starts_with("s.toml: line 11, column 11: [monitor.temperatures] is for"),
        "{told}"
    );
    let hot = PAIR.replace("reference_c = 20", "reference_c = 150");
    let told = SpindleFile::parse("s.toml", &hot, Path::new(SHIPPED))
        .unwrap_err()
        .to_string();
    assert!(
        told.starts_with("s.toml: line 3, column 15: `reference_c` must be within"),
        "{told}"
    );
}

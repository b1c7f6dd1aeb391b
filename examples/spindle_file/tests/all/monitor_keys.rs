//! Keys of `[monitor]`: the page against the reader, every key from text to number, refusals by line and column.

use spindle_file::designs::SHIPPED;
use spindle_file::monitors::MonitorFile;
use spindle_file::spindles::SpindleFile;
use spindle_monitor::mock::rig::B7005C;
use spindle_monitor::{Alarm, MonitorSettings, TemperatureSettings};
use std::collections::BTreeSet;
use std::f64::consts::PI;
use std::path::Path;

const PAGE: &str = include_str!("../../../../docs/monitor_keys.md");
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

fn read(text: &str) -> Result<MonitorFile, String> {
    let file = SpindleFile::parse("s.toml", &format!("{PAIR}{text}"), Path::new(SHIPPED));
    file.map(|file| file.monitor)
        .map_err(|error| error.to_string())
}

/// The monitor that a line of `[monitor.TABLE]` makes.
fn with(key: &str, value: &str) -> MonitorFile {
    let text = format!("[monitor]\n{}{key} = {value}\n", surroundings(key));
    read(&text).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

/// Bridges, for their keys.
fn surroundings(key: &str) -> String {
    match key {
        "bridges.tare_samples" => format!("loads = \"bridges\"\nbridges.{COUNTS}\n"),
        "bridges.counts" => "loads = \"bridges\"\n".to_owned(),
        "loads" => format!("bridges.{COUNTS}\n"),
        _ => String::new(),
    }
}

/// Keys of the reader under a table, as `serde` lists them where a key is unknown.
fn keys_under(table: &str, keys: &mut BTreeSet<String>) -> bool {
    let told = read(&format!("[{table}]\nunknown = 0")).unwrap_err();
    let Some((_, expected)) = told.split_once("unknown field `unknown`, expected ") else {
        return false;
    };
    for key in expected.split('`').skip(1).step_by(2) {
        let path = format!("{table}.{key}");
        if !keys_under(&path, keys) {
            keys.insert(path);
        }
    }
    true
}

fn keys_of_reader() -> BTreeSet<String> {
    let mut keys = BTreeSet::new();
    assert!(keys_under("monitor", &mut keys));
    let under = |path: &String| path.strip_prefix("monitor.").unwrap().to_owned();
    keys.iter().map(under).collect()
}

/// Text in code of a cell.
fn code(cell: &str) -> Option<&str> {
    let text = cell.trim().strip_prefix('`')?.strip_suffix('`')?;
    (!text.contains('`')).then_some(text)
}

/// Keys of the page with their defaults, as far as these are values.
fn keys_of_page() -> Vec<(String, Option<String>)> {
    let (mut keys, mut table) = (Vec::new(), "");
    for line in PAGE.lines() {
        if let Some(heading) = line.strip_prefix("## ") {
            let path = code(heading).unwrap().trim_matches(['[', ']']);
            table = path
                .strip_prefix("monitor")
                .unwrap()
                .trim_start_matches('.');
        }
        let cells: Vec<&str> = line.split('|').skip(1).collect();
        let Some(key) = cells.first().and_then(|cell| code(cell)) else {
            continue;
        };
        let value = |cell: &&str| code(cell).map(str::to_owned);
        match (table, cells.len()) {
            ("", _) => keys.push((key.to_owned(), cells.get(2).and_then(value))),
            // Keys of any alarm stand above the table by alarms.
            ("alarm.NAME", 5) => {}
            ("alarm.NAME", _) => {
                for (name, cell) in ["limit", "clear", "hold_ms", "at_once"]
                    .iter()
                    .zip(&cells[2..])
                {
                    keys.push((format!("alarm.{key}.{name}"), value(cell)));
                }
            }
            _ => keys.push((format!("{table}.{key}"), cells.get(2).and_then(value))),
        }
    }
    keys
}

#[test]
fn the_page_has_every_key_of_the_reader_and_no_other() {
    let page: Vec<String> = keys_of_page().into_iter().map(|(key, _)| key).collect();
    let once: BTreeSet<String> = page.iter().cloned().collect();
    assert_eq!(once.len(), page.len());
    assert_eq!(once, keys_of_reader());
}

#[test]
fn a_default_of_the_page_is_that_of_the_reader() {
    let silent = read("").unwrap();
    let mut values = 0;
    for (key, value) in keys_of_page() {
        let Some(value) = value else { continue };
        let mut found = match key.as_str() {
            "loads" => read(&format!("[monitor]\nloads = {value}")).unwrap(),
            key => with(key, &value),
        };
        if key.starts_with("bridges") {
            found.bridges = None;
            found.plausible.speed_stuck_after = 0;
        }
        assert_eq!(found, silent, "{key} = {value}");
        values += 1;
    }
    assert_eq!(values, 2 + 5 + 7 + 15 * 3 + 1 + 7 + 5 + 1 + 6 + 3);
    // Of a pair.
    assert_eq!(silent.telemetry.balls_us, 200_000);
}

fn assert_near(found: f64, truth: f64, by: f64, key: &str) {
    let off = (found - truth).abs();
    assert!(
        found == truth || off <= by * truth.abs(),
        "{key}: {found}, not {truth}"
    );
}

/// A key, its text, what it sets, and the value in SI units.
type Said = (&'static str, &'static str, fn(&MonitorFile) -> f64, f64);

const RAD: f64 = PI / 30.0;

#[rustfmt::skip]
const KEYS: [Said; 64] = [
    ("period_ms", "2", |m| m.period_us.into(), 2000.0),
    ("loads", "\"bridges\"", |m| m.plausible.speed_stuck_after.into(), 10_000.0),
    ("idle.fx_n", "420", |m| m.idle[0], 420.0),
    ("idle.fy_n", "-1", |m| m.idle[1], -1.0),
    ("idle.fz_n", "2", |m| m.idle[2], 2.0),
    ("idle.my_nm", "3", |m| m.idle[3], 3.0),
    ("idle.mz_nm", "4", |m| m.idle[4], 4.0),
    ("plausible.fx_n", "[-100, 900]", |m| m.plausible.load[0][1], 900.0),
    ("plausible.fx_n", "[-100, 900]", |m| m.plausible.load[0][0], -100.0),
    ("plausible.fx_n", "[-100, 900]", |m| m.plausible.load_rate[0], 2e5),
    ("plausible.fx_n", "[-1000, 900]", |m| m.overload[0], 1000.0),
    ("plausible.fx_n", "[-1000, 900]", |m| m.accuracy[0], 10.0),
    ("plausible.fy_n", "[-1, 2]", |m| m.plausible.load[1][1], 2.0),
    ("plausible.fz_n", "[-1, 3]", |m| m.plausible.load[2][1], 3.0),
    ("plausible.my_nm", "[-1, 4]", |m| m.plausible.load[3][1], 4.0),
    ("plausible.mz_nm", "[-1, 5]", |m| m.plausible.load[4][1], 5.0),
    ("plausible.fx_n_per_ms", "1", |m| m.plausible.load_rate[0], 1e3),
    ("plausible.fy_n_per_ms", "2", |m| m.plausible.load_rate[1], 2e3),
    ("plausible.fz_n_per_ms", "3", |m| m.plausible.load_rate[2], 3e3),
    ("plausible.my_nm_per_ms", "4", |m| m.plausible.load_rate[3], 4e3),
    ("plausible.mz_nm_per_ms", "5", |m| m.plausible.load_rate[4], 5e3),
    ("plausible.stuck_after", "7", |m| m.plausible.stuck_after.into(), 7.0),
    ("plausible.missing_ms", "70", |m| m.plausible.missing_after_us.into(), 7e4),
    ("plausible.fresh_ms", "30", |m| m.plausible.fresh_us.into(), 3e4),
    ("plausible.residual_counts", "12", |m| m.plausible.residual, 12.0),
    ("plausible.speed_rpm", "20000", |m| m.plausible.speed, 2e4 * RAD),
    ("plausible.speed_rpm_per_ms", "100", |m| m.plausible.speed_rate, 1e5 * RAD),
    ("plausible.deceleration_rpm_per_s", "9000", |m| m.plausible.deceleration, 9e3 * RAD),
    ("plausible.speed_stuck_after", "60", |m| m.plausible.speed_stuck_after.into(), 60.0),
    ("plausible.speed_difference_rpm", "60", |m| m.plausible.speed_difference[0], 60.0 * RAD),
    ("plausible.speed_difference_percent", "3", |m| m.plausible.speed_difference[1], 0.03),
    ("overload.fx_n", "11", |m| m.overload[0], 11.0),
    ("overload.fy_n", "12", |m| m.overload[1], 12.0),
    ("overload.fz_n", "13", |m| m.overload[2], 13.0),
    ("overload.my_nm", "14", |m| m.overload[3], 14.0),
    ("overload.mz_nm", "15", |m| m.overload[4], 15.0),
    ("accuracy.fx_n", "0", |m| m.accuracy[0], 0.0),
    ("accuracy.fy_n", "2", |m| m.accuracy[1], 2.0),
    ("accuracy.fz_n", "3", |m| m.accuracy[2], 3.0),
    ("accuracy.my_nm", "4", |m| m.accuracy[3], 4.0),
    ("accuracy.mz_nm", "5", |m| m.accuracy[4], 5.0),
    ("temperatures.range_c", "[0, 90]", |m| m.temperatures.range[1], 90.0),
    ("temperatures.difference_k", "30", |m| m.temperatures.difference, 30.0),
    ("temperatures.rate_k_per_s", "0.5", |m| m.temperatures.rate, 0.5),
    ("temperatures.noise_k", "0.2", |m| m.temperatures.noise, 0.2),
    ("temperatures.missing_ms", "3000", |m| m.temperatures.missing_after_us.into(), 3e6),
    ("temperatures.hold_ms", "90000", |m| m.temperatures.hold_us.into(), 9e7),
    ("temperatures.warm_c", "[50, 30]", |m| m.temperatures.warm[0] - m.temperatures.warm[1], 20.0),
    ("tachometer.pulses_per_revolution", "60", |m| m.tachometer.pulses_per_revolution.into(), 60.0),
    ("tachometer.count_above_rpm", "6000", |m| m.tachometer.count_above, 6e3 * RAD),
    ("tachometer.period_below_rpm", "900", |m| m.tachometer.period_below, 900.0 * RAD),
    ("tachometer.gate_ms", "4", |m| m.tachometer.gate_us.into(), 4e3),
    ("tachometer.standstill_ms", "800", |m| m.tachometer.standstill_us.into(), 8e5),
    ("bridges.tare_samples", "200", |m| m.tare_samples.into(), 200.0),
    ("cut.fx_n", "-90", |m| m.cut.0[0], -90.0),
    ("cut.fy_n", "270", |m| m.cut.0[1], 270.0),
    ("cut.fz_n", "135", |m| m.cut.0[2], 135.0),
    ("cut.my_nm", "6", |m| m.cut.0[3], 6.0),
    ("cut.mz_nm", "-13", |m| m.cut.0[4], -13.0),
    ("cut.speed_rpm", "12000", |m| m.cut.1, 12e3 * RAD),
    ("telemetry.estimate_ms", "10", |m| m.telemetry.estimate_us.into(), 1e4),
    ("telemetry.balls_ms", "100", |m| m.telemetry.balls_us.into(), 1e5),
    ("telemetry.health_ms", "2000", |m| m.telemetry.health_us.into(), 2e6),
    ("telemetry.standing_ms", "1.001", |m| m.telemetry.standing_us.into(), 1001.0),
];

/// Units of alarms in a file; the others are 1.
const UNITS: [(Alarm, f64); 8] = [
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
    let mut keys = keys_of_reader();
    for (key, text, value, truth) in KEYS {
        assert_near(value(&with(key, text)), truth, 1e-14, key);
        assert_ne!(value(&read("").unwrap()), truth, "{key}");
        keys.remove(key);
    }
    for (i, alarm) in Alarm::ALL.into_iter().enumerate() {
        let unit = UNITS
            .iter()
            .find(|(of, _)| *of == alarm)
            .map_or(1.0, |(_, unit)| *unit);
        let name = alarm.name();
        let table = "limit = 12\nclear = 11.5\nhold_ms = 77\nat_once = 90";
        let found = read(&format!("[monitor.alarm.{name}]\n{table}"))
            .unwrap()
            .alarms[i];
        assert_eq!((found.name, found.hold_us), (name, 77_000));
        assert_near(found.limit, 12.0 * unit, 1e-14, name);
        assert_near(found.clear, 11.5 * unit, 1e-14, name);
        assert_near(found.at_once, 90.0 * unit, 1e-14, name);
        let grows = matches!(alarm, Alarm::Sensor | Alarm::Temperature);
        let worse = if grows { f64::INFINITY } else { 3.0 * unit };
        assert_near(found.worse, worse, 1e-14, name);
        for key in ["limit", "clear", "hold_ms", "at_once"] {
            keys.remove(&format!("alarm.{name}.{key}"));
        }
    }
    let bridges = with("bridges.counts", COUNTS.split_once(" = ").unwrap().1)
        .bridges
        .unwrap();
    assert_eq!(
        (bridges.counts[5], bridges.counts[3][3]),
        ([300.0, 300.0, 300.0, 0.0, 0.0], 2e4)
    );
    // The loads that counts stand for give back each load.
    for i in 0..5 {
        for j in 0..5 {
            let pairs = bridges.loads.iter().zip(&bridges.counts);
            let product: f64 = pairs.map(|(loads, counts)| loads[i] * counts[j]).sum();
            let unit = bridges
                .counts
                .iter()
                .map(|of| of[j].abs())
                .fold(0.0, f64::max)
                / 500.0;
            let truth = f64::from(u8::from(i == j));
            assert!((product - truth).abs() < 1e-13 * unit, "{i} {j}: {product}");
        }
    }
    keys.remove("bridges.counts");
    assert!(keys.is_empty(), "without a test: {keys:?}");
}

/// Levels that are not said go with the limit.
#[test]
fn a_limit_takes_the_other_levels_along() {
    let alarm = |i: usize, text: &str| {
        let monitor = read(&format!("[monitor.alarm]\n{text}")).unwrap();
        let levels = monitor.alarms[i];
        [levels.limit, levels.clear, levels.at_once]
    };
    let pressure = alarm(0, "peak-pressure.limit = 1.6");
    for (found, truth) in pressure.into_iter().zip([1.6e9, 1.52e9, 2.0e9]) {
        assert_near(found, truth, 1e-14, "peak-pressure");
    }
    let [limit, clear, _] = alarm(1, "contact-angle.limit = -1");
    assert_near(limit, -PI / 180.0, 1e-14, "contact-angle");
    assert_near(clear, -3.0 * PI / 180.0, 1e-14, "contact-angle");
}

/// The monitor's settings to start from: the file rounds angles and speeds in its units.
#[test]
fn defaults_are_the_settings_of_the_monitor() {
    let monitor = read("").unwrap();
    let start = MonitorSettings::<2>::new(&B7005C, 16);
    for (alarm, found) in Alarm::ALL.into_iter().zip(monitor.alarms) {
        let truth = start.alarms.of(alarm);
        assert_eq!((found.name, found.hold_us), (alarm.name(), truth.hold_us));
        for (found, truth) in [
            (found.limit, truth.raise),
            (found.clear, truth.clear),
            (found.at_once, truth.at_once),
            (found.worse, truth.worse),
        ] {
            assert_near(found, truth.into(), 3e-3, alarm.name());
        }
    }
    let (t, truth) = (monitor.temperatures, TemperatureSettings::SPINDLE);
    assert_eq!(
        (t.range, t.warm),
        (truth.range.map(f64::from), truth.warm.map(f64::from))
    );
    let times = [t.missing_after_us, t.hold_us];
    assert_eq!(times, [truth.missing_after_us, truth.hold_us]);
    let found = [t.difference, t.rate, t.noise];
    assert_eq!(
        found,
        [truth.difference, truth.rate, truth.noise].map(f64::from)
    );
    let (t, truth) = (monitor.telemetry, start.telemetry);
    let times = [t.estimate_us, t.balls_us, t.health_us, t.standing_us];
    assert_eq!(
        times,
        [
            truth.estimate_us,
            truth.balls_us,
            truth.health_us,
            truth.standing_us
        ]
    );
    let (p, truth) = (&monitor.plausible, &start.plausibility);
    let [times, truths] = [
        [
            p.missing_after_us,
            p.fresh_us,
            p.stuck_after,
            p.speed_stuck_after,
        ],
        [
            truth.missing_after_us,
            truth.fresh_us,
            truth.stuck_after.into(),
            truth.speed_stuck_after.into(),
        ],
    ];
    assert_eq!(times, truths);
    for (found, truth, by) in [
        (p.speed, truth.speed, 1e-6),
        (p.speed_rate, truth.speed_rate, 1e-3),
        (p.deceleration, truth.deceleration, 0.05),
        (p.speed_difference[0], truth.speed_difference[0], 1e-3),
        (p.speed_difference[1], truth.speed_difference[1], 1e-3),
        (p.residual, truth.residual, 0.0),
    ] {
        assert_near(found, truth.into(), by, "plausible");
    }
    // 6 % of two rows of C = 14.50 kN, and a cutter's moment on an arm of 1.4 pitch diameters.
    let force = 0.06 * 2.0 * 14.50e3;
    let moment = 1.4 * 0.036 * force;
    for (i, most) in [force, force, force, moment, moment]
        .into_iter()
        .enumerate()
    {
        let [low, high] = truth.load[i];
        let (overload, rate) = (start.watch.overload[i], truth.load_rate[i]);
        assert_near(high.into(), most, 1e-3, "range");
        assert_eq!((low, overload), (-high, high));
        for (found, truth) in [
            (p.load[i][1], high),
            (p.load_rate[i], rate),
            (monitor.overload[i], overload),
        ] {
            assert_near(found, truth.into(), 1e-6, "load");
        }
    }
}

/// Formulas of the defaults, on bearings with ratings of their own and in closed form.
#[test]
fn ranges_follow_from_ratings_and_pitch_diameters() {
    let pair = PAIR.replace("b7005c.toml", "gmn:S6014C");
    let listed = SpindleFile::parse("s.toml", &pair, Path::new(SHIPPED)).unwrap();
    let design = &listed.plan.rows[0].design;
    let alone = SpindleFile::read("gmn:S6014C").unwrap();
    let force = alone.monitor.plausible.load[0][1];
    assert_near(
        listed.monitor.plausible.load[1][1],
        2.0 * force,
        1e-14,
        "two rows",
    );
    let moment = alone.monitor.plausible.load[4][1];
    assert_near(moment, 1.4 * design.pitch_diameter * force, 1e-14, "moment");
    let rotation = alone.monitor.plausible.speed / RAD;
    assert_near(rotation * 1e3 * design.pitch_diameter, 1.8e6, 1e-14, "n dm");
    let rated = PAIR.replacen("bearing = \"b7005c.toml\"", "design.name = \"r\"\ndesign.balls = 16\ndesign.ball_diameter_mm = 6.35\n\
        design.pitch_diameter_mm = 36\ndesign.inner_groove_factor = 0.515\ndesign.outer_groove_factor = 0.525\n\
        design.contact_angle_deg = 15\ndesign.dynamic_load_rating_n = 10000", 2);
    let rated = SpindleFile::parse("s.toml", &rated, Path::new(SHIPPED)).unwrap();
    assert_near(
        rated.monitor.plausible.load[2][0],
        -1200.0,
        1e-14,
        "6 % of 2 C",
    );
}

/// Text, the place of its fault counted from the end of the spindle, and words of the message.
#[rustfmt::skip]
const WRONG: [(&str, usize, usize, &str); 32] = [
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

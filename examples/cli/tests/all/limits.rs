//! `cargo replay --limits`: alarms over a recording, those of the firmware.

use crate::malformed::{HEADER, warmed};
use crate::replay::{replayed, scratch, table};
use crate::response::{PROBES, recording};
use cli::milling_cycle::record_of;
use cli::recordings::{self, Wanted};
use cli::stream::per_tick::PerTick;
use cli::stream::{ROOM, TEMPERATURES};
use cli::telemetry::simulated::MONITOR;
use cli::truth::Truth;
use spindle_file::monitors::level;
use spindle_file::mounting::preload;
use spindle_file::spindles::SpindleFile;
use spindle_firmware::chain::{self, Chain};
use spindle_firmware::spindle::{BALLS, FREEDOMS, IDLE, JOINTS, ROWS, SPINDLE};
use spindle_monitor::command::{self, Command, Order, PortReader, Received, Request};
use spindle_monitor::judgement::AlarmChange;
use spindle_monitor::loads::{FramedLoads, LoadSource};
use spindle_monitor::settings::MonitorSettings;
use spindle_monitor::telemetry::{FrameReader, Payload};
use spindle_monitor::tick::{CycleCost, NoCycles, NoWatchdog};
use spindle_monitor::{Alarm, Monitor, Past, Probes, Readings, record};
use std::array::from_fn;
use std::fmt::Write;
use std::path::Path;

const EVENTS: &str = "time_s,alarm,event,value,limit,unit";
const SPINDLES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../spindle_file/spindles");
const SHIPPED: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../firmware/spindle.toml");

/// Alarms of the firmware's chain, which has all over its port: time in ms, name, whether it was raised.
fn of_chain(path: &str) -> Vec<(u64, &'static str, bool)> {
    let probes = Box::leak(Box::new(chain::probes(&MONITOR)));
    let monitor = chain::monitor(probes, &Past::default(), &MONITOR);
    let mut chain = Chain::new(Box::new(monitor));
    chain.prepare().unwrap();
    let mut events = Vec::new();
    let (mut orders, mut raised) = (Vec::new(), [0; Alarm::COUNT]);
    let rows = recordings::read(path, &Wanted::default()).unwrap();
    for (number, tick) in PerTick::new(rows, MONITOR.tick.period_us).enumerate() {
        let tick = tick.unwrap();
        let mut bytes = std::mem::take(&mut orders);
        bytes.extend(record::encode(&tick.record));
        if number % TEMPERATURES == 0 {
            let temperatures = tick.temperatures.unwrap();
            bytes.extend(command::encode(Command::Temperatures(temperatures)));
        }
        for byte in bytes {
            assert_eq!(chain.push(byte, false), None);
        }
        let time_us = number as u64 * u64::from(MONITOR.tick.period_us);
        for change in chain.tick(time_us, &mut NoCycles, &mut NoWatchdog).changes {
            let alarm = change.alarm;
            let is_raised = match change.change {
                AlarmChange::Raised => true,
                AlarmChange::Cleared => false,
                _ => continue,
            };
            events.push((time_us / 1000, alarm.name(), is_raised));
            if is_raised {
                raised[alarm as usize] += 1;
                let raised = raised[alarm as usize];
                let order = Order::Acknowledge {
                    alarm,
                    start: 0,
                    raised,
                };
                let request = Request { number: 0, order };
                orders.extend(command::encode(Command::Ask(request)));
            }
        }
        for _ in 0..ROOM {
            chain.next_byte();
        }
    }
    events
}

#[test]
fn alarms_are_those_of_the_firmware() {
    let path = record_of(ROWS);
    let (status, out, err) = replayed(&[SHIPPED, path, "--limits"], "");
    assert_eq!(status, 0, "{err}");
    let lines = table(&out, EVENTS);
    let found = lines.iter().map(|line| {
        let time: f64 = line[0].parse().unwrap();
        ((time * 1e3).round() as u64, line[1], line[2] != "cleared")
    });
    let found: Vec<_> = found.collect();
    assert!(found.contains(&(9337, "overload", true)), "{out}");
    assert_eq!(found, of_chain(path));
    assert!(err.contains("ticks with doubts: range "), "{err}");
    let page = include_str!("../../../../docs/firmware.md");
    assert!(
        page.contains(&out),
        "docs/firmware.md has other lines than\n{out}"
    );
}

/// The shipped spindle with two probes on a board: all comes over its port, and goes out in its frames.
struct Board {
    monitor: Box<Monitor<ROWS, BALLS, 12, FREEDOMS, JOINTS, 2>>,
    port: PortReader,
    loads: FramedLoads,
    temperatures: Option<[f32; 2]>,
    frames: FrameReader,
    /// Bytes that come in before the next tick.
    bytes: Vec<u8>,
    /// Alarms that were raised or cleared: time in ms, name, whether it was raised, level.
    alarms: Vec<(u64, String, bool, String)>,
    /// Estimates, as `--limits` writes them, and the last ones.
    estimates: Vec<String>,
    last: [String; 3],
}

impl Board {
    fn new(file: &SpindleFile) -> Self {
        static SETTINGS: MonitorSettings<ROWS> = {
            let mut settings = MONITOR;
            settings.tick.cost = CycleCost::CORTEX_M4F.with_probes(2);
            settings
        };
        let response = Box::leak(Box::new(preload::response::<2>(file).unwrap()));
        let probes = Probes::new(response, &SETTINGS.alarms, SETTINGS.tick.period_us);
        let probes = Box::leak(Box::new(probes));
        let mut monitor = Box::new(Monitor::with_probes(&SPINDLE, &SETTINGS, probes));
        monitor.prepare(IDLE).unwrap();
        Self {
            monitor,
            port: PortReader::new(),
            loads: FramedLoads::new(),
            temperatures: None,
            frames: FrameReader::new(),
            bytes: Vec::new(),
            alarms: Vec::new(),
            estimates: Vec::new(),
            last: Default::default(),
        }
    }

    fn tick(&mut self, time_us: u64) {
        for byte in std::mem::take(&mut self.bytes) {
            match self.port.push(byte) {
                Some(Ok(Received::Record(record))) => self.loads.take(Ok(record)),
                Some(Ok(Received::Command(Command::Temperatures(read)))) => {
                    self.temperatures = Some(read);
                }
                Some(Ok(Received::Command(Command::Probes(read)))) => {
                    let measured = from_fn(|i| read.get(i).copied());
                    self.monitor.note_displacements(measured);
                }
                Some(Ok(Received::Command(Command::Ask(request)))) => {
                    self.monitor.ask(&request, true);
                }
                Some(other) => panic!("{other:?}"),
                None => {}
            }
        }
        let readings = Readings {
            loads: self.loads.sample(time_us),
            speed: None,
            temperatures: self.temperatures.take(),
        };
        self.monitor
            .tick(time_us, &readings, &mut NoCycles, &mut NoWatchdog);
        for _ in 0..ROOM {
            let byte = self.monitor.outbox().next_byte();
            let Some(frame) = byte.and_then(|byte| self.frames.push(byte)) else {
                continue;
            };
            let frame = frame.unwrap();
            match frame.payload {
                Payload::Alarm(report) => {
                    let is_raised = match report.change {
                        AlarmChange::Raised => true,
                        AlarmChange::Cleared => false,
                        _ => continue,
                    };
                    let alarm = report.alarm;
                    let value = level(alarm, report.value.into()).to_string();
                    let name = alarm.name().to_owned();
                    let time = frame.time_us / 1000;
                    self.alarms.push((time, name, is_raised, value));
                    if is_raised {
                        self.ask(Order::Acknowledge {
                            alarm,
                            start: 0,
                            raised: report.raised,
                        });
                    }
                }
                Payload::Probes(report) => {
                    let time = frame.time_us as f64 / 1e6;
                    let preload = report.preload.unwrap().value;
                    let [axial, nose] = [0, 1].map(|i| &report.probes[i]);
                    let lines = [
                        format!("preload,{},{preload:.0},,N", report.state.name()),
                        format!(
                            "probe axial,{},{:.1},,%",
                            axial.state.name(),
                            100.0 * axial.gain.value
                        ),
                        format!(
                            "probe nose,{},{:.1},,%",
                            nose.state.name(),
                            100.0 * nose.gain.value
                        ),
                    ];
                    for line in lines.iter().filter(|line| !self.last.contains(line)) {
                        self.estimates.push(format!("{time},{line}"));
                    }
                    self.last = lines;
                }
                _ => {}
            }
        }
    }

    fn ask(&mut self, order: Order) {
        let request = Request { number: 0, order };
        self.bytes.extend(command::encode(Command::Ask(request)));
    }
}

/// A loss of preload after commissioning, then an axial probe whose readings do not change.
#[test]
fn alarms_and_estimates_of_probes_are_those_of_the_board() {
    let path = scratch("probed.toml");
    let text = std::fs::read_to_string(SHIPPED).unwrap();
    let folder = Path::new(SHIPPED).parent().unwrap().to_str().unwrap();
    let text = text.replace("\"../", &format!("\"{folder}/../")) + PROBES;
    std::fs::write(&path, &text).unwrap();
    let truth = Truth {
        preload: [230.0, 160.0],
        change: 52.0,
        ..Truth::SOUND
    };
    let mut csv = recording(truth, 66.0);
    csv = csv
        .lines()
        .enumerate()
        .map(|(i, line)| {
            let mut fields: Vec<&str> = line.split(',').collect();
            if i > 60_000 {
                fields[7] = "40";
            }
            fields.join(",") + "\n"
        })
        .collect();
    let csv = warmed(&csv);
    let path = path.to_str().unwrap();
    let (status, out, err) = replayed(&[path, "-", "--limits"], &csv);
    assert_eq!(status, 0, "{err}");

    let file = SpindleFile::parse(path, &text, Path::new(folder)).unwrap();
    let mut board = Board::new(&file);
    let wanted = Wanted {
        probes: file.probes.iter().map(|probe| probe.name.clone()).collect(),
        ..Wanted::default()
    };
    let csv = Box::new(std::io::Cursor::new(csv));
    let rows = recordings::Loads::from_reader("", csv, &wanted).unwrap();
    for (number, tick) in PerTick::new(rows, MONITOR.tick.period_us).enumerate() {
        let tick = tick.unwrap();
        let probes = tick.probes.map(|um| um.unwrap_or(f32::NAN));
        board.bytes.extend(command::encode(Command::Probes(probes)));
        board.bytes.extend(record::encode(&tick.record));
        if number % TEMPERATURES == 0 {
            let temperatures = Command::Temperatures([25.0, 22.0]);
            board.bytes.extend(command::encode(temperatures));
        }
        board.tick(1000 * number as u64);
    }
    let lines = table(&out, EVENTS);
    let is_estimate = |line: &&Vec<&str>| line[1] == "preload" || line[1].starts_with("probe ");
    let (estimates, alarms): (Vec<_>, Vec<_>) = lines.iter().partition(is_estimate);
    let estimates: Vec<String> = estimates.iter().map(|line| line.join(",")).collect();
    assert_eq!(estimates, board.estimates);
    let alarms = alarms.iter().map(|line| {
        let time: f64 = line[0].parse().unwrap();
        let time = (time * 1e3).round() as u64;
        let [name, value] = [line[1], line[3]].map(str::to_owned);
        (time, name, line[2] != "cleared", value)
    });
    assert_eq!(alarms.collect::<Vec<_>>(), board.alarms);
    for told in [
        "preload-change,raised",
        ",probe,raised",
        "preload,preload-loss,1",
        "probe axial,probe,",
    ] {
        assert!(out.contains(told), "{told}:\n{out}");
    }
    std::fs::remove_file(path).unwrap();
}

/// A recording every 10 ms, with 2000 N instead of 50 N from 1 s to 2 s, of a spindle that may carry 1000 N.
#[test]
fn an_overload_is_raised_after_its_hold_time_and_cleared() {
    let path = scratch("limits.toml");
    let text = std::fs::read_to_string(format!("{SPINDLES}/7014c_qbc.toml")).unwrap();
    let text = text.replace("../bearings", &format!("{SPINDLES}/../bearings"));
    let text = text + "\n[monitor.overload]\nfx_n = 1000\n";
    std::fs::write(&path, text).unwrap();
    let mut loads = HEADER.to_owned();
    for i in 0..300 {
        let (time, wobble) = (40.0 + f64::from(i) / 100.0, i % 7);
        let fx = wobble + if (100..200).contains(&i) { 2000 } else { 50 };
        writeln!(
            loads,
            "{time},{fx},30{wobble},4{wobble},1.{wobble},2.{wobble},9000"
        )
        .unwrap();
    }
    let path = path.to_str().unwrap();
    let (status, out, err) = replayed(&[path, "-", "--limits"], &loads);
    assert_eq!(status, 0, "{err}");
    let expected = "41.003,overload,raised,200.2,100,%\n42.012,overload,cleared,5.5,90,%\n";
    assert_eq!(out, format!("{EVENTS}\n{expected}"), "{err}");
    assert!(
        err.contains("2991 ticks of 1 ms: 2691 hold the record"),
        "{err}"
    );
    let fallen = loads + "1,0,0,0,0,0,0\n";
    let (status, _, err) = replayed(&[path, "-", "--limits"], &fallen);
    assert_eq!(status, 2);
    assert!(
        err.contains("standard input: time_s is 1 after 42.99, but must not fall"),
        "{err}"
    );
    std::fs::remove_file(path).unwrap();
}

/// Two rows of 40 balls, for which a tick of the smaller board has no time.
#[test]
fn a_spindle_of_the_larger_board_has_a_monitor_there_alone() {
    let (bearing, path) = (scratch("forty.toml"), scratch("forties.toml"));
    let of = std::fs::read_to_string(format!("{SPINDLES}/../bearings/b7005c.toml")).unwrap();
    let of = of.replace("balls = 16", "balls = 40");
    std::fs::write(
        &bearing,
        of.replace("ball_diameter_mm = 6.35", "ball_diameter_mm = 2.5"),
    )
    .unwrap();
    let text = std::fs::read_to_string(SHIPPED).unwrap();
    let text = text.replace(
        "../spindle_file/bearings/b7005c.toml",
        bearing.to_str().unwrap(),
    );
    std::fs::write(&path, text.replace("preload_n = 250", "preload_n = 50")).unwrap();
    let (path, loads) = (
        path.to_str().unwrap(),
        warmed(&format!("{HEADER}0,5,30,-4,1,2,900\n1,5,1,1,1,1,900\n")),
    );
    let args = [path, "-", "--limits"];
    let (status, _, err) = replayed(&args, &loads);
    assert_eq!(status, 2, "{err}");
    assert!(err.contains("on the STM32F405 has no time"), "{err}");
    let (status, out, err) = replayed(&[&args[..], &["--board", "h743"]].concat(), &loads);
    assert_eq!(status, 0, "{err}");
    assert!(out.starts_with(EVENTS), "{out}");
    std::fs::remove_file(path).unwrap();
    std::fs::remove_file(bearing).unwrap();
}

#[test]
fn every_shipped_spindle_has_a_monitor() {
    for entry in std::fs::read_dir(SPINDLES).unwrap() {
        let path = entry.unwrap().path();
        let path = path.to_str().unwrap();
        let loads =
            format!("{HEADER}0,50,300,-40,1,2,9000\n0.1,nan,300,-40,1,2,9000\n1,50,1,1,1,1,9000\n");
        let is_warm = std::fs::read_to_string(path).unwrap().contains("\n[heat]");
        let loads = match is_warm {
            true => warmed(&loads),
            false => loads,
        };
        let (status, out, err) = replayed(&[path, "-", "--limits"], &loads);
        assert_eq!(status, 0, "{path}: {err}");
        // No number for 0.9 s.
        assert!(out.contains("sensor,raised,0.1,0.1,s"), "{path}: {out}");
    }
    let (status, _, err) = replayed(&[SHIPPED, "-", "--limits", "--summary"], "");
    assert_eq!(status, 2);
    assert!(err.contains("cannot be used with"), "{err}");
}

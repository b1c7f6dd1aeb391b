//! `cargo replay --limits`: alarms over a recording, those of the firmware.

use crate::malformed::HEADER;
use crate::replay::{replayed, scratch, table};
use cli::import::Wanted;
use cli::milling_cycle::record_of;
use cli::recordings;
use cli::stream::per_tick::PerTick;
use cli::stream::{ROOM, TEMPERATURES};
use cli::telemetry::simulated::MONITOR;
use spindle_firmware::chain::{self, Chain};
use spindle_firmware::spindle::ROWS;
use spindle_monitor::command::{self, Command, Order, Request};
use spindle_monitor::judgement::AlarmChange;
use spindle_monitor::tick::{NoCycles, NoWatchdog};
use spindle_monitor::{Alarm, Past, record};
use std::fmt::Write;

const EVENTS: &str = "time_s,alarm,event,value,limit,unit";
const SPINDLES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../spindle_file/spindles");
const SHIPPED: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../firmware/spindle.toml");

/// Alarms of the firmware's chain, which has all over its port: time in ms, name, whether it was raised.
fn of_chain(path: &str) -> Vec<(u64, &'static str, bool)> {
    let monitor = chain::monitor(&Past::default(), &MONITOR);
    let mut chain = Chain::new(Box::new(monitor));
    chain.prepare().unwrap();
    let mut events = Vec::new();
    let (mut orders, mut raised) = (Vec::new(), [0; Alarm::COUNT]);
    let rows = recordings::read(path, None, &Wanted::default()).unwrap();
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
        format!("{HEADER}0,5,30,-4,1,2,900\n1,5,1,1,1,1,900\n"),
    );
    let given = ["--t_inner", "25", "--t_outer", "22"];
    let args = [&[path, "-", "--limits"], &given[..]].concat();
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
        let mut args = vec![path, "-", "--limits"];
        if std::fs::read_to_string(path).unwrap().contains("\n[heat]") {
            args.extend(["--t_inner", "25", "--t_outer", "22"]);
        }
        let (status, out, err) = replayed(&args, &loads);
        assert_eq!(status, 0, "{path}: {err}");
        // No number for 0.9 s.
        assert!(out.contains("sensor,raised,0.1,0.1,s"), "{path}: {out}");
    }
    let (status, _, err) = replayed(&[SHIPPED, "-", "--limits", "--summary"], "");
    assert_eq!(status, 2);
    assert!(err.contains("cannot be used with"), "{err}");
}

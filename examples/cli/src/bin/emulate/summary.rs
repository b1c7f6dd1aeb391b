//! Counts of a run for a golden file, which holds for every build of the solver that is right. Left out are measured
//! digits, and counts that depend on how fast the solver follows the loads.

use crate::exchange::Answer;
use crate::plan::Plan;
use anyhow::{Context, Result, ensure};
use cli::stream::faults;
use spindle_file::monitors::against;
use spindle_monitor::judgement::AlarmChange;
use spindle_monitor::telemetry::Payload;
use spindle_monitor::{Alarm, Mark, Marks};
use std::fmt::Write;
use std::fs;
use std::iter;
use std::path::Path;

/// Reports of an alarm.
#[derive(Debug, Clone, Copy, Default)]
struct Story {
    raised: u32,
    cleared: u32,
    acknowledged: u32,
}

/// The counts of a run, from the board's own telemetry. Marks tick by tick, and counters at the end, are the twin's, whose telemetry
/// equals the board's.
///
/// # Errors
///
/// An alarm was not told of, or a self-check failed.
pub fn summary(plan: &Plan, answer: &Answer) -> Result<String> {
    let mut alarms = [Story::default(); Alarm::COUNT];
    let [mut reports, mut answers, mut probes] = [0_u64; 3];
    for frame in &answer.frames {
        match &frame.payload {
            Payload::Alarm(report) => {
                let story = &mut alarms[report.alarm as usize];
                story.raised = story.raised.max(report.raised);
                story.cleared = story.cleared.max(report.cleared);
                story.acknowledged += u32::from(report.change == AlarmChange::Acknowledged);
            }
            Payload::Health(_) => reports += 1,
            Payload::Answer(_) => answers += 1,
            Payload::Probes(_) => probes += 1,
            Payload::Hello(report) => {
                ensure!(
                    !report.board.is_broken(),
                    "a self-check of the board failed: {report:?}"
                );
            }
            _ => {}
        }
    }
    let health = &plan.ending.health;
    let total = |count: fn(&Story) -> u32| alarms.iter().map(|story| u64::from(count(story))).sum();
    let told: [u64; 2] = [total(|story| story.raised), total(|story| story.cleared)];
    let counted = [health.alarms_raised, health.alarms_cleared];
    ensure!(
        told == counted,
        "an alarm was lost: {told:?} raised and cleared were told of, but there were {counted:?}"
    );

    let mut text = String::new();
    let mut line = |name: &str, count: u64| writeln!(text, "{name:<34}{count:>9}");
    for fault in faults::names() {
        let episodes = plan.episodes.iter();
        let count = episodes.filter(|episode| episode.name() == fault).count();
        if count > 0 {
            line(&format!("fault: {fault}"), count as u64)?;
        }
    }
    for (name, count) in [
        ("ticks", health.ticks),
        ("ticks missed", health.missed_ticks),
        ("overruns", health.overruns),
        ("records received", plan.ending.counts.received),
        ("records corrupt", plan.ending.counts.corrupt),
        ("records lost", plan.ending.counts.lost),
        ("records out of order", plan.ending.counts.disordered),
        ("records late", plan.ending.counts.late),
    ] {
        line(name, count)?;
    }
    for (mark, count) in Marks::all().iter().zip(plan.ending.marks) {
        if count > 0 && mark != Mark::Unsolved {
            line(&format!("ticks marked {mark}"), count)?;
        }
    }
    for (alarm, story) in Alarm::ALL.iter().zip(alarms) {
        for (what, count) in [
            ("raised", story.raised),
            ("cleared", story.cleared),
            ("acknowledged", story.acknowledged),
        ] {
            if count > 0 && MEASURED.contains(alarm) {
                line(&format!("alarm {alarm} {what}"), count.into())?;
            }
        }
    }
    line("frames of health", reports)?;
    line("frames of answers", answers)?;
    if probes > 0 {
        line("frames of probes", probes)?;
    }
    let solved = 100 * health.estimates / (health.estimates + health.refusals).max(1);
    let name = format!("good samples solved, %, up to {ENOUGH}");
    line(&name, solved.min(ENOUGH))?;
    Ok(text)
}

/// Alarms that the board has told of, in the order of time, and the ages of its estimates.
pub fn seen(answer: &Answer) -> String {
    let (mut text, mut ages) = (String::new(), Vec::new());
    for frame in &answer.frames {
        match &frame.payload {
            Payload::Alarm(report) if report.change != AlarmChange::Standing => {
                let (time, of) = (frame.time_us as f64 * 1e-6, report);
                text += &format!(
                    "{time:9.3} s: {} {}, {}\n",
                    of.alarm,
                    format!("{:?}", of.change).to_lowercase(),
                    against(of.alarm, of.value, of.limit)
                );
            }
            Payload::Estimate(report) => ages.push(report.age),
            _ => {}
        }
    }
    ages.sort_unstable();
    if let (Some(median), Some(oldest)) = (ages.get(ages.len() / 2), ages.last()) {
        text += &format!("estimates {median} ticks old, at most {oldest}\n");
    }
    text
}

/// Share of solved samples, among those in order, that is enough, in percent. In most of the other
/// ticks, a load moves farther than their budget reaches.
const ENOUGH: u64 = 99;

/// Alarms of measured quantities. All others, and marks of an unsolved tick, depend on how fast the solver follows the loads.
const MEASURED: [Alarm; 3] = [Alarm::Overload, Alarm::Sensor, Alarm::Temperature];

/// Holds a summary against the golden file, or writes it again.
///
/// # Errors
///
/// The first line that differs.
pub fn check(path: &Path, text: &str, accept: bool) -> Result<()> {
    let name = path.display();
    if accept {
        fs::write(path, text).with_context(|| format!("cannot write {name}"))?;
        println!("accepted: {name}");
    } else if path.exists() {
        let golden = fs::read_to_string(path).with_context(|| format!("cannot read {name}"))?;
        let (mut expected, mut found) = (golden.lines(), text.lines());
        let difference = iter::from_fn(|| Some((expected.next(), found.next())))
            .take_while(|pair| *pair != (None, None))
            .find(|(expected, found)| expected != found);
        ensure!(
            difference.is_none(),
            "the summary is not that of {name}; first expected and found: {difference:?}. If that is right, accept it: the \
             same command with --accept"
        );
        println!("all as expected by {name}");
    } else {
        println!("there is no golden file for this run, {name}; `--accept` makes it");
    }
    Ok(())
}

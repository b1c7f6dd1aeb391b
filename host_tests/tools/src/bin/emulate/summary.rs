//! What a run comes to: counts and names, no measured digits, so that a golden file of it holds for
//! every build of the solver that is right.

use crate::exchange::Answer;
use crate::monitor_settings::MONITOR;
use crate::monitored::{BALLS, ROWS};
use crate::plan::Plan;
use anyhow::{Context, Result, bail, ensure};
use spindle_bearing::monitor::judgement::AlarmChange;
use spindle_bearing::monitor::telemetry::{HealthReport, Payload};
use spindle_bearing::monitor::{Alarm, Mark};
use std::collections::BTreeMap;
use std::fmt::Write;
use std::fs;
use std::path::Path;
use tools::report::{FIGURES, Figures};

/// Reports of an alarm.
#[derive(Debug, Clone, Copy, Default)]
struct Story {
    raised: u32,
    cleared: u32,
    acknowledged: u32,
}

/// The counts of a run, from the board's own telemetry; marks tick by tick, which no telemetry could hold,
/// are those of the host's build, which the telemetry has been found equal to.
///
/// # Errors
///
/// The board's counters do not agree with themselves.
pub fn summary(plan: &Plan, answer: &Answer) -> Result<String> {
    let mut text = String::new();
    let mut health: Option<HealthReport> = None;
    let mut alarms = [Story::default(); Alarm::COUNT];
    let mut kinds = [0_u64; 7];
    for frame in &answer.frames {
        match &frame.payload {
            Payload::Estimate(_) => kinds[0] += 1,
            Payload::Balls(_) => kinds[1] += 1,
            Payload::Alarm(report) => {
                kinds[2] += 1;
                let story = &mut alarms[report.alarm as usize];
                story.raised = story.raised.max(report.raised);
                story.cleared = story.cleared.max(report.cleared);
                story.acknowledged += u32::from(report.change == AlarmChange::Acknowledged);
            }
            Payload::Health(report) => {
                kinds[3] += 1;
                health = Some(*report);
            }
            Payload::Inputs(_) => kinds[4] += 1,
            Payload::Answer(_) => kinds[5] += 1,
            Payload::Rows(_) => kinds[6] += 1,
            Payload::Board(report) => {
                ensure!(
                    !report.is_broken(),
                    "a self-check of the board failed: {report:?}"
                );
            }
            Payload::Start(_) | Payload::Shaft(_) => {}
        }
    }
    let health = health.context("the board has sent no counters")?;
    let (raised, cleared) = alarms.iter().fold((0, 0), |(raised, cleared), story| {
        (
            raised + u64::from(story.raised),
            cleared + u64::from(story.cleared),
        )
    });
    // The counters went out before that tick's own alarms could change any more.
    ensure!(
        (raised, cleared) == (health.alarms_raised, health.alarms_cleared),
        "an alarm was lost: {raised} raised and {cleared} cleared were told of, but there were {} and {}",
        health.alarms_raised,
        health.alarms_cleared
    );
    ensure!(
        health.ticks + 1 == plan.health.ticks,
        "ticks were lost: {} of {}",
        health.ticks + 1,
        plan.health.ticks
    );

    let mut line = |name: &str, count: u64| writeln!(text, "{name:<34}{count:>9}");
    let mut faults: BTreeMap<_, u64> = BTreeMap::new();
    for episode in &plan.episodes {
        *faults.entry(episode.fault).or_default() += 1;
    }
    for (fault, count) in faults {
        line(&format!("fault: {fault}"), count)?;
    }
    for (name, count) in [
        ("ticks", health.ticks),
        ("ticks missed", health.missed_ticks),
        ("overruns", health.overruns),
        ("records received", plan.counts.received),
        ("records corrupt", plan.counts.corrupt),
        ("records lost", plan.counts.lost),
        ("records out of order", plan.counts.disordered),
        ("records late", plan.counts.late),
        ("estimates", health.estimates),
        ("refusals", health.refusals),
        ("samples marked", health.marked_samples),
    ] {
        line(name, count)?;
    }
    for (mark, count) in Mark::ALL.iter().zip(plan.marks) {
        if count > 0 {
            line(&format!("ticks marked {mark}"), count)?;
        }
    }
    line("alarms raised", raised)?;
    line("alarms cleared", cleared)?;
    let acknowledged = alarms
        .iter()
        .map(|story| u64::from(story.acknowledged))
        .sum();
    line("alarms acknowledged", acknowledged)?;
    for (alarm, story) in Alarm::ALL.iter().zip(alarms) {
        for (what, count) in [
            ("raised", story.raised),
            ("cleared", story.cleared),
            ("acknowledged", story.acknowledged),
        ] {
            if count > 0 {
                line(&format!("alarm {alarm} {what}"), count.into())?;
            }
        }
    }
    for (name, count) in [
        "estimates",
        "balls",
        "alarms",
        "health",
        "inputs",
        "answers",
        "rows",
    ]
    .iter()
    .zip(kinds)
    {
        line(&format!("frames of {name}"), count)?;
    }
    line("frames dropped", health.frames_dropped)?;
    line("alarms that stand at the end", raised - cleared)?;
    let solved = 100 * health.estimates / (health.estimates + health.refusals).max(1);
    line(&format!("{SOLVED} %, up to {ENOUGH}"), solved.min(ENOUGH))?;
    Ok(text)
}

/// Share of the samples in order that are solved, in percent, which is enough: most of the rest are ticks for which
/// a load moves farther than their budget reaches.
const ENOUGH: u64 = 99;
const SOLVED: &str = "good samples solved,";

/// Beginnings of the lines that depend on how fast the solver follows the loads, and not on whether it is right: no
/// golden file has them.
const FREE: [&str; 13] = [
    "estimates ",
    "refusals ",
    "samples marked ",
    "ticks marked unsolved ",
    "alarms raised ",
    "alarms cleared ",
    "alarms acknowledged ",
    "frames of estimates ",
    "frames of balls ",
    "frames of rows ",
    "frames of alarms ",
    "frames dropped ",
    "alarms that stand ",
];

/// Beginnings of the lines about alarms that a golden file has: alarms of what is measured, which take no solve.
const MEASURED_ALARMS: [&str; 3] = ["alarm overload ", "alarm sensor ", "alarm temperature "];

/// The lines that a golden file has.
fn kept(text: &str) -> String {
    let begins = |line: &str, with: &[&str]| with.iter().any(|start| line.starts_with(start));
    let is_kept = |line: &&str| match line.starts_with("alarm ") {
        true => begins(line, &MEASURED_ALARMS),
        false => !begins(line, &FREE),
    };
    text.lines()
        .filter(is_kept)
        .flat_map(|line| [line, "\n"])
        .collect()
}

/// What a tick takes of its period, as `cargo reports` has measured it on a modelled core, and what the
/// bound on iterations leaves.
pub fn budget(figures: &Figures) -> Result<String> {
    let tick = &MONITOR.tick;
    let deadline = u64::from(tick.deadline_cycles);
    let share = |cycles: u64| {
        let left = deadline as f64 - cycles as f64;
        let percent = |cycles: f64| 100.0 * cycles / deadline as f64;
        format!(
            "{cycles:>7} cycles, {:4.1} %, margin {left:>6.0} cycles, {:4.1} %",
            percent(cycles as f64),
            percent(left)
        )
    };
    let mut text = format!(
        "budget of a tick: {deadline} cycles in {} us (modelled, +-15 %, no wait states)",
        tick.period_us
    );
    for stat in ["median", "99 %", "worst"] {
        let name = format!("{MEASURED}: cycles of a tick with a warm solve, {stat}");
        let cycles = figures.get(&name).with_context(|| {
            format!("{FIGURES} has no `{name}`; `cargo reports monitor` adds it")
        })?;
        write!(
            text,
            "\n  a tick with a full warm solve, {stat:<6} {}",
            share(*cycles)
        )?;
    }
    let iterations = tick.max_iterations();
    write!(
        text,
        "\n  bound, {iterations} iteration{} of {ROWS} x {BALLS} balls allowed   {}\n  \
         which is {} for everything but iterations, in all ticks but one in a thousand, and {iterations} iterations of {}",
        if iterations == 1 { " " } else { "s" },
        share(tick.most_cycles()),
        tick.cost.fixed,
        tick.cost.iteration,
    )?;
    Ok(text)
}

/// The board's core and precision, as figures name them.
const MEASURED: &str = "Cortex-M4F, f32, monitor";

/// Holds a summary against the golden file, or writes it again.
///
/// # Errors
///
/// The first line that differs.
pub fn check(path: &Path, text: &str, accept: bool) -> Result<()> {
    let name = path.display();
    let text = &kept(text);
    if accept {
        if let Some(folder) = path.parent() {
            fs::create_dir_all(folder)?;
        }
        fs::write(path, text).with_context(|| format!("cannot write {name}"))?;
        println!("accepted: {name}");
        return Ok(());
    }
    if !path.exists() {
        println!("there is no golden file for this run, {name}; `--accept` makes it");
        return Ok(());
    }
    let golden = fs::read_to_string(path).with_context(|| format!("cannot read {name}"))?;
    if let Some(difference) = first_difference(&golden, text) {
        bail!(
            "the summary is not that of {name}:\n{difference}\nif that is right, accept it: the same \
             command with --accept"
        );
    }
    println!("all as expected by {name}");
    Ok(())
}

fn first_difference(golden: &str, text: &str) -> Option<String> {
    let (mut a, mut b) = (golden.lines(), text.lines());
    loop {
        match (a.next(), b.next()) {
            (None, None) => return None,
            (a, b) if a == b => {}
            (a, b) => {
                let of = |line: Option<&str>| line.unwrap_or("(nothing)").to_owned();
                return Some(format!("  expected: {}\n  is:       {}", of(a), of(b)));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use spindle_bearing::monitor::tick::CycleCost;

    #[test]
    fn the_line_that_differs_is_shown() {
        assert_eq!(first_difference("a 1\nb 2\n", "a 1\nb 2\n"), None);
        for (text, is) in [("a 1\nb 3\n", "b 3"), ("a 1\n", "(nothing)")] {
            let difference = first_difference("a 1\nb 2\n", text).unwrap();
            assert_eq!(difference, format!("  expected: b 2\n  is:       {is}"));
        }
    }

    #[test]
    fn a_golden_file_has_nothing_that_depends_on_how_fast_a_solve_is() {
        let text = "ticks 10\nrefusals 3\nalarm peak-pressure raised 1\nalarm sensor raised 2\n\
                    alarm availability raised 1\nalarms that stand at the end 1\n";
        assert_eq!(kept(text), "ticks 10\nalarm sensor raised 2\n");
    }

    #[test]
    fn the_longest_tick_fits_its_period() {
        let tick = &MONITOR.tick;
        assert!(tick.max_iterations() >= 3, "{tick:?}");
        assert!(
            tick.most_cycles() <= tick.deadline_cycles.into(),
            "{tick:?}"
        );
        assert_eq!((tick.period_us, tick.deadline_cycles), (1000, 168_000));
    }

    #[test]
    fn the_deadline_rests_on_the_committed_figures() {
        let root = tools::root();
        let figures = tools::report::figures(root).unwrap();
        for (cost, core) in [
            (CycleCost::CORTEX_M4F, MEASURED),
            (CycleCost::CORTEX_M7, "Cortex-M7, f64, monitor"),
        ] {
            let figure = |metric| figures[&format!("{core}: cycles of {metric}")];
            assert_eq!(
                u64::from(cost.fixed),
                figure("a tick but for iterations, of all but one in a thousand")
            );
            assert_eq!(u64::from(cost.iteration), figure("an iteration"));
        }
        let budget = budget(&figures).unwrap();
        assert_eq!(budget.matches("margin").count(), 4, "{budget}");
    }
}

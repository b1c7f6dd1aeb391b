//! The page of the campaign.

use crate::preload::constants::{ALL, Constant};
use crate::preload::spindles::Kind;
use crate::preload::{Campaign, Found, Row, What};
use crate::progress::Progress;
use spindle_monitor::estimator::State;
use std::fmt::Write;

const ABOUT: &str = "# Campaign of measured preloads

Each run draws a spindle that is another one than its file's: mounted preload 30 % more to 30 % less, gains of load cells within 3 %,
cross-talk of each into each within 2 % (a moment as a force at 50 mm), gains of probes within 10 %, the radial probe turned by up to 20
degrees, supports 0.7 to 1.5 times the file's, temperatures up to 0.5 K off and wandering by 0.1 K. The temperatures of a sound spindle
are lost for a tenth of the time. An axial and a radial probe are at -10 mm.

It cuts with 16 tools of 60 to 300 N radially, up to 200 N axially and 20 to 80 mm in front of the nose, at five speeds of 6,300 to
17,700 rpm, 0.36 to 1.43 times as deep, eight load steps each. Probes have 0.2 um of noise a sample, 3 um of runout and drift by 5 um/h.

*shipped*: the spindle of the firmware; *elastic pair*: two S 6005 C with 250 N as mounted; *face to face*: the shipped rows turned.

- Steps: the median and the largest number in all runs; *never*: runs without.
- *False alarms*: runs in which each alarm was raised.
- *Preload*: error of ln preload, standard error that the monitor states, reports within two of them.
- *Wrong*: `ok` with a preload beyond three standard errors.
";

/// Rows and all of their runs.
type Runs = [(Row, Vec<Found>)];

/// The median and the largest of these; how many runs have none, if some.
fn spread(all: impl Iterator<Item = Option<usize>>) -> String {
    let mut all: Vec<_> = all.map(|x| x.unwrap_or(usize::MAX)).collect();
    all.sort_unstable();
    let there = all.partition_point(|x| *x < usize::MAX);
    let Some(worst) = all[..there].last() else {
        return "-".to_owned();
    };
    let median = all.get(all.len() / 2).filter(|x| **x < usize::MAX);
    let median = median.map_or("-".to_owned(), usize::to_string);
    match all.len() - there {
        0 => format!("{median}, {worst}"),
        none => format!("{median}, {worst} ({none} never)"),
    }
}

/// How many runs are so.
fn count(founds: &[Found], is_so: impl Fn(&Found) -> bool) -> usize {
    founds.iter().filter(|found| is_so(found)).count()
}

/// What all reports have of something, over their number.
fn mean(founds: &[Found], of: impl Fn(&Found) -> f64) -> f64 {
    let reports: usize = founds.iter().map(|found| found.reports).sum();
    founds.iter().map(of).sum::<f64>() / reports.max(1) as f64
}

/// Part of the reports that are so, in percent.
fn part(founds: &[Found], of: impl Fn(&Found) -> usize) -> f64 {
    100.0 * mean(founds, |found| of(found) as f64)
}

/// Runs with each alarm.
fn alarms(founds: &[Found]) -> String {
    let of = |i: usize| count(founds, |found| found.raised[i] > 0).to_string();
    [0, 1, 2, 3].map(of).join("; ")
}

/// Standard deviation of ln preload from what it is, its mean standard error, and the part of reports that are within two of them.
fn preload(founds: &[Found]) -> String {
    format!(
        "{:.1} %; {:.1} %; {:.0} %",
        100.0 * mean(founds, |found| found.squares).sqrt(),
        100.0 * mean(founds, |found| found.stated),
        part(founds, |found| found.within)
    )
}

/// The table of spindles that nothing changes.
fn sound(rows: &Runs) -> String {
    let mut text = "| spindle | truth | commissioned after | false alarms: preload-change; stiffness-loss; stiffness-gain; probe | \
        preload: rms; stated; within two errors | `ok` | of which wrong | `unexplained` |\n\
        | --- | --- | --- | --- | --- | ---: | ---: | ---: |\n"
        .to_owned();
    for (row, founds) in rows
        .iter()
        .filter(|(row, _)| matches!(row.what, What::Nothing | What::OneCut))
    {
        let _ = writeln!(
            text,
            "| {} | {} | {} | {} | {} | {:.0} % | {:.1} % | {:.1} % |",
            row.kind.name(),
            row.name,
            spread(founds.iter().map(|found| found.commissioned)),
            alarms(founds),
            preload(founds),
            part(founds, |found| found.ok),
            part(founds, |found| found.wrong),
            part(founds, |found| found.unexplained),
        );
    }
    text
}

/// The table of changes.
fn changes(rows: &Runs) -> String {
    let mut text = "| spindle | change | preload-change after | stiffness-loss | stiffness-gain | probe | \
        ln preload at the end; gains, axial and radial |\n| --- | --- | --- | --- | --- | --- | --- |\n"
        .to_owned();
    let is_change = |what: What| !what.is_always() && !matches!(what, What::Probe(..));
    for (row, founds) in rows.iter().filter(|(row, _)| is_change(row.what)) {
        let alarms = [0, 1, 2, 3].map(|i| spread(founds.iter().map(|found| found.alarms[i])));
        let end =
            |i: usize| founds.iter().map(|found| found.end[i]).sum::<f64>() / founds.len() as f64;
        let _ = writeln!(
            text,
            "| {} | {} | {} | {:.3} +- {:.3}; {:.3}, {:.3} |",
            row.kind.name(),
            row.name,
            alarms.join(" | "),
            end(0),
            end(1),
            end(2),
            end(3),
        );
    }
    text
}

/// The table of probes that are not right.
fn faults(rows: &Runs) -> String {
    let mut text = "| fault | commissioned after | at the end, of that probe; of the other one; of the spindle | \
        preload-change; stiffness-loss; stiffness-gain; probe | `ok` | of which wrong | preload: rms; stated; within two errors |\n\
        | --- | --- | --- | --- | ---: | ---: | --- |\n"
        .to_owned();
    for (row, founds) in rows {
        let What::Probe(probe, _) = row.what else {
            continue;
        };
        let states = [1 + probe, 2 - probe, 0].map(|i| {
            let runs = |state: State| (count(founds, |found| found.states[i] == state), state);
            let mut all: Vec<_> = State::ALL
                .map(runs)
                .into_iter()
                .filter(|(runs, _)| *runs > 0)
                .collect();
            all.sort_by_key(|(runs, _)| std::cmp::Reverse(*runs));
            let said = |(runs, state): (usize, State)| format!("{runs} `{}`", state.name());
            all.into_iter().map(said).collect::<Vec<_>>().join(", ")
        });
        let _ = writeln!(
            text,
            "| {} | {} | {} | {} | {:.0} % | {:.1} % | {} |",
            row.name,
            spread(founds.iter().map(|found| found.commissioned)),
            states.join("; "),
            alarms(founds),
            part(founds, |found| found.ok),
            part(founds, |found| found.wrong),
            preload(founds),
        );
    }
    text
}

/// The page.
pub fn page(blocks: &Runs, ticks: &Runs, doubling: &str) -> String {
    let runs = |rows: &Runs| rows.first().map_or(0, |(_, founds)| founds.len());
    format!(
        "{ABOUT}
## By load steps

{} runs of each row. A sound spindle runs for ten hours, 60,000 steps; preload and states are those from an hour after commissioning on.
A change comes 400 steps after commissioning, and is followed for 600.

{}
{}
## By ticks

{} runs of each row: ten minutes of the whole monitor at 1 kHz, some 900 steps. Preload and states are those from 100 steps after commissioning on, when a
change comes. A probe freezes, goes over its range or is cut off then, or after five minutes; the other faults of probes are there from the start.

{}
{}
{}
## Constants

Effect of doubling each constant of the estimator on the shipped spindle, by load steps. What a step leaves of a sum (`kept`, `ratio_kept`) is
that of a sum over twice the steps.

{doubling}",
        runs(blocks),
        sound(blocks),
        changes(blocks),
        runs(ticks),
        sound(ticks),
        changes(ticks),
        faults(ticks),
    )
}

/// The table of what it does to double a constant, by the rows of a shipped spindle that are told the most by.
pub fn doubling(of: &Campaign, progress: &dyn Progress) -> String {
    const TELLING: [&str; 3] = ["sound", "20 % lost", "radial probe +10 %"];
    let usual = of.constants[0];
    let doubled = |constant: &Constant| constant.with(usual, constant.doubled(usual));
    let mut campaign = of.clone();
    campaign
        .rows
        .retain(|row| row.kind == Kind::Shipped && TELLING.contains(&row.name.as_str()));
    campaign.constants.extend(ALL.iter().map(doubled));
    let all = campaign.by_blocks(progress);
    let mut text = "| constant | doubled | commissioned after | false alarms: preload-change; stiffness-loss; stiffness-gain; probe | \
        preload: rms; stated; within two errors | `ok` | 20 % lost: preload-change after | radial probe +10 %: stiffness-loss after |\n\
        | --- | --- | --- | --- | --- | ---: | --- | --- |\n"
        .to_owned();
    for (i, runs) in all.iter().enumerate() {
        let [(_, sound), (_, lost), (_, gain)] = &runs[..] else {
            continue;
        };
        let constant = i.checked_sub(1).map(|i| &ALL[i]);
        let said = constant.map_or("| none | ".to_owned(), |constant| {
            // Numbers of single precision.
            let [is, doubled] = [(constant.get)(usual), constant.doubled(usual)].map(|x| x as f32);
            format!("| `{}` | {is} to {doubled}", constant.name)
        });
        let _ = writeln!(
            text,
            "{said} | {} | {} | {} | {:.0} % | {} | {} |",
            spread(sound.iter().map(|found| found.commissioned)),
            alarms(sound),
            preload(sound),
            part(sound, |found| found.ok),
            spread(lost.iter().map(|found| found.alarms[0])),
            spread(gain.iter().map(|found| found.alarms[1])),
        );
    }
    text
}

//! A campaign as a page, and as a list of solves to look at.

use super::Plan;
use super::contract::promises;
use super::families::Family;
use super::judge::{Branch, PRECISIONS, Record, Verdict};
use super::report::{Summary, name, part, table};
use crate::tolerances::allowed;
use std::fmt::Write;

fn small(x: f64) -> String {
    match x {
        0.0 => "0".to_owned(),
        x if x.is_nan() => "-".to_owned(),
        x => format!("{x:.1e}"),
    }
}

fn whole(x: f64) -> String {
    if x.is_nan() {
        "-".to_owned()
    } else {
        x.to_string()
    }
}

/// A row for every family and precision.
fn results(plan: &Plan, records: &[Record]) -> String {
    let mut rows = Vec::new();
    for &family in &plan.families {
        for precision in PRECISIONS {
            let of = Summary::of(&part(records, Some(family), precision));
            let mut row = vec![family.name().to_owned(), name(precision).to_owned()];
            row.extend([of.solves, of.solved[0]].map(|n| n.to_string()));
            row.extend(of.unsolved.map(|n| n.to_string()));
            row.push(of.iterations.show(whole));
            row.extend(of.errors.map(|errors| errors.show(small)));
            row.push(of.covered.map(|share| format!("{share:.1}")).join(" / "));
            rows.push(row);
        }
    }
    let head = [
        "family",
        "",
        "solves",
        "solved",
        "none",
        "missed",
        "open",
        "iterations",
        "error of u",
        "error of Q",
        "error of K",
        "covered, %",
    ];
    table(&head, &rows)
}

/// Each reason for no answer, with the families that have most of it.
fn reasons(records: &[Record]) -> String {
    let meanings = [
        (
            "diverged",
            "no start led to an equilibrium; mostly there is none at this speed",
        ),
        (
            "unseated",
            "the load is too small to hold the balls in the inner groove at this speed",
        ),
        (
            "indeterminate",
            "the balls that carry leave the ring free to move: mostly there are two",
        ),
        ("iteration-limit", "all iterations were used up"),
        (
            "unloaded",
            "the ring floats: no load, or so little that no ball carries",
        ),
        ("out-of-range", "an input is beyond what the model is about"),
        ("not-finite", "an input is not a number or infinite"),
    ];
    let mut text = String::new();
    for (status, meaning) in meanings {
        let count = |family: Option<Family>| {
            let of = |r: &&Record| r.status == status && family.is_none_or(|f| f == r.family);
            records.iter().filter(of).count()
        };
        let mut families = Family::ALL.map(|family| (count(Some(family)), family.name()));
        families.sort_by(|a, b| b.cmp(a));
        let most = families[..3].iter().filter(|(count, _)| *count > 0);
        let most: Vec<String> = most
            .map(|(count, name)| format!("{name} {count}"))
            .collect();
        if !most.is_empty() {
            let (all, most) = (count(None), most.join(", "));
            let _ = writeln!(text, "- `{status}`, {all} solves ({most}): {meaning}.");
        }
    }
    text
}

/// The page, but for its first line.
pub fn page(plan: &Plan, records: &[Record]) -> String {
    let families = plan.families.iter();
    let families: String = families
        .map(|f| format!("- **{}**: {}.\n", f.name(), f.about()))
        .collect();
    let searches = match plan.searches {
        Some(most) => format!("in {most} cases of a family"),
        None => "in every case".to_owned(),
    };
    format!(
        "# Stability campaign

{} solves of seed {}, as many of every family. Every case is solved in both precisions from one load and speed, rounded
to single precision. A warm family counts the ten solves after a cold one.

{families}
## Results

- *None*: no answer, and no equilibrium is known. *Missed*: no answer, though one is known. *Open*: nobody looked for one.
- The reference build searches for equilibria of solves without an answer {searches}.
- Iterations and errors: median / 99 % / worst. An error is that against the reference build in double-double arithmetic.
- *u*: displacement, of its largest component. *Q*: ball forces, of the largest. *K*: `abs(dKij) / sqrt(abs(Kii Kjj))`.
- *Covered*: answers whose error of *u* / *Q* / *K* is within the solver's own estimate.

{}

## Promises

Each family keeps the figures of its rows by itself. Three figures are those of *u*, *Q* and *K*.

{}

## What is not solved

{}
Two balls hold a ring by next to nothing: single precision does not know its position and its stiffness. The row of
few-balls has such answers. Of {} answers, {} are off by far more than their estimates.
",
        plan.solves,
        plan.seed,
        results(plan, records).trim_end(),
        promises().trim_end(),
        reasons(records),
        records.iter().filter(|r| r.errors.is_some()).count(),
        records.iter().filter(|r| r.deceives()).count(),
    )
}

/// Whether a solve is one to look into: no answer and no good reason, or an answer that is not as exact as the solver is.
fn is_failure(record: &Record) -> bool {
    let allowed = allowed(record.precision);
    let allowed = [allowed.displacement, allowed.force, allowed.stiffness];
    !matches!(record.verdict, Verdict::Judged | Verdict::RightlyRefused)
        || record.is_unbalanced()
        || record.branch == Some(Branch::Other)
        || record
            .errors
            .is_some_and(|errors| errors.iter().zip(allowed).any(|(e, most)| *e > most))
}

/// Every solve to look into, a line each.
pub fn failures(records: &[Record]) -> String {
    let failures = records.iter().filter(|record| is_failure(record));
    failures.map(|record| format!("{record:?}\n")).collect()
}

//! A campaign as a page.

use super::Plan;
use super::contract::promises;
use super::judge::{PRECISIONS, Record, Verdict};
use super::report::{Spread, covered, errors, name, part, table};

fn small(x: f64) -> String {
    match x {
        0.0 => "0".to_owned(),
        x => format!("{x:.1e}"),
    }
}

/// A row for every family and precision.
fn results(plan: &Plan, records: &[Record]) -> String {
    let mut rows = Vec::new();
    for &family in &plan.families {
        for precision in PRECISIONS {
            let of = part(records, Some(family), precision);
            let count = |is: fn(&Record) -> bool| of.iter().filter(|r| is(r)).count();
            let counts = [
                of.len(),
                count(Record::is_solved),
                count(|r| r.verdict == Verdict::RightlyRefused),
                count(|r| r.verdict == Verdict::Missed),
                count(|r| r.verdict == Verdict::Undecided),
            ];
            let solved = of.iter().filter(|r| r.is_solved());
            let iterations = solved.filter_map(|r| r.iterations).map(f64::from);
            let mut row = vec![family.name().to_owned(), name(precision).to_owned()];
            row.extend(counts.map(|n| n.to_string()));
            row.push(Spread::of(iterations).show(|x| x.to_string()));
            row.extend(errors(&of).map(|errors| errors.show(small)));
            row.push(covered(&of).map(|share| format!("{share:.1}")).join(" / "));
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

/// Text about bearings alone, after the figures.
const BEARINGS: &str = "## Not solved

There is one start. Some loads with an equilibrium end as `diverged` or `unseated` from there:

- a radial load or a moment that leaves a single row on three balls or fewer, with little axial load;
- a load far below the centrifugal force of the balls, at random directions;
- at rest, a small radial load alone, which three balls carry: some below 0.15 N (B7005C);
- one in 600 random sets whose rows hold each other;
- in double precision, one in a hundred loads on a bearing whose balls' inertia is below a ten thousandth of the load.

A solve with the last solution next to it is not concerned.

## Weak rings

Two balls hold a ring by next to nothing: single precision does not know its position and its stiffness. The row of
few-balls has such answers. Double precision finds another equilibrium of some, and their errors of *Q* are the distance
from there.
";

/// Text about sets, in the place of the texts about families and unsolved loads.
const SETS: &str = "A set has one to eight rows of a family's bearing, of which one side may have smaller balls; the loads act at `x = 0`, between
the rows or in front of them. Three in ten sets with two sides are sprung. Half of all stand on an elastic shaft, half of
whose supports are elastic, too; half have grown. A quarter have some displacements given in the place of loads.

The reference build of sets works in doubles: errors below 1e-10 count as none.

";

/// The page, but for its first line.
pub fn page(plan: &Plan, records: &[Record]) -> String {
    let families = plan.families.iter();
    let families: String = families
        .map(|f| format!("- **{}**: {}.\n", f.name(), f.about()))
        .collect();
    format!(
        "# Stability campaign{}

{} solves of seed {}, as many of every family. Every case is solved in both precisions from one load and speed, rounded
to single precision. A warm family counts the ten solves after a cold one.

{families}
{}## Results

- *None*: no answer, and no equilibrium is known. *Missed*: no answer, though one is known. *Open*: nobody looked for one.
- The reference build searches for equilibria of solves without an answer in {} cases of a family.
- Iterations and errors: median / 99 % / worst. An error is that against the reference build in double-double arithmetic.
- *u*: displacement, of its largest component. *Q*: ball forces, of the largest. *K*: `abs(dKij) / sqrt(abs(Kii Kjj))`.
- *Covered*: answers whose error of *u* / *Q* / *K* is within the solver's own estimate.

{}

## Promises

Each family keeps the figures of its rows by itself. Three figures are those of *u*, *Q* and *K*.

{}

Of {} answers, {} are off by far more than their estimates.
{}",
        if plan.of_sets { " of sets" } else { "" },
        plan.solves,
        plan.seed,
        if plan.of_sets { SETS } else { "" },
        plan.searches,
        results(plan, records).trim_end(),
        promises(plan.of_sets).trim_end(),
        records.iter().filter(|r| r.errors.is_some()).count(),
        records.iter().filter(|r| r.deceives()).count(),
        if plan.of_sets { "" } else { BEARINGS },
    )
}

//! What a campaign found, as the page and as a list of what to look at.

use super::contract::Figure;
use super::families::Family;
use super::judge::{Branch, PRECISIONS, Record, Verdict};
use super::{Plan, contract};
use crate::dispatch::Precision;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::io;

/// Median, 99th percentile and worst; NaN of nothing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spread {
    /// Half of the values are no larger.
    pub median: f64,
    /// 99 % of the values are no larger.
    pub most: f64,
    /// The largest.
    pub worst: f64,
}

impl Spread {
    /// Of these values, none of which is NaN.
    pub fn of(values: impl Iterator<Item = f64>) -> Self {
        let mut values: Vec<f64> = values.collect();
        values.sort_unstable_by(f64::total_cmp);
        // Nearest rank.
        let at = |share: f64| {
            let rank = (share * values.len() as f64).ceil() as usize;
            values
                .get(rank.saturating_sub(1))
                .copied()
                .unwrap_or(f64::NAN)
        };
        Self {
            median: at(0.5),
            most: at(0.99),
            worst: at(1.0),
        }
    }
}

/// How well the solver's own estimate of an error holds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coverage {
    /// Share of answers whose error is no larger than the estimate.
    pub share: f64,
    /// Median of estimate over error, of errors that are not 0.
    pub ratio: f64,
}

/// How well the estimates of displacement, force and stiffness hold in these records; none where no errors or
/// no estimates are known.
pub fn coverage<'r>(records: impl Iterator<Item = &'r Record>) -> Option<[Coverage; 3]> {
    let both: Vec<([f64; 3], [f64; 3])> = records
        .filter_map(|r| Some((r.errors?, r.estimate?)))
        .collect();
    let of = |i: usize| Coverage {
        share: both.iter().filter(|(e, of)| e[i] <= of[i]).count() as f64 / both.len() as f64,
        ratio: Spread::of(
            both.iter()
                .filter(|(e, _)| e[i] > 0.0)
                .map(|(e, of)| of[i] / e[i])
                .filter(|ratio| !ratio.is_nan()),
        )
        .median,
    };
    (!both.is_empty()).then(|| [0, 1, 2].map(of))
}

/// A family in a precision.
#[derive(Debug, Clone)]
pub struct Summary {
    /// The family.
    pub family: Family,
    /// The precision.
    pub precision: Precision,
    /// Solves.
    pub solves: usize,
    /// How they ended, by name.
    pub endings: BTreeMap<&'static str, usize>,
    /// Those that came to what must never be.
    pub failed: usize,
    /// Iterations of those with figures.
    pub iterations: Spread,
    /// Solves without an answer that were looked into: right, and wrong to have none.
    pub refused: [usize; 2],
    /// Of the latter, those where contacts oppose each other.
    pub missed_opposed: usize,
    /// Those that were not.
    pub undecided: usize,
    /// Answers whose errors are known; of those, of another equilibrium; answers of which they are not.
    pub answers: [usize; 3],
    /// Answers that are none: see [`Record::is_far`]; and of those, the ones that say of themselves to be better.
    pub far: [usize; 2],
    /// Answers whose forces do not balance.
    pub unbalanced: usize,
    /// Answers that were compared with the equilibrium on the branch from rest; those that are another one; answers
    /// where that branch could not be followed to the speed.
    pub branches: [usize; 3],
    /// Errors of displacement, force and stiffness.
    pub errors: [Spread; 3],
    /// How well the estimates of those hold, if there are any.
    pub coverage: Option<[Coverage; 3]>,
}

impl Summary {
    /// Of the records of one family in one precision.
    fn of(family: Family, precision: Precision, records: &[&Record]) -> Self {
        let count = |of: &dyn Fn(&Record) -> bool| records.iter().filter(|r| of(r)).count();
        let verdict = |v: Verdict| count(&|r| r.verdict == v);
        let mut endings = BTreeMap::new();
        for record in records {
            *endings.entry(record.status).or_default() += 1;
        }
        let branch = |of: Branch| count(&|r| r.branch == Some(of));
        let errors: Vec<[f64; 3]> = records.iter().filter_map(|r| r.errors).collect();
        let solved = || records.iter().filter(|r| r.is_solved());
        Self {
            family,
            precision,
            solves: records.len(),
            endings,
            failed: count(&|r| matches!(r.verdict, Verdict::Failed(_))),
            iterations: Spread::of(solved().filter_map(|r| r.iterations).map(f64::from)),
            refused: [
                verdict(Verdict::RightlyRefused),
                count(&|r| missed(r).is_some()),
            ],
            missed_opposed: count(&|r| missed(r) == Some(true)),
            undecided: verdict(Verdict::Undecided),
            answers: [
                errors.len(),
                verdict(Verdict::OtherBranch),
                verdict(Verdict::Unjudged),
            ],
            far: [
                count(&Record::is_far),
                count(&|r| r.is_far() && !is_estimated(r)),
            ],
            unbalanced: count(&Record::is_unbalanced),
            branches: [
                branch(Branch::FromRest) + branch(Branch::Other),
                branch(Branch::Other),
                branch(Branch::Lost),
            ],
            errors: [0, 1, 2].map(|i| Spread::of(errors.iter().map(|e| e[i]))),
            coverage: coverage(records.iter().copied()),
        }
    }

    /// How many ended so.
    pub fn ended(&self, status: &str) -> usize {
        self.endings.get(status).copied().unwrap_or(0)
    }
}

/// Summaries by family and precision, in the order of the families; double precision second.
pub fn summaries(records: &[Record]) -> Vec<Summary> {
    let mut all = Vec::new();
    for family in Family::ALL {
        for precision in PRECISIONS {
            let of: Vec<&Record> = records
                .iter()
                .filter(|r| r.family == family && r.precision == precision)
                .collect();
            if !of.is_empty() {
                all.push(Summary::of(family, precision, &of));
            }
        }
    }
    all
}

/// Of an equilibrium that was missed, whether contacts oppose each other there.
fn missed(record: &Record) -> Option<bool> {
    match record.verdict {
        Verdict::Missed { opposed } => Some(opposed),
        _ => None,
    }
}

/// Whether all errors of an answer are within its own estimate.
fn is_estimated(record: &Record) -> bool {
    let (Some(errors), Some(estimate)) = (record.errors, record.estimate) else {
        return false;
    };
    errors.iter().zip(estimate).all(|(error, of)| *error <= of)
}

fn name(precision: Precision) -> &'static str {
    match precision {
        Precision::F32 => "f32",
        Precision::F64 => "f64",
    }
}

/// A Markdown table, its columns padded so that the source can be read, too.
pub fn table(head: &[&str], rows: &[Vec<String>]) -> String {
    let width = |i: usize| {
        let cells = rows.iter().map(|row| row[i].chars().count());
        cells.chain([head[i].chars().count(), 3]).max().unwrap_or(3)
    };
    let widths: Vec<usize> = (0..head.len()).map(width).collect();
    let line = |cells: &mut dyn Iterator<Item = &str>| {
        let mut line = String::from("|");
        for (i, (cell, width)) in cells.zip(&widths).enumerate() {
            // Numbers line up on the right.
            let _ = if i == 0 {
                write!(line, " {cell:<width$} |")
            } else {
                write!(line, " {cell:>width$} |")
            };
        }
        line.push('\n');
        line
    };
    let mut text = line(&mut head.iter().copied());
    text.push('|');
    for (i, width) in widths.iter().enumerate() {
        let dashes = "-".repeat(*width);
        let _ = if i == 0 {
            write!(text, " {dashes} |")
        } else {
            write!(text, " {}: |", &dashes[1..])
        };
    }
    text.push('\n');
    for row in rows {
        text += &line(&mut row.iter().map(String::as_str));
    }
    text.push('\n');
    text
}

fn small(x: f64) -> String {
    if x.is_nan() {
        "-".to_owned()
    } else if x == 0.0 {
        "0".to_owned()
    } else {
        format!("{x:.1e}")
    }
}

fn short(x: f64) -> String {
    if x.is_nan() {
        "-".to_owned()
    } else if x.fract() == 0.0 {
        format!("{x}")
    } else {
        format!("{x:.1}")
    }
}

fn percent(share: f64) -> String {
    format!("{:.2} %", 100.0 * share)
}

/// Names with counts, all endings but the solved ones.
fn refusals(summary: &Summary) -> String {
    let named: Vec<String> = summary
        .endings
        .iter()
        .filter(|(status, _)| !matches!(**status, "converged" | "precision-limit"))
        .map(|(status, count)| format!("{status} {count}"))
        .collect();
    if named.is_empty() {
        "-".to_owned()
    } else {
        named.join(", ")
    }
}

fn outcomes(all: &[Summary]) -> String {
    let rows: Vec<Vec<String>> = all
        .iter()
        .map(|s| {
            vec![
                s.family.name().to_owned(),
                name(s.precision).to_owned(),
                s.solves.to_string(),
                s.ended("converged").to_string(),
                s.ended("precision-limit").to_string(),
                refusals(s),
                format!("{} ({})", s.refused[1], s.missed_opposed),
                s.undecided.to_string(),
                s.failed.to_string(),
                [s.iterations.median, s.iterations.most, s.iterations.worst]
                    .map(short)
                    .join(" / "),
            ]
        })
        .collect();
    table(
        &[
            "family",
            "",
            "solves",
            "converged",
            "precision limit",
            "no answer",
            "missed",
            "open",
            "failed",
            "iterations",
        ],
        &rows,
    )
}

fn errors(all: &[Summary], precision: Precision) -> String {
    let rows: Vec<Vec<String>> = all
        .iter()
        .filter(|s| s.precision == precision)
        .map(|s| {
            let mut row = vec![s.family.name().to_owned()];
            row.extend(s.answers.map(|count| count.to_string()));
            row.extend(
                s.errors
                    .map(|e| [e.median, e.most, e.worst].map(small).join(" / ")),
            );
            row
        })
        .collect();
    table(
        &["family", "judged", "other", "unjudged", "u", "Q", "K"],
        &rows,
    )
}

/// Answers that are none, and answers that are another equilibrium than the one meant.
fn equilibria(all: &[Summary]) -> String {
    let rows: Vec<Vec<String>> = all
        .iter()
        .map(|s| {
            let mut row = vec![s.family.name().to_owned(), name(s.precision).to_owned()];
            row.extend([s.far[0], s.far[1], s.unbalanced].map(|n| n.to_string()));
            row.extend(s.branches.map(|n| n.to_string()));
            row
        })
        .collect();
    table(
        &[
            "family",
            "",
            "far",
            "deceiving",
            "unbalanced",
            "followed",
            "other branch",
            "lost",
        ],
        &rows,
    )
}

fn estimates(all: &[Summary], records: &[Record]) -> String {
    let row = |family: &str, precision, coverage: [Coverage; 3]| {
        let mut row = vec![family.to_owned(), name(precision).to_owned()];
        row.extend(coverage.map(|c| format!("{}, {}", percent(c.share), short(c.ratio))));
        row
    };
    let mut rows: Vec<Vec<String>> = all
        .iter()
        .filter_map(|s| Some(row(s.family.name(), s.precision, s.coverage?)))
        .collect();
    rows.extend(PRECISIONS.into_iter().filter_map(|precision| {
        let of = coverage(records.iter().filter(|r| r.precision == precision))?;
        Some(row("all", precision, of))
    }));
    table(&["family", "", "u", "Q", "K"], &rows)
}

/// What the campaign promises and does not keep.
fn unkept(all: &[Summary]) -> String {
    let lines: Vec<String> = all
        .iter()
        .flat_map(contract::unkept)
        .map(|line| format!("- {line}\n"))
        .collect();
    if lines.is_empty() {
        "Everything is kept.\n".to_owned()
    } else {
        lines.concat()
    }
}

/// The page, but for its first line.
pub fn page(plan: &Plan, records: &[Record]) -> String {
    let all = summaries(records);
    let families: String = plan
        .families
        .iter()
        .map(|f| format!("- **{}**: {}.\n", f.name(), f.about()))
        .collect();
    let searches = plan.searches.map_or("all".to_owned(), |most| {
        format!("the first {most} of a family")
    });
    format!(
        "# Stability campaign

{} solves of seed {}, as many of every family. Every case is solved in both precisions from the same
load and speed, rounded to single precision; a warm family counts ten solves a case.

{families}
## How they ended

*No answer*: what the solver said instead. The reference build looks into those, by itself into {searches}:
*missed* are those where it knows an equilibrium (for `indeterminate`: one that three balls or more carry
and whose stiffness can be inverted), in brackets those of them where the contacts of every ball that
carries are within 90 degrees of each other: beyond that, the races no longer hold the ball between them.
*Open* are those that were not looked into. *Failed* is what must never be: a panic, a figure that is not
a finite number, more than 128 iterations, a refusal for a reason that does not hold. *Iterations* of
solves that ended with an answer: median / 99 % / worst, warm ones in warm families, cold ones elsewhere.

{}
## Which equilibrium

*Far*: answers with an error beyond 1e-2, or whose forces do not balance to 1e-2; *deceiving*: those of them whose
own estimate says less; *unbalanced*: those whose forces do not balance. Where a load has several equilibria, the one
meant is that on the branch connected to rest. The reference build follows it in `omega^2`, for one cold case at speed
of {}: *followed* are the answers that could be compared, *other branch* those of them that are another equilibrium,
*lost* those where the branch turns back before the speed.

{}
## Errors in single precision

Against the equilibrium that the reference build, in double-double arithmetic, reaches from the solver's
double precision answer, or, where single precision has found *another* one, from that. *Unjudged*: it
reaches none. *u*: displacement, of its largest component (tilts times the pitch radius); *Q*: ball
forces, of the largest; *K*: `abs(dKij) / sqrt(abs(Kii Kjj))`. Median / 99 % / worst.

{}
## Errors in double precision

{}
## The solver's own estimate of its errors

Share of answers whose error is within the estimate, and the median of estimate over error.

{}
## The contract

No panic, no figure that is not a number, no answer past the iteration limit, none whose forces do not balance. *Missed*
with contacts within 90 degrees: at most 0.2 % of a family, 1 % of random, radial, zero-loads and opening, 4 % of
few-balls. Single precision, 99 % of moderate, reversed, moduli, inner-control, warm-drift and warm-jumps: *u* within
1e-6, *Q* within 1e-6, *K* within 2e-5. Estimates cover 99.9 % of the errors in moderate, reversed and warm-drift, 99.5 %
in random and radial, and are 30 times too large at most in the median. At most 0.1 % of moderate is on another branch
than that from rest. What is not kept:

{}",
        plan.solves,
        plan.seed,
        outcomes(&all),
        plan.followed,
        equilibria(&all),
        errors(&all, Precision::F32),
        errors(&all, Precision::F64),
        estimates(&all, records).trim_end_matches('\n').to_owned() + "\n",
        unkept(&all),
    )
}

/// For every family and precision, the cases to look at first.
pub fn worst(records: &[Record]) -> String {
    let mut text = String::new();
    for summary in summaries(records) {
        let of = || {
            records
                .iter()
                .filter(|r| r.family == summary.family && r.precision == summary.precision)
        };
        let by = |key: &dyn Fn(&Record) -> Option<f64>| {
            of().filter_map(|r| Some((key(r)?, r.index)))
                .max_by(|a, b| a.0.total_cmp(&b.0))
                .map_or("-".to_owned(), |(x, index)| {
                    format!("{} in {index}", if x >= 1.0 { short(x) } else { small(x) })
                })
        };
        let _ = writeln!(
            text,
            "{} {}: iterations {}; u {}; Q {}; K {}",
            summary.family.name(),
            name(summary.precision),
            by(&|r| r.iterations.map(f64::from)),
            by(&|r| r.errors.map(|e| e[0])),
            by(&|r| r.errors.map(|e| e[1])),
            by(&|r| r.errors.map(|e| e[2])),
        );
        let first = |what: &str, of_verdict: &dyn Fn(&Record) -> bool| {
            let found: Vec<String> = of()
                .filter(|r| of_verdict(r))
                .take(8)
                .map(|r| format!("{} ({})", r.index, reason(r)))
                .collect();
            if found.is_empty() {
                String::new()
            } else {
                format!("  {what}: {}\n", found.join(", "))
            }
        };
        text += &first("failed", &|r| matches!(r.verdict, Verdict::Failed(_)));
        text += &first("missed", &|r| missed(r).is_some());
        text += &first("unjudged", &|r| r.verdict == Verdict::Unjudged);
        text += &first("far", &Record::is_far);
        text += &first("other branch", &|r| r.branch == Some(Branch::Other));
    }
    text
}

fn reason(record: &Record) -> &'static str {
    match record.verdict {
        Verdict::Failed(why) => why,
        _ => record.status,
    }
}

/// Whether a record is one to look into: no answer and no good reason, or a poor one.
fn is_failure(record: &Record) -> bool {
    let poor = record.errors.is_some_and(|errors| {
        errors.iter().enumerate().any(|(i, error)| {
            contract::bound(Figure::Error(i), record.family, record.precision)
                .is_some_and(|bound| *error > bound)
        })
    });
    !matches!(record.verdict, Verdict::Judged | Verdict::RightlyRefused)
        || record.is_far()
        || record.branch == Some(Branch::Other)
        || poor
}

/// Writes every solve to look into as CSV.
///
/// # Errors
///
/// That of writing.
pub fn list_failures(records: &[Record], out: impl io::Write) -> Result<(), csv::Error> {
    let mut out = csv::Writer::from_writer(out);
    out.write_record([
        "family",
        "case",
        "solve",
        "precision",
        "status",
        "verdict",
        "iterations",
        "error_u",
        "error_q",
        "error_k",
        "estimate_u",
        "estimate_q",
        "estimate_k",
        "residual",
        "branch",
    ])?;
    let three = |x: Option<[f64; 3]>| {
        x.map_or([(); 3].map(|()| String::new()), |x| {
            x.map(|x| format!("{x:.2e}"))
        })
    };
    for record in records.iter().filter(|r| is_failure(r)) {
        let verdict = match record.verdict {
            Verdict::Judged => "judged",
            Verdict::OtherBranch => "other equilibrium",
            Verdict::Unjudged => "unjudged",
            Verdict::RightlyRefused => "rightly refused",
            Verdict::Missed { .. } => "missed",
            Verdict::Undecided => "open",
            Verdict::Failed(why) => why,
        };
        let mut row = vec![
            record.family.name().to_owned(),
            record.index.to_string(),
            record.tick.to_string(),
            name(record.precision).to_owned(),
            record.status.to_owned(),
            verdict.to_owned(),
            record.iterations.map_or(String::new(), |n| n.to_string()),
        ];
        row.extend(three(record.errors));
        row.extend(three(record.estimate));
        row.push(
            record
                .residual
                .map_or(String::new(), |x| format!("{x:.2e}")),
        );
        row.push(match record.branch {
            Some(Branch::FromRest) => "from rest".to_owned(),
            Some(Branch::Other) => "other".to_owned(),
            Some(Branch::Lost) => "lost".to_owned(),
            None => String::new(),
        });
        out.write_record(row)?;
    }
    out.flush()?;
    Ok(())
}

//! Figures that must not change unnoticed, and README's table, which is made of them.

use crate::page;
use crate::scenes::{self, Measured};
use crate::ticks;
use anyhow::{Context, Result, ensure};
use lab::report::{self, FIGURES, Figures};
use lab::workload;
use std::fs;
use std::path::Path;

/// Part by which a figure may differ: the same source gives the same figures in any folder, but not under another compiler.
const LEEWAY: f64 = 0.005;

/// Measures all figures.
pub fn measure(root: &Path) -> Result<Figures> {
    let measured = scenes::run(root, scenes::programs(), &workload::all())?;
    let mut figures: Figures = measured.iter().flat_map(Measured::figures).collect();
    figures.extend(ticks::figures(&ticks::measure(root)?));
    Ok(figures)
}

/// Writes the figures, and README's table.
pub fn write(root: &Path, figures: &Figures) -> Result<()> {
    let [_, readme] = page::readme(root, figures)?;
    fs::write(root.join("README.md"), readme).context("README.md")?;
    let text = serde_json::to_string_pretty(figures)? + "\n";
    fs::write(root.join(FIGURES), text).context(FIGURES)?;
    println!(
        "{FIGURES}: {} figures; commit it, and README",
        figures.len()
    );
    for line in ticks::other_constants(figures) {
        println!("{line}");
    }
    Ok(())
}

/// Fails if a figure is not the committed one. README's table and the firmware's deadline must rest on
/// the committed figures, too.
pub fn check(root: &Path) -> Result<()> {
    let committed = report::figures(root)?;
    let figures = measure(root)?;
    println!("{}", changes(&committed, &figures));
    let mut complaints = differences(&committed, &figures);
    complaints.extend(ticks::other_constants(&committed));
    let [readme, made] = page::readme(root, &committed)?;
    if readme != made {
        complaints.push(format!("README's table is not made of {FIGURES}"));
    }
    ensure!(
        complaints.is_empty(),
        "{}\n`cargo reports --accept` takes the figures as they are now: commit them if they are worth it",
        complaints.join("\n")
    );
    Ok(())
}

/// A table of the figures that are not the committed ones to the last unit, which the leeway lets pass.
fn changes(committed: &Figures, figures: &Figures) -> String {
    let changed = figures.iter().filter_map(|(what, now)| {
        let before = *committed.get(what)?;
        let percent = 100.0 * (*now as f64 / before as f64 - 1.0);
        let row = || format!("{before:>12} {now:>12} {percent:>+7.2}  {what}");
        (*now != before).then(row)
    });
    let changed: Vec<String> = changed.collect();
    let of = format!("{} of {} figures are not", changed.len(), figures.len());
    let head = format!(
        "{:>12} {:>12} {:>7}  {of} those of {FIGURES}",
        "committed", "now", "%"
    );
    [vec![head], changed].concat().join("\n")
}

/// Figures that are not the committed ones, or are not measured any more.
fn differences(committed: &Figures, figures: &Figures) -> Vec<String> {
    let other = figures.iter().filter_map(|(what, now)| {
        let Some(before) = committed.get(what) else {
            return Some(format!("{what}: {now}, and {FIGURES} has no such figure"));
        };
        let differs = now.abs_diff(*before) as f64 > LEEWAY * *before as f64;
        differs.then(|| format!("{what}: {now}, was {before}"))
    });
    let gone = committed.keys().filter(|what| !figures.contains_key(*what));
    let gone = gone.map(|what| format!("{what}: not measured any more"));
    other.chain(gone).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_figure_may_differ_by_the_leeway_and_none_may_vanish() {
        let of = |pairs: &[(&str, u64)]| -> Figures {
            let pairs = pairs.iter();
            pairs
                .map(|(name, figure)| ((*name).to_owned(), *figure))
                .collect()
        };
        let committed = of(&[("a", 1000), ("b", 0)]);
        for a in [995, 1005] {
            assert!(differences(&committed, &of(&[("a", a), ("b", 0)])).is_empty());
        }
        for now in [
            of(&[("a", 1006), ("b", 0)]),
            of(&[("a", 994), ("b", 0)]),
            of(&[("a", 1000), ("b", 1)]),
            of(&[("a", 1000)]),
            of(&[("a", 1000), ("b", 0), ("c", 1)]),
        ] {
            assert_eq!(differences(&committed, &now).len(), 1, "{now:?}");
        }
    }
}

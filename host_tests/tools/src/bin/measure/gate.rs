//! Figures that must not get worse unnoticed, and README's table, which must be true.

use crate::page;
use crate::scenes::{self, Measured};
use crate::ticks;
use crate::workload::Work;
use anyhow::{Context, Result, bail};
use std::fs;
use std::path::Path;
use tools::report::{self, FIGURES, Figures};

/// Growth that is let pass.
const LEEWAY: f64 = 0.02;

fn measure(root: &Path) -> Result<Figures> {
    let measured = scenes::run(root, scenes::programs(), &Work::all())?;
    Ok(measured.iter().flat_map(Measured::figures).collect())
}

/// Takes the figures, README's table and the deadline's constants as they are now.
pub fn accept(root: &Path) -> Result<()> {
    let mut figures = measure(root)?;
    figures.extend(accept_ticks(root)?);
    page::write_readme(root, &figures)?;
    write(root, &figures)
}

/// Takes the monitor's figures and the deadline's constants as they are now.
pub fn accept_monitor(root: &Path) -> Result<()> {
    let measured = accept_ticks(root)?;
    for (name, figure) in &measured {
        println!("{name}: {figure}");
    }
    if !ticks::IS_SHIPPED {
        return Ok(());
    }
    let mut figures = report::figures(root)?;
    figures.extend(measured);
    write(root, &figures)
}

fn accept_ticks(root: &Path) -> Result<Figures> {
    let measured = ticks::measure(root)?;
    ticks::write_constants(root, &measured)?;
    Ok(ticks::figures(&measured))
}

/// Writes the figures.
pub fn write(root: &Path, figures: &Figures) -> Result<()> {
    let path = root.join(FIGURES);
    let text = serde_json::to_string_pretty(&figures)? + "\n";
    fs::write(&path, text).with_context(|| format!("cannot write {}", path.display()))?;
    println!("{FIGURES}: {} figures; commit it", figures.len());
    Ok(())
}

/// Fails if a figure has grown by more than the leeway, or README's table differs by more than it.
pub fn check(root: &Path) -> Result<()> {
    let accepted = report::figures(root)?;
    let mut figures = measure(root)?;
    figures.extend(ticks::check(root, LEEWAY)?);
    for (what, now) in &figures {
        println!("{what}: {now}");
    }
    let mut complaints = worse(&accepted, &figures);
    complaints.extend(differences(
        &page::readme_table_of(root)?,
        &page::readme_table(&figures)?,
    ));
    if !complaints.is_empty() {
        bail!(
            "{}\n`cargo reports --accept` takes the figures as they are now: commit them if they are worth it",
            complaints.join("\n")
        );
    }
    Ok(())
}

/// Figures that are worse than accepted ones, or are accepted and not measured.
fn worse(accepted: &Figures, figures: &Figures) -> Vec<String> {
    let worse = figures.iter().filter_map(|(what, now)| {
        let Some(before) = accepted.get(what) else {
            return Some(format!("{what}: {now}, and {FIGURES} has no such figure"));
        };
        let allowed = *before as f64 * (1.0 + LEEWAY);
        (*now as f64 > allowed).then(|| format!("{what}: {now}, was {before}"))
    });
    let gone = accepted.keys().filter(|what| !figures.contains_key(*what));
    worse
        .chain(gone.map(|what| format!("{what}: not measured any more")))
        .collect()
}

/// Lines of a published table whose numbers are not the measured ones.
fn differences(published: &str, measured: &str) -> Vec<String> {
    let differs = |(published, measured): &(&str, &str)| {
        let (published, measured) = (numbers(published), numbers(measured));
        let near = |(a, b): (&f64, &f64)| (a - b).abs() <= LEEWAY * b.abs();
        published.len() != measured.len() || !published.iter().zip(&measured).all(near)
    };
    let of_published: Vec<&str> = published.trim().lines().collect();
    let of_measured: Vec<&str> = measured.trim().lines().collect();
    if of_published.len() != of_measured.len() {
        return vec![format!("README's table is not this one:\n{measured}")];
    }
    of_published
        .into_iter()
        .zip(of_measured)
        .filter(differs)
        .map(|(published, measured)| format!("README has\n{published}\nmeasured:\n{measured}"))
        .collect()
}

/// The numbers of a line, their thousands set apart by commas.
fn numbers(line: &str) -> Vec<f64> {
    let line = line.replace(',', "");
    let words = line.split_whitespace();
    words.filter_map(|word| word.parse().ok()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_figure_may_grow_by_the_leeway_and_none_may_vanish() {
        let of = |pairs: &[(&str, u64)]| -> Figures {
            pairs
                .iter()
                .map(|(name, figure)| ((*name).to_owned(), *figure))
                .collect()
        };
        let accepted = of(&[("a", 1000), ("b", 0)]);
        assert!(worse(&accepted, &of(&[("a", 1020), ("b", 0)])).is_empty());
        for now in [
            of(&[("a", 1021), ("b", 0)]),
            of(&[("a", 1000), ("b", 1)]),
            of(&[("a", 1000)]),
            of(&[("a", 1000), ("b", 0), ("c", 1)]),
        ] {
            assert_eq!(worse(&accepted, &now).len(), 1, "{now:?}");
        }
    }

    #[test]
    fn a_number_of_the_readme_that_is_off_is_told_with_its_line() {
        let measured = "| a | cycles |\n| - | -: |\n| one | 23,674 | 0.141 ms |\n";
        assert!(differences(&measured.replace("23,674", "23,900"), measured).is_empty());
        assert_eq!(
            differences(&measured.replace("23,674", "24,674"), measured).len(),
            1
        );
        assert_eq!(
            differences(&measured.replace("0.141", "0.15"), measured).len(),
            1
        );
        assert_eq!(differences("", measured).len(), 1);
    }
}

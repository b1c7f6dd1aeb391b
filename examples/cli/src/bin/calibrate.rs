//! `cargo calibrate`: a calibration of strain bridges, as a spindle file takes it.

use anyhow::{Context, Result, ensure};
use clap::Parser;
use csv::ReaderBuilder;
use spindle_file::calibration::loads;
use std::path::PathBuf;

/// Judges the counts that each load makes alone, and prints them for a spindle file.
///
/// The condition tells how much of a count's noise gets into the loads: 1 is best.
#[derive(Parser, Debug)]
#[command(name = "calibrate", bin_name = "cargo calibrate")]
struct Arguments {
    /// CSV with the header fx,fy,fz,my,mz and a row for each of 5 to 8 bridges: counts per N and N m
    #[arg(value_name = "COUNTS.csv")]
    counts: PathBuf,
}

fn main() -> Result<()> {
    let path = Arguments::parse().counts;
    let said = || format!("cannot read {}", path.display());
    let mut reader = ReaderBuilder::new()
        .comment(Some(b'#'))
        .from_path(&path)
        .with_context(said)?;
    let header = reader.headers().with_context(said)?;
    ensure!(
        header == ["fx", "fy", "fz", "my", "mz"].as_slice(),
        "the header must be fx,fy,fz,my,mz"
    );
    let counts: Result<Vec<[f64; 5]>, _> = reader.deserialize().collect();
    print!("{}", text(&counts.with_context(said)?)?);
    Ok(())
}

/// The calibration as lines of a spindle file.
fn text(counts: &[[f64; 5]]) -> Result<String> {
    let bridges = counts.len();
    ensure!((5..=8).contains(&bridges), "{bridges} bridges, not 5 to 8");
    let condition = loads(counts).map_err(anyhow::Error::msg)?.condition;
    let mut text = format!("# Condition {condition:.2}.\n[monitor.bridges]\ncounts = [\n");
    for of in counts {
        text += &format!("    {of:?},\n");
    }
    Ok(text + "]\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bridges_that_see_a_load_each_have_the_best_condition_and_are_printed_for_a_file() {
        let counts: [[f64; 5]; 5] = std::array::from_fn(|i| {
            std::array::from_fn(|j| if i == j { [500.0, 2e4][i / 3] } else { 0.0 })
        });
        let text = text(&counts).unwrap();
        let parts = [
            "# Condition 1.00.\n",
            "counts = [\n    [500.0, 0.0,",
            " 20000.0],\n]",
        ];
        assert!(parts.iter().all(|part| text.contains(part)), "{text}");
        assert!(super::text(&counts[1..]).is_err());
    }
}

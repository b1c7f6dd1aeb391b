//! `cargo calibrate`: a calibration of strain bridges, as the firmware takes it.

use anyhow::{Context, Result, ensure};
use clap::Parser;
use csv::ReaderBuilder;
use files::calibration::{Loads, loads};
use std::path::PathBuf;

/// Turns the counts that each load makes alone into the matrices of the firmware, and prints them for
/// `monitor_settings.rs`.
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

/// The calibration as code.
fn text(counts: &[[f64; 5]]) -> Result<String> {
    let bridges = counts.len();
    ensure!((5..=8).contains(&bridges), "{bridges} bridges, not 5 to 8");
    let Loads {
        by_bridge,
        condition,
    } = loads(counts).map_err(anyhow::Error::msg)?;
    let mut text = format!("// Condition {condition:.2}.\nCalibration::new(\n    [\n");
    for load in 0..5 {
        let row: Vec<_> = by_bridge.iter().map(|of| of[load] as f32).collect();
        text += &format!("        {row:?},\n");
    }
    text += "    ],\n    [\n";
    for of in counts {
        text += &format!("        {:?},\n", of.map(|count| count as f32));
    }
    Ok(text + "    ],\n)\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bridges_that_see_a_load_each_have_the_best_condition_and_code_that_says_so() {
        let counts: [[f64; 5]; 5] = std::array::from_fn(|i| {
            std::array::from_fn(|j| if i == j { [500.0, 2e4][i / 3] } else { 0.0 })
        });
        let text = text(&counts).unwrap();
        let parts = [
            "// Condition 1.00.\n",
            "[0.002, 0.0,",
            " 5e-5],\n",
            " 20000.0],\n",
        ];
        assert!(parts.iter().all(|part| text.contains(part)), "{text}");
        assert!(super::text(&counts[1..]).is_err());
    }
}

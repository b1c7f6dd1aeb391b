//! Loads and speeds of a table of stiffness: every combination of the values that its axes have.

use anyhow::{Context, Result, anyhow, bail, ensure};
use spindle_file::loads::LoadRow;
use spindle_file::loads::celsius;

/// Most rows of a table.
const MOST_ROWS: usize = 1_000_000;

const TOO_MANY: &str =
    "the table has more than 1000000 rows; take larger steps, or make several tables";

/// Names of the axes, the one that changes most often last.
const AXES: [&str; 8] = ["t_inner", "t_outer", "fx", "fy", "fz", "my", "mz", "speed"];

/// The values of an axis: `first`, `last` and `step` with colons between, or a single number.
fn values(text: &str) -> Result<Vec<f64>> {
    let numbers = text.split(':').map(|part| {
        let number = part.trim().parse().ok().filter(|x: &f64| x.is_finite());
        number.with_context(|| format!("{part:?} is not a number"))
    });
    let numbers = numbers.collect::<Result<Vec<f64>>>()?;
    let (first, last, step) = match numbers[..] {
        [_] => return Ok(numbers),
        [first, last, step] => (first, last, step),
        _ => bail!("give FIRST:LAST:STEP or a single number"),
    };
    let steps = (last - first) / step;
    ensure!(
        step != 0.0 && steps >= 0.0,
        "no steps of {step} lead from {first} to {last}"
    );
    // Rounding may leave the last step a little short.
    let steps = (steps * (1.0 + 1e-12) + 1e-9).floor();
    ensure!(steps < MOST_ROWS as f64, TOO_MANY);
    let later = (1..=steps as usize).map(|i| match first + i as f64 * step {
        value if value.abs() < 1e-9 * step.abs() => 0.0,
        // Rounded, so that steps of a tenth give tenths.
        value => format!("{value:.12e}").parse().unwrap_or(value),
    });
    Ok([first].into_iter().chain(later).collect())
}

/// The axes of a table: the values of each, none where it is not given.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Axes([Vec<f64>; AXES.len()]);

impl Axes {
    /// Reads axes such as `speed=0:20000:500`; an error names the one that is wrong.
    pub fn parse(texts: &[String]) -> Result<Self> {
        let mut axes = Self::default();
        for text in texts {
            axes.add(text)
                .map_err(|error| anyhow!("--table {text}: {error}"))?;
        }
        let counts = axes.0.iter().map(|values| values.len().max(1));
        let rows = counts.fold(1, usize::saturating_mul);
        ensure!(rows <= MOST_ROWS, "--table: {TOO_MANY}");
        Ok(axes)
    }

    fn add(&mut self, text: &str) -> Result<()> {
        let (name, range) = text.split_once('=').context(
            "an axis is NAME=FIRST:LAST:STEP or NAME=VALUE, such as speed=0:20000:500; the design file stands before --table",
        )?;
        let axis = AXES.iter().position(|axis| *axis == name.trim());
        let axis =
            axis.with_context(|| format!("{name:?} is none of the axes {}", AXES.join(", ")))?;
        ensure!(self.0[axis].is_empty(), "{name} is given twice");
        self.0[axis] = values(range)?;
        for temperature in self.0[..2].iter().flatten() {
            celsius(*temperature).map_err(|error| anyhow!(error))?;
        }
        Ok(())
    }

    /// Whether one of the temperatures is given.
    pub fn has_temperatures(&self) -> bool {
        self.0[..2].iter().any(|values| !values.is_empty())
    }

    /// The rows: all combinations, time being their number. A load or speed that is not given is 0, a temperature that
    /// is not given is `reference`; without that, rows have no temperatures.
    pub fn rows(&self, reference: Option<f64>) -> impl ExactSizeIterator<Item = LoadRow> + use<> {
        let mut axes = self.0.clone();
        for (i, values) in axes.iter_mut().enumerate() {
            if values.is_empty() {
                values.push(reference.filter(|_| i < 2).unwrap_or(0.0));
            }
        }
        let rows = axes.iter().map(Vec::len).product();
        (0..rows).map(move |number| {
            let mut rest = number;
            let mut row = [0.0; AXES.len()];
            for (value, axis) in row.iter_mut().zip(&axes).rev() {
                *value = axis[rest % axis.len()];
                rest /= axis.len();
            }
            let [inner, outer, load @ .., speed_rpm] = row;
            LoadRow {
                time_s: number as f64,
                load,
                speed_rpm,
                temperatures: reference.map(|_| [inner, outer]),
                probes: [None; 4],
            }
        })
    }
}

//! A spindle as what is replayed: see `replay`.

use crate::dispatch::{Details, Precision};
use crate::loads::LoadRow;
use crate::replay::{Replayed, Solved, SolvedRow};
use crate::spindle_file::SpindleFile;
use crate::spindles::AnySpindleSolver;
use spindle_bearing::{LifeRating, LimitSet, ShaftEnd};

/// A spindle with its solver.
pub struct OneSpindle<'s> {
    /// The spindle.
    pub file: &'s SpindleFile,
    /// Its solver.
    pub solver: &'s mut dyn AnySpindleSolver,
    /// The solver's precision.
    pub precision: Precision,
}

impl Replayed for OneSpindle<'_> {
    fn balls(&self) -> Vec<usize> {
        self.file.plan.rows.iter().map(|row| row.balls).collect()
    }

    fn is_spindle(&self) -> bool {
        true
    }

    fn has_nose(&self) -> bool {
        self.file.nose.is_some()
    }

    fn precision(&self) -> Precision {
        self.precision
    }

    fn ratings(&self) -> Vec<LifeRating<f64>> {
        self.file.ratings()
    }

    fn reset(&mut self) {
        self.solver.reset();
    }

    fn solve(&mut self, row: &LoadRow, _details: bool) -> Result<Solved, (&'static str, String)> {
        let end = self.file.nose.unwrap_or(ShaftEnd::rigid(0.0));
        let answer = self.solver.solve(&self.file.question(row), &end);
        let answer = answer.map_err(|status| (status.name(), status.to_string()))?;
        let limits = answer.rows.iter().map(|row| row.limits);
        Ok(Solved {
            status: answer.status,
            iterations: answer.iterations,
            displacement: answer.displacement,
            stiffness: answer.stiffness,
            stiffness_at_nose: self.file.nose.map(|_| answer.stiffness_at),
            limits: limits.fold(LimitSet::default(), LimitSet::union),
            rows: answer
                .rows
                .into_iter()
                .map(|row| SolvedRow {
                    force: row.force,
                    preload: row.preload,
                    details: Details {
                        balls: row.balls,
                        motions: row.motions,
                        frequencies: row.frequencies,
                    },
                })
                .collect(),
        })
    }
}

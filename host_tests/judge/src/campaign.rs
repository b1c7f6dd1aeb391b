//! The stability campaign: very many cases of every kind, solved in both precisions, each answer
//! judged by the reference build, each refusal looked into.

pub mod balance;
pub mod contract;
pub mod families;
pub mod judge;
pub mod page;
pub mod report;
pub mod sets;

use crate::progress::Progress;
use families::{Family, Trial};
use judge::{Record, Verdict};
use rayon::prelude::*;

/// Which cases, and how hard to look at them.
#[derive(Debug, Clone)]
pub struct Plan {
    /// Seed of all cases.
    pub seed: u64,
    /// Solves of each precision to count, over all families.
    pub solves: usize,
    /// Sets of bearings are solved in the place of bearings.
    pub of_sets: bool,
    /// Families to take; the solves of the other families are left out.
    pub families: Vec<Family>,
    /// Refusals of a family that the reference build looks into with its own search, the first ones.
    pub searches: usize,
    /// Every so many-th case of a family, the branch from rest is followed to its speed.
    pub followed: usize,
}

impl Plan {
    /// Seed of the committed report.
    pub const SEED: u64 = 1;

    /// Families of which bearings or sets are drawn.
    pub const fn all(of_sets: bool) -> &'static [Family] {
        if of_sets {
            &Family::OF_SETS
        } else {
            &Family::ALL
        }
    }

    /// Cases of a family: every family gets as many solves as any other.
    pub fn cases(&self, family: Family) -> usize {
        self.solves
            .div_ceil(Self::all(self.of_sets).len())
            .div_ceil(family.ticks())
    }

    /// The case of this family and number.
    pub fn trial(&self, family: Family, index: usize) -> Trial {
        match self.of_sets {
            true => Trial::of_set(self.seed, family, index),
            false => Trial::new(self.seed, family, index),
        }
    }
}

/// Runs a campaign; the records are in the order of families, cases, ticks and precisions, whatever
/// the order of work was.
pub fn run(plan: &Plan, progress: &dyn Progress) -> Vec<Record> {
    let solves = |family: &Family| plan.cases(*family) * family.ticks();
    progress.expect(plan.families.iter().map(solves).sum());
    let mut records = Vec::new();
    for &family in &plan.families {
        progress.stage(family.name());
        let judged = |index| {
            let trial = plan.trial(family, index);
            let judged = judge::judge(&trial, index % plan.followed == 0);
            progress.done(family.ticks());
            judged.into_iter().map(|solve| solve.records)
        };
        let cases = (0..plan.cases(family)).into_par_iter();
        let mut solves: Vec<[Record; 2]> = cases.flat_map_iter(judged).collect();

        let is_open = |record: &Record| record.verdict == Verdict::Undecided;
        let open = solves.iter_mut().filter(|solve| solve.iter().any(is_open));
        let open: Vec<_> = open.take(plan.searches).collect();
        open.into_par_iter().for_each(|solve| {
            judge::search(&plan.trial(family, solve[0].index), solve);
        });
        records.extend(solves.into_iter().flatten());
    }
    records
}

//! The stability campaign: very many cases of every kind, solved in both precisions, each answer
//! judged by the reference build, each refusal looked into.

pub mod balance;
pub mod contract;
pub mod detail;
pub mod families;
pub mod judge;
pub mod report;

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
    /// Families to take; the solves of those left out are left out.
    pub families: Vec<Family>,
    /// Refusals of a family that the reference build looks into with its own search, the first ones;
    /// `None` for all.
    pub searches: Option<usize>,
    /// Every so many-th case of a family, the branch from rest is followed to its speed.
    pub followed: usize,
}

impl Plan {
    /// Seed of the committed report.
    pub const SEED: u64 = 1;
    /// Solves of the committed report.
    pub const SOLVES: usize = 1_000_000;
    /// Searches of the committed report.
    pub const SEARCHES: usize = 40;
    /// One case of so many is followed from rest in the committed report.
    pub const FOLLOWED: usize = 20;

    /// Cases of a family: every family gets as many solves as any other.
    pub fn cases(&self, family: Family) -> usize {
        self.solves
            .div_ceil(Family::ALL.len())
            .div_ceil(family.ticks())
    }
}

/// Runs a campaign; the records are in the order of families, cases, ticks and precisions, whatever
/// the order of work was.
pub fn run(plan: &Plan, progress: &dyn Progress) -> Vec<Record> {
    let mut records = Vec::new();
    let total: usize = plan
        .families
        .iter()
        .map(|f| plan.cases(*f) * f.ticks())
        .sum();
    progress.expect(total);
    for &family in &plan.families {
        progress.stage(family.name());
        let of_family: Vec<Vec<Record>> = (0..plan.cases(family))
            .into_par_iter()
            .map(|index| {
                let trial = Trial::new(plan.seed, family, index);
                let mut judged = judge::judge(&trial);
                if index % plan.followed == 0 {
                    judge::follow(&trial, &mut judged);
                }
                progress.done(family.ticks());
                judged.ticks.iter().flat_map(|t| t.records).collect()
            })
            .collect();
        records.extend(of_family.into_iter().flatten());
    }
    progress.stage("refusals");
    search(plan, &mut records);
    records
}

/// Has the reference build look for equilibria where the solver found none and nothing else decides.
fn search(plan: &Plan, records: &mut [Record]) {
    let most = plan.searches.unwrap_or(usize::MAX);
    let mut solves: Vec<Vec<&mut Record>> = Vec::new();
    let mut of_family = 0;
    for record in records {
        if record.verdict != Verdict::Undecided {
            continue;
        }
        let place = |r: &Record| (r.family, r.index, r.tick);
        let last = solves.last().map(|s| place(s[0]));
        // Both precisions share a search.
        if let Some(solve) = solves.last_mut()
            && last == Some(place(record))
        {
            solve.push(record);
            continue;
        }
        if last.is_none_or(|(family, ..)| family != record.family) {
            of_family = 0;
        }
        if of_family < most {
            of_family += 1;
            solves.push(vec![record]);
        }
    }
    solves.into_par_iter().for_each(|mut solve| {
        let trial = Trial::new(plan.seed, solve[0].family, solve[0].index);
        let _ = judge::search(&trial, &mut solve);
    });
}

//! The stability campaign: very many cases of every kind, solved in both precisions, each answer
//! judged by the reference build, each refusal looked into.

pub mod balance;
pub mod contract;
pub mod families;
pub mod judge;
pub mod page;
pub mod report;

use crate::progress::Progress;
use families::{Family, Trial};
use judge::{PRECISIONS, Record, Verdict};
use rayon::prelude::*;
use std::fmt::Write;

/// Which cases, and how hard to look at them.
#[derive(Debug, Clone)]
pub struct Plan {
    /// Seed of all cases.
    pub seed: u64,
    /// Solves of each precision to count, over all families.
    pub solves: usize,
    /// Families to take; the solves of the other families are left out.
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
    let solves = |family: &Family| plan.cases(*family) * family.ticks();
    progress.expect(plan.families.iter().map(solves).sum());
    let mut records = Vec::new();
    for &family in &plan.families {
        progress.stage(family.name());
        let judged = |index| {
            let trial = Trial::new(plan.seed, family, index);
            let mut judged = judge::judge(&trial);
            if index % plan.followed == 0 {
                judge::follow(&trial, &mut judged);
            }
            progress.done(family.ticks());
            judged.iter().flat_map(|solve| solve.records).collect()
        };
        let cases = (0..plan.cases(family)).into_par_iter();
        let of_family: Vec<Vec<Record>> = cases.map(judged).collect();
        records.extend(of_family.into_iter().flatten());
    }
    progress.stage("refusals");
    search(plan, &mut records);
    records
}

/// Has the reference build look for equilibria where the solver found none and nothing else decides.
fn search(plan: &Plan, records: &mut [Record]) {
    let mut left = [plan.searches.unwrap_or(usize::MAX); Family::ALL.len()];
    let is_open = |record: &Record| record.verdict == Verdict::Undecided;
    // Both precisions of a solve share a search.
    let solves = records.chunks_exact_mut(PRECISIONS.len()).filter(|solve| {
        let left = &mut left[solve[0].family as usize];
        let is_taken = *left > 0 && solve.iter().any(is_open);
        *left -= usize::from(is_taken);
        is_taken
    });
    let solves: Vec<&mut [Record]> = solves.collect();
    solves.into_par_iter().for_each(|solve| {
        let trial = Trial::new(plan.seed, solve[0].family, solve[0].index);
        let _ = judge::search(&trial, solve);
    });
}

/// One case in full, to look into: what is given, what both precisions and the reference build make of it.
pub fn in_full(trial: &Trial) -> String {
    let mut text = format!("{:#?}\nmade from {:?}\n", trial.case, trial.known);
    let mut judged = judge::judge(trial);
    judge::follow(trial, &mut judged);
    for mut solve in judged {
        let searched = judge::search(trial, &mut solve.records);
        let _ = writeln!(text, "\n{:?}", trial.ticks[solve.records[0].tick]);
        for ((record, answer), truth) in solve.records.iter().zip(solve.answers).zip(solve.truths) {
            let _ = writeln!(text, "\n{record:#?}\n{:#?}", answer.figures);
            for truth in truth.iter().chain(&searched) {
                let _ = writeln!(
                    text,
                    "\nthe reference build: u {:?}, K {:?}",
                    truth.u, truth.k
                );
                for ball in &truth.balls {
                    let _ = writeln!(text, "{ball:?}");
                }
            }
        }
    }
    text
}

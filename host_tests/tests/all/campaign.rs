//! Small campaigns, held to their contract.

use host_tests::campaign::families::{Family, Trial};
use host_tests::campaign::{Plan, contract, judge, report, run};
use host_tests::dispatch::Precision;

fn small_campaign(seed: u64) -> Vec<judge::Record> {
    let plan = Plan {
        seed,
        solves: 20_000,
        families: Family::ALL.to_vec(),
        // They take seconds.
        searches: Some(0),
    };
    run(&plan, &())
}

#[test]
fn every_family_holds_its_contract() {
    let records = small_campaign(Plan::SEED);
    let broken: Vec<String> = report::summaries(&records)
        .iter()
        .flat_map(contract::broken)
        .chain(contract::broken_estimates(&records))
        .collect();
    let look_at = report::worst(&records);
    assert!(broken.is_empty(), "\n{}\n{look_at}", broken.join("\n"));
}

/// Answers that are not what they say are so few that it takes more seeds to count them.
#[test]
#[ignore = "a minute; `.ci/run` runs it with CI_LONG=1"]
fn four_seeds_hold_what_answers_say_of_their_errors_and_how_long_they_take() {
    let mut records = small_campaign(Plan::SEED);
    let summaries = report::summaries(&records);
    let mut broken: Vec<String> = summaries.iter().filter_map(contract::slow).collect();
    let mut look_at = report::worst(&records);
    for seed in 2..=4 {
        let more = small_campaign(seed);
        for record in more.iter().filter(|r| contract::deceives(r)) {
            let (family, precision) = (record.family.name(), record.precision);
            look_at += &format!(
                "seed {seed}, deceives: {family} {} in {precision:?}\n",
                record.index
            );
        }
        records.extend(more);
    }
    let of_all = contract::broken_estimates(&records);
    broken.extend(of_all.iter().map(|what| format!("four seeds, {what}")));
    assert!(broken.is_empty(), "\n{}\n{look_at}", broken.join("\n"));
}

/// Solves in which a ball may leave its groove while the ring is still far from its place: they have an equilibrium.
#[test]
fn a_ball_that_diverges_on_the_way_does_not_cost_the_solve() {
    for (family, index, precision) in [
        (Family::Moderate, 42, Precision::F64),
        (Family::Reversed, 675, Precision::F32),
        (Family::Reversed, 967, Precision::F64),
        (Family::ZeroLoads, 147, Precision::F32),
        (Family::ZeroLoads, 1012, Precision::F64),
        (Family::Random, 574, Precision::F64),
    ] {
        let judged = judge::judge(&Trial::new(Plan::SEED, family, index));
        let record = judged.ticks[0].records[precision as usize];
        let place = format!("{} {index}, {precision:?}", family.name());
        assert!(record.is_solved(), "{place}: {}", record.status);
        let errors = record.errors.expect("an answer was judged");
        let tolerance = [2e-5, 3e-13][precision as usize];
        assert!(errors[2] <= tolerance, "{place}: K off by {:e}", errors[2]);
    }
}

/// Beyond the contract's cases: balls off the inner race whose cage speed is next to its pole, where a bound
/// on it balances loads that the model does not.
#[test]
fn what_only_the_pole_of_the_cage_speed_balances_is_refused() {
    for (family, index) in [(Family::ZeroLoads, 42_932), (Family::Radial, 38_764)] {
        let judged = judge::judge(&Trial::new(Plan::SEED, family, index));
        for record in judged.ticks[0].records {
            let (name, precision) = (family.name(), record.precision);
            assert_eq!(record.status, "unseated", "{name} {index}, {precision:?}");
        }
    }
}

/// Beyond the contract's cases: a ball's force goes out of all proportion when the ring is already there, which
/// says nothing of the ring's steps. What is no equilibrium is then refused, and not an answer.
#[test]
fn a_ball_whose_force_diverges_does_not_make_an_unbalanced_ring_converge() {
    let judged = judge::judge(&Trial::new(Plan::SEED, Family::Random, 2_282));
    let records = judged.ticks[0].records;
    assert!(
        records.iter().any(judge::Record::is_solved),
        "there is an equilibrium"
    );
    for record in records {
        let precision = record.precision;
        if !record.is_solved() {
            assert_eq!(record.status, "unseated", "{precision:?}");
            continue;
        }
        let errors = record.errors.expect("an answer was judged");
        let estimate = record.estimate.expect("an answer has an estimate");
        for (error, estimate) in errors.iter().zip(estimate) {
            assert!(
                *error <= estimate,
                "{precision:?}: {error:e} beyond {estimate:e}"
            );
        }
    }
}

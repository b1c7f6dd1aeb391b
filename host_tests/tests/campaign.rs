//! A small campaign, held to its contract.

use host_tests::campaign::{Plan, contract, families::Family, report, run_quietly};

#[test]
fn every_family_holds_its_contract() {
    let plan = Plan {
        seed: Plan::SEED,
        solves: 20_000,
        families: Family::ALL.to_vec(),
        // They take seconds.
        searches: Some(0),
    };
    let records = run_quietly(&plan);
    let broken: Vec<String> = report::summaries(&records)
        .iter()
        .flat_map(contract::broken)
        .chain(contract::broken_estimates(&records))
        .collect();
    assert!(
        broken.is_empty(),
        "\n{}\n{}",
        broken.join("\n"),
        report::worst(&records)
    );
}

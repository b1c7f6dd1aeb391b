//! Files of `recipes/ross_shaft.py`: sets on elastic shafts for ROSS, the rotor dynamics package.

use super::solves::{Balls, ask};
use judge::cases::elastic;
use serde_json::json;
use spindle_file::dispatch::Precision;
use std::fs;

#[test]
#[ignore = "writes files for a program that is not here"]
fn flexibilities_are_written_for_ross() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../target/ross_shafts");
    fs::create_dir_all(folder).unwrap();
    for (number, case) in elastic().iter().enumerate() {
        // Rows in a sleeve move together, which ROSS's rows cannot. A row of set 25 is 0.1 um from the end of a section: too
        // close for elements of stiffness.
        if case.plan.spring.is_some() || number == 25 {
            continue;
        }
        let shaft = case.plan.shaft.as_ref().unwrap();
        let balls = Balls::from(case.attitude);
        let nose = case.question.ends[0].position;
        let found = ask(&case.plan, balls, Precision::F64, &case.question).unwrap();
        let rows = case.plan.rows.iter().zip(&found.rows);
        let rows = rows.map(
            |(row, found)| json!({ "position": row.position, "stiffness": found.stiffness_on_shaft }),
        );
        let spindle = json!({
            "youngs_modulus": shaft.material.youngs_modulus,
            "poissons_ratio": shaft.material.poissons_ratio,
            "sections": shaft.sections.iter().map(|s| [s.from, s.to, s.outer, s.inner]).collect::<Vec<_>>(),
            "rows": rows.collect::<Vec<_>>(),
            "noses": [{ "position": nose, "flexibility": found.at[0].compliance }],
        });
        let path = format!("{folder}/{number:02}.json");
        fs::write(path, spindle.to_string()).unwrap();
    }
}

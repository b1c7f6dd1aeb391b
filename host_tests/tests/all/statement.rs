//! Statements of the validation book, and how their numbers are printed.

use host_tests::validation::statement::{Measure, Statement, shown, thousands};

#[test]
fn a_statement_falls_with_any_of_its_measures() {
    let good = Measure::above("good", 2.0, "", 1.0);
    let bad = [
        Measure::above("too small", 1.0, "", 1.0),
        Measure::below("too large", 1.0, "", 1.0),
        Measure::at_most("too large", 1.1, "", 1.0),
        Measure::within("too small", 1.0, "", 1.0, 3.0),
        Measure::within("too large", 3.1, "", 1.0, 3.0),
        Measure::rounding("too large, negative", -2e-9, "", 1e-9),
        Measure::count("too many", 3, 2),
        Measure::count("too few", 1, 2),
        Measure::at_most("no number", f64::NAN, "", 1.0),
        Measure::above("no number", f64::NAN, "", 1.0),
    ];
    assert!(Statement::ours("", vec![good.clone()]).holds());
    assert!(!Statement::ours("", vec![]).holds());
    for bad in bad {
        let statement = Statement::ours("", vec![good.clone(), bad]);
        assert!(
            !statement.holds() && statement.complaint().is_some(),
            "{statement:?}"
        );
    }
}

#[test]
fn numbers_are_short() {
    for (value, text) in [
        (0.0, "0"),
        (12.0, "12"),
        (0.012_345, "0.01235"),
        (-48.691, "-48.69"),
        (2.860_9e8, "2.861e8"),
        (1e-12, "1e-12"),
        (123_456.0, "123456"),
    ] {
        assert_eq!(shown(value), text);
    }
    for (value, text) in [
        (0.0, "0"),
        (500.0, "500"),
        (20_000.0, "20,000"),
        (1e6, "1,000,000"),
    ] {
        assert_eq!(thousands(value), text);
    }
}

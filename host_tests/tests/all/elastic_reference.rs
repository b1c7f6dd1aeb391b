//! The reference build of elastic spindles.

use host_tests::cases::elastic;

#[test]
fn solved_cases_are_read() {
    let cases = elastic();
    assert_eq!(cases.len(), 42);
    for case in &cases {
        let rows = case.set.plan.rows.len();
        assert_eq!((case.supports.len(), case.set.rows.len()), (rows, rows));
    }
}

//! The solve whose answer is known, on the shipped spindle.

use super::shipped::shipped;
use super::spindle::SPINDLE;
use mock::rig::SPEED;
use spindle_monitor::BoardReport;
use spindle_monitor::board::Check;
use spindle_monitor::self_check::KnownAnswer;

/// The preload, N.
const KNOWN_LOAD: f32 = 250.0;

fn known(preload: f32) -> KnownAnswer<'static, 2, 16, 5, 2> {
    KnownAnswer::new(&SPINDLE, preload, Box::leak(Box::default()))
}

/// The answer's checksum, and the steps to it.
fn answer(known: &mut KnownAnswer<'_, 2, 16, 5, 2>) -> (u32, usize) {
    let mut steps = 1;
    loop {
        match known.step() {
            Some(sum) => return (sum, steps),
            None => steps += 1,
        }
    }
}

#[test]
fn a_known_answer_is_the_same_every_time_and_another_one_for_another_load() {
    let mut first = known(KNOWN_LOAD);
    let (sum, steps) = answer(&mut first);
    // Two solves of an iteration each at least, neither of which fails.
    assert!((4..=20).contains(&steps), "{steps}");
    for _ in 0..3 {
        assert_eq!(answer(&mut first), (sum, steps));
    }
    assert_eq!(answer(&mut known(KNOWN_LOAD)), (sum, steps));
    let (other, _) = answer(&mut known(KNOWN_LOAD.next_up()));
    assert_ne!(other, sum);
}

/// A processor that computes wrongly once: another load stands in for it. PC8 stays low, though later answers are right.
#[test]
fn a_wrong_answer_is_a_failed_check_that_takes_pc8_away_for_good() {
    let expected = answer(&mut known(KNOWN_LOAD)).0;
    let mut rig = shipped().run_up();
    let mut check = Check::NotYet;
    for (i, load) in [KNOWN_LOAD, KNOWN_LOAD.next_up(), KNOWN_LOAD]
        .into_iter()
        .enumerate()
    {
        check = check.and(answer(&mut known(load)).0 == expected);
        rig.monitor.set_board(BoardReport {
            known_answer: check,
            ..BoardReport::NONE
        });
        // Nobody sends temperatures, whose alarm is due after 5 s.
        for _ in 0..1200 {
            let outputs = rig.good([0.0; 5], SPEED).outputs;
            assert_eq!((outputs.no_alarm, outputs.monitored), (true, i == 0));
        }
        assert_eq!(rig.host.board.known_answer, check);
    }
    assert_eq!(check, Check::Failed);
}

#[test]
fn a_solve_that_has_no_answer_has_a_checksum_too() {
    for preload in [0.0, f32::NAN, f32::INFINITY, f32::MAX, -1e-30] {
        let (sum, steps) = answer(&mut known(preload));
        assert!(steps <= 101, "{preload}: {steps}");
        assert_eq!(answer(&mut known(preload)), (sum, steps));
    }
}

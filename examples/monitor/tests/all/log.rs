//! Law of `monitor::log`: a start finds the newest record that was verified, or a complete one that was begun since.

use mock::flash::{ERASE, FailingFlash, Leftover};
use proptest::prelude::*;
use proptest::test_runner::{RngAlgorithm, TestRng};
use spindle_monitor::log::{Counts, Log, PAYLOAD, WriteError};
use std::ops::Range;

const SECTOR: usize = 1024;

type Payload = [u8; PAYLOAD];

/// Random numbers that are the same in every run.
fn seeded(seed: u64) -> TestRng {
    TestRng::from_seed(RngAlgorithm::ChaCha, &[seed.to_le_bytes(); 4].concat())
}

/// A flash of two sectors, and the records that it must hold.
#[derive(Clone)]
struct Bench<const UNIT: usize> {
    flash: FailingFlash<UNIT, SECTOR>,
    random: TestRng,
    /// Verified records, the newest last, and those begun since.
    verified: Vec<Payload>,
    begun: Vec<Payload>,
}

impl<const UNIT: usize> Bench<UNIT> {
    /// A log of some records.
    fn holding(records: usize) -> Self {
        let mut bench = Self {
            flash: FailingFlash::new(2),
            random: seeded(UNIT as u64),
            verified: Vec::new(),
            begun: Vec::new(),
        };
        bench.start(None, records);
        assert_eq!(bench.verified.len(), records);
        bench
    }

    /// A start with so much power, which writes some records.
    fn start(&mut self, power: Option<usize>, records: usize) -> Counts {
        let flash = std::mem::take(&mut self.flash).powered(power);
        let (mut log, found) = Log::open(flash);
        if found != self.verified.last().copied() {
            let found = found.expect("a record was lost");
            assert!(self.begun.contains(&found), "an older or an invented one");
            self.verified.push(found);
        }
        self.begun.clear();
        for _ in 0..records {
            let payload = self.random.random();
            let written = log.counts().written;
            self.begun.push(payload);
            log.begin(&payload);
            let steps = std::iter::from_fn(|| log.step().then_some(())).count();
            assert!(steps <= 6 * 48);
            if log.counts().written > written {
                self.verified.push(payload);
                self.begun.clear();
            }
        }
        let counts = log.counts();
        self.flash = log.into_flash();
        counts
    }

    fn flip_bits(&mut self, bits: usize, range: Range<usize>) {
        for _ in 0..bits {
            let at = self.random.random_range(range.clone());
            self.flash.bytes[at] ^= 1 << self.random.random_range(0..8);
        }
    }

    /// Both halves have the newest record: either may go.
    fn has_two_copies(&self) {
        for half in 0..2 {
            let mut bench = self.clone();
            bench.flash.bytes[half * SECTOR..][..SECTOR].fill(0);
            bench.start(None, 0);
        }
    }
}

#[test]
fn ten_thousand_power_cuts_one_after_another_lose_and_invent_nothing() {
    fn cut<const UNIT: usize>() -> [usize; 3] {
        let mut bench = Bench::<UNIT>::holding(0);
        let (mut cuts, mut between) = (0, 0);
        for _ in 0..4000 {
            bench.flash.leftover = Leftover::ALL[bench.random.random_range(0..4)];
            let power = bench.random.random_range(1..=300);
            let counts = bench.start(Some(power), 3);
            cuts += usize::from(bench.flash.power == Some(0));
            // One copy is complete, and the other is not.
            between += counts.written as usize % 2;
        }
        [cuts, between, bench.flash.failed_erases as usize]
    }
    let counts = [cut::<1>(), cut::<4>(), cut::<32>()];
    let total = |i: usize| counts.iter().map(|counts| counts[i]).sum::<usize>();
    assert!(
        total(0) >= 10_000 && total(1) >= 4000 && total(2) >= 1000,
        "{counts:?}"
    );
}

#[test]
fn power_lost_at_any_byte_of_a_start_and_again_at_the_next_loses_nothing() {
    fn cut<const UNIT: usize>() -> usize {
        let mut cuts = 0;
        for records in 0..10 {
            let bench = Bench::<UNIT>::holding(records);
            for power in 1..=4 * 64 + 2 * ERASE {
                for again in [None, Some(1), Some(2), Some(50)] {
                    let mut bench = bench.clone();
                    bench.flash.leftover = Leftover::ALL[power % 4];
                    for power in [Some(power), again] {
                        bench.start(power, 1);
                        cuts += usize::from(bench.flash.power == Some(0));
                    }
                    assert_eq!(bench.start(None, 1).failed, 0);
                    assert_eq!(bench.start(None, 0).failed, 0);
                }
            }
        }
        cuts
    }
    let cuts = [cut::<4>(), cut::<32>()];
    assert!(cuts.iter().sum::<usize>() > 30_000, "{cuts:?}");
}

#[test]
fn ten_thousand_flips_of_bits_in_a_half_lose_nothing() {
    fn flip<const UNIT: usize>() {
        for records in 1..=6 {
            let holding = Bench::<UNIT>::holding(records);
            for round in 0..1000 {
                let mut bench = holding.clone();
                bench.random = seeded(round as u64);
                for half in [round % 2, 1 - round % 2] {
                    let bits = 1 + round % 5;
                    bench.flip_bits(bits, half * SECTOR..half * SECTOR + 100 * records);
                    assert_eq!(bench.start(None, 0).failed, 0);
                }
            }
        }
    }
    flip::<4>();
    flip::<32>();
}

#[test]
fn ten_thousand_flips_of_bits_in_both_halves_leave_a_verified_record_or_none() {
    let (mut newest, mut older, mut none) = (0, 0, 0);
    for records in 1..=6 {
        let holding = Bench::<4>::holding(records);
        for round in 0..2000 {
            let mut bench = holding.clone();
            bench.random = seeded(round);
            for half in 0..2 {
                bench.flip_bits(2, half * SECTOR..half * SECTOR + 96 * records);
            }
            let (mut log, found) = Log::open(bench.flash);
            match found {
                None => none += 1,
                found if found == bench.verified.last().copied() => newest += 1,
                Some(found) => {
                    assert!(bench.verified.contains(&found), "invented");
                    older += 1;
                }
            }
            // The next record is newer than all that may still be read.
            log.begin(&[7; PAYLOAD]);
            while log.step() {}
            let (log, found) = Log::open(log.into_flash());
            assert_eq!((found, log.counts().failed), (Some([7; PAYLOAD]), 0));
        }
    }
    assert!(
        newest > 5000 && older > 2000 && none > 2000,
        "{newest} {older} {none}"
    );
}

/// A record that was torn before the newest one was written, and reads well later.
#[test]
fn a_torn_record_that_reads_well_another_time_is_not_the_newest() {
    let mut bench = Bench::<4>::holding(2);
    let mut whole = bench.clone();
    whole.start(None, 1);
    bench.start(Some(47), 1);
    bench.start(None, 1);
    bench.flash.bytes[160..240].copy_from_slice(&whole.flash.bytes[160..240]);
    bench.start(None, 0);
    bench.has_two_copies();
}

#[test]
fn an_erase_that_power_interrupts_is_done_again_even_if_it_looks_complete() {
    let mut bench = Bench::<4>::holding(7);
    bench.flash.leftover = Leftover::Nothing;
    bench.start(Some(1), 0);
    assert_eq!(
        (bench.flash.failed_erases, &bench.flash.erased[..]),
        (1, &[0, 0][..])
    );
    bench.start(None, 0);
    assert_eq!(bench.flash.erased, [1, 1]);
}

#[test]
fn an_erase_that_fails_costs_no_record_whatever_it_leaves() {
    for (half, leftover) in [0, 1]
        .into_iter()
        .flat_map(|half| Leftover::ALL.map(|of| (half, of)))
    {
        for worn in [false, true] {
            let mut bench = Bench::<4>::holding(10);
            bench.flash.leftover = leftover;
            bench.flash.stuck = [half].into();
            if worn {
                bench.flash.worn = (half * SECTOR..(half + 1) * SECTOR).collect();
            }
            let mut failed = bench.start(None, 1).failed;
            let erased = bench.flash.erased.clone();
            for _ in 0..20 {
                failed += bench.start(None, 1).failed;
                // The good copy stays as long as there is no other.
                assert!(!worn || leftover == Leftover::Everything || bench.flash.erased == erased);
            }
            assert!(failed > 0);
            bench.flash.worn.clear();
            bench.flash.stuck.clear();
            bench.start(None, 0);
            assert_eq!(bench.start(None, 1).failed, 0);
            bench.has_two_copies();
        }
    }
}

#[test]
fn worn_cells_are_left_behind_and_a_flash_that_takes_nothing_is_told_of() {
    let mut bench = Bench::<4>::holding(2);
    // Two attempts of the first half meet one of them, and one of the second.
    bench.flash.worn = [170, 250, SECTOR + 203].into();
    let counts = bench.start(None, 1);
    assert_eq!((counts.written, counts.failed), (2, 0));
    bench.has_two_copies();
    bench.flash.worn = (0..2 * SECTOR).collect();
    let counts = bench.start(None, 1);
    assert_eq!((counts.written, counts.failed), (0, 2));
    assert_eq!(counts.error, Some(WriteError::Flash));
    bench.flash.worn.clear();
    bench.start(None, 1);
    bench.has_two_copies();
}

#[test]
fn a_full_log_keeps_its_newest_record_and_says_so() {
    // 1024 bytes are 10 slots of 96.
    let mut bench = Bench::<4>::holding(10);
    let counts = bench.start(None, 0);
    assert_eq!((counts.written, counts.failed), (2, 0));
    assert_eq!(bench.flash.erased, [1, 1]);
    let counts = bench.start(None, 11);
    assert_eq!((counts.written, counts.failed), (18, 4));
    assert_eq!(counts.error, Some(WriteError::Full));
    bench.begun.clear();
    bench.start(None, 0);
    bench.has_two_copies();
}

#[test]
fn slots_are_whole_units_of_the_flash() {
    fn slot<const UNIT: usize>() -> usize {
        Log::<FailingFlash<UNIT, SECTOR>>::SLOT
    }
    let slots = [slot::<1>(), slot::<4>(), slot::<32>(), slot::<64>()];
    assert_eq!(slots, [96, 96, 96, 128]);
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(1000) })]

    #[test]
    fn any_content_ends_in_a_verified_record_or_none_and_can_be_written_over(
        pieces in prop::collection::vec(
            (0..2 * SECTOR, prop::collection::vec(any::<u8>(), 1..600)), 1..6),
        unreadable in prop::collection::btree_set((0..2 * SECTOR / 32).prop_map(|unit| unit * 32), 0..6),
        records in 0..6_usize,
    ) {
        let mut bench = Bench::<32>::holding(records);
        for (at, piece) in &pieces {
            for (to, from) in bench.flash.bytes[*at..].iter_mut().zip(piece) {
                *to = *from;
            }
        }
        bench.flash.unreadable = unreadable;
        let (log, found) = Log::open(bench.flash.clone());
        prop_assert!(found.is_none_or(|found| bench.verified.contains(&found)));
        prop_assert_eq!(log.counts().failed, 0);
        bench.verified = found.into_iter().collect();
        prop_assert_eq!(bench.start(None, 1).failed, 0);
        bench.has_two_copies();
    }
}

//! What the monitor has learnt outlasts the power: the log of `monitor::retained` on a flash in memory that
//! forgets its manners as real ones do.

use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashErrorKind, ReadNorFlash, check_erase, check_read, check_write,
};
use proptest::prelude::*;
use spindle_bearing::Bearing;
use spindle_bearing::monitor::judgement::{
    Alarm, BANDS, Baseline, BaselineSettings, Changes, Findings, Level,
};
use spindle_bearing::monitor::learning::Learning;
use spindle_bearing::monitor::loads::LoadSample;
use spindle_bearing::monitor::retained::{
    ATTEMPTS, Identity, LIFE_US, Past, STANDSTILL_LIFE_US, Store, WriteError,
};
use spindle_bearing::monitor::settings::MonitorSettings;
use spindle_bearing::monitor::telemetry::{Recovery, RetentionReport};
use spindle_bearing::monitor::tick::{NoCycles, NoWatchdog};
use spindle_bearing::monitor::{Judgement, Life, Marks, Monitor, Readings};
use spindle_bearing::{Design, FreeContact, Material};
use std::collections::BTreeSet;

const DESIGN: Design = Design {
    ball_diameter: 6.35e-3,
    pitch_diameter: 36e-3,
    inner_groove_factor: 0.515,
    outer_groove_factor: 0.525,
    free_contact: FreeContact::Angle(15.0 * std::f64::consts::PI / 180.0),
    inner_shoulder_angle: 48.0 * std::f64::consts::PI / 180.0,
    outer_shoulder_angle: 47.5 * std::f64::consts::PI / 180.0,
    first_ball: 0.0,
    ring: Material::STEEL,
    ball: Material::STEEL,
};
static BEARING: Bearing<f32, 16> = match Bearing::<f32, 16>::new(&DESIGN) {
    Ok(bearing) => bearing,
    Err(_) => panic!("this bearing cannot be built"),
};
static SETTINGS: MonitorSettings = {
    let mut settings = MonitorSettings::new(&DESIGN, 16);
    settings.tick.deadline_cycles *= 10;
    settings
};
/// Worked out by the compiler, as a firmware has it.
const IDENTITY: Identity = Identity::new(&DESIGN, 16, &BOUNDS);
const BOUNDS: BaselineSettings = MonitorSettings::new(&DESIGN, 16).judgement.baseline;

/// A flash of two sectors, units of `UNIT` bytes. `ECC`: a unit that is written only in part, or twice, cannot be
/// read until it is erased.
#[derive(Debug, Clone)]
struct Memory<const UNIT: usize, const SECTOR: usize, const ECC: bool> {
    bytes: Vec<u8>,
    unreadable: BTreeSet<usize>,
    /// Bytes that are still written before the power goes: an erased sector counts as one.
    power: Option<usize>,
    /// It is gone: nothing works any more.
    dead: bool,
    /// Places that do not hold what is written there.
    worn: BTreeSet<usize>,
    erased: Vec<u64>,
    written: u64,
    refuses_to_erase: bool,
}

impl<const UNIT: usize, const SECTOR: usize, const ECC: bool> Memory<UNIT, SECTOR, ECC> {
    fn new(sectors: usize) -> Self {
        Self {
            bytes: vec![0xff; sectors * SECTOR],
            unreadable: BTreeSet::new(),
            power: None,
            dead: false,
            worn: BTreeSet::new(),
            erased: vec![0; sectors],
            written: 0,
            refuses_to_erase: false,
        }
    }

    /// Power is back.
    fn powered(mut self, power: Option<usize>) -> Self {
        (self.power, self.dead) = (power, false);
        self
    }

    /// Whether the power goes right now.
    fn goes_out(&mut self) -> bool {
        match &mut self.power {
            None => false,
            Some(0) => {
                self.dead = true;
                true
            }
            Some(left) => {
                *left -= 1;
                false
            }
        }
    }
}

impl<const UNIT: usize, const SECTOR: usize, const ECC: bool> ErrorType
    for Memory<UNIT, SECTOR, ECC>
{
    type Error = NorFlashErrorKind;
}

impl<const UNIT: usize, const SECTOR: usize, const ECC: bool> ReadNorFlash
    for Memory<UNIT, SECTOR, ECC>
{
    const READ_SIZE: usize = UNIT;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), NorFlashErrorKind> {
        check_read(self, offset, bytes.len())?;
        if self.dead {
            return Err(NorFlashErrorKind::Other);
        }
        let range = offset as usize..offset as usize + bytes.len();
        if self.unreadable.range(range.clone()).next().is_some() {
            return Err(NorFlashErrorKind::Other);
        }
        bytes.copy_from_slice(&self.bytes[range]);
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.bytes.len()
    }
}

impl<const UNIT: usize, const SECTOR: usize, const ECC: bool> NorFlash
    for Memory<UNIT, SECTOR, ECC>
{
    const WRITE_SIZE: usize = UNIT;
    const ERASE_SIZE: usize = SECTOR;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), NorFlashErrorKind> {
        check_erase(self, from, to)?;
        if self.dead || self.refuses_to_erase {
            return Err(NorFlashErrorKind::Other);
        }
        for sector in from as usize / SECTOR..to as usize / SECTOR {
            let range = sector * SECTOR..(sector + 1) * SECTOR;
            if self.goes_out() {
                // Some bits are gone, some are not.
                for (i, byte) in self.bytes[range].iter_mut().enumerate() {
                    *byte |= (i as u8).wrapping_mul(73);
                }
                return Err(NorFlashErrorKind::Other);
            }
            self.erased[sector] += 1;
            self.bytes[range.clone()].fill(0xff);
            self.unreadable.retain(|at| !range.contains(at));
        }
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), NorFlashErrorKind> {
        check_write(self, offset, bytes.len())?;
        if self.dead {
            return Err(NorFlashErrorKind::Other);
        }
        for (at, byte) in (offset as usize..).zip(bytes) {
            if self.goes_out() {
                // Half of the bits of this byte.
                self.bytes[at] &= byte | 0xa5;
                if ECC {
                    self.unreadable.insert(at - at % UNIT);
                }
                return Err(NorFlashErrorKind::Other);
            }
            // A cell is cleared, never set, but by erasing.
            assert_eq!(self.bytes[at], 0xff, "{at} is written twice");
            self.bytes[at] &= byte;
            if self.worn.contains(&at) {
                self.bytes[at] |= 0x10;
            }
            self.written += 1;
        }
        Ok(())
    }
}

/// As an STM32F405 has it, with smaller sectors, and as an STM32H743.
type Words = Memory<4, 4096, false>;
type WideWords = Memory<32, 4096, true>;

const IDLE: [f32; 5] = [420.0, 0.0, 0.0, 0.0, 0.0];

/// What an idling spindle of this stiffness looks like to the one who judges it, without any limit near.
pub(super) fn idling(speed: f32, stiffness: [f32; 5]) -> Findings {
    let quiet = Level::of(0.0);
    Findings {
        pressure: quiet,
        contact_angle: quiet,
        slip: quiet,
        unloaded: quiet,
        load: IDLE,
        speed,
        stiffness,
    }
}

/// One power cycle of a board.
struct Board<F> {
    store: Store<F>,
    found: Past,
    judgement: Judgement,
    life: Life,
    time_us: u64,
}

impl<F: NorFlash> Board<F> {
    fn start(flash: F) -> Self {
        let (store, found) = Store::open(flash, IDENTITY);
        Self {
            store,
            found,
            judgement: Judgement::new(found.baseline),
            life: Life::resume(found.life.0, found.life.1),
            time_us: 0,
        }
    }

    /// Learns the spindle with a stiffness of `k`, as that of another bearing.
    fn learn(&mut self, k: f32) {
        self.judgement.forget_baseline();
        self.judgement.start_learning();
        for i in 0..200 * BANDS {
            let findings = idling(
                (i % BANDS) as f32 * 150.0,
                [k, 1.1 * k, 1.2 * k, 0.01 * k + i as f32, 0.02 * k],
            );
            let changes = &mut Changes::new();
            self.judgement
                .judge(self.time_us, &findings, &SETTINGS.judgement, changes);
        }
        let ended = self.judgement.stop_learning(&SETTINGS.judgement);
        assert_eq!(ended, Learning::Taken);
    }

    /// The shaft turns for so long, a look at every second.
    fn turn(&mut self, seconds: u32) {
        for _ in 0..seconds {
            self.life.set_damage(1e-3);
            self.life.turn(1000.0, 1.0, false);
            self.stand(1);
        }
    }

    /// It stands still for so long.
    fn stand(&mut self, seconds: u32) {
        for _ in 0..seconds {
            self.time_us += 1_000_000;
            self.store.look(self.time_us, &self.judgement, &self.life);
            self.write();
        }
    }

    fn write(&mut self) {
        let mut steps = 0;
        while self.store.step() {
            steps += 1;
            assert!(steps < 10_000);
        }
    }

    fn now(&self) -> Past {
        Past {
            baseline: *self.judgement.baseline(),
            life: self.life.kept(),
        }
    }

    fn off(self) -> F {
        self.store.into_flash()
    }

    fn report(&self) -> RetentionReport {
        self.store.report()
    }
}

/// A flash that has seen a baseline and an hour of turning.
fn used<F: NorFlash>(flash: F) -> (F, Past) {
    let mut board = Board::start(flash);
    board.learn(1e8);
    board.turn(3700);
    board.stand(700);
    let past = board.now();
    assert_eq!(board.report().failed, 0);
    (board.off(), past)
}

#[test]
fn what_was_kept_is_there_after_any_number_of_starts() {
    fn holds<F: NorFlash>(flash: F) {
        let first = Board::start(flash);
        assert_eq!(first.found, Past::NONE);
        let blank = RetentionReport {
            baseline: Recovery::Blank,
            life: Recovery::Blank,
            ..RetentionReport::NO_MEMORY
        };
        assert_eq!(first.report(), blank);
        let (mut flash, past) = used(first.off());
        let recovered = RetentionReport {
            baseline: Recovery::Recovered,
            life: Recovery::Recovered,
            ..RetentionReport::NO_MEMORY
        };
        for _ in 0..3 {
            let board = Board::start(flash);
            assert_eq!((board.found, board.report()), (past, recovered));
            flash = board.off();
        }
    }
    holds(Words::new(2));
    holds(WideWords::new(2));
    holds(Memory::<1, 2048, false>::new(5));
    holds(Memory::<64, 8192, true>::new(2));
}

#[test]
fn life_is_written_once_an_hour_and_at_a_standstill_after_ten_minutes() {
    let mut board = Board::start(Words::new(2));
    board.turn((LIFE_US / 1_000_000) as u32 - 1);
    assert_eq!(board.report().written, 0);
    board.turn(1);
    // A new sector begins with both.
    assert_eq!(board.report().written, 2);
    board.stand(20_000);
    assert_eq!(board.report().written, 2);
    board.turn(60);
    assert_eq!(board.report().written, 3);
    board.turn((STANDSTILL_LIFE_US / 1_000_000) as u32);
    assert_eq!(board.report().written, 3);
    board.stand(9);
    assert_eq!(board.report().written, 3);
    board.stand(1);
    assert_eq!(board.report().written, 4);
    let past = board.now();
    assert_eq!(Board::start(board.off()).found, past);
}

#[test]
fn a_baseline_is_written_when_learning_ends_and_not_while_it_lasts() {
    let (flash, past) = used(Words::new(2));
    let mut board = Board::start(flash);
    board.judgement.start_learning();
    board.stand(100);
    assert_eq!(board.report().written, 0);
    let flash = board.off();
    let mut board = Board::start(flash);
    assert_eq!(board.found, past);
    board.learn(0.7e8);
    board.stand(1);
    let newer = board.now();
    assert_ne!(newer.baseline, past.baseline);
    let mut board = Board::start(board.off());
    assert_eq!(board.found, newer);
    // A new bearing.
    board.judgement.forget_baseline();
    board.life = Life::NEW;
    board.stand(1);
    assert_eq!(Board::start(board.off()).found, Past::NONE);
}

// --- power lost --------------------------------------------------------------------------------

/// Power goes at every byte that is written, and again at every byte of the next start.
fn survives_power_loss<const UNIT: usize, const SECTOR: usize, const ECC: bool>(
    flash: &Memory<UNIT, SECTOR, ECC>,
    old: Past,
) {
    let run = |flash: Memory<UNIT, SECTOR, ECC>| {
        let mut board = Board::start(flash);
        let found = board.found;
        board.learn(2e8);
        board.life.turn(1000.0, 1.0, false);
        board.stand(1);
        (found, board.now(), board.off())
    };
    let (found, new, whole) = run(flash.clone());
    assert_eq!(found, old);
    let bytes = (whole.written - flash.written + whole.erased.iter().sum::<u64>()
        - flash.erased.iter().sum::<u64>()) as usize;
    assert!(bytes > 380, "{bytes}");
    let (mut with_old, mut with_new) = (0, 0);
    for power in 0..=bytes {
        let (_, _, cut) = run(flash.clone().powered(Some(power)));
        for again in [None, Some(0), Some(1), Some(7), Some(40), Some(200)] {
            let mut cut = cut.clone();
            if again.is_some() {
                // The power goes once more, at the start that follows.
                let board = Board::start(cut.powered(again));
                cut = board.off();
            }
            let board = Board::start(cut.powered(None));
            let Past { baseline, life } = board.found;
            assert!(
                baseline == old.baseline || baseline == new.baseline,
                "{power}, {again:?}"
            );
            assert!(life == old.life || life == new.life, "{power}, {again:?}");
            // The baseline is written first.
            assert!(life == old.life || baseline == new.baseline);
            let report = board.report();
            if old != Past::NONE {
                assert_eq!(report.baseline, Recovery::Recovered, "{power}, {again:?}");
                assert_eq!(report.life, Recovery::Recovered);
            }
            assert_eq!(report.failed, 0, "{power}, {again:?}");
            with_old += usize::from(board.found == old);
            with_new += usize::from(board.found == new);
            // And it goes on.
            let (_, newer, after) = run(board.off());
            assert_eq!(Board::start(after).found, newer, "{power}, {again:?}");
        }
    }
    assert!(with_old > 300 && with_new >= 6, "{with_old}, {with_new}");
}

#[test]
fn power_lost_at_any_byte_leaves_the_last_good_record() {
    let (flash, past) = used(Words::new(2));
    survives_power_loss(&flash, past);
    let (flash, past) = used(WideWords::new(2));
    survives_power_loss(&flash, past);
    let (flash, past) = used(Memory::<1, 4096, false>::new(3));
    survives_power_loss(&flash, past);
    survives_power_loss(&WideWords::new(2), Past::NONE);
}

/// So full that the records go to the next sector, with and without that one to be erased first.
#[test]
fn power_lost_at_any_byte_of_a_change_of_sectors_leaves_the_last_good_record() {
    fn full<const UNIT: usize, const ECC: bool>(turns: u32) {
        let (mut flash, _) = used(Memory::<UNIT, 2048, ECC>::new(2));
        let mut change = None;
        for _ in 0..turns {
            let mut board = Board::start(flash);
            board.turn(30);
            board.stand(700);
            let past = board.now();
            flash = board.off();
            // The first sector ends with fewer bytes than a baseline takes.
            let rest = |sector: usize| {
                let bytes = &flash.bytes[sector * 2048..(sector + 1) * 2048];
                bytes.iter().rev().take_while(|byte| **byte == 0xff).count()
            };
            if [rest(0), rest(1)]
                .iter()
                .any(|rest| (1..416).contains(rest))
            {
                change = Some(past);
                survives_power_loss(&flash, past);
            }
        }
        assert!(change.is_some());
    }
    full::<4, false>(30);
    full::<32, true>(24);
}

// --- any content -------------------------------------------------------------------------------

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(256) })]

    #[test]
    fn any_content_ends_in_a_record_or_a_named_refusal_and_can_be_written_over(
        pieces in prop::collection::vec(
            (any::<prop::sample::Index>(), prop::collection::vec(any::<u8>(), 1..600)), 1..6),
        unreadable in prop::collection::vec(any::<prop::sample::Index>(), 0..6),
        on_top in any::<bool>(),
    ) {
        let (mut flash, past) = if on_top {
            used(WideWords::new(2))
        } else {
            (WideWords::new(2), Past::NONE)
        };
        for (at, piece) in &pieces {
            let at = at.index(flash.bytes.len());
            for (to, from) in flash.bytes[at..].iter_mut().zip(piece) {
                *to = *from;
            }
        }
        for at in unreadable {
            flash.unreadable.insert(at.index(flash.bytes.len() / 32) * 32);
        }
        let mut board = Board::start(flash);
        let report = board.report();
        prop_assert!(report.failed == 0);
        for (recovery, same) in [
            (report.baseline, board.found.baseline == past.baseline),
            (report.life, board.found.life == past.life),
        ] {
            match recovery {
                // The one before it, if the newest was hit.
                Recovery::Recovered => prop_assert!(on_top && (same || report.damaged > 0)),
                Recovery::Damaged => prop_assert!(report.damaged > 0),
                Recovery::Blank | Recovery::OtherVersion => {}
                Recovery::NoMemory | Recovery::OtherSpindle => prop_assert!(false),
            }
        }
        board.learn(3e8);
        board.turn(3601);
        let past = Past { life: Board::start(board.store.into_flash()).found.life,
            baseline: *board.judgement.baseline() };
        prop_assert_eq!(past.life, board.life.kept());
    }

    #[test]
    fn a_changed_byte_never_passes_for_another_record(
        at in any::<prop::sample::Index>(), change in 1..=u8::MAX,
    ) {
        let (mut flash, past) = used(Words::new(2));
        let used = flash.bytes.iter().rposition(|byte| *byte != 0xff).unwrap();
        flash.bytes[at.index(used)] ^= change;
        let board = Board::start(flash);
        for (recovery, found) in [
            (board.report().baseline, board.found.baseline == past.baseline),
            (board.report().life, board.found.life == past.life),
        ] {
            // A record before it may be the one that counts then.
            let older = board.report().damaged > 0;
            prop_assert!(found || older || recovery != Recovery::Recovered);
        }
    }
}

#[test]
fn another_spindles_past_is_refused_by_name() {
    let (flash, past) = used(Words::new(2));
    let recovery = |design: &Design, balls, bands: &BaselineSettings| {
        let identity = Identity::new(design, balls, bands);
        let (store, found) = Store::open(flash.clone(), identity);
        let report = store.report();
        assert_eq!(report.life == Recovery::Recovered, found.life == past.life);
        let none = found.baseline == Baseline::EMPTY;
        assert_eq!(report.baseline != Recovery::Recovered, none);
        (report.baseline, report.life)
    };
    use Recovery::{OtherSpindle, Recovered};
    assert_eq!(recovery(&DESIGN, 16, &BOUNDS), (Recovered, Recovered));
    assert_eq!(recovery(&DESIGN, 17, &BOUNDS), (OtherSpindle, OtherSpindle));
    let mut hybrid = DESIGN;
    hybrid.ball = Material::SILICON_NITRIDE;
    assert_eq!(recovery(&hybrid, 16, &BOUNDS), (OtherSpindle, OtherSpindle));
    let mut clearance = DESIGN;
    clearance.free_contact = FreeContact::DiametralClearance(15.0 * std::f64::consts::PI / 180.0);
    assert_eq!(
        recovery(&clearance, 16, &BOUNDS),
        (OtherSpindle, OtherSpindle)
    );
    // Shoulders have no part in the stiffness.
    let mut shoulders = DESIGN;
    shoulders.inner_shoulder_angle = 0.8;
    assert_eq!(recovery(&shoulders, 16, &BOUNDS), (Recovered, Recovered));
    // Other bands are another baseline, but the same bearing.
    for change in [
        |b: &mut BaselineSettings| b.band_width *= 1.01,
        |b: &mut BaselineSettings| b.idle_axial[0] -= 1.0,
        |b: &mut BaselineSettings| b.idle_radial += 1.0,
        |b: &mut BaselineSettings| b.idle_moment += 0.1,
    ] {
        let mut bands = BOUNDS;
        change(&mut bands);
        assert_eq!(recovery(&DESIGN, 16, &bands), (OtherSpindle, Recovered));
    }
    let mut estimates = BOUNDS;
    estimates.least_estimates += 1;
    assert_eq!(recovery(&DESIGN, 16, &estimates), (Recovered, Recovered));
}

// --- wear --------------------------------------------------------------------------------------

/// Ten years of a spindle that never rests for long, with a power cycle a week, in two sectors of 128 KiB.
#[test]
fn ten_years_take_a_hundredth_of_the_erases_that_flash_endures() {
    fn ten_years<const UNIT: usize, const ECC: bool>(most: u64) {
        let mut flash = Memory::<UNIT, { 128 * 1024 }, ECC>::new(2);
        let mut life = (0, 0);
        for _ in 0..520 {
            let mut board = Board::start(flash);
            assert_eq!(board.found.life, life);
            board.life.set_damage(1e-3);
            for _ in 0..7 * 24 * 6 {
                board.life.turn(1000.0, 580.0, false);
                // One look sees the turn, one the standstill.
                for pause in [1, 10, 590] {
                    board.time_us += pause * 1_000_000;
                    board
                        .store
                        .look(board.time_us, &board.judgement, &board.life);
                }
                board.write();
            }
            life = board.life.kept();
            assert_eq!(board.report().failed, 0);
            assert!((1008..=1010).contains(&board.report().written));
            flash = board.off();
        }
        assert!(
            flash.erased.iter().all(|times| (1..=most).contains(times)),
            "{:?}",
            flash.erased
        );
        assert!(flash.erased[0].abs_diff(flash.erased[1]) <= 1);
    }
    ten_years::<4, false>(100);
    ten_years::<32, true>(130);
}

/// The other bound: no restart, so that nothing is erased.
#[test]
fn a_sector_lasts_nine_months_of_cutting_and_then_says_that_it_is_full() {
    fn hours<const UNIT: usize, const ECC: bool>() -> u64 {
        // In the worst case the one sector that is blank at the start is all there is.
        let mut board = Board::start(Memory::<UNIT, { 128 * 1024 }, ECC>::new(1));
        let mut hours = 0;
        while board.report().failed == 0 {
            assert!(hours < 100_000);
            hours += 1;
            board.life.set_damage(1e-3);
            board.life.turn(1000.0, 3600.0, false);
            board.time_us += LIFE_US;
            board
                .store
                .look(board.time_us, &board.judgement, &board.life);
            board.write();
        }
        assert_eq!(board.store.error(), Some(WriteError::Full));
        // What was written is still there, and a restart makes room.
        let life = board.life.kept();
        let board = Board::start(board.off());
        let lost = (life.1 - board.found.life.1) >> 64;
        let an_hour = (1000.0 * 3600.0 / std::f64::consts::TAU) as u128;
        assert!(board.report().life == Recovery::Recovered && lost <= 33 * an_hour);
        hours
    }
    for hours in [hours::<4, false>(), hours::<32, true>()] {
        let days = hours / 24;
        assert!((270..500).contains(&days), "{days}");
    }
}

#[test]
fn worn_cells_are_left_behind_and_a_flash_that_takes_nothing_is_told_of() {
    let (mut flash, past) = used(Words::new(2));
    let end = flash.bytes.iter().rposition(|byte| *byte != 0xff).unwrap();
    // Two attempts meet one of them.
    flash.worn = [end + 30, end + 60].into();
    let mut board = Board::start(flash);
    board.learn(2e8);
    board.stand(1);
    assert_eq!((board.report().written, board.report().failed), (2, 0));
    let newer = board.now();
    assert_ne!(newer, past);
    let board = Board::start(board.off());
    assert_eq!(
        (board.found, board.report().life),
        (newer, Recovery::Recovered)
    );
    assert_eq!(board.report().baseline, Recovery::Recovered);

    let mut flash = board.off();
    flash.worn = (0..flash.bytes.len()).collect();
    let mut board = Board::start(flash);
    board.learn(3e8);
    board.stand(1);
    let report = board.report();
    assert_eq!((report.written, report.failed), (0, 2));
    assert_eq!(board.store.error(), Some(WriteError::Flash));
    let mut flash = board.off();
    flash.worn.clear();
    let mut board = Board::start(flash);
    assert_eq!(board.found, newer);
    // The rest of the sector is no more than that.
    assert!(board.report().damaged <= 2 * u16::from(ATTEMPTS));
    board.learn(4e8);
    board.stand(1);
    let newest = board.now();
    assert_eq!(Board::start(board.off()).found, newest);
}

/// What cannot be erased is told of, and there is still the rest of the sector.
#[test]
fn a_flash_that_does_not_erase_is_told_of() {
    let mut flash = Words::new(2);
    flash.bytes[5000] = 0;
    flash.refuses_to_erase = true;
    let mut board = Board::start(flash);
    assert_eq!((board.report().failed, board.report().damaged), (1, 2));
    assert_eq!(board.report().life, Recovery::Damaged);
    board.learn(1e8);
    board.stand(1);
    let past = board.now();
    let board = Board::start(board.off());
    assert_eq!(board.found, past);
}

// --- the monitor -------------------------------------------------------------------------------

/// Idling and cutting in turns.
fn readings(time_us: u64) -> Readings {
    let step = time_us / 1000;
    let cut = if step % 2000 < 1000 { 0.0 } else { 60.0 };
    Readings {
        loads: Ok(Some(LoadSample {
            time_us,
            load: [420.0, cut, -8.0, 0.05, -0.1].map(|load| load + 1e-3 * (step % 7) as f32),
            speed: Some(1500.0 + (step % 11) as f32),
            residual: 0.0,
            doubts: Marks::NONE,
        })),
        speed: None,
    }
}

/// A monitor that was switched off goes on as one that was not: the same baseline, so the same ratios to the
/// bit, and the same life.
#[test]
fn a_monitor_goes_on_after_a_power_cycle_with_the_same_judgement() {
    let (store, past) = Store::open(WideWords::new(2), IDENTITY);
    let mut store = store;
    let mut monitor: Monitor<16> = Monitor::new(&BEARING, &SETTINGS).with_past(&past);
    monitor.prepare(IDLE, 0.0).unwrap();
    let tick = |monitor: &mut Monitor<16>, store: &mut Store<_>, time_us: u64| {
        let outcome = monitor.tick(time_us, &readings(time_us), &mut NoCycles, &mut NoWatchdog);
        monitor.retain(time_us, store);
        // One unit a tick, as between the ticks of a board.
        store.step();
        while monitor.outbox().next_byte().is_some() {}
        outcome
    };
    monitor.learn(true);
    for ms in 0..3000 {
        tick(&mut monitor, &mut store, ms * 1000);
    }
    monitor.learn(false);
    for ms in 3000..6000 {
        tick(&mut monitor, &mut store, ms * 1000);
    }
    let report = monitor.health().retention;
    assert_eq!((report.written, report.failed), (2, 0));
    let baseline = *monitor.judgement().baseline();
    assert!(
        baseline.estimates.iter().any(|count| *count > 1000),
        "{:?}",
        baseline.estimates
    );

    let (mut store, past) = Store::open(store.into_flash(), IDENTITY);
    assert_eq!(past.baseline, baseline);
    let mut other: Monitor<16> = Monitor::new(&BEARING, &SETTINGS).with_past(&past);
    assert_eq!(other.life().kept(), past.life);
    assert!(past.life.1 > 0 && past.life <= monitor.life().kept());
    let bounds = &SETTINGS.judgement.baseline;
    for (load, speed, k) in [(IDLE, 1500.0, 1.1e8), (IDLE, 1505.5, 0.3e8)] {
        let stiffness = [k, 1.1 * k, 0.9 * k, 1e4, 2e4];
        let ratio = |of: &Baseline| of.ratio(bounds, &load, speed, &stiffness).unwrap();
        let after = ratio(other.judgement().baseline()).map(f32::to_bits);
        assert_eq!(ratio(&baseline).map(f32::to_bits), after);
    }
    // The very life that was kept, and from there on as the one that was not switched off.
    let lived = |monitor: &Monitor<16>, from: (u128, u128)| {
        let now = monitor.life().kept();
        (now.0 - from.0, now.1 - from.1)
    };
    other.prepare(IDLE, 0.0).unwrap();
    let mut without: Monitor<16> = Monitor::new(&BEARING, &SETTINGS);
    without.prepare(IDLE, 0.0).unwrap();
    let mut losses = 0;
    for ms in 0..3000 {
        let outcome = tick(&mut other, &mut store, ms * 1000);
        without.tick(
            ms * 1000,
            &readings(ms * 1000),
            &mut NoCycles,
            &mut NoWatchdog,
        );
        losses += outcome
            .changes
            .iter()
            .filter(|c| c.alarm == Alarm::StiffnessLoss)
            .count();
    }
    assert_eq!(lived(&other, past.life), lived(&without, (0, 0)));
    assert_eq!(losses, 0);
    assert_eq!(other.health().retention.baseline, Recovery::Recovered);
    assert!(!other.replace_bearing(3_000_000));
    let mut standing = readings(9_999_000);
    if let Ok(Some(sample)) = &mut standing.loads {
        sample.speed = Some(0.0);
    }
    other.tick(9_999_000, &standing, &mut NoCycles, &mut NoWatchdog);
    // A standstill of long ago is none.
    assert!(!other.replace_bearing(10_100_000));
    assert!(other.replace_bearing(9_999_000));
    tick(&mut other, &mut store, 10_000_000);
    while store.step() {}
    let (_, past) = Store::open(store.into_flash(), IDENTITY);
    // A tick after the replacement has turned a little.
    assert_eq!(past.baseline, Baseline::EMPTY);
    assert!(past.life.1 >> 64 <= 250, "{}", past.life.1 >> 64);
}

#[test]
fn without_a_memory_the_monitor_says_so() {
    let monitor: Monitor<16> = Monitor::new(&BEARING, &SETTINGS);
    assert_eq!(monitor.health().retention, RetentionReport::NO_MEMORY);
    let (mut store, past) = Store::open(Words::new(0), IDENTITY);
    assert_eq!(
        (past, store.report()),
        (Past::NONE, RetentionReport::NO_MEMORY)
    );
    assert!(!store.step());
}

// --- the boards' flash -------------------------------------------------------------------------

#[path = "../../../examples/board/flash.rs"]
mod flash;

/// Cells that write down what is asked of them.
#[derive(Default)]
struct Asked {
    said: Vec<String>,
    /// Calls that go well.
    good: usize,
}

impl Asked {
    fn say(&mut self, what: String) -> bool {
        self.said.push(what);
        self.said.len() <= self.good
    }
}

impl flash::Cells for Asked {
    const UNIT: usize = 32;

    fn read(&mut self, at: u32, unit: &mut [u8]) -> bool {
        unit.fill(at.to_le_bytes()[0]);
        self.say(format!("read {at} {}", unit.len()))
    }

    fn program(&mut self, at: u32, unit: &[u8]) -> bool {
        self.say(format!("program {at} {} of {}", unit.len(), unit[0]))
    }

    fn erase(&mut self, sector: u32) -> bool {
        self.say(format!("erase {sector}"))
    }
}

#[test]
fn the_boards_flash_goes_unit_by_unit_and_stays_within_its_sectors() {
    use NorFlashErrorKind::{NotAligned, Other, OutOfBounds};
    const END: u32 = flash::SECTORS * flash::SECTOR;
    let asked = |good| {
        flash::Flash(Asked {
            good,
            ..Asked::default()
        })
    };
    let mut flash = asked(9);
    let mut bytes = [0; 64];
    assert_eq!(flash.read(END - 64, &mut bytes), Ok(()));
    assert_eq!((bytes[0], bytes[63]), (192, 224));
    assert_eq!(flash.write(32, &bytes), Ok(()));
    assert_eq!(flash.erase(flash::SECTOR, END), Ok(()));
    assert_eq!(flash.erase(0, END), Ok(()));
    // Nothing of these gets through.
    assert_eq!(flash.read(END - 32, &mut bytes), Err(OutOfBounds));
    assert_eq!(flash.write(END, &bytes), Err(OutOfBounds));
    assert_eq!(flash.erase(0, END + flash::SECTOR), Err(OutOfBounds));
    assert_eq!(flash.read(4, &mut bytes), Err(NotAligned));
    assert_eq!(flash.write(32, &bytes[1..]), Err(NotAligned));
    assert_eq!(flash.erase(0, 4096), Err(NotAligned));
    let expected = [
        "read 262080 32",
        "read 262112 32",
        "program 32 32 of 192",
        "program 64 32 of 224",
        "erase 1",
        "erase 0",
        "erase 1",
    ];
    assert_eq!(flash.0.said, expected);
    // What fails ends it.
    let mut flash = asked(1);
    assert_eq!(flash.write(0, &bytes), Err(Other));
    assert_eq!(flash.erase(0, END), Err(Other));
    assert_eq!(flash.read(0, &mut bytes), Err(Other));
    assert_eq!(flash.0.said.len(), 4);
}

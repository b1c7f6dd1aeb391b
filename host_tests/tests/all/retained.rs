//! What the monitor has learnt is kept without power: the log of `monitor::retained` on a flash in memory that
//! forgets its manners as real ones do.

use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashErrorKind, ReadNorFlash, check_erase, check_read, check_write,
};
use proptest::prelude::*;
use spindle_bearing::framing;
use spindle_bearing::monitor::baseline::{BANDS, Baseline, BaselineSettings};
use spindle_bearing::monitor::board::ResetCause;
use spindle_bearing::monitor::judgement::{Alarm, AlarmState, Changes, Findings, Level};
use spindle_bearing::monitor::learning::Learning;
use spindle_bearing::monitor::loads::LoadSample;
use spindle_bearing::monitor::retained::{
    FOREIGN, Identity, LIFE_US, LONGEST_FOREIGN, Past, Store, VERSION, WriteError,
};
use spindle_bearing::monitor::settings::MonitorSettings;
use spindle_bearing::monitor::telemetry::{FrameReader, Payload, Recovery, RetentionReport};
use spindle_bearing::monitor::tick::{NoCycles, NoWatchdog};
use spindle_bearing::monitor::{Judgement, Life, Marks, Monitor, Readings};
use spindle_bearing::{Bearing, Design, FreeContact, Material, Spindle};
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
const BOUNDS: BaselineSettings = MonitorSettings::<1>::new(&DESIGN, 16).judgement.baseline;

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
        preload: None,
        load: IDLE,
        speed,
        stiffness,
    }
}

/// Baseline and life.
type Learnt = (Baseline, (u128, u128));
const NOTHING: Learnt = (Baseline::EMPTY, (0, 0));

/// The same spindle with balls of ceramic.
const OTHER: Identity = {
    let mut design = DESIGN;
    design.ball = Material::SILICON_NITRIDE;
    Identity::new(&design, 16, &BOUNDS)
};

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
        Self::start_as(flash, IDENTITY)
    }

    fn start_as(flash: F, identity: Identity) -> Self {
        let (store, found) = Store::open(flash, identity, ResetCause::PowerOn);
        let mut judgement = Judgement::new(found.baseline);
        judgement.latch(found.start.alarms);
        Self {
            store,
            found,
            judgement,
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

    /// A level that raises an alarm at once.
    fn raise(&mut self, alarm: Alarm) {
        let level = Level::of(f32::INFINITY);
        let changes = &mut Changes::new();
        self.judgement
            .level(self.time_us, alarm, level, &SETTINGS.judgement, changes);
        assert_eq!(self.judgement.alarm(alarm).state(), AlarmState::Raised);
    }

    /// The shaft turns for so long, a look at every second.
    fn turn(&mut self, seconds: u64) {
        for _ in 0..seconds {
            self.life.set_damage(1e-3);
            self.life.turn(1000.0, 1.0, false);
            self.stand(1);
        }
    }

    /// It stands still for so long.
    fn stand(&mut self, seconds: u64) {
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

    fn now(&self) -> Learnt {
        (*self.judgement.baseline(), self.life.kept())
    }

    fn found(&self) -> Learnt {
        (self.found.baseline, self.found.life)
    }

    /// What became of baseline, life and alarms.
    fn recovery(&self) -> [Recovery; 3] {
        let report = self.report();
        [report.baseline, report.life, self.found.alarms]
    }

    fn off(self) -> F {
        self.store.into_flash()
    }

    fn report(&self) -> RetentionReport {
        self.store.report()
    }
}

const RECOVERED: [Recovery; 3] = [Recovery::Recovered; 3];

/// A flash that has seen a baseline and an hour of turning.
fn used<F: NorFlash>(flash: F) -> (F, Learnt) {
    used_as(flash, IDENTITY, 1e8)
}

fn used_as<F: NorFlash>(flash: F, identity: Identity, k: f32) -> (F, Learnt) {
    let mut board = Board::start_as(flash, identity);
    board.learn(k);
    board.turn(3600);
    board.stand(120);
    let learnt = board.now();
    assert_eq!(board.report().failed, 0);
    (board.off(), learnt)
}

/// Less than an hour: a few records only.
fn just_used<F: NorFlash>(flash: F) -> (F, Learnt) {
    let mut board = Board::start(flash);
    board.learn(1e8);
    board.turn(300);
    board.stand(120);
    (
        board.store.into_flash(),
        (*board.judgement.baseline(), board.life.kept()),
    )
}

#[test]
fn what_was_kept_is_there_after_any_number_of_starts() {
    fn holds<F: NorFlash>(flash: F) {
        let mut first = Board::start(flash);
        assert_eq!(first.found(), NOTHING);
        let blank = RetentionReport {
            baseline: Recovery::Blank,
            life: Recovery::Blank,
            ..RetentionReport::NO_MEMORY
        };
        assert_eq!(first.report(), blank);
        assert_eq!(first.recovery(), [Recovery::Blank; 3]);
        first.write();
        let (mut flash, learnt) = used(first.off());
        let recovered = RetentionReport {
            baseline: Recovery::Recovered,
            life: Recovery::Recovered,
            ..RetentionReport::NO_MEMORY
        };
        for boots in 3..6 {
            let mut board = Board::start(flash);
            assert_eq!((board.found(), board.report()), (learnt, recovered));
            assert_eq!(board.recovery(), RECOVERED);
            assert_eq!(board.found.start.boots, boots);
            board.write();
            assert_eq!((board.report().written, board.report().failed), (1, 0));
            flash = board.off();
        }
    }
    holds(Words::new(2));
    holds(WideWords::new(2));
    holds(Memory::<1, 4096, false>::new(5));
    holds(Memory::<64, 8192, true>::new(3));
    // One sector has both copies.
    holds(Memory::<4, 16384, false>::new(1));
}

#[test]
fn life_is_written_every_two_minutes_and_then_in_proportion() {
    let mut board = Board::start(Memory::<4, 65536, false>::new(2));
    board.write();
    assert_eq!(board.report().written, 1);
    board.turn(LIFE_US / 1_000_000 - 1);
    assert_eq!(board.report().written, 1);
    board.turn(1);
    assert_eq!(board.report().written, 2);
    // Nothing new.
    board.stand(20_000);
    assert_eq!(board.report().written, 2);
    // Two seconds after a long rest is worth a record.
    board.turn(2);
    assert_eq!(board.report().written, 3);
    board.stand(118);
    assert_eq!(board.report().written, 3);
    let mut written = Vec::new();
    for _ in 0..5 {
        let before = board.report().written;
        board.turn(7200);
        written.push(board.report().written - before);
    }
    assert_eq!(board.report().failed, 0);
    // 64 ln(4/2), 64 ln(6/4) and so on.
    let expected = [60, 44, 25, 18, 14];
    for (written, expected) in written.iter().zip(expected) {
        assert!(written.abs_diff(expected) <= 2, "{written:?}");
    }
    let lived = board.life.kept();
    let Board { found, .. } = Board::start(board.off());
    let lost = (lived.1 - found.life.1) as f64 / lived.1 as f64;
    assert!(lost < 1.0 / 64.0, "{lost}");
}

/// A crash of a minute after a week of idling: few revolutions, much life.
#[test]
fn life_that_is_used_fast_is_written_as_soon_as_revolutions() {
    let mut board = Board::start(Memory::<4, 65536, false>::new(2));
    board.life.set_damage(1e-6);
    for _ in 0..7 * 24 * 60 {
        board.life.turn(1000.0, 60.0, false);
        board.stand(60);
    }
    board.life.set_damage(10.0);
    board.life.turn(1000.0, 60.0, false);
    board.stand(60);
    board.life.turn(1000.0, 60.0, false);
    board.stand(60);
    let used = board.life.kept().0;
    let Board { found, .. } = Board::start(board.off());
    assert!(used - found.life.0 <= used / 2 + used / 64);
}

#[test]
fn a_baseline_is_written_when_learning_ends_and_not_while_it_lasts() {
    let (flash, learnt) = used(Words::new(2));
    let mut board = Board::start(flash);
    board.judgement.start_learning();
    board.stand(100);
    assert_eq!(board.report().written, 1);
    let flash = board.off();
    let mut board = Board::start(flash);
    assert_eq!(board.found(), learnt);
    board.learn(0.7e8);
    board.stand(1);
    let newer = board.now();
    assert_ne!(newer.0, learnt.0);
    let mut board = Board::start(board.off());
    assert_eq!(board.found(), newer);
    // A new bearing.
    board.judgement.forget_baseline();
    board.life = Life::NEW;
    board.stand(1);
    assert_eq!(Board::start(board.off()).found(), NOTHING);
}

// --- power lost --------------------------------------------------------------------------------

#[test]
fn a_power_cut_every_nine_minutes_or_more_leaves_three_quarters_of_the_life() {
    for minutes in [9, 10, 17, 31, 45, 59] {
        let mut flash = WideWords::new(2);
        let mut lived = Life::NEW;
        for _ in 0..20 {
            let mut board = Board::start(flash);
            let before = board.life.kept();
            board.turn(minutes * 60);
            let after = board.life.kept();
            assert_eq!(board.report().failed, 0);
            lived.turn(1000.0, minutes as f32 * 60.0, false);
            assert!(after > before);
            flash = board.off();
        }
        let kept = Board::start(flash).found.life.1 as f64 / lived.kept().1 as f64;
        assert!(kept > 0.88, "{minutes} min: {kept}");
    }
}

/// Power goes at every byte that is written, and again at every few bytes of the next start. Another spindle's records
/// in the same flash, if there are any, are as they were.
fn survives_power_loss<const UNIT: usize, const SECTOR: usize, const ECC: bool>(
    flash: &Memory<UNIT, SECTOR, ECC>,
    old: Learnt,
    other: Option<Learnt>,
    agains: &[Option<usize>],
) {
    let run = |flash: Memory<UNIT, SECTOR, ECC>| {
        let mut board = Board::start(flash);
        let found = board.found();
        board.learn(2e8);
        board.life.turn(1000.0, 1.0, false);
        board.stand(1);
        (found, board.now(), board.off())
    };
    let (found, new, whole) = run(flash.clone());
    assert_eq!(found, old);
    let bytes = (whole.written - flash.written + whole.erased.iter().sum::<u64>()
        - flash.erased.iter().sum::<u64>()) as usize;
    assert!(bytes > 760, "{bytes}");
    let (mut with_old, mut with_new) = (0, 0);
    for power in 0..=bytes {
        let (_, _, cut) = run(flash.clone().powered(Some(power)));
        for again in agains.iter().copied() {
            let mut cut = cut.clone();
            if again.is_some() {
                // The power goes once more, at the start that follows.
                let mut board = Board::start(cut.powered(again));
                board.write();
                cut = board.off();
            }
            let cut = cut.powered(None);
            if let Some(other) = other {
                let board = Board::start_as(cut.clone(), OTHER);
                assert_eq!(board.found(), other, "{power}, {again:?}");
                assert_eq!(board.recovery(), RECOVERED, "{power}, {again:?}");
            }
            let board = Board::start(cut);
            let (baseline, life) = board.found();
            assert!(baseline == old.0 || baseline == new.0, "{power}, {again:?}");
            assert!(life == old.1 || life == new.1, "{power}, {again:?}");
            // The baseline is written first.
            assert!(life == old.1 || baseline == new.0);
            if old != NOTHING {
                assert_eq!(board.recovery(), RECOVERED, "{power}, {again:?}");
            }
            assert_eq!(board.report().failed, 0, "{power}, {again:?}");
            with_old += usize::from(board.found() == old);
            with_new += usize::from(board.found() == new);
            // And it goes on.
            if power % 16 == 0 {
                let (_, newer, after) = run(board.off());
                assert_eq!(Board::start(after).found(), newer, "{power}, {again:?}");
            }
        }
    }
    assert!(with_old > 300 && with_new >= 6, "{with_old}, {with_new}");
}

/// When the power goes once more.
const AGAINS: &[Option<usize>] = &[None, Some(0), Some(7), Some(40), Some(150)];

#[test]
fn power_lost_at_any_byte_leaves_the_last_good_record() {
    let (flash, learnt) = just_used(Words::new(2));
    survives_power_loss(&flash, learnt, None, AGAINS);
    let (flash, learnt) = just_used(WideWords::new(2));
    survives_power_loss(&flash, learnt, None, AGAINS);
    let (flash, learnt) = just_used(Memory::<1, 4096, false>::new(3));
    survives_power_loss(&flash, learnt, None, AGAINS);
    survives_power_loss(&WideWords::new(2), NOTHING, None, AGAINS);
}

/// Two cuts in a row leave two torn pieces, and a flash of one sector cannot tell them from a pair that went bad.
#[test]
fn one_sector_leaves_the_last_good_record_after_power_lost_at_any_byte() {
    let (flash, old) = just_used(Memory::<4, 16384, false>::new(1));
    for power in 0..2000 {
        let mut board = Board::start(flash.clone().powered(Some(power)));
        board.learn(2e8);
        board.stand(1);
        let new = board.now();
        let board = Board::start(board.off().powered(None));
        assert!(board.found() == old || board.found() == (new.0, old.1));
        assert_eq!(board.recovery(), RECOVERED, "{power}");
    }
}

/// So full that one half after the other is erased, with the records of another spindle in both.
#[test]
fn power_lost_at_any_byte_while_halves_are_erased_leaves_the_last_good_record() {
    fn full<const UNIT: usize, const ECC: bool>(sector: usize, agains: &[Option<usize>]) {
        let (flash, other) = used_as(Memory::<UNIT, 4096, ECC>::new(sector), OTHER, 3e8);
        let (mut flash, mut learnt) = just_used(flash);
        let mut erased = 0;
        for _ in 0..80 {
            let before = flash.clone();
            let mut board = Board::start(flash);
            assert_eq!(board.found(), learnt);
            let erases = |flash: &Memory<UNIT, 4096, ECC>| flash.erased.iter().sum::<u64>();
            if erases(&Board::start(before.clone()).off()) > erases(&before) {
                erased += 1;
                survives_power_loss(&before, learnt, Some(other), agains);
                break;
            }
            board.turn(130);
            flash = board.off();
            learnt = Board::start(flash.clone()).found();
        }
        assert_eq!(erased, 1);
    }
    full::<4, false>(2, &[Some(0), Some(60)]);
    full::<32, true>(2, &[None, Some(100)]);
    // Halves of two sectors.
    full::<4, false>(4, &[None]);
}

// --- other designs and versions ----------------------------------------------------------------

/// A record that a firmware of another version has left: the first four numbers are those of every version.
fn of_another_version(
    version: u8,
    number: u32,
    kind: u32,
    identity: u32,
    length: usize,
) -> Vec<u8> {
    let rest: Vec<u8> = (0..length).map(|i| (i * 7) as u8).collect();
    let record = (version, number, kind, identity, rest);
    let frame = framing::encode::<_, { LONGEST_FOREIGN + 16 }>(&record).unwrap();
    frame.to_vec()
}

/// Puts records into both halves, as that firmware did.
fn put<const UNIT: usize, const SECTOR: usize, const ECC: bool>(
    flash: &mut Memory<UNIT, SECTOR, ECC>,
    frames: &[Vec<u8>],
) {
    let half = flash.bytes.len() / 2;
    for from in [0, half] {
        let mut at = from;
        for frame in frames {
            flash.bytes[at] = 0;
            at += 1;
            flash.bytes[at..at + frame.len()].copy_from_slice(frame);
            let end = (at + frame.len()).next_multiple_of(UNIT.max(16));
            flash.bytes[at + frame.len()..end].fill(0);
            at = end;
        }
    }
}

/// How often a frame stands in the flash.
fn copies<const UNIT: usize, const SECTOR: usize, const ECC: bool>(
    flash: &Memory<UNIT, SECTOR, ECC>,
    frame: &[u8],
) -> usize {
    let framed = [&[0], frame].concat();
    flash
        .bytes
        .windows(framed.len())
        .filter(|bytes| *bytes == framed)
        .count()
}

#[test]
fn another_version_finds_what_it_left_byte_by_byte() {
    fn holds<const UNIT: usize, const SECTOR: usize, const ECC: bool>() {
        let newest = [
            of_another_version(VERSION + 1, 400, 0, 5, 700),
            of_another_version(VERSION + 1, 401, 1, 6, 40),
            of_another_version(VERSION - 1, 300, 0, 5, 400),
            // Not even the first numbers are as they should be.
            framing::encode::<_, 16>(&(99_u8,)).unwrap().to_vec(),
        ];
        let old = of_another_version(VERSION + 1, 399, 1, 6, 41);
        let mut flash = Memory::<UNIT, SECTOR, ECC>::new(2);
        let all: Vec<_> = newest.iter().chain([&old]).cloned().collect();
        put(&mut flash, &all);
        // A start by itself changes nothing.
        let before = flash.bytes.clone();
        let board = Board::start(flash);
        assert_eq!(board.recovery(), [Recovery::OtherVersion; 3]);
        flash = board.off();
        assert_eq!(flash.bytes, before);
        let mut learnt = NOTHING;
        for start in 0..150 {
            let mut board = Board::start(flash);
            assert_eq!(board.found(), learnt, "{start}");
            if start == 0 {
                board.learn(1e8);
            }
            board.turn(121);
            assert_eq!(board.report().failed, 0, "{start}");
            flash = board.off();
            learnt = Board::start(flash.clone()).found();
            for frame in &newest {
                assert_eq!(copies(&flash, frame), 2, "{start}");
            }
        }
        // What was superseded there went when it was time.
        assert_eq!(copies(&flash, &old), 0);
        assert!(
            flash.erased.iter().all(|times| *times >= 2),
            "{:?}",
            flash.erased
        );
    }
    holds::<4, 8192, false>();
    holds::<32, 8192, true>();
}

#[test]
fn another_design_finds_what_it_has_learnt_when_it_is_back() {
    let (flash, first) = used(WideWords::new(2));
    let mut board = Board::start_as(flash, OTHER);
    assert_eq!(board.recovery(), [Recovery::OtherSpindle; 3]);
    assert_eq!(board.found(), NOTHING);
    // An hour of it, and more of the same until halves are erased.
    board.learn(3e8);
    board.turn(3600);
    let mut other = board.now();
    let mut flash = board.off();
    let before = flash.erased.clone();
    for _ in 0..60 {
        let mut board = Board::start_as(flash, OTHER);
        board.turn(125);
        flash = board.off();
        other.1 = Board::start_as(flash.clone(), OTHER).found().1;
    }
    assert!(
        flash
            .erased
            .iter()
            .zip(before)
            .all(|(now, before)| *now > before)
    );
    for _ in 0..2 {
        let board = Board::start(flash);
        assert_eq!((board.found(), board.recovery()), (first, RECOVERED));
        let board = Board::start_as(board.off(), OTHER);
        assert_eq!((board.found(), board.recovery()), (other, RECOVERED));
        flash = board.off();
    }
}

#[test]
fn more_other_spindles_than_are_carried_along_stop_the_erasing_and_are_told_of() {
    let mut flash = Memory::<4, 4096, false>::new(2);
    let frames: Vec<_> = (0..=FOREIGN as u32)
        .map(|i| of_another_version(VERSION + 1, i + 1, 0, i, 20))
        .collect();
    put(&mut flash, &frames);
    let mut error = None;
    for _ in 0..60 {
        let mut board = Board::start(flash);
        board.turn(121);
        error = board.store.error().or(error);
        flash = board.off();
        assert!(frames.iter().all(|frame| copies(&flash, frame) == 2));
    }
    assert_eq!(flash.erased, [0, 0]);
    let mut board = Board::start(flash);
    assert_eq!(board.store.error(), Some(WriteError::Crowded));
    assert_eq!(board.report().failed, 1);
    board.turn(121);
    assert_eq!(board.store.error(), Some(WriteError::Full));
    assert_eq!(board.report().life, Recovery::Recovered);
    // One fewer, and there is room again.
    let mut flash = Memory::<4, 4096, false>::new(2);
    put(&mut flash, &frames[1..]);
    for _ in 0..60 {
        let mut board = Board::start(flash);
        board.turn(121);
        assert_eq!(board.report().failed, 0);
        flash = board.off();
    }
    assert!(flash.erased.iter().all(|times| *times > 0));
    assert!(frames[1..].iter().all(|frame| copies(&flash, frame) == 2));
}

#[test]
fn another_spindles_past_is_refused_by_name() {
    let (flash, learnt) = used(Words::new(2));
    let recovery = |design: &Design, balls, bands: &BaselineSettings| {
        let identity = Identity::new(design, balls, bands);
        let board = Board::start_as(flash.clone(), identity);
        let [baseline, life, alarms] = board.recovery();
        assert_eq!(life == Recovery::Recovered, board.found.life == learnt.1);
        let none = board.found.baseline == Baseline::EMPTY;
        assert_eq!(baseline != Recovery::Recovered, none);
        assert_eq!(alarms, life);
        // The board is the same.
        assert_eq!(board.found.start.boots, 2);
        (baseline, life)
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

// --- damage ------------------------------------------------------------------------------------

/// Where the halves end that are in use.
fn ends<const UNIT: usize, const SECTOR: usize, const ECC: bool>(
    flash: &Memory<UNIT, SECTOR, ECC>,
) -> [usize; 2] {
    let half = flash.bytes.len() / 2;
    let end = |half: &[u8]| half.iter().rposition(|byte| *byte != 0xff).unwrap() + 1;
    [end(&flash.bytes[..half]), end(&flash.bytes[half..])]
}

#[test]
fn a_flipped_bit_anywhere_loses_nothing() {
    fn holds<const UNIT: usize, const SECTOR: usize, const ECC: bool>() {
        let (flash, learnt) = just_used(Memory::<UNIT, SECTOR, ECC>::new(2));
        let [first, second] = ends(&flash);
        let half = flash.bytes.len() / 2;
        for at in (0..first + 8).chain(half..half + second + 8) {
            for bit in 0..8 {
                let mut flash = flash.clone();
                flash.bytes[at] ^= 1 << bit;
                let board = Board::start(flash);
                assert_eq!(board.found(), learnt, "bit {bit} of {at}");
                assert_eq!(board.recovery(), RECOVERED, "bit {bit} of {at}");
                assert_eq!(board.report().failed, 0);
                let in_use = at < first || (half..half + second).contains(&at);
                if bit == 0 && in_use {
                    // The copy is made again: the other one may go now.
                    let mut flash = board.off();
                    let twin = if at < half { at + half } else { at - half };
                    flash.bytes[twin] ^= 1;
                    let board = Board::start(flash);
                    assert_eq!(
                        (board.found(), board.recovery()),
                        (learnt, RECOVERED),
                        "{at}"
                    );
                }
            }
        }
    }
    holds::<4, 4096, false>();
    holds::<32, 4096, true>();
}

/// A whole half cannot be read: what a worn sector or a torn erase leaves.
#[test]
fn a_half_that_is_gone_loses_nothing() {
    let (flash, learnt) = used(WideWords::new(2));
    for half in 0..2 {
        for what in [0x00, 0x5a, 0xff] {
            let mut flash = flash.clone();
            flash.bytes[half * 4096..(half + 1) * 4096].fill(what);
            for _ in 0..2 {
                let board = Board::start(flash);
                assert_eq!((board.found(), board.recovery()), (learnt, RECOVERED));
                assert_eq!(board.report().failed, 0);
                flash = board.off();
            }
            // There are two again.
            flash.bytes[(1 - half) * 4096..(2 - half) * 4096].fill(what);
            let board = Board::start(flash);
            assert_eq!((board.found(), board.recovery()), (learnt, RECOVERED));
        }
    }
}

#[test]
fn both_copies_of_the_newest_record_damaged_is_an_older_copy_until_there_is_a_newer_one() {
    let (flash, learnt) = just_used(Words::new(2));
    let mut board = Board::start(flash);
    board.write();
    let older = board.life.kept();
    board.turn(121);
    let newer = board.life.kept();
    assert_ne!(older, newer);
    let mut flash = board.off();
    for (half, end) in ends(&flash).into_iter().enumerate() {
        flash.bytes[half * 4096 + end - 30] ^= 1;
    }
    // Nobody knows what kind it was; and the next starts still know that something was lost.
    let mut board = Board::start(flash);
    assert_eq!(board.recovery(), [Recovery::OlderCopy; 3]);
    assert_eq!(board.found(), (learnt.0, older));
    for _ in 0..3 {
        board = Board::start(board.off());
        assert_eq!(board.found(), (learnt.0, older));
        // The alarms were written again at once.
        use Recovery::{OlderCopy, Recovered};
        assert_eq!(board.recovery(), [OlderCopy, OlderCopy, Recovered]);
        board.write();
    }
    board.turn(121);
    let mut board = Board::start(board.off());
    let [baseline, life, _] = board.recovery();
    assert_eq!((baseline, life), (Recovery::OlderCopy, Recovery::Recovered));
    board.learn(2e8);
    board.stand(1);
    assert_eq!(Board::start(board.off()).recovery(), RECOVERED);
}

#[test]
fn both_copies_of_a_baseline_damaged_is_told_of_the_baseline_alone() {
    let mut board = Board::start(Words::new(2));
    board.learn(1e8);
    board.stand(1);
    let older = board.now();
    let mut flash = board.off();
    let begin = ends(&flash);
    let mut board = Board::start(flash);
    board.learn(2e8);
    board.turn(400);
    flash = board.off();
    // The start and the baseline come first.
    for (half, begin) in begin.into_iter().enumerate() {
        flash.bytes[half * 4096 + begin + 64 + 100] ^= 0x40;
    }
    for _ in 0..40 {
        // However often the halves are erased.
        let mut board = Board::start(flash);
        assert_eq!(board.found.baseline, older.0);
        let [baseline, life, alarms] = board.recovery();
        assert_eq!(baseline, Recovery::OlderCopy);
        assert_eq!((life, alarms), (Recovery::Recovered, Recovery::Recovered));
        board.turn(121);
        flash = board.off();
    }
    assert!(flash.erased.iter().all(|times| *times > 0));
}

#[test]
fn a_torn_first_copy_was_never_complete_and_a_torn_second_one_is_not_needed() {
    let (flash, learnt) = just_used(Words::new(2));
    let run = |power| {
        let mut board = Board::start(flash.clone().powered(Some(power)));
        board.write();
        let older = board.life.kept();
        board.life.turn(1000.0, 1.0, false);
        assert_eq!(board.now().0, learnt.0);
        let life = &board.life;
        let went = board.store.power_fails(0, &board.judgement, life);
        (went, older, board.life.kept(), board.off().powered(None))
    };
    // Two copies of 48 bytes, twice.
    let cases = [
        (96, false),
        (97, false),
        (130, false),
        (144, true),
        (145, true),
        (190, true),
    ];
    for (power, newest) in cases {
        let (went, older, newer, flash) = run(power);
        assert_eq!(went, newest, "{power}");
        let board = Board::start(flash);
        assert_eq!(board.recovery(), RECOVERED);
        assert_eq!(board.found.life, if newest { newer } else { older });
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(256) })]

    #[test]
    fn any_content_ends_in_a_record_or_a_named_refusal_and_can_be_written_over(
        pieces in prop::collection::vec(
            (any::<prop::sample::Index>(), prop::collection::vec(any::<u8>(), 1..600)), 1..6),
        unreadable in prop::collection::vec(any::<prop::sample::Index>(), 0..6),
        on_top in any::<bool>(),
    ) {
        let (mut flash, learnt) = if on_top {
            just_used(WideWords::new(2))
        } else {
            (WideWords::new(2), NOTHING)
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
            (report.baseline, board.found.baseline == learnt.0),
            (report.life, board.found.life == learnt.1),
        ] {
            match recovery {
                Recovery::Recovered => prop_assert!(on_top && (same || report.damaged > 0)),
                Recovery::OlderCopy => prop_assert!(on_top && report.damaged > 0),
                Recovery::Damaged => prop_assert!(report.damaged > 0),
                Recovery::Blank | Recovery::OtherVersion => {}
                Recovery::NoMemory | Recovery::OtherSpindle => prop_assert!(false),
            }
        }
        board.learn(3e8);
        board.turn(1200);
        prop_assert_eq!(board.report().failed, 0);
        let learnt = board.now();
        let board = Board::start(board.off());
        prop_assert_eq!(board.found().0, learnt.0);
        prop_assert!(learnt.1.1 - board.found.life.1 <= learnt.1.1 / 8);
        prop_assert_eq!(board.recovery(), RECOVERED);
    }

    /// A byte in each half.
    #[test]
    fn two_changed_bytes_never_pass_an_older_record_for_the_newest(
        first in any::<prop::sample::Index>(), second in any::<prop::sample::Index>(),
        aligned in any::<bool>(), changes in prop::array::uniform2(1..=u8::MAX),
    ) {
        let (mut flash, learnt) = just_used(Words::new(2));
        let [end, other] = ends(&flash);
        prop_assert_eq!(end, other);
        let at = first.index(end);
        // Half of the cases hit the same place of both.
        let twin = if aligned { at } else { second.index(end) };
        flash.bytes[at] ^= changes[0];
        flash.bytes[4096 + twin] ^= changes[1];
        let board = Board::start(flash);
        for (recovery, same) in [
            (board.report().baseline, board.found.baseline == learnt.0),
            (board.report().life, board.found.life == learnt.1),
        ] {
            prop_assert!(same || recovery != Recovery::Recovered, "{at}, {twin}: {recovery:?}");
        }
        prop_assert_eq!(board.report().failed, 0);
    }
}

// --- starts and alarms -------------------------------------------------------------------------

#[test]
fn starts_are_counted_with_their_cause_and_a_failed_first_tick_counts_none() {
    let mut flash = WideWords::new(2);
    for (boots, cause) in (1..).zip(ResetCause::ALL.into_iter().cycle().take(50)) {
        let (mut store, past) = Store::open(flash, IDENTITY, cause);
        assert_eq!((past.start.boots, past.start.cause), (boots, cause));
        while store.step() {}
        assert_eq!(store.report().failed, 0);
        // This one is over before it has written anything.
        let (store, past) = Store::open(store.into_flash(), IDENTITY, cause);
        assert_eq!(past.start.boots, boots + 1);
        flash = store.into_flash();
    }
    let (_, past) = Store::open(Words::new(0), IDENTITY, ResetCause::Watchdog);
    assert_eq!(
        (past.start.boots, past.start.cause),
        (0, ResetCause::Watchdog)
    );
    let names: BTreeSet<_> = ResetCause::ALL.map(ResetCause::name).into();
    assert_eq!(names.len(), ResetCause::ALL.len());
}

#[test]
fn a_power_cycle_acknowledges_no_alarm() {
    let mut board = Board::start(WideWords::new(2));
    for alarm in [Alarm::Overload, Alarm::LifeUsed, Alarm::Slip] {
        board.raise(alarm);
    }
    board.judgement.acknowledge(Alarm::LifeUsed);
    board.stand(1);
    let mut flash = board.off();
    for _ in 0..2 {
        let board = Board::start(flash);
        let state = |alarm| board.judgement.alarm(alarm).state();
        assert_eq!(state(Alarm::Overload), AlarmState::Latched);
        assert_eq!(state(Alarm::Slip), AlarmState::Latched);
        assert_eq!(state(Alarm::LifeUsed), AlarmState::Clear);
        assert_eq!(state(Alarm::Sensor), AlarmState::Clear);
        let raised = board.found.start.raised;
        assert_eq!(raised[Alarm::Overload as usize], 1);
        assert_eq!(raised[Alarm::LifeUsed as usize], 1);
        assert_eq!(raised.iter().sum::<u16>(), 3);
        flash = board.off();
    }
    // Raised again, acknowledged, and raised by another bearing.
    let mut board = Board::start(flash);
    board.raise(Alarm::Overload);
    board.judgement.acknowledge(Alarm::Slip);
    board.stand(1);
    let mut other = Board::start_as(board.off(), OTHER);
    assert_eq!(other.judgement.unacknowledged(), 0);
    other.raise(Alarm::Sensor);
    other.stand(1);
    let board = Board::start(other.off());
    assert_eq!(
        board.judgement.unacknowledged(),
        1 << Alarm::Overload as u32
    );
    assert_eq!(board.found.start.raised[Alarm::Overload as usize], 2);
    assert_eq!(board.found.start.raised[Alarm::Sensor as usize], 0);
}

#[test]
fn alarms_that_come_and_go_leave_the_last_quarter_to_the_life() {
    let mut board = Board::start(Memory::<4, 16384, false>::new(2));
    for _ in 0..4000 {
        board.raise(Alarm::Slip);
        board.stand(1);
        let acknowledged = board.judgement.acknowledge(Alarm::Slip);
        assert!(acknowledged.is_some());
        board.judgement = Judgement::new(Baseline::EMPTY);
        board.stand(1);
    }
    assert_eq!(board.store.error(), Some(WriteError::Full));
    let written = board.report().written;
    assert!((150..260).contains(&written), "{written}");
    board.turn(3600);
    let life = board.life.kept();
    let found = Board::start(board.off()).found.life;
    assert!((life.1 - found.1) as f64 <= life.1 as f64 / 25.0);
}

#[test]
fn a_board_that_is_warned_of_the_power_cut_loses_nothing() {
    fn holds<F: NorFlash + Clone>(flash: F) {
        let (flash, _) = just_used(flash);
        let mut board = Board::start(flash);
        board.write();
        board.life.turn(1000.0, 50.0, false);
        board.raise(Alarm::Slip);
        let mut steps = 0;
        // Whatever else is being written.
        for busy in [0, 1, 2, 9, 40] {
            board.learn(1e8 * (2 + busy) as f32);
            board.time_us += 1_000_000;
            board
                .store
                .look(board.time_us, &board.judgement, &board.life);
            for _ in 0..busy {
                board.store.step();
            }
            board.life.turn(1000.0, 0.1, false);
            assert!(
                board
                    .store
                    .power_fails(board.time_us, &board.judgement, &board.life)
            );
            let life = board.life.kept();
            let Board { store, .. } = Board::start(board.off());
            board = Board::start(store.into_flash());
            assert_eq!(board.found.life, life, "{busy}");
            assert_eq!(board.recovery()[1], Recovery::Recovered);
            assert_eq!(board.judgement.unacknowledged(), 1 << Alarm::Slip as u32);
            steps += busy;
        }
        // If the power comes back, what was left is written.
        board.learn(9e8);
        board.time_us += 1_000_000;
        board
            .store
            .look(board.time_us, &board.judgement, &board.life);
        for _ in 0..steps {
            board.store.step();
        }
        board
            .store
            .power_fails(board.time_us, &board.judgement, &board.life);
        board.write();
        let learnt = board.now();
        let board = Board::start(board.off());
        assert_eq!((board.found(), board.recovery()), (learnt, RECOVERED));
    }
    holds(Memory::<4, 16384, false>::new(2));
    holds(Memory::<32, 16384, true>::new(2));
    let mut board = Board::start(Words::new(0));
    assert!(!board.store.power_fails(0, &board.judgement, &board.life));
}

// --- wear --------------------------------------------------------------------------------------

/// A year of eight hours a day, in two sectors of 128 KiB.
#[test]
fn a_year_of_daily_work_takes_fifty_erases_of_the_ten_thousand_that_flash_endures() {
    let mut flash = Memory::<32, { 128 * 1024 }, true>::new(2);
    let mut life = (0, 0);
    for _ in 0..365 {
        let mut board = Board::start(flash);
        assert_eq!(board.found.life, life);
        board.life.set_damage(1e-3);
        for _ in 0..8 * 60 {
            board.life.turn(1000.0, 60.0, false);
            board.time_us += 60_000_000;
            board
                .store
                .look(board.time_us, &board.judgement, &board.life);
            board.write();
        }
        assert_eq!(board.report().failed, 0);
        assert!(
            (130..170).contains(&board.report().written),
            "{:?}",
            board.report()
        );
        flash = board.off();
        life = Board::start(flash.clone()).found.life;
    }
    assert!(
        flash.erased.iter().all(|times| (30..60).contains(times)),
        "{:?}",
        flash.erased
    );
    assert_eq!(flash.erased[0], flash.erased[1]);
}

/// The worst that can be done to it: a start, and a record of the life, every two minutes.
#[test]
fn power_cuts_every_two_minutes_leave_a_half_twenty_years() {
    let mut flash = Memory::<32, { 128 * 1024 }, true>::new(2);
    let starts = 2000;
    for _ in 0..starts {
        let mut board = Board::start(flash);
        board.write();
        board.life.turn(1000.0, 60.0, false);
        board.time_us += LIFE_US;
        board
            .store
            .look(board.time_us, &board.judgement, &board.life);
        board.write();
        assert_eq!((board.report().written, board.report().failed), (2, 0));
        flash = board.off();
    }
    let a_year = flash.erased[0] as f64 * 365.25 * 720.0 / f64::from(starts);
    assert!((300.0..550.0).contains(&a_year), "{a_year}");
}

/// The other bound: no restart, so that nothing is erased.
#[test]
fn ten_years_without_a_restart_find_room_and_lose_less_than_a_64th_at_any_time() {
    let (flash, _) = used(Memory::<32, { 128 * 1024 }, true>::new(2));
    let mut board = Board::start(flash);
    let began = board.life.kept().1;
    board.life.set_damage(1e-3);
    let mut kept = began;
    for minute in 0..10 * 365 * 24 * 30_u32 {
        board.life.turn(1000.0, 120.0, false);
        board.time_us += 120_000_000;
        let written = board.report().written;
        board
            .store
            .look(board.time_us, &board.judgement, &board.life);
        board.write();
        let now = board.life.kept().1;
        if board.report().written > written {
            kept = now;
        }
        assert!(now - kept <= (now - began) / 64, "{minute}");
    }
    assert_eq!(board.report().failed, 0);
    assert!(
        (700..780).contains(&board.report().written),
        "{:?}",
        board.report()
    );
}

#[test]
fn a_log_that_is_full_keeps_what_it_has_and_says_so() {
    let mut board = Board::start(Memory::<4, 4096, false>::new(1));
    while board.report().failed == 0 {
        assert!(board.time_us < 1_000_000_000_000);
        board.life.turn(1000.0, 1e9, false);
        board.stand(120);
    }
    assert_eq!(board.store.error(), Some(WriteError::Full));
    let written = board.report().written;
    let mut flash = board.off();
    for _ in 0..3 {
        // One sector is not erased: there is no place for what stands in it.
        let mut board = Board::start(flash);
        assert_eq!(board.report().life, Recovery::Recovered);
        board.life.turn(1000.0, 1e9, false);
        board.stand(120);
        assert_eq!(board.report().written, 0);
        assert!(board.report().failed > 0);
        flash = board.off();
    }
    assert!(written > 20 && flash.erased == [0]);
}

#[test]
fn worn_cells_are_left_behind_and_a_flash_that_takes_nothing_is_told_of() {
    let (mut flash, learnt) = just_used(Words::new(2));
    let [end, other] = ends(&flash);
    // Two attempts of the first half meet one of them, and one of the second.
    flash.worn = [end + 30, end + 60, 4096 + other + 3].into();
    let mut board = Board::start(flash);
    board.learn(2e8);
    board.stand(1);
    assert_eq!((board.report().written, board.report().failed), (3, 0));
    let newer = board.now();
    assert_ne!(newer, learnt);
    let board = Board::start(board.off());
    assert_eq!((board.found(), board.recovery()), (newer, RECOVERED));

    let mut flash = board.off();
    flash.worn = (0..flash.bytes.len()).collect();
    let mut board = Board::start(flash);
    board.learn(3e8);
    board.stand(1);
    let report = board.report();
    assert_eq!((report.written, report.failed), (0, 3));
    assert_eq!(board.store.error(), Some(WriteError::Flash));
    let mut flash = board.off();
    flash.worn.clear();
    let mut board = Board::start(flash);
    assert_eq!(board.found(), newer);
    board.learn(4e8);
    board.stand(1);
    let newest = board.now();
    let board = Board::start(board.off());
    assert_eq!((board.found(), board.recovery()), (newest, RECOVERED));
}

#[test]
fn a_half_that_is_worn_out_leaves_the_other_one() {
    for half in 0..2 {
        let (mut flash, mut learnt) = just_used(Words::new(2));
        flash.worn = (half * 4096..(half + 1) * 4096).collect();
        for start in 1..6 {
            let mut board = Board::start(flash);
            assert_eq!(board.found(), learnt);
            board.learn(1e8 * start as f32);
            board.stand(1);
            assert!(board.report().failed > 0);
            learnt = board.now();
            flash = board.off();
        }
    }
}

/// What cannot be erased is told of, and there is still the rest.
#[test]
fn a_flash_that_does_not_erase_is_told_of() {
    let mut flash = Words::new(2);
    flash.bytes[4096 - 1000] = 0;
    flash.refuses_to_erase = true;
    let mut board = Board::start(flash);
    assert_eq!(board.report().failed, 2);
    assert_eq!(board.store.error(), Some(WriteError::Flash));
    board.learn(1e8);
    board.stand(1);
    let learnt = board.now();
    let board = Board::start(board.off());
    assert_eq!(board.found(), learnt);
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
        temperatures: None,
    }
}

/// A monitor that was switched off goes on as one that was not: the same baseline, so the same ratios to the
/// bit, and the same life.
#[test]
fn a_monitor_goes_on_after_a_power_cycle_with_the_same_judgement() {
    let (store, past) = Store::open(WideWords::new(2), IDENTITY, ResetCause::PowerOn);
    let mut store = store;
    let mut monitor: Monitor<1, 16> =
        Monitor::new(Spindle::single(&BEARING), &SETTINGS).with_past(&past);
    monitor.prepare(IDLE, 0.0).unwrap();
    let tick = |monitor: &mut Monitor<1, 16>, store: &mut Store<_>, time_us: u64| {
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
    assert_eq!((report.written, report.failed), (3, 0));
    let baseline = *monitor.judgement().baseline();
    assert!(
        baseline.estimates.iter().any(|count| *count > 1000),
        "{:?}",
        baseline.estimates
    );

    let (mut store, past) = Store::open(store.into_flash(), IDENTITY, ResetCause::PowerOn);
    assert_eq!(past.baseline, baseline);
    let mut other: Monitor<1, 16> =
        Monitor::new(Spindle::single(&BEARING), &SETTINGS).with_past(&past);
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
    let lived = |monitor: &Monitor<1, 16>, from: (u128, u128)| {
        let now = monitor.life().kept();
        (now.0 - from.0, now.1 - from.1)
    };
    other.prepare(IDLE, 0.0).unwrap();
    let mut without: Monitor<1, 16> = Monitor::new(Spindle::single(&BEARING), &SETTINGS);
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
    let (_, past) = Store::open(store.into_flash(), IDENTITY, ResetCause::PowerOn);
    // A tick after the replacement has turned a little.
    assert_eq!(past.baseline, Baseline::EMPTY);
    assert!(past.life.1 >> 64 <= 250, "{}", past.life.1 >> 64);
}

/// The host sees it without asking: the start by its own report, the alarm among those that stand.
#[test]
fn a_monitor_tells_of_its_start_and_of_the_alarms_before_it() {
    let mut board = Board::start(WideWords::new(2));
    board.raise(Alarm::Overload);
    board.stand(1);
    let (_, past) = Store::open(board.off(), IDENTITY, ResetCause::Watchdog);
    let mut monitor: Monitor<1, 16> =
        Monitor::new(Spindle::single(&BEARING), &SETTINGS).with_past(&past);
    monitor.prepare(IDLE, 0.0).unwrap();
    let mut reader = FrameReader::new();
    let (mut starts, mut states) = (Vec::new(), Vec::new());
    for ms in 0..2000 {
        let time_us = ms * 1000;
        monitor.tick(time_us, &readings(time_us), &mut NoCycles, &mut NoWatchdog);
        if ms == 1500 {
            monitor.acknowledge(time_us, Alarm::Overload);
        }
        while let Some(byte) = monitor.outbox().next_byte() {
            match reader.push(byte).map(|frame| frame.unwrap().payload) {
                Some(Payload::Start(report)) => starts.push(report),
                Some(Payload::Alarm(report)) if report.alarm == Alarm::Overload => {
                    states.push(report.state);
                }
                _ => {}
            }
        }
    }
    let [start] = starts[..] else {
        panic!("{starts:?}");
    };
    assert_eq!((start.boots, start.cause), (2, ResetCause::Watchdog));
    assert_eq!(start.recovery, Recovery::Recovered);
    assert_eq!(start.latched().collect::<Vec<_>>(), [Alarm::Overload]);
    assert_eq!(start.raised[Alarm::Overload as usize], 1);
    let (last, before) = states.split_last().unwrap();
    assert!(!before.is_empty() && before.iter().all(|state| *state == AlarmState::Latched));
    assert_eq!(*last, AlarmState::Clear);
}

#[test]
fn without_a_memory_the_monitor_says_so() {
    let monitor: Monitor<1, 16> = Monitor::new(Spindle::single(&BEARING), &SETTINGS);
    assert_eq!(monitor.health().retention, RetentionReport::NO_MEMORY);
    let (mut store, past) = Store::open(Words::new(0), IDENTITY, ResetCause::PowerOn);
    assert_eq!(past.alarms, Recovery::NoMemory);
    assert_eq!((past.baseline, past.life), NOTHING);
    assert_eq!(store.report(), RetentionReport::NO_MEMORY);
    assert!(!store.step());
}

// --- the boards' flash -------------------------------------------------------------------------

#[path = "../../../examples/firmware/board/flash.rs"]
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

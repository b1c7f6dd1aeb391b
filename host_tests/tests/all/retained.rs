//! Log of `monitor::retained` without power, on a flash in memory that forgets its manners as real ones do.

use super::monitor::BEARING;
use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashErrorKind, ReadNorFlash, check_erase, check_read, check_write,
};
use host_tests::cases::B7005C;
use proptest::prelude::*;
use spindle_bearing::framing;
use spindle_bearing::monitor::board::ResetCause;
use spindle_bearing::monitor::judgement::{Alarm, AlarmState, Level, Levels};
use spindle_bearing::monitor::loads::LoadSample;
use spindle_bearing::monitor::retained::{
    FOREIGN, Identity, LIFE_US, LONGEST_FOREIGN, Past, Store, VERSION, WriteError,
};
use spindle_bearing::monitor::settings::MonitorSettings;
use spindle_bearing::monitor::telemetry::{FrameReader, Payload, Recovery, RetentionReport};
use spindle_bearing::monitor::tick::{NoCycles, NoWatchdog};
use spindle_bearing::monitor::{Judgement, Life, Marks, Monitor, Readings};
use spindle_bearing::{Design, FreeContact, Material, Spindle};
use std::collections::BTreeSet;

static SETTINGS: MonitorSettings = {
    let mut settings = MonitorSettings::new(&B7005C, 16);
    settings.tick.deadline_cycles *= 10;
    settings
};
/// Worked out by the compiler, as a firmware has it.
const IDENTITY: Identity = Identity::new(&B7005C, 16);

/// A flash of sectors, units of `UNIT` bytes. Wide units have error correction: one that is written only in part cannot
/// be read until it is erased.
#[derive(Debug, Clone, Default)]
struct Memory<const UNIT: usize, const SECTOR: usize> {
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

impl<const UNIT: usize, const SECTOR: usize> Memory<UNIT, SECTOR> {
    fn new(sectors: usize) -> Self {
        Self {
            bytes: vec![0xff; sectors * SECTOR],
            erased: vec![0; sectors],
            ..Self::default()
        }
    }

    /// Puts records into both halves, as a firmware of another version did.
    fn put(&mut self, frames: &[Vec<u8>]) {
        let half = self.bytes.len() / 2;
        for mut at in [0, half] {
            for frame in frames {
                let end = (at + 1 + frame.len()).next_multiple_of(UNIT.max(16));
                self.bytes[at..end].fill(0);
                self.bytes[at + 1..][..frame.len()].copy_from_slice(frame);
                at = end;
            }
        }
    }

    /// How often a frame stands in it.
    fn copies(&self, frame: &[u8]) -> usize {
        let framed = [&[0], frame].concat();
        let places = self.bytes.windows(framed.len());
        places.filter(|bytes| *bytes == framed).count()
    }

    /// Where the halves end that are in use.
    fn ends(&self) -> [usize; 2] {
        let (one, other) = self.bytes.split_at(self.bytes.len() / 2);
        [one, other].map(|half| half.iter().rposition(|byte| *byte != 0xff).unwrap() + 1)
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

impl<const UNIT: usize, const SECTOR: usize> ErrorType for Memory<UNIT, SECTOR> {
    type Error = NorFlashErrorKind;
}

impl<const UNIT: usize, const SECTOR: usize> ReadNorFlash for Memory<UNIT, SECTOR> {
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

impl<const UNIT: usize, const SECTOR: usize> NorFlash for Memory<UNIT, SECTOR> {
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
                if UNIT >= 32 {
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
type Words = Memory<4, 4096>;
type WideWords = Memory<32, 4096>;

const IDLE: [f32; 5] = [420.0, 0.0, 0.0, 0.0, 0.0];

/// Life, and alarms that nobody has acknowledged.
type Kept = ((u64, u64), u32);
const NOTHING: Kept = ((0, 0), 0);

/// Identity of the spindle with balls of ceramic.
const OTHER: Identity = {
    let mut design = B7005C;
    design.ball = Material::SILICON_NITRIDE;
    Identity::new(&design, 16)
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
        let mut judgement = Judgement::default();
        judgement.latch(found.start.alarms);
        Self {
            store,
            found,
            judgement,
            life: Life::resume(found.life.0, found.life.1),
            time_us: 0,
        }
    }

    /// A level that raises an alarm at once.
    fn raise(&mut self, alarm: Alarm) {
        let level = Level::of(f32::INFINITY);
        let mut levels = Levels::default();
        levels.set(alarm, level);
        let _ = self
            .judgement
            .judge(self.time_us, &levels, &SETTINGS.alarms);
        assert_eq!(self.judgement.alarm(alarm).state(), AlarmState::Raised);
    }

    /// The shaft turns for so long, a look at every second.
    fn turn(&mut self, seconds: u64) {
        for _ in 0..seconds {
            self.life.set_damage(1e-3, 0.0);
            self.life.turn(1000.0, 1.0, false, false);
            self.stand(1);
        }
    }

    /// It stands still for so long.
    fn stand(&mut self, seconds: u64) {
        for _ in 0..seconds {
            self.pass(1);
        }
    }

    /// It turns for so long, a look at the end.
    fn turn_at_once(&mut self, seconds: u32) {
        self.life.turn(1000.0, seconds as f32, false, false);
        self.pass(seconds.into());
    }

    /// Time passes until the next look.
    fn pass(&mut self, seconds: u64) {
        self.time_us += 1_000_000 * seconds;
        self.look();
        self.write();
    }

    fn look(&mut self) {
        self.store.look(self.time_us, &self.judgement, &self.life);
    }

    fn power_fails(&mut self) -> bool {
        self.store
            .power_fails(self.time_us, &self.judgement, &self.life)
    }

    fn write(&mut self) {
        let mut steps = 0;
        while self.store.step() {
            steps += 1;
            assert!(steps < 10_000);
        }
    }

    fn now(&self) -> Kept {
        (self.life.kept(), self.judgement.unacknowledged())
    }

    fn found(&self) -> Kept {
        (self.found.life, self.found.start.alarms)
    }

    /// Starts once more, and finds all of this.
    fn recovers(flash: F, kept: Kept) -> F {
        let board = Self::start(flash);
        assert_eq!((board.found(), board.recovery()), (kept, RECOVERED));
        board.off()
    }

    /// Recovery of life and alarms.
    fn recovery(&self) -> [Recovery; 2] {
        [self.report().life, self.found.alarms]
    }

    fn off(self) -> F {
        self.store.into_flash()
    }

    fn report(&self) -> RetentionReport {
        self.store.report()
    }
}

const RECOVERED: [Recovery; 2] = [Recovery::Recovered; 2];

/// A flash that has seen an alarm and an hour of turning.
fn used<F: NorFlash>(flash: F) -> (F, Kept) {
    used_as(flash, IDENTITY, Alarm::Slip, 3600)
}

/// Less than an hour: a few records only.
fn just_used<F: NorFlash>(flash: F) -> (F, Kept) {
    used_as(flash, IDENTITY, Alarm::Slip, 300)
}

fn used_as<F: NorFlash>(flash: F, identity: Identity, alarm: Alarm, seconds: u64) -> (F, Kept) {
    let mut board = Board::start_as(flash, identity);
    board.raise(alarm);
    board.turn(seconds);
    board.stand(120);
    let kept = board.now();
    assert_eq!(board.report().failed, 0);
    (board.off(), kept)
}

#[test]
fn what_was_kept_is_there_after_any_number_of_starts() {
    fn holds<F: NorFlash>(flash: F) {
        let report = |state| RetentionReport {
            life: state,
            ..RetentionReport::NO_MEMORY
        };
        let mut first = Board::start(flash);
        assert_eq!(first.found(), NOTHING);
        assert_eq!(first.report(), report(Recovery::Blank));
        assert_eq!(first.recovery(), [Recovery::Blank; 2]);
        first.write();
        let (mut flash, kept) = used(first.off());
        for boots in 3..6 {
            let mut board = Board::start(flash);
            assert_eq!((board.found(), board.recovery()), (kept, RECOVERED));
            assert_eq!(board.report(), report(Recovery::Recovered));
            assert_eq!(board.found.start.boots, boots);
            board.write();
            assert_eq!((board.report().written, board.report().failed), (1, 0));
            flash = board.off();
        }
    }
    holds(Words::new(2));
    holds(WideWords::new(2));
    holds(Memory::<1, 4096>::new(5));
    holds(Memory::<64, 8192>::new(3));
    // One sector has both copies.
    holds(Memory::<4, 16384>::new(1));
}

#[test]
fn life_is_written_every_two_minutes_and_then_in_proportion() {
    let mut board = Board::start(Memory::<4, 65536>::new(2));
    board.write();
    for (turns, stands, written) in [
        (LIFE_US / 1_000_000 - 1, 0, 1),
        (1, 0, 2),
        // Nothing new.
        (0, 20_000, 2),
        // Two seconds after a long rest are worth a record.
        (2, 0, 3),
        (0, 118, 3),
    ] {
        board.turn(turns);
        board.stand(stands);
        assert_eq!(board.report().written, written);
    }
    // 64 ln(4/2), 64 ln(6/4) and so on.
    for expected in [60, 44, 25, 18, 14] {
        let before = board.report().written;
        board.turn(7200);
        let written = board.report().written - before;
        assert!(written.abs_diff(expected) <= 2, "{written}, not {expected}");
    }
    assert_eq!(board.report().failed, 0);
    let lived = board.life.kept();
    let Board { found, .. } = Board::start(board.off());
    let lost = (lived.1 - found.life.1) as f64 / lived.1 as f64;
    assert!(lost < 1.0 / 64.0, "{lost}");
}

/// A crash of a minute after a week of idling: few revolutions, much life.
#[test]
fn life_that_is_used_fast_is_written_as_soon_as_revolutions() {
    let mut board = Board::start(Memory::<4, 65536>::new(2));
    board.life.set_damage(1e-6, 0.0);
    for _ in 0..7 * 24 * 60 {
        board.life.turn(1000.0, 60.0, false, false);
        board.stand(60);
    }
    board.life.set_damage(10.0, 0.0);
    for _ in 0..2 {
        board.life.turn(1000.0, 60.0, false, false);
        board.stand(60);
    }
    let used = board.life.kept().0;
    let Board { found, .. } = Board::start(board.off());
    assert!(used - found.life.0 <= used / 2 + used / 64);
}

#[test]
fn the_life_of_a_replaced_bearing_is_written_at_once() {
    let (flash, (_, alarms)) = used(Words::new(2));
    let mut board = Board::start(flash);
    board.life = Life::NEW;
    board.stand(1);
    assert_eq!(Board::start(board.off()).found(), ((0, 0), alarms));
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
            lived.turn(1000.0, minutes as f32 * 60.0, false, false);
            assert!(after > before);
            flash = board.off();
        }
        let kept = Board::start(flash).found.life.1 as f64 / lived.kept().1 as f64;
        assert!(kept > 0.88, "{minutes} min: {kept}");
    }
}

/// Power goes at every byte that is written, and again at every few bytes of the next start. Another spindle's records
/// in the same flash, if there are any, are as they were.
fn survives_power_loss<const UNIT: usize, const SECTOR: usize>(
    flash: &Memory<UNIT, SECTOR>,
    old: Kept,
    other: Option<Kept>,
    agains: &[Option<usize>],
) {
    let run = |flash: Memory<UNIT, SECTOR>| {
        let mut board = Board::start(flash);
        let found = board.found();
        board.raise(Alarm::Overload);
        board.life.turn(1000.0, 1.0, false, false);
        board.pass(LIFE_US / 1_000_000);
        (found, board.now(), board.off())
    };
    let (found, new, whole) = run(flash.clone());
    assert_eq!(found, old);
    let bytes = (whole.written - flash.written + whole.erased.iter().sum::<u64>()
        - flash.erased.iter().sum::<u64>()) as usize;
    assert!(bytes >= 128, "{bytes}");
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
            let (life, alarms) = board.found();
            assert!(life == old.0 || life == new.0, "{power}, {again:?}");
            assert!(alarms == old.1 || alarms == new.1, "{power}, {again:?}");
            // The life is written first.
            assert!(alarms == old.1 || life == new.0);
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
    // A frame has 24 bytes at least, and zeros behind it.
    let least = [24, 2].map(|powers| powers * agains.len());
    assert!(
        with_old >= least[0] && with_new >= least[1],
        "{with_old}, {with_new}"
    );
}

/// When the power goes once more.
const AGAINS: &[Option<usize>] = &[None, Some(0), Some(7), Some(40), Some(150)];

#[test]
fn power_lost_at_any_byte_leaves_the_last_good_record() {
    fn holds<const UNIT: usize, const SECTOR: usize>(sectors: usize, agains: &[Option<usize>]) {
        let (flash, kept) = just_used(Memory::<UNIT, SECTOR>::new(sectors));
        survives_power_loss(&flash, kept, None, agains);
    }
    holds::<4, 4096>(2, AGAINS);
    holds::<32, 4096>(2, AGAINS);
    holds::<1, 4096>(3, AGAINS);
    // Two cuts in a row leave two torn pieces, and a flash of one sector cannot tell them from a pair that went bad.
    holds::<4, 16384>(1, &[None]);
    survives_power_loss(&WideWords::new(2), NOTHING, None, AGAINS);
}

/// So full that one half after the other is erased, with the records of another spindle in both.
#[test]
fn power_lost_at_any_byte_while_halves_are_erased_leaves_the_last_good_record() {
    fn full<const UNIT: usize>(sectors: usize, agains: &[Option<usize>]) {
        let (flash, other) = used_as(
            Memory::<UNIT, 4096>::new(sectors),
            OTHER,
            Alarm::Sensor,
            3600,
        );
        let (mut flash, mut kept) = just_used(flash);
        for _ in 0..80 {
            let mut board = Board::start(flash.clone());
            assert_eq!(board.found(), kept);
            let erased = Board::start(flash.clone()).off().erased;
            if erased != flash.erased {
                return survives_power_loss(&flash, kept, Some(other), agains);
            }
            board.turn(130);
            flash = board.off();
            kept = Board::start(flash.clone()).found();
        }
        panic!("nothing is erased");
    }
    full::<4>(2, &[Some(0), Some(60)]);
    full::<32>(2, &[None, Some(100)]);
    // Halves of two sectors.
    full::<4>(4, &[None]);
}

// --- other designs and versions ----------------------------------------------------------------

/// A record that a firmware of another version has left: version, number, kind and identity come first in every version.
fn foreign(version: u8, [number, kind, identity]: [u32; 3], length: usize) -> Vec<u8> {
    let rest: Vec<u8> = (0..length).map(|i| (i * 7) as u8).collect();
    let record = (version, number, kind, identity, rest);
    let frame = framing::encode::<_, { LONGEST_FOREIGN + 16 }>(&record).unwrap();
    frame.to_vec()
}

#[test]
fn another_version_finds_what_it_left_byte_by_byte() {
    fn holds<const UNIT: usize>() {
        let frames = [
            foreign(VERSION + 1, [400, 0, 5], 700),
            foreign(VERSION + 1, [401, 1, 6], 40),
            foreign(VERSION - 1, [300, 0, 5], 400),
            // Not even the first numbers are as they should be.
            framing::encode::<_, 16>(&(99_u8,)).unwrap().to_vec(),
            // There is a newer one.
            foreign(VERSION + 1, [399, 1, 6], 41),
        ];
        let [newest @ .., superseded] = &frames;
        let mut flash = Memory::<UNIT, 8192>::new(2);
        flash.put(&frames);
        // A start by itself changes nothing.
        let before = flash.bytes.clone();
        let board = Board::start(flash);
        assert_eq!(board.recovery(), [Recovery::OtherVersion; 2]);
        flash = board.off();
        assert_eq!(flash.bytes, before);
        let mut kept = NOTHING;
        for start in 0..150 {
            let mut board = Board::start(flash);
            assert_eq!(board.found(), kept, "{start}");
            if start == 0 {
                board.raise(Alarm::Slip);
            }
            board.turn(121);
            assert_eq!(board.report().failed, 0, "{start}");
            flash = board.off();
            kept = Board::start(flash.clone()).found();
            for frame in newest {
                assert_eq!(flash.copies(frame), 2, "{start}");
            }
        }
        // It went when it was time.
        assert_eq!(flash.copies(superseded), 0);
        assert!(flash.erased.iter().all(|times| *times >= 2));
    }
    holds::<4>();
    holds::<32>();
}

#[test]
fn more_other_spindles_than_are_carried_along_stop_the_erasing_and_are_told_of() {
    let frames: Vec<_> = (0..=FOREIGN as u32)
        .map(|i| foreign(VERSION + 1, [i + 1, 0, i], 20))
        .collect();
    let used = |frames: &[Vec<u8>]| {
        let mut flash = Words::new(2);
        flash.put(frames);
        let mut failed = 0;
        for _ in 0..60 {
            let mut board = Board::start(flash);
            board.turn(121);
            failed += board.report().failed;
            flash = board.off();
            assert!(frames.iter().all(|frame| flash.copies(frame) == 2));
        }
        (flash, failed)
    };
    let (flash, _) = used(&frames);
    assert_eq!(flash.erased, [0, 0]);
    let mut board = Board::start(flash);
    assert_eq!(board.store.error(), Some(WriteError::Crowded));
    assert_eq!(board.report().failed, 1);
    board.turn(121);
    assert_eq!(board.store.error(), Some(WriteError::Full));
    assert_eq!(board.report().life, Recovery::Recovered);
    // One fewer, and there is room again.
    let (flash, failed) = used(&frames[1..]);
    assert!(failed == 0 && flash.erased.iter().all(|times| *times > 0));
}

#[test]
fn another_spindles_past_is_refused_by_name() {
    use Recovery::{OtherSpindle, Recovered};
    type Change = fn(&mut Design, &mut usize);
    let cases: [(Change, Recovery); 5] = [
        (|_, _| {}, Recovered),
        (|_, balls| *balls = 17, OtherSpindle),
        (
            |design, _| design.ball = Material::SILICON_NITRIDE,
            OtherSpindle,
        ),
        (
            |design, _| {
                let angle = 15.0 * std::f64::consts::PI / 180.0;
                design.free_contact = FreeContact::DiametralClearance(angle);
            },
            OtherSpindle,
        ),
        // Shoulders have no part in the forces.
        (|design, _| design.inner_shoulder_angle = 0.8, Recovered),
    ];
    let (flash, kept) = used(Words::new(2));
    for (i, (change, expected)) in cases.into_iter().enumerate() {
        let (mut design, mut balls) = (B7005C, 16);
        change(&mut design, &mut balls);
        let identity = Identity::new(&design, balls);
        let board = Board::start_as(flash.clone(), identity);
        assert_eq!(board.recovery(), [expected; 2], "{i}");
        let found = if expected == Recovered { kept } else { NOTHING };
        assert_eq!(board.found(), found, "{i}");
        // The board is the same.
        assert_eq!(board.found.start.boots, 2);
    }
}

// --- damage ------------------------------------------------------------------------------------

#[test]
fn a_flipped_bit_anywhere_loses_nothing() {
    fn holds<const UNIT: usize>() {
        let (flash, kept) = just_used(Memory::<UNIT, 4096>::new(2));
        let [first, second] = flash.ends();
        for at in (0..first + 8).chain(4096..4096 + second + 8) {
            for bit in 0..8 {
                let mut flash = flash.clone();
                flash.bytes[at] ^= 1 << bit;
                let board = Board::start(flash);
                assert_eq!(board.report().failed, 0);
                assert_eq!((board.found(), board.recovery()), (kept, RECOVERED));
                let mut flash = board.off();
                if bit == 0 && at % 4096 < first.min(second) {
                    // The copy is made again: the other one may go now.
                    flash.bytes[(at + 4096) % 8192] ^= 1;
                    Board::recovers(flash, kept);
                }
            }
        }
    }
    holds::<4>();
    holds::<32>();
}

/// A whole half cannot be read: what a worn sector or a torn erase leaves.
#[test]
fn a_half_that_is_gone_loses_nothing() {
    let (flash, kept) = used(WideWords::new(2));
    for half in 0..2 {
        for what in [0x00, 0x5a, 0xff] {
            let mut flash = flash.clone();
            for gone in [half, 1 - half] {
                flash.bytes[gone * 4096..(gone + 1) * 4096].fill(what);
                // There are two again after the first start.
                for _ in 0..2 {
                    let board = Board::start(flash);
                    assert_eq!((board.found(), board.recovery()), (kept, RECOVERED));
                    assert_eq!(board.report().failed, 0);
                    flash = board.off();
                }
            }
        }
    }
}

#[test]
fn both_copies_of_the_newest_record_damaged_is_an_older_copy_until_there_is_a_newer_one() {
    use Recovery::{OlderCopy, Recovered};
    let (flash, kept) = just_used(Words::new(2));
    let mut board = Board::start(flash);
    board.write();
    let older = board.life.kept();
    board.turn(121);
    assert_ne!(older, board.life.kept());
    let mut flash = board.off();
    for (half, end) in flash.ends().into_iter().enumerate() {
        flash.bytes[half * 4096 + end - 30] ^= 1;
    }
    // Its kind is not known, and the next starts still know that a record was lost.
    for start in 0..4 {
        let mut board = Board::start(flash);
        assert_eq!(board.found(), (older, kept.1));
        // The alarms are written again at once.
        let alarms = if start == 0 { OlderCopy } else { Recovered };
        assert_eq!(board.recovery(), [OlderCopy, alarms]);
        if start == 3 {
            board.turn(121);
        } else if start > 0 {
            board.write();
        }
        flash = board.off();
    }
    assert_eq!(Board::start(flash).recovery(), RECOVERED);
}

#[test]
fn both_copies_of_a_life_damaged_is_told_of_the_life_alone() {
    use Recovery::{OlderCopy, Recovered};
    let (flash, kept) = just_used(Words::new(2));
    let mut board = Board::start(flash);
    board.turn(121);
    let flash = board.off();
    // The life is the last, and the record of a start behind it tells of it.
    let ends = flash.ends();
    let mut board = Board::start(flash);
    board.write();
    let mut flash = board.off();
    for (half, end) in ends.into_iter().enumerate() {
        flash.bytes[half * 4096 + end - 30] ^= 0x40;
    }
    for _ in 0..100 {
        // However often the halves are erased.
        let mut board = Board::start(flash);
        assert_eq!(board.found(), kept);
        assert_eq!(board.recovery(), [OlderCopy, Recovered]);
        board.write();
        flash = board.off();
    }
    assert!(flash.erased.iter().all(|times| *times > 0));
    let mut board = Board::start(flash);
    board.turn(121);
    assert_eq!(Board::start(board.off()).recovery(), RECOVERED);
}

#[test]
fn a_torn_first_copy_was_never_complete_and_a_torn_second_one_is_not_needed() {
    let (flash, _) = just_used(Words::new(2));
    let run = |power| {
        let mut board = Board::start(flash.clone().powered(Some(power)));
        board.write();
        let older = board.life.kept();
        board.life.turn(1000.0, 1.0, false, false);
        let went = board.power_fails();
        (went, older, board.life.kept(), board.off().powered(None))
    };
    // Two copies of 32 bytes, twice.
    let cases = [
        (64, false),
        (65, false),
        (86, false),
        (96, true),
        (97, true),
        (126, true),
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
        let (mut flash, kept) = if on_top {
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
            (report.life, board.found.life == kept.0),
            (board.found.alarms, board.found.start.alarms == kept.1),
        ] {
            match recovery {
                Recovery::Recovered => prop_assert!(on_top && (same || report.damaged > 0)),
                Recovery::OlderCopy => prop_assert!(on_top && report.damaged > 0),
                Recovery::Damaged => prop_assert!(report.damaged > 0),
                Recovery::Blank | Recovery::OtherVersion => {}
                Recovery::NoMemory | Recovery::OtherSpindle => prop_assert!(false),
            }
        }
        board.raise(Alarm::Overload);
        board.turn(1200);
        prop_assert_eq!(board.report().failed, 0);
        let (life, alarms) = board.now();
        let board = Board::start(board.off());
        prop_assert_eq!(board.found().1, alarms);
        prop_assert!(life.1 - board.found.life.1 <= life.1 / 8);
        prop_assert_eq!(board.recovery(), RECOVERED);
    }

    /// A byte in each half.
    #[test]
    fn two_changed_bytes_never_pass_an_older_record_for_the_newest(
        first in any::<prop::sample::Index>(), second in any::<prop::sample::Index>(),
        aligned in any::<bool>(), changes in prop::array::uniform2(1..=u8::MAX),
    ) {
        let (mut flash, kept) = just_used(Words::new(2));
        let [end, other] = flash.ends();
        prop_assert_eq!(end, other);
        let at = first.index(end);
        // Half of the cases hit the same place of both.
        let twin = if aligned { at } else { second.index(end) };
        flash.bytes[at] ^= changes[0];
        flash.bytes[4096 + twin] ^= changes[1];
        let board = Board::start(flash);
        for (recovery, same) in [
            (board.report().life, board.found.life == kept.0),
            (board.found.alarms, board.found.start.alarms == kept.1),
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
    let latched = |alarms: &[Alarm]| alarms.iter().map(|alarm| 1 << *alarm as u32).sum::<u32>();
    for _ in 0..2 {
        let board = Board::start(flash);
        let expected = latched(&[Alarm::Overload, Alarm::Slip]);
        assert_eq!(board.judgement.unacknowledged(), expected);
        let state = |alarm| board.judgement.alarm(alarm).state();
        assert_eq!(state(Alarm::Overload), AlarmState::Latched);
        assert_eq!(state(Alarm::LifeUsed), AlarmState::Clear);
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
    let expected = latched(&[Alarm::Overload]);
    assert_eq!(board.judgement.unacknowledged(), expected);
    assert_eq!(board.found.start.raised[Alarm::Overload as usize], 2);
    assert_eq!(board.found.start.raised[Alarm::Sensor as usize], 0);
}

#[test]
fn alarms_that_come_and_go_leave_the_last_quarter_to_the_life() {
    let mut board = Board::start(Memory::<4, 16384>::new(2));
    for _ in 0..4000 {
        board.raise(Alarm::Slip);
        board.stand(1);
        let acknowledged = board.judgement.acknowledge(Alarm::Slip);
        assert!(acknowledged.is_some());
        board.judgement = Judgement::default();
        board.stand(1);
    }
    assert_eq!(board.store.error(), Some(WriteError::Full));
    let written = board.report().written;
    // Of 32 to 48 bytes.
    let room = 16384 / 4 * 3;
    assert!((room / 48..=room / 32).contains(&written), "{written}");
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
        board.life.turn(1000.0, 50.0, false, false);
        board.raise(Alarm::Slip);
        let mut steps = 0;
        // Whatever else is being written.
        for busy in [0, 1, 2, 9, 40] {
            board.life.turn(1000.0, 50.0, false, false);
            board.time_us += LIFE_US;
            board.look();
            for _ in 0..busy {
                board.store.step();
            }
            board.life.turn(1000.0, 0.1, false, false);
            assert!(board.power_fails());
            let life = board.life.kept();
            board = Board::start(Board::start(board.off()).off());
            assert_eq!(board.found.life, life, "{busy}");
            assert_eq!(board.recovery()[1], Recovery::Recovered);
            assert_eq!(board.judgement.unacknowledged(), 1 << Alarm::Slip as u32);
            steps += busy;
        }
        // If the power comes back, what was left is written.
        board.raise(Alarm::Overload);
        board.time_us += LIFE_US;
        board.look();
        for _ in 0..steps {
            board.store.step();
        }
        board.power_fails();
        board.write();
        let kept = board.now();
        Board::recovers(board.off(), kept);
    }
    holds(Memory::<4, 16384>::new(2));
    holds(Memory::<32, 16384>::new(2));
}

// --- wear --------------------------------------------------------------------------------------

/// A year of eight hours a day, in two sectors of 128 KiB.
#[test]
fn a_year_of_daily_work_takes_fifty_erases_of_the_ten_thousand_that_flash_endures() {
    let mut flash = Memory::<32, 131_072>::new(2);
    let mut life = (0, 0);
    for _ in 0..365 {
        let mut board = Board::start(flash);
        assert_eq!(board.found.life, life);
        board.life.set_damage(1e-3, 0.0);
        for _ in 0..8 * 60 {
            board.turn_at_once(60);
        }
        assert_eq!(board.report().failed, 0);
        let written = board.report().written;
        assert!((130..170).contains(&written), "{written}");
        flash = board.off();
        life = Board::start(flash.clone()).found.life;
    }
    let [one, other] = flash.erased[..] else {
        panic!("two sectors");
    };
    assert!(one == other && (30..60).contains(&one), "{one} {other}");
}

/// The worst that can be done to it: a start, and a record of the life, every two minutes.
#[test]
fn power_cuts_every_two_minutes_leave_a_half_thirty_years() {
    let mut flash = Memory::<32, 131_072>::new(2);
    let starts = 2000;
    for _ in 0..starts {
        let mut board = Board::start(flash);
        board.write();
        board.life.turn(1000.0, 60.0, false, false);
        board.pass(LIFE_US / 1_000_000);
        assert_eq!((board.report().written, board.report().failed), (2, 0));
        flash = board.off();
    }
    let a_year = flash.erased[0] as f64 * 365.25 * 720.0 / f64::from(starts);
    assert!((200.0..350.0).contains(&a_year), "{a_year}");
}

/// The other bound: no restart, so that nothing is erased.
#[test]
fn ten_years_without_a_restart_find_room_and_lose_less_than_a_64th_at_any_time() {
    let (flash, _) = used(Memory::<32, 131_072>::new(2));
    let mut board = Board::start(flash);
    let began = board.life.kept().1;
    board.life.set_damage(1e-3, 0.0);
    let mut kept = began;
    for minute in 0..10 * 365 * 24 * 30_u32 {
        let written = board.report().written;
        board.turn_at_once(120);
        let now = board.life.kept().1;
        if board.report().written > written {
            kept = now;
        }
        assert!(now - kept <= (now - began) / 64, "{minute}");
    }
    assert_eq!(board.report().failed, 0);
    let written = board.report().written;
    assert!((700..780).contains(&written), "{written}");
}

#[test]
fn a_log_that_is_full_keeps_what_it_has_and_says_so() {
    let mut board = Board::start(Memory::<4, 4096>::new(1));
    while board.report().failed == 0 {
        assert!(board.time_us < 1_000_000_000_000);
        board.life.turn(1000.0, 1e7, false, false);
        board.stand(120);
    }
    assert_eq!(board.store.error(), Some(WriteError::Full));
    let written = board.report().written;
    let mut flash = board.off();
    for _ in 0..3 {
        // One sector is not erased: there is no place for what stands in it.
        let mut board = Board::start(flash);
        assert_eq!(board.report().life, Recovery::Recovered);
        board.life.turn(1000.0, 1e7, false, false);
        board.stand(120);
        assert_eq!(board.report().written, 0);
        assert!(board.report().failed > 0);
        flash = board.off();
    }
    assert!(written > 20 && flash.erased == [0]);
}

#[test]
fn worn_cells_are_left_behind_and_a_flash_that_takes_nothing_is_told_of() {
    // Turns, and says how many records were written and how many could not be.
    let turn = |flash: Words| {
        let mut board = Board::start(flash);
        board.turn_at_once(120);
        let report = board.report();
        let error = board.store.error();
        (
            board.now(),
            board.off(),
            (report.written, report.failed, error),
        )
    };
    let (mut flash, _) = just_used(Words::new(2));
    let [end, other] = flash.ends();
    // Two attempts of the first half meet one of them, and one of the second.
    flash.worn = [end + 30, end + 60, 4096 + other + 3].into();
    let (newer, flash, outcome) = turn(flash);
    assert_eq!(outcome, (2, 0, None));
    let mut flash = Board::recovers(flash, newer);

    flash.worn = (0..flash.bytes.len()).collect();
    let (_, mut flash, outcome) = turn(flash);
    assert_eq!(outcome, (0, 2, Some(WriteError::Flash)));
    flash.worn.clear();
    assert_eq!(Board::start(flash.clone()).found(), newer);
    let (newest, flash, _) = turn(flash);
    Board::recovers(flash, newest);
}

#[test]
fn a_half_that_is_worn_out_leaves_the_other_one() {
    for half in 0..2 {
        let (mut flash, mut kept) = just_used(Words::new(2));
        flash.worn = (half * 4096..(half + 1) * 4096).collect();
        for _ in 1..6 {
            let mut board = Board::start(flash);
            assert_eq!(board.found(), kept);
            board.turn_at_once(120);
            assert!(board.report().failed > 0);
            kept = board.now();
            flash = board.off();
        }
    }
}

/// A sector that cannot be erased is reported, and the other sectors are used.
#[test]
fn a_flash_that_does_not_erase_is_told_of() {
    let mut flash = Words::new(2);
    flash.bytes[4096 - 1000] = 0;
    flash.refuses_to_erase = true;
    let mut board = Board::start(flash);
    assert_eq!(board.report().failed, 2);
    assert_eq!(board.store.error(), Some(WriteError::Flash));
    board.turn_at_once(120);
    let kept = board.now();
    let board = Board::start(board.off());
    assert_eq!(board.found(), kept);
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

fn monitor(past: &Past) -> Monitor<1, 16> {
    let mut monitor = Monitor::new(Spindle::single(&BEARING), &SETTINGS).with_past(past);
    monitor.prepare(IDLE, 0.0).unwrap();
    monitor
}

/// A tick, and a unit written after it, as between the ticks of a board.
fn tick<F: NorFlash>(monitor: &mut Monitor<1, 16>, store: &mut Store<F>, time_us: u64) {
    monitor.tick(time_us, &readings(time_us), &mut NoCycles, &mut NoWatchdog);
    monitor.retain(time_us, store);
    store.step();
    while monitor.outbox().next_byte().is_some() {}
}

/// The life of a monitor that was switched off goes on as that of one that was not.
#[test]
fn a_monitor_goes_on_after_a_power_cycle_with_its_life() {
    let open = |flash| Store::open(flash, IDENTITY, ResetCause::PowerOn);
    let (mut store, past) = open(WideWords::new(2));
    let mut first = monitor(&past);
    for ms in 0..3000 {
        tick(&mut first, &mut store, ms * 1000);
    }
    assert!(first.power_fails(3_000_000, &mut store));
    let report = store.report();
    assert_eq!((report.written, report.failed), (2, 0));

    let (mut store, past) = open(store.into_flash());
    let mut other = monitor(&past);
    assert_eq!(other.life().kept(), past.life);
    assert!(past.life.1 > 0 && past.life == first.life().kept());
    // From there on as one that was not switched off.
    let (mut unkept, nothing) = open(WideWords::new(0));
    let mut without = monitor(&nothing);
    for ms in 0..3000 {
        tick(&mut other, &mut store, ms * 1000);
        tick(&mut without, &mut unkept, ms * 1000);
    }
    let (now, lived) = (other.life().kept(), without.life().kept());
    assert_eq!((now.0 - past.life.0, now.1 - past.life.1), lived);
    assert_eq!(other.health().retention.life, Recovery::Recovered);

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
    let (_, past) = open(store.into_flash());
    // A tick after the replacement has turned a little.
    assert!(past.life.1 >> 22 <= 250, "{}", past.life.1 >> 22);
}

/// The host sees it without asking: the start by its own report, the alarm among the standing ones.
#[test]
fn a_monitor_tells_of_its_start_and_of_the_alarms_before_it() {
    let mut board = Board::start(WideWords::new(2));
    board.raise(Alarm::Overload);
    board.stand(1);
    let (_, past) = Store::open(board.off(), IDENTITY, ResetCause::Watchdog);
    let mut monitor = monitor(&past);
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
                Some(Payload::Hello(report)) => starts.push(report.start),
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
    let (mut store, past) = Store::open(Words::new(0), IDENTITY, ResetCause::Watchdog);
    let start = (past.start.boots, past.start.cause);
    assert_eq!(start, (0, ResetCause::Watchdog));
    assert_eq!(past.alarms, Recovery::NoMemory);
    assert_eq!((past.life, past.start.alarms), NOTHING);
    assert_eq!(store.report(), RetentionReport::NO_MEMORY);
    assert!(!store.step() && !store.power_fails(0, &Judgement::default(), &Life::NEW));
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

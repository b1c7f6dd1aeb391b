//! What the monitor has learnt, over a power cycle: the baseline of the stiffness and the rating life used,
//! in the flash of the board.
//!
//! [`Store::open`] reads the [`Past`] before ticks begin, [`Monitor::retain`](super::Monitor::retain) sees
//! what is new, and [`Store::step`] writes it between ticks, one unit of the flash at a time. The flash is whatever
//! implements [`NorFlash`]; all of it is the store's.
//!
//! | kept | written | belongs to |
//! | --- | --- | --- |
//! | baseline | when learning has ended, or the bearing was replaced | bearing, and what idling is ([`Identity`]) |
//! | life used, revolutions | once an hour, and at a standstill after ten minutes | bearing |
//!
//! The tare is not kept: it drifts, and a shaft stands still when power comes on, so that it is taken anew.
//!
//! # Log
//!
//! Records stand one behind the other in the framing of [`framing`]: postcard, CRC-32, COBS,
//! each behind a zero of its own and filled up with zeros to [`Store::GRANULE`] bytes. What holds on a wire holds
//! here: a reader that meets a damaged piece is in step again after the next zero. Numbers tell the newest.
//!
//! - **Power lost while writing** leaves a piece without a good checksum, and what stood before it counts. So does
//!   a word that cannot be read at all, as flash with error correction leaves it.
//! - **Every unit is read back.** One that does not hold what was written is left behind, and the record is
//!   written again further on, [`ATTEMPTS`] times in all.
//! - **Any content** ends in a record or in a named [`Recovery`]. What cannot be used is erased at the start, but
//!   never before a record of each kind stands elsewhere.
//!
//! # Erasing
//!
//! It takes 1 s to 2 s for 128 KiB, and a core that executes from the same bank stands still meanwhile, longer than a
//! watchdog waits. So nothing is erased while ticks run. At the start all sectors but the newest are made blank,
//! which is work once per filled sector; from then on there is room for a sector at least. As it gets less, life is
//! written less often: half as often each time that half of the room is gone, down to a 32nd. A sector of
//! 128 KiB is good for nine months of cutting day and night without a restart. If there is no room in the end,
//! nothing is lost that was written, and [`RetentionReport::failed`] counts what is not.
//!
//! **Wear.** The shortest time between two records of the life is [`STANDSTILL_LIFE_US`]. That is 52,560 a year at
//! most, of 48 bytes, or of 64 where a unit has 32. In two sectors of 128 KiB, each is erased 13 times a
//! year then, and 10,000 erases last more than 700 years.
//!
//! # Why no library for this
//!
//! `sequential-storage` (8.0), `ekv` (1.0) and `tickv` (2.0) were looked at. The first two erase within a write, when
//! they have to. `sequential-storage` gives up where a word cannot be read, looks through a sector for each
//! item it writes, and can panic. `ekv` knows units of up to four bytes, and erases for every transaction. `tickv` wants
//! a sector's worth of RAM, writes words twice, and can panic. Framing, checksum and encoding are by libraries, as
//! everywhere in the monitor.

use super::judgement::{BANDS, Baseline, BaselineSettings, Judgement};
use super::life::Life;
use super::telemetry::{Recovery, RetentionReport};
use crate::design::{Design, FreeContact, Material};
use crate::framing::{self, CHECKSUM_LENGTH, FrameError, FrameReader};
use crc::{CRC_32_ISO_HDLC, Crc, NoTable};
pub use embedded_storage::nor_flash::NorFlash;
use heapless::Vec;
use serde::{Deserialize, Serialize};

/// Version of the format, and of the model: a baseline is that of one way to work the stiffness out.
pub const VERSION: u8 = 1;

/// While the shaft turns, life is written after this time, us.
pub const LIFE_US: u64 = 3_600_000_000;
/// At a standstill it is written when the last time is so long ago, us: most machines are switched off there.
pub const STANDSTILL_LIFE_US: u64 = 600_000_000;
/// A standstill is so long without a turn, us.
const STANDSTILL_US: u64 = 10_000_000;
/// Most halvings of how often life is written, as room gets less.
const HALVINGS: u32 = 5;
/// Time between looks at what is new, us.
const LOOK_US: u64 = 1_000_000;

/// How often a record is tried.
pub const ATTEMPTS: u8 = 3;
/// Longest unit that a flash may want, bytes.
const LONGEST_UNIT: usize = 64;
/// A number that no store gets to, at 53,000 records a year.
const LAST: u32 = u32::MAX / 2;

/// Longest message of a record, checksum included: version, number, variant and identity, then a baseline.
const MESSAGE_LENGTH: usize =
    1 + 5 + 1 + 5 + size_of::<[[f32; 5]; BANDS]>() + 5 * BANDS + CHECKSUM_LENGTH;
const FRAME_LENGTH: usize = framing::frame_length(MESSAGE_LENGTH);

/// What was kept.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Past {
    /// The baseline of the stiffness.
    pub baseline: Baseline,
    /// Life used and revolutions, as of [`Life::kept`].
    pub life: (u128, u128),
}

impl Past {
    /// That of a new bearing.
    pub const NONE: Self = Self {
        baseline: Baseline::EMPTY,
        life: (0, 0),
    };
}

/// Tells what was learnt on one spindle from what was learnt on another: checksums of all that it depends on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Identity {
    /// Of the bearing.
    bearing: u32,
    /// Of the bearing, and of when it idles in which band of speed.
    bands: u32,
}

impl Identity {
    /// That of a bearing of `balls` balls. Shoulders are no part of it, which have no part in the stiffness; nor is
    /// the load rating, by which only the life used from now on goes.
    pub const fn new(design: &Design, balls: usize, baseline: &BaselineSettings) -> Self {
        // Without a table, which would be for the compiler alone.
        const CHECKSUM: Crc<u32, NoTable> = Crc::<u32, NoTable>::new(&CRC_32_ISO_HDLC);
        let (kind, contact) = match design.free_contact {
            FreeContact::Angle(angle) => (0, angle),
            FreeContact::DiametralClearance(clearance) => (1, clearance),
        };
        const fn material(of: &Material) -> [u64; 3] {
            [
                of.youngs_modulus.to_bits(),
                of.poissons_ratio.to_bits(),
                of.density.to_bits(),
            ]
        }
        let (ring, ball) = (material(&design.ring), material(&design.ball));
        let numbers = [
            balls as u64,
            design.ball_diameter.to_bits(),
            design.pitch_diameter.to_bits(),
            design.inner_groove_factor.to_bits(),
            design.outer_groove_factor.to_bits(),
            kind,
            contact.to_bits(),
            design.first_ball.to_bits(),
            ring[0],
            ring[1],
            ring[2],
            ball[0],
            ball[1],
            ball[2],
        ];
        let mut digest = CHECKSUM.digest();
        let mut i = 0;
        while i < numbers.len() {
            digest.update(&numbers[i].to_le_bytes());
            i += 1;
        }
        let bearing = digest.finalize();
        let mut digest = CHECKSUM.digest();
        digest.update(&bearing.to_le_bytes());
        digest.update(&baseline.band_width.to_bits().to_le_bytes());
        let [low, high] = baseline.idle_axial;
        digest.update(&low.to_bits().to_le_bytes());
        digest.update(&high.to_bits().to_le_bytes());
        digest.update(&baseline.idle_radial.to_bits().to_le_bytes());
        digest.update(&baseline.idle_moment.to_bits().to_le_bytes());
        Self {
            bearing,
            bands: digest.finalize(),
        }
    }
}

/// What stands in the flash: the order of fields and variants *is* the format, as in
/// [`telemetry`](super::telemetry).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Record {
    #[serde(deserialize_with = "framing::version::<_, VERSION>")]
    version: u8,
    /// Counts records; the newest has the highest.
    number: u32,
    content: Content,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
// One at a time, and the largest must fit anyway.
#[allow(clippy::large_enum_variant)]
enum Content {
    Baseline { bands: u32, baseline: Baseline },
    Life { bearing: u32, life: (u128, u128) },
}

/// Why a record could not be written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum WriteError {
    /// The flash does not take, or does not hold, what is written.
    Flash,
    /// There is no room left until the next start.
    Full,
}

impl WriteError {
    /// What went wrong, in a few words.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Flash => "the flash does not hold what is written",
            Self::Full => "no room left until the next start",
        }
    }
}

impl core::fmt::Display for WriteError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(self.name())
    }
}

impl core::error::Error for WriteError {}

/// One kind of data, as the log has it.
#[derive(Debug, Clone, Copy)]
struct Newest<T> {
    number: u32,
    sector: u32,
    /// None if it is another spindle's.
    data: Option<T>,
}

impl<T> Newest<T> {
    /// Takes a record's place if it is no older.
    fn update(slot: &mut Option<Self>, number: u32, sector: u32, data: Option<T>) {
        if slot.as_ref().is_none_or(|newest| number >= newest.number) {
            *slot = Some(Self {
                number,
                sector,
                data,
            });
        }
    }
}

/// What a look through the whole log has found.
#[derive(Debug)]
struct Found {
    /// The newest number, and the sector where it stands.
    last: Option<(u32, u32)>,
    baseline: Option<Newest<Baseline>>,
    life: Option<Newest<(u128, u128)>>,
    /// Damaged pieces, and undamaged ones of another version.
    damaged: u16,
    foreign: u16,
}

impl Found {
    fn take(&mut self, read: Result<Record, FrameError>, sector: u32, identity: &Identity) {
        let record = match read {
            Ok(record) if record.number <= LAST => record,
            Err(FrameError::Content) => {
                self.foreign = self.foreign.saturating_add(1);
                return;
            }
            Ok(_) | Err(_) => {
                self.damaged = self.damaged.saturating_add(1);
                return;
            }
        };
        let number = record.number;
        if self.last.is_none_or(|(last, _)| number >= last) {
            self.last = Some((number, sector));
        }
        match record.content {
            Content::Baseline { bands, baseline } => {
                let own = (bands == identity.bands).then_some(baseline);
                Newest::update(&mut self.baseline, number, sector, own);
            }
            Content::Life { bearing, life } => {
                let own = (bearing == identity.bearing).then_some(life);
                Newest::update(&mut self.life, number, sector, own);
            }
        }
    }

    /// What became of one kind.
    const fn recovery<T>(&self, newest: Option<&Newest<T>>) -> Recovery {
        match newest {
            Some(Newest { data: Some(_), .. }) => Recovery::Recovered,
            Some(Newest { data: None, .. }) => Recovery::OtherSpindle,
            None if self.foreign > 0 => Recovery::OtherVersion,
            None if self.damaged > 0 => Recovery::Damaged,
            None => Recovery::Blank,
        }
    }
}

/// The log, and what is to go into it.
#[derive(Debug)]
pub struct Store<F> {
    flash: F,
    identity: Identity,
    /// Number of the next record.
    number: u32,
    /// The sector in use, and how much of it.
    sector: u32,
    used: u32,
    /// One bit for each sector that is blank.
    blank: u32,
    /// Room at the start, bytes.
    room: u32,
    /// What is kept, or will be when all that is due is written.
    past: Past,
    due: Due,
    /// The baseline could not be written; it is tried again with the life.
    owed: bool,
    /// The record that is being written, what it is of, and how much of it is done.
    frame: Vec<u8, FRAME_LENGTH>,
    writing: Due,
    done: usize,
    attempts: u8,
    report: RetentionReport,
    error: Option<WriteError>,
    /// Baselines that have been learnt, as [`Judgement::learnt`] counts them.
    learnt: u32,
    /// When to look again, when life was kept last, and since when it stands still.
    look_us: u64,
    life_us: u64,
    still: ((u128, u128), u64),
}

/// What is to be written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
struct Due {
    baseline: bool,
    life: bool,
}

impl Due {
    const NOTHING: Self = Self {
        baseline: false,
        life: false,
    };
    const ALL: Self = Self {
        baseline: true,
        life: true,
    };
}

impl<F: NorFlash> Store<F> {
    /// Bytes that a record is a multiple of.
    pub const GRANULE: usize = if F::WRITE_SIZE > 16 {
        F::WRITE_SIZE
    } else {
        16
    };
    /// What can be told at compile time of a flash that cannot hold this.
    const FITS: () = {
        assert!(
            F::WRITE_SIZE <= LONGEST_UNIT && Self::GRANULE.is_multiple_of(F::WRITE_SIZE),
            "a unit of the flash must be a power of two of bytes, 64 at most"
        );
        assert!(
            F::WRITE_SIZE.is_multiple_of(F::READ_SIZE),
            "what is written must be readable by itself"
        );
        assert!(
            F::ERASE_SIZE >= 4 * FRAME_LENGTH && F::ERASE_SIZE.is_multiple_of(Self::GRANULE),
            "a sector must hold some records"
        );
    };
    const SECTOR: u32 = F::ERASE_SIZE as u32;

    /// Reads what was kept, and makes room for what will be. Before ticks begin, since it may erase: some
    /// seconds at the most, and mostly nothing.
    ///
    /// Of what cannot be used, [`Store::report`] says why; the past is that of a new bearing then.
    pub fn open(flash: F, identity: Identity) -> (Self, Past) {
        const { Self::FITS };
        let sectors = (flash.capacity() / F::ERASE_SIZE).min(32) as u32;
        let mut store = Self {
            flash,
            identity,
            number: 0,
            sector: 0,
            used: Self::SECTOR,
            blank: 0,
            room: 0,
            past: Past::NONE,
            due: Due::NOTHING,
            owed: false,
            frame: Vec::new(),
            writing: Due::NOTHING,
            done: 0,
            attempts: 0,
            report: RetentionReport::NO_MEMORY,
            error: None,
            learnt: 0,
            look_us: 0,
            life_us: 0,
            still: ((0, 0), 0),
        };
        let mut found = Found {
            last: None,
            baseline: None,
            life: None,
            damaged: 0,
            foreign: 0,
        };
        for sector in 0..sectors {
            let used = store.look_through(sector, &mut found);
            if used == 0 {
                store.blank |= 1 << sector;
            }
            if found.last.is_some_and(|(_, at)| at == sector) {
                (store.sector, store.used) = (sector, used);
            }
        }
        if sectors > 0 {
            store.report.baseline = found.recovery(found.baseline.as_ref());
            store.report.life = found.recovery(found.life.as_ref());
            store.report.damaged = found.damaged;
        }
        if let Some(baseline) = found.baseline.as_ref().and_then(|newest| newest.data) {
            store.past.baseline = baseline;
        }
        if let Some(life) = found.life.as_ref().and_then(|newest| newest.data) {
            store.past.life = life;
        }
        store.still.0 = store.past.life;
        store.number = found.last.map_or(0, |(last, _)| last + 1);
        store.make_room(sectors, &found);
        store.room = store.room_left();
        let past = store.past;
        (store, past)
    }

    /// Blanks all sectors but the newest, and sees to it that nothing is lost by that.
    fn make_room(&mut self, sectors: u32, found: &Found) {
        let newest = found.last.map(|(_, sector)| sector);
        // Power was lost when this sector had been begun: what it lacks still stands elsewhere.
        let elsewhere = |sector: Option<u32>| sector.is_some() && sector != newest;
        let of_baseline = found.baseline.as_ref().filter(|of| of.data.is_some());
        let of_life = found.life.as_ref().filter(|of| of.data.is_some());
        let missing = Due {
            baseline: elsewhere(of_baseline.map(|of| of.sector)),
            life: elsewhere(of_life.map(|of| of.sector)),
        };
        self.due = missing;
        while self.step() {}
        if self.report.failed > 0 {
            return;
        }
        for sector in 0..sectors {
            let blank = self.blank & (1 << sector) != 0;
            if !blank && (sector != self.sector || newest.is_none()) {
                let from = sector * Self::SECTOR;
                if self.flash.erase(from, from + Self::SECTOR).is_ok() && self.is_blank(sector) {
                    self.blank |= 1 << sector;
                } else {
                    self.fail(WriteError::Flash);
                }
            }
        }
    }

    /// Takes all records of a sector; returns how much of it is in use.
    fn look_through(&mut self, sector: u32, found: &mut Found) -> u32 {
        let mut reader = FrameReader::<Record, MESSAGE_LENGTH>::new();
        let (mut used, mut within) = (0, false);
        let mut buffer = [0; LONGEST_UNIT];
        let identity = self.identity;
        for at in (0..Self::SECTOR).step_by(Self::GRANULE) {
            let Some(granule) = self.read(sector, at, &mut buffer) else {
                // Not even damaged content: what it was part of ends here.
                found.damaged = found.damaged.saturating_add(1);
                used = at + Self::GRANULE as u32;
                (reader, within) = (FrameReader::new(), false);
                continue;
            };
            let blank = granule.iter().all(|byte| *byte == 0xff);
            if !blank {
                used = at + Self::GRANULE as u32;
            }
            if blank && !within {
                continue;
            }
            for byte in granule {
                within = *byte != framing::DELIMITER;
                if let Some(read) = reader.push(*byte) {
                    found.take(read, sector, &identity);
                }
            }
        }
        if within && let Some(read) = reader.push(framing::DELIMITER) {
            found.take(read, sector, &identity);
        }
        used
    }

    fn is_blank(&mut self, sector: u32) -> bool {
        let mut buffer = [0; LONGEST_UNIT];
        (0..Self::SECTOR).step_by(Self::GRANULE).all(|at| {
            self.read(sector, at, &mut buffer)
                .is_some_and(|granule| granule.iter().all(|byte| *byte == 0xff))
        })
    }

    /// A granule, unless it cannot be read.
    fn read<'b>(
        &mut self,
        sector: u32,
        at: u32,
        buffer: &'b mut [u8; LONGEST_UNIT],
    ) -> Option<&'b [u8]> {
        let granule = buffer.get_mut(..Self::GRANULE)?;
        self.flash.read(sector * Self::SECTOR + at, granule).ok()?;
        Some(granule)
    }

    /// Room that is left, bytes.
    const fn room_left(&self) -> u32 {
        let blank = self.blank.count_ones().saturating_mul(Self::SECTOR);
        blank.saturating_add(Self::SECTOR.saturating_sub(self.used))
    }

    /// Sees what is new to be kept: what [`Monitor::retain`](super::Monitor::retain) does, with a monitor of
    /// one's own. Looks once a second, and else does nothing.
    pub fn look(&mut self, time_us: u64, judgement: &Judgement, life: &Life) {
        if time_us < self.look_us {
            return;
        }
        self.look_us = time_us.saturating_add(LOOK_US);
        let life = life.kept();
        if judgement.learnt() != self.learnt {
            self.learnt = judgement.learnt();
            self.past.baseline = *judgement.baseline();
            self.due.baseline = true;
            self.keep_life(time_us, life);
        }
        if life != self.still.0 {
            self.still = (life, time_us);
        }
        if life == self.past.life {
            return;
        }
        let since = time_us.saturating_sub(self.life_us);
        let standing = time_us.saturating_sub(self.still.1) >= STANDSTILL_US;
        let shortest = if standing {
            STANDSTILL_LIFE_US
        } else {
            LIFE_US
        };
        let halvings = (self.room / self.room_left().max(1))
            .checked_ilog2()
            .unwrap_or(0);
        if since >> halvings.min(HALVINGS) >= shortest {
            self.keep_life(time_us, life);
        }
    }

    const fn keep_life(&mut self, time_us: u64, life: (u128, u128)) {
        (self.past.life, self.life_us) = (life, time_us);
        self.due.life = true;
        self.due.baseline |= self.owed;
    }

    /// Writes the next unit ([`NorFlash::WRITE_SIZE`] bytes) of what is due; false if there is nothing to do.
    ///
    /// Takes as long as the flash does for one unit, and now and then as long as it takes to encode a record.
    pub fn step(&mut self) -> bool {
        if self.frame.is_empty() {
            return self.begin();
        }
        let mut unit = [framing::DELIMITER; LONGEST_UNIT];
        let Some(unit) = unit.get_mut(..F::WRITE_SIZE) else {
            return false;
        };
        // A zero, the frame, and zeros behind it.
        for (i, to) in (self.done..).zip(unit.iter_mut()) {
            let byte = i.checked_sub(1).and_then(|i| self.frame.get(i));
            *to = byte.copied().unwrap_or(framing::DELIMITER);
        }
        let at = self.sector * Self::SECTOR + self.used + self.done as u32;
        let mut there = [0; LONGEST_UNIT];
        let good = self.flash.write(at, unit).is_ok()
            && there
                .get_mut(..F::WRITE_SIZE)
                .is_some_and(|there| self.flash.read(at, there).is_ok() && there == unit);
        self.done += F::WRITE_SIZE;
        if good {
            if self.done >= self.length() {
                self.used += self.length() as u32;
                self.report.written = self.report.written.saturating_add(1);
                self.owed &= !self.writing.baseline;
                self.end();
            }
        } else {
            // This place is spoilt: once more behind it.
            let spoilt = self.done.next_multiple_of(Self::GRANULE);
            self.used += spoilt as u32;
            self.attempts += 1;
            if self.attempts < ATTEMPTS {
                self.due.baseline |= self.writing.baseline;
                self.due.life |= self.writing.life;
                self.frame.clear();
            } else {
                self.owed |= self.writing.baseline;
                self.end();
                self.fail(WriteError::Flash);
            }
        }
        true
    }

    /// Bytes of the record that is being written.
    fn length(&self) -> usize {
        (1 + self.frame.len()).next_multiple_of(Self::GRANULE)
    }

    /// Encodes the next record; false if none is due, or there is no room for it.
    fn begin(&mut self) -> bool {
        loop {
            let content = if self.due.baseline {
                Content::Baseline {
                    bands: self.identity.bands,
                    baseline: self.past.baseline,
                }
            } else if self.due.life {
                Content::Life {
                    bearing: self.identity.bearing,
                    life: self.past.life,
                }
            } else {
                return false;
            };
            let record = Record {
                version: VERSION,
                number: self.number,
                content,
            };
            // The lengths above make room for every record; the tests see to it.
            if framing::encode_into(&record, &mut self.frame).is_none() {
                self.due = Due::NOTHING;
                self.fail(WriteError::Flash);
                return false;
            }
            if self.length() as u32 <= Self::SECTOR.saturating_sub(self.used) {
                break;
            }
            self.frame.clear();
            let Some(next) = self.next_blank() else {
                self.owed |= self.due.baseline;
                self.due = Due::NOTHING;
                self.end();
                self.fail(WriteError::Full);
                return false;
            };
            self.blank &= !(1 << next);
            (self.sector, self.used) = (next, 0);
            // The one before it will be erased.
            self.due = Due::ALL;
        }
        self.number = self.number.saturating_add(1);
        self.done = 0;
        self.writing = Due {
            baseline: self.due.baseline,
            life: !self.due.baseline,
        };
        if self.writing.baseline {
            self.due.baseline = false;
        } else {
            self.due.life = false;
        }
        true
    }

    /// The next blank sector, around.
    const fn next_blank(&self) -> Option<u32> {
        let behind = self.blank & (u32::MAX << self.sector);
        let of = if behind != 0 { behind } else { self.blank };
        if of == 0 {
            None
        } else {
            Some(of.trailing_zeros())
        }
    }

    fn end(&mut self) {
        self.frame.clear();
        self.attempts = 0;
    }

    const fn fail(&mut self, error: WriteError) {
        self.report.failed = self.report.failed.saturating_add(1);
        self.error = Some(error);
    }

    /// What was found at the start, and what has been written since.
    pub const fn report(&self) -> RetentionReport {
        self.report
    }

    /// Why the last of the [`RetentionReport::failed`] failed.
    pub const fn error(&self) -> Option<WriteError> {
        self.error
    }

    /// The flash.
    pub fn into_flash(self) -> F {
        self.flash
    }
}

//! Log of one kind of record in flash, which holds its newest record through a power cut at any byte.
//!
//! The flash ([`NorFlash`]) is two halves of whole sectors. A half is slots of [`Log::SLOT`] bytes, filled one after the other.
//!
//! | bytes | content of a slot |
//! | --- | --- |
//! | 4 | number of the record, little-endian |
//! | [`PAYLOAD`] | payload, which the log does not look into |
//! | 4 | CRC-32 (ISO-HDLC) of number and payload |
//!
//! - **Writing.** A record goes to both halves, and the first copy is complete before the second begins. Every unit of
//!   the flash is read back. A slot that does not hold its bytes is left behind, [`ATTEMPTS`] times for a copy.
//! - **Reading.** The highest number with a good checksum wins, in either half; of equal ones the last.
//! - **Erasing** is for [`Log::open`] alone, since a core may stand still for seconds meanwhile. Erased is a half of which
//!   more than half is in use. Erased, too, is a half without a record, where the other one has the newest:
//!   an erase that power interrupts may look complete.
//! - **The good copy stays.** Where there is a record, a half is erased only after the newest was read in the other one. So the
//!   second half waits until the first has its copy. A failed erase counts for nothing: what it leaves is looked through again.
//! - **Power cuts.** A cut in the first copy leaves the record before it, a later cut the record itself.
//! - **Damage** to one copy loses nothing: the next start makes the copy again. Where both copies of the newest record are
//!   damaged, the newest undamaged record goes on.
//!
//! `sequential-storage` (8.0), `ekv` (1.0) and `tickv` (2.0) do not fit: the first two erase within a write, and the first
//! and the last can panic.

use crate::framing::{CHECKSUM, CHECKSUM_LENGTH};
pub use embedded_storage::nor_flash::NorFlash;

/// Bytes of a record's payload.
pub const PAYLOAD: usize = 88;
/// Attempts to write a copy.
pub const ATTEMPTS: u8 = 3;

/// Bytes of a record: number, payload, checksum.
const RECORD: usize = size_of::<u32>() + PAYLOAD + CHECKSUM_LENGTH;
/// Longest unit that a flash may write, bytes.
const LONGEST_UNIT: usize = 64;
/// Length of a slot of such units, bytes.
const LONGEST_SLOT: usize = RECORD.next_multiple_of(LONGEST_UNIT);

/// Why a copy could not be written, or a half not be erased.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum WriteError {
    /// The flash does not take, or does not hold, what is written.
    Flash,
    /// There is no room left until the next start.
    Full,
}

impl WriteError {
    /// The error in a few words.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Flash => "the flash does not hold what is written",
            Self::Full => "no room left until the next start",
        }
    }
}

/// Counts since the log was opened.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counts {
    /// Slots in use without a good record.
    pub damaged: u16,
    /// Copies written and read back.
    pub written: u32,
    /// Copies that could not be written, and halves that could not be erased.
    pub failed: u32,
    /// Reason of the last failure.
    pub error: Option<WriteError>,
}

#[derive(Debug, Clone, Copy)]
enum Half {
    First,
    Second,
}

const HALVES: [Half; 2] = [Half::First, Half::Second];

/// The log.
#[derive(Debug)]
pub struct Log<F> {
    flash: F,
    /// Length of a half, bytes; 0 without a memory.
    half: u32,
    /// Slots in use of each half.
    used: [u32; 2],
    /// The newest record, or the one that is being written, and its number; 0 for none.
    record: [u8; RECORD],
    number: u32,
    /// Halves that it still goes to.
    copies: [bool; 2],
    /// Bytes of this copy that are written, and attempts that ended.
    done: usize,
    attempts: u8,
    counts: Counts,
}

impl<F: NorFlash> Log<F> {
    /// Bytes of a slot.
    pub const SLOT: usize = RECORD.next_multiple_of(F::WRITE_SIZE);
    /// Checks at compile time that the flash can hold the log.
    const FITS: () = {
        assert!(
            F::WRITE_SIZE <= LONGEST_UNIT && F::WRITE_SIZE.is_power_of_two(),
            "a unit of the flash must be a power of two of bytes, 64 at most"
        );
        assert!(
            F::WRITE_SIZE.is_multiple_of(F::READ_SIZE),
            "what is written must be readable by itself"
        );
        assert!(
            F::ERASE_SIZE >= 8 * Self::SLOT,
            "a sector must hold some records"
        );
    };

    /// Reads the newest payload, completes its copies, and erases superseded records where they are many. A flash of
    /// less than two sectors is no memory.
    pub fn open(flash: F) -> (Self, Option<[u8; PAYLOAD]>) {
        const { Self::FITS };
        let capacity = flash.capacity().min(u32::MAX as usize);
        let mut log = Self {
            flash,
            half: (capacity / 2 / F::ERASE_SIZE * F::ERASE_SIZE) as u32,
            used: [0; 2],
            record: [0; RECORD],
            number: 0,
            copies: [false; 2],
            done: 0,
            attempts: 0,
            counts: Counts::default(),
        };
        let [first, second] = HALVES.map(|half| log.look_through(half));
        let mut order = [
            (Half::First, Half::Second, first),
            (Half::Second, Half::First, second),
        ];
        // A half that lacks the newest record comes first: it is copied there before the other half may go.
        if log.holds(Half::First) {
            order.reverse();
        }
        for (half, other, has_records) in order {
            log.tidy(half, other, has_records);
        }
        let payload = log.record.get(size_of::<u32>()..);
        let payload = payload.and_then(|bytes| bytes.first_chunk()).copied();
        let payload = payload.filter(|_| log.number > 0);
        // A torn record has a number, too, and may read well another time.
        log.number = log.number.saturating_add(log.counts.damaged.into());
        (log, payload)
    }

    /// Erases a half that has too many superseded records or none, and copies the newest record there.
    fn tidy(&mut self, half: Half, other: Half, has_records: bool) {
        let known = self.number > 0;
        let crowded = self.used[half as usize] > self.slots() / 2;
        if (crowded || (known && !has_records)) && (!known || self.holds(other)) {
            self.erase(half);
        }
        if known && !self.holds(half) {
            self.copies[half as usize] = true;
            while self.step() {}
        }
    }

    /// Erases a half, and looks at what is left.
    fn erase(&mut self, half: Half) {
        let from = self.place(half, 0);
        let erased = self.flash.erase(from, from + self.half).is_ok();
        self.look_through(half);
        if !erased || self.used[half as usize] > 0 {
            self.fail(WriteError::Flash);
        }
    }

    /// Takes the newest record of a half if it is newer, and counts the slots in use. Whether there is any good record.
    fn look_through(&mut self, half: Half) -> bool {
        let (mut used, mut has_records) = (0, false);
        for slot in 0..self.slots() {
            let bytes = self.read(half, slot);
            if bytes.is_some_and(|bytes| bytes.iter().all(|byte| *byte == 0xff)) {
                continue;
            }
            used = slot + 1;
            let Some((number, record)) = bytes.as_ref().and_then(record_in) else {
                self.counts.damaged = self.counts.damaged.saturating_add(1);
                continue;
            };
            has_records = true;
            // The last number may be there more than once: no later one is left.
            if number >= self.number {
                (self.number, self.record) = (number, record);
            }
        }
        self.used[half as usize] = used;
        has_records
    }

    /// Reads a half for the newest record; whether it is there.
    fn holds(&mut self, half: Half) -> bool {
        let record = self.record;
        let mut slots = (0..self.used[half as usize]).rev();
        self.number > 0
            && slots.any(|slot| {
                let bytes = self.read(half, slot);
                bytes.is_some_and(|bytes| bytes.starts_with(&record))
            })
    }

    /// Reads a slot, with erased bytes behind it; `None` if the flash cannot.
    fn read(&mut self, half: Half, slot: u32) -> Option<[u8; LONGEST_SLOT]> {
        let mut bytes = [0xff; LONGEST_SLOT];
        let at = self.place(half, slot);
        self.flash.read(at, bytes.get_mut(..Self::SLOT)?).ok()?;
        Some(bytes)
    }

    const fn place(&self, half: Half, slot: u32) -> u32 {
        half as u32 * self.half + slot * Self::SLOT as u32
    }

    const fn slots(&self) -> u32 {
        self.half / Self::SLOT as u32
    }

    /// Begins a record; [`Log::step`] writes it. A record that is being written is left as it is.
    pub fn begin(&mut self, payload: &[u8; PAYLOAD]) {
        if self.half == 0 {
            return;
        }
        if let Some(half) = self.half_to_write()
            && self.done > 0
        {
            self.used[half as usize] += 1;
        }
        self.number = self.number.saturating_add(1);
        let number = self.number.to_le_bytes();
        let mut digest = CHECKSUM.digest();
        digest.update(&number);
        digest.update(payload);
        let checksum = digest.finalize().to_le_bytes();
        let bytes = number.iter().chain(payload).chain(&checksum);
        for (to, from) in self.record.iter_mut().zip(bytes) {
            *to = *from;
        }
        (self.copies, self.done, self.attempts) = ([true; 2], 0, 0);
    }

    /// Writes the next unit ([`NorFlash::WRITE_SIZE`] bytes) of a record; false if there is nothing to do.
    pub fn step(&mut self) -> bool {
        let Some(half) = self.half_to_write() else {
            return false;
        };
        let slot = self.used[half as usize];
        if slot >= self.slots() {
            self.end_copy(half, Err(WriteError::Full));
            return true;
        }
        let (mut unit, mut there) = ([0xff; LONGEST_UNIT], [0; LONGEST_UNIT]);
        let (Some(unit), Some(there)) = (
            unit.get_mut(..F::WRITE_SIZE),
            there.get_mut(..F::WRITE_SIZE),
        ) else {
            return false;
        };
        for (to, from) in unit.iter_mut().zip(self.record.iter().skip(self.done)) {
            *to = *from;
        }
        let at = self.place(half, slot) + self.done as u32;
        let good = self.flash.write(at, unit).is_ok()
            && self.flash.read(at, there).is_ok()
            && there == unit;
        self.done += F::WRITE_SIZE;
        if good && self.done < RECORD {
            return true;
        }
        self.used[half as usize] += 1;
        (self.done, self.attempts) = (0, self.attempts + 1);
        if good {
            self.end_copy(half, Ok(()));
        } else if self.attempts >= ATTEMPTS {
            self.end_copy(half, Err(WriteError::Flash));
        }
        true
    }

    const fn end_copy(&mut self, half: Half, end: Result<(), WriteError>) {
        self.copies[half as usize] = false;
        self.attempts = 0;
        match end {
            Ok(()) => self.counts.written = self.counts.written.saturating_add(1),
            Err(error) => self.fail(error),
        }
    }

    fn half_to_write(&self) -> Option<Half> {
        let mut halves = HALVES.into_iter();
        halves.find(|half| self.copies[*half as usize])
    }

    const fn fail(&mut self, error: WriteError) {
        self.counts.failed = self.counts.failed.saturating_add(1);
        self.counts.error = Some(error);
    }

    /// Whether a record is being written.
    pub fn is_writing(&self) -> bool {
        self.half_to_write().is_some()
    }

    /// Whether there are two halves.
    pub const fn has_memory(&self) -> bool {
        self.half > 0
    }

    /// Counts since the log was opened.
    pub const fn counts(&self) -> Counts {
        self.counts
    }

    /// The flash.
    pub fn into_flash(self) -> F {
        self.flash
    }
}

/// The record in a slot and its number, if its checksum is right.
fn record_in(slot: &[u8; LONGEST_SLOT]) -> Option<(u32, [u8; RECORD])> {
    let record: &[u8; RECORD] = slot.first_chunk()?;
    let (content, checksum) = record.split_last_chunk()?;
    let (number, _) = content.split_first_chunk()?;
    let number = u32::from_le_bytes(*number);
    let good = CHECKSUM.checksum(content) == u32::from_le_bytes(*checksum);
    (good && number > 0).then_some((number, *record))
}

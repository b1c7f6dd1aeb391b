//! Data that the monitor keeps over a power cycle: life used, alarms, number of starts.
//!
//! All of it is in the flash of the board. [`Store::open`] reads the [`Past`] before ticks begin.
//! [`Monitor::retain`](super::Monitor::retain) sees changes, and [`Store::step`] writes them between ticks, one unit of
//! the flash at a time. The flash is whatever implements [`NorFlash`]; all of it is the store's.
//!
//! | kept | written | belongs to |
//! | --- | --- | --- |
//! | life used, revolutions | every two minutes, if either has grown by a 64th of its growth since the start | spindle ([`Identity`]) |
//! | alarms not acknowledged, times raised | within a second, 10 s apart | spindle |
//! | number of starts, cause of the reset | at every start, with the alarms | board |
//!
//! The tare is not kept: it drifts, and a shaft stands still when power comes on, so that it is taken again.
//!
//! **A power cut loses** the larger of two lives: the one used in two minutes, and a 64th of the one used since the
//! start. With a cut every nine minutes, that is a ninth. Cuts every two minutes lose everything. A board that is
//! warned of the cut loses nothing: see [`Store::power_fails`].
//!
//! # Log
//!
//! The flash is two halves, of one sector or more. Every record is written to both: the first copy is complete
//! before the second one begins. A flash of one sector has both copies one behind the other.
//!
//! Records stand one behind the other in the framing of [`framing`]: postcard, CRC-32, COBS. Each is
//! behind a zero of its own and filled up with zeros to [`Store::GRANULE`] bytes. As on a wire,
//! a reader that meets a damaged piece is in step again after the next zero. Numbers tell the newest.
//!
//! - **One damaged copy** loses nothing. At the next start the other one is copied to where it is missing.
//! - **Both copies damaged** is [`Recovery::OlderCopy`], if an older record of the kind can be read. Every record
//!   has the numbers of the newest ones of all kinds before it: one that is nowhere to be found was lost. The newest
//!   record of all is told of by none. So it counts as lost if *both* halves have a damaged piece behind the newest number
//!   that they hold. Nobody knows its kind: all kinds are older copies then, until they are written again.
//! - **Power lost while writing** leaves a damaged piece in the first half and none in the second. Then the record was
//!   never complete: the one before it is the newest, and is [`Recovery::Recovered`]. Or it leaves a good record in the
//!   first half and a damaged piece in the second. Then the record is the newest.
//! - **Not told apart**: power lost between the two copies, and the first one damaged before the next start. That looks
//!   as if it had never been complete. In a flash of one sector, two copies must have gone bad behind a pair of good ones.
//! - **Every unit is read back.** A unit that does not hold its bytes is left behind. The copy is
//!   written again further on, [`ATTEMPTS`] times in all.
//! - **Any content** ends in a record or in a named [`Recovery`].
//!
//! # Other designs and versions
//!
//! A record of another spindle or of another version is left alone: it is neither read nor superseded. Whoever wrote it finds it again, newest number and all. Every version begins its records with
//! version, number, kind and identity, so that all versions can tell each other's kinds.
//!
//! Where a half is erased, the newest record of each foreign kind is copied along, byte by byte. [`FOREIGN`] kinds
//! fit, which is eight other spindles. With more of them, no half is erased any more
//! ([`WriteError::Crowded`]): the log fills up, and then takes no more ([`WriteError::Full`]). Erasing the whole flash is the
//! way out. A record of another version that is longer than [`LONGEST_FOREIGN`] bytes counts as damage.
//!
//! # Erasing
//!
//! It takes 1 s to 2 s for 128 KiB. A core that executes from the same bank stands still meanwhile, longer than a
//! watchdog waits. So nothing is erased while ticks run. If half of a half is superseded at the start, each half in turn
//! is erased, and filled with the other one's newest records. At any time one half has them all.
//!
//! **How long the log lasts.** There is room for 1,000 records at every start, in halves of 128 KiB. Since life is
//! written in proportion, a year of cutting day and night without a restart takes 600 of them. They come every two
//! minutes in the first two hours, every 22 minutes after a day, every 11 hours after a month. Ten years take 740. The
//! last quarter of a half is for the life alone. If there is no room in the end, no written record is lost, and
//! [`RetentionReport::failed`] counts the others.
//!
//! **Wear.** A record of the life or of a start has 32 to 48 bytes. A day's work with a start in the morning and
//! eight hours of turning is 150 records of the life. Half of a half is full in a week: 50 erases a year, 200
//! years for 10,000. At worst, power is cut every two minutes, day and night. Then a half is erased 300 times a
//! year, and lasts for 30 years. A board that resets itself every second lasts for four months.
//!
//! # Why no library for this
//!
//! `sequential-storage` (8.0), `ekv` (1.0) and `tickv` (2.0) were looked at. The first two erase within a write, when
//! they have to. `sequential-storage` gives up where a word cannot be read, looks through a sector for each
//! item it writes, and can panic. `ekv` knows units of up to four bytes, and erases for every transaction. `tickv` wants
//! a sector's worth of RAM, writes words twice, and can panic. Framing, checksum and encoding are by libraries, as
//! everywhere in the monitor.

use super::board::ResetCause;
use super::judgement::{Alarm, Judgement};
use super::life::Life;
use super::telemetry::{Recovery, RetentionReport, StartReport};
use crate::framing::{self, CHECKSUM_LENGTH, DELIMITER, FrameReader};
use crate::{Design, Facing, FreeContact, Material};
use crc::{CRC_32_ISO_HDLC, Crc, NoTable};
pub use embedded_storage::nor_flash::NorFlash;
use heapless::Vec;
use serde::{Deserialize, Serialize};

/// Version of the format. Alarms are kept by their place in [`Alarm::ALL`].
pub const VERSION: u8 = 4;

/// Shortest time between two records of the life, us.
pub const LIFE_US: u64 = 120_000_000;
/// Life is written again when it has grown by this part of its growth since the start. A power cut
/// loses a 64th at most, and the number of records grows with the logarithm of time: `64 (1 + ln(t / 128 min))`.
const PART: u64 = 64;
/// Shortest time between two records of the alarms, us.
pub const ALARMS_US: u64 = 10_000_000;
/// Time between looks at new data, us.
const LOOK_US: u64 = 1_000_000;

/// How often a copy is tried.
pub const ATTEMPTS: u8 = 3;
/// Kinds of records of other spindles and versions that are carried along: two for each spindle.
pub const FOREIGN: usize = 16;
/// Longest message of another version that is carried along, bytes, checksum included. It is over twice the longest of any
/// version so far.
pub const LONGEST_FOREIGN: usize = 1024;
/// Longest unit that a flash may want, bytes.
const LONGEST_UNIT: usize = 64;
/// A number that no store gets to, at two million records a year.
const LAST: u32 = u32::MAX / 2;

/// Kinds of records.
const KINDS: usize = 2;

/// Longest message of a record, checksum included. It has version, number, kind and identity, a start, and the numbers of
/// the newest.
const MESSAGE_LENGTH: usize =
    1 + 5 + 1 + 5 + (5 + 1 + 5 + 3 * Alarm::COUNT) + 5 * KINDS + CHECKSUM_LENGTH;
const FRAME_LENGTH: usize = framing::frame_length(LONGEST_FOREIGN);
const _: () = assert!(MESSAGE_LENGTH <= LONGEST_FOREIGN);

/// Record of a start, and of the alarms since.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Start {
    /// Starts so far, this one included; 0 without a memory.
    pub boots: u32,
    /// Why this start was.
    pub cause: ResetCause,
    /// Alarms that nobody had acknowledged when the power went, as [`Judgement::unacknowledged`] has them.
    pub alarms: u32,
    /// How often each alarm was raised in all starts, in the order of [`Alarm::ALL`]. A count that an alarm raised again
    /// without any other change of the alarms is written with the life.
    pub raised: [u16; Alarm::COUNT],
}

impl Start {
    const NONE: Self = Self {
        boots: 0,
        cause: ResetCause::Unknown,
        alarms: 0,
        raised: [0; Alarm::COUNT],
    };
}

/// Data kept from earlier starts.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Past {
    /// Life used and revolutions, as of [`Life::kept`].
    pub life: (u64, u64),
    /// This start, with the alarms of those before.
    pub start: Start,
    /// Recovery of the alarms.
    pub alarms: Recovery,
}

impl Past {
    /// Past of a new bearing, without a memory.
    pub const NONE: Self = Self {
        life: (0, 0),
        start: Start::NONE,
        alarms: Recovery::NoMemory,
    };

    /// Past of a board without a memory, which knows why it started.
    pub const fn without_memory(cause: ResetCause) -> Self {
        let mut past = Self::NONE;
        past.start.cause = cause;
        past
    }

    /// Report of the start, for the telemetry.
    pub const fn report(&self) -> StartReport {
        let Start {
            boots,
            cause,
            alarms,
            raised,
        } = self.start;
        StartReport {
            boots,
            cause,
            recovery: self.alarms,
            alarms,
            raised,
        }
    }
}

/// Identity of a spindle, which tells its data from another's: a checksum of all that they depend on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Identity(u32);

impl Identity {
    /// Identity of a bearing of `balls` balls. Shoulders and load rating are left out: only alarms and
    /// life from now on go by them.
    pub const fn new(design: &Design, balls: usize) -> Self {
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
        Self(digest.finalize())
    }

    /// Identity of such bearings on a shaft: the rows' positions (m), facings and preload (N).
    #[must_use]
    pub const fn mounted<const R: usize>(
        self,
        positions: &[f64; R],
        facings: &[Facing; R],
        preload: f64,
    ) -> Self {
        const CHECKSUM: Crc<u32, NoTable> = Crc::<u32, NoTable>::new(&CRC_32_ISO_HDLC);
        let mut digest = CHECKSUM.digest();
        digest.update(&self.0.to_le_bytes());
        digest.update(&preload.to_bits().to_le_bytes());
        let mut row = 0;
        while row < R {
            digest.update(&positions[row].to_bits().to_le_bytes());
            digest.update(facings[row].name().as_bytes());
            row += 1;
        }
        Self(digest.finalize())
    }
}

/// Record in the flash: the order of fields and variants *is* the format, as in
/// [`telemetry`](super::telemetry). All versions begin as [`Prefix`] does.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Record {
    #[serde(deserialize_with = "framing::version::<_, VERSION>")]
    version: u8,
    /// Counts records; the newest has the highest.
    number: u32,
    content: Content,
    /// Numbers of the newest record of each kind before this one, whatever its identity; 0 for none.
    latest: [u32; KINDS],
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
enum Content {
    Life { spindle: u32, life: (u64, u64) },
    Start { spindle: u32, start: Start },
}

/// How a record of any version begins: version, number, kind and identity.
type Prefix = (u8, u32, u32, u32);

/// Kind of a record's content.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Life,
    Start,
}

impl Kind {
    const ALL: [Self; KINDS] = [Self::Life, Self::Start];
}

/// Why a record could not be written, or a half could not be erased.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum WriteError {
    /// The flash does not take, or does not hold, written bytes.
    Flash,
    /// There is no room left until the next start.
    Full,
    /// There are records of more other spindles and versions than are carried along: nothing is erased.
    Crowded,
}

impl WriteError {
    /// The error in a few words.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Flash => "the flash does not hold what is written",
            Self::Full => "no room left until the next start",
            Self::Crowded => "records of too many other spindles: erase the whole flash",
        }
    }
}

impl core::fmt::Display for WriteError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(self.name())
    }
}

impl core::error::Error for WriteError {}

/// A half of the flash. One that has a single sector has the first half only.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Half {
    First,
    Second,
}

impl Half {
    const ALL: [Self; 2] = [Self::First, Self::Second];

    const fn other(self) -> Self {
        match self {
            Self::First => Self::Second,
            Self::Second => Self::First,
        }
    }

    /// This half alone.
    const fn alone(self) -> &'static [Self] {
        match self {
            Self::First => &[Self::First],
            Self::Second => &[Self::Second],
        }
    }
}

/// Where a frame stands in its half, and its length, delimiter included.
#[derive(Debug, Clone, Copy)]
struct Place {
    at: u32,
    length: u32,
}

/// The newest record of a kind.
#[derive(Debug, Clone, Copy)]
struct Newest {
    /// Version, kind, identity.
    key: (u8, u32, u32),
    number: u32,
    /// Its copy in each half.
    places: [Option<Place>; 2],
}

impl Newest {
    /// Takes a record in, unless it is older.
    fn update(&mut self, number: u32, half: Half, place: Place) -> bool {
        if number < self.number {
            return false;
        }
        if number > self.number {
            (self.number, self.places) = (number, [None; 2]);
        }
        self.places[half as usize] = Some(place);
        true
    }

    /// Whether only the other half has it.
    const fn is_lacking(&self, half: Half) -> bool {
        self.places[half as usize].is_none() && self.places[half.other() as usize].is_some()
    }
}

/// Records found by a look through the whole log.
#[derive(Debug)]
struct Found {
    identity: Identity,
    /// The newest number of all, and how many copies there are of it.
    last: (u32, u8),
    /// The numbers of each kind that the newest record of this version tells of, and its own.
    told: (u32, [u32; KINDS]),
    /// The newest numbers that can be read of each kind, whatever their identity.
    readable: [u32; KINDS],
    /// This spindle's records, and their content.
    own: [Option<Newest>; KINDS],
    life: (u64, u64),
    start: Start,
    /// All others, and whether there are more than these.
    foreign: Vec<Newest, FOREIGN>,
    crowded: bool,
    /// There are records of another spindle, kind by kind, and of another version.
    other_spindle: [bool; KINDS],
    other_version: bool,
    /// Damaged pieces, and those behind the newest number of each half.
    damaged: u16,
    tail: [u16; 2],
    newest: [u32; 2],
    /// Where the zeros end behind the last good record of each half.
    ends: [u32; 2],
}

impl Found {
    const fn nothing(identity: Identity) -> Self {
        Self {
            identity,
            last: (0, 0),
            told: (0, [0; KINDS]),
            readable: [0; KINDS],
            own: [None; KINDS],
            life: (0, 0),
            start: Start::NONE,
            foreign: Vec::new(),
            crowded: false,
            other_spindle: [false; KINDS],
            other_version: false,
            damaged: 0,
            tail: [0; 2],
            newest: [0; 2],
            ends: [0; 2],
        }
    }

    /// Takes a damaged piece that begins there.
    fn damage(&mut self, half: Half, at: u32) {
        self.damaged = self.damaged.saturating_add(1);
        // What the zeros behind a record have become is none of another one.
        let behind = u16::from(at >= self.ends[half as usize]);
        let tail = &mut self.tail[half as usize];
        *tail = tail.saturating_add(behind);
    }

    /// Takes an undamaged message, and the place where the zeros behind it end.
    fn take(&mut self, message: &[u8], half: Half, place: Place, end: u32) {
        let record = framing::decode::<Record>(message);
        // One that does not begin as all do is a kind of its own.
        let unknown = (message.first().copied().unwrap_or(0), 0, u32::MAX, 0);
        let prefix = postcard::take_from_bytes::<Prefix>(message);
        let (version, number, kind, identity) = prefix.map_or(unknown, |(prefix, _)| prefix);
        if number > LAST && record.is_ok() {
            self.damage(half, place.at);
            return;
        }
        let number = if number > LAST { 0 } else { number };
        if number > self.last.0 {
            self.last = (number, 0);
        }
        if number == self.last.0 {
            self.last.1 = self.last.1.saturating_add(1);
        }
        self.ends[half as usize] = end;
        if number >= self.newest[half as usize] {
            (self.newest[half as usize], self.tail[half as usize]) = (number, 0);
        }
        let key = (version, kind, identity);
        let Ok(record) = record else {
            self.other_version = true;
            self.take_foreign(key, number, half, place);
            return;
        };
        if number >= self.told.0 {
            self.told = (number, record.latest);
        }
        let (kind, own) = match record.content {
            Content::Life { spindle, .. } => (Kind::Life, spindle == self.identity.0),
            Content::Start { spindle, start } => {
                self.start.boots = self.start.boots.max(start.boots);
                (Kind::Start, spindle == self.identity.0)
            }
        };
        let readable = &mut self.readable[kind as usize];
        *readable = number.max(*readable);
        if !own {
            self.other_spindle[kind as usize] = true;
            self.take_foreign(key, number, half, place);
            return;
        }
        let newest = self.own[kind as usize].get_or_insert(Newest {
            key,
            number,
            places: [None; 2],
        });
        if newest.update(number, half, place) {
            match record.content {
                Content::Life { life, .. } => self.life = life,
                Content::Start { start, .. } => {
                    (self.start.alarms, self.start.raised) = (start.alarms, start.raised);
                }
            }
        }
    }

    fn take_foreign(&mut self, key: (u8, u32, u32), number: u32, half: Half, place: Place) {
        if let Some(newest) = self.foreign.iter_mut().find(|newest| newest.key == key) {
            newest.update(number, half, place);
            return;
        }
        let mut places = [None; 2];
        places[half as usize] = Some(place);
        let newest = Newest {
            key,
            number,
            places,
        };
        self.crowded |= self.foreign.push(newest).is_err();
    }

    /// All that is to stay.
    fn all(&self) -> impl Iterator<Item = &Newest> {
        self.own.iter().flatten().chain(&self.foreign)
    }

    fn all_mut(&mut self) -> impl Iterator<Item = &mut Newest> {
        self.own.iter_mut().flatten().chain(&mut self.foreign)
    }

    /// Both copies of the newest record of all are damaged.
    const fn newest_is_lost(&self, halves: usize) -> bool {
        match halves {
            // A torn copy is one piece, and the second copy of a pair is behind the first one.
            1 => self.last.1 != 1 && self.tail[0] >= 2,
            _ => self.tail[0] > 0 && self.tail[1] > 0,
        }
    }

    /// Recovery of one kind of record.
    fn recovery(&self, kind: Kind, older: bool) -> Recovery {
        match self.own[kind as usize] {
            Some(_) if older => Recovery::OlderCopy,
            Some(_) => Recovery::Recovered,
            None if self.other_spindle[kind as usize] => Recovery::OtherSpindle,
            None if self.other_version => Recovery::OtherVersion,
            None if self.damaged > 0 => Recovery::Damaged,
            None => Recovery::Blank,
        }
    }
}

/// The log, and the data that are to go into it.
#[derive(Debug)]
pub struct Store<F> {
    flash: F,
    identity: Identity,
    /// Number of the next record, and numbers of the newest record of each kind.
    number: u32,
    latest: [u32; KINDS],
    /// Halves that there are, the length of one, and how much of it is in use.
    halves: usize,
    half: u32,
    used: [u32; 2],
    /// Data in the log once all due records are written.
    past: Past,
    due: Due,
    /// Records that could not be written: tried again with the life.
    owed: Due,
    /// The record that is being written, its number and kind if it is a new one, and the halves that it still goes to.
    frame: Vec<u8, FRAME_LENGTH>,
    writing: Option<(u32, Kind)>,
    copies: &'static [Half],
    /// How much of this copy is done, how often it was tried, and whether another one stands or failed.
    done: usize,
    attempts: u8,
    stands: bool,
    missed: bool,
    report: RetentionReport,
    error: Option<WriteError>,
    /// When to look again, when life was kept last, and when alarms may be kept again.
    look_us: u64,
    life_us: u64,
    alarms_us: u64,
    /// Life at the start, and how often alarms had been raised.
    began: (u64, u64),
    raised: [u16; Alarm::COUNT],
}

/// Records to be written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
struct Due {
    life: bool,
    start: bool,
}

impl Due {
    const NOTHING: Self = Self {
        life: false,
        start: false,
    };

    /// The first that is due.
    const fn first(self) -> Option<Kind> {
        if self.life {
            Some(Kind::Life)
        } else if self.start {
            Some(Kind::Start)
        } else {
            None
        }
    }

    const fn set(&mut self, kind: Kind, due: bool) {
        match kind {
            Kind::Life => self.life = due,
            Kind::Start => self.start = due,
        }
    }
}

impl<F: NorFlash> Store<F> {
    /// Bytes that a record is a multiple of.
    pub const GRANULE: usize = if F::WRITE_SIZE > 16 {
        F::WRITE_SIZE
    } else {
        16
    };
    /// Checks at compile time that the flash can hold the log.
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
            F::ERASE_SIZE >= 8 * MESSAGE_LENGTH && F::ERASE_SIZE.is_multiple_of(Self::GRANULE),
            "a sector must hold some records"
        );
    };

    /// Reads the kept data, and makes room for new records. Before ticks begin, since it may erase: some
    /// seconds at the most, and mostly nothing. `cause` is the cause of this start by the hardware. It is kept, with the
    /// number of starts, once [`Store::step`] is called.
    ///
    /// [`Store::report`] says why data cannot be used; the past is a new bearing's then.
    pub fn open(flash: F, identity: Identity, cause: ResetCause) -> (Self, Past) {
        const { Self::FITS };
        let most = u32::MAX as usize / F::ERASE_SIZE;
        let sectors = (flash.capacity() / F::ERASE_SIZE).min(most);
        let mut store = Self {
            flash,
            identity,
            number: 0,
            latest: [0; KINDS],
            halves: sectors.min(2),
            half: ((sectors / 2).max(1) * F::ERASE_SIZE) as u32,
            used: [0; 2],
            past: Past::NONE,
            due: Due::NOTHING,
            owed: Due::NOTHING,
            frame: Vec::new(),
            writing: None,
            copies: &[],
            done: 0,
            attempts: 0,
            stands: false,
            missed: false,
            report: RetentionReport::NO_MEMORY,
            error: None,
            look_us: 0,
            life_us: 0,
            alarms_us: 0,
            began: (0, 0),
            raised: [0; Alarm::COUNT],
        };
        if store.halves == 0 {
            store.past = Past::without_memory(cause);
            return (store, Past::without_memory(cause));
        }
        let mut found = store.look_through();
        store.recall(&found, cause);
        let all = [store.report.life, store.past.alarms];
        if all.contains(&Recovery::OlderCopy) && store.room() > store.half / 2 {
            // Before the damaged pieces go that tell of it.
            store.due.start = true;
            while store.step() {}
            found = store.look_through();
        }
        store.tidy(&mut found);
        store.due.start = true;
        let past = store.past;
        (store, past)
    }

    /// Takes the past from the records found in the log.
    fn recall(&mut self, found: &Found, cause: ResetCause) {
        let lost = found.newest_is_lost(self.halves);
        let mut older = [lost; KINDS];
        self.latest = found.readable;
        let told = found.told.1.iter().zip(&mut older);
        for (latest, (told, older)) in self.latest.iter_mut().zip(told) {
            *older |= *told > *latest;
            // One that nobody can read, until a newer one is written.
            *latest = latest.saturating_add(u32::from(lost)).max(*told);
        }
        self.number = found.last.0.saturating_add(1);
        let recovery = |kind: Kind| found.recovery(kind, older[kind as usize]);
        self.report.life = recovery(Kind::Life);
        self.report.damaged = found.damaged;
        self.past = Past {
            life: found.life,
            start: Start {
                boots: found.start.boots.saturating_add(1),
                cause,
                ..found.start
            },
            alarms: recovery(Kind::Start),
        };
        self.began = found.life;
        self.raised = found.start.raised;
    }

    /// Gives all records that are to stay two copies, and erases superseded ones where they are many.
    fn tidy(&mut self, found: &mut Found) {
        if self.halves < 2 {
            // Nothing is lost by that, and nothing else can be erased.
            if found.all().next().is_none() && self.used[0] > 0 && self.erase(Half::First) {
                self.used[0] = 0;
            }
            return;
        }
        for half in Half::ALL {
            self.fill(half, found);
        }
        let granule = Self::GRANULE as u32;
        let carried: u32 = found
            .all()
            .filter_map(|newest| newest.places.iter().flatten().next())
            .map(|place| (1 + place.length).next_multiple_of(granule))
            .sum();
        let superseded = |used: &u32| used.saturating_sub(carried) >= self.half / 2;
        if self.used.iter().any(superseded) {
            if found.crowded {
                self.fail(WriteError::Crowded);
            } else {
                // A torn piece goes first: it must not be there when the other half is torn.
                let first = if found.tail[1] > found.tail[0] {
                    Half::Second
                } else {
                    Half::First
                };
                for half in [first, first.other()] {
                    self.renew(half, found);
                }
                for (kind, newest) in Kind::ALL.into_iter().zip(&found.own) {
                    let stands = |newest: &Newest| newest.places.iter().any(Option::is_some);
                    self.due
                        .set(kind, newest.as_ref().is_some_and(|of| !stands(of)));
                }
                while self.step() {}
            }
        }
        let failed = self.report.failed;
        let filled = Half::ALL.map(|half| self.fill(half, found));
        if filled != [true; 2] && self.report.failed == failed {
            self.fail(WriteError::Full);
        }
    }

    /// Copies to a half what only the other one has, the newest last: a torn piece is behind none of it. Whether the half
    /// has all of it then.
    fn fill(&mut self, half: Half, found: &mut Found) -> bool {
        for _ in 0..KINDS + FOREIGN {
            let lacking = found.all_mut().filter(|newest| newest.is_lacking(half));
            let Some(newest) = lacking.min_by_key(|newest| newest.number) else {
                break;
            };
            if !self.copy(newest, half) {
                return false;
            }
        }
        true
    }

    /// Copies a record to a half from the other one. Counts what fails, but for want of room.
    fn copy(&mut self, newest: &mut Newest, to: Half) -> bool {
        let from = to.other();
        let Some(place) = newest.places[from as usize] else {
            return false;
        };
        if !self.load(from, place) {
            self.frame.clear();
            self.fail(WriteError::Flash);
            return false;
        }
        let length = self.length() as u32;
        if length > self.room_in(to) {
            self.frame.clear();
            return false;
        }
        (self.writing, self.copies) = (None, to.alone());
        let failed = self.report.failed;
        while !self.frame.is_empty() && self.step() {}
        if self.report.failed > failed {
            return false;
        }
        let at = self.used[to as usize].saturating_sub(length) + 1;
        newest.places[to as usize] = Some(Place { at, ..place });
        true
    }

    /// Erases a half, and fills it with the records that are to stay. The other half has them all,
    /// unless both are damaged. Then no record of another spindle is erased, and this one's are known.
    fn renew(&mut self, half: Half, found: &mut Found) {
        let elsewhere = |newest: &Newest| newest.places[half.other() as usize].is_some();
        if !found.foreign.iter().all(elsewhere) {
            self.fail(WriteError::Full);
            return;
        }
        if !self.erase(half) {
            return;
        }
        self.used[half as usize] = 0;
        for newest in found.all_mut() {
            newest.places[half as usize] = None;
        }
        self.fill(half, found);
    }

    /// Erases a half; whether it is blank then.
    fn erase(&mut self, half: Half) -> bool {
        let from = self.begin_of(half);
        let blank = self.flash.erase(from, from + self.half).is_ok() && self.is_blank(half);
        if !blank {
            self.fail(WriteError::Flash);
        }
        blank
    }

    /// Reads the frame of a record.
    fn load(&mut self, half: Half, place: Place) -> bool {
        self.frame.clear();
        let granule = Self::GRANULE as u32;
        let end = place.at.saturating_add(place.length);
        let mut buffer = [0; LONGEST_UNIT];
        let first = place.at - place.at % granule;
        for at in (first..end).step_by(Self::GRANULE) {
            let Some(bytes) = self.read(half, at, &mut buffer) else {
                return false;
            };
            let wanted = (at..)
                .zip(bytes)
                .filter(|(at, _)| (place.at..end).contains(at));
            for (_, byte) in wanted {
                if self.frame.push(*byte).is_err() {
                    return false;
                }
            }
        }
        true
    }

    /// Takes all records of the log, and sees how much of it is in use.
    fn look_through(&mut self) -> Found {
        let mut found = Found::nothing(self.identity);
        for half in Half::ALL.into_iter().take(self.halves) {
            self.used[half as usize] = self.look_through_half(half, &mut found);
        }
        found
    }

    /// Takes all records of a half; returns how much of it is in use.
    fn look_through_half(&mut self, half: Half, found: &mut Found) -> u32 {
        let mut reader = FrameReader::<(), LONGEST_FOREIGN>::new();
        // Where the frame began that is being read.
        let (mut used, mut begun) = (0, None);
        let mut buffer = [0; LONGEST_UNIT];
        for at in (0..self.half).step_by(Self::GRANULE) {
            let Some(granule) = self.read(half, at, &mut buffer) else {
                // Not even damaged content: what it was part of ends here.
                found.damage(half, at);
                used = at + Self::GRANULE as u32;
                (reader, begun) = (FrameReader::new(), None);
                continue;
            };
            let blank = granule.iter().all(|byte| *byte == 0xff);
            if !blank {
                used = at + Self::GRANULE as u32;
            }
            if blank && begun.is_none() {
                continue;
            }
            for (at, byte) in (at..).zip(granule) {
                if *byte != DELIMITER {
                    begun.get_or_insert(at);
                }
                let from = begun.unwrap_or(at);
                let place = Place {
                    at: from,
                    length: (at - from).saturating_add(1),
                };
                let end = (at + 1).next_multiple_of(Self::GRANULE as u32);
                let read = reader.push_with(*byte, |message| {
                    found.take(message, half, place, end);
                    Ok(())
                });
                if let Some(Err(_)) = read {
                    found.damage(half, from);
                }
                if *byte == DELIMITER {
                    begun = None;
                }
            }
        }
        if let Some(from) = begun {
            found.damage(half, from);
        }
        used
    }

    fn is_blank(&mut self, half: Half) -> bool {
        let mut buffer = [0; LONGEST_UNIT];
        (0..self.half).step_by(Self::GRANULE).all(|at| {
            self.read(half, at, &mut buffer)
                .is_some_and(|granule| granule.iter().all(|byte| *byte == 0xff))
        })
    }

    /// A granule, unless it cannot be read.
    fn read<'b>(
        &mut self,
        half: Half,
        at: u32,
        buffer: &'b mut [u8; LONGEST_UNIT],
    ) -> Option<&'b [u8]> {
        let granule = buffer.get_mut(..Self::GRANULE)?;
        self.flash.read(self.begin_of(half) + at, granule).ok()?;
        Some(granule)
    }

    const fn begin_of(&self, half: Half) -> u32 {
        match half {
            Half::First => 0,
            Half::Second => self.half,
        }
    }

    /// Room that is left in a half, bytes.
    const fn room_in(&self, half: Half) -> u32 {
        self.half.saturating_sub(self.used[half as usize])
    }

    /// Room that is left for two copies of something.
    fn room(&self) -> u32 {
        match self.halves {
            1 => self.room_in(Half::First) / 2,
            _ => self.room_in(Half::First).min(self.room_in(Half::Second)),
        }
    }

    /// Sees new data to be kept, as [`Monitor::retain`](super::Monitor::retain) does, with a monitor of
    /// one's own. Looks once a second, and else does nothing.
    pub fn look(&mut self, time_us: u64, judgement: &Judgement, life: &Life) {
        if time_us < self.look_us {
            return;
        }
        self.look_us = time_us.saturating_add(LOOK_US);
        let life = life.kept();
        // Another bearing.
        if life.0 < self.past.life.0 || life.1 < self.past.life.1 {
            self.began = life;
            self.keep_life(time_us, life);
        }
        let alarms = judgement.unacknowledged();
        if alarms != self.past.start.alarms && time_us >= self.alarms_us {
            self.keep_alarms(time_us, judgement);
        }
        let (kept, began) = (self.past.life, self.began);
        let grown = |now: u64, kept: u64, began: u64| {
            now != kept && now.abs_diff(kept) >= now.abs_diff(began) / PART
        };
        if time_us.saturating_sub(self.life_us) >= LIFE_US
            && (grown(life.0, kept.0, began.0) || grown(life.1, kept.1, began.1))
        {
            self.keep_life(time_us, life);
            if self.raised_by(judgement) != self.past.start.raised {
                self.keep_alarms(time_us, judgement);
            }
        }
    }

    const fn keep_life(&mut self, time_us: u64, life: (u64, u64)) {
        (self.past.life, self.life_us) = (life, time_us);
        self.due.life = true;
        self.due.start |= self.owed.start;
    }

    fn keep_alarms(&mut self, time_us: u64, judgement: &Judgement) {
        self.alarms_us = time_us.saturating_add(ALARMS_US);
        self.past.start.alarms = judgement.unacknowledged();
        self.past.start.raised = self.raised_by(judgement);
        self.due.start = true;
    }

    /// How often each alarm was raised in all starts.
    fn raised_by(&self, judgement: &Judgement) -> [u16; Alarm::COUNT] {
        let mut raised = self.raised;
        for (raised, alarm) in raised.iter_mut().zip(Alarm::ALL) {
            let (now, _) = judgement.alarm(alarm).counts();
            *raised = raised.saturating_add(now.min(u16::MAX.into()) as u16);
        }
        raised
    }

    /// The supply is about to go: writes life and alarms at once, whatever else is due. Whether they stand in the
    /// flash then, in one copy at least. Between ticks, as [`Store::look`] is.
    ///
    /// For boards whose hardware warns of that. A record of 48 bytes is two copies of 12 words on an STM32F405: 0.4 ms,
    /// or 2.4 ms at worst. The alarms take as long again if they have changed. The programmable voltage detector
    /// (PVD: `PWR_CR`, `PWR_CSR`) of that chip warns at 2.9 V, and words are written down to 2.7 V. The supply must hold out
    /// in between: 100 mA for 2.4 ms take 1.2 mF. A detector at the input of the regulator leaves more time. To be called
    /// once for each warning.
    pub fn power_fails(&mut self, time_us: u64, judgement: &Judgement, life: &Life) -> bool {
        if self.halves == 0 {
            return false;
        }
        self.abandon();
        self.keep_life(time_us, life.kept());
        if judgement.unacknowledged() != self.past.start.alarms {
            self.keep_alarms(time_us, judgement);
        }
        let number = self.number;
        while self.step() {}
        self.latest[Kind::Life as usize] >= number
    }

    /// Leaves a record as it is.
    fn abandon(&mut self) {
        if self.frame.is_empty() {
            return;
        }
        if self.done > 0 {
            self.spoil();
        }
        let (stands, writing) = (self.stands, self.writing);
        self.copies = &[];
        self.end();
        if !stands && let Some((_, kind)) = writing {
            self.due.set(kind, true);
        }
    }

    /// Writes the next unit ([`NorFlash::WRITE_SIZE`] bytes) of due records; false if there is nothing to do.
    ///
    /// Takes as long as the flash does for one unit, and now and then as long as it takes to encode a record.
    pub fn step(&mut self) -> bool {
        if self.frame.is_empty() {
            return self.begin();
        }
        let Some((half, _)) = self.copies.split_first() else {
            self.end();
            return true;
        };
        if self.done == 0 && self.length() as u32 > self.room_in(*half) {
            self.end_copy(Some(WriteError::Full));
            return true;
        }
        let mut unit = [DELIMITER; LONGEST_UNIT];
        let Some(unit) = unit.get_mut(..F::WRITE_SIZE) else {
            return false;
        };
        // A zero, the frame, and zeros behind it.
        for (i, to) in (self.done..).zip(unit.iter_mut()) {
            let byte = i.checked_sub(1).and_then(|i| self.frame.get(i));
            *to = byte.copied().unwrap_or(DELIMITER);
        }
        let at = self.begin_of(*half) + self.used[*half as usize] + self.done as u32;
        let mut there = [0; LONGEST_UNIT];
        let good = self.flash.write(at, unit).is_ok()
            && there
                .get_mut(..F::WRITE_SIZE)
                .is_some_and(|there| self.flash.read(at, there).is_ok() && there == unit);
        self.done += F::WRITE_SIZE;
        if good {
            if self.done >= self.length() {
                self.used[*half as usize] += self.length() as u32;
                self.end_copy(None);
            }
        } else {
            // This place is spoilt: once more behind it.
            self.spoil();
            self.attempts += 1;
            if self.attempts >= ATTEMPTS {
                self.end_copy(Some(WriteError::Flash));
            }
        }
        true
    }

    /// Bytes of the record that is being written.
    fn length(&self) -> usize {
        (1 + self.frame.len()).next_multiple_of(Self::GRANULE)
    }

    /// Leaves the written part of a copy behind.
    fn spoil(&mut self) {
        if let Some(half) = self.copies.first() {
            let spoilt = self.done.next_multiple_of(Self::GRANULE) as u32;
            self.used[*half as usize] = self.used[*half as usize].saturating_add(spoilt);
        }
        self.done = 0;
    }

    /// A copy stands, or could not be written: the next one.
    fn end_copy(&mut self, error: Option<WriteError>) {
        (self.done, self.attempts) = (0, 0);
        self.stands |= error.is_none();
        if error.is_some() {
            (self.error, self.missed) = (error, true);
        }
        self.copies = self.copies.get(1..).unwrap_or_default();
        if self.copies.is_empty() {
            self.end();
        }
    }

    /// A record is done.
    fn end(&mut self) {
        if self.missed {
            self.report.failed = self.report.failed.saturating_add(1);
        }
        if let Some((number, kind)) = self.writing.take() {
            self.owed.set(kind, !self.stands);
            if self.stands {
                self.report.written = self.report.written.saturating_add(1);
                self.latest[kind as usize] = number;
            }
        }
        (self.done, self.attempts) = (0, 0);
        (self.stands, self.missed) = (false, false);
        self.frame.clear();
    }

    /// Encodes the next record; false if none is due, or there is no room for it.
    fn begin(&mut self) -> bool {
        let Some(kind) = self.due.first() else {
            return false;
        };
        self.due.set(kind, false);
        let Identity(spindle) = self.identity;
        let content = match kind {
            Kind::Life => Content::Life {
                spindle,
                life: self.past.life,
            },
            Kind::Start => Content::Start {
                spindle,
                start: self.past.start,
            },
        };
        let record = Record {
            version: VERSION,
            number: self.number,
            content,
            latest: self.latest,
        };
        // The lengths above make room for every record; the tests see to it.
        if framing::encode_into(&record, &mut self.frame).is_none() {
            self.fail(WriteError::Flash);
            return true;
        }
        // The last of the room is not for the alarms, which may come and go.
        let reserve = match kind {
            Kind::Start => self.half / 4,
            Kind::Life => 0,
        };
        if (self.length() as u32).saturating_add(reserve) > self.room() {
            self.frame.clear();
            self.owed.set(kind, true);
            self.fail(WriteError::Full);
            return true;
        }
        self.writing = Some((self.number, kind));
        self.copies = match self.halves {
            1 => &[Half::First, Half::First],
            _ => &Half::ALL,
        };
        self.number = self.number.saturating_add(1);
        true
    }

    const fn fail(&mut self, error: WriteError) {
        self.report.failed = self.report.failed.saturating_add(1);
        self.error = Some(error);
    }

    /// Recovery at the start, and records written since.
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

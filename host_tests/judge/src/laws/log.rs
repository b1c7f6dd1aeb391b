//! Any image of the log in flash, and what a board makes of it.
//!
//! No panic, no past but one whose checksum holds in the image, and what is written then is there at the next start.

use crate::laws::common::{Ends, run_of};
use arbitrary::{Arbitrary, Result, Unstructured};
use crc::{CRC_32_ISO_HDLC, Crc};
use mock::flash::FailingFlash;
use spindle_monitor::board::ResetCause;
use spindle_monitor::enumset::EnumSet;
use spindle_monitor::estimator::{KEPT, Kept as KeptEstimates};
use spindle_monitor::log::{Log, PAYLOAD};
use spindle_monitor::retained::{NorFlash, Recovery, RetentionReport, VERSION};
use spindle_monitor::{Alarm, Identity, Judgement, Life, Past, Store};
use std::ops::Range;

const SECTOR: usize = 1024;
/// Sectors of a half.
const SECTORS: usize = 1;
const HALF: usize = SECTORS * SECTOR;

const IDENTITY: Identity = Identity::of(7005, 25);
const CHECKSUM: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// Bytes of a record, and where its parts are.
const RECORD: usize = 4 + PAYLOAD + 4;
const BEARINGS: Range<usize> = 8..12;
const RAISED: Range<usize> = 32..32 + Alarm::COUNT;
const DISPLACEMENTS: Range<usize> = RAISED.end..RAISED.end + 4;

/// An image, and starts of a board on it.
#[derive(Debug)]
pub struct Run {
    /// Number of the flash's unit.
    unit: u8,
    /// Slots of both halves in their order, as long as there are any.
    slots: Vec<Slot>,
    /// Bytes anywhere that are others.
    changes: Vec<(u16, u8)>,
    starts: Vec<Start>,
}

#[derive(Debug)]
enum Slot {
    Blank,
    /// Bytes as they are.
    Bytes([u8; RECORD]),
    /// A number and a payload, with their checksum; of these bearings and, with an odd number, these displacements, or of any.
    Record(u32, [u8; PAYLOAD], bool),
    /// The record before it once more.
    Again,
}

/// A start, and what is to be kept in it: alarms and life, so many times.
#[derive(Debug)]
struct Start {
    alarms: u16,
    life: (u64, u64),
    /// Records more than one.
    records: u8,
}

impl Arbitrary<'_> for Run {
    fn arbitrary(u: &mut Unstructured) -> Result<Self> {
        let mut run = Self {
            unit: u.arbitrary()?,
            slots: Vec::new(),
            changes: Vec::new(),
            starts: Vec::new(),
        };
        for _ in 0..u.int_in_range(1..=3)? {
            run.starts.push(Start {
                alarms: u.arbitrary()?,
                life: u.arbitrary()?,
                records: u.arbitrary()?,
            });
        }
        for _ in 0..u.int_in_range(0..=3)? {
            run.changes.push(u.arbitrary()?);
        }
        while !u.is_empty() && run.slots.len() < 2 * HALF / RECORD {
            run.slots.push(slot(u)?);
        }
        Ok(run)
    }
}

fn slot(u: &mut Unstructured) -> Result<Slot> {
    Ok(match u.int_in_range(0..=7)? {
        0 => Slot::Blank,
        1 => Slot::Bytes(u.arbitrary()?),
        2 | 3 => Slot::Again,
        _ => {
            let number = match u.arbitrary()? {
                0..=191_u8 => u.int_in_range(1..=20)?,
                192..=223 => u32::MAX - u.int_in_range(0..=3)?,
                224.. => u.arbitrary()?,
            };
            let mut payload: [u8; PAYLOAD] = u.arbitrary()?;
            if u.ratio(7, 8)? {
                payload[0] = VERSION;
            }
            Slot::Record(number, payload, u.ratio(7, 8)?)
        }
    })
}

/// Runs a kept input as its target does; what the starts found.
pub fn replay(input: &[u8]) -> Ends {
    check(&run_of(input))
}

/// Runs it; what the starts found. A law that is broken is a panic.
pub fn check(run: &Run) -> Ends {
    match run.unit % 3 {
        0 => with_unit::<1>(run),
        1 => with_unit::<4>(run),
        _ => with_unit::<32>(run),
    }
}

/// The bytes of [`IDENTITY`] at both places of a record.
fn identity() -> [[u8; 4]; 2] {
    let flash = FailingFlash::<4, SECTOR>::new(2);
    let (mut store, _) = Store::open(flash, IDENTITY, ResetCause::PowerOn);
    while store.step() {}
    let bytes = store.into_flash().bytes;
    [BEARINGS, DISPLACEMENTS].map(|place| bytes[place].try_into().expect("four bytes"))
}

fn image<const UNIT: usize>(run: &Run) -> FailingFlash<UNIT, SECTOR> {
    let mut flash = FailingFlash::<UNIT, SECTOR>::new(2 * SECTORS);
    let places = places::<UNIT>();
    let [bearings, displacements] = identity();
    let mut last = [0xff; RECORD];
    for (at, slot) in places.zip(&run.slots) {
        match slot {
            Slot::Blank => continue,
            Slot::Again => {}
            Slot::Bytes(bytes) => last = *bytes,
            Slot::Record(number, payload, ours) => {
                last[..4].copy_from_slice(&number.to_le_bytes());
                last[4..][..PAYLOAD].copy_from_slice(payload);
                if *ours {
                    last[BEARINGS].copy_from_slice(&bearings);
                }
                if *ours && number % 2 == 1 {
                    last[DISPLACEMENTS].copy_from_slice(&displacements);
                }
                let checksum = CHECKSUM.checksum(&last[..4 + PAYLOAD]);
                last[4 + PAYLOAD..].copy_from_slice(&checksum.to_le_bytes());
            }
        }
        flash.bytes[at..][..RECORD].copy_from_slice(&last);
    }
    for (at, byte) in &run.changes {
        flash.bytes[usize::from(*at) % (2 * HALF)] = *byte;
    }
    flash
}

fn alarms(bits: u16) -> EnumSet<Alarm> {
    EnumSet::from_repr_truncated(bits)
}

/// Where the slots of both halves begin.
fn places<const UNIT: usize>() -> impl Iterator<Item = usize> {
    let slot = Log::<FailingFlash<UNIT, SECTOR>>::SLOT;
    (0..2).flat_map(move |half| (0..HALF / slot).map(move |i| half * HALF + i * slot))
}

/// Payloads of the good records with the highest number.
fn newest<const UNIT: usize>(bytes: &[u8]) -> Vec<[u8; PAYLOAD]> {
    let mut newest = (1, Vec::new());
    for at in places::<UNIT>() {
        let (content, checksum) = bytes[at..][..RECORD].split_at(4 + PAYLOAD);
        let (number, payload) = content.split_at(4);
        let number = u32::from_le_bytes(number.try_into().expect("four bytes"));
        if CHECKSUM.checksum(content).to_le_bytes() != *checksum || number < newest.0 {
            continue;
        }
        if number > newest.0 {
            newest = (number, Vec::new());
        }
        newest.1.push(payload.try_into().expect("a payload"));
    }
    newest.1
}

/// Whether a past is of such a payload: number of starts, of these bearings also alarms and life, and estimates of this spindle.
fn is_of(past: &Past, payload: &[u8; PAYLOAD], report: &RetentionReport) -> bool {
    let payload = |place: Range<usize>| &payload[place.start - 4..place.end - 4];
    let number = |place: Range<usize>| {
        let bytes = payload(place).iter().rev();
        bytes.fold(0_u64, |number, byte| number << 8 | u64::from(*byte))
    };
    let [bearings, displacements] = identity();
    let has_bearings = *payload(BEARINGS) == bearings;
    let is_ours = has_bearings && *payload(DISPLACEMENTS) == displacements;
    let boots = number(28..32).saturating_add(1).min(u32::MAX.into());
    let start = &past.start;
    let kept = payload(DISPLACEMENTS.end..DISPLACEMENTS.end + KEPT);
    let found = past.estimates;
    let estimated = match report.estimates {
        Recovery::Recovered => {
            is_ours && found.is_some_and(|KeptEstimates(found)| found[..] == *kept)
        }
        Recovery::Blank => kept.iter().all(|byte| *byte == 0) && found.is_none(),
        Recovery::OtherSpindle => !is_ours && found.is_none(),
        other => other == report.recovery && found.is_none(),
    };
    let is_version = payload(4..5) == [VERSION];
    estimated
        && is_version != (report.recovery == Recovery::OtherVersion)
        && match report.recovery {
            Recovery::Recovered => {
                let same = start.alarms == alarms(number(6..8) as u16)
                    && start.raised[..] == *payload(RAISED);
                let kept = (number(12..20), number(20..28));
                has_bearings && past.life == kept && same && u64::from(start.boots) == boots
            }
            Recovery::OtherSpindle => {
                is_new(past) && !has_bearings && u64::from(start.boots) == boots
            }
            Recovery::OtherVersion => is_new(past) && start.boots == 1,
            _ => false,
        }
}

/// Whether a past has no life and no alarm.
fn is_new(past: &Past) -> bool {
    let start = &past.start;
    past.life == (0, 0) && start.alarms.is_empty() && start.raised == [0; Alarm::COUNT]
}

fn with_unit<const UNIT: usize>(run: &Run) -> Ends {
    let mut flash = image::<UNIT>(run);
    let mut ends = Ends::new();
    let is_last = |slot: &Slot| matches!(slot, Slot::Record(u32::MAX, ..));
    if run.slots.iter().any(is_last) {
        ends.insert("last-number");
    }
    let mut kept = None;
    for start in &run.starts {
        let newest = newest::<UNIT>(&flash.bytes);
        let (store, past) = Store::open(flash, IDENTITY, ResetCause::Pin);
        let report = store.report();
        ends.insert(report.recovery.name());
        match report.recovery {
            Recovery::NoMemory => panic!("there are two halves"),
            Recovery::Blank | Recovery::Damaged => {
                assert_eq!(report.recovery == Recovery::Damaged, report.damaged > 0);
                assert!(newest.is_empty());
                assert!(is_new(&past) && past.start.boots == 1);
            }
            _ => assert!(newest.iter().any(|payload| is_of(&past, payload, &report))),
        }
        if let Some((life, alarms, boots)) = kept {
            assert_eq!(report.recovery, Recovery::Recovered);
            assert_eq!((past.life, past.start.alarms), (life, alarms));
            assert_eq!(past.start.boots, u32::saturating_add(boots, 1));
        }
        (flash, kept) = keep(store, &past, start);
    }
    // All of it is there at the next start.
    let (store, past) = Store::open(flash, IDENTITY, ResetCause::Pin);
    let (life, alarms, _) = kept.expect("there was a start");
    assert_eq!(store.report().recovery, Recovery::Recovered);
    assert_eq!((past.life, past.start.alarms), (life, alarms));
    ends
}

type Kept = Option<((u64, u64), EnumSet<Alarm>, u32)>;

/// Keeps life and alarms as often as a start wants. A half has room for half of its slots after any start.
fn keep<F: NorFlash>(mut store: Store<F>, past: &Past, start: &Start) -> (F, Kept) {
    let mut judgement = Judgement::default();
    judgement.latch(alarms(start.alarms));
    let (used, revolutions) = start.life;
    let mut life = Life::resume(used, revolutions);
    for record in 0..1 + u64::from(start.records % 4) {
        life = Life::resume(used ^ record, revolutions);
        assert!(
            store.power_fails(record, &judgement, &life, past.estimates),
            "no room"
        );
    }
    assert!(!store.step());
    let kept = (life.kept(), judgement.unacknowledged(), past.start.boots);
    (store.into_flash(), Some(kept))
}

//! Data that the monitor keeps over a power cycle: life used, alarms, estimates of the probes, number of starts.
//!
//! [`Store::open`] reads the [`Past`] before ticks begin. [`Monitor::retain`](crate::Monitor::retain) sees changes, and
//! [`Store::step`] writes them between ticks, one unit of the flash at a time. The flash is whatever implements
//! [`NorFlash`]; all of it is the store's, as a [`log`](crate::log).
//!
//! There is one kind of record. Each of these reasons writes all of it:
//!
//! | reason | when |
//! | --- | --- |
//! | life used, revolutions | every two minutes, if either has grown by a 64th of its growth since the start; at once for a new bearing |
//! | alarms not acknowledged | within a second, 10 s apart |
//! | estimates of the probes | within a second, when commissioned and when an alarm of theirs changes; once a day |
//! | number of starts, cause of the reset | at every start |
//!
//! How often each alarm was raised is kept along with them. The tare is not kept: it drifts, and a shaft stands still when
//! power comes on, so that it is taken again.
//!
//! Life and alarms belong to the bearings of a spindle ([`Identity`]). With other bearings life begins at 0 without alarms, and the
//! number of starts goes on. Estimates belong to all that the displacements computed at the probes depend on, too: with another
//! support, preload or probe they alone are gone.
//! With a record of another [`VERSION`] all of it begins at 0.
//!
//! **A power cut loses** the larger of two lives: the one used in two minutes, and a 64th of the one used since the
//! start. With a cut every nine minutes, that is a ninth. Cuts every two minutes lose everything. A board that is
//! warned of the cut loses nothing: see [`Store::power_fails`].
//!
//! **How long it lasts.** Halves of 128 KiB have 1,365 slots of 96 bytes. At least half of them are free after a start. Without a restart,
//! `n` slots last for `128 min (64/63)^(n - 64)`: 682 for 4 years.
//! A full log keeps what it has, and [`RetentionReport::failed`] counts the rest. Eight hours a day are 150 records, and wear
//! halves of 1,365 slots out in 130 years, at 10,000 erases. Power cuts every two minutes, day and night, wear them out
//! in 13 years, a reset every second in 79 days.

use crate::alarms::Alarm;
use crate::board::ResetCause;
use crate::estimator::{KEPT, Kept};
use crate::judgement::Judgement;
use crate::life::Life;
use crate::log::{Log, PAYLOAD};
pub use crate::log::{NorFlash, WriteError};
use enumset::EnumSet;
use serde::{Deserialize, Serialize};

/// Version of the records. Alarms are kept by their place in [`Alarm::ALL`].
pub const VERSION: u8 = 7;

/// Shortest time between two records for the life alone, us.
pub const LIFE_US: u64 = 120_000_000;
/// Life is written again when it has grown by this part of its growth since the start. A power cut
/// loses a 64th at most, and the number of records grows with the logarithm of time.
const PART: u64 = 64;
/// Shortest time between two records for alarms, us.
const ALARMS_US: u64 = 10_000_000;
/// Time between looks at new data, us: half of the second within which a record is written.
const LOOK_US: u64 = 500_000;

/// Recovery of the kept data at the start of the monitor.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Recovery {
    /// There is no memory: the data are lost with the power.
    #[default]
    NoMemory,
    /// Nothing has been kept yet.
    Blank,
    /// The newest undamaged record goes on.
    Recovered,
    /// The record is of another spindle: life begins at 0 without alarms, or there are no estimates; the number of starts goes on.
    OtherSpindle,
    /// The record is of another version of the monitor.
    OtherVersion,
    /// There are records, but damaged: none can be read.
    Damaged,
}

impl Recovery {
    /// All of them, in the order of the format.
    pub const ALL: [Self; 6] = [
        Self::NoMemory,
        Self::Blank,
        Self::Recovered,
        Self::OtherSpindle,
        Self::OtherVersion,
        Self::Damaged,
    ];

    /// Short name in lower case.
    pub const fn name(self) -> &'static str {
        match self {
            Self::NoMemory => "no-memory",
            Self::Blank => "blank",
            Self::Recovered => "recovered",
            Self::OtherSpindle => "other-spindle",
            Self::OtherVersion => "other-version",
            Self::Damaged => "damaged",
        }
    }
}

/// Data kept over a power cycle ([`retained`](crate::retained)).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct RetentionReport {
    /// Recovery of life and alarms.
    pub recovery: Recovery,
    /// Recovery of the probes' estimates.
    pub estimates: Recovery,
    /// Damaged records that were met at the start, such as one that the power was lost in.
    pub damaged: u16,
    /// Copies of records written since the start, two of each record.
    pub written: u32,
    /// Copies that could not be written, and halves of the flash that could not be erased, since the start.
    pub failed: u32,
}

/// A start of the monitor, and the data kept from earlier ones.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct StartReport {
    /// Starts so far, this one included; 0 without a memory.
    pub boots: u32,
    /// Why this one was.
    pub cause: ResetCause,
    /// Alarms that nobody had acknowledged before, and that were latched again.
    pub alarms: EnumSet<Alarm>,
    /// How often each alarm was raised before, in all starts, in that order; 255 stands for more, too.
    pub raised: [u8; Alarm::COUNT],
}

/// Data kept from earlier starts.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Past {
    /// Life used and revolutions, as of [`Life::kept`].
    pub life: (u64, u64),
    /// This start, with the alarms of earlier ones.
    pub start: StartReport,
    /// Estimates of the probes, once they were commissioned.
    pub estimates: Option<Kept>,
}

impl Past {
    /// Past of a board without a memory, which knows why it started.
    pub fn without_memory(cause: ResetCause) -> Self {
        let mut past = Self::default();
        past.start.cause = cause;
        past
    }

    /// Payload of a record, numbers little-endian: version, cause, alarms, bearings, life, starts, times raised,
    /// displacements, estimates.
    fn encode(&self, identity: Identity) -> [u8; PAYLOAD] {
        let (used, revolutions) = self.life;
        let start = &self.start;
        let estimates = self.estimates.map_or([0; KEPT], |Kept(kept)| kept);
        let parts: [&[u8]; 9] = [
            &[VERSION, start.cause as u8],
            &start.alarms.as_repr().to_le_bytes(),
            &identity.bearings.to_le_bytes(),
            &used.to_le_bytes(),
            &revolutions.to_le_bytes(),
            &start.boots.to_le_bytes(),
            &start.raised,
            &identity.displacements.to_le_bytes(),
            &estimates,
        ];
        let mut payload = [0; PAYLOAD];
        for (to, from) in payload.iter_mut().zip(parts.into_iter().flatten()) {
            *to = *from;
        }
        payload
    }

    /// The past in a payload, and whose it is; `None` if it is of another version.
    fn decode(payload: &[u8; PAYLOAD]) -> Option<(Identity, Self)> {
        let (&[version, cause], rest) = payload.split_first_chunk()?;
        let (alarms, rest) = rest.split_first_chunk()?;
        let (bearings, rest) = rest.split_first_chunk()?;
        let (used, rest) = rest.split_first_chunk()?;
        let (revolutions, rest) = rest.split_first_chunk()?;
        let (boots, rest) = rest.split_first_chunk()?;
        let (raised, rest) = rest.split_first_chunk()?;
        let (displacements, rest) = rest.split_first_chunk()?;
        let (estimates, _) = rest.split_first_chunk()?;
        let causes = ResetCause::ALL.get(usize::from(cause));
        let past = Self {
            life: (u64::from_le_bytes(*used), u64::from_le_bytes(*revolutions)),
            start: StartReport {
                boots: u32::from_le_bytes(*boots),
                cause: causes.copied().unwrap_or_default(),
                alarms: EnumSet::from_repr_truncated(u16::from_le_bytes(*alarms)),
                raised: *raised,
            },
            estimates: (*estimates != [0; KEPT]).then_some(Kept(*estimates)),
        };
        let identity = Identity {
            bearings: u32::from_le_bytes(*bearings),
            displacements: u32::from_le_bytes(*displacements),
        };
        (version == VERSION).then_some((identity, past))
    }
}

// A record has room for all alarms.
const _: () =
    assert!(Alarm::COUNT <= 16 && 2 + 2 + 4 + 8 + 8 + 4 + Alarm::COUNT + 4 + KEPT <= PAYLOAD);

/// Identity of a spindle, which tells its data from another's.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Identity {
    bearings: u32,
    displacements: u32,
}

impl Identity {
    /// Of two checksums: of the bearings, and of all numbers that the displacements computed at the probes depend on.
    ///
    /// Both are of numbers, so that life does not end with the wording of a program.
    pub const fn of(bearings: u32, displacements: u32) -> Self {
        Self {
            bearings,
            displacements,
        }
    }
}

/// The log, and the data that are to go into it.
#[derive(Debug)]
pub struct Store<F> {
    log: Log<F>,
    identity: Identity,
    recovery: Recovery,
    estimates: Recovery,
    /// Data at the start, with the life of the bearing that is in place; and in the log, once the due record is written.
    began: Past,
    past: Past,
    due: bool,
    /// Times to look again, of the last record, and from which alarms may be kept again.
    look_us: u64,
    life_us: u64,
    alarms_us: u64,
}

impl<F: NorFlash> Store<F> {
    /// Reads the kept data, and makes room for new records. Before ticks begin, since it may erase: some
    /// seconds at the most, and mostly nothing. `cause` is the cause of this start by the hardware. It is kept, with the
    /// number of starts, once [`Store::step`] is called.
    ///
    /// [`Store::report`] says why data cannot be used; the past is a new bearing's then.
    pub fn open(flash: F, identity: Identity, cause: ResetCause) -> (Self, Past) {
        let (log, payload) = Log::open(flash);
        let mut past = Past::without_memory(cause);
        let kept = payload.as_ref().map(Past::decode);
        let recovery = match &kept {
            _ if !log.has_memory() => Recovery::NoMemory,
            None if log.counts().damaged > 0 => Recovery::Damaged,
            None => Recovery::Blank,
            Some(None) => Recovery::OtherVersion,
            Some(Some((whose, kept))) => {
                past.start.boots = kept.start.boots;
                if whose.bearings == identity.bearings {
                    past.life = kept.life;
                    past.start.alarms = kept.start.alarms;
                    past.start.raised = kept.start.raised;
                    Recovery::Recovered
                } else {
                    Recovery::OtherSpindle
                }
            }
        };
        let estimates = match kept.flatten() {
            None => recovery,
            Some((_, kept)) if kept.estimates.is_none() => Recovery::Blank,
            Some((whose, _)) if whose != identity => Recovery::OtherSpindle,
            Some((_, kept)) => {
                past.estimates = kept.estimates;
                Recovery::Recovered
            }
        };
        let due = recovery != Recovery::NoMemory;
        past.start.boots = past.start.boots.saturating_add(due.into());
        let store = Self {
            log,
            identity,
            recovery,
            estimates,
            began: past,
            past,
            due,
            look_us: 0,
            life_us: 0,
            alarms_us: 0,
        };
        (store, past)
    }

    /// Sees new data to be kept, as [`Monitor::retain`](crate::Monitor::retain) does, with a monitor of
    /// one's own. Looks twice a second, and else does nothing.
    pub fn look(
        &mut self,
        time_us: u64,
        judgement: &Judgement,
        life: &Life,
        estimates: Option<Kept>,
    ) {
        if time_us < self.look_us {
            return;
        }
        self.look_us = time_us.saturating_add(LOOK_US);
        let (now, kept) = (life.kept(), self.past.life);
        let replaced = now.0 < kept.0 || now.1 < kept.1;
        if replaced {
            self.began.life = now;
        }
        let began = self.began.life;
        let grown = |now: u64, kept: u64, began: u64| {
            now != kept && now.abs_diff(kept) >= now.abs_diff(began) / PART
        };
        let grown = time_us.saturating_sub(self.life_us) >= LIFE_US
            && (grown(now.0, kept.0, began.0) || grown(now.1, kept.1, began.1));
        let alarms = judgement.unacknowledged() != self.past.start.alarms;
        let estimated = estimates != self.past.estimates;
        if replaced || grown || estimated || (alarms && time_us >= self.alarms_us) {
            self.keep(time_us, judgement, life, estimates);
        }
    }

    /// Makes a record due.
    fn keep(&mut self, time_us: u64, judgement: &Judgement, life: &Life, estimates: Option<Kept>) {
        let start = &mut self.past.start;
        if judgement.unacknowledged() != start.alarms {
            self.alarms_us = time_us.saturating_add(ALARMS_US);
        }
        start.alarms = judgement.unacknowledged();
        start.raised = self.began.start.raised;
        for (raised, alarm) in start.raised.iter_mut().zip(Alarm::ALL) {
            let (now, _) = judgement.alarm(alarm).counts();
            *raised = raised.saturating_add(now.min(u8::MAX.into()) as u8);
        }
        (self.past.life, self.life_us) = (life.kept(), time_us);
        self.past.estimates = estimates;
        self.due = true;
    }

    /// The supply is about to go: writes life, alarms and estimates at once. Whether they stand in the flash then, in one copy at
    /// least. Between ticks, as [`Store::look`] is.
    ///
    /// For boards whose hardware warns of that. A record of 96 bytes is two copies of 24 words on an STM32F405: 0.8 ms,
    /// or 4 ms at worst. The programmable voltage detector (PVD: `PWR_CR`, `PWR_CSR`) of that chip warns at 2.9 V, and words
    /// are written down to 2.7 V. The supply must hold out in between: 100 mA for 4 ms take 2 mF. A detector at the
    /// input of the regulator leaves more time. To be called once for each warning.
    pub fn power_fails(
        &mut self,
        time_us: u64,
        judgement: &Judgement,
        life: &Life,
        estimates: Option<Kept>,
    ) -> bool {
        self.keep(time_us, judgement, life, estimates);
        self.due = false;
        self.log.begin(&self.past.encode(self.identity));
        let written = self.log.counts().written;
        while self.log.step() {}
        self.log.counts().written > written
    }

    /// Writes the next unit ([`NorFlash::WRITE_SIZE`] bytes) of due records; false if there is nothing to do.
    pub fn step(&mut self) -> bool {
        if self.due && !self.log.is_writing() {
            self.due = false;
            self.log.begin(&self.past.encode(self.identity));
        }
        self.log.step()
    }

    /// Recovery at the start, and copies written since.
    pub const fn report(&self) -> RetentionReport {
        let counts = self.log.counts();
        RetentionReport {
            recovery: self.recovery,
            estimates: self.estimates,
            damaged: counts.damaged,
            written: counts.written,
            failed: counts.failed,
        }
    }

    /// Why the last of the [`RetentionReport::failed`] failed.
    pub const fn error(&self) -> Option<WriteError> {
        self.log.counts().error
    }

    /// The flash.
    pub fn into_flash(self) -> F {
        self.log.into_flash()
    }
}

//! Measured loads behind one trait, and those from a serial line.
//!
//! Read [`LoadSource`] first. [`FramedLoads`] takes the frames of [`record`](crate::record) apart. Sources tell
//! their own faults: a damaged frame, a bus error, a converter at its rail. Whether loads make sense is the next stage's to say
//! ([`plausibility`](crate::plausibility)).

use crate::framing::FrameError;
use crate::marks::{Mark, Marks};
use crate::record::{FrameReader, LoadRecord, MESSAGE_LENGTH};
use serde::{Deserialize, Serialize};

/// The five loads at one instant.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct LoadSample {
    /// Time at which the sample was taken in, us.
    pub time_us: u64,
    /// `Fx, Fy, Fz` (N), `My, Mz` (N m) on the inner ring.
    pub load: [f32; 5],
    /// Shaft speed `omega`, rad/s, of sources that measure it, too.
    pub speed: Option<f32>,
    /// How far redundant channels are from agreeing, counts; 0 of a source that has none.
    pub residual: f32,
    /// Doubts of the source itself.
    pub doubts: Marks,
}

/// Where loads come from.
pub trait LoadSource {
    /// The newest sample since the last call, if there is one. Never waits.
    ///
    /// # Errors
    ///
    /// Why a sample is lost.
    fn sample(&mut self, time_us: u64) -> Result<Option<LoadSample>, Marks>;
}

/// Loads from a serial line: feed it the bytes as they come.
///
/// Of several records between two calls, the newest is the sample. A damaged frame is an error if no
/// good one followed it.
///
/// - **Order.** Numbers of records grow. A record is out of order if its number is not larger than the last, or
///   larger than any sender reaches in the time since. It is then no sample.
/// - **Restart.** A sender that restarts counts from 0. A record with a smaller number begins a new count if its own time
///   is not longer than the time since any record came. Replayed records are older than that, and stay out of order. Of a sender
///   without a clock, one begins a new count if none has been in order for 50 ms, and its number is one to reach in that time.
/// - **Age.** The sender's clock is compared with the monitor's. A record that took 20 ms longer than the fastest one is
///   late ([`Mark::Late`]). So is one whose time is 20 ms later than any before it, until those of 50 ms agree with it: a single
///   wrong time makes no other record late. A sender whose time is always 0 has no clock, and its records have no age.
#[derive(Debug)]
pub struct FramedLoads {
    reader: FrameReader<MESSAGE_LENGTH>,
    newest: Option<LoadRecord>,
    /// Number of the newest record in order, and number and time (us) of the last sample.
    sequence: Option<u32>,
    sampled: Option<(u32, u64)>,
    /// When the last record came that was not damaged, us.
    heard_us: u64,
    /// Records in order since the last sample, and the last one that was behind.
    in_order: u32,
    behind: Option<LoadRecord>,
    /// Monitor's time less the record's, for the fastest record, ms; and when this was set, ms.
    fastest: Option<(u32, u32)>,
    /// Records that have agreed with it, as far as they count.
    agreed: u8,
    /// As `fastest`, of records that claim to be faster by more than they may be late.
    ahead: Option<(u32, u32)>,
    doubts: Marks,
    counts: FrameCounts,
}

/// Counts of frames and records over the line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct FrameCounts {
    /// Records that arrived.
    pub received: u64,
    /// Frames that were damaged.
    pub corrupt: u64,
    /// Records that are missing in the sequence.
    pub lost: u64,
    /// Records out of order.
    pub disordered: u64,
    /// Records that a newer one replaced before they were used.
    pub passed_over: u64,
    /// Records that came late.
    pub late: u64,
}

/// Longest that a record may take over the fastest one, ms: an estimate of that age is no longer fresh.
const LATE_MS: u32 = 20;
/// Time for which records that are ahead of all before must agree, ms. Without a clock, records must all be behind for as long.
const AGREE_MS: u32 = 50;
/// Records that make the fastest one credible.
const AGREED: u8 = 3;
/// Time in which two clocks part by a millisecond at most, ms: 200 millionths, four times what a crystal has.
const DRIFT_MS: u32 = 5000;
/// Numbers of records that a sender may get ahead by, at once and in every millisecond.
const AHEAD: u64 = 1000;
const AHEAD_PER_MS: u64 = 10;

/// Numbers of records that a sender gets through in this time at most.
const fn reached(time_ms: u64) -> u64 {
    AHEAD.saturating_add(AHEAD_PER_MS.saturating_mul(time_ms))
}

impl Default for FramedLoads {
    fn default() -> Self {
        Self::new()
    }
}

impl FramedLoads {
    /// A source at the start of a frame.
    pub const fn new() -> Self {
        Self {
            reader: FrameReader::new(),
            newest: None,
            sequence: None,
            sampled: None,
            heard_us: 0,
            in_order: 0,
            behind: None,
            fastest: None,
            agreed: 0,
            ahead: None,
            doubts: Marks::new(),
            counts: FrameCounts {
                received: 0,
                corrupt: 0,
                lost: 0,
                disordered: 0,
                passed_over: 0,
                late: 0,
            },
        }
    }

    /// Takes the next byte.
    #[inline]
    pub fn push(&mut self, byte: u8) {
        if let Some(read) = self.reader.push(byte) {
            self.take(read);
        }
    }

    /// Takes a record, or a frame that was damaged, which somebody else has read from the line.
    #[inline(never)]
    pub fn take(&mut self, read: Result<LoadRecord, FrameError>) {
        match read {
            Ok(record) => self.arrived(record),
            Err(error) => self.damaged(error),
        }
    }

    /// Counts of frames and records so far.
    pub const fn counts(&self) -> FrameCounts {
        self.counts
    }

    fn damaged(&mut self, _: FrameError) {
        let counts = &mut self.counts;
        counts.corrupt = counts.corrupt.saturating_add(1);
        self.doubts.insert(Mark::Corrupt);
    }

    fn arrived(&mut self, record: LoadRecord) {
        self.counts.received = self.counts.received.saturating_add(1);
        let ahead = match self.sequence {
            None => 1,
            Some(last) => record.sequence.wrapping_sub(last),
        };
        // The nearer way around.
        if ahead == 0 || ahead > u32::MAX / 2 {
            self.disordered();
            if ahead != 0 {
                self.behind = Some(record);
            }
            return;
        }
        self.sequence = Some(record.sequence);
        self.in_order = self.in_order.saturating_add(1);
        if self.newest.replace(record).is_some() {
            self.counts.passed_over = self.counts.passed_over.saturating_add(1);
        }
        // A good record makes up for what was damaged before it.
        self.doubts = Marks::new();
    }

    fn disordered(&mut self) {
        self.counts.disordered = self.counts.disordered.saturating_add(1);
        self.doubts.insert(Mark::Order);
    }

    /// The newest record, if it is in order.
    fn next(&mut self, time_us: u64) -> Option<LoadRecord> {
        let in_order = core::mem::take(&mut self.in_order);
        let (behind, newest) = (self.behind.take(), self.newest.take());
        let heard = newest.or(behind)?;
        let silent_ms = time_us.saturating_sub(self.heard_us) / 1000;
        self.heard_us = time_us;
        let Some(record) = newest else {
            self.restart(&heard, silent_ms, time_us);
            return None;
        };
        if let Some((last, then)) = self.sampled {
            let since_ms = time_us.saturating_sub(then) / 1000;
            let ahead = record.sequence.wrapping_sub(last);
            if u64::from(ahead) > reached(since_ms) {
                self.sequence = Some(last);
                self.disordered();
                // Beyond half of all numbers, the nearer way to 0 is ahead.
                if record.sequence < last {
                    self.restart(&record, silent_ms, time_us);
                }
                return None;
            }
            let lost = ahead.saturating_sub(in_order);
            self.counts.lost = self.counts.lost.saturating_add(lost.into());
        }
        self.sampled = Some((record.sequence, time_us));
        Some(record)
    }

    /// Begins a new count with this record, if its sender can have started since any record came; without a clock, since the last
    /// one in order.
    fn restart(&mut self, record: &LoadRecord, silent_ms: u64, time_us: u64) {
        let last_us = self.sampled.map_or(0, |(_, then)| then);
        let since_ms = time_us.saturating_sub(last_us) / 1000;
        let has_restarted = if record.time_ms == 0 && self.fastest.is_none() {
            since_ms >= AGREE_MS.into() && u64::from(record.sequence) <= reached(since_ms)
        } else {
            u64::from(record.time_ms) <= silent_ms.saturating_add(LATE_MS.into())
        };
        if has_restarted {
            self.sequence = Some(record.sequence);
            self.sampled = Some((record.sequence, time_us));
            (self.fastest, self.agreed) = (None, 0);
        }
    }

    /// Whether a record took much longer than the fastest one, or claims a time that is not credible yet.
    fn is_late(&mut self, time_us: u64, record: &LoadRecord) -> bool {
        if record.time_ms == 0 {
            return false;
        }
        // Modulo 2^32 ms, as the record's time is.
        let now_ms = (time_us / 1000) as u32;
        let under_way = now_ms.wrapping_sub(record.time_ms);
        let (fastest, since) = self.fastest.unwrap_or((under_way, now_ms));
        let drift = now_ms.wrapping_sub(since) / DRIFT_MS;
        let longer = under_way.wrapping_sub(fastest) as i32;
        let is_ahead = longer < -(LATE_MS as i32) && !self.is_confirmed(under_way, now_ms);
        if longer >= -(LATE_MS as i32) {
            self.ahead = None;
        }
        let late = longer > (LATE_MS.saturating_add(drift)) as i32;
        if is_ahead {
            // Nothing yet.
        } else if late && self.agreed < AGREED {
            // One record alone speaks for the fastest: it may have been the wrong one.
            (self.fastest, self.agreed) = (Some((under_way, now_ms)), 1);
        } else {
            self.fastest = Some(if longer <= 0 || (drift > 0 && !late) {
                let slower = longer.min(drift as i32);
                (fastest.wrapping_add(slower as u32), now_ms)
            } else {
                (fastest, since)
            });
            self.agreed = self.agreed.saturating_add((!late).into());
        }
        self.counts.late = self.counts.late.saturating_add((late || is_ahead).into());
        late || is_ahead
    }

    /// Whether records that are ahead have agreed for long enough with one that was so long under way.
    fn is_confirmed(&mut self, under_way: u32, now_ms: u32) -> bool {
        let agrees = |(first, _): &(u32, u32)| {
            (under_way.wrapping_sub(*first) as i32).unsigned_abs() <= LATE_MS
        };
        let (first, since) = self.ahead.filter(agrees).unwrap_or((under_way, now_ms));
        let is_confirmed = now_ms.wrapping_sub(since) >= AGREE_MS;
        self.ahead = (!is_confirmed).then_some((first, since));
        is_confirmed
    }
}

impl LoadSource for FramedLoads {
    fn sample(&mut self, time_us: u64) -> Result<Option<LoadSample>, Marks> {
        let record = self.next(time_us);
        let mut doubts = core::mem::take(&mut self.doubts);
        match record {
            Some(record) => {
                doubts.extend(self.is_late(time_us, &record).then_some(Mark::Late));
                Ok(Some(LoadSample {
                    time_us,
                    load: record.load(),
                    speed: Some(record.omega()),
                    residual: 0.0,
                    doubts,
                }))
            }
            None if doubts.is_empty() => Ok(None),
            None => Err(doubts),
        }
    }
}

//! Received bytes on their way from the hardware to the main program: a ring that a DMA controller, or an interrupt
//! handler, fills.
//!
//! The hardware writes place after place, round and round, and waits for nobody. The main program takes bytes behind it,
//! and marks their places as empty. The place before the next one to take is therefore empty, until as many bytes wait as
//! there are places. Then it is full, however often the hardware has gone round: no overrun goes unseen.

use crate::spindle::PERIOD_US;
use core::sync::atomic::{AtomicU16, AtomicU32, Ordering};

/// Baud rate of the ports, 8N1: 10.9 us a byte.
pub const BAUD: u32 = 921_600;

/// Places of the ring: the bytes of two ticks, one of which is late by its period, and of 2 ms more, in which a change of
/// each alarm goes into the log. A power of two, for a cheap remainder.
pub const PLACES: usize = {
    let us = 2 * PERIOD_US as u64 + 2000;
    (us * BAUD as u64 / 10 / 1_000_000).next_power_of_two() as usize
};

/// Content of an empty place. The data register of a receiver has nine bits.
const EMPTY: u16 = u16::MAX;

/// The ring, in memory that the hardware reaches.
pub struct Ring {
    places: [AtomicU16; PLACES],
    /// Bytes that the port's hardware has lost by itself.
    overruns: AtomicU32,
}

impl Ring {
    /// A ring of zeros, so that it takes no place in flash: [`Receiver::new`] empties it.
    pub const fn zeroed() -> Self {
        Self {
            places: [const { AtomicU16::new(0) }; PLACES],
            overruns: AtomicU32::new(0),
        }
    }

    /// Address of the first place.
    pub const fn address(&self) -> *const u16 {
        (&raw const self.places).cast()
    }

    /// Writes a byte to a place, in the hardware's stead.
    pub fn put(&self, at: usize, byte: u8) {
        self.place(at).store(byte.into(), Ordering::Release);
    }

    /// Counts a byte that the port's hardware has lost: it came before the one before it was fetched.
    pub fn note_overrun(&self) {
        self.overruns.fetch_add(1, Ordering::Relaxed);
    }

    fn place(&self, at: usize) -> &AtomicU16 {
        &self.places[at % PLACES]
    }
}

/// The main program's side of a ring.
pub struct Receiver<W = fn() -> usize> {
    ring: &'static Ring,
    /// Place that the hardware writes next.
    writes: W,
    /// Place that is taken next.
    takes: usize,
    lost: u32,
}

impl<W: Fn() -> usize> Receiver<W> {
    /// Empties the ring, before the hardware begins to fill it from its first place on. `writes` has the place that is
    /// written next.
    pub fn new(ring: &'static Ring, writes: W) -> Self {
        let receiver = Self {
            ring,
            writes,
            takes: 0,
            lost: 0,
        };
        receiver.empty(0, PLACES);
        receiver
    }

    /// The next byte, if there is one. Where bytes were overwritten, all of the ring is dropped.
    pub fn byte(&mut self) -> Option<u8> {
        let before = self.ring.place(self.takes.wrapping_sub(1));
        if before.load(Ordering::Acquire) != EMPTY {
            self.start_again();
        }
        let place = self.ring.place(self.takes);
        let byte = u8::try_from(place.load(Ordering::Acquire)).ok()?;
        place.store(EMPTY, Ordering::Release);
        self.takes = self.takes.wrapping_add(1);
        Some(byte)
    }

    /// Bytes lost since the start, at least: by the ring, which was not emptied in time, and by the port.
    pub fn lost(&self) -> u32 {
        let overruns = self.ring.overruns.load(Ordering::Relaxed);
        self.lost.saturating_add(overruns)
    }

    /// Drops all of the ring, and goes on where the hardware is.
    fn start_again(&mut self) {
        self.lost = self.lost.saturating_add(PLACES as u32);
        let from = (self.writes)();
        self.empty(from, PLACES);
        // Bytes may have come meanwhile, before their places were emptied and behind that.
        self.takes = (self.writes)();
        self.empty(from, self.takes.wrapping_sub(from) % PLACES);
    }

    fn empty(&self, from: usize, places: usize) {
        for i in 0..places {
            let place = self.ring.place(from.wrapping_add(i));
            place.store(EMPTY, Ordering::Release);
        }
    }
}

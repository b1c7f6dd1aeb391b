//! defmt's log, out through a serial port of its own.
//!
//! Nothing is logged before [`start`].
//!
//! A log that held interrupts back while it waits for the port would lose bytes that an interrupt handler receives. This one
//! leaves them on, and therefore belongs to the main program: interrupt handlers must not log.

#![allow(
    unsafe_code,
    reason = "defmt's logger is an unsafe trait around a static"
)]

use core::cell::{Cell, UnsafeCell};
use core::sync::atomic::{AtomicBool, Ordering};
use critical_section::Mutex;
use defmt::{Encoder, Logger, global_logger};

#[global_logger]
struct Log;

struct Shared(UnsafeCell<Encoder>);

// SAFETY: only who has set `TAKEN` touches the encoder.
unsafe impl Sync for Shared {}

static ENCODER: Shared = Shared(UnsafeCell::new(Encoder::new()));
static TAKEN: AtomicBool = AtomicBool::new(false);

/// The log's port, as [`start`] says.
#[derive(Clone, Copy)]
struct Port {
    send: fn(u8),
    finish: fn(),
}

static PORT: Mutex<Cell<Port>> = Mutex::new(Cell::new(Port {
    send: |_| {},
    finish: || {},
}));

/// Logs through a port, by a function that sends a byte, and one that waits until the last one has left.
pub fn start(send: fn(u8), finish: fn()) {
    critical_section::with(|cs| PORT.borrow(cs).set(Port { send, finish }));
}

fn port() -> Port {
    critical_section::with(|cs| PORT.borrow(cs).get())
}

/// Whether a frame may be begun.
pub fn is_free() -> bool {
    !TAKEN.load(Ordering::Acquire)
}

/// Waits until all of it has left, before a reset.
pub fn finish() {
    (port().finish)();
}

fn send(bytes: &[u8]) {
    bytes.iter().copied().for_each(port().send);
}

// SAFETY: `acquire` lets one frame at a time begin, and panics where a second one would, whatever
// its context. The panic handler logs only where no frame has begun.
unsafe impl Logger for Log {
    fn acquire() {
        assert!(
            !TAKEN.swap(true, Ordering::Acquire),
            "log used twice at once"
        );
        // SAFETY: taken just now.
        unsafe { &mut *ENCODER.0.get() }.start_frame(send);
    }

    unsafe fn flush() {
        finish();
    }

    unsafe fn release() {
        // SAFETY: the caller has acquired the log.
        unsafe { &mut *ENCODER.0.get() }.end_frame(send);
        TAKEN.store(false, Ordering::Release);
    }

    unsafe fn write(bytes: &[u8]) {
        // SAFETY: the caller has acquired the log.
        unsafe { &mut *ENCODER.0.get() }.write(bytes, send);
    }
}

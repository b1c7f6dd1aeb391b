//! Received bytes on their way from the interrupt handler to the main program.

use core::cell::RefCell;
use core::sync::atomic::{AtomicU32, Ordering};
use critical_section::Mutex;
use heapless::spsc::{Consumer, Producer, Queue};

/// Bytes that wait for the monitor: some 50 records, and far more than come in during a tick.
const QUEUE_LENGTH: usize = 2048;

/// The queue's writing end, on its way to the interrupt handler.
static HANDOVER: Mutex<RefCell<Option<Producer<'static, u8>>>> = Mutex::new(RefCell::new(None));

/// Bytes that the hardware or the queue had no room for.
static LOST: AtomicU32 = AtomicU32::new(0);

/// The receiving side of a port.
pub struct Receiver {
    queue: Consumer<'static, u8>,
}

impl Receiver {
    /// Sets up the queue; `None` if it was set up before.
    pub fn new() -> Option<Self> {
        let queue = cortex_m::singleton!(: Queue<u8, QUEUE_LENGTH> = Queue::new())?;
        let (producer, consumer) = queue.split();
        critical_section::with(|cs| HANDOVER.borrow_ref_mut(cs).replace(producer));
        Some(Self { queue: consumer })
    }

    /// The next byte, if there is one.
    pub fn byte(&mut self) -> Option<u8> {
        self.queue.dequeue()
    }

    /// Bytes lost since the start, because they came faster than they were taken.
    pub fn lost(&self) -> u32 {
        LOST.load(Ordering::Relaxed)
    }
}

/// The interrupt handler's side, which it keeps between interrupts.
#[derive(Default)]
pub struct Sender(Option<Producer<'static, u8>>);

impl Sender {
    /// One that fetches its end of the queue at the first byte.
    pub const fn new() -> Self {
        Self(None)
    }

    /// Queues a received byte, if there is one, and counts lost bytes: this one for want of room, and
    /// another one if the hardware was overrun.
    pub fn push(&mut self, byte: Option<u8>, overrun: bool) {
        if self.0.is_none() {
            self.0 = critical_section::with(|cs| HANDOVER.borrow_ref_mut(cs).take());
        }
        let mut lost = u32::from(overrun);
        if let Some(byte) = byte {
            let kept = self
                .0
                .as_mut()
                .is_some_and(|queue| queue.enqueue(byte).is_ok());
            lost += u32::from(!kept);
        }
        if lost > 0 {
            LOST.fetch_add(lost, Ordering::Relaxed);
        }
    }
}

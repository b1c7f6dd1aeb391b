//! Received bytes while the log of kept data is written: the core of an STM32F405 stands still, and the port goes on.

use spindle_firmware::flash::{Cells, Flash, Pace, SECTOR, SECTORS};
use spindle_firmware::receiver::{BAUD, PLACES, Receiver, Ring};
use spindle_firmware::spindle::DESIGN_0;
use spindle_monitor::Alarm;
use spindle_monitor::board::ResetCause;
use spindle_monitor::estimator::{KEPT, Kept};
use spindle_monitor::judgement::Levels;
use spindle_monitor::loads::{FrameCounts, FramedLoads, LoadSource};
use spindle_monitor::record::{self, LoadRecord};
use spindle_monitor::settings::MonitorSettings;
use spindle_monitor::{Identity, Judgement, Life, Store};
use std::cell::{Cell, RefCell};
use std::collections::VecDeque;
use std::rc::Rc;

static SETTINGS: MonitorSettings = {
    let mut settings = MonitorSettings::new(&DESIGN_0, 16);
    settings.alarms[Alarm::Overload as usize].hold_us = 0;
    settings.alarms[Alarm::Slip as usize].hold_us = 0;
    settings
};

const CORE_HZ: u32 = 168_000_000;
/// Of a byte with its start and stop bit, and of a tick.
const BYTE_NS: u64 = 10_000_000_000 / BAUD as u64;
const TICK_NS: u64 = 1_000_000;
/// Of the main program for a byte: some hundred cycles.
const LOOK_NS: u64 = 600;
const SECOND_NS: u64 = 1_000_000_000;

/// Where the hardware puts a byte that has come in.
enum Port {
    /// Into a register, from which an interrupt handler in the flash fetches it.
    OneByte {
        register: Option<u8>,
        queue: VecDeque<u8>,
        lost: u32,
    },
    /// Into the ring, by DMA.
    Ring {
        ring: &'static Ring,
        writes: Rc<Cell<usize>>,
    },
}

/// A board in time: its core, and a line that waits for nobody.
struct Board {
    now_ns: u64,
    port: Port,
    is_back_to_back: bool,
    /// Bytes of the record on the line, when the next of them is complete, and records so far.
    frame: VecDeque<u8>,
    next_ns: u64,
    records: u32,
    stall_ns: u64,
    /// Of the flash.
    bytes: Vec<u8>,
}

impl Board {
    fn new(port: Port, is_back_to_back: bool, stall_us: u64) -> Self {
        Self {
            now_ns: 0,
            port,
            is_back_to_back,
            frame: VecDeque::new(),
            next_ns: BYTE_NS,
            records: 0,
            stall_ns: 1000 * stall_us,
            bytes: vec![0xff; (SECTORS * SECTOR) as usize],
        }
    }

    /// Time goes on, while the core runs or stands still.
    fn pass(&mut self, ns: u64, is_running: bool) {
        self.now_ns += ns;
        while self.next_ns <= self.now_ns {
            if let Some(byte) = self.frame.pop_front() {
                self.arrives(byte, is_running);
            }
            if self.frame.is_empty() {
                self.records += 1;
                let record = LoadRecord {
                    sequence: self.records,
                    time_ms: (self.next_ns / 1_000_000) as u32,
                    fx: 420.0,
                    fy: self.records as f32,
                    fz: -8.0,
                    my: 0.05,
                    mz: -0.1,
                    speed_rpm: 12_000.0,
                };
                self.frame.extend(record::encode(&record));
                if !self.is_back_to_back {
                    self.next_ns = self.next_ns.next_multiple_of(TICK_NS);
                }
            }
            self.next_ns += BYTE_NS;
        }
        if is_running
            && let Port::OneByte {
                register, queue, ..
            } = &mut self.port
        {
            queue.extend(register.take());
        }
    }

    fn arrives(&mut self, byte: u8, is_running: bool) {
        match &mut self.port {
            Port::Ring { ring, writes } => {
                ring.put(writes.get(), byte);
                writes.set((writes.get() + 1) % PLACES);
            }
            Port::OneByte { queue, .. } if is_running => queue.push_back(byte),
            Port::OneByte { register, lost, .. } if register.is_some() => *lost += 1,
            Port::OneByte { register, .. } => *register = Some(byte),
        }
    }
}

/// The flash of such a board, whose core stands still while a word is written.
struct Words(Rc<RefCell<Board>>);

impl Cells for Words {
    const UNIT: usize = 4;

    fn read(&mut self, at: u32, unit: &mut [u8]) -> bool {
        let at = at as usize;
        unit.copy_from_slice(&self.0.borrow().bytes[at..at + unit.len()]);
        true
    }

    fn program(&mut self, at: u32, unit: &[u8]) -> bool {
        let (mut board, at) = (self.0.borrow_mut(), at as usize);
        board.bytes[at..at + unit.len()].copy_from_slice(unit);
        let stall_ns = board.stall_ns;
        board.pass(stall_ns, false);
        true
    }

    fn erase(&mut self, sector: u32) -> bool {
        let from = (sector * SECTOR) as usize;
        self.0.borrow_mut().bytes[from..from + SECTOR as usize].fill(0xff);
        true
    }
}

/// Result of a run of the main program.
struct Ran {
    /// Bytes that the port has lost, and counts of the records.
    lost: u32,
    counts: FrameCounts,
    records: u32,
    /// Times at which both copies of each record of the log were written, s.
    kept: Vec<f64>,
}

/// Times at which something new is to be kept, s.
const ALARM: f64 = 1.3;
const LATER_ALARM: f64 = 3.7;
const ESTIMATES: f64 = 15.0;

/// The main program, as `by_the_timer` has it: it takes bytes, writes the log between ticks, and ticks for so long.
fn run(has_ring: bool, is_back_to_back: bool, stall_us: u64, tick_us: u64, seconds: u64) -> Ran {
    let ring: &'static Ring = Box::leak(Box::new(Ring::zeroed()));
    let writes = Rc::new(Cell::new(0));
    let position = Rc::clone(&writes);
    let mut receiver = Receiver::new(ring, move || position.get());
    let port = if has_ring {
        Port::Ring { ring, writes }
    } else {
        Port::OneByte {
            register: None,
            queue: VecDeque::new(),
            lost: 0,
        }
    };
    let board = Rc::new(RefCell::new(Board::new(port, is_back_to_back, stall_us)));
    let words = Flash(Words(Rc::clone(&board)));
    let (mut store, _) = Store::open(words, Identity::of(1, 2), ResetCause::PowerOn);
    let (mut judgement, mut life) = (Judgement::default(), Life::NEW);
    life.set_damage(1e-3, 0.0);
    let mut estimates = None;
    let (mut pace, mut loads) = (Pace::new(CORE_HZ), FramedLoads::new());
    let (mut ticks, mut kept) = (0, Vec::new());
    let pass = |ns| board.borrow_mut().pass(ns, true);
    let now = || board.borrow().now_ns;
    while now() < seconds * SECOND_NS {
        loop {
            let byte = match &mut board.borrow_mut().port {
                Port::Ring { .. } => receiver.byte(),
                Port::OneByte { queue, .. } => queue.pop_front(),
            };
            let Some(byte) = byte else { break };
            loads.push(byte);
            pass(LOOK_NS);
        }
        let left_ns = ((ticks + 1) * TICK_NS).saturating_sub(now());
        if left_ns > 0 {
            let left = left_ns * u64::from(CORE_HZ / 1_000_000) / 1000;
            if !(pace.has_time(left as u32) && store.step()) {
                pass(left_ns.min(BYTE_NS));
            }
        } else {
            ticks = now() / TICK_NS;
            let (time_us, seconds) = (1000 * ticks, 1e-3 * ticks as f64);
            let _ = loads.sample(time_us);
            pass(1000 * tick_us);
            life.turn(1000.0, 1e-3, false, false);
            for (at, alarm) in [(ALARM, Alarm::Overload), (LATER_ALARM, Alarm::Slip)] {
                let mut levels = Levels::default();
                levels.set_value(alarm, if seconds < at { 0.0 } else { f32::INFINITY });
                let _ = judgement.judge(time_us, &levels, &SETTINGS.alarms, |_| 1000);
            }
            if seconds >= ESTIMATES {
                estimates = Some(Kept([1; KEPT]));
            }
            store.look(time_us, &judgement, &life, estimates);
            if pace.is_overdue() {
                store.step();
            }
        }
        let report = store.report();
        if report.written as usize == 2 * (kept.len() + 1) {
            kept.push(now() as f64 * 1e-9);
        }
    }
    assert_eq!(store.report().failed, 0);
    let board = board.borrow();
    Ran {
        lost: match &board.port {
            Port::Ring { .. } => receiver.lost(),
            Port::OneByte { lost, .. } => *lost,
        },
        counts: loads.counts(),
        records: board.records,
        kept,
    }
}

/// Times of the records are those of `docs/boards.md`, on a core that has time and on one that is always late.
#[test]
fn writing_the_log_loses_no_byte_of_the_ring_and_each_record_is_in_time() {
    for (is_back_to_back, stall_us, tick_us) in [
        (false, 16, 300),
        (false, 100, 300),
        (true, 16, 300),
        (true, 100, 300),
        (false, 100, 1000),
        (true, 100, 1000),
    ] {
        let case = (is_back_to_back, stall_us, tick_us);
        let ran = run(true, is_back_to_back, stall_us, tick_us, 140);
        let FrameCounts {
            received,
            corrupt,
            lost,
            disordered,
            ..
        } = ran.counts;
        assert_eq!(
            (ran.lost, corrupt, lost, disordered),
            (0, 0, 0, 0),
            "{case:?}"
        );
        assert!(u64::from(ran.records) - received <= 3, "{case:?}");
        let [start, alarm, later, estimates, life] = ran.kept[..] else {
            panic!("{case:?}: {:?}", ran.kept);
        };
        assert!(start <= 1.0, "{case:?}: {start}");
        assert!((ALARM..=ALARM + 1.0).contains(&alarm), "{case:?}: {alarm}");
        // Alarms are kept 10 s apart, and life two minutes after any record.
        let until = alarm + 10.0 + 1.0;
        assert!((LATER_ALARM..=until).contains(&later), "{case:?}: {later}");
        let until = ESTIMATES + 1.0;
        assert!(
            (ESTIMATES..=until).contains(&estimates),
            "{case:?}: {estimates}"
        );
        let until = estimates + 120.0 + 1.0;
        assert!((estimates..=until).contains(&life), "{case:?}: {life}");
    }
}

/// Loss without the ring: an interrupt handler in the flash fetches a byte only once the core goes on.
#[test]
fn a_port_of_one_byte_loses_some_while_a_word_is_written() {
    for (is_back_to_back, stall_us) in [(false, 16), (false, 100), (true, 16), (true, 100)] {
        let ran = run(false, is_back_to_back, stall_us, 300, 3);
        let damaged = ran.counts.corrupt + ran.counts.lost;
        assert!(ran.lost > 0 && damaged > 0, "{is_back_to_back} {stall_us}");
    }
}

/// The hardware goes round any number of times while nobody takes a byte.
#[test]
fn an_overrun_of_the_ring_is_told_however_often_it_went_round() {
    let ring: &'static Ring = Box::leak(Box::new(Ring::zeroed()));
    let writes = Rc::new(Cell::new(0));
    let position = Rc::clone(&writes);
    let mut receiver = Receiver::new(ring, move || position.get());
    let mut sent = 0_usize;
    let mut send = |bytes: usize| {
        for _ in 0..bytes {
            ring.put(writes.get(), sent as u8);
            writes.set((writes.get() + 1) % PLACES);
            sent += 1;
        }
        sent
    };
    let mut taken = 0;
    for bytes in [1, PLACES - 2, 7, PLACES - 1, 0, PLACES / 2, PLACES - 1] {
        let sent = send(bytes);
        while let Some(byte) = receiver.byte() {
            assert_eq!(byte, taken as u8);
            taken += 1;
        }
        assert_eq!((taken, receiver.lost()), (sent, 0));
    }
    let mut lost = 0;
    for bytes in [
        PLACES,
        PLACES + 1,
        2 * PLACES - 1,
        2 * PLACES,
        5 * PLACES + 3,
    ] {
        send(bytes);
        assert_eq!(receiver.byte(), None);
        let now = receiver.lost() as usize;
        assert!((1..=bytes).contains(&(now - lost)), "{bytes}");
        lost = now;
        // What comes then is whole.
        let next = send(0);
        send(5);
        let whole: Vec<_> = std::iter::from_fn(|| receiver.byte()).collect();
        assert_eq!(whole, [0, 1, 2, 3, 4].map(|i| (next + i) as u8));
        assert_eq!(receiver.lost() as usize, lost);
    }
}

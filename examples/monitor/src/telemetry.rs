//! Telemetry of the monitor: a versioned binary record, and the queue in which it waits for a link.
//!
//! A [`Frame`] goes out in the framing of [`framing`]: postcard, CRC-32, COBS. On the wire it is the fields of
//! [`Frame`] in their order. Integers are varints, floats four bytes, and enums the index of their variant. The
//! order in which fields and variants stand here *is* the format. A change of it is a new [`VERSION`], which older
//! receivers refuse as [`FrameError::Content`].
//!
//! | payload | when | in need |
//! | --- | --- | --- |
//! | [`Payload::Alarm`] | an alarm changed its state; again and again while it stands | never dropped |
//! | [`Payload::Answer`] | an operator has asked for something | no order is carried out before it is gone |
//! | [`Payload::Health`] | at a fixed interval | the newest is kept |
//! | [`Payload::Hello`] | at the start, at changes of the board, and once a minute | the newest is kept |
//! | [`Payload::Estimate`], [`Payload::Rows`] | at a fixed interval | the oldest is dropped, and counted |
//! | [`Payload::Probes`] | with the health reports of a spindle with probes | the oldest is dropped, and counted |
//! | [`Payload::Balls`] | at a fixed interval | the oldest is dropped, and counted |
//!
//! [`Outbox`](crate::outbox::Outbox) is the queue.

use crate::alarms::Alarm;
use crate::board::BoardReport;
use crate::command::{Answer, MOST_PROBES};
use crate::estimator::{Estimate, State};
use crate::framing::{self, CHECKSUM_LENGTH, FrameError};
use crate::judgement::{AlarmChange, AlarmState};
use crate::loads::FrameCounts;
use crate::marks::Marks;
use crate::retained::{RetentionReport, StartReport};
use crate::temperature::TemperatureSource;
use heapless::Vec;
use serde::{Deserialize, Serialize};
use spindle_bearing::{Frequencies, Limit, LimitSet, Status};

/// Version of the format.
pub const VERSION: u8 = 12;

/// Balls in one [`BallsReport`].
pub const BALLS_PER_FRAME: usize = 4;
/// Rows in one [`RowsReport`].
pub const ROWS_PER_FRAME: usize = 4;
/// Rows in a [`ShaftReport`]: a spindle's file has no more.
pub const MOST_ROWS: usize = 8;

/// Length of the longest message that a frame can become, checksum included.
///
/// Version, sequence, time and variant have 17 bytes. Then come the numbers of a [`HealthReport`]: 17 of 64 bits, four of 32, one
/// of 16, five floats and four names.
pub const MESSAGE_LENGTH: usize = 17 + (17 * 10 + 4 * 5 + 3 + 5 * 4 + 4) + CHECKSUM_LENGTH;

/// Length of the frame of the longest message, its delimiter included.
pub const FRAME_LENGTH: usize = framing::frame_length(MESSAGE_LENGTH);

/// Takes a stream of telemetry apart, byte by byte.
pub type FrameReader = framing::FrameReader<Frame, MESSAGE_LENGTH>;

/// One telemetry record.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Frame {
    /// [`VERSION`]. A frame of another version is not read.
    #[serde(deserialize_with = "framing::version::<_, VERSION>")]
    pub version: u8,
    /// Counts the frames that went out; wraps to 0.
    pub sequence: u32,
    /// Time of the monitor since its start, us.
    pub time_us: u64,
    /// Content of the frame.
    pub payload: Payload,
}

/// Content of a [`Frame`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
// Frames live in fixed memory, and the largest variant is what the queue must hold anyway.
#[allow(clippy::large_enum_variant)]
pub enum Payload {
    /// The last good estimate.
    Estimate(EstimateReport),
    /// Contact forces and angles of some balls of that estimate.
    Balls(BallsReport),
    /// An alarm's state.
    Alarm(AlarmReport),
    /// Counters.
    Health(HealthReport),
    /// Outcome of an operator's order.
    Answer(Answer),
    /// Forces, preload and frequencies of the rows of that estimate.
    Rows(RowsReport),
    /// Who is there: this start, the board, and the spindle.
    Hello(HelloReport),
    /// Estimates by the probes.
    Probes(ProbesReport),
}

/// The last good estimate, its age, and the doubts of now. SI units.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct EstimateReport {
    /// Ticks since the sample was taken that the estimate belongs to: 0 for one of this tick.
    pub age: u32,
    /// Doubts about the sample of this tick. If there are any, the estimate is an older one.
    pub marks: Marks,
    /// Loads `Fx, Fy, Fz` (N), `My, Mz` (N m) of the estimate.
    pub load: [f32; 5],
    /// Shaft speed `omega` of the estimate, rad/s.
    pub speed: f32,
    /// Displacements `dx, dy, dz` (m), `ty, tz` (rad) of the shaft at its nose, less what a flexible end yields by itself.
    pub displacement: [f32; 5],
    /// Stiffness at the nose, what a dial gauge there finds: `1 / C_ii` of the compliance `C`, N/m and N m/rad. One force or
    /// moment acts, all other displacements and tilts are free.
    pub stiffness: [f32; 5],
    /// `1 / C_ij` of the element that couples most: the load along `j` per motion along `i`. `f32::MAX` if nothing couples.
    pub coupling: f32,
    /// Its row `i`, 0 for x to 4 for the tilt about z.
    pub coupling_row: u8,
    /// Its column `j`.
    pub coupling_column: u8,
    /// Smallest contact force on the inner race, N; 0 if a ball is off that race.
    pub least_force: f32,
    /// Largest contact force on the inner race, N.
    pub largest_force: f32,
    /// How the last solve ended. If not with an answer, the estimate is an older one.
    pub status: Status<f32>,
    /// Iterations of the estimate.
    pub iterations: u16,
    /// Estimated relative errors of displacement, contact forces and the worst of `stiffness`. That of the displacement is the
    /// solver's and that by the accuracy of the loads; the others are the solver's alone. Where one is 1 or more, nothing is known.
    pub error: [f32; 3],
    /// Physical limits that were passed, one bit each ([`bits_of`]), and [`LIFT_OFF`].
    pub limits: u8,
}

impl EstimateReport {
    /// Of no equilibrium.
    pub const NONE: Self = Self {
        age: 0,
        marks: Marks::new(),
        load: [0.0; 5],
        speed: 0.0,
        displacement: [0.0; 5],
        stiffness: [0.0; 5],
        coupling: 0.0,
        coupling_row: 0,
        coupling_column: 1,
        least_force: 0.0,
        largest_force: 0.0,
        status: Status::Unloaded,
        iterations: 0,
        error: [0.0; 3],
        limits: 0,
    };

    /// Names of the physical limits that were passed, the most serious first, and `lift-off`.
    pub fn passed(&self) -> impl Iterator<Item = &'static str> {
        let bits = self.limits;
        let passed = Limit::ALL
            .into_iter()
            .filter(move |limit| bits & bits_of(LimitSet::default().with(*limit)) != 0);
        let lifted_off = (bits & LIFT_OFF != 0).then_some("lift-off");
        passed.map(Limit::name).chain(lifted_off)
    }
}

/// Bit of [`EstimateReport::limits`]: a row has lifted off, and no preload is left.
pub const LIFT_OFF: u8 = 1 << 6;

const _: () = assert!(Limit::ALL.len() <= 7);

/// Bits of passed limits in [`EstimateReport::limits`]: as the library numbers them, but for the bit of [`LIFT_OFF`].
pub const fn bits_of(passed: LimitSet) -> u8 {
    let bits = passed.bits();
    let below = bits & (LIFT_OFF - 1);
    below | (bits - below) << 1
}

/// Forces, preload and frequencies of the rows.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct RowsReport {
    /// Index of the first row in this frame.
    pub first: u8,
    /// Number of rows.
    pub count: u8,
    /// The rows from `first` on.
    pub rows: Vec<RowReport, ROWS_PER_FRAME>,
}

/// One row, N and Hz.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct RowReport {
    /// Axial force in the direction that presses its balls; not above 0 once it has lifted off.
    pub axial: f32,
    /// Radial force of the shaft on it, along y and z.
    pub radial: [f32; 2],
    /// Part of its axial force that is preload.
    pub preload: f32,
    /// Smallest and largest contact force on its inner race; 0 if a ball is off that race.
    pub least_force: f32,
    /// The largest one.
    pub largest_force: f32,
    /// Frequencies at which a defect of one of its parts vibrates, at the speed of the estimate.
    pub frequencies: Frequencies<f32>,
}

/// Estimates by the probes ([`estimator`](crate::estimator)).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ProbesReport {
    /// How the spindle stands.
    pub state: State,
    /// Preload of now, N; none without opposed rows.
    pub preload: Option<Estimate>,
    /// Its change since commissioning, part of 1; none before.
    pub change: Option<Estimate>,
    /// Load steps since the estimates began.
    pub steps: u32,
    /// Runout cannot be told from drift at the speed of now: nothing counts.
    pub aliased: bool,
    /// The probes, in the order of the spindle's file.
    pub probes: Vec<ProbeReport, MOST_PROBES>,
}

/// A probe.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ProbeReport {
    /// How it stands.
    pub state: State,
    /// Its gain: measured over computed motion, at the preload that is estimated.
    pub gain: Estimate,
    /// Measured over computed motion of its last steps, whether it follows the loads or not; none before the first.
    pub ratio: Option<f32>,
}

/// Who is there, for a host that joins in.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct HelloReport {
    /// This start, and the data kept from earlier ones.
    pub start: StartReport,
    /// Report of the board on itself.
    pub board: BoardReport,
    /// Places on the shaft.
    pub shaft: ShaftReport,
}

/// Places on the shaft, for a picture of it.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ShaftReport {
    /// Position of the nose, m.
    pub nose: f32,
    /// Position of the point that the measured moments are about, m.
    pub loads_at: f32,
    /// Preload of the mounted spindle, N; 0 if none is watched.
    pub preload: f32,
    /// Number of rows.
    pub count: u8,
    /// The first of the rows, which are all of a spindle's file.
    pub rows: Vec<RowPlace, MOST_ROWS>,
}

/// Where a row is.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct RowPlace {
    /// Position of its centre, m.
    pub position: f32,
    /// It faces `-x`: a load on the shaft in `-x` presses its balls.
    pub mirrored: bool,
    /// Number of its balls.
    pub balls: u16,
}

/// Contact forces and angles of some balls of a row, for a polar picture. The balls stand at equal angles,
/// from [`BallsReport::first_azimuth`] on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct BallsReport {
    /// Index of the row.
    pub row: u8,
    /// Index of the first ball in this frame, in its row.
    pub first: u16,
    /// Number of balls of the row.
    pub count: u16,
    /// Azimuth of the row's ball 0, rad from +y towards +z.
    pub first_azimuth: f32,
    /// The balls from `first` on.
    pub balls: Vec<BallReport, BALLS_PER_FRAME>,
}

/// One ball.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct BallReport {
    /// Inner contact force, N.
    pub q_i: f32,
    /// Outer contact force, N.
    pub q_o: f32,
    /// Inner contact angle, rad.
    pub alpha_i: f32,
    /// Outer contact angle, rad.
    pub alpha_o: f32,
}

/// An alarm's state, and what led to it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct AlarmReport {
    /// Which alarm.
    pub alarm: Alarm,
    /// Change that is reported.
    pub change: AlarmChange,
    /// Its state since then.
    pub state: AlarmState,
    /// Watched value, in the unit of [`Alarm`].
    pub value: f32,
    /// The limit that it is held against.
    pub limit: f32,
    /// The worst ball, counted on from row to row, or the worst probe, if it is about one.
    pub place: Option<u16>,
    /// Number of this start ([`StartReport::boots`]), which an acknowledgement repeats.
    pub start: u32,
    /// How often this alarm was raised since the start.
    pub raised: u32,
    /// How often its condition went away again.
    pub cleared: u32,
}

/// Counters since the start. None of them can overflow within a century.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct HealthReport {
    /// Ticks that finished.
    pub ticks: u64,
    /// Of these, ticks that took longer than their deadline.
    pub overruns: u64,
    /// Ticks that never began, because the one before took so long.
    pub missed_ticks: u64,
    /// Solves that gave an estimate.
    pub estimates: u64,
    /// Solves that were refused, or stopped short of an answer.
    pub refusals: u64,
    /// Ticks whose sample was doubted.
    pub marked_samples: u64,
    /// Alarms raised.
    pub alarms_raised: u64,
    /// Alarms whose condition went away.
    pub alarms_cleared: u64,
    /// Estimates and balls that were dropped because the link was too slow.
    pub frames_dropped: u64,
    /// Largest number of cycles that a tick took.
    pub most_cycles: u32,
    /// Revolutions of the shaft.
    pub revolutions: u64,
    /// Rating life used up, as a part of 1.
    pub life_used: f32,
    /// Every doubt that there was since the last health report.
    pub marks: Marks,
    /// Data kept over a power cycle.
    pub retention: RetentionReport,
    /// Share of ticks with a fresh estimate in the last second, a part of 1.
    pub availability: f32,
    /// Load records over the line; all 0 where loads come from elsewhere.
    pub records: FrameCounts,
    /// Revolutions at a doubtful speed or under doubtful loads.
    pub doubtful_revolutions: u64,
    /// Part of `life_used` that was counted between samples that were solved, by the cube of the loads.
    pub life_estimated: f32,
    /// Temperatures of the inner and of the outer side that are used, degrees Celsius.
    pub temperatures: [f32; 2],
    /// Where they come from.
    pub temperature_sources: [TemperatureSource; 2],
}

/// The frame of a record, delimiter included; empty if it is longer than any that this version knows.
pub fn encode(frame: &Frame) -> Vec<u8, FRAME_LENGTH> {
    framing::encode(frame).unwrap_or_default()
}

/// Result of a reader at the end of each frame.
pub type Read = Result<Frame, FrameError>;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::board::{Check, ResetCause};
    use crate::command::{AnswerCode, Order};
    use crate::marks::Mark;
    use crate::retained::Recovery;
    use enumset::EnumSet;
    use std::vec::Vec as Bytes;

    fn longest(payload: Payload) -> Frame {
        Frame {
            version: VERSION,
            sequence: u32::MAX,
            time_us: u64::MAX,
            payload,
        }
    }

    fn balls() -> Payload {
        let ball = BallReport {
            q_i: f32::MAX,
            q_o: f32::MAX,
            alpha_i: f32::MAX,
            alpha_o: f32::MAX,
        };
        Payload::Balls(BallsReport {
            row: u8::MAX,
            first: u16::MAX,
            count: u16::MAX,
            first_azimuth: f32::MAX,
            balls: Vec::from_array([ball; BALLS_PER_FRAME]),
        })
    }

    fn estimate(iterations: u16) -> Payload {
        Payload::Estimate(EstimateReport {
            age: u32::MAX,
            marks: Marks::all(),
            load: [f32::MAX; 5],
            speed: f32::MAX,
            displacement: [f32::MAX; 5],
            stiffness: [f32::MAX; 5],
            coupling: f32::MAX,
            coupling_row: u8::MAX,
            coupling_column: u8::MAX,
            least_force: f32::MAX,
            largest_force: f32::MAX,
            status: Status::OutOfRange {
                quantity: spindle_bearing::Quantity::Tolerance,
                value: f32::MAX,
                limit: f32::MAX,
            },
            iterations,
            error: [f32::MAX; 3],
            limits: u8::MAX,
        })
    }

    fn alarm(alarm: Alarm, change: AlarmChange, raised: u32) -> Payload {
        Payload::Alarm(AlarmReport {
            alarm,
            change,
            state: AlarmState::Raised,
            value: f32::MAX,
            limit: f32::MAX,
            place: Some(u16::MAX),
            start: u32::MAX,
            raised,
            cleared: u32::MAX,
        })
    }

    fn health() -> Payload {
        Payload::Health(HealthReport {
            ticks: u64::MAX,
            overruns: u64::MAX,
            missed_ticks: u64::MAX,
            estimates: u64::MAX,
            refusals: u64::MAX,
            marked_samples: u64::MAX,
            alarms_raised: u64::MAX,
            alarms_cleared: u64::MAX,
            frames_dropped: u64::MAX,
            most_cycles: u32::MAX,
            revolutions: u64::MAX,
            life_used: f32::MAX,
            marks: Marks::all(),
            retention: RetentionReport {
                recovery: Recovery::Damaged,
                estimates: Recovery::Damaged,
                damaged: u16::MAX,
                written: u32::MAX,
                failed: u32::MAX,
            },
            availability: f32::MAX,
            records: FrameCounts {
                received: u64::MAX,
                corrupt: u64::MAX,
                lost: u64::MAX,
                disordered: u64::MAX,
                passed_over: u64::MAX,
                late: u64::MAX,
            },
            doubtful_revolutions: u64::MAX,
            life_estimated: f32::MAX,
            temperatures: [f32::MAX; 2],
            temperature_sources: [TemperatureSource::Assumed; 2],
        })
    }

    fn answer() -> Payload {
        Payload::Answer(Answer {
            number: u16::MAX,
            order: Order::Acknowledge {
                alarm: Alarm::Deadline,
                start: u32::MAX,
                raised: u32::MAX,
            },
            outcome: AnswerCode::NoSuchOccurrence,
        })
    }

    fn frequencies([cage, outer_race, inner_race, ball]: [f32; 4]) -> Frequencies<f32> {
        let mut frequencies = Frequencies::default();
        (frequencies.cage, frequencies.ball) = (cage, ball);
        (frequencies.outer_race, frequencies.inner_race) = (outer_race, inner_race);
        frequencies
    }

    fn rows() -> Payload {
        let row = RowReport {
            axial: f32::MAX,
            radial: [f32::MAX; 2],
            preload: f32::MAX,
            least_force: f32::MAX,
            largest_force: f32::MAX,
            frequencies: frequencies([f32::MAX; 4]),
        };
        Payload::Rows(RowsReport {
            first: u8::MAX,
            count: u8::MAX,
            rows: Vec::from_array([row; ROWS_PER_FRAME]),
        })
    }

    fn probes() -> Payload {
        let estimate = Estimate {
            value: f32::MAX,
            error: f32::MAX,
        };
        let probe = ProbeReport {
            state: State::Ok,
            gain: estimate,
            ratio: Some(f32::MAX),
        };
        Payload::Probes(ProbesReport {
            state: State::Ok,
            preload: Some(estimate),
            change: Some(estimate),
            steps: u32::MAX,
            aliased: true,
            probes: Vec::from_array([probe; MOST_PROBES]),
        })
    }

    fn hello() -> Payload {
        let place = RowPlace {
            position: f32::MAX,
            mirrored: true,
            balls: u16::MAX,
        };
        Payload::Hello(HelloReport {
            start: StartReport {
                boots: u32::MAX,
                cause: ResetCause::Unknown,
                alarms: EnumSet::all(),
                raised: [u8::MAX; Alarm::COUNT],
            },
            board: BoardReport {
                known_answer: Check::Failed,
                image: Check::Failed,
                unused_stack: Some(u32::MAX),
                brown_out: Some(u8::MAX),
            },
            shaft: ShaftReport {
                nose: f32::MAX,
                loads_at: f32::MAX,
                preload: f32::MAX,
                count: u8::MAX,
                rows: Vec::from_array([place; MOST_ROWS]),
            },
        })
    }

    fn read(bytes: &[u8]) -> Bytes<Read> {
        let mut reader = FrameReader::new();
        bytes.iter().filter_map(|b| reader.push(*b)).collect()
    }

    #[test]
    fn the_longest_frames_fit_and_arrive_as_they_left() {
        for payload in [
            balls(),
            estimate(u16::MAX),
            alarm(Alarm::Deadline, AlarmChange::Standing, u32::MAX),
            health(),
            answer(),
            rows(),
            hello(),
            probes(),
        ] {
            let frame = longest(payload);
            let bytes = encode(&frame);
            assert!(!bytes.is_empty(), "{frame:?}");
            if matches!(frame.payload, Payload::Health(_)) {
                assert!(bytes.len() + 2 >= FRAME_LENGTH);
            }
            assert_eq!(read(&bytes), [Ok(frame)]);
        }
    }

    #[test]
    fn a_frame_of_another_version_is_refused_as_content() {
        let frame = Frame {
            version: VERSION + 1,
            ..longest(health())
        };
        assert_eq!(read(&encode(&frame)), [Err(FrameError::Content)]);
    }

    /// Receivers know alarms by these numbers, marks and limits by these bits: none moves for a new one.
    #[test]
    fn numbers_of_alarms_and_bits_of_marks_and_limits_are_these() {
        let numbers = Alarm::ALL.map(|alarm| {
            let mut bytes = [0; 4];
            (
                postcard::to_slice(&alarm, &mut bytes).unwrap()[0],
                alarm.name(),
            )
        });
        let names = [
            "peak-pressure",
            "contact-angle",
            "slip",
            "unloaded-balls",
            "preload-growth",
            "preload-loss",
            "overload",
            "life-used",
            "sensor",
            "temperature",
            "availability",
            "deadline",
            "stiffness-loss",
            "stiffness-gain",
            "probe",
            "preload-change",
        ];
        assert_eq!(numbers, core::array::from_fn(|i| (i as u8, names[i])));
        for (i, alarm) in Alarm::ALL.into_iter().enumerate() {
            assert_eq!(EnumSet::only(alarm).as_repr(), 1 << i);
        }
        let marks = [
            "not-finite",
            "range",
            "rate",
            "stuck",
            "saturated",
            "missing",
            "disagreement",
            "bus",
            "corrupt",
            "order",
            "untared",
            "temperature",
            "speed-missing",
            "speed-range",
            "speed-rate",
            "speed-disagreement",
            "unsolved",
            "no-estimate",
            "late",
            "speed-stuck",
        ];
        assert_eq!(Marks::all().len(), marks.len());
        for (i, (mark, name)) in Marks::all().iter().zip(marks).enumerate() {
            let mut bytes = [0; 5];
            let bytes = postcard::to_slice(&Marks::only(mark), &mut bytes).unwrap();
            let number = postcard::from_bytes::<u32>(bytes).unwrap();
            assert_eq!((number, mark.name()), (1 << i, name));
        }
        for (limits, name) in [
            (1, "peak-pressure"),
            (2, "shoulder"),
            (4, "truncation"),
            (8, "reversal"),
            (16, "friction"),
            (32, "inner-contact"),
            (64, "lift-off"),
        ] {
            let report = EstimateReport {
                limits,
                ..EstimateReport::NONE
            };
            assert!(report.passed().eq([name]));
        }
    }

    /// Bytes of numbers of four bytes.
    fn floats<const K: usize>(numbers: [f32; K]) -> Bytes<u8> {
        numbers.map(f32::to_le_bytes).concat()
    }

    /// The bytes that a decoder in another language has to expect of every payload. Other bytes are a new [`VERSION`].
    #[test]
    fn the_wire_format_of_every_payload_is_that_of_its_version() {
        let estimate = Payload::Estimate(EstimateReport {
            age: 300,
            marks: Mark::Stuck | Mark::SpeedStuck,
            load: [1.0, 2.0, 3.0, 4.0, 5.0],
            speed: 6.0,
            displacement: [7.0, 8.0, 9.0, 10.0, 11.0],
            stiffness: [12.0, 13.0, 14.0, 15.0, 16.0],
            coupling: 17.0,
            coupling_row: 4,
            coupling_column: 200,
            least_force: 18.0,
            largest_force: 19.0,
            status: Status::Unseated {
                ball: 300,
                apart: 20.0,
            },
            iterations: 301,
            error: [21.0, 22.0, 23.0],
            limits: 0x81,
        });
        let of_estimate = [
            &[0xac, 0x02, 0x88, 0x80, 0x20],
            &*floats([1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 11.0]),
            &floats([12.0, 13.0, 14.0, 15.0, 16.0, 17.0]),
            &[4, 200],
            &floats([18.0, 19.0]),
            &[3, 0xac, 0x02],
            &floats([20.0]),
            &[0xad, 0x02],
            &floats([21.0, 22.0, 23.0]),
            &[0x81],
        ]
        .concat();
        let ball = BallReport {
            q_i: 1.0,
            q_o: 2.0,
            alpha_i: 3.0,
            alpha_o: 4.0,
        };
        let balls = Payload::Balls(BallsReport {
            row: 200,
            first: 300,
            count: 301,
            first_azimuth: 5.0,
            balls: Vec::from_iter([ball]),
        });
        let of_balls = [
            &[200, 0xac, 0x02, 0xad, 0x02],
            &*floats([5.0]),
            &[1],
            &floats([1.0, 2.0, 3.0, 4.0]),
        ]
        .concat();
        let alarm = Payload::Alarm(AlarmReport {
            alarm: Alarm::PreloadLoss,
            change: AlarmChange::Cleared,
            state: AlarmState::Acknowledged,
            value: 1.0,
            limit: 0.5,
            place: Some(300),
            start: 302,
            raised: 301,
            cleared: 2,
        });
        let of_alarm = [
            &[5, 1, 3],
            &*floats([1.0, 0.5]),
            &[1, 0xac, 0x02, 0xae, 0x02, 0xad, 0x02, 2],
        ]
        .concat();
        let health = Payload::Health(HealthReport {
            ticks: 300,
            overruns: 1,
            missed_ticks: 2,
            estimates: 3,
            refusals: 4,
            marked_samples: 5,
            alarms_raised: 6,
            alarms_cleared: 7,
            frames_dropped: 8,
            most_cycles: 301,
            revolutions: 9,
            life_used: 1.0,
            marks: Marks::only(Mark::Range),
            retention: RetentionReport {
                recovery: Recovery::Recovered,
                estimates: Recovery::OtherSpindle,
                damaged: 302,
                written: 10,
                failed: 11,
            },
            availability: 2.0,
            records: FrameCounts {
                received: 12,
                corrupt: 13,
                lost: 14,
                disordered: 15,
                passed_over: 16,
                late: 17,
            },
            doubtful_revolutions: 18,
            life_estimated: 3.0,
            temperatures: [4.0, 5.0],
            temperature_sources: [TemperatureSource::Measured, TemperatureSource::Assumed],
        });
        let of_health = [
            &[0xac, 0x02, 1, 2, 3, 4, 5, 6, 7, 8, 0xad, 0x02, 9],
            &*floats([1.0]),
            &[2, 2, 3, 0xae, 0x02, 10, 11],
            &floats([2.0]),
            &[12, 13, 14, 15, 16, 17, 18],
            &floats([3.0, 4.0, 5.0]),
            &[1, 3],
        ]
        .concat();
        let answer = Payload::Answer(Answer {
            number: 300,
            order: Order::Acknowledge {
                alarm: Alarm::Probe,
                start: 302,
                raised: 301,
            },
            outcome: AnswerCode::Learning,
        });
        let of_answer = [0xac, 0x02, 0, 14, 0xae, 0x02, 0xad, 0x02, 4].to_vec();
        let row = RowReport {
            axial: 1.0,
            radial: [2.0, 3.0],
            preload: 4.0,
            least_force: 5.0,
            largest_force: 6.0,
            frequencies: frequencies([7.0, 8.0, 9.0, 10.0]),
        };
        let rows = Payload::Rows(RowsReport {
            first: 4,
            count: 200,
            rows: Vec::from_iter([row]),
        });
        let of_rows = [
            &[4, 200, 1],
            &*floats([1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0]),
        ]
        .concat();
        let place = RowPlace {
            position: -0.5,
            mirrored: true,
            balls: 300,
        };
        let hello = Payload::Hello(HelloReport {
            start: StartReport {
                boots: 300,
                cause: ResetCause::Watchdog,
                alarms: EnumSet::only(Alarm::LifeUsed),
                raised: core::array::from_fn(|i| 200 + i as u8),
            },
            board: BoardReport {
                known_answer: Check::Passed,
                image: Check::Failed,
                unused_stack: Some(301),
                brown_out: Some(200),
            },
            shaft: ShaftReport {
                nose: 1.0,
                loads_at: 0.5,
                preload: 2.0,
                count: 1,
                rows: Vec::from_iter([place]),
            },
        });
        let of_hello = [
            &[0xac, 0x02, 3, 0x80, 0x01],
            &(200..216).collect::<Bytes<u8>>()[..],
            &[2, 3, 1, 0xad, 0x02, 1, 200],
            &floats([1.0, 0.5, 2.0]),
            &[1, 1],
            &floats([-0.5]),
            &[1, 0xac, 0x02],
        ]
        .concat();
        let one = |value: f32, error: f32| Estimate { value, error };
        let probe = ProbeReport {
            state: State::Learning,
            gain: one(1.0, 0.5),
            ratio: Some(2.0),
        };
        let probes = Payload::Probes(ProbesReport {
            state: State::Unknown,
            preload: Some(one(3.0, 4.0)),
            change: Some(one(5.0, 6.0)),
            steps: 300,
            aliased: true,
            probes: Vec::from_iter([probe]),
        });
        let of_probes = [
            &[7, 1],
            &*floats([3.0, 4.0]),
            &[1],
            &*floats([5.0, 6.0]),
            &[0xac, 0x02, 1, 1, 6],
            &*floats([1.0, 0.5]),
            &[1],
            &*floats([2.0]),
        ]
        .concat();
        for (number, payload, content) in [
            (0, estimate, of_estimate),
            (1, balls, of_balls),
            (2, alarm, of_alarm),
            (3, health, of_health),
            (4, answer, of_answer),
            (5, rows, of_rows),
            (6, hello, of_hello),
            (7, probes, of_probes),
        ] {
            let frame = Frame {
                version: VERSION,
                sequence: 300,
                time_us: 5,
                payload,
            };
            let mut bytes = [0; MESSAGE_LENGTH];
            let bytes = postcard::to_slice(&frame, &mut bytes).unwrap();
            let expected = [&[12, 0xac, 0x02, 5, number], &*content].concat();
            assert_eq!(bytes, expected, "{frame:?}");
        }
    }
}

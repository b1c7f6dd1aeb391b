//! Telemetry on the host: nothing undamaged is lost, nothing missing goes unnoticed, and the table holds all
//! of it.

use crate::frames::{
    alarm, balls, balls_of, estimate, frame, health, pair, rows, shaft, state_of, stream,
};
use host_tests::loads::{self, LoadRow};
use host_tests::milling_cycle::record_of;
use host_tests::telemetry::decoder::{Decoder, Event, Gap};
use host_tests::telemetry::operator::Operator;
use host_tests::telemetry::simulated::monitored::ROWS;
use host_tests::telemetry::state::{At, HISTORY, State, facing};
use host_tests::telemetry::{simulated, table};
use proptest::prelude::*;
use spindle_bearing::Facing;
use spindle_bearing::monitor::board::{BoardReport, Check, ResetCause};
use spindle_bearing::monitor::command::{self, Answer, Command, Order, PortReader, Received};
use spindle_bearing::monitor::judgement::{Alarm, AlarmChange, AlarmState};
use spindle_bearing::monitor::learning::{Learning, LearningReport};
use spindle_bearing::monitor::loads::FrameCounts;
use spindle_bearing::monitor::telemetry::{
    AlarmReport, BALLS_PER_FRAME, BallReport, BallsReport, EstimateReport, Frame, HealthReport,
    InputsReport, Payload, ROWS_PER_FRAME, Recovery, RetentionReport, RowPlace, RowReport,
    RowsReport, ShaftReport, StartReport, StatusCode, VERSION, encode,
};
use spindle_bearing::monitor::{Mark, Marks, TemperatureSource};

pub(super) fn decoded(bytes: &[u8]) -> (Vec<Event>, Decoder) {
    let mut decoder = Decoder::new();
    let events = decoder.push_all(bytes).collect();
    (events, decoder)
}

pub(super) fn frames_of(events: &[Event]) -> Vec<&Frame> {
    let frames = events.iter().filter_map(|event| match event {
        Event::Frame { frame, .. } => Some(frame),
        Event::Damaged(_) => None,
    });
    frames.collect()
}

/// The recording up to a time, and what the monitor sends of it.
pub(super) fn cycle(seconds: f64) -> (Vec<LoadRow>, Vec<u8>) {
    let rows: Result<Vec<_>, _> = loads::read(record_of(ROWS))
        .unwrap()
        .take_while(|row| row.as_ref().is_ok_and(|row| row.time_s < seconds))
        .collect();
    let rows = rows.unwrap();
    let bytes = simulated::stream(&rows).unwrap();
    (rows, bytes)
}

// Numbers that are none are the same in the table whatever their bits, so that they are left out where
// frames are compared.
prop_compose! {
    fn any_estimate()(
        (age, iterations) in any::<(u32, u16)>(),
        marks in prop::collection::vec(prop::sample::select(Mark::ALL.to_vec()), 0..5),
        floats in prop::array::uniform25(number()),
        (coupling_row, coupling_column) in any::<(u8, u8)>(),
        status in prop::sample::select(vec![
            StatusCode::Converged,
            StatusCode::PrecisionLimit,
            StatusCode::Unseated,
            StatusCode::Diverged,
        ]),
        limits in 0..64_u8,
    ) -> EstimateReport {
        let five = |at: usize| core::array::from_fn(|i| floats[at + i]);
        EstimateReport {
            age,
            marks: marks.into_iter().fold(Marks::NONE, Marks::with),
            load: five(0),
            speed: floats[5],
            displacement: five(6),
            stiffness: five(11),
            nose: [floats[22], floats[23], floats[24]],
            coupling: floats[16],
            coupling_row,
            coupling_column,
            least_force: floats[17],
            largest_force: floats[18],
            status,
            iterations,
            error: [floats[19], floats[20], floats[21]],
            limits,
        }
    }
}

fn number() -> impl Strategy<Value = f32> {
    prop::num::f32::NORMAL
        | prop::num::f32::SUBNORMAL
        | prop::num::f32::ZERO
        | prop::num::f32::INFINITE
}

prop_compose! {
    fn any_balls()(
        (row, first, count) in any::<(u8, u16, u16)>(),
        first_azimuth in number(),
        balls in prop::collection::vec(prop::array::uniform4(number()), 0..=BALLS_PER_FRAME),
    ) -> BallsReport {
        let ball = |[q_i, q_o, alpha_i, alpha_o]: [f32; 4]| BallReport { q_i, q_o, alpha_i, alpha_o };
        BallsReport {
            row,
            first,
            count,
            first_azimuth,
            balls: balls.into_iter().map(ball).collect(),
        }
    }
}

prop_compose! {
    fn any_rows()(
        (first, count) in any::<(u8, u8)>(),
        rows in prop::collection::vec(prop::array::uniform6(number()), 0..=ROWS_PER_FRAME),
    ) -> RowsReport {
        let row = |[axial, y, z, preload, least_force, largest_force]: [f32; 6]| RowReport {
            axial,
            radial: [y, z],
            preload,
            least_force,
            largest_force,
        };
        RowsReport { first, count, rows: rows.into_iter().map(row).collect() }
    }
}

prop_compose! {
    fn any_shaft()(
        [nose, loads_at, preload] in prop::array::uniform3(number()),
        count in any::<u8>(),
        rows in prop::collection::vec((number(), any::<bool>(), any::<u16>()), 0..=ROWS_PER_FRAME),
    ) -> ShaftReport {
        let place = |(position, mirrored, balls)| RowPlace { position, mirrored, balls };
        ShaftReport { nose, loads_at, preload, count, rows: rows.into_iter().map(place).collect() }
    }
}

prop_compose! {
    fn any_alarm()(
        alarm in prop::sample::select(Alarm::ALL.to_vec()),
        change in prop::sample::select(vec![
            AlarmChange::Raised,
            AlarmChange::Cleared,
            AlarmChange::Acknowledged,
            AlarmChange::Standing,
        ]),
        state in prop::sample::select(vec![
            AlarmState::Clear,
            AlarmState::Pending,
            AlarmState::Raised,
            AlarmState::Acknowledged,
            AlarmState::Latched,
        ]),
        (value, limit) in (number(), number()),
        ball in any::<Option<u16>>(),
        (raised, cleared) in any::<(u32, u32)>(),
    ) -> AlarmReport {
        AlarmReport { alarm, change, state, value, limit, ball, raised, cleared }
    }
}

prop_compose! {
    fn any_health()(
        counts in prop::array::uniform10(any::<u64>()),
        most_cycles in any::<u32>(),
        life_used in number(),
        marks in prop::collection::vec(prop::sample::select(Mark::ALL.to_vec()), 0..5),
        retention in any_retention(),
        availability in prop::array::uniform2(number()),
        state in prop::sample::select(Learning::ALL.to_vec()),
        bands in any::<u8>(),
    ) -> HealthReport {
        HealthReport {
            ticks: counts[0],
            overruns: counts[1],
            missed_ticks: counts[2],
            estimates: counts[3],
            refusals: counts[4],
            marked_samples: counts[5],
            alarms_raised: counts[6],
            alarms_cleared: counts[7],
            frames_dropped: counts[8],
            most_cycles,
            revolutions: counts[9],
            life_used,
            marks: marks.into_iter().fold(Marks::NONE, Marks::with),
            retention,
            availability,
            learning: LearningReport { state, bands },
        }
    }
}

prop_compose! {
    fn any_retention()(
        baseline in prop::sample::select(Recovery::ALL.to_vec()),
        life in prop::sample::select(Recovery::ALL.to_vec()),
        damaged in any::<u16>(),
        (written, failed) in any::<(u32, u32)>(),
    ) -> RetentionReport {
        RetentionReport { baseline, life, damaged, written, failed }
    }
}

prop_compose! {
    fn any_inputs()(
        counts in prop::array::uniform7(any::<u64>()),
        life_estimated in number(),
        nonce in any::<u32>(),
        temperatures in prop::array::uniform2(number()),
        temperature_sources in
            prop::array::uniform2(prop::sample::select(TemperatureSource::ALL.to_vec())),
    ) -> InputsReport {
        let [received, corrupt, lost, disordered, passed_over, late, doubtful_revolutions] = counts;
        InputsReport {
            records: FrameCounts { received, corrupt, lost, disordered, passed_over, late },
            doubtful_revolutions,
            life_estimated,
            nonce,
            temperatures,
            temperature_sources,
        }
    }
}

prop_compose! {
    fn any_answer()(
        number in any::<u16>(),
        order in prop_oneof![
            (prop::sample::select(Alarm::ALL.to_vec()), any::<u32>())
                .prop_map(|(alarm, raised)| Order::Acknowledge { alarm, raised }),
            any::<bool>().prop_map(Order::Learn),
            Just(Order::ReplaceBearing),
        ],
        outcome in prop::sample::select(command::AnswerCode::ALL.to_vec()),
        nonce in any::<u32>(),
    ) -> Answer {
        Answer { number, order, outcome, nonce }
    }
}

prop_compose! {
    fn any_board()(
        checks in prop::array::uniform2(prop::sample::select(Check::ALL.to_vec())),
        unused_stack in any::<Option<u32>>(),
        brown_out in any::<Option<u8>>(),
    ) -> BoardReport {
        let [known_answer, image] = checks;
        BoardReport { known_answer, image, unused_stack, brown_out }
    }
}

prop_compose! {
    fn any_start()(
        boots in any::<u32>(),
        cause in prop::sample::select(ResetCause::ALL.to_vec()),
        recovery in prop::sample::select(Recovery::ALL.to_vec()),
        alarms in any::<u32>(),
        raised in any::<[u16; Alarm::COUNT]>(),
    ) -> StartReport {
        StartReport { boots, cause, recovery, alarms, raised }
    }
}

fn any_payload() -> impl Strategy<Value = Payload> {
    prop_oneof![
        any_estimate().prop_map(Payload::Estimate),
        any_balls().prop_map(Payload::Balls),
        any_rows().prop_map(Payload::Rows),
        any_shaft().prop_map(Payload::Shaft),
        any_alarm().prop_map(Payload::Alarm),
        any_health().prop_map(Payload::Health),
        any_inputs().prop_map(Payload::Inputs),
        any_answer().prop_map(Payload::Answer),
        any_board().prop_map(Payload::Board),
        any_start().prop_map(Payload::Start),
    ]
}

/// Frames with consecutive numbers, which may wrap.
fn any_frames() -> impl Strategy<Value = Vec<Frame>> {
    let payloads = prop::collection::vec((any::<u64>(), any_payload()), 2..12);
    (any::<u32>(), payloads).prop_map(|(first, payloads)| {
        let number = |i: usize| first.wrapping_add(i as u32);
        let frames = payloads.into_iter().enumerate();
        frames
            .map(|(i, (time_us, payload))| Frame {
                version: VERSION,
                sequence: number(i),
                time_us,
                payload,
            })
            .collect()
    })
}

proptest! {
    #[test]
    fn an_undamaged_stream_arrives_whole_and_counts_nothing_as_lost(frames in any_frames()) {
        let bytes = stream(&frames);
        let (events, decoder) = decoded(&bytes);
        prop_assert_eq!(frames_of(&events), frames.iter().collect::<Vec<_>>());
        let tally = decoder.tally();
        prop_assert_eq!(tally.bytes, bytes.len() as u64);
        prop_assert_eq!(tally.frames, frames.len() as u64);
        prop_assert_eq!((tally.lost, tally.damaged, tally.restarts), (0, 0, 0));
    }

    /// Bytes changed, removed and put in between: whatever frame they leave alone, and whose delimiter
    /// before it arrives, is there in the end.
    #[test]
    fn every_undamaged_frame_after_the_next_delimiter_is_recovered(
        frames in any_frames(),
        hits in prop::collection::vec((any::<prop::sample::Index>(), 0..3_u8, any::<u8>()), 1..6),
    ) {
        let mut pieces: Vec<Vec<u8>> = frames.iter().map(|frame| encode(frame).to_vec()).collect();
        let mut is_hit = vec![false; frames.len()];
        for (at, how, byte) in hits {
            let which = at.index(frames.len());
            is_hit[which] = true;
            let piece = &mut pieces[which];
            let place = at.index(piece.len().max(1));
            match how {
                0 if place < piece.len() => piece[place] ^= byte.max(1),
                1 if place < piece.len() => drop(piece.remove(place)),
                _ => piece.insert(place, byte),
            }
        }
        let bytes = pieces.concat();
        let (events, decoder) = decoded(&bytes);
        let arrived = frames_of(&events);
        for (i, frame) in frames.iter().enumerate() {
            let begins_clean = i == 0 || pieces[i - 1].last() == Some(&0);
            if !is_hit[i] && begins_clean {
                prop_assert!(arrived.contains(&frame), "frame {i} is lost");
            }
        }
        // No damaged frame passes for another one.
        for frame in &arrived {
            prop_assert!(frames.contains(frame));
        }
        let tally = decoder.tally();
        prop_assert_eq!(tally.frames, arrived.len() as u64);
        prop_assert_eq!(tally.restarts, 0);
        // Between the first and the last that arrived, every other one is counted.
        if let (Some(first), Some(last)) = (arrived.first(), arrived.last()) {
            let span = u64::from(last.sequence.wrapping_sub(first.sequence)) + 1;
            prop_assert_eq!(tally.frames + tally.lost, span);
        }
    }

    #[test]
    fn frames_taken_out_are_counted_where_they_are_missing(
        frames in any_frames(),
        kept in prop::collection::vec(any::<bool>(), 12),
    ) {
        let left: Vec<Frame> = frames
            .iter()
            .zip(&kept)
            .filter(|(_, kept)| **kept)
            .map(|(frame, _)| frame.clone())
            .collect();
        let (events, _) = decoded(&stream(&left));
        let mut before: Option<u32> = None;
        for event in &events {
            let Event::Frame { frame, gap } = event else {
                return Err(TestCaseError::fail("nothing was damaged"));
            };
            let missing = before.map_or(0, |n| frame.sequence.wrapping_sub(n) - 1);
            let expected = if missing == 0 { Gap::None } else { Gap::Lost(missing) };
            prop_assert_eq!(*gap, expected);
            before = Some(frame.sequence);
        }
    }

    #[test]
    fn garbage_is_damage_and_the_frame_after_it_is_read(
        garbage in prop::collection::vec(any::<u8>(), 0..2000),
    ) {
        let whole = frame(7, Payload::Health(health()));
        let mut bytes = garbage;
        bytes.push(0);
        bytes.extend(encode(&whole));
        let (events, decoder) = decoded(&bytes);
        prop_assert_eq!(frames_of(&events), [&whole]);
        prop_assert_eq!(decoder.tally().damaged as usize, events.len() - 1);
    }

    #[test]
    fn the_table_holds_every_frame_to_the_last_bit(frames in any_frames()) {
        let (events, _) = decoded(&stream(&frames));
        let mut out = Vec::new();
        let mut writer = table::Writer::new(&mut out);
        for event in &events {
            writer.write(event).unwrap();
        }
        writer.flush().unwrap();
        drop(writer);
        prop_assert_eq!(table::read(out.as_slice()).unwrap(), frames);
    }
}

#[test]
fn numbers_that_wrap_are_no_gap_and_numbers_that_go_back_are_a_restart() {
    let health = |n| frame(n, Payload::Health(health()));
    let frames = [u32::MAX - 1, u32::MAX, 0, 1, 5, 3, 6, 0, 1, 2].map(health);
    let (events, decoder) = decoded(&stream(&frames));
    let gaps: Vec<Gap> = events
        .iter()
        .map(|event| match event {
            Event::Frame { gap, .. } => *gap,
            Event::Damaged(error) => panic!("{error}"),
        })
        .collect();
    let (none, lost) = (Gap::None, Gap::Lost(3));
    let (behind, restart) = (Gap::Behind, Gap::Restart);
    assert_eq!(
        gaps,
        [
            none, none, none, none, lost, behind, none, behind, restart, none
        ]
    );
    let tally = decoder.tally();
    assert_eq!((tally.lost, tally.behind, tally.restarts), (3, 2, 1));
}

#[test]
fn a_frame_of_another_version_is_told_from_damage() {
    let other = Frame {
        version: VERSION + 1,
        ..frame(0, Payload::Health(health()))
    };
    let mut bytes = encode(&other).to_vec();
    bytes.extend([3, 1, 1, 0]);
    let tally = decoded(&bytes).1.tally();
    assert_eq!((tally.damaged, tally.foreign), (2, 1));
}

#[test]
fn damage_has_a_row_of_its_own_and_a_gap_is_in_the_row_after_it() {
    let mut bytes = encode(&frame(0, balls(&[1.0; 8])[0].clone())).to_vec();
    bytes.extend([9, 1, 1, 0]);
    bytes.extend(encode(&frame(3, balls(&[1.0; 8])[0].clone())));
    let mut out = Vec::new();
    let mut writer = table::Writer::new(&mut out);
    for event in &decoded(&bytes).0 {
        writer.write(event).unwrap();
    }
    writer.flush().unwrap();
    drop(writer);
    let text = String::from_utf8(out.clone()).unwrap();
    let kinds: Vec<&str> = text
        .lines()
        .skip(1)
        .filter_map(|l| l.split(',').next())
        .collect();
    assert_eq!(kinds.iter().filter(|kind| **kind == "damaged").count(), 1);
    assert_eq!(kinds.len(), 17);
    let lost: u32 = text
        .lines()
        .filter(|line| line.starts_with("ball,"))
        .map(|line| line.split(',').nth(1).unwrap().parse::<u32>().unwrap())
        .sum();
    assert_eq!(lost, 2);
    assert_eq!(table::read(out.as_slice()).unwrap().len(), 2);
}

#[test]
fn a_table_with_a_wrong_row_is_refused_by_its_number() {
    let mut out = Vec::new();
    let mut writer = table::Writer::new(&mut out);
    let (events, _) = decoded(&stream(&[
        frame(0, Payload::Health(health())),
        frame(1, Payload::Health(health())),
    ]));
    for event in &events {
        writer.write(event).unwrap();
    }
    writer.flush().unwrap();
    drop(writer);
    let text = String::from_utf8(out).unwrap();
    let (first, last) = text.trim_end().rsplit_once('\n').unwrap();
    for (from, to) in [("health", "wealth"), (",1000,", ",,"), (",1000,", ",x,")] {
        assert!(last.contains(from));
        let spoiled = format!("{first}\n{}\n", last.replacen(from, to, 1));
        let error = format!("{:#}", table::read(spoiled.as_bytes()).unwrap_err());
        assert!(error.contains("row 2"), "{error}");
    }
}

#[test]
fn the_simulation_solves_the_recording_in_every_tick() {
    // Up to the crash, which has loads beyond what is solved.
    let (_, bytes) = cycle(9.0);
    let (events, decoder) = decoded(&bytes);
    let tally = decoder.tally();
    assert_eq!((tally.lost, tally.damaged, tally.restarts), (0, 0, 0));
    let mut state = State::default();
    let (mut estimates, mut reports) = (0, 0);
    for event in &events {
        state.note(event, tally);
        let Event::Frame { frame, .. } = event else {
            continue;
        };
        match &frame.payload {
            Payload::Estimate(_) => estimates += 1,
            Payload::Balls(_) => reports += 1,
            _ => {}
        }
    }
    // Estimates every 20 ms, pictures of eight frames every 200 ms.
    assert_eq!((estimates, reports), (450, 360));
    let health = state.health.unwrap().report;
    assert_eq!(health.estimates + health.refusals, health.ticks + 1);
    // One in a thousand may take longer than a tick.
    assert!(1000 * health.refusals <= health.ticks, "{health:?}");
    assert!(health.availability.iter().all(|share| *share > 0.99));
}

/// At rest there is no friction, and contact forces and angles are all there is.
#[test]
fn the_balls_at_rest_carry_the_load_that_came_in() {
    let (rows, bytes) = cycle(0.2);
    let (events, decoder) = decoded(&bytes);
    let mut state = State::default();
    let mut pictured = 0.0;
    for event in &events {
        state.note(event, decoder.tally());
        if let Event::Frame { frame, .. } = event
            && matches!(frame.payload, Payload::Balls(_))
        {
            pictured = frame.time_us as f64 * 1e-6;
        }
    }
    // The load between two rows.
    let next = rows.iter().position(|row| row.time_s > pictured).unwrap();
    let (from, to) = (&rows[next - 1], &rows[next]);
    assert_eq!((from.speed_rpm, to.speed_rpm), (0.0, 0.0));
    let part = (pictured - from.time_s) / (to.time_s - from.time_s);
    let mut carried = [0.0; 3];
    for (row, facing) in state.balls.iter().zip([1.0, -1.0]) {
        for (i, ball) in row.balls.iter().enumerate() {
            let ball = ball.unwrap();
            let force = f64::from(ball.q_i);
            let (sin, cos) = f64::from(ball.alpha_i).sin_cos();
            let (towards_z, towards_y) = row.azimuth(i).sin_cos();
            carried[0] += facing * force * sin;
            carried[1] += force * cos * towards_y;
            carried[2] += force * cos * towards_z;
        }
    }
    for (i, carried) in carried.into_iter().enumerate() {
        let load = from.load[i] + part * (to.load[i] - from.load[i]);
        assert!((carried - load).abs() < 0.02, "{carried} and {load} N");
    }
}

#[test]
fn the_history_is_bounded_and_keeps_the_newest() {
    let count = HISTORY + 100;
    let state = state_of((0..count).map(|i| Payload::Estimate(estimate(i as f32))));
    assert_eq!(state.history.len(), HISTORY);
    assert_eq!(
        state.history.back().unwrap().stiffness[0],
        (count - 1) as f32
    );
    assert_eq!(state.history.front().unwrap().stiffness[0], 100.0);
}

#[test]
fn rows_are_kept_apart() {
    let mut payloads = pair();
    // A new report of one row leaves the other one alone.
    payloads.extend(balls_of(1, &[33.0; 18]));
    let state = state_of(payloads);
    assert_eq!(state.row_count(), 2);
    let force = |row: usize, ball: usize| state.balls[row].balls[ball].unwrap().q_i;
    assert_eq!(
        (state.balls[0].balls.len(), state.balls[1].balls.len()),
        (16, 18)
    );
    assert_eq!((force(0, 0), force(1, 0), force(1, 17)), (90.0, 33.0, 33.0));
    let axial = |at: &Option<At<RowReport>>| at.unwrap().report.axial;
    assert_eq!(
        state.rows.iter().map(axial).collect::<Vec<_>>(),
        [412.0, 244.0]
    );
    let facings = [0, 1].map(|row| facing(state.place(row).unwrap()));
    assert_eq!(facings, [Facing::PlusX, Facing::MinusX]);
    assert!(state.is_opposed() && !state.is_lifted(0));
    let lifted = state_of(pair().into_iter().chain(rows(&[250.0, -1.0], 0.0)));
    assert_eq!([0, 1].map(|row| lifted.is_lifted(row)), [false, true]);
}

#[test]
fn rows_that_all_face_one_way_hold_no_preload_that_could_be_lost() {
    let tandem = [(0.0, true, 16), (0.02, true, 16)];
    let mut payloads = vec![shaft(&tandem)];
    payloads.extend(rows(&[250.0, -1.0], 0.0));
    let state = state_of(payloads);
    assert!(!state.is_opposed() && !state.is_lifted(1));
    assert_eq!(State::default().row_count(), 0);
    assert!(!State::default().is_lifted(0));
}

#[test]
fn more_rows_than_a_frame_holds_come_in_several() {
    let axial: Vec<f32> = (0..6).map(|i| 100.0 + i as f32).collect();
    let mut reports = rows(&axial, 1.0);
    assert_eq!(reports.len(), 2);
    let last = reports.pop();
    let state = state_of(reports);
    assert_eq!((state.row_count(), state.rows[5]), (6, None));
    let state = state_of(rows(&axial, 1.0).into_iter().chain(last));
    for (row, axial) in state.rows.iter().zip(&axial) {
        assert_eq!(row.unwrap().report.axial, *axial);
    }
}

#[test]
fn a_ball_that_is_counted_on_from_row_to_row_has_its_row() {
    let places = [(-0.02, false, 16), (0.02, true, 18)];
    // Known from the shaft, or from the balls.
    let mut reports = balls_of(0, &[1.0; 16]);
    reports.extend(balls_of(1, &[1.0; 18]));
    for state in [state_of([shaft(&places)]), state_of(reports)] {
        for (ball, expected) in [
            (0, Some((0, 0))),
            (15, Some((0, 15))),
            (16, Some((1, 0))),
            (33, Some((1, 17))),
            (34, None),
            (u16::MAX, None),
        ] {
            assert_eq!(state.row_and_ball(ball), expected, "{ball}");
        }
    }
    // The first row is not known yet.
    let state = state_of(balls_of(1, &[1.0; 18]));
    assert_eq!(state.row_and_ball(3), None);
    assert_eq!(State::default().row_and_ball(0), None);
}

#[test]
fn the_table_has_a_line_for_each_row_and_each_place_on_the_shaft() {
    let mut payloads = pair();
    payloads.push(shaft(&[]));
    payloads.push(Payload::Rows(RowsReport {
        first: 4,
        count: 4,
        rows: Default::default(),
    }));
    let frames: Vec<_> = (0..).zip(payloads).map(|(i, of)| frame(i, of)).collect();
    let mut out = Vec::new();
    let mut writer = table::Writer::new(&mut out);
    for event in &decoded(&stream(&frames)).0 {
        writer.write(event).unwrap();
    }
    writer.flush().unwrap();
    drop(writer);
    assert_eq!(table::read(out.as_slice()).unwrap(), frames);
    let mut reader = csv::Reader::from_reader(out.as_slice());
    let names = reader.headers().unwrap().clone();
    let lines: Vec<_> = reader.records().collect::<Result<_, _>>().unwrap();
    let of = |kind: &str, fields: &[&str]| -> Vec<Vec<String>> {
        let lines = lines.iter().filter(|line| &line[0] == kind);
        let field = |line: &csv::StringRecord, name: &str| {
            let column = names.iter().position(|of| of == name).unwrap();
            line[column].to_string()
        };
        lines
            .map(|line| fields.iter().map(|name| field(line, name)).collect())
            .collect()
    };
    assert_eq!(
        of(
            "row",
            &[
                "row",
                "first_row",
                "row_count",
                "row_axial_n",
                "row_fz_n",
                "preload_n"
            ]
        ),
        [
            ["0", "0", "2", "412.0", "-40.0", "244.0"],
            ["1", "0", "2", "244.0", "-40.0", "244.0"],
            ["", "4", "4", "", "", ""],
        ]
    );
    assert_eq!(
        of(
            "shaft",
            &[
                "row",
                "row_count",
                "position_m",
                "facing",
                "balls",
                "nose_m"
            ]
        ),
        [
            ["0", "2", "-0.02", "+x", "16", "0.09"],
            ["1", "2", "0.02", "-x", "18", "0.09"],
            ["", "0", "", "", "", "0.09"],
        ]
    );
    assert_eq!(
        of(
            "inputs",
            &["t_inner_c", "t_outer_c", "t_inner_source", "t_outer_source"]
        ),
        [["41.2", "36.5", "measured", "held"]]
    );
    let rows = of("ball", &["row"]).concat();
    assert_eq!(rows.iter().filter(|row| *row == "1").count(), 18);
}

#[test]
fn an_old_frame_again_wipes_no_alarm() {
    let mut decoder = Decoder::new();
    let mut state = State::default();
    let raised = alarm(Alarm::Slip, AlarmChange::Raised, AlarmState::Raised);
    let old = frame(7, Payload::Health(health()));
    let frames = [
        old.clone(),
        frame(100, Payload::Alarm(raised)),
        old,
        frame(101, Payload::Estimate(estimate(5e7))),
    ];
    for byte in stream(&frames) {
        if let Some(event) = decoder.push(byte) {
            state.note(&event, decoder.tally());
        }
    }
    assert_eq!((state.standing().count(), state.history.len()), (1, 1));
    assert_eq!(state.tally.restarts, 0);
}

#[test]
fn a_restart_forgets_what_was_and_goes_on_counting() {
    let mut decoder = Decoder::new();
    let mut state = State::default();
    let raised = alarm(Alarm::Slip, AlarmChange::Raised, AlarmState::Raised);
    let frames = [
        frame(100, Payload::Alarm(raised)),
        frame(101, Payload::Estimate(estimate(5e7))),
        frame(
            0,
            Payload::Alarm(alarm(
                Alarm::Sensor,
                AlarmChange::Raised,
                AlarmState::Raised,
            )),
        ),
        frame(1, Payload::Health(health())),
    ];
    for byte in stream(&frames) {
        if let Some(event) = decoder.push(byte) {
            state.note(&event, decoder.tally());
        }
    }
    // All but what the new start has said, from its first frame on.
    let standing: Vec<Alarm> = state.standing().map(|at| at.report.alarm).collect();
    assert_eq!(standing, [Alarm::Sensor]);
    assert_eq!((state.history.len(), state.time_us), (0, 1000));
    assert_eq!((state.tally.frames, state.tally.restarts), (4, 1));
}

// --- commands -----------------------------------------------------------------------------------

/// The commands in a stream of bytes, as the board finds them.
fn commands(bytes: &[u8]) -> Vec<Command> {
    let mut reader = PortReader::new();
    let frames = bytes.iter().filter_map(|byte| reader.push(*byte));
    let command = |frame| match frame {
        Ok(Received::Command(command)) => command,
        other => panic!("{other:?} is no command"),
    };
    frames.map(command).collect()
}

/// The orders in what an operator has sent, with their nonces.
fn orders(operator: &mut Operator<Vec<u8>>) -> Vec<(u32, Order)> {
    let sent = std::mem::take(operator.get_mut());
    let order = |command| match command {
        Command::Ask(request) => (request.nonce, request.order),
        other => panic!("no operator says {other:?}"),
    };
    commands(&sent).into_iter().map(order).collect()
}

fn note(state: &mut State, decoder: &mut Decoder, frame: &Frame) {
    for byte in encode(frame) {
        if let Some(event) = decoder.push(byte) {
            state.note(&event, decoder.tally());
        }
    }
}

fn told(sequence: u32, time_us: u64, nonce: u32) -> Frame {
    let inputs = InputsReport {
        nonce,
        ..InputsReport::default()
    };
    Frame {
        time_us,
        ..frame(sequence, Payload::Inputs(inputs))
    }
}

#[test]
fn only_alarms_that_nobody_has_acknowledged_are_acknowledged_by_their_occurrence() {
    let (mut state, mut decoder) = (State::default(), Decoder::new());
    let reports = [
        alarm(Alarm::Slip, AlarmChange::Raised, AlarmState::Raised),
        alarm(Alarm::Sensor, AlarmChange::Cleared, AlarmState::Latched),
        alarm(
            Alarm::Deadline,
            AlarmChange::Acknowledged,
            AlarmState::Acknowledged,
        ),
        alarm(Alarm::LifeUsed, AlarmChange::Cleared, AlarmState::Clear),
    ];
    let mut expected = Vec::new();
    for (sequence, report) in (0..).zip(reports) {
        if matches!(report.alarm, Alarm::Slip | Alarm::Sensor) {
            expected.push((report.alarm, report.raised));
        }
        note(
            &mut state,
            &mut decoder,
            &frame(sequence, Payload::Alarm(report)),
        );
    }
    let mut operator = Operator::new(Vec::new(), None);
    // Asked back, and not sent before the board's nonce is known.
    let said = operator.press('a', &state).unwrap();
    assert!(said.starts_with("acknowledge 2?"), "{said}");
    assert_eq!(
        operator.press('y', &state).as_deref(),
        Some("2 to be acknowledged")
    );
    assert_eq!(operator.press('x', &state), None);
    operator.follow(&state).unwrap();
    assert_eq!(orders(&mut operator), []);
    note(&mut state, &mut decoder, &told(4, 1000, 7));
    operator.follow(&state).unwrap();
    let sent: Vec<_> = orders(&mut operator)
        .into_iter()
        .map(|(nonce, order)| match order {
            Order::Acknowledge { alarm, raised } => (nonce, (alarm, raised)),
            other => panic!("{other:?}"),
        })
        .collect();
    expected.sort_by_key(|(alarm, _)| *alarm as usize);
    assert_eq!(sent, [(7, expected[0]), (8, expected[1])]);
}

#[test]
fn each_key_says_one_thing_and_a_no_sends_nothing() {
    let (mut state, mut decoder) = (State::default(), Decoder::new());
    note(&mut state, &mut decoder, &told(0, 1000, 7));
    let mut operator = Operator::new(Vec::new(), None);
    for key in ['s', 'e', 'r'] {
        assert!(operator.press(key, &state).unwrap().contains("? y"));
        assert_eq!(operator.press('n', &state).unwrap(), "nothing was sent");
        operator.press(key, &state);
        operator.press('y', &state);
    }
    operator.follow(&state).unwrap();
    let wanted = [
        Order::Learn(true),
        Order::Learn(false),
        Order::ReplaceBearing,
    ];
    assert_eq!(
        orders(&mut operator),
        [(7, wanted[0]), (8, wanted[1]), (9, wanted[2])]
    );
}

#[test]
fn an_order_is_sent_again_until_it_is_answered_and_is_given_up_in_the_end() {
    let (mut state, mut decoder) = (State::default(), Decoder::new());
    let mut operator = Operator::new(Vec::new(), None);
    operator.want(Order::Learn(true));
    operator.want(Order::Learn(false));
    let mut sent = Vec::new();
    for second in 0..10 {
        note(
            &mut state,
            &mut decoder,
            &told(2 * second, 1_000_000 * u64::from(second), 7),
        );
        if second == 2 {
            let answer = Payload::Answer(Answer {
                number: 1,
                order: Order::Learn(true),
                outcome: command::AnswerCode::NotIdling,
                nonce: 8,
            });
            note(&mut state, &mut decoder, &frame(5, answer));
            assert_eq!(
                state.said.as_deref(),
                Some("board: learn the baseline: not-idling")
            );
        }
        operator.follow(&state).unwrap();
        sent.extend(orders(&mut operator).into_iter().map(|(_, order)| order));
    }
    let times = |order| sent.iter().filter(|sent| **sent == order).count();
    assert_eq!(
        (times(Order::Learn(true)), times(Order::Learn(false))),
        (2, 5)
    );
    assert_eq!(operator.unanswered(), [Order::Learn(false)]);
}

#[test]
fn a_port_that_takes_no_bytes_is_told_of() {
    struct Gone;
    impl std::io::Write for Gone {
        fn write(&mut self, _: &[u8]) -> std::io::Result<usize> {
            Err(std::io::ErrorKind::BrokenPipe.into())
        }
        fn flush(&mut self) -> std::io::Result<()> {
            Ok(())
        }
    }
    let mut operator = Operator::new(Gone, None);
    operator.want(Order::Learn(true));
    let state = State {
        nonce: Some(0),
        ..State::default()
    };
    let error = operator.follow(&state).unwrap_err();
    assert_eq!(error.to_string(), "cannot send a command to the board");
}

//! Telemetry on the host: nothing undamaged is lost, nothing missing goes unnoticed, the table holds all
//! of it, and the view shows what is so.

use host_tests::design_file::{DesignFile, SHIPPED};
use host_tests::loads;
use host_tests::milling_cycle::RECORD;
use host_tests::telemetry::decoder::{Decoder, Event, Gap};
use host_tests::telemetry::operator::Operator;
use host_tests::telemetry::state::{HISTORY, State};
use host_tests::telemetry::{picture, simulated, source, table, view};
use proptest::prelude::*;
use spindle_bearing::monitor::command::{Command, Sorter};
use spindle_bearing::monitor::judgement::{Alarm, AlarmState};
use spindle_bearing::monitor::plausibility::{Mark, Marks};
use spindle_bearing::monitor::telemetry::{
    AlarmChange, AlarmReport, BALLS_PER_FRAME, BallReport, BallsReport, EstimateReport, Frame,
    HealthReport, Payload, Recovery, RetentionReport, StatusCode, VERSION, encode,
};
use std::io::Cursor;

fn estimate(stiffness: f32) -> EstimateReport {
    EstimateReport {
        age: 0,
        marks: Marks::NONE,
        load: [250.0, 120.0, -40.0, 0.2, 0.1],
        speed: 1256.6,
        displacement: [1e-5, 2e-6, -1e-6, 1e-5, -2e-5],
        stiffness: [stiffness, 4.0 * stiffness, 4.5 * stiffness, 8e3, 9e3],
        coupling: 1e6,
        coupling_row: 0,
        coupling_column: 1,
        least_force: 10.0,
        largest_force: 90.0,
        status: StatusCode::Converged,
        sweeps: 2,
        error: [1e-6, 1e-6, 1e-5],
        limits: 0,
    }
}

fn health() -> HealthReport {
    HealthReport {
        ticks: 1000,
        estimates: 990,
        ..HealthReport::default()
    }
}

fn alarm(alarm: Alarm, change: AlarmChange, state: AlarmState) -> AlarmReport {
    AlarmReport {
        alarm,
        change,
        state,
        value: 0.25,
        limit: 0.2,
        ball: None,
        raised: 1,
        cleared: 0,
    }
}

fn frame(sequence: u32, payload: Payload) -> Frame {
    Frame {
        version: VERSION,
        sequence,
        time_us: u64::from(sequence) * 1000,
        payload,
    }
}

fn stream(frames: &[Frame]) -> Vec<u8> {
    frames.iter().flat_map(encode).collect()
}

fn decoded(bytes: &[u8]) -> (Vec<Event>, Decoder) {
    let mut decoder = Decoder::new();
    let events = decoder.push_all(bytes).collect();
    (events, decoder)
}

fn frames_of(events: &[Event]) -> Vec<&Frame> {
    let frames = events.iter().filter_map(|event| match event {
        Event::Frame { frame, .. } => Some(frame),
        Event::Damaged(_) => None,
    });
    frames.collect()
}

fn state_of(payloads: impl IntoIterator<Item = Payload>) -> State {
    let frames: Vec<_> = (0..)
        .zip(payloads)
        .map(|(i, payload)| frame(i, payload))
        .collect();
    let mut decoder = Decoder::new();
    let mut state = State::default();
    for byte in stream(&frames) {
        if let Some(event) = decoder.push(byte) {
            state.note(&event, decoder.tally());
        }
    }
    assert_eq!(state.tally.frames, frames.len() as u64);
    state
}

fn balls(forces: &[f32]) -> Vec<Payload> {
    let chunks = forces.chunks(BALLS_PER_FRAME).enumerate();
    let payloads = chunks.map(|(i, some)| {
        Payload::Balls(BallsReport {
            first: (i * BALLS_PER_FRAME) as u16,
            count: forces.len() as u16,
            first_azimuth: 0.0,
            balls: some
                .iter()
                .map(|q_i| BallReport {
                    q_i: *q_i,
                    q_o: *q_i,
                    alpha_i: 0.3,
                    alpha_o: 0.25,
                })
                .collect(),
        })
    });
    payloads.collect()
}

/// The lines of the view.
fn text(state: &State) -> String {
    let screen = view::screen(state, 120, 40);
    let mut text = String::new();
    for (i, cell) in screen.content().iter().enumerate() {
        text += cell.symbol();
        if (i + 1) % 120 == 0 {
            text.push('\n');
        }
    }
    text
}

fn cycle(seconds: f64) -> Vec<u8> {
    let design = DesignFile::read(format!("{SHIPPED}/b7005c.toml")).unwrap();
    let rows: Result<Vec<_>, _> = loads::read(RECORD)
        .unwrap()
        .take_while(|row| row.as_ref().is_ok_and(|row| row.time_s < seconds))
        .collect();
    simulated::stream(&design.design, &rows.unwrap()).unwrap()
}

// Numbers that are none are the same in the table whatever their bits, so that they are left out where
// frames are compared.
prop_compose! {
    fn any_estimate()(
        (age, sweeps) in any::<(u32, u16)>(),
        marks in prop::collection::vec(prop::sample::select(Mark::ALL.to_vec()), 0..5),
        floats in prop::array::uniform24(number()),
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
            coupling: floats[16],
            coupling_row,
            coupling_column,
            least_force: floats[17],
            largest_force: floats[18],
            status,
            sweeps,
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
        (first, count) in any::<(u16, u16)>(),
        first_azimuth in number(),
        balls in prop::collection::vec(prop::array::uniform4(number()), 0..=BALLS_PER_FRAME),
    ) -> BallsReport {
        let ball = |[q_i, q_o, alpha_i, alpha_o]: [f32; 4]| BallReport { q_i, q_o, alpha_i, alpha_o };
        BallsReport {
            first,
            count,
            first_azimuth,
            balls: balls.into_iter().map(ball).collect(),
        }
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

fn any_payload() -> impl Strategy<Value = Payload> {
    prop_oneof![
        any_estimate().prop_map(Payload::Estimate),
        any_balls().prop_map(Payload::Balls),
        any_alarm().prop_map(Payload::Alarm),
        any_health().prop_map(Payload::Health),
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
    let frames = [u32::MAX - 1, u32::MAX, 0, 1, 5, 0, 1].map(health);
    let (events, decoder) = decoded(&stream(&frames));
    let gaps: Vec<Gap> = events
        .iter()
        .map(|event| match event {
            Event::Frame { gap, .. } => *gap,
            Event::Damaged(error) => panic!("{error}"),
        })
        .collect();
    let (none, lost) = (Gap::None, Gap::Lost(3));
    assert_eq!(gaps, [none, none, none, none, lost, Gap::Restart, none]);
    assert_eq!((decoder.tally().lost, decoder.tally().restarts), (3, 1));
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
fn a_stream_that_breaks_off_gives_what_came_and_then_its_error() {
    struct Breaking(Cursor<Vec<u8>>);
    impl std::io::Read for Breaking {
        fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
            match self.0.read(buffer)? {
                0 => Err(std::io::Error::other("unplugged")),
                n => Ok(n),
            }
        }
    }
    let bytes = stream(&[frame(0, Payload::Health(health()))]);
    let chunks: Vec<_> = source::stream(Breaking(Cursor::new(bytes.clone())))
        .into_iter()
        .collect();
    assert_eq!(chunks.len(), 2);
    assert_eq!(chunks[0].as_ref().unwrap(), &bytes);
    assert_eq!(chunks[1].as_ref().unwrap_err().to_string(), "unplugged");
    let error = source::port("/dev/there_is_no_such_port", 460_800)
        .err()
        .unwrap();
    assert!(error.to_string().contains("there_is_no_such_port"));
}

#[test]
fn the_simulation_solves_every_row_of_the_recording() {
    let bytes = cycle(10.0);
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
    assert_eq!((estimates, reports), (1000, 2000));
    let health = state.health.unwrap().report;
    assert_eq!((health.ticks, health.estimates), (1000, 1000));
    let estimate = state.estimate.unwrap().report;
    let forces = || state.balls.balls.iter().flatten().map(|ball| ball.q_i);
    assert_eq!(forces().fold(0.0, f32::max), estimate.largest_force);
    assert_eq!(forces().fold(f32::INFINITY, f32::min), estimate.least_force);
}

/// At rest there is no friction, and contact forces and angles are all there is.
#[test]
fn the_balls_at_rest_carry_the_load_that_is_reported_with_them() {
    let bytes = cycle(2.0);
    let (events, decoder) = decoded(&bytes);
    let mut state = State::default();
    for event in &events {
        state.note(event, decoder.tally());
    }
    let estimate = state.estimate.unwrap().report;
    assert_eq!(estimate.speed, 0.0);
    let mut carried = [0.0; 3];
    for (i, ball) in state.balls.balls.iter().enumerate() {
        let ball = ball.unwrap();
        let force = f64::from(ball.q_i);
        let (sin, cos) = f64::from(ball.alpha_i).sin_cos();
        let (towards_z, towards_y) = state.balls.azimuth(i).sin_cos();
        carried[0] += force * sin;
        carried[1] += force * cos * towards_y;
        carried[2] += force * cos * towards_z;
    }
    for (carried, load) in carried.into_iter().zip(estimate.load) {
        assert!(
            (carried - f64::from(load)).abs() < 0.02,
            "{carried} and {load} N"
        );
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
fn a_restart_forgets_what_was_and_goes_on_counting() {
    let mut decoder = Decoder::new();
    let mut state = State::default();
    let raised = alarm(Alarm::Slip, AlarmChange::Raised, AlarmState::Raised);
    let frames = [
        frame(100, Payload::Alarm(raised)),
        frame(101, Payload::Estimate(estimate(5e7))),
        frame(0, Payload::Health(health())),
    ];
    for byte in stream(&frames) {
        if let Some(event) = decoder.push(byte) {
            state.note(&event, decoder.tally());
        }
    }
    assert_eq!(state.standing().count(), 0);
    assert_eq!((state.history.len(), state.time_us), (0, 0));
    assert_eq!((state.tally.frames, state.tally.restarts), (3, 1));
}

#[test]
fn the_ball_with_the_largest_force_is_drawn_farthest_out_along_its_azimuth() {
    for hardest in 0..16 {
        let mut forces = [40.0; 16];
        forces[hardest] = 90.0;
        forces[(hardest + 5) % 16] = 0.0;
        let state = state_of(balls(&forces));
        let scale = view::scale(&state.balls);
        assert!((90.0..=180.0).contains(&scale));
        let radius = |i| {
            let [(x, y), _] = view::places(&state.balls, i, scale).unwrap();
            f64::hypot(x, y)
        };
        let farthest = (0..16)
            .max_by(|a, b| radius(*a).total_cmp(&radius(*b)))
            .unwrap();
        assert_eq!(farthest, hardest);
        assert!(radius(hardest) <= 1.0);
        assert_eq!(radius((hardest + 5) % 16), 0.0);
        assert!((radius(hardest) / radius((hardest + 1) % 16) - 90.0 / 40.0).abs() < 1e-9);
        // On the screen: red dots from the middle of the picture towards the ball, y to the right and z
        // up, and nowhere else.
        let screen = view::screen(&state, 120, 40);
        let dots: Vec<(f64, f64)> = screen
            .area
            .positions()
            .filter(|at| {
                let cell = &screen[*at];
                let is_braille =
                    matches!(cell.symbol().chars().next(), Some('\u{2801}'..='\u{28ff}'));
                is_braille && cell.fg == ratatui::style::Color::Red
            })
            .map(|at| (f64::from(at.x), -2.0 * f64::from(at.y)))
            .collect();
        assert!(!dots.is_empty());
        let axes = state.balls.azimuth(hardest);
        let (towards_y, towards_z) = (axes.cos(), axes.sin());
        let place = |(x, y): &(f64, f64)| x * towards_y + y * towards_z;
        let across = |(x, y): &(f64, f64)| y * towards_y - x * towards_z;
        let length = dots.iter().map(place).fold(f64::MIN, f64::max)
            - dots.iter().map(place).fold(f64::MAX, f64::min);
        let width = dots.iter().map(across).fold(f64::MIN, f64::max)
            - dots.iter().map(across).fold(f64::MAX, f64::min);
        assert!(
            length > 4.0 * width,
            "ball {hardest}: {length} long, {width} wide"
        );
    }
}

#[test]
fn the_hardest_ball_and_its_force_are_named() {
    let mut forces = [40.0; 16];
    forces[11] = 123.4;
    assert!(text(&state_of(balls(&forces))).contains("ball 11: 123 N"));
    assert!(text(&State::default()).contains("none known"));
}

#[test]
fn an_alarm_is_shown_by_name_until_it_is_acknowledged_and_gone() {
    use AlarmChange as C;
    use AlarmState as S;
    for which in Alarm::ALL {
        let shown = |steps: &[(C, S)]| {
            let reports = steps
                .iter()
                .map(|(change, state)| alarm(which, *change, *state));
            text(&state_of(reports.map(Payload::Alarm)))
        };
        let open = |text: &str| text.contains("1 not acknowledged") && text.contains(which.name());
        let raised = (C::Raised, S::Raised);
        assert!(!shown(&[]).contains(which.name()));
        assert!(!shown(&[(C::Standing, S::Pending)]).contains(which.name()));
        assert!(open(&shown(&[raised])), "{which} raised");
        // The condition is gone, but nobody knows of it.
        assert!(
            open(&shown(&[raised, (C::Cleared, S::Latched)])),
            "{which} latched"
        );
        // Somebody knows, but the condition stands.
        let known = shown(&[raised, (C::Acknowledged, S::Acknowledged)]);
        assert!(known.contains(which.name()) && known.contains("acknowledged"));
        assert!(!known.contains("not acknowledged"));
        for end in [C::Cleared, C::Acknowledged] {
            assert!(!shown(&[raised, (end, S::Clear)]).contains(which.name()));
        }
    }
}

#[test]
fn all_alarms_at_once_are_all_shown_the_most_serious_first() {
    let raised = |which| Payload::Alarm(alarm(which, AlarmChange::Raised, AlarmState::Raised));
    let text = text(&state_of(Alarm::ALL.into_iter().rev().map(raised)));
    assert!(text.contains("10 not acknowledged"));
    let places: Vec<usize> = Alarm::ALL
        .map(|a| text.find(&format!(" {} ", a.name())).unwrap())
        .into();
    assert!(places.is_sorted(), "{places:?}");
}

#[test]
fn the_last_stiffness_is_there_as_a_number_and_the_course_falls_with_it() {
    let falling = (0..600).map(|i| Payload::Estimate(estimate(5e7 * (1.0 - i as f32 / 1200.0))));
    let state = state_of(falling);
    assert!(text(&state).contains("Kx 25.0"), "{}", text(&state));
    let screen = view::screen(&state, 120, 40);
    // Rows of the dots of Kx, from the left to the right.
    let mut rows: Vec<(u16, u16)> = screen
        .area
        .positions()
        .filter(|at| {
            let cell = &screen[*at];
            let is_braille = matches!(cell.symbol().chars().next(), Some('\u{2801}'..='\u{28ff}'));
            is_braille && cell.fg == ratatui::style::Color::Yellow
        })
        .map(|at| (at.x, at.y))
        .collect();
    rows.sort_unstable();
    assert!(rows.len() > 20);
    assert!(rows.first().unwrap().1 < rows.last().unwrap().1);
    assert!(
        rows.windows(2).all(|pair| pair[0].1 <= pair[1].1),
        "{rows:?}"
    );
}

#[test]
fn a_doubted_sample_is_named_and_is_no_point_of_the_course() {
    let doubted = EstimateReport {
        age: 7,
        marks: Marks::from(Mark::Stuck).with(Mark::SpeedMissing),
        ..estimate(5e7)
    };
    let state = state_of([Payload::Estimate(estimate(5e7)), Payload::Estimate(doubted)]);
    let trusted: Vec<bool> = state.history.iter().map(|point| point.trusted).collect();
    assert_eq!(trusted, [true, false]);
    let text = text(&state);
    assert!(text.contains("7 ticks old"));
    assert!(text.contains("doubted: stuck speed-missing"));
}

#[test]
fn losses_and_counters_are_on_the_health_lines() {
    let mut decoder = Decoder::new();
    let mut state = State::default();
    let late = HealthReport {
        overruns: 3,
        marked_samples: 41,
        most_cycles: 120_345,
        retention: RetentionReport {
            baseline: Recovery::OtherSpindle,
            life: Recovery::Recovered,
            damaged: 1,
            written: 12,
            failed: 2,
        },
        ..health()
    };
    let mut bytes = encode(&frame(0, Payload::Health(health()))).to_vec();
    bytes.extend([9, 1, 1, 0]);
    bytes.extend(encode(&frame(5, Payload::Health(late))));
    for byte in bytes {
        if let Some(event) = decoder.push(byte) {
            state.note(&event, decoder.tally());
        }
    }
    let without = state_of([Payload::Health(health())]);
    assert!(self::text(&without).contains("no memory: what is learnt is lost with the power"));
    let text = text(&state);
    for part in [
        "1000 ticks, 3 overruns",
        "longest 120345 cycles",
        "41 doubted",
        "baseline other-spindle, life recovered, 1 damaged pieces; 12 records written, 2 failed",
        "2 frames in",
        "4 lost, 1 damaged",
        "frame stuffing broken",
    ] {
        assert!(text.contains(part), "{part} is not in\n{text}");
    }
}

#[test]
fn any_state_can_be_drawn_on_any_screen() {
    let nothing = f32::NAN;
    let broken = EstimateReport {
        stiffness: [nothing, f32::INFINITY, -1.0, 0.0, f32::MAX],
        ..estimate(1.0)
    };
    let mut payloads = balls(&[nothing, f32::INFINITY, 0.0, -5.0, 1e30]);
    payloads.push(Payload::Estimate(broken));
    let states = [State::default(), state_of(payloads)];
    for state in &states {
        for (width, height) in [(0, 0), (1, 1), (20, 5), (40, 12), (80, 24), (300, 100)] {
            let screen = view::screen(state, width, height);
            assert_eq!(screen.area.area(), u32::from(width) * u32::from(height));
        }
    }
}

#[test]
fn the_picture_has_every_word_of_the_screen_at_its_place() {
    let raised = alarm(Alarm::Slip, AlarmChange::Raised, AlarmState::Raised);
    let state = state_of([Payload::Alarm(raised), Payload::Estimate(estimate(5e7))]);
    let screen = view::screen(&state, 120, 40);
    let svg = picture::svg(&screen);
    let mut letters = 0;
    for line in svg.lines().filter(|line| line.starts_with("<text")) {
        let number = |name: &str| -> u16 {
            let (_, rest) = line.split_once(&format!(" {name}=\"")).unwrap();
            rest.split('"').next().unwrap().parse().unwrap()
        };
        let word = line.split(['>', '<']).nth(2).unwrap();
        let (x, y) = (number("x") / 8, (number("y") - 12) / 16);
        for (i, letter) in (0..).zip(word.chars()) {
            assert_eq!(screen[(x + i, y)].symbol(), letter.to_string());
            letters += 1;
        }
    }
    let drawn = |cell: &ratatui::buffer::Cell| {
        let symbol = cell.symbol().chars().next();
        matches!(
            symbol,
            Some(' ' | '\u{2500}'..='\u{257f}' | '\u{2800}'..='\u{28ff}') | None
        )
    };
    assert_eq!(
        letters,
        screen.content().iter().filter(|cell| !drawn(cell)).count()
    );
    assert!(svg.contains(">slip<"));
}

// --- commands -----------------------------------------------------------------------------------

/// The commands in a stream of bytes, as the board finds them.
fn commands(bytes: &[u8]) -> Vec<Command> {
    let mut sorter = Sorter::new();
    let found = |byte: &u8| sorter.push(*byte, |other| panic!("{other} is no command's"));
    bytes.iter().filter_map(found).collect()
}

#[test]
fn only_alarms_that_nobody_has_acknowledged_are_acknowledged() {
    let mut state = State::default();
    let mut decoder = Decoder::new();
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
    for (sequence, report) in (0..).zip(reports) {
        for byte in encode(&frame(sequence, Payload::Alarm(report))) {
            if let Some(event) = decoder.push(byte) {
                state.note(&event, decoder.tally());
            }
        }
    }
    let mut operator = Operator::new(Vec::new());
    let said = operator.press('a', &state).unwrap();
    assert_eq!(said.as_deref(), Some("2 alarms acknowledged"));
    assert_eq!(operator.press('x', &state).unwrap(), None);
    let mut sent = commands(&operator.into_inner());
    sent.sort_by_key(|command| format!("{command:?}"));
    assert_eq!(sent, [Alarm::Sensor, Alarm::Slip].map(Command::Acknowledge));
}

#[test]
fn learning_begins_and_ends_by_one_key_and_all_alarms_are_acknowledged_unseen() {
    let state = State::default();
    let mut operator = Operator::new(Vec::new());
    let mut press = || operator.press('l', &state).unwrap().unwrap();
    assert_eq!(
        [press(), press()],
        [
            "learning of the baseline begun",
            "learning of the baseline ended"
        ]
    );
    operator.acknowledge_all().unwrap();
    let mut expected = vec![Command::Learn(true), Command::Learn(false)];
    expected.extend(Alarm::ALL.map(Command::Acknowledge));
    assert_eq!(commands(&operator.into_inner()), expected);
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
    let error = Operator::new(Gone)
        .press('l', &State::default())
        .unwrap_err();
    assert_eq!(error.to_string(), "cannot send a command to the board");
}

#[test]
fn what_was_said_to_the_board_is_in_the_view() {
    let mut state = State {
        said: Some("2 alarms acknowledged".into()),
        ..State::default()
    };
    let shown = |state: &State| {
        let screen = view::screen(state, 120, 40);
        screen
            .content()
            .iter()
            .map(|cell| cell.symbol())
            .collect::<String>()
    };
    assert!(shown(&state).contains("2 alarms acknowledged"));
    state.said = None;
    assert!(!shown(&state).contains("acknowledged"));
}

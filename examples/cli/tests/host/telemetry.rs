//! Telemetry on the host: nothing undamaged is lost, nothing missing goes unnoticed, and lines of JSON hold all of it.

use cli::milling_cycle::record_of;
use cli::random::Random;
use cli::recordings::{self, Wanted};
use cli::telemetry::decoder::{Decoder, Event, Gap};
use cli::telemetry::frames::{
    alarm, balls, estimate, frame, health, note, pair, rows, shaft, state_of, stream,
};
use cli::telemetry::operator::Operator;
use cli::telemetry::state::{HISTORY, State};
use cli::telemetry::{json, simulated};
use proptest::prelude::*;
use serde_json::Value;
use spindle_file::loads::LoadRow;
use spindle_file::spindles::SpindleFile;
use spindle_firmware::spindle::ROWS;
use spindle_monitor::Alarm;
use spindle_monitor::board::{BoardReport, Check, ResetCause};
use spindle_monitor::command::{Answer, AnswerCode, Command, Order, PortReader, Received};
use spindle_monitor::judgement::{AlarmChange, AlarmState};
use spindle_monitor::retained::Recovery;
use spindle_monitor::telemetry::{EstimateReport, Frame, HelloReport, Payload, VERSION, encode};
use spindle_monitor::{Mark, TemperatureSource};

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

/// What the shipped monitor sends of a recording.
fn simulated_of(rows: &[LoadRow]) -> Vec<u8> {
    let file = SpindleFile::read(cli::root().join("examples/firmware/spindle.toml")).unwrap();
    simulated::stream(&file, rows.iter().copied().map(Ok)).unwrap()
}

/// The recording up to a time, and the monitor's bytes for it.
fn cycle(seconds: f64) -> (Vec<LoadRow>, Vec<u8>) {
    let rows: Result<Vec<_>, _> = recordings::read(record_of(ROWS), &Wanted::default())
        .unwrap()
        .take_while(|row| row.as_ref().is_ok_and(|row| row.time_s < seconds))
        .collect();
    let rows = rows.unwrap();
    let bytes = simulated_of(&rows);
    (rows, bytes)
}

/// Payloads of every kind.
fn samples() -> Vec<Payload> {
    let mut payloads = pair();
    let mut slip = alarm(Alarm::Slip, AlarmChange::Raised, AlarmState::Raised);
    payloads.push(Payload::Alarm(slip));
    slip.place = Some(3);
    payloads.extend([
        Payload::Alarm(slip),
        Payload::Health(health()),
        Payload::Hello(HelloReport {
            board: BoardReport {
                unused_stack: Some(900),
                brown_out: Some(3),
                ..BoardReport::NONE
            },
            ..HelloReport::default()
        }),
        shaft(&[]),
    ]);
    let acknowledge = Order::Acknowledge {
        alarm: Alarm::Slip,
        start: 7,
        raised: 1,
    };
    let orders = [acknowledge, Order::ReplaceBearing];
    payloads.extend(orders.map(|order| answer(1, order)));
    payloads
}

fn answer(number: u16, order: Order) -> Payload {
    Payload::Answer(Answer {
        number,
        order,
        outcome: AnswerCode::NotAtStandstill,
    })
}

/// Puts other numbers in the place of a sample's: any finite ones, and integers that every type holds.
fn fill(value: &mut Value, numbers: &mut dyn Iterator<Item = (f32, u8)>) {
    match value {
        Value::Array(of) => of.iter_mut().for_each(|of| fill(of, numbers)),
        Value::Object(of) => of.values_mut().for_each(|of| fill(of, numbers)),
        Value::Number(number) => {
            let (float, integer) = numbers.next().unwrap();
            *value = if number.is_f64() {
                float.into()
            } else {
                integer.into()
            };
        }
        _ => {}
    }
}

fn any_payload() -> impl Strategy<Value = Payload> {
    use prop::num::f32::{NORMAL, SUBNORMAL, ZERO};
    let numbers = prop::collection::vec((NORMAL | SUBNORMAL | ZERO, 0..=127_u8), 64);
    let samples = prop::sample::select(samples());
    (samples, numbers).prop_map(|(sample, numbers)| {
        let mut value = serde_json::to_value(sample).unwrap();
        fill(&mut value, &mut numbers.into_iter());
        serde_json::from_value(value).unwrap()
    })
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
    fn an_undamaged_stream_arrives_whole_and_lines_of_json_hold_all_of_it(frames in any_frames()) {
        let bytes = stream(&frames);
        let (events, decoder) = decoded(&bytes);
        prop_assert_eq!(frames_of(&events), frames.iter().collect::<Vec<_>>());
        let tally = decoder.tally();
        prop_assert_eq!((tally.bytes, tally.frames), (bytes.len() as u64, frames.len() as u64));
        prop_assert_eq!((tally.lost, tally.damaged, tally.restarts), (0, 0, 0));
        let lines = lines(&events);
        let again: Vec<u8> = lines.iter().flat_map(|line| json::bytes(line)).collect();
        prop_assert_eq!(again, bytes);
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

    /// A hundred thousand damaged streams in all. Whatever came, the frame behind the next delimiter is read.
    #[test]
    fn damage_makes_up_no_frame(frames in any_frames(), seed in any::<u64>()) {
        let (mut decoder, mut state) = (Decoder::new(), State::default());
        let (mut random, mut count) = (Random::seeded(seed), 0);
        for _ in 0..400 {
            let mut bytes = stream(&frames);
            random.damage(&mut bytes);
            bytes.push(0);
            bytes.extend(encode(&frames[0]));
            let events: Vec<Event> = decoder.push_all(&bytes).collect();
            let tally = decoder.tally();
            let arrived = frames_of(&events);
            prop_assert!(arrived.iter().all(|frame| frames.contains(frame)));
            prop_assert_eq!(arrived.last(), Some(&&frames[0]));
            count += events.len() as u64;
            prop_assert_eq!(tally.frames + tally.damaged, count);
            events.iter().for_each(|event| state.note(event, tally));
        }
    }
}

/// The lines of a stream.
fn lines(events: &[Event]) -> Vec<String> {
    let mut out = Vec::new();
    for event in events {
        json::write(&mut out, event).unwrap();
    }
    let text = String::from_utf8(out).unwrap();
    text.lines().map(String::from).collect()
}

#[test]
fn numbers_that_wrap_are_no_gap_and_numbers_that_go_back_are_a_restart() {
    let health = |n| frame(n, Payload::Health(health()));
    let frames = [u32::MAX - 1, u32::MAX, 0, 1, 5, 3, 6, 0, 1, 2].map(health);
    let (events, decoder) = decoded(&stream(&frames));
    let gaps = events.iter().filter_map(|event| match event {
        Event::Frame { gap, .. } => Some(*gap),
        Event::Damaged(_) => None,
    });
    let mut expected = [Gap::None; 10];
    (expected[4], expected[8]) = (Gap::Lost(3), Gap::Restart);
    (expected[5], expected[7]) = (Gap::Behind, Gap::Behind);
    assert!(gaps.eq(expected));
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
fn damage_has_a_line_of_its_own_and_a_gap_is_in_the_line_after_it() {
    let doubted = EstimateReport {
        marks: Mark::Stuck | Mark::SpeedMissing,
        limits: 1,
        ..estimate(6.1e7)
    };
    let mut bytes = encode(&frame(0, Payload::Health(health()))).to_vec();
    bytes.extend([9, 1, 1, 0]);
    bytes.extend(encode(&frame(3, Payload::Estimate(doubted))));
    let lines = lines(&decoded(&bytes).0);
    let [first, damaged, last] = [0, 1, 2].map(|i| lines[i].parse::<Value>().unwrap());
    assert_eq!(first["payload"]["health"]["ticks"], 1000);
    assert_eq!(
        (&first["gap"], &first["names"]),
        (&Value::Null, &Value::Null)
    );
    assert_eq!(damaged["damaged"], "frame stuffing broken");
    assert_eq!(
        (&last["gap"]["lost"], &last["sequence"]),
        (&2.into(), &3.into())
    );
    let names = ["stuck", "speed-missing", "peak-pressure"];
    assert_eq!(last["names"], Value::from(names.to_vec()));
    // The way back counts alike.
    let again: Vec<u8> = lines.iter().flat_map(|line| json::bytes(line)).collect();
    let tally = |bytes: &[u8]| {
        let tally = decoded(bytes).1.tally();
        (tally.frames, tally.lost, tally.damaged)
    };
    assert_eq!(tally(&again), tally(&bytes));
}

#[test]
fn a_line_that_is_no_frame_is_a_damaged_piece() {
    let line_of = |payload| lines(&decoded(&encode(&frame(0, payload))).0).remove(0);
    let line = &line_of(Payload::Health(health()));
    let version = |of| format!("\"version\":{of}");
    assert_eq!(decoded(&json::bytes(line)).1.tally().frames, 1);
    // No such payload, no such number, another version, and a number that is not finite.
    for (from, to) in [
        ("health", "wealth"),
        ("1000", "-1000"),
        (&version(VERSION), &version(VERSION - 1)),
        ("\"life_used\":0.0", "\"life_used\":null"),
    ] {
        assert!(line.contains(from));
        let tally = decoded(&json::bytes(&line.replacen(from, to, 1))).1.tally();
        assert_eq!((tally.frames, tally.damaged), (0, 1), "{to}");
    }
    let nowhere = Payload::Estimate(estimate(f32::NAN));
    assert!(line_of(nowhere).contains("\"stiffness\":[null,null,null,"));
}

#[test]
fn names_in_json_are_those_of_the_view() {
    fn check<T: serde::Serialize + Copy>(all: &[T], name: impl Fn(T) -> &'static str) {
        for one in all {
            assert_eq!(serde_json::to_value(one).unwrap(), name(*one));
        }
    }
    check(&Alarm::ALL, Alarm::name);
    check(&Recovery::ALL, Recovery::name);
    check(&TemperatureSource::ALL, TemperatureSource::name);
    check(&AnswerCode::ALL, AnswerCode::name);
    check(&ResetCause::ALL, ResetCause::name);
    check(&Check::ALL, Check::name);
}

#[test]
fn the_simulation_has_a_fresh_estimate_in_every_tick_of_the_recording() {
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
    let health = state.health.unwrap();
    assert_eq!((health.refusals, health.availability), (0, 1.0));
    assert!(3 * health.estimates > health.ticks, "{health:?}");
}

/// At rest there is no friction, and contact forces and angles are all there is.
#[test]
fn the_balls_at_rest_carry_the_load_that_came_in() {
    const LOAD: [f64; 5] = [120.0, 80.0, -50.0, 0.5, -0.3];
    let (mut rows, _) = cycle(0.1);
    rows.truncate(2);
    for (row, time_s) in rows.iter_mut().zip([0.0, 0.05]) {
        (row.time_s, row.load, row.speed_rpm) = (time_s, LOAD, 0.0);
    }
    let (events, decoder) = decoded(&simulated_of(&rows));
    let mut state = State::default();
    for event in &events {
        state.note(event, decoder.tally());
    }
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
    for (carried, load) in carried.into_iter().zip(LOAD) {
        assert!((carried - load).abs() < 0.02, "{carried} and {load} N");
    }
}

#[test]
fn the_history_is_bounded_and_keeps_the_newest() {
    let count = HISTORY + 100;
    let state = state_of((0..count).map(|i| Payload::Estimate(estimate(i as f32))));
    assert_eq!(state.history.len(), HISTORY);
    let (first, last) = (
        state.history.front().unwrap(),
        state.history.back().unwrap(),
    );
    assert_eq!(
        (first.stiffness[0], last.stiffness[0]),
        (100.0, (count - 1) as f32)
    );
}

#[test]
fn rows_are_kept_apart() {
    let mut payloads = pair();
    // A new report of one row leaves the other one alone.
    payloads.extend(balls(1, &[33.0; 18]));
    let state = state_of(payloads);
    assert_eq!(state.row_count(), 2);
    let force = |row: usize, ball: usize| state.balls[row].balls[ball].unwrap().q_i;
    assert_eq!(
        state
            .balls
            .iter()
            .map(|row| row.balls.len())
            .collect::<Vec<_>>(),
        [16, 18]
    );
    assert_eq!((force(0, 0), force(1, 0), force(1, 17)), (90.0, 33.0, 33.0));
    assert_eq!(
        [0, 1].map(|row| state.rows[row].unwrap().axial),
        [412.0, 244.0]
    );
    assert!(state.is_opposed() && !state.is_lifted(0));
    let lifted = state_of(pair().into_iter().chain(rows(&[250.0, -1.0], 0.0)));
    assert_eq!([0, 1].map(|row| lifted.is_lifted(row)), [false, true]);
}

#[test]
fn rows_that_all_face_one_way_hold_no_preload_that_could_be_lost() {
    let mut payloads = vec![shaft(&[(0.0, true, 16), (0.02, true, 16)])];
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
    let state = state_of(reports.clone());
    assert!(state.rows.iter().map(|row| row.unwrap().axial).eq(axial));
    reports.pop();
    let state = state_of(reports);
    assert_eq!((state.row_count(), state.rows[5]), (6, None));
}

#[test]
fn a_ball_that_is_counted_on_from_row_to_row_has_its_row() {
    let places = [(-0.02, false, 16), (0.02, true, 18)];
    // Known from the shaft, or from the balls.
    let mut reports = balls(0, &[1.0; 16]);
    reports.extend(balls(1, &[1.0; 18]));
    for state in [state_of([shaft(&places)]), state_of(reports)] {
        let found = [0, 15, 16, 33, 34, u16::MAX].map(|ball| state.row_and_ball(ball));
        let expected = [(0, 0), (0, 15), (1, 0), (1, 17)].map(Some);
        assert_eq!(found[..4], expected);
        assert_eq!(found[4..], [None; 2]);
    }
    // The first row is not known yet.
    assert_eq!(state_of(balls(1, &[1.0; 18])).row_and_ball(3), None);
    assert_eq!(State::default().row_and_ball(0), None);
}

#[test]
fn an_old_frame_again_wipes_no_alarm() {
    let mut state = State::default();
    let raised = alarm(Alarm::Slip, AlarmChange::Raised, AlarmState::Raised);
    let old = frame(7, Payload::Health(health()));
    let frames = [
        old.clone(),
        frame(100, Payload::Alarm(raised)),
        old,
        frame(101, Payload::Estimate(estimate(5e7))),
    ];
    note(&mut state, &mut Decoder::new(), &frames);
    assert_eq!((state.standing().count(), state.history.len()), (1, 1));
    assert_eq!(state.tally.restarts, 0);
}

#[test]
fn a_restart_forgets_what_was_and_goes_on_counting() {
    let mut state = State::default();
    let raised = |which| Payload::Alarm(alarm(which, AlarmChange::Raised, AlarmState::Raised));
    let frames = [
        frame(100, raised(Alarm::Slip)),
        frame(101, Payload::Estimate(estimate(5e7))),
        frame(0, raised(Alarm::Sensor)),
        frame(1, Payload::Health(health())),
    ];
    note(&mut state, &mut Decoder::new(), &frames);
    // All but what the new start has said, from its first frame on.
    let standing: Vec<Alarm> = state.standing().map(|(_, of)| of.alarm).collect();
    assert_eq!(standing, [Alarm::Sensor]);
    assert_eq!((state.history.len(), state.time_us), (0, 1000));
    assert_eq!((state.tally.frames, state.tally.restarts), (4, 1));
}

/// The orders that an operator has sent, with their numbers, as the board finds them.
fn orders(operator: &mut Operator<Vec<u8>>) -> Vec<(u16, Order)> {
    let sent = std::mem::take(operator.get_mut());
    let mut reader = PortReader::new();
    let frames = sent.iter().filter_map(|byte| reader.push(*byte));
    let order = |frame| match frame {
        Ok(Received::Command(Command::Ask(request))) => (request.number, request.order),
        other => panic!("no operator says {other:?}"),
    };
    frames.map(order).collect()
}

#[test]
fn only_alarms_that_nobody_has_acknowledged_are_acknowledged_by_their_occurrence() {
    let state = state_of(
        [
            alarm(Alarm::Slip, AlarmChange::Raised, AlarmState::Raised),
            alarm(Alarm::Sensor, AlarmChange::Cleared, AlarmState::Latched),
            alarm(
                Alarm::Deadline,
                AlarmChange::Acknowledged,
                AlarmState::Acknowledged,
            ),
            alarm(Alarm::LifeUsed, AlarmChange::Cleared, AlarmState::Clear),
        ]
        .map(Payload::Alarm),
    );
    let mut operator = Operator::new(Vec::new());
    // Asked back.
    let said = operator.press('a', &state).unwrap();
    assert!(said.starts_with("acknowledge 2?"), "{said}");
    let said = operator.press('y', &state);
    assert_eq!(said.as_deref(), Some("2 to be acknowledged"));
    assert_eq!(operator.press('x', &state), None);
    operator.follow(&state).unwrap();
    let acknowledge = |alarm| Order::Acknowledge {
        alarm,
        start: 7,
        raised: 1,
    };
    let expected = [
        (1, acknowledge(Alarm::Slip)),
        (2, acknowledge(Alarm::Sensor)),
    ];
    assert_eq!(orders(&mut operator), expected);
}

#[test]
fn each_key_says_one_thing_and_a_no_sends_nothing() {
    let state = State::default();
    let mut operator = Operator::new(Vec::new());
    assert!(operator.press('r', &state).unwrap().contains("? y"));
    assert_eq!(operator.press('n', &state).unwrap(), "nothing was sent");
    operator.press('r', &state);
    operator.press('y', &state);
    assert_eq!(
        operator.press('a', &state).unwrap(),
        "no alarm to acknowledge"
    );
    operator.follow(&state).unwrap();
    assert_eq!(orders(&mut operator), [(1, Order::ReplaceBearing)]);
}

#[test]
fn an_order_is_sent_again_until_it_is_answered_and_is_given_up_in_the_end() {
    let (mut state, mut decoder) = (State::default(), Decoder::new());
    let mut operator = Operator::new(Vec::new());
    let acknowledge = Order::Acknowledge {
        alarm: Alarm::Slip,
        start: 7,
        raised: 1,
    };
    operator.want(Order::ReplaceBearing);
    operator.want(acknowledge);
    let mut sent = Vec::new();
    for second in 0..10 {
        let told = Frame {
            time_us: 1_000_000 * u64::from(second),
            ..frame(2 * second, Payload::Health(health()))
        };
        note(&mut state, &mut decoder, &[told]);
        if second == 2 {
            let answer = frame(5, answer(1, Order::ReplaceBearing));
            note(&mut state, &mut decoder, &[answer]);
            let said = state.said.as_deref();
            assert_eq!(
                said,
                Some("board: take the bearing for a new one: not-at-standstill")
            );
        }
        operator.follow(&state).unwrap();
        sent.extend(orders(&mut operator).into_iter().map(|(_, order)| order));
    }
    let times = |order| sent.iter().filter(|sent| **sent == order).count();
    assert_eq!([Order::ReplaceBearing, acknowledge].map(times), [2, 5]);
    assert_eq!(operator.unanswered(), [acknowledge]);
}

#[test]
fn a_port_that_takes_no_bytes_is_told_of() {
    // A buffer without room.
    let mut operator = Operator::new([0_u8; 0].as_mut_slice());
    operator.want(Order::ReplaceBearing);
    let error = operator.follow(&State::default()).unwrap_err();
    assert_eq!(error.to_string(), "cannot send a command to the board");
}

//! The live view of the telemetry, as it is drawn.

use cli::telemetry::decoder::Decoder;
use cli::telemetry::frames::{
    alarm, balls, estimate, frame, health, note, pair, rows, shaft, state_of, stream,
};
use cli::telemetry::json;
use cli::telemetry::state::State;
use cli::telemetry::{source, view};
use ratatui::buffer::{Buffer, Cell};
use ratatui::style::Color;
use spindle_monitor::Alarm;
use spindle_monitor::Mark;
use spindle_monitor::board::{BoardReport, Check};
use spindle_monitor::command::{self, Command, Order, Request};
use spindle_monitor::estimator::{Estimate, State as ProbeState};
use spindle_monitor::judgement::{AlarmChange, AlarmState};
use spindle_monitor::retained::{Recovery, RetentionReport};
use spindle_monitor::telemetry::{
    AlarmReport, EstimateReport, HealthReport, HelloReport, Payload, ProbeReport, ProbesReport,
    encode,
};
use std::io::{Cursor, Read, Write};
use std::sync::mpsc::RecvTimeoutError;
use std::time::{Duration, Instant};

/// The lines of a screen.
fn lines(screen: &Buffer) -> Vec<String> {
    let cells = screen.content().chunks(screen.area.width.into());
    let line = |cells: &[Cell]| cells.iter().map(Cell::symbol).collect::<String>();
    // A blank is a blank, whether it breaks or not.
    cells
        .map(|cells| line(cells).replace('\u{a0}', " "))
        .collect()
}

/// The text of the view.
fn text(state: &State) -> String {
    lines(&view::screen(state, 120, 45)).join("\n")
}

/// Whether the view has all of this.
fn shows(state: &State, parts: &[&str]) {
    let text = text(state);
    for part in parts {
        assert!(text.contains(part), "{part} is not in\n{text}");
    }
}

/// The colour of a text on the screen, if there is one.
fn colour(screen: &Buffer, text: &str) -> Option<Color> {
    let (y, line) = (0..)
        .zip(lines(screen))
        .find(|(_, line)| line.contains(text))?;
    let before = line[..line.find(text)?].chars().count() as u16;
    let cells: Vec<_> = (0..text.chars().count() as u16)
        .map(|i| screen[(before + i, y)].fg)
        .collect();
    cells
        .windows(2)
        .all(|pair| pair[0] == pair[1])
        .then_some(cells[0])
}

/// Places of the dots of a colour.
fn dots(screen: &Buffer, colour: Color) -> Vec<(f64, f64)> {
    let places = screen.area.positions().filter(|at| {
        let is_dots = |letter| ('\u{2801}'..='\u{28ff}').contains(&letter);
        screen[*at].fg == colour && screen[*at].symbol().starts_with(is_dots)
    });
    places
        .map(|at| (f64::from(at.x), -2.0 * f64::from(at.y)))
        .collect()
}

#[test]
fn a_stream_without_telemetry_is_an_error_that_says_what_to_look_at() {
    let tally = |bytes: &[u8]| {
        let mut decoder = Decoder::new();
        decoder.push_all(bytes).count();
        decoder.tally()
    };
    let noise = tally(&[9, 1, 1, 0, 7, 0]);
    let said = |tally, port| source::is_telemetry(tally, port).unwrap_err().to_string();
    assert!(said(&noise, None).contains("6 bytes"));
    assert!(said(&noise, Some(("COM3", 9600))).contains("at 9600 baud"));
    assert!(said(&tally(&[]), Some(("COM3", 9600))).contains("powered"));
    let mut bytes = vec![9, 1, 1, 0];
    bytes.extend(encode(&frame(0, Payload::Health(health()))));
    assert!(source::is_telemetry(&tally(&bytes), None).is_ok());
}

#[test]
fn a_stream_that_breaks_off_gives_what_came_and_then_its_error() {
    struct Unplugged;
    impl Read for Unplugged {
        fn read(&mut self, _: &mut [u8]) -> std::io::Result<usize> {
            Err(std::io::Error::other("unplugged"))
        }
    }
    let bytes = stream(&[frame(0, Payload::Health(health()))]);
    let breaking = Read::chain(Cursor::new(bytes.clone()), Unplugged);
    let mut chunks = source::stream(breaking).into_iter();
    assert_eq!(chunks.next().unwrap().unwrap(), bytes);
    assert_eq!(chunks.next().unwrap().unwrap_err().to_string(), "unplugged");
    assert!(chunks.next().is_none());
    let refused = source::port("/dev/there_is_no_such_port", 921_600);
    let said = refused.err().unwrap().to_string();
    assert!(said.contains("there_is_no_such_port"));
}

/// A pseudo-terminal is a port to whoever opens it.
#[test]
#[cfg(unix)]
fn the_bytes_of_a_port_arrive_as_they_were_sent_silence_is_no_end_and_unplugging_is() {
    use serialport::{SerialPort, TTYPort};
    let (mut sender, port_side) = TTYPort::pair().unwrap();
    let (chunks, mut operator) = source::port(&port_side.name().unwrap(), 921_600).unwrap();
    let next = || chunks.recv_timeout(Duration::from_secs(10));
    // All of them: a terminal would change some.
    let sent: Vec<u8> = (0..=255).collect();
    for _ in 0..2 {
        sender.write_all(&sent).unwrap();
        let mut received = Vec::new();
        while received.len() < sent.len() {
            received.extend(next().unwrap().unwrap());
        }
        assert_eq!(received, sent);
        std::thread::sleep(2 * source::PORT_TIMEOUT);
    }
    operator.want(Order::ReplaceBearing);
    operator.follow(&State::default()).unwrap();
    let wanted = Command::Ask(Request {
        number: 1,
        order: Order::ReplaceBearing,
    });
    let wanted = command::encode(wanted);
    let mut command = vec![0; wanted.len()];
    sender.read_exact(&mut command).unwrap();
    assert_eq!(command, *wanted);
    drop((sender, port_side));
    let last = next();
    assert!(!matches!(last, Ok(Ok(_)) | Err(RecvTimeoutError::Timeout)));
}

#[test]
fn a_recording_is_bytes_or_lines_of_json() {
    let frames = [0, 1].map(|i| frame(i, Payload::Health(health())));
    let bytes = stream(&frames);
    let mut lines = Vec::new();
    for event in Decoder::new().push_all(&bytes) {
        json::write(&mut lines, &event).unwrap();
    }
    for (name, content) in [("bytes", &bytes), ("lines", &lines)] {
        let path = std::env::temp_dir().join(format!("telemetry_{}_{name}", std::process::id()));
        std::fs::write(&path, content).unwrap();
        let chunks = source::recorded(path.to_str().unwrap()).unwrap();
        std::fs::remove_file(&path).unwrap();
        let read: Vec<_> = chunks.into_iter().map(Result::unwrap).collect();
        assert_eq!(read.concat(), bytes, "{name}");
    }
    assert!(source::recorded("there_is_no_such_file").is_err());
}

#[test]
fn a_paced_stream_takes_its_own_time_and_loses_nothing() {
    let bytes = stream(&[0, 200].map(|i| frame(i, Payload::Health(health()))));
    let began = Instant::now();
    let chunks = source::paced(source::stream(Cursor::new(bytes.clone())));
    let read: Vec<_> = chunks.into_iter().map(Result::unwrap).collect();
    assert_eq!(read.concat(), bytes);
    assert!(began.elapsed() >= Duration::from_millis(200));
}

#[test]
fn the_ball_with_the_largest_force_is_drawn_farthest_out_along_its_azimuth() {
    for hardest in 0..16 {
        let mut forces = [40.0; 16];
        forces[hardest] = 90.0;
        forces[(hardest + 5) % 16] = 0.0;
        let state = state_of(balls(0, &forces));
        let scale = view::scale(&state.balls[0]);
        assert!((90.0..=180.0).contains(&scale));
        let radius = |i| {
            let [(x, y), _] = view::places(&state.balls[0], i, scale).unwrap();
            f64::hypot(x, y)
        };
        for (i, force) in forces.into_iter().enumerate() {
            assert!((radius(i) - f64::from(force) / scale).abs() < 1e-9);
        }
        // On the screen: red dots from the middle of the picture towards the ball, y to the right and z
        // up, and nowhere else.
        let dots = dots(&view::screen(&state, 120, 40), Color::Red);
        assert!(!dots.is_empty());
        let (towards_z, towards_y) = state.balls[0].azimuth(hardest).sin_cos();
        let extent = |along: (f64, f64)| {
            let places = dots.iter().map(|(x, y)| x * along.0 + y * along.1);
            places.clone().fold(f64::MIN, f64::max) - places.fold(f64::MAX, f64::min)
        };
        let length = extent((towards_y, towards_z));
        let width = extent((-towards_z, towards_y));
        assert!(
            length > 4.0 * width,
            "ball {hardest}: {length} long, {width} wide"
        );
    }
}

#[test]
fn a_pair_shows_both_rows_and_their_places_on_the_shaft() {
    let mut slipping = alarm(Alarm::Slip, AlarmChange::Raised, AlarmState::Raised);
    slipping.place = Some(19);
    let state = state_of(pair().into_iter().chain([Payload::Alarm(slipping)]));
    let parts = [
        "nose 61, 30, 37 N/um",
        " at mm  faces  axial N  radial N preload N balls N",
        " row 0  -20    +x     412      50       244       12 to 95       cage 83.4, ball 532, outer 1334, inner 1866 Hz",
        " row 1  20     -x     244      50       244       12 to 95",
        " row 0 ball 0: 90 N ",
        " row 1 ball 0: 54 N ",
        " rim 90 N ",
        "nose at 90 mm, loads at 120 mm, mounted with 250 N",
        "row 1 ball 3",
        "inner side 41.2 °C;",
        "outer side 36.5 °C is held: not measured any more",
    ];
    shows(&state, &parts);
    let screen = view::screen(&state, 120, 45);
    assert_eq!(colour(&screen, "outer side 36.5"), Some(Color::Red));
    assert_eq!(colour(&screen, "inner side 41.2"), Some(Color::Reset));
    assert_eq!(
        colour(&screen, "row 0  -20    +x     412"),
        Some(Color::Reset)
    );
    assert!(!text(&state).contains("lifted off"));
}

/// Levels of alarms are in the units of files, as in the tables of `--limits`.
#[test]
fn levels_of_alarms_are_shown_in_the_units_of_files() {
    let of = |of, value, limit| {
        let report = alarm(of, AlarmChange::Raised, AlarmState::Raised);
        Payload::Alarm(AlarmReport {
            value,
            limit,
            ..report
        })
    };
    let payloads = [
        of(Alarm::PeakPressure, 2.131e9, 2e9),
        of(Alarm::ContactAngle, -0.017_453_293, 0.0),
        of(Alarm::Overload, 1.161_235_3, 1.0),
        of(Alarm::LifeUsed, 0.805, 0.8),
        of(Alarm::Sensor, 0.125, 0.1),
        of(Alarm::UnloadedBalls, 3.0, 0.5),
    ];
    let parts = [
        "2.131 of 2 GPa",
        "-1 of 0 deg",
        "116.124 of 100 %",
        "80.5 of 80 %",
        "0.125 of 0.1 s",
        "3 of 0.5 ",
    ];
    shows(&state_of(payloads), &parts);
}

/// Of any spindle that a file may have, each row has its place, and each alarm its row.
#[test]
fn all_of_eight_rows_have_a_place_and_a_facing() {
    let places: [_; 8] = std::array::from_fn(|i| (0.02 * i as f32, i > 3, 16));
    let mut slipping = alarm(Alarm::Slip, AlarmChange::Raised, AlarmState::Raised);
    slipping.place = Some(7 * 16 + 2);
    let payloads = [shaft(&places), Payload::Alarm(slipping)];
    let state = state_of(payloads.into_iter().chain(rows(&[212.0; 8], 170.0)));
    let parts = [
        " row 3  60     +x     212",
        " row 4  80     -x     212",
        " row 7  140    -x     212",
        "row 7 ball 2",
    ];
    shows(&state, &parts);
}

#[test]
fn a_row_that_has_lost_its_preload_is_told_from_the_others() {
    let state = state_of(pair().into_iter().chain(rows(&[250.0, -1.0], 0.0)));
    let screen = view::screen(&state, 120, 45);
    let lifted = "row 1  20     -x     -1       50       0         12 to 95       lifted off";
    assert_eq!(colour(&screen, lifted), Some(Color::Red));
    assert_eq!(
        colour(&screen, "row 0  -20    +x     250"),
        Some(Color::Reset)
    );
}

#[test]
fn a_single_row_is_shown_without_its_name_and_without_a_shaft() {
    let mut slipping = alarm(Alarm::Slip, AlarmChange::Raised, AlarmState::Raised);
    slipping.place = Some(3);
    let mut payloads = balls(0, &[50.0; 16]);
    payloads.extend(rows(&[250.0], 0.0));
    payloads.extend([
        shaft(&[(0.0, false, 16)]),
        Payload::Alarm(slipping),
        Payload::Health(health()),
    ]);
    let state = state_of(payloads);
    for word in [" row ", "faces", "preload"] {
        assert!(!text(&state).contains(word), "{word}");
    }
    shows(&state, &[" ball 3 "]);
}

#[test]
fn any_state_can_be_drawn_on_any_screen() {
    let nothing = f32::NAN;
    let broken = EstimateReport {
        stiffness: [nothing, f32::INFINITY, -1.0, 0.0, f32::MAX],
        ..estimate(1.0)
    };
    let single = balls(0, &[nothing, f32::INFINITY, 0.0, -5.0, 1e30]);
    let quad = [
        (-0.03, false, 18),
        (-0.01, false, 18),
        (0.01, true, 18),
        (0.03, true, 18),
    ];
    let of_quad = [shaft(&quad)]
        .into_iter()
        .chain(rows(&[212.0, 204.0, nothing, -1.0], 170.0))
        .chain(balls(3, &[50.0, 0.0, nothing]));
    let nowhere = [
        (nothing, false, 0),
        (f32::MAX, true, 1),
        (f32::MIN, true, 1),
    ];
    let many = rows(&[1.0; 255], 0.0).into_iter();
    let states = [
        State::default(),
        state_of(single.into_iter().chain([Payload::Estimate(broken)])),
        state_of(pair()),
        state_of(of_quad),
        state_of([shaft(&nowhere)]),
        state_of([shaft(&[(0.09, true, 16); 2]), Payload::Health(health())]),
        state_of(many.chain(balls(u8::MAX, &[1.0; 3]))),
    ];
    for state in &states {
        for width in [0, 1, 2, 20, 47, 80, 300] {
            for height in [0, 1, 3, 9, 30, 100] {
                let screen = view::screen(state, width, height);
                assert_eq!(screen.area.area(), u32::from(width) * u32::from(height));
            }
        }
    }
}

const fn one(value: f32, error: f32) -> Estimate {
    Estimate { value, error }
}

/// A report of two probes on a spindle of 250 N.
fn measured(state: ProbeState, of_probes: [ProbeState; 2]) -> ProbesReport {
    let probe = |(state, ratio)| ProbeReport {
        state,
        gain: one(0.987, 0.0123),
        ratio,
    };
    let ratios = [Some(0.9871), Some(0.001)];
    ProbesReport {
        state,
        preload: Some(one(198.4, 6.2)),
        change: Some(one(-0.208, 0.021)),
        steps: 341,
        aliased: false,
        probes: of_probes.into_iter().zip(ratios).map(probe).collect(),
    }
}

/// The view of a pair with this report, and an alarm.
fn measured_pair(report: ProbesReport, alarms: &[AlarmReport]) -> State {
    let alarms = alarms.iter().copied().map(Payload::Alarm);
    let report = [Payload::Probes(report)];
    let estimates = (0..100).map(|_| Payload::Estimate(estimate(6e7)));
    state_of(
        pair()
            .into_iter()
            .chain(report)
            .chain(alarms)
            .chain(estimates),
    )
}

#[test]
fn the_measured_preload_is_drawn_with_its_error_and_each_probe_has_its_line() {
    let lost = measured(ProbeState::PreloadLoss, [ProbeState::Ok, ProbeState::Probe]);
    let state = measured_pair(lost, &[]);
    let parts = [
        " preload: 198 +- 6 N measured ",
        "spindle preload-loss: 20.8 +- 2.1 % of the preload is lost, 341 load steps",
        "probe 0 ok: gain 0.987 +- 0.012",
        "probe 1 probe: does not follow the loads: 0.0010 of the computed motion: mm for um?",
    ];
    shows(&state, &parts);
    let screen = view::screen(&state, 120, 45);
    for (part, expected) in parts[1..]
        .iter()
        .zip([Color::Red, Color::Reset, Color::Red])
    {
        assert_eq!(colour(&screen, part), Some(expected), "{part}");
    }
    // The curve, and a bar of four standard errors, on the left of the balls.
    let curve = dots(&screen, Color::Green);
    let heights = curve.iter().filter(|(x, _)| *x < 50.0).map(|(_, y)| *y);
    let ends = heights
        .map(|y| [y; 2])
        .reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])]);
    let [least, most] = ends.unwrap();
    assert!(most > least, "{least} to {most}");
}

#[test]
fn a_preload_without_probes_is_the_computed_one_and_a_row_alone_has_none() {
    let state = state_of(pair().into_iter().chain([Payload::Estimate(estimate(6e7))]));
    shows(&state, &[" preload: 244 N computed "]);
    assert!(!text(&state).contains("probe"));
    shows(&state_of([Payload::Estimate(estimate(6e7))]), &["Kty 8.0"]);
    // Probes on rows that do not face each other know no preload.
    let report = ProbesReport {
        preload: None,
        change: None,
        ..measured(ProbeState::Learning, [ProbeState::Learning; 2])
    };
    let state = measured_pair(report, &[]);
    shows(
        &state,
        &["Kty 8.0", "probe 0 learning: 0.9871 of the computed motion"],
    );
}

#[test]
fn learning_says_what_is_missing() {
    let of = |steps, error| ProbesReport {
        preload: Some(one(250.0, error)),
        change: None,
        steps,
        aliased: true,
        ..measured(ProbeState::Learning, [ProbeState::Learning; 2])
    };
    let due = "loads of another direction or size: preload known to 8 %, 3 % is due";
    for (steps, error, told) in [
        (
            143,
            19.0,
            format!("spindle learning: 57 load steps to go; {due}"),
        ),
        (200, 19.0, format!("spindle learning: {due}")),
        (143, 5.0, "spindle learning: 57 load steps to go".into()),
    ] {
        let state = measured_pair(of(steps, error), &[]);
        shows(&state, &[&told, "readings do not count"]);
        let screen = view::screen(&state, 120, 45);
        assert_eq!(colour(&screen, &told), Some(Color::Reset));
    }
}

#[test]
fn alarms_of_gains_say_where_to_look() {
    for (which, state) in [
        (Alarm::StiffnessLoss, ProbeState::StiffnessLoss),
        (Alarm::StiffnessGain, ProbeState::StiffnessGain),
    ] {
        let raised = AlarmReport {
            value: 0.0817,
            limit: 0.05,
            place: Some(1),
            ..alarm(which, AlarmChange::Raised, AlarmState::Raised)
        };
        let state = measured_pair(measured(state, [ProbeState::Ok, state]), &[raised]);
        let more = if which == Alarm::StiffnessLoss {
            "more"
        } else {
            "less"
        };
        shows(
            &state,
            &[
                &format!("a probe sees {more} motion than the preload explains"),
                "8.17 of 5 %",
                "probe 1        since",
                "a support, the probe, its mount or the load cells",
            ],
        );
    }
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
    assert!(text.contains(&format!("{} not acknowledged", Alarm::COUNT)));
    let places: Vec<usize> = Alarm::ALL
        .map(|a| text.find(&format!(" {} ", a.name())).unwrap())
        .into();
    assert!(places.is_sorted(), "{places:?}");
}

#[test]
fn the_last_stiffness_is_there_as_a_number_and_the_course_falls_with_it() {
    let falling = (0..600).map(|i| Payload::Estimate(estimate(5e7 * (1.0 - i as f32 / 1200.0))));
    let state = state_of(falling);
    shows(&state, &["Kx 25.0"]);
    // From the left to the right.
    let mut dots = dots(&view::screen(&state, 120, 60), Color::Yellow);
    dots.sort_by(|a, b| a.0.total_cmp(&b.0).then(b.1.total_cmp(&a.1)));
    assert!(dots.len() > 20);
    assert!(dots[0].1 > dots[dots.len() - 1].1);
    assert!(dots.is_sorted_by(|a, b| a.1 >= b.1), "{dots:?}");
}

#[test]
fn a_doubted_sample_is_named_and_is_no_point_of_the_course() {
    let doubted = EstimateReport {
        age: 7,
        marks: Mark::Stuck | Mark::SpeedMissing,
        ..estimate(5e7)
    };
    let state = state_of([estimate(6e7), doubted].map(Payload::Estimate));
    assert!(state.history[0].trusted && !state.history[1].trusted);
    shows(
        &state,
        &["7 ticks old", "doubted: stuck | speed-missing", "Kx 60.0"],
    );
}

#[test]
fn hardest_ball_checks_of_the_board_and_words_to_it_are_shown() {
    for part in ["self-check", "acknowledged", "ball 11"] {
        assert!(!text(&State::default()).contains(part));
    }
    shows(&State::default(), &["no balls known"]);
    let mut forces = [40.0; 16];
    forces[11] = 123.4;
    let hello = HelloReport {
        board: BoardReport {
            known_answer: Check::Passed,
            image: Check::Failed,
            ..BoardReport::NONE
        },
        ..HelloReport::default()
    };
    let payloads = balls(0, &forces).into_iter();
    let mut state = state_of(payloads.chain([Payload::Hello(hello)]));
    state.said = Some("2 alarms acknowledged".into());
    let parts = [
        "ball 11: 123 N",
        "rim 200 N",
        "self-check of code in flash failed",
        "self-check of a solve passed",
    ];
    shows(&state, &parts);
    shows(&state, &["2 alarms acknowledged"]);
}

#[test]
fn losses_and_counters_are_on_the_health_lines() {
    let late = HealthReport {
        overruns: 3,
        marked_samples: 41,
        most_cycles: 120_345,
        retention: RetentionReport {
            recovery: Recovery::OtherSpindle,
            estimates: Recovery::Recovered,
            damaged: 1,
            written: 12,
            failed: 2,
        },
        ..health()
    };
    let (mut state, mut decoder) = (State::default(), Decoder::new());
    let first = frame(0, Payload::Health(health()));
    note(&mut state, &mut decoder, &[first]);
    shows(
        &state,
        &["no memory: life and alarms are lost with the power"],
    );
    for event in decoder.push_all(&[9, 1, 1, 0]).collect::<Vec<_>>() {
        state.note(&event, decoder.tally());
    }
    note(&mut state, &mut decoder, &[frame(5, Payload::Health(late))]);
    let parts = [
        "3 ticks past their deadline;",
        "life and alarms begin at 0: those kept are another",
        "1 kept records damaged",
        "2 records not kept: the flash is worn or full",
        "1000 ticks;",
        "120345 cycles in the longest tick",
        "41 samples doubted",
        "12 records kept",
        "2 frames in",
        "4 lost,",
        "1 damaged pieces",
        "frame stuffing broken",
    ];
    shows(&state, &parts);
    let screen = view::screen(&state, 120, 45);
    for (text, expected) in [
        ("3 ticks past", Color::Red),
        ("begin at 0", Color::Red),
        ("1000 ticks", Color::Reset),
        ("4 lost,", Color::Red),
    ] {
        assert_eq!(colour(&screen, text), Some(expected), "{text}");
    }
    // What is wrong comes first, and what has not happened is left out.
    let shown = lines(&screen).join("\n");
    assert!(shown.find("4 lost") < shown.find("1000 ticks"));
    for none in ["never began", "load records", "estimates of the probes"] {
        assert!(!shown.contains(none), "{none}");
    }
}

//! The live view of the telemetry shows what is so, and so does its picture.

use crate::frames::{
    alarm, balls, balls_of, estimate, frame, health, inputs, pair, rows, shaft, state_of, stream,
};
use host_tests::telemetry::decoder::Decoder;
use host_tests::telemetry::state::State;
use ratatui::buffer::Buffer;
use ratatui::style::Color;
use spindle_bearing::monitor::board::{BoardReport, Check};
use spindle_bearing::monitor::judgement::{Alarm, AlarmChange, AlarmState};
use spindle_bearing::monitor::telemetry::{
    EstimateReport, HealthReport, Payload, Recovery, RetentionReport, encode,
};
use spindle_bearing::monitor::{Mark, Marks, TemperatureSource};
use std::io::Cursor;
use tools::telemetry::{picture, source, view};

/// The lines of the view.
fn text(state: &State) -> String {
    text_of(&view::screen(state, 120, 40))
}

fn text_of(screen: &Buffer) -> String {
    let mut text = String::new();
    for (i, cell) in screen.content().iter().enumerate() {
        text += cell.symbol();
        if (i + 1) % usize::from(screen.area.width) == 0 {
            text.push('\n');
        }
    }
    text
}

/// Whether a text is on the screen, all of it in one colour.
fn is_in_colour(screen: &Buffer, text: &str, colour: Color) -> bool {
    let width = usize::from(screen.area.width);
    screen.content().chunks(width).any(|line| {
        let symbols: Vec<_> = line.iter().map(|cell| cell.symbol()).collect();
        let length = text.chars().count();
        let mut parts = line.windows(length).zip(symbols.windows(length));
        parts.any(|(cells, part)| {
            part.concat() == text && cells.iter().all(|cell| cell.fg == colour)
        })
    })
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
    let error = source::port("/dev/there_is_no_such_port", 460_800, None)
        .err()
        .unwrap();
    assert!(error.to_string().contains("there_is_no_such_port"));
}

#[test]
fn the_ball_with_the_largest_force_is_drawn_farthest_out_along_its_azimuth() {
    for hardest in 0..16 {
        let mut forces = [40.0; 16];
        forces[hardest] = 90.0;
        forces[(hardest + 5) % 16] = 0.0;
        let state = state_of(balls(&forces));
        let scale = view::scale(&state.balls[0]);
        assert!((90.0..=180.0).contains(&scale));
        let radius = |i| {
            let [(x, y), _] = view::places(&state.balls[0], i, scale).unwrap();
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
        let axes = state.balls[0].azimuth(hardest);
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
fn a_pair_shows_both_rows_and_how_they_stand_on_the_shaft() {
    let mut slipping = alarm(Alarm::Slip, AlarmChange::Raised, AlarmState::Raised);
    slipping.ball = Some(19);
    let mut payloads = pair();
    payloads.push(Payload::Alarm(slipping));
    payloads.push(Payload::Health(health()));
    let state = state_of(payloads);
    let screen = view::screen(&state, 120, 45);
    let text = text_of(&screen);
    for part in [
        "nose 61, 30, 37 N/um",
        "row 0: axial   412 N, radial    50 N, preload   244 N, balls 12 to 95 N",
        "row 1: axial   244 N, radial    50 N, preload   244 N, balls 12 to 95 N",
        " row 0 ball 0: 90 N ",
        " row 1 ball 0: 54 N ",
        " rim 100 N ",
        " shaft: rows +x -x and their preload ",
        "0: 244 N",
        "1: 244 N",
        " nose ",
        " loads ",
        " mounted with 250 N ",
        ", row 1 ball 3, since",
        "temperatures: inner 41.2 C measured, outer 36.5 C held",
    ] {
        assert!(text.contains(part), "{part} is not in\n{text}");
    }
    assert!(is_in_colour(&screen, " 36.5 C held", Color::Red));
    assert!(!is_in_colour(&screen, " 41.2 C measured", Color::Red));
    assert!(!is_in_colour(&screen, "row 0: axial", Color::Red));
    assert!(!text.contains("lifted off"));
}

#[test]
fn a_row_that_has_lost_its_preload_is_told_from_the_others() {
    let state = state_of(pair().into_iter().chain(rows(&[250.0, -1.0], 0.0)));
    let screen = view::screen(&state, 120, 45);
    assert!(is_in_colour(&screen, "row 1: axial    -1 N", Color::Red));
    assert!(is_in_colour(&screen, "1: 0 N", Color::Red));
    assert!(!is_in_colour(&screen, "row 0: axial   250 N", Color::Red));
    assert!(!is_in_colour(&screen, "0: 0 N", Color::Red));
}

/// Where the contact lines of each row meet the axis, to the left of its middle or to the right.
#[test]
fn contact_lines_lean_as_the_rows_face() {
    // Columns of the green dots nearest to the axis, of rows far apart.
    let apexes = |mirrored: [bool; 2]| -> Vec<u16> {
        let places = [(-0.1, mirrored[0], 16), (0.09, mirrored[1], 16)];
        let mut payloads = vec![shaft(&places)];
        payloads.extend(rows(&[250.0, 250.0], 0.0));
        let screen = view::screen(&state_of(payloads), 120, 45);
        let green: Vec<_> = screen
            .area
            .positions()
            .filter(|at| screen[*at].fg == Color::Green)
            .collect();
        let top = green.iter().map(|at| at.y).min().unwrap();
        let bottom = green.iter().map(|at| at.y).max().unwrap();
        let axis = (top + bottom).div_ceil(2);
        green
            .iter()
            .filter(|at| at.y == axis)
            .map(|at| at.x)
            .collect()
    };
    let ends = |columns: Vec<u16>| (columns[0], columns[columns.len() - 1]);
    let back_to_back = ends(apexes([false, true]));
    let face_to_face = ends(apexes([true, false]));
    assert!(
        back_to_back.0 < face_to_face.0,
        "{back_to_back:?} {face_to_face:?}"
    );
    assert!(
        back_to_back.1 > face_to_face.1,
        "{back_to_back:?} {face_to_face:?}"
    );
}

#[test]
fn a_single_row_is_shown_without_its_name_and_without_a_shaft() {
    let mut slipping = alarm(Alarm::Slip, AlarmChange::Raised, AlarmState::Raised);
    slipping.ball = Some(3);
    let mut payloads = balls(&[50.0; 16]);
    payloads.push(shaft(&[(0.0, false, 16)]));
    payloads.extend(rows(&[250.0], 0.0));
    payloads.push(Payload::Alarm(slipping));
    payloads.push(Payload::Health(health()));
    payloads.push(inputs([TemperatureSource::Unused; 2]));
    let text = text(&state_of(payloads));
    for word in ["row", "shaft", "preload", "temperatures"] {
        assert!(!text.contains(word), "{word} is in\n{text}");
    }
    assert!(text.contains(", ball 3, since"));
}

#[test]
fn spindles_of_any_number_of_rows_can_be_drawn_on_any_screen() {
    let quad = [
        (-0.03, false, 18),
        (-0.01, false, 18),
        (0.01, true, 18),
        (0.03, true, 18),
    ];
    let of_quad = [shaft(&quad)]
        .into_iter()
        .chain(rows(&[212.0, 204.0, f32::NAN, -1.0], 170.0))
        .chain(balls_of(3, &[50.0, 0.0, f32::NAN]));
    let nowhere = [
        (f32::NAN, false, 0),
        (f32::MAX, true, 1),
        (f32::MIN, true, 1),
    ];
    let states = [
        state_of(pair()),
        state_of(of_quad),
        state_of([shaft(&nowhere)]),
        state_of([shaft(&[(0.09, true, 16); 2]), Payload::Health(health())]),
        state_of(
            rows(&[1.0; 255], 0.0)
                .into_iter()
                .chain(balls_of(u8::MAX, &[1.0; 3])),
        ),
    ];
    for state in &states {
        for width in [0, 1, 2, 20, 47, 80, 119, 139] {
            for height in [0, 1, 3, 9, 17, 30, 45, 59] {
                let screen = view::screen(state, width, height);
                assert_eq!(screen.area.area(), u32::from(width) * u32::from(height));
            }
        }
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
    assert!(text(&state).contains("Kx 25.0"), "{}", text(&state));
    let screen = view::screen(&state, 120, 60);
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
fn a_board_says_what_its_checks_come_to_and_a_monitor_without_one_says_nothing() {
    let report = BoardReport {
        known_answer: Check::Passed,
        image: Check::Failed,
        ..BoardReport::NONE
    };
    let shown = |report| text(&state_of([Payload::Board(report)]));
    let said = "known answer passed, image failed";
    assert!(shown(report).contains(said), "{}", shown(report));
    assert!(!shown(BoardReport::NONE).contains("known answer"));
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

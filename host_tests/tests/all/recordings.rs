//! From a recording to results: formats of files, what is refused and how, and that nothing is lost between the
//! solver and the table.

use crate::malformed::{self, HEADER};
use host_tests::design_file::{DesignFile, DesignFileError, SHIPPED};
use host_tests::dispatch::{
    self, Answer, AnySolver, Attitude, BALL_COUNTS, Figures, Precision, Wanted,
};
use host_tests::loads::write_csv;
use host_tests::loads::{self, COLUMNS, LoadRow, Loads, LoadsError};
use host_tests::milling_cycle::{CRASH, NOSE_RECORD, Place, RECORD, recorded};
use host_tests::replay::{OneBearing, Outputs, replay};
use host_tests::warm_up;
use spindle_bearing::{Design, FreeContact, LimitSet, Limits, Material};
use std::io::Cursor;

fn shipped(name: &str) -> String {
    format!("{SHIPPED}/{name}.toml")
}

fn parsed(csv: &str) -> Result<Vec<LoadRow>, LoadsError> {
    Loads::from_reader("loads.csv", Box::new(Cursor::new(csv.as_bytes().to_vec())))?.collect()
}

/// Pseudo-random bit patterns (xorshift).
fn patterns(count: usize) -> impl Iterator<Item = u64> {
    let mut x = 0x2545_F491_4F6C_DD1D_u64;
    (0..count).map(move |_| {
        x ^= x << 13;
        x ^= x >> 7;
        x ^= x << 17;
        x
    })
}

#[test]
fn a_printed_number_reads_back_exactly_in_its_precision() {
    let edges = [0.0, -0.0, 5e-324, 2.2250738585072014e-308, 1e-4, 1e16];
    let wide = patterns(20_000).map(f64::from_bits).chain(edges);
    for x in wide.filter(|x| x.is_finite()) {
        let text = Precision::F64.show(x).to_string();
        assert_eq!(
            text.parse::<f64>().unwrap().to_bits(),
            x.to_bits(),
            "{text}"
        );
        assert!(text.len() <= 24, "{text}");
    }
    let narrow = patterns(20_000).map(|bits| f32::from_bits(bits as u32));
    for x in narrow.filter(|x| x.is_finite()) {
        let text = Precision::F32.show(f64::from(x)).to_string();
        assert_eq!(
            text.parse::<f32>().unwrap().to_bits(),
            x.to_bits(),
            "{text}"
        );
        let digits = text.split('e').next().unwrap();
        let digits = digits.trim_start_matches(['-', '0', '.']);
        let digits = digits.trim_end_matches('0');
        assert!(digits.len() <= 10, "more digits than f32 has: {text}");
    }
    assert_eq!(Precision::F32.show(f64::from(0.1_f32)).to_string(), "0.1");
}

#[test]
fn columns_may_stand_in_any_order() {
    let plain = parsed(&format!("{HEADER}1,2,3,4,5,6,7\n")).unwrap();
    assert_eq!(
        plain,
        [LoadRow {
            time_s: 1.0,
            load: [2.0, 3.0, 4.0, 5.0, 6.0],
            speed_rpm: 7.0,
            temperatures: None,
        }]
    );
    let turned = "speed_rpm,mz_nm,my_nm,fz_n,fy_n,fx_n,time_s\n7,6,5,4,3,2,1\n";
    assert_eq!(parsed(turned).unwrap(), plain);
}

#[test]
fn files_of_spreadsheets_are_read() {
    let plain = parsed(&format!("{HEADER}1,2,3,4,5,6,7\n8,9,10,11,12,13,14\n")).unwrap();
    let header = HEADER.trim_end();
    for text in [
        // Line ends of Windows, no end of the last line, byte order mark, blank lines, quotes.
        format!("{header}\r\n1,2,3,4,5,6,7\r\n8,9,10,11,12,13,14\r\n"),
        format!("{header}\n1,2,3,4,5,6,7\n8,9,10,11,12,13,14"),
        format!("\u{feff}{header}\n1,2,3,4,5,6,7\n8,9,10,11,12,13,14\n"),
        format!("\n{header}\n\n1,2,3,4,5,6,7\n \n8,9,10,11,12,13,14\n\n"),
        format!("{header}\n1, 2 ,3,4,5,6,7\n8,+9,1e1,11.,12,13,\"14\"\n"),
    ] {
        assert_eq!(parsed(&text).unwrap(), plain, "{text:?}");
    }
}

#[test]
fn a_malformed_recording_is_refused_with_line_and_column() {
    for (text, start) in malformed::recordings() {
        let error = parsed(&text).unwrap_err();
        assert!(!matches!(error, LoadsError::Row(_)), "{error}");
        let (error, expected) = (error.to_string(), format!("loads.csv: {start}"));
        assert!(error.starts_with(&expected), "{error}\nnot\n{expected}");
    }
}

#[test]
fn a_row_that_cannot_be_read_is_refused_with_line_and_column_and_the_next_one_is_read() {
    for (text, start) in malformed::rows() {
        let line = |text: &str| {
            text.lines()
                .nth(usize::from(text.starts_with('#')))
                .unwrap()
                .to_owned()
        };
        let separator = if line(&text).contains(';') { ";" } else { "," };
        let text = text + &["11", "12", "13", "14", "15", "16", "17\n"].join(separator);
        let input = Box::new(Cursor::new(text.as_bytes().to_vec()));
        let rows: Vec<_> = Loads::from_reader("loads.csv", input).unwrap().collect();
        let mut faults = rows.iter().filter_map(|row| row.as_ref().err());
        let Some(error @ LoadsError::Row(_)) = faults.next() else {
            panic!("{text}");
        };
        let (error, expected) = (error.to_string(), format!("loads.csv: {start}"));
        assert!(error.starts_with(&expected), "{error}\nnot\n{expected}");
        assert!(faults.next().is_none());
        assert_eq!(rows.last().unwrap().as_ref().unwrap().time_s, 11.0);
    }
}

#[test]
fn what_can_be_read_of_a_refused_row_is_kept() {
    let numbers = |row: &str| match parsed(&format!("{HEADER}{row}\n")) {
        Err(LoadsError::Row(row)) => row.numbers,
        other => panic!("{other:?}"),
    };
    let [a, b] = [Some(1.0), Some(7.0)];
    assert_eq!(
        numbers("1,,three,4,5,6,7"),
        [a, None, None, Some(4.0), Some(5.0), Some(6.0), b]
    );
    // Which column a number belongs to is not known in a row with a field too many or too few.
    assert_eq!(numbers("1,5,2,3,4,5,6,7"), [None; 7]);
    assert_eq!(numbers("1,,3"), [None; 7]);
}

#[test]
fn separators_and_decimal_marks_of_all_countries_are_understood() {
    let plain = parsed(&format!("{HEADER}0.5,-2,3e3,4,5,6,7.25\n1,2,3,4,5,6,7\n")).unwrap();
    for text in [
        "time_s;fx_n;fy_n;fz_n;my_nm;mz_nm;speed_rpm\n0,5;-2;3e3;4;5;6;7,25\n1;2;3;4;5;6;7\n",
        "time_s;fx_n;fy_n;fz_n;my_nm;mz_nm;speed_rpm\n0.5;-2;3e3;4;5;6;7.25\n1;2;3;4;5;6;7\n",
        "time_s\tfx_n\tfy_n\tfz_n\tmy_nm\tmz_nm\tspeed_rpm\n0,5\t-2,0\t3e3\t4\t5\t6\t7,25\n1\t2\t3\t4\t5\t6\t7\n",
        "# logger 5; 2024-03-01\n\u{20} TIME_S ; Fx_N;FY_N ;fz_n;my_nm;mz_nm;Speed_RPM\r\n\n\
         # start\n0,5;\"-2\";3,0e3;4;5;6;7,25\r\n#\n 1;2;3;4;5;6;7",
        "\u{feff}\"time_s\";\"fx_n\";\"fy_n\";\"fz_n\";\"my_nm\";\"mz_nm\";\"speed_rpm\"\n\
         \"0,5\";-2;3e3;4;5;6;7,25\n1;2;3;4;5;6;7\n",
    ] {
        assert_eq!(parsed(text).unwrap(), plain, "{text:?}");
    }
}

#[test]
fn columns_of_others_are_ignored_and_named() {
    let text = "no,time_s,\"remark; long\",fx_n,fy_n,fz_n,my_nm,mz_nm,speed_rpm,fx_kn,\n\
                a,1,\"so, so\",2,3,4,5,6,7,,\n";
    let input = Box::new(Cursor::new(text.as_bytes().to_vec()));
    let mut loads = Loads::from_reader("loads.csv", input).unwrap();
    assert_eq!(loads.ignored_columns(), ["no", "remark; long", "fx_kn"]);
    assert!(!loads.has_temperatures());
    let plain = parsed(&format!("{HEADER}1,2,3,4,5,6,7\n")).unwrap();
    assert_eq!(loads.next().unwrap().unwrap(), plain[0]);
}

/// Bytes that nobody meant to be a recording end in an error or in rows, never in a panic or without end.
#[test]
fn any_bytes_are_refused_or_read() {
    let pieces: [&[u8]; 14] = [
        HEADER.as_bytes(),
        b"1,2,3,4,5,6,7\n",
        b";",
        b"\t",
        b",",
        b"\"",
        b"\n",
        b"\r",
        b"#",
        b"\xFF",
        b"\0",
        b"1e999",
        b"nan",
        b"\xEF\xBB\xBF",
    ];
    for seed in 0..4000 {
        let mut bytes = if seed % 2 == 0 {
            HEADER
                .replace(',', [",", ";", "\t"][seed / 2 % 3])
                .into_bytes()
        } else {
            Vec::new()
        };
        let mut x = (seed as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
        for _ in 0..40 {
            x ^= x << 13;
            x ^= x >> 7;
            x ^= x << 17;
            bytes.extend(pieces[(x % 14) as usize]);
        }
        let length = bytes.len();
        if let Ok(loads) = Loads::from_reader("x", Box::new(Cursor::new(bytes))) {
            assert!(loads.count() <= length);
        }
    }
}

#[test]
fn bytes_that_are_no_text_are_refused_with_line_and_column() {
    let mut bytes = format!("{HEADER}1,2,3,4,5,6,7\n").into_bytes();
    bytes.extend(b"1,2,\xFF\xFE,4,5,6,7\n");
    let error = Loads::from_reader("x", Box::new(Cursor::new(bytes)))
        .unwrap()
        .find_map(Result::err)
        .unwrap();
    assert!(
        error
            .to_string()
            .starts_with("x: line 3, column 3 (fy_n): "),
        "{error}"
    );
}

/// Says what it is told to say.
struct Parrot(Answer);

impl AnySolver for Parrot {
    fn ball_count(&self) -> usize {
        3
    }

    fn precision(&self) -> Precision {
        Precision::F32
    }

    fn solve_for(&mut self, _: [f64; 5], _: f64, _: Wanted<'_>) -> Answer {
        self.0.clone()
    }

    fn reset(&mut self) {}

    fn set_limits(&mut self, _: &Limits<f64>) {}

    fn set_settings(&mut self, _: f64, _: u16) {}
}

#[test]
fn figures_are_printed_as_the_solver_gave_them() {
    let mut solver = Parrot(Answer {
        status: "precision-limit",
        figures: Ok(Figures {
            iterations: 40,
            displacement: [f64::from(1e-7_f32), 0.0, -2.5, 0.0, f64::from(-3e-9_f32)],
            stiffness: [[1e8, 0.0, 0.0, 0.0, f64::from(0.3_f32)]; 5],
            limits: LimitSet::default(),
            error: None,
        }),
    });
    let row = LoadRow {
        time_s: 0.1,
        // A load is copied, though it is none of single precision.
        load: [0.1, 0.0, 0.0, 0.0, -2e-5],
        speed_rpm: 6000.0,
        temperatures: None,
    };
    let mut out = Vec::new();
    let rows = [Ok(row)].into_iter();
    let mut solver = OneBearing {
        solver: &mut solver,
        rating: None,
    };
    let summary = replay(&mut solver, rows, false, &mut Outputs::of(&mut out)).unwrap();
    assert_eq!(summary.rows, 1);
    assert!(summary.refused.is_empty());
    let out = String::from_utf8(out).unwrap();
    assert_eq!(
        out.lines().nth(1).unwrap(),
        format!(
            "0.1,precision-limit,40,1e-7,0,-2.5,0,-3e-9{},,0.1,0,0,0,-2e-5,6000,,",
            ",100000000,0,0,0,0.3".repeat(5)
        )
    );
}

/// Where a solve stopped for want of iterations there is no equilibrium, and no figure of one.
#[test]
fn a_solve_that_ran_out_of_iterations_has_no_figures() {
    let file = DesignFile::read(shipped("b7005c")).unwrap();
    for precision in [Precision::F32, Precision::F64] {
        let bearing = dispatch::bearing(&file.design, file.balls, precision).unwrap();
        let mut solver = bearing.solver(Attitude::Raceless);
        solver.set_settings(1e-6, 1);
        let row = LoadRow {
            time_s: 0.5,
            load: [1000.0, 200.0, 0.0, 0.0, 3.0],
            speed_rpm: 20_000.0,
            temperatures: None,
        };
        let (mut out, mut balls) = (Vec::new(), Vec::new());
        let rows = [Ok(row)].into_iter();
        let mut outputs = Outputs {
            balls: Some(&mut balls),
            ..Outputs::of(&mut out)
        };
        let mut solver = OneBearing {
            solver: solver.as_mut(),
            rating: None,
        };
        let summary = replay(&mut solver, rows, false, &mut outputs).unwrap();
        let count = summary.refused.values().sum::<u64>();
        assert_eq!((summary.rows, count), (1, 1), "{summary}");

        let text = String::from_utf8(out).unwrap();
        let fields: Vec<&str> = text.lines().nth(1).unwrap().split(',').collect();
        assert_eq!(fields.len(), 3 + 5 + 25 + 1 + 6 + 2);
        assert_eq!(fields[0], "0.5");
        assert!(!["", "converged", "precision-limit"].contains(&fields[1]));
        let figures = &fields[2..34];
        assert!(figures.iter().all(|field| field.is_empty()), "{text}");
        assert_eq!(
            fields[34..],
            ["1000", "200", "0", "0", "3", "20000", "", ""]
        );

        let text = String::from_utf8(balls).unwrap();
        assert_eq!(text.lines().count(), 1 + file.balls);
        for line in text.lines().skip(1) {
            assert!(line.ends_with(",,,,,,,"), "{line}");
        }
    }
}

#[test]
fn every_ball_count_has_a_solver() {
    let mut design = DesignFile::read(shipped("b7005c")).unwrap().design;
    design.ball_diameter = 1.5e-3;
    for balls in BALL_COUNTS {
        for precision in [Precision::F32, Precision::F64] {
            let bearing = dispatch::bearing(&design, balls, precision).unwrap();
            for attitude in [Attitude::Raceless, Attitude::Outer, Attitude::Inner] {
                let solver = bearing.solver(attitude);
                assert_eq!(solver.ball_count(), balls);
                assert_eq!(solver.precision(), precision);
            }
        }
    }
    for balls in [0, 2, 65, usize::MAX] {
        assert!(dispatch::bearing(&design, balls, Precision::F64).is_err());
    }
}

/// A design file without the materials.
const DESIGN: &str = "\
    name = \"test\"\n\
    balls = 16\n\
    ball_diameter_mm = 6.35\n\
    pitch_diameter_mm = 36\n\
    inner_groove_factor = 0.515\n\
    outer_groove_factor = 0.525\n\
    contact_angle_deg = 15\n";

#[test]
fn a_design_file_means_si_units_and_steel_unless_it_says_otherwise() {
    let file = DesignFile::parse("x", DESIGN).unwrap();
    assert_eq!(file.name, "test");
    assert_eq!(file.balls, 16);
    let design = file.design;
    assert_eq!(design.ball_diameter, 0.00635);
    assert_eq!(design.pitch_diameter, 0.036);
    assert_eq!(design.inner_groove_factor, 0.515);
    assert_eq!(design.outer_groove_factor, 0.525);
    assert_eq!(design.free_contact, FreeContact::Angle(15_f64.to_radians()));
    assert_eq!(design.inner_shoulder_angle, Design::HIGHEST_SHOULDER);
    assert_eq!(design.outer_shoulder_angle, Design::HIGHEST_SHOULDER);
    assert_eq!(design.first_ball, 0.0);
    assert_eq!(design.ring, Material::STEEL);
    assert_eq!(design.ball, Material::STEEL);

    let clearance = DESIGN.replace("contact_angle_deg = 15", "diametral_clearance_um = 10");
    let more = "first_ball_deg = 11.25\ninner_shoulder_deg = 50\nouter_shoulder_deg = 45\n\
                [ball]\nyoungs_modulus_gpa = 310\ndensity_kg_m3 = 3200\n\
                [ring]\npoissons_ratio = 0.29\n";
    let design = DesignFile::parse("x", &(clearance + more)).unwrap().design;
    assert_eq!(design.free_contact, FreeContact::DiametralClearance(10e-6));
    let pressed = DESIGN.replace("contact_angle_deg = 15", "diametral_clearance_um = -5");
    let pressed = DesignFile::parse("x", &pressed).unwrap().design;
    assert_eq!(pressed.free_contact, FreeContact::DiametralClearance(-5e-6));
    assert_eq!(design.first_ball, 11.25_f64.to_radians());
    assert_eq!(design.inner_shoulder_angle, 50_f64.to_radians());
    assert_eq!(design.outer_shoulder_angle, 45_f64.to_radians());
    assert_eq!(
        design.ball,
        Material {
            youngs_modulus: 310e9,
            poissons_ratio: 0.3,
            density: 3200.0
        }
    );
    assert_eq!(
        design.ring,
        Material {
            poissons_ratio: 0.29,
            ..Material::STEEL
        }
    );
}

#[test]
fn a_malformed_design_file_is_refused_with_line_and_column() {
    let with = |from: &str, to: &str| DESIGN.replace(from, to);
    for (text, expected) in [
        (with("balls = 16", "balls ="), "line 2, column 8: "),
        (
            with("contact_angle_deg", "contact_angle"),
            "line 7, column 1: unknown field `contact_angle`, expected one of `name`, ",
        ),
        (
            with("6.35", "\"6.35\""),
            "line 3, column 20: invalid type: string \"6.35\", expected a number",
        ),
        (
            with("balls = 16", "balls = 16.5"),
            "line 2, column 9: `balls` is 16.5, but must be a whole number from 3 to 64",
        ),
        (
            with("balls = 16", "balls = 2"),
            "line 2, column 9: `balls` is 2, but must be a whole number from 3 to 64",
        ),
        (
            with("balls = 16", "balls = -16"),
            "line 2, column 9: `balls` is -16, but must be a whole number from 3 to 64",
        ),
        (
            with("balls = 16\n", ""),
            "line 1, column 1: the key `balls` is missing; add a line such as `balls = 16`",
        ),
        (
            with("contact_angle_deg = 15\n", ""),
            "line 1, column 1: the contact angle is missing; add a line such as",
        ),
        (
            format!("{DESIGN}diametral_clearance_um = 10\n"),
            "line 8, column 26: `contact_angle_deg` and `diametral_clearance_um` say the same \
             thing, and line 7 already says it",
        ),
        (
            format!("{DESIGN}balls = 9\n"),
            "line 8, column 1: duplicate key",
        ),
        (
            format!("{DESIGN}[ring]\ndensity_kg_m3 = 7850\n"),
            "line 9, column 1: unknown field `density_kg_m3`",
        ),
        (
            format!("{DESIGN}[rings]\n"),
            "line 8, column 2: unknown field `rings`",
        ),
    ] {
        let error = DesignFile::parse("b.toml", &text).unwrap_err().to_string();
        let expected = format!("b.toml: {expected}");
        assert!(error.starts_with(&expected), "{error}\nnot\n{expected}");
    }
}

#[test]
fn a_bearing_that_cannot_be_built_is_refused_with_the_key_at_fault() {
    let explained = |text: &str| -> DesignFileError {
        let file = DesignFile::parse("b.toml", text).unwrap();
        let error = dispatch::bearing(&file.design, file.balls, Precision::F64)
            .err()
            .unwrap();
        file.explain(&error)
    };
    for (text, expected) in [
        (
            DESIGN.replace("6.35", "60"),
            "b.toml: line 4, column 21: `pitch_diameter_mm`: ",
        ),
        (
            DESIGN.replace("6.35", "8"),
            "b.toml: line 3, column 20: `ball_diameter_mm`: ",
        ),
        (
            DESIGN.replace("0.515", "0.5"),
            "b.toml: line 5, column 23: `inner_groove_factor`: ",
        ),
        (
            DESIGN.replace("= 15", "= nan"),
            "b.toml: line 7, column 21: `contact_angle_deg`: ",
        ),
        (
            format!("{DESIGN}[ball]\ndensity_kg_m3 = 0\n"),
            "b.toml: line 9, column 17: `ball.density_kg_m3`: ",
        ),
    ] {
        let error = explained(&text).to_string();
        assert!(error.starts_with(expected), "{error}\nnot\n{expected}");
    }
}

#[test]
fn the_shipped_design_files_can_be_built() {
    for (name, balls) in [
        ("b218", 16),
        ("b7005c", 16),
        ("b7005c-hybrid", 16),
        ("skf6205", 9),
    ] {
        let file = DesignFile::read(shipped(name)).unwrap();
        assert_eq!(file.balls, balls);
        for precision in [Precision::F32, Precision::F64] {
            assert!(dispatch::bearing(&file.design, file.balls, precision).is_ok());
        }
    }
}

#[test]
fn the_recording_of_a_spindle_that_warms_up_is_what_its_program_writes() {
    let kept = std::fs::read_to_string(warm_up::RECORD)
        .unwrap()
        .replace('\r', "");
    let mut made = Vec::new();
    write_csv(&warm_up::warm_up(), &mut made).unwrap();
    assert!(
        kept.as_bytes() == made,
        "`cargo run -p tools --bin make_record -- --warm-up` writes it again"
    );
}

#[test]
fn the_recording_is_what_its_program_writes() {
    for (place, path) in [(Place::Bearing, RECORD), (Place::Nose, NOSE_RECORD)] {
        let mut written = Vec::new();
        write_csv(&recorded(place), &mut written).unwrap();
        // Line ends aside, which a checkout may change.
        let kept = std::fs::read_to_string(path).unwrap().replace('\r', "");
        assert!(
            kept.as_bytes() == written,
            "{place:?}: run `cargo run -p tools --bin make_record`, once more with `-- --nose`"
        );
        assert!(written.len() < 1_200_000);
        assert!(kept.starts_with(&COLUMNS.join(",")));
    }
}

#[test]
fn the_recording_holds_a_whole_cycle_within_what_a_spindle_carries() {
    let rows: Vec<_> = loads::read(RECORD).unwrap().map(Result::unwrap).collect();
    assert_eq!(rows.last().unwrap().time_s - rows[0].time_s, 20.0);
    for pair in rows.windows(2) {
        let step = pair[1].time_s - pair[0].time_s;
        assert!((step - 1e-3).abs() < 1e-9);
    }
    let mut most = 0.0_f64;
    for row in &rows {
        let [fx, fy, fz, my, mz] = row.load;
        // Preload never vanishes.
        assert!((300.0..2600.0).contains(&fx), "{row:?}");
        let (force, moment) = (fy.hypot(fz), my.hypot(mz));
        if !(CRASH[0]..=CRASH[1]).contains(&row.time_s) {
            assert!(force < 1520.0 && moment < 5.0, "{row:?}");
        }
        most = most.max(force);
        assert!((0.0..20_100.0).contains(&row.speed_rpm), "{row:?}");
    }
    assert!((4000.0..5000.0).contains(&most), "{most}");
    let stops = rows
        .windows(2)
        .filter(|pair| pair[0].speed_rpm > 0.0 && pair[1].speed_rpm == 0.0)
        .count();
    assert_eq!(stops, 2, "a tool change and an end");
}

#[test]
fn the_recording_is_solved_to_the_last_row() {
    let file = DesignFile::read(shipped("b7005c")).unwrap();
    for precision in [Precision::F32, Precision::F64] {
        let bearing = dispatch::bearing(&file.design, file.balls, precision).unwrap();
        let mut solver = bearing.solver(Attitude::Raceless);
        let mut out = Vec::new();
        let rows = loads::read(RECORD).unwrap();
        let mut solver = OneBearing {
            solver: solver.as_mut(),
            rating: None,
        };
        let summary = replay(&mut solver, rows, false, &mut Outputs::of(&mut out)).unwrap();
        assert!(summary.refused.is_empty(), "{summary}");
        let text = String::from_utf8(out).unwrap();
        assert_eq!(text.lines().count(), 1 + 20_001);
        for line in text.lines().skip(1) {
            let status = line.split(',').nth(1).unwrap();
            assert!(["converged", "precision-limit"].contains(&status), "{line}");
        }
    }
}

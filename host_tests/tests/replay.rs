//! The path from a recording to the results: formats, messages, exit status, and that nothing is
//! lost between the solver and the file.

use host_tests::design_file::{DesignFile, DesignFileError, SHIPPED};
use host_tests::dispatch::{self, Answer, AnySolver, Attitude, BALL_COUNTS, Figures, Precision};
use host_tests::loads::{self, COLUMNS, LoadRow, Loads, LoadsError};
use host_tests::milling_cycle::{RECORD, milling_cycle, write_csv};
use host_tests::replay::{replay, run};
use spindle_bearing::{BallState, Design, FreeContact, LimitSet, Limits, Material};
use std::ffi::OsString;
use std::io::{self, Cursor, Write};
use std::path::PathBuf;

const HEADER: &str = "time_s,fx_n,fy_n,fz_n,my_nm,mz_nm,speed_rpm\n";

const RESULT_HEADER: &str = "time_s,status,sweeps,dx_m,dy_m,dz_m,ty_rad,tz_rad,\
    k_x_x,k_x_y,k_x_z,k_x_ty,k_x_tz,k_y_x,k_y_y,k_y_z,k_y_ty,k_y_tz,k_z_x,k_z_y,k_z_z,k_z_ty,k_z_tz,\
    k_ty_x,k_ty_y,k_ty_z,k_ty_ty,k_ty_tz,k_tz_x,k_tz_y,k_tz_z,k_tz_ty,k_tz_tz,limits";

/// Loads that are easy, uneven, at rest and at speed.
const ROWS: &str = "\
    0,400,0,0,0,0,0\n\
    0.1,420.5,35,-12,0.2,0.35,1000\n\
    0.2,500,200,10,0,1.5,20000\n\
    0.30000000000000004,1000,200,0,0,3,12000\n";

fn shipped(name: &str) -> String {
    format!("{SHIPPED}/{name}.toml")
}

/// A file of this test run alone, in the folder that cargo keeps for tests.
fn scratch(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("replay-{}-{name}", std::process::id()))
}

/// Exit status, standard output and standard error of `cargo replay` with these arguments.
fn replayed(args: &[&str], stdin: &str) -> (u8, String, String) {
    let (mut stdout, mut stderr) = (Vec::new(), Vec::new());
    let args = ["replay"].iter().chain(args).map(OsString::from);
    let stdin = Cursor::new(stdin.as_bytes().to_vec());
    let status = run(args, stdin, &mut stdout, &mut stderr);
    let text = |bytes| String::from_utf8(bytes).unwrap();
    (status, text(stdout), text(stderr))
}

fn fields(line: &str) -> Vec<&str> {
    line.split(',').collect()
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
fn results_hold_the_bits_that_the_solver_gave() {
    let file = DesignFile::read(shipped("b7005c")).unwrap();
    for (name, precision) in [("f32", Precision::F32), ("f64", Precision::F64)] {
        for (rule, attitude) in [
            ("raceless", Attitude::Raceless),
            ("outer", Attitude::Outer),
            ("inner", Attitude::Inner),
        ] {
            let (status, out, err) = replayed(
                &[
                    &shipped("b7005c"),
                    "-",
                    "--precision",
                    name,
                    "--attitude",
                    rule,
                ],
                &format!("{HEADER}{ROWS}"),
            );
            assert_eq!((status, err.as_str()), (0, ""));
            let mut lines = out.lines();
            assert_eq!(lines.next(), Some(RESULT_HEADER));

            let bearing = dispatch::bearing(&file.design, file.balls, precision).unwrap();
            let mut solver = bearing.solver(attitude);
            for row in parsed(&format!("{HEADER}{ROWS}")).unwrap() {
                let line = fields(lines.next().unwrap());
                let answer = solver.solve(row.load, row.omega());
                let figures = answer.figures.unwrap();
                assert_eq!(line[0].parse::<f64>().unwrap(), row.time_s);
                assert_eq!(line[1], answer.status);
                assert_eq!(line[2].parse::<u16>().unwrap(), figures.sweeps);
                let expected = figures
                    .displacement
                    .iter()
                    .chain(figures.stiffness.iter().flatten());
                assert_eq!(line.len(), 3 + 5 + 25 + 1);
                assert_eq!(line[33], figures.limits.to_string());
                for (text, &expected) in line[3..].iter().zip(expected) {
                    let read_back = match precision {
                        Precision::F32 => f64::from(text.parse::<f32>().unwrap()),
                        Precision::F64 => text.parse().unwrap(),
                    };
                    assert_eq!(read_back.to_bits(), expected.to_bits(), "{text}");
                }
            }
            assert_eq!(lines.next(), None);
        }
    }
}

#[test]
fn a_limit_that_is_set_marks_the_rows_that_pass_it() {
    let input = format!("{HEADER}0,100,0,0,0,0,0\n1,2000,0,0,0,0,0\n");
    let replay = |pressure| {
        let bearing = shipped("b7005c");
        let args = [&bearing, "-", "--peak-pressure", pressure];
        let (status, out, _) = replayed(&args, &input);
        assert_eq!(status, 0);
        let last = |line: &str| fields(line)[33].to_owned();
        out.lines().skip(1).map(last).collect::<Vec<_>>()
    };
    assert_eq!(replay("1200"), ["", "peak-pressure"]);
    assert_eq!(replay("4200"), ["", ""]);
}

#[test]
fn the_three_attitude_rules_differ_at_speed_only() {
    let result = |rule, speed| {
        let input = format!("{HEADER}0,500,100,0,0,1,{speed}\n");
        replayed(&[&shipped("b7005c"), "-", "--attitude", rule], &input).1
    };
    assert_ne!(result("raceless", 20_000), result("outer", 20_000));
    assert_ne!(result("raceless", 20_000), result("inner", 20_000));
    assert_eq!(result("raceless", 0), result("outer", 0));
    assert_eq!(result("raceless", 0), result("inner", 0));
}

#[test]
fn columns_may_stand_in_any_order() {
    let plain = parsed(&format!("{HEADER}1,2,3,4,5,6,7\n")).unwrap();
    assert_eq!(
        plain,
        [LoadRow {
            time_s: 1.0,
            load: [2.0, 3.0, 4.0, 5.0, 6.0],
            speed_rpm: 7.0
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
    let row = "1,2,3,4,5,6,7";
    let header = HEADER.trim_end();
    for (text, start) in [
        (String::new(), "line 1, column 1: the file is empty"),
        ("\n\n".to_owned(), "line 2, column 1: the file is empty"),
        (
            "time_s,fx_n,fy_n,fz_n,my_nm,mz_nm,rpm\n".to_owned(),
            "line 1, column 7: \"rpm\" is none of the columns",
        ),
        (
            format!("{header},time_s\n"),
            "line 1, column 8 (time_s): the header has this column already as column 1",
        ),
        (
            "time_s,fx_n,fz_n,my_nm,mz_nm,speed_rpm\n".to_owned(),
            "line 1, column 7 (fy_n): the header lacks this column",
        ),
        (
            row.to_owned(),
            "line 1, column 1: \"1\" is none of the columns",
        ),
        (
            format!("{header}\n{row}\n1,2,three,4,5,6,7\n"),
            "line 3, column 3 (fy_n): \"three\" is not a number",
        ),
        (
            format!("{header}\n\n\n{row}\n\n1,2,3,4,5,6,7 rpm\n"),
            "line 6, column 7 (speed_rpm): \"7 rpm\" is not a number",
        ),
        (
            format!("{header}\r\n{row}\r\n1,2,3,4,,6,7\r\n"),
            "line 3, column 5 (my_nm): the field is empty",
        ),
        (
            format!("{header}\n1,2,3,4,5\n"),
            "line 2, column 6 (mz_nm): the line ends after 5 of 7 numbers",
        ),
        (
            format!("{header}\n{row},8\n"),
            "line 2, column 8: the line has 8 fields where the header has 7",
        ),
        (
            format!("{header}\n0,5,2,3,4,5,6,7\n"),
            "line 2, column 8: the line has 8 fields where the header has 7",
        ),
        (
            format!("{header}\n1,2,3,\"4,5,6,7\n{row}\n"),
            "line 2, column 4: a quotation mark is opened but not closed",
        ),
        (
            format!("{header}\r{row}\r{row}\r"),
            "line 1, column 7: a carriage return in the middle of the line",
        ),
        (
            format!("{header}\n{}\n", "1".repeat(100_000)),
            "line 2, column 1: the line is longer than",
        ),
    ] {
        let error = parsed(&text).unwrap_err().to_string();
        let expected = format!("loads.csv: {start}");
        assert!(error.starts_with(&expected), "{error}\nnot\n{expected}");

        let (status, _, err) = replayed(&[&shipped("b7005c"), "-"], &text);
        assert_eq!(status, 2);
        assert!(err.contains(start), "{err}");
        assert_eq!(err.lines().count(), 1, "{err}");
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

#[test]
fn rows_before_a_fault_are_out_and_nothing_after_it() {
    let input = format!("{HEADER}{ROWS}oops,1,2,3,4,5,6\n{ROWS}");
    let (status, out, _) = replayed(&[&shipped("b7005c"), "-"], &input);
    assert_eq!(status, 2);
    assert_eq!(out.lines().count(), 1 + 4);
}

#[test]
fn a_row_without_an_answer_keeps_its_place() {
    let balls = scratch("refused.csv");
    let rows = "\
        0,400,0,0,0,0,0\n\
        1,nan,0,0,0,0,0\n\
        2,400,0,-inf,0,0,0\n\
        3,400,0,0,0,0,NaN\n\
        4,400,0,0,0,0,0\n";
    for precision in ["f32", "f64"] {
        let (status, out, err) = replayed(
            &[
                &shipped("b7005c"),
                "-",
                "--precision",
                precision,
                "--balls",
                balls.to_str().unwrap(),
            ],
            &format!("{HEADER}{rows}"),
        );
        assert_eq!(status, 0);
        let lines: Vec<_> = out.lines().skip(1).map(fields).collect();
        assert_eq!(lines.len(), 5);
        for (i, line) in lines.iter().enumerate() {
            assert_eq!(line.len(), 34);
            assert_eq!(line[0], i.to_string());
            if [1, 2, 3].contains(&i) {
                assert_eq!(line[1], "not-finite");
                assert!(line[2..].iter().all(|field| field.is_empty()));
            } else {
                assert_eq!(line[1], "converged");
                assert!(line[2..33].iter().all(|field| field.parse::<f64>().is_ok()));
            }
        }
        // A refusal leaves the warm start alone: same load as before, same place.
        let place = |line: &[&str]| line[3].parse::<f64>().unwrap();
        assert!((place(&lines[4]) / place(&lines[0]) - 1.0).abs() < 1e-5);
        assert_eq!(err.lines().count(), 1, "{err}");
        assert!(
            err.starts_with("replay: 3 of 5 rows have no answer: 3 not-finite (the first at 1 s: "),
            "{err}"
        );

        let text = std::fs::read_to_string(&balls).unwrap();
        let lines: Vec<_> = text.lines().skip(1).map(fields).collect();
        assert_eq!(lines.len(), 5 * 16);
        for (i, line) in lines.iter().enumerate() {
            assert_eq!(line.len(), 9);
            assert_eq!(line[0], (i / 16).to_string());
            assert_eq!(line[1], (i % 16).to_string());
            let refused = [1, 2, 3].contains(&(i / 16));
            assert!(line[2..].iter().all(|field| field.is_empty() == refused));
        }
    }
    std::fs::remove_file(balls).unwrap();
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

    fn solve_with_balls(
        &mut self,
        _: [f64; 5],
        _: f64,
        _: Option<&mut Vec<BallState<f64>>>,
    ) -> Answer {
        self.0.clone()
    }

    fn forget(&mut self) {}

    fn set_limits(&mut self, _: &Limits<f64>) {}

    fn set_settings(&mut self, _: f64, _: u16) {}
}

#[test]
fn a_solve_that_ran_out_of_sweeps_still_has_figures() {
    let mut solver = Parrot(Answer {
        status: "sweep-limit",
        figures: Ok(Figures {
            sweeps: 40,
            repeats: 0,
            displacement: [f64::from(1e-7_f32), 0.0, -2.5, 0.0, f64::from(-3e-9_f32)],
            stiffness: [[1e8, 0.0, 0.0, 0.0, f64::from(0.3_f32)]; 5],
            limits: LimitSet::default(),
            error: None,
        }),
    });
    let row = LoadRow {
        time_s: 0.1,
        load: [0.0; 5],
        speed_rpm: 0.0,
    };
    let mut out = Vec::new();
    let summary = replay(&mut solver, [Ok(row)].into_iter(), false, &mut out, None).unwrap();
    assert_eq!(summary.rows, 1);
    assert!(summary.refused.is_empty());
    let out = String::from_utf8(out).unwrap();
    assert_eq!(
        out.lines().nth(1).unwrap(),
        format!(
            "0.1,sweep-limit,40,1e-7,0,-2.5,0,-3e-9{},",
            ",100000000,0,0,0,0.3".repeat(5)
        )
    );
}

#[test]
fn cold_rows_are_those_of_fresh_solvers() {
    let bearing = shipped("b218");
    for precision in ["f32", "f64"] {
        let args = [&bearing, "-", "--precision", precision];
        let cold = [&args[..], &["--cold"]].concat();
        let (_, out, _) = replayed(&cold, &format!("{HEADER}{ROWS}"));
        for (line, row) in out.lines().skip(1).zip(ROWS.lines()) {
            let (_, fresh, _) = replayed(&args, &format!("{HEADER}{row}\n"));
            assert_eq!(fresh.lines().nth(1), Some(line));
        }
    }
}

#[test]
fn warm_rows_take_fewer_sweeps_than_cold_ones() {
    let sweeps = |extra: &[&str]| -> u32 {
        let bearing = shipped("b7005c");
        let args = [&[bearing.as_str(), RECORD], extra].concat();
        let (status, out, err) = replayed(&args, "");
        assert_eq!((status, err.as_str()), (0, ""));
        out.lines()
            .skip(1)
            .map(|line| fields(line)[2].parse::<u32>().unwrap())
            .sum()
    };
    assert!(sweeps(&[]) < sweeps(&["--cold"]));
}

#[test]
fn standard_input_gives_what_the_file_gives() {
    let path = scratch("loads.csv");
    let text = format!("{HEADER}{ROWS}");
    std::fs::write(&path, &text).unwrap();
    let piped = replayed(&[&shipped("skf6205"), "-"], &text);
    let named = replayed(&[&shipped("skf6205"), path.to_str().unwrap()], "");
    std::fs::remove_file(path).unwrap();
    assert_eq!(piped.0, 0);
    assert_eq!(piped, named);
}

/// Forces of the balls on the inner ring, without friction: `(Fx, Fy, Fz, My, Mz)`.
fn ring_load(file: &DesignFile, balls: &[Vec<f64>]) -> [f64; 5] {
    let design = &file.design;
    let li = (design.inner_groove_factor - 0.5) * design.ball_diameter;
    let l0 = (design.inner_groove_factor + design.outer_groove_factor - 1.0) * design.ball_diameter;
    let alpha0 = match design.free_contact {
        FreeContact::Angle(angle) => angle,
        FreeContact::DiametralClearance(clearance) => (1.0 - clearance / (2.0 * l0)).acos(),
    };
    let rp = 0.5 * design.pitch_diameter + li * alpha0.cos();
    let zp = li * alpha0.sin();
    let mut sum = [0.0; 5];
    for ball in balls {
        let (phi, alpha_i, q_i) = (ball[2], ball[3], ball[5]);
        let (fa, fr) = (q_i * alpha_i.sin(), q_i * alpha_i.cos());
        let moment = rp * fa - zp * fr;
        sum[0] += fa;
        sum[1] += fr * phi.cos();
        sum[2] += fr * phi.sin();
        sum[3] += moment * phi.sin();
        sum[4] -= moment * phi.cos();
    }
    sum
}

/// At rest there is no friction, and under outer race control the inner contacts carry none, so that
/// the contact forces alone must add up to the load.
#[test]
fn forces_of_the_balls_balance_the_load() {
    let path = scratch("balance.csv");
    let rows = "0,400,0,0,0,0,0\n1,500,60,-40,0.4,1.1,0\n2,1000,200,0,0,3,0\n";
    for (name, rows, attitude) in [
        ("b7005c", rows.to_owned(), "raceless"),
        ("b7005c-hybrid", rows.to_owned(), "inner"),
        ("b218", rows.to_owned(), "outer"),
        ("b7005c", rows.replace(",0\n", ",18000\n"), "outer"),
        ("skf6205", rows.replace(",0\n", ",9000\n"), "outer"),
    ] {
        let (status, _, err) = replayed(
            &[
                &shipped(name),
                "-",
                "--attitude",
                attitude,
                "--balls",
                path.to_str().unwrap(),
            ],
            &format!("{HEADER}{rows}"),
        );
        assert_eq!((status, err.as_str()), (0, ""));
        let file = DesignFile::read(shipped(name)).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        let mut lines = text.lines();
        assert_eq!(
            lines.next(),
            Some("time_s,ball,azimuth_rad,alpha_i_rad,alpha_o_rad,q_i_n,q_o_n,fc_n,mg_nm")
        );
        let balls: Vec<Vec<f64>> = lines
            .map(|line| fields(line).iter().map(|f| f.parse().unwrap()).collect())
            .collect();
        let loads = parsed(&format!("{HEADER}{rows}")).unwrap();
        assert_eq!(balls.len(), loads.len() * file.balls);
        for (balls, row) in balls.chunks(file.balls).zip(&loads) {
            let sum = ring_load(&file, balls);
            let (force, moment) = (row.load[0].abs(), row.load[0].abs() * 0.02);
            for (i, (sum, load)) in sum.iter().zip(row.load).enumerate() {
                let size = if i < 3 { force } else { moment };
                assert!(
                    (sum - load).abs() < 1e-9 * size,
                    "{name} at {}, component {i}: {sum} for {load}",
                    row.time_s
                );
            }
        }
    }
    std::fs::remove_file(path).unwrap();
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

/// Hands out a little, then behaves as a pipe whose reader has gone.
struct Head(usize);

impl Write for Head {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.0 == 0 {
            return Err(io::ErrorKind::BrokenPipe.into());
        }
        let taken = bytes.len().min(self.0);
        self.0 -= taken;
        Ok(taken)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

#[test]
fn a_reader_that_leaves_ends_the_replay_quietly() {
    for room in [0, 100, 100_000] {
        let mut stderr = Vec::new();
        let args = ["replay", &shipped("b7005c"), RECORD].map(OsString::from);
        let status = run(args, io::empty(), Head(room), &mut stderr);
        assert_eq!((status, stderr.as_slice()), (0, &b""[..]));
    }
}

#[test]
fn ball_states_never_overwrite_the_input() {
    let path = scratch("precious.csv");
    let text = format!("{HEADER}{ROWS}");
    std::fs::write(&path, &text).unwrap();
    let name = path.to_str().unwrap();
    let (status, out, err) = replayed(&[&shipped("b7005c"), name, "--balls", name], "");
    assert_eq!((status, out.as_str()), (2, ""));
    assert!(err.contains("would overwrite its own input"), "{err}");
    assert_eq!(std::fs::read_to_string(&path).unwrap(), text);
    std::fs::remove_file(path).unwrap();

    let (status, _, err) = replayed(&[&shipped("b7005c"), "-", "--balls", "-"], &text);
    assert_eq!(status, 2);
    assert!(err.contains("--balls needs a file"), "{err}");
}

#[test]
fn help_goes_to_standard_output_and_complaints_about_arguments_do_not() {
    let (status, out, err) = replayed(&["--help"], "");
    assert_eq!((status, err.as_str()), (0, ""));
    for word in [
        "cargo replay",
        "BEARING.toml",
        "--attitude",
        HEADER.trim_end(),
        "k_y_tz",
    ] {
        assert!(out.contains(word), "{word} is missing in\n{out}");
    }
    for args in [
        &["x.toml"][..],
        &["a", "b", "--precision", "f16"],
        &["a", "b", "c"],
    ] {
        let (status, out, err) = replayed(args, "");
        assert_eq!((status, out.as_str()), (2, ""));
        assert!(err.starts_with("error: "), "{err}");
    }
}

#[test]
fn files_that_are_not_there_are_named() {
    let (status, _, err) = replayed(&["nowhere.toml", "-"], "");
    assert_eq!(status, 2);
    assert!(
        err.starts_with("replay: nowhere.toml: cannot be read: "),
        "{err}"
    );
    let (status, _, err) = replayed(&[&shipped("b218"), "nowhere.csv"], "");
    assert_eq!(status, 2);
    assert!(
        err.starts_with("replay: nowhere.csv: cannot be read: "),
        "{err}"
    );
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
fn the_recording_is_what_its_program_writes() {
    let mut written = Vec::new();
    write_csv(&milling_cycle(), &mut written).unwrap();
    // Line ends aside, which a checkout may change.
    let kept = std::fs::read_to_string(RECORD).unwrap().replace('\r', "");
    assert!(
        kept.as_bytes() == written,
        "run `cargo run --profile host -p host_tests --bin make_record`"
    );
    assert!(written.len() < 400_000);
    assert!(kept.starts_with(&COLUMNS.join(",")));
}

#[test]
fn the_recording_holds_a_whole_cycle_within_what_a_spindle_carries() {
    let rows: Vec<_> = loads::read(RECORD).unwrap().map(Result::unwrap).collect();
    assert!(rows.last().unwrap().time_s - rows[0].time_s >= 60.0);
    for pair in rows.windows(2) {
        let step = pair[1].time_s - pair[0].time_s;
        assert!((step - 0.01).abs() < 1e-9);
    }
    for row in &rows {
        let [fx, fy, fz, my, mz] = row.load;
        // Preload never vanishes.
        assert!((200.0..1000.0).contains(&fx), "{row:?}");
        assert!(fy.hypot(fz) < 400.0 && my.hypot(mz) < 4.0, "{row:?}");
        assert!((0.0..20_100.0).contains(&row.speed_rpm), "{row:?}");
    }
    let stops = rows
        .windows(2)
        .filter(|pair| pair[0].speed_rpm > 0.0 && pair[1].speed_rpm == 0.0)
        .count();
    assert!(stops >= 2, "a tool change and an end");
}

#[test]
fn the_recording_is_solved_to_the_last_row() {
    for precision in ["f32", "f64"] {
        let (status, out, err) =
            replayed(&[&shipped("b7005c"), RECORD, "--precision", precision], "");
        assert_eq!((status, err.as_str()), (0, ""));
        for line in out.lines().skip(1) {
            let status = fields(line)[1];
            assert!(["converged", "precision-limit"].contains(&status), "{line}");
        }
    }
}

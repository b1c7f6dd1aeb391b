//! `cargo replay`: arguments, messages, exit status, and that the results are the solver's.

use crate::malformed::{self, HEADER};
use host_tests::design_file::{DesignFile, SHIPPED};
use host_tests::dispatch::{self, Attitude, Precision};
use host_tests::loads::{LoadRow, Loads, LoadsError};
use host_tests::milling_cycle::RECORD;
use spindle_bearing::{Bearing, FreeContact, Full, RacewayControlFree, Settings, Solver, Speed};
use std::ffi::OsString;
use std::io::{self, Cursor, Write};
use std::path::PathBuf;
use tools::replay::run;

const RESULT_HEADER: &str = "time_s,status,iterations,dx_m,dy_m,dz_m,ty_rad,tz_rad,\
    k_x_x,k_x_y,k_x_z,k_x_ty,k_x_tz,k_y_x,k_y_y,k_y_z,k_y_ty,k_y_tz,k_z_x,k_z_y,k_z_z,k_z_ty,k_z_tz,\
    k_ty_x,k_ty_y,k_ty_z,k_ty_ty,k_ty_tz,k_tz_x,k_tz_y,k_tz_z,k_tz_ty,k_tz_tz,limits,\
    fx_n,fy_n,fz_n,my_nm,mz_nm,speed_rpm,l10_mrev,l10_h";

pub const BALL_HEADER: &str = "time_s,ball,azimuth_rad,alpha_i_rad,alpha_o_rad,q_i_n,q_o_n,fc_n,mg_nm,\
    p_i_pa,p_o_pa,a_i_m,b_i_m,a_o_m,b_o_m,cage_rad_s,attitude_rad,spin_roll_i,spin_roll_o";

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
pub fn scratch(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("replay-{}-{name}", std::process::id()))
}

/// Exit status, standard output and standard error of `cargo replay` with these arguments.
pub fn replayed(args: &[&str], stdin: &str) -> (u8, String, String) {
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
                assert_eq!(line[2].parse::<u16>().unwrap(), figures.iterations);
                let expected = figures
                    .displacement
                    .iter()
                    .chain(figures.stiffness.iter().flatten());
                assert_eq!(line.len(), 3 + 5 + 25 + 1 + 6 + 2);
                let [revolutions, hours] = [40, 41].map(|i| line[i].parse::<f64>().unwrap());
                assert!(revolutions > 0.0);
                let speed = row.speed_rpm;
                assert!(
                    speed == 0.0 || (hours * 60.0 * speed / (1e6 * revolutions) - 1.0).abs() < 1e-6
                );
                assert!(speed != 0.0 || hours.is_infinite());
                assert_eq!(line[33], figures.limits.to_string());
                let [fx, fy, fz, my, mz] = row.load;
                for (text, copied) in line[34..].iter().zip([fx, fy, fz, my, mz, row.speed_rpm]) {
                    assert_eq!(text.parse::<f64>().unwrap(), copied);
                }
                for (text, &expected) in line[3..33].iter().zip(expected) {
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
fn a_malformed_recording_ends_the_replay_with_one_line_of_complaint() {
    for (text, start) in malformed::recordings() {
        let (status, _, err) = replayed(&[&shipped("b7005c"), "-"], &text);
        assert_eq!(status, 2);
        assert!(err.contains(start), "{err}");
        assert_eq!(err.lines().count(), 1, "{err}");
    }
}

#[test]
fn rows_before_a_fault_are_out_and_nothing_after_it() {
    let long = "1".repeat(100_000);
    let input = format!("{HEADER}{ROWS}{long}\n{ROWS}");
    let (status, out, _) = replayed(&[&shipped("b7005c"), "-"], &input);
    assert_eq!(status, 2);
    assert_eq!(out.lines().count(), 1 + 4);
}

#[test]
fn a_row_that_cannot_be_read_keeps_its_place_and_is_counted() {
    for (text, start) in malformed::rows() {
        let separator = if text.contains(';') { ";" } else { "," };
        let text = text + &["1", "400", "0", "0", "0", "0", "7\n"].join(separator);
        let (status, out, err) = replayed(&[&shipped("b7005c"), "-"], &text);
        assert_eq!((status, err.lines().count()), (0, 1), "{err}");
        let refused: Vec<_> = out
            .lines()
            .map(fields)
            .filter(|line| line[1] == "refused-input")
            .collect();
        assert_eq!(refused.len(), 1, "{out}");
        assert_eq!(refused[0].len(), RESULT_HEADER.split(',').count());
        assert!(out.lines().last().unwrap().starts_with("1,converged,"));
        assert!(
            err.contains("1 refused-input") && err.contains(&format!("standard input: {start}")),
            "{err}"
        );
    }
    let rows =
        "0,400,0,0,0,0,0\n1,,0,0,0,0,0\n2,nan,0,0,0,0,0\nthree,,0,0,0,0,0\n4,400,0,0,0,0,0\n";
    let (status, out, err) = replayed(&[&shipped("b7005c"), "-"], &format!("{HEADER}{rows}"));
    let starts: Vec<_> = out
        .lines()
        .skip(1)
        .map(|line| fields(line)[..2].join(","))
        .collect();
    assert_eq!(status, 0);
    assert_eq!(
        starts,
        [
            "0,converged",
            "1,refused-input",
            "2,not-finite",
            ",refused-input",
            "4,converged"
        ]
    );
    assert_eq!(
        err,
        "replay: 3 of 5 rows have no answer: 1 not-finite, 2 refused-input (the first at 2 s: axial load \
         Fx (N) is NaN; the first that cannot be read: standard input: line 3, column 2 (fx_n): the field \
         is empty; a number is needed)\n"
    );
}

/// A file of which no row can be read is at fault itself.
#[test]
fn decimal_commas_between_commas_are_not_guessed_at() {
    let rows = "0,0,400,5,0,0,0,0,0,0,0,0,0,0\n";
    let (status, out, err) = replayed(&[&shipped("b7005c"), "-"], &format!("{HEADER}{rows}{rows}"));
    assert_eq!((status, out.lines().count()), (2, 3));
    assert!(
        err.contains(
            "line 2, column 8: the line has 14 fields where the header has 7; decimals take a point"
        ),
        "{err}"
    );
    assert!(err.contains("separate fields by semicolons"), "{err}");
}

#[test]
fn columns_that_are_not_read_are_named_once() {
    let text = "time_s,fx_n,fy_n,fz_n,my_nm,mz_nm,speed_rpm,tool,t_oil_c\n0,400,0,0,0,0,0,T1,\n1,400,0,0,0,0,0,,\n";
    let (status, out, err) = replayed(&[&shipped("b7005c"), "-"], text);
    assert_eq!((status, out.lines().count()), (0, 3));
    assert_eq!(
        err,
        "replay: standard input: columns ignored: \"tool\", \"t_oil_c\"\n"
    );
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
            assert_eq!(line.len(), 42);
            assert_eq!(line[0], i.to_string());
            if [1, 2, 3].contains(&i) {
                assert_eq!(line[1], "not-finite");
                assert!(line[2..34].iter().all(|field| field.is_empty()));
                assert!(
                    line[34..40]
                        .iter()
                        .all(|field| field.parse::<f64>().is_ok())
                );
                assert_eq!(line[40..], ["", ""]);
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
            assert_eq!(line.len(), 19);
            assert_eq!(line[0], (i / 16).to_string());
            assert_eq!(line[1], (i % 16).to_string());
            let refused = [1, 2, 3].contains(&(i / 16));
            assert!(line[2..].iter().all(|field| field.is_empty() == refused));
        }
    }
    std::fs::remove_file(balls).unwrap();
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
fn warm_rows_take_fewer_iterations_than_cold_ones() {
    let iterations = |extra: &[&str]| -> u32 {
        let bearing = shipped("b7005c");
        let args = [&[bearing.as_str(), RECORD], extra].concat();
        let (status, out, err) = replayed(&args, "");
        assert_eq!((status, err.as_str()), (0, ""));
        out.lines()
            .skip(1)
            .map(|line| fields(line)[2].parse::<u32>().unwrap())
            .sum()
    };
    assert!(iterations(&[]) < iterations(&["--cold"]));
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
    let (cos, zp) = match design.free_contact {
        FreeContact::Angle(angle) => (angle.cos(), li * angle.sin()),
        FreeContact::DiametralClearance(clearance) => (1.0 - clearance / (2.0 * l0), 0.0),
    };
    let rp = 0.5 * design.pitch_diameter + li * cos;
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
        assert_eq!(lines.next(), Some(BALL_HEADER));
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

/// Motions, contacts and frequencies are those of the library, and hold together.
#[test]
fn balls_and_frequencies_are_written_as_the_solver_gave_them() {
    let [of_balls, frequencies] = ["details.csv", "frequencies.csv"].map(scratch);
    let args = [
        &shipped("b7005c"),
        "-",
        "--balls",
        of_balls.to_str().unwrap(),
        "--frequencies",
        frequencies.to_str().unwrap(),
    ];
    let (status, _, err) = replayed(&args, &format!("{HEADER}{ROWS}4,nan,0,0,0,0,0\n"));
    assert_eq!(status, 0, "{err}");
    let [of_balls, frequencies] = [of_balls, frequencies].map(|path| {
        let text = std::fs::read_to_string(&path).unwrap();
        std::fs::remove_file(path).unwrap();
        text
    });
    let (mut of_balls, mut frequencies) = (of_balls.lines().skip(1), frequencies.lines());
    assert_eq!(
        frequencies.next(),
        Some("time_s,cage_hz,outer_race_hz,inner_race_hz,ball_hz")
    );
    let file = DesignFile::read(shipped("b7005c")).unwrap();
    let bearing = Bearing::<f64, 16>::new(&file.design).unwrap();
    let mut solver = Solver::<f64, 16, Full<RacewayControlFree>>::of(&bearing);
    let numbers =
        |line: &str| -> Vec<f64> { fields(line).iter().map(|f| f.parse().unwrap()).collect() };
    for row in parsed(&format!("{HEADER}{ROWS}")).unwrap() {
        let speed = Speed::rad_per_s(row.omega());
        let solution = solver.solve(row.load, speed, &Settings::default()).unwrap();
        for motion in solution.motions() {
            let line = numbers(of_balls.next().unwrap());
            let (i, o) = (motion.inner, motion.outer);
            let expected = [
                i.peak_pressure,
                o.peak_pressure,
                i.semi_major,
                i.semi_minor,
                o.semi_major,
                o.semi_minor,
                motion.cage_speed,
                motion.attitude,
                i.spin_to_roll,
                o.spin_to_roll,
            ];
            assert_eq!(line[9..], expected);
            // Hertz: force = 2/3 pi a b p.
            let force = 2.0 / 3.0 * std::f64::consts::PI * line[9] * line[11] * line[12];
            assert!(
                (force - line[5]).abs() <= 1e-9 * line[5].max(1.0),
                "{line:?}"
            );
        }
        let found = solution.frequencies();
        assert_eq!(
            numbers(frequencies.next().unwrap()),
            [
                row.time_s,
                found.cage,
                found.outer_race,
                found.inner_race,
                found.ball
            ]
        );
    }
    assert_eq!(frequencies.next(), Some("4,,,,"));
    assert_eq!(of_balls.next(), Some("4,0,,,,,,,,,,,,,,,,,"));
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
        "DESIGN.toml",
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

#[test]
fn a_table_has_what_a_recording_of_its_loads_gives() {
    let args = [
        &shipped("b7005c"),
        "--table",
        "speed=0:20000:10000",
        "fx=500",
        "fy=0:200:100",
        "--cold",
    ];
    let (status, table, err) = replayed(&args, "");
    assert_eq!((status, &*err), (0, ""));
    let mut rows = String::new();
    for (i, (fy, speed)) in [0, 100, 200]
        .into_iter()
        .flat_map(|fy| [0, 10_000, 20_000].map(|speed| (fy, speed)))
        .enumerate()
    {
        rows += &format!("{i},500,{fy},0,0,0,{speed}\n");
    }
    let recording = format!("{HEADER}{rows}");
    assert_eq!(
        table,
        replayed(&[&shipped("b7005c"), "-", "--cold"], &recording).1
    );
}

#[test]
fn axes_that_make_no_table_are_refused() {
    let bearing = shipped("b7005c");
    for (args, wanted) in [
        (&["speed=0:1e9:1"][..], "more than 1000000 rows"),
        (&["rpm=5"], "\"rpm\" is none of the axes"),
        (
            &["t_inner=30"],
            "t_inner and t_outer are for spindles with [heat]",
        ),
        (&["loads.csv"], "an axis is NAME=FIRST:LAST:STEP"),
    ] {
        let (status, out, err) = replayed(&[&[&*bearing, "--table"], args].concat(), "");
        assert_eq!((status, &*out), (2, ""));
        assert!(
            err.starts_with("replay: --table") && err.contains(wanted),
            "{err}"
        );
    }
    let (status, _, err) = replayed(&[&bearing, "loads.csv", "--table", "fx=5"], "");
    assert_eq!(status, 2);
    assert!(err.contains("cannot be used with"), "{err}");
    let spindle = format!("{SHIPPED}/../spindles/milling_spindle.toml");
    let (status, out, err) = replayed(&[&spindle, "--table", "speed=3000", "t_inner=25:35:5"], "");
    assert_eq!((status, &*err), (0, ""));
    assert_eq!(out.lines().count(), 4);
}

#[test]
fn bearings_of_the_catalogue_are_replayed_by_name_and_listed() {
    let loads = format!("{HEADER}{ROWS}");
    let (status, named, told) = replayed(&["gmn:s 6005 c", "-"], &loads);
    assert_eq!((status, told.as_str()), (0, ""));
    assert_eq!(named.lines().count(), 5);
    let (status, _, told) = replayed(&["gmn:S6005X", "-"], &loads);
    assert!(status == 2 && told.contains("gmn:S6005C"), "{told}");
    let (status, list, _) = replayed(&["--list"], "");
    assert!(status == 0 && list.contains("gmn:S6014C"), "{list}");
}

//! `cargo replay`: arguments, messages, exit status, and that the results are the solver's.

use crate::malformed::{self, HEADER};
use host_tests::design_file::{DesignFile, SHIPPED};
use host_tests::dispatch::{Attitude, Precision};
use host_tests::loads::{LoadRow, Loads};
use host_tests::milling_cycle::RECORD;
use host_tests::spindles::{Balls, Plan, with_solver};
use spindle_bearing::{Bearing, Full, InnerRaceControl, Motion, OuterRaceControl};
use spindle_bearing::{RacewayControlFree, Settings, Solver, Speed};
use std::io::{Cursor, Read, Write};
use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::thread;

const REPLAY: &str = env!("CARGO_BIN_EXE_replay");

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

/// Exit status, standard output and standard error of a program with these arguments and this input.
pub fn ran(program: &str, args: &[&str], stdin: &[u8]) -> (i32, String, String) {
    let mut program = Command::new(program);
    let program = program.args(args).stdin(Stdio::piped());
    let program = program.stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut running = program.spawn().unwrap();
    let mut input = running.stdin.take().unwrap();
    let output = thread::scope(|scope| {
        // A program that is content with its arguments reads nothing.
        scope.spawn(move || input.write_all(stdin));
        running.wait_with_output().unwrap()
    });
    let text = |bytes| String::from_utf8(bytes).unwrap();
    let status = output.status.code().unwrap();
    (status, text(output.stdout), text(output.stderr))
}

/// [`ran`] with `cargo replay`.
pub fn replayed(args: &[&str], stdin: &str) -> (i32, String, String) {
    ran(REPLAY, args, stdin.as_bytes())
}

/// Standard output and error of a replay that succeeds with files of these options, and the files.
pub fn with_files<const N: usize>(
    args: &[&str],
    options: [&str; N],
    stdin: &str,
) -> (String, String, [String; N]) {
    let test = std::thread::current().name().unwrap().to_owned();
    let paths = options.map(|option| scratch(&format!("{test}{option}")));
    let mut args = args.to_vec();
    for (option, path) in options.iter().zip(&paths) {
        args.extend([option, path.to_str().unwrap()]);
    }
    let (status, out, err) = replayed(&args, stdin);
    assert_eq!(status, 0, "{err}");
    let files = paths.map(|path| {
        let text = std::fs::read_to_string(&path).unwrap();
        std::fs::remove_file(path).unwrap();
        text
    });
    (out, err, files)
}

/// The fields of the lines below a header, each with as many as the header.
pub fn table<'t>(text: &'t str, header: &str) -> Vec<Vec<&'t str>> {
    let mut lines = text.lines().map(|line| line.split(',').collect::<Vec<_>>());
    assert_eq!(lines.next().unwrap().join(","), header);
    let lines: Vec<_> = lines.collect();
    let count = header.split(',').count();
    assert!(lines.iter().all(|line| line.len() == count), "{text}");
    lines
}

/// Numbers as they were before they were written.
pub fn numbers(fields: &[&str], precision: Precision) -> Vec<f64> {
    let number = |text: &&str| match precision {
        Precision::F32 => f64::from(text.parse::<f32>().unwrap()),
        Precision::F64 => text.parse().unwrap(),
    };
    fields.iter().map(number).collect()
}

pub fn parsed(csv: &str) -> Vec<LoadRow> {
    let input = Cursor::new(csv.as_bytes().to_vec());
    let loads = Loads::from_reader("loads.csv", Box::new(input)).unwrap();
    loads.map(Result::unwrap).collect()
}

#[test]
fn results_hold_the_bits_that_the_solver_gave() {
    let design = shipped("b7005c");
    let file = DesignFile::read(&design).unwrap();
    let text = format!("{HEADER}{ROWS}");
    for (name, precision) in [("f32", Precision::F32), ("f64", Precision::F64)] {
        for (rule, attitude) in [
            ("raceless", Attitude::Raceless),
            ("outer", Attitude::Outer),
            ("inner", Attitude::Inner),
        ] {
            let args = [&design, "-", "--precision", name, "--attitude", rule];
            let (status, out, err) = replayed(&args, &text);
            assert_eq!((status, err.as_str()), (0, ""));
            let lines = table(&out, RESULT_HEADER);
            let rows = parsed(&text);
            assert_eq!(lines.len(), rows.len());

            let plan = Plan::alone(&file.design, file.balls);
            let answers = with_solver(&plan, Balls::Moving(attitude), precision, |solver| {
                let solve = |row: &LoadRow| solver.load(row.load, row.omega()).unwrap();
                rows.iter().map(solve).collect::<Vec<_>>()
            });
            for ((line, row), figures) in lines.into_iter().zip(rows).zip(answers.unwrap()) {
                assert_eq!(line[1], figures.status);
                assert_eq!(line[2], figures.iterations.to_string());
                let stiffness = figures.stiffness.as_flattened();
                let expected = [&figures.displacement, stiffness].concat();
                let bits = |numbers: Vec<f64>| numbers.into_iter().map(f64::to_bits).collect();
                let [found, expected]: [Vec<_>; 2] =
                    [numbers(&line[3..33], precision), expected].map(bits);
                assert_eq!(found, expected);
                assert_eq!(line[33], figures.rows[0].limits.to_string());
                let [fx, fy, fz, my, mz] = row.load;
                let copied = [row.time_s, fx, fy, fz, my, mz, row.speed_rpm];
                let copies = [&line[..1], &line[34..40]].concat();
                assert_eq!(numbers(&copies, Precision::F64), copied);
                let life = numbers(&line[40..], Precision::F64);
                let (revolutions, hours, speed) = (life[0], life[1], row.speed_rpm);
                assert!(revolutions > 0.0);
                if speed == 0.0 {
                    assert!(hours.is_infinite());
                } else {
                    assert!((hours * 60.0 * speed / (1e6 * revolutions) - 1.0).abs() < 1e-6);
                }
            }
        }
    }
}

#[test]
fn a_limit_that_is_set_marks_the_rows_that_pass_it() {
    let input = format!("{HEADER}0,100,0,0,0,0,0\n1,2000,0,0,0,0,0\n");
    for (pressure, marks) in [("1200", ["", "peak-pressure"]), ("4200", ["", ""])] {
        let args = [&shipped("b7005c"), "-", "--peak-pressure", pressure];
        let (status, out, _) = replayed(&args, &input);
        assert_eq!(status, 0);
        let lines = table(&out, RESULT_HEADER).into_iter();
        assert_eq!(lines.map(|line| line[33]).collect::<Vec<_>>(), marks);
    }
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
        let lines = table(&out, RESULT_HEADER);
        let refused = lines.iter().filter(|line| line[1] == "refused-input");
        assert_eq!(refused.count(), 1, "{out}");
        assert_eq!(lines.last().unwrap()[..2], ["1", "converged"]);
        assert!(err.contains("1 refused-input"), "{err}");
        assert!(err.contains(&format!("standard input: {start}")), "{err}");
    }
    let rows =
        "0,400,0,0,0,0,0\n1,,0,0,0,0,0\n2,nan,0,0,0,0,0\nthree,,0,0,0,0,0\n4,400,0,0,0,0,0\n";
    let (status, out, err) = replayed(&[&shipped("b7005c"), "-"], &format!("{HEADER}{rows}"));
    assert_eq!(status, 0);
    let starts = table(&out, RESULT_HEADER).into_iter();
    let starts: Vec<_> = starts.map(|line| line[..2].join(",")).collect();
    let refused = "1,refused-input 2,not-finite ,refused-input";
    let expected = format!("0,converged {refused} 4,converged");
    assert_eq!(starts.join(" "), expected);
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
    let rows = "0,400,0,0,0,0,0\n1,nan,0,0,0,0,0\n2,400,0,-inf,0,0,0\n3,400,0,0,0,0,NaN\n4,400,0,0,0,0,0\n";
    for precision in ["f32", "f64"] {
        let args = [&shipped("b7005c"), "-", "--precision", precision];
        let (status, out, _) = replayed(&args, &format!("{HEADER}{rows}"));
        assert_eq!(status, 0);
        let lines = table(&out, RESULT_HEADER);
        assert_eq!(lines.len(), 5);
        for (i, line) in lines.iter().enumerate() {
            let numeric = |fields: &[&str]| fields.iter().all(|text| text.parse::<f64>().is_ok());
            assert_eq!(line[0], i.to_string());
            assert!(numeric(&line[34..40]));
            if (1..4).contains(&i) {
                assert_eq!(line[1], "not-finite");
                assert!([&line[2..34], &line[40..]].concat().concat().is_empty());
            } else {
                assert_eq!(line[1], "converged");
                assert!(numeric(&line[2..33]));
            }
        }
        // A refusal leaves the warm start alone: the first load and the last are equal, and so are their places.
        let place = |line: &[&str]| line[3].parse::<f64>().unwrap();
        assert!((place(&lines[4]) / place(&lines[0]) - 1.0).abs() < 1e-5);
    }
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

/// States, motions, contacts and frequencies are those of the library, and hold together.
#[test]
fn balls_and_frequencies_are_written_as_the_solver_gave_them() {
    check_balls::<Full<RacewayControlFree>>("raceless");
    check_balls::<Full<OuterRaceControl>>("outer");
    check_balls::<Full<InnerRaceControl>>("inner");
}

fn check_balls<M: Motion>(rule: &str) {
    let args = [&shipped("b7005c"), "-", "--attitude", rule];
    let loads = format!("{HEADER}{ROWS}4,nan,0,0,0,0,0\n");
    let (.., [balls, frequencies]) = with_files(&args, ["--balls", "--frequencies"], &loads);
    let mut balls = table(&balls, BALL_HEADER).into_iter();
    let header = "time_s,cage_hz,outer_race_hz,inner_race_hz,ball_hz";
    let mut frequencies = table(&frequencies, header).into_iter();
    let file = DesignFile::read(shipped("b7005c")).unwrap();
    let bearing = Bearing::<f64, 16>::new(&file.design).unwrap();
    let mut solver = Solver::<f64, 16, M>::of(&bearing);
    for row in parsed(&format!("{HEADER}{ROWS}")) {
        let speed = Speed::rad_per_s(row.omega());
        let solution = solver.solve(row.load, speed, &Settings::default()).unwrap();
        for (j, (ball, motion)) in solution.balls().zip(solution.motions()).enumerate() {
            let line = numbers(&balls.next().unwrap(), Precision::F64);
            let (i, o) = (motion.inner, motion.outer);
            let expected = [
                row.time_s,
                j as f64,
                ball.azimuth,
                ball.alpha_i,
                ball.alpha_o,
                ball.q_i,
                ball.q_o,
                ball.centrifugal_force,
                ball.gyroscopic_moment,
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
            assert_eq!(line, expected);
            // Hertz: force = 2/3 pi a b p.
            let force = 2.0 / 3.0 * std::f64::consts::PI * line[9] * line[11] * line[12];
            assert!((force - ball.q_i).abs() <= 1e-9 * ball.q_i.max(1.0));
        }
        let found = solution.frequencies();
        let [cage, outer, inner] = [found.cage, found.outer_race, found.inner_race];
        let line = numbers(&frequencies.next().unwrap(), Precision::F64);
        assert_eq!(line, [row.time_s, cage, outer, inner, found.ball]);
    }
    assert_eq!(frequencies.next().unwrap().join(","), "4,,,,");
    let rest: Vec<_> = balls.map(|line| line.join(",")).collect();
    let empty = |j| format!("4,{j},,,,,,,,,,,,,,,,,");
    assert_eq!(rest, (0..16).map(empty).collect::<Vec<_>>());
}

#[test]
fn a_reader_that_leaves_ends_the_replay_quietly() {
    for length in [0, 100, 100_000] {
        let mut replay = Command::new(REPLAY);
        let replay = replay.args([&shipped("b7005c"), RECORD]);
        let replay = replay.stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut running = replay.spawn().unwrap();
        let head = running.stdout.take().unwrap().take(length);
        assert_eq!(head.bytes().count() as u64, length);
        let ended = running.wait_with_output().unwrap();
        assert!(ended.status.success() && ended.stderr.is_empty());
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
    let header = HEADER.trim_end();
    for word in [
        "cargo replay",
        "DESIGN.toml",
        "--attitude",
        header,
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
    for (args, name) in [
        ([&*shipped("b218"), "nowhere.csv"], "nowhere.csv"),
        (["nowhere.toml", "-"], "nowhere.toml"),
    ] {
        let (status, _, err) = replayed(&args, "");
        assert_eq!(status, 2);
        let start = format!("replay: {name}: cannot be read: ");
        assert!(err.starts_with(&start), "{err}");
    }
}

#[test]
fn a_table_has_what_a_recording_of_its_loads_gives() {
    let design = shipped("b7005c");
    let axes = ["speed=0:20000:10000", "fx=500", "fy=0:200:100", "--cold"];
    let (status, table, err) = replayed(&[&[&*design, "--table"], &axes[..]].concat(), "");
    assert_eq!((status, &*err), (0, ""));
    let row = |i| format!("{i},500,{},0,0,0,{}\n", i / 3 * 100, i % 3 * 10_000);
    let recording = HEADER.to_owned() + &(0..9).map(row).collect::<String>();
    assert_eq!(table, replayed(&[&design, "-", "--cold"], &recording).1);
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

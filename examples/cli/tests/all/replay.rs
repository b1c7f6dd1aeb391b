//! `cargo replay`: arguments, messages, exit status, and that the results are the solver's.

use crate::malformed::{self, HEADER};
use cli::milling_cycle::RECORD;
use cli::recordings::{Loads, Wanted};
use solvers::dispatch::{Attitude, Precision};
use solvers::{AnySolver, Balls, with_solver};
use spindle_bearing::{BallKinematics, BallState, RatingLife, Speed};
use spindle_file::designs::SHIPPED;
use spindle_file::loads::LoadRow;
use spindle_file::spindles::SpindleFile;
use std::f64::consts::PI;
use std::io::{self, Cursor, Read, Write};
use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::thread;

const REPLAY: &str = env!("CARGO_BIN_EXE_replay");

const RESULT_HEADER: &str = "time_s,status,iterations,dx_m,dy_m,dz_m,ty_rad,tz_rad,\
    k_x_x,k_x_y,k_x_z,k_x_ty,k_x_tz,k_y_x,k_y_y,k_y_z,k_y_ty,k_y_tz,k_z_x,k_z_y,k_z_z,k_z_ty,k_z_tz,\
    k_ty_x,k_ty_y,k_ty_z,k_ty_ty,k_ty_tz,k_tz_x,k_tz_y,k_tz_z,k_tz_ty,k_tz_tz,limits,\
    fx_n,fy_n,fz_n,my_nm,mz_nm,speed_rpm,l10_mrev,l10_h";

const BALL_HEADER: &str = "time_s,ball,azimuth_rad,alpha_i_rad,alpha_o_rad,q_i_n,q_o_n,fc_n,mg_nm,\
    p_i_pa,p_o_pa,a_i_m,b_i_m,a_o_m,b_o_m,cage_rad_s,attitude_rad,spin_roll_i,spin_roll_o";

const ROW_HEADER: &str = "time_s,row,fx_n,fy_n,fz_n,my_nm,mz_nm,preload_n,least_q_i_n,\
    k_row_x_x,k_row_x_y,k_row_x_z,k_row_x_ty,k_row_x_tz,k_row_y_x,k_row_y_y,k_row_y_z,k_row_y_ty,k_row_y_tz,\
    k_row_z_x,k_row_z_y,k_row_z_z,k_row_z_ty,k_row_z_tz,k_row_ty_x,k_row_ty_y,k_row_ty_z,k_row_ty_ty,k_row_ty_tz,\
    k_row_tz_x,k_row_tz_y,k_row_tz_z,k_row_tz_ty,k_row_tz_tz,dx_m,dy_m,dz_m,ty_rad,tz_rad,closure_um,l10_mrev,l10_h";

const NOSE_HEADER: &str = "time_s,nose,dx_m,dy_m,dz_m,ty_rad,tz_rad,\
    c_x_x,c_x_y,c_x_z,c_x_ty,c_x_tz,c_y_x,c_y_y,c_y_z,c_y_ty,c_y_tz,c_z_x,c_z_y,c_z_z,c_z_ty,c_z_tz,\
    c_ty_x,c_ty_y,c_ty_z,c_ty_ty,c_ty_tz,c_tz_x,c_tz_y,c_tz_z,c_tz_ty,c_tz_tz,\
    c_error_x,c_error_y,c_error_z,c_error_ty,c_error_tz";

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

/// Standard output of a replay that succeeds with files of these options, and the files.
fn with_files(args: &[&str], options: &[&str], stdin: &str) -> (String, Vec<String>) {
    let path = |option: &&str| scratch(&option[2..]);
    let paths: Vec<_> = options.iter().map(path).collect();
    let mut args = args.to_vec();
    for (option, path) in options.iter().zip(&paths) {
        args.extend([option, path.to_str().unwrap()]);
    }
    let (status, out, err) = replayed(&args, stdin);
    assert_eq!(status, 0, "{err}");
    let read = |path| {
        let text = std::fs::read_to_string(&path).unwrap();
        std::fs::remove_file(path).unwrap();
        text
    };
    (out, paths.into_iter().map(read).collect())
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
    let loads = Loads::from_reader("loads.csv", Box::new(input), &Wanted::default()).unwrap();
    loads.map(Result::unwrap).collect()
}

#[test]
fn tables_hold_the_bits_that_the_solver_gave() {
    let spindles = ["7014c_back_to_back", "elastic_spindle"];
    let [spindle, elastic] = spindles.map(|name| shipped(&format!("../spindles/{name}")));
    let bearing = shipped("b7005c");
    for precision in [Precision::F32, Precision::F64] {
        check_tables(&bearing, "raceless", Attitude::Raceless, precision);
        check_tables(&bearing, "outer", Attitude::Outer, precision);
        check_tables(&bearing, "inner", Attitude::Inner, precision);
        check_tables(&spindle, "raceless", Attitude::Raceless, precision);
        check_tables(&elastic, "raceless", Attitude::Raceless, precision);
    }
}

fn check_tables(design: &str, rule: &str, attitude: Attitude, precision: Precision) {
    let file = SpindleFile::read(design).unwrap();
    let name = format!("{precision:?}").to_lowercase();
    let args = [design, "-", "--precision", &name, "--attitude", rule];
    let refused = "4,nan,300,-40,1,2,9000\n5,400,0,-inf,0,0,0\n6,400,0,0,0,0,NaN\n";
    let text = format!("{HEADER}{ROWS}{refused}{ROWS}");
    // A bearing has no table of rows, and no nose.
    let (options, row): (&[&str], _) = match file.is_bearing {
        true => (&["--balls", "--frequencies"], ""),
        false => (&["--balls", "--frequencies", "--rows", "--nose"], "row,"),
    };
    let (out, mut files) = with_files(&args, options, &text);
    if file.is_bearing {
        files.extend([ROW_HEADER, NOSE_HEADER].map(|header| format!("{header}\n")));
    }
    let stiffness = RESULT_HEADER.find("k_x_x").unwrap()..RESULT_HEADER.find("limits").unwrap();
    let at_nose = "k_nose_x_x,k_nose_y_y,k_nose_z_z,k_nose_ty_ty,k_nose_tz_tz,";
    let mut header = RESULT_HEADER.to_owned();
    if file.nose().is_some() {
        header.insert_str(stiffness.end, at_nose);
    }
    let mut lines = table(&out, &header).into_iter();
    let headers = [
        BALL_HEADER.replace("ball,", &format!("{row}ball,")),
        format!("time_s,{row}cage_hz,outer_race_hz,inner_race_hz,ball_hz"),
        ROW_HEADER.to_owned(),
        NOSE_HEADER.to_owned(),
    ];
    let mut files = [0, 1, 2, 3].map(|i| table(&files[i], &headers[i]).into_iter());
    let limits = header.split(',').count() - 9;
    let balls = Balls::from(attitude);
    let check = |solver: &mut dyn AnySolver| {
        for row in parsed(&text) {
            let line = lines.next().unwrap();
            let [fx, fy, fz, my, mz] = row.load;
            let given = [row.time_s, fx, fy, fz, my, mz, row.speed_rpm];
            let copies = [&line[..1], &line[limits + 1..limits + 7]].concat();
            let copies = numbers(&copies, Precision::F64).into_iter();
            assert!(copies.map(f64::to_bits).eq(given.map(f64::to_bits)));
            let answer = solver.solve(&file.question(&row));
            match &answer {
                Ok(answer) => {
                    let iterations = answer.iterations.to_string();
                    assert_eq!(line[1..3], [answer.status.name(), &iterations]);
                    let stiffness = answer.stiffness.as_flattened();
                    let at_nose = answer.at.first().map_or([0.0; 5], |at| {
                        let all = [0, 1, 2, 3, 4].map(|i| 1.0 / at.compliance[i][i]);
                        all.map(|k| match precision {
                            Precision::F32 => f64::from(k as f32),
                            Precision::F64 => k,
                        })
                    });
                    let figures = [&answer.displacement, stiffness, &at_nose].concat();
                    let found = numbers(&line[3..limits], precision).into_iter();
                    let figures = figures.into_iter().take(limits - 3);
                    assert!(found.map(f64::to_bits).eq(figures.map(f64::to_bits)));
                    assert_eq!(line[limits], answer.passed().join(" "));
                    let [revolutions, hours] = [line[limits + 7], line[limits + 8]];
                    let speed = row.speed_rpm;
                    assert_eq!(hours.is_empty(), speed == 0.0);
                    if speed > 0.0 {
                        let life = numbers(&[revolutions, hours], Precision::F64);
                        let turned = life[1] * 60.0 * speed / 1e6;
                        assert!((turned / life[0] - 1.0).abs() < 1e-6);
                    }
                }
                Err(status) => {
                    assert_eq!(line[1], status.name());
                    assert!(
                        [&line[2..=limits], &line[limits + 7..]]
                            .concat()
                            .concat()
                            .is_empty()
                    );
                }
            }
            let omega = Speed::rpm(row.speed_rpm).as_rad_per_s();
            for (i, of) in file.plan.rows.iter().enumerate() {
                let row = answer.as_ref().ok().map(|answer| &answer.rows[i]);
                let lives = row.map(|row| {
                    let forces = row.balls.iter().map(|ball| (ball.q_i, ball.q_o));
                    let life = RatingLife::of_weight(file.ratings()[i].weight_of(forces), omega);
                    [life.million_revolutions, life.hours].map(|life| {
                        let mut text = String::new();
                        if life.is_finite() {
                            Precision::F32.write(&mut text, life).unwrap();
                        }
                        text
                    })
                });
                let mut check = |table: usize, ball: Option<usize>, figures: Option<Vec<f64>>| {
                    let line = files[table].next().unwrap();
                    let numbered = (!file.is_bearing).then_some(i).into_iter().chain(ball);
                    let numbered: Vec<_> = numbered.map(|number| number.to_string()).collect();
                    let (place, rest) = line[1..].split_at(numbered.len());
                    assert_eq!(place, numbered);
                    let (rest, life) = rest.split_at(rest.len() - if table == 2 { 2 } else { 0 });
                    if table == 2 {
                        assert_eq!(life, lives.clone().unwrap_or_default());
                    }
                    match figures {
                        Some(figures) => assert_eq!(numbers(rest, precision), figures),
                        None => assert!(rest.concat().is_empty()),
                    }
                };
                for j in 0..of.balls {
                    let figures = row.map(|row| ball_figures(&row.balls[j], &row.motions[j]));
                    // Hertz: force = 2/3 pi a b p.
                    if let (Some(of), Precision::F64) = (&figures, precision) {
                        let force = 2.0 / 3.0 * PI * of[7] * of[9] * of[10];
                        assert!((force - of[3]).abs() <= 1e-9 * of[3].max(1.0));
                    }
                    check(0, Some(j), figures);
                }
                let found = row.map(|row| &row.frequencies);
                let found = found.map(|f| vec![f.cage, f.outer_race, f.inner_race, f.ball]);
                check(1, None, found);
                if !file.is_bearing {
                    let carried = row.map(|row| {
                        let forces = row.balls.iter().map(|ball| ball.q_i);
                        let least = forces.fold(f64::INFINITY, f64::min);
                        // In um, rounded as the solver's figures are.
                        let closure = match precision {
                            Precision::F32 => f64::from((1e6 * row.closure) as f32),
                            Precision::F64 => 1e6 * row.closure,
                        };
                        let stiffness = row.stiffness_on_shaft.as_flattened();
                        let carried = [&row.force[..], &[row.preload, least], stiffness];
                        [&carried.concat()[..], &row.displacement, &[closure]].concat()
                    });
                    check(2, None, carried);
                }
            }
            for (i, nose) in file.noses.iter().enumerate() {
                let line = files[3].next().unwrap();
                assert_eq!(line[1], nose.name);
                match &answer {
                    Ok(answer) => {
                        let at = &answer.at[i];
                        let figures = [&at.displacement[..], at.compliance.as_flattened()];
                        let figures = [&figures.concat()[..], &at.compliance_error].concat();
                        assert_eq!(numbers(&line[2..], precision), figures);
                    }
                    Err(_) => assert!(line[2..].concat().is_empty()),
                }
            }
        }
    };
    with_solver(&file.plan, balls, precision, check).unwrap();
    assert_eq!(lines.next(), None);
    assert!(files.iter_mut().all(|file| file.next().is_none()));
}

/// State, motion and contacts of a ball in the order of their columns.
fn ball_figures(ball: &BallState<f64>, motion: &BallKinematics<f64>) -> Vec<f64> {
    let (i, o) = (motion.inner, motion.outer);
    vec![
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
    ]
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
fn a_malformed_recording_ends_the_replay_with_a_complaint() {
    for (text, start) in malformed::recordings() {
        let (status, _, err) = replayed(&[&shipped("b7005c"), "-"], &text);
        assert_eq!(status, 2, "{err}");
        assert!(err.contains(start), "{err}\nnot\n{start}");
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
        let text = text + "1,400,0,0,0,0,7\n";
        let (status, out, err) = replayed(&[&shipped("b7005c"), "-"], &text);
        assert_eq!((status, err.lines().count()), (0, 2), "{err}");
        let lines = table(&out, RESULT_HEADER);
        let refused = lines.iter().filter(|line| line[1] == "refused-input");
        assert_eq!(refused.count(), 1, "{out}");
        assert_eq!(lines.last().unwrap()[..2], ["1", "converged"]);
        assert!(err.contains("1 refused-input"), "{err}");
        assert!(err.contains(&format!("standard input: {start}")), "{err}");
    }
    // A column that is not read is named once.
    let rows = "0,400,0,0,0,0,0,T1\n1,,0,0,0,0,0,\n2,nan,0,0,0,0,0,\nthree,,0,0,0,0,0,\n4,400,0,0,0,0,0,\n";
    let text = HEADER.replace('\n', ",tool\n") + rows;
    let (status, out, err) = replayed(&[&shipped("b7005c"), "-"], &text);
    assert_eq!(status, 0);
    let starts = table(&out, RESULT_HEADER).into_iter();
    let starts: Vec<_> = starts.map(|line| line[..2].join(",")).collect();
    let refused = "1,refused-input 2,not-finite ,refused-input";
    let expected = format!("0,converged {refused} 4,converged");
    assert_eq!(starts.join(" "), expected);
    assert_eq!(
        err,
        "replay: standard input: columns ignored: \"tool\"\n\
         replay: standard input: rows read 3, refused 2; lines skipped 0; time 0 to 4 s, fx 400 N, fy 0 N, fz 0 N, my 0 Nm, \
         mz 0 Nm, speed 0 rpm\nreplay: 3 of 5 rows have no answer: 1 not-finite, 2 refused-input (the first at 2 s: axial load \
         Fx (N) is NaN; the first that cannot be read: standard input: line 3, column 2 (fx_n): the field \
         is empty; a number is needed)\n"
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
fn a_reader_that_leaves_ends_the_replay_quietly() {
    for length in [0, 100, 100_000] {
        let mut replay = Command::new(REPLAY);
        let replay = replay.args([&shipped("b7005c"), RECORD]);
        let replay = replay.stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut running = replay.spawn().unwrap();
        let mut head = running.stdout.take().unwrap().take(length);
        assert_eq!(io::copy(&mut head, &mut io::sink()).unwrap(), length);
        drop(head);
        let ended = running.wait_with_output().unwrap();
        assert!(ended.status.success() && ended.stderr.is_empty());
    }
}

/// Blocks of 500 records begin cold, and are written in order: nothing depends on the threads that solve them.
#[test]
fn tables_are_those_of_one_thread() {
    let recording = std::fs::read_to_string(RECORD).unwrap();
    let mut lines: Vec<&str> = recording.lines().take(1 + 5700).collect();
    lines[1 + 2600] = "2.6,1,2,3,4,no number,6";
    lines.push("5.7,1,2");
    let recording = lines.join("\n") + "\n";
    let (path, balls) = (scratch("blocks.csv"), scratch("blocks_balls.csv"));
    std::fs::write(&path, &recording).unwrap();
    let bearing = shipped("b7005c");
    let run = |threads: &str, options: &[&str]| {
        let mut replay = Command::new(REPLAY);
        let replay = replay.arg(&bearing).arg(&path).args(options);
        let ended = replay.env("RAYON_NUM_THREADS", threads).output().unwrap();
        let text = |bytes| String::from_utf8(bytes).unwrap();
        (ended.status.code(), text(ended.stdout), text(ended.stderr))
    };
    let with_balls = ["--balls", balls.to_str().unwrap()];
    for options in [&with_balls[..], &["--summary=json"]] {
        let [one, two, five] = ["1", "2", "5"].map(|threads| {
            let ended = run(threads, options);
            (ended, std::fs::read(&balls).unwrap())
        });
        assert!(one == two && one == five, "{options:?}");
        let (_, _, err) = one.0;
        assert!(
            err.contains("2 of 5701 rows have no answer: 2 refused-input"),
            "{err}"
        );
    }
    let [(_, warm, _), (_, cold, _)] = [&[][..], &["--cold"]].map(|options| run("2", options));
    let [warm, cold] = [&warm, &cold].map(|text| text.lines().skip(1).collect::<Vec<_>>());
    assert_eq!((warm.len(), cold.len()), (5701, 5701));
    for record in (0..5700).step_by(500) {
        assert_eq!(warm[record], cold[record]);
        assert!(
            record == 0 || warm[record - 1] != cold[record - 1],
            "{record}"
        );
    }
    std::fs::remove_file(path).unwrap();
    std::fs::remove_file(balls).unwrap();
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

    // Inputs are the bearings that a spindle names, too, by whatever path.
    let [spindle, bearing] = ["7014c_back_to_back.toml", "7014c.toml"].map(scratch);
    let shipped = |folder: &str, name| {
        format!(
            "{}/../spindle_file/{folder}/{name}",
            env!("CARGO_MANIFEST_DIR")
        )
    };
    let text = std::fs::read_to_string(shipped("spindles", "7014c_back_to_back.toml")).unwrap();
    let text = text.replace("../bearings/7014c.toml", bearing.to_str().unwrap());
    std::fs::write(&spindle, text).unwrap();
    std::fs::copy(shipped("bearings", "7014c.toml"), &bearing).unwrap();
    let before = std::fs::read(&bearing).unwrap();
    let folder = bearing.parent().unwrap();
    let other = folder.join("..").join(folder.file_name().unwrap());
    let other = other.join(bearing.file_name().unwrap());
    let args = [
        spindle.to_str().unwrap(),
        "-",
        "--rows",
        other.to_str().unwrap(),
    ];
    let (status, out, err) = replayed(&args, HEADER);
    assert_eq!((status, out.as_str()), (2, ""));
    assert!(
        err.contains("--rows would overwrite its own input"),
        "{err}"
    );
    assert_eq!(std::fs::read(&bearing).unwrap(), before);
    std::fs::remove_file(spindle).unwrap();
    std::fs::remove_file(bearing).unwrap();
}

/// `z.csv` was written as `z.csv.part`: a recording of that name was emptied, and what was written read for ever.
#[test]
fn a_recording_by_the_name_of_an_unfinished_output_is_read() {
    let [recording, balls] = ["z.csv.part", "z.csv"].map(scratch);
    let text = format!("{HEADER}{ROWS}");
    std::fs::write(&recording, &text).unwrap();
    let [name, out] = [&recording, &balls].map(|path| path.to_str().unwrap());
    let (status, results, err) = replayed(&[&shipped("b7005c"), name, "--balls", out], "");
    assert_eq!((status, results.lines().count()), (0, 5), "{err}");
    assert_eq!(std::fs::read_to_string(&recording).unwrap(), text);
    let written = std::fs::read_to_string(&balls).unwrap();
    assert_eq!(written.lines().count(), 1 + 4 * 16);
    std::fs::remove_file(recording).unwrap();
    std::fs::remove_file(balls).unwrap();
}

#[test]
fn two_outputs_of_one_path_are_refused() {
    let path = scratch("both.csv");
    let folder = path.parent().unwrap();
    let again = folder.join(".").join("both.csv").display().to_string();
    let again = again.replace("both.csv", path.file_name().unwrap().to_str().unwrap());
    let (status, out, err) = replayed(
        &[
            &shipped("b7005c"),
            "-",
            "--balls",
            path.to_str().unwrap(),
            "--frequencies",
            &again,
        ],
        &format!("{HEADER}{ROWS}"),
    );
    assert_eq!((status, out.as_str()), (2, ""));
    assert!(
        err.contains("--frequencies: ") && err.contains("is another output, too"),
        "{err}"
    );
    assert!(!path.exists());
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
fn a_table_has_what_a_recording_of_its_loads_gives() {
    let design = shipped("b7005c");
    // Speed changes first, and steps of a tenth give tenths.
    let axes = "speed=0:20000:10000 fx=500 fy=0:0.3:0.1 mz=-1:-2:-1 --cold";
    let axes: Vec<_> = axes.split(' ').collect();
    let (status, table, err) = replayed(&[&[&*design, "--table"], &axes[..]].concat(), "");
    assert_eq!((status, &*err), (0, ""));
    let row = |i: usize| {
        let (fy, mz, speed) = (["0", "0.1", "0.2", "0.3"][i / 6], i / 3 % 2, i % 3 * 10_000);
        format!("{i},500,{fy},0,0,{},{speed}\n", ["-1", "-2"][mz])
    };
    let recording = HEADER.to_owned() + &(0..24).map(row).collect::<String>();
    assert_eq!(table, replayed(&[&design, "-", "--cold"], &recording).1);

    // A temperature that is not given is the reference's.
    let spindle = shipped("../spindles/milling_spindle");
    let axes = ["speed=3000", "t_inner=25:35:5", "--cold"];
    let (status, table, err) = replayed(&[&[&*spindle, "--table"], &axes[..]].concat(), "");
    assert_eq!((status, &*err), (0, ""));
    let row = |i| format!("{i},0,0,0,0,0,3000,{},20\n", 25 + 5 * i);
    let header = HEADER.replace('\n', ",t_inner_c,t_outer_c\n");
    let recording = header + &(0..3).map(row).collect::<String>();
    assert_eq!(table, replayed(&[&spindle, "-", "--cold"], &recording).1);
}

#[test]
fn axes_that_make_no_table_are_refused() {
    let bearing = shipped("b7005c");
    for (axes, wanted) in [
        ("loads.csv", "an axis is NAME=FIRST:LAST:STEP"),
        ("rpm=5", "\"rpm\" is none of the axes t_inner, "),
        (
            "t_inner=30",
            "t_inner and t_outer are for spindles with [heat]",
        ),
        ("speed=1:2", "give FIRST:LAST:STEP"),
        ("speed=1:2:0", "no steps of 0 lead from 1 to 2"),
        ("speed=1:2:-1", "no steps of -1 lead"),
        ("speed=nan", "\"nan\" is not a number"),
        ("speed=1:inf:1", "\"inf\" is not a number"),
        ("speed=", "\"\" is not a number"),
        ("speed=-1e308:1e308:1e308", "more than 1000000 rows"),
        ("speed=0:1e300:1e-300", "more than 1000000 rows"),
        ("speed=0:1e6:1", "more than 1000000 rows"),
        (
            "speed=0:1e4:1 fx=0:1e4:1 fy=0:1e4:1 mz=0:1e4:1",
            "more than 1000000 rows",
        ),
        ("speed=0 speed=1", "speed is given twice"),
    ] {
        let args: Vec<_> = [&*bearing, "--table"]
            .into_iter()
            .chain(axes.split(' '))
            .collect();
        let (status, out, err) = replayed(&args, "");
        assert_eq!((status, &*out), (2, ""));
        let is_named = err.starts_with("replay: --table") && err.contains(wanted);
        assert!(is_named, "{err}\nnot\n{wanted}");
    }
    let (status, _, err) = replayed(&[&bearing, "loads.csv", "--table", "fx=5"], "");
    assert_eq!(status, 2);
    assert!(err.contains("cannot be used with"), "{err}");
}

#[test]
fn bearings_of_the_catalogue_are_replayed_by_name_and_listed() {
    let loads = format!("{HEADER}{ROWS}");
    let (status, named, told) = replayed(&["gmn:s 6005 c", "-"], &loads);
    assert!(status == 0 && told.lines().count() == 1, "{told}");
    assert_eq!(named.lines().count(), 5);
    let (status, _, told) = replayed(&["gmn:S6005X", "-"], &loads);
    assert!(status == 2 && told.contains("gmn:S6005C"), "{told}");
    let (status, list, _) = replayed(&["--list"], "");
    assert!(status == 0 && list.contains("gmn:S6014C"), "{list}");
}

/// Another file gets what it has, what is due, and the lines that make a recording of it.
#[test]
fn another_file_is_refused_with_the_lines_that_make_a_recording() {
    let text = "t;Fx [kN];Fy;Fz;remark;n\n0;0,4;1;0,5;a;6000\n";
    let (status, out, err) = replayed(&[&shipped("b7005c"), "-"], text);
    assert_eq!((status, &*out), (2, ""));
    assert_eq!(
        err,
        "replay: standard input: line 1, column 1: the names are \"t\", \"Fx [kN]\", \"Fy\", \"Fz\", \"remark\" and 1 more: \
         there is no fx_n, fy_n, fz_n, my_nm, mz_nm, speed_rpm\n  \
         column 1: `t`: the column `time_s` is due, in s: rename it if it is in s, convert it, or leave it out\n  \
         column 2: `Fx [kN]`: the column `fx_n` is due, in N: multiply by 1000\n  \
         column 3: `Fy`: the column `fy_n` is due, in N: rename it if it is in N, convert it, or leave it out\n  \
         column 4: `Fz`: the column `fz_n` is due, in N: rename it if it is in N, convert it, or leave it out\n\
         Type the header time_s,fx_n,fy_n,fz_n,my_nm,mz_nm,speed_rpm above your columns in a spreadsheet, and save them as CSV. \
         Or in Python, after `import pandas`:\n  \
         df = pandas.read_csv(\"other.csv\", sep=\";\", decimal=\",\")  # or as in docs/recordings.md\n  \
         df = pandas.DataFrame({\"time_s\": df[\"?\"], \"fx_n\": df[\"?\"], \"fy_n\": df[\"?\"], \"fz_n\": df[\"?\"], \
         \"my_nm\": df[\"?\"], \"mz_nm\": df[\"?\"], \"speed_rpm\": df[\"?\"]})  # such as 1000 * df[\"Fx / kN\"], or a constant\n  \
         df.to_csv(\"loads.csv\", index=False)\n"
    );
    let (_, _, err) = replayed(&[&shipped("b7005c"), "-", "--given", "dx=0,ty=0"], "a\tb\n");
    for told in [
        "there is no fy_n, fz_n, mz_nm, speed_rpm\n",
        "Type the header time_s,fy_n,fz_n,mz_nm,speed_rpm above",
        "read_csv(\"other.csv\", sep=\"\\t\", decimal=\",\")",
    ] {
        assert!(err.contains(told), "{told}\n{err}");
    }
}

/// A constant is a column, and no option, of a recording.
#[test]
fn options_give_no_columns() {
    let (status, _, err) = replayed(&[&shipped("b7005c"), "-", "--my", "0"], HEADER);
    let told = "'[LOADS.csv]' cannot be used with '--my <Nm>'";
    assert!(status == 2 && err.contains(told), "{err}");
    let (status, _, err) = replayed(&[&shipped("b7005c"), "--my", "0"], "");
    assert!(status == 2 && err.contains("--sensitivity"), "{err}");
}

#[test]
fn columns_are_selected_by_their_names() {
    let input = format!("{HEADER}{ROWS}");
    let bearing = shipped("b7005c");
    let (_, all, _) = replayed(&[&bearing, "-"], &input);
    let all = table(&all, RESULT_HEADER);
    let (status, out, _) = replayed(
        &[&bearing, "-", "--select", "kxx,time_s,k_ty_z,dx,l10_h"],
        &input,
    );
    assert_eq!(status, 0);
    let picked = table(&out, "k_x_x,time_s,k_ty_z,dx_m,l10_h");
    let names: Vec<&str> = RESULT_HEADER.split(',').collect();
    let place = |name: &str| names.iter().position(|one| *one == name).unwrap();
    let places = ["k_x_x", "time_s", "k_ty_z", "dx_m", "l10_h"].map(place);
    for (line, all) in picked.iter().zip(&all) {
        assert_eq!(line[..], places.map(|i| all[i]));
    }
    for (names, wanted) in [
        ("kxq", "no column kxq: there are time_s,"),
        ("l10", "no column l10"),
        ("dx,dx_m", "given twice"),
    ] {
        let (status, _, err) = replayed(&[&bearing, "-", "--select", names], &input);
        assert!(status == 2 && err.contains(wanted), "{err}");
    }
}

#[test]
fn balls_move_as_they_are_told() {
    let input = format!("{HEADER}0,500,100,0,0,0,0\n1,500,100,0,0,0,15000\n");
    let bearing = shipped("b7005c");
    let solved = |motion: &str| {
        let args = [&bearing, "-", "--cold", "--motion", motion];
        let (out, files) = with_files(&args, &["--frequencies"], &input);
        let lines = out
            .lines()
            .map(|line| line.split(',').map(str::to_owned).collect::<Vec<_>>());
        let frequencies = files[0]
            .lines()
            .nth(2)
            .unwrap()
            .split(',')
            .map(|x| x.parse::<f64>().unwrap_or(0.0));
        (
            lines.skip(1).collect::<Vec<_>>(),
            frequencies.collect::<Vec<f64>>(),
        )
    };
    let (still, by_angles) = solved("static");
    // The same displacement and stiffness, whatever the speed; the life in hours is at that speed.
    assert_eq!(still[0][3..34], still[1][3..34]);
    assert!(still[0][41].is_empty() && !still[1][41].is_empty());
    let (full, turning) = solved("full");
    let (centrifugal, _) = solved("centrifugal");
    assert_ne!(full[1], centrifugal[1]);
    for i in 1..5 {
        assert!(
            (by_angles[i] / turning[i] - 1.0).abs() < 0.05,
            "{by_angles:?} {turning:?}"
        );
    }
    assert!((by_angles[2] + by_angles[3] - 16.0 * 250.0).abs() < 1e-9);
    let (status, _, err) = replayed(
        &[&bearing, "-", "--motion", "static", "--attitude", "outer"],
        &input,
    );
    assert!(
        status == 2 && err.contains("--attitude makes no difference"),
        "{err}"
    );
}

/// A record before a pause counts for one usual step, unless states are held.
#[test]
fn a_pause_of_the_logger_is_no_load() {
    let rows = "0,1000,0,0,0,0,3000\n0.001,1000,0,0,0,0,3000\n3600,2000,0,0,0,0,6000\n3600.001,2000,0,0,0,0,6000\n";
    let input = format!("{HEADER}{rows}");
    for (options, duration, said) in [
        (&[][..], 0.004, true),
        (&["--pauses", "hold"][..], 3600.002, false),
    ] {
        let bearing = shipped("b7005c");
        let args = [&[&*bearing, "-", "--summary=json"], options].concat();
        let (_, out, err) = replayed(&args, &input);
        let found = serde_json::from_str::<serde_json::Value>(&out).unwrap()["duration_s"].as_f64();
        assert!((found.unwrap() - duration).abs() < 1e-9, "{out}");
        assert_eq!(
            err.contains("the logger pauses for 3599.999 s after 0.001 s"),
            said,
            "{err}"
        );
    }
}

/// Two loads, each for half of the time: the shares of life that they use up add up.
#[test]
fn a_recording_has_one_life() {
    let bearing = shipped("b7005c");
    let hours = |rows: &str| -> f64 {
        let args = [&bearing, "-", "--summary=json"];
        let (status, out, err) = replayed(&args, &format!("{HEADER}{rows}"));
        assert!(status == 0 && err.lines().count() == 1, "{err}");
        serde_json::from_str::<serde_json::Value>(&out).unwrap()["l10_h"]
            .as_f64()
            .unwrap()
    };
    let heavy = hours("0,900,300,0,0,0,9000\n1,900,300,0,0,0,9000\n");
    let light = hours("0,500,100,0,0,0,12000\n1,500,100,0,0,0,12000\n");
    let both = hours("0,900,300,0,0,0,9000\n1,500,100,0,0,0,12000\n");
    assert!((2.0 / (1.0 / heavy + 1.0 / light) / both - 1.0).abs() < 1e-9);
    // Where no time passes, records hold equally long.
    let still = hours("5,900,300,0,0,0,9000\n5,500,100,0,0,0,12000\n");
    assert!((still / both - 1.0).abs() < 1e-9);
    let input = format!(
        "{HEADER}0,900,300,0,0,0,9000\n3,x,0,0,0,0,0\n4,6000,300,0,0,0,9000\n3,6000,0,0,0,0,0\n"
    );
    let args = [&bearing, "-", "--summary", "--peak-pressure", "2500"];
    let (status, out, _) = replayed(&args, &input);
    assert_eq!(status, 0);
    for line in [
        "records            4",
        "without an answer  1 (25.00 %)",
        "time with answers  5.000000 s",
        "time goes back     1 times",
        "peak-pressure    2.000000 s (40.00 %)",
    ] {
        assert!(out.contains(line), "{out}\nwithout {line}");
    }
}

/// A disk that is full, or a recording that is none, leaves the file of yesterday.
#[test]
fn an_old_file_stays_until_the_new_one_is_complete() {
    let path = scratch("kept.csv");
    std::fs::write(&path, "of yesterday").unwrap();
    let name = path.to_str().unwrap();
    for (design, loads, missing) in [
        (&*shipped("b7005c"), "nowhere.csv", "nowhere.csv"),
        ("nowhere.toml", "-", "nowhere.toml"),
    ] {
        let (status, _, err) = replayed(&[design, loads, "--balls", name], "");
        assert_eq!(status, 2);
        let start = format!("replay: {missing}: cannot be read: ");
        assert!(err.starts_with(&start), "{err}");
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "of yesterday");
    }
    // A line without end; no row that can be read.
    for (rows, lines, fault) in [
        (
            format!("{ROWS}{}", "1".repeat(100_000)),
            5,
            "line 6, column 1: the line is longer",
        ),
        (
            "0,0,400,5,0,0,0,0\n1,2\n".to_owned(),
            3,
            "line 2, column 8: the line has 8 fields",
        ),
    ] {
        let recording = format!("{HEADER}{rows}");
        let (status, out, err) = replayed(&[&shipped("b7005c"), "-", "--balls", name], &recording);
        assert_eq!((status, out.lines().count()), (2, lines), "{err}");
        assert!(err.contains(fault), "{err}");
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "of yesterday");
    }
    // One that nobody may write.
    let permissions = std::fs::metadata(&path).unwrap().permissions();
    let mut locked = permissions.clone();
    locked.set_readonly(true);
    std::fs::set_permissions(&path, locked).unwrap();
    let (status, out, err) = replayed(
        &[&shipped("b7005c"), "-", "--balls", name],
        &format!("{HEADER}{ROWS}"),
    );
    assert_eq!((status, out.as_str()), (2, ""), "{err}");
    assert!(err.contains("kept.csv: cannot be written: "), "{err}");
    assert_eq!(std::fs::read_to_string(&path).unwrap(), "of yesterday");
    std::fs::set_permissions(&path, permissions).unwrap();
    let full = std::fs::File::options().write(true).open("/dev/full");
    if let Ok(full) = full {
        let mut replay = Command::new(REPLAY);
        let replay = replay.args([&*shipped("b7005c"), RECORD, "--balls", name]);
        let ended = replay.stdout(full).stderr(Stdio::piped()).output().unwrap();
        assert_eq!(ended.status.code(), Some(1));
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "of yesterday");
    }
    let (status, _, _) = replayed(
        &[&shipped("b7005c"), "-", "--balls", name],
        &format!("{HEADER}{ROWS}"),
    );
    assert_eq!(status, 0);
    assert!(
        std::fs::read_to_string(&path)
            .unwrap()
            .starts_with(BALL_HEADER)
    );
    std::fs::remove_file(&path).unwrap();
    let rest = std::fs::read_dir(path.parent().unwrap()).unwrap();
    let name = path.file_name().unwrap().to_str().unwrap();
    let is_left = |name: &std::ffi::OsString, of: &str| name.to_string_lossy().starts_with(of);
    let rest = rest.map(|entry| entry.unwrap().file_name());
    let rest: Vec<_> = rest.filter(|entry| is_left(entry, name)).collect();
    assert!(rest.is_empty(), "{rest:?}");
}

#[cfg(unix)]
#[test]
fn paths_need_not_be_text() {
    use std::os::unix::ffi::OsStrExt;
    let path = scratch("x").with_file_name(std::ffi::OsStr::from_bytes(b"loads-\xFF.csv"));
    std::fs::write(&path, format!("{HEADER}{ROWS}")).unwrap();
    let ended = Command::new(REPLAY)
        .arg(shipped("b7005c"))
        .arg(&path)
        .output()
        .unwrap();
    std::fs::remove_file(&path).unwrap();
    assert!(ended.status.success());
    assert_eq!(ended.stdout.split(|byte| *byte == b'\n').count(), 6);
}

#[test]
fn displacements_may_be_given() {
    let spindle = shipped("../spindles/7014c_back_to_back");
    let input = format!("{HEADER}0,300,100,0,0,2,6000\n");
    let select = |args: &[&str]| -> Vec<f64> {
        let (status, out, err) = replayed(&[&[&*spindle, "-"], args].concat(), &input);
        assert!(status == 0 && err.lines().count() == 1, "{err}");
        numbers(
            &out.lines().nth(1).unwrap().split(',').collect::<Vec<_>>(),
            Precision::F64,
        )
    };
    let free = select(&["--select", "dx,dy,dz,ty,tz"]);
    let given = format!("dx={},tz={}", free[0], free[4]);
    let names = "dx,dy,dz,ty,tz,reaction_fx_n,reaction_mz_nm,fx_n";
    let held = select(&["--given", &given, "--select", names]);
    for (held, wanted) in held.iter().zip(free.iter().chain(&[300.0, 2.0, 300.0])) {
        assert!(
            (held - wanted).abs() <= 1e-9 * wanted.abs().max(1e-3),
            "{held} {wanted}"
        );
    }
    let locked = select(&["--freedoms", "3", "--select", "ty,tz,dx"]);
    assert!(locked[..2] == [0.0, 0.0] && locked[2] > 0.0);
    for wrong in [
        &["--given", "fx=0"][..],
        &["--freedoms", "4"],
        &["--freedoms", "3", "--given", "tz=1"],
    ] {
        let (status, _, err) = replayed(&[&[&*spindle, "-"], wrong].concat(), &input);
        assert!(status == 2 && err.starts_with("replay: --"), "{err}");
    }
}

/// A program that has written the beginning of an output, and waits for more of its recording.
#[cfg(unix)]
fn begun(out: &std::path::Path) -> std::process::Child {
    let before = parts(out);
    let mut running = Command::new(REPLAY)
        .args([&shipped("b7005c"), "-", "--balls", out.to_str().unwrap()])
        .stdin(Stdio::piped())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let text = format!("{HEADER}{ROWS}");
    running
        .stdin
        .as_mut()
        .unwrap()
        .write_all(text.as_bytes())
        .unwrap();
    let has_begun = (0..600).any(|_| {
        thread::sleep(std::time::Duration::from_millis(50));
        parts(out).iter().any(|part| !before.contains(part))
    });
    if !has_begun {
        running.kill().unwrap();
        running.wait().unwrap();
        panic!("no unfinished output in half a minute");
    }
    running
}

/// Unfinished outputs beside this path.
#[cfg(unix)]
fn parts(out: &std::path::Path) -> Vec<PathBuf> {
    let name = format!("{}.", out.file_name().unwrap().to_str().unwrap());
    let all = std::fs::read_dir(out.parent().unwrap()).unwrap();
    let all = all.map(|entry| entry.unwrap().path());
    let is_part = |path: &PathBuf| {
        let of = path.file_name().unwrap().to_string_lossy();
        of.starts_with(&name) && of.ends_with(".part")
    };
    all.filter(is_part).collect()
}

#[cfg(unix)]
#[test]
fn a_signal_leaves_no_unfinished_output() {
    use std::os::unix::process::ExitStatusExt;
    let out = scratch("signal.csv");
    for (name, number) in [("INT", 2), ("TERM", 15)] {
        let mut running = begun(&out);
        let kill = Command::new("kill")
            .args(["-s", name, &running.id().to_string()])
            .status();
        assert!(kill.unwrap().success());
        // `wait` would end its input, and it might be done before it hears of the signal.
        let input = running.stdin.take();
        let ended = running.wait().unwrap();
        drop(input);
        // It ends as it would without a handler, for a shell to see.
        assert_eq!(ended.signal(), Some(number), "{ended}");
        assert_eq!(parts(&out), Vec::<PathBuf>::new(), "{name}");
    }
    assert!(!out.exists());
}

#[cfg(unix)]
#[test]
fn a_run_removes_what_killed_ones_have_left_and_nothing_else() {
    let out = scratch("killed.csv");
    let mut killed = begun(&out);
    killed.kill().unwrap();
    killed.wait().unwrap();
    assert_eq!(parts(&out).len(), 1);
    let kept = out.with_file_name(format!(
        "{}.backup.part",
        out.file_name().unwrap().to_str().unwrap()
    ));
    std::fs::write(&kept, "mine").unwrap();
    // One that is written, a user's own, and that of the new run.
    let mut running = begun(&out);
    assert_eq!(parts(&out).len(), 2);
    let input = format!("{HEADER}{ROWS}");
    let args = [&*shipped("b7005c"), "-", "--balls", out.to_str().unwrap()];
    let (status, _, err) = replayed(&args, &input);
    assert_eq!(status, 0, "{err}");
    assert_eq!(parts(&out).len(), 2);
    drop(running.stdin.take());
    assert!(running.wait().unwrap().success());
    assert_eq!(parts(&out), std::slice::from_ref(&kept));
    for path in [out, kept] {
        std::fs::remove_file(path).unwrap();
    }
}

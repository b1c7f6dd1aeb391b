//! `cargo replay` of spindles: files, messages, and that the results are the solver's.

use crate::replay::{BALL_HEADER, replayed, scratch};
use host_tests::dispatch::{Attitude, Precision};
use host_tests::loads::{self, LoadRow};
use host_tests::spindle_file::SpindleFile;
use host_tests::spindles::{AnySpindleSolver, Balls, with_solver};
use host_tests::warm_up;
use spindle_bearing::ShaftEnd;

const SPINDLES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../spindles");

const LOADS: &str = "time_s,fx_n,fy_n,fz_n,my_nm,mz_nm,speed_rpm\n\
    0,0,0,0,0,0,0\n\
    1,50,300,-40,1,2,9000\n\
    2,nan,300,-40,1,2,9000\n\
    3,50,310,-40,1,2,9100\n";

fn shipped(name: &str) -> String {
    format!("{SPINDLES}/{name}.toml")
}

fn rows(csv: &str) -> Vec<LoadRow> {
    let input = std::io::Cursor::new(csv.as_bytes().to_vec());
    let loads = loads::Loads::from_reader("loads.csv", Box::new(input)).unwrap();
    loads.map(Result::unwrap).collect()
}

#[test]
fn results_hold_the_bits_that_the_solver_gave() {
    for (name, precision) in [("f32", Precision::F32), ("f64", Precision::F64)] {
        let design = shipped("7014c_back_to_back");
        let [of_rows, of_balls, frequencies] =
            ["rows", "balls", "frequencies"].map(|what| scratch(&format!("{name}-{what}.csv")));
        let args = [
            &design,
            "-",
            "--precision",
            name,
            "--rows",
            of_rows.to_str().unwrap(),
            "--balls",
            of_balls.to_str().unwrap(),
            "--frequencies",
            frequencies.to_str().unwrap(),
        ];
        let (status, out, err) = replayed(&args, LOADS);
        assert_eq!(status, 0);
        assert!(
            err.contains(
                "1 of 4 rows has no answer: 1 not-finite (the first at 2 s: axial load Fx"
            ),
            "{err}"
        );
        let [of_rows, of_balls, frequencies] = [of_rows, of_balls, frequencies].map(|path| {
            let text = std::fs::read_to_string(&path).unwrap();
            std::fs::remove_file(path).unwrap();
            text
        });
        let mut lines = out.lines().map(|line| line.split(',').collect::<Vec<_>>());
        let header = lines.next().unwrap();
        assert_eq!(header.len(), 8 + 25 + 25 + 1 + 6 + 2);
        assert_eq!(
            (header[8], header[33], header[58], header[66]),
            ("k_x_x", "k_nose_x_x", "limits", "l10_h")
        );
        let (mut of_rows, mut of_balls) = (of_rows.lines(), of_balls.lines());
        let mut frequencies = frequencies.lines();
        assert_eq!(
            frequencies.next(),
            Some("time_s,row,cage_hz,outer_race_hz,inner_race_hz,ball_hz")
        );
        let [rows_header, balls_header] =
            [&mut of_rows, &mut of_balls].map(|lines| lines.next().unwrap());
        assert_eq!(
            rows_header,
            "time_s,row,fx_n,fy_n,fz_n,my_nm,mz_nm,preload_n,least_q_i_n"
        );
        assert_eq!(balls_header, BALL_HEADER.replace("ball,", "row,ball,"));

        let file = SpindleFile::read(&design).unwrap();
        let end = file.nose.unwrap();
        assert_eq!(end, ShaftEnd::rigid(-0.06));
        let number = |text: &str| -> f64 {
            if precision == Precision::F32 {
                text.parse::<f32>().unwrap().into()
            } else {
                text.parse().unwrap()
            }
        };
        let check = |solver: &mut dyn AnySpindleSolver| {
            for row in rows(LOADS) {
                let line = lines.next().unwrap();
                let answer = solver.solve(&file.question(&row), &end);
                let Ok(answer) = answer else {
                    assert_eq!(line[1], "not-finite");
                    assert!(
                        line[2..59].iter().all(|field| field.is_empty())
                            && line.len() == header.len()
                    );
                    for _ in 0..2 {
                        assert!(of_rows.next().unwrap().ends_with(",,,,,,,"));
                    }
                    for _ in 0..40 {
                        assert!(of_balls.next().unwrap().ends_with(",,,,,,,"));
                    }
                    for i in 0..2 {
                        assert_eq!(frequencies.next().unwrap(), format!("2,{i},,,,"));
                    }
                    continue;
                };
                let figures = answer.displacement.into_iter();
                let figures = figures.chain(answer.stiffness.into_iter().flatten());
                let figures = figures.chain(answer.stiffness_at.into_iter().flatten());
                for (field, figure) in line[3..58].iter().zip(figures) {
                    assert_eq!(number(field), figure);
                }
                for (i, row) in answer.rows.iter().enumerate() {
                    let line: Vec<&str> = of_rows.next().unwrap().split(',').collect();
                    assert_eq!(line[1], i.to_string());
                    let least = row
                        .balls
                        .iter()
                        .map(|ball| ball.q_i)
                        .fold(f64::INFINITY, f64::min);
                    for (field, figure) in line[2..]
                        .iter()
                        .zip(row.force.into_iter().chain([row.preload, least]))
                    {
                        assert_eq!(number(field), figure);
                    }
                    for (j, ball) in row.balls.iter().enumerate() {
                        let line: Vec<&str> = of_balls.next().unwrap().split(',').collect();
                        assert_eq!((line[1], line[2]), (&*i.to_string(), &*j.to_string()));
                        assert_eq!(number(line[6]), ball.q_i);
                        let motion = &row.motions[j];
                        assert_eq!(number(line[10]), motion.inner.peak_pressure);
                        assert_eq!(number(line[19]), motion.outer.spin_to_roll);
                    }
                    let line: Vec<&str> = frequencies.next().unwrap().split(',').collect();
                    let found = &row.frequencies;
                    let found = [found.cage, found.outer_race, found.inner_race, found.ball];
                    assert_eq!(line[1], i.to_string());
                    assert_eq!([2, 3, 4, 5].map(|i| number(line[i])), found);
                }
            }
            assert_eq!(
                (lines.next(), of_rows.next(), of_balls.next()),
                (None, None, None)
            );
        };
        with_solver(
            &file.plan,
            Balls::Moving(Attitude::Raceless),
            precision,
            check,
        )
        .unwrap();
    }
}

/// Bearings and balls of every shipped spindle carry through the whole recording of a spindle that warms up.
#[test]
fn shipped_spindles_are_solved_while_they_warm_up() {
    let cold: String = std::fs::read_to_string(warm_up::RECORD)
        .unwrap()
        .lines()
        .map(|line| line.splitn(8, ',').take(7).collect::<Vec<_>>().join(",") + "\n")
        .collect();
    for entry in std::fs::read_dir(SPINDLES).unwrap() {
        let path = entry.unwrap().path();
        let file = SpindleFile::read(&path).unwrap();
        let path = path.to_str().unwrap();
        for precision in ["f32", "f64"] {
            let (status, out, err) = if file.heat.is_some() {
                replayed(&[path, warm_up::RECORD, "--precision", precision], "")
            } else {
                replayed(&[path, "-", "--precision", precision], &cold)
            };
            assert_eq!((status, &*err), (0, ""), "{path}");
            assert_eq!(out.lines().count(), 1801);
            assert!(!out.contains("lift-off"), "{path}");
        }
    }
}

#[test]
fn what_is_wrong_with_a_spindle_file_is_said_with_its_place() {
    let good = std::fs::read_to_string(shipped("7014c_back_to_back")).unwrap();
    let path = scratch("spindle.toml");
    let bearings = format!("{SPINDLES}/../bearings");
    let complaint = |text: String, args: &[&str]| {
        std::fs::write(&path, text.replace("../bearings", &bearings)).unwrap();
        let mut all = vec![path.to_str().unwrap(), "-"];
        all.extend(args);
        let (status, out, err) = replayed(&all, LOADS);
        assert_eq!((status, &*out), (2, ""), "{err}");
        err
    };
    let changed = |from: &str, to: &str| {
        assert!(good.contains(from), "{from}");
        complaint(good.replacen(from, to, 1), &[])
    };
    for (from, to, wanted) in [
        (
            "facing = \"+x\"",
            "facing = \"x\"",
            "line 10, column 10: \"x\" is none of \"+x\", \"-x\"",
        ),
        (
            "facing = \"+x\"",
            "",
            "line 7, column 1: this row lacks `facing`; add a line such as `facing = \"+x\"`",
        ),
        (
            "facing = \"+x\"",
            "facing = \"-x\"",
            "row 1 faces -x, which is not back-to-back",
        ),
        (
            "position_mm = 27",
            "position_mm = 0",
            "row 1: another row is 0e0 m away",
        ),
        ("position_mm = 27", "", "this row lacks `position_mm`"),
        (
            "arrangement = \"back-to-back\"",
            "arrangement = \"DB\"",
            "line 4, column 15: \"DB\" is none of \"back-to-back\"",
        ),
        (
            "name = \"7014C back to back\"",
            "",
            "the key `name` is missing",
        ),
        (
            "bearing = \"../bearings/7014c.toml\"",
            "bearing = \"none.toml\"",
            "line 8, column 11: ",
        ),
        (
            "bearing = \"../bearings/7014c.toml\"",
            "",
            "this row lacks `bearing`",
        ),
        (
            "facing = \"+x\"",
            "facing = \"+x\"\npreload_offset_um = 3",
            "`preload_n` above preloads all clamped rows",
        ),
        (
            "facing = \"+x\"",
            "facing = \"+x\"\nspring = true",
            "row 0 slides, but there is no spring",
        ),
        (
            "facing = \"+x\"",
            "facing = \"+x\"\nprelaod = 3",
            "unknown field `prelaod`",
        ),
        (
            "preload_n = 294",
            "preload_n = -1",
            "row 0 is preloaded by -1 N: give a positive force",
        ),
        ("position_mm = -60", "", "[nose] lacks `position_mm`"),
        (
            "[nose]",
            "[heat]\nreference_c = 20\n[nose]",
            "the columns t_inner_c and t_outer_c are missing, which [heat] needs",
        ),
    ] {
        let found = changed(from, to);
        assert!(found.contains(wanted), "{found}\nwithout: {wanted}");
    }
    assert!(
        complaint("row = []\nname = \"none\"".to_owned(), &[])
            .contains("0 rows: a spindle has 1 to 8 here")
    );
    std::fs::remove_file(&path).unwrap();

    let (status, _, err) = replayed(
        &[&format!("{bearings}/7014c.toml"), "-", "--rows", "rows.csv"],
        LOADS,
    );
    assert_eq!(status, 2);
    assert!(err.contains("--rows is for spindles"), "{err}");
    let warm = LOADS
        .replace("speed_rpm", "speed_rpm,t_inner_c,t_outer_c")
        .replace("000\n", "000,30,25\n");
    let (status, _, err) = replayed(&[&shipped("7014c_qbc"), "-"], &warm);
    assert_eq!(status, 2);
    assert!(
        err.contains("are for spindles with [heat]: add that to the spindle with reference_c"),
        "{err}"
    );
    let half = LOADS.replace("speed_rpm", "speed_rpm,t_inner_c");
    let (_, _, err) = replayed(&[&shipped("7014c_qbc"), "-"], &half);
    assert!(
        err.contains("line 1, column 9 (t_outer_c): the header lacks this column"),
        "{err}"
    );
}

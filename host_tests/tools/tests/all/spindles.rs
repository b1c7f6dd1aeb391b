//! `cargo replay` of spindles: files, messages, and that the results are the solver's.

use crate::replay::{BALL_HEADER, numbers, parsed, replayed, scratch, table, with_files};
use host_tests::dispatch::{Attitude, Precision};
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

#[test]
fn results_hold_the_bits_that_the_solver_gave() {
    for (name, precision) in [("f32", Precision::F32), ("f64", Precision::F64)] {
        let design = shipped("7014c_back_to_back");
        let args = [&design, "-", "--precision", name];
        let options = ["--rows", "--balls", "--frequencies"];
        let (out, err, files) = with_files(&args, options, LOADS);
        let said = "1 of 4 rows has no answer: 1 not-finite (the first at 2 s: axial load Fx";
        assert!(err.contains(said), "{err}");
        let header = out.lines().next().unwrap();
        let columns: Vec<_> = header.split(',').collect();
        assert_eq!(columns.len(), 8 + 25 + 25 + 1 + 6 + 2);
        assert_eq!(
            [8, 33, 58, 66].map(|i| columns[i]),
            ["k_x_x", "k_nose_x_x", "limits", "l10_h"]
        );
        let mut lines = table(&out, header).into_iter();
        let headers = [
            "time_s,row,fx_n,fy_n,fz_n,my_nm,mz_nm,preload_n,least_q_i_n",
            &BALL_HEADER.replace("ball,", "row,ball,"),
            "time_s,row,cage_hz,outer_race_hz,inner_race_hz,ball_hz",
        ];
        let mut files = [0, 1, 2].map(|i| table(&files[i], headers[i]).into_iter());
        let [of_rows, of_balls, frequencies] = &mut files;

        let file = SpindleFile::read(&design).unwrap();
        let end = file.nose.unwrap();
        assert_eq!(end, ShaftEnd::rigid(-0.06));
        let check = |solver: &mut dyn AnySpindleSolver| {
            for row in parsed(LOADS) {
                let line = lines.next().unwrap();
                let Ok(answer) = solver.solve(&file.question(&row), &end) else {
                    assert_eq!(line[1], "not-finite");
                    assert!(line[2..59].concat().is_empty());
                    let rows = of_rows.take(2).map(|line| line[2..].concat());
                    let balls = of_balls.take(40).map(|line| line[3..].concat());
                    assert!(rows.chain(balls).all(|figures| figures.is_empty()));
                    let frequencies: Vec<_> = frequencies.take(2).collect();
                    let empty = |row| ["2", row, "", "", "", ""];
                    assert_eq!(frequencies, [empty("0"), empty("1")]);
                    continue;
                };
                let stiffness = answer.stiffness.as_flattened();
                let at_nose = answer.stiffness_at.as_flattened();
                let figures = [&answer.displacement, stiffness, at_nose].concat();
                assert_eq!(numbers(&line[3..58], precision), figures);
                for (i, row) in answer.rows.iter().enumerate() {
                    let line = of_rows.next().unwrap();
                    assert_eq!(line[1], i.to_string());
                    let forces = row.balls.iter().map(|ball| ball.q_i);
                    let least = forces.fold(f64::INFINITY, f64::min);
                    let carried = [&row.force[..], &[row.preload, least]].concat();
                    assert_eq!(numbers(&line[2..], precision), carried);
                    for (j, ball) in row.balls.iter().enumerate() {
                        let line = of_balls.next().unwrap();
                        assert_eq!(line[1..3], [i.to_string(), j.to_string()]);
                        let motion = &row.motions[j];
                        assert_eq!(
                            numbers(&[line[6], line[10], line[19]], precision),
                            [
                                ball.q_i,
                                motion.inner.peak_pressure,
                                motion.outer.spin_to_roll
                            ]
                        );
                    }
                    let line = frequencies.next().unwrap();
                    let found = &row.frequencies;
                    let found = [found.cage, found.outer_race, found.inner_race, found.ball];
                    assert_eq!(line[1], i.to_string());
                    assert_eq!(numbers(&line[2..], precision), found);
                }
            }
        };
        let balls = Balls::Moving(Attitude::Raceless);
        with_solver(&file.plan, balls, precision, check).unwrap();
        assert_eq!(lines.next(), None);
        assert!(files.iter_mut().all(|file| file.next().is_none()));
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
    let changed = |from: &str, to: &str, wanted: &str| {
        assert!(good.contains(from), "{from}");
        let found = complaint(good.replacen(from, to, 1), &[]);
        assert!(found.contains(wanted), "{found}\nwithout: {wanted}");
    };
    let facing = r#"facing = "+x""#;
    let added = |line: &str| format!("{facing}\n{line}");
    let place = r#"line 10, column 10: "x" is none of "+x", "-x""#;
    changed(facing, r#"facing = "x""#, place);
    let place = r#"line 7, column 1: this row lacks `facing`; add a line such as `facing = "+x"`"#;
    changed(facing, "", place);
    let reason = "row 1 faces -x, which is not back-to-back";
    changed(facing, r#"facing = "-x""#, reason);
    let reason = "`preload_n` above preloads all clamped rows";
    changed(facing, &added("preload_offset_um = 3"), reason);
    let reason = "row 0 slides, but there is no spring";
    changed(facing, &added("spring = true"), reason);
    changed(facing, &added("prelaod = 3"), "unknown field `prelaod`");
    let position = "position_mm = 27";
    changed(
        position,
        "position_mm = 0",
        "row 1: another row is 0e0 m away",
    );
    changed(position, "", "this row lacks `position_mm`");
    changed("position_mm = -60", "", "[nose] lacks `position_mm`");
    let place = r#"line 4, column 15: "DB" is none of "back-to-back""#;
    changed(r#"= "back-to-back""#, r#"= "DB""#, place);
    let name = r#"name = "7014C back to back""#;
    changed(name, "", "the key `name` is missing");
    let bearing = r#"bearing = "../bearings/7014c.toml""#;
    changed(bearing, r#"bearing = "none.toml""#, "line 8, column 11: ");
    changed(bearing, "", "this row lacks `bearing`");
    let reason = "row 0 is preloaded by -1 N: give a positive force";
    changed("preload_n = 294", "preload_n = -1", reason);
    let reason = "the columns t_inner_c and t_outer_c are missing, which [heat] needs";
    changed("[nose]", "[heat]\nreference_c = 20\n[nose]", reason);
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

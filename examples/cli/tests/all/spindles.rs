//! `cargo replay` of spindles: files and messages.

use crate::replay::{replayed, scratch};
use cli::warm_up;
use spindle_file::spindles::SpindleFile;

const SPINDLES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../spindle_file/spindles");

const LOADS: &str = "time_s,fx_n,fy_n,fz_n,my_nm,mz_nm,speed_rpm\n\
    0,0,0,0,0,0,0\n\
    1,50,300,-40,1,2,9000\n\
    2,nan,300,-40,1,2,9000\n\
    3,50,310,-40,1,2,9100\n";

fn shipped(name: &str) -> String {
    format!("{SPINDLES}/{name}.toml")
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
            assert!(
                status == 0 && err.contains("rows read 1800, refused 0"),
                "{path}: {err}"
            );
            assert_eq!(out.lines().count(), 1801);
            assert!(!out.contains("lift-off"), "{path}");
        }
    }
}

#[test]
fn recordings_and_options_that_do_not_fit_a_spindle_are_told() {
    let good = std::fs::read_to_string(shipped("7014c_back_to_back")).unwrap();
    let path = scratch("spindle.toml");
    let bearings = format!("{SPINDLES}/../bearings");
    let complaint = |text: String| {
        std::fs::write(&path, text.replace("../bearings", &bearings)).unwrap();
        let (status, out, err) = replayed(&[path.to_str().unwrap(), "-"], LOADS);
        assert_eq!((status, &*out), (2, ""), "{err}");
        err
    };
    let found = complaint(good.replace("[nose]", "[heat]\nreference_c = 20\n[nose]"));
    let reason = "there is no t_inner_c, t_outer_c\n";
    assert!(found.contains(reason), "{found}");
    assert!(
        complaint("row = []\nname = \"none\"".to_owned())
            .contains("0 rows: a spindle has 1 to 8 here")
    );
    std::fs::remove_file(&path).unwrap();

    let (status, _, err) = replayed(
        &[&format!("{bearings}/7014c.toml"), "-", "--rows", "rows.csv"],
        LOADS,
    );
    assert_eq!(status, 2);
    assert!(err.contains("--rows is for spindles"), "{err}");
    let (_, _, err) = replayed(
        &[&format!("{bearings}/7014c.toml"), "-", "--nose", "nose.csv"],
        LOADS,
    );
    assert!(err.contains("has no [nose]; add one"), "{err}");
    for option in [["--given", "tz=0"], ["--freedoms", "3"]] {
        let elastic = shipped("elastic_spindle");
        let (status, _, err) = replayed(&[&elastic, "-", option[0], option[1]], LOADS);
        assert_eq!(status, 2);
        assert!(err.contains("hold an elastic shaft at x = 0"), "{err}");
    }
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
    assert!(err.contains("are for spindles with [heat]"), "{err}");
    let warm = [&shipped("7014c_qbc"), "--sensitivity", "--t_inner", "30"];
    let (_, _, err) = replayed(&warm, "");
    assert!(
        err.contains("--t_inner is for spindles with [heat]"),
        "{err}"
    );
}

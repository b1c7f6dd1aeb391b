//! `cargo replay` of spindles: files and messages.

use crate::replay::{replayed, scratch};
use files::spindles::SpindleFile;
use host_tests::warm_up;

const SPINDLES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../spindles");

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
    let reason = "line 7, column 21: the preload is `preload_n`, as ground, or `mounted_preload_n`";
    changed("[[row]]", "mounted_preload_n = 9\n[[row]]", reason);
    let mounted = |row: &str| format!("mounted_preload_n = 9\n[[row]]\n{row}");
    let alone = |row: &str| {
        good.replace("preload_n = 294\n", "")
            .replacen("[[row]]\n", &mounted(row), 1)
    };
    let reason = "`mounted_preload_n` finds the closure of all rows";
    for row in ["preload_offset_um = 3\n", "spring = true\n"] {
        let found = complaint(alone(row), &[]);
        assert!(found.contains(reason), "{found}");
    }
    let far = alone("").replace("= 9", "= 1e9");
    let found = complaint(far, &[]);
    assert!(
        found.contains("row 0: preload force of the pair"),
        "{found}"
    );
    let reason = "row 0 slides, but there is no spring";
    changed(facing, &added("spring = true"), reason);
    changed(facing, &added("prelaod = 3"), "unknown field `prelaod`");
    let position = "position_mm = 27";
    changed(
        position,
        "position_mm = 0",
        "line 14, column 15: row 1: another row is 0 mm away",
    );
    changed(position, "", "this row lacks `position_mm`");
    changed("position_mm = -60", "", "[nose] lacks `position_mm`");
    let reason = "expected `position_mm`, `radial_um_per_kn`, `axial_um_per_kn`, or a nose by name";
    changed("position_mm = -60", "positon_mm = -60", reason);
    let place = r#"line 4, column 15: "DB" is none of "back-to-back""#;
    changed(r#"= "back-to-back""#, r#"= "DB""#, place);
    let name = r#"name = "7014C back to back""#;
    changed(name, "", "the key `name` is missing");
    let bearing = r#"bearing = "../bearings/7014c.toml""#;
    changed(bearing, r#"bearing = "none.toml""#, "line 8, column 11: ");
    changed(bearing, "", "this row lacks `bearing`");
    let reason = "row 0: preload force of the pair (N) is -1, but must be above 0";
    changed("preload_n = 294", "preload_n = -1", reason);
    let reason = "no column t_inner_c: add it, or give --t_inner; no column t_outer_c: add it";
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
    let (_, _, err) = replayed(&[&shipped("7014c_qbc"), "-", "--t_inner", "30"], LOADS);
    assert!(
        err.contains("--t_inner is for spindles with [heat]"),
        "{err}"
    );
}

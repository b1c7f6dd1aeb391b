//! `cargo plot`: what is drawn of a file, and what is said of one that cannot be drawn.

use crate::malformed::HEADER;
use crate::replay::{ran, replayed, scratch};
use cli::random::Random;
use spindle_file::designs::SHIPPED;

/// Exit status, standard output and standard error of `cargo plot` with these arguments.
fn plotted(args: &[&str], stdin: &[u8]) -> (i32, String, String) {
    ran(env!("CARGO_BIN_EXE_plot"), args, stdin)
}

fn drawn(args: &[&str], csv: &str) -> String {
    let (status, svg, err) = plotted(&[&["-"], args].concat(), csv.as_bytes());
    assert_eq!((status, &*err), (0, ""));
    assert!(svg.starts_with("<svg ") && svg.ends_with("</svg>\n"));
    assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
    svg
}

fn bearing() -> String {
    format!("{SHIPPED}/b7005c.toml")
}

fn results(rows: &str) -> String {
    replayed(&[&bearing(), "-"], &format!("{HEADER}{rows}")).1
}

fn count(svg: &str, what: &str) -> usize {
    svg.matches(what).count()
}

fn table(axes: &[&str]) -> String {
    replayed(&[&[&*bearing(), "--table"], axes].concat(), "").1
}

#[test]
fn results_are_drawn_over_time_and_broken_where_there_is_no_answer() {
    let rows = |missing: u32| -> String {
        let load = |t| if t == missing { "nan" } else { "400" };
        let rows = (0..8).map(|t| format!("{t},{},{},0,0,0,{}\n", load(t), 10 * t, 1000 * t));
        rows.collect()
    };
    let whole = drawn(&["--title", "a < b & c"], &results(&rows(9)));
    for text in [
        "a &lt; b &amp; c",
        "Shaft speed",
        "Tilt stiffness",
        "\nradial\n",
        "time / s",
    ] {
        assert!(whole.contains(text), "{text} is missing in\n{whole}");
    }
    let broken = drawn(&[], &results(&rows(4)));
    // Five curves of stiffness, and one of the load, in two parts each.
    let curves = |svg| count(svg, "stroke-width=\"6\" points");
    assert_eq!(curves(&broken), curves(&whole) + 5 + 1, "{broken}");
}

#[test]
fn a_long_recording_is_drawn_in_bands() {
    let rows = (0..4000).map(|i| format!("{i}e-3,{},0,0,0,0,9000\n", 400 + i % 7));
    let svg = drawn(&[], &results(&rows.collect::<String>()));
    assert!(svg.contains("lines: means of 34 rows; bands: least to largest"));
    // Of each curve, and of the four names in the legend.
    assert_eq!(count(&svg, "<polygon opacity=\"0.25\""), 8 + 4, "{svg}");
    assert!(svg.len() < 50_000, "{}", svg.len());
}

#[test]
fn tables_are_drawn_over_speed_with_a_curve_for_each_load() {
    let few = table(&["speed=0:9000:1000", "fx=500", "fy=0:200:100", "mz=1"]);
    let svg = drawn(&["--over", "speed"], &few);
    for text in [
        "Fx = 500 N, Mz = 1 N m",
        "\nFy = 0 N\n",
        "\nFy = 100 N\n",
        "\nFy = 200 N\n",
        "K_ty,ty",
    ] {
        assert!(svg.contains(text), "{text} is missing in\n{svg}");
    }
    // Of more loads, every row is a dot.
    let many = table(&["speed=0:9000:1000", "fx=500", "fy=0:200:10"]);
    let svg = drawn(&["--over", "speed"], &many);
    assert_eq!(count(&svg, "<circle"), 5 * 210 + 1);
    assert!(svg.contains("\none row of 1\n"));
}

#[test]
fn tables_are_drawn_over_a_temperature() {
    let spindle = format!("{SHIPPED}/../spindles/milling_spindle.toml");
    let axes = ["speed=3000", "t_inner=20:40:10", "t_outer=20:30:10"];
    let (_, table, _) = replayed(&[&[&*spindle, "--table"], &axes[..]].concat(), "");
    let svg = drawn(&["--over", "t_inner"], &table);
    for text in [
        "inner temperature",
        "n = 3000 rpm",
        "To = 20 °C",
        "To = 30 °C",
    ] {
        assert!(svg.contains(text), "{text} is missing in\n{svg}");
    }
    let without = results("0,400,0,0,0,0,9000\n1,500,0,0,0,0,9000\n");
    refused(
        &["--over", "t_outer"],
        &without,
        "there is no outer temperature in the file",
    );
}

#[test]
fn results_of_an_elastic_spindle_are_drawn() {
    let spindle = format!("{SHIPPED}/../spindles/elastic_spindle.toml");
    let (_, table, _) = replayed(&[&spindle, "--table", "speed=0:9000:3000", "fy=500"], "");
    for nose in [&["--over", "speed"][..], &["--over", "speed", "--nose"]] {
        assert!(drawn(nose, &table).contains("Fy = 500 N"));
    }
}

const RESPONSE: &str = "time_s,state,preload_n,preload_error_n,change_percent,change_error_percent,steps,\
    gain_axial,gain_error_axial,state_axial,gain_nose,gain_error_nose,state_nose\n";

/// Half learning, then as it should be, then with less preload.
fn measured(lines: usize, of_preload: impl Fn(usize) -> String) -> String {
    let line = |i: usize| {
        let state = match 3 * i / lines {
            0 => "learning",
            1 => "ok",
            _ => "preload-loss",
        };
        let (time, preload) = (i + 1, of_preload(i));
        format!("{time},{state},{preload},,,{i},1.1,0.02,ok,0.95,0.01,probe\n")
    };
    RESPONSE.to_owned() + &(0..lines).map(line).collect::<String>()
}

#[test]
fn preload_gains_and_states_are_drawn_over_time() {
    let preload = |i: usize| format!("{},5", if i < 20 { 250 } else { 200 });
    let svg = drawn(&[], &measured(30, preload));
    for text in [
        "Preload / N",
        "Gain: measured over computed motion",
        "\nspindle\n",
        "\naxial\n",
        "\nnose\n",
        "\nlearning\n",
        "\nok\n",
        "\npreload-loss\n",
        "\nprobe\n",
        "time / s",
    ] {
        assert!(svg.contains(text), "{text} is missing in\n{svg}");
    }
    // States that have not been have no place.
    assert!(!svg.contains("stiffness-loss") && !svg.contains("unknown"));
    // Of preload and of both gains, and in the legend.
    assert_eq!(count(&svg, "<polygon opacity=\"0.25\""), 3 + 3, "{svg}");
    let gains = drawn(&[], &measured(30, |_| ",".into()));
    assert!(!gains.contains("Preload /") && gains.contains("\naxial\n"));
    assert_eq!(count(&gains, "<polygon opacity=\"0.25\""), 2 + 2, "{gains}");
}

/// A state that lasts for a line is seen in a picture of ten hours.
#[test]
fn a_long_response_has_its_worst_state() {
    let text = measured(36_000, |_| "250,5".into());
    let text = text.replace("\n18000,ok,", "\n18000,stiffness-gain,");
    let svg = drawn(&[], &text);
    assert!(svg.contains("\nstiffness-gain\n"));
    assert!(svg.len() < 100_000, "{}", svg.len());
}

#[test]
fn balls_are_drawn_at_the_time_of_the_largest_force_or_the_one_that_is_wanted() {
    let path = scratch("plot-balls.csv");
    let rows = "0,400,0,0,0,0,0\n1,400,900,0,0,0,0\n2,nan,0,0,0,0,0\n3,400,0,100,0,0,0\n";
    let args = [&bearing(), "-", "--balls", path.to_str().unwrap()];
    let (status, ..) = replayed(&args, &format!("{HEADER}{rows}"));
    assert_eq!(status, 0);
    let balls = std::fs::read_to_string(&path).unwrap();
    std::fs::remove_file(path).unwrap();
    let largest = drawn(&[], &balls);
    assert!(largest.contains("contact forces at 1 s") && largest.contains("\nouter race\n"));
    // A time whose row has no answer is no time to draw.
    for (wanted, found) in [("-5", "0"), ("1.9", "1"), ("2.2", "3"), ("99", "3")] {
        let svg = drawn(&["--time", wanted], &balls);
        assert!(svg.contains(&format!("at {found} s")), "{wanted}");
    }
}

/// Standard input is refused with this message.
fn refused(args: &[&str], csv: &str, wanted: &str) {
    let (status, out, err) = plotted(&[&["-"], args].concat(), csv.as_bytes());
    assert_eq!((status, &*out), (2, ""), "{err}");
    assert!(err.starts_with("plot: standard input: "), "{err}");
    assert!(err.contains(wanted), "{err}\nnot\n{wanted}");
}

#[test]
fn what_cannot_be_drawn_is_said_with_its_place() {
    let none = "line 1: there is no column k_x_x as in the results";
    refused(&[], "", none);
    refused(&[], HEADER, none);
    let good = results("0,400,0,0,0,0,0\n1,400,0,0,0,0,0\n");
    for column in ["k_z_z", "time_s", "speed_rpm"] {
        let missing = format!("line 1: the column {column} is missing");
        refused(&[], &good.replace(column, "other"), &missing);
    }
    refused(&["--nose"], &good, "the column k_nose_x_x is missing");
    let speed = ["--over", "speed"];
    refused(
        &speed,
        &good,
        "fewer than two values of the shaft speed have an answer",
    );
    refused(&["--time", "3"], &good, "--time is for a file of balls");
    let words = good.replace("\n1,", "\none,");
    refused(&[], &words, "line 3 (time_s): \"one\" is not a number");
    let unsolved = results("0,400,0,0,0,0,0\n1,nan,0,0,0,0,0\n");
    refused(&[], &unsolved, "fewer than two rows have an answer");
    let at_once = results("5,400,0,0,0,0,0\n5,400,0,0,0,0,0\n");
    refused(&[], &at_once, "all rows have the time 5 s");
    let balls = "time_s,azimuth_rad,q_i_n,q_o_n\n0,0,1,1\n";
    refused(&speed, balls, "--over and --nose are for results");
    let empty = balls.replace("0,0,1,1", ",,,");
    refused(&[], &empty, "no ball has forces, nothing to draw");
    let idle = balls.replace("1,1", "0,0");
    refused(&[], &idle, "no ball carries a force at 0 s");
    let lines = measured(1, |_| "250,5".into());
    refused(
        &[],
        &lines,
        "there are fewer than two lines, nothing to draw",
    );
    let without = measured(3, |_| "250,5".into()).replace("gain_axial", "gain");
    refused(&[], &without, "the column gain_axial is missing");
    let nameless = balls.replace("q_o_n", "q");
    refused(&[], &nameless, "the column q_o_n is missing");

    let (status, _, err) = plotted(&["nowhere.csv"], b"");
    assert_eq!(status, 2);
    let start = "plot: nowhere.csv: cannot be read: ";
    assert!(err.starts_with(start), "{err}");
    let path = scratch("plot.csv");
    std::fs::write(&path, &good).unwrap();
    let name = path.to_str().unwrap();
    let (status, _, err) = plotted(&[name, "-o", name], b"");
    assert_eq!(status, 1);
    assert!(err.contains("the file itself"), "{err}");
    let (status, _, err) = plotted(&[name, "-o", "picture.txt"], b"");
    assert_eq!(status, 1);
    assert!(err.contains("pictures are .svg"), "{err}");
    let table = path.with_extension("table.svg");
    std::fs::write(&table, &good).unwrap();
    let (status, ..) = plotted(&[table.to_str().unwrap()], b"");
    assert_eq!(
        (status, &*std::fs::read_to_string(&table).unwrap()),
        (1, &*good)
    );
    std::fs::remove_file(table).unwrap();
    // Beside the file, if nothing else is said.
    assert_eq!(plotted(&[name], b""), (0, String::new(), String::new()));
    let picture = path.with_extension("svg");
    assert!(
        std::fs::read_to_string(&picture)
            .unwrap()
            .ends_with("</svg>\n")
    );
    std::fs::remove_file(picture).unwrap();
    std::fs::remove_file(path).unwrap();
}

/// Whatever stands in the fields, and however many there are, ends in a picture or in a message.
#[test]
fn any_file_is_drawn_or_refused() {
    let results = results("");
    let balls = "time_s,row,azimuth_rad,q_i_n,q_o_n";
    let headers = [results.trim_end(), balls, RESPONSE.trim_end()];
    let pieces = [
        "0", "1", "-1", "1e308", "-1e308", "1e-320", "nan", "inf", "", "7", "1e15", "3.3", "400",
        "\"", "x\n", "\u{e9}",
    ];
    let mut random = Random::seeded(1);
    let mut drawn = 0;
    for seed in 0..900 {
        let header = headers[seed % 3];
        let columns = header.split(',').count();
        // The stranger pieces in every third file only.
        let kinds = if seed % 4 == 0 { 16 } else { 13 };
        let mut text = format!("{header}\n");
        for _ in 0..12 {
            let fields: Vec<_> = (0..columns).map(|_| pieces[random.below(kinds)]).collect();
            text += &(fields.join(",") + "\n");
        }
        if seed % 5 == 0 {
            text = text.chars().take(text.len() / 2).collect();
        }
        for args in [&["-"][..], &["-", "--over", "speed"], &["-", "--time", "1"]] {
            let (status, out, err) = plotted(args, text.as_bytes());
            assert!(matches!(
                (status, out.is_empty(), err.is_empty()),
                (0, false, true) | (2, true, false)
            ));
            drawn += usize::from(status == 0);
            assert!(!out.contains("NaN"), "{text}\n{out}");
        }
    }
    assert!(drawn > 0, "{drawn}");
}

/// Of every shipped spindle: balls and contact lines above and below the axis, sections, springs, and each row in words.
#[test]
fn a_spindle_is_drawn_in_section() {
    const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");
    for (path, rows, sections, sprung) in [
        ("examples/firmware/spindle.toml", 2, 2, 0),
        ("examples/spindle_file/spindles/7014c_qbc.toml", 4, 0, 0),
        (
            "examples/spindle_file/spindles/elastic_spindle.toml",
            4,
            3,
            0,
        ),
        (
            "examples/spindle_file/spindles/milling_spindle.toml",
            4,
            0,
            2,
        ),
        ("examples/spindle_file/bearings/b7005c.toml", 1, 0, 0),
    ] {
        let path = format!("{ROOT}/{path}");
        let (status, svg, err) = plotted(&[&path, "-o", "-"], b"");
        assert_eq!((status, &*err), (0, ""), "{path}");
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
        let class = |name: &str| count(&svg, &format!("class=\"{name}\""));
        assert_eq!([class("ball"), class("contact")], [2 * rows; 2], "{path}");
        assert_eq!(class("shaft"), 2 * sections, "{path}");
        assert_eq!(class("spring"), 6 * sprung, "{path}");
        assert_eq!(count(&svg, ">row "), rows, "{path}");
    }
    let path = format!("{ROOT}/examples/firmware/spindle.toml");
    let (_, svg, _) = plotted(&[&path, "-o", "-"], b"");
    let docs = std::fs::read_to_string(format!("{ROOT}/docs/spindle.svg")).unwrap();
    assert_eq!(
        svg, docs,
        "cargo plot examples/firmware/spindle.toml -o docs/spindle.svg"
    );
    // Back to back: contact lines lean apart towards the axis.
    let lean = |line: &str| {
        let points = line.split_once("points=\"").unwrap().1.split(['"', ' ']);
        let x: Vec<f64> = points
            .take(2)
            .map(|point| point.split(',').next().unwrap().parse().unwrap())
            .collect();
        x[1] - x[0]
    };
    let leans: Vec<f64> = svg
        .lines()
        .filter(|line| line.contains("\"contact\""))
        .map(lean)
        .collect();
    assert!(leans[0] > 0.0 && leans[2] < 0.0, "{leans:?}");
    let (status, _, err) = plotted(&[&path, "--over", "speed"], b"");
    assert_eq!(status, 2);
    assert!(err.contains("are for tables"), "{err}");
}

/// Probes, diameters of sections, and the part of a mounted preload that each row has.
#[test]
fn probes_diameters_and_preloads_are_drawn() {
    let (status, svg, err) = plotted(
        &[&format!("{SHIPPED}/../spindles/five_rows.toml"), "-o", "-"],
        b"",
    );
    assert_eq!((status, &*err), (0, ""));
    assert_eq!(count(&svg, "class=\"probe\""), 2);
    for words in [
        ">Ø90/30<",
        ">Ø70/30<",
        ">probe axial: x = -60 mm, along x<",
        ">probe nose: x = -60 mm, 0° from +y towards +z<",
        ">sections, mm: -60 to -15 Ø90/30; -15 to 330 Ø70/30<",
    ] {
        assert_eq!(count(&svg, words), 1, "{words}");
    }
    let path = format!("{SHIPPED}/../spindles/elastic_spindle.toml");
    let text = std::fs::read_to_string(path).unwrap();
    let text = text.replace("../bearings/7014c.toml", "project:7014c");
    let path = scratch("mounted.toml");
    std::fs::write(
        &path,
        text.replace("preload_n = 400", "mounted_preload_n = 350"),
    )
    .unwrap();
    let (status, svg, err) = plotted(&[path.to_str().unwrap(), "-o", "-"], b"");
    std::fs::remove_file(&path).unwrap();
    assert_eq!((status, &*err), (0, ""));
    let parts = svg.lines().filter_map(|line| {
        let (before, _) = line.split_once(" N of the mounted preload")?;
        before.rsplit(' ').next()?.parse::<f64>().ok()
    });
    let parts: Vec<f64> = parts.collect();
    // Two rows to each side, which are alike.
    assert_eq!(parts.len(), 4, "{svg}");
    for side in parts.chunks(2) {
        assert!((side[0] + side[1] - 350.0).abs() <= 1.0, "{parts:?}");
        assert!((side[0] - 175.0).abs() < 10.0, "{parts:?}");
    }
}

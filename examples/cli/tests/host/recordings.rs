//! From a recording to results: formats of files, what is refused and how, and that nothing is lost between the
//! solver and the table.

use cli::fault::LoadsError;
use cli::random::Random;
use cli::recordings::{Loads, Wanted};
use cli::replay::{Job, Output, Summary, Table, replay};
use solvers::dispatch::Precision;
use solvers::{AnySolver, Balls, Choices, with_solver};
use spindle_file::designs::{DesignFile, SHIPPED};
use spindle_file::loads::LoadRow;
use spindle_file::spindles::SpindleFile;
use std::io::Cursor;

const HEADER: &str = "time_s,fx_n,fy_n,fz_n,my_nm,mz_nm,speed_rpm\n";

fn shipped(name: &str) -> String {
    format!("{SHIPPED}/{name}.toml")
}

fn opened(csv: &[u8], wanted: &Wanted) -> Result<Loads, LoadsError> {
    Loads::from_reader("x", Box::new(Cursor::new(csv.to_vec())), wanted)
}

fn parsed_bytes(csv: &[u8]) -> Result<Vec<LoadRow>, LoadsError> {
    opened(csv, &Wanted::default())?.collect()
}

fn parsed(csv: &str) -> Result<Vec<LoadRow>, LoadsError> {
    parsed_bytes(csv.as_bytes())
}

#[test]
fn what_can_be_read_of_a_refused_row_is_kept() {
    let numbers = |row: &str| match parsed(&format!("{HEADER}1,2,3,4,5,6,7\n{row}\n")) {
        Err(LoadsError::Row(row)) => row.numbers,
        other => panic!("{other:?}"),
    };
    let [a, b] = [Some(1.0), Some(7.0)];
    assert_eq!(
        numbers("1,,three,4,5,6,7"),
        [
            a,
            None,
            None,
            Some(4.0),
            Some(5.0),
            Some(6.0),
            b,
            None,
            None
        ]
    );
    // Which column a number belongs to is not known in a row with a field too many or too few.
    assert_eq!(numbers("1,5,2,3,4,5,6,7"), [None; 9]);
    assert_eq!(numbers("1,,3"), [None; 9]);
}

#[test]
fn recordings_are_read() {
    let row = |time_s, load, speed_rpm| LoadRow {
        time_s,
        load,
        speed_rpm,
        temperatures: None,
        probes: [None; 4],
    };
    let plain = [
        row(0.5, [-2.0, 3e3, 4.0, 5.0, 6.0], 7.25),
        row(1.0, [2.0, 3.0, 4.0, 5.0, 6.0], 7.0),
    ];
    let header = HEADER.trim_end();
    for text in [
        // Columns in any order.
        "speed_rpm,mz_nm,my_nm,fz_n,fy_n,fx_n,time_s\n7.25,6,5,4,3e3,-2,0.5\n7,6,5,4,3,2,1\n"
            .to_owned(),
        // Line ends of Windows, no end of the last line, byte order mark, blank lines, quotes.
        format!("{header}\r\n0.5,-2,3e3,4,5,6,7.25\r\n1,2,3,4,5,6,7\r\n"),
        format!("\u{feff}{header}\n0.5,-2,3e3,4,5,6,7.25\n1,2,3,4,5,6,7"),
        format!("{header}\n\n0.5,-2,3e3,4,5,6,7.25\n \n1,2,3,4,5,6,7\n\n"),
        format!("{header}\n.5, -2 ,3000.,4,5,6,7.25\n1,2,+3,4,5,6,\"7\"\n"),
        // Further columns hold anything.
        format!("Sample,{header},T_oil\n#1,0.5,-2,3e3,4,5,6,7.25,\n#2,1,2,3,4,5,6,7,warm\n"),
        // Semicolons and tabs, as the header has them; the header again; empty fields behind the last.
        format!("{header};\n0.5;-2;3e3;4;5;6;7.25;;\n1;2;3;4;5;6;7\n").replace(',', ";"),
        format!("no,{header}\n0,0.5,-2,3e3,4,5,6,7.25\n0,1,2,3,4,5,6,7\n").replace(',', "\t"),
        format!("{header}\n0.5,-2,3e3,4,5,6,7.25\n{header}\n1,2,3,4,5,6,7\n"),
    ] {
        assert_eq!(parsed(&text).unwrap(), plain, "{text:?}");
    }
    // Temperatures are read where they are, asked for or not.
    let warm = format!("{header},t_inner_c,probe_a_um,t_outer_c\n0.5,-2,3e3,4,5,6,7.25,40,8,35\n");
    let wanted = Wanted {
        probes: vec!["a".to_owned()],
        ..Wanted::default()
    };
    let warm = opened(warm.as_bytes(), &wanted).unwrap().next().unwrap();
    let expected = LoadRow {
        temperatures: Some([40.0, 35.0]),
        probes: [Some(8.0), None, None, None],
        ..plain[0]
    };
    assert_eq!(warm.unwrap(), expected);
    // Without times, rows are counted.
    let states = "fx_n,fy_n,fz_n,my_nm,mz_nm,speed_rpm\n2,3,4,5,6,7\n";
    assert_eq!(parsed(states).unwrap(), [row(0.0, plain[1].load, 7.0)]);
}

#[test]
fn columns_of_others_are_ignored_and_named() {
    let text = "no,time_s,\"remark; long\",fx_n,fy_n,fz_n,my_nm,mz_nm,speed_rpm,fx_kn,\n\
                a,1,\"so, so\",2,3,4,5,6,7,,\n";
    let mut loads = opened(text.as_bytes(), &Wanted::default()).unwrap();
    let ignored = "\"no\", \"remark; long\", \"fx_kn\"";
    assert_eq!(loads.ignored_columns().unwrap(), ignored);
    assert!(!loads.has_temperatures());
    let plain = parsed(&format!("{HEADER}1,2,3,4,5,6,7\n")).unwrap();
    assert_eq!(loads.next().unwrap().unwrap(), plain[0]);
}

#[test]
fn bytes_that_are_no_text_are_refused_with_line_and_column() {
    let mut bytes = format!("{HEADER}1,2,3,4,5,6,7\n").into_bytes();
    bytes.extend(b"1,2,\xFF\xFE,4,5,6,7\n");
    let mut loads = opened(&bytes, &Wanted::default()).unwrap();
    let error = loads.find_map(Result::err).unwrap().to_string();
    let told =
        "x: line 3, column 3 (fy_n): byte 5 of the line is no UTF-8 text: save the file as UTF-8";
    assert!(error.starts_with(told), "{error}");
    // In any column, and in the header; Windows-1252, a workbook, UTF-16.
    let mut note = HEADER.trim_end().as_bytes().to_vec();
    note.extend(b",note\n1,2,3,4,5,6,7,gr\xFCn\n");
    let error = parsed_bytes(&note).unwrap_err().to_string();
    assert!(
        error.starts_with("x: line 2, column 8: byte 17 "),
        "{error}"
    );
    let texts: [(&[u8], &str); 3] = [
        (b"Dr\xFCcke,fx_n\n", "byte 3"),
        (b"PK\x03\x04\x14\0", "byte 6"),
        (b"\xFF\xFEt\0i\0", "byte 1"),
    ];
    for (bytes, at) in texts {
        let error = parsed_bytes(bytes).unwrap_err().to_string();
        let told = format!("x: line 1, column 1: {at} of the line is no UTF-8 text");
        assert!(
            error.starts_with(&told) && error.contains("pandas"),
            "{error}"
        );
    }
}

/// Bytes flipped, lines cut, doubled and swapped, below the header or in it: every line is read, refused or skipped, or ends it.
#[test]
fn no_line_is_lost_without_a_word() {
    let wanted = Wanted {
        probes: vec!["a".to_owned()],
        ..Wanted::default()
    };
    for seed in 0..6000 {
        let mut random = Random::seeded(seed);
        let separator = [",", ";", "\t"][random.below(3)];
        let header = format!("{},note,probe_a_um\n", HEADER.trim_end()).replace(',', separator);
        let rows = "0.5,1.5,-2,\"3\",4,+5,6,,1\n7,6,5,4,3,2,1,\"a\",\n"
            .replace(',', separator)
            .repeat(4);
        let mut bytes = format!("{header}{rows}").into_bytes();
        let from = if seed % 2 == 0 { 0 } else { header.len() };
        for _ in 0..1 + random.below(4) {
            let at = from + random.below(bytes.len() - from);
            match random.below(5) {
                0 => bytes[at] ^= 1 << random.below(8),
                1 => bytes.truncate(at + 1),
                2 => drop(bytes.remove(at)),
                3 => {
                    let end = (at + random.below(30)).min(bytes.len());
                    let doubled = bytes[at..end].to_vec();
                    bytes.splice(at..at, doubled);
                }
                _ => {
                    let other = from + random.below(bytes.len() - from);
                    bytes.swap(at, other);
                }
            }
            if bytes.len() <= from {
                break;
            }
        }
        let mut loads = match opened(&bytes, &wanted) {
            Ok(loads) => loads,
            Err(LoadsError::Malformed(fault)) => {
                assert!(fault.starts_with("x: line "), "{seed}: {fault}");
                continue;
            }
            Err(error) => panic!("{seed}: {error}"),
        };
        let found: Vec<_> = loads.by_ref().collect();
        if let Some(Err(LoadsError::Malformed(_))) = found.last() {
            continue;
        }
        let counts = loads.counts();
        let ends = bytes.iter().filter(|byte| **byte == b'\n').count();
        let lines = ends + usize::from(!bytes.ends_with(b"\n"));
        assert_eq!(
            (
                found.len() as u64,
                1 + counts.read + counts.refused + counts.skipped
            ),
            (counts.read + counts.refused, lines as u64),
            "{seed}"
        );
    }
}

#[test]
fn one_record_of_so_many_is_read() {
    let rows: String = (0..10).map(|i| format!("{i},2,3,4,5,6,7\n")).collect();
    let every = Wanted {
        every: 4,
        ..Wanted::default()
    };
    let loads = opened(format!("{HEADER}{rows}").as_bytes(), &every).unwrap();
    let times: Vec<f64> = loads.map(|row| row.unwrap().time_s).collect();
    assert_eq!(times, [0.0, 4.0, 8.0]);
}

/// Summary and results of a replay of a row by the B7005C.
fn replayed(
    solver: &mut dyn AnySolver,
    precision: Precision,
    choices: Choices,
    row: LoadRow,
) -> (Summary, String) {
    let file = SpindleFile::read(shipped("b7005c")).unwrap();
    let mut results = Vec::new();
    let out: Vec<Output<'_>> = vec![(Table::Results, Box::new(&mut results))];
    let rows = [Ok(row)].into_iter();
    let job = Job {
        file: &file,
        precision,
        cold: false,
        at_rest: false,
        select: Vec::new(),
        choices,
        held: [None; 5],
        holds_pauses: false,
        lifetime: None,
    };
    let summary = replay(job, solver, rows, out).unwrap();
    let text = String::from_utf8(results).unwrap();
    (summary, text.lines().nth(1).unwrap().to_owned())
}

/// Where a solve stopped for want of iterations there is no equilibrium, and no figure of one.
#[test]
fn a_solve_that_ran_out_of_iterations_has_no_figures() {
    let plan = SpindleFile::read(shipped("b7005c")).unwrap().plan;
    let row = parsed(&format!("{HEADER}0.5,1000,200,0,0,3,20000\n")).unwrap();
    for precision in [Precision::F32, Precision::F64] {
        let run = |solver: &mut dyn AnySolver| {
            let choices = Choices {
                max_iterations: 1,
                ..Choices::default()
            };
            replayed(solver, precision, choices, row[0])
        };
        let balls = Balls::Free;
        let (summary, line) = with_solver(&plan, balls, precision, run).unwrap();
        assert_eq!(summary.refused.values().sum::<u64>(), 1, "{summary}");
        let [time, status, rest] = line.splitn(3, ',').collect::<Vec<_>>()[..] else {
            panic!("{line}");
        };
        assert_eq!(time, "0.5");
        assert!(!["", "converged", "precision-limit"].contains(&status));
        let figures = ",".repeat(1 + 5 + 25 + 1);
        assert_eq!(rest, format!("{}1000,200,0,0,3,20000,,", figures));
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

/// Of a bearing by itself; `wrong_files` has more, of spindles.
#[test]
fn a_bearing_that_cannot_be_built_is_refused_with_the_key_at_fault() {
    for (from, to, told) in [
        (
            "= 0.525",
            "= -0.0",
            "6, column 23: `outer_groove_factor`: in SI units, outer groove factor fo",
        ),
        (
            "= 36",
            "= 0",
            "4, column 21: `pitch_diameter_mm`: in SI units, pitch diameter dm",
        ),
        (
            "= 15",
            "= -inf",
            "7, column 21: `contact_angle_deg` is -inf, and no number",
        ),
    ] {
        let refused = DesignFile::parse("b.toml", &DESIGN.replace(from, to));
        let message = refused.unwrap_err().to_string();
        let start = format!("b.toml: line {told}");
        assert!(message.starts_with(&start), "{message}");
    }
}

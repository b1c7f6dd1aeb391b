//! Recordings of other programs: proposed, filled in by the words of the file, and read to the letter.

use cli::fault::LoadsError;
use cli::import::{Import, Wanted};
use cli::propose;
use cli::random::Random;
use cli::recordings::Loads;
use serde::Deserialize;
use spindle_file::loads::LoadRow;
use std::collections::BTreeMap;
use std::io::Cursor;

/// The recordings, and what is expected of each.
const FOREIGN: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/records/foreign");

#[derive(Deserialize)]
struct Expected {
    open: Vec<String>,
    #[serde(default)]
    fill: BTreeMap<String, String>,
    rows: usize,
    refused: usize,
    first: Option<[f64; 7]>,
    last: Option<[f64; 7]>,
}

fn opened(text: &[u8], import: Option<&Import>, wanted: &Wanted) -> Result<Loads, LoadsError> {
    Loads::from_reader("x", Box::new(Cursor::new(text.to_vec())), import, wanted)
}

/// Rows that are read, and messages of those that are refused.
fn read(text: &str, import: &str) -> (Vec<LoadRow>, Vec<String>) {
    let import =
        Import::parse("i.toml", import).unwrap_or_else(|error| panic!("{import}\n{error}"));
    let loads = opened(text.as_bytes(), Some(&import), &Wanted::default());
    let (mut rows, mut refused) = (Vec::new(), Vec::new());
    for row in loads.unwrap_or_else(|error| panic!("{text}\n{error}")) {
        match row {
            Ok(row) => rows.push(row),
            Err(error) => refused.push(error.to_string()),
        }
    }
    (rows, refused)
}

fn figures(row: &LoadRow) -> [f64; 7] {
    let [fx, fy, fz, my, mz] = row.load;
    [row.time_s, fx, fy, fz, my, mz, row.speed_rpm]
}

fn proposed(text: &[u8]) -> String {
    let input = Box::new(Cursor::new(text.to_vec()));
    propose::of_input("x", input).unwrap().description
}

/// Keys of which a description has a question mark.
fn open_points(description: &str) -> Vec<&str> {
    let lines = description
        .lines()
        .filter(|line| !line.starts_with('#') && line.contains("\"?\""));
    lines.filter_map(|line| line.split(" = ").next()).collect()
}

/// A description with these keys rewritten; keys with an empty value are left out.
fn filled(description: &str, fill: &BTreeMap<String, String>) -> String {
    let lines = description.lines().map(|line| {
        let key = line.split(" = ").next().unwrap_or_default();
        match fill.get(key) {
            Some(text) if text.is_empty() => String::new(),
            Some(text) => format!("{key} = {text}"),
            None => line.to_owned(),
        }
    });
    lines.collect::<Vec<_>>().join("\n")
}

#[test]
fn proposals_filled_in_by_the_words_of_the_file_are_right() {
    let text = std::fs::read_to_string(format!("{FOREIGN}/expected.toml")).unwrap();
    let all: BTreeMap<String, Expected> = toml::from_str(&text).unwrap();
    let files = std::fs::read_dir(FOREIGN).unwrap().count();
    assert_eq!(all.len() + 1, files, "each file of {FOREIGN} is expected");
    for (name, expected) in all {
        let bytes = std::fs::read(format!("{FOREIGN}/{name}")).unwrap();
        let description = proposed(&bytes);
        assert_eq!(
            open_points(&description),
            expected.open,
            "{name}\n{description}"
        );
        let description = filled(&description, &expected.fill);
        let import = Import::parse(&name, &description);
        let import = import.unwrap_or_else(|error| panic!("{name}: {error}\n{description}"));
        let loads = opened(&bytes, Some(&import), &Wanted::default());
        let mut loads = loads.unwrap_or_else(|error| panic!("{name}: {error}\n{description}"));
        let rows: Vec<[f64; 7]> = loads
            .by_ref()
            .filter_map(|row| row.ok().map(|row| figures(&row)))
            .collect();
        let counts = loads.counts();
        assert_eq!(
            (counts.read, counts.refused),
            (expected.rows as u64, expected.refused as u64),
            "{name}"
        );
        let ends = [(rows.first(), expected.first), (rows.last(), expected.last)];
        for (found, wanted) in ends {
            let pairs = found
                .into_iter()
                .zip(wanted)
                .flat_map(|(a, b)| a.iter().copied().zip(b));
            for (found, wanted) in pairs {
                let off = (found - wanted).abs();
                assert!(off <= 1e-8 * wanted.abs(), "{name}: {found} for {wanted}");
            }
        }
    }
}

/// A foreign recording without a description is refused with two command lines, and nothing is read.
#[test]
fn none_is_read_without_a_description() {
    let mut refused = 0;
    for entry in std::fs::read_dir(FOREIGN).unwrap() {
        let path = entry.unwrap().path();
        if path.file_name().unwrap() == "expected.toml" {
            continue;
        }
        match cli::recordings::read(&path, None, &Wanted::default()) {
            Ok(_) => panic!("{}", path.display()),
            Err(error @ LoadsError::Foreign { .. }) => {
                let message = error.to_string();
                let name = path.display().to_string();
                let propose = format!("cargo replay --propose {name} > ");
                let import = format!("cargo replay SPINDLE.toml {name} --import ");
                assert!(
                    message.contains(&propose) && message.contains(&import),
                    "{message}"
                );
                refused += 1;
            }
            // In the project's own columns but for one, which is named.
            Err(LoadsError::Malformed(message)) if message.contains("no column") => refused += 1,
            Err(error) => panic!("{error}"),
        }
    }
    assert!(refused > 50, "{refused}");
}

/// A description of forces and speed by their names, with more of it.
fn described(head: &str, columns: &str) -> String {
    format!(
        "header_line = 1\nfirst_row = 2\nseparator = \"semicolon\"\n{head}\n[columns]\n{columns}\n"
    )
}

const COLUMNS: &str = "time = { column = \"t\", unit = \"s\" }\nfx = { column = \"Fx\", unit = \"N\" }\n\
    fy = { column = \"Fy\", unit = \"N\" }\nfz = { value = 0, unit = \"N\" }\nmy = { value = 0, unit = \"Nm\" }\n\
    mz = { value = 0, unit = \"Nm\" }\nspeed = { value = 6000, unit = \"rpm\" }";

#[test]
fn rows_are_read_to_the_letter() {
    // Head of the description, text below `t;Fx;Fy;note`, and of each line: the axial force, `!` refused, `-` skipped.
    let cases = [
        ("", "0;1;2;a\n1;3;4;\n", "1 3"),
        // More or fewer fields; empty ones behind the last.
        ("", "0;1;2;a;\n0;3;2;a;;\n0;5;2;a;7\n0;5;2\n", "1 3 ! !"),
        ("short_rows = true", "0;1;2\n0;3;2;a\n0;5\n", "1 3 !"),
        // Blank lines, comments, the header again, also after a row that is none.
        (
            "comment = \"#\"",
            "\n;;;\n# a\n0;1;2;a\nt;Fx;Fy;note\n0;3;2;a\n",
            "- - - 1 - 3",
        ),
        ("", "# a\n0;1;2;a\n", "! 1"),
        // Words where numbers are due; thousands; quotes; signs; a unit behind the time.
        (
            "",
            "0;1;2;a\nMax;1;2;a\n0;;2;a\n0;1,000;2;a\n0;1'000;2;a\n",
            "1 ! ! ! !",
        ),
        (
            "",
            "\"0\";\"1\";\"2\";\"a;b\"\n0;+ 3;- 4;a\n0;\u{2212}5;2;a\n0.5 s;7;2;a\n0.5 ms;9;2;a\n0;+-9;2;a\n",
            "1 3 -5 7 ! !",
        ),
        (
            "decimal = \",\"",
            "0;1,5;2;a\n0;1.5;2;a\n0;1.000,5;2;a\n",
            "1.5 ! !",
        ),
        // A word in every column begins another file, until the header comes again.
        (
            "",
            "0;1;2;a\nt;Fy;Fx;note\n0;3;2;a\nt;Fx;Fy;note\n0;5;2;a\n",
            "1 ! ! - 5",
        ),
        // Its units are those of nobody knows what: the header alone does not end that.
        (
            "",
            "0;1;2;a\ns;kN;kN;\nt;Fx;Fy;note\n0;3;2;a\nt;Fx;Fy;note\n0;5;2;a\n",
            "1 ! - ! - 5",
        ),
    ];
    for (head, text, expected) in cases {
        let import = described(head, COLUMNS);
        let text = format!("t;Fx;Fy;note\n{text}");
        let import = Import::parse("i.toml", &import).unwrap();
        let mut loads = opened(text.as_bytes(), Some(&import), &Wanted::default()).unwrap();
        let mut found = Vec::new();
        let mut skipped = 0;
        while let Some(row) = loads.next() {
            let more = loads.counts().skipped;
            found.extend((skipped..more).map(|_| "-".to_owned()));
            skipped = more;
            found.push(row.map_or("!".to_owned(), |row| row.load[0].to_string()));
        }
        found.extend((skipped..loads.counts().skipped).map(|_| "-".to_owned()));
        assert_eq!(found.join(" "), expected, "{text}");
    }
}

#[test]
fn another_file_is_told_with_both_headers() {
    let text = b"t;Fx;Fy;note\n0;1;2;a\nt;Fy;Fx;note\n0;3;2;a\n";
    let import = Import::parse("i.toml", &described("", COLUMNS)).unwrap();
    let mut loads = opened(text, Some(&import), &Wanted::default()).unwrap();
    assert_eq!(loads.by_ref().filter(Result::is_ok).count(), 1);
    let account = loads.account();
    assert!(
        account.contains("line 3 begins another file, \"t;Fy;Fx;note\", not \"t;Fx;Fy;note\""),
        "{account}"
    );
    assert!(
        account.contains("rows read 1, refused 2; lines skipped 0; time 0 to 0 s, fx 1 N"),
        "{account}"
    );
}

/// Lines between the header and the first row are skipped with it, here and further down, and told if they read as rows.
#[test]
fn numbers_of_channels_are_no_rows() {
    let text = b"t;Fx;Fy;note\n1;2;3;4\n0;1;2;a\nt;Fx;Fy;note\n1;2;3;4\n0;3;2;a\n1;2;3;4\n";
    let import = described("", COLUMNS).replace("first_row = 2", "first_row = 3");
    let import = Import::parse("i.toml", &import).unwrap();
    let mut loads = opened(text, Some(&import), &Wanted::default()).unwrap();
    let found: Vec<f64> = loads.by_ref().map(|row| row.unwrap().load[0]).collect();
    assert_eq!((found, loads.counts().skipped), (vec![1.0, 3.0, 2.0], 2));
    let told: Vec<&str> = loads.told().collect();
    assert_eq!(
        told,
        ["line 2, above `first_row`, reads as a row, and is none"]
    );
}

/// A word in the only column that is read may be a sensor's; without a header, the first row that is read counts the fields.
#[test]
fn a_refused_row_is_the_only_one() {
    let forces = COLUMNS.replace("time = { column = \"t\", unit = \"s\" }\n", "");
    let forces = forces.replace("fy = { column = \"Fy\", unit", "fy = { value = 0, unit");
    let (rows, refused) = read(
        "t;Fx;Fy;note\n0;1;2;a\n0;OVER;2;a\n0;3;2;a\n",
        &described("", &forces),
    );
    assert_eq!((rows.len(), refused.len()), (2, 1));
    let numbers = forces.replace("\"Fx\"", "2");
    let headless =
        described("", &numbers).replace("header_line = 1\nfirst_row = 2", "first_row = 1");
    let (rows, refused) = read("0;x\n0;1;2\n0;3;2;;\n0;5\n", &headless);
    assert_eq!((rows.len(), refused.len()), (2, 2));
    assert!(
        refused[1].contains("the line ends after 2 of 3 fields"),
        "{refused:?}"
    );
    // Its time is none of the recording's.
    let clock = COLUMNS.replace("unit = \"s\"", "unit = \"clock\"");
    let text = "t;Fx;Fy;note\n13:00:00;1;2;a\n00:00:00;x;2;a\n13:00:01;1;2;a\n";
    let (rows, _) = read(text, &described("", &clock));
    assert_eq!((rows[1].time_s, rows.len()), (46801.0, 2));
}

#[test]
fn clock_times_count_from_midnight() {
    let clock = COLUMNS.replace("unit = \"s\"", "unit = \"clock\"");
    let cases = [
        (
            "23:59:59,5 00:00:00,25 00:00:01",
            [86399.5, 86400.25, 86401.0],
        ),
        (
            "2025-11-14T23:59:59.5 2025-11-15T00:00:00.25 2025-11-15T00:00:01",
            [86399.5, 86400.25, 86401.0],
        ),
        // Summer time ends.
        (
            "2025-10-26T02:59:59.5+02:00 2025-10-26T02:00:00+01:00 2025-10-26T01:00:00.5Z",
            [3599.5, 3600.0, 3600.5],
        ),
    ];
    for (times, expected) in cases {
        let rows: String = times
            .split(' ')
            .map(|time| format!("{time};1;2;a\n"))
            .collect();
        let (rows, refused) = read(&format!("t;Fx;Fy;note\n{rows}"), &described("", &clock));
        let found: Vec<f64> = rows.iter().map(|row| row.time_s).collect();
        assert_eq!((found, refused.len()), (expected.to_vec(), 0));
    }
    let dates = "2025-11-14 12:00:00.5 14.11.2025 12:00:00,5 2025/11/14 12:00:00.5";
    let dates: Vec<&str> = dates.split(' ').collect();
    for date in dates.chunks(2) {
        let (rows, _) = read(
            &format!("t;Fx;Fy;note\n{};1;2;a\n", date.join(" ")),
            &described("", &clock),
        );
        assert_eq!(rows[0].time_s, 43200.5);
    }
}

/// Units, factors, constants, numbers of columns, rates and axes, from text to number.
#[test]
fn descriptions_mean_what_they_say() {
    let units = [
        ("fx", "kN", 2e3),
        ("fx", "daN", 20.0),
        ("fx", "mN", 2e-3),
        ("fx", "MN", 2e6),
        ("fx", "lbf", 2.0 * 4.448_221_615_260_5),
        ("fx", "kgf", 2.0 * 9.806_65),
        ("mz", "Nmm", 2e-3),
        ("mz", "N.cm", 2e-2),
        ("mz", "kNm", 2e3),
        ("mz", "mNm", 2e-3),
        ("mz", "MNm", 2e6),
        ("mz", "kgf m", 2.0 * 9.806_65),
        ("mz", "kgf.cm", 2e-2 * 9.806_65),
        ("mz", "lbf in", 2.0 * 0.112_984_829_027_616_7),
        ("mz", "lbf ft", 2.0 * 1.355_817_948_331_400_4),
        ("speed", "Hz", 120.0),
        ("speed", "krpm", 2e3),
        ("speed", "rad/s", 60.0 / std::f64::consts::PI),
        ("time", "ms", 2e-3),
        ("time", "us", 2e-6),
        ("time", "ns", 2e-9),
        ("time", "min", 120.0),
        ("time", "h", 7200.0),
    ];
    for (key, unit, expected) in units {
        let columns: Vec<String> = COLUMNS
            .lines()
            .filter(|line| !line.starts_with(key))
            .map(str::to_owned)
            .collect();
        let entry = format!("{key} = {{ column = 4, unit = \"{unit}\" }}");
        let (rows, _) = read(
            "t;Fx;Fy;it\n0;1;2;2\n",
            &described("", &format!("{}\n{entry}", columns.join("\n"))),
        );
        let found = match key {
            "fx" => rows[0].load[0],
            "mz" => rows[0].load[4],
            "speed" => rows[0].speed_rpm,
            _ => rows[0].time_s,
        };
        assert!(
            (found - expected).abs() < 1e-12 * expected,
            "{unit}: {found}"
        );
    }
    let temperatures = [("degC", 40.0), ("degF", 104.0), ("K", 313.15)];
    for (unit, value) in temperatures {
        let sides = format!(
            "t_inner = {{ column = 3, unit = \"{unit}\" }}\nt_outer = {{ value = {value}, unit = \"{unit}\" }}"
        );
        let columns = COLUMNS.replace("fy = { column = \"Fy\"", "fy = { column = \"note\"");
        let import =
            Import::parse("i.toml", &described("", &format!("{columns}\n{sides}"))).unwrap();
        let wanted = Wanted {
            needed: [true; 9],
            ..Wanted::default()
        };
        let text = format!("t;Fx;Fy;note\n0;1;{value};2\n");
        let row = opened(text.as_bytes(), Some(&import), &wanted)
            .unwrap()
            .next()
            .unwrap()
            .unwrap();
        let [inner, outer] = row.temperatures.unwrap();
        assert!(
            (inner - 40.0).abs() < 1e-10 && inner == outer,
            "{inner} {outer}"
        );
    }
    // Axes turn forces and moments; a factor and a sign besides; a rate counts rows, refused ones, too.
    let columns = "time = { rate_hz = 4 }\nfx = { column = 1, unit = \"N\" }\nfy = { column = 2, unit = \"N\", factor = -0.5 }\n\
        fz = { column = 3, unit = \"N\" }\nmx = { column = 4, unit = \"Nm\" }\nmy = { column = 5, unit = \"Nm\" }\n\
        speed = { value = 100, unit = \"Hz\" }";
    let head = "first_row = 1\nseparator = \"blank\"\naxes = { x = \"Fz\", y = \"-Fx\", z = \"-Fy\" }\n[columns]\n";
    let (rows, refused) = read(
        "1  2 3 4 5\n1 x 3 4 5\n1 2 3 4 5\n",
        &format!("{head}{columns}"),
    );
    assert_eq!(refused.len(), 1);
    assert_eq!(figures(&rows[0]), [0.0, 3.0, -1.0, 1.0, -4.0, -5.0, 6000.0]);
    assert_eq!(rows[1].time_s, 0.5);
}

#[test]
fn what_is_open_or_wrong_in_a_description_is_told() {
    let cases = [
        (
            "fx = { column = \"Fx\", unit = \"N\" }",
            "fx = \"?\"",
            "i.toml: `fx` is open: write for each",
        ),
        (
            "fx = { column = \"Fx\", unit = \"N\" }",
            "fx = { column = \"Fx\", unit = \"?\" }",
            "i.toml: the unit of `fx` is open",
        ),
        (
            "my = { value = 0, unit = \"Nm\" }\n",
            "",
            "i.toml: [columns] lacks `my`: add it, or give --my",
        ),
        (
            "unit = \"s\"",
            "unit = \"N\"",
            "i.toml: line 6, column 8: \"N\" is none of the units s, ms, us, ns, min, h, clock",
        ),
        (
            "column = \"Fx\"",
            "column = \"fx\"",
            "x: line 1 has the columns \"t\", \"Fx\", \"Fy\", \"note\", and not the column \"fx\" of i.toml: it is another file",
        ),
        (
            "column = \"Fx\"",
            "column = 9",
            "x: line 1 has 4 columns, and not the column 9",
        ),
        (
            "column = \"Fx\"",
            "column = \"Fy\"",
            "x: line 1 has one column for fx and fy",
        ),
        (
            "first_row = 2",
            "first_row = 1",
            "i.toml: line 2, column 13: `first_row` is the number of a line below",
        ),
        ("first_row = 2", "first_row = 9", "x: it ends above line 9"),
        (
            "\"semicolon\"",
            "\";\"",
            "i.toml: line 3, column 13: `separator` is one of tab, comma, semicolon, blank",
        ),
        (
            "[columns]",
            "decimal = \"?\"\n[columns]",
            "i.toml: `decimal` is open",
        ),
        (
            "[columns]",
            "axes = { x = \"Fz\", y = \"-Fx\", z = \"Fy\" }\n[columns]",
            "i.toml: line 5, column 8: these axes are left-handed",
        ),
        (
            "[columns]",
            "axes = { x = \"Fz\", y = \"Fz\", z = \"Fy\" }\n[columns]",
            "i.toml: line 5, column 8: each of Fx, Fy, Fz must be there once",
        ),
        (
            "[columns]",
            "[columns]\nfa = \"?\"",
            "i.toml: line 6, column 1: unknown field `fa`",
        ),
        (
            "value = 6000",
            "value = nan",
            "i.toml: line 12, column 19: `value` is nan, and no number",
        ),
        (
            "time = { column = \"t\", unit = \"s\" }",
            "time = { rate_hz = 0 }",
            "i.toml: line 6, column 8: `rate_hz` is a positive number",
        ),
    ];
    for (from, to, start) in cases {
        let text = described("", COLUMNS).replacen(from, to, 1);
        let import = Import::parse("i.toml", &text).map_err(|error| error.to_string());
        let found = import.and_then(|import| {
            let loads = opened(
                b"t;Fx;Fy;note\n0;1;2;a\n",
                Some(&import),
                &Wanted::default(),
            );
            loads
                .err()
                .map(|error| error.to_string())
                .ok_or_else(|| text.clone())
        });
        let (Ok(message) | Err(message)) = found;
        assert!(message.starts_with(start), "{message}\nnot\n{start}");
    }
    // An open point of a quantity that is given, or that nobody needs, is no fault.
    let open = described(
        "",
        &COLUMNS.replace(
            "mz = { value = 0, unit = \"Nm\" }",
            "mz = \"?\"\nt_inner = \"?\"\nmx = \"?\"",
        ),
    );
    let import = Import::parse("i.toml", &open).unwrap();
    let mut given = Wanted::default();
    given.given[5] = Some(7.0);
    let mut unneeded = Wanted::default();
    unneeded.needed[5] = false;
    for (wanted, mz) in [(given, 7.0), (unneeded, 0.0)] {
        let mut loads = opened(b"t;Fx;Fy;note\n0;1;2;a\n", Some(&import), &wanted).unwrap();
        assert_eq!(loads.next().unwrap().unwrap().load[4], mz);
    }
}

#[test]
fn files_that_are_no_text_are_named() {
    let texts: [(&[u8], &str); 6] = [
        (b"PK\x03\x04\x14\0", "an Excel workbook"),
        (b"TDSm\x0e\0", "a TDMS file"),
        (b"MATLAB 5.0 MAT-file", "a MAT-file"),
        (b"\x89HDF\r\n\x1a\n", "an HDF5"),
        (b"    -1\n    58\nForce\n", "a universal file"),
        (b"\xFF\xFEt\0i\0", "UTF-16"),
    ];
    for (bytes, name) in texts {
        let own = opened(bytes, None, &Wanted::default())
            .err()
            .unwrap()
            .to_string();
        let proposal = propose::of_input("x", Box::new(Cursor::new(bytes.to_vec()))).unwrap_err();
        assert!(
            own.contains(name) && proposal.to_string().contains(name),
            "{own}\n{proposal}"
        );
    }
}

/// Bytes flipped, lines cut, doubled and swapped: below the header every line is read, refused or skipped.
#[test]
fn no_line_is_lost_without_a_word() {
    let texts = [
        ("", "time_s,fx_n,fy_n,fz_n,my_nm,mz_nm,speed_rpm,note\n"),
        (
            "of a program\nDate;1\n",
            "Zeit [s];Fx [kN];Fy [N];Fz [N];My [Nm];Mz [Nm];n [1/min]\n",
        ),
        (
            "Y_Unit_Label\tkN\tN\tN\tNm\tNm\n",
            "X_Value\tFx\tFy\tFz\tMy\tMz\trpm\n",
        ),
    ];
    for seed in 0..3000 {
        let mut random = Random::seeded(seed);
        let which = random.below(3);
        let (preamble, names) = texts[which];
        let separator = [",", ";", "\t"][which];
        let rows = "0.5,1.5,-2,\"3\",4,+ 5,6,\n7,6,5,4,3,2,1,\n"
            .replace(',', separator)
            .repeat(4);
        let header = format!("{preamble}{names}");
        let mut bytes = format!("{header}{rows}").into_bytes();
        for _ in 0..1 + random.below(4) {
            let at = header.len() + random.below((bytes.len() - header.len()).max(1));
            match random.below(5) {
                _ if at >= bytes.len() => break,
                0 => bytes[at] ^= 1 << random.below(8),
                1 => bytes.truncate(at + 1),
                2 => drop(bytes.remove(at)),
                3 => {
                    let end = (at + random.below(30)).min(bytes.len());
                    let doubled = bytes[at..end].to_vec();
                    bytes.splice(at..at, doubled);
                }
                _ => {
                    let other = header.len() + random.below(bytes.len() - header.len());
                    bytes.swap(at, other);
                }
            }
        }
        let numbers = (1..=7).map(|i| {
            let quantity = cli::quantities::OWN[i - 1];
            let unit = cli::units::Unit::of(quantity.dimension()).name();
            format!(
                "{} = {{ column = {i}, unit = \"{unit}\" }}\n",
                quantity.name()
            )
        });
        let name = ["comma", "semicolon", "tab"][which];
        let line = header.lines().count();
        let numbers: String = numbers.collect();
        let import = format!(
            "header_line = {line}\nfirst_row = {}\nseparator = \"{name}\"\n[columns]\n{numbers}",
            line + 1
        );
        let import = Import::parse("i.toml", &import).unwrap();
        let Ok(mut loads) = opened(&bytes, Some(&import), &Wanted::default()) else {
            panic!("{seed}");
        };
        let found = loads.by_ref().count() as u64;
        let counts = loads.counts();
        let below = &bytes[header.len()..];
        let ends = below.iter().filter(|byte| **byte == b'\n').count();
        let lines = ends + usize::from(!below.is_empty() && !below.ends_with(b"\n"));
        assert_eq!(
            (found, counts.read + counts.refused + counts.skipped),
            (counts.read + counts.refused, lines as u64),
            "{seed}"
        );
        let _ = propose::of_input("x", Box::new(Cursor::new(bytes)));
    }
}

#[test]
fn one_record_of_so_many_is_read() {
    let rows: String = (0..10).map(|i| format!("{i},2,3,4,5,6,7\n")).collect();
    let text = format!("time_s,fx_n,fy_n,fz_n,my_nm,mz_nm,speed_rpm\n{rows}");
    let every = Wanted {
        every: 4,
        ..Wanted::default()
    };
    let loads = opened(text.as_bytes(), None, &every).unwrap();
    let times: Vec<f64> = loads.map(|row| row.unwrap().time_s).collect();
    assert_eq!(times, [0.0, 4.0, 8.0]);
}

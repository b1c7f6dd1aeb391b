//! Recordings in the shapes of other programs: numbers are made up, headers are as the programs write them.

use files::designs::DesignFile;
use files::plan::Question;
use files::recordings::{LoadRow, Loads, LoadsError};
use files::spindles::SpindleFile;
use files::told::{Quantity, Told};
use host_tests::cases::Random;
use std::io::Cursor;
use std::path::Path;

fn opened(text: &[u8], told: Told) -> Result<Loads, LoadsError> {
    Loads::from_reader("x", Box::new(Cursor::new(text.to_vec())), told)
}

fn read(text: &str, told: Told) -> Vec<LoadRow> {
    let rows = opened(text.as_bytes(), told).and_then(Iterator::collect);
    rows.unwrap_or_else(|error| panic!("{text}\n{error}"))
}

fn refused(text: &str, told: Told) -> String {
    let rows = opened(text.as_bytes(), told).and_then(Iterator::collect::<Result<Vec<_>, _>>);
    rows.unwrap_err().to_string()
}

/// What `--columns`, `--axes` and constant quantities say.
fn told(columns: &str, axes: &str, given: &[(Quantity, f64)]) -> Told {
    let mut told = Told::default();
    if !columns.is_empty() {
        told.add_columns(columns).unwrap();
    }
    if !axes.is_empty() {
        told.set_axes(axes).unwrap();
    }
    for (quantity, value) in given {
        told.given[*quantity as usize] = Some(*value);
    }
    told
}

fn row(time_s: f64, load: [f64; 5], speed_rpm: f64) -> LoadRow {
    LoadRow {
        time_s,
        load,
        speed_rpm,
        temperatures: None,
    }
}

#[test]
fn shapes_of_other_programs_are_read() {
    let rest = [
        (Quantity::My, 0.0),
        (Quantity::Mz, 0.0),
        (Quantity::Speed, 6000.0),
    ];
    let own = "time_s,fx_n,fy_n,fz_n,my_nm,mz_nm,speed_rpm";
    let forces = [row(0.5, [100.0, 50.0, -400.0, 0.0, 0.0], 6000.0)];
    let all = [row(0.5, [500.5, -100.0, 0.0, 0.25, 1.0], 12000.0)];
    let counted = [
        row(0.0, all[0].load, 12000.0),
        row(1.0, all[0].load, 12000.0),
    ];
    let cases: [(&str, Told, &[LoadRow]); 20] = [
        // DynoWare: a preamble, names, units.
        (
            "DynoWare Data Export\r\nDate:\t12.03.2024\r\nSampling rate [Hz]:\t10000\r\nRange Fx [N]:\t1000\r\n\
             Filter:\t3.3 kHz\r\nTime\tFx\tFy\tFz\r\ns\tN\tN\tN\r\n0.5\t100\t50\t-400\r\n",
            told("", "", &rest),
            &forces,
        ),
        // BioWare: no unit for the time but in its name.
        (
            "BioWare Data Export\nTrial 3\n\nabs time (s)\tFx\tFy\tFz\n\tkN\tkN\tkN\n0,5\t0,1\t0,05\t-0,4\n",
            told("", "", &rest),
            &forces,
        ),
        // LabVIEW: two headers, units in the second.
        (
            "LabVIEW Measurement\t\nSeparator\tTab\nTime\t13:42:36,5\n***End_of_Header***\t\n\t\nChannels\t3\nSamples\t5\t5\t5\n\
             Y_Unit_Label\tN\tN\tkN\nX_Dimension\tTime\tTime\tTime\nX0\t0\t0\t0\nDelta_X\t0,5\t0,5\t0,5\n***End_of_Header***\n\
             X_Value\tFx\tFy\tFz\tComment\n0,5\t100\t50\t-0,4\n",
            told("", "", &rest),
            &forces,
        ),
        // ATI: counts, and the counts of a unit.
        (
            "Force Units: N,Counts per Unit Force: 1000\nTorque Units: Nm,Counts per Unit Torque: 100000\n\
             Status (hex),RDT Sequence,Fx,Fy,Fz,Tx,Ty,Tz,Time\n0,7,500500,-100000,0,0,25000,100000,0.5\n",
            told("", "", &rest[2..]),
            &[row(0.5, [500.5, -100.0, 0.0, 0.25, 1.0], 6000.0)],
        ),
        // Graphtec: blanks after signs, columns by channel.
        (
            "\"Vendor\",\"GRAPHTEC Corporation\"\n\"CH1\",\"Fx\",\"DC\"\n\"Data\"\n\"Number\",\"Date&Time\",\"ms\",\"CH1\",\"CH2\",\"CH3\"\n\
             \"NO.\",\"Time\",\"ms\",\"N\",\"N\",\"N\"\n\"1\",\"2024/03/12 10:21:33\",\"500\",\"+   100.0\",\"+ 50\",\"- 400\"\n",
            told("time=ms,fx=CH1,fy=CH2,fz=CH3", "", &rest),
            &forces,
        ),
        (
            "Zeit [s];Kraft X [N];Fy in N;Fz / N;My [N·m];Mz [Nmm];Drehzahl [1/min]\n0,5;500,5;-100;0;0,25;1000;12000\n",
            Told::default(),
            &all,
        ),
        (
            "Time [ms],Force X (kN),Fy [N],Fz [N],My [Nm],Mz [Nm],n [1/s]\n500,0.5,-100,0,0.25,1,200\n",
            Told::default(),
            &[row(0.5, [500.0, -100.0, 0.0, 0.25, 1.0], 12000.0)],
        ),
        (
            "% of a program\n; too\ntime_s,fx_n,fy_n,fz_n,my_nm,mz_nm,speed_rpm\n% here\n0.5,500.5,-100,0,0.25,1,12000\n",
            Told::default(),
            &all,
        ),
        (
            "time_s,fx_n,fy_n,fz_n,my_nm,mz_nm,speed_rpm\n\"0,5\",\"500,5\",\"-100,0\",\"0,0\",\"0,25\",\"1,0\",\"12000,0\"\n",
            Told::default(),
            &all,
        ),
        (
            "time_s;fx_n;fy_n;fz_n;my_nm;mz_nm;speed_rpm\n0.5;500.5;-100;0;0.25;1;12000;\n",
            Told::default(),
            &all,
        ),
        (
            "time_s\tfx_n\tfy_n\tfz_n\tmy_nm\tmz_nm\tspeed_rpm\tComment\n0.5\t500.5\t\u{2212}100\t0\t0.25\t1\t12000\n",
            Told::default(),
            &all,
        ),
        // Without times: states, counted.
        (
            "fx_n,fy_n,fz_n,my_nm,mz_nm,speed_rpm\n500.5,-100,0,0.25,1,12000\n500.5,-100,0,0.25,1,12000\n",
            Told::default(),
            &counted,
        ),
        // A clock that is left out.
        (
            "Time,Fx,Fy,Fz,My,Mz,rpm\n10:21:33,500.5,-100,0,0.25,1,12000\n10:21:34,500.5,-100,0,0.25,1,12000\n",
            told("time=-", "", &[]),
            &counted,
        ),
        // No names: numbers of columns.
        (
            "0.5,500.5,-100,0,0.25,1,12000\n",
            told("time=1,fx=2,fy=3,fz=4,my=5,mz=6,speed=7", "", &[]),
            &all,
        ),
        (
            "time_s,Fx (V),fy_n,fz_n,my_nm,mz_nm,speed_rpm\n0.5,5.005,-100,0,0.25,1,12000\n",
            told("fx=Fx (V)*100", "", &[]),
            &[row(0.5, [5.005 * 100.0, -100.0, 0.0, 0.25, 1.0], 12000.0)],
        ),
        // A comma in a name, a sign, and axes: moments follow forces.
        (
            "t [s],\"Force, along\",b,c,my_nm,mz_nm,n [rpm]\n0.5,500.5,100,0,0.25,1,12000\n",
            told("fx=Force, along,fy=-b,fz=c", "", &[]),
            &all,
        ),
        (
            "time_s,Fx,Fy,Fz,Mx,My,Mz,rpm\n0.5,-100,0,500.5,0.25,1,3,12000\n",
            told("", "x=Fz,y=Fx,z=Fy", &[]),
            &all,
        ),
        (
            "time_s,Fx,Fy,Fz,Mx,My,Mz,rpm\n0.5,500.5,100,0,3,-0.25,-1,12000\n",
            told("", "x=Fx,y=-Fy,z=-Fz", &[]),
            &[row(0.5, [500.5, -100.0, -0.0, 0.25, 1.0], 12000.0)],
        ),
        // A mirrored frame has no moments of its own.
        (
            "time_s,Fx,Fy,Fz,rpm\n0.5,100,0,500.5,12000\n",
            told(
                "",
                "x=Fz,y=-Fx,z=Fy",
                &[(Quantity::My, 0.25), (Quantity::Mz, 1.0)],
            ),
            &all,
        ),
        (
            &format!("{own},fx_kn,remark\n0.5,500.5,-100,0,0.25,1,12000,7,a\n"),
            Told::default(),
            &all,
        ),
    ];
    for (text, told, rows) in cases {
        assert_eq!(read(text, told), rows, "{text}");
    }
}

/// Preambles that mislead: rows that look like one of numbers, names of quantities, counts that are none.
#[test]
fn preambles_do_not_mislead() {
    let all = [row(0.5, [500.0, -100.0, 0.0, 0.25, 1.0], 12000.0)];
    let names = "Time (s),Fx,Fy,Fz,My,Mz,Speed";
    let values = "0.5,500,-100,0,0.25,1,12000";
    let by_semicolons = |text: &str| text.replace(',', ";");
    let texts = [
        // Whole numbers are counts, numbers with decimals are not.
        format!(
            "Force Units: N\nCounts per Unit Force: 1,000,000\n{names}\n0.5,500000000,-100000000,0,0.25,1,12000\n"
        ),
        format!(
            "Force Units: N\nCounts per Unit Force: 1000000.0\n{names}\n0.5,500.0,-100.0,0.0,0.25,1,12000\n"
        ),
        format!("Encoder counts per force sensor tick: 4096\n{names}\n{values}\n"),
        format!(
            "\"Force Units:\",\"N\"\n\"Counts per Force:\",\"1000\"\n{names}\n0.5,500000,-100000,0,0.25,1,12000\n"
        ),
        format!("Force unit: kN\n{names}\n0.5,0.5,-0.1,0,0.25,1,12000\n"),
        by_semicolons(
            "s,kN,kN,kN,Nm,Nm,rpm\nTime,Fx,Fy,Fz,My,Mz,Speed\n0.5,0.5,-0.1,0,0.25,1,12000\n",
        ),
        by_semicolons(
            "No,Time,Fx,Fy,Fz,My,Mz,Speed\n,ms,kN,kN,kN,Nm,Nm,rpm\n1,500,0.5,-0.1,0,0.25,1,12000\n",
        ),
        by_semicolons(&format!(",{names}\n0,{values}\n")),
        by_semicolons(&format!("Fz,Fy,Fx,My,Mz,Speed,Time\n{names}\n{values}\n")),
        format!("1;2;3;4;5;6;7\n2024;3;12\n0.5,1000\n{names}\n{values}\n"),
        format!(
            "\"TraceName\",{names}\n\"BlockSize\",2,2,2,2,2,2,2\n\"VUnit\",\"s\",\"kN\",\"N\",\"N\",\"Nm\",\"Nm\",\"rpm\"\n\
                 \"SampleRate\",9,9,9,9,9,9,9\n\n,0.5,0.5,-100,0,0.25,1,12000\n"
        ),
        format!("# {names}\n{values}\n"),
        format!("% {names}\n% a note\n{values}\n"),
        "time_s fx_n fy_n fz_n my_nm mz_nm speed_rpm\n 0.5  500 -100 0 0.25 1 12000\n".to_owned(),
        format!("Time [min],Fx (N),Fy [mN],Fz,My,Mz,speed rad/s\n{values}\n")
            .replace("0.5,", "0.008333333333333333,")
            .replace("[mN]", "[N]")
            .replace(",12000", ",1256.6370614359173"),
    ];
    for text in texts {
        let found = read(&text, Told::default());
        assert_eq!(found.len(), 1, "{text}");
        let figures = |row: &LoadRow| [&[row.time_s, row.speed_rpm][..], &row.load].concat();
        for (found, wanted) in figures(&found[0]).into_iter().zip(figures(&all[0])) {
            assert!(
                (found - wanted).abs() <= 1e-12 * wanted.abs(),
                "{text}{found} {wanted}"
            );
        }
    }
    // Western Windows: a micro sign that is no UTF-8.
    let micro = b"Zeit [\xb5s];Fx [N];Fy;Fz;My;Mz;rpm\n500000;500;-100;0;0.25;1;12000\n";
    let rows: Result<Vec<_>, _> = opened(micro, Told::default()).unwrap().collect();
    assert_eq!(rows.unwrap(), all);
}

#[test]
fn what_is_not_known_is_asked_for_at_once() {
    let cases = [
        (
            "Time [s],F1,F2,F3,Speed [rpm]\n0,1,2,3,4\n",
            told("", "", &[]),
            "x: line 1, column 1: fx is in no column; fy is in no column; fz is in no column; my is in no column; mz is in \
             no column; columns that say nothing: \"F1\", \"F2\", \"F3\". Say where each is, or its value, such as \
             --columns fx=\"?\",fy=\"?\",fz=\"?\" --my 0 --mz 0",
        ),
        (
            "time_s,Fx [N],Force X [N],fy,fz,my,mz,rpm\n0,1,2,3,4,5,6,7\n",
            told("", "", &[]),
            "fx may be \"Fx [N]\" or \"Force X [N]\"",
        ),
        (
            "time_s,Fx [V],fy,fz,my,mz,rpm\n",
            told("", "", &[]),
            "\"Fx [V]\" has the unit V, which is none of N, kN",
        ),
        (
            "time_s,Fx,Fy,Fz,Mx,My,Mz,rpm\n",
            told("", "x=Fz,y=-Fx,z=Fy", &[]),
            "the axes are mirrored",
        ),
        (
            "time_s,Fx,Fy,Fz,My,Mz,rpm\n",
            told("fx=Fq", "", &[]),
            "no column is called \"Fq\": there are \"time_s\"",
        ),
        (
            "time_s,Fx,Fy,Fz,My,Mz,rpm\n",
            told("fy=Fx", "", &[]),
            "\"Fx\" is fx and fy",
        ),
        // Proposals are names that may be meant, or none.
        (
            "t,Fx [N],Fy,Fz,Tx,Ty,Tz,Sample\n",
            told("", "", &[]),
            "--columns time=\"t\",my=\"Ty\",mz=\"Tz\" --speed 12000",
        ),
        (
            "Fx,Fx,Fy,Fz,My,Mz,rpm\n",
            told("", "", &[]),
            "--columns fx=1",
        ),
        // Of turned axes, the recording's quantity.
        (
            "time_s,Fx,Fy,Fz (V),rpm\n",
            told(
                "",
                "x=Fz,y=Fx,z=Fy",
                &[(Quantity::My, 0.0), (Quantity::Mz, 0.0)],
            ),
            "by --columns fz=\"Fz (V)*0.001\"",
        ),
        (
            "Fx (V),Fy [N],Fz,Mz [Nm]\n",
            told("", "", &[]),
            "by --columns fx=\"Fx (V)*0.001\"; my is in no column; speed",
        ),
        (
            "Time [hh:mm:ss],Fx,Fy,Fz,My,Mz,rpm\n",
            told("", "", &[]),
            "leave it out by --columns time=-",
        ),
        (
            "Fx [%N],Fy,Fz,My,Mz,rpm\n",
            told("", "", &[]),
            "has the unit %N, which is none of",
        ),
        (
            "0,1,2\n",
            told("", "", &[]),
            "--columns fx=\"?\",fy=\"?\",fz=\"?\" --my 0 --mz 0 --speed 12000",
        ),
        (
            "t\0i\0m\0e\0_\0s\0,\0\n\0",
            told("", "", &[]),
            "the file is UTF-16 text",
        ),
        (
            "fx,fy,fz,my,mz,rpm\n1.000,5,2,3,4,5,6\n",
            told("", "", &[]),
            "the line has 7 fields where the header has 6",
        ),
        (
            "fx;fy;fz;my;mz;rpm\n1.000,5;2;3;4;5;6\n",
            told("", "", &[]),
            "\"1.000,5\" is not a number: it has thousands separators",
        ),
        (
            "fx,fy,fz,my,mz,rpm\n1 000.5,2,3,4,5,6\n",
            told("", "", &[]),
            "\"1 000.5\" is not a number: it has thousands separators",
        ),
        (
            "time_s,fx,fy,fz,my,mz,rpm\n10:21:33,2,3,4,5,6,7\n",
            told("", "", &[]),
            "--columns time=-",
        ),
        (
            "time_s,fx,fy,fz,my,mz,rpm,t_inner_c,t_outer_c\n1,2,3,4,5,6,7,293.15,20\n",
            told("", "", &[]),
            "line 2, column 8 (t_inner_c): 293.15 is above 200 deg C; if it is in kelvin",
        ),
    ];
    for (text, told, wanted) in cases {
        let message = refused(text, told);
        assert!(message.contains(wanted), "{message}\nnot\n{wanted}");
        assert_eq!(message.lines().count(), 1, "{message}");
    }
    for wrong in [
        "x=Fz",
        "x=Fx,y=Fx,z=Fz",
        "x=Fx,x=Fy,z=Fz",
        "x=Fq,y=Fx,z=Fy",
        "",
    ] {
        assert!(Told::default().set_axes(wrong).is_err(), "{wrong}");
    }
    for wrong in ["", "fx", "fq=1", "fx=1,fx=2"] {
        assert!(Told::default().add_columns(wrong).is_err(), "{wrong}");
    }
}

#[test]
fn what_was_assumed_is_told_with_ranges() {
    let mut loads = opened(
        b"Zeit [s];Fx [N];Fy;Fz;My;Mz;n [1/s]\n0;1;2;3;4;5;0,2\n1;2;2;3;4;5;0,25\n",
        told("fy=-Fy", "", &[(Quantity::Mz, 0.0)]),
    )
    .unwrap();
    assert_eq!(loads.by_ref().count(), 2);
    assert_eq!(
        loads.assumed().unwrap(),
        "x: read as time 0 to 1 s (\"Zeit [s]\"), fx 1 to 2 N (\"Fx [N]\"), fy -2 N? (-\"Fy\"), fz 3 N? (\"Fz\"), \
         my 4 Nm? (\"My\"), mz 0 Nm, speed 12 to 15 rpm (\"n [1/s]\")"
    );
    // A mark before three digits may be one of thousands: the range shows it, even of the project's own names.
    for (text, is_told) in [
        ("12.000", true),
        ("1.5", false),
        ("0.125", false),
        ("12.000;0.5", false),
    ] {
        let speed = format!("fx_n;fy_n;fz_n;my_nm;mz_nm;time_s;speed_rpm\n1;2;3;4;5;6;{text}\n");
        let text = speed.replace(";12.000;0.5", ";12.000\n1;2;3;4;5;6;0.5");
        let mut loads = opened(text.as_bytes(), Told::default()).unwrap();
        assert!(loads.by_ref().all(|row| row.is_ok()));
        assert_eq!(loads.assumed().is_some(), is_told, "{text}");
    }
    let own = "time_s,fx_n,fy_n,fz_n,my_nm,mz_nm,speed_rpm,note\n1,2,3,4,5,6,7,a\n";
    let mut loads = opened(own.as_bytes(), Told::default()).unwrap();
    assert!(loads.by_ref().count() == 1 && loads.assumed().is_none());
}

/// Bytes flipped, cut and doubled: below the header every line is a row, a fault, or says nothing.
#[test]
fn no_record_is_lost_without_a_word() {
    let headers = [
        "time_s,fx_n,fy_n,fz_n,my_nm,mz_nm,speed_rpm,note\n",
        "of a program\nDate;1\nZeit [s];Fx [kN];Fy;Fz;My;Mz;n [1/min]\n",
        "Y_Unit_Label\tkN\tN\tN\tNm\tNm\nX_Value\tFx\tFy\tFz\tMy\tMz\trpm\ns\tkN\tN\tN\tNm\tNm\t1/min\n",
    ];
    for seed in 0..1500 {
        let mut random = Random::seeded(seed);
        let (which, whole) = (random.below(3), random.below(4) == 0);
        let separator = [",", ";", "\t"][which];
        let rows = "0.5,1.5,-2,\"3\",4,+ 5,6,\n7,6,5,4,3,2,1\n"
            .replace(',', separator)
            .repeat(4);
        // A first row that can be read, so that the header stays where it is.
        let first = ["1"; 7].join(separator) + "\n";
        let header = format!("{}{first}", headers[which]).into_bytes();
        let mut bytes = [&header[..], rows.as_bytes()].concat();
        let start = if whole { 0 } else { header.len() };
        for _ in 0..1 + random.below(4) {
            let at = start + random.below((bytes.len() - start).max(1));
            if at == bytes.len() {
                break;
            }
            match random.below(4) {
                0 => bytes[at] ^= 1 << random.below(8),
                1 => bytes.truncate(at.max(header.len()) + 1),
                2 => drop(bytes.remove(at)),
                _ => {
                    let end = (at + random.below(30)).min(bytes.len());
                    let doubled = bytes[at..end].to_vec();
                    bytes.splice(at..at, doubled);
                }
            }
        }
        let Ok(loads) = opened(&bytes, Told::default()) else {
            assert!(whole, "{seed}");
            continue;
        };
        let found = loads.count();
        if !whole {
            let says_something = |line: &&[u8]| match line.trim_ascii_start() {
                [b'#' | b'%', ..] => false,
                [b';', ..] if which != 1 => false,
                line => line.iter().any(|byte| !b",;\" \t\r\x1a".contains(byte)),
            };
            let lines = bytes[header.len()..].split(|byte| *byte == b'\n');
            assert_eq!(found, 1 + lines.filter(says_something).count(), "{seed}");
        }
    }
}

#[test]
fn one_record_of_so_many_is_read() {
    let text = "time_s,fx_n,fy_n,fz_n,my_nm,mz_nm,speed_rpm\n".to_owned()
        + &(0..10)
            .map(|i| format!("{i},2,3,4,5,6,7\n"))
            .collect::<String>();
    let every = Told {
        every: 4,
        ..Told::default()
    };
    let times: Vec<f64> = read(&text, every).iter().map(|row| row.time_s).collect();
    assert_eq!(times, [0.0, 4.0, 8.0]);
}

/// Loads away from the centre, and constant ones, are the same as their sum about the centre.
#[test]
fn loads_act_where_they_stand() {
    let bearing = "name = \"b\"\nballs = 16\nball_diameter_mm = 6.35\npitch_diameter_mm = 36\n\
                   inner_groove_radius_mm = 3.27025\nouter_groove_factor = 0.525\ncontact_angle_deg = 15\n";
    let more = "[load]\nposition_mm = -60\n[[constant_load]]\nposition_mm = 40\nfx_n = 5\nfy_n = -300\n\
                [[constant_load]]\nposition_mm = 0\nfz_n = 7\n";
    let file = DesignFile::parse("x", &format!("{bearing}{more}")).unwrap();
    assert!((file.design.inner_groove_factor - 0.515).abs() < 1e-15);
    let at = |file: &SpindleFile| -> Question {
        file.question(&row(0.0, [1.0, 100.0, 20.0, 0.5, 0.25], 0.0))
    };
    let expected = [
        6.0,
        -200.0,
        27.0,
        0.5 + 0.06 * 20.0,
        0.25 - 0.06 * 100.0 - 0.04 * 300.0,
    ];
    let close = |question: Question| {
        let pairs = question.load.into_iter().zip(expected);
        pairs.fold(0.0, |most: f64, (a, b)| most.max((a - b).abs())) < 1e-12
    };
    assert!(close(at(&SpindleFile::from(file))));
    let spindle = |design: &str, more: &str| {
        let text = format!(
            "name = \"s\"\n[[row]]\nposition_mm = 0\nfacing = \"+x\"\n[row.design]\n{design}\n{more}"
        );
        SpindleFile::parse("x", &text, Path::new(""))
    };
    assert!(close(at(&spindle(bearing, more).unwrap())));
    let error = spindle(&format!("{bearing}load = {{ position_mm = 1 }}"), "").unwrap_err();
    assert!(error.to_string().contains("a row has no loads"), "{error}");
    let both =
        DesignFile::parse("x", &format!("{bearing}inner_groove_factor = 0.515\n")).unwrap_err();
    assert!(
        both.to_string()
            .contains("say the same thing, and line 5 already says it"),
        "{both}"
    );
}

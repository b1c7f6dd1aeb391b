//! Recordings that are refused, or of which a row is, and how the refusal begins.

/// The header of a recording.
pub const HEADER: &str = "time_s,fx_n,fy_n,fz_n,my_nm,mz_nm,speed_rpm\n";

/// A recording with temperatures, as a spindle with `[heat]` takes it.
pub fn warmed(recording: &str) -> String {
    let (header, rows) = recording.split_once('\n').unwrap();
    let rows = rows.lines().map(|row| format!("{row},25,22\n"));
    format!("{header},t_inner_c,t_outer_c\n{}", rows.collect::<String>())
}

/// Texts that are no recordings, and the place and the reason that are given for each.
pub fn recordings() -> impl Iterator<Item = (String, &'static str)> {
    let row = "1,2,3,4,5,6,7";
    let header = HEADER.trim_end();
    let with = |from: &str, to: &str| format!("{}\n{row}\n", header.replace(from, to));
    let texts = [
        String::new(),
        "\n\n".to_owned(),
        format!("\n{HEADER}{row}\n"),
        "# 1\n# 2\n".to_owned(),
        "\u{feff}\n\0\u{1}\n".to_owned(),
        "t\0i\0m\0e\0".to_owned(),
        row.to_owned(),
        header.to_owned(),
        "time_s,fx_n,fz_n,my_nm\n".to_owned(),
        "Zeit,Kraft,Moment,n,a,b,c\n".to_owned(),
        format!("{header},time_s\n"),
        format!("{header},note,note\n"),
        with("time_s", "\"time_s"),
        // Another unit, none, another way to write it.
        with("time_s", "time_ms"),
        with("time_s", "time"),
        with("time_s", "Timestamp"),
        with("fx_n", "fx_kn"),
        with("fx_n", "Fx [V]"),
        with("fx_n", "fx"),
        with("my_nm", "my_mNm"),
        with("mz_nm", "mz_nmm"),
        with("speed_rpm", "rpm"),
        with("speed_rpm", "rpm_krpm"),
        with("speed_rpm", "speed [rad/s]"),
        with("speed_rpm", "speed_rpm,t_inner_k"),
        with("speed_rpm", "speed_rpm,probe_axial_mm"),
        with("speed_rpm", "speed_rpm,Probe axial [\u{b5}m]"),
        with("speed_rpm", "speed_rpm,probe_axial"),
        HEADER.to_uppercase(),
        // Lines that are no rows below the header.
        format!("{header}\n\"0,5\",2,3,4,5,6,7\n"),
        format!("{}\n0,5;2;3;4;5;6;7\n", header.replace(',', ";")),
        format!("{header}\ns,N,N,N,Nm,Nm,1/min\n{row}\n"),
        format!("clock,{}\n12:00:00,2,3,4,5,6,7\n", &header[7..]),
        format!("day,{}\n2025-11-14,2,3,4,5,6,7\n", &header[7..]),
        format!("{header}\n{}\n", "1".repeat(100_000)),
        format!("{header}\n{row}\ntime_s,fy_n,fx_n,fz_n,my_nm,mz_nm,speed_rpm\n{row}\n"),
    ];
    let starts = "\
line 1, column 1: the file is empty
line 1, column 1: the line is blank: there is no fx_n, fy_n, fz_n, my_nm, mz_nm, speed_rpm
line 1, column 1: the line is blank: there is no fx_n
line 1, column 1: the names are \"# 1\": there is no fx_n
line 1, column 1: the line is blank: there is no fx_n
line 1, column 1: byte 2 of the line is no UTF-8 text: save the file as UTF-8
line 1, column 1: the names are \"1\", \"2\", \"3\", \"4\", \"5\" and 2 more: there is no fx_n
there is no row below the header
line 1, column 1: the names are \"time_s\", \"fx_n\", \"fz_n\", \"my_nm\": there is no fy_n, mz_nm, speed_rpm
line 1, column 1: the names are \"Zeit\", \"Kraft\", \"Moment\", \"n\", \"a\" and 2 more: there is no fx_n
line 1, column 8: \"time_s\" is the name of another column, too: rename one
line 1, column 9: \"note\" is the name of another column, too: rename one
line 1, column 1: a quotation mark is opened but not closed
line 1, column 1: `time_ms`: the column `time_s` is due, in s: divide by 1000
line 1, column 1: `time`: the column `time_s` is due, in s: rename it if it is in s, convert it, or leave it out
line 1, column 1: `Timestamp`: the column `time_s` is due, in s: rename it if it is in s
column 2: `fx_kn`: the column `fx_n` is due, in N: multiply by 1000
column 2: `Fx [V]`: the column `fx_n` is due, in N: rename it if it is in N, convert it
column 2: `fx`: the column `fx_n` is due, in N: rename it if it is in N, convert it
column 5: `my_mNm`: the column `my_nm` is due, in Nm: rename it if it is in Nm, convert it
column 6: `mz_nmm`: the column `mz_nm` is due, in Nm: divide by 1000
column 7: `rpm`: the column `speed_rpm` is due, in rpm: rename it if it is in rpm
column 7: `rpm_krpm`: the column `speed_rpm` is due, in rpm: multiply by 1000
column 7: `speed [rad/s]`: the column `speed_rpm` is due, in rpm: multiply by 30 / pi
line 1, column 8: `t_inner_k`: the column `t_inner_c` is due, in degC: subtract 273.15
line 1, column 8: `probe_axial_mm`: the column `probe_axial_um` is due, in um: multiply by 1000
line 1, column 8: `Probe axial [\u{b5}m]`: the column `probe_axial_um` is due, in um: rename it
line 1, column 8: `probe_axial`: the column `probe_axial_um` is due, in um: rename it if it is in um
column 2: `FX_N`: the column `fx_n` is due, in N: rename it
line 2, column 1 (time_s): \"0,5\" is not a number with a decimal point: decimal commas and thousands separators are not read
line 2, column 1 (time_s): \"0,5\" is not a number with a decimal point: decimal commas and thousands separators are not read
line 2, column 1 (time_s): \"s\" is not a number
line 2, column 1: \"12:00:00\" is a time, and there is no time_s
line 2, column 1: \"2025-11-14\" is a time, and there is no time_s
line 2, column 1: the line is longer than
line 3, column 1: no column has a number: if another recording begins here, give it by itself";
    paired(texts, starts)
}

/// Texts with one row that cannot be read, and the place and the reason that are given for each.
pub fn rows() -> impl Iterator<Item = (String, &'static str)> {
    let row = "1,2,3,4,5,6,7";
    let header = HEADER.trim_end();
    let texts = [
        format!("{header}\n{row}\n1,2,three,4,5,6,7\n"),
        format!("{header}\n\n\n{row}\n\n1,2,3,4,5,6,7 rpm\n"),
        format!("{header}\r\n{row}\r\n1,2,3,4,,6,7\r\n"),
        format!("{header}\n{row}\n1,2,3,4,5\n"),
        format!("{header}\n{row},8\n"),
        format!("{header}\n0,5,2,3,4,5,6,7\n"),
        format!("{header}\n{row}\n1,2,3,\"4,5,6,7\n{row}\n"),
        format!("{header}\n{row}\n# more\n{row}\n"),
        format!("{header}\n{row}\n1,\"2'500,5\",3,4,5,6,7\n"),
        format!("{header}\n{row}\n1,\"2,500\",3,4,5,6,7\n"),
        format!("{header}\n{row}\n1,2,3,4,5\r,6,7\n"),
    ];
    let starts = "\
line 3, column 3 (fy_n): \"three\" is not a number
line 6, column 7 (speed_rpm): \"7 rpm\" is not a number
line 3, column 5 (my_nm): the field is empty
line 3, column 6 (mz_nm): the line ends after 5 of 7 fields
line 2, column 8: the line has 8 fields where the header has 7
line 2, column 8: the line has 8 fields where the header has 7
line 3, column 4: a quotation mark is opened but not closed
line 3, column 1 (time_s): \"# more\" is not a number
line 3, column 2 (fx_n): \"2'500,5\" is not a number with a decimal point: decimal commas and thousands separators are not read
line 3, column 2 (fx_n): \"2,500\" is not a number with a decimal point: decimal commas and thousands separators are not read
line 3, column 5: a carriage return in the middle of the line";
    paired(texts, starts)
}

/// Every text, and how the complaint about it begins.
fn paired<const N: usize>(
    texts: [String; N],
    starts: &'static str,
) -> impl Iterator<Item = (String, &'static str)> {
    assert_eq!(starts.lines().count(), N);
    texts.into_iter().zip(starts.lines())
}

//! Recordings that are refused, or of which a row is, and how the refusal begins.

/// The header of a recording.
pub const HEADER: &str = "time_s,fx_n,fy_n,fz_n,my_nm,mz_nm,speed_rpm\n";

/// Texts that are no recordings, and the place and the reason that are given for each.
pub fn recordings() -> impl Iterator<Item = (String, &'static str)> {
    let row = "1,2,3,4,5,6,7";
    let header = HEADER.trim_end();
    let with = |from: &str, to: &str| header.replace(from, to);
    let texts = [
        String::new(),
        "\n\n".to_owned(),
        with("fx_n", "Fx [V]"),
        with("my_nm", "My [N]"),
        with(",", ";"),
        format!("\n{HEADER}{row}\n"),
        "# 1\n# 2\n".to_owned(),
        "\u{feff}\n\0\u{1}\n".to_owned(),
        format!("{header},time_s\n"),
        "time_s,fx_n,fz_n,my_nm\n".to_owned(),
        row.to_owned(),
        header.to_owned(),
        format!("{header}\n\"0,5\",2,3,4,5,6,7\n"),
        format!("clock,{}\n12:00:00,2,3,4,5,6,7\n", &header[7..]),
        format!("{header}\n{}\n", "1".repeat(100_000)),
    ];
    let starts = "\
line 1, column 1: the file is empty
line 1 has none of the columns time_s,fx_n,fy_n,fz_n,my_nm,mz_nm,speed_rpm. Describe it
line 1, column 1: no column fx_n: add it, or give --fx
line 1, column 1: no column my_nm: add it, or give --my
line 1 has none of the columns
line 1 has none of the columns
line 1 has none of the columns
line 1 has none of the columns
line 1 has two columns \"time_s\"
line 1, column 1: no column fy_n: add it, or give --fy; no column mz_nm: add it, or give --mz; no column speed_rpm:
line 1 has none of the columns
there is no row below the header
below time_s, \"0,5\" is no number with a point
there is no time_s, but \"12:00:00\" is a time
line 2, column 1: the line is longer than";
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
line 3, column 2 (fx_n): \"2'500,5\" is not a number with a decimal point and without thousands separators
line 3, column 2 (fx_n): \"2,500\" is not a number with a decimal point and without thousands separators
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

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
        with("time_s", "tme_s"),
        format!("{header},t_inner_c,T_oil_K"),
        with("fx_n", "remark"),
        "# 1\n# 2\n".to_owned(),
        "\u{feff}\n\0\u{1}\n".to_owned(),
        format!("{header},time_s\n"),
        "time_s,fx_n,fz_n,my_nm,mz_nm,speed_rpm\n".to_owned(),
        row.to_owned(),
        format!("{header}\r{row}\r{row}\r"),
        format!("{header}\n{}\n", "1".repeat(100_000)),
    ];
    let starts = "\
line 1, column 1: the file is empty
line 2, column 1: the file is empty
line 1, column 1: \"Fx [V]\" has the unit V, which is none of N, kN, daN, lbf, kgf
line 1, column 1: my is in no column; columns that say nothing: \"My [N]\"
line 1, column 1: time is in no column; columns that say nothing: \"tme_s\"
line 1, column 1: t_outer is in no column; columns that say nothing: \"T_oil_K\"
line 1, column 1: fx is in no column; columns that say nothing: \"remark\"
line 2, column 1: the file is empty
line 2, column 1: fx is in no column; fy is in no column;
line 1, column 1: time may be \"time_s\" or \"time_s\"
line 1, column 1: fy is in no column. Say where each is, or its value, such as: cargo replay
line 1, column 1: fx is in no column; fy is in no column;
line 1, column 7: a carriage return in the middle of the line
line 2, column 1: the line is longer than";
    paired(texts, starts)
}

/// Texts with one row that cannot be read, and the place and the reason that are given for each.
pub fn rows() -> impl Iterator<Item = (String, &'static str)> {
    let row = "1,2,3,4,5,6,7";
    let header = HEADER.trim_end();
    let semicolons = HEADER.replace(',', ";");
    let texts = [
        format!("{header}\n{row}\n1,2,three,4,5,6,7\n"),
        format!("{header}\n\n\n{row}\n\n1,2,3,4,5,6,7 rpm\n"),
        format!("{header}\r\n{row}\r\n1,2,3,4,,6,7\r\n"),
        format!("{header}\n1,2,3,4,5\n"),
        format!("{header}\n{row},8\n"),
        format!("{header}\n0,5,2,3,4,5,6,7\n"),
        format!("{header}\n1,2,3,\"4,5,6,7\n{row}\n"),
        format!("# of a machine\n{header}\n# more\n\n{row}\n,2,3,4,5,6,7\n"),
        format!("{header}\n1,\"2'500,5\",3,4,5,6,7\n"),
        format!("{semicolons}1,5;2;3;4;5;6;7\n1.5;2;3;4;5;6;7\n"),
        format!("{semicolons}1.5;2;3;4;5;6;7\n1;2,500;3;4;5;6;7\n"),
        format!("{semicolons}1;2.500,5;3;4;5;6;7\n"),
        format!("{semicolons}1;2,5,5;3;4;5;6;7\n"),
        format!("{header}\n1,2,3,4,5\r,6,7\n"),
    ];
    let starts = "\
line 3, column 3 (fy_n): \"three\" is not a number
line 6, column 7 (speed_rpm): \"7 rpm\" is not a number
line 3, column 5 (my_nm): the field is empty
line 2, column 6 (mz_nm): the line ends after 5 of 7 fields
line 2, column 8: the line has 8 fields where the header has 7
line 2, column 8: the line has 8 fields where the header has 7
line 2, column 4: a quotation mark is opened but not closed
line 6, column 1 (time_s): the field is empty
line 2, column 2 (fx_n): \"2'500,5\" is not a number: it has thousands separators; write it without
line 3, column 1 (time_s): \"1.5\" has a point where numbers above have decimal commas
line 3, column 2 (fx_n): \"2,500\" has a comma where numbers above have decimal points
line 2, column 2 (fx_n): \"2.500,5\" is not a number: it has thousands separators
line 2, column 2 (fx_n): \"2,5,5\" is not a number
line 2, column 5: a carriage return in the middle of the line";
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

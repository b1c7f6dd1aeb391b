//! Recordings that are refused, and how the refusal begins.

/// The header of a recording.
pub const HEADER: &str = "time_s,fx_n,fy_n,fz_n,my_nm,mz_nm,speed_rpm\n";

/// Texts, and the place and the reason that are given for each.
pub fn recordings() -> Vec<(String, &'static str)> {
    let row = "1,2,3,4,5,6,7";
    let header = HEADER.trim_end();
    vec![
        (String::new(), "line 1, column 1: the file is empty"),
        ("\n\n".to_owned(), "line 2, column 1: the file is empty"),
        (
            "time_s,fx_n,fy_n,fz_n,my_nm,mz_nm,rpm\n".to_owned(),
            "line 1, column 7: \"rpm\" is none of the columns",
        ),
        (
            format!("{header},time_s\n"),
            "line 1, column 8 (time_s): the header has this column already as column 1",
        ),
        (
            "time_s,fx_n,fz_n,my_nm,mz_nm,speed_rpm\n".to_owned(),
            "line 1, column 7 (fy_n): the header lacks this column",
        ),
        (
            row.to_owned(),
            "line 1, column 1: \"1\" is none of the columns",
        ),
        (
            format!("{header}\n{row}\n1,2,three,4,5,6,7\n"),
            "line 3, column 3 (fy_n): \"three\" is not a number",
        ),
        (
            format!("{header}\n\n\n{row}\n\n1,2,3,4,5,6,7 rpm\n"),
            "line 6, column 7 (speed_rpm): \"7 rpm\" is not a number",
        ),
        (
            format!("{header}\r\n{row}\r\n1,2,3,4,,6,7\r\n"),
            "line 3, column 5 (my_nm): the field is empty",
        ),
        (
            format!("{header}\n1,2,3,4,5\n"),
            "line 2, column 6 (mz_nm): the line ends after 5 of 7 numbers",
        ),
        (
            format!("{header}\n{row},8\n"),
            "line 2, column 8: the line has 8 fields where the header has 7",
        ),
        (
            format!("{header}\n0,5,2,3,4,5,6,7\n"),
            "line 2, column 8: the line has 8 fields where the header has 7",
        ),
        (
            format!("{header}\n1,2,3,\"4,5,6,7\n{row}\n"),
            "line 2, column 4: a quotation mark is opened but not closed",
        ),
        (
            format!("{header}\r{row}\r{row}\r"),
            "line 1, column 7: a carriage return in the middle of the line",
        ),
        (
            format!("{header}\n{}\n", "1".repeat(100_000)),
            "line 2, column 1: the line is longer than",
        ),
    ]
}

//! Columns of a recording, and names that look like theirs.

/// A column of a recording.
#[derive(Debug, Clone, Copy)]
pub struct Quantity {
    /// Its name in the header.
    pub column: &'static str,
    /// Its name in summaries and options.
    pub name: &'static str,
    /// Its unit.
    pub unit: &'static str,
}

const fn quantity(column: &'static str, name: &'static str, unit: &'static str) -> Quantity {
    Quantity { column, name, unit }
}

/// All columns of a record but those of probes, in the order of the project's own recordings.
pub const OWN: [Quantity; 9] = [
    quantity("time_s", "time", "s"),
    quantity("fx_n", "fx", "N"),
    quantity("fy_n", "fy", "N"),
    quantity("fz_n", "fz", "N"),
    quantity("my_nm", "my", "Nm"),
    quantity("mz_nm", "mz", "Nm"),
    quantity("speed_rpm", "speed", "rpm"),
    quantity("t_inner_c", "t_inner", "degC"),
    quantity("t_outer_c", "t_outer", "degC"),
];

/// Columns before the temperatures.
pub const LOADS: usize = 7;

/// Our unit, another one in small letters, and what makes our numbers of it. Small letters do not tell `mN` from `MN`.
#[rustfmt::skip]
const OTHERS: [(&str, &str, &str); 20] = [
    ("s", "ms", "divide by 1000"), ("s", "us", "divide by 1e6"), ("s", "ns", "divide by 1e9"),
    ("s", "min", "multiply by 60"), ("s", "h", "multiply by 3600"), ("N", "kn", "multiply by 1000"),
    ("N", "dan", "multiply by 10"), ("N", "kgf", "multiply by 9.80665"), ("N", "lbf", "multiply by 4.4482216152605"),
    ("Nm", "nmm", "divide by 1000"), ("Nm", "ncm", "divide by 100"), ("Nm", "knm", "multiply by 1000"),
    ("rpm", "krpm", "multiply by 1000"), ("rpm", "hz", "multiply by 60"), ("rpm", "rads", "multiply by 30 / pi"),
    ("degC", "k", "subtract 273.15"), ("degC", "f", "subtract 32, and divide by 1.8"),
    ("um", "mm", "multiply by 1000"), ("um", "m", "multiply by 1e6"), ("um", "nm", "divide by 1000"),
];

/// The column that is due in the place of one that looks like it (`fx_kn`, `Fx [N]`, `time`, `probe_nose_mm`), and what to do.
pub fn due(name: &str) -> Option<(String, String)> {
    if name.starts_with("probe_") && name.ends_with("_um") {
        return None;
    }
    let plain = name.replace(['\u{b5}', '\u{3bc}'], "u");
    let words = plain.split(|c: char| !c.is_alphanumeric());
    let words: Vec<&str> = words.filter(|word| !word.is_empty()).collect();
    let plain = words.join("_");
    let small = match plain.to_ascii_lowercase() {
        t if ["t", "t_s", "t_ms", "t_us"].contains(&&*t) => t.replacen('t', "time", 1),
        rpm if rpm.starts_with("rpm") => rpm.replacen("rpm", "speed", 1),
        small => small,
    };
    let (column, ours, unit) = if let Some(probe) = small.strip_prefix("probe_") {
        let parts = probe.rsplit_once('_');
        let is_unit = |unit: &str| unit.len() == 1 || unit == "um" || advice("um", unit).is_some();
        let (name, unit) = parts
            .filter(|(_, unit)| is_unit(unit))
            .unwrap_or((probe, ""));
        let name = &plain["probe_".len()..][..name.len()];
        (format!("probe_{name}_um"), "um", unit)
    } else {
        let behind = |own: &Quantity| {
            let unit = small.strip_prefix(own.name)?;
            (unit.is_empty() || unit.starts_with('_')).then_some(unit)
        };
        let mut found = OWN.iter().filter_map(|own| Some((own, behind(own)?)));
        let time = || small.contains("time").then_some((&OWN[0], ""));
        let (own, unit) = found.next().or_else(time)?;
        (own.column.to_owned(), own.unit, unit)
    };
    let what = match advice(ours, &unit.replace('_', "")) {
        Some(advice) => advice.to_owned(),
        None if column == small => "rename it".to_owned(),
        None => format!("rename it if it is in {ours}, convert it, or leave it out"),
    };
    let what = format!("the column `{column}` is due, in {ours}: {what}");
    Some((column, what))
}

/// What makes our numbers of another unit.
fn advice(ours: &str, other: &str) -> Option<&'static str> {
    let mut others = OTHERS.iter();
    let found = others.find(|(of, name, _)| *of == ours && *name == other);
    found.map(|(.., advice)| *advice)
}

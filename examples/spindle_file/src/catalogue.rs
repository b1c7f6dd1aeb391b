//! Designs that one can name: makers' bearings with published ball data, and the files in `bearings`.

use crate::designs::DesignFile;
use crate::reading::{DesignFileError, alike};
use serde::Deserialize;
use spindle_bearing::FreeContact;
use std::fmt::Write;
use std::path::Path;

/// Before the name of one of GMN's bearings.
const GMN: &str = "gmn:";
/// Before the name of a design that comes with the project.
const PROJECT: &str = "project:";

/// Bearings of the maker GMN, as a table.
pub const GMN_S60: &str = include_str!("../makers/gmn_s60.csv");

/// A bearing of a maker's table, with the preloads of a pair of it.
#[derive(Debug, Clone, Deserialize)]
pub struct Listed {
    /// As the maker calls it.
    pub designation: String,
    /// Number of balls.
    pub balls: usize,
    /// Ball diameter, mm.
    pub ball_mm: f64,
    /// Pitch diameter, mm.
    pub pitch_mm: f64,
    /// Contact angle, degrees.
    pub contact_angle_deg: f64,
    bore_mm: f64,
    outside_mm: f64,
    preload_light_n: f64,
    preload_medium_n: f64,
    preload_strong_n: f64,
}

impl Listed {
    /// The name that the catalogue has for it.
    pub fn name(&self) -> String {
        format!("{GMN}{}", self.designation.replace(' ', ""))
    }

    /// The bearing, with groove factors of 0.515 and 0.525 assumed, of steel.
    ///
    /// # Errors
    ///
    /// A row of the table that is no bearing.
    pub fn design(&self) -> Result<DesignFile, DesignFileError> {
        let text = format!(
            "name = \"GMN {}\"\nballs = {}\nball_diameter_mm = {}\npitch_diameter_mm = {}\n\
             inner_groove_factor = 0.515\nouter_groove_factor = 0.525\ncontact_angle_deg = {}\n\
             bore_mm = {}\noutside_mm = {}\n",
            self.designation,
            self.balls,
            self.ball_mm,
            self.pitch_mm,
            self.contact_angle_deg,
            self.bore_mm,
            self.outside_mm
        );
        DesignFile::parse(&self.name(), &text)
    }
}

/// GMN's series S 60.
///
/// # Panics
///
/// If the table in `makers` is damaged, which a test excludes.
pub fn gmn_s60() -> Vec<Listed> {
    let mut reader = csv::ReaderBuilder::new()
        .comment(Some(b'#'))
        .from_reader(GMN_S60.as_bytes());
    let rows: Result<Vec<Listed>, csv::Error> = reader.deserialize().collect();
    rows.unwrap_or_else(|error| panic!("examples/spindle_file/makers/gmn_s60.csv: {error}"))
}

/// Designs that come with the project, and their files.
const SHIPPED: [(&str, &str); 5] = [
    ("project:7014c", include_str!("../bearings/7014c.toml")),
    ("project:b218", include_str!("../bearings/b218.toml")),
    ("project:b7005c", include_str!("../bearings/b7005c.toml")),
    (
        "project:b7005c-hybrid",
        include_str!("../bearings/b7005c-hybrid.toml"),
    ),
    ("project:skf6205", include_str!("../bearings/skf6205.toml")),
];

/// Small letters and no blanks.
fn plain(name: &str) -> String {
    name.split_whitespace().collect::<String>().to_lowercase()
}

/// All names.
fn names(listed: &[Listed]) -> Vec<String> {
    let shipped = SHIPPED.iter().map(|(name, _)| (*name).to_owned());
    listed.iter().map(Listed::name).chain(shipped).collect()
}

/// The names that are most like this one, as a question.
fn alike_names(name: &str) -> String {
    let (mut names, wanted) = (names(&gmn_s60()), plain(name));
    names.sort_by_key(|one| (usize::MAX - alike(&plain(one), &wanted), one.len()));
    format!(
        "did you mean {}? `cargo replay --list` has them all",
        names[..3].join(", ")
    )
}

/// The error of a file that cannot be read, which may be meant to be a bearing of the catalogue.
pub(crate) fn hint(path: &Path, mut error: DesignFileError) -> DesignFileError {
    let name = path.file_name().map(|name| name.to_string_lossy());
    let name = name.filter(|_| !path.exists() && path.extension().is_none());
    if let Some(name) = name {
        error.message += &format!("; nor is it in the catalogue; {}", alike_names(&name));
    }
    error
}

/// A bearing by its name, such as `gmn:S6014C` or `project:b7005c`; without the catalogue's name where the rest is
/// unique. Capital letters and blanks make no difference. `None` if that is no such name.
///
/// # Errors
///
/// A catalogue has no such bearing; the message has names that are alike.
pub fn find(name: &str) -> Option<Result<DesignFile, DesignFileError>> {
    let wanted = plain(name);
    let listed = gmn_s60();
    let names = names(&listed);
    let is = |one: &String| {
        let one = plain(one);
        one == wanted
            || one
                .split_once(':')
                .is_some_and(|(_, short)| short == wanted)
    };
    let found: Vec<usize> = (0..names.len()).filter(|i| is(&names[*i])).collect();
    let [found] = found[..] else {
        if !wanted.starts_with(GMN) && !wanted.starts_with(PROJECT) {
            return None;
        }
        return Some(Err(DesignFileError {
            file: name.to_owned(),
            place: None,
            message: format!("the catalogue has no such bearing; {}", alike_names(name)),
        }));
    };
    Some(match listed.get(found) {
        Some(listed) => listed.design(),
        None => {
            let (name, text) = SHIPPED[found - listed.len()];
            DesignFile::parse(name, text)
        }
    })
}

/// The catalogue as a table to read.
pub fn list() -> String {
    let mut text = String::from(
        "name                     bore outside balls   ball  pitch  angle       preload of a pair, N\n\
         \x20                          mm      mm           mm     mm    deg   light  medium  strong\n",
    );
    let gmn = gmn_s60().into_iter().map(|one| {
        let preloads = [
            one.preload_light_n,
            one.preload_medium_n,
            one.preload_strong_n,
        ];
        (one.name(), preloads.map(|n| format!("{n:8.0}")).concat())
    });
    for (name, preloads) in gmn.chain(SHIPPED.map(|(name, _)| (name.to_owned(), String::new()))) {
        let Some(Ok(DesignFile {
            balls,
            design,
            size_mm,
            ..
        })) = find(&name)
        else {
            continue;
        };
        let or_none = |x: Option<f64>, width| {
            x.map_or(format!("{:>width$}", "-"), |x| format!("{x:width$.0}"))
        };
        let angle = match design.free_contact {
            FreeContact::Angle(angle) => Some(angle.to_degrees()),
            FreeContact::DiametralClearance(_) => None,
        };
        let [bore, outside] = size_mm;
        let _ = writeln!(
            text,
            "{name:<24}{} {} {balls:5} {:6.3} {:6.1} {}{preloads}",
            or_none(bore, 5),
            or_none(outside, 7),
            1e3 * design.ball_diameter,
            1e3 * design.pitch_diameter,
            or_none(angle, 6),
        );
    }
    text.push_str(
        "\ngmn: series S 60 of GMN's catalogue 4000 0813 EN. Groove factors of 0.515 and 0.525 are assumed, shoulders are not\n\
         known. project: files of examples/spindle_file/bearings, each of which says where its figures come from. The name before the colon\n\
         may be left out where the rest is unique.\n",
    );
    text
}

//! Where each quantity of a recording is: found by the columns' names and by what a user says, or asked for.

use crate::preamble::listed;
use crate::told::{Heading, Quantity, Told};
use crate::units::{Dimension, Unit};
use std::fmt::Write;

/// The quantities of a row, in the order of the project's own files. Temperatures may lack.
pub const OWN: [Quantity; 9] = [
    Quantity::Time,
    Quantity::Fx,
    Quantity::Fy,
    Quantity::Fz,
    Quantity::My,
    Quantity::Mz,
    Quantity::Speed,
    Quantity::TInner,
    Quantity::TOuter,
];

/// Quantities without temperatures.
pub const LOADS: usize = 7;

/// Where the numbers of a quantity come from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Source {
    /// Nowhere: a temperature that nobody needs.
    None,
    /// A constant.
    Given(f64),
    /// Rows are counted.
    Count,
    /// A column.
    Field(Field),
}

/// A column that holds a quantity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Field {
    /// Its number, from 0.
    pub number: usize,
    /// Its unit, and whether somebody says so.
    pub unit: Unit,
    pub is_said: bool,
    /// The sign, and the factor of a user.
    pub factor: f64,
}

/// Columns that are not clear.
#[derive(Debug)]
pub struct Unclear {
    /// All that is wrong or missing.
    pub message: String,
    /// Options that would say what is missing; none if that is not the fault.
    pub options: String,
}

/// A quantity that is not known, and columns that may hold it.
struct Missing {
    recorded: Quantity,
    /// The bearing's quantity that is made of it.
    own: Quantity,
    fields: Vec<usize>,
}

/// Finds where each quantity comes from.
///
/// # Errors
///
/// All that is wrong or missing, at once.
pub fn find(headings: &[Heading], told: &Told) -> Result<[Source; OWN.len()], Unclear> {
    let (mut missing, mut faults) = (Vec::new(), Vec::new());
    let mut sources = [Source::None; OWN.len()];
    for (i, own) in OWN.into_iter().enumerate() {
        if let Some(value) = told.given[own as usize] {
            sources[i] = Source::Given(value);
            continue;
        }
        let (recorded, turn) = told.recorded(own);
        let (fields, factor) = match fields_of(headings, told, recorded) {
            Ok(found) => found,
            Err(fault) => {
                faults.push(fault);
                continue;
            }
        };
        let is_needed = i < LOADS || told.heat;
        match fields[..] {
            [number] => {
                let field = field(&headings[number], number, recorded, factor, &mut faults);
                let factor = turn * factor.unwrap_or(1.0);
                sources[i] = Source::Field(Field { factor, ..field });
            }
            [] if own == Quantity::Time && !may_have_time(headings, told) => {
                sources[i] = Source::Count;
            }
            [] if !is_needed => {}
            _ => missing.push(Missing {
                recorded,
                own,
                fields,
            }),
        }
    }
    let has = |i: usize| sources[i] != Source::None;
    if !told.heat && has(LOADS) != has(LOADS + 1) {
        // Temperatures are those of both sides.
        let own = OWN[if has(LOADS) { LOADS + 1 } else { LOADS }];
        missing.push(Missing {
            recorded: own,
            own,
            fields: Vec::new(),
        });
    }
    let is_measured = |i: usize| matches!(sources[i], Source::Field(_));
    if told.is_mirrored() && (4..6).any(is_measured) {
        let fault = "the axes are mirrored, which leaves the sign of moments open: turn one of them, or give --my and --mz";
        faults.push(fault.to_owned());
    }
    for (i, source) in sources.iter().enumerate() {
        let same = |other: &&Source| match (source, other) {
            (Source::Field(one), Source::Field(other)) => one.number == other.number,
            _ => false,
        };
        let other = sources[..i].iter().position(|other| same(&other));
        if let (Some(other), Source::Field(one), true) = (other, source, faults.is_empty()) {
            let names = [OWN[other], OWN[i]].map(Quantity::name);
            faults.push(format!(
                "{:?} is {} and {}",
                headings[one.number].text, names[0], names[1]
            ));
        }
    }
    if faults.is_empty() && missing.is_empty() {
        return Ok(sources);
    }
    Err(ask(headings, told, &faults, &missing))
}

/// The column, with its unit checked.
fn field(
    heading: &Heading,
    number: usize,
    recorded: Quantity,
    factor: Option<f64>,
    faults: &mut Vec<String>,
) -> Field {
    let dimension = recorded.dimension();
    // Who gives a factor has thought of the unit.
    let said = heading
        .unit
        .filter(|_| factor.is_none_or(|factor| factor.abs() == 1.0));
    let unit = said.unwrap_or(Unit::of(dimension));
    let strange = heading
        .strange_unit()
        .or((unit.dimension != dimension).then_some(unit.name()));
    let by_factor = factor.is_some_and(|factor| factor.abs() != 1.0);
    if let Some(strange) = strange.filter(|_| !by_factor) {
        let (text, units, name) = (&heading.text, Unit::names(dimension), recorded.name());
        let remedy = match recorded {
            Quantity::Time => "leave it out by --columns time=-, and rows are counted".to_owned(),
            _ => format!(
                "turn it into {} by --columns {name}={:?}",
                Unit::of(dimension).name(),
                format!("{text}*0.001")
            ),
        };
        faults.push(format!(
            "{text:?} has the unit {strange}, which is none of {units}; {remedy}"
        ));
    }
    Field {
        number,
        unit,
        is_said: said.is_some() || by_factor,
        factor: 1.0,
    }
}

/// The columns that may hold a quantity, and the factor that a user gives.
fn fields_of(
    headings: &[Heading],
    told: &Told,
    quantity: Quantity,
) -> Result<(Vec<usize>, Option<f64>), String> {
    let places = |is: &dyn Fn(&Heading) -> bool| -> Vec<usize> {
        (0..headings.len()).filter(|i| is(&headings[*i])).collect()
    };
    let named = |name: &str| places(&|heading| heading.text.eq_ignore_ascii_case(name));
    let mut columns = told.columns.iter();
    let Some((_, name)) = columns.find(|(one, _)| *one == quantity) else {
        let own = named(quantity.column());
        let fields = if own.is_empty() {
            places(&|heading| heading.means(quantity))
        } else {
            own
        };
        return Ok((fields, None));
    };
    if name == "-" {
        return Ok((Vec::new(), None));
    }
    let (bare, factor) = Told::split(name);
    for (name, factor) in [(&**name, None), (bare, Some(factor))] {
        let found = named(name);
        if !found.is_empty() {
            return Ok((found, factor));
        }
    }
    match bare
        .parse()
        .ok()
        .filter(|i| (1..=headings.len()).contains(i))
    {
        Some(number) => Ok((vec![number - 1], Some(factor))),
        None => {
            let all: Vec<String> = headings
                .iter()
                .map(|heading| heading.text.clone())
                .collect();
            Err(format!(
                "no column is called {bare:?}: there are {}",
                listed(&all)
            ))
        }
    }
}

/// Whether a column that is not understood may have the time.
fn may_have_time(headings: &[Heading], told: &Told) -> bool {
    let is_told = told.columns.iter().any(|(one, _)| *one == Quantity::Time);
    !is_told
        && headings
            .iter()
            .any(|heading| heading.may_be(Quantity::Time))
}

/// Asks for what is missing, besides what is wrong.
fn ask(headings: &[Heading], told: &Told, faults: &[String], missing: &[Missing]) -> Unclear {
    let is_silent = |heading: &&Heading| {
        let is_known = Quantity::ALL.iter().any(|one| heading.means(*one));
        !is_known && !heading.text.is_empty() && !told.names(&heading.text)
    };
    let silent: Vec<&Heading> = headings.iter().filter(is_silent).collect();
    let mut parts = faults.to_vec();
    let (mut columns, mut values) = (String::new(), String::new());
    for Missing {
        recorded,
        own,
        fields,
    } in missing
    {
        let names: Vec<String> = fields
            .iter()
            .map(|i| format!("{:?}", headings[*i].text))
            .collect();
        parts.push(match names[..] {
            [] => format!("{} is in no column", recorded.name()),
            _ => format!("{} may be {}", recorded.name(), names.join(" or ")),
        });
        let likely = silent
            .iter()
            .find(|heading| heading.may_be(*recorded))
            .copied();
        let likely = fields.first().map(|i| &headings[*i]).or(likely);
        let is_force = matches!(recorded.dimension(), Dimension::Time | Dimension::Force);
        let same = |heading: &Heading| {
            headings
                .iter()
                .filter(|one| one.text == heading.text)
                .count()
        };
        let name = match likely {
            // A name that several columns have is a number.
            Some(heading) if same(heading) > 1 => {
                let place = headings.iter().position(|one| one.text == heading.text);
                place.map_or(0, |place| place + 1).to_string()
            }
            Some(heading) => quoted(&heading.text),
            None if is_force && !silent.is_empty() => quoted("?"),
            None => {
                let value = match own.dimension() {
                    Dimension::Speed => "12000",
                    Dimension::Temperature => "25",
                    _ => "0",
                };
                let _ = write!(values, " --{} {value}", own.name());
                continue;
            }
        };
        let start = if columns.is_empty() {
            " --columns "
        } else {
            ","
        };
        let _ = write!(columns, "{start}{}={name}", recorded.name());
    }
    let mut message = parts.join("; ");
    if !missing.is_empty() {
        let names: Vec<String> = silent.iter().map(|heading| heading.text.clone()).collect();
        if !names.is_empty() {
            let _ = write!(message, "; columns that say nothing: {}", listed(&names));
        }
        message += ". Say where each is, or its value, such as";
    }
    Unclear {
        message,
        options: columns + &values,
    }
}

/// A name as a shell takes it.
fn quoted(name: &str) -> String {
    let mut quoted = String::new();
    for c in name.chars() {
        quoted.extend(['"', '\\', '$', '`'].contains(&c).then_some('\\'));
        quoted.push(c);
    }
    format!("\"{quoted}\"")
}

//! Spindles to try, and steps to take with them.

use crate::laws::common::{design, magnitude, number, settings, several, signed};
use arbitrary::{Arbitrary, Result, Unstructured};
use spindle_bearing::{Design, Facing, Preload, Section, Settings, Support};

/// Most rows of a spindle.
const MOST_ROWS: usize = 4;
/// Steps of one run, each of which makes a solve or prepares the next ones.
const MOST_STEPS: usize = 8;

/// A spindle, and what is asked of it.
#[derive(Debug)]
pub struct Run {
    /// Numbers of the precision, the motion and the arrangement.
    pub(crate) scene: [u8; 3],
    pub(crate) designs: [Design; 2],
    /// Of one to four rows.
    pub(crate) rows: Vec<Row>,
    /// Force of the spring, if there is one, relative to what the first bearing can take.
    pub(crate) spring: Option<f64>,
    /// The shaft, if it is elastic.
    pub(crate) shaft: Option<Elastic>,
    /// The default, or these.
    pub(crate) settings: Option<Settings<f64>>,
    pub(crate) steps: Vec<Step>,
}

impl Arbitrary<'_> for Run {
    fn arbitrary(u: &mut Unstructured) -> Result<Self> {
        let scene: [u8; 3] = u.arbitrary()?;
        Ok(Self {
            scene,
            designs: designs(u)?,
            rows: rows(u)?,
            spring: spring(u)?,
            shaft: (scene[0] >= 160).then(|| elastic(u)).transpose()?,
            settings: settings(u)?,
            steps: steps(u)?,
        })
    }
}

/// A row. Its distance is over the first bearing's pitch diameter; force and closure are over what that can take.
#[derive(Debug)]
pub(crate) struct Row {
    /// A row of the second bearing.
    pub(crate) second: bool,
    /// From the row before.
    pub(crate) distance: f64,
    pub(crate) facing: Facing,
    pub(crate) preload: Preload<f64>,
}

/// An elastic shaft: one section, and the support of every row. Lengths are over the first bearing's pitch diameter.
#[derive(Debug)]
pub(crate) struct Elastic {
    pub(crate) section: Section,
    pub(crate) support: Support<f64>,
}

/// Numbers relative to what the first bearing can take.
#[derive(Debug)]
pub(crate) enum Step {
    /// Loads and a speed.
    Solve([f64; 5], f64),
    /// The last loads and speed times these.
    Nudge([f64; 5], f64),
    /// Axial and radial growth of every row's rings, growth of its balls: for the solves to come.
    Grow([[f64; 3]; MOST_ROWS]),
    /// Displacements that are given in the place of loads, for the solves to come: these are not cut.
    Hold([Option<f64>; 5]),
    /// Iterations after which the solves to come are cut.
    Cut(Option<u8>),
    Reset,
}

/// Any two, or one for a spindle and another of about its size.
fn designs(u: &mut Unstructured) -> Result<[Design; 2]> {
    let first = match u.arbitrary()? {
        true => design(u)?,
        false => {
            let diameter = number(u, 3e-3, 20e-3)?;
            let pitch = diameter * number(u, 5.5, 9.0)?;
            Design::angular_contact(diameter, pitch, number(u, 0.2, 0.45)?)
        }
    };
    let second = match u.arbitrary()? {
        true => design(u)?,
        false => Design {
            ball_diameter: first.ball_diameter * number(u, 0.4, 1.0)?,
            ..first
        },
    };
    Ok([first, second])
}

fn rows(u: &mut Unstructured) -> Result<Vec<Row>> {
    let count = u.int_in_range(1..=MOST_ROWS)?;
    let row = |_| {
        let [second, facing, preload] = u.arbitrary::<[u8; 3]>()?;
        Ok(Row {
            second: second >= 192,
            distance: number(u, -0.5, 3.0)?,
            facing: [Facing::PlusX, Facing::MinusX][usize::from(facing % 2)],
            preload: match preload {
                0..=111 => Preload::Closure(signed(u, 1e-5, 0.3)?),
                112..=191 => Preload::Force(signed(u, 1e-7, 1e-2)?),
                192.. => Preload::Spring,
            },
        })
    };
    (0..count).map(row).collect()
}

fn spring(u: &mut Unstructured) -> Result<Option<f64>> {
    Ok(match u.ratio(1, 3)? {
        true => Some(signed(u, 1e-7, 1e-2)?),
        false => None,
    })
}

fn elastic(u: &mut Unstructured) -> Result<Elastic> {
    let outer = magnitude(u, 0.01, 3.0)?;
    let from = number(u, -5.0, 5.0)?;
    Ok(Elastic {
        section: Section {
            from,
            to: from + magnitude(u, 1e-3, 30.0)?,
            outer,
            inner: outer * number(u, 0.0, 0.99)?,
        },
        support: Support {
            axial: magnitude(u, 1e4, 1e15)?,
            radial: magnitude(u, 1e4, 1e15)?,
            tilting: magnitude(u, 0.1, 1e12)?,
        },
    })
}

/// A displacement in the place of every other load.
fn held(u: &mut Unstructured) -> Result<Option<f64>> {
    Ok(match u.arbitrary()? {
        true => Some(signed(u, 1e-9, 3.0)?),
        false => None,
    })
}

fn steps(u: &mut Unstructured) -> Result<Vec<Step>> {
    let mut steps = Vec::new();
    while steps.len() < MOST_STEPS && !u.is_empty() {
        steps.push(match u.int_in_range(0..=9)? {
            0..=2 => Step::Solve(several(|_| signed(u, 1e-9, 10.0))?, signed(u, 1e-4, 3.0)?),
            3 => Step::Hold(several(|_| held(u))?),
            4..=6 => Step::Nudge(several(|_| signed(u, 0.3, 3.0))?, signed(u, 0.3, 3.0)?),
            7 => Step::Grow(several(|_| several(|_| signed(u, 1e-6, 0.3)))?),
            8 => Step::Cut(u.arbitrary()?),
            _ => Step::Reset,
        });
    }
    Ok(steps)
}

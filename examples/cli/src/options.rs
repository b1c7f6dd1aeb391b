//! Options of a replay, by the names that the command line and the package of Python share.

use crate::lifetime::Lifetime;
use crate::replay::Job;
use anyhow::{Context, Result, bail, ensure};
use solvers::dispatch::{Attitude, Precision};
use solvers::{Balls, Choices};
use spindle_bearing::Limits;
use spindle_file::spindles::SpindleFile;
use spindle_monitor::tick::Core;

/// A value by its name, and what is said of it.
pub type Named<T> = (&'static str, &'static str, T);

/// Boards by name.
pub const BOARDS: [Named<Core>; 2] = [
    ("f405", "STM32F405", Core::STM32F405),
    ("h743", "STM32H743", Core::STM32H743),
];

/// Precisions by name.
pub const PRECISIONS: [Named<Precision>; 2] = [
    (
        "f32",
        "Single precision, as the firmware computes",
        Precision::F32,
    ),
    ("f64", "Double precision", Precision::F64),
];

/// Rules for the axis about which a ball turns, by name.
pub const ATTITUDES: [Named<Attitude>; 3] = [
    (
        "raceless",
        "Raceway-control-free: from d'Alembert's principle, which does not assume race control",
        Attitude::Raceless,
    ),
    (
        "outer",
        "Outer race control: no spin at the outer race",
        Attitude::Outer,
    ),
    (
        "inner",
        "Inner race control: no spin at the inner race; not for loads that lift balls off it",
        Attitude::Inner,
    ),
];

/// How the balls move, but for the rule of their attitude, by name.
pub const MOTIONS: [Named<Motion>; 3] = [
    (
        "static",
        "At rest: the speed counts for life and frequencies alone",
        Motion::Static,
    ),
    (
        "centrifugal",
        "Under centrifugal force alone",
        Motion::Centrifugal,
    ),
    ("full", "With all inertia loads", Motion::Full),
];

/// How the balls move.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Motion {
    /// At rest.
    Static,
    /// Under centrifugal force alone.
    Centrifugal,
    /// With all inertia loads.
    Full,
}

/// How long a record counts before a pause, by name.
pub const PAUSES: [Named<Pauses>; 2] = [
    ("end", "Count for one usual step", Pauses::End),
    (
        "hold",
        "Count until the next record: a list of held states",
        Pauses::Hold,
    ),
];

/// How long a record counts before a pause.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pauses {
    /// For one usual step.
    End,
    /// Until the next record.
    Hold,
}

/// How a recording is solved.
#[derive(Debug, Clone)]
pub struct Options {
    /// Precision to compute in.
    pub precision: Precision,
    /// Rule for the axis about which a ball turns.
    pub attitude: Attitude,
    /// How the balls move.
    pub motion: Motion,
    /// 5, or 3 with the tilts locked.
    pub freedoms: u8,
    /// Displacements at `x = 0` in the place of loads, such as `tz=0`.
    pub given: Vec<String>,
    /// Largest change of the stiffness along the last step; the library's own if there is none.
    pub tolerance: Option<f64>,
    /// Every row is solved from scratch.
    pub cold: bool,
    /// Peak contact pressure above which a row is marked, MPa.
    pub peak_pressure: f64,
    /// Friction force over contact force above which a row is marked.
    pub friction: f64,
    /// How long a record counts before a pause.
    pub pauses: Pauses,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            precision: Precision::F64,
            attitude: Attitude::Raceless,
            motion: Motion::Full,
            freedoms: 5,
            given: Vec::new(),
            tolerance: None,
            cold: false,
            peak_pressure: 4200.0,
            friction: Limits::<f64>::LUBRICATED_FRICTION,
            pauses: Pauses::End,
        }
    }
}

impl Options {
    /// How the balls move, and displacements that are given.
    ///
    /// # Errors
    ///
    /// Options that do not fit each other or the file.
    pub fn checked(&self, file: &SpindleFile) -> Result<(Balls, [Option<f64>; 5])> {
        let balls = match self.motion {
            Motion::Full => self.attitude.into(),
            _ if self.attitude != Attitude::Raceless => bail!(
                "--attitude makes no difference without gyroscopic moments; leave out it or --motion"
            ),
            Motion::Static => Balls::Static,
            Motion::Centrifugal => Balls::Centrifugal,
        };
        if let Some(tolerance) = self.tolerance {
            ensure!(
                tolerance > 0.0 && tolerance < 1.0,
                "--tolerance {tolerance}: it is 0 to 1"
            );
        }
        let held = self.held()?;
        ensure!(
            held == [None; 5] || file.plan.loaded_at() == 0.0,
            "--given and --freedoms 3 hold an elastic shaft at x = 0 where its loads act there; set [load] position_mm = 0, or \
             leave the option out"
        );
        Ok((balls, held))
    }

    /// The job that the options describe.
    pub fn job<'j>(
        &self,
        file: &'j SpindleFile,
        held: [Option<f64>; 5],
        select: Vec<String>,
        lifetime: Option<&'j mut Lifetime>,
    ) -> Job<'j> {
        Job {
            file,
            precision: self.precision,
            cold: self.cold,
            at_rest: self.motion == Motion::Static,
            select,
            choices: Choices {
                limits: Limits {
                    peak_pressure: self.peak_pressure * 1e6,
                    friction: self.friction,
                },
                tolerance: self.tolerance,
                ..Choices::default()
            },
            held,
            holds_pauses: self.pauses == Pauses::Hold,
            lifetime,
        }
    }

    /// Displacements that are given.
    ///
    /// # Errors
    ///
    /// A number of freedoms or a displacement that there is not, or one that is given twice.
    pub fn held(&self) -> Result<[Option<f64>; 5]> {
        let freedoms = self.freedoms;
        ensure!(
            [3, 5].contains(&freedoms),
            "--freedoms {freedoms}: they are 3 or 5"
        );
        let mut held = [None; 5];
        if freedoms == 3 {
            (held[3], held[4]) = (Some(0.0), Some(0.0));
        }
        for text in &self.given {
            let pair = text.split_once('=').and_then(|(name, value)| {
                let names = ["dx", "dy", "dz", "ty", "tz"];
                let freedom = names.iter().position(|one| *one == name.trim())?;
                Some((freedom, value.trim().parse().ok()?))
            });
            let (freedom, value) = pair.with_context(|| {
                format!(
                    "--given {text}: give dx, dy, dz (m), ty or tz (rad) a number, such as tz=0"
                )
            })?;
            ensure!(
                held[freedom].replace(value).is_none(),
                "--given {text}: it is held already, by --given or --freedoms 3"
            );
        }
        Ok(held)
    }
}

/// Times from and to which the monitor learns, s, such as `0:10`.
///
/// # Errors
///
/// Words that are no such times.
pub fn window(text: &str) -> Result<[f64; 2], String> {
    let numbers = text.split_once(':');
    let numbers = numbers.and_then(|(from, to)| Some([from.parse().ok()?, to.parse().ok()?]));
    let ordered = numbers.filter(|[from, to]: &[f64; 2]| from < to && to.is_finite());
    ordered.ok_or_else(|| "give seconds FROM:TO, such as 0:10".to_owned())
}

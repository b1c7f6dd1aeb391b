//! Rows of a spindle, its question, and why it is no spindle. A bearing is a spindle with one row.

use spindle_bearing::{
    Arrangement, Design, DesignError, Facing, Growth, Material, Preload, Section, ShaftLoad,
    Support,
};
use std::array::from_fn;
use std::fmt;
use std::ops::RangeInclusive;

/// Largest number of balls of a row.
pub const MOST_BALLS: usize = 64;

/// Ball counts that there is a bearing for.
pub const BALL_COUNTS: RangeInclusive<usize> = 3..=MOST_BALLS;

/// Largest number of rows.
pub const MOST_ROWS: usize = 8;

/// A row of a spindle.
#[derive(Debug, Clone)]
pub struct Row {
    /// Ball count.
    pub balls: usize,
    /// The bearing.
    pub design: Design,
    /// Position on the shaft, m.
    pub position: f64,
    /// How it faces.
    pub facing: Facing,
    /// How it is held.
    pub preload: Preload<f64>,
}

/// A spindle.
#[derive(Debug, Clone)]
pub struct Plan {
    /// The rows.
    pub rows: Vec<Row>,
    /// Arrangement that the rows claim to be.
    pub arrangement: Arrangement,
    /// Force of the spring, N.
    pub spring: Option<f64>,
    /// Preload of the mounted spindle, N, in the place of the rows' own, and growth of the rows there.
    pub mounted_preload: Option<(f64, Vec<Growth<f64>>)>,
    /// The shaft, if it is elastic.
    pub shaft: Option<ElasticShaft>,
}

/// An elastic shaft, and what is on it.
#[derive(Debug, Clone)]
pub struct ElasticShaft {
    /// Its sections.
    pub sections: Vec<Section>,
    /// Its material.
    pub material: Material,
    /// Support of each row.
    pub supports: Vec<Support<f64>>,
    /// Constant loads.
    pub loads: Vec<ShaftLoad<f64>>,
    /// Position where the loads of a question act, m.
    pub loaded_at: f64,
}

impl ElasticShaft {
    /// A shaft of steel, loaded at `x = 0` alone.
    pub fn of(sections: Vec<Section>, supports: Vec<Support<f64>>) -> Self {
        Self {
            sections,
            material: Material::STEEL,
            supports,
            loads: Vec::new(),
            loaded_at: 0.0,
        }
    }
}

/// Largest number of sections of a shaft.
pub const MOST_SECTIONS: usize = 64;

impl Plan {
    /// Rows on a rigid shaft, in an arrangement of their own.
    pub fn of(rows: Vec<Row>) -> Self {
        Self {
            rows,
            arrangement: Arrangement::ByRows,
            spring: None,
            mounted_preload: None,
            shaft: None,
        }
    }

    /// A bearing as the only row, which has the bits of a plain solver.
    pub fn alone(design: &Design, balls: usize) -> Self {
        Self::of(vec![Row {
            balls,
            design: *design,
            position: 0.0,
            facing: Facing::PlusX,
            preload: Preload::Closure(0.0),
        }])
    }

    /// Middle between the outermost rows, from which lengths grow with heat, m.
    pub fn middle(&self) -> f64 {
        let positions = || self.rows.iter().map(|row| row.position);
        let first = positions().fold(f64::INFINITY, f64::min);
        let last = positions().fold(f64::NEG_INFINITY, f64::max);
        0.5 * (first + last)
    }

    /// Position where the loads of a question act, and where displacements are given, m.
    pub fn loaded_at(&self) -> f64 {
        self.shaft.as_ref().map_or(0.0, |shaft| shaft.loaded_at)
    }
}

/// A point on the shaft where stiffness and displacement are wanted, like the nose.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ShaftEnd {
    /// Its position x, m.
    pub position: f64,
    /// Flexibility of the shaft itself there, besides its motion as a rigid body: displacement of each freedom (m, rad) per its force
    /// (N) or moment (N m).
    pub flexibility: [f64; 5],
}

impl ShaftEnd {
    /// A point of a rigid shaft, or of one that bends by its sections.
    pub const fn rigid(position: f64) -> Self {
        Self {
            position,
            flexibility: [0.0; 5],
        }
    }
}

/// Load, speed and growth that a spindle is solved for.
#[derive(Debug, Clone, Default)]
pub struct Question {
    /// `Fx, Fy, Fz, My, Mz` on the shaft at [`Plan::loaded_at`], N and N m.
    pub load: [f64; 5],
    /// Displacements there that are given in the place of loads, m and rad.
    pub held: [Option<f64>; 5],
    /// Shaft speed, rad/s.
    pub omega: f64,
    /// Growth of each row; none if there are fewer than rows.
    pub growth: Vec<Growth<f64>>,
    /// Axial growth of the shaft against the housing at the rows' middle from `x = 0` on, m. It is left out of `growth`, which
    /// counts from that middle, and is part of the displacement.
    pub middle_growth: f64,
    /// Points of the shaft at which stiffness and compliance are wanted besides `x = 0`.
    pub ends: Vec<ShaftEnd>,
}

impl Question {
    /// A load at a speed, rad/s, on rows that have not grown.
    pub fn load(load: [f64; 5], omega: f64) -> Self {
        Self {
            load,
            omega,
            ..Self::default()
        }
    }

    /// The displacements `u` in the place of the loads of freedoms that are `held`.
    #[must_use]
    pub fn holding(self, held: [bool; 5], u: [f64; 5]) -> Self {
        Self {
            held: from_fn(|i| held[i].then_some(u[i])),
            ..self
        }
    }

    /// With a point of the shaft that is wanted, too, and that does not yield.
    #[must_use]
    pub fn at(mut self, x: f64) -> Self {
        self.ends.push(ShaftEnd::rigid(x));
        self
    }

    /// Rows that have all grown alike.
    #[must_use]
    pub fn grown(self, growth: Growth<f64>) -> Self {
        Self {
            growth: vec![growth; MOST_ROWS],
            ..self
        }
    }
}

/// Part of a spindle that a key of its file gives. Rows and loads are counted from 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// Position of a row.
    Position(usize),
    /// Direction in which a row faces.
    Facing(usize),
    /// Closure of a row.
    Closure(usize),
    /// Whether a row slides under the spring.
    Slides(usize),
    /// Preload of all rows.
    Preload,
    /// Force of the spring.
    Spring,
    /// Position of a constant load.
    LoadPosition(usize),
    /// Force of a constant load, along x, y or z.
    LoadForce(usize, usize),
}

/// Why a spindle cannot be built.
#[derive(Debug, Clone, PartialEq)]
pub enum BuildError {
    /// The design of a row, counted from 0.
    Design(usize, DesignError),
    /// A part that does not fit the others, in the unit of files.
    Part(Part, String),
    /// The rows, as the solver says it.
    Spindle(String),
    /// Too many rows, or none.
    Rows(usize),
}

impl fmt::Display for BuildError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Design(row, error) => write!(f, "row {row}: {error}"),
            Self::Part(_, error) | Self::Spindle(error) => f.write_str(error),
            Self::Rows(rows) => write!(f, "{rows} rows: a spindle has 1 to {MOST_ROWS} here"),
        }
    }
}

impl std::error::Error for BuildError {}

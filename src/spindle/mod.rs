//! Bearings on a shaft, rigid or elastic.
//!
//! The shaft's axis is x, and loads act at `x = 0`, or at positions of their own. A row sits at its position, its balls pressed by
//! a load on the shaft in `+x` or in `-x`. Rows that face each other hold the shaft with a preload: outer rings that are clamped
//! closer than the free bearings would stand, or a sleeve that a spring pushes.
//!
//! All rows' balls are condensed into one system of the shaft's five freedoms, and a sixth for a sleeve, in the loop that
//! solves a single bearing. [`Spindle`] is what does not change, [`SpindleSolver`] solves it, [`SpindleSolution`] is what
//! comes of it.

pub mod arrangement;
pub mod build;
pub mod change;
pub mod elastic;
pub mod error;
pub mod sections;
pub mod solution;
pub mod solver;

use crate::bearing::Bearing;
use crate::real::Real;
use crate::rows::{BearingRef, Layout, Placed};
use crate::solver::problem::radius;
use crate::spindle::arrangement::Facing;
use crate::spindle::sections::OnShaft;

/// How a row is held against the others.
///
/// See [`Mounted`] for an example.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Preload<T> {
    /// Clamped: spacers and ring faces leave a closure `e` (m), by which the row's rings are moved into each other. 0 if
    /// they just touch, negative for a play. For a bearing that is given by its clearance, it counts from the middle of the
    /// play.
    Closure(T),
    /// Clamped, with the closure that gives a pair of such bearings this preload (N) on rigid seats, at rest, cold and without
    /// load: as rings are ground. Elastic supports leave less of it.
    Force(T),
    /// The outer ring sits in the sleeve that slides under the spindle's spring.
    Spring,
}

/// A bearing at its place on the shaft.
///
/// `N` is the largest number of balls that a row of the spindle has: a row with more does not compile.
///
/// ```
/// use spindle_bearing::{Arrangement, Bearing, Design, Facing, Mounted, Preload, Spindle};
///
/// const DESIGN: Design = Design::angular_contact(6.35e-3, 36e-3, 15_f64.to_radians());
/// static BEARING: Bearing<f32, 15> = Bearing::<f32, 15>::const_new(&DESIGN);
/// // Two rows in tandem against a third, at 0, 20 and 120 mm.
/// let preload = Preload::Force(200.0);
/// let row = |at, facing| Mounted::<f32, 15>::new(&BEARING, at, facing).with(preload);
/// let rows = [row(0.0, Facing::PlusX), row(0.02, Facing::PlusX), row(0.12, Facing::MinusX)];
/// let spindle = Spindle::new(Arrangement::BackToBack, rows);
/// assert!(spindle.is_ok());
/// assert!(Spindle::new(Arrangement::FaceToFace, rows).is_err());
/// ```
#[derive(Debug, Clone, Copy)]
pub struct Mounted<'b, T, const N: usize> {
    bearing: BearingRef<'b, T>,
    position: T,
    facing: Facing,
    preload: Preload<T>,
}

impl<'b, T: Real, const N: usize> Mounted<'b, T, N> {
    /// A bearing whose centre is at the position x (m) on the shaft; clamped, with its rings just touching.
    pub const fn new<const BALLS: usize>(
        bearing: &'b Bearing<T, BALLS>,
        position: T,
        facing: Facing,
    ) -> Self {
        const {
            assert!(
                BALLS <= N,
                "a row has more balls than the spindle has room for"
            )
        };
        Self {
            bearing: BearingRef {
                c: &bearing.constants,
                azimuths: bearing.azimuths(),
            },
            position,
            facing,
            preload: Preload::Closure(T::ZERO),
        }
    }

    /// This bearing, held by `preload`.
    pub const fn with(self, preload: Preload<T>) -> Self {
        Self { preload, ..self }
    }

    const fn slides(&self) -> bool {
        matches!(self.preload, Preload::Spring)
    }
}

/// Bearings on a shaft, rigid or elastic, ready to be solved: immutable, made once, by the compiler where the rows are known there
/// (`Spindle::const_new`).
///
/// `R` rows of at most `N` balls. `D` is 5, the shaft's freedoms, or 6 where a sleeve slides under a spring: a
/// [`SprungSpindle`]. `E` is 0, or `R` where the shaft bends: an [`ElasticSpindle`](crate::ElasticSpindle). Programs that learn all of
/// this when they run have more joints than rows: [`Spindle::of_rows`].
///
/// ```
/// use spindle_bearing::{Arrangement, Bearing, Design};
/// use spindle_bearing::{Preload, Settings, Speed, Spindle, SpindleSolver};
/// const DESIGN: Design = Design::angular_contact(11.906e-3, 90e-3, 15_f64.to_radians());
/// const BEARING: Bearing<f64, 20> = Bearing::<f64, 20>::const_new(&DESIGN);
/// let pair = Spindle::pair(Arrangement::BackToBack, &BEARING, 0.027, Preload::Force(294.0))?;
/// let mut solver = SpindleSolver::new();
/// let load = [0.0, 200.0, 0.0, 0.0, 0.0];
/// let solution = solver.solve(&pair, load, Speed::rpm(10_000.0), &Settings::default())?;
/// let nose = solution.compliance_at(-0.06);
/// println!("{:.0} N/um at the nose", 1e-6 / nose[1][1]);
/// for row in solution.rows() {
///     println!("{:.0} N of preload", row.preload());
/// }
/// # assert!(solution.rows().all(|row| row.preload() > 600.0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Copy)]
pub struct Spindle<'b, T, const R: usize, const N: usize, const D: usize = 5, const E: usize = 0> {
    layout: Layout<'b, T, R, true, E>,
    /// Force of the spring, N.
    spring: T,
    /// Position of the shaft's centre, m: the mean of the rows'; of an elastic shaft, the point between them that is nearest to
    /// `x = 0`.
    centre: T,
    /// The elastic shaft; without sections and loads if it is rigid.
    shaft: OnShaft<'b, T>,
}

/// A spindle of which some rows sit in a sleeve that slides under a spring: [`Spindle::sprung`].
pub type SprungSpindle<'b, T, const R: usize, const N: usize> = Spindle<'b, T, R, N, 6>;

impl<'b, T: Real, const R: usize, const N: usize, const D: usize, const E: usize>
    Spindle<'b, T, R, N, D, E>
{
    /// How the rows sit, with the position `x` (m) in the place of the shaft's centre, which is beyond it by the distance that is
    /// returned, over `Rp`.
    fn about(&self, x: T) -> (Layout<'b, T, R, true, E>, T) {
        let (mut layout, beyond) = (self.layout, self.centre - x);
        let distance = beyond / radius(layout.rows[0].bearing.c);
        layout.plane += distance;
        for Placed { bearing, mount, .. } in &mut layout.rows {
            mount.reach += mount.facing * (beyond / radius(bearing.c));
        }
        (layout, distance)
    }

    /// Closure `e` of each clamped row (m), given, or made by the preload force; 0 for a row that slides.
    pub fn closures(&self) -> impl ExactSizeIterator<Item = T> + '_ {
        self.layout
            .rows()
            .iter()
            .map(|row| row.mount.closure * row.bearing.c.length)
    }

    /// Positions of the rows on the shaft, m.
    pub fn positions(&self) -> impl ExactSizeIterator<Item = T> + '_ {
        self.layout.rows().iter().map(|row| row.position)
    }

    /// Number of balls of each row.
    pub fn ball_counts(&self) -> impl ExactSizeIterator<Item = u16> + '_ {
        self.layout
            .rows()
            .iter()
            .map(|row| row.bearing.azimuths.len() as u16)
    }

    /// How the rows face.
    pub fn facings(&self) -> impl ExactSizeIterator<Item = Facing> + '_ {
        self.layout
            .rows()
            .iter()
            .map(|row| Facing::of(row.mount.facing))
    }
}

#[cfg(feature = "defmt")]
impl<T: Real, const N: usize> defmt::Format for Mounted<'_, T, N> {
    fn format(&self, f: defmt::Formatter<'_>) {
        defmt::write!(
            f,
            "{} facing {}, {}",
            self.position,
            self.facing,
            self.preload
        );
    }
}

#[cfg(feature = "defmt")]
impl<T: Real, const R: usize, const N: usize, const D: usize, const E: usize> defmt::Format
    for Spindle<'_, T, R, N, D, E>
{
    fn format(&self, f: defmt::Formatter<'_>) {
        let rows = self.positions().zip(self.facings()).zip(self.closures());
        for ((position, facing), closure) in rows {
            defmt::write!(f, "{} facing {}, closure {}; ", position, facing, closure);
        }
    }
}

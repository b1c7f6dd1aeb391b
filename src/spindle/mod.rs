//! Bearings on a shaft, rigid or elastic.
//!
//! The shaft's axis is x, and loads act at `x = 0`. A row sits at its position with its balls pressed by a load on the shaft in
//! `+x` or in `-x`. Rows that face each other hold the shaft with a preload: outer rings that are clamped closer than the
//! free bearings would stand, or a sleeve that a spring pushes.
//!
//! All rows' balls are condensed into one system of the shaft's five freedoms, and a sixth for a sleeve, in the loop that
//! solves a single bearing. [`Spindle`] is what does not change, [`SpindleSolver`] solves it, [`SpindleSolution`] is what
//! comes of it.

pub mod arrangement;
pub mod elastic;
pub mod error;
pub mod sections;
pub mod solution;
pub mod solver;

use crate::bearing::{Bearing, Constants};
use crate::growth::Growth;
use crate::linalg::vector;
use crate::real::Real;
use crate::shaft::axial::AxialRest;
use crate::shaft::{BearingRef, Group, Layout, Mount};
use crate::solver::problem::{check, radius};
use crate::spindle::arrangement::{Arrangement, Facing};
use crate::spindle::error::SpindleError;
use crate::spindle::sections::OnShaft;
use crate::status::Quantity;

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
    pub fn new<const BALLS: usize>(
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
                azimuths: &bearing.azimuths,
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

    fn slides(&self) -> bool {
        matches!(self.preload, Preload::Spring)
    }

    /// How far its groove plane is in front of its centre, in `+x`, over the radius `rp`.
    fn plane(&self, rp: T) -> T {
        self.facing.sign::<T>() * self.bearing.c.plane * (radius(self.bearing.c) / rp)
    }

    /// Closure, in its unit of length; 0 if it slides.
    fn closure(&self) -> T {
        let c = self.bearing.c;
        match self.preload {
            Preload::Closure(e) => e / c.length,
            Preload::Force(force) => closure(c, force / c.force),
            Preload::Spring => T::ZERO,
        }
    }

    /// Refuses what is out of range of the row with this number. `spring` is its force, if there is one.
    fn check(&self, number: usize, first: &Self, spring: Option<T>) -> Result<(), SpindleError<T>> {
        let c = self.bearing.c;
        // Far from x = 0, the stiffness about that point is beyond all numbers.
        let farthest = T::of(4096.0) * radius(first.bearing.c);
        let position = check(Quantity::RowPosition, self.position, farthest);
        let most = c.balls * c.force;
        let half_play = c.play.at_least(T::ZERO).sqrt();
        let (held, force) = match self.preload {
            Preload::Closure(e) => (
                check(Quantity::Closure, e, (T::of(16.0) + half_play) * c.length),
                None,
            ),
            Preload::Force(force) => (check(Quantity::PreloadForce, force, most), Some(force)),
            Preload::Spring => {
                let force = spring.unwrap_or(T::ZERO);
                (check(Quantity::SpringForce, force, most), spring)
            }
        };
        position.and(held).map_err(|status| SpindleError::Row {
            row: number,
            status,
        })?;
        match force {
            Some(force) if !(force > T::ZERO) => Err(SpindleError::NoForce { row: number, force }),
            _ => Ok(()),
        }
    }
}

/// The rows that slide, or the fixed ones, and how the first of them faces.
fn group<T: Real, const N: usize>(
    rows: &[Mounted<'_, T, N>],
    sliding: bool,
) -> Option<(Facing, Group<T>)> {
    let mut of_group = rows.iter().enumerate();
    let (first, row) = of_group.find(|(_, row)| row.slides() == sliding)?;
    let mut group = Group {
        first,
        balls: row.bearing.c.balls,
        opposed: false,
    };
    for (_, other) in of_group.filter(|(_, row)| row.slides() == sliding) {
        group.balls += other.bearing.c.balls;
        group.opposed |= other.facing != row.facing;
    }
    Some((row.facing, group))
}

/// Fixed rows and sliding ones.
type Groups<T> = (Group<T>, Option<Group<T>>);

/// The fixed rows and the sliding ones, unless they do not hold the shaft.
fn groups<T: Real, const N: usize>(
    rows: &[Mounted<'_, T, N>],
    spring: bool,
) -> Result<Groups<T>, SpindleError<T>> {
    let Some((facing, fixed)) = group(rows, false) else {
        return Err(SpindleError::NotHeld);
    };
    let sliding = match (group(rows, true), spring) {
        (None, false) => None,
        (None, true) => return Err(SpindleError::NothingSlides),
        (Some((_, group)), false) => return Err(SpindleError::NoSpring { row: group.first }),
        (Some((other, group)), true) => {
            let faced = fixed.opposed || facing != other;
            if group.opposed || !faced {
                return Err(SpindleError::Unopposed { row: group.first });
            }
            Some(group)
        }
    };
    let preloaded = |row: &Mounted<'_, T, N>| matches!(row.preload, Preload::Force(_));
    match rows.iter().position(preloaded) {
        Some(row) if !fixed.opposed => Err(SpindleError::Unopposed { row }),
        _ => Ok((fixed, sliding)),
    }
}

/// Refuses rows that are not arranged like this, or where two are too near to each other.
fn check_arranged<T: Real, const N: usize>(
    arrangement: Arrangement,
    rows: &[Mounted<'_, T, N>],
) -> Result<(), SpindleError<T>> {
    let mut opposed = false;
    for (i, a) in rows.iter().enumerate() {
        for (j, b) in rows.iter().enumerate() {
            if i == j {
                continue;
            }
            let distance = (a.position - b.position).abs();
            let least = a.bearing.c.ball_radius.at_least(b.bearing.c.ball_radius);
            if !(distance >= least) {
                return Err(SpindleError::TooNear {
                    row: j,
                    distance,
                    least,
                });
            }
            if a.position < b.position && !arrangement.allows(a.facing, b.facing) {
                return Err(SpindleError::NotArranged {
                    arrangement,
                    row: j,
                    facing: b.facing,
                });
            }
            opposed |= a.facing != b.facing;
        }
    }
    let needs_both = matches!(
        arrangement,
        Arrangement::BackToBack | Arrangement::FaceToFace
    );
    match rows.last() {
        Some(last) if needs_both && !opposed => Err(SpindleError::NotArranged {
            arrangement,
            row: rows.len() - 1,
            facing: last.facing,
        }),
        _ => Ok(()),
    }
}

/// Bearings on a shaft, rigid or elastic, ready to be solved: immutable, made once.
///
/// `R` rows of at most `N` balls. `D` is 5, the shaft's freedoms, or 6 where a sleeve slides under a spring: a
/// [`SprungSpindle`].
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
    positions: [T; R],
    facings: [Facing; R],
    /// Force of the spring, N.
    spring: T,
    /// Position of the shaft's centre, m: the mean of the rows'; of an elastic shaft, the point between them that is nearest to
    /// `x = 0`.
    centre: T,
    /// The elastic shaft, at each of its rows.
    shaft: [OnShaft<'b, T>; E],
}

/// A spindle of which some rows sit in a sleeve that slides under a spring: [`Spindle::sprung`].
pub type SprungSpindle<'b, T, const R: usize, const N: usize> = Spindle<'b, T, R, N, 6>;

impl<'b, T: Real, const N: usize> Spindle<'b, T, 1, N, 5> {
    /// A single bearing at `x = 0`, pressed by a load in `+x`: what a [`Solver`](crate::Solver) solves, with the same bits.
    pub fn single(bearing: &'b Bearing<T, N>) -> Self {
        let row = Mounted::new(bearing, T::ZERO, Facing::PlusX);
        let group = Group {
            first: 0,
            balls: row.bearing.c.balls,
            opposed: false,
        };
        Self::mounted(&[row], &row, group, None, T::ZERO)
    }
}

impl<'b, T: Real, const N: usize> Spindle<'b, T, 2, N, 5> {
    /// Two equal bearings, the first at `x = 0`, the second at this distance (m) in `+x`.
    ///
    /// # Errors
    ///
    /// As for [`Spindle::new`].
    pub fn pair(
        arrangement: Arrangement,
        bearing: &'b Bearing<T, N>,
        distance: T,
        preload: Preload<T>,
    ) -> Result<Self, SpindleError<T>> {
        let [first, second] = arrangement.of_pair();
        let rows = [
            Mounted::new(bearing, T::ZERO, first).with(preload),
            Mounted::new(bearing, distance, second).with(preload),
        ];
        Self::new(arrangement, rows)
    }
}

impl<'b, T: Real, const R: usize, const N: usize> Spindle<'b, T, R, N, 5> {
    /// Rows that are clamped, in an arrangement that is checked.
    ///
    /// # Errors
    ///
    /// A figure of a row that is out of range, or why the rows are not so arranged.
    pub fn new(
        arrangement: Arrangement,
        rows: [Mounted<'b, T, N>; R],
    ) -> Result<Self, SpindleError<T>> {
        Self::of(arrangement, &rows, T::ZERO)
    }
}

impl<'b, T: Real, const R: usize, const N: usize> Spindle<'b, T, R, N, 6> {
    /// Rows of which some sit in a sleeve that slides along the shaft under a spring of this force (N), in an arrangement that
    /// is checked. Its solver is a [`SpindleSolver`](crate::SpindleSolver) with `D = 6`.
    ///
    /// ```
    /// use spindle_bearing::{Arrangement, Bearing, Design, Facing, Mounted, Preload, Settings, Speed};
    /// use spindle_bearing::{SpindleSolver, Spindle};
    ///
    /// const DESIGN: Design = Design::angular_contact(6.35e-3, 36e-3, 15_f64.to_radians());
    /// static BEARING: Bearing<f32, 15> = Bearing::<f32, 15>::const_new(&DESIGN);
    /// let front = Mounted::<f32, 15>::new(&BEARING, 0.0, Facing::PlusX);
    /// let rear = Mounted::new(&BEARING, 0.1, Facing::MinusX).with(Preload::Spring);
    /// let set = Spindle::sprung(Arrangement::BackToBack, [front, rear], 200.0)?;
    /// let mut solver = SpindleSolver::new();
    /// let solution = solver.solve(&set, [0.0, 150.0, 0.0, 0.0, 0.0], Speed::rpm(20_000.0), &Settings::default())?;
    /// assert!(solution.spring_closure() > 0.0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    ///
    /// A figure of a row that is out of range, or why the rows are not so arranged.
    pub fn sprung(
        arrangement: Arrangement,
        rows: [Mounted<'b, T, N>; R],
        force: T,
    ) -> Result<Self, SpindleError<T>> {
        Self::of(arrangement, &rows, force)
    }
}

impl<'b, T: Real, const R: usize, const N: usize, const D: usize> Spindle<'b, T, R, N, D> {
    fn of(
        arrangement: Arrangement,
        rows: &[Mounted<'b, T, N>; R],
        spring: T,
    ) -> Result<Self, SpindleError<T>> {
        let Some(first) = rows.first() else {
            return Err(SpindleError::NoRow);
        };
        // Positions and closures first: they are compared below.
        for (number, row) in rows.iter().enumerate() {
            let spring = (D == 6).then_some(spring);
            row.check(number, first, spring)?;
        }
        check_arranged(arrangement, rows)?;
        let (fixed, sliding) = groups(rows, D == 6)?;
        Ok(Self::mounted(rows, first, fixed, sliding, spring))
    }

    /// Rows that hold the shaft, on their mounts; the `first` one has the units.
    #[inline]
    fn mounted(
        rows: &[Mounted<'b, T, N>; R],
        first: &Mounted<'b, T, N>,
        fixed: Group<T>,
        sliding: Option<Group<T>>,
        spring: T,
    ) -> Self {
        let unit = first.bearing.c;
        let rp = radius(unit);
        let (mut centre, mut plane, mut count) = (T::ZERO, T::ZERO, T::ZERO);
        for row in rows {
            centre += row.position;
            plane += row.plane(rp);
            count += T::ONE;
        }
        let mut set = Self {
            layout: Layout {
                bearings: rows.each_ref().map(|row| row.bearing),
                mounts: [Mount::PLAIN; R],
                fixed,
                sliding,
                plane: plane / count,
                ball_count: T::ZERO,
                preload_at_rest: T::ZERO,
                joints: [],
                mark: spring.mix(0),
            },
            positions: rows.each_ref().map(|row| row.position),
            facings: rows.each_ref().map(|row| row.facing),
            spring,
            centre: centre / count,
            shaft: [],
        };
        let layout = &mut set.layout;
        for (mount, row) in layout.mounts.iter_mut().zip(rows) {
            let c = row.bearing.c;
            let (facing, off) = (row.facing.sign::<T>(), row.position - set.centre);
            *mount = Mount {
                facing,
                length: unit.length / c.length,
                force: c.force / unit.force,
                lever: (off / rp + row.plane(rp)) - layout.plane,
                reach: facing * (off / radius(c)) + c.plane,
                arm: radius(c) / rp,
                inertia: c.inertia / unit.inertia,
                closure: row.closure(),
                sliding: row.slides(),
            };
            layout.mark = mount
                .closure
                .mix(row.position.mix(facing.mix(layout.mark ^ c.mark)));
            if mount.sliding {
                layout.mark = !layout.mark;
            }
            layout.ball_count += c.balls * (mount.force * mount.inertia);
            let axial = c.balls * force_at(c, mount.closure).at_least(T::ZERO);
            layout.preload_at_rest += mount.force * (axial + c.preload);
        }
        set
    }
}

impl<'b, T: Real, const R: usize, const N: usize, const D: usize, const E: usize>
    Spindle<'b, T, R, N, D, E>
{
    /// How the rows sit, with the position `x` (m) in the place of the shaft's centre, which is beyond it by the distance that is
    /// returned, over `Rp`.
    fn about(&self, x: T) -> (Layout<'b, T, R, true, E>, T) {
        let (mut layout, beyond) = (self.layout, self.centre - x);
        let distance = beyond / radius(layout.bearings[0].c);
        layout.plane += distance;
        for (mount, row) in layout.mounts.iter_mut().zip(&layout.bearings) {
            mount.reach += mount.facing * (beyond / radius(row.c));
        }
        (layout, distance)
    }

    /// Closure `e` of each clamped row (m), given, or made by the preload force; 0 for a row that slides.
    pub fn closures(&self) -> [T; R] {
        vector(|i| self.layout.mounts[i].closure * self.layout.bearings[i].c.length)
    }

    /// Positions of the rows on the shaft, m.
    pub fn positions(&self) -> [T; R] {
        self.positions
    }

    /// How the rows face.
    pub fn facings(&self) -> [Facing; R] {
        self.facings
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
        defmt::write!(
            f,
            "{} facing {}, closures {}",
            self.positions,
            self.facings,
            self.closures()
        );
    }
}

/// Axial displacement of a bearing at rest, cold, under an axial load, both in its units.
fn closure<T: Real>(c: &Constants<T>, load: T) -> T {
    let balls = AxialRest::new(c, &Growth::NONE);
    let loaded = balls.root(T::HUGE, load / c.balls, T::EPSILON * T::EPSILON, 64);
    balls.displacement(&loaded.centres, false)
}

/// Axial force on a ball of a bearing at rest, cold, at an axial displacement, both in its units.
fn force_at<T: Real>(c: &Constants<T>, dx: T) -> T {
    let balls = AxialRest::new(c, &Growth::NONE);
    let contact = balls.contact(&balls.centres_at(dx));
    contact.q * contact.n[0]
}

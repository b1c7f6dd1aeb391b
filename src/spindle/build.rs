//! How rows become a spindle, when a program runs or by the compiler.
//!
//! A `const fn` cannot be generic over the precision. So each function is written once, in a macro, and is there three times: for
//! any precision, and for each in the compiler. Single precision has no arithmetic in doubles.

use crate::bearing::{Bearing, Constants, L0, mix as mix_bits};
use crate::const_math::{sqrt_f32, sqrt_f64};
use crate::design::check;
use crate::real::{Float, Real};
use crate::rows::row::Mount;
use crate::rows::{BearingRef, Group, Layout, Placed};
use crate::spindle::arrangement::{Arrangement, Facing};
use crate::spindle::error::SpindleError;
use crate::spindle::sections::OnShaft;
use crate::spindle::{Mounted, Preload, Spindle, SprungSpindle};
use crate::status::Quantity;

impl<'b, T: Real, const N: usize> Spindle<'b, T, 1, N, 5> {
    /// A single bearing at `x = 0`, pressed by a load in `+x`: what a [`Solver`](crate::Solver) solves, with the same bits.
    pub fn single(bearing: &'b Bearing<T, N>) -> Self {
        let row = Mounted::new(bearing, T::ZERO, Facing::PlusX);
        let group = Group {
            first: 0,
            balls: row.bearing.c.balls,
            opposed: false,
        };
        any::mounted(&[row], &row, group, None, None)
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
        any::set(arrangement, &rows, None)
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
        any::set(arrangement, &rows, Some(force))
    }
}

/// Fixed rows and sliding ones.
type Groups<T> = (Group<T>, Option<Group<T>>);

/// `build!(module, precision, [if generic], [if const], { elementary functions })`
macro_rules! build {
    ($module:ident, $t:ident, [$($any:ident)?], [$($const:tt)?], { $($elementary:item)* }) => {
/// Spindles of this precision.
pub mod $module {
    use super::*;

    $($elementary)*

    #[inline(always)]
    pub $($const)? fn at_least$(<$any: Real>)?(a: $t, b: $t) -> $t {
        if b > a { b } else { a }
    }

    #[inline(always)]
    pub $($const)? fn at_most$(<$any: Real>)?(a: $t, b: $t) -> $t {
        if b < a { b } else { a }
    }

    /// `Rp`, m.
    #[inline(always)]
    pub $($const)? fn radius$(<$any: Real>)?(c: &Constants<$t>) -> $t {
        c.length / c.tilt
    }

    #[inline(always)]
    $($const)? fn sign$(<$any: Real>)?(facing: Facing) -> $t {
        match facing {
            Facing::PlusX => $t::ONE,
            Facing::MinusX => -$t::ONE,
        }
    }

    /// Refuses a figure of a row that is less than `least`, more than `most`, or no number.
    pub $($const)? fn check_figure$(<$any: Real>)?(
        row: usize,
        quantity: Quantity,
        value: $t,
        least: $t,
        most: $t,
    ) -> Result<(), SpindleError<$t>> {
        if value >= least && value <= most {
            return Ok(());
        }
        Err(SpindleError::Row { row, quantity, value, least, most })
    }

    /// Rows that are clamped, and rows that slide under a spring of this force (N), which takes `D` of 6, in an arrangement that is
    /// checked.
    pub $($const)? fn set<'b, $($any: Real,)? const R: usize, const N: usize, const D: usize>(
        arrangement: Arrangement,
        rows: &[Mounted<'b, $t, N>],
        spring: Option<$t>,
    ) -> Result<Spindle<'b, $t, R, N, D>, SpindleError<$t>> {
        let Some(first) = rows.first() else {
            return Err(SpindleError::NoRow);
        };
        if rows.len() > R {
            return Err(SpindleError::TooManyRows { rows: rows.len(), most: R });
        }
        // Positions and closures first: they are compared below.
        let mut row = 0;
        while row < rows.len() {
            check!(check_row(row, &rows[row], first, spring));
            row += 1;
        }
        check!(check_arranged(arrangement, rows));
        let (fixed, sliding) = check!(groups(rows, spring.is_some()));
        Ok(mounted(rows, first, fixed, sliding, spring))
    }

    /// Refuses what is out of range of the row with this number. `spring` is its force, if there is one.
    $($const)? fn check_row<$($any: Real,)? const N: usize>(
        number: usize,
        row: &Mounted<'_, $t, N>,
        first: &Mounted<'_, $t, N>,
        spring: Option<$t>,
    ) -> Result<(), SpindleError<$t>> {
        let c = row.bearing.c;
        // Far from x = 0, the stiffness about that point is beyond all numbers.
        let farthest = radius(first.bearing.c) * of(4096.0);
        let most = c.balls * c.force;
        let half_play = sqrt(at_least(c.play, $t::ZERO));
        let closure = (half_play + of(16.0)) * c.length;
        check!(check_figure(number, Quantity::RowPosition, row.position, -farthest, farthest));
        match (row.preload, spring) {
            (Preload::Closure(e), _) => check_figure(number, Quantity::Closure, e, -closure, closure),
            (Preload::Force(force), _) => check_figure(number, Quantity::PreloadForce, force, $t::TINY, most),
            (Preload::Spring, Some(force)) => check_figure(number, Quantity::SpringForce, force, $t::TINY, most),
            (Preload::Spring, None) => Ok(()),
        }
    }

    /// Refuses rows that are not arranged like this, or where two are too near to each other.
    $($const)? fn check_arranged<$($any: Real,)? const N: usize>(
        arrangement: Arrangement,
        rows: &[Mounted<'_, $t, N>],
    ) -> Result<(), SpindleError<$t>> {
        let (mut opposed, mut i) = (false, 0);
        while i < rows.len() {
            let (a, mut j) = (&rows[i], 0);
            while j < rows.len() {
                let (b, row) = (&rows[j], j);
                j += 1;
                if i == row {
                    continue;
                }
                let off = b.position - a.position;
                let distance = at_least(off, -off);
                let least = at_least(a.bearing.c.ball_radius, b.bearing.c.ball_radius);
                check!(check_figure(row, Quantity::RowDistance, distance, least, $t::INFINITY));
                if a.position < b.position && !arrangement.allows(a.facing, b.facing) {
                    return Err(SpindleError::NotArranged { arrangement, row, facing: b.facing });
                }
                opposed |= !a.facing.is(b.facing);
            }
            i += 1;
        }
        let needs_both = matches!(arrangement, Arrangement::BackToBack | Arrangement::FaceToFace);
        match rows.last() {
            Some(last) if needs_both && !opposed => {
                Err(SpindleError::NotArranged { arrangement, row: rows.len() - 1, facing: last.facing })
            }
            _ => Ok(()),
        }
    }

    /// The rows that slide, or the fixed ones, and how the first of them faces.
    $($const)? fn group<$($any: Real,)? const N: usize>(
        rows: &[Mounted<'_, $t, N>],
        sliding: bool,
    ) -> Option<(Facing, Group<$t>)> {
        let (mut found, mut first) = (None::<(Facing, Group<$t>)>, 0);
        while first < rows.len() {
            let (row, balls) = (&rows[first], rows[first].bearing.c.balls);
            match &mut found {
                _ if row.slides() != sliding => {}
                None => found = Some((row.facing, Group { first, balls, opposed: false })),
                Some((facing, group)) => {
                    group.balls += balls;
                    group.opposed |= !facing.is(row.facing);
                }
            }
            first += 1;
        }
        found
    }

    /// The fixed rows and the sliding ones, unless they do not hold the shaft.
    $($const)? fn groups<$($any: Real,)? const N: usize>(
        rows: &[Mounted<'_, $t, N>],
        spring: bool,
    ) -> Result<Groups<$t>, SpindleError<$t>> {
        let Some((facing, fixed)) = group(rows, false) else {
            return Err(SpindleError::NotHeld);
        };
        let sliding = match (group(rows, true), spring) {
            (None, false) => None,
            (None, true) => return Err(SpindleError::NothingSlides),
            (Some((_, group)), false) => return Err(SpindleError::NoSpring { row: group.first }),
            (Some((other, group)), true) => {
                let faced = fixed.opposed || !facing.is(other);
                if group.opposed || !faced {
                    return Err(SpindleError::Unopposed { row: group.first });
                }
                Some(group)
            }
        };
        let mut row = 0;
        while row < rows.len() {
            if matches!(rows[row].preload, Preload::Force(_)) && !fixed.opposed {
                return Err(SpindleError::Unopposed { row });
            }
            row += 1;
        }
        Ok((fixed, sliding))
    }

    /// Rows that hold the shaft, at most `R`, on their mounts; the `first` one has the units.
    pub $($const)? fn mounted<'b, $($any: Real,)? const R: usize, const N: usize, const D: usize>(
        rows: &[Mounted<'b, $t, N>],
        first: &Mounted<'b, $t, N>,
        fixed: Group<$t>,
        sliding: Option<Group<$t>>,
        spring: Option<$t>,
    ) -> Spindle<'b, $t, R, N, D> {
        let unit = first.bearing.c;
        let rp = radius(unit);
        let spring = match spring {
            Some(force) => force,
            None => $t::ZERO,
        };
        let mut set = Spindle {
            layout: Layout {
                rows: [Placed {
                    bearing: BearingRef { c: unit, azimuths: &[] },
                    mount: Mount::PLAIN,
                    position: first.position,
                }; R],
                fixed,
                sliding,
                plane: $t::ZERO,
                ball_count: $t::ZERO,
                preload_at_rest: $t::ZERO,
                joints: [],
                fingerprint: mix(0, spring),
                count: rows.len() as u16,
                bends: false,
            },
            spring,
            centre: $t::ZERO,
            shaft: OnShaft::NONE,
        };
        let (layout, mut count, mut i) = (&mut set.layout, $t::ZERO, 0);
        while i < rows.len() {
            set.centre += rows[i].position;
            layout.plane += plane(&rows[i], rp);
            count += $t::ONE;
            i += 1;
        }
        set.centre = set.centre / count;
        layout.plane = layout.plane / count;
        i = 0;
        while i < rows.len() {
            let (row, c) = (&rows[i], rows[i].bearing.c);
            let (facing, off) = (sign(row.facing), row.position - set.centre);
            let mount = Mount {
                facing,
                length: unit.length / c.length,
                force: c.force / unit.force,
                lever: (off / rp + plane(row, rp)) - layout.plane,
                reach: facing * (off / radius(c)) + c.plane,
                arm: radius(c) / rp,
                inertia: c.inertia / unit.inertia,
                closure: closure(row),
                sliding: row.slides(),
            };
            layout.fingerprint = mix(mix(mix(layout.fingerprint ^ c.fingerprint, facing), row.position), mount.closure);
            if mount.sliding {
                layout.fingerprint = !layout.fingerprint;
            }
            layout.ball_count += c.balls * (mount.force * mount.inertia);
            let axial = c.balls * at_least(force_at(c, mount.closure), $t::ZERO);
            layout.preload_at_rest += mount.force * (axial + c.preload);
            let Mounted { bearing, position, .. } = *row;
            layout.rows[i] = Placed { bearing, mount, position };
            i += 1;
        }
        set
    }

    /// How far a row's groove plane is in front of its centre, in `+x`, over the radius `rp`.
    $($const)? fn plane<$($any: Real,)? const N: usize>(row: &Mounted<'_, $t, N>, rp: $t) -> $t {
        let c = row.bearing.c;
        c.plane * sign(row.facing) * (radius(c) / rp)
    }

    /// A row's closure, in its unit of length; 0 if it slides.
    $($const)? fn closure<$($any: Real,)? const N: usize>(row: &Mounted<'_, $t, N>) -> $t {
        let c = row.bearing.c;
        match row.preload {
            Preload::Closure(e) => e / c.length,
            Preload::Force(force) => displacement(c, force / c.force),
            Preload::Spring => $t::ZERO,
        }
    }

    /// The balls at rest, cold, as `AxialRest` has them with growth: `A1` without displacement, and its square less `e`.
    #[inline(always)]
    $($const)? fn free$(<$any: Real>)?(c: &Constants<$t>) -> [$t; 2] {
        [c.n0[0] * of(L0), $t::ZERO - c.play]
    }

    /// Axial force of a ball at rest, cold, and its slope, where the grooves' centres are so far apart.
    #[inline(always)]
    $($const)? fn pressed$(<$any: Real>)?(c: &Constants<$t>, axial: $t, excess: $t) -> [$t; 2] {
        let radial = c.n0[1] * of(L0);
        let r = sqrt(at_least(axial * axial + radial * radial, $t::TINY));
        let both = r + (c.lo + c.li);
        let inverse = $t::ONE / (r * both);
        let (depth, per_r) = (at_least(inverse * r * excess, $t::ZERO), inverse * both);
        let stiffness = c.kn * sqrt(depth);
        let (q, sin) = (stiffness * depth, per_r * axial);
        let across = q * per_r;
        [q * sin, across + (stiffness * of(1.5) - across) * sin * sin]
    }

    /// Axial force on a ball of a bearing at rest, cold, at an axial displacement, both in its units.
    $($const)? fn force_at$(<$any: Real>)?(c: &Constants<$t>, dx: $t) -> $t {
        let [free, change] = free(c);
        pressed(c, free + dx, dx * (free + free + dx) + change)[0]
    }

    /// Axial displacement of a bearing at rest, cold, under an axial load, both in its units: `AxialRest::root`.
    $($const)? fn displacement$(<$any: Real>)?(c: &Constants<$t>, load: $t) -> $t {
        let ([free, change], q) = (free(c), load / c.balls);
        let e = free * free - change;
        let above = sqrt(($t::ONE + q / c.kn) * of(8.0 * L0));
        let (mut root, mut step, mut left) = (above, above, 64);
        loop {
            let square = root * root;
            let (axial, excess) = (sqrt(at_least(e, $t::ZERO) + square), at_least(-e, $t::ZERO) + square);
            if left == 0 || step * step <= $t::EPSILON * $t::EPSILON * square {
                let both = axial + free;
                // A difference of squares instead of a difference.
                return if free > $t::ZERO { (excess - change) / both } else { both };
            }
            let [force, slope] = pressed(c, axial, excess);
            let next = at_least(root + (q - force) * axial / (slope * root), root * of(0.1));
            let next = at_most(next, above);
            (step, root, left) = (next - root, next, left - 1);
        }
    }
}
    };
}

build!(any, T, [T], [], {
    #[inline(always)]
    pub fn of<T: Real>(x: f64) -> T {
        T::of(x)
    }

    #[inline(always)]
    fn sqrt<T: Real>(x: T) -> T {
        x.sqrt_abs()
    }

    #[inline(always)]
    pub fn mix<T: Real>(fingerprint: u32, x: T) -> u32 {
        x.mix(fingerprint)
    }
});

build!(single, f32, [], [const], {
    use sqrt_f32 as sqrt;

    pub const fn of(x: f64) -> f32 {
        x as f32
    }

    pub const fn mix(fingerprint: u32, x: f32) -> u32 {
        mix_bits(fingerprint, x.to_bits() as u64)
    }
});

build!(double, f64, [], [const], {
    use sqrt_f64 as sqrt;

    pub const fn of(x: f64) -> f64 {
        x
    }

    pub const fn mix(fingerprint: u32, x: f64) -> u32 {
        mix_bits(fingerprint, x.to_bits())
    }
});

macro_rules! const_new {
    ($t:ident, $module:ident) => {
        impl<'b, const R: usize, const N: usize> Spindle<'b, $t, R, N> {
            /// [`Spindle::new`] for rows that the compiler knows. Rows that cannot hold a shaft are a compile error that says why.
            ///
            /// The precision is written at the call, too, since there is one such function for each.
            ///
            /// ```
            /// use spindle_bearing::{Arrangement, Bearing, Design, Facing, Mounted, Preload, Spindle};
            ///
            /// const DESIGN: Design = Design::angular_contact(6.35e-3, 36e-3, 15_f64.to_radians());
            /// static BEARING: Bearing<f32, 15> = Bearing::<f32, 15>::const_new(&DESIGN);
            /// const PRELOAD: Preload<f32> = Preload::Force(200.0);
            /// static PAIR: Spindle<f32, 2, 15> = Spindle::<f32, 2, 15>::const_new(
            ///     Arrangement::BackToBack,
            ///     [
            ///         Mounted::new(&BEARING, 0.0, Facing::PlusX).with(PRELOAD),
            ///         Mounted::new(&BEARING, 0.1, Facing::MinusX).with(PRELOAD),
            ///     ],
            /// );
            /// assert!(PAIR.closures().all(|e| e > 1e-6));
            /// ```
            ///
            /// # Panics
            ///
            /// For rows that cannot hold a shaft, with [`SpindleError::reason`].
            pub const fn const_new(
                arrangement: Arrangement,
                rows: [Mounted<'b, $t, N>; R],
            ) -> Self {
                match $module::set(arrangement, &rows, None) {
                    Ok(set) => set,
                    Err(error) => panic!("{}", error.reason()),
                }
            }
        }

        impl<'b, const R: usize, const N: usize> SprungSpindle<'b, $t, R, N> {
            /// [`Spindle::sprung`] for rows that the compiler knows.
            ///
            /// # Panics
            ///
            /// As [`Spindle::const_new`].
            pub const fn const_sprung(
                arrangement: Arrangement,
                rows: [Mounted<'b, $t, N>; R],
                force: $t,
            ) -> Self {
                match $module::set(arrangement, &rows, Some(force)) {
                    Ok(set) => set,
                    Err(error) => panic!("{}", error.reason()),
                }
            }
        }
    };
}

const_new!(f32, single);
const_new!(f64, double);

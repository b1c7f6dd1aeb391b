//! A spindle whose shaft bends, on supports that give way.

use crate::bearing::Constants;
use crate::design::check;
use crate::linalg::{norm, refer, vector};
use crate::real::{Float, Real};
use crate::rows::elastic::{Deflection, Joint, Piece, forces};
use crate::rows::{Layout, Placed};
use crate::solver::problem::{Given, ShaftLoad, check, units};
use crate::spindle::arrangement::Arrangement;
use crate::spindle::build::any::set;
use crate::spindle::error::SpindleError;
use crate::spindle::sections::{Flexible, OnShaft, Shaft, Support, of_freedoms};
use crate::spindle::{Mounted, Spindle};
use crate::status::{Quantity, Status};
use any::{deflection, deflection_by, piece};

/// Least stiffness of a support along and across the axis, N/m: less is mostly N/um.
const LEAST: f64 = 1e5;
/// Least stiffness against tilting, N m/rad. Self-aligning supports have next to none.
const LEAST_TILTING: f64 = 1.0;

/// A spindle with an elastic shaft: [`Spindle::elastic`]. Its solver is a [`SpindleSolver`](crate::SpindleSolver) with `E = R`.
pub type ElasticSpindle<'b, T, const R: usize, const N: usize, const D: usize = 5> =
    Spindle<'b, T, R, N, D, R>;

impl<'b, T: Real, const R: usize, const N: usize, const D: usize> Spindle<'b, T, R, N, D, 0> {
    /// These rows on an elastic shaft, each on its support.
    ///
    /// See [`Shaft`] for an example.
    ///
    /// # Errors
    ///
    /// A support that is too soft: [`SpindleError::Row`].
    pub fn elastic<const K: usize>(
        self,
        shaft: &'b Shaft<T, K>,
        supports: [Support<T>; R],
    ) -> Result<ElasticSpindle<'b, T, R, N, D>, SpindleError<T>> {
        any::elastic(self, &shaft.sections, &supports)
    }
}

impl<'b, T: Real, const R: usize, const N: usize, const E: usize> Spindle<'b, T, R, N, 6, E> {
    /// A spindle of which a program learns everything when it runs.
    ///
    /// It has as many `rows` as there are, at most `R`. With a `spring` of this force (N), some sit in a sleeve. A shaft without
    /// sections is rigid, and so is the support of a row for which none is given. `E` is `R + 1`, or more.
    ///
    /// The answers are those of the type that has no more than is there, in a little more time.
    ///
    /// ```
    /// use spindle_bearing::{Arrangement, Bearing, Design, Facing, Material, Mounted, Preload, Settings, Shaft, Speed, Spindle, SpindleSolver};
    ///
    /// let design = Design::angular_contact(6.35e-3, 36e-3, 15_f64.to_radians());
    /// let bearing = Bearing::<f64, 20>::with_balls(&design, 15)?;
    /// let row = |at, facing| Mounted::new(&bearing, at, facing).with(Preload::Force(200.0));
    /// let rows = vec![row(0.0, Facing::PlusX), row(0.1, Facing::MinusX)];
    /// let rigid = Shaft::<f64, 8>::new(&[], &Material::STEEL)?;
    /// let spindle = Spindle::<f64, 4, 20, 6, 5>::of_rows(Arrangement::BackToBack, &rows, None, &rigid, &[])?;
    /// let mut solver = SpindleSolver::new();
    /// let solution = solver.solve(&spindle, [0.0, 150.0, 0.0, 0.0, 0.0], Speed::rpm(20_000.0), &Settings::default())?;
    /// assert_eq!(solution.rows().len(), 2);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    ///
    /// As for [`Spindle::new`] and [`Spindle::elastic`]; more rows than `R`.
    pub fn of_rows<const K: usize>(
        arrangement: Arrangement,
        rows: &[Mounted<'b, T, N>],
        spring: Option<T>,
        shaft: &'b Shaft<T, K>,
        supports: &[Support<T>],
    ) -> Result<Self, SpindleError<T>> {
        const { assert!(E > R, "`E` is `R + 1`, or more") };
        let rigid = set(arrangement, rows, spring)?;
        any::elastic(rigid, &shaft.sections, supports)
    }
}

impl<'b, T: Real, const R: usize, const N: usize, const D: usize, const E: usize>
    Spindle<'b, T, R, N, D, E>
{
    /// The spindle under loads that act on the shaft at all times, besides those of a solve.
    ///
    /// ```
    /// # use spindle_bearing::{Arrangement, Bearing, Design, Material, Preload, Section, Shaft, ShaftLoad, Spindle, Support};
    /// # const DESIGN: Design = Design::angular_contact(6.35e-3, 36e-3, 15_f64.to_radians());
    /// # static BEARING: Bearing<f32, 15> = Bearing::<f32, 15>::const_new(&DESIGN);
    /// # static SHAFT: Shaft<f32, 0> = Shaft::<f32, 0>::const_new(&[], &Material::STEEL);
    /// # let rigid = Spindle::pair(Arrangement::BackToBack, &BEARING, 0.1, Preload::Force(200.0))?;
    /// static BELT: [ShaftLoad<f32>; 1] = [ShaftLoad { position: 0.15, load: [0.0, 0.0, -80.0, 0.0, 0.0] }];
    /// let spindle = rigid.elastic(&SHAFT, [Support::RIGID; 2])?.with_loads(&BELT)?;
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`SpindleError::Load`], for a load or a position that is out of range; [`SpindleError::HasLoads`] on a second call.
    pub fn with_loads(self, loads: &'b [ShaftLoad<T>]) -> Result<Self, SpindleError<T>> {
        const { assert!(E > 0, "a shaft that may bend takes constant loads") };
        any::with_loads(self, loads)
    }
}

/// `elastic!(module, precision, [if generic], [if const])`, as in `build.rs`.
macro_rules! elastic {
    ($module:ident, $t:ident, [$($any:ident)?], [$($const:tt)?]) => {
/// Elastic shafts in this precision.
pub mod $module {
    use super::*;
    use crate::spindle::build::$module::{at_least, at_most, check_figure, mix, of, radius};

    /// Rows on a shaft of such sections, each on its support, or on a rigid one.
    pub $($const)? fn elastic<'b, $($any: Real,)? const R: usize, const N: usize, const D: usize, const E: usize>(
        rigid: Spindle<'b, $t, R, N, D>,
        sections: &'b [Flexible<$t>],
        supports: &[Support<$t>],
    ) -> Result<Spindle<'b, $t, R, N, D, E>, SpindleError<$t>> {
        let Spindle { mut layout, spring, .. } = rigid;
        // Not `count()`, which is that of the rigid spindle's type.
        let (unit, mut count) = (layout.rows[0].bearing.c, layout.count as usize);
        if count > R {
            count = R;
        }
        let (axial, tilting) = (unit.force / unit.length, unit.moment / unit.tilt);
        let mut joints = [Joint {
            row: 0,
            position: $t::ZERO,
            support: [$t::ZERO; 5],
            constant: [$t::ZERO; 5],
            piece: Piece::NONE,
            is_last: false,
        }; E];
        let (mut bends, mut rest) = (E == R, sections);
        while let [section, others @ ..] = rest {
            bends |= section.to > section.from;
            rest = others;
        }
        let mut row = 0;
        while row < count && row < E {
            let support = if row < supports.len() { &supports[row] } else { &Support::RIGID };
            check!(check_support(row, support));
            (joints[row].row, joints[row].position) = (row, layout.rows[row].position);
            joints[row].support = of_freedoms([
                axial / support.axial,
                axial / support.radial,
                tilting / support.tilting,
            ]);
            let [of_x, of_y, _, of_ty, _] = joints[row].support;
            bends |= of_x > $t::ZERO || of_y > $t::ZERO || of_ty > $t::ZERO;
            row += 1;
        }
        let mut centre = rigid.centre;
        if bends {
            centre = between(&layout.rows, count, $t::ZERO);
            layout.plane += (rigid.centre - centre) / radius(unit);
            joints = towards(joints, count, sections, unit, centre);
            row = 0;
            while row < count && row < E {
                layout.rows[row].mount.reach = layout.rows[row].bearing.c.plane;
                layout.fingerprint = mix_all(layout.fingerprint, &joints[row].support);
                row += 1;
            }
            rest = sections;
            while let [section, others @ ..] = rest {
                layout.fingerprint = mix_all(layout.fingerprint, &section.numbers());
                rest = others;
            }
        }
        Ok(Spindle {
            layout: layout.with_joints(joints, bends),
            spring,
            centre,
            shaft: OnShaft { sections, loads: &[], load: [$t::ZERO; 5], centre },
        })
    }

    $($const)? fn check_support$(<$any: Real>)?(row: usize, support: &Support<$t>) -> Result<(), SpindleError<$t>> {
        let all = [
            (Quantity::AxialSupport, support.axial, of(LEAST)),
            (Quantity::RadialSupport, support.radial, of(LEAST)),
            (Quantity::TiltingSupport, support.tilting, of(LEAST_TILTING)),
        ];
        let mut rest = all.as_slice();
        while let [(quantity, value, least), others @ ..] = rest {
            check!(check_figure(row, *quantity, *value, *least, $t::INFINITY));
            rest = others;
        }
        Ok(())
    }

    /// The position between the first `count` rows that is nearest to `x`, m.
    pub $($const)? fn between$(<$any: Real>)?(rows: &[Placed<'_, $t>], count: usize, x: $t) -> $t {
        let (mut low, mut high, mut row) = ($t::INFINITY, -$t::INFINITY, 0);
        while row < count && row < rows.len() {
            let x = rows[row].position;
            (low, high) = (at_most(low, x), at_least(high, x));
            row += 1;
        }
        at_most(at_least(x, low), high)
    }

    /// The chain of the first `count` rows, which leads to the position `x` (m) on the shaft: rows below it, then rows above, the
    /// outermost first.
    pub $($const)? fn towards<$($any: Real,)? const E: usize>(
        mut joints: [Joint<$t>; E],
        count: usize,
        sections: &[Flexible<$t>],
        unit: &Constants<$t>,
        x: $t,
    ) -> [Joint<$t>; E] {
        let (chain, _) = joints.split_at_mut(if count < E { count } else { E });
        let mut first = 0;
        while first < chain.len() {
            let mut other = first + 1;
            while other < chain.len() {
                let (a, b) = (chain[other].position, chain[first].position);
                let is_before = match (a < x, b < x) {
                    (true, true) => a < b,
                    (false, false) => a > b,
                    (is_below, _) => is_below,
                };
                if is_before {
                    chain.swap(first, other);
                }
                other += 1;
            }
            first += 1;
        }
        let (mut next, mut rest) = (None::<$t>, chain);
        while let [others @ .., joint] = rest {
            let (near, is_last) = match next {
                Some(inner) if (inner < x) == (joint.position < x) => (inner, false),
                _ => (x, true),
            };
            joint.is_last = is_last;
            joint.piece = piece(sections, unit, near, joint.position);
            (next, rest) = (Some(joint.position), others);
        }
        joints
    }

    /// The piece of a shaft between the positions `near` and `far`, m.
    pub $($const)? fn piece$(<$any: Real>)?(
        sections: &[Flexible<$t>],
        unit: &Constants<$t>,
        near: $t,
        far: $t,
    ) -> Piece<$t> {
        let (low, high) = (at_most(near, far), at_least(near, far));
        let (mut tilting, mut first, mut axial) = ($t::ZERO, $t::ZERO, $t::ZERO);
        let mut rest = sections;
        while let Some((length, middle, per)) = next_part(&mut rest, low, high, far) {
            let [of_axial, of_bending, _] = *per;
            axial += length * of_axial;
            tilting += length * of_bending;
            first += length * of_bending * middle;
        }
        // The elastic centre, from the far end, and what a force shifts there.
        let centre = ratio(first, tilting);
        let mut lateral = $t::ZERO;
        rest = sections;
        while let Some((length, middle, per)) = next_part(&mut rest, low, high, far) {
            let ([_, of_bending, of_shear], off) = (*per, middle - centre);
            let spread = off * off + length * length * of(1.0 / 12.0);
            lateral += length * (of_bending * spread + of_shear);
        }
        let at_end = lateral + first * centre;
        let stiffness = unit.force / unit.length;
        Piece {
            length: (far - near) / radius(unit),
            lean: ratio(first, at_end) * radius(unit),
            flexibility: of_freedoms([
                axial * stiffness,
                at_end * stiffness,
                tilting * ratio(lateral, at_end) * (unit.moment / unit.tilt),
            ]),
        }
    }

    /// The next section that has a part between two positions: its length, the distance from its middle to the far end, and the
    /// flexibilities.
    #[inline(always)]
    $($const)? fn next_part<'s $(, $any: Real)?>(
        rest: &mut &'s [Flexible<$t>],
        low: $t,
        high: $t,
        far: $t,
    ) -> Option<($t, $t, &'s [$t; 3])> {
        while let [section, others @ ..] = *rest {
            *rest = others;
            let (from, to) = (at_least(section.from, low), at_most(section.to, high));
            if to > from {
                return Some((to - from, ((far - from) + (far - to)) * of(0.5), &section.per));
            }
        }
        None
    }

    #[inline(always)]
    $($const)? fn ratio$(<$any: Real>)?(a: $t, b: $t) -> $t {
        if b > $t::ZERO { a / b } else { $t::ZERO }
    }

    /// The shaft under loads that act on it at all times.
    pub $($const)? fn with_loads<'b, $($any: Real,)? const R: usize, const N: usize, const D: usize, const E: usize>(
        mut set: Spindle<'b, $t, R, N, D, E>,
        loads: &'b [ShaftLoad<$t>],
    ) -> Result<Spindle<'b, $t, R, N, D, E>, SpindleError<$t>> {
        if !set.shaft.loads.is_empty() {
            return Err(SpindleError::HasLoads);
        }
        let unit = set.layout.rows[0].bearing.c;
        let (mut sum, mut load, mut rest) = ([$t::ZERO; 5], 0, loads);
        while let [at, others @ ..] = rest {
            if let Err((quantity, value, most)) = check_load(unit, set.layout.ball_count, at) {
                return Err(SpindleError::Load { load, quantity, value, least: -most, most });
            }
            sum = plus(&sum, &refer(at.position - set.centre, &at.load));
            (load, rest) = (load + 1, others);
        }
        (set.shaft.loads, set.shaft.load) = (loads, sum);
        let mut row = 0;
        while row < set.layout.count() && row < E {
            let x = set.layout.joints[row].position;
            set.layout.joints[row].constant = deflection_by(&set.shaft, unit, x, loads);
            row += 1;
        }
        set.layout.fingerprint = fingerprint(loads, set.layout.fingerprint);
        Ok(set)
    }

    /// Refuses a load or its position that is out of range: which figure, its value and the largest magnitude.
    pub $($const)? fn check_load$(<$any: Real>)?(
        unit: &Constants<$t>,
        ball_count: $t,
        at: &ShaftLoad<$t>,
    ) -> Result<(), (Quantity, $t, $t)> {
        let (mut quantity, mut value) = (Quantity::LoadPosition, at.position);
        let (mut most, mut i) = (radius(unit) * of(4096.0), 0);
        loop {
            if !(value <= most && value >= -most) {
                return Err((quantity, value, most));
            }
            if i == 5 {
                return Ok(());
            }
            (quantity, value) = (Quantity::OF_FREEDOM[i][0], at.load[i]);
            (most, i) = (ball_count * of(512.0) * units(unit)[i], i + 1);
        }
    }

    /// Units of the five forces.
    #[inline(always)]
    $($const)? fn units$(<$any: Real>)?(unit: &Constants<$t>) -> [$t; 5] {
        [unit.force, unit.force, unit.force, unit.moment, unit.moment]
    }

    #[inline(always)]
    $($const)? fn plus$(<$any: Real>)?(a: &[$t; 5], b: &[$t; 5]) -> [$t; 5] {
        let (mut sum, mut i) = (*a, 0);
        while i < 5 {
            sum[i] += b[i];
            i += 1;
        }
        sum
    }

    /// Refers a force to a point that is nearer to the origin by `distance`. With a lean in the place of the distance, adds the turns that
    /// go with a shift.
    #[inline(always)]
    $($const)? fn refer$(<$any: Real>)?(distance: $t, force: &[$t; 5]) -> [$t; 5] {
        let [x, y, z, my, mz] = *force;
        [x, y, z, my - distance * z, mz + distance * y]
    }

    /// Motion of a point that is further along the axis by `distance`. With a lean, the force where turns are counted beyond the turns
    /// that go with a shift.
    #[inline(always)]
    $($const)? fn moved$(<$any: Real>)?(distance: $t, u: &[$t; 5]) -> [$t; 5] {
        let [x, y, z, ty, tz] = *u;
        [x, y + distance * tz, z - distance * ty, ty, tz]
    }

    /// Deflection of the shaft at the position `x` (m) by `load` at the position `at`, both in the solver's units, about the section
    /// at its centre.
    #[inline(never)]
    pub $($const)? fn deflection$(<$any: Real>)?(
        shaft: &OnShaft<'_, $t>,
        unit: &Constants<$t>,
        x: $t,
        at: $t,
        load: &[$t; 5],
    ) -> [$t; 5] {
        let [of_x, of_load] = [x - shaft.centre, at - shaft.centre];
        if !(of_x * of_load > $t::ZERO) {
            return [$t::ZERO; 5];
        }
        // Beyond the nearer of both, nothing bends.
        let is_nearer = at_least(of_x, -of_x) < at_least(of_load, -of_load);
        let end = if is_nearer { x } else { at };
        let per = $t::ONE / radius(unit);
        let piece = piece(shaft.sections, unit, shaft.centre, end);
        // As `Piece::deflection`.
        let mut u = moved(piece.lean, &refer((at - end) * per, load));
        let mut i = 0;
        while i < 5 {
            u[i] = piece.flexibility[i] * u[i];
            i += 1;
        }
        moved((x - end) * per, &refer(piece.lean, &u))
    }

    /// Deflection by loads, about the section at its centre.
    pub $($const)? fn deflection_by$(<$any: Real>)?(
        shaft: &OnShaft<'_, $t>,
        unit: &Constants<$t>,
        x: $t,
        loads: &[ShaftLoad<$t>],
    ) -> [$t; 5] {
        let (mut u, mut rest) = ([$t::ZERO; 5], loads);
        while let [at, others @ ..] = rest {
            let (mut load, mut i) = (at.load, 0);
            while i < 5 {
                load[i] = load[i] / units(unit)[i];
                i += 1;
            }
            u = plus(&u, &deflection(shaft, unit, x, at.position, &load));
            rest = others;
        }
        u
    }

    /// A fingerprint with these loads mixed into it.
    pub $($const)? fn fingerprint$(<$any: Real>)?(loads: &[ShaftLoad<$t>], mut fingerprint: u32) -> u32 {
        let mut rest = loads;
        while let [at, others @ ..] = rest {
            fingerprint = mix_all(mix(fingerprint, at.position), &at.load);
            rest = others;
        }
        fingerprint
    }

    $($const)? fn mix_all$(<$any: Real>)?(mut fingerprint: u32, numbers: &[$t; 5]) -> u32 {
        let mut i = 0;
        while i < 5 {
            fingerprint = mix(fingerprint, numbers[i]);
            i += 1;
        }
        fingerprint
    }
}
    };
}

elastic!(any, T, [T], []);
elastic!(single, f32, [], [const]);
elastic!(double, f64, [], [const]);

macro_rules! const_elastic {
    ($t:ident, $module:ident) => {
        impl<'b, const R: usize, const N: usize, const D: usize> Spindle<'b, $t, R, N, D> {
            /// [`Spindle::elastic`] for a shaft and supports that the compiler knows.
            ///
            /// # Panics
            ///
            /// For a support that is too soft, with [`SpindleError::reason`].
            pub const fn const_elastic<const K: usize>(
                self,
                shaft: &'b Shaft<$t, K>,
                supports: [Support<$t>; R],
            ) -> ElasticSpindle<'b, $t, R, N, D> {
                match $module::elastic(self, &shaft.sections, &supports) {
                    Ok(set) => set,
                    Err(error) => panic!("{}", error.reason()),
                }
            }
        }

        impl<'b, const R: usize, const N: usize, const D: usize> ElasticSpindle<'b, $t, R, N, D> {
            /// [`Spindle::with_loads`] for loads that the compiler knows.
            ///
            /// # Panics
            ///
            /// For loads that are out of range, and on a second call, with [`SpindleError::reason`].
            pub const fn const_with_loads(self, loads: &'b [ShaftLoad<$t>]) -> Self {
                match $module::with_loads(self, loads) {
                    Ok(set) => set,
                    Err(error) => panic!("{}", error.reason()),
                }
            }
        }
    };
}

const_elastic!(f32, single);
const_elastic!(f64, double);
impl<'b, T: Real, const R: usize, const N: usize, const D: usize, const E: usize>
    Spindle<'b, T, R, N, D, E>
{
    /// How the rows sit, the shaft deflected by these loads, too, and a fingerprint of them.
    pub(super) fn under_loads(&self, loads: &[ShaftLoad<T>]) -> (Layout<'b, T, R, true, E>, u32) {
        let (mut layout, unit) = (self.layout, self.layout.rows[0].bearing.c);
        for joint in &mut layout.joints {
            let by_loads = deflection_by(&self.shaft, unit, joint.position, loads);
            joint.constant = vector(|i| joint.constant[i] + by_loads[i]);
        }
        (layout, any::fingerprint(loads, 1))
    }

    /// Refuses a load or its position that is out of range.
    pub(super) fn check_load(&self, at: &ShaftLoad<T>) -> Result<(), Status<T>> {
        match any::check_load(self.layout.rows[0].bearing.c, self.layout.ball_count, at) {
            Ok(()) => Ok(()),
            Err((quantity, value, most)) => check(quantity, value, most),
        }
    }

    /// The chain of rows that leads to the position `x` (m) on the shaft.
    pub(super) fn joints_towards(&self, x: T) -> [Joint<T>; E] {
        any::towards(
            self.layout.joints,
            self.layout.count(),
            self.shaft.sections,
            self.layout.rows[0].bearing.c,
            x,
        )
    }

    /// The position between the rows that is nearest to `x`, m.
    pub(super) fn between_rows(&self, x: T) -> T {
        any::between(&self.layout.rows, self.layout.count(), x)
    }

    /// The piece of an elastic shaft from `x = 0` to its centre, if it is not there; and how far loads move its end at `x = 0`: these,
    /// and the constant ones.
    pub(super) fn overhang(&self, given: &[Given<T>; 5]) -> Option<(Piece<T>, [T; 5])> {
        if !self.layout.bends() || self.centre == T::ZERO {
            return None;
        }
        let (unit, shaft) = (self.layout.rows[0].bearing.c, &self.shaft);
        let load: [T; 5] = vector(|i| given[i].load_or(T::ZERO) / units(unit, i).0);
        let by_load = piece(shaft.sections, unit, self.centre, T::ZERO).deflection(&load);
        let by_loads = deflection_by(shaft, unit, T::ZERO, shaft.loads);
        let mut piece = piece(shaft.sections, unit, T::ZERO, self.centre);
        if !matches!(
            given,
            [_, Given::Displacement(_), ..] | [_, _, Given::Displacement(_), ..]
        ) {
            // Moments alone react, and turn the end. A lever would cost digits.
            piece.length = T::ZERO;
            let by_moment = piece.lean * piece.lean * piece.flexibility[1];
            for (i, given) in given.iter().enumerate().skip(1) {
                let turn = piece.flexibility[i] + by_moment;
                piece.flexibility[i] = match given {
                    Given::Displacement(_) => turn,
                    Given::Load(_) => T::ZERO,
                };
            }
        }
        Some((piece, vector(|i| by_loads[i] + by_load[i])))
    }

    /// Deflection of an elastic shaft at the position `x` (m) about its section at the centre, in the solver's units, under the loads
    /// of a solve, the forces of its rows and its constant loads; and the sizes of its parts.
    pub(super) fn deflection_at(
        &self,
        x: T,
        loads: &[ShaftLoad<T>],
        deflections: &[Deflection<T, D>; E],
    ) -> ([T; 5], T) {
        let (mut u, mut size) = ([T::ZERO; 5], T::ZERO);
        if !self.layout.bends() {
            return (u, size);
        }
        let (unit, shaft) = (self.layout.rows[0].bearing.c, &self.shaft);
        let mut add = |part: [T; 5]| {
            u = vector(|i| u[i] + part[i]);
            size += norm(&part);
        };
        add(deflection_by(shaft, unit, x, shaft.loads));
        add(deflection_by(shaft, unit, x, loads));
        let deflections = self.layout.of_joints(deflections);
        for (position, force) in forces(self.layout.joints(), deflections) {
            add(deflection(shaft, unit, x, position, &vector(|i| -force[i])));
        }
        (u, size)
    }

    /// Deflection at the position `x` (m) by the forces of the rows alone, in the solver's units.
    pub(super) fn deflection_by_rows(&self, x: T, deflections: &[Deflection<T, D>; E]) -> [T; 5] {
        let (unit, deflections) = (
            self.layout.rows[0].bearing.c,
            self.layout.of_joints(deflections),
        );
        let mut u = [T::ZERO; 5];
        for (position, force) in forces(self.layout.joints(), deflections) {
            let part = deflection(&self.shaft, unit, x, position, &vector(|i| -force[i]));
            u = vector(|i| u[i] + part[i]);
        }
        u
    }

    /// Flexibility of a row's support, SI.
    pub(super) fn support_of(&self, row: usize) -> [T; 5] {
        let unit = self.layout.rows[0].bearing.c;
        let joint = self.layout.joints().iter().find(|joint| joint.row == row);
        vector(|i| {
            let (force, length) = units(unit, i);
            joint.map_or(T::ZERO, |joint| joint.support[i] * (length / force))
        })
    }

    /// Constant loads about the position `x` (m), which is the centre of a shaft that bends.
    #[inline(always)]
    fn constant_about(&self, x: T) -> [T; 5] {
        let mut load = self.shaft.load;
        if E > 0 && !self.layout.bends() {
            refer(self.centre - x, &mut load);
        }
        load
    }

    /// Adds the constant loads to a load about the position `x` (m) in the solver's units.
    pub(super) fn add_constant(&self, load: &mut [T; D], x: T) {
        if E > 0 {
            let (unit, constant) = (self.layout.rows[0].bearing.c, self.constant_about(x));
            for i in 0..5 {
                load[i] += constant[i] / units(unit, i).0;
            }
        }
    }

    /// Loads of a solve at `x = 0`, SI, from the loads that its rows carry about the position `x` (m), in the solver's units.
    pub(super) fn load_at_origin(&self, carried: &[T; D], x: T) -> [T; 5] {
        let (unit, constant) = (self.layout.rows[0].bearing.c, self.constant_about(x));
        let mut load = vector(|i| carried[i] * units(unit, i).0 - constant[i]);
        refer(x, &mut load);
        load
    }
}

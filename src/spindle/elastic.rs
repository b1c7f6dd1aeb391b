//! A spindle whose shaft bends, on supports that give way.

use crate::linalg::{norm, refer, vector};
use crate::real::Real;
use crate::shaft::Layout;
use crate::shaft::elastic::{Bend, Joint, Piece, forces, order};
use crate::solver::problem::{Given, ShaftLoad, about, check, radius, units};
use crate::spindle::Spindle;
use crate::spindle::error::SpindleError;
use crate::spindle::sections::{OnShaft, Shaft, Support, of_freedoms};
use crate::status::{Quantity, Status};
use core::array::from_fn;

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
    /// A support that is too soft: [`SpindleError::Support`].
    pub fn elastic<const K: usize>(
        self,
        shaft: &'b Shaft<T, K>,
        supports: [Support<T>; R],
    ) -> Result<ElasticSpindle<'b, T, R, N, D>, SpindleError<T>> {
        for (row, support) in supports.iter().enumerate() {
            support.check(row)?;
        }
        let centre = self.between_rows(T::ZERO);
        let (layout, _) = self.about(centre);
        let unit = layout.bearings[0].c;
        let (axial, tilting) = (unit.force / unit.length, unit.moment / unit.tilt);
        let joints = from_fn(|row| {
            let rigid = Support::RIGID;
            let support = supports.get(row).unwrap_or(&rigid);
            Joint {
                row,
                position: self.positions.get(row).copied().unwrap_or(T::ZERO),
                support: of_freedoms([
                    axial / support.axial,
                    axial / support.radial,
                    tilting / support.tilting,
                ]),
                constant: [T::ZERO; 5],
                piece: Piece::NONE,
                is_last: false,
            }
        });
        let on_shaft = OnShaft {
            sections: &shaft.sections,
            loads: &[],
            load: [T::ZERO; 5],
            centre,
        };
        let mut set = Spindle {
            layout: layout.with_joints(joints),
            positions: self.positions,
            facings: self.facings,
            spring: self.spring,
            centre,
            shaft: [on_shaft; R],
        };
        for (mount, row) in set.layout.mounts.iter_mut().zip(&layout.bearings) {
            mount.reach = row.c.plane;
        }
        set.layout.joints = set.joints_towards(centre);
        let supports = set.layout.joints.iter().flat_map(|joint| joint.support);
        let sections = shaft.sections.iter().flat_map(|section| section.numbers());
        set.layout.mark = supports
            .chain(sections)
            .fold(set.layout.mark, |mark, number| number.mix(mark));
        Ok(set)
    }
}

impl<'b, T: Real, const R: usize, const N: usize, const D: usize> Spindle<'b, T, R, N, D, R> {
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
    pub fn with_loads(mut self, loads: &'b [ShaftLoad<T>]) -> Result<Self, SpindleError<T>> {
        if self.shaft.iter().any(|shaft| !shaft.loads.is_empty()) {
            return Err(SpindleError::HasLoads);
        }
        let unit = self.layout.bearings[0].c;
        for (number, load) in loads.iter().enumerate() {
            self.check_load(load).map_err(|status| SpindleError::Load {
                load: number,
                status,
            })?;
        }
        let sum = about(loads, self.centre);
        for shaft in &mut self.shaft {
            (shaft.loads, shaft.load) = (loads, sum);
        }
        for (joint, shaft) in self.layout.joints.iter_mut().zip(&self.shaft) {
            joint.constant = shaft.deflection_by(unit, joint.position, loads);
        }
        self.layout.mark = mark(loads, self.layout.mark);
        Ok(self)
    }
}

/// A mark with these loads mixed into it.
fn mark<T: Real>(loads: &[ShaftLoad<T>], mark: u32) -> u32 {
    let numbers = loads
        .iter()
        .flat_map(|at| [at.position].into_iter().chain(at.load));
    numbers.fold(mark, |mark, number| number.mix(mark))
}

impl<'b, T: Real, const R: usize, const N: usize, const D: usize, const E: usize>
    Spindle<'b, T, R, N, D, E>
{
    /// How the rows sit, the shaft deflected by these loads, too, and a mark of them.
    pub(super) fn under_loads(&self, loads: &[ShaftLoad<T>]) -> (Layout<'b, T, R, true, E>, u32) {
        let (mut layout, unit) = (self.layout, self.layout.bearings[0].c);
        for (joint, shaft) in layout.joints.iter_mut().zip(&self.shaft) {
            let by_loads = shaft.deflection_by(unit, joint.position, loads);
            joint.constant = vector(|i| joint.constant[i] + by_loads[i]);
        }
        (layout, mark(loads, 1))
    }

    /// Refuses a load or its position that is out of range.
    pub(super) fn check_load(&self, at: &ShaftLoad<T>) -> Result<(), Status<T>> {
        let unit = self.layout.bearings[0].c;
        let farthest = T::of(4096.0) * radius(unit);
        check(Quantity::LoadPosition, at.position, farthest)?;
        for (i, load) in at.load.into_iter().enumerate() {
            let most = T::of(512.0) * self.layout.ball_count * units(unit, i).0;
            let [quantity, _] = Quantity::OF_FREEDOM[i];
            check(quantity, load, most)?;
        }
        Ok(())
    }

    /// The chain of rows that leads to the position `x` (m) on the shaft.
    pub(super) fn joints_towards(&self, x: T) -> [Joint<T>; E] {
        let mut joints = self.layout.joints;
        order(&mut joints, x);
        let Some(shaft) = self.shaft.first() else {
            return joints;
        };
        let unit = self.layout.bearings[0].c;
        let mut next = None::<T>;
        for joint in joints.iter_mut().rev() {
            let inner = next.filter(|inner| (*inner < x) == (joint.position < x));
            joint.is_last = inner.is_none();
            let near = inner.unwrap_or(x);
            joint.piece = shaft.piece(unit, near, joint.position);
            next = Some(joint.position);
        }
        joints
    }

    /// The position between the rows that is nearest to `x`, m.
    pub(super) fn between_rows(&self, x: T) -> T {
        let (mut low, mut high) = (T::INFINITY, -T::INFINITY);
        for position in &self.positions {
            (low, high) = (low.at_most(*position), high.at_least(*position));
        }
        x.at_least(low).at_most(high)
    }

    /// The piece of an elastic shaft from `x = 0` to its centre, if it is not there; and how far loads move its end at `x = 0`: these,
    /// and the constant ones.
    pub(super) fn overhang(&self, given: &[Given<T>; 5]) -> Option<(Piece<T>, [T; 5])> {
        let unit = self.layout.bearings[0].c;
        let shaft = self.shaft.first().filter(|_| self.centre != T::ZERO)?;
        let load: [T; 5] = vector(|i| given[i].load_or(T::ZERO) / units(unit, i).0);
        let by_load = shaft.piece(unit, self.centre, T::ZERO).deflection(&load);
        let by_loads = shaft.deflection_by(unit, T::ZERO, shaft.loads);
        let mut piece = shaft.piece(unit, T::ZERO, self.centre);
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
        bends: &[Bend<T, D>; E],
    ) -> ([T; 5], T) {
        let (mut u, mut size) = ([T::ZERO; 5], T::ZERO);
        let Some(shaft) = self.shaft.first() else {
            return (u, size);
        };
        let unit = self.layout.bearings[0].c;
        let mut add = |part: [T; 5]| {
            u = vector(|i| u[i] + part[i]);
            size += norm(&part);
        };
        add(shaft.deflection_by(unit, x, shaft.loads));
        add(shaft.deflection_by(unit, x, loads));
        for (position, force) in forces(&self.layout.joints, bends) {
            add(shaft.deflection(unit, x, position, &vector(|i| -force[i])));
        }
        (u, size)
    }

    /// Flexibility of a row's support, SI.
    pub(super) fn support_of(&self, row: usize) -> [T; 5] {
        let unit = self.layout.bearings[0].c;
        let joint = self.layout.joints.iter().find(|joint| joint.row == row);
        vector(|i| {
            let (force, length) = units(unit, i);
            joint.map_or(T::ZERO, |joint| joint.support[i] * (length / force))
        })
    }

    /// Adds the constant loads to a load in the solver's units.
    pub(super) fn add_constant(&self, load: &mut [T; D]) {
        if E > 0 {
            let (unit, constant) = (self.layout.bearings[0].c, self.constant_load());
            for i in 0..5 {
                load[i] += constant[i] / units(unit, i).0;
            }
        }
    }

    /// Loads of a solve at `x = 0`, SI, from those that its rows carry about the position `x` (m), in the solver's units.
    pub(super) fn load_at_origin(&self, carried: &[T; D], x: T) -> [T; 5] {
        let (unit, constant) = (self.layout.bearings[0].c, self.constant_load());
        let mut load = vector(|i| carried[i] * units(unit, i).0 - constant[i]);
        refer(x, &mut load);
        load
    }

    /// Constant loads on an elastic shaft, about its centre, SI.
    fn constant_load(&self) -> [T; 5] {
        self.shaft.first().map_or([T::ZERO; 5], |shaft| shaft.load)
    }
}

//! An elastic shaft in its sections, the supports of rows, and constant loads.

use crate::design::{DesignError, Material, check, in_range, within};
use crate::real::Real;
use crate::solver::problem::ShaftLoad;
use crate::status::Quantity;
use core::f64::consts::PI;
use core::fmt;

/// A hollow round piece of a shaft, m.
///
/// See [`Shaft`] for an example.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Section {
    /// Position where it begins.
    pub from: f64,
    /// Position where it ends.
    pub to: f64,
    /// Outer diameter.
    pub outer: f64,
    /// Diameter of its bore, 0 if it is solid.
    pub inner: f64,
}

/// A shaft that cannot be built: which section, counted from 0, and which of its figures.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ShaftError {
    /// The section at fault; that of the material is the first.
    pub section: usize,
    /// Its figure, and the range it must lie in.
    pub error: DesignError,
}

impl fmt::Display for ShaftError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "section {} of the shaft: {}", self.section, self.error)
    }
}

impl core::error::Error for ShaftError {}

/// Flexibility of a section per metre.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Flexible<T> {
    pub from: T,
    pub to: T,
    /// `1/EA`, `1/EI` and `1/(kappa G A)`.
    pub per: [T; 3],
}

impl<T: Copy> Flexible<T> {
    /// All of its numbers.
    pub(super) const fn numbers(&self) -> [T; 5] {
        let [axial, bending, shear] = self.per;
        [self.from, self.to, axial, bending, shear]
    }
}

/// An elastic shaft: `K` hollow round sections of one material, ready for a [`Spindle`](crate::Spindle).
///
/// It bends with shear (Timoshenko) and stretches. It has no mass, and no torsion. Outside of its sections and in gaps between them
/// it is rigid: a row, the nose or a load may stand there.
///
/// ```
/// use spindle_bearing::{Arrangement, Bearing, Design, Material, Preload, Section, Settings};
/// use spindle_bearing::{Shaft, Speed, Spindle, SpindleSolver, Support};
///
/// const DESIGN: Design = Design::angular_contact(6.35e-3, 36e-3, 15_f64.to_radians());
/// static BEARING: Bearing<f32, 15> = Bearing::<f32, 15>::const_new(&DESIGN);
/// // Solid, 25 mm thick, from 30 mm in front of the first row to the second.
/// const SOLID: Section = Section { from: -0.03, to: 0.1, outer: 0.025, inner: 0.0 };
/// static SHAFT: Shaft<f32, 1> = Shaft::<f32, 1>::const_new(&[SOLID], &Material::STEEL);
///
/// let rigid = Spindle::pair(Arrangement::BackToBack, &BEARING, 0.1, Preload::Force(200.0))?;
/// let housing = Support { radial: 4e8, ..Support::RIGID };
/// let spindle = rigid.elastic(&SHAFT, [housing; 2])?;
/// let mut solver = SpindleSolver::new();
/// let solution = solver.solve(&spindle, [0.0, 100.0, 0.0, 0.0, 0.0], Speed::rpm(10_000.0), &Settings::default())?;
/// let nose = solution.compliance_at(-0.03);
/// assert!(1e-6 / nose[1][1] < 60.0); // N/um
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Shaft<T, const K: usize> {
    pub(super) sections: [Flexible<T>; K],
}

/// Largest position on a shaft, and largest diameter, m.
const FARTHEST: f64 = 100.0;
const THICKEST: f64 = 2.0;

impl Section {
    const fn check(&self) -> Result<(), DesignError> {
        use Quantity as Q;
        check!(within(Q::SectionStart, self.from, -FARTHEST, FARTHEST));
        check!(within(Q::SectionEnd, self.to, self.from + 1e-6, FARTHEST));
        check!(within(Q::OuterDiameter, self.outer, 1e-4, THICKEST));
        within(Q::InnerDiameter, self.inner, 0.0, 0.999 * self.outer)
    }

    /// Refuses to overlap with a section in front of it or behind it.
    const fn check_beside(&self, other: &Self) -> Result<(), DesignError> {
        if self.from >= other.to || self.to <= other.from {
            return Ok(());
        }
        within(Quantity::SectionStart, self.from, other.to, FARTHEST)
    }

    /// `1/EA`, `1/EI` and `1/(kappa G A)`, with the shear factor of a hollow round section: G. R. Cowper, The Shear Coefficient in
    /// Timoshenko's Beam Theory, J. Appl. Mech. 33 (1966).
    const fn flexibilities(&self, material: &Material) -> [f64; 3] {
        let (e, nu) = (material.youngs_modulus, material.poissons_ratio);
        let (outer, inner) = (self.outer * self.outer, self.inner * self.inner);
        let area = PI / 4.0 * (outer - inner);
        let second = area / 16.0 * (outer + inner);
        let ratio = inner / outer;
        let square = (1.0 + ratio) * (1.0 + ratio);
        let kappa =
            6.0 * (1.0 + nu) * square / ((7.0 + 6.0 * nu) * square + (20.0 + 12.0 * nu) * ratio);
        let shear = e / (2.0 * (1.0 + nu));
        [
            1.0 / (e * area),
            1.0 / (e * second),
            1.0 / (kappa * shear * area),
        ]
    }
}

const fn check_shaft(sections: &[Section], material: &Material) -> Result<(), ShaftError> {
    use Quantity as Q;
    let error = match in_range(Q::ShaftYoungsModulus, material.youngs_modulus) {
        Ok(()) => in_range(Q::ShaftPoissonsRatio, material.poissons_ratio),
        Err(error) => Err(error),
    };
    if let Err(error) = error {
        return Err(ShaftError { section: 0, error });
    }
    let mut section = 0;
    while section < sections.len() {
        if let Err(error) = sections[section].check() {
            return Err(ShaftError { section, error });
        }
        let mut other = 0;
        while other < section {
            if let Err(error) = sections[section].check_beside(&sections[other]) {
                return Err(ShaftError { section, error });
            }
            other += 1;
        }
        section += 1;
    }
    Ok(())
}

/// Flexibilities of sections that are checked. Unused places have the length 0.
const fn flexible<const K: usize>(
    sections: &[Section],
    material: &Material,
) -> Result<[Flexible<f64>; K], ShaftError> {
    let count = sections.len();
    if let Err(error) = within(Quantity::SectionCount, count as f64, 0.0, K as f64) {
        return Err(ShaftError { section: K, error });
    }
    check!(check_shaft(sections, material));
    let none = Flexible {
        from: 0.0,
        to: 0.0,
        per: [0.0; 3],
    };
    let mut flexible = [none; K];
    let mut i = 0;
    while i < count {
        flexible[i] = Flexible {
            from: sections[i].from,
            to: sections[i].to,
            per: sections[i].flexibilities(material),
        };
        i += 1;
    }
    Ok(flexible)
}

impl<T: Real, const K: usize> Shaft<T, K> {
    /// Checks sections, at most `K` in any order, and works out their flexibilities in doubles. Of the material, Young's modulus and
    /// Poisson's ratio count.
    ///
    /// # Errors
    ///
    /// The first figure that is out of its range. A section that begins within another one must begin where that ends.
    pub fn new(sections: &[Section], material: &Material) -> Result<Self, ShaftError> {
        let flexible = flexible::<K>(sections, material)?;
        let sections = flexible.map(|section| Flexible {
            from: T::of(section.from),
            to: T::of(section.to),
            per: section.per.map(T::of),
        });
        Ok(Self { sections })
    }
}

macro_rules! shaft {
    ($t:ident) => {
        impl<const K: usize> Shaft<$t, K> {
            /// [`Shaft::new`] for a shaft that the compiler knows: one that cannot be built is a compile error that names the
            /// quantity.
            ///
            /// # Panics
            ///
            /// For a shaft that cannot be built, with [`DesignError::reason`].
            pub const fn const_new(sections: &[Section; K], material: &Material) -> Self {
                let flexible = match flexible::<K>(sections, material) {
                    Ok(flexible) => flexible,
                    Err(ShaftError { error, .. }) => panic!("{}", error.reason()),
                };
                let none = Flexible {
                    from: 0.0,
                    to: 0.0,
                    per: [0.0; 3],
                };
                let mut sections = [none; K];
                let mut i = 0;
                while i < K {
                    let [axial, bending, shear] = flexible[i].per;
                    sections[i] = Flexible {
                        from: flexible[i].from as $t,
                        to: flexible[i].to as $t,
                        per: [axial as $t, bending as $t, shear as $t],
                    };
                    i += 1;
                }
                Self { sections }
            }
        }
    };
}

shaft!(f32);
shaft!(f64);

/// Stiffness of what holds a row's outer ring; that of a rigid one is infinite.
///
/// The least are 1e5 N/m, and 1 N m/rad.
///
/// See [`Shaft`] for an example.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(bound(
        serialize = "T: crate::serialize::Written",
        deserialize = "T: crate::serialize::Read<'de>"
    ))
)]
pub struct Support<T> {
    /// Along the axis, N/m.
    #[cfg_attr(feature = "serde", serde(with = "crate::serialize::number"))]
    pub axial: T,
    /// Across it, N/m.
    #[cfg_attr(feature = "serde", serde(with = "crate::serialize::number"))]
    pub radial: T,
    /// Against tilting, N m/rad.
    #[cfg_attr(feature = "serde", serde(with = "crate::serialize::number"))]
    pub tilting: T,
}

impl<T: Real> Support<T> {
    /// A rigid one.
    pub const RIGID: Self = Self {
        axial: T::INFINITY,
        radial: T::INFINITY,
        tilting: T::INFINITY,
    };
}

/// An elastic shaft and its constant loads.
#[derive(Debug, Clone, Copy)]
pub struct OnShaft<'b, T> {
    pub sections: &'b [Flexible<T>],
    pub loads: &'b [ShaftLoad<T>],
    /// Sum of the loads about the shaft's centre.
    pub load: [T; 5],
    /// Position of that, m.
    pub centre: T,
}

impl<T: Real> OnShaft<'_, T> {
    /// Of a rigid shaft.
    pub const NONE: Self = Self {
        sections: &[],
        loads: &[],
        load: [T::ZERO; 5],
        centre: T::ZERO,
    };
}

/// Axial, lateral and tilting flexibility as those of the five freedoms.
pub(super) const fn of_freedoms<T: Copy>([axial, lateral, tilting]: [T; 3]) -> [T; 5] {
    [axial, lateral, lateral, tilting, tilting]
}

//! Quantities of a recording.

use crate::units::Dimension;

/// A quantity of a recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// Time, s.
    Time,
    /// Axial force, N.
    Fx,
    /// Radial force, N.
    Fy,
    /// Radial force, N.
    Fz,
    /// Moment about the shaft, N m: only of use where axes are turned.
    Mx,
    /// Tilting moment, N m.
    My,
    /// Tilting moment, N m.
    Mz,
    /// Shaft speed, rpm.
    Speed,
    /// Temperature of the inner side, degrees Celsius.
    TInner,
    /// Temperature of the outer side, degrees Celsius.
    TOuter,
}

/// Number of quantities.
pub const QUANTITIES: usize = Quantity::ALL.len();

/// The quantities of a row, in the order of the project's own recordings.
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

impl Quantity {
    /// All of them.
    pub const ALL: [Self; 10] = [
        Self::Time,
        Self::Fx,
        Self::Fy,
        Self::Fz,
        Self::Mx,
        Self::My,
        Self::Mz,
        Self::Speed,
        Self::TInner,
        Self::TOuter,
    ];

    /// Its key in a description, its column in the project's own recordings, its dimension.
    const fn facts(self) -> (&'static str, &'static str, Dimension) {
        match self {
            Self::Time => ("time", "time_s", Dimension::Time),
            Self::Fx => ("fx", "fx_n", Dimension::Force),
            Self::Fy => ("fy", "fy_n", Dimension::Force),
            Self::Fz => ("fz", "fz_n", Dimension::Force),
            Self::Mx => ("mx", "mx_nm", Dimension::Moment),
            Self::My => ("my", "my_nm", Dimension::Moment),
            Self::Mz => ("mz", "mz_nm", Dimension::Moment),
            Self::Speed => ("speed", "speed_rpm", Dimension::Speed),
            Self::TInner => ("t_inner", "t_inner_c", Dimension::Temperature),
            Self::TOuter => ("t_outer", "t_outer_c", Dimension::Temperature),
        }
    }

    /// Its key in a description, and its option.
    pub const fn name(self) -> &'static str {
        self.facts().0
    }

    /// The column of the project's own recordings.
    pub const fn column(self) -> &'static str {
        self.facts().1
    }

    /// Its dimension.
    pub const fn dimension(self) -> Dimension {
        self.facts().2
    }
}

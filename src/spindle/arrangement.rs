//! How rows face, and the names of their arrangements.

use crate::real::Real;

/// Which load on the shaft presses the balls of a row.
///
/// See [`Mounted`](crate::Mounted) for an example.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Facing {
    /// An axial load on the shaft in `+x`. The contact lines meet the axis on the side of smaller x.
    #[cfg_attr(feature = "serde", serde(rename = "+x"))]
    PlusX,
    /// One in `-x`: the mirror image.
    #[cfg_attr(feature = "serde", serde(rename = "-x"))]
    MinusX,
}

impl Facing {
    /// 1 or -1.
    pub fn sign<T: Real>(self) -> T {
        match self {
            Self::PlusX => T::ONE,
            Self::MinusX => -T::ONE,
        }
    }

    /// By its sign.
    pub(super) fn of<T: Real>(sign: T) -> Self {
        if sign < T::ZERO {
            Self::MinusX
        } else {
            Self::PlusX
        }
    }

    /// Both are one direction.
    pub(super) const fn is(self, other: Self) -> bool {
        self as u8 == other as u8
    }

    /// `+x` or `-x`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::PlusX => "+x",
            Self::MinusX => "-x",
        }
    }
}

/// How the rows of a spindle stand to each other. Sets of three and four rows have the name of the pair that they are made
/// of: TBT, QBC and QBT are back to back, TFT and QFC face to face.
///
/// See [`Mounted`](crate::Mounted) for an example.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
#[non_exhaustive]
pub enum Arrangement {
    /// DB, O: the contact lines meet the axis far apart, which resists a tilt. Rows that face `+x` are at smaller x than
    /// rows that face `-x`.
    BackToBack,
    /// DF, X: the contact lines meet the axis close together. Rows that face `-x` are at smaller x.
    FaceToFace,
    /// DT: all rows face one way and share an axial load.
    Tandem,
    /// As the rows say, unchecked. A pair of equal bearings is then back to back.
    ByRows,
}

impl Arrangement {
    /// Short name in lower case.
    pub const fn name(self) -> &'static str {
        match self {
            Self::BackToBack => "back-to-back",
            Self::FaceToFace => "face-to-face",
            Self::Tandem => "tandem",
            Self::ByRows => "by-rows",
        }
    }

    /// How the two rows of a pair face, that at the smaller x first.
    pub(super) const fn of_pair(self) -> [Facing; 2] {
        match self {
            Self::BackToBack | Self::ByRows => [Facing::PlusX, Facing::MinusX],
            Self::FaceToFace => [Facing::MinusX, Facing::PlusX],
            Self::Tandem => [Facing::PlusX, Facing::PlusX],
        }
    }

    /// Whether two rows may stand to each other like this, the first one at the smaller x.
    pub(super) const fn allows(self, first: Facing, second: Facing) -> bool {
        match self {
            Self::BackToBack => !matches!((first, second), (Facing::MinusX, Facing::PlusX)),
            Self::FaceToFace => !matches!((first, second), (Facing::PlusX, Facing::MinusX)),
            Self::Tandem => first.is(second),
            Self::ByRows => true,
        }
    }
}

//! Why bearings do not make a spindle.

use crate::real::Real;
use crate::spindle::arrangement::{Arrangement, Facing};
use crate::status::{Quantity, Status};
use core::fmt;

/// Why rows cannot be a spindle. Rows are counted from 0.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case"),
    serde(bound(
        serialize = "T: crate::serialize::Written",
        deserialize = "T: crate::serialize::Read<'de>"
    ))
)]
pub enum SpindleError<T> {
    /// There is no row.
    NoRow,
    /// A figure of a row is out of range.
    Row {
        /// Which row.
        row: usize,
        /// Which figure, and its range.
        status: Status<T>,
    },
    /// A row is to be preloaded by a force that presses nothing.
    NoForce {
        /// Which row.
        row: usize,
        /// The force, N.
        #[cfg_attr(feature = "serde", serde(with = "crate::serialize::number"))]
        force: T,
    },
    /// Two rows are nearer to each other than half a ball's diameter.
    TooNear {
        /// One of them.
        row: usize,
        /// Their distance, m.
        #[cfg_attr(feature = "serde", serde(with = "crate::serialize::number"))]
        distance: T,
        /// Least distance, m.
        least: T,
    },
    /// The rows do not stand to each other as the arrangement says.
    NotArranged {
        /// The arrangement that they claim.
        arrangement: Arrangement,
        /// The row that faces the wrong way.
        row: usize,
        /// How it faces.
        facing: Facing,
    },
    /// All rows slide: nothing holds the shaft along its axis.
    NotHeld,
    /// A row is preloaded that no clamped row faces, or the sliding rows face both ways.
    Unopposed {
        /// Which row.
        row: usize,
    },
    /// There is a spring, but no row slides.
    NothingSlides,
    /// A row slides, but there is no spring.
    NoSpring {
        /// Which row.
        row: usize,
    },
    /// A row's support is too soft to hold it, or its stiffness is not a number.
    Support {
        /// Which row.
        row: usize,
        /// Which stiffness.
        quantity: Quantity,
        /// Its value.
        #[cfg_attr(feature = "serde", serde(with = "crate::serialize::number"))]
        value: T,
        /// Least value.
        least: T,
    },
    /// A constant load on the shaft is out of range.
    Load {
        /// Which load.
        load: usize,
        /// Which figure, and its range.
        status: Status<T>,
    },
    /// The shaft has its constant loads already.
    HasLoads,
}

impl<T> SpindleError<T> {
    /// Condition that the rows must fulfil. A literal, for the compiler's error about a spindle in a `const`, which has no numbers.
    pub const fn reason(&self) -> &'static str {
        use Quantity as Q;
        match self {
            Self::NoRow => "a spindle needs a row of balls",
            Self::Row { status, .. } | Self::Load { status, .. } => match status {
                Status::NotFinite { quantity, .. } | Status::OutOfRange { quantity, .. } => {
                    match quantity {
                        Q::RowPosition => "a row must be within 4096 of its radii Rp of x = 0",
                        Q::Closure => {
                            "closure e of a row must be at most a quarter of the distance L0 of the groove centres, besides \
                             half its play"
                        }
                        Q::PreloadForce | Q::SpringForce => {
                            "force of a preload or spring must be at most that which presses all balls of a row by a 64th of \
                             the distance L0 of the groove centres"
                        }
                        Q::LoadPosition => "a constant load must be within 4096 radii Rp of x = 0",
                        _ => {
                            "a constant load must be at most that which presses all balls by the distance L0 of the groove centres"
                        }
                    }
                }
                _ => "a figure of a row is out of range",
            },
            Self::NoForce { .. } => {
                "a row is preloaded by a force that presses nothing: give a positive force, or a closure"
            }
            Self::TooNear { .. } => {
                "two rows are nearer to each other than half a ball's diameter: check the positions"
            }
            Self::NotArranged { arrangement, .. } => match arrangement {
                Arrangement::BackToBack => {
                    "back to back, rows at smaller x face +x and rows at larger x face -x"
                }
                Arrangement::FaceToFace => {
                    "face to face, rows at smaller x face -x and rows at larger x face +x"
                }
                Arrangement::Tandem | Arrangement::ByRows => "in tandem, all rows face one way",
            },
            Self::NotHeld => {
                "all rows slide under the spring, and nothing holds the shaft along its axis: clamp one of them"
            }
            Self::Unopposed { .. } => {
                "a row is preloaded, but no clamped row faces it, or rows in the sleeve face both ways: turn a row round, or load the shaft instead"
            }
            Self::NothingSlides => {
                "there is a spring, but no row slides: hold a row by `Preload::Spring`"
            }
            Self::NoSpring { .. } => {
                "a row slides, but there is no spring: build the spindle by `Spindle::sprung`"
            }
            Self::Support { quantity, .. } => match quantity {
                Q::TiltingSupport => {
                    "tilting stiffness of a support must be 1 N m/rad at least; an infinite one is rigid"
                }
                _ => {
                    "axial and radial stiffness of a support must be 1e5 N/m at least; an infinite one is rigid"
                }
            },
            Self::HasLoads => "the shaft has constant loads already: give all of them in one call",
        }
    }
}

impl<T: Real> fmt::Display for SpindleError<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Row { row, status } => write!(f, "row {row}: {status}"),
            Self::NoForce { row, force } => write!(
                f,
                "row {row} is preloaded by {force} N: give a positive force, or a closure"
            ),
            Self::TooNear {
                row,
                distance,
                least,
            } => write!(
                f,
                "row {row}: another row is {distance:e} m away, nearer than half a ball's diameter, {least:e} m: check \
                 the positions"
            ),
            Self::NotArranged {
                arrangement,
                row,
                facing,
            } => write!(
                f,
                "row {row} faces {}, which is not {}: {}",
                facing.name(),
                arrangement.name(),
                self.reason()
            ),
            Self::Unopposed { row } => write!(
                f,
                "row {row} is preloaded, but no clamped row faces it, or rows in the sleeve face both ways: turn a row round, or load the shaft instead"
            ),
            Self::NoSpring { row } => write!(
                f,
                "row {row} slides, but there is no spring: build the spindle by `Spindle::sprung`"
            ),
            Self::Support {
                row,
                quantity,
                value,
                least,
            } => write!(
                f,
                "row {row}: {quantity} is {value:e}, but must be {least:e} at least; an infinite one is rigid"
            ),
            Self::Load { load, status } => write!(f, "constant load {load}: {status}"),
            Self::NoRow | Self::NotHeld | Self::NothingSlides | Self::HasLoads => {
                f.write_str(self.reason())
            }
        }
    }
}

impl<T: Real> core::error::Error for SpindleError<T> {}

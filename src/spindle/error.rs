//! Why bearings do not make a spindle.

use crate::real::Real;
use crate::spindle::arrangement::{Arrangement, Facing};
use crate::status::Quantity;
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
    /// There are more rows than the spindle's type has room for.
    TooManyRows {
        /// Number of rows.
        rows: usize,
        /// Largest number, `R`.
        most: usize,
    },
    /// A figure of a row is out of its range.
    Row {
        /// Which row.
        row: usize,
        /// Which figure.
        quantity: Quantity,
        /// Its value.
        #[cfg_attr(feature = "serde", serde(with = "crate::serialize::number"))]
        value: T,
        /// Least value.
        #[cfg_attr(feature = "serde", serde(with = "crate::serialize::number"))]
        least: T,
        /// Largest value.
        #[cfg_attr(feature = "serde", serde(with = "crate::serialize::number"))]
        most: T,
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
    /// A figure of a constant load on the shaft is out of its range.
    Load {
        /// Which load.
        load: usize,
        /// Which figure.
        quantity: Quantity,
        /// Its value.
        #[cfg_attr(feature = "serde", serde(with = "crate::serialize::number"))]
        value: T,
        /// Least value.
        #[cfg_attr(feature = "serde", serde(with = "crate::serialize::number"))]
        least: T,
        /// Largest value.
        #[cfg_attr(feature = "serde", serde(with = "crate::serialize::number"))]
        most: T,
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
            Self::TooManyRows { .. } => {
                "there are more rows than the type of the spindle has room for: give it a larger `R`"
            }
            Self::Row { quantity, .. } => match quantity {
                Q::RowPosition => "a row must be within 4096 of its radii Rp of x = 0",
                Q::RowDistance => {
                    "two rows are nearer to each other than half a ball's diameter: check the positions"
                }
                Q::Closure => {
                    "closure e of a row must be at most a quarter of the distance L0 of the groove centres, besides \
                     half its play"
                }
                Q::TiltingSupport => {
                    "tilting stiffness of a support must be 1 N m/rad at least; an infinite one is rigid"
                }
                Q::AxialSupport | Q::RadialSupport => {
                    "axial and radial stiffness of a support must be 1e5 N/m at least; an infinite one is rigid"
                }
                Q::SpringForce => {
                    "force of a spring must be above 0, and at most that which presses all balls of a row by a 64th of the \
                     distance L0 of the groove centres"
                }
                _ => {
                    "force of a preload must be above 0, and at most that which presses all balls of a row by a 64th of the \
                     distance L0 of the groove centres; a closure may be given in its place"
                }
            },
            Self::Load { quantity, .. } => match quantity {
                Q::LoadPosition => "a constant load must be within 4096 radii Rp of x = 0",
                _ => {
                    "a constant load must be at most that which presses all balls by the distance L0 of the groove centres"
                }
            },
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
            Self::HasLoads => "the shaft has constant loads already: give all of them in one call",
        }
    }
}

impl<T: Real> fmt::Display for SpindleError<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Row {
                row,
                quantity,
                value,
                least,
                most,
            } => {
                write!(f, "row {row}: ")?;
                out_of_range(f, *quantity, *value, [*least, *most])?;
                f.write_str(match quantity {
                    Quantity::RowDistance => ", half a ball's diameter: check the positions",
                    Quantity::AxialSupport | Quantity::RadialSupport | Quantity::TiltingSupport => {
                        "; an infinite one is rigid"
                    }
                    Quantity::PreloadForce => "; a closure may be given in its place",
                    _ => "",
                })
            }
            Self::Load {
                load,
                quantity,
                value,
                least,
                most,
            } => {
                write!(f, "constant load {load}: ")?;
                out_of_range(f, *quantity, *value, [*least, *most])
            }
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
            Self::TooManyRows { rows, most } => {
                write!(
                    f,
                    "there are {rows} rows, but the spindle has room for {most}"
                )
            }
            Self::NoRow | Self::NotHeld | Self::NothingSlides | Self::HasLoads => {
                f.write_str(self.reason())
            }
        }
    }
}

impl<T: Real> core::error::Error for SpindleError<T> {}

/// A figure, and the range that it must lie in.
fn out_of_range<T: Real>(
    f: &mut fmt::Formatter<'_>,
    quantity: Quantity,
    value: T,
    [least, most]: [T; 2],
) -> fmt::Result {
    write!(f, "{quantity} is {value}, but must be ")?;
    if !most.is_finite() {
        write!(f, "{least} at least")
    } else if least == -most {
        write!(f, "at most {most} in magnitude")
    } else if least == T::TINY {
        write!(f, "above 0, and at most {most}")
    } else {
        write!(f, "{least} to {most}")
    }
}

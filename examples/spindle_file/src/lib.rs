//! A spindle's file: designs, rows, shaft, loads, probes and settings of its monitor, as people type them; spindles whose sizes
//! are known at run time.
//!
//! A program that reads any spindle, and tells the stiffness at its nose over the speed:
//!
//! ```
//! use spindle_file::{dispatch::Precision, loads::LoadRow, solvers::{Balls, with_solver}, spindles::SpindleFile};
//!
//! let file = SpindleFile::read("spindles/milling_spindle.toml")?;
//! let solved = with_solver(&file.plan, Balls::Free, Precision::F64, |solver| {
//!     for speed_rpm in [0.0, 5e3, 10e3, 15e3] {
//!         let loads = LoadRow { speed_rpm, load: [0.0, 300.0, 0.0, 0.0, 0.0], ..LoadRow::default() };
//!         // The points that are asked for are the file's noses.
//!         match solver.solve(&file.question(&loads)) {
//!             Ok(answer) => println!("{speed_rpm} 1/min: {:.0} N/um", 1e-6 / answer.at[0].compliance[1][1]),
//!             Err(status) => println!("{speed_rpm} 1/min: {status}"),
//!         }
//!     }
//! });
//! solved.map_err(|error| file.explain(&error))?;
//! # Ok::<(), spindle_file::reading::DesignFileError>(())
//! ```

pub mod calibration;
pub mod catalogue;
pub mod designs;
#[cfg(feature = "solvers")]
pub mod dispatch;
mod doubts;
mod identity;
pub mod loads;
pub mod monitors;
pub mod mounting;
pub mod noses;
pub mod plan;
pub mod probes;
pub mod reading;
mod shafts;
#[cfg(feature = "solvers")]
pub mod solvers;
pub mod spindles;

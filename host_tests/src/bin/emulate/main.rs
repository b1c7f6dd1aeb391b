//! `cargo emulate`: runs the firmware on an emulated STM32F405, feeds it recorded loads, and holds
//! every estimate it sends back against the host's own.
//!
//! | module | does |
//! | --- | --- |
//! | `toolchain` | sees to it that there is an emulator |
//! | `firmware` | builds the ELF and reads its sizes |
//! | `loads` | reads the recorded loads |
//! | `emulator` | the running board: bytes in, lines of its log out |
//! | `report` | a line of the log as fields, and as a row of the table |
//! | `exchange` | records out, answers back, and the comparison |

mod emulator;
mod exchange;
mod firmware;
mod loads;
#[path = "../../../../examples/monitored.rs"]
mod monitored;
mod report;
mod toolchain;

/// That of the emulated core.
type Precision = f32;

use anyhow::{Context, Result};
use clap::Parser;
use std::path::Path;
use std::process::ExitCode;
use std::time::Duration;

/// Status when the run did not show what it should.
const DISAGREEMENT: u8 = 1;
/// Status when the run could not start.
const NOT_STARTED: u8 = 2;

/// Runs the spindle monitor's firmware on an emulated STM32F405, feeds it recorded loads over the
/// emulated serial port, and compares each estimate with the host's, bit for bit.
#[derive(Parser, Debug)]
#[command(
    name = "emulate",
    bin_name = "cargo emulate",
    after_help = "Exit status:\n  \
        0  every record was answered, every answer equals the host's to the last bit\n  \
        1  an answer differs or is missing, a record was lost, or the emulator stopped\n  \
        2  it could not start: arguments, input file, Rust target, emulator or build"
)]
struct Arguments {
    /// Recorded loads: CSV with the header
    /// time_s,fx_n,fy_n,fz_n,my_nm,mz_nm,speed_rpm; `-` is standard input [default: the project's milling cycle]
    #[arg(long, value_name = "LOADS.csv")]
    input: Option<String>,

    /// Stop after so much recorded time [default: all of it]
    #[arg(long, value_name = "S", value_parser = positive)]
    seconds: Option<f64>,

    /// Slip in a damaged frame after every so many records; 0 for none
    #[arg(long, value_name = "RECORDS", default_value_t = 500)]
    corrupt: usize,

    /// Show every so many records [default: some 100 rows in all]; those without an answer, and
    /// those that did not converge, are always shown
    #[arg(long, value_name = "RECORDS", value_parser = clap::value_parser!(u32).range(1..))]
    every: Option<u32>,

    /// Longest wait for an answer, s
    #[arg(long, value_name = "S", default_value_t = 20.0, value_parser = positive)]
    patience: f64,
}

fn positive(text: &str) -> Result<f64, String> {
    match text.parse() {
        // A week is beyond every recording, and within every clock's range.
        Ok(x) if x > 0.0 && x <= 604_800.0 => Ok(x),
        _ => Err("must be a number of seconds above 0".into()),
    }
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let (plan, firmware, emulator) = match prepare(&arguments) {
        Ok(ready) => ready,
        Err(error) => return fail(&error, NOT_STARTED),
    };
    match exchange::run(&plan, &firmware, &emulator) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => fail(&error, DISAGREEMENT),
    }
}

fn fail(error: &anyhow::Error, status: u8) -> ExitCode {
    eprintln!("error: {error:#}");
    ExitCode::from(status)
}

fn prepare(
    arguments: &Arguments,
) -> Result<(exchange::Plan, firmware::Firmware, toolchain::Emulator)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"))
        .parent()
        .context("the project has no root folder")?;
    let input = match &arguments.input {
        Some(path) => path.clone(),
        None => root
            .join("host_tests/records/milling_cycle.csv")
            .display()
            .to_string(),
    };
    let records = loads::read(&input, arguments.seconds)?;
    host_tests::cross::add_target(root)?;
    let emulator = toolchain::find_emulator()?;
    let firmware = firmware::build(root)?;
    let every = arguments
        .every
        .map_or_else(|| records.len().div_ceil(100), |n| n as usize);
    let plan = exchange::Plan {
        records,
        corrupt: arguments.corrupt,
        every,
        patience: Duration::from_secs_f64(arguments.patience),
    };
    Ok((plan, firmware, emulator))
}

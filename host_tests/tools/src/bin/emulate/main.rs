//! `cargo emulate`: runs the spindle monitor's firmware on an emulated STM32F405 and feeds it recorded
//! loads. All of its telemetry is held against the telemetry of the host's own build of the monitor.
//!
//! The board runs in lock-step: a tick is a command in the stream, and ticks are what time is. No clock of
//! this machine or of the emulator has a part in it, so that a run is the same every time.
//!
//! | module | does |
//! | --- | --- |
//! | `plan` | the bytes for the board, and what it must answer |
//! | `emulator` | the firmware, and the running board: bytes in and out, lines of its log |
//! | `exchange` | the run, and the comparison |
//! | `rows` | an estimate as a row of the table |
//! | `summary` | counts, and the golden file |

mod emulator;
mod exchange;
mod plan;
mod rows;
mod summary;

use anyhow::{Result, anyhow};
use clap::Parser;
use emulator::Firmware;
use host_tests::milling_cycle::record_of;
use plan::Plan;
use spindle_firmware::spindle::{PERIOD_US, ROWS};
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::mpsc;
use std::thread;
use tools::stream::faults::{self, Spoiler};
use tools::stream::records;
use tools::telemetry::session::Session;
use tools::telemetry::{source, view};

/// Status when the run did not show what it should.
const DISAGREEMENT: u8 = 1;
/// Status when the run could not start.
const NOT_STARTED: u8 = 2;

/// Runs the spindle monitor's firmware on an emulated STM32F405, and feeds it recorded loads over the
/// emulated serial port. Compares its telemetry with the host's own, bit for bit.
///
/// Time is counted in ticks of the stream, a millisecond each, so that every run is the same.
#[derive(Parser, Debug)]
#[command(
    name = "emulate",
    bin_name = "cargo emulate",
    after_help = "Exit status:\n  \
        0  the telemetry equals the host's to the last bit, and the summary the golden file\n  \
        1  it does not, or the emulator stopped\n  \
        2  it could not start: arguments, input file, Rust target, emulator or build"
)]
struct Arguments {
    /// Recorded loads: CSV with the header
    /// time_s,fx_n,fy_n,fz_n,my_nm,mz_nm,speed_rpm, and t_inner_c,t_outer_c if there are temperatures; `-` is standard input
    /// [default: the project's milling cycle]
    #[arg(long, value_name = "LOADS.csv")]
    input: Option<String>,

    /// Stop after so much recorded time [default: all of it]
    #[arg(long, value_name = "S", value_parser = positive)]
    seconds: Option<f64>,

    /// Inject faults, and hold the summary against the golden file
    #[arg(long)]
    faults: bool,

    /// Where the faults begin to be drawn from
    #[arg(long, value_name = "NUMBER", default_value_t = 1, requires = "faults")]
    seed: u64,

    /// Make the summary of this run the golden file
    #[arg(long, requires = "faults", conflicts_with = "input")]
    accept: bool,

    /// Show the telemetry live; q leaves
    #[arg(long)]
    view: bool,
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
    let (status, error) = match prepare(&arguments) {
        Err(error) => (NOT_STARTED, error),
        Ok((plan, firmware)) => match run(&arguments, &plan, &firmware) {
            Err(error) => (DISAGREEMENT, error),
            Ok(()) => return ExitCode::SUCCESS,
        },
    };
    eprintln!("error: {error:#}");
    ExitCode::from(status)
}

/// All that a run takes.
fn prepare(arguments: &Arguments) -> Result<(Plan, Firmware)> {
    let shipped = || record_of(ROWS).to_owned();
    let input = arguments.input.clone().unwrap_or_else(shipped);
    let recording = records::read(&input, arguments.seconds, PERIOD_US)?;
    tools::cross::add_target(tools::root())?;
    emulator::find()?;
    let firmware = Firmware::build(tools::root())?;
    let episodes = match arguments.faults {
        true => faults::schedule(arguments.seed, &recording.records),
        false => Vec::new(),
    };
    let plan = plan::plan(&recording, Spoiler::new(arguments.seed, episodes))?;
    Ok((plan, firmware))
}

/// The golden file of a run, if it may have one.
fn golden(arguments: &Arguments) -> Option<PathBuf> {
    let length = match arguments.seconds {
        Some(seconds) => format!("{seconds}_s"),
        None => "whole".into(),
    };
    let name = format!("faults_{length}_seed_{}.txt", arguments.seed);
    let is_known = arguments.faults && arguments.input.is_none();
    is_known.then(|| tools::root().join("host_tests/golden").join(name))
}

fn run(arguments: &Arguments, plan: &Plan, firmware: &Firmware) -> Result<()> {
    let answer = if arguments.view {
        // The view draws at the pace of the recording; the board may be ahead of it.
        let (sender, chunks) = mpsc::sync_channel(usize::from(u16::MAX));
        thread::scope(|scope| {
            let running = scope.spawn(|| exchange::run(plan, firmware, Some(sender)));
            view::view(&source::paced(chunks, 1.0), &mut Session::default())?;
            running.join().map_err(|_| anyhow!("the run panicked"))?
        })?
    } else {
        exchange::run(plan, firmware, None)?
    };
    let Some(answer) = answer else {
        println!("the view was left before the run was over");
        return Ok(());
    };
    let text = summary::summary(plan, &answer)?;
    println!(
        "\n{text}\n{} frames in {} bytes of telemetry, equal to the host's to the last bit; {} lines of log",
        answer.frames.len(),
        plan.expected.len(),
        answer.log.len(),
    );
    match golden(arguments) {
        Some(path) => summary::check(&path, &text, arguments.accept),
        None => Ok(()),
    }
}

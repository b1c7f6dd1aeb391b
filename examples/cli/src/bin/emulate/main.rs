//! `cargo emulate`: runs the spindle monitor's firmware on an emulated STM32F405 and feeds it recorded
//! loads. All of its telemetry is held against the telemetry of the host's own build of the monitor.
//!
//! The board runs in lock-step: a tick is a command in the stream, and ticks are what time is. No clock of
//! this machine or of the emulator has a part in it, so that a run is the same every time.
//!
//! | module | does |
//! | --- | --- |
//! | `twin` | the firmware's twin on this machine |
//! | `plan` | the bytes for the board, and the answers it must give |
//! | `exchange` | the run, and the comparison |
//! | `rows` | an estimate as a row of the table |
//! | `summary` | counts, and the golden file |

mod exchange;
mod plan;
mod rows;
mod summary;
mod twin;

use anyhow::{Result, anyhow};
use clap::Parser;
use cli::cross::{self, Build, TARGET};
use cli::emulator::{self, Firmware};
use cli::milling_cycle::record_of;
use cli::stream::faults::{self, Spoiler};
use cli::stream::records;
use cli::telemetry::session::Session;
use cli::telemetry::{source, view};
use plan::Plan;
use spindle_file::mounting::board;
use spindle_file::spindles::SpindleFile;
use spindle_monitor::tick::Core;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::mpsc;
use std::thread;
use twin::Twin;

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
    /// The spindle: a file as `cargo replay` reads it [default: the firmware's own, examples/firmware/spindle.toml]
    #[arg(value_name = "SPINDLE.toml", env = "SPINDLE", hide_env_values = true)]
    spindle: Option<String>,

    /// Recorded loads: CSV with the header
    /// time_s,fx_n,fy_n,fz_n,my_nm,mz_nm,speed_rpm, t_inner_c,t_outer_c if there are temperatures, and probe_NAME_um for each probe;
    /// `-` is standard input
    /// [default: the project's milling cycle]
    #[arg(value_name = "RECORDING")]
    recording: Option<String>,

    /// Stop after so much recorded time [default: all of it]
    #[arg(long, value_name = "S", value_parser = positive)]
    seconds: Option<f64>,

    /// Inject faults, and hold the summary against the golden file. Besides, a board with a short stack must say that it runs over
    #[arg(long)]
    faults: bool,

    /// Where the faults begin to be drawn from
    #[arg(long, value_name = "NUMBER", default_value_t = 1, requires = "faults")]
    seed: u64,

    /// Make the summary of this run the golden file
    #[arg(long, requires = "faults", conflicts_with = "spindle")]
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
    let root = cli::root();
    let spindle = arguments.spindle.as_deref().map(from_root);
    let file = spindle
        .as_deref()
        .unwrap_or("examples/firmware/spindle.toml");
    // A name of the catalogue is no file here.
    let (here, name) = (root.join(file), Path::new(file));
    let file = SpindleFile::read(if here.exists() { &here } else { name })?;
    // Before anything is built.
    board::plan(&file, Some(Core::STM32F405))?;
    let shipped = || record_of(file.plan.rows.len()).to_owned();
    let path = arguments.recording.clone().unwrap_or_else(shipped);
    let period_us = file.settings(&Core::STM32F405).tick.period_us;
    let recording = records::read(&path, &file.probes, arguments.seconds, period_us)?;
    cross::add_target(root)?;
    eprintln!(
        "building the firmware for {TARGET}, and its twin; the first time takes about a minute"
    );
    let build = Build {
        package: cross::F405,
        program: "spindle_firmware",
        // Another profile makes another build: the shipped one is kept beside it.
        profile: match spindle {
            Some(_) => &["package.spindle_firmware.debug=2"],
            None => &[],
        },
        environment: &[("SPINDLE", spindle.as_deref())],
        ..Build::default()
    };
    // The firmware takes half a minute, of one core in the end: the other one builds the twin.
    let (built, twin) = thread::scope(|scope| {
        let built = scope.spawn(|| build.run(root));
        let twin = cross::twin(root, spindle.as_deref());
        let found = emulator::find();
        let built = built.join().map_err(|_| anyhow!("the build has panicked"));
        anyhow::Ok((built??, found.and(twin)?))
    })?;
    let twin = Twin(twin);
    let running = twin.start()?;
    let firmware = Firmware::read(twin.seal(&built)?)?;
    let episodes = match arguments.faults {
        true => faults::schedule(arguments.seed, &recording.records),
        false => Vec::new(),
    };
    let spoiler = Spoiler::new(arguments.seed, episodes);
    let plan = plan::plan(&recording, spoiler, running)?;
    Ok((plan, firmware))
}

/// A spindle's file as the build finds it from the root of the checkout: one that is here by its whole path; a name of the
/// catalogue stays.
fn from_root(file: &str) -> String {
    let whole = std::path::absolute(file).ok().filter(|path| path.exists());
    whole.map_or_else(|| file.to_owned(), |path| path.display().to_string())
}

/// The golden file of a run, if it may have one.
fn golden(arguments: &Arguments) -> Option<PathBuf> {
    let length = match arguments.seconds {
        Some(seconds) => format!("{seconds}_s"),
        None => "whole".into(),
    };
    let name = format!("faults_{length}_seed_{}.txt", arguments.seed);
    let is_known = arguments.faults && arguments.spindle.is_none();
    is_known.then(|| cli::root().join("examples/cli/golden").join(name))
}

fn run(arguments: &Arguments, plan: &Plan, firmware: &Firmware) -> Result<()> {
    if arguments.faults {
        exchange::overrun(firmware)?;
    }
    let answer = if arguments.view {
        // The view draws at the pace of the recording; the board may be ahead of it.
        let (sender, chunks) = mpsc::sync_channel(usize::from(u16::MAX));
        thread::scope(|scope| {
            let running = scope.spawn(|| exchange::run(plan, firmware, Some(sender)));
            view::view(&source::paced(chunks), &mut Session::default())?;
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
        "\n{}\n{text}\n{} frames in {} bytes of telemetry, equal to the host's to the last bit; {} lines of log; {} bytes of stack never used",
        summary::seen(&answer),
        answer.frames.len(),
        plan.expected.len(),
        answer.log.len(),
        answer.unused_stack,
    );
    match golden(arguments) {
        Some(path) => summary::check(&path, &text, arguments.accept),
        None => Ok(()),
    }
}

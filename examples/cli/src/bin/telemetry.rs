//! `cargo telemetry`: reads the monitor's telemetry from a port or a recording, prints it as lines of JSON, or shows it
//! live.

use anyhow::{Context, Result};
use clap::{ArgGroup, Parser};
use cli::milling_cycle::record_of;
use cli::output::NewFile;
use cli::recordings::{self, Wanted};
use cli::telemetry::session::Session;
use cli::telemetry::simulated;
use cli::telemetry::source::{self, Chunks, PortOperator};
use cli::telemetry::{picture, view};
use spindle_file::spindles::SpindleFile;
use spindle_monitor::command::Order;
use std::fs::File;
use std::io::{self, BufWriter, Cursor, Write};
use std::path::PathBuf;
use std::process::ExitCode;

/// Size of the screen of `--picture`, cells.
const SCREEN: (u16, u16) = (120, 40);

/// Sources that nobody can give an order to. clap drops a `requires` whose argument conflicts with one that is there.
const NO_BOARD: [&str; 2] = ["replay", "simulate"];

/// Reads the monitor's telemetry, and prints it as lines of JSON, or shows it live.
///
/// Damaged and missing frames are counted, and told at the end.
#[derive(Parser, Debug)]
#[command(
    name = "telemetry",
    bin_name = "cargo telemetry",
    group(ArgGroup::new("source").required(true)),
    after_help = "Exit status:\n  \
        0  the stream has ended, or the view was left; damage and losses are told, not counted as failure\n  \
        1  the stream cannot be read, nothing in it is telemetry, or an output cannot be written"
)]
struct Arguments {
    /// Serial port, as /dev/ttyUSB0 or COM3
    #[arg(long, value_name = "PORT", group = "source")]
    port: Option<String>,

    /// Acknowledge the alarms that stand, and go on; with --view, press a
    #[arg(long, requires = "port", conflicts_with_all = NO_BOARD)]
    acknowledge: bool,

    /// The bearing was replaced: forget the life used, with the spindle at a standstill and the board in service; with
    /// --view, press r
    #[arg(long, requires = "port", conflicts_with_all = NO_BOARD)]
    new_bearing: bool,

    /// The shaft stands still, though its speed was lost, with the board in service; with --view, press s
    #[arg(long, requires = "port", conflicts_with_all = NO_BOARD)]
    shaft_stands: bool,

    /// The spindle is as it should be: preload and gains of now count as those of commissioning, with the board in service; with
    /// --view, press c
    #[arg(long, requires = "port", conflicts_with_all = NO_BOARD)]
    commission: bool,

    /// Baud rate of the port
    #[arg(long, value_name = "BAUD", default_value_t = 921_600)]
    baud: u32,

    /// Recorded stream: bytes as they came from the port, or lines of --json; `-` is standard input
    #[arg(long, value_name = "FILE", group = "source")]
    replay: Option<String>,

    /// Without a board: its monitor on this machine, fed with a recording
    #[arg(long, group = "source")]
    simulate: bool,

    /// The simulated spindle: a file as `cargo replay` reads it [default: the firmware's own, examples/firmware/spindle.toml]
    #[arg(value_name = "SPINDLE.toml", requires = "simulate", conflicts_with_all = ["port", "replay"])]
    spindle: Option<PathBuf>,

    /// Its recorded loads, as for `cargo emulate` [default: the project's milling cycle]
    #[arg(value_name = "RECORDING", requires = "spindle")]
    recording: Option<String>,

    /// Stop the simulation after so much recorded time
    #[arg(long, value_name = "S", requires = "simulate", conflicts_with_all = ["port", "replay"])]
    seconds: Option<f64>,

    /// Write every frame as an object of JSON, one a line, to this file or to standard output (the
    /// default without --view and --picture)
    #[arg(
        long,
        value_name = "FILE",
        require_equals = true,
        num_args = 0..=1,
        default_missing_value = "-"
    )]
    json: Option<String>,

    /// Show the stream live; q leaves. With a port: a acknowledges alarms, r replaces the bearing, c commissions the probes
    #[arg(long)]
    view: bool,

    /// At the end, draw the view to this file
    #[arg(long, value_name = "FILE.svg")]
    picture: Option<PathBuf>,
}

fn main() -> ExitCode {
    match run(&Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}

fn run(arguments: &Arguments) -> Result<()> {
    let (chunks, mut operator) = open(arguments)?;
    if let Some(operator) = &mut operator {
        if arguments.acknowledge {
            operator.want_all_acknowledged();
        }
        if arguments.new_bearing {
            operator.want(Order::ReplaceBearing);
        }
        if arguments.shaft_stands {
            operator.want(Order::ShaftStands);
        }
        if arguments.commission {
            operator.want(Order::Commission);
        }
    }
    let shows = arguments.view || arguments.picture.is_some();
    let json = match arguments.json.as_deref() {
        None if shows => None,
        None => Some("-"),
        named => named,
    };
    let mut session = Session::new(operator, json.map(create).transpose()?);
    let port = arguments.port.as_deref().map(|port| (port, arguments.baud));
    let ended = match arguments.view {
        false => session.read(&chunks, port),
        true if port.is_none() => view::view(&source::paced(chunks), &mut session),
        true => view::view(&chunks, &mut session),
    };
    // A port that was unplugged is told of after what came from it.
    eprintln!("{}", session.state.tally);
    if let Some(json) = &mut session.json {
        json.flush()?;
    }
    ended?;
    source::is_telemetry(&session.state.tally, port)?;
    if let Some(path) = &arguments.picture {
        let (width, height) = SCREEN;
        let svg = picture::svg(&view::screen(&session.state, width, height));
        NewFile::write_whole(path, svg.as_bytes())
            .with_context(|| format!("cannot write {}", path.display()))?;
    }
    Ok(())
}

/// Where the bytes come from, and for a port, who says something to it.
fn open(arguments: &Arguments) -> Result<(Chunks, Option<PortOperator>)> {
    if let Some(port) = &arguments.port {
        let (chunks, operator) = source::port(port, arguments.baud)?;
        return Ok((chunks, Some(operator)));
    }
    if let Some(path) = &arguments.replay {
        return Ok((source::recorded(path)?, None));
    }
    let end = arguments.seconds.unwrap_or(f64::INFINITY);
    let own = cli::root().join("examples/firmware/spindle.toml");
    let file = SpindleFile::read(arguments.spindle.as_ref().unwrap_or(&own))?;
    let cycle = record_of(file.plan.rows.len()).to_owned();
    let path = arguments.recording.as_ref().unwrap_or(&cycle);
    let wanted = Wanted {
        probes: file.probes.iter().map(|probe| probe.name.clone()).collect(),
        shares_times: true,
        ..Wanted::default()
    };
    let rows = recordings::read(path, &wanted)?;
    let rows = rows.take_while(|row| row.as_ref().map_or(true, |row| row.time_s < end));
    let bytes = simulated::stream(&file, rows)?;
    Ok((source::stream(Cursor::new(bytes)), None))
}

fn create(path: &str) -> Result<Box<dyn Write>> {
    if path == "-" {
        return Ok(Box::new(io::stdout()));
    }
    let file = File::create(path).with_context(|| format!("cannot write {path}"))?;
    Ok(Box::new(BufWriter::new(file)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_source_cannot_do_is_refused() {
        let parse = |words: &[&str]| Arguments::try_parse_from([&["telemetry"], words].concat());
        for order in [
            "--acknowledge",
            "--new-bearing",
            "--shaft-stands",
            "--commission",
        ] {
            let order = &[order][..];
            assert!(parse(&[&["--port", "COM3"], order].concat()).is_ok());
            for source in [&["--simulate"][..], &["--replay", "stream"]] {
                let refused = parse(&[source, order].concat()).unwrap_err();
                assert!(
                    refused.to_string().contains("cannot be used with"),
                    "{refused}"
                );
            }
            assert!(parse(order).is_err());
        }
        assert!(parse(&["--simulate", "--seconds", "2"]).is_ok());
        assert!(parse(&["--replay", "stream", "--seconds", "2"]).is_err());
        assert!(parse(&["--simulate", "spindle.toml", "loads.csv"]).is_ok());
        for source in [&["--port", "COM3"][..], &["--replay", "stream"]] {
            assert!(parse(&[source, &["spindle.toml"]].concat()).is_err());
        }
    }
}

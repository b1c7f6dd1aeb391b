//! `cargo telemetry`: reads the monitor's telemetry from a port, a file or a pipe, prints what it says,
//! writes it as a table, or shows it live.

use anyhow::{Context, Result, bail};
use clap::{ArgGroup, Parser, ValueEnum};
use host_tests::loads;
use host_tests::milling_cycle::record_of;
use host_tests::telemetry::decoder::{Decoder, Event, Gap};
use host_tests::telemetry::operator::{answer_words, words};
use host_tests::telemetry::simulated;
use host_tests::telemetry::simulated::monitored::ROWS;
use host_tests::telemetry::state::{State, facing};
use host_tests::telemetry::table::{Writer, change_name};
use spindle_bearing::monitor::TemperatureSource;
use spindle_bearing::monitor::command::{self, Order};
use spindle_bearing::monitor::telemetry::Payload;
use std::fs::File;
use std::io::{self, BufWriter, Cursor, Write};
use std::path::PathBuf;
use std::process::ExitCode;
use tools::telemetry::source::{self, Chunks, PortOperator};
use tools::telemetry::{picture, view};

/// Size of the screen of `--picture`, cells.
const SCREEN: (u16, u16) = (120, 40);

/// Sources that nobody can give an order to. clap drops a `requires` whose argument conflicts with one that is there.
const NO_BOARD: [&str; 2] = ["file", "simulate"];

/// Reads the monitor's telemetry, and prints it, writes it as a table, or shows it live.
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

    /// Start or end learning the baseline of the stiffness, with the spindle idling; with --view, press s or e
    #[arg(long, value_name = "WHEN", requires = "port", conflicts_with_all = NO_BOARD)]
    learn: Option<Learning>,

    /// The bearing was replaced: forget its baseline and the life used, with the spindle at a standstill; with --view,
    /// press r
    #[arg(long, requires = "port", conflicts_with_all = NO_BOARD)]
    new_bearing: bool,

    /// Key of the board, 32 hexadecimal digits, if it was built with one
    #[arg(long, value_name = "HEX", env = "SPINDLE_KEY", hide_env_values = true)]
    key: Option<String>,

    /// Baud rate of the port
    #[arg(long, value_name = "BAUD", default_value_t = 460_800)]
    baud: u32,

    /// File with the bytes of a stream; `-` is standard input
    #[arg(long, value_name = "FILE", group = "source")]
    file: Option<String>,

    /// Without a board: the shipped monitor on this machine, fed with the project's milling cycle
    #[arg(long, group = "source")]
    simulate: bool,

    /// Stop the simulation after so much recorded time
    #[arg(long, value_name = "S", requires = "simulate", conflicts_with_all = ["port", "file"])]
    seconds: Option<f64>,

    /// Write every frame to this table; `-` is standard output
    #[arg(long, value_name = "FILE.csv")]
    csv: Option<String>,

    /// Show the stream live; q leaves. With a port: a acknowledges alarms, s and e start and end learning the baseline,
    /// r replaces the bearing
    #[arg(long)]
    view: bool,

    /// With --view and not from a port: so many times as fast as it was, 0 for as fast as it comes
    #[arg(
        long,
        value_name = "TIMES",
        default_value_t = 1.0,
        conflicts_with = "port"
    )]
    pace: f64,

    /// At the end, draw the view to this file
    #[arg(long, value_name = "FILE.svg")]
    picture: Option<PathBuf>,
}

/// Whether the board is to learn the baseline.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Learning {
    /// Start
    On,
    /// End
    Off,
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
        if let Some(when) = arguments.learn {
            operator.want(Order::Learn(when == Learning::On));
        }
    }
    let mut table = match &arguments.csv {
        None => None,
        Some(path) => Some(Writer::new(create(path)?)),
    };
    // Somebody who wants a table or a picture does not want a line for each frame.
    let quiet = table.is_some() || arguments.picture.is_some();
    let write = |event: &Event| match &mut table {
        Some(table) => table.write(event),
        None => Ok(()),
    };
    let mut state = State::default();
    let ended = if arguments.view {
        let pace = (arguments.port.is_none() && arguments.pace > 0.0).then_some(arguments.pace);
        view::view(&chunks, pace, &mut state, write, operator.as_mut())
    } else {
        let from = (&chunks, port_of(arguments));
        read(from, quiet, &mut state, write, operator.as_mut())
    };
    // A port that was unplugged is told of after what came from it.
    eprintln!("{}", state.tally);
    if let Some(table) = &mut table {
        table.flush()?;
    }
    ended?;
    source::is_telemetry(&state.tally, port_of(arguments))?;
    if let Some(path) = &arguments.picture {
        let (width, height) = SCREEN;
        let svg = picture::svg(&view::screen(&state, width, height));
        std::fs::write(path, svg).with_context(|| format!("cannot write {}", path.display()))?;
    }
    Ok(())
}

/// The port and its rate, if bytes come from one.
fn port_of(arguments: &Arguments) -> Option<(&str, u32)> {
    arguments.port.as_deref().map(|port| (port, arguments.baud))
}

/// Where the bytes come from, and for a port, who says something to it.
fn open(arguments: &Arguments) -> Result<(Chunks, Option<PortOperator>)> {
    if let Some(port) = &arguments.port {
        let key = match &arguments.key {
            None => None,
            Some(digits) => {
                let key = command::key(digits).context("--key must be 32 hexadecimal digits")?;
                Some(key)
            }
        };
        let (chunks, operator) = source::port(port, arguments.baud, key)?;
        return Ok((chunks, Some(operator)));
    }
    if let Some(path) = &arguments.file {
        return Ok((source::file(path)?, None));
    }
    let mut rows = Vec::new();
    for row in loads::read(record_of(ROWS))? {
        let row = row?;
        if arguments.seconds.is_some_and(|end| row.time_s >= end) {
            break;
        }
        rows.push(row);
    }
    let bytes = simulated::stream(&rows)?;
    Ok((source::stream(Cursor::new(bytes)), None))
}

fn create(path: &str) -> Result<Box<dyn Write>> {
    if path == "-" {
        return Ok(Box::new(io::stdout()));
    }
    let file = File::create(path).with_context(|| format!("cannot write {path}"))?;
    Ok(Box::new(BufWriter::new(file)))
}

/// Damaged pieces after which a port without a single frame is given up.
const HOPELESS: u64 = 100;

/// Reads to the end of the stream.
fn read(
    (chunks, port): (&Chunks, Option<(&str, u32)>),
    quiet: bool,
    state: &mut State,
    mut each: impl FnMut(&Event) -> Result<()>,
    mut operator: Option<&mut PortOperator>,
) -> Result<()> {
    let mut decoder = Decoder::new();
    let mut out = io::stdout().lock();
    for chunk in chunks {
        for byte in chunk.context("cannot read on")? {
            if let Some(event) = decoder.push(byte) {
                each(&event)?;
                state.note(&event, decoder.tally());
                if !quiet {
                    print(&mut out, &event)?;
                }
                if let Some(operator) = &mut operator {
                    operator.follow(state)?;
                    if let Some(order) = operator.unanswered().first() {
                        bail!(
                            "the board does not answer the order to {}: is its RX on this port's TX?",
                            words(order)
                        );
                    }
                }
            }
        }
        let tally = decoder.tally();
        // Bytes without an end of a frame are no event.
        state.tally = tally;
        if port.is_some() && tally.damaged >= HOPELESS {
            source::is_telemetry(&tally, port)?;
        }
    }
    Ok(())
}

/// One line for an event.
fn print(out: &mut impl Write, event: &Event) -> Result<()> {
    let (frame, gap) = match event {
        Event::Damaged(error) => return Ok(writeln!(out, "damaged: {error}")?),
        Event::Frame { frame, gap } => (frame, gap),
    };
    match gap {
        Gap::None => {}
        Gap::Lost(count) => {
            let from = frame.sequence.wrapping_sub(*count);
            let to = frame.sequence.wrapping_sub(1);
            writeln!(out, "lost: {count} frames, {from} to {to}")?;
        }
        Gap::Behind => writeln!(
            out,
            "behind: an old frame again, or a new start of the sender"
        )?,
        Gap::Restart => writeln!(out, "the sender has started again")?,
    }
    let time = frame.time_us as f64 * 1e-6;
    write!(out, "{:>8} {time:12.6} s  ", frame.sequence)?;
    match &frame.payload {
        Payload::Estimate(report) => {
            let k = report.stiffness;
            writeln!(
                out,
                "estimate  Kx {:.2} Ky {:.2} Kz {:.2}, nose {:.2} {:.2} {:.2} N/um  Q {:.1} to {:.1} N  {}{}{}",
                k[0] * 1e-6,
                k[1] * 1e-6,
                k[2] * 1e-6,
                report.nose[0] * 1e-6,
                report.nose[1] * 1e-6,
                report.nose[2] * 1e-6,
                report.least_force,
                report.largest_force,
                report.status.name(),
                if report.marks.is_empty() {
                    ""
                } else {
                    "  doubted: "
                },
                report.marks
            )?;
        }
        Payload::Balls(report) => {
            let last = usize::from(report.first) + report.balls.len();
            writeln!(
                out,
                "balls     row {}, {} to {last} of {}",
                report.row, report.first, report.count
            )?;
        }
        Payload::Rows(report) => {
            let rows = report.rows.iter().zip(usize::from(report.first)..);
            let rows: Vec<_> = rows
                .map(|(row, i)| {
                    format!(
                        "{i}: axial {:.1} radial {:.1} preload {:.1} Q {:.1} to {:.1} N",
                        row.axial,
                        row.radial[0].hypot(row.radial[1]),
                        row.preload,
                        row.least_force,
                        row.largest_force
                    )
                })
                .collect();
            writeln!(
                out,
                "rows      {} in all; {}",
                report.count,
                rows.join("; ")
            )?;
        }
        Payload::Shaft(report) => {
            let rows: Vec<_> = report
                .rows
                .iter()
                .zip(0..)
                .map(|(place, i): (_, usize)| {
                    let facing = facing(place).name();
                    format!(
                        "{i}: {facing} at {} m, {} balls",
                        place.position, place.balls
                    )
                })
                .collect();
            writeln!(
                out,
                "shaft     {} rows; {}; nose at {} m, loads about {} m, mounted preload {} N",
                report.count,
                rows.join("; "),
                report.nose,
                report.loads_at,
                report.preload
            )?;
        }
        Payload::Alarm(report) => writeln!(
            out,
            "alarm     {} {}, now {}: {:e} of {:e} {}",
            report.alarm,
            change_name(report.change),
            report.state.name(),
            report.value,
            report.limit,
            report.alarm.unit()
        )?,
        Payload::Health(report) => writeln!(
            out,
            "health    {} ticks, {} overruns, {} missed, {} estimates, {} doubted; baseline {}, life {}",
            report.ticks,
            report.overruns,
            report.missed_ticks,
            report.estimates,
            report.marked_samples,
            report.retention.baseline.name(),
            report.retention.life.name()
        )?,
        Payload::Inputs(report) => {
            write!(
                out,
                "inputs    {} records, {} corrupt, {} lost, {} out of order, {} late; of the life {:.3e} estimated",
                report.records.received,
                report.records.corrupt,
                report.records.lost,
                report.records.disordered,
                report.records.late,
                report.life_estimated
            )?;
            if report.temperature_sources != [TemperatureSource::Unused; 2] {
                let ([inner, outer], from) = (report.temperatures, report.temperature_sources);
                let [inner_from, outer_from] = from.map(TemperatureSource::name);
                write!(
                    out,
                    "; inner {inner:.1} C {inner_from}, outer {outer:.1} C {outer_from}"
                )?;
            }
            writeln!(out)?;
        }
        Payload::Answer(answer) => writeln!(out, "answer    {}", answer_words(answer))?,
        Payload::Board(report) => {
            let stack = report.unused_stack.map_or("not measured".into(), |bytes| {
                format!("{bytes} bytes never used")
            });
            let level = report
                .brown_out
                .map_or("unknown".into(), |level| level.to_string());
            writeln!(
                out,
                "board     known answer {}, image {}; stack {stack}; brown-out level {level}",
                report.known_answer.name(),
                report.image.name(),
            )?;
        }
        Payload::Start(report) => {
            write!(
                out,
                "start     {}, reset by {}; alarms before {}:",
                report.boots,
                report.cause.name(),
                report.recovery.name()
            )?;
            for alarm in report.latched() {
                write!(out, " {alarm}")?;
            }
            writeln!(out)?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use spindle_bearing::monitor::telemetry::{
        Frame, RowPlace, RowReport, RowsReport, ShaftReport, VERSION,
    };

    #[test]
    fn rows_and_shaft_have_a_line_each() {
        let row = RowReport {
            axial: 412.0,
            radial: [30.0, -40.0],
            preload: 244.0,
            least_force: 12.0,
            largest_force: 95.0,
        };
        let place = |position, mirrored| RowPlace {
            position,
            mirrored,
            balls: 16,
        };
        let payloads = [
            Payload::Rows(RowsReport {
                first: 1,
                count: 2,
                rows: [row].into_iter().collect(),
            }),
            Payload::Shaft(ShaftReport {
                nose: 0.09,
                loads_at: 0.12,
                preload: 250.0,
                count: 2,
                rows: [place(-0.02, false), place(0.02, true)]
                    .into_iter()
                    .collect(),
            }),
        ];
        let lines = payloads.map(|payload| {
            let frame = Frame {
                version: VERSION,
                sequence: 0,
                time_us: 0,
                payload,
            };
            let mut out = Vec::new();
            let gap = Gap::None;
            print(&mut out, &Event::Frame { frame, gap }).unwrap();
            String::from_utf8(out).unwrap()
        });
        let expected = [
            "rows      2 in all; 1: axial 412.0 radial 50.0 preload 244.0 Q 12.0 to 95.0 N\n",
            "shaft     2 rows; 0: +x at -0.02 m, 16 balls; 1: -x at 0.02 m, 16 balls; \
             nose at 0.09 m, loads about 0.12 m, mounted preload 250 N\n",
        ];
        for (line, expected) in lines.iter().zip(expected) {
            assert!(line.ends_with(expected), "{line}");
        }
    }

    #[test]
    fn what_a_source_cannot_do_is_refused() {
        let parse = |words: &[&str]| Arguments::try_parse_from([&["telemetry"], words].concat());
        for order in [
            &["--acknowledge"][..],
            &["--learn", "on"],
            &["--new-bearing"],
        ] {
            assert!(parse(&[&["--port", "COM3"], order].concat()).is_ok());
            for source in [&["--simulate"][..], &["--file", "stream"]] {
                let refused = parse(&[source, order].concat()).unwrap_err();
                assert!(
                    refused.to_string().contains("cannot be used with"),
                    "{refused}"
                );
            }
            assert!(parse(order).is_err());
        }
        assert!(parse(&["--simulate", "--seconds", "2"]).is_ok());
        assert!(parse(&["--file", "stream", "--seconds", "2"]).is_err());
    }
}

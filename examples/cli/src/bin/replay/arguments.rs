//! Arguments of `cargo replay`.

use crate::formats::FORMATS;
use anyhow::{Result, ensure};
use clap::{ArgMatches, Parser};
use cli::arguments::by_name;
use cli::options::{
    ATTITUDES, BOARDS, MOTIONS, Motion, Options, PAUSES, PRECISIONS, Pauses, window,
};
use cli::quantities::OWN;
use cli::sensitivity;
use solvers::dispatch::{Attitude, Precision};
use spindle_bearing::Limits;
use spindle_file::spindles::SpindleFile;
use spindle_monitor::tick::Core;
use std::path::{Path, PathBuf};

/// Replays recorded bearing loads through the solver
///
/// Takes the design of an angular contact ball bearing, or of a spindle with several of them, and a
/// recording of loads and shaft speed. For every row of the recording it computes where the shaft
/// goes and how stiff it is held there. The results go to standard output as CSV.
#[derive(Debug, Parser)]
#[command(name = "replay", bin_name = "cargo replay", max_term_width = 100, after_long_help = FORMATS)]
pub struct Args {
    /// Design of the bearing: ball count, diameters, grooves, contact angle, materials; or of a spindle: its rows
    ///
    /// Examples are in examples/spindle_file/bearings/ and examples/spindle_file/spindles/. A bearing of the catalogue is named in the place of
    /// a file, such as gmn:S6014C.
    #[arg(value_name = "DESIGN.toml", required_unless_present = "list")]
    pub design: Option<PathBuf>,

    /// Recorded loads and speed; `-` reads standard input
    ///
    /// An example, a synthetic milling cycle, is examples/cli/records/milling_cycle.csv.
    #[arg(value_name = "LOADS.csv", required_unless_present_any = ["table", "list", "sensitivity"])]
    pub loads: Option<PathBuf>,

    /// Print the catalogue: bearings that can be named in the place of DESIGN.toml
    #[arg(long)]
    pub list: bool,

    /// In place of LOADS.csv, make a table: stiffness at every combination of these speeds and loads
    ///
    /// Axes are speed in rpm, fx, fy, fz in N, and my, mz in N m. A spindle with `[heat]` has t_inner and
    /// t_outer, too, in deg C. Each is NAME=FIRST:LAST:STEP or NAME=VALUE, such as speed=0:20000:500 fx=500;
    /// one that is left out is 0, or `[heat]`'s reference. Speed changes from row to row. `time_s` counts
    /// the rows.
    #[arg(long, value_name = "AXIS=RANGE", num_args = 1.., conflicts_with = "loads")]
    pub table: Vec<String>,

    /// Columns of the results, in this order, such as time_s,kxx,kyy,dx
    #[arg(long, value_name = "COLUMN,..", value_delimiter = ',')]
    pub select: Vec<String>,

    /// In the place of the results: rating life of the whole recording, worst pressure, least preload, time beyond limits
    ///
    /// A record lasts until the next one; records of one time share the time to the next one. Without times, all records last equally
    /// long.
    #[arg(long, value_parser = by_name(FORMS), value_name = "FORM", num_args = 0..=1, require_equals = true, default_missing_value = "text")]
    pub summary: Option<Form>,

    /// In the place of the results: alarms that the monitor of the spindle's file would raise over the recording, and when
    ///
    /// The monitor is that of `--board`, with the monitor settings of the file. A recording of another rate is brought to its ticks:
    /// held where it is slower, the newest record of each tick where it is faster. Probes are read in the columns probe_NAME_um.
    #[arg(long, group = "with_probes", conflicts_with_all = LIMITS_ALONE)]
    pub limits: bool,

    /// In the place of the results: what 1 um of a row's closure, 1 N of the spring and 1 K on either side do
    ///
    /// Lines are changes of the preload of each row (N) and of the displacement at each nose and probe (um). Closing a row presses its
    /// balls harder; rows count from 0. Options such as --fy 100 --speed 12000 give load, speed and temperatures. Without them, the
    /// spindle idles, at rest and cold.
    #[arg(long, conflicts_with_all = LIMITS_ALONE, conflicts_with_all = ["loads", "limits", "response", "every", "board"])]
    pub sensitivity: bool,

    /// Board that the monitor runs on
    #[arg(long, value_parser = by_name(BOARDS), default_value = "f405", requires = "limits")]
    pub board: Core,

    /// Records before a pause of the logger, a step of time ten times as long as the usual one, in the summary
    #[arg(long, value_parser = by_name(PAUSES), default_value = "end", requires = "summary")]
    pub pauses: Pauses,

    /// Precision to compute in
    ///
    /// Loads and speed are rounded to it first. Results have as many digits as it takes to read
    /// back the same number of this precision.
    #[arg(long, value_parser = by_name(PRECISIONS), default_value = "f64")]
    pub precision: Precision,

    /// Rule for the axis about which a ball turns, and with it the gyroscopic moment
    #[arg(long, value_parser = by_name(ATTITUDES), default_value = "raceless")]
    pub attitude: Attitude,

    /// How the balls move
    #[arg(long, value_parser = by_name(MOTIONS), default_value = "full")]
    pub motion: Motion,

    /// Freedoms of the shaft: 5, or 3 with the tilts locked
    #[arg(long, value_name = "COUNT", default_value_t = 5, value_parser = clap::value_parser!(u8).range(3..=5))]
    pub freedoms: u8,

    /// Displacements of the shaft at x = 0 in the place of loads, such as tz=0,dx=10e-6; the reactions are more columns
    ///
    /// They are dx, dy, dz in m and ty, tz in rad.
    #[arg(long, value_name = "FREEDOM=VALUE,..", value_delimiter = ',')]
    pub given: Vec<String>,

    /// Largest change of the stiffness along the last step, relative to its diagonal: 1e-3 is that of a tick of firmware
    ///
    /// The default is 2e-5 in single and 3e-13 in double precision.
    #[arg(long, value_name = "PART")]
    pub tolerance: Option<f64>,

    /// Solve every row from scratch, as after a reset
    ///
    /// Without this, each row starts from the result of the row before, as the firmware does, and
    /// takes fewer iterations. Blocks of 500 rows begin from scratch: they are solved side by side,
    /// by a thread for every core, or RAYON_NUM_THREADS of them.
    #[arg(long)]
    pub cold: bool,

    /// Peak contact pressure, MPa, above which a row is marked in the column `limits`
    ///
    /// The default is from ISO 76's static load rating. A spindle in continuous service is better
    /// held to some 2000 MPa.
    #[arg(long, value_name = "MPA", default_value_t = 4200.0)]
    pub peak_pressure: f64,

    /// Friction force over contact force above which a row is marked in the column `limits`
    #[arg(long, value_name = "T/Q", default_value_t = Limits::<f64>::LUBRICATED_FRICTION)]
    pub friction: f64,

    /// Write the contact angles, forces, pressures, inertia loads and speeds of every ball to this CSV file
    #[arg(long, value_name = "BALLS.csv")]
    pub balls: Option<PathBuf>,

    /// Write each row of a spindle to this CSV file: load, preload, least contact force, stiffness, motion, closure, life
    #[arg(long, value_name = "ROWS.csv")]
    pub rows: Option<PathBuf>,

    /// Write the displacement and flexibility of every nose of a spindle to this CSV file
    #[arg(long, value_name = "NOSES.csv")]
    pub nose: Option<PathBuf>,

    /// Write the frequencies at which damaged parts of every row of balls are heard to this CSV file
    #[arg(long, value_name = "FREQUENCIES.csv")]
    pub frequencies: Option<PathBuf>,

    /// Solve one record of so many
    #[arg(long, value_name = "COUNT", default_value_t = 1, conflicts_with = "table", value_parser = clap::value_parser!(u32).range(1..))]
    pub every: u32,

    #[command(flatten)]
    pub response: Probes,

    #[command(flatten)]
    pub state: State,
}

/// Options without a meaning beside `--limits`, which is as the board solves, and beside `--sensitivity`.
const LIMITS_ALONE: [&str; 17] = [
    "table",
    "select",
    "summary",
    "precision",
    "attitude",
    "motion",
    "freedoms",
    "given",
    "tolerance",
    "cold",
    "peak_pressure",
    "friction",
    "pauses",
    "balls",
    "rows",
    "nose",
    "frequencies",
];

/// Measured and computed displacement
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Probes")]
pub struct Probes {
    /// In the place of the results: write the preload that the board's monitor measures with the probes to this CSV file
    ///
    /// The recording has a column probe_NAME_um for each probe of the spindle. A line for each second:
    /// time_s,state,preload_n,preload_error_n,change_percent,change_error_percent,steps, then for each probe
    /// gain_NAME,gain_error_NAME,state_NAME. Errors are standard errors. The change is since commissioning.
    #[arg(long, value_name = "FILE.csv", group = "with_probes", conflicts_with_all = ["table", "summary", "balls", "rows", "nose", "frequencies",
        "given", "select"])]
    pub response: Option<PathBuf>,

    /// With --response or --limits: learn from this time on, and do not end commissioning before that one, s
    ///
    /// Without it, learning begins with the recording, and ends as soon as enough is known.
    #[arg(long, value_name = "FROM:TO", requires = "with_probes", value_parser = window, allow_hyphen_values = true)]
    pub commission: Option<[f64; 2]>,
}

/// State of `--sensitivity`, in the order of [`OWN`]. There is an option for each load, the speed and the temperatures.
#[derive(Debug)]
pub struct State(pub sensitivity::State);

impl clap::FromArgMatches for State {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let mut state = [None; OWN.len()];
        for (value, own) in state.iter_mut().zip(OWN).skip(1) {
            *value = matches.get_one(own.name).copied();
        }
        Ok(Self(state))
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

impl clap::Args for State {
    fn augment_args(command: clap::Command) -> clap::Command {
        command.args(OWN.iter().skip(1).map(|own| {
            let arg = clap::Arg::new(own.name).long(own.name).value_name(own.unit);
            arg.value_parser(clap::value_parser!(f64))
                .allow_negative_numbers(true)
                .requires("sensitivity")
                .conflicts_with_all(["loads", "table"])
                .help_heading("State of --sensitivity")
                .help(format!("{} in {}", own.name, own.unit))
        }))
    }

    fn augment_args_for_update(command: clap::Command) -> clap::Command {
        Self::augment_args(command)
    }
}

/// How the summary is written.
const FORMS: [(&str, &str, Form); 2] = [
    ("text", "To read", Form::Text),
    ("json", "As JSON, SI units", Form::Json),
];

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Form {
    Text,
    Json,
}

impl Args {
    /// clap demands one, except with `--list`.
    pub fn design(&self) -> &Path {
        self.design.as_deref().unwrap_or(Path::new(""))
    }

    /// How the recording is solved.
    pub fn options(&self) -> Options {
        Options {
            precision: self.precision,
            attitude: self.attitude,
            motion: self.motion,
            freedoms: self.freedoms,
            given: self.given.clone(),
            tolerance: self.tolerance,
            cold: self.cold,
            peak_pressure: self.peak_pressure,
            friction: self.friction,
            pauses: self.pauses,
        }
    }

    /// Looks whether the file has what the outputs are of.
    pub fn check_outputs(&self, file: &SpindleFile) -> Result<()> {
        ensure!(
            self.rows.is_none() || !file.is_bearing,
            "--rows is for spindles, and {} is one bearing: it has no [[row]]",
            self.design().display()
        );
        ensure!(
            self.nose.is_none() || !file.noses.is_empty(),
            "--nose: {} has no [nose]; add one with position_mm",
            self.design().display()
        );
        Ok(())
    }
}

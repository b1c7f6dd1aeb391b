//! `cargo replay`: recorded loads and speed in, displacements and stiffness out.

mod limits;
mod response;
mod table;

use anyhow::{Context, Result, anyhow, bail, ensure};
use clap::{ArgMatches, Parser};
use cli::arguments::by_name;
use cli::fault::LoadsError;
use cli::import::{Import, Wanted};
use cli::lifetime::Lifetime;
use cli::output::{NewFile, place};
use cli::propose;
use cli::quantities::{LOADS, OWN, Quantity};
use cli::recordings;
use cli::replay::{Job, Output, ReplayError, Summary, Table, replay};
use cli::units::Unit;
use indicatif::{ProgressBar, ProgressFinish, ProgressIterator, ProgressStyle};
use spindle_bearing::Limits;
use spindle_file::catalogue;
use spindle_file::dispatch::{Attitude, Precision};
use spindle_file::loads::LoadRow;
use spindle_file::loads::celsius;
use spindle_file::solvers::{Balls, Choices, with_solver};
use spindle_file::spindles::SpindleFile;
use spindle_monitor::tick::Core;
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::{Arc, Mutex};
use table::Axes;

/// Replays recorded bearing loads through the solver
///
/// Takes the design of an angular contact ball bearing, or of a spindle with several of them, and a
/// recording of loads and shaft speed. For every row of the recording it computes where the shaft
/// goes and how stiff it is held there. The results go to standard output as CSV.
#[derive(Debug, Parser)]
#[command(name = "replay", bin_name = "cargo replay", max_term_width = 100, after_long_help = FORMATS)]
struct Args {
    /// Design of the bearing: ball count, diameters, grooves, contact angle, materials; or of a spindle: its rows
    ///
    /// Examples are in examples/spindle_file/bearings/ and examples/spindle_file/spindles/. A bearing of the catalogue is named in the place of
    /// a file, such as gmn:S6014C.
    #[arg(value_name = "DESIGN.toml", required_unless_present_any = ["list", "propose"])]
    design: Option<PathBuf>,

    /// Recorded loads and speed; `-` reads standard input
    ///
    /// An example, a synthetic milling cycle, is examples/cli/records/milling_cycle.csv.
    #[arg(value_name = "LOADS.csv", required_unless_present_any = ["table", "list", "propose"])]
    loads: Option<PathBuf>,

    /// Print the catalogue: bearings that can be named in the place of DESIGN.toml
    #[arg(long)]
    list: bool,

    /// Look at a recording of another program, and write a description of its columns
    ///
    /// The description goes to standard output; standard error has the first and the last rows as they would be read, and
    /// all that is open. `-` reads standard input.
    #[arg(long, value_name = "RECORDING", conflicts_with_all = ["design", "list", "table", "import"])]
    propose: Option<PathBuf>,

    /// In place of LOADS.csv, make a table: stiffness at every combination of these speeds and loads
    ///
    /// Axes are speed in rpm, fx, fy, fz in N, and my, mz in N m. A spindle with `[heat]` has t_inner and
    /// t_outer, too, in deg C. Each is NAME=FIRST:LAST:STEP or NAME=VALUE, such as speed=0:20000:500 fx=500;
    /// one that is left out is 0, or `[heat]`'s reference. Speed changes from row to row. `time_s` counts
    /// the rows.
    #[arg(long, value_name = "AXIS=RANGE", num_args = 1.., conflicts_with = "loads")]
    table: Vec<String>,

    /// Columns of the results, in this order, such as time_s,kxx,kyy,dx
    #[arg(long, value_name = "COLUMN,..", value_delimiter = ',')]
    select: Vec<String>,

    /// In the place of the results: rating life of the whole recording, worst pressure, least preload, time beyond limits
    ///
    /// A record lasts until the next one; records of one time share the time to the next one. Without times, all records last equally
    /// long.
    #[arg(long, value_parser = by_name(FORMS), value_name = "FORM", num_args = 0..=1, require_equals = true, default_missing_value = "text")]
    summary: Option<Form>,

    /// In the place of the results: alarms that the monitor of the spindle's file would raise over the recording, and when
    ///
    /// The monitor is that of `--board`, with the monitor settings of the file. A recording of another rate is brought to its ticks:
    /// held where it is slower, the newest record of each tick where it is faster. Probes are read in the columns probe_NAME_um.
    #[arg(long, group = "with_probes", conflicts_with_all = LIMITS_ALONE)]
    limits: bool,

    /// Board that the monitor runs on
    #[arg(long, value_parser = by_name(limits::BOARDS), default_value = "f405", requires = "limits")]
    board: Core,

    /// Records before a pause of the logger, a step of time ten times as long as the usual one, in the summary
    #[arg(long, value_parser = by_name(PAUSES), default_value = "end", requires = "summary")]
    pauses: Pauses,

    /// Precision to compute in
    ///
    /// Loads and speed are rounded to it first. Results have as many digits as it takes to read
    /// back the same number of this precision.
    #[arg(long, value_parser = by_name(PRECISIONS), default_value = "f64")]
    precision: Precision,

    /// Rule for the axis about which a ball turns, and with it the gyroscopic moment
    #[arg(long, value_parser = by_name(ATTITUDES), default_value = "raceless")]
    attitude: Attitude,

    /// How the balls move
    #[arg(long, value_parser = by_name(MOTIONS), default_value = "full")]
    motion: Motion,

    /// Freedoms of the shaft: 5, or 3 with the tilts locked
    #[arg(long, value_name = "COUNT", default_value_t = 5, value_parser = clap::value_parser!(u8).range(3..=5))]
    freedoms: u8,

    /// Displacements of the shaft at x = 0 in the place of loads, such as tz=0,dx=10e-6; the reactions are more columns
    ///
    /// They are dx, dy, dz in m and ty, tz in rad.
    #[arg(long, value_name = "FREEDOM=VALUE,..", value_delimiter = ',')]
    given: Vec<String>,

    /// Largest change of the stiffness along the last step, relative to its diagonal: 1e-3 is that of a tick of firmware
    ///
    /// The default is 2e-5 in single and 3e-13 in double precision.
    #[arg(long, value_name = "PART")]
    tolerance: Option<f64>,

    /// Solve every row from scratch, as after a reset
    ///
    /// Without this, each row starts from the result of the row before, as the firmware does, and
    /// takes fewer iterations. Blocks of 500 rows begin from scratch: they are solved side by side,
    /// by a thread for every core, or RAYON_NUM_THREADS of them.
    #[arg(long)]
    cold: bool,

    /// Peak contact pressure, MPa, above which a row is marked in the column `limits`
    ///
    /// The default is from ISO 76's static load rating. A spindle in continuous service is better
    /// held to some 2000 MPa.
    #[arg(long, value_name = "MPA", default_value_t = 4200.0)]
    peak_pressure: f64,

    /// Friction force over contact force above which a row is marked in the column `limits`
    #[arg(long, value_name = "T/Q", default_value_t = Limits::<f64>::LUBRICATED_FRICTION)]
    friction: f64,

    /// Write the contact angles, forces, pressures, inertia loads and speeds of every ball to this CSV file
    #[arg(long, value_name = "BALLS.csv")]
    balls: Option<PathBuf>,

    /// Write the load, preload, least contact force, stiffness, motion and closure of every row of a spindle to this CSV file
    #[arg(long, value_name = "ROWS.csv")]
    rows: Option<PathBuf>,

    /// Write the displacement and flexibility of every nose of a spindle to this CSV file
    #[arg(long, value_name = "NOSES.csv")]
    nose: Option<PathBuf>,

    /// Write the frequencies at which damaged parts of every row of balls are heard to this CSV file
    #[arg(long, value_name = "FREQUENCIES.csv")]
    frequencies: Option<PathBuf>,

    #[command(flatten)]
    response: response::Options,

    #[command(flatten)]
    recording: Recording,
}

/// Options without a meaning beside `--limits`, which is as the board solves.
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

/// How the recording is read
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Recording")]
struct Recording {
    /// Description of the recording's columns, as `--propose` writes it
    #[arg(long, value_name = "IMPORT.toml", conflicts_with = "table")]
    import: Option<PathBuf>,

    /// Solve one record of so many
    #[arg(long, value_name = "COUNT", default_value_t = 1, conflicts_with = "table", value_parser = clap::value_parser!(u32).range(1..))]
    every: u32,

    #[command(flatten)]
    given: Given,
}

/// Quantities that are constant, in the bearing's frame: an option for each.
#[derive(Debug)]
struct Given([Option<f64>; OWN.len()]);

impl Given {
    /// The quantities that have an option of their name.
    fn all() -> impl Iterator<Item = (usize, Quantity)> {
        OWN.into_iter().enumerate().skip(1)
    }
}

impl clap::FromArgMatches for Given {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let mut given = [None; OWN.len()];
        for (i, quantity) in Self::all() {
            given[i] = matches.get_one(quantity.name()).copied();
        }
        Ok(Self(given))
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

impl clap::Args for Given {
    fn augment_args(command: clap::Command) -> clap::Command {
        command.args(Self::all().map(|(_, quantity)| {
            let (name, unit) = (quantity.name(), Unit::of(quantity.dimension()).name());
            let arg = clap::Arg::new(name)
                .long(name)
                .value_name(unit)
                .conflicts_with("table");
            let arg = arg
                .value_parser(clap::value_parser!(f64))
                .allow_negative_numbers(true);
            arg.help(format!("{name} in {unit}, where it is constant"))
        }))
    }

    fn augment_args_for_update(command: clap::Command) -> clap::Command {
        Self::augment_args(command)
    }
}

const PRECISIONS: [(&str, &str, Precision); 2] = [
    (
        "f32",
        "Single precision, as the firmware computes",
        Precision::F32,
    ),
    ("f64", "Double precision", Precision::F64),
];

const ATTITUDES: [(&str, &str, Attitude); 3] = [
    (
        "raceless",
        "Raceway-control-free: from d'Alembert's principle, which does not assume race control",
        Attitude::Raceless,
    ),
    (
        "outer",
        "Outer race control: no spin at the outer race",
        Attitude::Outer,
    ),
    (
        "inner",
        "Inner race control: no spin at the inner race; not for loads that lift balls off it",
        Attitude::Inner,
    ),
];

/// How the balls move, but for the rule of their attitude.
const MOTIONS: [(&str, &str, Motion); 3] = [
    (
        "static",
        "At rest: the speed counts for life and frequencies alone",
        Motion::Static,
    ),
    (
        "centrifugal",
        "Under centrifugal force alone",
        Motion::Centrifugal,
    ),
    ("full", "With all inertia loads", Motion::Full),
];

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Motion {
    Static,
    Centrifugal,
    Full,
}

/// How long a record counts before a pause.
const PAUSES: [(&str, &str, Pauses); 2] = [
    ("end", "Count for one usual step", Pauses::End),
    (
        "hold",
        "Count until the next record: a list of held states",
        Pauses::Hold,
    ),
];

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Pauses {
    End,
    Hold,
}

/// How the summary is written.
const FORMS: [(&str, &str, Form); 2] = [
    ("text", "To read", Form::Text),
    ("json", "As JSON, SI units", Form::Json),
];

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Form {
    Text,
    Json,
}

const FORMATS: &str = "\
Frame: the outer rings stand still, the shaft turns about +x. Loads act on the inner ring of a
bearing, moments about its centre; on the shaft of a spindle at x = 0. Azimuths count from +y
towards +z.

DESIGN.toml is a spindle if it has [[row]]s:
  name = \"7014C back to back\"
  preload_n = 294               # as ground: of a pair of such bearings on rigid seats
                                # or mounted_preload_n, between the rows as they are built in: on their
                                # supports and shaft, at rest, cold, without loads
                                # or for each row preload_offset_um, its closure, which adds up with that
                                # of the row it faces (a spacer 10 um short: 10 in one of them, or 5 in
                                # both); or spring = true
  [[row]]
  bearing = \"7014c.toml\"       # beside this file; a name of the catalogue; or its keys under
                                # [row.design]
                                # ball = { youngs_modulus_gpa = 310, .. } for balls of another material
  position_mm = 0
  facing = \"+x\"               # a load on the shaft in +x presses its balls
  radial_growth_um = 2          # and axial_, ball_growth_um; may be left out
  [[row]]                       # back to back: +x at the smaller x, -x at the larger
  bearing = \"7014c.toml\"
  position_mm = 27
  facing = \"-x\"
  [spring]                      # of the rows with spring = true: force_n = 300
  [shaft]                       # rings grow with the speed on a shaft with bore_mm = 40
  sections = [                  # or a shaft that bends, rigid outside of them and in gaps
    { from_mm = -30, to_mm = 90, outer_mm = 70, inner_mm = 30 },
  ]
  grow_with_speed = true        # rings grow on the bores of the sections; youngs_modulus_gpa = 206
  [heat]                        # growth with temperatures: reference_c = 20; shaft_per_k, housing_per_k,
                                # ring_per_k, ball_per_k of bearing steel (11.5e-6) if left out
  [nose]                        # stiffness there, too: position_mm = -60, radial_um_per_kn,
                                # axial_um_per_kn, both of a shaft without sections
  [nose.tool]                   # more of them, by name: position_mm = -120
  [[probe]]                     # sees the shaft against the housing, for --response: name = \"nose\",
                                # position_mm = -10, angle_deg = 90 from +y towards +z, or
                                # direction = \"x\"; accuracy_um = 0.5
A [[row]] may stand on an elastic support; what is left out is rigid:
  support = { axial_n_per_um = 500, radial_n_per_um = 400, tilting_nm_per_rad = 1e6 }

DESIGN.toml of either kind may say where recorded loads act, and what acts besides:
  [load]                        # on an elastic shaft, all loads act where they stand
  position_mm = -60
  [[constant_load]]             # belt, gear, weight: fx_n, fy_n, fz_n at
  position_mm = 120

LOADS.csv has the columns
  time_s,fx_n,fy_n,fz_n,my_nm,mz_nm,speed_rpm
in any order, names on the first line, fields separated by commas, decimals by points; for a spindle with [heat]
t_inner_c,t_outer_c as well; for --response probe_NAME_um of each [[probe]]. Other columns are ignored, and named once on standard error. Without time_s, rows are
counted. A constant such as --my 0 takes the place of a column.

A recording of any other program needs a description of its columns:
  cargo replay --propose slot.txt > slot.toml
  cargo replay DESIGN.toml slot.txt --import slot.toml
The description has a \"?\" for all that the file leaves open: write there what the recording has. docs/host.md has all keys. A
row that cannot be read to the letter is refused, and so are rows below the header of another file. A line on standard
error counts rows that were read or refused, and lines that were skipped, with the range of each quantity.

A table, in place of LOADS.csv:
  cargo replay DESIGN.toml --table speed=0:20000:500 fx=500 fy=0:1000:250 >TABLE.csv
  cargo plot TABLE.csv --over speed
It has the columns of the results. host_tests/judge/recipes/ross_bearing.py makes a bearing of ROSS of it.

Results, one row for each row of LOADS.csv, SI units:
  time_s          copied
  status          converged; precision-limit (as close as the precision allows);
                  anything else means that this row has no answer, and its figures are empty:
                  unseated (the speed drives a ball out of its groove), iteration-limit (ran out
                  of iterations), refused-input (a field of LOADS.csv is empty or no number, the line has
                  too few or too many fields, or stands in another file) and so on
  iterations      passes over all balls that the solve took
  dx_m .. tz_rad  displacement of the inner ring, or of the shaft at x = 0
  k_x_x .. k_tz_tz  stiffness, 25 columns: k_y_tz is the change of Fy with the tilt tz
  k_nose_x_x k_nose_y_y k_nose_z_z k_nose_ty_ty k_nose_tz_tz
                  of a spindle with [nose], the stiffness that a force or moment alone meets
                  there: 1 over the compliance, as a dial gauge finds it
  limits          physical limits that are passed, a blank between two of them; empty if none is:
                  peak-pressure (of a contact); shoulder (a contact's centre is past it); truncation
                  (of a contact ellipse by the shoulder); reversal (of a contact angle); friction
                  (more is called for, gross slip suspected); inner-contact (lost by a ball);
                  lift-off (no preload is left)
  fx_n .. speed_rpm  loads and speed, copied
  t_inner_c, t_outer_c  at the end, of a spindle with [heat]; reaction_fx_n .. with --given
  l10_mrev, l10_h    basic rating life by ISO/TS 16281 under this load, million revolutions and hours;
                  with dynamic_load_rating_n of DESIGN.toml, else with ISO 281's C, 5 % to 8 % high

BALLS.csv, one row for each ball of each row, balls numbered from 0 at the first azimuth:
  time_s,ball,azimuth_rad,alpha_i_rad,alpha_o_rad,q_i_n,q_o_n,fc_n,mg_nm,
  p_i_pa,p_o_pa,a_i_m,b_i_m,a_o_m,b_o_m,cage_rad_s,attitude_rad,spin_roll_i,spin_roll_o
  contact angles and contact forces at the inner and outer race, centrifugal force, gyroscopic
  moment; peak pressures, semi-axes of the contact ellipses across (a) and along (b) the rolling
  direction; speed about the bearing's axis, angle of the axis of its own rotation to that axis,
  angular speed of spin over that of rolling. A ball off the inner race has 0 for that contact;
  rows without an answer have empty figures here, too. Of a spindle, `row` comes before `ball`.

FREQUENCIES.csv, one row for each row of balls; of a spindle, `row` comes after `time_s`:
  time_s,cage_hz,outer_race_hz,inner_race_hz,ball_hz
  turns of the cage (FTF); balls past a point of the outer and of the inner race (BPFO, BPFI); turns
  of a ball seen from the cage (BSF: a damaged ball meets both races in each)

ROWS.csv, one row for each row of balls, numbered from 0 as in DESIGN.toml, in the row's own frame,
whose x points where an axial load presses its balls:
  time_s,row,fx_n,fy_n,fz_n,my_nm,mz_nm,preload_n,least_q_i_n
  load on its inner ring about its centre; what of the axial one is preload; least force of a ball
then in the shaft's frame, SI units:
  k_row_x_x .. k_row_tz_tz  stiffness between shaft and housing: of the row, its support in series
  dx_m .. tz_rad  displacement of the shaft at the row
and closure_um, by which the row's rings are ground or set off against each other; 0 under a spring

NOSES.csv, one row for each nose, the plain one being called nose:
  time_s,nose,dx_m,dy_m,dz_m,ty_rad,tz_rad,c_x_x .. c_tz_tz,c_error_x .. c_error_tz
  displacement of the shaft there; flexibility: c_y_tz is the change of dy with the moment Mz;
  estimated relative errors of c_x_x, c_y_y, c_z_z, c_ty_ty, c_tz_tz

--limits, one row for each change of an alarm:
  time_s,alarm,event,value,limit,unit
  raised; worse, raised again since its level has grown; or cleared. Its level then, and the limit, or
  the level that ends it, in the unit of [monitor.alarm]. Each alarm is acknowledged at once
and one for each change of a probe in the board's report of every second, `probe NAME` being the alarm:
  its state is the event, measured over computed displacement, over that at --commission, the value

Files are written beside their places, as X.*.part, and moved there when they are complete: not where
the exit status is 1 or 2. A signal (Ctrl-C) removes them, and a later run what a killed one has left.

Exit status: 0, also if rows have no answer (a line on standard error counts them);
2 if the arguments, the design or the recording are at fault, or no row of it can be read;
1 if the results cannot be written.";

fn main() -> ExitCode {
    let args = Args::parse();
    if args.list {
        // Nobody reads a message about standard output that is closed.
        let _ = io::stdout().write_all(catalogue::list().as_bytes());
        return ExitCode::SUCCESS;
    }
    if let Some(path) = &args.propose {
        return match propose::propose(path) {
            Ok(proposal) => {
                eprint!("{}", proposal.report);
                let _ = io::stdout().write_all(proposal.description.as_bytes());
                ExitCode::SUCCESS
            }
            Err(error) => {
                eprintln!("replay: {error}");
                ExitCode::from(2)
            }
        };
    }
    let done = match args.limits {
        true => limits::run(&args),
        false => run(&args),
    };
    match done {
        Ok(summary) => {
            if !summary.refused.is_empty() {
                eprintln!("replay: {summary}");
            }
            if summary.any_row_read() {
                ExitCode::SUCCESS
            } else {
                ExitCode::from(2)
            }
        }
        Err(error) => {
            let status = match error.downcast_ref() {
                // A reader that has seen enough (`| head`) is no failure.
                Some(ReplayError::Output(_, reason)) if reason.kind() == ErrorKind::BrokenPipe => {
                    return ExitCode::SUCCESS;
                }
                Some(ReplayError::Output(..)) => 1,
                _ => 2,
            };
            eprintln!("replay: {error}");
            ExitCode::from(status)
        }
    }
}

fn run(args: &Args) -> Result<Summary> {
    let file = args.file()?;
    ensure!(
        args.rows.is_none() || !file.is_bearing,
        "--rows is for spindles, and {} is one bearing: it has no [[row]]",
        args.design().display()
    );
    ensure!(
        args.nose.is_none() || !file.noses.is_empty(),
        "--nose: {} has no [nose]; add one with position_mm",
        args.design().display()
    );
    let balls = match args.motion {
        Motion::Full => args.attitude.into(),
        _ if args.attitude != Attitude::Raceless => bail!(
            "--attitude makes no difference without gyroscopic moments; leave out it or --motion"
        ),
        Motion::Static => Balls::Static,
        Motion::Centrifugal => Balls::Centrifugal,
    };
    let precision = args.precision;
    if let Some(tolerance) = args.tolerance {
        ensure!(
            tolerance > 0.0 && tolerance < 1.0,
            "--tolerance {tolerance}: it is 0 to 1"
        );
    }
    let held = args.held()?;
    ensure!(
        held == [None; 5] || file.plan.loaded_at() == 0.0,
        "--given and --freedoms 3 hold an elastic shaft at x = 0 where its loads act there; set [load] position_mm = 0, or \
         leave the option out"
    );
    let mut lifetime = args.summary.map(|_| Lifetime::default());
    let solved = with_solver(&file.plan, balls, precision, |solver| {
        if let Some(path) = &args.response.response {
            return response::replay(args, &file, solver, path);
        }
        let (rows, recording) = args.input(&file)?;
        let mut files = args.files(&file)?;
        let mut outputs: Vec<Output<'_>> = Vec::new();
        if args.summary.is_none() {
            outputs.push((Table::Results, Box::new(io::stdout())));
        }
        outputs.extend(files.iter_mut().map(|(table, file)| {
            let out: Box<dyn Write + Send> = Box::new(file);
            (*table, out)
        }));
        let job = Job {
            file: &file,
            precision,
            cold: args.cold,
            at_rest: args.motion == Motion::Static,
            select: args.select.clone(),
            choices: Choices {
                limits: Limits {
                    peak_pressure: args.peak_pressure * 1e6,
                    friction: args.friction,
                },
                tolerance: args.tolerance,
                ..Choices::default()
            },
            held,
            holds_pauses: args.pauses == Pauses::Hold,
            lifetime: lifetime.as_mut(),
        };
        let replayed = replay(job, solver, rows, outputs);
        // Nobody reads on where an output has failed.
        let is_out = matches!(replayed, Err(ReplayError::Output(..)));
        if let Some(recording) = recording.filter(|_| !is_out) {
            let recording = recording.lock().expect("a reader");
            for line in recording.account().lines() {
                eprintln!("replay: {line}");
            }
            let counts = recording.counts();
            ensure!(
                replayed.is_err() || counts.read + counts.refused > 0,
                "{}: there is no row below the header",
                recording.file()
            );
        }
        let summary = replayed?;
        let complete = files.into_iter().filter(|_| summary.any_row_read());
        for (table, file) in complete {
            file.finish()
                .map_err(|error| ReplayError::Output(table, error))?;
        }
        anyhow::Ok(summary)
    });
    let summary = solved.map_err(|error| file.explain(&error))??;
    if let (Some(mut lifetime), Some(form)) = (lifetime, args.summary) {
        lifetime.finish();
        if let Some(pauses) = lifetime.pauses() {
            eprintln!("replay: {pauses}");
        }
        let text = match form {
            Form::Text => lifetime.to_string(),
            Form::Json => serde_json::to_string_pretty(&lifetime)? + "\n",
        };
        let written = io::stdout().write_all(text.as_bytes());
        written.map_err(|error| ReplayError::Output(Table::Results, error))?;
    }
    Ok(summary)
}

/// Rows to solve, and the recording that they come from.
type Input = (
    Box<dyn Iterator<Item = Result<LoadRow, LoadsError>> + Send>,
    Option<Arc<Mutex<recordings::Loads>>>,
);

impl Args {
    /// clap demands one, except with `--list`.
    fn design(&self) -> &Path {
        self.design.as_deref().unwrap_or(Path::new(""))
    }

    /// The spindle.
    fn file(&self) -> Result<SpindleFile> {
        let file = SpindleFile::read(self.design())?;
        for doubt in &file.doubts {
            eprintln!("replay: {doubt}");
        }
        Ok(file)
    }

    /// Displacements that are given.
    fn held(&self) -> Result<[Option<f64>; 5]> {
        ensure!(self.freedoms != 4, "--freedoms 4: they are 3 or 5");
        let mut held = [None; 5];
        if self.freedoms == 3 {
            (held[3], held[4]) = (Some(0.0), Some(0.0));
        }
        for text in &self.given {
            let pair = text.split_once('=').and_then(|(name, value)| {
                let names = ["dx", "dy", "dz", "ty", "tz"];
                let freedom = names.iter().position(|one| *one == name.trim())?;
                Some((freedom, value.trim().parse().ok()?))
            });
            let (freedom, value) = pair.with_context(|| {
                format!(
                    "--given {text}: give dx, dy, dz (m), ty or tz (rad) a number, such as tz=0"
                )
            })?;
            ensure!(
                held[freedom].replace(value).is_none(),
                "--given {text}: it is held already, by --given or --freedoms 3"
            );
        }
        Ok(held)
    }

    /// Quantities that the options leave to the recording, with temperatures if the spindle has `heat`.
    fn wanted(&self, heat: bool) -> Result<Wanted> {
        let mut wanted = Wanted {
            given: self.recording.given.0,
            every: self.recording.every as usize,
            shares_times: self.summary.is_some() || self.limits || self.response.response.is_some(),
            ..Wanted::default()
        };
        for (i, quantity) in OWN.into_iter().enumerate().skip(LOADS) {
            wanted.needed[i] = heat;
            if let Some(value) = wanted.given[i] {
                ensure!(heat, "--{} is for spindles with [heat]", quantity.name());
                celsius(value).map_err(|error| anyhow!("--{}: {error}", quantity.name()))?;
            }
        }
        // A displacement that is given takes the place of the load of its freedom.
        for (needed, held) in wanted.needed[1..].iter_mut().zip(self.held()?) {
            *needed &= held.is_none();
        }
        Ok(wanted)
    }

    /// Rows of the recording or of the table.
    fn input(&self, file: &SpindleFile) -> Result<Input> {
        let reference = file.heat.map(|heat| heat.reference);
        let Some(path) = &self.loads else {
            let axes = Axes::parse(&self.table)?;
            if axes.has_temperatures() && reference.is_none() {
                bail!("--table: t_inner and t_outer are for spindles with [heat]; leave them out");
            }
            let rows = axes.rows(reference);
            let bar = progress_bar(Some(rows.len() as u64), "{pos} of {len} rows");
            return Ok((Box::new(rows.progress_with(bar).map(Ok)), None));
        };
        let (import, mut wanted) = (self.recording.import()?, self.wanted(reference.is_some())?);
        if self.limits {
            wanted.probes = file.probes.iter().map(|probe| probe.name.clone()).collect();
        }
        let loads = recordings::read(path, import.as_ref(), &wanted)?;
        for (probe, has) in file.probes.iter().zip(loads.has_probes()) {
            if !has {
                let (file, name) = (loads.file(), &probe.name);
                eprintln!("replay: {file}: there is no column probe_{name}_um");
            }
        }
        let file = loads.file();
        let ignored = loads.ignored_columns();
        if let Some(ignored) = ignored {
            eprintln!("replay: {file}: columns ignored: {ignored}");
        }
        if reference.is_none() && import.is_none() && loads.has_temperatures() {
            bail!(
                "{file}: t_inner_c and t_outer_c are for spindles with [heat]: add that to the spindle with \
                 reference_c, or remove these columns"
            );
        }
        let bar = progress_bar(loads.total_bytes(), "{bytes} of {total_bytes}");
        let loads = Arc::new(Mutex::new(loads));
        let read = Arc::clone(&loads);
        let rows = std::iter::from_fn(move || {
            let mut loads = read.lock().expect("a reader");
            let row = loads.next();
            bar.set_position(loads.bytes_read());
            row
        });
        Ok((Box::new(rows), Some(loads)))
    }

    /// The files that options name.
    fn files(&self, file: &SpindleFile) -> Result<Vec<(Table, NewFile)>> {
        let mut taken: Vec<PathBuf> = (self.loads.iter().map(PathBuf::as_path))
            .chain([self.design()])
            .chain(self.recording.import.as_deref())
            .chain(file.files())
            .filter_map(|input| place(input).ok())
            .collect();
        let inputs = taken.len();
        let mut wanted = Vec::new();
        for (table, option, path) in [
            (Table::Balls, "--balls", &self.balls),
            (Table::Rows, "--rows", &self.rows),
            (Table::Noses, "--nose", &self.nose),
            (Table::Frequencies, "--frequencies", &self.frequencies),
        ] {
            let Some(path) = path else { continue };
            let name = path.display();
            if path.as_os_str() == "-" {
                bail!("{option} needs a file; standard output carries the results");
            }
            let place = place(path).map_err(|error| unwritable(path, &error))?;
            match taken.iter().position(|taken| *taken == place) {
                Some(input) if input < inputs => {
                    bail!("{option} would overwrite its own input {name}; name another file")
                }
                Some(_) => bail!("{option}: {name} is another output, too; name another file"),
                None => taken.push(place),
            }
            wanted.push((table, path));
        }
        let files = wanted.into_iter().map(|(table, path)| {
            let file = NewFile::create(path).map_err(|error| unwritable(path, &error))?;
            Ok((table, file))
        });
        files.collect()
    }
}

impl Recording {
    fn import(&self) -> Result<Option<Import>> {
        let read = self.import.as_deref().map(Import::read);
        Ok(read.transpose()?)
    }
}

fn unwritable(path: &Path, error: &io::Error) -> anyhow::Error {
    anyhow!("{}: cannot be written: {error}", path.display())
}

/// A bar on the terminal over the bytes of the recording or the rows of a table, with `position` beside
/// it. A count if their number is unknown.
fn progress_bar(total: Option<u64>, position: &str) -> ProgressBar {
    let (bar, template) = match total {
        Some(total) => (
            ProgressBar::new(total),
            format!("replaying {{bar:40}} {position}, {{eta}} left"),
        ),
        None => (
            ProgressBar::new_spinner(),
            "replaying {spinner} {bytes}, {elapsed}".to_owned(),
        ),
    };
    bar.with_style(ProgressStyle::with_template(&template).expect("a template"))
        .with_finish(ProgressFinish::AndClear)
}

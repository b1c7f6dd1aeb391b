//! `cargo replay`: recorded loads and speed in, displacements and stiffness out.

mod table;

use anyhow::{Result, bail};
use clap::{Parser, ValueEnum};
use files::catalogue;
use files::recordings::{self, LoadRow, LoadsError};
use files::spindles::SpindleFile;
use host_tests::dispatch::{Attitude, Precision};
use host_tests::replay::{Outputs, ReplayError, Summary, Table, replay};
use host_tests::spindles::{Balls, with_solver};
use indicatif::{ProgressBar, ProgressFinish, ProgressIterator, ProgressStyle};
use spindle_bearing::Limits;
use std::fs::File;
use std::io::{self, BufWriter, ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
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
    /// Examples are in host_tests/bearings/ and host_tests/spindles/. A bearing of the catalogue is named in the place of
    /// a file, such as gmn:S6014C.
    #[arg(value_name = "DESIGN.toml", required_unless_present = "list")]
    design: Option<PathBuf>,

    /// Recorded loads and speed; `-` reads standard input
    ///
    /// An example, a synthetic milling cycle, is host_tests/records/milling_cycle.csv.
    #[arg(value_name = "LOADS.csv", required_unless_present_any = ["table", "list"])]
    loads: Option<String>,

    /// Print the catalogue: bearings that can be named in the place of DESIGN.toml
    #[arg(long)]
    list: bool,

    /// In place of LOADS.csv, make a table: stiffness at every combination of these speeds and loads
    ///
    /// Axes are speed in rpm, fx, fy, fz in N, and my, mz in N m. A spindle with `[heat]` has t_inner and
    /// t_outer, too, in deg C. Each is NAME=FIRST:LAST:STEP or NAME=VALUE, such as speed=0:20000:500 fx=500;
    /// one that is left out is 0, or `[heat]`'s reference. Speed changes from row to row. `time_s` counts
    /// the rows.
    #[arg(long, value_name = "AXIS=RANGE", num_args = 1.., conflicts_with = "loads")]
    table: Vec<String>,

    /// Precision to compute in
    ///
    /// Loads and speed are rounded to it first. Results have as many digits as it takes to read
    /// back the same number of this precision.
    #[arg(long, value_enum, default_value_t = Digits::F64)]
    precision: Digits,

    /// Rule for the axis about which a ball turns, and with it the gyroscopic moment
    #[arg(long, value_enum, default_value_t = Rule::Raceless)]
    attitude: Rule,

    /// Solve every row from scratch, as after a reset
    ///
    /// Without this, each row starts from the result of the row before, as the firmware does, and
    /// takes fewer iterations.
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

    /// Write the load, preload and least contact force of every row of a spindle to this CSV file
    #[arg(long, value_name = "ROWS.csv")]
    rows: Option<PathBuf>,

    /// Write the frequencies at which damaged parts of every row of balls are heard to this CSV file
    #[arg(long, value_name = "FREQUENCIES.csv")]
    frequencies: Option<PathBuf>,
}

/// The working precision.
#[derive(Debug, Clone, Copy, ValueEnum)]
enum Digits {
    /// Single precision, as the firmware computes
    F32,
    /// Double precision
    F64,
}

/// The rule for the axis about which a ball turns.
#[derive(Debug, Clone, Copy, ValueEnum)]
enum Rule {
    /// Raceway-control-free: from d'Alembert's principle, no race presumed to be in control
    Raceless,
    /// Outer race control: no spin at the outer race
    Outer,
    /// Inner race control: no spin at the inner race; not for loads that lift balls off it
    Inner,
}

const FORMATS: &str = "\
Frame: the outer rings stand still, the shaft turns about +x. Loads act on the inner ring of a
bearing, moments about its centre; on the shaft of a spindle at x = 0. Azimuths count from +y
towards +z.

DESIGN.toml is a spindle if it has [[row]]s:
  name = \"7014C back to back\"
  preload_n = 294               # of a pair; or preload_offset_um or spring = true for each row
  [[row]]
  bearing = \"7014c.toml\"       # beside this file; a name of the catalogue; or its keys under
                                # [row.design]
  position_mm = 0
  facing = \"+x\"               # a load on the shaft in +x presses its balls
  radial_growth_um = 2          # and axial_, ball_growth_um; may be left out
  [[row]]                       # back to back: +x at the smaller x, -x at the larger
  bearing = \"7014c.toml\"
  position_mm = 27
  facing = \"-x\"
  [spring]                      # of the rows with spring = true: force_n = 300
  [shaft]                       # rings grow with the speed on a shaft with bore_mm = 40
  [heat]                        # they grow with temperatures: reference_c = 20, ring_per_k, ball_per_k
  [nose]                        # stiffness there, too: position_mm = -60, radial_um_per_kn,
                                # axial_um_per_kn

LOADS.csv must have the header
  time_s,fx_n,fy_n,fz_n,my_nm,mz_nm,speed_rpm
with the columns in any order, in capitals or not. For a spindle with [heat] it has
t_inner_c,t_outer_c as well. Other columns are ignored, and named once on standard error. Fields are
separated as those of the header are: by commas, semicolons or tabs. With the latter two, numbers
may have decimal commas. Blank lines and lines that begin with # are skipped.

A table, in place of LOADS.csv:
  cargo replay DESIGN.toml --table speed=0:20000:500 fx=500 fy=0:1000:250 >TABLE.csv
  cargo plot TABLE.csv --over speed
It has the columns of the results. host_tests/recipes/ross_bearing.py makes a bearing of ROSS of it.

Results, one row for each row of LOADS.csv, SI units:
  time_s          copied
  status          converged; precision-limit (as close as the precision allows);
                  anything else means that this row has no answer, and its figures are empty:
                  unseated (the speed drives a ball out of its groove), iteration-limit (ran out
                  of iterations), refused-input (a field of LOADS.csv is empty or no number, or
                  the line has too few or too many fields) and so on
  iterations      passes over all balls that the solve took
  dx_m .. tz_rad  displacement of the inner ring, or of the shaft at x = 0
  k_x_x .. k_tz_tz  stiffness, 25 columns: k_y_tz is the change of Fy with the tilt tz
  k_nose_x_x ..   of a spindle with [nose], the stiffness there
  limits          physical limits that are passed, a blank between two of them; empty if none is:
                  peak-pressure (of a contact); shoulder (a contact's centre is past it); truncation
                  (of a contact ellipse by the shoulder); reversal (of a contact angle); friction
                  (more is called for, gross slip suspected); inner-contact (lost by a ball)
  fx_n .. speed_rpm  loads and speed, copied
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
    match run(&args) {
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
                Some(ReplayError::Output(Table::Results, reason))
                    if reason.kind() == ErrorKind::BrokenPipe =>
                {
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
    let file = SpindleFile::read(args.design())?;
    if args.rows.is_some() && file.is_bearing {
        bail!(
            "--rows is for spindles, and {} is one bearing: it has no [[row]]",
            args.design().display()
        );
    }
    let balls = Balls::Moving(match args.attitude {
        Rule::Raceless => Attitude::Raceless,
        Rule::Outer => Attitude::Outer,
        Rule::Inner => Attitude::Inner,
    });
    let precision = match args.precision {
        Digits::F32 => Precision::F32,
        Digits::F64 => Precision::F64,
    };
    let solved = with_solver(&file.plan, balls, precision, |solver| {
        solver.set_limits(&Limits {
            peak_pressure: args.peak_pressure * 1e6,
            friction: args.friction,
        });
        let rows = args.input(file.heat.map(|heat| heat.reference))?;
        let outputs = args.outputs()?;
        Ok(replay(&file, solver, precision, rows, args.cold, outputs)?)
    });
    solved.map_err(|error| file.explain(&error))?
}

impl Args {
    /// clap demands one, except with `--list`.
    fn design(&self) -> &Path {
        self.design.as_deref().unwrap_or(Path::new(""))
    }

    /// Rows of the recording or of the table; `reference` is the temperature of a spindle with `[heat]`.
    fn input(&self, reference: Option<f64>) -> Result<Rows> {
        let Some(path) = &self.loads else {
            let axes = Axes::parse(&self.table)?;
            if axes.has_temperatures() && reference.is_none() {
                bail!("--table: t_inner and t_outer are for spindles with [heat]; leave them out");
            }
            let rows = axes.rows(reference);
            let bar = progress_bar(Some(rows.len() as u64), "{pos} of {len} rows");
            return Ok(Box::new(rows.progress_with(bar).map(Ok)));
        };
        let mut loads = recordings::read(path)?;
        let file = loads.file();
        let ignored = loads.ignored_columns();
        if !ignored.is_empty() {
            eprintln!("replay: {file}: columns ignored: {}", listed(ignored));
        }
        match (reference.is_some(), loads.has_temperatures()) {
            (true, false) => {
                bail!("{file}: the columns t_inner_c and t_outer_c are missing, which [heat] needs")
            }
            (false, true) => bail!(
                "{file}: t_inner_c and t_outer_c are for spindles with [heat]: add that to the spindle with \
                 reference_c, or remove these columns"
            ),
            _ => {}
        }
        let bar = progress_bar(loads.total_bytes(), "{bytes} of {total_bytes}");
        Ok(Box::new(std::iter::from_fn(move || {
            let row = loads.next();
            bar.set_position(loads.bytes_read());
            row
        })))
    }

    /// Standard output, and the files that options name.
    fn outputs(&self) -> Result<Outputs<'static>> {
        let loads = self.loads.as_ref().map(Path::new);
        let inputs: Vec<&Path> = [Some(self.design()), loads].into_iter().flatten().collect();
        let mut outputs: Outputs<'_> = vec![(
            Table::Results,
            Box::new(BufWriter::with_capacity(1 << 16, io::stdout())),
        )];
        for (table, option, path) in [
            (Table::Balls, "--balls", &self.balls),
            (Table::Rows, "--rows", &self.rows),
            (Table::Frequencies, "--frequencies", &self.frequencies),
        ] {
            if let Some(path) = path {
                outputs.push((table, Box::new(create(option, path, &inputs)?)));
            }
        }
        Ok(outputs)
    }
}

/// Rows to solve.
type Rows = Box<dyn Iterator<Item = Result<LoadRow, LoadsError>>>;

/// The first of these names, and the number of the others.
fn listed(names: &[String]) -> String {
    const SHOWN: usize = 12;
    let quoted = names.iter().take(SHOWN).map(|name| format!("{name:?}"));
    let mut list = quoted.collect::<Vec<_>>().join(", ");
    if names.len() > SHOWN {
        list.push_str(&format!(" and {} more", names.len() - SHOWN));
    }
    list
}

/// Creates the file that an option names, unless that would destroy one of the `inputs`.
fn create(option: &str, path: &Path, inputs: &[&Path]) -> Result<BufWriter<File>> {
    let name = path.display();
    if path.as_os_str() == "-" {
        bail!("{option} needs a file; standard output carries the results");
    }
    let same = |input: &&Path| match (path.canonicalize(), input.canonicalize()) {
        (Ok(path), Ok(input)) => path == input,
        _ => false,
    };
    if inputs.iter().any(same) {
        bail!("{option} would overwrite its own input {name}; name another file");
    }
    match File::create(path) {
        Ok(file) => Ok(BufWriter::new(file)),
        Err(error) => bail!("{name}: cannot be written: {error}"),
    }
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

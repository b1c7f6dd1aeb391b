//! `cargo plot`: a table that `cargo replay` wrote, or a spindle, as a picture.

use anyhow::{Context, Result, bail, ensure};
use clap::{Parser, ValueEnum};
use cli::chart::{self, Axis, Chart, Curve, Panel, Style};
use cli::drawing;
use cli::output::NewFile;
use spindle_file::mounting::Parts;
use spindle_file::spindles::SpindleFile;
use spindle_monitor::estimator::State;
use std::array::from_fn;
use std::cmp::Ordering;
use std::fs::File;
use std::io::{self, Read, Write};
use std::path::PathBuf;
use std::process::ExitCode;

/// Most points of a curve: of a longer recording, each point is the mean of many rows.
const MOST_POINTS: usize = 120;
/// Most points of a curve of --response, whose changes are sudden.
const MOST_SPANS: usize = 600;
/// Name of the curves of a whole spindle.
const SPINDLE: &str = "spindle";
/// Most curves of a panel: of more loads, each row is a dot.
const MOST_CURVES: usize = 8;
/// Most dots of a panel.
const MOST_DOTS: usize = 400;

/// Draws what `cargo replay` has written, or the spindle of a file
///
/// Results and tables become curves of speed, load and stiffness over time, or of stiffness over
/// speed. A file of balls becomes the load distribution: contact forces over the azimuth at one
/// time. A file that ends in .toml is a spindle's: its shaft with its diameters, rows, contact lines, supports, loads, noses and probes in section. A file
/// of --response becomes preload and gains over time, with their errors, and states.
#[derive(Debug, Parser)]
#[command(name = "plot", bin_name = "cargo plot", max_term_width = 100)]
struct Args {
    /// Results of `cargo replay`, or its file of --balls, `-` being standard input; or a spindle's SPINDLE.toml
    #[arg(value_name = "FILE")]
    file: PathBuf,

    /// Picture to write; `-` is standard output
    ///
    /// The default is FILE.svg; standard output if FILE is standard input.
    #[arg(short, long, value_name = "FILE.svg")]
    output: Option<PathBuf>,

    /// Axis over which a results file is drawn
    #[arg(long, value_enum, default_value_t = Over::Time)]
    over: Over,

    /// Stiffness at the nose of a spindle, 1 over the compliance there, in place of that at x = 0
    #[arg(long)]
    nose: bool,

    /// Time of which the balls are drawn, s: the nearest in the file
    ///
    /// The default is the time of the largest contact force.
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    time: Option<f64>,

    /// Title of the picture
    #[arg(long)]
    title: Option<String>,
}

/// The quantity along the axis of a drawing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Over {
    /// Time, with speed and loads above
    Time,
    /// Shaft speed, a curve for each load
    Speed,
    /// Axial load
    Fx,
    /// Radial load
    Fy,
    /// Radial load
    Fz,
    /// Tilting moment
    My,
    /// Tilting moment
    Mz,
    /// Temperature of the inner side
    #[value(name = "t_inner")]
    TInner,
    /// Temperature of the outer side
    #[value(name = "t_outer")]
    TOuter,
}

fn main() -> ExitCode {
    let args = Args::parse();
    let drawn = draw(&args).map_err(|error| (2, error));
    match drawn.and_then(|svg| write(&args, &svg).map_err(|error| (1, error))) {
        Ok(()) => ExitCode::SUCCESS,
        // A reader that has seen enough is no failure.
        Err((_, error)) if is_closed_pipe(&error) => ExitCode::SUCCESS,
        Err((status, error)) => {
            eprintln!("plot: {error:#}");
            ExitCode::from(status)
        }
    }
}

fn is_closed_pipe(error: &anyhow::Error) -> bool {
    let reason = error.downcast_ref::<io::Error>();
    reason.is_some_and(|reason| reason.kind() == io::ErrorKind::BrokenPipe)
}

/// The picture as SVG.
fn draw(args: &Args) -> Result<String> {
    if args.file.extension().is_some_and(|ending| ending == "toml") {
        let given = args.over != Over::Time || args.nose || args.time.is_some();
        ensure!(
            !given,
            "--over, --nose and --time are for tables, and {} is a spindle",
            args.file.display()
        );
        let mut spindle = SpindleFile::read(&args.file)?;
        // What cannot be built of good parts is drawn: a look at it tells why.
        let parts = Parts::<f64>::of(&spindle.plan);
        parts.map_err(|error| spindle.explain(&error))?;
        for doubt in &spindle.doubts {
            eprintln!("plot: {doubt}");
        }
        spindle.name = args.title.clone().unwrap_or(spindle.name);
        return Ok(drawing::svg(&spindle));
    }
    let name = args.file.display().to_string();
    let (file, input): (_, Box<dyn Read>) = if name == "-" {
        ("standard input", Box::new(io::stdin()))
    } else {
        let file = File::open(&args.file);
        let file = file.with_context(|| format!("{name}: cannot be read"))?;
        (&*name, Box::new(file))
    };
    chart(args, input)
        .and_then(|chart| chart::svg(&chart))
        .with_context(|| file.to_owned())
}

fn chart(args: &Args, input: Box<dyn Read>) -> Result<Chart> {
    let mut table = Table::open(input)?;
    let mut chart = if table.has("k_x_x") {
        ensure!(
            args.time.is_none(),
            "--time is for a file of balls, and this one holds results"
        );
        match args.over {
            Over::Time => over_time(&results(&mut table, args.nose)?, args.nose)?,
            over => over_given(
                &results(&mut table, args.nose)?,
                args.nose,
                over as usize - 1,
            )?,
        }
    } else if table.has("azimuth_rad") {
        let for_results = args.over != Over::Time || args.nose;
        ensure!(
            !for_results,
            "--over and --nose are for results, and this is a file of balls"
        );
        around(&mut table, args.time)?
    } else if table.has("preload_error_n") {
        responses(&mut table)?
    } else {
        bail!(
            "line 1: there is no column k_x_x as in the results of cargo replay, nor azimuth_rad as in its --balls, \
             nor preload_error_n as in its --response; files of --rows, --nose and --frequencies are not drawn"
        )
    };
    let name = args.file.file_name().unwrap_or_default();
    let title = format!("{}: {}", name.to_string_lossy(), chart.title);
    chart.title = args.title.clone().unwrap_or(title);
    Ok(chart)
}

/// A CSV file with a header.
struct Table {
    reader: csv::Reader<Box<dyn Read>>,
    header: csv::StringRecord,
}

impl Table {
    fn open(input: Box<dyn Read>) -> Result<Self> {
        let mut reader = csv::ReaderBuilder::new()
            .flexible(true)
            .trim(csv::Trim::All)
            .from_reader(input);
        let header = reader.headers()?.clone();
        Ok(Self { reader, header })
    }

    fn has(&self, name: &str) -> bool {
        self.header.iter().any(|field| field == name)
    }

    /// The numbers of all rows in the columns of these names: not a number where there is nothing to draw.
    fn read<const N: usize>(&mut self, names: &str) -> Result<Vec<[f64; N]>> {
        let names: Vec<_> = names.split_whitespace().collect();
        let rows = self.read_with(&names, &[])?.into_iter();
        let numbers = |row: Vec<f64>| from_fn(|i| row.get(i).copied().unwrap_or(f64::NAN));
        Ok(rows.map(|(row, _)| numbers(row)).collect())
    }

    /// The numbers of all rows in the columns of these names, and the words in some.
    fn read_with(
        &mut self,
        names: &[&str],
        words: &[&str],
    ) -> Result<Vec<(Vec<f64>, Vec<String>)>> {
        let place = |name: &&str| {
            let column = self.header.iter().position(|field| field == *name);
            column.with_context(|| {
                format!(
                    "line 1: the column {name} is missing; did cargo replay write the file, and of a spindle with [nose] \
                     for --nose?"
                )
            })
        };
        let columns = names.iter().map(place).collect::<Result<Vec<_>>>()?;
        let words = words.iter().map(place).collect::<Result<Vec<_>>>()?;
        let mut rows = Vec::new();
        let mut record = csv::StringRecord::new();
        while self.reader.read_record(&mut record)? {
            let text = |column: usize| record.get(column).unwrap_or_default();
            let line = record.position().map_or(0, |place| place.line());
            let number = |(name, column): (&&str, &usize)| {
                let text = text(*column);
                if text.is_empty() {
                    return Ok(f64::NAN);
                }
                let read = text.parse::<f64>();
                let read = read
                    .with_context(|| format!("line {line} ({name}): {text:?} is not a number"))?;
                // Beyond this power there is nothing to draw, and a scale for it would overflow.
                Ok(if read.abs() < 1e30 { read } else { f64::NAN })
            };
            let numbers = names.iter().zip(&columns).map(number);
            let numbers = numbers.collect::<Result<Vec<_>>>()?;
            let words = words.iter().map(|column| text(*column).to_owned());
            rows.push((numbers, words.collect()));
        }
        Ok(rows)
    }
}

/// Quantities over which stiffness is drawn, their units, and names along an axis.
const GIVEN: [(&str, &str, &str); 8] = [
    ("n", "1000 rpm", "shaft speed"),
    ("Fx", "N", "axial load"),
    ("Fy", "N", "radial load Fy"),
    ("Fz", "N", "radial load Fz"),
    ("My", "N m", "moment My"),
    ("Mz", "N m", "moment Mz"),
    ("Ti", "°C", "inner temperature"),
    ("To", "°C", "outer temperature"),
];

/// A row of results.
struct Row {
    time: f64,
    /// Speed in 1000 rpm, Fx, Fy, Fz, My, Mz, temperatures: as in [`GIVEN`].
    given: [f64; GIVEN.len()],
    /// Diagonal at x = 0, or at the nose 1 over that of the compliance: N/µm, then kN m/rad.
    stiffness: [f64; 5],
}

/// Stiffness of a picture.
const fn stiffness(nose: bool) -> &'static str {
    if nose {
        "stiffness at the nose"
    } else {
        "stiffness"
    }
}

fn results(table: &mut Table, nose: bool) -> Result<Vec<Row>> {
    let k = if nose { "k_nose" } else { "k" };
    let warm = if table.has("t_inner_c") {
        "t_inner_c t_outer_c"
    } else {
        ""
    };
    let rows = table.read(&format!(
        "time_s speed_rpm fx_n fy_n fz_n my_nm mz_nm {k}_x_x {k}_y_y {k}_z_z {k}_ty_ty {k}_tz_tz {warm}"
    ))?;
    let rows = rows.into_iter().map(
        |[
            time,
            speed,
            fx,
            fy,
            fz,
            my,
            mz,
            x,
            y,
            z,
            ty,
            tz,
            inner,
            outer,
        ]| Row {
            time,
            given: [speed / 1e3, fx, fy, fz, my, mz, inner, outer],
            stiffness: [x / 1e6, y / 1e6, z / 1e6, ty / 1e3, tz / 1e3],
        },
    );
    let rows: Vec<_> = rows.filter(|row| row.time.is_finite()).collect();
    let answers = rows
        .iter()
        .filter(|row| row.stiffness[0].is_finite())
        .count();
    ensure!(
        answers > 1,
        "fewer than two rows have an answer, nothing to draw; the column status says why"
    );
    Ok(rows)
}

fn over_time(rows: &[Row], nose: bool) -> Result<Chart> {
    type Named = (&'static str, fn(&Row) -> f64);
    const RADIAL: [Named; 2] = [("y", |row| row.stiffness[1]), ("z", |row| row.stiffness[2])];
    const TILT: [Named; 2] = [("y", |row| row.stiffness[3]), ("z", |row| row.stiffness[4])];
    const LOAD: [Named; 2] = [
        ("axial", |row| row.given[1]),
        ("radial", |row| row.given[2].hypot(row.given[3])),
    ];
    const PANELS: [(&str, &str, &[Named]); 5] = [
        ("Shaft speed", "1000 rpm", &[("", |row| row.given[0])]),
        ("Load", "N", &LOAD),
        ("Radial", "N/µm", &RADIAL),
        ("Axial", "N/µm", &[("axial", |row| row.stiffness[0])]),
        ("Tilt", "kN m/rad", &TILT),
    ];
    let first = rows[0].time;
    let moves = rows.iter().any(|row| row.time != first);
    ensure!(
        moves,
        "all rows have the time {first} s, nothing to draw over time"
    );
    let panels = PANELS.iter().enumerate().map(|(i, (title, unit, curves))| {
        let of = if i < 2 {
            String::new()
        } else {
            format!(" {}", stiffness(nose))
        };
        let curves = curves.iter().flat_map(|(name, value)| {
            let points: Vec<_> = rows.iter().map(|row| (row.time, value(row))).collect();
            means(name, &points)
        });
        Panel::new(&format!("{title}{of}"), "", unit, curves.collect())
    });
    let mut panels: Vec<_> = panels.collect();
    panels[4].x = Axis::new("time / s");
    let mut title = format!("{} over time", stiffness(nose));
    let together = rows.len().div_ceil(MOST_POINTS);
    if together > 1 {
        title += &format!("; lines: means of {together} rows; bands: least to largest");
    }
    Ok(Chart::new(&title, 1, panels))
}

/// Preload and gains with two standard errors over time, and the states of the spindle and of its probes.
fn responses(table: &mut Table) -> Result<Chart> {
    let header = table.header.clone();
    let probes = header.iter().filter_map(|name| name.strip_prefix("state_"));
    let probes: Vec<_> = probes.collect();
    let gains = probes
        .iter()
        .flat_map(|probe| [format!("gain_{probe}"), format!("gain_error_{probe}")]);
    let numbers = ["time_s", "preload_n", "preload_error_n"].map(str::to_owned);
    let numbers: Vec<_> = numbers.into_iter().chain(gains).collect();
    let words = probes.iter().map(|probe| format!("state_{probe}"));
    let words: Vec<_> = ["state".to_owned()].into_iter().chain(words).collect();
    let [numbers, words] =
        [&numbers, &words].map(|all| all.iter().map(|name| &**name).collect::<Vec<_>>());
    let mut rows = table.read_with(&numbers, &words)?;
    rows.retain(|(row, _)| row[0].is_finite());
    ensure!(
        rows.len() > 1,
        "there are fewer than two lines, nothing to draw"
    );
    let spans: Vec<_> = rows.chunks(rows.len().div_ceil(MOST_SPANS)).collect();
    let time = |span: &[(Vec<f64>, Vec<String>)]| span[span.len() / 2].0[0];
    // The band of a span is from the least to the largest of its lines.
    let band = |name: &str, column: usize| {
        let spans = spans.iter().map(|span| {
            let known = span.iter().map(|(row, _)| [row[column], row[column + 1]]);
            let known: Vec<_> = known.filter(|of| of[0].is_finite()).collect();
            let mean = known.iter().map(|of| of[0]).sum::<f64>() / known.len() as f64;
            let ends = [-2.0, 2.0].map(|side| known.iter().map(move |of| of[0] + side * of[1]));
            let [low, high] = ends;
            (
                time(span),
                [
                    low.fold(f64::NAN, f64::min),
                    mean,
                    high.fold(f64::NAN, f64::max),
                ],
            )
        });
        banded(name, &spans.collect::<Vec<_>>())
    };
    let gains = probes.iter().enumerate();
    let gains = gains
        .flat_map(|(i, probe)| band(probe, 3 + 2 * i))
        .collect();
    let mut panels = vec![Panel::new(
        "Gain: measured over computed motion",
        "",
        "",
        gains,
    )];
    if rows.iter().any(|(row, _)| row[1].is_finite()) {
        panels.insert(0, Panel::new("Preload / N", "", "", band(SPINDLE, 1)));
    }
    // The worst of a span is its state. The best of all states is the lowest.
    let worst = |span: &[(Vec<f64>, Vec<String>)], i: usize| {
        State::ALL
            .into_iter()
            .find(|state| span.iter().any(|(_, words)| words[i] == state.name()))
    };
    let is_seen = |state: &State| {
        (0..words.len()).any(|i| spans.iter().any(|span| worst(span, i) == Some(*state)))
    };
    let seen: Vec<_> = State::ALL.into_iter().rev().filter(is_seen).collect();
    let curves = [SPINDLE]
        .iter()
        .chain(&probes)
        .enumerate()
        .map(|(i, name)| {
            let aside = 0.12 * (0.5 * probes.len() as f64 - i as f64);
            let points = spans.iter().map(|span| {
                let level = seen.iter().position(|state| Some(*state) == worst(span, i));
                (
                    time(span),
                    level.map_or(f64::NAN, |level| level as f64 + aside),
                )
            });
            Curve::new(name, Style::Line, points.collect())
        });
    let mut states = Panel::new("State", "time / s", "", curves.collect());
    states.y.range = Some((-0.5, seen.len() as f64 - 0.5));
    states.y.words = seen.iter().map(|state| state.name()).collect();
    panels.push(states);
    Ok(Chart::new(
        "measured by the probes; bands: two standard errors",
        1,
        panels,
    ))
}

/// A line through the points; through means of them above a band, if there are too many.
fn means(name: &str, points: &[(f64, f64)]) -> Vec<Curve> {
    let together = points.len().div_ceil(MOST_POINTS);
    if together == 1 {
        return vec![Curve::new(name, Style::Line, points.to_vec())];
    }
    let spans = points.chunks(together).map(|span| {
        let values = span.iter().map(|point| point.1);
        let values: Vec<_> = values.filter(|value| value.is_finite()).collect();
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let [least, largest] =
            [f64::min, f64::max].map(|of| values.iter().copied().fold(f64::NAN, of));
        (span[span.len() / 2].0, [least, mean, largest])
    });
    banded(name, &spans.collect::<Vec<_>>())
}

/// A line over a band: least, mean and largest of each place; broken where the mean is not a number.
fn banded(name: &str, spans: &[(f64, [f64; 3])]) -> Vec<Curve> {
    let bands = spans.split(|span| span.1[1].is_nan()).map(|run| {
        let low = run.iter().map(|(x, [least, ..])| (*x, *least));
        let high = run.iter().map(|(x, [.., largest])| (*x, *largest));
        Curve::new(name, Style::Band, low.chain(high.rev()).collect())
    });
    let line = spans.iter().map(|(x, [_, mean, _])| (*x, *mean)).collect();
    bands.chain([Curve::new(name, Style::Line, line)]).collect()
}

/// Stiffness over one of the quantities that are [`GIVEN`], a curve for each combination of the others.
fn over_given(rows: &[Row], nose: bool, over: usize) -> Result<Chart> {
    const PANELS: [(&str, &str, &str, usize); 5] = [
        ("Radial", "yy", "N/µm", 1),
        ("Radial", "zz", "N/µm", 2),
        ("Tilt", "ty,ty", "kN m/rad", 3),
        ("Tilt", "tz,tz", "kN m/rad", 4),
        ("Axial", "xx", "N/µm", 0),
    ];
    let (_, unit, axis) = GIVEN[over];
    let is_there = |row: &Row| row.given[over].is_finite();
    ensure!(
        rows.iter().any(is_there),
        "there is no {axis} in the file: temperatures are those of a spindle with [heat]"
    );
    // What all rows lack is no reason to leave one out.
    let complete = |row: &&Row| {
        let numbers = row.given[..6].iter().chain(&row.stiffness);
        is_there(row) && numbers.copied().all(f64::is_finite)
    };
    let mut rows: Vec<_> = rows.iter().filter(complete).collect();
    let others = |row: &Row| {
        let mut others = row.given.map(|x| if x.is_finite() { x } else { 0.0 });
        others[over] = 0.0;
        others
    };
    let order = |row: &Row| (others(row), row.given[over]);
    rows.sort_by(|a, b| order(a).partial_cmp(&order(b)).unwrap_or(Ordering::Equal));
    ensure!(
        rows.iter()
            .any(|row| row.given[over] != rows[0].given[over]),
        "fewer than two values of the {axis} have an answer, nothing to draw over it"
    );
    let varies: [bool; GIVEN.len()] =
        std::array::from_fn(|i| rows.iter().any(|row| others(row)[i] != others(rows[0])[i]));
    let name = |row: &Row, varying: bool| {
        let others = others(row);
        let said =
            (0..GIVEN.len()).filter(|i| varies[*i] == varying && (varying || others[*i] != 0.0));
        let said = said.map(|i| match (GIVEN[i], others[i]) {
            ((name, "1000 rpm", _), thousands) => format!("{name} = {} rpm", 1e3 * thousands),
            ((name, unit, _), value) => format!("{name} = {value} {unit}"),
        });
        said.collect::<Vec<_>>().join(", ")
    };
    let title = format!(
        "{} over {}, {}",
        stiffness(nose),
        if over == 0 { "speed" } else { axis },
        name(rows[0], false)
    );
    let groups = rows.chunk_by(|a, b| others(a) == others(b));
    let groups = groups.map(|rows| (name(rows[0], true), rows.to_vec()));
    let (mut groups, mut style) = (groups.collect::<Vec<_>>(), Style::Line);
    if groups.len() > MOST_CURVES {
        let step = rows.len().div_ceil(MOST_DOTS);
        let some = rows.into_iter().step_by(step).collect();
        (groups, style) = (vec![(format!("one row of {step}"), some)], Style::Dots);
    }
    let along = format!("{axis} / {unit}");
    let symbol = if nose { "1/c" } else { "K" };
    let panels = PANELS.iter().map(|&(title, freedom, unit, i)| {
        let curves = groups.iter().map(|(name, rows)| {
            let points = rows.iter().map(|row| (row.given[over], row.stiffness[i]));
            Curve::new(name, style, points.collect())
        });
        let title = format!("{title} {} {symbol}_{freedom}", stiffness(nose));
        Panel::new(&title, &along, unit, curves.collect())
    });
    let title = title.trim_end_matches(", ");
    Ok(Chart::new(title, 2, panels.collect()))
}

/// Contact forces around the bearing at the time nearest to `wanted`, or of the largest force.
fn around(table: &mut Table, wanted: Option<f64>) -> Result<Chart> {
    // The file of a single bearing has no rows: its balls share the time, too.
    let row = if table.has("row") { "row" } else { "time_s" };
    let mut balls = table.read(&format!("time_s azimuth_rad q_i_n q_o_n {row}"))?;
    balls.retain(|ball| ball.iter().all(|number| number.is_finite()));
    let rank = |[time, _, inner, outer, _]: &[f64; 5]| match wanted {
        Some(wanted) => -(time - wanted).abs(),
        None => inner.max(*outer),
    };
    let best = balls.iter().max_by(|a, b| rank(a).total_cmp(&rank(b)));
    let [time, ..] = *best.context("no ball has forces, nothing to draw: no row had an answer")?;
    balls.retain(|ball| ball[0] == time);
    ensure!(
        balls.iter().any(|ball| ball[2].max(ball[3]) > 0.0),
        "no ball carries a force at {time} s"
    );
    let place = |ball: &[f64; 5]| (ball[4], ball[1]);
    balls.sort_by(|a, b| place(a).partial_cmp(&place(b)).unwrap_or(Ordering::Equal));
    let rows = balls.chunk_by(|a, b| a[4] == b[4]).map(|balls| {
        let curve = |name, style, force: usize| {
            let points = balls.iter().map(|ball| (ball[1].to_degrees(), ball[force]));
            Curve::new(name, style, points.collect())
        };
        let [inner, outer] = ["inner race", "outer race"];
        let mut curves = vec![curve(inner, Style::Line, 2), curve(outer, Style::Dashed, 3)];
        curves.extend([curve(inner, Style::Dots, 2), curve(outer, Style::Dots, 3)]);
        let azimuth = "azimuth / degrees: y at 0, z at 90";
        let title = format!("row {}", balls[0][4]);
        Panel::new(&title, azimuth, "contact force / N", curves)
    });
    let mut panels: Vec<_> = rows.collect();
    if let [panel] = &mut panels[..] {
        panel.title.clear();
    }
    let title = format!("contact forces at {time} s");
    Ok(Chart::new(&title, panels.len().min(2), panels))
}

/// Writes the picture where it is wanted.
fn write(args: &Args, svg: &str) -> Result<()> {
    let path = match &args.output {
        Some(path) => path.clone(),
        None if args.file.as_os_str() == "-" => PathBuf::from("-"),
        None => args.file.with_extension("svg"),
    };
    if path.as_os_str() == "-" {
        return Ok(io::stdout().write_all(svg.as_bytes())?);
    }
    let name = path.display();
    ensure!(
        path != args.file,
        "{name}: the file itself; name the picture with -o"
    );
    let is_svg = path.extension().is_some_and(|ending| ending == "svg");
    ensure!(is_svg, "{name}: pictures are .svg; name one so");
    let written = NewFile::write_whole(&path, svg.as_bytes());
    written.with_context(|| format!("{name}: cannot be written"))
}

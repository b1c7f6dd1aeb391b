//! `cargo plot`: a table that `cargo replay` wrote, as a picture.

mod balls;
mod results;

use crate::arguments::parsed;
use clap::{Parser, ValueEnum};
use csv::StringRecord;
use std::ffi::OsString;
use std::fs::File;
use std::io::{BufReader, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Draws what `cargo replay` has written
///
/// Results and tables become curves of speed, load and stiffness over time, or of stiffness over
/// speed. A file of balls becomes the load distribution: contact forces around the bearing at one
/// time.
#[derive(Debug, Parser)]
#[command(name = "plot", bin_name = "cargo plot", max_term_width = 100)]
pub struct Args {
    /// Results of `cargo replay`, or its file of --balls; `-` reads standard input
    #[arg(value_name = "FILE.csv")]
    file: String,

    /// Picture to write; `-` is standard output
    ///
    /// The default is FILE.svg; standard output if FILE is standard input. A name that ends with
    /// .png needs rsvg-convert.
    #[arg(short, long, value_name = "FILE.svg")]
    output: Option<PathBuf>,

    /// What a results file is drawn over
    #[arg(long, value_enum, default_value_t = Over::Time)]
    over: Over,

    /// Stiffness at the nose of a spindle, in place of that at x = 0
    #[arg(long)]
    nose: bool,

    /// Time of which the balls are drawn, s: the nearest in the file
    ///
    /// The default is that of the largest contact force.
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    time: Option<f64>,

    /// Title of the picture
    #[arg(long)]
    title: Option<String>,
}

/// What stiffness is drawn over.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Over {
    /// Time, with speed and loads above
    Time,
    /// Shaft speed, a curve for each load
    Speed,
}

/// The whole program but for the process around it: arguments (the first is the program's name) and
/// streams in, exit status out.
pub fn run(
    args: impl IntoIterator<Item = OsString>,
    stdin: impl Read + 'static,
    mut stdout: impl Write,
    mut stderr: impl Write,
) -> u8 {
    let args: Args = match parsed(args, &mut stdout, &mut stderr) {
        Ok(args) => args,
        Err(status) => return status,
    };
    let drawn = draw(&args, Box::new(stdin)).map_err(|message| (2, message));
    match drawn.and_then(|svg| write(&args, &svg, &mut stdout).map_err(|message| (1, message))) {
        Ok(()) => 0,
        Err((status, message)) => {
            let _ = writeln!(stderr, "plot: {message}");
            status
        }
    }
}

/// The picture as SVG.
fn draw(args: &Args, stdin: Box<dyn Read>) -> Result<String, String> {
    let mut table = Table::open(&args.file, stdin)?;
    if table.find("k_x_x").is_some() {
        if args.time.is_some() {
            let name = &table.file;
            return Err(format!(
                "{name}: --time is for a file of balls, and this one holds results"
            ));
        }
        results::draw(&mut table, args)
    } else if table.find("q_i_n").is_some() && table.find("azimuth_rad").is_some() {
        if args.over == Over::Speed || args.nose {
            let name = &table.file;
            return Err(format!(
                "{name}: --over speed and --nose are for results, and this is a file of balls"
            ));
        }
        balls::draw(&mut table, args)
    } else {
        Err(format!(
            "{}: line 1: there is no column k_x_x as in the results of cargo replay, nor azimuth_rad and q_i_n as in its \
             --balls; files of --rows and --frequencies are not drawn",
            table.file
        ))
    }
}

impl Args {
    /// The title, which is this one if none is given.
    fn title(&self, default: impl FnOnce(&str) -> String) -> String {
        let name = Path::new(&self.file).file_name().unwrap_or_default();
        let title = self.title.clone();
        title.unwrap_or_else(|| default(&name.to_string_lossy()))
    }
}

/// A CSV file with a header.
struct Table {
    file: String,
    reader: csv::Reader<Box<dyn Read>>,
    header: StringRecord,
    record: StringRecord,
}

impl Table {
    fn open(path: &str, stdin: Box<dyn Read>) -> Result<Self, String> {
        let (file, input): (_, Box<dyn Read>) = if path == "-" {
            ("standard input", stdin)
        } else {
            let unreadable = |error| format!("{path}: cannot be read: {error}");
            let file = File::open(path).map_err(unreadable)?;
            (path, Box::new(BufReader::new(file)))
        };
        let mut reader = csv::ReaderBuilder::new().flexible(true).from_reader(input);
        let header = reader.headers();
        let header = header.map_err(|error| format!("{file}: {error}"))?.clone();
        Ok(Self {
            file: file.to_owned(),
            reader,
            header,
            record: StringRecord::new(),
        })
    }

    /// The column of this name.
    fn find(&self, name: &str) -> Option<usize> {
        self.header.iter().position(|field| field.trim() == name)
    }

    /// The columns of these names, all of which must be there.
    fn columns<const N: usize>(&self, names: [&str; N]) -> Result<[usize; N], String> {
        let mut columns = [0; N];
        for (column, name) in columns.iter_mut().zip(names) {
            let found = self.find(name);
            *column = found.ok_or_else(|| {
                let file = &self.file;
                format!("{file}: line 1: the column {name} is missing; was the file written by cargo replay?")
            })?;
        }
        Ok(columns)
    }

    /// Brings the next line; `false` at the end of the file.
    fn next(&mut self) -> Result<bool, String> {
        let read = self.reader.read_record(&mut self.record);
        read.map_err(|error| format!("{}: {error}", self.file))
    }

    /// The number in a column; none where the field is empty. What cannot be drawn counts as empty.
    fn number(&self, column: usize) -> Result<Option<f64>, String> {
        let text = self.record.get(column).unwrap_or_default().trim();
        if text.is_empty() {
            return Ok(None);
        }
        let number: Result<f64, _> = text.parse();
        let number = number.map_err(|_| {
            let line = self.record.position().map_or(0, |place| place.line());
            let name = self.header.get(column).unwrap_or_default();
            let start: String = text.chars().take(40).collect();
            let file = &self.file;
            format!("{file}: line {line} ({name}): {start:?} is not a number")
        })?;
        // Beyond these powers there is nothing to draw, and a scale for it would overflow.
        let number = if number.abs() < 1e-30 { 0.0 } else { number };
        Ok(Some(number).filter(|number| number.abs() < 1e30))
    }

    /// The numbers in these columns, where none is missing.
    fn numbers<const N: usize>(&self, columns: &[usize; N]) -> Result<Option<[f64; N]>, String> {
        let mut numbers = [0.0; N];
        for (number, &column) in numbers.iter_mut().zip(columns) {
            match self.number(column)? {
                Some(found) => *number = found,
                None => return Ok(None),
            }
        }
        Ok(Some(numbers))
    }
}

/// Writes the picture where it is wanted.
fn write(args: &Args, svg: &str, stdout: &mut dyn Write) -> Result<(), String> {
    let path = match &args.output {
        Some(path) => path.clone(),
        None if args.file == "-" => PathBuf::from("-"),
        None => Path::new(&args.file).with_extension("svg"),
    };
    let failed = |error| format!("{}: cannot be written: {error}", path.display());
    if path.as_os_str() == "-" {
        return match stdout
            .write_all(svg.as_bytes())
            .and_then(|()| stdout.flush())
        {
            // A reader that has seen enough is no failure.
            Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => Err(failed(error)),
            _ => Ok(()),
        };
    }
    if path.canonicalize().is_ok_and(|path| {
        Path::new(&args.file)
            .canonicalize()
            .is_ok_and(|file| file == path)
    }) {
        return Err(format!(
            "{} would be overwritten by its own picture; name another with -o",
            path.display()
        ));
    }
    match path.extension().and_then(|ending| ending.to_str()) {
        Some("svg") => std::fs::write(&path, svg).map_err(failed),
        Some("png") => png(svg, &path),
        _ => Err(format!(
            "{}: pictures are .svg or .png; name one so",
            path.display()
        )),
    }
}

/// Has rsvg-convert write a PNG file.
fn png(svg: &str, path: &Path) -> Result<(), String> {
    let failed = |error: &dyn std::fmt::Display| {
        format!(
            "{}: rsvg-convert does not write it: {error}; install librsvg2-bin, or name a .svg file",
            path.display()
        )
    };
    let converter = Command::new("rsvg-convert")
        .arg("-o")
        .arg(path)
        .stdin(Stdio::piped())
        .spawn();
    let mut converter = converter.map_err(|error| failed(&error))?;
    let mut input = converter.stdin.take();
    let written = input.as_mut().map(|input| input.write_all(svg.as_bytes()));
    drop(input);
    let status = converter.wait().map_err(|error| failed(&error))?;
    match written {
        Some(Err(error)) => Err(failed(&error)),
        _ if !status.success() => Err(failed(&status)),
        _ => Ok(()),
    }
}

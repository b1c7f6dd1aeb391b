//! The module `spindle_bearing._core`: arrays in, tables out. The Python files beside it are around it.

use cli::lifetime::Lifetime;
use cli::limits::{Watch, limits};
use cli::options::{ATTITUDES, BOARDS, MOTIONS, Named, Options, PAUSES, PRECISIONS, window};
use cli::quantities::{OWN, due};
use cli::replay::{Job, Refusals, Table, Wanted, Words, fill, forms};
use cli::response::response;
use cli::sensitivity::sensitivity;
use cli::{fault::LoadsError, recordings::sharing_times};
use numpy::{PyArray2, PyArrayMethods, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rayon::{ThreadPool, ThreadPoolBuilder};
use solvers::{Balls, with_solver};
use spindle_file::catalogue;
use spindle_file::loads::{LoadRow, celsius};
use spindle_file::noses::Nose;
use spindle_file::plan::ShaftEnd;
use spindle_file::probes::MOST_PROBES;
use spindle_file::reading::{DesignFileError, read_text};
use spindle_file::spindles::SpindleFile;
use std::collections::BTreeMap;
use std::fmt::Display;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::Mutex;

pyo3::import_exception!(spindle_bearing._errors, SpindleError);

/// Columns of an array of records: those of a recording, and the probes.
const WIDTH: usize = OWN.len() + MOST_PROBES;

/// Records of the monitor between two looks for Ctrl-C: a tenth of a second.
const LOOK: usize = 2000;

const TABLES: [(&str, Table); 5] = [
    ("results", Table::Results),
    ("rows", Table::Rows),
    ("noses", Table::Noses),
    ("balls", Table::Balls),
    ("frequencies", Table::Frequencies),
];

/// An error in its words. Options have dashes on the command line alone.
fn refused(error: impl Display) -> PyErr {
    SpindleError::new_err(error.to_string().replace("--", ""))
}

/// An error of a file, with its place.
fn refused_file(error: DesignFileError) -> PyErr {
    let place = error.place.map(|place| (place.line, place.column));
    let (line, column) = place.unzip();
    SpindleError::new_err((error.to_string(), error.file, line, column))
}

/// Runs without the interpreter. A panic becomes an exception.
fn detached<O: Send>(py: Python<'_>, run: impl FnOnce() -> PyResult<O> + Send) -> PyResult<O> {
    let done = py.detach(|| catch_unwind(AssertUnwindSafe(run)));
    done.unwrap_or_else(|panic| {
        let words = panic.downcast_ref::<String>().map(String::as_str);
        let words = words.or_else(|| panic.downcast_ref::<&str>().copied());
        let words = words.unwrap_or("panic");
        Err(PyRuntimeError::new_err(format!(
            "a fault of spindle_bearing, please report it: {words}"
        )))
    })
}

fn named<T: Copy>(option: &str, all: &[Named<T>], name: &str) -> PyResult<T> {
    let found = all.iter().find(|one| one.0 == name);
    let names: Vec<&str> = all.iter().map(|one| one.0).collect();
    found
        .map(|one| one.2)
        .ok_or_else(|| refused(format!("{option}={name:?} is none of {}", names.join(", "))))
}

/// Options by the names of `cargo replay`.
fn options(given: &Bound<'_, PyDict>) -> PyResult<Options> {
    const NAMES: &str = "precision, attitude, motion, freedoms, given, tolerance, cold, peak_pressure, friction, pauses";
    let mut options = Options::default();
    for (name, value) in given {
        let name: String = name.extract()?;
        let mut read = || -> PyResult<()> {
            let word = || value.extract::<String>();
            match &*name {
                "precision" => options.precision = named(&name, &PRECISIONS, &word()?)?,
                "attitude" => options.attitude = named(&name, &ATTITUDES, &word()?)?,
                "motion" => options.motion = named(&name, &MOTIONS, &word()?)?,
                "pauses" => options.pauses = named(&name, &PAUSES, &word()?)?,
                "freedoms" => options.freedoms = value.extract()?,
                "tolerance" => options.tolerance = value.extract()?,
                "cold" => options.cold = value.extract()?,
                "peak_pressure" => options.peak_pressure = value.extract()?,
                "friction" => options.friction = value.extract()?,
                "given" => {
                    let given: BTreeMap<String, f64> = value.extract()?;
                    let given = given.iter().map(|(freedom, u)| format!("{freedom}={u:e}"));
                    options.given = given.collect();
                }
                _ => {
                    return Err(refused(format!(
                        "there is no option {name}: they are {NAMES}"
                    )));
                }
            }
            Ok(())
        };
        read().map_err(
            |error| match error.is_instance_of::<SpindleError>(given.py()) {
                true => error,
                false => refused(format!("{name}={value}: {}", error.value(given.py()))),
            },
        )?;
    }
    Ok(options)
}

/// A table: its columns, and whether they have words; lines of each record; numbers and words, line by line.
type PyTable<'py> = (
    Vec<(String, bool)>,
    usize,
    Bound<'py, PyArray2<f64>>,
    Vec<String>,
);

#[pyclass(frozen, module = "spindle_bearing._core")]
struct Spindle {
    file: SpindleFile,
    path: String,
    /// None of a bearing of the catalogue.
    text: Option<String>,
    /// Files of bearings, by their names in the text.
    designs: BTreeMap<String, String>,
}

#[pymethods]
impl Spindle {
    /// Reads a file, or a bearing of the catalogue.
    #[staticmethod]
    fn read(path: PathBuf) -> PyResult<Self> {
        match read_text(&path) {
            Ok((file, text)) => {
                let folder = path.parent().unwrap_or(Path::new(""));
                Self::of(file, text, |name| read_text(&folder.join(name)))
            }
            Err(_) => Ok(Self {
                file: SpindleFile::read(&path).map_err(refused_file)?,
                path: path.display().to_string(),
                text: None,
                designs: BTreeMap::new(),
            }),
        }
    }

    /// A spindle of its text, which names files of bearings in the current folder, or these.
    #[staticmethod]
    fn parse(
        path: String,
        text: String,
        designs: Option<BTreeMap<String, String>>,
    ) -> PyResult<Self> {
        Self::of(path, text, |name| match &designs {
            None => read_text(Path::new(name)),
            Some(designs) => match designs.get(name) {
                Some(text) => Ok((name.to_owned(), text.clone())),
                None => Err(DesignFileError {
                    file: name.to_owned(),
                    place: None,
                    message: "is not there".to_owned(),
                }),
            },
        })
    }

    /// What another process makes the same spindle of.
    fn state(&self) -> (&str, Option<&str>, BTreeMap<String, String>) {
        (&self.path, self.text.as_deref(), self.designs.clone())
    }

    #[getter]
    fn name(&self) -> &str {
        &self.file.name
    }

    #[getter]
    fn doubts(&self) -> Vec<String> {
        self.file.doubts.clone()
    }

    #[getter]
    fn noses(&self) -> BTreeMap<String, f64> {
        let noses = self.file.noses.iter();
        noses
            .map(|nose| (nose.name.clone(), nose.end.position))
            .collect()
    }

    #[getter]
    fn probes(&self) -> Vec<String> {
        self.file
            .probes
            .iter()
            .map(|probe| probe.name.clone())
            .collect()
    }

    #[getter]
    fn reference(&self) -> Option<f64> {
        self.file.heat.map(|heat| heat.reference)
    }

    /// Balls, position, pitch and ball diameter and facing of each row, m.
    #[getter]
    fn rows(&self) -> Vec<(usize, f64, f64, f64, &'static str)> {
        let rows = self.file.plan.rows.iter();
        let rows = rows.map(|row| {
            let design = &row.design;
            let (pitch, ball) = (design.pitch_diameter, design.ball_diameter);
            (row.balls, row.position, pitch, ball, row.facing.name())
        });
        rows.collect()
    }

    /// Both ends, outer and inner diameter of each section, m.
    #[getter]
    fn sections(&self) -> Vec<(f64, f64, f64, f64)> {
        let shaft = self.file.plan.shaft.iter();
        let sections = shaft.flat_map(|shaft| &shaft.sections);
        sections
            .map(|of| (of.from, of.to, of.outer, of.inner))
            .collect()
    }

    /// Tables of records, with these of their columns, and why records have no answer; noses are at `at`, if that is given.
    fn solve<'py>(
        &self,
        py: Python<'py>,
        rows: PyReadonlyArray2<'py, f64>,
        tables: Vec<(String, Vec<String>)>,
        given: &Bound<'py, PyDict>,
        how: (Option<f64>, usize, Option<Py<PyAny>>),
    ) -> PyResult<(Vec<PyTable<'py>>, Refusals)> {
        let (at, threads, progress) = how;
        let mut file = self.file.clone();
        if let Some(x) = at {
            file.noses = vec![Nose {
                name: "at".to_owned(),
                end: ShaftEnd::rigid(x),
            }];
        }
        let wanted = tables.iter().map(|(name, columns)| {
            let found = TABLES.iter().find(|one| one.0 == name);
            let names = TABLES.map(|one| one.0).join(", ");
            let found = found.ok_or_else(|| refused(format!("{name:?} is none of {names}")));
            Ok((found?.1, &columns[..]))
        });
        let wanted = wanted.collect::<PyResult<Vec<Wanted<'_>>>>()?;
        let (rows, options) = (self.records(&rows)?, options(given)?);
        let ask = Ask::of(&file, &options, threads, progress)?;
        let forms = forms(&ask.job(None), &wanted).map_err(refused)?;
        let arrays = forms.iter().map(|form| {
            // Of numpy, which has large pages for large arrays.
            PyArray2::zeros(py, [rows.len() * form.lines, form.width()], false)
        });
        let arrays: Vec<Bound<'py, PyArray2<f64>>> = arrays.collect();
        let mut filled: Vec<_> = arrays.iter().map(|array| array.readwrite()).collect();
        let numbers = filled.iter_mut().map(|array| array.as_slice_mut());
        let numbers = numbers.collect::<Result<Vec<_>, _>>()?;
        let (words, refusals) = detached(py, || ask.run(&rows, (&wanted, numbers), None))?;
        drop(filled);
        let tables = forms.into_iter().zip(arrays).zip(words);
        let tables = tables.map(|((form, array), words)| (form.columns, form.lines, array, words));
        Ok((tables.collect(), refusals))
    }

    /// Sums over a recording as JSON, and what was said of its times.
    fn life(
        &self,
        py: Python<'_>,
        rows: PyReadonlyArray2<'_, f64>,
        given: &Bound<'_, PyDict>,
        threads: usize,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<(String, Vec<String>)> {
        let (rows, options) = (self.records(&rows)?, options(given)?);
        let mut lifetime = Lifetime::default();
        let ask = Ask::of(&self.file, &options, threads, progress)?;
        let (rows, shared) = sharing_times(rows);
        detached(py, || {
            ask.run(&rows, (&[], Vec::new()), Some(&mut lifetime))
        })?;
        lifetime.finish();
        let notes = shared.into_iter().chain(lifetime.pauses()).collect();
        let json = serde_json::to_string(&lifetime).map_err(refused)?;
        Ok((json, notes))
    }

    /// Alarms over a recording as CSV, and what was said of it.
    fn limits(
        &self,
        py: Python<'_>,
        rows: PyReadonlyArray2<'_, f64>,
        board: &str,
        commission: Option<&str>,
    ) -> PyResult<(String, Vec<String>)> {
        let (rows, mut notes) = self.followed(&rows)?;
        let watch = self.watch(board, commission)?;
        let (mut text, stopped) = (Vec::new(), Mutex::new(None));
        let seen = detached(py, || {
            limits(&watch, stoppable(rows, &stopped), &mut text)
                .map_err(|error| stop(&stopped, error))
        })?;
        notes.extend(seen.ticks.into_iter().chain(seen.doubts));
        Ok((String::from_utf8_lossy(&text).into_owned(), notes))
    }

    /// Measured preload and gains over a recording as CSV, and findings.
    fn response(
        &self,
        py: Python<'_>,
        rows: PyReadonlyArray2<'_, f64>,
        commission: Option<&str>,
    ) -> PyResult<(String, Vec<String>)> {
        let (rows, mut notes) = self.followed(&rows)?;
        let watch = self.watch("f405", commission)?;
        let (mut text, stopped) = (String::new(), Mutex::new(None));
        let write = |lines: &str| {
            text.push_str(lines);
            Ok(())
        };
        let tell = |line: &str| notes.push(line.to_owned());
        let summary = detached(py, || {
            let rows = stoppable(rows, &stopped);
            response(&watch, rows, write, tell).map_err(|error| stop(&stopped, error))
        })?;
        if !summary.refused.is_empty() {
            notes.push(summary.to_string());
        }
        Ok((text, notes))
    }

    /// Changes of preloads and displacements as CSV; the state has the order of a recording's columns.
    fn sensitivity(&self, py: Python<'_>, state: [Option<f64>; OWN.len()]) -> PyResult<String> {
        detached(py, || sensitivity(&self.file, state).map_err(refused))
    }
}

impl Spindle {
    fn of(
        path: String,
        text: String,
        mut read: impl FnMut(&str) -> Result<(String, String), DesignFileError>,
    ) -> PyResult<Self> {
        let mut designs = BTreeMap::new();
        let mut files = |name: &str| {
            let (file, text) = read(name)?;
            designs.insert(name.to_owned(), text.clone());
            Ok((file, text))
        };
        let file = SpindleFile::of(&path, &text, &mut files).map_err(refused_file)?;
        Ok(Self {
            file,
            path,
            text: Some(text),
            designs,
        })
    }

    /// Records of an array, with temperatures if the spindle has `[heat]`.
    fn records(&self, rows: &PyReadonlyArray2<'_, f64>) -> PyResult<Vec<LoadRow>> {
        if rows.shape()[1] != WIDTH {
            return Err(refused(format!(
                "records have {} columns, and {WIDTH} are due",
                rows.shape()[1]
            )));
        }
        let rows = rows.as_array();
        let rows = rows.outer_iter().enumerate().map(|(i, row)| {
            let warm = self.file.heat.is_some();
            let of = |t: f64| celsius(t).map_err(|error| refused(format!("record {i}: {error}")));
            Ok(LoadRow {
                time_s: row[0],
                load: std::array::from_fn(|i| row[1 + i]),
                speed_rpm: row[6],
                temperatures: if warm {
                    Some([of(row[7])?, of(row[8])?])
                } else {
                    None
                },
                probes: std::array::from_fn(|i| Some(row[9 + i]).filter(|um| !um.is_nan())),
            })
        });
        rows.collect()
    }

    /// Records for a monitor, which share their times.
    fn followed(&self, rows: &PyReadonlyArray2<'_, f64>) -> PyResult<(Vec<LoadRow>, Vec<String>)> {
        let (rows, shared) = sharing_times(self.records(rows)?);
        Ok((rows, shared.into_iter().collect()))
    }

    fn watch(&self, board: &str, commission: Option<&str>) -> PyResult<Watch<'_>> {
        let commission = commission.map(window).transpose();
        Ok(Watch {
            file: &self.file,
            board: named("board", &BOARDS, board)?,
            commission: commission.map_err(|error| refused(format!("commission: {error}")))?,
            recording: "the recording",
        })
    }
}

/// What records are solved by.
struct Ask<'a> {
    file: &'a SpindleFile,
    options: &'a Options,
    balls: Balls,
    held: [Option<f64>; 5],
    pool: ThreadPool,
    /// Is called with the number of records that are solved.
    progress: Option<Py<PyAny>>,
}

impl<'a> Ask<'a> {
    fn of(
        file: &'a SpindleFile,
        options: &'a Options,
        threads: usize,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Self> {
        let (balls, held) = options.checked(file).map_err(refused)?;
        let pool = pool(threads)?;
        Ok(Self {
            file,
            options,
            balls,
            held,
            pool,
            progress,
        })
    }

    fn job<'j>(&'j self, lifetime: Option<&'j mut Lifetime>) -> Job<'j> {
        self.options.job(self.file, self.held, Vec::new(), lifetime)
    }

    /// Solves, until Ctrl-C or an exception of `progress`.
    fn run(
        &self,
        rows: &[LoadRow],
        tables: (&[Wanted<'_>], Vec<&mut [f64]>),
        lifetime: Option<&mut Lifetime>,
    ) -> PyResult<(Words, Refusals)> {
        let mut stopped = None;
        let go_on = |done: usize| {
            let looked = Python::attach(|py| {
                py.check_signals()?;
                let progress = self.progress.as_ref();
                progress.map_or(Ok(()), |progress| progress.call1(py, (done,)).map(drop))
            });
            stopped = looked.err();
            stopped.is_none()
        };
        let job = self.job(lifetime);
        let (plan, precision) = (&self.file.plan, self.options.precision);
        let solved = with_solver(plan, self.balls, precision, |solver| {
            fill(job, solver, rows, tables, (&self.pool, go_on))
        });
        let solved = solved.map_err(|error| refused_file(self.file.explain(&error)))?;
        match (solved.map_err(refused)?, stopped) {
            (_, Some(stopped)) => Err(stopped),
            (answered, None) => Ok(answered.unwrap_or_default()),
        }
    }
}

/// Threads of one call: those that a process had before a fork are not in its child.
fn pool(threads: usize) -> PyResult<ThreadPool> {
    let pool = ThreadPoolBuilder::new().num_threads(threads);
    pool.build().map_err(refused)
}

/// Records, until Ctrl-C.
fn stoppable(
    rows: Vec<LoadRow>,
    stopped: &Mutex<Option<PyErr>>,
) -> impl Iterator<Item = Result<LoadRow, LoadsError>> {
    rows.into_iter().enumerate().map(move |(i, row)| {
        if i % LOOK == 0
            && let Err(error) = Python::attach(|py| py.check_signals())
        {
            *stopped.lock().expect("one thread") = Some(error);
            return Err(LoadsError::Malformed("stopped".to_owned()));
        }
        Ok(row)
    })
}

/// Why a monitor has not come to the end.
fn stop(stopped: &Mutex<Option<PyErr>>, error: anyhow::Error) -> PyErr {
    let stopped = stopped.lock().expect("one thread").take();
    stopped.unwrap_or_else(|| refused(error))
}

/// Columns in another unit or by another name, with the column that is due and what to do.
#[pyfunction]
fn due_columns(names: Vec<String>) -> Vec<(String, String, String)> {
    let found = names.into_iter().filter_map(|name| {
        let (column, what) = due(&name)?;
        Some((name, column, what))
    });
    found.collect()
}

/// The catalogue as a table to read.
#[pyfunction]
fn bearings() -> String {
    catalogue::list()
}

/// A panic on a thread of a pool, for the test that it becomes an exception.
#[pyfunction]
fn panic(py: Python<'_>) -> PyResult<()> {
    let pool = pool(2)?;
    detached(py, || pool.install(|| panic!("as told")))
}

#[pymodule]
mod _core {
    #[pymodule_export]
    use super::{Spindle, bearings, due_columns, panic};
}

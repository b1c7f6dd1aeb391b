//! Input of a replay: the spindle, and its recording or table.

use crate::arguments::Args;
use crate::table::Axes;
use anyhow::{Result, bail, ensure};
use cli::fault::LoadsError;
use cli::quantities::LOADS;
use cli::recordings::{self, Wanted};
use indicatif::{ProgressBar, ProgressFinish, ProgressIterator, ProgressStyle};
use spindle_file::loads::LoadRow;
use spindle_file::spindles::SpindleFile;
use std::sync::{Arc, Mutex};

/// Rows to solve, and the recording that they come from.
pub type Input = (
    Box<dyn Iterator<Item = Result<LoadRow, LoadsError>> + Send>,
    Option<Arc<Mutex<recordings::Loads>>>,
);

impl Args {
    /// The spindle.
    pub fn file(&self) -> Result<SpindleFile> {
        let file = SpindleFile::read(self.design())?;
        for doubt in &file.doubts {
            eprintln!("replay: {doubt}");
        }
        Ok(file)
    }

    /// Quantities of the recording, with temperatures if the spindle has `heat`.
    pub fn wanted(&self, heat: bool) -> Result<Wanted> {
        let mut wanted = Wanted {
            every: self.every as usize,
            shares_times: self.summary.is_some() || self.limits || self.response.response.is_some(),
            ..Wanted::default()
        };
        wanted.needed[LOADS..].fill(heat);
        // A displacement that is given takes the place of the load of its freedom.
        for (needed, held) in wanted.needed[1..].iter_mut().zip(self.options().held()?) {
            *needed &= held.is_none();
        }
        Ok(wanted)
    }

    /// Rows of the recording or of the table.
    pub fn input(&self, file: &SpindleFile) -> Result<Input> {
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
        let mut wanted = self.wanted(reference.is_some())?;
        if self.limits || self.response.response.is_some() {
            wanted.probes = file.probes.iter().map(|probe| probe.name.clone()).collect();
        }
        let loads = recordings::read(path, &wanted)?;
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
        // `--response` leaves temperatures out of account that its spindle does not take.
        let is_followed = self.response.response.is_some();
        if reference.is_none() && loads.has_temperatures() && !is_followed {
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
}

/// Says how the recording was read.
///
/// # Errors
///
/// It has no row, though the rows that it has `were_solved`.
pub fn account(recording: &Mutex<recordings::Loads>, were_solved: bool) -> Result<()> {
    let recording = recording.lock().expect("a reader");
    for line in recording.account().lines() {
        eprintln!("replay: {line}");
    }
    let counts = recording.counts();
    ensure!(
        !were_solved || counts.read + counts.refused > 0,
        "{}: there is no row below the header",
        recording.file()
    );
    Ok(())
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

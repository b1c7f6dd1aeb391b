//! Outputs of a replay: results, files and the summary.

use crate::arguments::{Args, Form};
use anyhow::{Result, anyhow, bail};
use cli::lifetime::Lifetime;
use cli::output::{NewFile, place};
use cli::replay::{Output, ReplayError, Summary, Table};
use spindle_file::spindles::SpindleFile;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

impl Args {
    /// The files that options name.
    pub fn files(&self, file: &SpindleFile) -> Result<Vec<(Table, NewFile)>> {
        let mut taken: Vec<PathBuf> = (self.loads.iter().map(PathBuf::as_path))
            .chain([self.design()])
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

    /// Standard output, unless the summary takes it, and the files.
    pub fn outputs<'f>(&self, files: &'f mut [(Table, NewFile)]) -> Vec<Output<'f>> {
        let mut outputs: Vec<Output<'_>> = Vec::new();
        if self.summary.is_none() {
            outputs.push((Table::Results, Box::new(io::stdout())));
        }
        outputs.extend(files.iter_mut().map(|(table, file)| {
            let out: Box<dyn Write + Send> = Box::new(file);
            (*table, out)
        }));
        outputs
    }
}

/// Moves complete files to their places.
pub fn finish(files: Vec<(Table, NewFile)>, summary: &Summary) -> Result<()> {
    let complete = files.into_iter().filter(|_| summary.any_row_read());
    for (table, file) in complete {
        file.finish()
            .map_err(|error| ReplayError::Output(table, error))?;
    }
    Ok(())
}

/// Writes the summary of the whole recording.
pub fn summarise(mut lifetime: Lifetime, form: Form) -> Result<()> {
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
    Ok(())
}

pub fn unwritable(path: &Path, error: &io::Error) -> anyhow::Error {
    anyhow!("{}: cannot be written: {error}", path.display())
}

//! Files that appear when they are complete.

use std::ffi::OsString;
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// A file that is written beside its place: a full disk or an interruption leaves what was there before.
#[derive(Debug)]
pub struct NewFile {
    file: File,
    /// Where it is written, and where it belongs; none for a pipe or a device.
    move_to: Option<(PathBuf, PathBuf)>,
}

impl NewFile {
    /// Creates it.
    ///
    /// # Errors
    ///
    /// Errors of the operating system.
    pub fn create(path: &Path) -> io::Result<Self> {
        let is_file = fs::metadata(path).map_or(true, |found| found.is_file());
        let move_to = is_file.then(|| {
            // A link stays one.
            let path = path.canonicalize().unwrap_or_else(|_| path.to_owned());
            let mut beside = OsString::from(&path);
            beside.push(".part");
            (PathBuf::from(beside), path)
        });
        let place = move_to.as_ref().map_or(path, |(beside, _)| beside);
        Ok(Self {
            file: File::create(place)?,
            move_to,
        })
    }

    /// Puts it in its place.
    ///
    /// # Errors
    ///
    /// Errors of the operating system.
    pub fn finish(mut self) -> io::Result<()> {
        match self.move_to.take() {
            Some((beside, path)) => fs::rename(beside, path),
            None => Ok(()),
        }
    }

    /// Writes a whole file.
    ///
    /// # Errors
    ///
    /// Errors of the operating system.
    pub fn write_whole(path: &Path, bytes: &[u8]) -> io::Result<()> {
        let mut file = Self::create(path)?;
        file.write_all(bytes)?;
        file.finish()
    }
}

impl Write for NewFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.file.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

/// One that is not finished goes away.
impl Drop for NewFile {
    fn drop(&mut self) {
        if let Some((beside, _)) = &self.move_to {
            let _ = fs::remove_file(beside);
        }
    }
}

//! Files that appear when they are complete.

use std::ffi::OsString;
use std::fs::{self, File, OpenOptions};
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};
use tempfile::{Builder, NamedTempFile};

/// A file that is written beside its place: a full disk or an interruption leaves what was there before.
#[derive(Debug)]
pub enum NewFile {
    /// It has a name of its own until it is complete, and then this path. One that is not finished goes away.
    Beside(NamedTempFile, PathBuf),
    /// A pipe or a device.
    Stream(File),
}

impl NewFile {
    /// Creates it.
    ///
    /// # Errors
    ///
    /// A file in its place that may not be written; errors of the operating system.
    pub fn create(path: &Path) -> io::Result<Self> {
        let found = fs::metadata(path).ok();
        if let Some(found) = &found {
            if found.permissions().readonly() {
                return Err(ErrorKind::PermissionDenied.into());
            }
            let there = OpenOptions::new().write(true).open(path)?;
            if !found.is_file() {
                return Ok(Self::Stream(there));
            }
        }
        let path = place(path)?;
        let mut name = OsString::from(path.file_name().unwrap_or_default());
        name.push(".");
        let folder = path.parent().unwrap_or(Path::new("."));
        let mut beside = Builder::new();
        let beside = beside.prefix(&name).suffix(".part");
        // With the permissions of a new file, not those of a temporary one.
        let file = beside.make_in(folder, |path| File::create_new(path))?;
        Ok(Self::Beside(file, path))
    }

    /// Puts it in its place.
    ///
    /// # Errors
    ///
    /// Errors of the operating system.
    pub fn finish(self) -> io::Result<()> {
        match self {
            Self::Beside(file, path) => file.persist(path).map(drop).map_err(|e| e.error),
            Self::Stream(_) => Ok(()),
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
        match self {
            Self::Beside(file, _) => file.write(bytes),
            Self::Stream(file) => file.write(bytes),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        match self {
            Self::Beside(file, _) => file.flush(),
            Self::Stream(file) => file.flush(),
        }
    }
}

/// Where a file is or will be, without links: two paths of one file are one place.
///
/// # Errors
///
/// A folder that is not there.
pub fn place(path: &Path) -> io::Result<PathBuf> {
    path.canonicalize().or_else(|_| {
        let folder = path.parent().filter(|folder| *folder != Path::new(""));
        let folder = folder.unwrap_or(Path::new(".")).canonicalize()?;
        let name = path.file_name().ok_or(ErrorKind::InvalidInput)?;
        Ok(folder.join(name))
    })
}

//! Files that appear when they are complete.

use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::iterator::Signals;
use signal_hook::low_level::emulate_default_handler;
use std::collections::BTreeSet;
use std::ffi::OsString;
use std::fs::{self, File, OpenOptions};
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, Once, PoisonError};
use std::thread;
use tempfile::{Builder, NamedTempFile};

/// End of the name of a file until it is complete, and random letters and digits before it: as many as nobody types.
const PART: &str = ".part";
const RANDOM: usize = 12;

/// Files of this process that are not complete. A signal ends it without destructors.
static PARTS: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

/// Removes the files that are not complete when the process is told to end, and lets it end as it would.
fn remove_parts_at_end() -> io::Result<()> {
    let mut signals = Signals::new([SIGINT, SIGTERM])?;
    thread::spawn(move || {
        for signal in signals.forever() {
            // Held until the end, so that no other file begins.
            let parts = PARTS.lock().unwrap_or_else(PoisonError::into_inner);
            for part in parts.iter() {
                let _ = fs::remove_file(part);
            }
            let _ = emulate_default_handler(signal);
        }
    });
    Ok(())
}

/// Removes files that runs before have left beside `path`: the system unlocks those of a process that has ended.
fn remove_stale(folder: &Path, prefix: &str) {
    let files = fs::read_dir(folder).into_iter().flatten().flatten();
    for file in files {
        let name = file.file_name();
        let random = name.to_str().and_then(|name| {
            let rest = name.strip_prefix(prefix)?;
            rest.strip_suffix(PART)
        });
        let is_part = |random: &str| {
            random.len() == RANDOM && random.bytes().all(|byte| byte.is_ascii_alphanumeric())
        };
        if random.is_some_and(is_part)
            && File::open(file.path()).is_ok_and(|file| file.try_lock().is_ok())
        {
            let _ = fs::remove_file(file.path());
        }
    }
}

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
        static WATCH: Once = Once::new();
        let mut watched = Ok(());
        WATCH.call_once(|| watched = remove_parts_at_end());
        watched?;
        let path = place(path)?;
        let mut prefix = OsString::from(path.file_name().unwrap_or_default());
        prefix.push(".");
        let folder = path.parent().unwrap_or(Path::new("."));
        remove_stale(folder, &prefix.to_string_lossy());
        let mut beside = Builder::new();
        let beside = beside.prefix(&prefix).suffix(PART).rand_bytes(RANDOM);
        let mut parts = PARTS.lock().unwrap_or_else(PoisonError::into_inner);
        // With the permissions of a new file, not those of a temporary one.
        let file = beside.make_in(folder, |path| File::create_new(path))?;
        parts.insert(file.path().to_owned());
        // Where the file system has no locks, another run may take it for stale.
        let _ = file.as_file().try_lock();
        Ok(Self::Beside(file, path))
    }

    /// Puts it in its place.
    ///
    /// # Errors
    ///
    /// Errors of the operating system.
    pub fn finish(self) -> io::Result<()> {
        match self {
            Self::Beside(file, path) => {
                let mut parts = PARTS.lock().unwrap_or_else(PoisonError::into_inner);
                parts.remove(file.path());
                file.persist(path).map(drop).map_err(|e| e.error)
            }
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

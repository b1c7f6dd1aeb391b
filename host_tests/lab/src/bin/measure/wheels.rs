//! Unicorn, which emulates a core, and Capstone, which names its instructions: libraries in C, of their makers' builds for Python.
//!
//! Their Rust crates compile them for two minutes, with cmake and libclang. The wheels are there in seconds.

use anyhow::{Context, Result, anyhow, ensure};
use cli::cross::output;
use libloading::Library;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::LazyLock;

/// Packages of the Python Package Index. `machine.rs` and `decode.rs` call the functions of these versions.
///
/// Unicorn is licensed under the GPL, which is for `cargo reports` alone to heed; it is in no other program.
const PACKAGES: [&str; 2] = ["unicorn==2.1.4", "capstone==5.0.9"];

/// Prints where the libraries are, a line each.
const PLACES: &str = "
import glob, importlib.util, os
for name in ('unicorn', 'capstone'):
    folder = os.path.dirname(importlib.util.find_spec(name).origin)
    print(next(p for e in ('so*', '*dylib', 'dll') for p in sorted(glob.glob(f'{folder}/lib/*{name}*.{e}'))))
";

/// The libraries of [`PACKAGES`], installed into a folder of the project's `target` where they are not there yet.
#[derive(Debug)]
pub struct Wheels {
    /// The emulator.
    pub unicorn: Library,
    /// The disassembler.
    pub capstone: Library,
}

/// Both libraries.
pub fn open() -> Result<&'static Wheels> {
    static WHEELS: LazyLock<Result<Wheels>> = LazyLock::new(Wheels::open);
    WHEELS.as_ref().map_err(|error| anyhow!("{error:#}"))
}

impl Wheels {
    fn open() -> Result<Self> {
        let folder = cli::root().join("target/emulator");
        let python = folder.join(if cfg!(windows) {
            "Scripts/python"
        } else {
            "bin/python"
        });
        let places = || {
            let installed = output(Command::new(&python).args(["-m", "pip", "freeze"]))?;
            let all = PACKAGES.iter().all(|package| installed.contains(package));
            all.then(|| output(Command::new(&python).args(["-c", PLACES])))?
        };
        let places = match places() {
            Some(places) => places,
            None => {
                eprintln!("{} are fetched", PACKAGES.join(" and "));
                let mut make = Command::new("python3");
                run(make.args(["-m", "venv"]).arg(&folder))?;
                let mut install = Command::new(&python);
                run(install
                    .args(["-m", "pip", "install", "--quiet", "--only-binary=:all:"])
                    .args(PACKAGES))?;
                places().context("the wheels of the emulator have no libraries for this system")?
            }
        };
        let [unicorn, capstone]: [PathBuf; 2] = places
            .lines()
            .map(PathBuf::from)
            .collect::<Vec<_>>()
            .try_into()
            .map_err(|_| anyhow!("not two libraries: {places}"))?;
        #[allow(unsafe_code, reason = "both libraries do nothing when they are opened")]
        // SAFETY: as above.
        let open = |path: &Path| {
            unsafe { Library::new(path) }.with_context(|| format!("cannot open {}", path.display()))
        };
        Ok(Self {
            unicorn: open(&unicorn)?,
            capstone: open(&capstone)?,
        })
    }
}

/// Runs a command of the installation.
fn run(command: &mut Command) -> Result<()> {
    let done = command.status().is_ok_and(|status| status.success());
    ensure!(
        done,
        "{command:?} fails: install python3 with venv and pip (Debian and Ubuntu: python3-venv)"
    );
    Ok(())
}

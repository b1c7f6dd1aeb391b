//! Firmware built from a host program: the Rust target, and cargo's way to the ELF.

use anyhow::{Context, Result, bail, ensure};
use serde::Deserialize;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// The target that firmware is built for.
pub const TARGET: &str = "thumbv7em-none-eabihf";

/// The one kind of message from cargo that matters here.
#[derive(Deserialize)]
struct Message {
    executable: Option<PathBuf>,
    target: Option<MessageTarget>,
}

#[derive(Deserialize)]
struct MessageTarget {
    name: String,
}

/// The firmware of the STM32F405, in words for cargo.
pub const F405: &[&str] = &[
    "-p",
    "spindle_firmware",
    "--features",
    "f405",
    "--target",
    TARGET,
];

/// How a program is built.
#[derive(Debug, Clone, Copy, Default)]
pub struct Build<'b> {
    /// Its package and target, in words for cargo.
    pub package: &'b [&'b str],
    /// Its name.
    pub program: &'b str,
    /// Features besides those of its package.
    pub features: &'b str,
    /// Arguments for the linker.
    pub link: &'b [&'b str],
    /// Settings of the profile, in the place of the project's.
    pub profile: &'b [&'b str],
    /// Flags for the compiler, in the place of the project's.
    pub flags: &'b [&'b str],
    /// Environment variables; one with `None` must not be set.
    pub environment: &'b [(&'b str, Option<&'b str>)],
    /// Keep what cargo says for the error instead of showing it.
    pub quiet: bool,
}

impl Build<'_> {
    /// Builds the program of the project in `root` as it is shipped; returns where the ELF is.
    pub fn run(&self, root: &Path) -> Result<PathBuf> {
        let mut command = cargo();
        command.args(["rustc", "--release"]);
        command.args(self.package);
        command.args(["--features", self.features]);
        // Lines and functions are enough for a log, and for the proof: no variables.
        command.args(["--config", "profile.release.debug=1"]);
        for setting in self.profile {
            command.args(["--config", &format!("profile.release.{setting}")]);
        }
        command
            .args(["--bin", self.program])
            .arg("--message-format=json-render-diagnostics")
            .arg("--");
        for argument in self.link {
            command.arg("-C").arg(format!("link-arg={argument}"));
        }
        // These would replace the linker scripts of the project's configuration.
        command
            .env_remove("RUSTFLAGS")
            .env_remove("CARGO_ENCODED_RUSTFLAGS")
            // Host programs speak to the firmware as it is shipped.
            .env_remove("SPINDLE")
            .env("DEFMT_LOG", "info");
        if !self.flags.is_empty() {
            command.env("CARGO_ENCODED_RUSTFLAGS", self.flags.join("\x1f"));
        }
        for (name, value) in self.environment {
            match value {
                Some(value) => command.env(name, value),
                None => command.env_remove(name),
            };
        }
        executable(command.current_dir(root), self.program, self.quiet)
    }
}

/// Builds the firmware's twin on this machine, for the spindle of a file or for the shipped one; returns where it is.
pub fn twin(root: &Path, spindle: Option<&str>) -> Result<PathBuf> {
    let mut command = cargo();
    command
        .args(["build", "-p", "twin", "--bin", "twin"])
        // With the features of `cargo emulate`, whose crates it takes.
        .args([
            "-p",
            "cli",
            "--no-default-features",
            "--features",
            "cli/board",
        ])
        .arg("--message-format=json-render-diagnostics");
    match spindle {
        // Another profile makes another build: the shipped one is kept beside it.
        Some(file) => command
            .args(["--config", "profile.dev.package.spindle_firmware.debug=0"])
            .env("SPINDLE", file),
        None => command.env_remove("SPINDLE"),
    };
    executable(command.current_dir(root), "twin", false)
}

/// Runs cargo, and returns where the program is that it has built.
fn executable(command: &mut Command, program: &str, quiet: bool) -> Result<PathBuf> {
    if !quiet {
        command.stderr(Stdio::inherit());
    }
    let output = command
        .stdin(Stdio::null())
        .output()
        .context("cannot run cargo")?;
    if !output.status.success() {
        if quiet {
            bail!("{}", String::from_utf8_lossy(&output.stderr));
        }
        bail!("{program} does not build: cargo's messages are above");
    }
    output
        .stdout
        .split(|byte| *byte == b'\n')
        .filter_map(|line| serde_json::from_slice::<Message>(line).ok())
        .filter(|message| message.target.as_ref().is_some_and(|t| t.name == program))
        .find_map(|message| message.executable)
        .with_context(|| format!("cargo built {program} but does not say where it is"))
}

/// The cargo that this program was started by, or any.
pub fn cargo() -> Command {
    Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()))
}

/// Output of a command; `None` if it cannot be run, or fails.
pub fn output(command: &mut Command) -> Option<String> {
    let output = command
        .stdin(Stdio::null())
        .stderr(Stdio::null())
        .output()
        .ok()?;
    output
        .status
        .success()
        .then(|| String::from_utf8_lossy(&output.stdout).trim().to_owned())
}

/// Something that is not on this machine.
#[derive(Debug, Clone, Copy)]
pub struct Missing<'m> {
    /// Name of the missing thing.
    pub what: &'m str,
    /// Debian's packages that bring it.
    pub debian: &'m [&'m str],
    /// How to install it on other systems.
    pub elsewhere: &'m str,
}

/// Installs the packages that are its arguments, on Debian and Ubuntu. A package of the release may not get
/// along with a newer one that is there. It then comes from Debian's backports; the system's sources are left alone.
const INSTALL: &str = r#"
export DEBIAN_FRONTEND=noninteractive
install="install -q -y --no-remove --no-install-recommends"
apt-get -q update
apt-get $install "$@" && exit
. /etc/os-release
suite="$VERSION_CODENAME-backports"
sources=$(mktemp --suffix .list)
archive="s|^$VERSION_CODENAME \(.*\)|deb \1 $suite main|p"
apt-get indextargets --format '$(CODENAME) $(REPO_URI)' | sed -n "$archive" | head -n 1 >"$sources"
apt-get -q -o "Dir::Etc::SourceList=$sources" update
apt-get -o "Dir::Etc::SourceList=$sources" -t "$suite" $install "$@"
"#;

/// Installs missing packages where that takes no password: on Debian and Ubuntu, by root or with `sudo`.
///
/// # Errors
///
/// How to do it by hand.
pub fn install(missing: &Missing<'_>) -> Result<()> {
    let Missing {
        what,
        debian,
        elsewhere,
    } = missing;
    eprintln!("{what} is missing; to be installed, in a minute or two");
    let root = output(Command::new("id").arg("-u")).as_deref() == Some("0");
    let shell: &[&str] = if root { &["sh"] } else { &["sudo", "-n", "sh"] };
    let mut command = Command::new(shell[0]);
    command
        .args(&shell[1..])
        .args(["-c", INSTALL, "install"])
        .args(*debian)
        // Standard output is for results.
        .stdout(std::io::stderr());
    let installed = command.stdin(Stdio::null()).status();
    ensure!(
        installed.is_ok_and(|status| status.success()),
        "{what} is missing, and could not be installed. Install it, then try again. Debian and Ubuntu: sudo apt-get install {}; \
         {elsewhere}",
        debian.join(" ")
    );
    Ok(())
}

/// Adds the Rust target of the firmware, unless it is there.
pub fn add_target(root: &Path) -> Result<()> {
    let rustc = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let libraries = output(
        Command::new(rustc)
            .args(["--print", "target-libdir", "--target", TARGET])
            .current_dir(root),
    );
    if libraries.is_some_and(|path| Path::new(&path).is_dir()) {
        return Ok(());
    }
    let mut rustup = Command::new("rustup");
    rustup.args(["target", "add", TARGET]).current_dir(root);
    ensure!(
        rustup.status().is_ok_and(|status| status.success()),
        "Rust's target {TARGET} is missing, and could not be added; is there a network, and rustup?"
    );
    Ok(())
}

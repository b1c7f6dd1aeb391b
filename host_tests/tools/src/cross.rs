//! Firmware built from a host program: the Rust target, and cargo's way to the ELF.

use anyhow::{Context, Result, bail};
use serde::Deserialize;
use std::io::{self, IsTerminal};
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

/// Where a program for a microcontroller is from.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Origin {
    /// The firmware of the STM32F405, an example of the library.
    #[default]
    F405,
    /// The firmware of the STM32H743, a package beside the examples.
    H743,
    /// The images in `host_tests/probes`, for the core of the STM32F405.
    Probes,
}

/// How a program is built.
#[derive(Debug, Clone, Copy, Default)]
pub struct Build<'b> {
    /// Where it is from.
    pub origin: Origin,
    /// Its name.
    pub program: &'b str,
    /// Arguments for the linker.
    pub link: &'b [&'b str],
    /// Processor to compile for, where it is not the one of the project's configuration.
    pub processor: Option<&'b str>,
    /// Environment variables, and `None` for those that must not be set.
    pub environment: &'b [(&'b str, Option<&'b str>)],
    /// Keep what cargo says for the error instead of showing it.
    pub quiet: bool,
}

impl Build<'_> {
    /// Builds the program of the project in `root` as it is shipped; returns where the ELF is.
    pub fn run(&self, root: &Path) -> Result<PathBuf> {
        let mut command = cargo();
        command.args(["rustc", "--release"]);
        match self.origin {
            Origin::F405 => command
                .args(["-p", "spindle-bearing", "--features", "defmt,monitor"])
                .args(["--target", TARGET, "--example", self.program]),
            Origin::H743 => command
                .args(["--manifest-path", "examples/firmware_h743/Cargo.toml"])
                .args(["--config", "examples/firmware_h743/.cargo/config.toml"])
                .args(["--bin", self.program]),
            Origin::Probes => command
                .args(["-p", "probes", "--target", TARGET])
                .args(["--bin", self.program]),
        };
        command
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
            .env_remove("SPINDLE_SENSORS")
            .env("DEFMT_LOG", "info");
        if let Some(processor) = self.processor {
            // Takes the place of the configuration's flags, so that the linker scripts are named again.
            let flags = [
                "-Clink-arg=-Tlink.x",
                "-Clink-arg=-Tdefmt.x",
                &format!("-Ctarget-cpu={processor}"),
            ];
            command.env("CARGO_ENCODED_RUSTFLAGS", flags.join("\x1f"));
        }
        for (name, value) in self.environment {
            match value {
                Some(value) => command.env(name, value),
                None => command.env_remove(name),
            };
        }
        if !self.quiet {
            command.stderr(Stdio::inherit());
        }
        let output = command
            .current_dir(root)
            .stdin(Stdio::null())
            .output()
            .context("cannot run cargo")?;
        if !output.status.success() {
            if self.quiet {
                bail!("{}", String::from_utf8_lossy(&output.stderr));
            }
            bail!("the firmware does not build: cargo's messages are above");
        }
        output
            .stdout
            .split(|byte| *byte == b'\n')
            .filter_map(|line| serde_json::from_slice::<Message>(line).ok())
            .filter(|message| {
                message
                    .target
                    .as_ref()
                    .is_some_and(|t| t.name == self.program)
            })
            .find_map(|message| message.executable)
            .context("cargo built the firmware but does not say where it is")
    }
}

/// The cargo that this program was started by, or any.
pub fn cargo() -> Command {
    Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()))
}

/// What a command prints; `None` if it cannot be run, or fails.
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

/// Runs a command in the open, and fails if it does.
pub fn run(command: &mut Command) -> Result<()> {
    let name = format!("{command:?}").replace('"', "");
    let status = command
        .stdin(Stdio::null())
        .status()
        .with_context(|| format!("cannot run `{name}`"))?;
    if !status.success() {
        bail!("`{name}` ended with {status}");
    }
    Ok(())
}

/// Something that is not on this machine.
#[derive(Debug, Clone, Copy)]
pub struct Missing<'m> {
    /// What to call it.
    pub what: &'m str,
    /// Debian's packages that bring it.
    pub debian: &'m [&'m str],
    /// How to install it on other systems.
    pub elsewhere: &'m str,
}

/// Installs what is missing where that takes no password: on Debian and Ubuntu, by root or with `sudo`. Asks first
/// where somebody is there to answer.
///
/// # Errors
///
/// How to do it by hand.
pub fn install(missing: &Missing<'_>) -> Result<()> {
    let what = missing.what;
    let packages = missing.debian.join(" ");
    let by_hand = format!("apt-get update && apt-get install --no-remove {packages}");
    if !is_debian() {
        bail!(
            "{what} is missing. Install it, then try again. Debian and Ubuntu: {by_hand}; {}",
            missing.elsewhere
        );
    }
    let root = output(Command::new("id").arg("-u")).as_deref() == Some("0");
    if !root && output(Command::new("sudo").args(["-n", "true"])).is_none() {
        bail!(
            "{what} is missing, and installing it needs a password. Run this, then try again: \
             sudo sh -c '{by_hand}'"
        );
    }
    let apt = |arguments: &[&str]| {
        let mut command = if root {
            Command::new("env")
        } else {
            let mut command = Command::new("sudo");
            command.args(["-n", "env"]);
            command
        };
        command
            .args(["DEBIAN_FRONTEND=noninteractive", "apt-get", "-q"])
            .args(arguments)
            // Standard output is for results.
            .stdout(std::io::stderr());
        run(&mut command)
    };
    eprintln!("{what} is missing; to be installed, in a minute or two: {by_hand}");
    if !agreed("install it now?")? {
        bail!("{what} was not installed. To do it by hand: {by_hand}");
    }
    // One source that does not answer fails the update, though the package may well be there.
    if let Err(error) = apt(&["update"]) {
        eprintln!("warning: {error:#}");
    }
    let install = ["install", "-y", "--no-remove", "--no-install-recommends"];
    let Err(error) = apt(&[&install, missing.debian].concat()) else {
        return Ok(());
    };
    let failed = || format!("{what} could not be installed; try by hand: {by_hand}");
    // What is newer here than the release does not get along with the release's own packages.
    let Some(backports) = backports()? else {
        return Err(error).with_context(failed);
    };
    eprintln!("{error:#}; to be tried from {}", backports.suite);
    apt(&["-o", &backports.sources, "update"]).with_context(failed)?;
    let from = ["-o", &backports.sources, "-t", &backports.suite];
    apt(&[&from, &install[..], missing.debian].concat()).with_context(failed)
}

/// Debian's backports, as a further source for one call of apt.
struct Backports {
    suite: String,
    sources: String,
}

/// Those of this release; none where it is not Debian's. The system's own sources are left alone.
fn backports() -> Result<Option<Backports>> {
    let release = release();
    let named = |name: &str| {
        let mut pairs = release.lines().filter_map(|line| line.split_once('='));
        let (_, value) = pairs.find(|(key, _)| *key == name)?;
        Some(value.trim_matches('"').to_owned())
    };
    let (Some("debian"), Some(codename)) = (named("ID").as_deref(), named("VERSION_CODENAME"))
    else {
        return Ok(None);
    };
    // Where the release itself comes from.
    let format = "$(CODENAME) $(REPO_URI)";
    let sources = output(Command::new("apt-get").args(["indextargets", "--format", format]));
    let archive = sources.as_deref().and_then(|sources| {
        let mut pairs = sources.lines().filter_map(|line| line.split_once(' '));
        pairs.find_map(|(of, archive)| (of == codename).then_some(archive))
    });
    let Some(archive) = archive else {
        return Ok(None);
    };
    let suite = format!("{codename}-backports");
    let list = std::env::temp_dir().join(format!("{suite}.list"));
    let line = format!("deb {archive} {suite} main\n");
    std::fs::write(&list, line).with_context(|| format!("cannot write {}", list.display()))?;
    let sources = format!("Dir::Etc::SourceList={}", list.display());
    Ok(Some(Backports { suite, sources }))
}

/// Whether the person at the terminal agrees, if there is one. Who answers nothing does; a program that nobody
/// watches goes on.
fn agreed(question: &str) -> Result<bool> {
    if !(io::stdin().is_terminal() && io::stderr().is_terminal()) {
        return Ok(true);
    }
    eprint!("{question} [Y/n] ");
    let mut answer = String::new();
    let length = io::stdin().read_line(&mut answer)?;
    Ok(length > 0 && is_yes(&answer))
}

fn is_yes(answer: &str) -> bool {
    matches!(answer.trim().to_lowercase().as_str(), "" | "y" | "yes")
}

/// What the system says that it is.
fn release() -> String {
    std::fs::read_to_string("/etc/os-release").unwrap_or_default()
}

/// Debian, Ubuntu, and what is made from them.
fn is_debian() -> bool {
    release()
        .lines()
        .filter_map(|line| line.split_once('='))
        .filter(|(key, _)| matches!(*key, "ID" | "ID_LIKE"))
        .flat_map(|(_, value)| value.trim_matches('"').split_whitespace())
        .any(|id| matches!(id, "debian" | "ubuntu"))
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
    if output(Command::new("rustup").arg("--version")).is_none() {
        bail!(
            "Rust's target {TARGET} is missing, and there is no rustup to add it; install it the \
             way Rust was installed, then try again"
        );
    }
    eprintln!("installing Rust's target {TARGET}, in some seconds: rustup target add {TARGET}");
    run(Command::new("rustup")
        .args(["target", "add", TARGET])
        .current_dir(root))
    .context("the Rust target could not be added; is there a network?")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_yes_or_the_return_key_agrees() {
        for answer in ["\n", "y\n", "Yes\r\n"] {
            assert!(is_yes(answer), "{answer:?}");
        }
        for answer in ["n\n", "no\n", "what?\n"] {
            assert!(!is_yes(answer), "{answer:?}");
        }
    }
}

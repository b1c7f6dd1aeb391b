//! The firmware's twin on this machine, a program of its own: it has the constants of the same spindle's file.

use anyhow::{Context, Result, ensure};
use std::io::BufReader;
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use twin::{Ending, receive, send};

/// The program.
pub struct Twin(pub PathBuf);

impl Twin {
    /// Seals a firmware; returns where the sealed one is.
    pub fn seal(&self, elf: &Path) -> Result<PathBuf> {
        let mut command = Command::new(&self.0);
        command.arg("seal").arg(elf).stderr(Stdio::inherit());
        let output = command
            .output()
            .context("the firmware's twin does not run")?;
        ensure!(output.status.success(), "the firmware cannot be sealed");
        Ok(String::from_utf8(output.stdout)?.trim_end().into())
    }

    /// Starts its monitor.
    pub fn start(&self) -> Result<Running> {
        let mut command = Command::new(&self.0);
        command
            .arg("run")
            .stdin(Stdio::piped())
            .stdout(Stdio::piped());
        let mut child = command
            .spawn()
            .context("the firmware's twin does not run")?;
        let (input, output) = (child.stdin.take(), child.stdout.take());
        Ok(Running {
            input: input.context("the twin cannot be spoken to")?,
            output: BufReader::new(output.context("the twin cannot be heard")?),
            child,
        })
    }
}

/// A running twin.
pub struct Running {
    child: Child,
    input: ChildStdin,
    output: BufReader<ChildStdout>,
}

impl Running {
    fn hear(&mut self) -> Result<Vec<u8>> {
        let message = receive(&mut self.output)?;
        message.context("the firmware's twin has stopped, and says why above")
    }

    /// The bytes that the board must send after these.
    pub fn answer(&mut self, bytes: &[u8]) -> Result<Vec<u8>> {
        send(&mut self.input, bytes).context("the firmware's twin has stopped")?;
        self.hear()
    }

    /// Ends the run.
    pub fn end(mut self) -> Result<Ending> {
        drop(self.input);
        let message = receive(&mut self.output)?;
        self.child.wait()?;
        let message = message.context("the firmware's twin has no counters")?;
        Ok(postcard::from_bytes(&message)?)
    }
}

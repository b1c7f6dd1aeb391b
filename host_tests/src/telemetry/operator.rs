//! What an operator tells the board: alarms seen, and when to learn the baseline.

use super::state::State;
use anyhow::{Context, Result};
use spindle_bearing::monitor::Alarm;
use spindle_bearing::monitor::command::{self, Command};
use spindle_bearing::monitor::judgement::AlarmState;
use std::io::Write;

/// Sends commands.
#[derive(Debug)]
pub struct Operator<W> {
    to: W,
}

impl<W: Write> Operator<W> {
    /// One whose words go there.
    pub const fn new(to: W) -> Self {
        Self { to }
    }

    /// Sends a command.
    ///
    /// # Errors
    ///
    /// The port takes no bytes.
    pub fn send(&mut self, command: Command) -> Result<()> {
        self.to
            .write_all(&command::encode(command))
            .and_then(|()| self.to.flush())
            .context("cannot send a command to the board")
    }

    /// Acknowledges every alarm, whether it is known here or not: those that stand are acknowledged, and the
    /// board takes no notice of the rest.
    ///
    /// # Errors
    ///
    /// As for [`Operator::send`].
    pub fn acknowledge_all(&mut self) -> Result<()> {
        Alarm::ALL
            .into_iter()
            .try_for_each(|alarm| self.send(Command::Acknowledge(alarm)))
    }

    /// Acknowledges what the board has told of and nobody has acknowledged; returns how many that were.
    ///
    /// # Errors
    ///
    /// As for [`Operator::send`].
    pub fn acknowledge(&mut self, state: &State) -> Result<usize> {
        let mut count = 0;
        for at in state.standing() {
            if at.report.state != AlarmState::Acknowledged {
                self.send(Command::Acknowledge(at.report.alarm))?;
                count += 1;
            }
        }
        Ok(count)
    }

    /// Has the board learn the baseline from now on, or no longer.
    ///
    /// # Errors
    ///
    /// As for [`Operator::send`].
    pub fn learn(&mut self, on: bool) -> Result<()> {
        self.send(Command::Learn(on))
    }

    /// What a key of the view says; returns what was done, in a few words, `None` if the key means nothing.
    ///
    /// # Errors
    ///
    /// As for [`Operator::send`].
    pub fn press(&mut self, key: char, state: &State) -> Result<Option<String>> {
        Ok(match key {
            'a' => {
                let count = self.acknowledge(state)?;
                let plural = if count == 1 { "" } else { "s" };
                Some(format!("{count} alarm{plural} acknowledged"))
            }
            's' => {
                self.learn(true)?;
                Some("asked to learn the baseline".into())
            }
            'e' => {
                self.learn(false)?;
                Some("asked to end the learning".into())
            }
            _ => None,
        })
    }

    /// Where the words went.
    pub fn into_inner(self) -> W {
        self.to
    }
}

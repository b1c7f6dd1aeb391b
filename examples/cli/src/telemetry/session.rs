//! Bytes of a stream to lines of JSON, to the state of the spindle, and to an operator's next orders.

use super::source::{self, Chunks, PortOperator};
use crate::telemetry::decoder::Decoder;
use crate::telemetry::json;
use crate::telemetry::state::{State, words};
use anyhow::{Context, Result, bail};
use std::io::Write;

/// Damaged pieces after which a port without a single frame is given up.
const HOPELESS: u64 = 100;

/// A stream as far as it has come.
#[derive(Default)]
pub struct Session {
    /// State of the monitor by its frames.
    pub state: State,
    /// Who says something to the board, if there is one.
    pub operator: Option<PortOperator>,
    /// Where the lines of its events go, if anywhere.
    pub json: Option<Box<dyn Write>>,
    decoder: Decoder,
}

impl Session {
    /// A stream that has not begun.
    pub fn new(operator: Option<PortOperator>, json: Option<Box<dyn Write>>) -> Self {
        Self {
            operator,
            json,
            ..Self::default()
        }
    }

    /// Takes some bytes.
    ///
    /// # Errors
    ///
    /// A line cannot be written, or the port takes no bytes.
    pub fn take(&mut self, bytes: &[u8]) -> Result<()> {
        for byte in bytes {
            let Some(event) = self.decoder.push(*byte) else {
                continue;
            };
            if let Some(out) = &mut self.json {
                json::write(out, &event).context("cannot write a line of JSON")?;
            }
            self.state.note(&event, self.decoder.tally());
            if let Some(operator) = &mut self.operator {
                operator.follow(&self.state)?;
                if let Some(order) = operator.unanswered().last() {
                    let order = words(order);
                    self.state.said = Some(format!("the board does not answer: {order}"));
                }
            }
        }
        // Bytes without an end of a frame are no event.
        self.state.tally = self.decoder.tally();
        Ok(())
    }

    /// Reads to the end of the stream, which comes from a port with its rate or from elsewhere.
    ///
    /// # Errors
    ///
    /// The stream breaks off, [`Session::take`] fails, the board does not answer, or what a port says is no telemetry.
    pub fn read(&mut self, chunks: &Chunks, port: Option<(&str, u32)>) -> Result<()> {
        for chunk in chunks {
            self.take(&chunk.context("cannot read on")?)?;
            if let Some(order) = self.operator.iter().flat_map(|of| of.unanswered()).next() {
                let order = words(order);
                bail!(
                    "the board does not answer the order to {order}: is its RX on this port's TX?"
                );
            }
            if port.is_some() && self.state.tally.damaged >= HOPELESS {
                source::is_telemetry(&self.state.tally, port)?;
            }
        }
        Ok(())
    }
}

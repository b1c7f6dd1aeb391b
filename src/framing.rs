//! Messages on a wire: one message, one frame.
//!
//! | layer | by |
//! | --- | --- |
//! | message to bytes | postcard: integers as varints, floats as their four bytes |
//! | damage found | CRC-32 (ISO-HDLC) of those bytes, appended little-endian |
//! | frame boundaries | COBS, so that a zero byte occurs nowhere but after every frame |
//!
//! A receiver that joins in the middle, or loses bytes, is in step again after the next zero.
//! [`encode`] is the sender's side, [`FrameReader`] the receiver's; neither allocates. What travels is the
//! caller's: [`record`](crate::record) has the loads on their way in.

use cobs::{DecodeResult, DecoderState};
use core::fmt;
use core::marker::PhantomData;
use crc::{CRC_32_ISO_HDLC, Crc};
use heapless::Vec;
use serde::Serialize;
use serde::de::DeserializeOwned;

/// With a table of a kilobyte: bit by bit, the checksums of a tick with telemetry would take a tenth of the
/// period on a Cortex-M4F.
pub(crate) static CHECKSUM: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// Bytes of the checksum.
pub const CHECKSUM_LENGTH: usize = size_of::<u32>();

/// The byte between frames.
pub const DELIMITER: u8 = 0;

/// Length of the frame of a message of `length` bytes, which has its checksum in it; the frame its
/// delimiter.
pub const fn frame_length(length: usize) -> usize {
    cobs::max_encoding_length(length) + 1
}

/// The frame of a message, delimiter included; `None` if it is longer than `FRAME`
/// ([`frame_length`] of the longest message).
pub fn encode<T: Serialize, const FRAME: usize>(message: &T) -> Option<Vec<u8, FRAME>> {
    let mut frame = Vec::new();
    encode_into(message, &mut frame)?;
    Some(frame)
}

/// The same into the place of another frame; empty and `None` if it is too long.
pub fn encode_into<T: Serialize, const FRAME: usize>(
    message: &T,
    frame: &mut Vec<u8, FRAME>,
) -> Option<()> {
    let written = write(message, frame);
    if written.is_none() {
        frame.clear();
    }
    written
}

fn write<T: Serialize, const FRAME: usize>(message: &T, frame: &mut Vec<u8, FRAME>) -> Option<()> {
    let mut content = [0; FRAME];
    let written = postcard::to_slice(message, &mut content).ok()?.len();
    let sum = CHECKSUM.checksum(content.get(..written)?).to_le_bytes();
    let end = written.checked_add(CHECKSUM_LENGTH)?;
    content.get_mut(written..end)?.copy_from_slice(&sum);
    // What stands there from before is written over.
    frame.resize_default(FRAME).ok()?;
    let length = cobs::try_encode(content.get(..end)?, frame).ok()?;
    frame.truncate(length);
    frame.push(DELIMITER).ok()
}

/// Why a frame was skipped.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum FrameError {
    /// Longer than the reader holds: a delimiter was lost, or this is another protocol.
    TooLong,
    /// Too short to hold a message and its checksum.
    Truncated,
    /// Not a COBS encoding: bytes were lost or changed.
    Stuffing,
    /// The checksum says that bytes were changed.
    Checksum,
    /// Undamaged, but not a message of this kind: the sender speaks another version.
    Content,
}

impl FrameError {
    /// What went wrong, in a few words.
    pub const fn name(self) -> &'static str {
        match self {
            Self::TooLong => "frame too long",
            Self::Truncated => "frame truncated",
            Self::Stuffing => "frame stuffing broken",
            Self::Checksum => "frame checksum wrong",
            Self::Content => "frame holds another message",
        }
    }
}

impl fmt::Display for FrameError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl core::error::Error for FrameError {}

/// Takes a stream of messages `T` apart, byte by byte. `CAP` bounds the messages it accepts, checksum
/// included.
#[derive(Debug)]
pub struct FrameReader<T, const CAP: usize> {
    stuffing: DecoderState,
    message: Vec<u8, CAP>,
    overflow: bool,
    kind: PhantomData<fn() -> T>,
}

impl<T, const CAP: usize> Default for FrameReader<T, CAP> {
    fn default() -> Self {
        Self::new()
    }
}

impl<T, const CAP: usize> FrameReader<T, CAP> {
    /// A reader at the start of a frame.
    pub const fn new() -> Self {
        Self {
            stuffing: DecoderState::Idle,
            message: Vec::new(),
            overflow: false,
            kind: PhantomData,
        }
    }
}

impl<T: DeserializeOwned, const CAP: usize> FrameReader<T, CAP> {
    /// Takes the next byte; at the end of a frame returns the message, or why there is none. A
    /// frame of no bytes is no error: senders may separate with more than one delimiter.
    pub fn push(&mut self, byte: u8) -> Option<Result<T, FrameError>> {
        let result = match self.stuffing.feed(byte) {
            Ok(DecodeResult::NoData | DecodeResult::DataStart) => return None,
            Ok(DecodeResult::DataContinue(byte)) => {
                self.overflow |= self.message.push(byte).is_err();
                return None;
            }
            _ if self.overflow => Err(FrameError::TooLong),
            Ok(DecodeResult::DataComplete) => parse(&self.message),
            Err(_) => Err(FrameError::Stuffing),
        };
        self.message.clear();
        self.overflow = false;
        Some(result)
    }
}

/// The version `V` of a message, for its first field: another one is not read.
#[cfg(feature = "monitor")]
pub(crate) fn version<'de, D: serde::Deserializer<'de>, const V: u8>(
    deserializer: D,
) -> Result<u8, D::Error> {
    use serde::de::{Deserialize, Error, Unexpected};
    let version = u8::deserialize(deserializer)?;
    if version == V {
        return Ok(version);
    }
    Err(D::Error::invalid_value(
        Unexpected::Unsigned(version.into()),
        &"the version of this receiver",
    ))
}

/// What the bytes of a frame hold.
fn parse<T: DeserializeOwned>(message: &[u8]) -> Result<T, FrameError> {
    let (content, sum) = message
        .split_last_chunk::<CHECKSUM_LENGTH>()
        .ok_or(FrameError::Truncated)?;
    // Before the parser sees a byte, so that damage is called damage.
    if CHECKSUM.checksum(content) != u32::from_le_bytes(*sum) {
        return Err(FrameError::Checksum);
    }
    match postcard::take_from_bytes(content) {
        Ok((message, [])) => Ok(message),
        _ => Err(FrameError::Content),
    }
}

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

use core::fmt;
use core::marker::PhantomData;
use core::slice::IterMut;
use crc::{CRC_32_ISO_HDLC, Crc};
use heapless::Vec;
use postcard::ser_flavors::Flavor;
use serde::Serialize;
use serde::de::DeserializeOwned;

/// CRC-32 with a table of a kilobyte. Bit by bit, the checksums of a tick with telemetry would take a
/// tenth of the period on a Cortex-M4F.
pub(crate) static CHECKSUM: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// Bytes of the checksum.
pub const CHECKSUM_LENGTH: usize = size_of::<u32>();

/// The byte between frames.
pub const DELIMITER: u8 = 0;

/// Longest message: COBS breaks up a longer run of bytes that are not zero.
const LONGEST: usize = 254;

/// Length of the frame of a message of `length` bytes, which has its checksum in it; the frame its first code and its delimiter.
///
/// # Panics
///
/// If the message has more than 254 bytes, at compile time in a constant.
pub const fn frame_length(length: usize) -> usize {
    assert!(length <= LONGEST, "a message has at most 254 bytes");
    length + 2
}

/// The frame of a message, delimiter included; `None` if it is longer than `FRAME`
/// ([`frame_length`] of the longest message).
pub fn encode<T: Serialize, const FRAME: usize>(message: &T) -> Option<Vec<u8, FRAME>> {
    let mut frame = Vec::new();
    encode_into(message, &mut frame)?;
    Some(frame)
}

/// Frame of a message in the place of another one; empty and `None` if it is too long.
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
    const { assert!(FRAME <= frame_length(LONGEST)) };
    frame.clear();
    frame.resize_default(FRAME).ok()?;
    // Behind the place of the first code.
    let (_, content) = frame.split_first_mut()?;
    let written = postcard::serialize_with_flavor(message, Bytes::into(content)).ok()?;
    let (message, rest) = content.split_at_mut_checked(written)?;
    *rest.first_chunk_mut()? = CHECKSUM.checksum(message).to_le_bytes();
    let end = written.checked_add(CHECKSUM_LENGTH)?;
    frame.truncate(1 + end);
    stuff(frame);
    frame.push(DELIMITER).ok()
}

/// Where a message goes, byte by byte; in the end, how many. `postcard`'s own copies every varint by a call of `memcpy`.
struct Bytes<'a> {
    room: IterMut<'a, u8>,
    length: usize,
}

impl<'a> Bytes<'a> {
    fn into(room: &'a mut [u8]) -> Self {
        Self {
            length: room.len(),
            room: room.iter_mut(),
        }
    }
}

impl Flavor for Bytes<'_> {
    type Output = usize;

    #[inline(always)]
    fn try_push(&mut self, byte: u8) -> postcard::Result<()> {
        let to = self.room.next();
        *to.ok_or(postcard::Error::SerializeBufferFull)? = byte;
        Ok(())
    }

    fn finalize(self) -> postcard::Result<usize> {
        Ok(self.length.saturating_sub(self.room.len()))
    }
}

/// COBS of at most [`LONGEST`] bytes behind a zero: every zero becomes the way to the next one. `cobs` has it byte by
/// byte, which takes three times as long.
fn stuff(frame: &mut [u8]) {
    let mut way = 1_u8;
    for byte in frame.iter_mut().rev() {
        if *byte == 0 {
            *byte = way;
            way = 0;
        }
        way = way.wrapping_add(1);
    }
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
    /// Kind of damage, in a few words.
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
    message: [u8; CAP],
    length: usize,
    /// Bytes until the next code, which says how far it is to the code after it. `cobs` has such a reader, which takes three
    /// times as long for a byte.
    run: u8,
    begun: bool,
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
            message: [0; CAP],
            length: 0,
            run: 0,
            begun: false,
            overflow: false,
            kind: PhantomData,
        }
    }

    /// Takes a byte of a frame, which is no delimiter.
    #[inline(always)]
    fn take(&mut self, byte: u8) {
        let mut next = byte;
        if self.run > 0 {
            self.run -= 1;
        } else {
            self.run = byte - 1;
            if !core::mem::replace(&mut self.begun, true) {
                return;
            }
            next = 0;
        }
        if let Some(to) = self.message.get_mut(self.length) {
            *to = next;
            self.length += 1;
        } else {
            self.overflow = true;
        }
    }
}

impl<T: DeserializeOwned, const CAP: usize> FrameReader<T, CAP> {
    /// Takes the next byte; at the end of a frame returns the message, or why there is none. A
    /// frame of no bytes is no error: senders may separate with more than one delimiter.
    #[inline(always)]
    pub fn push(&mut self, byte: u8) -> Option<Result<T, FrameError>> {
        self.push_with(byte, decode)
    }
}

impl<T, const CAP: usize> FrameReader<T, CAP> {
    /// Takes the next byte like `push`, with another way to read the bytes of an undamaged message.
    #[inline(always)]
    pub(crate) fn push_with<R>(
        &mut self,
        byte: u8,
        read: impl FnOnce(&[u8]) -> Result<R, FrameError>,
    ) -> Option<Result<R, FrameError>> {
        if byte == DELIMITER {
            return self.end(read);
        }
        self.take(byte);
        None
    }

    #[inline(never)]
    fn end<R>(
        &mut self,
        read: impl FnOnce(&[u8]) -> Result<R, FrameError>,
    ) -> Option<Result<R, FrameError>> {
        let result = if !self.begun {
            return None;
        } else if self.overflow {
            Err(FrameError::TooLong)
        } else if self.run > 0 {
            Err(FrameError::Stuffing)
        } else {
            let message = self.message.get(..self.length).unwrap_or_default();
            undamaged(message).and_then(read)
        };
        self.length = 0;
        self.run = 0;
        (self.begun, self.overflow) = (false, false);
        Some(result)
    }
}

/// The version `V` of a message, for its first field: another one is not read.
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

/// The bytes of a message without their checksum, if that is right.
fn undamaged(message: &[u8]) -> Result<&[u8], FrameError> {
    let (content, sum) = message
        .split_last_chunk::<CHECKSUM_LENGTH>()
        .ok_or(FrameError::Truncated)?;
    // Before the parser sees a byte, so that damage is called damage.
    if CHECKSUM.checksum(content) != u32::from_le_bytes(*sum) {
        return Err(FrameError::Checksum);
    }
    Ok(content)
}

/// Message in undamaged bytes.
pub(crate) fn decode<T: DeserializeOwned>(content: &[u8]) -> Result<T, FrameError> {
    match postcard::take_from_bytes(content) {
        Ok((message, [])) => Ok(message),
        _ => Err(FrameError::Content),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::vec::Vec as List;

    proptest! {
        #[test]
        fn the_stuffing_is_that_of_cobs_and_comes_apart_again(
            content in proptest::collection::vec(prop_oneof![0..2_u8, any::<u8>()], 0..=LONGEST)
        ) {
            for content in [content.clone(), std::vec![7; content.len()]] {
                let mut frame = [&[0], &content[..]].concat();
                stuff(&mut frame);
                let mut expected = std::vec![0; cobs::max_encoding_length(content.len())];
                let length = cobs::encode(&content, &mut expected);
                prop_assert_eq!(&frame[..], &expected[..length]);
                let mut reader = FrameReader::<(), LONGEST>::new();
                frame.into_iter().for_each(|byte| reader.take(byte));
                prop_assert_eq!(reader.run, 0);
                prop_assert_eq!(&reader.message[..reader.length], &content[..]);
            }
        }

        /// No sender here has a code of 255: no message is that long.
        #[test]
        fn a_reader_takes_any_bytes_apart_as_cobs_does(
            bytes in proptest::collection::vec(prop_oneof![0..4_u8, 0..u8::MAX], 0..700)
        ) {
            let mut reader = FrameReader::<(), 600>::new();
            let mut state = cobs::DecoderState::Idle;
            let mut message = List::new();
            for byte in bytes {
                let ended = match state.feed(byte) {
                    Ok(cobs::DecodeResult::DataContinue(byte)) => {
                        message.push(byte);
                        None
                    }
                    Ok(cobs::DecodeResult::DataComplete) => Some(true),
                    Ok(_) => None,
                    Err(_) => Some(false),
                };
                if ended.is_none() && byte != DELIMITER {
                    reader.take(byte);
                    if message.len() <= 600 {
                        prop_assert_eq!(&reader.message[..reader.length], &message[..]);
                    }
                    continue;
                }
                let read = reader.push(byte);
                prop_assert_eq!(read.is_some(), ended.is_some());
                if message.len() <= 600 && let (Some(read), Some(whole)) = (read, ended) {
                    prop_assert_eq!(read == Err(FrameError::Stuffing), !whole);
                }
                message.clear();
            }
        }
    }
}

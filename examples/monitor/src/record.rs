//! Measured loads and speed as messages: one record, one frame of [`framing`].
//!
//! [`encode`] is the sender's side, [`FrameReader`] the receiver's; neither allocates.

use crate::framing::{self, CHECKSUM_LENGTH};
pub use crate::framing::{DELIMITER, FrameError};
use heapless::Vec;
use serde::{Deserialize, Serialize};

/// Length of the longest message that a record can become. It has two varints of at most five bytes, six
/// floats, and the checksum.
pub const MESSAGE_LENGTH: usize = 2 * 5 + 6 * size_of::<f32>() + CHECKSUM_LENGTH;

/// Length of the frame of the longest message, its delimiter included.
pub const FRAME_LENGTH: usize = framing::frame_length(MESSAGE_LENGTH);

/// Loads on the inner ring and speed of the shaft at one instant.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct LoadRecord {
    /// Counts records, so that a lost one shows.
    pub sequence: u32,
    /// Time since the start of the recording, ms. A whole number is the same on both sides of a
    /// wire, and wraps only after seven weeks.
    pub time_ms: u32,
    /// Axial load `Fx`, N.
    pub fx: f32,
    /// Radial load `Fy`, N.
    pub fy: f32,
    /// Radial load `Fz`, N.
    pub fz: f32,
    /// Tilting moment `My`, N m.
    pub my: f32,
    /// Tilting moment `Mz`, N m.
    pub mz: f32,
    /// Shaft speed, revolutions per minute.
    pub speed_rpm: f32,
}

impl LoadRecord {
    /// The five loads in the order of the solver: `Fx, Fy, Fz, My, Mz` (N, N m).
    pub const fn load(&self) -> [f32; 5] {
        [self.fx, self.fy, self.fz, self.my, self.mz]
    }

    /// Shaft speed `omega`, rad/s.
    pub const fn omega(&self) -> f32 {
        self.speed_rpm * (core::f32::consts::PI / 30.0)
    }
}

/// The frame of a record, delimiter included.
pub fn encode(record: &LoadRecord) -> Vec<u8, FRAME_LENGTH> {
    // The lengths above make room for every record. Should a later field break that, the frame is
    // empty, which the tests see.
    framing::encode(record).unwrap_or_default()
}

/// Takes a stream of load records apart, byte by byte. `CAP` bounds the messages it accepts, checksum
/// included; [`MESSAGE_LENGTH`] holds every record.
pub type FrameReader<const CAP: usize> = framing::FrameReader<LoadRecord, CAP>;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::framing::CHECKSUM;
    use proptest::prelude::*;
    use std::vec::Vec as Bytes;

    const RECORD: LoadRecord = LoadRecord {
        sequence: 7,
        time_ms: 70,
        fx: 250.0,
        fy: -12.5,
        fz: 0.0,
        my: 1.5e-3,
        mz: -0.0,
        speed_rpm: 12_000.0,
    };

    type Read = Result<LoadRecord, FrameError>;

    fn read<const CAP: usize>(bytes: &[u8]) -> Bytes<Read> {
        let mut reader = FrameReader::<CAP>::new();
        bytes.iter().filter_map(|b| reader.push(*b)).collect()
    }

    fn bits(r: &LoadRecord) -> (u32, u32, [u32; 6]) {
        let [a, b, c, d, e] = r.load().map(f32::to_bits);
        (
            r.sequence,
            r.time_ms,
            [a, b, c, d, e, r.speed_rpm.to_bits()],
        )
    }

    /// A frame of `content` with a right checksum.
    fn frame_of(content: &[u8]) -> Bytes<u8> {
        let mut payload = content.to_vec();
        payload.extend(CHECKSUM.checksum(content).to_le_bytes());
        let mut frame = std::vec![0; cobs::max_encoding_length(payload.len())];
        let length = cobs::encode(&payload, &mut frame);
        frame.truncate(length);
        frame.push(DELIMITER);
        frame
    }

    #[test]
    fn the_checksum_is_the_common_crc_32() {
        assert_eq!(CHECKSUM.checksum(b"123456789"), 0xcbf4_3926);
    }

    #[test]
    fn the_longest_record_fills_a_frame_exactly() {
        let all_ones = f32::from_bits(0x7f7f_ffff);
        let frame = encode(&LoadRecord {
            sequence: u32::MAX,
            time_ms: u32::MAX,
            fx: all_ones,
            fy: all_ones,
            fz: all_ones,
            my: all_ones,
            mz: all_ones,
            speed_rpm: all_ones,
        });
        assert_eq!(frame.len(), FRAME_LENGTH);
        assert_eq!(read::<MESSAGE_LENGTH>(&frame).len(), 1);
        assert_eq!(
            read::<{ MESSAGE_LENGTH - 1 }>(&frame),
            [Err(FrameError::TooLong)]
        );
    }

    #[test]
    fn every_kind_of_damage_has_its_name_and_the_stream_goes_on() {
        let good = encode(&RECORD);
        let mut flipped = good.clone();
        flipped[good.len() - 3] ^= 0x40;
        let mut record_and_more = Bytes::from([0; 64]);
        let length = postcard::to_slice(&RECORD, &mut record_and_more)
            .unwrap()
            .len();
        record_and_more.truncate(length + 1);
        for (bytes, error) in [
            (flipped.to_vec(), FrameError::Checksum),
            (Bytes::from([3, 1, 1, 0]), FrameError::Truncated),
            (Bytes::from([9, 1, 1, 0]), FrameError::Stuffing),
            (Bytes::from([1; 300]), FrameError::TooLong),
            (frame_of(&[1, 2, 3]), FrameError::Content),
            (frame_of(&record_and_more), FrameError::Content),
        ] {
            let mut stream = bytes.clone();
            if bytes.last() != Some(&DELIMITER) {
                stream.push(DELIMITER);
            }
            stream.extend(&good);
            assert_eq!(
                read::<MESSAGE_LENGTH>(&stream),
                [Err(error), Ok(RECORD)],
                "{bytes:?}"
            );
        }
    }

    prop_compose! {
        fn any_record()(
            (sequence, time_ms) in any::<(u32, u32)>(),
            [fx, fy, fz, my, mz, speed_rpm] in any::<[u32; 6]>(),
        ) -> LoadRecord {
            let of = f32::from_bits;
            LoadRecord {
                sequence,
                time_ms,
                fx: of(fx),
                fy: of(fy),
                fz: of(fz),
                my: of(my),
                mz: of(mz),
                speed_rpm: of(speed_rpm),
            }
        }
    }

    proptest! {
        #[test]
        fn a_stream_of_any_records_arrives_bit_for_bit(
            records in prop::collection::vec(any_record(), 0..8)
        ) {
            let stream: Bytes<u8> = records.iter().flat_map(encode).collect();
            let got: Bytes<_> = read::<MESSAGE_LENGTH>(&stream)
                .iter()
                .map(|r| bits(r.as_ref().unwrap()))
                .collect();
            prop_assert_eq!(got, records.iter().map(bits).collect::<Bytes<_>>());
        }
    }
}

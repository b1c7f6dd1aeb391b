//! A hundred thousand damaged streams into the host. What comes to the board is in `judge::laws::port`.

use super::telemetry::{cycle, decoded, frames_of};
use cli::random::Random;
use cli::telemetry::decoder::{Decoder, Event};
use cli::telemetry::state::State;
use rayon::prelude::*;

const STREAMS: u64 = 100_000;
/// Streams one after the other into the same host.
const IN_A_ROW: u64 = 1000;

/// Damages a piece of a stream as lines, gateways and strangers do.
fn mutate(random: &mut Random, bytes: &mut Vec<u8>) {
    for _ in 0..1 + random.below(4) {
        if bytes.is_empty() {
            return;
        }
        let (a, b) = (random.below(bytes.len()), random.below(bytes.len()));
        let (from, to) = (a.min(b), a.max(b));
        match random.below(7) {
            0 => bytes[from] ^= 1 << random.below(8),
            1 => bytes[from] = random.bits() as u8,
            2 => bytes.insert(from, random.bits() as u8),
            3 => drop(bytes.remove(from)),
            4 => drop(bytes.drain(from..to)),
            5 => {
                let again = bytes[from..to].to_vec();
                bytes.splice(to..to, again);
            }
            _ => bytes[from..to].reverse(),
        }
    }
}

/// Every frame that a host receives is one that the board has sent; counts do not go back.
#[test]
fn a_hundred_thousand_damaged_streams_to_the_host_make_up_no_frame() {
    let (_, bytes) = cycle(2.0);
    let (events, _) = decoded(&bytes);
    let sent = frames_of(&events);
    (0..STREAMS / IN_A_ROW).into_par_iter().for_each(|seed| {
        let mut random = Random::seeded(seed);
        let (mut decoder, mut state) = (Decoder::new(), State::default());
        for _ in 0..IN_A_ROW {
            let from = random.below(bytes.len() - 600);
            let mut piece = bytes[from..from + 600].to_vec();
            mutate(&mut random, &mut piece);
            let before = decoder.tally();
            for byte in piece {
                let Some(event) = decoder.push(byte) else {
                    continue;
                };
                state.note(&event, decoder.tally());
                if let Event::Frame { frame, .. } = &event {
                    assert_eq!(sent[frame.sequence as usize], frame);
                }
            }
            let after = decoder.tally();
            assert!(before.frames <= after.frames && before.damaged <= after.damaged);
            assert!(before.lost <= after.lost && before.restarts <= after.restarts);
        }
    });
}

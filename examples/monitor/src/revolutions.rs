//! Lengths of blocks that are whole revolutions.
//!
//! A harmonic of the revolution near a multiple of the sampling rate looks like a drift ([`is_aliased`]).

/// Harmonics of the revolution that runout has.
const HARMONICS: u16 = 4;
/// Most blocks in a second, and least pairs of a block.
const BLOCKS: f32 = 20.0;
const PAIRS: f32 = 50.0;
/// Longest block and longest step, s: below 30 rpm blocks do not count.
pub(crate) const LONGEST: f32 = 2.0;

/// Whether runout at this speed (rpm) cannot be told from drift at this sampling rate (Hz).
///
/// A harmonic of the revolution is within the inverse of the shortest block of a multiple of the rate.
pub fn is_aliased(rpm: f32, rate: f32) -> bool {
    let turns = rpm.abs() / 60.0 / rate;
    let near = 1.0 / shortest(rate);
    (1..=HARMONICS).any(|harmonic| {
        let turns = f32::from(harmonic) * turns;
        turns > 0.5 && off(turns).abs() < near
    })
}

/// Time of the longest block, us, of probes that are read once in a tick of this period, us.
pub(crate) const fn longest_us(period_us: u32) -> u32 {
    let rate = 1e6 / period_us as f32;
    // A block is a revolution at least, and longer by the shortest one at most.
    (1e6 * (LONGEST + shortest(rate) / rate)) as u32
}

/// Pairs of the shortest block.
pub(crate) const fn shortest(rate: f32) -> f32 {
    (rate / BLOCKS).max(PAIRS)
}

/// Distance from the nearest whole number.
fn off(x: f32) -> f32 {
    x - (x + 0.5) as u32 as f32
}

/// Pairs of the block that comes nearest to whole revolutions.
pub(crate) fn length(rpm: f32, rate: f32) -> Option<u32> {
    let turns = rpm.abs() / 60.0 / rate;
    let least = (1.0 / turns).max(shortest(rate));
    if least > LONGEST * rate || is_aliased(rpm, rate) {
        return None;
    }
    let (mut best, mut nearest) = (0, 1.0);
    for pairs in least as u32..=(least + shortest(rate)) as u32 {
        let off = off(pairs as f32 * turns).abs();
        if off < nearest {
            (best, nearest) = (pairs, off);
        }
    }
    Some(best)
}

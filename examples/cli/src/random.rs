//! Random numbers that are equal on every machine.

/// Pseudo-random numbers (splitmix64), the same everywhere and for ever.
#[derive(Debug, Clone)]
pub struct Random(u64);

impl Random {
    /// The sequence of a seed.
    pub const fn seeded(seed: u64) -> Self {
        Self(seed)
    }

    /// 64 random bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// Evenly distributed in `least..most`.
    pub fn between(&mut self, least: f64, most: f64) -> f64 {
        let unit = (self.bits() >> 11) as f64 / (1u64 << 53) as f64;
        least + (most - least) * unit
    }

    /// Positive number from `least` to `most`, with an evenly distributed logarithm.
    pub fn log_between(&mut self, least: f64, most: f64) -> f64 {
        self.between(least.ln(), most.ln()).exp()
    }

    /// A whole number below `count`, all equally likely.
    pub fn below(&mut self, count: usize) -> usize {
        self.between(0.0, count as f64) as usize
    }

    /// True with this probability.
    pub fn chance(&mut self, probability: f64) -> bool {
        self.between(0.0, 1.0) < probability
    }

    /// Zero with this probability, else evenly distributed.
    pub fn zero_or(&mut self, probability: f64, least: f64, most: f64) -> f64 {
        if self.chance(probability) {
            0.0
        } else {
            self.between(least, most)
        }
    }

    /// Damages a piece of a stream as lines, gateways and strangers do.
    pub fn damage(&mut self, bytes: &mut Vec<u8>) {
        for _ in 0..1 + self.below(4) {
            if bytes.is_empty() {
                return;
            }
            let (a, b) = (self.below(bytes.len()), self.below(bytes.len()));
            let (from, to) = (a.min(b), a.max(b));
            match self.below(7) {
                0 => bytes[from] ^= 1 << self.below(8),
                1 => bytes[from] = self.bits() as u8,
                2 => bytes.insert(from, self.bits() as u8),
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
}

//! Self-checks of a board: arithmetic by a solve whose answer is known, flash by a checksum.
//!
//! Two checksums are written into the image after it is linked ([`Seal`]). One is the image's, the other the answer's as
//! another machine has computed it with the same source. Both checks go step by step, so that they fit between ticks.

use crate::framing::CHECKSUM;
use crc::Digest;
use spindle_bearing::{
    RacewayControlFree, Settings, Speed, Spindle, SpindleSolution, SpindleSolver, Status,
};

/// A checksum of many pieces: CRC-32 (ISO-HDLC), as frames have it.
#[derive(Clone)]
pub struct Checksum(Digest<'static, u32>);

impl Default for Checksum {
    fn default() -> Self {
        Self(CHECKSUM.digest())
    }
}

impl Checksum {
    /// Takes the next piece.
    pub fn add(&mut self, bytes: &[u8]) {
        self.0.update(bytes);
    }

    /// Of all pieces.
    pub fn finish(self) -> u32 {
        self.0.finalize()
    }
}

/// Expected checksums of an image, in words that no checksum of the image covers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Seal {
    /// As the linker leaves it: nothing is known.
    Open,
    /// As it was flashed.
    Closed {
        /// Checksum of the image.
        image: u32,
        /// Checksum of [`KnownAnswer`].
        answer: u32,
    },
    /// Neither of them.
    Damaged,
}

/// The first word of an open seal.
const OPEN: u32 = 4;

impl Seal {
    /// Reads it.
    pub const fn read(words: [u32; 4]) -> Self {
        match words {
            [OPEN, 0, 0, 0] => Self::Open,
            [image, a, answer, b] if a == !image && b == !answer => Self::Closed { image, answer },
            _ => Self::Damaged,
        }
    }

    /// The words that say so.
    pub const fn words(self) -> [u32; 4] {
        match self {
            Self::Open => [OPEN, 0, 0, 0],
            Self::Closed { image, answer } => [image, !image, answer, !answer],
            Self::Damaged => [0; 4],
        }
    }
}

/// Parts of an image. Gaps that the linker leaves between them belong to nobody.
pub const PARTS: usize = 4;

/// Holds an image against its checksum, again and again.
#[derive(Clone)]
pub struct ImageCheck {
    parts: [&'static [u8]; PARTS],
    expected: u32,
    left: [&'static [u8]; PARTS],
    sum: Checksum,
}

impl ImageCheck {
    /// At the beginning.
    pub fn new(parts: [&'static [u8]; PARTS], expected: u32) -> Self {
        Self {
            parts,
            expected,
            left: parts,
            sum: Checksum::default(),
        }
    }

    /// Takes up to so many more bytes. At the end of the image, whether it is as expected; the next step begins
    /// again.
    pub fn step(&mut self, bytes: usize) -> Option<bool> {
        let Some(left) = self.left.iter_mut().find(|left| !left.is_empty()) else {
            let sum = core::mem::take(&mut self.sum).finish();
            self.left = self.parts;
            return Some(sum == self.expected);
        };
        let (now, later) = left.split_at_checked(bytes.max(1)).unwrap_or((left, &[]));
        self.sum.add(now);
        *left = later;
        None
    }

    /// Bytes of the image.
    pub fn length(&self) -> usize {
        self.parts.iter().map(|part| part.len()).sum()
    }
}

/// Two solves of the monitored spindle, from nothing and from the first one's answer, at fixed loads and speeds. Their
/// answers have the same bits on every machine.
#[derive(Debug)]
pub struct KnownAnswer<'m, const R: usize, const N: usize, const D: usize = 5, const E: usize = 0> {
    spindle: &'static Spindle<'static, f32, R, N, D, E>,
    solver: &'m mut SpindleSolver<f32, R, N, RacewayControlFree, D, E>,
    preload: f32,
    /// Solves that have ended, and steps of the one that has not.
    solves: u8,
    steps: u16,
    sum: u32,
}

/// Loads in parts of the preload (moments in its parts by a metre) and speeds (rad/s) of the solves.
/// Speeds are some hundred to some thousand rpm, and a lateral load is most of the preload.
const SOLVES: [([f32; 5], f32); 2] = [
    ([1.25, 0.25, -0.125, 0.0005, -0.001], 1024.0),
    ([1.3125, 0.375, -0.25, 0.0015, -0.0005], 1088.0),
];
/// Steps of a solve that ends, by far: from nothing, some ten.
const MOST_STEPS: u16 = 50;

impl<'m, const R: usize, const N: usize, const D: usize, const E: usize>
    KnownAnswer<'m, R, N, D, E>
{
    /// Of this spindle, under an axial load (N) that it carries in normal use, by a new solver.
    pub fn new(
        spindle: &'static Spindle<'static, f32, R, N, D, E>,
        preload: f32,
        solver: &'m mut SpindleSolver<f32, R, N, RacewayControlFree, D, E>,
    ) -> Self {
        Self {
            spindle,
            solver,
            preload,
            solves: 0,
            steps: 0,
            sum: 0,
        }
    }

    /// An iteration. At the end, the checksum of the answers; the next step begins again.
    pub fn step(&mut self) -> Option<u32> {
        let Some((parts, speed)) = SOLVES.get(usize::from(self.solves)) else {
            self.solver.reset();
            let sum = self.sum;
            (self.solves, self.steps, self.sum) = (0, 0, 0);
            return Some(sum);
        };
        let load = parts.map(|part| part * self.preload);
        let settings = Settings {
            max_iterations: 1,
            ..Settings::default()
        };
        let speed = Speed::rad_per_s(*speed);
        let mut sum = Checksum::default();
        sum.add(&self.sum.to_le_bytes());
        sum.add(&self.steps.to_le_bytes());
        self.steps += 1;
        match self.solver.solve(self.spindle, load, speed, &settings) {
            Err(Status::IterationLimit) if self.steps < MOST_STEPS => return None,
            Err(status) => sum.add(status.name().as_bytes()),
            Ok(solution) => add(&mut sum, &solution),
        }
        self.sum = sum.finish();
        (self.solves, self.steps) = (self.solves + 1, 0);
        None
    }
}

/// Adds the figures that a monitor uses of an answer.
fn add<const R: usize, const N: usize, const D: usize, const E: usize>(
    sum: &mut Checksum,
    of: &SpindleSolution<'_, f32, R, N, RacewayControlFree, D, E>,
) {
    let mut add = |x: f32| sum.add(&x.to_bits().to_le_bytes());
    let stiffness = of.stiffness();
    for x in of.displacement.iter().chain(stiffness.iter().flatten()) {
        add(*x);
    }
    for row in of.rows() {
        for ball in row.balls() {
            for x in [ball.q_i, ball.alpha_i, ball.q_o, ball.alpha_o] {
                add(x);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_seal_is_read_as_it_was_written_and_no_damage_makes_it_another() {
        for seal in [
            Seal::Open,
            Seal::Closed {
                image: 0,
                answer: 0,
            },
            Seal::Closed {
                image: 0xdead_beef,
                answer: u32::MAX,
            },
        ] {
            let words = seal.words();
            assert_eq!(Seal::read(words), seal);
            for bit in 0..128 {
                let mut damaged = words;
                damaged[bit / 32] ^= 1 << (bit % 32);
                let read = Seal::read(damaged);
                assert_eq!(read, Seal::Damaged, "{seal:?}, bit {bit}");
            }
        }
        assert_eq!(Seal::read(Seal::Damaged.words()), Seal::Damaged);
        // As flash is when it is blank.
        assert_eq!(Seal::read([u32::MAX; 4]), Seal::Damaged);
    }

    fn ends(check: &mut ImageCheck, bytes: usize) -> (bool, usize) {
        let mut steps = 0;
        loop {
            steps += 1;
            if let Some(passed) = check.step(bytes) {
                return (passed, steps);
            }
        }
    }

    static TEXT: [u8; 1000] = [0x5a; 1000];

    #[test]
    fn an_image_is_what_its_parts_are_together_whatever_the_steps() {
        let mut whole = Checksum::default();
        whole.add(&TEXT[..613]);
        whole.add(b"data");
        let expected = whole.finish();
        let parts = [&TEXT[..600], &TEXT[..13], &[], b"data"];
        for (bytes, most) in [(0, 618), (1, 618), (7, 90), (256, 6), (4096, 4)] {
            let mut check = ImageCheck::new(parts, expected);
            assert_eq!(check.length(), 617);
            // Again and again.
            for _ in 0..3 {
                let (passed, steps) = ends(&mut check, bytes);
                assert!(passed && steps <= most, "{bytes}: {steps}");
            }
        }
    }

    #[test]
    fn an_image_with_a_wrong_bit_fails() {
        let mut sum = Checksum::default();
        sum.add(&TEXT);
        let mut check = ImageCheck::new([&TEXT, &[], &[], &[]], sum.finish());
        assert!(ends(&mut check, 64).0);
        for bit in [0, 4001, 7999] {
            let mut damaged = TEXT.to_vec();
            damaged[bit / 8] ^= 1 << (bit % 8);
            check.left[0] = damaged.leak();
            assert!(!ends(&mut check, 64).0);
            assert!(ends(&mut check, 64).0);
        }
    }
}

//! The preload of a spindle by the closure of its rows: the law by which an estimate becomes newtons, and a growth that the solves take.

use core::f32::consts::{LN_2, LOG2_E};

/// Closures of a law.
pub const NODES: usize = 9;
/// The two thirds power of the preload over the file's: the least one of a law, and its steps. Closure is almost a straight line over it.
pub const POWERS: [f32; 2] = [0.1, 0.3625];

/// How the rows of a spindle press each other.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum PreloadBy {
    /// Rows that are clamped, with a bit for each. A closure of all of them, besides that of the file, gives the preload: m, for the two
    /// thirds power `0.1 + 0.3625 k` of the preload over the file's.
    Closure {
        /// Bit `i` is set where row `i` is clamped.
        rows: u8,
        /// The closures, which rise.
        closures: [f32; NODES],
        /// Closure that a K on the inner, and on the outer side, has the effect of, m.
        heat: [f32; 2],
    },
    /// A spring.
    Spring,
}

/// The preload of a spindle at rest, cold, without a load.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PreloadLaw {
    /// Preload of the spindle's file, N.
    pub force: f32,
    /// What gives it.
    pub by: PreloadBy,
}

impl PreloadLaw {
    /// Preload, N, of its ln over the file's.
    pub fn newtons(&self, ln: f32) -> f32 {
        self.force * exp(ln)
    }

    /// The nearest ln preload over the file's that the law has.
    pub fn limited(&self, ln: f32) -> f32 {
        // 1.5 ln of the least and of the largest power.
        ln.clamp(-3.45, 1.64)
    }

    /// Whether the solves can be told another preload than the file's: a closure, as a growth of the rows. A spring's force is theirs.
    pub(crate) const fn is_told(&self) -> bool {
        matches!(self.by, PreloadBy::Closure { .. })
    }

    /// Closure besides the file's, m, and its slope by ln preload; 0 of a spring.
    pub fn closure(&self, ln: f32) -> [f32; 2] {
        let PreloadBy::Closure { closures, .. } = &self.by else {
            return [0.0; 2];
        };
        let power = exp(2.0 / 3.0 * self.limited(ln));
        let place = (power - POWERS[0]) / POWERS[1];
        let node = (place as usize).clamp(1, NODES - 3);
        let x = place - node as f32;
        // The cubic through four nodes, all of which are there; an index would be checked.
        let mut nodes = closures.iter().skip(node - 1).copied();
        let [a, b, c, d] = core::array::from_fn(|_| nodes.next().unwrap_or_default());
        let second = 0.5 * (a - 2.0 * b + c);
        let third = (d - a + 3.0 * (b - c)) / 6.0;
        let first = c - b - second - third;
        let closure = b + x * (first + x * (second + x * third));
        let slope = first + x * (2.0 * second + 3.0 * x * third);
        [closure, slope / POWERS[1] * (2.0 / 3.0) * power]
    }

    /// Change of ln preload by a K of the side that changes it more.
    pub fn per_kelvin(&self, ln: f32) -> f32 {
        let PreloadBy::Closure { heat, .. } = self.by else {
            return 0.0;
        };
        let [_, slope] = self.closure(ln);
        heat[0].abs().max(heat[1].abs()) / slope
    }

    /// Whether its force is positive, and its closures are numbers that rise.
    pub(crate) const fn is_sound(&self) -> bool {
        let mut is_sound = self.force > 0.0 && self.force.is_finite();
        if let PreloadBy::Closure { closures, heat, .. } = &self.by {
            is_sound &= heat[0].is_finite() && heat[1].is_finite();
            let mut i = 0;
            while i < NODES {
                is_sound &= closures[i].is_finite() && (i == 0 || closures[i] > closures[i - 1]);
                i += 1;
            }
        }
        is_sound
    }

    /// Whether a row is clamped.
    pub const fn clamps(&self, row: usize) -> bool {
        match self.by {
            PreloadBy::Closure { rows, .. } => row < 8 && rows >> row & 1 == 1,
            PreloadBy::Spring => false,
        }
    }
}

/// e to this power, to 1e-6 of it; within powers of two that are numbers. `libm` has it in 1.6 kB more.
// Once, for six places.
#[inline(never)]
pub(crate) fn exp(x: f32) -> f32 {
    let turns = (x * LOG2_E).clamp(-126.0, 126.0);
    let whole = (turns + if turns < 0.0 { -0.5 } else { 0.5 }) as i32;
    // Half a power of two at most.
    let rest = (turns - whole as f32) * LN_2;
    let mut sum = 1.0;
    for n in [6.0, 5.0, 4.0, 3.0, 2.0, 1.0] {
        sum = 1.0 + sum * rest / n;
    }
    sum * f32::from_bits(((127 + whole) as u32) << 23)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_of_e_are_those_of_the_library() {
        for i in -800..=800 {
            let x = 0.1 * i as f32;
            assert!((exp(x) / x.exp() - 1.0).abs() < 1e-5, "{x}");
        }
        assert!(exp(1e9).is_finite() && exp(-1e9) > 0.0);
    }

    /// Closures of a force's power of two thirds, which Hertz's contacts have.
    #[test]
    fn a_law_gives_the_closure_and_its_slope() {
        let closures = core::array::from_fn(|i| 1e-5 * (POWERS[0] + POWERS[1] * i as f32 - 1.0));
        let law = PreloadLaw {
            force: 250.0,
            by: PreloadBy::Closure {
                rows: 0b101,
                closures,
                heat: [1e-7, -2e-7],
            },
        };
        assert!(law.is_sound() && law.clamps(0) && !law.clamps(1) && law.clamps(2));
        for i in -30..=15 {
            let ln = 0.1 * i as f32;
            let power = (2.0 / 3.0 * ln).exp();
            let [closure, slope] = law.closure(ln);
            assert!((closure - 1e-5 * (power - 1.0)).abs() < 1e-9, "{ln}");
            assert!((slope - 1e-5 * power / 1.5).abs() < 1e-9, "{ln}");
            assert!((law.per_kelvin(ln) * slope - 2e-7).abs() < 1e-12);
        }
        assert_eq!(law.closure(9.0), law.closure(1.64));
        assert!((law.newtons(0.5) - 412.18).abs() < 0.01);
    }
}

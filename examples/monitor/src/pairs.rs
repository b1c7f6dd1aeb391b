//! Pairs of measured and computed displacement in every tick, though a solve takes some: runout averages out over all ticks of a
//! revolution alone.
//!
//! Ticks wait until the first solve ends whose sample is not older. The displacement `p` under the loads `F` of a tick follows from
//! this solve's loads `F_s` and displacement `p_s`:
//!
//! ```text
//! p(F) = p_s + c (F - F_s)        c += (dp - c dF) dF / (dF^2 + least^2)
//! ```
//!
//! The changes `dp` and `dF` are those from the solve before. This is Broyden's update: between both loads, `p` is the chord of
//! both equilibria.

use crate::blocks::{Blocks, forces};
use crate::estimator::{Step, dot};
use heapless::Deque;

/// Ticks that wait: two solves of four ticks. Beyond, a tick has nothing computed.
const MOST: usize = 8;
/// Changes of the loads below this one, N, hardly count: their displacement has the solver's error.
const LEAST: f32 = 3.0;

/// Displacements (um) at `P` probes over the loads (N, N m), by the newest solves.
#[derive(Debug, Clone)]
struct Secant<const P: usize> {
    /// The newest solve: its loads, moments as forces, and displacements.
    newest: Option<([f32; 5], [f32; P])>,
    compliance: [[f32; 5]; P],
}

impl<const P: usize> Default for Secant<P> {
    fn default() -> Self {
        Self {
            newest: None,
            compliance: [[0.0; 5]; P],
        }
    }
}

impl<const P: usize> Secant<P> {
    /// Takes the displacements that a solve gives for its loads. Numbers that are not finite are left out.
    fn take(&mut self, load: &[f32; 5], computed: [f32; P]) {
        let load = forces(load);
        let change = self.newest.map(|(last, _)| difference(&load, &last));
        let square = change.map_or(0.0, |change| dot(&change, &change));
        if !square.is_finite() || !computed.iter().all(|p| p.is_finite()) {
            return;
        }
        if let Some(((_, before), change)) = self.newest.zip(change) {
            let gain = 1.0 / (square + LEAST * LEAST);
            for ((c, p), before) in self.compliance.iter_mut().zip(computed).zip(before) {
                let residual = gain * (p - before - dot(c, &change));
                for (c, change) in c.iter_mut().zip(change) {
                    *c += residual * change;
                }
            }
        }
        self.newest = Some((load, computed));
    }

    /// Displacements under these loads; none before the first solve.
    fn at(&self, load: &[f32; 5]) -> Option<[f32; P]> {
        let (last, mut displacement) = self.newest?;
        let change = difference(&forces(load), &last);
        for (p, c) in displacement.iter_mut().zip(&self.compliance) {
            *p += dot(c, &change);
        }
        Some(displacement)
    }
}

/// Readings of a tick. They are not numbers where they are missing or not believed.
#[derive(Debug, Clone)]
pub struct TickReadings<const P: usize> {
    /// Speed, rpm.
    pub rpm: f32,
    /// Loads, N, N m.
    pub load: [f32; 5],
    /// Measured displacements, um.
    pub measured: [f32; P],
}

/// Ticks that wait for a solve, and what the newest solves say.
#[derive(Debug, Clone)]
pub struct Pairs<const P: usize> {
    secant: Secant<P>,
    /// The tick of the sample that was solved last.
    solved: Option<u64>,
    waiting: Deque<TickReadings<P>, MOST>,
}

impl<const P: usize> Default for Pairs<P> {
    fn default() -> Self {
        Self {
            secant: Secant::default(),
            solved: None,
            waiting: Deque::new(),
        }
    }
}

impl<const P: usize> Pairs<P> {
    /// Takes the displacements (um) that a solve gives for the loads of a tick.
    pub fn solved(&mut self, tick: u64, load: &[f32; 5], computed: [f32; P]) {
        self.secant.take(load, computed);
        self.solved = Some(tick);
    }

    /// Forgets what the solves have said: they have learnt another preload. Ticks that wait have nothing computed.
    pub fn forget(&mut self) {
        (self.secant, self.solved) = (Secant::default(), None);
        self.waiting.clear();
    }

    /// Takes the readings of a tick, the one after the last. Hands the pairs of ticks up to the solved one on to the blocks; whether
    /// one of them was the last of a block, and the load step that is complete then.
    pub fn tick(
        &mut self,
        tick: u64,
        readings: TickReadings<P>,
        blocks: &mut Blocks<P>,
    ) -> Option<Option<Step<P>>> {
        let mut ended = None;
        if let Err(readings) = self.waiting.push_back(readings) {
            if let Some(TickReadings { rpm, measured, .. }) = self.waiting.pop_front() {
                ended = blocks.tick(rpm, None, &measured);
            }
            let _ = self.waiting.push_back(readings);
        }
        let since = self
            .solved
            .map_or(u64::MAX, |solved| tick.saturating_sub(solved));
        while self.waiting.len() as u64 > since
            && let Some(ready) = self.waiting.pop_front()
        {
            let computed = self.secant.at(&ready.load);
            let ended_now = blocks.tick(
                ready.rpm,
                computed.map(|u| (&ready.load, u)),
                &ready.measured,
            );
            ended = ended_now.or(ended);
        }
        ended
    }
}

fn difference(a: &[f32; 5], b: &[f32; 5]) -> [f32; 5] {
    core::array::from_fn(|i| a[i] - b[i])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::blocks::Look;
    use crate::settings::{ProbeSettings, ResponseSettings};

    static SETTINGS: ResponseSettings<1> = ResponseSettings {
        probes: [ProbeSettings {
            position: -0.01,
            direction: [0.0, 1.0, 0.0],
            accuracy: 0.2,
            compliance: 0.05,
        }],
        preload: None,
        heat: 0.0,
        load_error: 0.02,
        gain: 0.1,
    };

    #[test]
    fn between_solves_displacements_follow_the_loads() {
        let mut secant = Secant::<1>::default();
        assert_eq!(secant.at(&[0.0; 5]), None);
        let cut = |share: f32| [-90.0, 270.0, 135.0, 6.75, -13.5].map(|load| share * load);
        let truth = |share: f32| 10.0 * share + 2.0 * share * share;
        for share in [0.0, 0.9, 1.1] {
            secant.take(&cut(share), [truth(share)]);
        }
        let [p] = secant.at(&cut(1.0)).unwrap();
        assert!((p - truth(1.0)).abs() < 0.03, "{p}");
    }

    #[test]
    fn numbers_that_are_none_leave_it_as_it_is() {
        let mut secant = Secant::<1>::default();
        secant.take(&[0.0; 5], [1.0]);
        secant.take(&[f32::MAX; 5], [2.0]);
        secant.take(&[1.0; 5], [f32::NAN]);
        assert_eq!(secant.at(&[9.0; 5]), Some([1.0]));
    }

    #[test]
    fn each_tick_has_its_pair_once_if_solves_take_up_to_four_ticks() {
        for (ticks, share) in [(1, 1.0), (4, 1.0), (20, 0.0)] {
            let mut pairs = Pairs::<1>::default();
            let mut blocks = Blocks::new(&SETTINGS, 1000.0);
            let mut steps = 0.0;
            let mut begun: Option<(u64, [f32; 5])> = None;
            for tick in 0..4000_u64 {
                let cut = if tick % 1000 < 500 { 270.0 } else { 0.0 };
                let load = [0.0, cut, 0.0, 0.0, 0.0];
                let begins = tick % ticks == 0;
                if begins && let Some((tick, load)) = begun.replace((tick, load)) {
                    pairs.solved(tick, &load, [0.05 * load[1]]);
                }
                let readings = TickReadings {
                    rpm: 12_000.0,
                    load,
                    measured: [0.06 * cut],
                };
                if tick % 10 == 0 {
                    blocks.look(&[Look::default()]);
                }
                let ended = pairs.tick(tick, readings, &mut blocks);
                steps += f32::from(u8::from(ended.flatten().is_some()));
            }
            assert_eq!(steps, 7.0 * share, "{ticks} ticks a solve");
        }
    }

    /// A hundredth of all ticks is under a blow of coolant, besides runout.
    #[test]
    fn blocks_that_coolant_hits_bring_no_step() {
        let mut pairs = Pairs::<1>::default();
        let mut blocks = Blocks::new(&SETTINGS, 1000.0);
        let (mut steps, mut hit) = (0, 0);
        for tick in 0..20_000_u64 {
            let cut = if tick % 1000 < 500 { 270.0 } else { 0.0 };
            let load = [0.0, cut, 0.0, 0.0, 0.0];
            let blow = if tick % 1930 > 1900 { 40.0 } else { 0.0 };
            let runout = 3.0 * (core::f32::consts::TAU * 0.2 * (tick % 5) as f32).sin();
            pairs.solved(tick, &load, [0.05 * cut]);
            let readings = TickReadings {
                rpm: 12_000.0,
                load,
                measured: [0.06 * cut + runout + blow],
            };
            if tick % 10 == 0 {
                blocks.look(&[Look::default()]);
            }
            if let Some(step) = pairs.tick(tick, readings, &mut blocks).flatten() {
                let [Some(motion)] = step.motions else {
                    continue;
                };
                steps += 1;
                hit += u32::from((motion.measured / motion.computed - 1.2).abs() > 0.01);
            }
        }
        assert!(steps > 25 && hit == 0, "{steps}, {hit} of them hit");
    }
}

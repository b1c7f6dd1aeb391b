//! Cases of the scenes, and their solves on any machine, each timed and hashed.

use crate::{Answer, Question, Scene};
use core::hint::black_box;
use spindle_bearing::{Bearing, Design, Real, Settings};

/// Balls of a row.
pub const BALLS: usize = 16;

/// Cases.
pub const CASES: usize = 100;

/// Load (N, N m) and speed (rad/s), numbers of single precision.
pub type State = ([f64; 5], f64);

/// Starts of a solve: from nothing, and from the solution a tick before.
pub const STARTS: [&str; 2] = ["cold", "warm"];

/// A bearing under load, and a moment later.
#[derive(Debug, Clone)]
pub struct Work {
    /// The bearing.
    pub design: Design,
    /// At first; then one tick later, every load 1 % and the speed 0.5 % larger or smaller.
    pub states: [State; 2],
}

impl Work {
    /// The state of a start, at rest if the shaft does not turn.
    pub fn state(&self, start: usize, at_speed: bool) -> State {
        let (load, omega) = self.states[start];
        (load, if at_speed { omega } else { 0.0 })
    }

    /// The state of a start as a question to a scene.
    pub fn question<T: Real, S: Scene<T, BALLS, D>, const D: usize>(
        &self,
        start: usize,
        tolerance: T,
    ) -> Question<T, D> {
        let (load, omega) = self.state(start, S::AT_SPEED);
        Question {
            load: core::array::from_fn(|i| T::of(load[i])),
            omega: T::of(omega),
            tolerance,
        }
    }
}

/// Kinds of solves: cold and warm at the default tolerance, warm at the tolerance of a tick.
pub const KINDS: [&str; 3] = ["cold", "warm", "warm tick"];

/// The solves of one kind that have found a solution.
#[derive(Debug, Clone, Copy)]
pub struct Solves {
    cycles: [u32; CASES],
    solved: usize,
    /// Hash of the answers: FNV-1a over displacements, stiffness and iterations.
    pub hash: u32,
}

impl Solves {
    const NONE: Self = Self {
        cycles: [0; CASES],
        solved: 0,
        hash: 0x811c_9dc5,
    };

    fn add<T: Real, const D: usize>(&mut self, cycles: u32, answer: &Answer<T, D>) {
        if let Some(to) = self.cycles.get_mut(self.solved) {
            *to = cycles;
            self.solved += 1;
        }
        let numbers = answer.displacement.iter();
        let numbers = numbers.chain(answer.stiffness.as_flattened());
        let bytes = numbers
            .flat_map(|number| number.to_f64().to_le_bytes())
            .chain(answer.iterations.to_le_bytes());
        self.hash = bytes.fold(self.hash, |hash, byte| {
            (hash ^ u32::from(byte)).wrapping_mul(0x0100_0193)
        });
    }

    /// Cycles, median and worst; `None` where the counter stands still.
    pub fn cycles(&mut self) -> Option<[u32; 2]> {
        let cycles = self.cycles.get_mut(..self.solved)?;
        cycles.sort_unstable();
        let median = cycles.get(cycles.len().checked_sub(1)? / 2)?;
        Some([*median, *cycles.last()?]).filter(|[_, worst]| *worst > 0)
    }
}

/// Solves all cases, with a counter of cycles: the solves of each kind.
pub fn run<T: Real, S: Scene<T, BALLS, D>, const D: usize>(
    works: &[Work; CASES],
    now: &mut dyn FnMut() -> u32,
) -> [Solves; 3] {
    let mut all = [Solves::NONE; 3];
    // Fills caches, and does not count.
    let _ = case::<T, S, D>(&works[0], now, &mut all.clone());
    for work in works {
        let _ = case::<T, S, D>(work, now, &mut all);
    }
    all
}

/// Solves a case. `None` for a design or a load without a solution.
fn case<T: Real, S: Scene<T, BALLS, D>, const D: usize>(
    work: &Work,
    now: &mut dyn FnMut() -> u32,
    all: &mut [Solves; 3],
) -> Option<()> {
    let bearing = Bearing::<T, BALLS>::of(&work.design).ok()?;
    let [default, tick] = [Settings::<T>::DEFAULT, Settings::TICK].map(|of| of.tolerance);
    for (solves, (start, tolerance)) in all.iter_mut().zip([(0, default), (1, default), (1, tick)])
    {
        let mut solver = S::solver(&bearing, &work.design)?;
        if start == 1 {
            solve::<T, S, D>(&mut solver, &work.question::<T, S, D>(0, default))?;
        }
        let question = work.question::<T, S, D>(start, tolerance);
        let [before, began] = [now(), now()];
        let answer = solve::<T, S, D>(&mut solver, &question);
        let ended = now();
        let of_counter = began.wrapping_sub(before);
        let cycles = ended.wrapping_sub(began).saturating_sub(of_counter);
        if let Some(answer) = answer {
            solves.add(cycles, &answer);
        }
    }
    Some(())
}

/// Solves, as a function by itself.
#[inline(never)]
fn solve<T: Real, S: Scene<T, BALLS, D>, const D: usize>(
    solver: &mut S::Solver<'_>,
    question: &Question<T, D>,
) -> Option<Answer<T, D>> {
    // Firmware may have the solver anywhere: a known address would be spelled out in every function.
    S::solve(black_box(solver), question)
}

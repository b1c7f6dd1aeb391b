//! Any rows on a shaft, any settings, any sequence of loads, speeds, growths and cut solves.
//!
//! No panic, every figure a number, forces in balance, a symmetric stiffness at rest, and a refusal does no harm.

use crate::laws::common::{
    Answer, Asked, Ends, Scale, assert_finite, growth, inspect, refused, run_of, settings_in,
    unharmed,
};
use crate::laws::shaft::Step;
use crate::laws::statics::{Place, assert_balances, assert_symmetric};
use spindle_bearing::{
    Arrangement, Bearing, Centrifugal, Given, Growth, InnerRaceControl, Material, Motion, Mounted,
    OuterRaceControl, Preload, RacewayControlFree, Real, Section, Settings, Shaft, Speed,
    SpindleError, SpindleSolution, Static, Status, Support,
};
use spindle_file::mounting::{DynSolver, DynSpindle, MOST_JOINTS};
use spindle_file::plan::{MOST_BALLS, MOST_ROWS};
use std::array::from_fn;

pub use crate::laws::shaft::Run;

/// Balls of the first bearing, and of the second one.
const BALLS: usize = 16;
const FEWER: usize = 9;

/// Runs a kept input as its target does; how its solves ended.
pub fn replay(input: &[u8]) -> Ends {
    check(&run_of(input))
}

/// Runs it; how its solves ended. A law that is broken is a panic.
pub fn check(run: &Run) -> Ends {
    match run.scene[0] % 2 {
        0 => in_precision::<f32>(run),
        _ => in_precision::<f64>(run),
    }
}

fn in_precision<T: Real>(run: &Run) -> Ends {
    let [first, second] = &run.designs;
    let (first, second) = match (
        Bearing::<T, MOST_BALLS>::with_balls(first, BALLS),
        Bearing::<T, MOST_BALLS>::with_balls(second, FEWER),
    ) {
        (Ok(first), Ok(second)) => (first, second),
        (Err(error), _) | (_, Err(error)) => return refused(&error),
    };
    let scale = Scale::of(&run.designs[0], BALLS);
    let mut x = 0.0;
    let mounted = run.rows.iter().map(|row| {
        x += row.distance * run.designs[0].pitch_diameter;
        let mounted = match row.second {
            false => Mounted::new(&first, T::of(x), row.facing),
            true => Mounted::new(&second, T::of(x), row.facing),
        };
        mounted.with(match row.preload {
            Preload::Closure(e) => Preload::Closure(T::of(e * scale.displacement[0])),
            Preload::Force(force) => Preload::Force(T::of(force * scale.load[0])),
            _ => Preload::Spring,
        })
    });
    use Arrangement::{BackToBack, ByRows, FaceToFace, Tandem};
    let named = [ByRows, ByRows, ByRows, BackToBack, FaceToFace, Tandem];
    let arrangement = named[usize::from(run.scene[2]) % named.len()];
    let mounted: Vec<_> = mounted.collect();
    let spring = run.spring.map(|force| T::of(force * scale.load[0]));
    // Pairs alone are on elastic shafts.
    let elastic = run.shaft.as_ref().filter(|_| mounted.len() == 2);
    let size = run.designs[0].pitch_diameter;
    let sections = elastic.map(|elastic| {
        let of = &elastic.section;
        let [from, to, outer, inner] = [of.from, of.to, of.outer, of.inner].map(|x| x * size);
        Section {
            from,
            to,
            outer,
            inner,
        }
    });
    let Ok(shaft) = Shaft::<T, 1>::new(sections.as_slice(), &Material::STEEL) else {
        return Ends::from(["rows"]);
    };
    let support = elastic.map_or(Support::RIGID, |elastic| Support {
        axial: T::of(elastic.support.axial),
        radial: T::of(elastic.support.radial),
        tilting: T::of(elastic.support.tilting),
    });
    match DynSpindle::of_rows(arrangement, &mounted, spring, &shaft, &[support; MOST_ROWS]) {
        Ok(spindle) => moving(run, spindle),
        Err(error) => {
            if let SpindleError::Row {
                row,
                value,
                least,
                most,
                ..
            } = error
            {
                assert!(row < mounted.len() && !(value >= least && value <= most));
            }
            Ends::from(["rows"])
        }
    }
}

fn moving<T: Real>(run: &Run, spindle: DynSpindle<'_, T>) -> Ends {
    match run.scene[1] % 5 {
        0 => solve::<T, Static>(run, spindle),
        1 => solve::<T, RacewayControlFree>(run, spindle),
        2 => solve::<T, Centrifugal>(run, spindle),
        3 => solve::<T, OuterRaceControl>(run, spindle),
        _ => solve::<T, InnerRaceControl>(run, spindle),
    }
}

/// A question to a solver.
#[derive(Debug, Clone, Copy)]
struct Question<T> {
    load: [T; 5],
    /// Displacements in the place of loads.
    held: [Option<T>; 5],
    omega: T,
    growth: [Growth<T>; MOST_ROWS],
    /// Iterations after which it is cut.
    cut: Option<u8>,
}

/// Every figure of a solution.
fn answer<T: Real, M: Motion>(
    s: &SpindleSolution<'_, T, MOST_ROWS, MOST_BALLS, M, 6, MOST_JOINTS>,
) -> Answer<T> {
    let nose = s.rows().next().map_or(T::ZERO, |row| row.position);
    let matrices = [s.stiffness(), s.stiffness_at(nose), s.compliance_at(nose)];
    let mut figures = Vec::new();
    figures.extend(matrices.as_flattened().as_flattened());
    figures.extend(s.displacement.into_iter().chain(s.load));
    figures.push(s.spring_closure());
    let mut balls = Vec::new();
    for row in s.rows() {
        figures.extend(row.stiffness().into_iter().flatten());
        figures.extend(row.force.into_iter().chain([row.preload()]));
        figures.extend(row.cage_speeds());
        assert!(row.inner_forces().eq(row.balls().map(|ball| ball.q_i)));
        balls.extend(row.balls());
    }
    Answer {
        status: s.status,
        iterations: s.iterations,
        error: s.error,
        figures,
        balls,
    }
}

/// Takes the steps of a run.
fn solve<T: Real, M: Motion + Copy>(run: &Run, spindle: DynSpindle<'_, T>) -> Ends {
    let scale = Scale::of(&run.designs[0], BALLS);
    let spring = T::of(run.spring.unwrap_or(0.0) * scale.load[0]);
    let settings: Settings<T> = settings_in(run.settings);
    let rows = run.rows.iter().map(|row| {
        let pitch = run.designs[usize::from(row.second)].pitch_diameter;
        (row.facing, row.preload == Preload::Spring, pitch)
    });
    let rows: Vec<Place> = rows.collect();
    let ask = |solver: &mut DynSolver<T, M>, q: &Question<T>, settings: &Settings<T>| {
        let mut taken = 0;
        let more_time = || {
            taken += 1;
            q.cut.is_none_or(|cut| taken < u32::from(cut))
        };
        let at = Speed::rad_per_s(q.omega).with_growth(q.growth);
        let solved = match q.held {
            [None, None, None, None, None] => {
                solver.solve_while(&spindle, q.load, at, settings, more_time)
            }
            held => {
                let given: [_; 5] =
                    from_fn(|i| held[i].map_or(Given::Load(q.load[i]), Given::Displacement));
                solver.solve_while(&spindle, given, at, settings, more_time)
            }
        };
        let asked: Asked<T> = solved.map(|s| {
            if s.status == Status::Converged {
                assert_balances(&rows, spring, &s);
            }
            if q.omega == T::ZERO {
                assert_symmetric(&s);
            }
            answer(&s)
        });
        asked
    };
    // Something near, so that a solver would start from what it remembers.
    let probe = |solver: &DynSolver<T, M>, near: &Question<T>| {
        let unfinished = format!("{:?}", solver.unfinished(&spindle).map(|s| answer(&s)));
        let question = Question {
            load: near.load.map(|load| load * T::of(0.9)),
            cut: None,
            ..*near
        };
        let asked = ask(&mut solver.clone(), &question, &Settings::default());
        format!("{unfinished}, {asked:?}")
    };
    let fresh = DynSolver::<T, M>::of();
    let (mut solver, mut ends) = (fresh.clone(), Ends::new());
    let mut question = Question {
        load: from_fn(|i| T::of([1e-4, 1e-5, 0.0, 1e-6, 0.0][i] * scale.load[i])),
        held: [None; 5],
        omega: T::ZERO,
        growth: [Growth::NONE; MOST_ROWS],
        cut: None,
    };
    // The last question that was not refused for what it is.
    let mut tried = question;
    for step in &run.steps {
        let before = solver.clone();
        match step {
            Step::Reset => {
                solver.reset();
                assert_eq!(probe(&solver, &tried), probe(&fresh, &tried), "reset");
                continue;
            }
            Step::Grow(rows) => {
                let lengths = |x: [f64; 3]| growth(x.map(|x| x * scale.displacement[0]));
                let of_row = |i: usize| rows.get(i).map_or(Growth::NONE, |x| lengths(*x));
                question.growth = from_fn(of_row);
                continue;
            }
            Step::Hold(held) => {
                let scaled = |i: usize| held[i].map(|u| T::of(u * scale.displacement[i]));
                question.held = from_fn(scaled);
                continue;
            }
            Step::Cut(cut) => {
                question.cut = *cut;
                continue;
            }
            Step::Solve(load, omega) => {
                question.load = from_fn(|i| T::of(load[i] * scale.load[i]));
                question.omega = T::of(omega * scale.speed);
            }
            Step::Nudge(factors, factor) => {
                question.load = from_fn(|i| question.load[i] * T::of(factors[i]));
                question.omega = question.omega * T::of(*factor);
            }
        }
        let is_cut = question.held.iter().all(Option::is_none);
        let cut = question.cut.filter(|_| is_cut);
        let cut = cut.map_or(u16::MAX, u16::from);
        let most = settings.max_iterations.min(cut).max(1);
        let ended = inspect(ask(&mut solver, &question, &settings), most);
        ends.insert(ended.name());
        match (&ended, solver.unfinished(&spindle)) {
            (Status::IterationLimit, Some(s)) => {
                assert_eq!(s.status, ended);
                assert_finite(&answer(&s));
            }
            (Status::IterationLimit, None) => {}
            (Status::NotFinite { .. } | Status::OutOfRange { .. } | Status::Unloaded, _) => {}
            (_, unfinished) => assert!(unfinished.is_none(), "{unfinished:?} after {ended:?}"),
        }
        tried = unharmed(&ended, [&solver, &before, &fresh], tried, question, probe);
    }
    ends
}

//! Every scene against the reference build restricted in the same way, and every scene that is a special
//! case of another against that one.
#![allow(clippy::neg_cmp_op_on_partial_ord, clippy::needless_range_loop)]

use host_tests::campaign::Plan;
use host_tests::campaign::families::{Family, Tick, Trial};
use host_tests::cases::{B218, B7005C, Case, SKF6205};
use host_tests::compare::{Ball, Equilibrium, Errors, stiffness_error, worse};
use host_tests::dispatch::{Attitude, Precision};
use host_tests::reference::{self, Reference};
use host_tests::tolerances::{allowed, allowed_at};
use spindle_bearing::{
    All, Axial, BallState, BallStore, Bearing, Centrifugal, Conditions, Design, Displacement,
    Displacements, FreeContact, Freedoms, Full, ImposedTilt, InnerRaceControl, Load, Loads,
    Material, Motion, OuterRaceControl, Quantity, RacewayControlFree, Real, RigidPreload, Settings,
    Solver, Static, Status, Stiffness, Translations,
};
use std::array::from_fn;
use std::f64::consts::TAU;
use std::fmt::Write;
use std::hint::black_box;

/// Adds to the solver's precisions the name they have in the tables.
trait Working: Real {
    const PRECISION: Precision;
}
impl Working for f32 {
    const PRECISION: Precision = Precision::F32;
}
impl Working for f64 {
    const PRECISION: Precision = Precision::F64;
}

/// What the reference build has to leave out to be restricted as a motion is.
trait Restricted: Motion {
    const NAME: &'static str;
    const RULE: Attitude;
    fn reference(whole: &Reference) -> Reference;
    fn speed(omega: f64) -> f64 {
        omega
    }
}
impl Restricted for Static {
    const NAME: &'static str = "static";
    const RULE: Attitude = Attitude::Outer;
    fn reference(whole: &Reference) -> Reference {
        whole.clone()
    }
    fn speed(_: f64) -> f64 {
        0.0
    }
}
impl Restricted for Centrifugal<RacewayControlFree> {
    const NAME: &'static str = "centrifugal, race control free";
    const RULE: Attitude = Attitude::Raceless;
    fn reference(whole: &Reference) -> Reference {
        whole.clone().without_gyroscopic_moment()
    }
}
impl Restricted for Full<RacewayControlFree> {
    const NAME: &'static str = "full, race control free";
    const RULE: Attitude = Attitude::Raceless;
    fn reference(whole: &Reference) -> Reference {
        whole.clone()
    }
}
impl Restricted for Full<OuterRaceControl> {
    const NAME: &'static str = "full, outer race control";
    const RULE: Attitude = Attitude::Outer;
    fn reference(whole: &Reference) -> Reference {
        whole.clone()
    }
}
impl Restricted for Full<InnerRaceControl> {
    const NAME: &'static str = "full, inner race control";
    const RULE: Attitude = Attitude::Inner;
    fn reference(whole: &Reference) -> Reference {
        whole.clone()
    }
}

/// An answer in doubles.
#[derive(Debug, Clone)]
struct Found {
    solved: bool,
    u: Vec<f64>,
    load: Vec<f64>,
    k: Vec<Vec<f64>>,
    balls: Vec<BallState<f64>>,
    /// The solver's own estimate of its errors of displacement, force and stiffness.
    estimate: [f64; 3],
}

fn widened<T: Real>(b: &BallState<T>) -> BallState<f64> {
    BallState {
        azimuth: b.azimuth.to_f64(),
        alpha_i: b.alpha_i.to_f64(),
        alpha_o: b.alpha_o.to_f64(),
        q_i: b.q_i.to_f64(),
        q_o: b.q_o.to_f64(),
        delta_i: b.delta_i.to_f64(),
        delta_o: b.delta_o.to_f64(),
        centrifugal_force: b.centrifugal_force.to_f64(),
        gyroscopic_moment: b.gyroscopic_moment.to_f64(),
    }
}

/// Why there is no answer.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Why {
    NotFinite,
    OutOfRange,
    Unloaded,
    Other,
}

/// A refusal, and the status in the solver's words.
#[derive(Debug)]
struct Refusal {
    why: Why,
    #[allow(dead_code, reason = "for those who read a failure")]
    status: String,
}

impl<T: Real> From<Status<T>> for Refusal {
    fn from(status: Status<T>) -> Self {
        let why = match status {
            Status::NotFinite { .. } => Why::NotFinite,
            Status::OutOfRange { .. } => Why::OutOfRange,
            Status::Unloaded => Why::Unloaded,
            _ => Why::Other,
        };
        let status = format!("{status:?}");
        Self { why, status }
    }
}

// Functions of slices and iterators, so that they are not compiled again for every scene.

fn in_doubles<T: Real>(values: &[T]) -> Vec<f64> {
    values.iter().map(|x| x.to_f64()).collect()
}

fn rows<T: Real>(k: impl IntoIterator<Item: AsRef<[T]>>) -> Vec<Vec<f64>> {
    k.into_iter().map(|row| in_doubles(row.as_ref())).collect()
}

fn states<T: Real>(balls: impl Iterator<Item = BallState<T>>) -> Vec<BallState<f64>> {
    balls.map(|ball| widened(&ball)).collect()
}

/// Solves for `values`, one for each of the scene's freedoms.
fn solve<T, const N: usize, const D: usize, M, B>(
    solver: &mut Solver<'_, T, N, M, Freedoms<D>, B>,
    values: &[f64],
    omega: f64,
) -> Result<Found, Refusal>
where
    T: Real,
    M: Motion,
    Freedoms<D>: BallStore,
    B: Conditions<Freedoms<D>>,
{
    assert_eq!(values.len(), D);
    let values = from_fn(|i| T::of(values[i]));
    let s = solver.solve(values, T::of(omega), &Settings::default())?;
    Ok(Found {
        solved: matches!(s.status, Status::Converged | Status::PrecisionLimit),
        u: in_doubles(&s.displacement),
        load: in_doubles(&s.load),
        k: rows(s.stiffness),
        balls: states(s.balls()),
        estimate: [s.error.displacement, s.error.force, s.error.stiffness].map(T::to_f64),
    })
}

fn cold<T, const N: usize, const D: usize, M, B>(
    bearing: &Bearing<T, N>,
    values: [f64; D],
    omega: f64,
) -> Result<Found, Refusal>
where
    T: Real,
    M: Motion,
    Freedoms<D>: BallStore,
    B: Conditions<Freedoms<D>>,
{
    let mut solver = Solver::<T, N, M, Freedoms<D>, B>::new(bearing);
    solve(&mut solver, &values, omega)
}

/// The freedoms of five that a scene solves for.
fn free<const D: usize, B>() -> [bool; 5]
where
    Freedoms<D>: BallStore,
    B: Conditions<Freedoms<D>>,
{
    from_fn(|i| i < D && !B::HELD[i])
}

/// A scene's answer among five freedoms: what it does not solve for is as in `truth`, and so is what its
/// one ball says of the others.
fn among_five(found: &Found, truth: &Equilibrium, free: [bool; 5]) -> Equilibrium {
    let places: Vec<usize> = (0..5).filter(|i| free[*i]).collect();
    let mut whole = truth.clone();
    for (i, u) in found.u.iter().enumerate() {
        whole.displacement[i] = *u;
    }
    for (row, i) in found.k.iter().zip(&places) {
        for (element, j) in row.iter().zip(&places) {
            whole.stiffness[*i][*j] = *element;
        }
    }
    let balls = truth.balls.len();
    whole.balls = (0..balls)
        .map(|j| Ball::from(&found.balls[j.min(found.balls.len() - 1)]))
        .collect();
    whole
}

/// A ball of the reference build, as the solver would say it.
fn state(ball: &reference::BallState) -> BallState<f64> {
    BallState {
        azimuth: ball.azimuth,
        alpha_i: ball.alpha_i,
        alpha_o: ball.alpha_o,
        q_i: ball.q_i,
        q_o: ball.q_o,
        delta_i: ball.delta_i,
        delta_o: ball.delta_o,
        centrifugal_force: ball.fc,
        gyroscopic_moment: ball.mg,
    }
}

/// The balls' centres, axial and radial from the outer groove's curvature centre.
fn centres(case: &Case, found: &Found) -> Vec<[f64; 2]> {
    let lo = (case.design.outer_groove_factor - 0.5) * case.design.ball_diameter;
    (0..case.balls)
        .map(|j| {
            let ball = &found.balls[j.min(found.balls.len() - 1)];
            let (sin, cos) = ball.alpha_o.sin_cos();
            [(lo + ball.delta_o) * sin, (lo + ball.delta_o) * cos]
        })
        .collect()
}

/// The equilibrium that the restricted reference build reaches from an answer.
fn truth_near(
    case: &Case,
    reference: &Reference,
    rule: reference::Attitude,
    tick: &Tick,
    free: [bool; 5],
    found: &Found,
) -> Option<reference::Solution> {
    let centres: Vec<(f64, f64)> = centres(case, found).iter().map(|x| (x[0], x[1])).collect();
    let u = from_fn(|i| found.u.get(i).copied().unwrap_or(0.0));
    reference
        .polish_with(tick.load, tick.omega, rule, u, &centres, free)
        .ok()
}

/// Force and moment of balls on the inner ring, by the textbook. The last one stands for those that are
/// missing.
fn carried(case: &Case, rule: Attitude, balls: &[BallState<f64>]) -> [f64; 5] {
    let design = &case.design;
    let cos0 = match design.free_contact {
        FreeContact::Angle(angle) => angle.cos(),
        FreeContact::DiametralClearance(clearance) => {
            1.0 - clearance / (2.0 * design.centre_distance())
        }
    };
    let (d, li) = (
        design.ball_diameter,
        (design.inner_groove_factor - 0.5) * design.ball_diameter,
    );
    let (rp, zp) = (
        0.5 * design.pitch_diameter + li * cos0,
        li * (1.0 - cos0 * cos0).sqrt(),
    );
    let mut sum = [0.0; 5];
    for j in 0..case.balls {
        let ball = &balls[j.min(balls.len() - 1)];
        let share = match rule {
            // A ball that has dropped out has no contact forces.
            Attitude::Raceless if ball.q_i <= 0.0 => 0.0,
            Attitude::Raceless => 2.0 * ball.q_i / (ball.q_i + ball.q_o),
            Attitude::Outer => 0.0,
            Attitude::Inner => f64::from(u8::from(ball.q_i > 0.0)),
        };
        let friction = if ball.gyroscopic_moment == 0.0 {
            0.0
        } else {
            share * ball.gyroscopic_moment / d
        };
        let (si, ci) = ball.alpha_i.sin_cos();
        let (s, c) = (design.first_ball + TAU * j as f64 / case.balls as f64).sin_cos();
        let axial = ball.q_i * si + friction * ci;
        let radial = ball.q_i * ci - friction * si;
        let moment = rp * axial - zp * radial - design.inner_groove_factor * d * friction;
        let parts = [axial, radial * c, radial * s, moment * s, -moment * c];
        for (sum, part) in sum.iter_mut().zip(parts) {
            *sum += part;
        }
    }
    sum
}

/// Largest difference of two loads in units of `size`, moments over the pitch radius.
fn load_error<'l>(
    case: &Case,
    loads: impl IntoIterator<Item = (usize, &'l f64)>,
    other: &[f64; 5],
    size: f64,
) -> f64 {
    loads.into_iter().fold(0.0, |error, (i, load)| {
        let unit = if i < 3 { 1.0 } else { case.pitch_radius() };
        worse(error, (load - other[i]).abs() / (size * unit))
    })
}

/// How much more than the table's errors an answer may have: the families have harder cases than
/// those the table is for, whose own errors are a third of it.
const HARDER: f64 = 20.0;

/// The largest estimate of its own errors that excuses an answer.
const MOST: f64 = 0.05;

/// Whether the free freedoms are hardly determined: one is softer than the stiffest by so much that this
/// precision cannot tell. Two balls at rest leave none but a tilt undetermined: across its own plane, a
/// ball resists by its force over the distance of the grooves' centres.
fn is_loose(truth: &reference::Solution, free: [bool; 5], lever: f64, epsilon: f64) -> bool {
    let unit = |i: usize| if i < 3 { 1.0 } else { lever };
    let places: Vec<usize> = (0..5).filter(|i| free[*i]).collect();
    let mut k: Vec<Vec<f64>> = places
        .iter()
        .map(|&i| {
            let row = places.iter();
            row.map(|&j| truth.k[i][j] / (unit(i) * unit(j))).collect()
        })
        .collect();
    let largest = (0..k.len()).fold(0.0, |m, i| f64::max(m, k[i][i]));
    for p in 0..k.len() {
        if !(k[p][p] > 1e3 * epsilon * largest) {
            return true;
        }
        for i in p + 1..k.len() {
            let factor = k[i][p] / k[p][p];
            for j in p..k.len() {
                let above = k[p][j];
                k[i][j] -= factor * above;
            }
        }
    }
    false
}

/// What came of one kind of scene.
#[derive(Default)]
struct Tally {
    solves: usize,
    judged: usize,
    refused: usize,
    unsolved: usize,
    unjudged: usize,
    /// Judged by the equations alone.
    loose: usize,
    /// Without an equilibrium that the reference build knew of; by inner race control only.
    none: usize,
    /// Where inner race control is torn between a ball on and off the inner race.
    jumping: usize,
    worst: Errors,
    complaints: Vec<String>,
}

impl Tally {
    fn line(&self, name: &str) -> String {
        format!(
            "{name}: {} solves, {} judged, {} refused, {} without an answer, {} without an equilibrium, {} at a jump, \
             {} without a truth, {} loose, {} too far off; {}",
            self.solves,
            self.judged,
            self.refused,
            self.unsolved,
            self.none,
            self.jumping,
            self.unjudged,
            self.loose,
            self.complaints.len(),
            self.worst
        )
    }
}

/// What the judge knows of a scene and its solver.
struct Scene {
    /// Of the balls.
    motion: &'static str,
    rule: Attitude,
    /// The reference build, restricted as the motion is.
    reference: Reference,
    /// The speed that the motion takes notice of.
    speed: fn(f64) -> f64,
    /// Freedoms that there are, and of five those that are solved for.
    freedoms: usize,
    free: [bool; 5],
    precision: Precision,
    epsilon: f64,
    /// A number as the solver sees it.
    seen: fn(f64) -> f64,
}

impl Scene {
    fn of<T, const D: usize, M, B>(whole: &Reference) -> Self
    where
        T: Working,
        M: Restricted,
        Freedoms<D>: BallStore,
        B: Conditions<Freedoms<D>>,
    {
        Self {
            motion: M::NAME,
            rule: M::RULE,
            reference: M::reference(whole),
            speed: M::speed,
            freedoms: D,
            free: free::<D, B>(),
            precision: T::PRECISION,
            epsilon: T::EPSILON.to_f64(),
            seen: |x| T::of(x).to_f64(),
        }
    }
}

/// A solver of one scene: its answer to given loads or displacements, and a speed.
type Solve<'s> = dyn FnMut(&[f64], f64) -> Result<Found, Refusal> + 's;

/// Solves one trial in one scene, all its ticks, and judges the answers.
fn judge_scene<T, const N: usize, const D: usize, M, B>(
    trial: &Trial,
    held: [f64; 5],
    tally: &mut Tally,
) where
    T: Working,
    M: Restricted,
    Freedoms<D>: BallStore,
    B: Conditions<Freedoms<D>>,
{
    let bearing = Bearing::<T, N>::build(&trial.case.design).unwrap();
    let mut solver = Solver::<T, N, M, Freedoms<D>, B>::new(&bearing);
    let scene = Scene::of::<T, D, M, B>(&trial.reference);
    judge(trial, &scene, held, tally, &mut |values, omega| {
        solve(&mut solver, values, omega)
    });
}

/// Has all ticks of a trial solved, and judges the answers. One function for all scenes, precisions and ball
/// counts, since there are hundreds of these.
fn judge(trial: &Trial, scene: &Scene, held: [f64; 5], tally: &mut Tally, solve: &mut Solve<'_>) {
    let case = &trial.case;
    let Scene {
        rule,
        reference,
        free,
        precision,
        epsilon,
        ..
    } = scene;
    let (rule, free, precision, epsilon) = (*rule, *free, *precision, *epsilon);
    let seen = |x: &f64| (scene.seen)(*x);
    for tick in &trial.ticks {
        let all: [f64; 5] = from_fn(|i| if free[i] { tick.load[i] } else { held[i] });
        let values = &all[..scene.freedoms];
        tally.solves += 1;
        let answer = solve(values, tick.omega);
        let inputs = || values.iter().chain([&tick.omega]);
        if !inputs().all(|x| seen(x).is_finite()) {
            assert!(
                matches!(&answer, Err(refusal) if [Why::NotFinite, Why::OutOfRange].contains(&refusal.why)),
                "{}: {answer:?}",
                case.name
            );
            continue;
        }
        let found = match answer {
            Ok(found) if found.solved => found,
            // Their own loads are zero, or subnormal; or beyond what the model is for.
            Err(refusal) if [Why::Unloaded, Why::OutOfRange].contains(&refusal.why) => {
                let largest = values.iter().fold(0.0, |m, x| f64::max(m, x.abs()));
                let unloaded = refusal.why == Why::Unloaded;
                assert!(
                    if unloaded {
                        largest < 1e-12
                    } else {
                        largest.max(tick.omega.abs()) > 1e3
                    },
                    "{}: {refusal:?}, loads up to {largest}",
                    case.name
                );
                tally.refused += 1;
                continue;
            }
            _ => {
                // Inner race control need not have an equilibrium.
                let held: [f64; 5] = from_fn(|i| values.get(i).map_or(0.0, seen));
                let there_is_none = rule == Attitude::Inner
                    && reference
                        .search_with(held, seen(&tick.omega), rule.into(), free, held)
                        .is_err();
                if there_is_none {
                    tally.none += 1;
                } else {
                    tally.unsolved += 1;
                }
                continue;
            }
        };
        let loaded = found.balls.iter().filter(|ball| ball.q_i > 0.0).count();
        let complain = |what: String| {
            let (name, precision, motion) = (&case.name, precision, scene.motion);
            format!("{name} {precision:?} {motion}: {what}; {loaded} balls loaded")
        };
        let restricted = Tick {
            load: from_fn(|i| if free[i] { seen(&tick.load[i]) } else { 0.0 }),
            omega: (scene.speed)(seen(&tick.omega)),
        };
        let lever = case.pitch_radius();
        let strongest = |force: f64, ball: &BallState<f64>| force.max(ball.q_i).max(ball.q_o);
        let size = found.balls.iter().fold(0.0, strongest) * case.balls as f64;
        let deepest = found.balls.iter().map(|b| b.delta_i).fold(0.0, f64::max);
        let unit = |i: usize| if i < 3 { 1.0 } else { lever };
        let lengths = found.u.iter().enumerate().map(|(i, u)| u.abs() * unit(i));
        let largest = lengths.fold(0.0, f64::max);
        let mut bounds = allowed_at(precision, largest / case.design.centre_distance());
        bounds = bounds.times(HARDER);
        // A hard case is one that the answer itself calls so.
        // But not one that says nothing of itself.
        let [displacement, force, stiffness] = found.estimate.map(|error| error.min(MOST));
        bounds.displacement = bounds.displacement.max(displacement);
        // A displacement of many deformations has few digits left for them.
        // Single precision keeps positions in two parts.
        let length = match precision {
            Precision::F32 => largest,
            Precision::F64 => largest + case.design.centre_distance(),
        };
        let rounding = 32.0 * epsilon * length / deepest;
        bounds.force = bounds.force.max(force);

        // Two balls hold the ring in four directions. What a load has in others from being rounded, which the
        // families do to single precision, nothing carries.
        if 2 * loaded < free.iter().filter(|free| **free).count() && scene.freedoms > 1 {
            bounds.force = bounds.force.max(f64::from(f32::EPSILON));
        }
        // The balls carry the load, and what they carry is what the answer says.
        let by_balls = carried(case, rule, &found.balls);
        let given = || (0..).zip(&restricted.load).filter(|(i, _)| free[*i]);
        let error = load_error(case, given(), &by_balls, size);
        let own = load_error(case, (0..).zip(&found.load), &by_balls, size);
        let missed = worse(error, own);
        if !(missed <= bounds.force) {
            // Where a ball leaves the inner race, inner race control takes its friction from one moment to
            // the next; there may be no balance to better than that.
            let open = found.balls.iter().any(|ball| ball.q_i <= 0.0);
            let friction = found.balls.iter().fold(0.0, |m, ball| {
                f64::max(m, ball.gyroscopic_moment.abs() / case.design.ball_diameter)
            });
            if rule == Attitude::Inner && open && missed <= 2.0 * friction / size {
                tally.jumping += 1;
                continue;
            }
            let allowed = bounds.force;
            tally.complaints.push(complain(format!(
                "the balls miss the load by {error:.1e}, what the answer says of it by {own:.1e}; allowed \
                 {allowed:.1e}"
            )));
            continue;
        }

        bounds.force = bounds.force.max(rounding);
        bounds.stiffness = bounds.stiffness.max(stiffness).max(rounding);
        let truth = truth_near(case, reference, rule.into(), &restricted, free, &found);
        let truth = match truth {
            Some(truth) if !is_loose(&truth, free, lever, epsilon) => truth,
            other => {
                // Where the ring is may be hard to tell, but there the bearing must carry the load.
                let u = from_fn(|i| found.u.get(i).copied().unwrap_or(0.0));
                let mut centres = centres(case, &found);
                let law = reference.rough_law(u, restricted.omega, rule.into(), &mut centres);
                let error = law.map(|(force, _)| load_error(case, given(), &force, size));
                match error {
                    Ok(error) if error <= bounds.force => {}
                    Ok(error) => tally.complaints.push(complain(format!(
                        "the bearing misses the load by {error:.1e} at this displacement; allowed {:.1e}",
                        bounds.force
                    ))),
                    Err(_) => {
                        tally.unjudged += 1;
                        continue;
                    }
                }
                if other.is_some() {
                    tally.loose += 1;
                } else {
                    tally.unjudged += 1;
                }
                continue;
            }
        };
        tally.judged += 1;
        let exact = Equilibrium::from(&truth);
        let whole = among_five(&found, &exact, free);
        let mut errors = whole.errors(&exact, case.design.ball_diameter, lever);
        // Reactions, which no displacement shows.
        let size = exact.largest_force() * case.balls as f64;
        let balls: Vec<BallState<f64>> = truth.balls.iter().map(state).collect();
        let carried = carried(case, rule, &balls);
        let reactions = load_error(case, (0..).zip(&found.load), &carried, size);
        errors.force = worse(errors.force, reactions);
        tally.worst = tally.worst.worse(errors);
        // The stiffness of a ball that is about to open goes with the root of its deformation.
        if (truth.balls.iter()).any(|ball| ball.delta_i.abs() < 1e-3 * deepest) {
            bounds.stiffness = bounds.stiffness.max(rounding.sqrt());
        }
        bounds.contact_angle = f64::INFINITY;
        if !errors.within(bounds) {
            let what = format!("{errors}; allowed {bounds}");
            tally.complaints.push(complain(what));
        }
    }
}

type L = Load;
type H = Displacement;

/// Every set of freedoms and conditions, in both precisions.
fn judge_scenes<const N: usize, M: Restricted>(trial: &Trial, tallies: &mut [Tally; 7]) {
    let bearing = Bearing::<f64, N>::build(&trial.case.design).unwrap();
    let tick = &trial.ticks[0];
    // Displacements to give: some of those under the loads.
    let u = match cold::<f64, N, 5, M, Loads>(&bearing, tick.load, tick.omega) {
        Ok(found) if found.solved => [found.u[0], 0.7 * found.u[1], 0.0, 0.5 * found.u[3], 0.0],
        _ => [0.0; 5],
    };
    let held = u.map(|x| f64::from(x as f32));
    fn both<const N: usize, const D: usize, M: Restricted, B: Conditions<Freedoms<D>>>(
        trial: &Trial,
        held: [f64; 5],
        tally: &mut Tally,
    ) where
        Freedoms<D>: BallStore,
    {
        judge_scene::<f32, N, D, M, B>(trial, held, tally);
        judge_scene::<f64, N, D, M, B>(trial, held, tally);
    }
    let [axial, translations, all, rigid, tilted, guided, pressed] = tallies;
    both::<N, 1, M, Loads>(trial, held, axial);
    both::<N, 3, M, Loads>(trial, held, translations);
    both::<N, 5, M, Loads>(trial, held, all);
    if held[0] != 0.0 {
        both::<N, 5, M, RigidPreload>(trial, held, rigid);
        both::<N, 5, M, ImposedTilt>(trial, held, tilted);
        both::<N, 5, M, (L, H, L, L, L)>(trial, held, guided);
        both::<N, 3, M, (H, L, L)>(trial, held, pressed);
    }
}

fn judge_motion<M: Restricted>(families: &[Family]) -> String {
    const SCENES: [&str; 7] = [
        "axial",
        "translations",
        "all",
        "rigid preload",
        "imposed tilt",
        "all, dy held",
        "translations, dx held",
    ];
    let mut report = String::new();
    for &family in families {
        let mut tallies: [Tally; 7] = Default::default();
        for index in 0..150 {
            let trial = Trial::new(Plan::SEED, family, index);
            match trial.case.balls {
                5 => judge_scenes::<5, M>(&trial, &mut tallies),
                8 => judge_scenes::<8, M>(&trial, &mut tallies),
                16 => judge_scenes::<16, M>(&trial, &mut tallies),
                33 => judge_scenes::<33, M>(&trial, &mut tallies),
                _ => {}
            }
        }
        // Loads and speeds of any size leave more without an answer.
        let share = if family == Family::Random { 3 } else { 4 };
        for (tally, scene) in tallies.iter().zip(SCENES) {
            let silent = tally.unsolved + tally.unjudged;
            if share * silent > tally.solves - tally.refused - tally.none {
                writeln!(report, "{}: {}", family.name(), tally.line(scene)).unwrap();
            }
            let name = format!("{}, {}, {scene}", M::NAME, family.name());
            println!("{}", tally.line(&name));
            for complaint in &tally.complaints {
                writeln!(report, "{scene}, {complaint}").unwrap();
            }
        }
    }
    report
}

fn pass(report: String) {
    assert!(report.is_empty(), "\n{report}");
}

#[test]
fn scenes_at_rest_agree_with_the_restricted_reference_build() {
    pass(judge_motion::<Static>(&Family::ALL));
}

#[test]
fn scenes_under_centrifugal_force_agree_with_the_restricted_reference_build() {
    pass(judge_motion::<Centrifugal>(&Family::ALL));
}

#[test]
fn scenes_at_speed_agree_with_the_restricted_reference_build() {
    pass(judge_motion::<Full>(&Family::ALL));
}

#[test]
fn scenes_under_outer_race_control_agree_with_the_restricted_reference_build() {
    pass(judge_motion::<Full<OuterRaceControl>>(&Family::ALL));
}

#[test]
fn scenes_under_inner_race_control_agree_with_the_restricted_reference_build() {
    pass(judge_motion::<Full<InnerRaceControl>>(&[
        Family::Random,
        Family::Moderate,
        Family::Radial,
        Family::InnerControl,
    ]));
}

// ---------------------------------------------------------------------------------------------
// Scenes that are special cases of others

/// Largest difference of two answers by the measures of the tables, over what is allowed.
fn apart(a: &Found, b: &Found, design: &Design, precision: Precision) -> f64 {
    let lever = 0.5 * design.pitch_diameter;
    let unit = |i: usize| if i < 3 { 1.0 } else { lever };
    let size = |v: &[f64]| {
        let sizes = v.iter().enumerate().map(|(i, x)| x.abs() * unit(i));
        sizes.fold(0.0, f64::max)
    };
    let bounds = allowed_at(precision, size(&b.u) / design.centre_distance());
    let mut worst = 0.0;
    for (i, (a, b_)) in a.u.iter().zip(&b.u).enumerate() {
        let error = (a - b_).abs() * unit(i) / size(&b.u);
        worst = worse(worst, error / bounds.displacement);
    }
    let largest = b.balls.iter().fold(0.0, |m, x| f64::max(m, x.q_o));
    for (a, b) in a.balls.iter().zip(&b.balls) {
        worst = worse(worst, (a.q_i - b.q_i).abs() / largest / bounds.force);
        worst = worse(worst, (a.q_o - b.q_o).abs() / largest / bounds.force);
    }
    let padded = |k: &[Vec<f64>]| -> [[f64; 5]; 5] {
        from_fn(|i| {
            from_fn(|j| {
                let element = k.get(i).and_then(|row| row.get(j)).copied();
                element.unwrap_or(f64::from(u8::from(i == j)))
            })
        })
    };
    let rows = a.k.len().min(b.k.len());
    let part = |k: &[Vec<f64>]| -> Vec<Vec<f64>> {
        k[..rows].iter().map(|row| row[..rows].to_vec()).collect()
    };
    let error = stiffness_error(&padded(&part(&a.k)), &padded(&part(&b.k)));
    worse(worst, error / bounds.stiffness)
}

/// Loads from light to heavy, for a bearing of this size.
fn loads(design: &Design) -> impl Iterator<Item = [f64; 5]> {
    let size = 12e6 * 9.0 * design.ball_diameter.powi(2); // the capacity of 9 balls, roughly
    let lever = 0.5 * design.pitch_diameter;
    [1e-4, 1e-3, 1e-2, 1e-1].into_iter().flat_map(move |part| {
        let f = part * size;
        [
            [f, 0.3 * f, -0.1 * f, 0.02 * f * lever, -0.03 * f * lever],
            [f, 0.0, 0.2 * f, 0.01 * f * lever, 0.0],
            [-f, 0.2 * f, 0.0, 0.0, 0.02 * f * lever],
        ]
    })
}

const DESIGNS: [Design; 3] = [B7005C, B218, SKF6205];

fn special_cases<T: Working, M: Motion>(omega: impl Fn(&Design) -> f64) {
    let mut compared = 0;
    for design in &DESIGNS {
        let bearing = Bearing::<T, 9>::build(design).unwrap();
        let omega = omega(design);
        let mut check = |name: &str, a: &Found, b: &Found, most: f64| {
            compared += 1;
            let by = apart(a, b, design, T::PRECISION);
            assert!(
                by <= most,
                "{name}: {by} times what is allowed\n{a:?}\n{b:?}"
            );
        };
        for load in loads(design) {
            let [fx, fy, fz, ..] = load;
            let axial = [fx, 0.0, 0.0, 0.0, 0.0];
            let (Ok(one), Ok(three), Ok(five)) = (
                cold::<T, 9, 1, M, Loads>(&bearing, [fx], omega),
                cold::<T, 9, 3, M, Loads>(&bearing, [fx, 0.0, 0.0], omega),
                cold::<T, 9, 5, M, Loads>(&bearing, axial, omega),
            ) else {
                panic!("{fx} N at {omega} rad/s has no answer");
            };
            check("axial, translations", &one, &three, 1.0);
            check("axial, all", &one, &five, 1.0);
            let of_three = cold::<T, 9, 3, M, Loads>(&bearing, [fx, fy, fz], omega).unwrap();
            let locked = [fx, fy, fz, 0.0, 0.0];
            let of_five = cold::<T, 9, 5, M, ImposedTilt>(&bearing, locked, omega).unwrap();
            check("translations, tilts held at 0", &of_three, &of_five, 1.0);
            assert_eq!(of_five.u[3..], [0.0; 2]);
            // What holds the axial displacement of a load is that load.
            let loaded = cold::<T, 9, 5, M, Loads>(&bearing, load, omega).unwrap();
            let given = [loaded.u[0], load[1], load[2], load[3], load[4]];
            let held = cold::<T, 9, 5, M, RigidPreload>(&bearing, given, omega).unwrap();
            assert_eq!(held.u[0], loaded.u[0]);
            let without_x = |found: &Found| Found {
                k: Vec::new(),
                ..found.clone()
            };
            // A given displacement is many deformations, and rounded.
            let rounded = 100.0;
            check(
                "rigid preload, all",
                &without_x(&held),
                &without_x(&loaded),
                rounded,
            );
            let reduced: Vec<Vec<f64>> =
                loaded.k[1..].iter().map(|row| row[1..].to_vec()).collect();
            assert_eq!((held.k.len(), held.k[0].len()), (4, 4));
            for (i, row) in held.k.iter().enumerate() {
                for (j, k) in row.iter().enumerate() {
                    let scale = (reduced[i][i] * reduced[j][j]).abs().sqrt();
                    let error = (k - reduced[i][j]).abs() / scale;
                    let bound = 10.0 * allowed(T::PRECISION).stiffness;
                    assert!(error <= bound, "K {i} {j}: {error:e}");
                }
            }
            let error = (held.load[0] / load[0] - 1.0).abs();
            let bound = rounded * allowed(T::PRECISION).force;
            assert!(
                error < bound,
                "reaction {}, load {}: {error:e}",
                held.load[0],
                load[0]
            );
        }
    }
    assert_eq!(compared, 3 * 12 * 4);
}

#[test]
fn special_cases_at_rest_are_the_same_scenes() {
    special_cases::<f64, Static>(|_| 0.0);
    special_cases::<f32, Static>(|_| 0.0);
}

#[test]
fn special_cases_at_speed_are_the_same_scenes() {
    // Slow enough for the lightest of the loads.
    let omega = |design: &Design| 2.0 / design.pitch_diameter;
    special_cases::<f64, Full>(omega);
    special_cases::<f32, Full>(omega);
    special_cases::<f64, Full<InnerRaceControl>>(omega);
    special_cases::<f64, Centrifugal>(omega);
    special_cases::<f32, Centrifugal<OuterRaceControl>>(omega);
}

#[test]
fn motions_at_rest_are_the_static_scene() {
    fn check<T: Working, M: Motion>() {
        for design in &DESIGNS {
            let bearing = Bearing::<T, 9>::build(design).unwrap();
            for load in loads(design) {
                let rest = cold::<T, 9, 5, Static, Loads>(&bearing, load, 0.0).unwrap();
                let still = cold::<T, 9, 5, M, Loads>(&bearing, load, 0.0).unwrap();
                let by = apart(&still, &rest, design, T::PRECISION);
                assert!(by <= 1.0, "{by} times what is allowed\n{still:?}\n{rest:?}");
            }
        }
    }
    check::<f64, Full>();
    check::<f32, Full>();
    check::<f64, Centrifugal>();
    check::<f32, Centrifugal<OuterRaceControl>>();
}

#[test]
fn what_is_not_put_out_changes_nothing_of_the_rest() {
    type Whole<'b> = Solver<'b, f32, 16, Full, All>;
    type Stiff<'b> = Solver<'b, f32, 16, Full, All, Loads, Stiffness>;
    type Bare<'b> = Solver<'b, f32, 16, Full, All, Loads, Displacements>;
    let bearing = Bearing::<f32, 16>::new(&B7005C).unwrap();
    let settings = Settings::default();
    for load in loads(&B7005C) {
        let load = load.map(|x| x as f32);
        let mut whole = Whole::new(&bearing);
        let mut stiff = Stiff::new(&bearing);
        let mut bare = Bare::new(&bearing);
        let whole = whole.solve(load, 1500.0, &settings).unwrap();
        let stiff = stiff.solve(load, 1500.0, &settings).unwrap();
        let bare = bare.solve(load, 1500.0, &settings).unwrap();
        assert_eq!(whole.displacement, stiff.displacement);
        assert_eq!(whole.stiffness, stiff.stiffness);
        for (a, b) in bare.displacement.iter().zip(whole.displacement) {
            let largest = whole
                .displacement
                .iter()
                .fold(0.0, |m: f32, x| m.max(x.abs()));
            assert!((a - b).abs() <= 1e-6 * largest, "{a} {b}");
        }
        assert!(size_of_val(&bare) + 100 <= size_of_val(&stiff));
        assert!(size_of_val(&stiff) < size_of_val(&whole));
    }
}

#[test]
fn one_ball_is_kept_where_one_stands_for_all() {
    type One = Solver<'static, f32, 16, Full, Axial>;
    type All16 = Solver<'static, f32, 16, Full, Translations>;
    assert!(size_of::<One>() * 8 < size_of::<All16>());
    let bearing = Bearing::<f64, 16>::new(&B218).unwrap();
    let mut solver = Solver::<f64, 16, Full, Axial>::new(&bearing);
    let solution = solver
        .solve([17_800.0], 1000.0, &Settings::default())
        .unwrap();
    assert_eq!(solution.balls().len(), 1);
}

#[test]
fn a_displacement_out_of_range_is_named_and_leaves_the_solver_as_it_was() {
    let bearing = Bearing::<f64, 16>::new(&B7005C).unwrap();
    type Given = (Displacement, Load, Displacement, Load, Displacement);
    let mut solver = Solver::<f64, 16, Full, All, Given>::new(&bearing);
    let settings = Settings::default();
    let good = [12e-6, 100.0, 1e-6, 0.5, 1e-4];
    let before = format!("{:?}", solver.clone().solve(good, 2000.0, &settings));
    for (i, quantity) in [(0, Quantity::Dx), (2, Quantity::Dz), (4, Quantity::Tz)] {
        for bad in [f64::NAN, f64::INFINITY, 1.0] {
            let mut values = good;
            values[i] = bad;
            match solver.solve(values, 2000.0, &settings).map(drop) {
                Err(Status::NotFinite {
                    quantity: named, ..
                }) => {
                    assert!(!bad.is_finite());
                    assert_eq!(named, quantity);
                }
                Err(Status::OutOfRange {
                    quantity: named,
                    value,
                    limit,
                }) => {
                    assert_eq!((named, value), (quantity, bad));
                    assert!(value > limit);
                }
                other => panic!("{other:?}"),
            }
            let after = format!("{:?}", solver.clone().solve(good, 2000.0, &settings));
            assert_eq!(before, after);
        }
    }
}

#[test]
fn a_ring_that_nothing_touches_is_indeterminate() {
    let bearing = Bearing::<f64, 16>::new(&B7005C).unwrap();
    let mut solver = Solver::<f64, 16, Static, All, RigidPreload>::new(&bearing);
    // Between the two sides of the grooves.
    let answer = solver.solve([-20e-6, 0.0, 0.0, 0.0, 0.0], 0.0, &Settings::default());
    assert!(
        matches!(answer, Err(Status::Indeterminate { loaded_balls: 0 })),
        "{answer:?}"
    );
}

// ---------------------------------------------------------------------------------------------
// Constants by the compiler

#[test]
fn the_compiler_and_the_program_work_out_the_same_bits() {
    const HYBRID: Design = Design {
        ball: Material::SILICON_NITRIDE,
        first_ball: 0.3,
        ..B7005C
    };
    macro_rules! same {
        ($($t:ident $n:literal $design:ident)*) => {$({
            const BUILT: Bearing<$t, $n> = Bearing::<$t, $n>::checked(&$design);
            let built = Bearing::<$t, $n>::new(black_box(&$design)).unwrap();
            // Digits that read back to the same bits, the sign of 0 included.
            assert_eq!(format!("{BUILT:?}"), format!("{built:?}"));
            assert_eq!(BUILT, built);
            assert_eq!(BUILT, <$t as Real>::bearing(black_box(&$design)).unwrap());
        })*};
    }
    same! {
        f32 16 B7005C f64 16 B7005C
        f32 16 B218 f64 16 B218
        f32 9 SKF6205 f64 9 SKF6205
        f32 17 HYBRID f64 17 HYBRID
    }
}

//! Judges the answers of a scene by the reference build, restricted as the scene is.

use crate::solvers::{AnySolver, Found, Restricted, Working};
use host_tests::campaign::families::{Tick, Trial};
use host_tests::cases::Case;
use host_tests::compare::{Ball, Equilibrium, Errors, worse};
use host_tests::dispatch::{Attitude, Precision};
use host_tests::reference::{self, Reference};
use host_tests::tolerances::allowed_at;
use spindle_bearing::Given;
use spindle_bearing::{BallState, FreeContact, Status};
use std::array::from_fn;
use std::f64::consts::TAU;

/// A scene's answer among five freedoms: those that it does not have are as in `truth`, and so is what its one ball says
/// of the others.
fn among_five(found: &Found, truth: &Equilibrium) -> Equilibrium {
    let mut whole = truth.clone();
    for (i, u) in found.u.iter().enumerate() {
        whole.displacement[i] = *u;
    }
    for (i, row) in found.k.iter().enumerate() {
        for (j, element) in row.iter().enumerate() {
            whole.stiffness[i][j] = *element;
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

/// Forces of a ball by the textbook.
struct BallForces {
    /// On the inner ring, axial and radial, and the moment of its friction.
    axial: f64,
    radial: f64,
    friction_moment: f64,
    /// What its own balance leaves, axial and radial.
    left: [f64; 2],
}

impl BallForces {
    fn of(case: &Case, rule: Attitude, ball: &BallState<f64>) -> Self {
        let d = case.design.ball_diameter;
        let (q_i, q_o) = (ball.q_i, ball.q_o);
        let shares = match rule {
            // A ball that has dropped out has no contact forces.
            Attitude::Raceless if q_i + q_o <= 0.0 => [0.0, 0.0],
            Attitude::Raceless => [q_i, q_o].map(|q| 2.0 * q / (q_i + q_o)),
            Attitude::Inner if q_i > 0.0 => [1.0, 1.0],
            Attitude::Inner | Attitude::Outer => [0.0, 2.0],
        };
        let [inner, outer] = shares.map(|share| share * ball.gyroscopic_moment / d);
        let ((si, ci), (so, co)) = (ball.alpha_i.sin_cos(), ball.alpha_o.sin_cos());
        let (axial, radial) = (q_i * si + inner * ci, q_i * ci - inner * si);
        Self {
            axial,
            radial,
            friction_moment: case.design.inner_groove_factor * d * inner,
            left: [
                axial - q_o * so - outer * co,
                radial - q_o * co + outer * so + ball.centrifugal_force,
            ],
        }
    }
}

/// Force and moment of balls on the inner ring. The last one stands for those that are missing.
fn carried(case: &Case, rule: Attitude, balls: &[BallState<f64>]) -> [f64; 5] {
    let design = &case.design;
    let li = (design.inner_groove_factor - 0.5) * design.ball_diameter;
    let (cos0, zp) = match design.free_contact {
        FreeContact::Angle(angle) => (angle.cos(), li * angle.sin()),
        FreeContact::DiametralClearance(clearance) => (
            1.0 - clearance.max(0.0) / (2.0 * design.centre_distance()),
            0.0,
        ),
    };
    let rp = 0.5 * design.pitch_diameter + li * cos0;
    let mut sum = [0.0; 5];
    for j in 0..case.balls {
        let ball = BallForces::of(case, rule, &balls[j.min(balls.len() - 1)]);
        let (s, c) = (design.first_ball + TAU * j as f64 / case.balls as f64).sin_cos();
        let moment = rp * ball.axial - zp * ball.radial - ball.friction_moment;
        let parts = [
            ball.axial,
            ball.radial * c,
            ball.radial * s,
            moment * s,
            -moment * c,
        ];
        for (sum, part) in sum.iter_mut().zip(parts) {
            *sum += part;
        }
    }
    sum
}

/// What is left of the balance of the ball that is worst off, N.
fn unbalanced(case: &Case, rule: Attitude, balls: &[BallState<f64>]) -> f64 {
    balls.iter().fold(0.0, |most, ball| {
        let [axial, radial] = BallForces::of(case, rule, ball).left;
        worse(most, axial.hypot(radial))
    })
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

/// How much more than the answer says of the error of its stiffness a ring with given displacements may have. Estimates
/// need not cover every answer: of these scenes, one on three balls is off by 1.5 times what its answer says.
const HELD_RING: f64 = 2.0;

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
pub struct Tally {
    pub solves: usize,
    pub judged: usize,
    pub refused: usize,
    pub unsolved: usize,
    pub unjudged: usize,
    /// Judged by the equations alone.
    loose: usize,
    /// Without an equilibrium that the reference build knew of; by inner race control only.
    pub none: usize,
    /// Where inner race control is torn between a ball on and off the inner race.
    jumping: usize,
    worst: Errors,
    pub complaints: Vec<String>,
}

impl Tally {
    pub fn line(&self, name: &str) -> String {
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
pub struct Scene {
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
    /// Of a ring with this many freedoms, some of which are held.
    pub fn of<T: Working, M: Restricted>(
        whole: &Reference,
        freedoms: usize,
        held: [bool; 5],
    ) -> Self {
        Self {
            motion: M::NAME,
            rule: M::RULE,
            reference: M::reference(whole),
            speed: M::speed,
            freedoms,
            free: from_fn(|i| i < freedoms && !held[i]),
            precision: T::PRECISION,
            epsilon: T::EPSILON.to_f64(),
            seen: |x| T::of(x).to_f64(),
        }
    }
}

/// Has all ticks of a trial solved, and judges the answers. Freedoms that are not free have the displacement `held`.
pub fn judge(
    trial: &Trial,
    scene: &Scene,
    held: [f64; 5],
    tally: &mut Tally,
    solver: &mut dyn AnySolver,
) {
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
        let given: Vec<Given<f64>> = (0..scene.freedoms)
            .map(|i| {
                if free[i] {
                    Given::Load(values[i])
                } else {
                    Given::Displacement(values[i])
                }
            })
            .collect();
        let answer = solver.ask(&given, tick.omega);
        let inputs = || values.iter().chain([&tick.omega]);
        if !inputs().all(|x| seen(x).is_finite()) {
            assert!(
                matches!(
                    answer,
                    Err(Status::NotFinite { .. } | Status::OutOfRange { .. })
                ),
                "{}: {answer:?}",
                case.name
            );
            continue;
        }
        let found = match answer {
            Ok(found) => found,
            // Their own loads are zero, or subnormal; or beyond what the model is for.
            Err(status @ (Status::Unloaded | Status::OutOfRange { .. })) => {
                let largest = values.iter().fold(0.0, |m, x| f64::max(m, x.abs()));
                let unloaded = status == Status::Unloaded;
                assert!(
                    if unloaded {
                        largest < 1e-12
                    } else {
                        largest.max(tick.omega.abs()) > 1e3
                    },
                    "{}: {status:?}, loads up to {largest}",
                    case.name
                );
                tally.refused += 1;
                continue;
            }
            Err(_) => {
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
        if free == [false; 5] && loaded == 0 {
            // Nothing holds a ring that no ball touches, and nothing pushes it.
            let forces = found.load.iter().chain(found.k.iter().flatten());
            if forces.copied().any(|x| x != 0.0) {
                tally.complaints.push(complain(format!("{found:?}")));
            }
            tally.judged += 1;
            continue;
        }
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
        let [displacement, force, mut stiffness] = found.estimate.map(|error| error.min(MOST));
        if free != [true; 5] && scene.freedoms == 5 {
            stiffness *= HELD_RING;
        }
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

        // And every ball is in balance.
        let left = unbalanced(case, rule, &found.balls) / size;
        if !(left <= bounds.force) {
            let allowed = bounds.force;
            tally.complaints.push(complain(format!(
                "a ball is out of balance by {left:.1e}; allowed {allowed:.1e}"
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
        let whole = among_five(&found, &exact);
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

//! Figures that runs draw, and laws of any answer and of any refusal.

use arbitrary::{Arbitrary, Error, Result, Unstructured};
use spindle_bearing::{
    BallState, Design, DesignError, ErrorEstimate, FreeContact, Growth, Material, Real, Settings,
    Status,
};
use std::collections::BTreeSet;
use std::f64::consts::PI;

/// Names of all the ways in which the solves of a run ended.
pub type Ends = BTreeSet<&'static str>;

/// The run that a target makes of an input.
pub fn run_of<'b, R: Arbitrary<'b>>(input: &'b [u8]) -> R {
    let run = R::arbitrary_take_rest(Unstructured::new(input));
    run.expect("bits of any number are a run")
}

/// Bound on the iteration limit, so that no run is slow because it is told to be.
const MOST_ITERATIONS: u16 = 400;

/// Mostly a number of the range, sometimes an end of it, now and then any number at all.
pub fn number(u: &mut Unstructured, least: f64, most: f64) -> Result<f64> {
    Ok(match u.arbitrary::<u8>()? {
        0..=223 => least + (most - least) * f64::from(u.arbitrary::<u16>()?) / 65535.0,
        224..=235 => least,
        236..=247 => most,
        248..=251 => f32::from_bits(u.arbitrary()?).into(),
        252.. => f64::from_bits(u.arbitrary()?),
    })
}

/// A number with all orders of magnitude alike.
pub fn magnitude(u: &mut Unstructured, least: f64, most: f64) -> Result<f64> {
    Ok(10f64.powf(number(u, least.log10(), most.log10())?))
}

/// Of either sign, or nothing, or any number at all.
pub fn signed(u: &mut Unstructured, least: f64, most: f64) -> Result<f64> {
    Ok(match u.arbitrary::<u8>()? {
        0..=79 => 0.0,
        80..=119 => -magnitude(u, least, most)?,
        120..=247 => magnitude(u, least, most)?,
        248.. => f64::from_bits(u.arbitrary()?),
    })
}

fn material(u: &mut Unstructured) -> Result<Material> {
    Ok(match u.arbitrary::<u8>()? {
        0..=127 => Material::STEEL,
        128..=191 => Material::SILICON_NITRIDE,
        192.. => Material {
            youngs_modulus: magnitude(u, 1e6, 1e13)?,
            poissons_ratio: number(u, 0.0, 0.5)?,
            density: magnitude(u, 1.0, 1e5)?,
        },
    })
}

/// Any design, mostly one that can be built.
pub fn design(u: &mut Unstructured) -> Result<Design> {
    let mut design = Design {
        ball_diameter: magnitude(u, 1e-5, 10.0)?,
        pitch_diameter: magnitude(u, 1.01, 1e4)?,
        inner_groove_factor: number(u, 0.501, 0.7)?,
        outer_groove_factor: number(u, 0.501, 0.7)?,
        free_contact: FreeContact::Angle(number(u, 0.0, 1.4)?),
        inner_shoulder_angle: number(u, 1.4, 1.6)?,
        outer_shoulder_angle: number(u, 1.4, 1.6)?,
        first_ball: number(u, -7.0, 7.0)?,
        ring: material(u)?,
        ball: material(u)?,
    };
    design.pitch_diameter *= design.ball_diameter;
    if u.arbitrary()? {
        let clearance = number(u, 0.0, 1.66)? * design.centre_distance();
        design.free_contact = FreeContact::DiametralClearance(clearance);
    }
    Ok(design)
}

/// Settings in the place of the default, now and then.
pub fn settings(u: &mut Unstructured) -> Result<Option<Settings<f64>>> {
    let settings = Settings {
        max_iterations: u.int_in_range(0..=MOST_ITERATIONS)?,
        tolerance: signed(u, 1e-20, 1.0)?,
    };
    Ok(u.ratio(1, 4)?.then_some(settings))
}

/// The settings of a run in a precision.
pub fn settings_in<T: Real>(settings: Option<Settings<f64>>) -> Settings<T> {
    settings.map_or_else(Settings::default, |s| Settings {
        max_iterations: s.max_iterations,
        tolerance: T::of(s.tolerance),
    })
}

/// Axial, radial and of the ball.
pub fn growth<T: Real>(lengths: [f64; 3]) -> Growth<T> {
    let [axial, radial, ball] = lengths.map(T::of);
    Growth {
        axial,
        radial,
        ball,
    }
}

/// As many as an array has.
pub fn several<T, const K: usize>(one: impl FnMut(usize) -> Result<T>) -> Result<[T; K]> {
    let several: Result<Vec<T>> = (0..K).map(one).collect();
    several?.try_into().map_err(|_| Error::IncorrectFormat)
}

/// Load capacity of the bearing, to an order of magnitude.
pub struct Scale {
    /// N and N m.
    pub load: [f64; 5],
    /// rad/s.
    pub speed: f64,
    /// m and rad.
    pub displacement: [f64; 5],
}

impl Scale {
    /// Of a bearing with so many balls.
    pub fn of(design: &Design, balls: usize) -> Self {
        let diameter = design.ball_diameter;
        let radius = design.pitch_diameter / 2.0;
        let distance = design.centre_distance();
        let softer = design.ring.youngs_modulus.min(design.ball.youngs_modulus);
        let force = softer * diameter.sqrt() * distance.powf(1.5);
        let mass = design.ball.density * PI / 6.0 * diameter.powi(3);
        let lengths = [1.0, 1.0, 1.0, radius, radius];
        Self {
            load: lengths.map(|length| force * balls as f64 * length),
            speed: (force / (mass * radius)).sqrt(),
            displacement: lengths.map(|length| distance / length),
        }
    }
}

/// Every figure of an answer.
#[derive(Debug)]
pub struct Answer<T> {
    /// How the solve ended.
    pub status: Status<T>,
    /// Iterations.
    pub iterations: u16,
    /// Estimated errors.
    pub error: ErrorEstimate<T>,
    /// All figures of ring and rows.
    pub figures: Vec<T>,
    /// All balls.
    pub balls: Vec<BallState<T>>,
}

/// An answer or a refusal.
pub type Asked<T> = std::result::Result<Answer<T>, Status<T>>;

/// A design that was refused is out of the range that its error names.
pub fn refused(error: &DesignError) -> Ends {
    assert!(
        !(error.value >= error.least && error.value <= error.most),
        "{error:?}"
    );
    Ends::from(["design"])
}

/// The figures that a status names are what it says of them.
pub fn assert_names<T: Real>(status: &Status<T>) {
    match *status {
        Status::NotFinite { value, .. } => assert!(!value.is_finite()),
        Status::OutOfRange { value, limit, .. } => {
            assert!(value.is_finite() && value.abs() > limit);
        }
        Status::Unseated { apart, .. } => assert!(apart.is_finite()),
        Status::Diverged { residual } => assert!(residual >= T::ZERO, "{status:?}"),
        _ => {}
    }
}

/// Looks at every figure of an answer; returns how the solve ended.
pub fn inspect<T: Real>(answer: Asked<T>, most_iterations: u16) -> Status<T> {
    let is_good = |status| matches!(status, Status::Converged | Status::PrecisionLimit);
    let answer = match answer {
        Ok(answer) => answer,
        Err(status) => {
            assert!(!is_good(status), "{status:?}");
            assert_names(&status);
            return status;
        }
    };
    assert!(is_good(answer.status) && answer.iterations <= most_iterations);
    assert_finite(&answer);
    answer.status
}

/// Every figure is a number, and errors and contact forces are not negative.
pub fn assert_finite<T: Real>(answer: &Answer<T>) {
    let error = &answer.error;
    for estimate in [error.displacement, error.force, error.stiffness] {
        assert!(estimate >= T::ZERO, "{error:?}");
    }
    let of_balls = answer.balls.iter().flat_map(|ball| {
        assert!(ball.q_i >= T::ZERO && ball.q_o >= T::ZERO, "{ball:?}");
        let (angles, inertia) = (
            [ball.azimuth, ball.alpha_i, ball.alpha_o],
            [ball.centrifugal_force, ball.gyroscopic_moment],
        );
        let contacts = [ball.q_i, ball.q_o, ball.delta_i, ball.delta_o];
        angles.into_iter().chain(contacts).chain(inertia)
    });
    let mut figures = answer.figures.iter().copied().chain(of_balls);
    assert!(figures.all(|x| x.is_finite()), "{answer:?}");
}

/// A refused input leaves a solver as it was; a solve that found nothing leaves it without history.
///
/// `probe` tells. Solvers are that after the solve, that before it, and a fresh one. The last question that was not refused.
pub fn unharmed<T: Real, S, Q>(
    ended: &Status<T>,
    [after, before, fresh]: [&S; 3],
    tried: Q,
    question: Q,
    probe: impl Fn(&S, &Q) -> String,
) -> Q {
    match ended {
        Status::NotFinite { .. } | Status::OutOfRange { .. } | Status::Unloaded => {
            let (after, before) = (probe(after, &tried), probe(before, &tried));
            assert_eq!(after, before, "{ended:?} has changed the solver");
            return tried;
        }
        Status::Diverged { .. } | Status::Indeterminate { .. } | Status::Unseated { .. } => {
            let (after, fresh) = (probe(after, &question), probe(fresh, &question));
            assert_eq!(after, fresh, "{ended:?} left something behind");
        }
        _ => {}
    }
    question
}

//! The stiffness: slope of the loads by the displacements, and its symmetries.

use super::solves::{Answer, Balls, GROWN, LIFTING, Question, SKEW, cold, lengths, solver};
use judge::cases::{B218, B7005C, SKF6205, rad_per_s};
use judge::compare::{Equilibrium, stiffness_error, worse};
use solvers::dispatch::Precision;
use spindle_bearing::Design;
use spindle_bearing::Growth;
use std::array::from_fn;

fn deepest(found: &Answer) -> f64 {
    let balls = found.rows[0].balls.iter();
    balls.fold(0.0, |m, b| worse(worse(m, b.delta_i), b.delta_o))
}

/// Derivative of `f` at 0 by central differences, Richardson-extrapolated: exact to `h^4`.
fn derivative(h: f64, mut f: impl FnMut(f64) -> [f64; 5]) -> [f64; 5] {
    let mut slope = |h: f64| -> [f64; 5] {
        let (a, b) = (f(h), f(-h));
        from_fn(|i| (a[i] - b[i]) / (2.0 * h))
    };
    let (wide, narrow) = (slope(h), slope(0.5 * h));
    from_fn(|i| (4.0 * narrow[i] - wide[i]) / 3.0)
}

/// A place at which a tangent is judged.
#[derive(Debug, Clone, Copy)]
struct Point<'d> {
    design: &'d Design,
    n: usize,
    balls: Balls,
    load: [f64; 5],
    rpm: f64,
    growth: Growth<f64>,
}

impl Point<'_> {
    /// The tangent of a solution for loads is the slope of the reactions to given displacements.
    fn assert_tangent(&self, bound: f64) {
        let mut solver = solver(self.design, self.n, Precision::F64, self.balls);
        let omega = rad_per_s(self.rpm);
        let at = solver.answer(&Question::load(self.load, omega).grown(self.growth));
        let unit = lengths(self.design);
        let mut k = [[0.0; 5]; 5];
        for j in 0..5 {
            let column = derivative(1e-3 * deepest(&at) / unit[j], |x| {
                let mut u = at.displacement;
                u[j] += x;
                let question = Question::load([0.0; 5], omega)
                    .holding([true; 5], u)
                    .grown(self.growth);
                solver.answer(&question).load
            });
            for i in 0..5 {
                k[i][j] = column[i];
            }
        }
        let error = stiffness_error(&k, &at.stiffness);
        assert!(error < bound, "{self:?}: {error:e}");
    }
}

const DIFFERENCES: f64 = 1e-9;

const LOAD_OF_218: [f64; 5] = [17_800.0, 900.0, 1500.0, -40.0, 25.0];

fn b7005c(balls: Balls, load: [f64; 5], rpm: f64) -> Point<'static> {
    Point {
        design: &B7005C,
        n: 16,
        balls,
        load,
        rpm,
        growth: Growth::NONE,
    }
}

#[test]
fn the_tangent_is_the_slope_of_forces() {
    for (balls, rpm) in [
        (Balls::Static, 0.0),
        (Balls::Free, 0.0),
        (Balls::Free, 5_000.0),
        (Balls::Free, 20_000.0),
        (Balls::Free, 40_000.0),
        (Balls::Centrifugal, 20_000.0),
        (Balls::Outer, 20_000.0),
        (Balls::Inner, 20_000.0),
    ] {
        b7005c(balls, SKEW, rpm).assert_tangent(DIFFERENCES);
    }
    for (balls, rpm) in [
        (Balls::Free, 3_000.0),
        (Balls::Free, 10_000.0),
        (Balls::Free, 15_000.0),
        (Balls::Centrifugal, 10_000.0),
        (Balls::Outer, 10_000.0),
        (Balls::Inner, 6_000.0),
    ] {
        let of_218 = Point {
            design: &B218,
            ..b7005c(balls, LOAD_OF_218, rpm)
        };
        of_218.assert_tangent(DIFFERENCES);
    }
    let deep_groove = Point {
        design: &SKF6205,
        n: 8,
        ..b7005c(Balls::Static, [100.0, 80.0, 10.0, 0.05, 0.1], 0.0)
    };
    deep_groove.assert_tangent(DIFFERENCES);
    for balls in [Balls::Static, Balls::Free, Balls::Outer, Balls::Inner] {
        let grown = Point {
            growth: GROWN,
            ..b7005c(balls, SKEW, 20_000.0)
        };
        grown.assert_tangent(DIFFERENCES);
    }
    // Balls are off the inner race.
    let found = cold(&B7005C, 16, Balls::Free, LIFTING, rad_per_s(40_000.0));
    assert!(
        Equilibrium::from(&found).unloaded_balls() > 0,
        "{:?}",
        found.rows[0].balls
    );
    b7005c(Balls::Free, LIFTING, 40_000.0).assert_tangent(1e-7);
}

#[test]
fn the_tangent_is_not_symmetric_at_speed_and_symmetric_at_rest() {
    let load = [17_800.0, 0.0, 0.0, 0.0, 0.0];
    // Plain SI, in which the tilts' elements are the small ones.
    let skewness = |balls: Balls, rpm: f64| {
        let k = cold(&B218, 16, balls, load, rad_per_s(rpm)).stiffness;
        let (mut skew, mut largest) = (0.0, 0.0);
        for (i, row) in k.iter().enumerate() {
            for (j, x) in row.iter().enumerate() {
                skew = worse(skew, (x - k[j][i]).abs());
                largest = worse(largest, x.abs());
            }
        }
        skew / largest
    };
    assert!(skewness(Balls::Free, 0.0) < 1e-13);
    assert!(skewness(Balls::Static, 0.0) < 1e-13);
    for (rpm, range) in [
        (6_000.0, 1e-5..1e-4),
        (10_000.0, 2e-4..2e-3),
        (15_000.0, 1e-3..1e-2),
    ] {
        let s = skewness(Balls::Free, rpm);
        assert!(range.contains(&s), "{rpm} rpm: asymmetry {s:.2e}");
    }
}

#[test]
fn a_pure_axial_load_leaves_the_stiffness_of_a_body_of_revolution() {
    for (design, n, balls, load, rpm) in [
        (&B218, 16, Balls::Free, 17_800.0, 10_000.0),
        (&B218, 16, Balls::Outer, 4_450.0, 6_000.0),
        (&B218, 16, Balls::Inner, 17_800.0, 6_000.0),
        (&B218, 16, Balls::Static, 17_800.0, 0.0),
        (&SKF6205, 8, Balls::Free, 100.0, 12_000.0),
    ] {
        let k = cold(design, n, balls, [load, 0.0, 0.0, 0.0, 0.0], rad_per_s(rpm)).stiffness;
        let mut round = [[0.0; 5]; 5];
        round[0][0] = k[0][0];
        for (i, j) in [(1, 2), (3, 4)] {
            round[i][i] = 0.5 * (k[i][i] + k[j][j]);
            round[j][j] = round[i][i];
        }
        for (i, j, m, n) in [(1, 4, 2, 3), (4, 1, 3, 2)] {
            round[i][j] = 0.5 * (k[i][j] - k[m][n]);
            round[m][n] = -round[i][j];
        }
        let error = stiffness_error(&k, &round);
        assert!(error < 1e-12, "{balls:?}, {load} N: {error:e}");
    }
}

//! What is reported of each load record: a summary of its equilibrium, small enough to send on.
//!
//! Firmware and host use this one path from record to report, so that their reports can be held
//! against each other to the last bit. The solver works in either precision; what is reported of it is
//! rounded to single.

use crate::float::Real;
use crate::limits::{LimitSet, Limits, Margin};
use crate::record::LoadRecord;
use crate::status::Status;
use crate::{Motion, Settings, Solution, Solver, Speed};

/// Stiffness and contact forces of a bearing under one [`LoadRecord`].
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Estimate {
    /// Sequence number of the record.
    pub sequence: u32,
    /// Time of the record, ms.
    pub time_ms: u32,
    /// Shaft speed, revolutions per minute.
    pub speed_rpm: f32,
    /// Diagonal of the stiffness matrix: `Kxx, Kyy, Kzz` (N/m), `Ktyty, Ktztz` (N m/rad).
    pub stiffness: [f32; 5],
    /// The off-diagonal stiffness `Kij` that couples most, SI units.
    ///
    /// Since their units differ, each is judged relative to the directions it couples, by `|Kij| / sqrt(|Kii Kjj|)`. Of
    /// several within a per cent, the first in row order is reported, so that rounding does not choose.
    pub coupling: f32,
    /// Its row `i`, 0 for x to 4 for the tilt about z.
    pub coupling_row: u8,
    /// Its column `j`.
    pub coupling_column: u8,
    /// Smallest contact force of a ball on the inner race, N; 0 if a ball is off that race.
    pub least_force: f32,
    /// Largest contact force of a ball on the inner race, N.
    pub largest_force: f32,
    /// How the solve ended.
    pub status: Status<f32>,
    /// Iterations that it took.
    pub iterations: u16,
    /// Physical limits that were passed.
    pub limits: LimitSet,
    /// The worst contact in view of the most serious of them.
    pub worst: Option<Margin<f32>>,
}

/// A record that has no equilibrium to report, and why.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Refusal {
    /// Sequence number of the record.
    pub sequence: u32,
    /// Time of the record, ms.
    pub time_ms: u32,
    /// Shaft speed, revolutions per minute.
    pub speed_rpm: f32,
    /// Why the solve was refused.
    pub status: Status<f32>,
}

impl Estimate {
    /// Solves the equilibrium under a record, from where the solver stands, sums it up, and holds it
    /// against the limits.
    ///
    /// # Errors
    ///
    /// The record's numbers and the status of a solve that gave no answer.
    pub fn of<T: Real, const N: usize, M: Motion>(
        solver: &mut Solver<'_, T, N, M>,
        record: &LoadRecord,
        settings: &Settings<T>,
        limits: &Limits<T>,
    ) -> Result<Self, Refusal> {
        let load = record.load().map(T::from_f32);
        let speed = Speed::rpm(T::from_f32(record.speed_rpm));
        match solver.solve(load, speed, settings) {
            Ok(solution) => Ok(Self::sum_up(record, &solution, limits)),
            Err(status) => Err(Refusal {
                sequence: record.sequence,
                time_ms: record.time_ms,
                speed_rpm: record.speed_rpm,
                status: status.to_f32(),
            }),
        }
    }

    /// Sums up the equilibrium under a record, and holds it against the limits.
    pub fn sum_up<T: Real, const N: usize, M: Motion>(
        record: &LoadRecord,
        solution: &Solution<'_, T, N, M, 5>,
        limits: &Limits<T>,
    ) -> Self {
        let k = solution.stiffness().map(|row| row.map(T::to_f32));
        let (row, column) = strongest_coupling(&k);
        let (mut least, mut largest) = (f32::INFINITY, 0.0);
        for force in solution.inner_forces().map(T::to_f32) {
            if force < least {
                least = force;
            }
            if force > largest {
                largest = force;
            }
        }
        let margins = solution.margins(limits);
        let passed = margins.passed();
        let worst = passed.iter().find_map(|limit| margins.get(limit));
        Self {
            sequence: record.sequence,
            time_ms: record.time_ms,
            speed_rpm: record.speed_rpm,
            stiffness: core::array::from_fn(|i| k[i][i]),
            coupling: k[row][column],
            coupling_row: row as u8,
            coupling_column: column as u8,
            least_force: least,
            largest_force: largest,
            status: solution.status.to_f32(),
            iterations: solution.iterations,
            limits: passed,
            worst: worst.map(|Margin { value, ball, race }| Margin {
                value: value.to_f32(),
                ball,
                race,
            }),
        }
    }

    /// Whether two estimates are the same to the last bit: unlike `==`, tells 0 from -0 and takes
    /// one and the same not-a-number for equal.
    pub fn same_bits(&self, other: &Self) -> bool {
        let floats = |e: &Self| {
            let [kx, ky, kz, kty, ktz] = e.stiffness;
            [
                e.speed_rpm,
                kx,
                ky,
                kz,
                kty,
                ktz,
                e.coupling,
                e.least_force,
                e.largest_force,
            ]
            .map(f32::to_bits)
        };
        let integers = |e: &Self| {
            (
                e.sequence,
                e.time_ms,
                e.coupling_row,
                e.coupling_column,
                e.iterations,
                e.limits,
            )
        };
        let worst = |e: &Self| e.worst.map(|x| (x.ball, x.race, x.value.to_bits()));
        integers(self) == integers(other)
            && floats(self) == floats(other)
            && worst(self) == worst(other)
            && self.status == other.status
    }
}

/// By how much `Kij^2 / |Kii Kjj|` must exceed that of an earlier element: a per cent of its root.
const CLEARLY: f32 = 1.02;

/// Row and column of the off-diagonal element that couples most; x, y if nothing couples.
pub(crate) fn strongest_coupling(k: &[[f32; 5]; 5]) -> (usize, usize) {
    let mut place = (0, 1);
    let mut strongest: f32 = 0.0;
    let per: [f32; 5] = core::array::from_fn(|i| 1.0 / k[i][i].abs());
    for i in 0..5 {
        for j in 0..5 {
            let ratio = (k[i][j] * per[i]) * (k[i][j] * per[j]);
            // False for 0/0, too: a direction without stiffness couples with nothing.
            if i != j && ratio > CLEARLY * strongest {
                strongest = ratio;
                place = (i, j);
            }
        }
    }
    place
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Bearing;
    use crate::{Design, FreeContact, Limit, Material};

    const DESIGN: Design = Design {
        ball_diameter: 6.35e-3,
        pitch_diameter: 36e-3,
        inner_groove_factor: 0.515,
        outer_groove_factor: 0.525,
        free_contact: FreeContact::Angle(15.0 * core::f64::consts::PI / 180.0),
        inner_shoulder_angle: Design::HIGHEST_SHOULDER,
        outer_shoulder_angle: Design::HIGHEST_SHOULDER,
        first_ball: 0.0,
        ring: Material::STEEL,
        ball: Material::STEEL,
    };

    const RECORD: LoadRecord = LoadRecord {
        sequence: 3,
        time_ms: 30,
        fx: 250.0,
        fy: 120.0,
        fz: -40.0,
        my: 0.2,
        mz: 0.1,
        speed_rpm: 12_000.0,
    };

    #[test]
    fn an_estimate_repeats_the_solution_it_sums_up() {
        let bearing = Bearing::<f32, 16>::new(&DESIGN).unwrap();
        let mut solver: Solver<'_, f32, 16> = Solver::new(&bearing);
        let settings = Settings::default();
        // So low that every ball passes it.
        let limits = Limits {
            peak_pressure: 1e7,
            ..Limits::default()
        };
        let estimate = Estimate::of(&mut solver, &RECORD, &settings, &limits).unwrap();
        let mut again: Solver<'_, f32, 16> = Solver::new(&bearing);
        let solution = again
            .solve(RECORD.load(), Speed::rpm(RECORD.speed_rpm), &settings)
            .unwrap();
        assert!(estimate.same_bits(&Estimate::sum_up(&RECORD, &solution, &limits)));
        let (i, j) = (estimate.coupling_row, estimate.coupling_column);
        assert_ne!(i, j);
        assert_eq!(
            estimate.coupling,
            solution.stiffness()[usize::from(i)][usize::from(j)]
        );
        let force = |q| solution.balls().any(|ball| ball.q_i == q);
        assert!(force(estimate.least_force) && force(estimate.largest_force));
        assert!(estimate.least_force < estimate.largest_force);
        assert_eq!((estimate.sequence, estimate.time_ms), (3, 30));
        let margins = solution.margins(&limits);
        assert_eq!(estimate.limits, margins.passed());
        assert!(estimate.limits.contains(Limit::PeakPressure));
        assert_eq!(estimate.worst, margins.get(Limit::PeakPressure));
    }

    #[test]
    fn a_load_that_is_no_number_is_refused_with_the_number_of_its_record() {
        let bearing = Bearing::<f32, 16>::new(&DESIGN).unwrap();
        let mut solver: Solver<'_, f32, 16> = Solver::new(&bearing);
        let record = LoadRecord {
            fy: f32::NAN,
            ..RECORD
        };
        let refusal = Estimate::of(
            &mut solver,
            &record,
            &Settings::default(),
            &Limits::default(),
        )
        .unwrap_err();
        assert_eq!((refusal.sequence, refusal.time_ms), (3, 30));
        assert_eq!(refusal.status.name(), "not-finite");
    }

    #[test]
    fn an_estimate_in_double_precision_agrees_with_one_in_single() {
        let (single, double) = (
            Bearing::<f32, 16>::new(&DESIGN).unwrap(),
            Bearing::<f64, 16>::new(&DESIGN).unwrap(),
        );
        let mut solver: Solver<'_, f32, 16> = Solver::new(&single);
        let a = Estimate::of(
            &mut solver,
            &RECORD,
            &Settings::default(),
            &Limits::default(),
        )
        .unwrap();
        let mut solver: Solver<'_, f64, 16> = Solver::new(&double);
        let b = Estimate::of(
            &mut solver,
            &RECORD,
            &Settings::default(),
            &Limits::default(),
        )
        .unwrap();
        for (a, b) in a.stiffness.into_iter().zip(b.stiffness) {
            assert!((a - b).abs() < 1e-3 * b, "{a} and {b}");
        }
        for (a, b) in [
            (a.least_force, b.least_force),
            (a.largest_force, b.largest_force),
        ] {
            assert!((a - b).abs() < 1e-4 * b, "{a} and {b}");
        }
        let loads = LoadRecord {
            my: f32::INFINITY,
            ..RECORD
        };
        let refusal = Estimate::of(
            &mut solver,
            &loads,
            &Settings::default(),
            &Limits::default(),
        )
        .unwrap_err();
        let status = Status::NotFinite {
            quantity: crate::Quantity::My,
            value: f32::INFINITY,
        };
        assert_eq!(refusal.status, status);
    }

    #[test]
    fn coupling_is_judged_relative_to_the_stiffnesses_it_joins() {
        let mut k = [[0.0; 5]; 5];
        for (i, row) in k.iter_mut().enumerate() {
            row[i] = if i < 3 { 1e8 } else { 1e3 };
        }
        assert_eq!(strongest_coupling(&k), (0, 1));
        k[1][2] = 1e6;
        k[4][1] = -1e5;
        assert_eq!(strongest_coupling(&k), (4, 1));
        k[1][4] = -0.999e5;
        assert_eq!(strongest_coupling(&k), (1, 4));
        k[4] = [0.0; 5];
        k[1][4] = 0.0;
        assert_eq!(strongest_coupling(&k), (1, 2));
    }

    #[test]
    fn same_bits_tells_zero_from_minus_zero() {
        let bearing = Bearing::<f32, 16>::new(&DESIGN).unwrap();
        let mut solver: Solver<'_, f32, 16> = Solver::new(&bearing);
        let a = Estimate::of(
            &mut solver,
            &RECORD,
            &Settings::default(),
            &Limits::default(),
        )
        .unwrap();
        let b = Estimate {
            least_force: 0.0,
            ..a
        };
        let c = Estimate {
            least_force: -0.0,
            ..a
        };
        assert!(b == c && !b.same_bits(&c));
        let d = Estimate {
            coupling: f32::NAN,
            ..a
        };
        let e = d;
        assert!(d != e && d.same_bits(&e));
    }
}

//! Displacements, stiffness and compliance as vectors and matrices of `nalgebra`.

use crate::ball::kinematics::Motion;
use crate::real::Real;
use crate::solver::solution::{Snapshot, Solution};
use crate::spindle::solution::{RowSolution, ShaftEnd, SpindleSnapshot, SpindleSolution};
use nalgebra::{SMatrix, SVector, Scalar};

/// The matrix of `nalgebra` with these rows.
///
/// `SMatrix::from` takes columns: of a stiffness by rows it makes the transposed matrix, without a word.
///
/// ```
/// let k = spindle_bearing::matrix(&[[1.0, 2.0], [3.0, 4.0]]);
/// assert_eq!(k[(0, 1)], 2.0);
/// ```
pub fn matrix<T: Scalar + Copy, const R: usize, const C: usize>(
    rows: &[[T; C]; R],
) -> SMatrix<T, R, C> {
    SMatrix::from_fn(|i, j| rows[i][j])
}

impl<T: Real + Scalar, const N: usize, M: Motion, const D: usize> Solution<'_, T, N, M, D> {
    /// [`Solution::displacement`] as a vector of `nalgebra`.
    pub fn displacement_vector(&self) -> SVector<T, D> {
        SVector::from(self.displacement)
    }

    /// [`Solution::stiffness`] as a matrix of `nalgebra`, rows are forces.
    ///
    /// ```
    /// use spindle_bearing::{Bearing, Design, Settings, Solver, Speed};
    /// let bearing = Bearing::<f64, 16>::new(&Design::angular_contact(6.35e-3, 36e-3, 15_f64.to_radians()))?;
    /// let mut solver = Solver::new(&bearing);
    /// let (load, speed) = ([1000.0, 200.0, 0.0, 0.0, 3.0], Speed::rpm(20_000.0));
    /// let solution = solver.solve(load, speed, &Settings::default())?;
    /// let k = solution.stiffness_matrix();
    /// assert_eq!(k[(0, 1)], solution.stiffness()[0][1]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn stiffness_matrix(&self) -> SMatrix<T, D, D> {
        matrix(&self.stiffness())
    }
}

impl<T: Real + Scalar, const N: usize, const D: usize> Snapshot<T, N, D> {
    /// The displacement as a vector of `nalgebra`.
    pub fn displacement_vector(&self) -> SVector<T, D> {
        SVector::from(self.displacement)
    }

    /// The stiffness as a matrix of `nalgebra`, rows are forces.
    pub fn stiffness_matrix(&self) -> SMatrix<T, D, D> {
        matrix(&self.stiffness)
    }
}

impl<T: Real + Scalar, const R: usize, const N: usize, M: Motion, const D: usize, const E: usize>
    SpindleSolution<'_, T, R, N, M, D, E>
{
    /// [`SpindleSolution::displacement`] as a vector of `nalgebra`.
    pub fn displacement_vector(&self) -> SVector<T, 5> {
        SVector::from(self.displacement)
    }

    /// [`SpindleSolution::stiffness`] as a matrix of `nalgebra`, rows are forces.
    pub fn stiffness_matrix(&self) -> SMatrix<T, 5, 5> {
        matrix(&self.stiffness())
    }

    /// [`SpindleSolution::stiffness_at`] as a matrix of `nalgebra`, rows are forces.
    pub fn stiffness_matrix_at(&self, end: &ShaftEnd<T>) -> SMatrix<T, 5, 5> {
        matrix(&self.stiffness_at(end))
    }

    /// [`SpindleSolution::compliance_at`] as a matrix of `nalgebra`, rows are displacements.
    pub fn compliance_matrix_at(&self, end: &ShaftEnd<T>) -> SMatrix<T, 5, 5> {
        matrix(&self.compliance_at(end))
    }
}

impl<T: Real + Scalar, const R: usize, const N: usize> SpindleSnapshot<T, R, N> {
    /// The displacement as a vector of `nalgebra`.
    pub fn displacement_vector(&self) -> SVector<T, 5> {
        SVector::from(self.displacement)
    }

    /// The stiffness as a matrix of `nalgebra`, rows are forces.
    pub fn stiffness_matrix(&self) -> SMatrix<T, 5, 5> {
        matrix(&self.stiffness)
    }
}

impl<T: Real + Scalar, M: Motion> RowSolution<'_, T, M> {
    /// [`RowSolution::stiffness`] as a matrix of `nalgebra`, rows are forces.
    pub fn stiffness_matrix(&self) -> SMatrix<T, 5, 5> {
        matrix(&self.stiffness())
    }
}

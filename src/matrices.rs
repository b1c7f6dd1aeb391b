//! Stiffness and compliance as matrices of `nalgebra`.

use nalgebra::{SMatrix, Scalar};

/// The matrix of `nalgebra` with these rows.
///
/// `SMatrix::from` takes columns: of a stiffness by rows it makes the transposed matrix, without a word.
///
/// ```
/// use spindle_bearing::{Bearing, Design, Settings, Solver, Speed, matrix};
/// let bearing = Bearing::<f64, 16>::new(&Design::angular_contact(6.35e-3, 36e-3, 15_f64.to_radians()))?;
/// let (load, speed) = ([1000.0, 200.0, 0.0, 0.0, 3.0], Speed::rpm(20_000.0));
/// let mut solver = Solver::new();
/// let solution = solver.solve(&bearing, load, speed, &Settings::default())?;
/// let k = matrix(&solution.stiffness());
/// // At speed, it is not symmetric.
/// assert_eq!(k[(0, 1)], solution.stiffness()[0][1]);
/// assert_ne!(k[(0, 1)], k[(1, 0)]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn matrix<T: Scalar + Copy, const R: usize, const C: usize>(
    rows: &[[T; C]; R],
) -> SMatrix<T, R, C> {
    SMatrix::from_fn(|i, j| rows[i][j])
}

//~ cannot index into a value of type `NotPutOut`
use spindle_bearing::*;

#[cfg(good)]
type Output = Stiffness;
#[cfg(not(good))]
type Output = Displacements;

pub fn stiffness(solver: &mut Solver<'_, f32, 16, Full, Axial, Loads, Output>) -> f32 {
    match solver.solve([1000.0], 0.0, &Settings::default()) {
        Ok(solution) => solution.stiffness[0][0],
        Err(_) => 0.0,
    }
}

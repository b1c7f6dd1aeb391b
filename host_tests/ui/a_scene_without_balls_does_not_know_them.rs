//~ does not know its balls
//~ give the solver the output `Balls`
use spindle_bearing::*;

#[cfg(good)]
type Output = Balls;
#[cfg(not(good))]
type Output = Stiffness;

pub fn loaded(solver: &mut Solver<'_, f32, 16, Full, All, Loads, Output>) -> usize {
    let load = [1000.0, 0.0, 0.0, 0.0, 0.0];
    match solver.solve(load, 0.0, &Settings::default()) {
        Ok(solution) => solution.balls().filter(|ball| ball.q_i > 0.0).count(),
        Err(_) => 0,
    }
}

//! Error of the displacement at the nose by the accuracy of the loads.
//!
//! `e_i = sum of abs(C_ij) a_j`: by the accuracy `a` of the loads, and displacements `C` at the nose per load where loads are measured.
//! The changes add up, since each load may be off in either direction.

use crate::settings::ShaftSettings;

/// Compliance at a position of the shaft.
type Compliance = [[f32; 5]; 5];

/// The position nearest to the loads, between the nose and the row next to the nose. Beyond the nose, loads bend no part of the shaft that
/// moves the nose.
///
/// Between the rows of an elastic shaft, loads count as if they pressed a rigid arm of the row next to the nose.
pub(crate) fn place(shaft: &ShaftSettings, rows: impl Iterator<Item = f32>) -> f32 {
    let ends = rows.fold([f32::INFINITY, f32::NEG_INFINITY], |[low, high], x| {
        [low.min(x), high.max(x)]
    });
    let between = |x: f32, [a, b]: [f32; 2]| x.min(a.max(b)).max(a.min(b));
    let row = between(shaft.nose, ends);
    between(shaft.loads_at, [row, shaft.nose])
}

/// Errors (m) of the nose's translations, by the compliance at the [`place`].
pub(crate) fn errors(
    at_place: &Compliance,
    place: f32,
    shaft: &ShaftSettings,
    accuracy: &[f32; 5],
) -> [f32; 3] {
    let [to_loads, to_nose] = [shaft.loads_at - place, shaft.nose - place];
    let row = |i: usize| {
        let [x, y, z, ty, tz] = at_place[i];
        [x, y + to_loads * tz, z - to_loads * ty, ty, tz]
    };
    let [x, y, z, ty, tz] = [0, 1, 2, 3, 4].map(row);
    let sum = |along: [f32; 5], tilt: f32, with: [f32; 5]| {
        let parts = along.iter().zip(with).zip(accuracy);
        parts
            .map(|((c, turn), a)| (c + tilt * turn).abs() * a)
            .sum()
    };
    [sum(x, 0.0, ty), sum(y, to_nose, tz), sum(z, -to_nose, ty)]
}

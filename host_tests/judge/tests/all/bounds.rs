//! The type of a program, whose sizes are bounds, against the types that have no more than is there: their bits.

use cli::random::Random;
use judge::cases::B7005C;
use spindle_bearing::{
    Arrangement, Bearing, Design, Facing, FreeContact, Given, Growth, Material, Mounted, Preload,
    RacewayControlFree, Real, Section, Settings, Shaft, ShaftLoad, Speed, Spindle, SpindleSolution,
    SpindleSolver, Status, Support,
};
use spindle_file::mounting::{DynSolver, DynSpindle, growths};
use spindle_file::plan::{MOST_BALLS, MOST_ROWS};
use std::array::from_fn;

/// Balls of a row, and the number that its type has room for.
pub(super) const BALLS: usize = 16;
const SOLVES: usize = 250;
pub(super) const BY_ROWS: Arrangement = Arrangement::ByRows;

/// Rows that a test draws, and what is around them.
pub(super) struct Drawn<T> {
    pub(super) designs: Vec<Design>,
    pub(super) places: Vec<(T, Facing, Preload<T>)>,
    pub(super) sections: Vec<Section>,
    pub(super) supports: Vec<Support<T>>,
    pub(super) spring: Option<T>,
}

impl<T: Real> Drawn<T> {
    /// So many rows: the first half faces the other one, which slides under a spring if there is one.
    pub(super) fn of(rows: usize, is_sprung: bool, bends: bool, r: &mut Random) -> Self {
        let ahead = rows.div_ceil(2);
        let force = Preload::Force(T::of(r.log_between(50.0, 400.0)));
        let place = |i: usize, r: &mut Random| {
            let facing = if i < ahead {
                Facing::PlusX
            } else {
                Facing::MinusX
            };
            let held = match is_sprung || rows == 1 {
                true if i >= ahead => Preload::Spring,
                true => Preload::Closure(T::of(r.between(0.0, 5e-6))),
                false => force,
            };
            let x = 0.025 * i as f64 + if i < ahead { 0.0 } else { 0.1 };
            (T::of(x + r.between(-2e-3, 2e-3)), facing, held)
        };
        let support = |r: &mut Random| Support {
            axial: T::of(r.log_between(5e7, 1e9)),
            radial: T::of(r.log_between(5e7, 1e9)),
            tilting: T::of(r.log_between(1e4, 1e7)),
        };
        let design = |r: &mut Random| Design {
            free_contact: FreeContact::Angle(r.between(12.0, 30.0).to_radians()),
            pitch_diameter: B7005C.pitch_diameter * r.between(1.0, 1.3),
            ..B7005C
        };
        let section = Section {
            from: -0.1,
            to: 0.3,
            outer: 0.025,
            inner: 0.01,
        };
        Self {
            designs: (0..rows).map(|_| design(r)).collect(),
            places: (0..rows).map(|i| place(i, r)).collect(),
            sections: bends.then_some(section).into_iter().collect(),
            supports: (0..rows).filter(|_| bends).map(|_| support(r)).collect(),
            spring: is_sprung.then(|| T::of(r.log_between(50.0, 400.0))),
        }
    }

    pub(super) fn mounted<'b, const N: usize>(
        &self,
        bearings: &'b [Bearing<T, N>],
    ) -> Vec<Mounted<'b, T, N>> {
        let rows = self.places.iter().zip(bearings);
        rows.map(|((x, facing, held), bearing)| Mounted::new(bearing, *x, *facing).with(*held))
            .collect()
    }
}

/// The figures of an answer, as bits.
fn bits<T: Real, const R: usize, const N: usize, const D: usize, const E: usize>(
    answer: &Result<SpindleSolution<'_, T, R, N, RacewayControlFree, D, E>, Status<T>>,
) -> Result<Vec<u64>, String> {
    let answer = answer.as_ref().map_err(Status::to_string)?;
    let mut figures = answer.displacement.to_vec();
    figures.extend(answer.displacement_at(T::of(-0.07)));
    figures.extend(answer.stiffness().as_flattened());
    figures.extend(answer.compliance_at(T::of(-0.07)).as_flattened());
    let error = answer.error;
    figures.extend([error.displacement, error.force, error.stiffness]);
    for row in answer.rows() {
        figures.extend(row.force);
        figures.extend(row.stiffness().as_flattened());
        figures.extend(row.balls().flat_map(|ball| [ball.q_i, ball.q_o]));
    }
    let mut bits: Vec<u64> = figures.iter().map(|x| x.to_f64().to_bits()).collect();
    bits.push(answer.iterations.into());
    Ok(bits)
}

/// Solves both, question by question, from one solution to the next. How many have an answer.
fn compare<T: Real, const R: usize, const D: usize, const E: usize>(
    exact: &Spindle<'_, T, R, BALLS, D, E>,
    dynamic: &DynSpindle<'_, T>,
    r: &mut Random,
) -> usize {
    let mut solver = SpindleSolver::<T, R, BALLS, RacewayControlFree, D, E>::of();
    let (mut other, mut answers) = (DynSolver::<T>::new(), 0);
    let rows = dynamic.facings().len();
    for i in 0..SOLVES {
        let size = r.log_between(1.0, 2e3);
        let pressed = if rows == 1 { size } else { 0.0 };
        let mut load =
            [1.0, 1.0, 1.0, 0.02, 0.02].map(|arm| T::of(r.between(-0.5, 0.5) * arm * size));
        load[0] += T::of(pressed);
        let speed = Speed::rpm(T::of(r.zero_or(0.2, 0.0, 30e3)));
        let growth: [Growth<f64>; R] = from_fn(|_| Growth {
            radial: r.zero_or(0.5, 0.0, 3e-6),
            ..Growth::NONE
        });
        let settings = if r.chance(0.5) {
            Settings::TICK
        } else {
            Settings::DEFAULT
        };
        let given = from_fn(|i| match r.chance(0.4) {
            true => Given::Displacement(T::of(r.zero_or(0.3, -1.0, 1.0) * [1e-5, 1e-4][i / 3])),
            false => Given::Load(load[i]),
        });
        let placed = [ShaftLoad {
            position: T::of(-0.05),
            load,
        }];
        let (form, at) = (r.below(3), speed.with_growth(growths(&growth)));
        let found = bits(&match form {
            0 => solver.solve(exact, load, at, &settings),
            1 => solver.solve(exact, given, at, &settings),
            _ => solver.solve(exact, &placed, at, &settings),
        });
        let at = speed.with_growth(growths(&growth));
        let said = bits(&match form {
            0 => other.solve(dynamic, load, at, &settings),
            1 => other.solve(dynamic, given, at, &settings),
            _ => other.solve(dynamic, &placed, at, &settings),
        });
        answers += usize::from(found.is_ok());
        assert_eq!(
            found, said,
            "solve {i} of {rows} rows, {load:?}, {form}, {given:?}"
        );
    }
    answers
}

/// Rows of an exact type, which `build` mounts, and of the program's. How many solves have an answer.
fn answers<T: Real, const R: usize, const D: usize, const E: usize>(
    drawn: &Drawn<T>,
    r: &mut Random,
    build: impl for<'b> FnOnce(
        [Mounted<'b, T, BALLS>; R],
        &'b Shaft<T, 2>,
    ) -> Spindle<'b, T, R, BALLS, D, E>,
) -> usize {
    let designs = drawn.designs.iter();
    let exact = designs.clone().map(|of| Bearing::<T, BALLS>::of(of));
    let exact: Vec<_> = exact.map(Result::unwrap).collect();
    let dynamic = designs.map(|of| Bearing::<T, MOST_BALLS>::with_balls(of, BALLS).unwrap());
    let dynamic: Vec<_> = dynamic.collect();
    let shaft = Shaft::<T, 2>::new(&drawn.sections, &Material::STEEL).unwrap();
    let rows = drawn.mounted(&dynamic);
    let spindle = Spindle::of_rows(BY_ROWS, &rows, drawn.spring, &shaft, &drawn.supports);
    let rows = drawn.mounted(&exact);
    compare(&build(from_fn(|i| rows[i]), &shaft), &spindle.unwrap(), r)
}

fn rigid<T: Real, const R: usize>(r: &mut Random) -> usize {
    let drawn = Drawn::<T>::of(R, false, false, r);
    answers::<T, R, 5, 0>(&drawn, r, |rows, _| Spindle::new(BY_ROWS, rows).unwrap())
}

fn sprung<T: Real, const R: usize>(r: &mut Random) -> usize {
    let drawn = Drawn::<T>::of(R, true, false, r);
    let force = drawn.spring.unwrap();
    answers::<T, R, 6, 0>(&drawn, r, |rows, _| {
        Spindle::sprung(BY_ROWS, rows, force).unwrap()
    })
}

fn elastic<T: Real, const R: usize>(r: &mut Random) -> usize {
    let drawn = Drawn::<T>::of(R, false, true, r);
    answers::<T, R, 5, R>(&drawn, r, |rows, shaft| {
        let rigid = Spindle::new(BY_ROWS, rows).unwrap();
        rigid
            .elastic(shaft, from_fn(|i| drawn.supports[i]))
            .unwrap()
    })
}

/// One row, two, and as many as a program's, of each kind.
fn check<T: Real>() {
    let mut r = Random::seeded(3);
    let kinds = [
        rigid::<T, 1>,
        rigid::<T, 2>,
        rigid::<T, MOST_ROWS>,
        sprung::<T, 2>,
        sprung::<T, MOST_ROWS>,
        elastic::<T, 1>,
        elastic::<T, 2>,
        elastic::<T, MOST_ROWS>,
    ];
    let answers = kinds.map(|answers: fn(&mut Random) -> usize| answers(&mut r));
    assert!(
        answers.iter().all(|answers| *answers > SOLVES / 3),
        "{answers:?}"
    );
}

#[test]
fn a_spindle_of_bounds_has_the_bits_of_exact_types_in_single_precision() {
    check::<f32>();
}

#[test]
fn a_spindle_of_bounds_has_the_bits_of_exact_types_in_double_precision() {
    check::<f64>();
}

/// In whatever form the loads of a solve come, constant ones on a rigid shaft act besides.
#[test]
fn constant_loads_on_a_rigid_shaft_are_loads_at_their_place() {
    let bearing = Bearing::<f64, MOST_BALLS>::with_balls(&B7005C, BALLS).unwrap();
    let rows = [(0.0, Facing::PlusX), (0.1, Facing::MinusX)]
        .map(|(x, facing)| Mounted::new(&bearing, x, facing).with(Preload::Force(200.0)));
    let rigid = Shaft::<f64, 1>::new(&[], &Material::STEEL).unwrap();
    let spindle =
        || DynSpindle::of_rows(Arrangement::BackToBack, &rows, None, &rigid, &[]).unwrap();
    let belt = [ShaftLoad {
        position: 0.03,
        load: [0.0, 100.0, 0.0, 0.0, 0.0],
    }];
    let (plain, loaded) = (spindle(), spindle().with_loads(&belt).unwrap());
    let settings = Settings::default();
    let mut solver = DynSolver::<f64>::new();
    let truth = solver
        .solve(&plain, &belt, Speed::REST, &settings)
        .unwrap()
        .displacement;
    let mut solver = DynSolver::<f64>::new();
    let by_loads = solver
        .solve(&loaded, [0.0; 5], Speed::REST, &settings)
        .unwrap()
        .displacement;
    let given = [Given::Load(0.0); 5];
    let by_given = solver
        .solve(&loaded, given, Speed::REST, &settings)
        .unwrap()
        .displacement;
    let held = [0, 1, 2, 3, 4].map(|i| {
        if i == 4 {
            Given::Displacement(truth[4])
        } else {
            given[i]
        }
    });
    let held = solver.solve(&loaded, held, Speed::REST, &settings).unwrap();
    assert!(held.load[4].abs() < 1e-9, "{:?}", held.load);
    for u in [by_loads, by_given, held.displacement] {
        let off = (0..5).map(|i| (u[i] - truth[i]).abs()).fold(0.0, f64::max);
        assert!(off < 1e-15, "{u:?}, {truth:?}");
    }
}

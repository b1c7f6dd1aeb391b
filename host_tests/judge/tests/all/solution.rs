//! Snapshots and summaries of a solution.

use super::solves::SKEW;
use judge::cases::{B7005C, reference};
use judge::compare::Equilibrium;
use judge::reference::Task;
use judge::tolerances::allowed;
use serde::{Serialize, de::DeserializeOwned};
use solvers::dispatch::{Attitude, Precision};
use spindle_bearing::{
    Arrangement, Bearing, Design, FreeContact, LifeRating, Limit, Limits, Material, Preload,
    Section, Settings, Shaft, ShaftLoad, Snapshot, Solver, Speed, Spindle, SpindleSolver, Status,
    Support,
};
use spindle_file::plan::MOST_BALLS;
use std::array::from_fn;
use std::f64::consts::PI;
use std::fmt::Debug;

#[test]
fn a_snapshot_is_what_the_reference_build_says() {
    let bearing = Bearing::<f64, 16>::new(&B7005C).unwrap();
    let mut solver = Solver::new();
    let (mut of_spindles, alone) = (SpindleSolver::new(), Spindle::single(&bearing));
    let reference = reference(&B7005C, 16);
    for rpm in [0.0, 20_000.0, -20_100.0] {
        let speed = Speed::rpm(rpm);
        let solution = solver
            .solve(&bearing, SKEW, speed, &Settings::default())
            .unwrap();
        let copy = solution.snapshot();
        let [row] = copy.rows;
        // A bearing alone is one row, which has its load.
        let off = from_fn::<_, 5, _>(|i| row.force[i] - SKEW[i]);
        assert!(off.iter().all(|off| off.abs() < 1e-9), "{off:?}");
        let task = Task::new(SKEW, speed.as_rad_per_s(), Attitude::Raceless);
        let truth = reference.solve(&task);
        let found = Equilibrium {
            displacement: copy.displacement,
            stiffness: copy.stiffness,
            balls: row.balls.to_vec(),
        };
        let errors = found.errors(&truth.unwrap(), &B7005C);
        assert!(errors.within(allowed(Precision::F64)), "{rpm}: {errors}");
        assert_eq!((copy.load, copy.speed), (SKEW, speed));
        let by_spindle = of_spindles.solve(&alone, SKEW, speed, &Settings::default());
        assert_eq!(by_spindle.unwrap().snapshot(), copy);
        assert!(solution.inner_forces().eq(row.balls.map(|ball| ball.q_i)));
        // Cage speeds fit the centrifugal forces.
        let volume = PI / 6.0 * B7005C.ball_diameter.powi(3);
        let half_m_dm = 0.5 * B7005C.ball.density * volume * B7005C.pitch_diameter;
        assert!(solution.cage_speeds().eq(row.cage_speeds));
        for (ball, cage_speed) in row.balls.iter().zip(row.cage_speeds) {
            let expected = (ball.centrifugal_force / half_m_dm).sqrt().copysign(rpm);
            assert!(
                (cage_speed - expected).abs() <= 1e-12 * expected.abs(),
                "{rpm}"
            );
        }
    }
}

/// A summary has the figures that the solution's other methods give ball by ball.
#[test]
fn a_summary_is_what_the_balls_of_each_row_say() {
    let bearing = Bearing::<f64, 16>::new(&B7005C).unwrap();
    let rating = LifeRating::<f64>::new(&B7005C, 16, 13_700.0);
    let (arrangement, preload) = (Arrangement::BackToBack, Preload::Force(200.0));
    let pair = Spindle::pair(arrangement, &bearing, 0.1, preload).unwrap();
    let mut solver = SpindleSolver::new();
    let (load, limits) = ([100.0, 300.0, -50.0, 0.0, 2.0], Limits::default());
    let solution = solver.solve(&pair, load, Speed::rpm(20_000.0), &Settings::default());
    let solution = solution.unwrap();
    let rows: Vec<_> = solution.summary(&limits, &[rating; 2]).collect();
    let near = |a: f64, b: f64| assert!((a - b).abs() <= 1e-9 * b.abs(), "{a:e}, {b:e}");
    let range = |numbers: &mut dyn Iterator<Item = f64>| {
        numbers.fold([f64::INFINITY, f64::NEG_INFINITY], |[least, most], x| {
            [x.min(least), x.max(most)]
        })
    };
    let (mut life_rate, mut shares) = (0.0, [0.0; 2]);
    for (found, row) in rows.iter().zip(solution.rows()) {
        for i in 0..3 {
            near(found.force[i], row.force[i]);
        }
        near(found.preload, row.preload());
        let figures = [
            (
                found.inner_force,
                range(&mut row.balls().map(|ball| ball.q_i)),
            ),
            (
                found.outer_force,
                range(&mut row.balls().map(|ball| ball.q_o)),
            ),
            (
                found.inner_angle,
                range(&mut row.balls().map(|ball| ball.alpha_i)),
            ),
            (
                found.outer_angle,
                range(&mut row.balls().map(|ball| ball.alpha_o)),
            ),
        ];
        for (found, expected) in figures {
            near(found[0], expected[0]);
            near(found[1], expected[1]);
        }
        let [_, inner] = range(&mut row.kinematics().map(|ball| ball.inner.peak_pressure));
        let [_, outer] = range(&mut row.kinematics().map(|ball| ball.outer.peak_pressure));
        near(found.peak_pressure[0], inner);
        near(found.peak_pressure[1], outer);
        assert_eq!(found.frequencies, row.frequencies());
        assert_eq!(found.margins, row.margins(&limits));
        let life = row.rating_life(&rating);
        near(found.life_rate.powf(-0.9), life.million_revolutions);
        life_rate += found.life_rate;
        shares = [0, 1].map(|i| shares[i] + found.load_share[i]);
    }
    near(shares[0], 1.0);
    near(shares[1], 1.0);
    assert!(rows[0].load_share[1] > 0.5);
    let life = solution.rating_life(&[rating; 2]);
    near(life_rate.powf(-0.9), life.million_revolutions);
    near(life.hours * 60.0 * 0.02, life.million_revolutions);
}

/// A solver that turns to another bearing or spindle gives the bits of a cold one. Two solvers share a spindle.
#[test]
fn a_solver_that_turns_to_another_spindle_begins_anew() {
    let steeper = Design {
        free_contact: FreeContact::Angle(0.4),
        ..B7005C
    };
    let bearings = [B7005C, steeper].map(|design| Bearing::<f64, 16>::new(&design).unwrap());
    let (speed, settings) = (Speed::rpm(20_000.0), Settings::default());
    let mut turning = Solver::new();
    for bearing in bearings.iter().cycle().take(4) {
        let load = [800.0, 100.0, 0.0, 0.0, 1.0];
        let cold = Solver::new()
            .solve(bearing, load, speed, &settings)
            .unwrap()
            .snapshot();
        assert!(turning.unfinished(bearing).is_none());
        let found = turning.solve(bearing, load, speed, &settings).unwrap();
        assert_eq!(found.snapshot(), cold);
    }
    let pair = |x: f64, force: f64, spring: bool| {
        let preload = Preload::Force(force);
        let rigid = Spindle::pair(Arrangement::BackToBack, &bearings[0], x, preload).unwrap();
        let shaft = Shaft::<f64, 1>::new(&[], &Material::STEEL).unwrap();
        let radial = if spring { 4e8 } else { f64::INFINITY };
        let support = Support {
            radial,
            ..Support::RIGID
        };
        (rigid, shaft, support)
    };
    let mut turning = SpindleSolver::new();
    for (x, force, spring) in [
        (0.1, 200.0, true),
        (0.1, 210.0, true),
        (0.12, 210.0, true),
        (0.12, 210.0, false),
        (0.1, 200.0, true),
    ] {
        let (rigid, shaft, support) = pair(x, force, spring);
        let spindle = rigid.elastic(&shaft, [support; 2]).unwrap();
        for load in [SKEW, [100.0, 300.0, -50.0, 0.0, 2.0]] {
            let cold = SpindleSolver::new()
                .solve(&spindle, load, speed, &settings)
                .unwrap()
                .snapshot();
            turning.solve(&spindle, load, speed, &settings).unwrap();
            turning.reset();
            let found = turning.solve(&spindle, load, speed, &settings).unwrap();
            assert_eq!(found.snapshot(), cold);
        }
        let mut other = turning.clone();
        let [a, b] = [&mut turning, &mut other].map(|solver| {
            solver
                .solve(&spindle, SKEW, speed, &settings)
                .unwrap()
                .snapshot()
        });
        assert_eq!(a, b);
    }
    // Warm of the one before, and the bits of a cold one.
    for (x, force, spring) in [
        (0.1, 205.0, true),
        (0.101, 205.0, true),
        (0.101, 205.0, false),
    ] {
        let (rigid, shaft, support) = pair(x, force, spring);
        let spindle = rigid.elastic(&shaft, [support; 2]).unwrap();
        let cold = SpindleSolver::new()
            .solve(&spindle, SKEW, speed, &settings)
            .unwrap()
            .snapshot();
        let found = turning.solve(&spindle, SKEW, speed, &settings).unwrap();
        assert_eq!(found.snapshot(), cold);
    }
}

/// Loads that act elsewhere than at `x = 0` are the sum of forces and moments on a rigid shaft. An elastic one they deflect where they
/// act: as loads that act there at all times.
#[test]
fn loads_act_where_they_stand() {
    let bearing = Bearing::<f64, 16>::new(&B7005C).unwrap();
    let preload = Preload::Force(200.0);
    let rigid = Spindle::pair(Arrangement::BackToBack, &bearing, 0.1, preload).unwrap();
    let section = Section {
        from: -0.06,
        to: 0.16,
        outer: 0.02,
        inner: 0.0,
    };
    let shaft = Shaft::<f64, 1>::new(&[section], &Material::STEEL).unwrap();
    let loads = [
        ShaftLoad {
            position: -0.05,
            load: [-50.0, 120.0, -30.0, 0.0, 0.5],
        },
        ShaftLoad {
            position: 0.06,
            load: [0.0, 0.0, 60.0, 0.0, 0.0],
        },
        ShaftLoad {
            position: 0.15,
            load: [0.0, 40.0, -80.0, 0.0, 0.0],
        },
    ];
    let (speed, settings) = (Speed::rpm(12_000.0), Settings::default());
    let moved = loads.iter().fold([0.0; 5], |sum, at| {
        let [fx, fy, fz, my, mz] = at.load;
        let about = [fx, fy, fz, my - at.position * fz, mz + at.position * fy];
        from_fn(|i| sum[i] + about[i])
    });
    let near = |a: &[f64], b: &[f64], part: f64| {
        let size = b.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        a.iter().zip(b).all(|(a, b)| (a - b).abs() <= part * size)
    };
    let mut solver = SpindleSolver::new();
    let one = solver
        .solve(&rigid, &loads, speed, &settings)
        .unwrap()
        .snapshot();
    solver.reset();
    let other = solver
        .solve(&rigid, moved, speed, &settings)
        .unwrap()
        .snapshot();
    assert!(near(&one.displacement, &other.displacement, 1e-12));

    let elastic = rigid.elastic(&shaft, [Support::RIGID; 2]).unwrap();
    let constant = elastic.with_loads(&loads).unwrap();
    let (mut here, mut there) = (SpindleSolver::new(), SpindleSolver::new());
    let truth = there.solve(&constant, [0.0; 5], speed, &settings).unwrap();
    // From nothing, and from where other loads left it.
    for others in [&loads[..], &loads[..1], &loads[..]] {
        here.solve(&elastic, others, speed, &settings).unwrap();
        let found = here.solve(&elastic, &loads, speed, &settings).unwrap();
        for x in [-0.05, 0.0, 0.06, 0.15] {
            assert!(
                near(&found.displacement_at(x), &truth.displacement_at(x), 1e-10),
                "{x}"
            );
        }
        let forces = [&found, &truth].map(|s| s.rows().map(|row| row.force).collect::<Vec<_>>());
        assert!(near(
            forces[0].as_flattened(),
            forces[1].as_flattened(),
            1e-10
        ));
    }
    // What a stopped solve says of displacements where its loads had places, is that they are not known.
    here.reset();
    let stopped = here.solve(&elastic, &loads, speed, &Settings::TICK);
    assert_eq!(stopped.err(), Some(Status::IterationLimit));
    let reached = here.unfinished(&elastic).unwrap();
    assert!(reached.error.displacement >= 1.0 && reached.displacement_error_at(-0.05) > 0.5);
    // Elsewhere on a rigid shaft, the error of a solve to a tick's tolerance is no smaller than at the rows.
    let mut ticks = SpindleSolver::new();
    ticks.solve(&rigid, moved, speed, &settings).unwrap();
    let near_by = moved.map(|load| 1.05 * load);
    let tick = ticks
        .solve(&rigid, near_by, speed, &Settings::TICK)
        .unwrap();
    let precise = solver.solve(&rigid, near_by, speed, &settings).unwrap();
    for x in [-0.05, 0.0, 0.15] {
        let (found, true_u) = (tick.displacement_at(x), precise.displacement_at(x));
        assert!(
            near(&found[..3], &true_u[..3], tick.displacement_error_at(x)),
            "{x}"
        );
    }
    assert!(tick.displacement_error_at(0.05) > 0.5 * tick.error.displacement);
    let at_origin = here.solve(&elastic, moved, speed, &settings).unwrap();
    let [of_tool, of_truth] = [&at_origin, &truth].map(|s| s.displacement_at(-0.05)[1]);
    assert!(
        (of_tool / of_truth - 1.0).abs() > 0.02,
        "{of_tool} {of_truth}"
    );

    let refused = |position: f64, force: f64| {
        let load = [ShaftLoad {
            position,
            load: [force, 0.0, 0.0, 0.0, 0.0],
        }];
        let status = SpindleSolver::new()
            .solve(&elastic, &load, speed, &settings)
            .unwrap_err();
        status.to_string()
    };
    assert!(refused(f64::NAN, 1.0).contains("position"));
    assert!(refused(1e9, 1.0).contains("position"));
    assert!(refused(0.0, f64::INFINITY).contains("Fx"));
}

/// Results are read back as they were written, by a format with names and by one without: infinite numbers, numbers that are none,
/// and balls of any number, too.
#[test]
fn results_are_read_as_they_were_written() {
    fn again<T: Serialize + DeserializeOwned + Debug + PartialEq>(written: &T) {
        let is_read = |read: T| {
            assert_eq!(format!("{read:?}"), format!("{written:?}"));
            // But for numbers that are none: NaN is not equal to itself.
            let is_itself = written == written;
            assert_eq!(read == *written, is_itself, "{written:?}");
        };
        let text = serde_json::to_string(written).unwrap();
        is_read(serde_json::from_str(&text).unwrap_or_else(|error| panic!("{error}: {text}")));
        let mut bytes = [0; 16384];
        let bytes = postcard::to_slice(written, &mut bytes).unwrap();
        is_read(postcard::from_bytes(bytes).unwrap());
    }
    let bearing = Bearing::<f64, MOST_BALLS>::new(&Design {
        pitch_diameter: 144e-3,
        ..B7005C
    });
    let (bearing, mut solver) = (bearing.unwrap(), Solver::new());
    let (load, speed) = ([48_000.0, 0.0, 0.0, 0.0, 0.0], Speed::rpm(10_000.0));
    let settings = Settings::default();
    let solution = solver.solve(&bearing, load, speed, &settings).unwrap();
    again(&solution.snapshot());
    let rating = LifeRating::<f64>::new(&B7005C, 16, 13_700.0);
    let limits = Limits {
        peak_pressure: 1e9,
        friction: f64::INFINITY,
    };
    let summary = solution.summary(&limits, &rating);
    let passed = summary.margins.passed();
    assert!(passed.contains(Limit::PeakPressure));
    again(&passed);
    again(&limits);
    again(&Support::<f32>::RIGID);
    again(&summary);
    again(&summary.margins);
    // Margins of shoulders at any angle, from far inside to beyond a quarter turn; ratings of nothing.
    let mut margins = 0;
    for (low, force) in [0.3, 0.6, 1.0, 1.5]
        .into_iter()
        .flat_map(|low| [-200.0, 20.0, 3000.0, 2e4].map(|force| (low, force)))
    {
        let design = Design {
            inner_shoulder_angle: low,
            outer_shoulder_angle: low,
            ..B7005C
        };
        let bearing = Bearing::<f32, 16>::new(&design).unwrap();
        let mut solver = Solver::new();
        let load = [force, 0.4 * force, 10.0, 0.0, 0.1];
        let Ok(solution) = solver.solve(&bearing, load, Speed::rpm(15e3), &Settings::default())
        else {
            continue;
        };
        let rating = LifeRating::<f32>::new(&design, 16, 0.0);
        again(&solution.margins(&Limits::default()));
        again(&solution.summary(&Limits::default(), &rating));
        again(&solution.rating_life(&rating));
        again(&solution.balls().next());
        again(&solution.error);
        margins += 1;
    }
    assert!(margins >= 12, "{margins}");
    again(&solution.kinematics().next());
    again(&solution.frequencies());
    let text = serde_json::to_string(&solution.snapshot()).unwrap();
    let at_rest = solver
        .solve(&bearing, load, Speed::REST, &settings)
        .unwrap();
    let life = at_rest.rating_life(&rating);
    assert!(life.hours.is_infinite() && life.million_revolutions.is_finite());
    again(&life);
    again(&Bearing::<f32, MOST_BALLS>::new(&B7005C).unwrap_err());
    let refused = solver.solve(&bearing, [f64::NAN; 5], Speed::REST, &settings);
    again(&refused.unwrap_err());
    // An array of another length is refused.
    assert!(serde_json::from_str::<Snapshot<f64, 1, { MOST_BALLS - 1 }>>(&text).is_err());
    assert!(serde_json::from_str::<Snapshot<f64, 1, { MOST_BALLS + 1 }>>(&text).is_err());
}

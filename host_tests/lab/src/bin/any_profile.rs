//! A bearing and spindles on a rigid and on an elastic shaft, as `cargo check-firmware` wants them under profiles that inline less than the project's own:
//! see `bare_solver.rs`.

#![cfg_attr(target_os = "none", no_std)]
#![cfg_attr(target_os = "none", no_main)]

lab::image!(scenes::run);

#[cfg(target_os = "none")]
mod scenes {
    use core::hint::black_box;
    use spindle_bearing::{
        Arrangement, Bearing, Design, Facing, Growth, LifeRating, Limits, Material, Mounted,
        Preload, RacewayControlFree, Section, Settings, Shaft, ShaftLoad, Speed, Spindle,
        SpindleSolver, Support,
    };

    const DESIGN: Design = Design::angular_contact(6.35e-3, 50e-3, 15_f64.to_radians());
    /// Rows of a spindle, and balls of a row.
    const ROWS: usize = 5;
    const BALLS: usize = 22;
    static SINGLE: Bearing<f32, 16> = Bearing::<f32, 16>::const_new(&DESIGN);
    static ROW: Bearing<f32, BALLS> = Bearing::<f32, BALLS>::const_new(&DESIGN);
    const SOLID: Section = Section {
        from: -0.05,
        to: 0.2,
        outer: 0.03,
        inner: 0.0,
    };
    static SHAFT: Shaft<f32, 1> = Shaft::<f32, 1>::const_new(&[SOLID], &Material::STEEL);
    const RATING: LifeRating<f32> = LifeRating::<f32>::new(&DESIGN, BALLS, 13_700.0);

    pub fn run() {
        if option_env!("BARE_SOLVER").is_some() {
            return lab::spoiled();
        }
        lab::ring::<f32, 16, RacewayControlFree, 5>(&SINGLE);
        spindles();
    }

    fn spindles() {
        let rows = black_box([0.0_f32, 0.02, 0.04, 0.12, 0.14]).map(|position| {
            let (facing, preload) = black_box((Facing::PlusX, Preload::Closure(0.0)));
            Mounted::<f32, BALLS>::new(&ROW, position, facing).with(preload)
        });
        let preload = black_box(Preload::Force(200.0));
        let pair = Spindle::pair(Arrangement::BackToBack, &ROW, 0.1, preload);
        let supports = black_box([Support::RIGID; ROWS]);
        let loads = black_box([ShaftLoad {
            position: 0.2,
            load: [1.0; 5],
        }]);
        if let Ok(sprung) = Spindle::sprung(Arrangement::BackToBack, rows, black_box(1.0)) {
            ask(&sprung);
            if let Ok(elastic) = sprung.elastic(&SHAFT, supports)
                && let Ok(elastic) = elastic.with_loads(&loads)
            {
                ask(&elastic);
            }
        }
        if let Ok(pair) = pair
            && let Ok(elastic) = pair.elastic(&SHAFT, [supports[0]; 2])
        {
            ask(&elastic);
        }
    }

    fn ask<const R: usize, const D: usize, const E: usize>(
        spindle: &Spindle<'_, f32, R, BALLS, D, E>,
    ) {
        spindle.closures().zip(spindle.positions()).for_each(|row| {
            black_box(row);
        });
        let solver = &mut SpindleSolver::<f32, R, BALLS, RacewayControlFree, D, E>::of();
        while black_box(true) {
            let (load, speed) = black_box(([1.0; 5], Speed::rpm(1.0)));
            let at = speed.with_growth(black_box([Growth::NONE; R]));
            let solved = solver.solve(spindle, load, at, &black_box(Settings::TICK));
            let status = solved.map_or_else(|status| status, |solution| solution.status);
            black_box(status);
            let Some(solution) = solver.unfinished(spindle) else {
                continue;
            };
            let x = black_box(0.0);
            black_box((solution.snapshot(), solution.compliance_at(x)));
            black_box((solution.stiffness_at(x), solution.displacement_at(x)));
            let (limits, ratings) = (Limits::default(), black_box([RATING; R]));
            black_box(solution.rating_life(&ratings));
            for row in solution.summary(&limits, &ratings) {
                black_box(row);
            }
            for row in solution.rows() {
                black_box((row.preload(), row.force, row.stiffness()));
                black_box((row.margins(&limits).passed().bits(), row.frequencies()));
                row.inner_forces().for_each(|force| {
                    black_box(force);
                });
            }
        }
    }
}

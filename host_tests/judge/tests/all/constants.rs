//! Spindles that the compiler makes.

use cli::random::Random;
use judge::cases::{B7005C, SKF6205};
use spindle_bearing::{
    Arrangement, Bearing, ElasticSpindle, Facing, Material, Mounted, Preload, Section, Shaft,
    ShaftLoad, Spindle, SprungSpindle, Support,
};
use std::array::from_fn;

const SECTIONS: [Section; 2] = [
    Section {
        from: -0.05,
        to: 0.06,
        outer: 0.025,
        inner: 0.0,
    },
    Section {
        from: 0.06,
        to: 0.2,
        outer: 0.03,
        inner: 0.01,
    },
];

/// All numbers of a spindle, to the last bit.
fn bits(spindle: impl std::fmt::Debug) -> String {
    format!("{spindle:?}")
}

macro_rules! constants {
    ($t:ident) => {
        mod $t {
            use super::*;

            static BEARING: Bearing<$t, 16> = Bearing::<$t, 16>::const_new(&B7005C);
            static LOOSE: Bearing<$t, 9> = Bearing::<$t, 9>::const_new(&SKF6205);
            static SHAFT: Shaft<$t, 2> = Shaft::<$t, 2>::const_new(&SECTIONS, &Material::STEEL);
            static LOADS: [ShaftLoad<$t>; 2] = [
                ShaftLoad {
                    position: 0.15,
                    load: [0.0, 0.0, -80.0, 0.0, 0.0],
                },
                ShaftLoad {
                    position: -0.04,
                    load: [20.0, 3.0, 0.0, 0.1, -0.2],
                },
            ];
            const SUPPORTS: [Support<$t>; 3] = [
                Support::RIGID,
                Support {
                    radial: 3e8,
                    ..Support::RIGID
                },
                Support {
                    axial: 1e8,
                    radial: 2e8,
                    tilting: 1e5,
                },
            ];

            const fn row(at: $t, facing: Facing, preload: Preload<$t>) -> Mounted<'static, $t, 16> {
                Mounted::new(&BEARING, at, facing).with(preload)
            }

            const CLAMPED: [Mounted<$t, 16>; 3] = [
                row(-0.03, Facing::PlusX, Preload::Force(150.0)),
                row(0.01, Facing::PlusX, Preload::Closure(2e-6)),
                Mounted::new(&LOOSE, 0.1, Facing::MinusX).with(Preload::Force(200.0)),
            ];
            const SLIDING: [Mounted<$t, 16>; 3] = [
                row(-0.03, Facing::PlusX, Preload::Closure(0.0)),
                row(0.01, Facing::PlusX, Preload::Closure(-1e-6)),
                row(0.1, Facing::MinusX, Preload::Spring),
            ];
            const SET: Arrangement = Arrangement::BackToBack;

            static PRELOADED: Spindle<$t, 3, 16> = Spindle::<$t, 3, 16>::const_new(SET, CLAMPED);
            static SPRUNG: SprungSpindle<$t, 3, 16> =
                SprungSpindle::<$t, 3, 16>::const_sprung(SET, SLIDING, 200.0);
            static ELASTIC: ElasticSpindle<$t, 3, 16> =
                Spindle::<$t, 3, 16>::const_new(SET, CLAMPED)
                    .const_elastic(&SHAFT, SUPPORTS)
                    .const_with_loads(&LOADS);
            static ELASTIC_SPRUNG: ElasticSpindle<$t, 3, 16, 6> =
                SprungSpindle::<$t, 3, 16>::const_sprung(SET, SLIDING, 200.0)
                    .const_elastic(&SHAFT, SUPPORTS);

            #[test]
            fn spindles_of_the_compiler_have_the_bits_of_those_made_at_run_time() {
                let preloaded = Spindle::new(SET, CLAMPED).unwrap();
                assert_eq!(bits(preloaded), bits(PRELOADED));
                let sprung = Spindle::sprung(SET, SLIDING, 200.0).unwrap();
                assert_eq!(bits(sprung), bits(SPRUNG));
                let elastic = preloaded.elastic(&SHAFT, SUPPORTS).unwrap();
                assert_eq!(bits(elastic.with_loads(&LOADS).unwrap()), bits(ELASTIC));
                let elastic = sprung.elastic(&SHAFT, SUPPORTS).unwrap();
                assert_eq!(bits(elastic), bits(ELASTIC_SPRUNG));
            }

            #[test]
            fn random_spindles_have_equal_bits_by_either_way() {
                let mut random = Random::seeded(75);
                for _ in 0..300 {
                    let rows: [_; 3] = from_fn(|i| {
                        let facing = if i == 2 {
                            Facing::MinusX
                        } else {
                            Facing::PlusX
                        };
                        let at = 0.1 * (i as f64 - 1.0) + random.between(-0.04, 0.04);
                        let preload = if random.chance(0.5) {
                            Preload::Force(random.log_between(1e-3, 1e3) as $t)
                        } else {
                            Preload::Closure(random.between(-5e-6, 2e-5) as $t)
                        };
                        let row = if random.chance(0.5) {
                            Mounted::new(&BEARING, at as $t, facing)
                        } else {
                            Mounted::new(&LOOSE, at as $t, facing)
                        };
                        row.with(preload)
                    });
                    let rigid = Spindle::new(SET, rows).unwrap();
                    let constant = Spindle::<$t, 3, 16>::const_new(SET, rows);
                    assert_eq!(bits(rigid), bits(constant));
                    let touching = rows.map(|row| row.with(Preload::Closure(0.0)));
                    let sliding = [touching[0], touching[1], rows[2].with(Preload::Spring)];
                    let force = random.log_between(1.0, 1e3) as $t;
                    let sprung = Spindle::sprung(SET, sliding, force).unwrap();
                    let constant_sprung =
                        SprungSpindle::<$t, 3, 16>::const_sprung(SET, sliding, force);
                    assert_eq!(bits(sprung), bits(constant_sprung));
                    let supports = from_fn(|_| Support {
                        axial: random.log_between(1e7, 1e9) as $t,
                        radial: random.log_between(1e7, 1e9) as $t,
                        tilting: random.log_between(1e3, 1e6) as $t,
                    });
                    let loads: [_; 2] = from_fn(|_| ShaftLoad {
                        position: random.between(-0.3, 0.3) as $t,
                        load: from_fn(|_| random.between(-100.0, 100.0) as $t),
                    });
                    let elastic = rigid.elastic(&SHAFT, supports).unwrap();
                    let constant = constant.const_elastic(&SHAFT, supports);
                    assert_eq!(bits(elastic), bits(constant));
                    let loaded = elastic.with_loads(&loads).unwrap();
                    assert_eq!(bits(loaded), bits(constant.const_with_loads(&loads)));
                }
            }
        }
    };
}

constants!(f32);
constants!(f64);

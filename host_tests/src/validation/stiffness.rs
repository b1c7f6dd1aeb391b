//! Stiffness of a B7005C against speed under the study's six tilting moments.

use super::around::Tilt;
use super::figure::{
    Axis, BLUE, Curve, Dash, Figure, GREEN, INK, Marker, Panel, Pen, Plane, VERMILION,
};
use super::scene::{Scene, Solved, evenly, solve_all};
use super::statement::{Measure, Statement, Verdict, shown, with_digits};
use super::{Block, COMMAND, Chapter, Progress, Table, judged};
use crate::cases::{self, B7005C, rad_per_s};
use crate::compare::{stiffness_error, worse};
use crate::dispatch::Attitude;
use anyhow::Context;
use rayon::prelude::*;

const MOMENT: f64 = 3.0;
const TOP: f64 = 20_000.0;
const STEPS: usize = 40;

/// The six cases, in the order of the panels.
const CASES: [(Tilt, f64); 6] = [
    (Tilt::Mz, MOMENT),
    (Tilt::My, MOMENT),
    (Tilt::Both, MOMENT),
    (Tilt::Mz, -MOMENT),
    (Tilt::My, -MOMENT),
    (Tilt::Both, -MOMENT),
];

/// One case over the speeds.
type Run = Vec<Solved>;

/// An element of the stiffness: name, row, column.
#[derive(Debug, Clone, Copy)]
struct Element(&'static str, usize, usize);

const KXX: Element = Element("Kxx", 0, 0);
const KYY: Element = Element("Kyy", 1, 1);
const KZZ: Element = Element("Kzz", 2, 2);
const KTYTY: Element = Element("K_ty,ty", 3, 3);
const KTZTZ: Element = Element("K_tz,tz", 4, 4);
const KXY: Element = Element("Kxy", 0, 1);
const KXZ: Element = Element("Kxz", 0, 2);
const KYZ: Element = Element("Kyz", 1, 2);
const KXTY: Element = Element("K_x,ty", 0, 3);
const KXTZ: Element = Element("K_x,tz", 0, 4);
const KYTY: Element = Element("K_y,ty", 1, 3);
const KYTZ: Element = Element("K_y,tz", 1, 4);
const KZTY: Element = Element("K_z,ty", 2, 3);
const KZTZ: Element = Element("K_z,tz", 2, 4);
const KTYTZ: Element = Element("K_ty,tz", 3, 4);

const DIAGONAL: [Element; 5] = [KXX, KYY, KZZ, KTYTY, KTZTZ];
const UPPER: [Element; 10] = [KXY, KXZ, KYZ, KXTY, KXTZ, KYTY, KYTZ, KZTY, KZTZ, KTYTZ];

impl Element {
    /// In SI units.
    fn of(self, solved: &Solved) -> f64 {
        solved.k[self.1][self.2]
    }

    fn over(self, run: &Run) -> Vec<f64> {
        run.iter().map(|s| self.of(s)).collect()
    }

    /// The unit it is shown in, and what turns SI units into it.
    fn unit(self) -> (&'static str, f64) {
        match (self.1, self.2) {
            (0..=2, 0..=2) => ("N/\u{b5}m", 1e-6),
            (0..=2, _) => ("N/mrad", 1e-3),
            _ => ("N m/mrad", 1e-3),
        }
    }

    fn shown(self, solved: &Solved) -> f64 {
        self.unit().1 * self.of(solved)
    }

    /// It is no more than rounding under this load.
    fn vanishes(self, solved: &Solved) -> bool {
        let diagonal = solved.k[self.1][self.1] * solved.k[self.2][self.2];
        self.of(solved).abs() < 1e-9 * diagonal.abs().sqrt()
    }
}

fn scenes(design_balls: usize, load: [f64; 5], rpm: impl IntoIterator<Item = f64>) -> Vec<Scene> {
    rpm.into_iter()
        .map(|rpm| Scene {
            name: "B7005C",
            design: B7005C,
            balls: design_balls,
            attitude: Attitude::Raceless,
            load,
            rpm,
        })
        .collect()
}

/// One a case.
const PENS: [Pen; 6] = [
    Pen(BLUE, Dash::Solid, Marker::Square),
    Pen(VERMILION, Dash::Solid, Marker::Triangle),
    Pen(GREEN, Dash::Solid, Marker::Disc),
    Pen(BLUE, Dash::Long, Marker::Ring),
    Pen(VERMILION, Dash::Short, Marker::Cross),
    Pen(INK, Dash::Dots, Marker::None),
];

/// A panel per element: of each case that has the element, the curve `of` makes of it.
fn figure(
    name: &'static str,
    what: &str,
    elements: &[Element],
    runs: &[Run],
    label: impl Fn(Element) -> String,
    of: impl Fn(Element, &Run) -> Option<Vec<f64>>,
) -> Figure {
    let panel = |element: &Element| Panel {
        title: element.0.to_owned(),
        plane: Plane::Straight {
            x: Axis::from_zero("speed / 1000 rpm"),
            y: Axis::new(label(*element)),
        },
        curves: runs
            .iter()
            .zip(PENS)
            .enumerate()
            .filter_map(|(i, (run, pen))| {
                let values = of(*element, run)?;
                let speeds = run.iter().map(|s| s.scene.rpm / 1e3);
                Some(Curve::through(pen, speeds.zip(values).collect(), 2 * i, 4))
            })
            .collect(),
        nodes: Vec::new(),
    };
    let names = CASES
        .iter()
        .map(|(tilt, moment)| format!("{} = {moment:+} N m", tilt.symbol()));
    Figure {
        name,
        title: format!("B7005C, Fx = 1000 N, 200 N radial: {what} against speed"),
        caption: format!(
            "{}{} against speed under the six moments. Regenerate with `{COMMAND}`.",
            what[..1].to_uppercase(),
            &what[1..]
        ),
        legend: PENS.into_iter().zip(names).collect(),
        columns: 3,
        panels: elements.iter().map(panel).collect(),
    }
}

fn figures(runs: &[Run]) -> [Figure; 3] {
    let absolute =
        |element: Element, run: &Run| Some(run.iter().map(|s| element.shown(s)).collect());
    let unit = |element: Element| format!("{} / ({})", element.0, element.unit().0);
    let relative = |element: Element, run: &Run| {
        let (start, values) = (element.of(&run[0]), run.iter());
        let change = values.map(|s| 100.0 * (element.of(s) / start - 1.0));
        (!element.vanishes(&run[0])).then(|| change.collect())
    };
    [
        figure(
            "stiffness_diagonal",
            "diagonal stiffness",
            &DIAGONAL,
            runs,
            unit,
            absolute,
        ),
        figure(
            "stiffness_off_diagonal",
            "off-diagonal stiffness",
            &UPPER,
            runs,
            unit,
            absolute,
        ),
        figure(
            "stiffness_off_diagonal_change",
            "change of the off-diagonal stiffness since rest",
            &UPPER,
            runs,
            |_| "change / %".to_owned(),
            relative,
        ),
    ]
}

/// The upper half of the stiffness at rest and at the top speed.
fn table(runs: &[Run]) -> Table {
    let mut rows = Vec::new();
    for element in DIAGONAL.iter().chain(&UPPER) {
        for end in [0, STEPS] {
            let mut row = vec![
                format!("{} / ({})", element.0, element.unit().0),
                shown(runs[0][end].scene.rpm),
            ];
            row.extend(runs.iter().map(|run| {
                let solved = &run[end];
                if element.vanishes(solved) {
                    "0".to_owned()
                } else {
                    with_digits(element.shown(solved), 5)
                }
            }));
            rows.push(row);
        }
    }
    let mut head = vec![String::new(), "rpm".to_owned()];
    let names = CASES
        .iter()
        .map(|(tilt, moment)| format!("{} = {moment:+} N m", tilt.symbol()));
    head.extend(names);
    Table {
        caption: "Stiffness at rest and at 20,000 rpm.".to_owned(),
        head,
        rows,
    }
}

/// The largest step up of a sequence, over its largest size; negative if it falls throughout.
fn largest_rise(values: &[f64]) -> f64 {
    let size = values.iter().fold(0.0, |m, v| worse(m, v.abs()));
    let steps = values.windows(2).map(|w| (w[1] - w[0]) / size);
    steps.fold(f64::NEG_INFINITY, worse)
}

/// How much a sequence rises above its start at most, over the start.
fn rise_above_start(values: &[f64]) -> f64 {
    values
        .iter()
        .fold(0.0, |m, v| worse(m, v / values[0] - 1.0))
}

/// Change from first to last, %.
fn change(values: &[f64]) -> f64 {
    100.0 * (values[values.len() - 1] / values[0] - 1.0)
}

fn falls(element: Element, run: &Run) -> [Measure; 2] {
    let values = element.over(run);
    [
        Measure::within(
            format!("{}: change over the range", element.0),
            change(&values),
            "%",
            -100.0,
            0.0,
        ),
        Measure::below(
            format!("{}: largest step", element.0),
            100.0 * largest_rise(&values),
            "%",
            0.0,
        ),
    ]
}

/// The least of `a/b - 1` and the largest, %.
fn excess(a: Element, b: Element, run: &Run) -> (f64, f64) {
    let ratios = run.iter().map(|s| 100.0 * (a.of(s) / b.of(s) - 1.0));
    ratios.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), r| {
        (l.min(r), h.max(r))
    })
}

fn extreme(element: Element, run: &Run, scale: f64) -> (f64, f64) {
    let values = run.iter().map(|s| scale * element.of(s));
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| {
        (l.min(v), h.max(v))
    })
}

fn item_3(over: &Run, back: &Run, without_moment: &[f64]) -> Vec<Statement> {
    let (y_least, y_most) = excess(KYY, KZZ, over);
    let (t_least, t_most) = excess(KTZTZ, KTYTY, over);
    let (back_least, back_most) = excess(KYY, KZZ, back);
    // A negative element that rises is one whose negative falls.
    let rises = |element: Element| {
        let values: Vec<f64> = element.over(over).iter().map(|v| -v).collect();
        vec![
            Measure::below(
                format!("{}: largest value", element.0),
                -element.unit().1 * values.iter().fold(f64::INFINITY, |m, v| m.min(*v)),
                element.unit().0,
                0.0,
            ),
            Measure::within(
                format!("{}: change of its size over the range", element.0),
                change(&values),
                "%",
                -100.0,
                0.0,
            ),
            Measure::below(
                format!("{}: largest step of its size", element.0),
                100.0 * largest_rise(&values),
                "%",
                0.0,
            ),
        ]
    };
    let positive_falls = |element: Element, run: &Run| {
        let (unit, scale) = element.unit();
        let (least, _) = extreme(element, run, scale);
        let mut measures = vec![Measure::above(
            format!("{}: least value", element.0),
            least,
            unit,
            0.0,
        )];
        measures.extend(falls(element, run));
        measures
    };
    let kxy = KXY.over(back);
    let peak = kxy
        .iter()
        .enumerate()
        .max_by(|a, b| a.1.total_cmp(b.1))
        .map_or(0, |(i, _)| i);
    vec![
        Statement::of(
            "item 3",
            "`Mz` = +3 N m: all diagonal stiffness falls with speed.",
            DIAGONAL.iter().flat_map(|e| falls(*e, over)).collect(),
        ),
        Statement::of(
            "item 3",
            "`Mz` = +3 N m: `Kyy > Kzz`.",
            vec![
                Measure::above("least excess", y_least, "%", 0.0),
                Measure::above("largest", y_most, "%", 0.0),
            ],
        ),
        Statement::of(
            "item 3",
            "`Mz` = +3 N m: `K_tz,tz > K_ty,ty`.",
            vec![
                Measure::above("least excess", t_least, "%", 0.0),
                Measure::above("largest", t_most, "%", 0.0),
            ],
        ),
        Statement::of("item 3", "`Mz` = +3 N m: `Kxy < 0`, rising with speed.", rises(KXY)),
        Statement::of("item 3", "`Mz` = +3 N m: `K_y,tz < 0`, rising with speed.", rises(KYTZ)),
        Statement::of("item 3", "`Mz` = +3 N m: `K_x,tz > 0`, falling with speed.", positive_falls(KXTZ, over)),
        Statement::of("item 3", "`Mz` = +3 N m: `K_z,ty > 0`, falling with speed.", positive_falls(KZTY, over)),
        Statement::of(
            "item 3",
            "`Mz` = -3 N m: `Kyy` is close to `Kzz`.",
            vec![
                Measure::within("least excess of `Kyy`", back_least, "%", 0.0, 2.0),
                Measure::within("largest", back_most, "%", 0.0, 2.0),
                Measure::above("largest with `Mz` = +3 N m over largest with -3 N m", y_most / back_most, "", 3.0),
            ],
        ),
        Statement::of(
            "item 3",
            "`Mz` = -3 N m: `Kxy > 0`, falling with speed.",
            vec![
                Measure::above("`Kxy`: least value", extreme(KXY, back, 1e-6).0, "N/\u{b5}m", 0.0),
                Measure::within("`Kxy`: change over the range", change(&kxy), "%", -100.0, 0.0),
                Measure::within("`Kxy`: largest rise above its value at rest", 100.0 * rise_above_start(&kxy), "%", 0.0, 0.1),
                Measure::below(
                    "largest step without `mt`",
                    100.0 * largest_rise(without_moment),
                    "%",
                    0.0,
                ),
                Measure::within("reached at", back[peak].scene.rpm, "rpm", 0.0, 10_000.0),
            ],
        )
        .but(
            Verdict::InPart,
            "It is positive and ends lower, but does not fall from the start: up to some thousand rpm \
             it rises, by less than a thousandth. That comes with the friction moment `mt` on the ring: a \
             reference build that leaves it out has the stiffness fall throughout.",
        ),
    ]
}

/// Largest error of the stiffness under the load turned by 90 degrees against the first one's,
/// turned, over the speeds.
fn turned_by_90_degrees(one: &Run, other: &Run) -> f64 {
    // y -> z, z -> -y, for forces as for moments.
    const FROM: [(usize, f64); 5] = [(0, 1.0), (2, -1.0), (1, 1.0), (4, -1.0), (3, 1.0)];
    one.iter().zip(other).fold(0.0, |m, (a, b)| {
        let turned = std::array::from_fn(|i| {
            std::array::from_fn(|j| {
                let ((from_i, si), (from_j, sj)) = (FROM[i], FROM[j]);
                si * sj * a.k[from_i][from_j]
            })
        });
        worse(m, stiffness_error(&b.k, &turned))
    })
}

/// Largest relative difference of the diagonal elements that turning by 90 degrees should swap.
fn swapped(one: &Run, other: &Run) -> f64 {
    let pairs = [(KYY, KZZ), (KZZ, KYY), (KTYTY, KTZTZ), (KTZTZ, KTYTY)];
    one.iter().zip(other).fold(0.0, |m, (a, b)| {
        pairs
            .iter()
            .fold(m, |m, (p, q)| worse(m, (p.of(a) / q.of(b) - 1.0).abs()))
    })
}

/// Largest difference of the two halves of the stiffness, in units of its diagonal.
fn skewness(run: &Run) -> f64 {
    run.iter().fold(0.0, |m, s| {
        let transposed = std::array::from_fn(|i| std::array::from_fn(|j| s.k[j][i]));
        worse(m, stiffness_error(&transposed, &s.k))
    })
}

/// `Kxy` under `Mz` = -3 N m over the speeds, by a reference build without the friction moment on the
/// ring.
fn without_friction_moment(progress: &dyn Progress) -> anyhow::Result<Vec<f64>> {
    let reference = cases::reference(&B7005C, 16).without_friction_moment();
    let speeds = evenly(0.0, TOP, STEPS);
    progress.expect(speeds.len());
    speeds
        .into_par_iter()
        .map(|rpm| {
            let load = Tilt::Mz.load(-MOMENT);
            let found = reference
                .search(load, rad_per_s(rpm), Attitude::Raceless.into())
                .with_context(|| format!("reference build without `mt`, {load:?} at {rpm} rpm"))?;
            progress.done(1);
            Ok(found.k[KXY.1][KXY.2])
        })
        .collect()
}

/// The chapter.
///
/// # Errors
///
/// A load without a solution.
pub fn chapter(progress: &dyn Progress) -> anyhow::Result<Chapter> {
    let [a, b, c, d, e, f] = CASES.map(|(tilt, moment)| {
        let speeds = evenly(0.0, TOP, STEPS);
        solve_all(scenes(16, tilt.load(moment), speeds), progress)
    });
    let runs = [a?, b?, c?, d?, e?, f?];
    let [mz, my, both, mz_back, my_back, both_back] = &runs;
    let without_moment = without_friction_moment(progress)?;
    // A count that four does not divide.
    let odd: Vec<Run> = [Tilt::Mz.load(MOMENT), Tilt::My.load(-MOMENT)]
        .into_iter()
        .map(|load| solve_all(scenes(15, load, evenly(0.0, TOP, 4)), progress))
        .collect::<Result<_, _>>()?;

    let coupled = |run: &Run| {
        run.iter()
            .fold((f64::INFINITY, 0.0), |(least, most): (f64, f64), s| {
                let share = (KTYTZ.of(s) / (KTYTY.of(s) * KTZTZ.of(s)).sqrt()).abs();
                (least.min(share), worse(most, share))
            })
    };
    let alone = [mz, my, mz_back, my_back]
        .into_iter()
        .fold(0.0, |m, run| worse(m, coupled(run).1));
    let mut later = vec![
        Statement::of(
            "item 4",
            "Turning the load by 90 degrees, `Mz` to `-My` with `Fy` to `Fz`, swaps `Kyy` and `Kzz`, \
             `K_ty,ty` and `K_tz,tz`; exactly, since 4 divides the 16 balls.",
            vec![
                Measure::rounding(
                    "largest relative difference, `Mz` = 3 N m against `My` = -3 N m",
                    swapped(mz, my_back),
                    "",
                    1e-11,
                ),
                Measure::rounding(
                    "`Mz` = -3 N m against `My` = 3 N m",
                    swapped(mz_back, my),
                    "",
                    1e-11,
                ),
                Measure::rounding(
                    "the whole matrix, turned",
                    worse(
                        turned_by_90_degrees(mz, my_back),
                        turned_by_90_degrees(mz_back, my),
                    ),
                    "",
                    1e-11,
                ),
            ],
        ),
        Statement::ours(
            "With 15 balls, which 4 does not divide, it is no longer exact, but nearly so.",
            vec![
                Measure::within(
                    "largest relative difference, `Mz` = 3 N m against `My` = -3 N m",
                    swapped(&odd[0], &odd[1]),
                    "",
                    1e-9,
                    1e-2,
                )
                .digits(2),
            ],
        ),
        Statement::of(
            "item 5",
            "`My = Mz` with `Fy = Fz` = 200 N: a non-zero `K_ty,tz` appears.",
            vec![
                Measure::above(
                    "least `|K_ty,tz|` over `sqrt(K_ty,ty K_tz,tz)`, +3 N m",
                    100.0 * coupled(both).0,
                    "%",
                    1.0,
                ),
                Measure::above("-3 N m", 100.0 * coupled(both_back).0, "%", 1.0),
                Measure::rounding("largest with `Mz` or `My` alone", alone, "", 1e-12),
            ],
        ),
        Statement::ours(
            "The stiffness is symmetric at rest and not at speed: friction is not conservative. A curve of \
             `Kij` is drawn for `i < j` only.",
            vec![
                Measure::rounding(
                    "largest `|Kij - Kji|` over `sqrt(Kii Kjj)` at rest",
                    runs.iter()
                        .fold(0.0, |m, r| worse(m, skewness(&r[..1].to_vec()))),
                    "",
                    1e-12,
                ),
                Measure::within(
                    "at speed",
                    100.0 * runs.iter().fold(0.0, |m, r| worse(m, skewness(r))),
                    "%",
                    1e-3,
                    1.0,
                ),
            ],
        ),
    ];
    let [diagonal, off_diagonal, change_of_it] = figures(&runs);
    later.push(judged(runs.iter().chain(&odd).flatten()));

    Ok(Chapter {
        title: "Stiffness against speed under tilting moments",
        blocks: vec![
            Block::Text(
                "Loads as in the chapter before, with moments of 3 N m either way, 0 to 20,000 rpm in \
                 steps of 500 rpm. \"Step\" is the change from one speed to the next."
                    .to_owned(),
            ),
            Block::Figure(diagonal),
            Block::Figure(off_diagonal),
            Block::Figure(change_of_it),
            Block::Table(table(&runs)),
            Block::Statements(item_3(mz, mz_back, &without_moment)),
            Block::Statements(later),
        ],
    })
}

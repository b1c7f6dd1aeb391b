//! The promises of the solver to its users, which every campaign is held against.

use super::Plan;
use super::families::Family::{self, *};
use super::judge::{PRECISIONS, Record, Verdict};
use super::report::{covered, errors, name, part, ratios, share, table};

/// Figures in words; their families, none for all together; the figures; and their largest values in
/// single and in double precision, infinite where nothing is promised.
type Promise = (
    &'static str,
    &'static [Family],
    fn(&[&Record]) -> Vec<f64>,
    [&'static [f64]; 2],
);

/// Loads that spindles and machines have.
const EVERYDAY: &[Family] = &[
    Moderate,
    Reversed,
    Moduli,
    InnerControl,
    WarmDrift,
    WarmJumps,
    ExtremeAngles,
];

/// Loads of any size and direction, some of them hopeless.
const WILD: &[Family] = &[Random, Radial, DeepGroove, ZeroLoads, AnyBits];

fn unbalanced(of: &[&Record]) -> Vec<f64> {
    vec![share(of, Record::is_unbalanced, |_| true)]
}

fn missed(of: &[&Record]) -> Vec<f64> {
    vec![share(of, |r| r.verdict == Verdict::Missed, |_| true)]
}

/// A solver that refuses everything misses nothing, as long as nobody looks for what it has missed.
fn silent(of: &[&Record]) -> Vec<f64> {
    let is_silent = |r: &Record| matches!(r.verdict, Verdict::Missed | Verdict::Undecided);
    vec![share(of, is_silent, |_| true)]
}

/// An answer from which the reference build finds nothing has no errors either.
fn unjudged(of: &[&Record]) -> Vec<f64> {
    vec![share(of, |r| r.verdict == Verdict::Unjudged, |_| true)]
}

fn most(of: &[&Record]) -> Vec<f64> {
    errors(of).map(|errors| errors.most).to_vec()
}

fn beyond(of: &[&Record]) -> Vec<f64> {
    covered(of).map(|covered| 100.0 - covered).to_vec()
}

/// A load cell is good for a hundredth, and a stability lobe wants stiffness to a thousandth. Single precision keeps both
/// with room to spare wherever a spindle runs. Double precision is good to some hundred units in the last place.
#[rustfmt::skip]
const PROMISES: &[Promise] = &[
    ("panics, figures not finite, solves past 100 iterations, wrong reasons", &Family::ALL,
        |of| vec![share(of, |r| matches!(r.verdict, Verdict::Failed(_)), |_| true)], [&[0.0], &[0.0]]),
    ("forces that do not balance to 1e-2, %", EVERYDAY, unbalanced, [&[0.0], &[0.0]]),
    ("forces that do not balance to 1e-2, %", &Family::ALL, unbalanced, [&[0.2], &[0.1]]),
    ("on another branch than that from rest, %", &[Moderate],
        |of| vec![share(of, |r| r.from_rest == Some(false), |r| r.from_rest.is_some())], [&[0.1], &[0.1]]),
    ("missed, %", EVERYDAY, missed, [&[0.3], &[0.3]]),
    ("missed, %", &[Opening, DeepGroove, AnyBits, Typed], missed, [&[0.2], &[0.1]]),
    ("missed, %", &[Radial, ZeroLoads], missed, [&[0.3], &[0.5]]),
    ("missed, %", &[Random], missed, [&[2.3], &[1.0]]),
    ("missed, %", &[FewBalls], missed, [&[1.7], &[0.9]]),
    ("missed or open, %", EVERYDAY, silent, [&[2.5], &[2.5]]),
    ("missed or open, %", &[Radial, Opening, DeepGroove, AnyBits], silent, [&[5.0], &[5.0]]),
    ("missed or open, %", &[Random, ZeroLoads, Typed], silent, [&[11.0], &[11.0]]),
    ("missed or open, %", &[FewBalls], silent, [&[14.0], &[14.0]]),
    ("unjudged, %", EVERYDAY, unjudged, [&[0.1], &[0.1]]),
    ("unjudged, %", &[DeepGroove], unjudged, [&[1.4], &[0.5]]),
    ("unjudged, %", &[Random, Radial, ZeroLoads, AnyBits, Opening, Typed], unjudged,
        [&[0.5], &[0.5]]),
    ("unjudged, %", &[FewBalls], unjudged, [&[13.0], &[12.0]]),
    ("error of u / Q / K, 99 %", &[Moderate, Reversed, InnerControl, WarmDrift, WarmJumps, ExtremeAngles], most,
        [&[3e-6, 5e-5, 5e-5], &[3e-14, 1e-13, 2e-13]]),
    ("error of u / Q / K, 99 %", &[Moduli], most, [&[3e-6, 7e-5, 5e-5], &[3e-14, 1e-13, 2e-13]]),
    ("error of u / Q / K, 99 %", &[Random, Radial, ZeroLoads, AnyBits], most,
        [&[1e-5, 5e-4, 1.5e-3], &[3e-14, 7e-13, 2.5e-12]]),
    ("error of u / Q / K, 99 %", &[DeepGroove], most, [&[1.2e-4, 2e-5, 3e-4], &[2e-13, 2e-14, 4e-13]]),
    ("error of u / Q / K, 99 %", &[Typed], most, [&[4e-5, 2e-4, 2e-3], &[4e-14, 2.5e-13, 2e-9]]),
    ("error of u / Q / K, 99 %", &[Opening], most, [&[1e-2, 1e-5, 3e-2], &[2e-11, 5e-14, 4e-11]]),
    ("error of u / Q / K, 99 %", &[FewBalls], most, [&[f64::INFINITY, 0.5, 1.2], &[1e-10, 2e-12, 2e-7]]),
    ("errors of u / Q / K beyond the estimate, %", EVERYDAY, beyond, [&[0.5; 3], &[0.5, 0.5, 0.6]]),
    ("errors of u / Q / K beyond the estimate, %", &[Moderate, Reversed, WarmDrift], beyond,
        [&[0.2; 3], &[0.4, 0.4, 0.6]]),
    ("errors of u / Q / K beyond the estimate, %", WILD, beyond, [&[0.5, 0.5, 0.8], &[0.5, 0.5, 0.8]]),
    ("errors of u / Q / K beyond the estimate, %", &[Opening, Typed], beyond,
        [&[1.3, 0.5, 3.0], &[1.3, 0.5, 1.7]]),
    ("errors of u / Q / K beyond the estimate, %", &[FewBalls], beyond,
        [&[2.9, 7.0, 9.7], &[1.2, 0.5, 6.5]]),
    ("errors of u / Q / K beyond the estimate, %", &[], beyond, [&[0.4, 0.4, 0.6], &[0.2, 0.2, 0.7]]),
    ("median of estimate over error of u / Q / K", &[],
        |of| ratios(of).map(|ratio| ratio.median).to_vec(), [&[50.0, 100.0, 90.0], &[51.0, 110.0, 80.0]]),
    ("errors beyond 1e-3 and 30 times the estimate, % of the answers", &[],
        |of| vec![share(of, Record::deceives, |r| r.errors.is_some())], [&[0.3], &[0.01]]),
];

/// Of sets of bearings, an answer is wrong if it is off by more than its errors say: see [`Record::deceives`].
#[rustfmt::skip]
const OF_SETS: &[Promise] = &[
    ("panics, figures not finite, solves past 100 iterations, wrong reasons", &Family::OF_SETS,
        |of| vec![share(of, |r| matches!(r.verdict, Verdict::Failed(_)), |_| true)], [&[0.0], &[0.0]]),
    ("missed, %", &[Moderate, WarmJumps], missed, [&[0.3], &[0.3]]),
    ("missed, %", &[Random], missed, [&[2.0], &[1.0]]),
    ("unjudged, %", &[Moderate, ZeroLoads, WarmJumps], unjudged, [&[0.2], &[0.2]]),
    ("unjudged, %", &[Random], unjudged, [&[0.8], &[0.8]]),
    ("wrong, %", &Family::OF_SETS, |of| vec![share(of, Record::deceives, |_| true)], [&[0.0], &[0.0]]),
];

const fn promised(of_sets: bool) -> &'static [Promise] {
    if of_sets { OF_SETS } else { PROMISES }
}

/// The promises that a campaign of all families does not keep, in words.
pub fn broken(records: &[Record], of_sets: bool) -> Vec<String> {
    let mut broken = Vec::new();
    for &(text, families, figures, bounds) in promised(of_sets) {
        let each = families.iter().map(|family| Some(*family));
        for family in each.chain(families.is_empty().then_some(None)) {
            for (precision, most) in PRECISIONS.into_iter().zip(bounds) {
                let figures = figures(&part(records, family, precision));
                let mut kept = figures
                    .iter()
                    .zip(most)
                    .map(|(figure, most)| figure <= most);
                if !kept.all(|kept| kept) {
                    let family = family.map_or("all families", Family::name);
                    let precision = name(precision);
                    broken.push(format!(
                        "{family} in {precision}: {text}: {figures:?}, promised {most:?}"
                    ));
                }
            }
        }
    }
    broken
}

/// The promises, as a table.
pub fn promises(of_sets: bool) -> String {
    let bound = |most: &f64| match *most {
        f64::INFINITY => "-".to_owned(),
        most if most < 1e-3 && most > 0.0 => format!("{most:e}"),
        most => most.to_string(),
    };
    let row = |&(text, families, _, bounds): &Promise| {
        let families: Vec<&str> = match families {
            [] => vec!["all together"],
            families if families == Plan::all(of_sets) => vec!["every family"],
            families => families.iter().map(|family| family.name()).collect(),
        };
        let [f32, f64] = bounds.map(|most| most.iter().map(bound).collect::<Vec<_>>().join(" / "));
        vec![text.to_owned(), families.join(", "), f32, f64]
    };
    let rows: Vec<Vec<String>> = promised(of_sets).iter().map(row).collect();
    table(&["largest", "of", "f32", "f64"], &rows)
}

//! `docs/validation.md`: the claims as a page, and how two makings of it are compared.

use super::book::{Book, Measure};
use super::judge::{Judged, JudgedClaim};
use std::fmt::Write;

/// The page; `made_from` names the commit.
pub fn page(book: &Book, judged: &[Vec<JudgedClaim<'_>>], made_from: &str) -> String {
    let mut page = format!(
        "<!-- Made by `cargo reports validation` from {made_from}; do not edit. -->\n\n\
         # Validation\n\n{}\n\n",
        paragraphs(&book.opening)
    );
    let claims = || judged.iter().flatten();
    let in_part = claims().filter(|one| one.claim.in_part.is_some()).count();
    let _ = writeln!(
        page,
        "{} claims: {} hold, {in_part} hold in part.",
        claims().count(),
        claims().count() - in_part
    );
    for (chapter, claims) in book.chapter.iter().zip(judged) {
        let _ = write!(
            page,
            "\n## {}\n\n{}\n\n",
            chapter.title,
            paragraphs(&chapter.text)
        );
        for picture in &chapter.picture {
            let _ = write!(
                page,
                "![{}](validation/{}.svg)\n\n*{}*\n\n",
                picture.title, picture.file, picture.caption
            );
        }
        page.push_str("| claim | published | ours | bound |\n| --- | --- | --- | --- |\n");
        for one in claims {
            let claim = one.claim;
            let verdict = match &claim.in_part {
                Some(instead) => format!("**Holds in part.** {instead}"),
                None => "**Holds.**".to_owned(),
            };
            let head = format!("*{}*: {} {verdict}", claim.by, claim.claim);
            match one.measures.as_slice() {
                [only] => row(&mut page, &format!("{head} {}:", only.measure.name), only),
                measures => {
                    let _ = writeln!(page, "| {head} | | | |");
                    for one in measures {
                        row(&mut page, &one.measure.name, one);
                    }
                }
            }
        }
    }
    page
}

/// Each paragraph on a line.
fn paragraphs(text: &str) -> String {
    let lines = text.trim().split("\n\n").map(|one| one.replace('\n', " "));
    lines.collect::<Vec<_>>().join("\n\n")
}

fn row(page: &mut String, name: &str, judged: &Judged<'_>) {
    let m = judged.measure;
    let digits = m.published.iter().map(|v| decimals(*v)).max();
    let unit = |text: String| match m.unit.as_str() {
        unit if unit.is_empty() || text.is_empty() => text,
        "°" => format!("{text}°"),
        unit => format!("{text} {unit}"),
    };
    let ours = match digits {
        _ if m.rounding.is_some() => "rounding".to_owned(),
        Some(digits) => unit(joined(
            judged.numbers.iter().map(|v| format!("{v:.digits$}")),
        )),
        None => unit(range(&judged.numbers)),
    };
    let published = unit(joined(m.published.iter().map(f64::to_string)));
    let _ = writeln!(page, "| {name} | {published} | {ours} | {} |", bound(m));
}

fn joined(texts: impl Iterator<Item = String>) -> String {
    texts.collect::<Vec<_>>().join(", ")
}

fn decimals(value: f64) -> usize {
    value
        .to_string()
        .split_once('.')
        .map_or(0, |(_, part)| part.len())
}

fn range(numbers: &[f64]) -> String {
    let least = numbers.iter().copied().fold(f64::INFINITY, f64::min);
    let largest = numbers.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let [least, largest] = [least, largest].map(shown);
    if least == largest {
        least
    } else {
        format!("{least} to {largest}")
    }
}

fn bound(m: &Measure) -> String {
    let mut bounds = Vec::new();
    match (m.above, m.below) {
        (Some(above), Some(below)) => bounds.push(format!("{} to {}", shown(above), shown(below))),
        (Some(above), None) => bounds.push(format!("above {}", shown(above))),
        (None, Some(below)) => bounds.push(format!("below {}", shown(below))),
        (None, None) => {}
    }
    bounds.extend(m.within.map(|most| format!("within {}", shown(most))));
    bounds.extend(
        m.within_percent
            .map(|most| format!("within {} %", shown(most))),
    );
    bounds.extend(m.rounding.map(|most| format!("at most {}", shown(most))));
    bounds.join(", ")
}

/// A number with four significant digits, trailing zeros of a fraction left out.
pub fn shown(value: f64) -> String {
    let trimmed = |text: &str| match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text.to_owned(),
    };
    let size = value.abs();
    if value == 0.0 {
        "0".to_owned()
    } else if (1e-3..1e6).contains(&size) {
        let decimals = 3 - size.log10().floor() as i32;
        trimmed(&format!("{value:.*}", decimals.max(0) as usize))
    } else {
        let text = format!("{value:.3e}");
        let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
        format!("{}e{exponent}", trimmed(mantissa))
    }
}

/// First line of `committed` whose text differs from `made`, or whose numbers differ by over 1e-3.
///
/// The commit in the first line makes no difference.
pub fn difference(committed: &str, made: &str) -> Option<String> {
    let (old, new): (Vec<_>, Vec<_>) = (committed.lines().collect(), made.lines().collect());
    (1..old.len().max(new.len())).find_map(|i| {
        let (old, new) = (old.get(i), new.get(i));
        let is_alike = old.zip(new).is_some_and(|(old, new)| alike(old, new));
        let [old, new] = [old, new].map(|line| *line.unwrap_or(&"(none)"));
        (!is_alike).then(|| format!("line {}:\n  committed: {old}\n  made:      {new}", i + 1))
    })
}

fn alike(old: &str, new: &str) -> bool {
    let words = |line: &str| -> Vec<String> {
        let words = line.split([' ', ',', '|', '°']);
        words.map(str::to_owned).collect()
    };
    let (old, new) = (words(old), words(new));
    let is_near = |(old, new): (&String, &String)| match (old.parse::<f64>(), new.parse::<f64>()) {
        (Ok(x), Ok(y)) => (x - y).abs() <= 1e-3 * y.abs(),
        _ => old == new,
    };
    old.len() == new.len() && old.iter().zip(&new).all(is_near)
}

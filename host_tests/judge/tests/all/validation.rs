//! Published figures and claims of `host_tests/judge/validation.toml`, judged.

use judge::validation::book::{Book, Measure, TEXT};
use judge::validation::judge::{Judged, judge};
use judge::validation::{cases, page};

/// Complaints about the claims of chapters whose titles contain `title`.
fn complaints(text: &str, title: &str) -> Vec<String> {
    let book = Book::parse(text).unwrap();
    let chapters = book.chapter.iter().filter(|c| c.title.contains(title));
    let complaints = chapters.flat_map(|chapter| {
        let runs = cases::solve(chapter).unwrap();
        let judged = judge(chapter, &runs).unwrap();
        judged
            .iter()
            .filter_map(|c| c.complaint())
            .collect::<Vec<_>>()
    });
    complaints.collect()
}

#[test]
fn every_claim_is_as_stated() {
    let complaints = complaints(TEXT, "");
    assert!(complaints.is_empty(), "\n{}", complaints.join("\n"));
}

#[test]
fn the_table_of_a_third_party_is_not_reproduced_by_another_rule() {
    for attitude in ["raceless", "inner"] {
        let run = "\"third party's speeds\", attitude = ";
        let text = TEXT.replace(&format!("{run}\"outer\""), &format!("{run}\"{attitude}\""));
        assert_eq!(complaints(&text, "Against others").len(), 1, "{attitude}");
    }
}

#[test]
fn a_measure_falls_with_any_of_its_bounds() {
    let holds = |bounds: &str, numbers: &[f64]| {
        let measure: Measure = toml::from_str(&format!("of = \"k_x_x\"\n{bounds}")).unwrap();
        let measure = &measure;
        let numbers = numbers.to_vec();
        Judged { measure, numbers }.holds()
    };
    for (bounds, good, bad) in [
        ("above = 1", 2.0, 1.0),
        ("below = 1", 0.0, 1.0),
        ("above = 1\nbelow = 3", 2.0, 3.1),
        ("rounding = 1e-9", 1e-9, -2e-9),
        ("published = 2\nwithin = 0", 2.0, 3.0),
        ("published = 2\nwithin_percent = 1", 2.01, 2.03),
        ("below = 1", 0.0, f64::NAN),
    ] {
        assert!(holds(bounds, &[good]), "{bounds}");
        assert!(!holds(bounds, &[bad]), "{bounds}: {bad}");
    }
    assert!(!holds("above = 1", &[]));
    assert!(!holds("", &[1.0]));
    assert!(!holds("published = [1, 2]\nwithin = 0", &[1.0]));
}

#[test]
fn a_changed_number_or_word_of_the_page_is_found() {
    let page = "made from a\n| `Kxx`, 3 rpm | 2.5 | 2.503e-4 to 17 | above 0 |\nend\n";
    let same = "made from b\n| `Kxx`, 3 rpm | 2.5 | 2.504e-4 to 17 | above 0 |\nend\n";
    assert_eq!(page::difference(page, same), None);
    for (old, new) in [
        ("17", "17.1"),
        ("2.503", "2.51"),
        ("e-4", "e-5"),
        ("Kxx", "Kyy"),
        ("end\n", ""),
    ] {
        let found = page::difference(&page.replace(old, new), page);
        assert!(found.is_some_and(|line| line.starts_with("line ")), "{old}");
    }
}

#[test]
fn numbers_are_short() {
    for (value, text) in [
        (0.0, "0"),
        (12.0, "12"),
        (0.012_345, "0.01235"),
        (-48.691, "-48.69"),
        (2.860_9e8, "2.861e8"),
        (1e-12, "1e-12"),
        (123_456.0, "123456"),
    ] {
        assert_eq!(page::shown(value), text);
    }
}

#[test]
fn the_spindle_of_a_maker_is_asked_nothing() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/makers/spindlecad.toml");
    let doubts = spindle_file::spindles::SpindleFile::read(file)
        .unwrap()
        .doubts;
    assert!(doubts.is_empty(), "{doubts:?}");
}

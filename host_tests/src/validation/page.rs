//! The book as a page: `docs/validation.md` and the figures beside it.

use super::statement::{Statement, Verdict};
use super::{Block, COMMAND, Chapter, Table};
use std::fmt::Write;

const OPENING: &str = "What is known of angular contact ball bearings at speed, against what this solver computes: the \
results of a published study of spindle bearings under tilting moments, a third party's program, makers' \
tables, closed forms, and a check of the physics that shares no algebra with the solver. `docs/model.md` has the equations and symbols.

Every row of the tables of statements is tested: `cargo test` fails if a number leaves the range in parentheses. Where a claim of the study does not hold in \
this model, its row says so and by how much. A number that is rounding and nothing else is given as a bound.

Unless a line says otherwise, figures and numbers are the solver's in double precision. Each chapter but that of makers' figures holds every \
equilibrium against the reference build and against single precision. The bearings: 218 (16 balls of 22.23 mm, 40\u{b0}), \
B7005C (16 of 6.35 mm, 15\u{b0}), SKF 6205 (9 of 7.938 mm, angle by clearance), of steel; `host_tests/bearings` \
has the files. The study's own tables of dimensions are not known; those of the B7005C are a plausible set, not the \
maker's.
";

/// The page.
pub fn page(chapters: &[Chapter]) -> String {
    let mut page =
        format!("<!-- Made by `{COMMAND}`; do not edit. -->\n\n# Validation\n\n{OPENING}\n");
    summary(&mut page, chapters);
    let mut number = 0;
    for chapter in chapters {
        let _ = write!(page, "## {}\n\n", chapter.title);
        for block in &chapter.blocks {
            match block {
                Block::Text(text) => {
                    let _ = write!(page, "{text}\n\n");
                }
                Block::Figure(figure) => {
                    number += 1;
                    let _ = write!(
                        page,
                        "![{}](validation/{}.svg)\n\n*Figure {number}. {}*\n\n",
                        figure.title, figure.name, figure.caption
                    );
                }
                Block::Table(table) => markdown(&mut page, table),
                Block::Statements(statements) => {
                    let rows = statements.iter().map(row).collect();
                    let head = ["statement", "measured", "verdict"]
                        .map(str::to_owned)
                        .into();
                    markdown(
                        &mut page,
                        &Table {
                            caption: String::new(),
                            head,
                            rows,
                        },
                    );
                }
            }
        }
    }
    while page.ends_with("\n\n") {
        page.pop();
    }
    page
}

/// The study's claims and what became of them.
fn summary(page: &mut String, chapters: &[Chapter]) {
    let claims = || {
        chapters
            .iter()
            .flat_map(Chapter::statements)
            .filter(|s| s.source.is_some())
    };
    let count = |verdict: Verdict| claims().filter(|s| s.verdict == verdict).count();
    let _ = write!(
        page,
        "{} claims of the study: {} hold, {} in part, {} not. Those that do not hold as they stand:\n\n",
        claims().count(),
        count(Verdict::Holds),
        count(Verdict::InPart),
        count(Verdict::DoesNotHold)
    );
    for claim in claims().filter(|s| s.verdict != Verdict::Holds) {
        let remark = claim.remark.as_deref().unwrap_or_default();
        let source = claim.source.unwrap_or_default();
        let _ = writeln!(
            page,
            "- \"{}\" ({source}) {}. {remark}",
            claim.claim, claim.verdict
        );
    }
    page.push('\n');
}

fn row(statement: &Statement) -> Vec<String> {
    let mut claim = statement.claim.clone();
    if let Some(source) = statement.source {
        claim = format!("Study, {source}: {claim}");
    }
    if let Some(remark) = &statement.remark {
        claim = format!("{claim} *{remark}*");
    }
    let measures: Vec<String> = statement.measures.iter().map(ToString::to_string).collect();
    vec![claim, measures.join("<br>"), statement.verdict.to_string()]
}

fn markdown(page: &mut String, table: &Table) {
    if !table.caption.is_empty() {
        let _ = write!(page, "{}\n\n", table.caption);
    }
    let line = |cells: &[String]| {
        let cells: Vec<String> = cells.iter().map(|c| c.replace('|', "\\|")).collect();
        format!("| {} |\n", cells.join(" | "))
    };
    page.push_str(&line(&table.head));
    let rule = |i: usize| {
        let numbers = table
            .rows
            .iter()
            .all(|r| r.get(i).is_some_and(|c| c.parse::<f64>().is_ok()));
        if numbers {
            "--:".to_owned()
        } else {
            "---".to_owned()
        }
    };
    page.push_str(&line(&(0..table.head.len()).map(rule).collect::<Vec<_>>()));
    for row in &table.rows {
        page.push_str(&line(row));
    }
    page.push('\n');
}

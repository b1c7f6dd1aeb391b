//! The validation book.

use anyhow::{Context, bail};
use host_tests::validation::statement::Statement;
use host_tests::validation::{self, Chapter, FIGURES, PAGE, page};
use std::fs;
use std::path::Path;
use tools::bar::Bar;
use tools::figure;

/// Makes the page and its figures, and says what is not as the page says.
pub fn run() -> anyhow::Result<()> {
    let bar = Bar::new("{bar:40} {pos} of {len} equilibria, {elapsed}")?;
    let book = validation::book(&bar)?;
    bar.finish();
    write(&book)?;
    let statements = || book.iter().flat_map(Chapter::statements);
    let complaints: Vec<String> = statements().filter_map(Statement::complaint).collect();
    let figures = book.iter().flat_map(Chapter::figures).count();
    println!(
        "docs/validation.md: {} statements, {figures} figures in docs/validation/",
        statements().count()
    );
    if !complaints.is_empty() {
        bail!(
            "{} statements are not as the page says; mend the solver, or the statement in \
             host_tests/src/validation/:\n{}",
            complaints.len(),
            complaints.join("\n")
        );
    }
    Ok(())
}

/// Writes the page and its figures to their places.
fn write(book: &[Chapter]) -> anyhow::Result<()> {
    let folder = Path::new(FIGURES);
    fs::create_dir_all(folder)
        .with_context(|| format!("cannot make {}; is docs/ writable?", folder.display()))?;
    for figure in book.iter().flat_map(Chapter::figures) {
        figure::draw(figure, folder)?;
    }
    fs::write(PAGE, page::page(book))
        .with_context(|| format!("cannot write {PAGE}; is docs/ writable?"))
}

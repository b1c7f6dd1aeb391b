//! The validation book.

use anyhow::bail;
use host_tests::validation::statement::Statement;
use host_tests::validation::{self, Chapter, Progress, page};
use indicatif::{ProgressBar, ProgressStyle};

/// Makes the page and its figures, and says what is not as the page says.
pub fn run() -> anyhow::Result<()> {
    let bar = ProgressBar::new(0).with_style(ProgressStyle::with_template(
        "{bar:40} {pos} of {len} equilibria, {elapsed}",
    )?);
    let book = validation::book(&Progress::on(bar.clone()))?;
    bar.finish_and_clear();
    page::write(&book)?;
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

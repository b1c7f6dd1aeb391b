//! Figures of `cargo reports`.

use anyhow::{Context, Result};
use std::collections::BTreeMap;
use std::path::Path;

/// Place of the figures, from the project's root.
pub const FIGURES: &str = "docs/report_figures.json";

/// Figures by name.
pub type Figures = BTreeMap<String, u64>;

/// The committed figures.
///
/// # Errors
///
/// They are not there, or something else is.
pub fn figures(root: &Path) -> Result<Figures> {
    let text = std::fs::read_to_string(root.join(FIGURES)).context(FIGURES)?;
    serde_json::from_str(&text).context(FIGURES)
}

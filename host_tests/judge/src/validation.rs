//! Validation: published figures and claims against ours.
//!
//! `host_tests/judge/validation.toml` holds every claim with its source, its cases and its bounds. The test
//! `tests/all/validation.rs` judges them, and `cargo reports validation` writes them to `docs/validation.md`.

mod beams;
pub mod book;
pub mod case;
pub mod cases;
pub mod judge;
pub mod page;

/// The page, from the root of the project; its pictures are in the folder beside it.
pub const PAGE: &str = "docs/validation.md";

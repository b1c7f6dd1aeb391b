//! Colours of the view, and its boxes.

use ratatui::style::{Color, Style};
use ratatui::text::Line;
use ratatui::widgets::Block;

pub(super) const INNER: Color = Color::Green;
pub(super) const OUTER: Color = Color::Blue;
pub(super) const WORST: Color = Color::Red;
pub(super) const UNLOADED: Color = Color::Yellow;
pub(super) const FAINT: Color = Color::DarkGray;

/// A box with a title.
pub(super) fn boxed<'a>(title: impl Into<Line<'a>>) -> Block<'a> {
    Block::bordered().title(title).border_style(FAINT)
}

/// Red, if something is amiss.
pub(super) const fn flag(is_amiss: bool) -> Style {
    match is_amiss {
        true => Style::new().fg(WORST),
        false => Style::new(),
    }
}

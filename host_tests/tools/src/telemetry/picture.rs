//! A terminal's content as SVG, for documents.
//!
//! Braille and box drawing are drawn as dots and lines rather than as text, since few fonts have both,
//! and none of them in the right width.

use ratatui::buffer::{Buffer, Cell};
use ratatui::style::{Color, Modifier};
use std::fmt::Write;

/// Size of a cell, px.
const CELL: (u16, u16) = (8, 16);
/// Size of the letters, px: that of the usual fonts in which one is as wide as a cell.
const LETTERS: f64 = 13.29;
const BACKGROUND: &str = "#16181d";

fn colour(colour: Color) -> &'static str {
    match colour {
        Color::Red => "#ff6b6b",
        Color::Green => "#7bd88f",
        Color::Yellow => "#ffd866",
        Color::Blue => "#6ca0f6",
        Color::Magenta => "#d58fe0",
        Color::Cyan => "#6fd3e0",
        Color::DarkGray => "#7d828c",
        _ => "#e6e6e6",
    }
}

/// The content of a screen as SVG.
pub fn svg(screen: &Buffer) -> String {
    let (width, height) = (screen.area.width, screen.area.height);
    let (w, h) = (width * CELL.0, height * CELL.1);
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{w}\" height=\"{h}\" viewBox=\"0 0 {w} {h}\" \
         font-family=\"DejaVu Sans Mono, Menlo, Consolas, monospace\" font-size=\"{LETTERS}\">\n\
         <rect width=\"{w}\" height=\"{h}\" fill=\"{BACKGROUND}\"/>\n"
    );
    for y in 0..height {
        let mut x = 0;
        while x < width {
            let cell = &screen[(x, y)];
            let run = (x..width)
                .take_while(|at| is_same_text(cell, &screen[(*at, y)]))
                .count() as u16;
            if run > 0 {
                text(&mut out, screen, (x, y), run);
                x += run;
            } else {
                drawn(&mut out, cell, x * CELL.0, y * CELL.1);
                x += 1;
            }
        }
    }
    out + "</svg>\n"
}

fn symbol(cell: &Cell) -> char {
    cell.symbol().chars().next().unwrap_or(' ')
}

/// Whether both cells are text, and look the same.
fn is_same_text(first: &Cell, cell: &Cell) -> bool {
    let is_drawn = matches!(symbol(cell), '\u{2500}'..='\u{257f}' | '\u{2800}'..='\u{28ff}');
    !is_drawn && cell.fg == first.fg && cell.modifier == first.modifier
}

/// Cells of the same look, word by word, so that every word is at its place, whatever the font.
fn text(out: &mut String, screen: &Buffer, (x, y): (u16, u16), run: u16) {
    let first = &screen[(x, y)];
    let weight = if first.modifier.contains(Modifier::BOLD) {
        " font-weight=\"bold\""
    } else {
        ""
    };
    let mut at = x;
    while at < x + run {
        let mut word = String::new();
        let start = at;
        while at < x + run && symbol(&screen[(at, y)]) != ' ' {
            match symbol(&screen[(at, y)]) {
                '<' => word += "&lt;",
                '&' => word += "&amp;",
                other => word.push(other),
            }
            at += 1;
        }
        if !word.is_empty() {
            // Writing to a string cannot fail.
            let _ = writeln!(
                out,
                "<text x=\"{}\" y=\"{}\" fill=\"{}\"{weight}>{word}</text>",
                start * CELL.0,
                y * CELL.1 + 12,
                colour(first.fg)
            );
        }
        at += 1;
    }
}

/// Braille or box drawing with its upper left corner at this place.
fn drawn(out: &mut String, cell: &Cell, x: u16, y: u16) {
    let colour = colour(cell.fg);
    match symbol(cell) {
        dots @ '\u{2800}'..='\u{28ff}' => {
            let dots = dots as u32 - 0x2800;
            let mut path = String::new();
            // Bits 0 to 2 and 6 are the left column from the top, 3 to 5 and 7 the right one.
            for (bit, (column, row)) in [
                (0, 0),
                (0, 1),
                (0, 2),
                (1, 0),
                (1, 1),
                (1, 2),
                (0, 3),
                (1, 3),
            ]
            .into_iter()
            .enumerate()
            {
                if dots & 1 << bit != 0 {
                    let _ = write!(path, "M{} {}h2v2h-2z", x + 1 + 4 * column, y + 1 + 4 * row);
                }
            }
            let _ = writeln!(out, "<path d=\"{path}\" fill=\"{colour}\"/>");
        }
        line => {
            let (x, y) = (x + CELL.0 / 2, y + CELL.1 / 2);
            let (half_w, half_h) = (CELL.0 / 2, CELL.1 / 2);
            let [left, right, up, down] = arms(line);
            let mut path = String::new();
            for (is_there, arm) in [
                (left, format!("M{x} {y}h-{half_w}")),
                (right, format!("M{x} {y}h{half_w}")),
                (up, format!("M{x} {y}v-{half_h}")),
                (down, format!("M{x} {y}v{half_h}")),
            ] {
                if is_there {
                    path += &arm;
                }
            }
            let _ = writeln!(
                out,
                "<path d=\"{path}\" stroke=\"{colour}\" fill=\"none\"/>"
            );
        }
    }
}

/// Whether a line goes to the left, to the right, up and down.
const fn arms(line: char) -> [bool; 4] {
    match line {
        '─' => [true, true, false, false],
        '│' => [false, false, true, true],
        '┌' => [false, true, false, true],
        '┐' => [true, false, false, true],
        '└' => [false, true, true, false],
        '┘' => [true, false, true, false],
        '├' => [false, true, true, true],
        '┤' => [true, false, true, true],
        '┬' => [true, true, false, true],
        '┴' => [true, true, true, false],
        _ => [true, true, true, true],
    }
}

//! A terminal's content as SVG, for documents.
//!
//! Dots of braille are drawn, since few fonts have them. Text is a run of cells, stretched to their width.

use ratatui::buffer::{Buffer, Cell};
use ratatui::style::{Color, Modifier};
use std::collections::BTreeMap;
use std::fmt::Write;

/// Size of a cell, px.
const CELL: (u16, u16) = (8, 16);
const BACKGROUND: &str = "#16181d";

const fn colour(colour: Color) -> &'static str {
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
    let mut text = String::new();
    let mut dots: BTreeMap<&str, String> = BTreeMap::new();
    for y in 0..height {
        let line: Vec<&Cell> = (0..width).map(|x| &screen[(x, y)]).collect();
        let mut x = 0;
        for run in line.chunk_by(|a, b| look(a) == look(b)) {
            let letters: String = run.iter().map(|cell| cell.symbol()).collect();
            if look(run[0]).2 {
                let path = dots.entry(colour(run[0].fg)).or_default();
                braille(path, &letters, x, y);
            } else if !letters.trim().is_empty() {
                let weight = match run[0].modifier.contains(Modifier::BOLD) {
                    true => " font-weight=\"bold\"",
                    false => "",
                };
                text += &format!(
                    "<text x=\"{}\" y=\"{}\" textLength=\"{}\" fill=\"{}\"{weight}>{}</text>\n",
                    x * CELL.0,
                    y * CELL.1 + 12,
                    run.len() * usize::from(CELL.0),
                    colour(run[0].fg),
                    letters.replace('&', "&amp;").replace('<', "&lt;"),
                );
            }
            x += run.len() as u16;
        }
    }
    for (colour, path) in dots {
        text += &format!("<path stroke=\"{colour}\" stroke-width=\"3\" d=\"{path}\"/>\n");
    }
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {w} {h}\" width=\"{w}\" height=\"{h}\" \
         font-family=\"DejaVu Sans Mono, Menlo, Consolas, monospace\" font-size=\"13.3\" \
         xml:space=\"preserve\">\n\
         <rect width=\"{w}\" height=\"{h}\" fill=\"{BACKGROUND}\"/>\n{text}</svg>\n"
    )
}

/// Cells that look alike make a run: colour, weight, and whether they are dots.
fn look(cell: &Cell) -> (Color, Modifier, bool) {
    let is_braille = |letter| ('\u{2800}'..='\u{28ff}').contains(&letter);
    (
        cell.fg,
        cell.modifier,
        cell.symbol().starts_with(is_braille),
    )
}

/// The bits of braille, row by row: the left column, and the right one.
const BITS: [[u32; 2]; 4] = [[0, 3], [1, 4], [2, 5], [6, 7]];

/// Adds the dots of some cells from this one on, each a dash.
fn braille(path: &mut String, letters: &str, x: u16, y: u16) {
    for (row, bits) in (0..).zip(BITS) {
        for (x, letter) in (x..).zip(letters.chars()) {
            for (column, bit) in (0..).zip(bits) {
                if (letter as u32) & (1 << bit) != 0 {
                    let (x, y) = (x * CELL.0 + 4 * column, y * CELL.1 + 4 * row + 2);
                    // Writing to a string cannot fail.
                    let _ = write!(path, "M{x} {y}h3");
                }
            }
        }
    }
}

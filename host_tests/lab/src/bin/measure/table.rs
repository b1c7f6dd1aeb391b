//! Numbers in tables.

use judge::campaign::report::table;

/// A whole number, its thousands set apart.
pub fn thousands(number: u64) -> String {
    match number {
        0..1000 => number.to_string(),
        _ => format!("{},{:03}", thousands(number / 1000), number % 1000),
    }
}

/// A Markdown table, the cells of its head set apart by bars.
pub fn markdown(head: &str, lines: &[Vec<String>]) -> String {
    let head: Vec<&str> = head.split(" | ").collect();
    table(&head, lines)
}

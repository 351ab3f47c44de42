//! Lines of a summary: a label of ten columns, and its text.

use crate::table::fixed;

/// Below a label of the summary.
pub const INDENT: &str = "          ";

/// Breaks a long list of names, indented below the first line.
pub fn wrapped(text: &str) -> String {
    const WIDTH: usize = 90;
    let mut lines = vec![String::new()];
    for word in text.split(' ') {
        match lines.last_mut() {
            Some(line) if line.is_empty() => line.push_str(word),
            Some(line) if line.chars().count() + 1 + word.chars().count() <= WIDTH => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines.join(&format!("\n{INDENT}"))
}

/// A length in mm.
pub fn millimetres(metres: f64) -> String {
    fixed(1e3 * metres, 3)
}

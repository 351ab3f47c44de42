//! Lines of a summary: a label of ten columns, and its text.

use console::Term;
use touchcal::report::fixed;

/// Below a label of the summary.
pub const INDENT: &str = "          ";

/// Least and most columns of text beside a label.
const WIDTH: [usize; 2] = [40, 90];

/// Breaks text at the width of the terminal, if stdout is one, indented below the first line.
pub fn wrapped(text: &str) -> String {
    let terminal = Some(Term::stdout()).filter(Term::is_term);
    let columns = terminal.and_then(|terminal| terminal.size_checked()).map(|(_, columns)| usize::from(columns));
    let width = columns.map_or(WIDTH[1], |columns| columns.saturating_sub(INDENT.len()).clamp(WIDTH[0], WIDTH[1]));
    let mut lines = vec![String::new()];
    for word in text.split(' ') {
        match lines.last_mut() {
            Some(line) if line.is_empty() => line.push_str(word),
            Some(line) if line.chars().count() + 1 + word.chars().count() <= width => {
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

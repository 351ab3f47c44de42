//! Lines of a summary: a label of ten columns, and its text.

use console::Term;
use touchcal::report::fixed;

/// Below a label of the summary.
pub const INDENT: &str = "          ";

/// Before advice.
const ARROW: &str = "-> ";

/// Least and most columns of text beside a label.
const WIDTH: [usize; 2] = [40, 90];

/// Breaks text beside a label at the width of the terminal, if stdout is one, indented below the
/// first line.
pub fn wrapped(text: &str) -> String {
    hanging(text, INDENT.len())
}

/// A line of advice, indented as by `indent`, and what of it does not fit below the first line.
pub fn advice(indent: &str, text: &str) -> String {
    let text = hanging(text, indent.len() + ARROW.len());
    format!("{indent}{ARROW}{text}\n")
}

/// Breaks text that begins after `indent` columns; all lines end at the same column.
pub fn hanging(text: &str, indent: usize) -> String {
    let terminal = Some(Term::stdout()).filter(Term::is_term);
    let columns = terminal.and_then(|terminal| terminal.size_checked()).map(|(_, columns)| usize::from(columns));
    let width = columns.map_or(WIDTH[1], |columns| columns.saturating_sub(INDENT.len()).clamp(WIDTH[0], WIDTH[1]));
    filled(text, (width + INDENT.len()).saturating_sub(indent), indent)
}

/// Text in lines of `width` columns where its words allow it, indented below the first.
fn filled(text: &str, width: usize, indent: usize) -> String {
    let mut lines = vec![String::new()];
    for word in words(text) {
        match lines.last_mut() {
            Some(line) if line.is_empty() => line.push_str(&word),
            // What is too long for a line of its own is not worth a break.
            Some(line) if line.chars().count() + 1 + word.chars().count() <= width || word.chars().count() > width => {
                line.push(' ');
                line.push_str(&word);
            }
            _ => lines.push(word),
        }
    }
    lines.join(&format!("\n{}", " ".repeat(indent)))
}

/// The words of a text. A key with its value, `key = { … }`, is one: it is to be copied.
fn words(text: &str) -> Vec<String> {
    let mut words: Vec<String> = Vec::new();
    let mut open = 0_usize;
    for part in text.split(' ') {
        match words.last_mut() {
            Some(word) if open > 0 || part == "=" || word.ends_with(" =") => {
                word.push(' ');
                word.push_str(part);
            }
            _ => words.push(part.to_owned()),
        }
        open = (open + part.matches('{').count()).saturating_sub(part.matches('}').count());
    }
    words
}

/// A length in mm.
pub fn millimetres(metres: f64) -> String {
    fixed(1e3 * metres, 3)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_hang_below_the_first() {
        assert_eq!(filled("one two three four", 9, 3), "one two\n   three\n   four");
        assert_eq!(filled("one", 9, 3), "one");
    }

    #[test]
    fn a_key_stays_with_its_value() {
        let text = "where it is: tip = { xyz_mm = [1, 2] } and more";
        assert_eq!(filled(text, 28, 2), "where it is:\n  tip = { xyz_mm = [1, 2] }\n  and more");
        assert_eq!(filled(text, 12, 2), "where it is: tip = { xyz_mm = [1, 2] }\n  and more");
    }

    #[test]
    fn advice_is_wrapped_too() {
        let lines = advice(INDENT, &"word ".repeat(40));
        assert!(lines.starts_with("          -> word") && lines.lines().count() > 2, "{lines}");
        assert!(lines.lines().skip(1).all(|line| line.starts_with("             word")), "{lines}");
        assert!(lines.lines().all(|line| line.chars().count() <= INDENT.len() + WIDTH[1]), "{lines}");
    }
}

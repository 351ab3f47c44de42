//! Results on stdout, diagnostics on stderr.

use std::borrow::Cow;
use std::io::{ErrorKind, Write};

use console::{colors_enabled, style};
use touchcal::estimate::Status;

use crate::failure::Failure;
use crate::summary::verdict;

/// Writes to stdout; a closed pipe is no failure.
pub fn print(text: &str) -> Result<(), Failure> {
    write(&printable(text))
}

fn write(text: &str) -> Result<(), Failure> {
    let mut stdout = std::io::stdout().lock();
    match stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(Failure::Stdout(error)),
        _ => Ok(()),
    }
}

/// Writes a result to stdout: the verdict, which has a colour on a terminal unless the environment
/// says no (`NO_COLOR`), and the text that follows.
pub fn print_result(status: Status, text: &str) -> Result<(), Failure> {
    let label = style(verdict(status)).bold();
    let coloured = match status {
        Status::Usable => label.green(),
        Status::Doubtful => label.yellow(),
        Status::NotUsable => label.red(),
    };
    let is_plain = std::env::var_os("NO_COLOR").is_some_and(|set| !set.is_empty());
    let coloured = coloured.force_styling(colors_enabled() && !is_plain);
    write(&format!("{coloured}{}", printable(text)))
}

/// Writes a line to stderr; a failure to do so is ignored.
pub fn diagnostic(line: &str) {
    let written = writeln!(std::io::stderr().lock(), "touchcal: {}", printable(line));
    drop(written);
}

/// `text` with control characters but line breaks and tabs escaped, as in JSON: names in files must
/// not control the terminal.
fn printable(text: &str) -> Cow<'_, str> {
    let commands = |c: char| c.is_control() && c != '\n' && c != '\t';
    if !text.contains(commands) {
        return Cow::Borrowed(text);
    }
    let escaped = |c: char| if commands(c) { format!("\\u{:04x}", u32::from(c)) } else { c.to_string() };
    Cow::Owned(text.chars().map(escaped).collect())
}

/// Writes the assumptions made in reading to stderr.
pub fn notes(notes: &[String]) {
    notes.iter().for_each(|note| diagnostic(&format!("note: {note}")));
}

/// JSON has no infinities.
pub fn finite(value: f64) -> Option<f64> {
    value.is_finite().then_some(value)
}

//! Results on stdout, diagnostics on stderr.

use std::io::{ErrorKind, Write};

use crate::failure::Failure;

/// Writes to stdout; a closed pipe is no failure.
pub fn print(text: &str) -> Result<(), Failure> {
    let mut stdout = std::io::stdout().lock();
    match stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(Failure::Stdout(error)),
        _ => Ok(()),
    }
}

/// Writes a line to stderr; a failure to do so is ignored.
pub fn diagnostic(line: &str) {
    let written = writeln!(std::io::stderr().lock(), "touchcal: {line}");
    drop(written);
}

/// Writes the assumptions made in reading to stderr.
pub fn notes(notes: &[String]) {
    notes.iter().for_each(|note| diagnostic(&format!("note: {note}")));
}

/// JSON has no infinities.
pub fn finite(value: f64) -> Option<f64> {
    value.is_finite().then_some(value)
}

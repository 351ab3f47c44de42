//! Results on stdout, complaints on stderr.

use std::io::{ErrorKind, Write};

use crate::command::Failure;

/// Writes to stdout; a reader that has left is no failure.
pub fn print(text: &str) -> Result<(), Failure> {
    let mut stdout = std::io::stdout().lock();
    match stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(Failure::Stdout(error)),
        _ => Ok(()),
    }
}

/// Writes a line to stderr; if that fails nobody is there to be told.
pub fn complain(line: &str) {
    let written = writeln!(std::io::stderr().lock(), "touchcal: {line}");
    drop(written);
}

/// Says on stderr what was taken for granted in reading.
pub fn notes(notes: &[String]) {
    notes.iter().for_each(|note| complain(&format!("note: {note}")));
}

/// JSON has no infinities.
pub fn finite(value: f64) -> Option<f64> {
    value.is_finite().then_some(value)
}

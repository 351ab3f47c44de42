//! Lines and fields of CSV, each bounded in size.

use std::io::{BufRead, Read};
use std::path::Path;

use super::{MAX_BYTES, MAX_LINE};
use crate::io::error::{IoError, Place};

/// The lines of a file with their numbers. Quoted fields may hold commas but no line breaks, so a
/// stray quote costs one line and not the rest of the file.
pub(in crate::io) struct Lines<'f, R> {
    input: R,
    file: &'f str,
    line: Vec<u8>,
    number: u64,
    bytes: u64,
}

impl<'f, R: BufRead> Lines<'f, R> {
    pub(in crate::io) fn new(input: R, file: &'f str) -> Self {
        Lines { input, file, line: Vec::new(), number: 0, bytes: 0 }
    }

    /// The next line that is not blank, without its end, and its number.
    pub(in crate::io) fn next(&mut self) -> Result<Option<(u64, &[u8])>, IoError> {
        loop {
            self.line.clear();
            let mut limited = self.input.by_ref().take(MAX_LINE as u64 + 1);
            let read = limited.read_until(b'\n', &mut self.line).map_err(|source| self.broken(source))?;
            if read == 0 {
                return Ok(None);
            }
            self.number += 1;
            self.bytes += read as u64;
            let place = || Place::file(self.file).line(self.number);
            if read > MAX_LINE {
                return Err(IoError::unexpected(place(), format!("at most {MAX_LINE} bytes in a line"), "more"));
            }
            if self.bytes > MAX_BYTES {
                return Err(IoError::unexpected(place(), format!("at most {MAX_BYTES} bytes, unpacked"), "more"));
            }
            let blank = self.line.iter().all(u8::is_ascii_whitespace);
            if !blank {
                break;
            }
        }
        let mut line = self.line.as_slice();
        if self.number == 1 {
            line = line.strip_prefix(b"\xef\xbb\xbf").unwrap_or(line);
        }
        Ok(Some((self.number, line.trim_ascii_end())))
    }

    fn broken(&self, source: std::io::Error) -> IoError {
        let damaged = matches!(source.kind(), std::io::ErrorKind::UnexpectedEof | std::io::ErrorKind::InvalidInput);
        if damaged || source.kind() == std::io::ErrorKind::InvalidData {
            let place = Place::file(self.file).line(self.number + 1);
            return IoError::unexpected(place, "complete gzip data", format!("truncated or damaged data ({source})"));
        }
        IoError::file(Path::new(self.file), "read", source)
    }
}

/// The fields of a line, trimmed, without their quotes.
pub(in crate::io) fn fields(line: &[u8]) -> Fields<'_> {
    Separator::Comma.fields(line)
}

/// What stands between fields.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::io) enum Separator {
    Comma,
    /// One or more blanks or tabs.
    Blanks,
}

impl Separator {
    pub(in crate::io) fn fields(self, line: &[u8]) -> Fields<'_> {
        Fields { rest: Some(line), separator: self }
    }
}

pub(in crate::io) struct Fields<'l> {
    rest: Option<&'l [u8]>,
    separator: Separator,
}

impl<'l> Iterator for Fields<'l> {
    type Item = &'l [u8];

    fn next(&mut self) -> Option<&'l [u8]> {
        let rest = self.rest.take()?;
        if self.separator == Separator::Blanks {
            let rest = rest.trim_ascii();
            let end = rest.iter().position(u8::is_ascii_whitespace);
            self.rest = end.map(|end| &rest[end..]);
            return Some(&rest[..end.unwrap_or(rest.len())]);
        }
        let start = rest.iter().position(|byte| !byte.is_ascii_whitespace()).unwrap_or(rest.len());
        // A quoted field ends at the comma after its closing quote; a doubled quote inside is kept
        // as two.
        let quoted = rest.get(start) == Some(&b'"');
        let closing = || rest[start + 1..].iter().position(|byte| *byte == b'"').map_or(start, |at| start + 1 + at);
        let from = if quoted { closing() } else { start };
        let end = rest[from..].iter().position(|byte| *byte == b',').map(|at| from + at);
        self.rest = end.map(|end| &rest[end + 1..]);
        let field = rest[..end.unwrap_or(rest.len())].trim_ascii();
        Some(field.strip_prefix(b"\"").and_then(|inner| inner.strip_suffix(b"\"")).map_or(field, <[u8]>::trim_ascii))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn split(line: &str) -> Vec<&str> {
        fields(line.as_bytes()).map(|field| std::str::from_utf8(field).unwrap()).collect()
    }

    #[test]
    fn fields_are_trimmed_and_unquoted() {
        assert_eq!(split("a, b ,c"), ["a", "b", "c"]);
        assert_eq!(split("\"a, x\" ,\" b\",,"), ["a, x", "b", "", ""]);
        assert_eq!(split("\"open,1"), ["\"open", "1"]);
        assert_eq!(split(""), [""]);
        let blanks: Vec<&[u8]> = Separator::Blanks.fields(b" 1.5\t-2   x ").collect();
        assert_eq!(blanks, [b"1.5".as_slice(), b"-2", b"x"]);
    }
}

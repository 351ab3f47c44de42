//! Comma-separated values: lines and fields, each bounded in size, and the names of columns.

use std::io::{BufRead, BufReader, Read};
use std::path::Path;

use flate2::bufread::MultiGzDecoder;

use super::error::{IoError, Place, quoted};

/// Largest size of one log (bytes, unpacked), 2 GiB: about 20 million rows of seven joints.
pub const MAX_BYTES: u64 = 2 << 30;
/// Largest length of one line with its line break (bytes), 64 KiB; a longer line is an error.
pub const MAX_LINE: usize = 1 << 16;

/// What to do with a bag in a format that is not read.
const CONVERT: &str =
    "to make MCAP of it: `pip install rosbags`, then `rosbags-convert --src BAG --dst NEW --dst-storage mcap`";

/// Bytes read from the file at a time.
const BUFFER: usize = 1 << 18;

/// The lines of a file with their numbers. Quoted fields may hold commas but no line breaks, so a
/// stray quote costs one line and not the rest of the file.
pub(crate) struct Lines<'f, R> {
    input: R,
    file: &'f str,
    line: Vec<u8>,
    number: u64,
    bytes: u64,
}

impl<'f, R: BufRead> Lines<'f, R> {
    pub(crate) fn new(input: R, file: &'f str) -> Self {
        Lines { input, file, line: Vec::new(), number: 0, bytes: 0 }
    }

    /// The next line that is not blank, without its end, and its number.
    pub(crate) fn next(&mut self) -> Result<Option<(u64, &[u8])>, IoError> {
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
pub(crate) fn fields(line: &[u8]) -> Fields<'_> {
    Separator::Comma.fields(line)
}

/// What stands between fields.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Separator {
    Comma,
    /// One or more blanks or tabs.
    Blanks,
}

impl Separator {
    pub(crate) fn fields(self, line: &[u8]) -> Fields<'_> {
        Fields { rest: Some(line), separator: self }
    }
}

pub(crate) struct Fields<'l> {
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

/// The text of a table, plain or gzipped; other formats are refused.
pub(crate) fn unpacked<'c>(content: impl Read + 'c, file: &str) -> Result<Box<dyn BufRead + 'c>, IoError> {
    let mut content = BufReader::with_capacity(BUFFER, content);
    let start = content.fill_buf().map_err(|source| IoError::file(Path::new(file), "read", source))?;
    refuse_other_formats(start, file)?;
    if start.starts_with(&[0x1f, 0x8b]) {
        return Ok(Box::new(BufReader::with_capacity(BUFFER, MultiGzDecoder::new(content))));
    }
    Ok(Box::new(content))
}

fn refuse_other_formats(start: &[u8], file: &str) -> Result<(), IoError> {
    let bags: [(&[u8], &str); 2] =
        [(b"SQLite format 3\0", "a ROS 2 bag in SQLite (.db3)"), (b"#ROSBAG V2.0", "a ROS 1 bag")];
    if let Some((_, name)) = bags.iter().find(|(magic, _)| start.starts_with(magic)) {
        return Err(IoError::unexpected(Place::file(file), "CSV or gzipped CSV", format!("{name}; {CONVERT}")));
    }
    let known: [(&[u8], &str); 6] = [
        (b"PAR1", "Parquet"),
        (b"\x89MCAP0", "MCAP"),
        (b"\x28\xb5\x2f\xfd", "a file packed by zstd: unpack it first (`zstd -d FILE`)"),
        (b"PK\x03\x04", "a zip archive or spreadsheet"),
        (b"\xff\xfe", "text in UTF-16"),
        (b"\xfe\xff", "text in UTF-16"),
    ];
    match known.iter().find(|(magic, _)| start.starts_with(magic)) {
        Some((_, name)) => Err(IoError::unexpected(Place::file(file), "CSV or gzipped CSV", *name)),
        None => Ok(()),
    }
}

/// The number of a cell; none where it is none, or not finite.
pub(crate) fn finite(cell: &[u8]) -> Option<f64> {
    let value: f64 = std::str::from_utf8(cell).ok()?.parse().ok()?;
    value.is_finite().then_some(value)
}

/// A cell in quotes, for messages.
pub(crate) fn shown(cell: &[u8]) -> String {
    quoted(&String::from_utf8_lossy(cell))
}

/// Column names as a message shows them.
pub(crate) fn names(cells: &[&[u8]]) -> String {
    let names: Vec<_> = cells.iter().map(|cell| String::from_utf8_lossy(cell)).collect();
    shown_names(&names.iter().map(AsRef::as_ref).collect::<Vec<&str>>())
}

/// Column names as a message shows them.
pub(crate) fn shown_names(header: &[&str]) -> String {
    format!("columns {}", quoted(&header.join(",")))
}

/// Advice where a header looks as if its fields had another separator.
pub(crate) fn hint(cells: &[&[u8]]) -> &'static str {
    match cells {
        [only] if only.contains(&b';') => " (fields are separated by `,`, not by `;`)",
        [only] if only.contains(&b'\t') => " (fields are separated by `,`, not by tabs)",
        [only] if only.contains(&b' ') => " (fields are separated by `,`, not by blanks)",
        _ => "",
    }
}

/// Whether two names are the same but for case and blanks around them.
pub(crate) fn same(a: &str, b: &str) -> bool {
    a.trim().eq_ignore_ascii_case(b.trim())
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

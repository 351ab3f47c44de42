//! Errors of reading and writing files, with their place.

use std::fmt;
use std::path::Path;

/// Longest excerpt of a file that a message quotes (characters).
const EXCERPT: usize = 60;
/// Longest name that a message shows whole (characters).
const LONGEST_NAME: usize = 80;

/// A place in a file, shown as `file:line:column, field`; parts that are `None` are left out.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Place {
    /// Name of the file, as the user gave it.
    pub file: String,
    /// Line, 1 for the first; `None` for the file as a whole.
    pub line: Option<u64>,
    /// Column in characters, 1 for the first; shown only together with a line.
    pub column: Option<u64>,
    /// Element, key or table column, in words; several levels are separated by commas.
    pub field: Option<String>,
}

impl Place {
    /// A file as a whole, by its name.
    pub fn file(file: impl Into<String>) -> Place {
        Place { file: file.into(), ..Place::default() }
    }

    /// This place with a line number, 1 for the first line, in place of the former one.
    pub fn line(mut self, line: u64) -> Place {
        self.line = Some(line);
        self
    }

    /// This place with an element, key or table column; appended to the one named before, if any.
    pub fn field(mut self, field: impl Into<String>) -> Place {
        let field = field.into();
        self.field = Some(self.field.map_or(field.clone(), |outer| format!("{outer}, {field}")));
        self
    }

    /// The line and column of byte `offset` of `text`.
    pub(crate) fn at_byte(mut self, text: &str, offset: usize) -> Place {
        let before = text.get(..offset).unwrap_or(text);
        self.line = Some(1 + before.bytes().filter(|&byte| byte == b'\n').count() as u64);
        let line_start = before.rfind('\n').map_or(0, |newline| newline + 1);
        self.column = Some(1 + before[line_start..].chars().count() as u64);
        self
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.file)?;
        if let Some(line) = self.line {
            write!(f, ":{line}")?;
            if let Some(column) = self.column {
                write!(f, ":{column}")?;
            }
        }
        match &self.field {
            Some(field) => write!(f, ", {field}"),
            None => Ok(()),
        }
    }
}

/// Why a file cannot be read, understood or written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum IoError {
    /// The operating system refused an operation on a file.
    #[error("{path}: could not {action}: {source}")]
    File {
        /// Path of the file or folder.
        path: String,
        /// Operation that failed, as it follows "could not": "read", "write", "open", "make the
        /// folder" …
        action: &'static str,
        /// Reason given by the operating system.
        source: std::io::Error,
    },
    /// A file's content, or an option or name that was given for it, is not what is required there.
    #[error("{place}: expected {expected}, found {found}")]
    Unexpected {
        /// Where in the file.
        place: Box<Place>,
        /// What the format requires there, in words.
        expected: String,
        /// What the file has there, in words or as an excerpt.
        found: String,
    },
    /// The text does not follow the grammar of its format, describes something that cannot be, such
    /// as an outline that crosses itself, or could not be serialized.
    #[error("{place}: {message}")]
    Syntax {
        /// Where in the file.
        place: Box<Place>,
        /// Message of the parser, of the type that refuses the content, or of the serializer.
        message: String,
    },
}

impl IoError {
    pub(crate) fn unexpected(place: Place, expected: impl Into<String>, found: impl Into<String>) -> IoError {
        IoError::Unexpected { place: Box::new(place), expected: expected.into(), found: found.into() }
    }

    pub(crate) fn syntax(place: Place, message: impl Into<String>) -> IoError {
        IoError::Syntax { place: Box::new(place), message: message.into() }
    }

    pub(crate) fn file(path: &Path, action: &'static str, source: std::io::Error) -> IoError {
        IoError::File { path: path.display().to_string(), action, source }
    }
}

/// Reads by `read` from a file of that `format`.
///
/// Some damage makes the crates `parquet` (60.1: a negative offset, a page whose dictionary is
/// missing) and `mcap` (0.26: a record that goes on beyond its chunk, where overflow is checked)
/// panic. That is caught here and is an error as any other, though the panic hook has its say.
#[cfg(any(feature = "mcap", feature = "parquet"))]
pub(crate) fn caught<T>(file: &str, format: &str, read: impl FnOnce() -> Result<T, IoError>) -> Result<T, IoError> {
    std::panic::catch_unwind(std::panic::AssertUnwindSafe(read)).unwrap_or_else(|_| {
        Err(IoError::unexpected(Place::file(file), format!("a whole {format} file"), "damaged data"))
    })
}

/// A number as messages show it: in full, or with an exponent where that takes more than 17 digits.
pub(crate) fn shown_number(value: f64) -> String {
    let is_plain = value == 0.0 || (1e-5..1e17).contains(&value.abs());
    if is_plain { format!("{value}") } else { format!("{value:e}") }
}

/// `name` as messages show it: cut where it is long.
pub(crate) fn shown_name(name: &str) -> String {
    match name.char_indices().nth(LONGEST_NAME) {
        Some((end, _)) => format!("{}…", &name[..end]),
        None => name.to_owned(),
    }
}

/// `text` in quotes, control characters escaped, shortened where it is long.
pub(crate) fn quoted(text: &str) -> String {
    match text.char_indices().nth(EXCERPT) {
        Some((end, _)) => format!("{:?}…", &text[..end]),
        None => format!("{text:?}"),
    }
}

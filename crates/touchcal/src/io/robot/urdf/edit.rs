//! Replacements of some bytes of a URDF, all others kept.

use std::ops::Range;

use roxmltree::{Attribute, Node};

use super::document::place;
use crate::io::base::error::IoError;

/// The text's name in messages: writers are given no path.
pub(super) const FILE: &str = "URDF";

/// A replacement of some bytes of the text.
pub(super) struct Edit {
    pub(super) range: Range<usize>,
    pub(super) with: String,
}

impl Edit {
    /// Puts something before the byte `at`.
    pub(super) fn insert(at: usize, with: impl Into<String>) -> Edit {
        Edit { range: at..at, with: with.into() }
    }
}

/// The text with all edits, which do not overlap; those at one byte in their order.
pub(super) fn apply(text: &str, mut edits: Vec<Edit>) -> String {
    edits.sort_by_key(|edit| (edit.range.start, edit.range.end));
    let mut out = String::with_capacity(text.len() + 64 * edits.len());
    let mut done = 0;
    for edit in &edits {
        out.push_str(slice(text, done..edit.range.start));
        out.push_str(&edit.with);
        done = edit.range.end;
    }
    out.push_str(slice(text, done..text.len()));
    out
}

/// Where an element's name ends: before something that no name contains.
pub(super) fn name_end(element: &Node<'_, '_>, text: &str) -> usize {
    let start = element.range().start;
    let rest = slice(text, start..text.len());
    start + rest.find(|c: char| c.is_ascii_whitespace() || c == '/' || c == '>').unwrap_or(0)
}

/// The bytes between the quotes of an attribute of `element`.
pub(super) fn value_range(
    element: &Node<'_, '_>,
    attribute: &Attribute<'_, '_>,
    text: &str,
) -> Result<Range<usize>, IoError> {
    // Not `range_value`: it is documented to be off where very many blanks surround the equals
    // sign.
    let range = attribute.range();
    let whole = slice(text, range.clone());
    let quote = whole.find(['"', '\'']).filter(|quote| quote + 2 <= whole.len());
    match quote {
        Some(quote) => Ok(range.start + quote + 1..range.end - 1),
        None => {
            let expected = format!("a quoted `{}`", attribute.name());
            Err(IoError::unexpected(place(element, FILE), expected, "none"))
        }
    }
}

/// Byte ranges of the parser lie on characters of the text; an empty string stands for one that
/// does not.
pub(super) fn slice(text: &str, range: Range<usize>) -> &str {
    text.get(range).unwrap_or_default()
}

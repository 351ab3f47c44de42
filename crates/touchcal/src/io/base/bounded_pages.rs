//! A Parquet file whose pages are bounded.
//!
//! The parquet crate reserves as many bytes for a page, and room for as many values of a
//! dictionary, as the header of the page says: a few damaged bytes would take gigabytes. A
//! header that gives its size once more, behind the first structure, is not recognized; no writer
//! makes such a header.

use std::io::{Chain, Cursor, Read};

use bytes::Bytes;
use parquet::errors::ParquetError;
use parquet::file::FOOTER_SIZE;
use parquet::file::reader::{ChunkReader, Length};

/// Most bytes of a page after decompression: half a million numbers. Most programs write pages of
/// one megabyte.
const MAX_PAGE: u64 = 1 << 22;
/// Bytes of a page's header up to the number of its values, or more: six fields of a byte, their
/// identifiers in up to three, and their values in up to ten.
const HEAD: u64 = 84;
/// Types of fields in Thrift's compact protocol: a 32-bit integer, and a structure.
const INTEGER: u8 = 5;
const STRUCTURE: u8 = 12;
/// Identifiers of fields: the type of a page, its size after decompression, and the structure that
/// only a dictionary has.
const PAGE_TYPE: u64 = 1;
const UNCOMPRESSED_SIZE: u64 = 2;
const DICTIONARY: u64 = 7;
/// Type of a page that is a dictionary.
const IS_DICTIONARY: u64 = 2;

/// The content of a Parquet file. It is an error to read a page of more than [`MAX_PAGE`] bytes, a
/// page beyond the end of the file, or a dictionary of more values than bytes.
pub(crate) struct BoundedPages<R>(pub R);

impl<R: ChunkReader> Length for BoundedPages<R> {
    fn len(&self) -> u64 {
        self.0.len()
    }
}

impl<R: ChunkReader> ChunkReader for BoundedPages<R> {
    type T = Chain<Cursor<Vec<u8>>, R::T>;

    fn get_read(&self, start: u64) -> Result<Self::T, ParquetError> {
        let mut rest = self.0.get_read(start)?;
        let mut head = Vec::new();
        rest.by_ref().take(HEAD).read_to_end(&mut head)?;
        // The parquet crate reads headers of pages in this way, and the end of the file.
        if start.saturating_add(FOOTER_SIZE as u64) < self.len() {
            check_page(&head)?;
        }
        Ok(Cursor::new(head).chain(rest))
    }

    fn get_bytes(&self, start: u64, length: usize) -> Result<Bytes, ParquetError> {
        if start.saturating_add(length as u64) > self.len() {
            return Err(ParquetError::General(format!("{length} bytes at {start}, beyond the end of the file")));
        }
        self.0.get_bytes(start, length)
    }
}

/// Checks the size of a page, of which `head` is the beginning of its header, and how many values
/// it has if it is a dictionary.
fn check_page(head: &[u8]) -> Result<(), ParquetError> {
    let Some((size, values)) = size_and_values(&mut head.iter().copied()) else {
        return Err(ParquetError::General("a page's header is damaged".to_owned()));
    };
    if size > MAX_PAGE {
        let remedy = "its writer must make pages or row groups smaller";
        return Err(ParquetError::General(format!("a page of {size} bytes, more than {MAX_PAGE}: {remedy}")));
    }
    if values.is_some_and(|values| values > size) {
        return Err(ParquetError::General("a dictionary of more values than bytes".to_owned()));
    }
    Ok(())
}

/// From a page's header its size (bytes) after decompression, and the number of values if it is a
/// dictionary; `None` if the fields up to these are not in the order of their identifiers.
///
/// Source: the Thrift project's specification of the compact protocol, and `PageHeader` in that of
/// Apache Parquet.
fn size_and_values(bytes: &mut impl Iterator<Item = u8>) -> Option<(u64, Option<u64>)> {
    let (mut identifier, mut size, mut is_dictionary) = (0, None, false);
    loop {
        match next_field(bytes, &mut identifier)? {
            INTEGER => match (identifier, unsigned(bytes)? >> 1) {
                (PAGE_TYPE, page_type) => is_dictionary = page_type == IS_DICTIONARY,
                (UNCOMPRESSED_SIZE, bytes) => size = Some(bytes),
                _ => {}
            },
            STRUCTURE if is_dictionary != (identifier == DICTIONARY) => return None,
            STRUCTURE if is_dictionary => {
                let is_integer = next_field(bytes, &mut 0)? == INTEGER;
                let values = is_integer.then(|| unsigned(bytes)).flatten()? >> 1;
                return Some((size?, Some(values)));
            }
            STRUCTURE => return Some((size?, None)),
            _ => return None,
        }
    }
}

/// The type of the next field; `None` if its identifier is not larger than that of the field
/// before. `identifier` is that of the field before, and becomes that of the next.
fn next_field(bytes: &mut impl Iterator<Item = u8>, identifier: &mut u64) -> Option<u8> {
    let field = bytes.next()?;
    let next = match field >> 4 {
        0 => unsigned(bytes)? >> 1,
        difference => *identifier + u64::from(difference),
    };
    let is_larger = next > std::mem::replace(identifier, next);
    is_larger.then_some(field & 0x0f)
}

/// A number in groups of seven bits, the lowest group first. The lowest bit of a signed number is
/// its sign.
fn unsigned(bytes: &mut impl Iterator<Item = u8>) -> Option<u64> {
    let mut value = 0;
    for shift in (0..u64::BITS).step_by(7) {
        let byte = bytes.next()?;
        value |= u64::from(byte & 0x7f) << shift;
        if byte & 0x80 == 0 {
            return Some(value);
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A page's header: its type (2 is a dictionary's), sizes and number of values, as writers have
    /// it, with every field's identifier as a difference.
    fn header(kind: u8, size: u64, values: u64) -> Vec<u8> {
        let number = |mut value: u64| {
            let mut bytes = Vec::new();
            while value >= 0x80 {
                bytes.push(value as u8 | 0x80);
                value >>= 7;
            }
            bytes.push(value as u8);
            bytes
        };
        let has = if kind == 2 { 0x4c } else { 0x2c };
        let fields = [vec![0x15, 2 * kind, 0x15], number(2 * size), vec![0x15, 20, has, 0x15], number(2 * values)];
        [fields.concat(), vec![0x15, 0, 0, 0]].concat()
    }

    #[test]
    fn pages_are_bounded() {
        assert!(check_page(&header(0, MAX_PAGE, 1_000_000_000)).is_ok());
        assert!(check_page(&header(2, 80, 10)).is_ok());
        let refusal = |head: &[u8]| check_page(head).expect_err("a page that is refused").to_string();
        assert!(refusal(&header(0, MAX_PAGE + 1, 10)).contains("a page of 4194305 bytes, more than 4194304"));
        assert!(refusal(&header(2, u64::from(u32::MAX), 10)).contains("a page of 4294967295 bytes"));
        assert!(refusal(&header(2, 80, 81)).contains("more values than bytes"));
        // The identifier of the size in full.
        let mut full = header(0, MAX_PAGE + 1, 10);
        full.splice(2..3, [0x05, 4]);
        assert!(refusal(&full).contains("a page of 4194305 bytes"));
        // An end in the middle.
        assert!((0..10).all(|end| refusal(&header(2, 80, 10)[..end]).contains("header is damaged")));
        assert!(refusal(&[0x1c, 0x15, 2, 0]).contains("header is damaged"));
        // The type of a dictionary, with the structure of a page of values.
        let mut without = header(0, 80, 81);
        without[1] = 2 * 2;
        assert!(refusal(&without).contains("header is damaged"));
    }
}

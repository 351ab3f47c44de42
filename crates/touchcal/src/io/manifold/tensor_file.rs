//! Safetensors files with one entry of metadata. Their header is checked before their tensors are
//! read.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use safetensors::SafeTensors;
use safetensors::tensor::Metadata;

use crate::io::base::bytes::{self, Input};
use crate::io::base::error::{IoError, Place};

/// Longest header read (bytes).
const MAX_HEADER: u64 = 1 << 20;
/// Length of the header's own length (bytes).
const LENGTH: u64 = 8;

/// The bytes of a file of at most `limit`, and their fingerprint. What is no safetensors file of
/// the size that its header states, or lacks the entry `key`, is refused from its header alone.
pub(crate) fn read_all(path: &Path, limit: u64, key: &str) -> Result<(Vec<u8>, Input), IoError> {
    let name = path.display().to_string();
    let failed = |source| IoError::file(path, "read", source);
    let mut file = bytes::open(path)?;
    let size = file.metadata().map_err(failed)?.len();
    bytes::check_size(size, limit, &name)?;
    let mut content = Vec::new();
    let mut extend = |content: &mut Vec<u8>, length: u64| extend(&mut file, content, length).map_err(failed);
    extend(&mut content, LENGTH)?;
    let header = content.first_chunk().map_or(u64::MAX, |length| u64::from_le_bytes(*length));
    if header > MAX_HEADER {
        let expected = format!("a whole safetensors file, with a header of at most {MAX_HEADER} bytes");
        return Err(IoError::unexpected(Place::file(name), expected, "another file"));
    }
    extend(&mut content, header)?;
    let found = check_header(content.get(LENGTH as usize..).unwrap_or_default(), &name, key)?;
    let stated = found.saturating_add(LENGTH + header);
    if stated != size {
        let expected = format!("a whole safetensors file, of {stated} bytes by its header");
        return Err(IoError::unexpected(Place::file(name), expected, format!("{size} bytes")));
    }
    extend(&mut content, found)?;
    let sha256 = bytes::sha256(&content);
    Ok((content, Input { path: name, sha256, is_log: false }))
}

/// Reads so many bytes more, or those that are left.
fn extend(file: &mut File, content: &mut Vec<u8>, length: u64) -> std::io::Result<()> {
    file.take(length).read_to_end(content).map(drop)
}

/// Number of bytes of the tensors, by a header with the entry `key`.
fn check_header(header: &[u8], file: &str, key: &str) -> Result<u64, IoError> {
    let header: Metadata = serde_json::from_slice(header)
        .map_err(|error| IoError::unexpected(Place::file(file), "a whole safetensors file", error.to_string()))?;
    entry(&header, file, key)?;
    Ok(header.data_len() as u64)
}

/// The tensors of a file's bytes, and the text of its entry `key`; `file` is its name for messages.
pub(crate) fn parse<'b>(bytes: &'b [u8], file: &str, key: &str) -> Result<(SafeTensors<'b>, String), IoError> {
    let damaged = |error| IoError::unexpected(Place::file(file), "a whole safetensors file", format!("{error}"));
    let (_, header) = SafeTensors::read_metadata(bytes).map_err(damaged)?;
    let tensors = SafeTensors::deserialize(bytes).map_err(damaged)?;
    Ok((tensors, entry(&header, file, key)?.to_owned()))
}

fn entry<'h>(header: &'h Metadata, file: &str, key: &str) -> Result<&'h str, IoError> {
    header.metadata().as_ref().and_then(|metadata| metadata.get(key)).map(String::as_str).ok_or_else(|| {
        let found = format!("a file without it, of {} tensors", header.tensors().len());
        IoError::unexpected(Place::file(file).field("metadata"), format!("entry `{key}`"), found)
    })
}

//! Bytes of files, with a bound on how many, and their fingerprints.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::io::base::error::{IoError, Place};
use crate::io::base::manifest;

/// Path and fingerprint of a file that was read, for provenance.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Input {
    /// Path of the file, as given or found; of content in memory the name that stands for it.
    pub path: String,
    /// SHA-256 of the file's bytes, 64 hexadecimal digits in lower case.
    pub sha256: String,
    /// Whether it is a log of contacts.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub is_log: bool,
}

impl Input {
    /// Fingerprint of `content` in memory, under a `name` that stands for a path. No file is read.
    pub fn of(name: impl Into<String>, content: impl AsRef<[u8]>) -> Input {
        Input { path: name.into(), sha256: sha256(content), is_log: false }
    }
}

/// Passes bytes on and fingerprints them.
pub(crate) struct Hashing<R> {
    inner: R,
    hasher: Sha256,
}

impl<R: Read> Hashing<R> {
    pub(crate) fn new(inner: R) -> Self {
        Hashing { inner, hasher: Sha256::new() }
    }

    /// The fingerprint of all bytes, those not yet read too.
    pub(crate) fn finish(mut self) -> std::io::Result<String> {
        std::io::copy(&mut self, &mut std::io::sink())?;
        Ok(hex(&self.hasher.finalize()))
    }
}

impl<R: Read> Read for Hashing<R> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let count = self.inner.read(buffer)?;
        self.hasher.update(&buffer[..count]);
        Ok(count)
    }
}

/// Opens a regular file, which is of no unfinished result.
pub(crate) fn open(path: &Path) -> Result<File, IoError> {
    manifest::check_finished(path)?;
    // Asked before opening: a pipe would block.
    let kind = std::fs::metadata(path).map_err(|source| IoError::file(path, "open", source))?;
    if !kind.is_file() {
        let found = if kind.is_dir() { "a folder" } else { "a device or pipe" };
        return Err(IoError::unexpected(Place::file(path.display().to_string()), "a file", found));
    }
    File::open(path).map_err(|source| IoError::file(path, "open", source))
}

/// The bytes of a file of at most `limit`, and their fingerprint.
pub(crate) fn read_all(path: &Path, limit: u64) -> Result<(Vec<u8>, Input), IoError> {
    let name = path.display().to_string();
    let mut bytes = Vec::new();
    let file = open(path)?;
    let size = file.metadata().map_err(|source| IoError::file(path, "read", source))?.len();
    check_size(size, limit, &name)?;
    // It may grow meanwhile.
    let mut limited = file.take(limit + 1);
    limited.read_to_end(&mut bytes).map_err(|source| IoError::file(path, "read", source))?;
    check_size(bytes.len() as u64, limit, &name)?;
    let sha256 = sha256(&bytes);
    Ok((bytes, Input { path: name, sha256, is_log: false }))
}

/// The text of a file of at most `limit` bytes, and its fingerprint.
pub(crate) fn read_text(path: &Path, limit: u64) -> Result<(String, Input), IoError> {
    let (bytes, input) = read_all(path, limit)?;
    let text = text_from(&bytes, &input.path)?.to_owned();
    Ok((text, input))
}

/// The fingerprint of a text or of bytes.
pub(crate) fn sha256(content: impl AsRef<[u8]>) -> String {
    hex(&Sha256::digest(content))
}

/// The fingerprint of bytes in parts, one after another.
pub(crate) fn sha256_of_parts(parts: impl Iterator<Item = impl AsRef<[u8]>>) -> String {
    let mut hasher = Sha256::new();
    parts.for_each(|part| hasher.update(part));
    hex(&hasher.finalize())
}

/// Refuses more than `limit` bytes.
pub(crate) fn check_size(bytes: u64, limit: u64, file: &str) -> Result<(), IoError> {
    if bytes > limit {
        return Err(IoError::unexpected(Place::file(file), format!("at most {limit} bytes"), "more"));
    }
    Ok(())
}

/// UTF-8, without its byte-order mark, or an error with the line.
pub(crate) fn text_from<'a>(bytes: &'a [u8], file: &str) -> Result<&'a str, IoError> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    std::str::from_utf8(bytes).map_err(|error| {
        let before = &bytes[..error.valid_up_to()];
        let line = 1 + before.iter().filter(|&&byte| byte == b'\n').count() as u64;
        let found = bytes.get(error.valid_up_to()).map_or(String::new(), |byte| format!("byte 0x{byte:02x}"));
        IoError::unexpected(Place::file(file).line(line), "UTF-8 text", found)
    })
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

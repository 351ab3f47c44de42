//! Files that are written whole or not at all.

use std::ffi::OsStr;
use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};

use tempfile::{NamedTempFile, PersistError};

use crate::io::base::error::IoError;

/// What the names of temporary files begin with: those of single files, and those of files that
/// are one result.
const OF_FILE: &str = ".touchcal-";
pub(crate) const OF_RESULT: &str = ".touchcal-result-";

/// Writes `bytes` to `path`: to a temporary file in the same folder, which is flushed to the disk
/// and then renamed. A concurrent reader of `path` gets the old content or the new, never a part.
/// Missing folders are made; an existing file is replaced, and a symbolic link by the file.
///
/// # Errors
/// [`IoError::File`] if the folder cannot be made, `path` is a folder, or the file cannot be
/// written. `path` is then as it was and the temporary file removed; folders that were made stay.
pub fn write(path: &Path, bytes: &[u8]) -> Result<(), IoError> {
    write_by(path, |file| file.write_all(bytes).map_err(|source| IoError::file(path, "write", source)))
}

/// As [`write()`], for content that `content` writes into the open temporary file, which is empty
/// and at its beginning, piece by piece.
///
/// # Errors
/// As [`write()`], and those of `content`; `path` is then as it was.
pub fn write_by(path: &Path, content: impl FnOnce(&mut File) -> Result<(), IoError>) -> Result<(), IoError> {
    prepare(path, OF_FILE, content)?.replace()
}

/// A file that is written but not yet in its place.
pub(crate) struct Prepared {
    path: PathBuf,
    temporary: NamedTempFile,
}

impl Prepared {
    /// Puts the file in its place.
    pub(crate) fn replace(self) -> Result<(), IoError> {
        let failed = |error: PersistError| IoError::file(&self.path, "write", error.error);
        self.temporary.persist(&self.path).map(drop).map_err(failed)
    }
}

/// Writes what [`write_by`] does, to a temporary file whose name begins with `prefix`.
pub(crate) fn prepare(
    path: &Path,
    prefix: &str,
    content: impl FnOnce(&mut File) -> Result<(), IoError>,
) -> Result<Prepared, IoError> {
    let folder = match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    std::fs::create_dir_all(folder).map_err(|source| IoError::file(folder, "make the folder", source))?;
    let failed = |source| IoError::file(path, "write", source);
    let mut temporary = builder(prefix).tempfile_in(folder).map_err(failed)?;
    content(temporary.as_file_mut())?;
    // Without this, a power cut after the rename could leave an empty file under the final name.
    temporary.as_file().sync_all().map_err(failed)?;
    Ok(Prepared { path: path.to_owned(), temporary })
}

/// Removes temporary files of results that runs left in `folder` when they were ended; what cannot
/// be removed stays.
pub(crate) fn remove_left_over(folder: &Path) {
    let is_temporary = |name: &OsStr| name.to_str().is_some_and(|name| name.starts_with(OF_RESULT));
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        if is_temporary(&entry.file_name()) {
            std::fs::remove_file(entry.path()).ok();
        }
    }
}

/// Removes a file; of a symbolic link the link, not what it points to.
///
/// # Errors
/// [`IoError::File`] if there is no such file, `path` is a folder, or the file cannot be removed.
pub fn remove(path: &Path) -> Result<(), IoError> {
    std::fs::remove_file(path).map_err(|source| IoError::file(path, "remove", source))
}

/// Temporary files are private by default, which the final file should not be: let the user's umask
/// decide.
#[cfg(unix)]
fn builder(prefix: &str) -> tempfile::Builder<'_, 'static> {
    use std::os::unix::fs::PermissionsExt;
    let mut builder = tempfile::Builder::new();
    builder.prefix(prefix).permissions(std::fs::Permissions::from_mode(0o666));
    builder
}

#[cfg(not(unix))]
fn builder(prefix: &str) -> tempfile::Builder<'_, 'static> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(prefix);
    builder
}

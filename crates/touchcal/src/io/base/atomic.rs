//! Files that are written whole or not at all.

use std::ffi::OsStr;
use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};

use tempfile::{NamedTempFile, PersistError};

use crate::io::base::error::IoError;

/// What the names of temporary files begin with, and how many letters and digits follow.
const TEMPORARY: &str = ".touchcal-";
const RANDOM: usize = 6;

/// Writes `bytes` to `path`: to a temporary file in the same folder, which is flushed to the disk
/// and then renamed. A concurrent reader of `path` gets the old content or the new, never a part.
/// Missing folders are made; an existing file is replaced, and a symbolic link by the file.
///
/// # Errors
/// [`IoError::File`] if the folder cannot be made, `path` is a folder, or the file cannot be
/// written. `path` is then as it was and the temporary file removed; folders that were made stay.
pub fn write(path: &Path, bytes: &[u8]) -> Result<(), IoError> {
    write_by(path, |file| write_all(file, path, bytes))
}

/// Writes `bytes` into the open file that is to be at `path`.
pub(crate) fn write_all(file: &mut File, path: &Path, bytes: &[u8]) -> Result<(), IoError> {
    file.write_all(bytes).map_err(|source| IoError::file(path, "write", source))
}

/// As [`write()`], for content that `content` writes into the open temporary file, which is empty
/// and at its beginning, piece by piece.
///
/// # Errors
/// As [`write()`], and those of `content`; `path` is then as it was.
pub fn write_by(path: &Path, content: impl FnOnce(&mut File) -> Result<(), IoError>) -> Result<(), IoError> {
    prepare(path, content)?.replace()
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

/// Writes what [`write_by`] does, to a temporary file.
pub(crate) fn prepare(
    path: &Path,
    content: impl FnOnce(&mut File) -> Result<(), IoError>,
) -> Result<Prepared, IoError> {
    let folder = match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    std::fs::create_dir_all(folder).map_err(|source| IoError::file(folder, "make the folder", source))?;
    let failed = |source| IoError::file(path, "write", source);
    let mut temporary = temporary_in(folder).map_err(failed)?;
    content(temporary.as_file_mut())?;
    // Without this, a power cut after the rename could leave an empty file under the final name.
    temporary.as_file().sync_all().map_err(failed)?;
    Ok(Prepared { path: path.to_owned(), temporary })
}

/// A temporary file that is locked, as long as it is open: it is not left over.
fn temporary_in(folder: &Path) -> std::io::Result<NamedTempFile> {
    loop {
        let temporary = builder().tempfile_in(folder)?;
        // A file system without locks does without them.
        temporary.as_file().lock().ok();
        // Another run may have taken it for left over before it was locked.
        if temporary.path().exists() {
            return Ok(temporary);
        }
    }
}

/// Removes the temporary files in `folder` that no run has open: those of runs that were ended. For
/// folders of one machine: another's lock may not be seen. What cannot be removed stays; nothing
/// happens if there is no such folder.
pub fn remove_left_over(folder: &Path) {
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let is_file = entry.file_type().is_ok_and(|kind| kind.is_file());
        if !is_file || !is_temporary(&entry.file_name()) {
            continue;
        }
        // Locked while it is removed, so that a run that is about to lock it sees that it is gone.
        let Ok(file) = File::options().write(true).open(entry.path()) else { continue };
        if file.try_lock().is_ok() {
            std::fs::remove_file(entry.path()).ok();
        }
    }
}

fn is_temporary(name: &OsStr) -> bool {
    let random = name.to_str().and_then(|name| name.strip_prefix(TEMPORARY));
    random.is_some_and(|random| random.len() == RANDOM && random.bytes().all(|byte| byte.is_ascii_alphanumeric()))
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
fn builder() -> tempfile::Builder<'static, 'static> {
    use std::os::unix::fs::PermissionsExt;
    let mut builder = tempfile::Builder::new();
    builder.prefix(TEMPORARY).rand_bytes(RANDOM).permissions(std::fs::Permissions::from_mode(0o666));
    builder
}

#[cfg(not(unix))]
fn builder() -> tempfile::Builder<'static, 'static> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(TEMPORARY).rand_bytes(RANDOM);
    builder
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_temporary_files_that_no_run_has_open_are_left_over() {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path();
        for name in [".touchcal-left12", ".touchcal-notes", "mine", ".mine"] {
            std::fs::write(folder.join(name), "").unwrap();
        }
        std::fs::create_dir(folder.join(".touchcal-folder")).unwrap();
        let other = prepare(&folder.join("a"), |file| write_all(file, Path::new("a"), b"1")).unwrap();
        remove_left_over(folder);
        let names = || {
            let mut names: Vec<String> = std::fs::read_dir(folder)
                .unwrap()
                .map(|entry| entry.unwrap().file_name().to_str().unwrap().to_owned())
                .filter(|name| name != ".touchcal-folder")
                .collect();
            names.sort();
            names
        };
        let temporary = other.temporary.path().file_name().unwrap().to_str().unwrap().to_owned();
        assert!(
            names() == [".mine", &temporary, ".touchcal-notes", "mine"]
                || names() == [".mine", ".touchcal-notes", &temporary, "mine"]
        );
        other.replace().unwrap();
        assert_eq!(names(), [".mine", ".touchcal-notes", "a", "mine"]);
    }
}

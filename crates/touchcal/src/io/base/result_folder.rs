//! A folder whose files are one result: all of one run, or known to be unfinished.
//!
//! The manifest, [`MANIFEST`], lists the files that touchcal wrote; only these are replaced or
//! removed. A new result is written to temporary files first. Then the manifest is replaced by one
//! that lists the new files as unfinished, the files are renamed, those of the former result that
//! the new one lacks are removed, and the manifest is replaced by that of the finished result.
//! Wherever that ends early, the files are those of the former result, those of the new one, or
//! unfinished: readers refuse these, and the next run replaces them.

use std::collections::BTreeMap;
use std::fs::{File, TryLockError};
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::atomic;
use super::bytes;
use super::error::{IoError, Place};

/// Name of the manifest.
pub(crate) const MANIFEST: &str = "touchcal.json";
/// Largest manifest read (bytes).
const MAX_BYTES: u64 = 1 << 20;

/// Path of a file in a result's folder, with `/` between its parts, and its content.
pub(crate) type ResultFile = (&'static str, Vec<u8>);

/// The files of a result, by their paths in the folder, with `/` between their parts.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Manifest {
    /// Version of this format: 1.
    schema: u32,
    /// Whether files may be missing, or be those of a former result.
    unfinished: bool,
    /// SHA-256 of each file as it was written.
    files: BTreeMap<String, String>,
    /// Files of former results that are to be removed.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    obsolete: Vec<String>,
}

impl Manifest {
    fn read(folder: &Path) -> Result<Manifest, IoError> {
        let path = folder.join(MANIFEST);
        if !path.is_file() {
            return Ok(Manifest::default());
        }
        let (text, input) = bytes::read_text(&path, MAX_BYTES)?;
        serde_json::from_str(&text).map_err(|error| IoError::syntax(Place::file(input.path), error.to_string()))
    }

    fn write(&self, folder: &Path) -> Result<(), IoError> {
        let path = folder.join(MANIFEST);
        let failed =
            |error: serde_json::Error| IoError::syntax(Place::file(path.display().to_string()), error.to_string());
        atomic::write(&path, &serde_json::to_vec_pretty(self).map_err(failed)?)
    }

    fn lists(&self, name: &str) -> bool {
        self.files.contains_key(name) || self.obsolete.iter().any(|known| known == name)
    }
}

/// Checks that no file of these `names` in `folder` is anything but touchcal's.
///
/// # Errors
/// [`IoError`] if there is one that the manifest does not list, or the manifest cannot be read.
pub(crate) fn check_own<'n>(folder: &Path, names: impl IntoIterator<Item = &'n str>) -> Result<(), IoError> {
    let manifest = Manifest::read(folder)?;
    let mut foreign = names.into_iter().filter(|name| folder.join(name).exists() && !manifest.lists(name));
    match foreign.next() {
        None => Ok(()),
        Some(name) => {
            let place = Place::file(folder.join(name).display().to_string());
            let found = format!("another, which {MANIFEST} does not list: move it, or choose another folder");
            Err(IoError::unexpected(place, "no file but those that touchcal wrote", found))
        }
    }
}

/// Checks that a file that is read is of no unfinished result. Files that no manifest lists are of
/// no result.
///
/// # Errors
/// [`IoError`] if it is, or the manifest cannot be read.
pub(crate) fn check_finished(path: &Path) -> Result<(), IoError> {
    for folder in path.ancestors().skip(1).take(2) {
        let Some(name) = path.strip_prefix(folder).ok().and_then(Path::to_str) else { continue };
        let manifest = Manifest::read(folder)?;
        if manifest.unfinished && manifest.lists(&name.replace('\\', "/")) {
            let found = "one whose writing was interrupted: write it again";
            return Err(IoError::unexpected(
                Place::file(path.display().to_string()),
                "a file of a finished result",
                found,
            ));
        }
    }
    Ok(())
}

/// Writes the files of a result, by their paths in `folder`, in place of a former one.
///
/// # Errors
/// As [`check_own`]; and if another run is writing into the folder, or a file cannot be written.
pub(crate) fn write(folder: &Path, files: &[ResultFile]) -> Result<(), IoError> {
    std::fs::create_dir_all(folder).map_err(|source| IoError::file(folder, "make the folder", source))?;
    let lock = lock(folder)?;
    check_own(folder, files.iter().map(|(name, _)| *name))?;
    let folders: Vec<PathBuf> =
        files.iter().filter_map(|(name, _)| Some(folder.join(name).parent()?.to_owned())).collect();
    folders.iter().for_each(|folder| atomic::remove_left_over(folder));
    let former = Manifest::read(folder)?;
    let mut pending = Vec::with_capacity(files.len());
    for (name, content) in files {
        let path = folder.join(name);
        let write = |file: &mut File| file.write_all(content).map_err(|source| IoError::file(&path, "write", source));
        pending.push(atomic::prepare(&path, write)?);
    }
    let listed = files.iter().map(|(name, content)| ((*name).to_owned(), bytes::sha256(content)));
    let mut manifest = Manifest { schema: 1, unfinished: true, files: listed.collect(), obsolete: Vec::new() };
    let known = former.files.into_keys().chain(former.obsolete);
    manifest.obsolete = known.filter(|name| !manifest.files.contains_key(name)).collect();
    manifest.write(folder)?;
    for file in pending {
        file.replace()?;
    }
    for name in std::mem::take(&mut manifest.obsolete) {
        let path = folder.join(name);
        match std::fs::remove_file(&path) {
            Err(error) if error.kind() != ErrorKind::NotFound => return Err(IoError::file(&path, "remove", error)),
            _ => {}
        }
        // Its folder, if nothing else is there.
        if let Some(above) = path.parent().filter(|above| *above != folder) {
            std::fs::remove_dir(above).ok();
        }
    }
    manifest.unfinished = false;
    manifest.write(folder)?;
    drop(lock);
    Ok(())
}

/// Keeps other runs from writing into the folder, where the file system can.
fn lock(folder: &Path) -> Result<Option<File>, IoError> {
    let Ok(handle) = File::open(folder) else { return Ok(None) };
    match handle.try_lock() {
        Err(TryLockError::WouldBlock) => {
            let place = Place::file(folder.display().to_string());
            Err(IoError::unexpected(place, "a folder that no other run writes into", "another run that does"))
        }
        Ok(()) | Err(TryLockError::Error(_)) => Ok(Some(handle)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn content(folder: &Path, name: &str) -> String {
        std::fs::read_to_string(folder.join(name)).unwrap_or_default()
    }

    #[test]
    fn a_result_replaces_its_own_files_and_no_others() {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path();
        std::fs::write(folder.join("mine"), "kept").unwrap();
        write(folder, &[("a", b"1".to_vec()), ("sub/b", b"1".to_vec())]).unwrap();
        std::fs::write(folder.join(".touchcal-left"), "over").unwrap();
        write(folder, &[("a", b"2".to_vec()), ("c", b"2".to_vec())]).unwrap();
        assert_eq!(["a", "c", "mine"].map(|name| content(folder, name)), ["2", "2", "kept"]);
        assert!(!folder.join("sub").exists() && !folder.join(".touchcal-left").exists());
        let refused = write(folder, &[("mine", b"3".to_vec())]).unwrap_err().to_string();
        assert!(refused.contains("mine: expected no file but those that touchcal wrote"), "{refused}");
        assert_eq!(content(folder, "mine"), "kept");
        let other = lock(folder).unwrap();
        let refused = write(folder, &[("a", b"3".to_vec())]).unwrap_err().to_string();
        assert!(refused.contains("expected a folder that no other run writes into"), "{refused}");
        drop(other);
        assert_eq!(content(folder, "a"), "2");
    }

    /// Stopped before each file of the new result is in its place: with the former files, with a
    /// mixture, and before a former one is removed.
    #[test]
    fn an_unfinished_result_is_refused_and_replaced() {
        for stopped_after in 0..3 {
            let folder = tempfile::tempdir().unwrap();
            let folder = folder.path();
            write(folder, &[("a", b"1".to_vec()), ("b", b"1".to_vec()), ("old", b"1".to_vec())]).unwrap();
            assert!(["a", "b", "old", "none"].iter().all(|name| check_finished(&folder.join(name)).is_ok()));
            let listed = |name: &str| (name.to_owned(), bytes::sha256("2"));
            let files = BTreeMap::from([listed("a"), listed("b")]);
            let obsolete = vec!["old".to_owned()];
            Manifest { schema: 1, unfinished: true, files, obsolete }.write(folder).unwrap();
            for name in ["a", "b"].iter().take(stopped_after) {
                std::fs::write(folder.join(name), "2").unwrap();
            }
            for name in ["a", "b", "old"] {
                let refused = check_finished(&folder.join(name)).unwrap_err().to_string();
                assert!(refused.contains("expected a file of a finished result"), "{refused}");
            }
            write(folder, &[("a", b"3".to_vec())]).unwrap();
            assert!(check_finished(&folder.join("a")).is_ok() && content(folder, "a") == "3");
            assert!(!folder.join("b").exists() && !folder.join("old").exists());
        }
    }
}

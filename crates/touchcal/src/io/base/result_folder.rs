//! A folder whose files are one result: all of one run, or known to be unfinished.
//!
//! The manifest, [`MANIFEST`], lists the files that touchcal wrote; only these are replaced or
//! removed. A new result is written to temporary files first. Then the manifest is replaced by one
//! that lists the new files as unfinished, the files are renamed, those of the former result that
//! the new one lacks are removed, and the manifest is replaced by that of the finished result.
//! Wherever that ends early, the files are those of the former result, those of the new one, or
//! unfinished: readers refuse these, and the next run replaces them.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::{File, TryLockError};
use std::io::{ErrorKind, Write};
use std::path::{Component, Path, PathBuf};

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
    /// The manifest of a folder, if it has one.
    fn read(folder: &Path) -> Result<Option<Manifest>, IoError> {
        let path = folder.join(MANIFEST);
        if !path.is_file() {
            return Ok(None);
        }
        let (text, input) = bytes::read_text(&path, MAX_BYTES)?;
        let failed = |message: String| IoError::syntax(Place::file(&input.path), message);
        let manifest: Manifest = serde_json::from_str(&text).map_err(|error| failed(error.to_string()))?;
        let is_inside = |name: &&str| Path::new(name).components().all(|part| matches!(part, Component::Normal(_)));
        if manifest.schema != 1 || !manifest.names().all(|name| is_inside(&name)) {
            return Err(failed("expected schema 1, and files in this folder".to_owned()));
        }
        Ok(Some(manifest))
    }

    fn write(&self, folder: &Path) -> Result<(), IoError> {
        let path = folder.join(MANIFEST);
        let failed =
            |error: serde_json::Error| IoError::syntax(Place::file(path.display().to_string()), error.to_string());
        atomic::write(&path, &serde_json::to_vec_pretty(self).map_err(failed)?)
    }

    fn names(&self) -> impl Iterator<Item = &str> {
        self.files.keys().chain(&self.obsolete).map(String::as_str)
    }

    /// Whether a file is as it was written. In an unfinished result it may be that of either.
    fn is_own(&self, folder: &Path, name: &str) -> bool {
        let as_written = |sha256: &String| {
            let found = std::fs::File::open(folder.join(name)).and_then(|file| bytes::Hashing::new(file).finish());
            found.is_ok_and(|found| found == *sha256)
        };
        self.names().any(|known| known == name) && (self.unfinished || self.files.get(name).is_none_or(as_written))
    }
}

/// Checks that no file of these `names` in `folder` is anything but what touchcal wrote: the
/// manifest lists it, or it is one of the files `without_manifest` that earlier versions wrote.
///
/// # Errors
/// [`IoError`] if there is another, or the manifest cannot be read.
pub(crate) fn check_own(folder: &Path, names: &[&str], without_manifest: &[&str]) -> Result<(), IoError> {
    let manifest = Manifest::read(folder)?;
    let is_own = |name: &str| match &manifest {
        Some(manifest) => manifest.is_own(folder, name),
        None => without_manifest.contains(&name),
    };
    let exists = |name: &&str| folder.join(name).symlink_metadata().is_ok();
    let listed = manifest.iter().flat_map(Manifest::names);
    match names.iter().copied().chain(listed).filter(exists).find(|name| !is_own(name)) {
        None => Ok(()),
        Some(name) => {
            let place = Place::file(folder.join(name).display().to_string());
            let found = "another, or one that was changed since: move it, or choose another folder";
            Err(IoError::unexpected(place, "no file but those that touchcal wrote", found))
        }
    }
}

/// Checks that a file that is read is of no unfinished result. Files that no manifest lists are of
/// no result.
///
/// # Errors
/// [`IoError`] if it is.
pub(crate) fn check_finished(path: &Path) -> Result<(), IoError> {
    let absolute = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    for folder in absolute.ancestors().skip(1).take(2) {
        let Some(name) = absolute.strip_prefix(folder).ok().and_then(Path::to_str) else { continue };
        // A file of that name that is no manifest is of somebody else.
        let Ok(Some(manifest)) = Manifest::read(folder) else { continue };
        let name = name.replace('\\', "/");
        if manifest.unfinished && manifest.names().any(|known| known == name) {
            let found = "a file of an unfinished one: writing it was interrupted, or another run is writing it";
            let place = Place::file(path.display().to_string());
            return Err(IoError::unexpected(place, "a file of a finished result", found));
        }
    }
    Ok(())
}

/// Writes the files of a result, by their paths in `folder`, in place of a former one, also of one
/// `without_manifest`.
///
/// # Errors
/// As [`check_own`]; and if another run is writing into the folder, or a file cannot be written.
pub(crate) fn write(folder: &Path, files: &[ResultFile], without_manifest: &[&str]) -> Result<(), IoError> {
    std::fs::create_dir_all(folder).map_err(|source| IoError::file(folder, "make the folder", source))?;
    let lock = lock(folder)?;
    let names: Vec<&str> = files.iter().map(|(name, _)| *name).collect();
    check_own(folder, &names, without_manifest)?;
    let former = Manifest::read(folder)?.unwrap_or_default();
    let all = former.names().chain(names);
    let folders: BTreeSet<PathBuf> = all.filter_map(|name| Some(folder.join(name).parent()?.to_owned())).collect();
    folders.iter().for_each(|folder| atomic::remove_left_over(folder));
    let mut pending = Vec::with_capacity(files.len());
    for (name, content) in files {
        let path = folder.join(name);
        let write = |file: &mut File| file.write_all(content).map_err(|source| IoError::file(&path, "write", source));
        pending.push(atomic::prepare(&path, atomic::OF_RESULT, write)?);
    }
    let listed = files.iter().map(|(name, content)| ((*name).to_owned(), bytes::sha256(content)));
    let mut manifest = Manifest { schema: 1, unfinished: true, files: listed.collect(), obsolete: Vec::new() };
    let known = former.names().chain(without_manifest.iter().copied());
    manifest.obsolete = known.filter(|name| !manifest.files.contains_key(*name)).map(str::to_owned).collect();
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

    fn refused(folder: &Path, files: &[ResultFile]) -> String {
        write(folder, files, &[]).unwrap_err().to_string()
    }

    #[test]
    fn a_result_replaces_its_own_files_and_no_others() {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path();
        std::fs::write(folder.join("mine"), "kept").unwrap();
        write(folder, &[("a", b"1".to_vec()), ("sub/b", b"1".to_vec())], &[]).unwrap();
        std::fs::write(folder.join("sub").join(format!("{}left", atomic::OF_RESULT)), "over").unwrap();
        write(folder, &[("a", b"2".to_vec()), ("c", b"2".to_vec())], &[]).unwrap();
        assert_eq!(["a", "c", "mine"].map(|name| content(folder, name)), ["2", "2", "kept"]);
        assert!(!folder.join("sub").exists());
        let expected = "mine: expected no file but those that touchcal wrote";
        assert!(refused(folder, &[("mine", b"3".to_vec())]).contains(expected));
        // Changed since, though the new result would only remove it.
        std::fs::write(folder.join("c"), "changed").unwrap();
        assert!(refused(folder, &[("a", b"3".to_vec())]).contains("c: expected no file but those that touchcal wrote"));
        let other = lock(folder).unwrap();
        let expected = "expected a folder that no other run writes into";
        assert!(refused(folder, &[("a", b"3".to_vec())]).contains(expected));
        drop(other);
        assert_eq!(["a", "c", "mine"].map(|name| content(folder, name)), ["2", "changed", "kept"]);
    }

    #[test]
    fn files_of_earlier_versions_are_replaced_where_that_is_said() {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path();
        for name in ["a", "b"] {
            std::fs::write(folder.join(name), "1").unwrap();
        }
        assert!(refused(folder, &[("a", b"2".to_vec())]).contains("a: expected no file"));
        write(folder, &[("a", b"2".to_vec())], &["a", "b"]).unwrap();
        assert!(content(folder, "a") == "2" && !folder.join("b").exists());
    }

    #[test]
    fn an_unfinished_result_is_refused_and_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path();
        let names = ["a", "sub/b", "old"];
        write(folder, &names.map(|name| (name, b"1".to_vec())), &[]).unwrap();
        assert!(names.iter().all(|name| check_finished(&folder.join(name)).is_ok()));
        // Ended after the first of two files is in its place.
        let files = ["a", "sub/b"].map(|name| (name.to_owned(), bytes::sha256("2")));
        let obsolete = vec!["old".to_owned()];
        Manifest { schema: 1, unfinished: true, files: BTreeMap::from(files), obsolete }.write(folder).unwrap();
        std::fs::write(folder.join("a"), "2").unwrap();
        for name in names {
            let refused = check_finished(&folder.join(name)).unwrap_err().to_string();
            assert!(refused.contains("expected a file of a finished result"), "{refused}");
        }
        write(folder, &[("a", b"3".to_vec())], &[]).unwrap();
        assert!(check_finished(&folder.join("a")).is_ok() && content(folder, "a") == "3");
        assert!(!folder.join("sub").exists() && !folder.join("old").exists());
    }

    #[test]
    fn a_manifest_names_no_files_elsewhere() {
        let folder = tempfile::tempdir().unwrap();
        let (inside, outside) = (folder.path().join("out"), folder.path().join("mine"));
        std::fs::write(&outside, "kept").unwrap();
        write(&inside, &[("a", b"1".to_vec())], &[]).unwrap();
        for name in ["../mine", outside.to_str().unwrap()] {
            let manifest = Manifest { schema: 1, obsolete: vec![name.to_owned()], ..Manifest::default() };
            manifest.write(&inside).unwrap();
            assert!(refused(&inside, &[("a", b"2".to_vec())]).contains("expected schema 1, and files in this folder"));
            assert!(outside.exists());
        }
    }
}

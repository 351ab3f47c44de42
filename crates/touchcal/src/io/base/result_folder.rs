//! A folder whose files are one result: all of one run, or known to be unfinished.
//!
//! The manifest, `touchcal.json`, lists the files that touchcal wrote; only these are replaced or
//! removed. A new result is written to temporary files first. Then the manifest is replaced by one
//! that lists the new files as unfinished, the files are renamed, those of the former result that
//! the new one lacks are removed, and the manifest is replaced by that of the finished result.
//! Wherever that ends early, the files are those of the former result, those of the new one, or
//! unfinished: readers of this crate refuse these, and the next run replaces them.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::{File, TryLockError};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use super::atomic;
use super::bytes;
use super::error::{IoError, Place};
use super::manifest::{ListedResult, MANIFEST, Manifest, is_name};

pub use super::manifest::ResultKind;

/// A file of a result: its path in the folder, of one or two parts with `/` between them, and its
/// content.
pub struct ResultFile {
    name: String,
    content: Vec<u8>,
}

impl ResultFile {
    /// A file of these bytes.
    pub fn new(name: impl Into<String>, content: impl Into<Vec<u8>>) -> Self {
        ResultFile { name: name.into(), content: content.into() }
    }
}

/// Checks that no file of these `names` in `folder`, nor another of the former result of this
/// `kind`, is anything but what touchcal wrote: the manifest lists it as it is, or the manifest
/// lists no result of this kind and it is one of the files `without_manifest` of an earlier
/// version.
///
/// # Errors
/// [`IoError`] if there is another, or the manifest cannot be read.
pub fn check(folder: &Path, kind: ResultKind, names: &[&str], without_manifest: &[&str]) -> Result<(), IoError> {
    own_files(folder, Manifest::read(folder)?.results.get(&kind), names, without_manifest).map(drop)
}

/// The files that the new result replaces or removes, with their SHA-256.
fn own_files(
    folder: &Path,
    former: Option<&ListedResult>,
    names: &[&str],
    without_manifest: &[&str],
) -> Result<BTreeMap<String, String>, IoError> {
    let known: Vec<&str> = former.map_or(without_manifest.to_vec(), |former| former.names().collect());
    let is_listed = |name: &str, sha256: &String| {
        former.is_none_or(|former| [former.files.get(name), former.former.get(name)].contains(&Some(sha256)))
    };
    let mut own = BTreeMap::new();
    for name in known.iter().chain(names) {
        let path = folder.join(name);
        if path.symlink_metadata().is_err() {
            continue;
        }
        let found = sha256(&path).ok().filter(|sha256| known.contains(name) && is_listed(name, sha256));
        let Some(sha256) = found else {
            let found = "another, one that was changed since, or one of a version without touchcal.json: \
                         move it, or choose another folder";
            let place = Place::file(path.display().to_string());
            return Err(IoError::unexpected(place, "no file but those that touchcal wrote", found));
        };
        own.insert((*name).to_owned(), sha256);
    }
    Ok(own)
}

fn sha256(path: &Path) -> std::io::Result<String> {
    bytes::Hashing::new(File::open(path)?).finish()
}

/// Writes the files of a result into `folder`, in place of a former one of the same kind, also of
/// one `without_manifest` (see [`check`]). Missing folders are made.
///
/// # Errors
/// As [`check`]; and if a file has no name of a file in the folder, another run is writing into the
/// folder, or a file cannot be written.
pub fn write(folder: &Path, kind: ResultKind, files: &[ResultFile], without_manifest: &[&str]) -> Result<(), IoError> {
    if let Some(file) = files.iter().find(|file| !is_name(&file.name)) {
        let place = Place::file(folder.display().to_string());
        return Err(IoError::unexpected(place, "names of files in the folder", file.name.clone()));
    }
    std::fs::create_dir_all(folder).map_err(|source| IoError::file(folder, "make the folder", source))?;
    let lock = lock(folder, kind)?;
    let mut manifest = Manifest::read(folder)?;
    let names: Vec<&str> = files.iter().map(|file| file.name.as_str()).collect();
    let former = own_files(folder, manifest.results.get(&kind), &names, without_manifest)?;
    let all = former.keys().map(String::as_str).chain(names);
    let folders: BTreeSet<PathBuf> = all.filter_map(|name| Some(folder.join(name).parent()?.to_owned())).collect();
    folders.iter().for_each(|folder| atomic::remove_left_over(folder));
    let mut pending = Vec::with_capacity(files.len());
    for file in files {
        let path = folder.join(&file.name);
        pending.push(atomic::prepare(&path, |opened| atomic::write_all(opened, &path, &file.content))?);
    }
    let listed = files.iter().map(|file| (file.name.clone(), bytes::sha256(&file.content))).collect();
    let listed = ListedResult { unfinished: true, files: listed, former };
    write_manifest(&mut manifest, folder, kind, listed.clone())?;
    sync(folder)?;
    for file in pending {
        file.replace()?;
    }
    remove_obsolete(folder, &listed)?;
    folders.iter().filter(|folder| folder.is_dir()).try_for_each(|folder| sync(folder))?;
    if let Some((name, _)) =
        listed.files.iter().find(|(name, written)| sha256(&folder.join(name)).ok().as_ref() != Some(written))
    {
        let place = Place::file(folder.join(name).display().to_string());
        return Err(IoError::unexpected(
            place,
            "the file as it was written",
            "another: another run wrote into the folder",
        ));
    }
    write_manifest(&mut manifest, folder, kind, ListedResult { unfinished: false, former: BTreeMap::new(), ..listed })?;
    sync(folder)?;
    drop(lock);
    Ok(())
}

/// Removes the files of the former result that the new one lacks.
fn remove_obsolete(folder: &Path, listed: &ListedResult) -> Result<(), IoError> {
    for name in listed.former.keys().filter(|name| !listed.files.contains_key(*name)) {
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
    Ok(())
}

/// Writes the manifest with this list of a result, in place of the former list.
fn write_manifest(
    manifest: &mut Manifest,
    folder: &Path,
    kind: ResultKind,
    listed: ListedResult,
) -> Result<(), IoError> {
    manifest.results.insert(kind, listed);
    let path = folder.join(MANIFEST);
    let failed = |error: serde_json::Error| IoError::syntax(Place::file(path.display().to_string()), error.to_string());
    atomic::write(&path, &serde_json::to_vec_pretty(manifest).map_err(failed)?)
}

/// Keeps other runs from writing into the folder, where the file system has locks. Runs that sum up
/// trials wait for each other.
fn lock(folder: &Path, kind: ResultKind) -> Result<Option<File>, IoError> {
    let Ok(handle) = File::open(folder) else { return Ok(None) };
    if is_of_trials(kind) {
        handle.lock().ok();
        return Ok(Some(handle));
    }
    match handle.try_lock() {
        Err(TryLockError::WouldBlock) => {
            let place = Place::file(folder.display().to_string());
            Err(IoError::unexpected(place, "a folder that no other run writes into", "another run that does"))
        }
        Ok(()) | Err(TryLockError::Error(_)) => Ok(Some(handle)),
    }
}

/// Whether a result sums up trials, which runs on several machines may have computed in parts.
fn is_of_trials(kind: ResultKind) -> bool {
    matches!(kind, ResultKind::Campaign | ResultKind::Sweep | ResultKind::Falsified | ResultKind::Table1)
}

/// Flushes the names of a folder's files to the disk, so that later changes are not there before
/// earlier ones when the power fails; without effect where the file system does not have this.
fn sync(folder: &Path) -> Result<(), IoError> {
    let Ok(handle) = File::open(folder) else { return Ok(()) };
    match handle.sync_all() {
        Err(error) if !matches!(error.kind(), ErrorKind::InvalidInput | ErrorKind::Unsupported) => {
            Err(IoError::file(folder, "write", error))
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::super::manifest::check_finished;
    use super::*;

    const KIND: ResultKind = ResultKind::Calibration;

    fn content(folder: &Path, name: &str) -> String {
        std::fs::read_to_string(folder.join(name)).unwrap_or_default()
    }

    fn written(folder: &Path, files: &[(&str, &str)]) -> Result<(), IoError> {
        write(folder, KIND, &files.iter().map(|&(name, text)| ResultFile::new(name, text)).collect::<Vec<_>>(), &[])
    }

    fn refused(folder: &Path, files: &[(&str, &str)]) -> String {
        written(folder, files).unwrap_err().to_string()
    }

    #[test]
    fn a_result_replaces_its_own_files_and_no_others() {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path();
        std::fs::write(folder.join("mine"), "kept").unwrap();
        written(folder, &[("a", "1"), ("sub/b", "1")]).unwrap();
        std::fs::write(folder.join("sub/.touchcal-left12"), "over").unwrap();
        written(folder, &[("a", "2"), ("c", "2")]).unwrap();
        assert_eq!(["a", "c", "mine"].map(|name| content(folder, name)), ["2", "2", "kept"]);
        assert!(!folder.join("sub").exists());
        let expected = "mine: expected no file but those that touchcal wrote";
        assert!(refused(folder, &[("mine", "3")]).contains(expected));
        // Changed since, though the new result would only remove it.
        std::fs::write(folder.join("c"), "changed").unwrap();
        assert!(refused(folder, &[("a", "3")]).contains("c: expected no file but those that touchcal wrote"));
        let other = lock(folder, KIND).unwrap();
        let expected = "expected a folder that no other run writes into";
        assert!(refused(folder, &[("a", "3")]).contains(expected));
        drop(other);
        assert_eq!(["a", "c", "mine"].map(|name| content(folder, name)), ["2", "changed", "kept"]);
    }

    #[test]
    fn results_of_two_kinds_share_a_folder() {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path();
        let simulate = |files: &[ResultFile]| write(folder, ResultKind::Simulation, files, &[]);
        simulate(&[ResultFile::new("log", "1"), ResultFile::new("problem", "1")]).unwrap();
        written(folder, &[("a", "1")]).unwrap();
        // Each replaces and removes only its own files.
        simulate(&[ResultFile::new("log", "2")]).unwrap();
        assert_eq!(["log", "problem", "a"].map(|name| content(folder, name)), ["2", "", "1"]);
        assert!(refused(folder, &[("log", "3")]).contains("log: expected no file but those that touchcal wrote"));
    }

    #[test]
    fn what_cannot_be_written_leaves_the_former_result() {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path();
        written(folder, &[("a", "1"), ("b", "1")]).unwrap();
        // A folder in the place of a file's folder.
        std::fs::write(folder.join("sub"), "mine").unwrap();
        assert!(refused(folder, &[("a", "2"), ("sub/b", "2")]).contains("sub"));
        assert!(content(folder, "a") == "1" && check_finished(&folder.join("a")).is_ok());
        assert_eq!(std::fs::read_dir(folder).unwrap().count(), 4);
    }

    #[test]
    fn files_of_earlier_versions_are_replaced_where_that_is_said() {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path();
        for name in ["a", "b"] {
            std::fs::write(folder.join(name), "1").unwrap();
        }
        assert!(refused(folder, &[("a", "2")]).contains("a: expected no file"));
        write(folder, KIND, &[ResultFile::new("a", "2")], &["a", "b"]).unwrap();
        assert!(content(folder, "a") == "2" && !folder.join("b").exists());
    }

    #[test]
    fn an_unfinished_result_is_refused_and_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path();
        let names = ["a", "sub/b", "old"];
        written(folder, &names.map(|name| (name, "1"))).unwrap();
        assert!(names.iter().all(|name| check_finished(&folder.join(name)).is_ok()));
        // Ended after the first of two files is in its place.
        let files = BTreeMap::from(["a", "sub/b"].map(|name| (name.to_owned(), bytes::sha256("2"))));
        let former = BTreeMap::from(names.map(|name| (name.to_owned(), bytes::sha256("1"))));
        let listed = ListedResult { unfinished: true, files, former };
        write_manifest(&mut Manifest::default(), folder, KIND, listed).unwrap();
        std::fs::write(folder.join("a"), "2").unwrap();
        for name in names {
            let refused = bytes::open(&folder.join(name)).unwrap_err().to_string();
            assert!(refused.contains("expected a file of a finished result"), "{refused}");
        }
        // A file of either is replaced, another is not.
        std::fs::write(folder.join("old"), "mine").unwrap();
        assert!(refused(folder, &[("a", "3")]).contains("old: expected no file but those that touchcal wrote"));
        std::fs::write(folder.join("old"), "1").unwrap();
        written(folder, &[("a", "3")]).unwrap();
        assert!(bytes::open(&folder.join("a")).is_ok() && content(folder, "a") == "3");
        assert!(!folder.join("sub").exists() && !folder.join("old").exists());
    }

    #[test]
    fn a_manifest_names_no_files_elsewhere() {
        let folder = tempfile::tempdir().unwrap();
        let (inside, outside) = (folder.path().join("out"), folder.path().join("mine"));
        std::fs::write(&outside, "kept").unwrap();
        written(&inside, &[("a", "1")]).unwrap();
        for name in ["../mine", outside.to_str().unwrap(), MANIFEST, "", "a/b/c"] {
            assert!(refused(&inside, &[(name, "2")]).contains("names of files in the folder"), "{name}");
            let files = BTreeMap::from([(name.to_owned(), bytes::sha256("kept"))]);
            let listed = ListedResult { files, ..ListedResult::default() };
            write_manifest(&mut Manifest::default(), &inside, KIND, listed).unwrap();
            assert!(refused(&inside, &[("a", "2")]).contains("expected schema 1, and files in this folder"));
            assert!(outside.exists());
        }
    }
}

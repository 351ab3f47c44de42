//! A folder whose files are one result: all of one run, or known to be unfinished.
//!
//! The manifest, `touchcal.json`, lists the files that touchcal wrote; only these are replaced or
//! removed. A new result is written to temporary files first. Then the manifest is replaced by one
//! that lists the new files as unfinished, the files are renamed, those of the former result that
//! the new one lacks are removed, and the manifest is replaced by that of the finished result.
//! Wherever that ends early, the files are those of the former result, those of the new one, or
//! unfinished: all readers of this crate refuse these, and the next run replaces them.

use std::collections::BTreeSet;
use std::fs::{File, TryLockError};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use super::atomic;
use super::bytes;
use super::error::{IoError, Place};
use super::manifest::{ListedResult, MANIFEST, Manifest};

pub use super::manifest::ResultKind;

/// A file of a result: its path in the folder, with `/` between its parts, and its content.
pub struct ResultFile<'a> {
    name: String,
    content: Content<'a>,
}

enum Content<'a> {
    Bytes(Vec<u8>),
    By(Box<Writer<'a>>),
}

type Writer<'a> = dyn FnOnce(&mut File) -> Result<(), IoError> + 'a;

impl<'a> ResultFile<'a> {
    /// A file of these bytes.
    pub fn new(name: impl Into<String>, bytes: impl Into<Vec<u8>>) -> Self {
        ResultFile { name: name.into(), content: Content::Bytes(bytes.into()) }
    }

    /// A file that `content` writes piece by piece, into an empty file.
    pub fn by(name: impl Into<String>, content: impl FnOnce(&mut File) -> Result<(), IoError> + 'a) -> Self {
        ResultFile { name: name.into(), content: Content::By(Box::new(content)) }
    }

    /// The file beside its place, where [`Prepared::replace`](atomic::Prepared::replace) puts it.
    fn prepare(self, folder: &Path) -> Result<atomic::Prepared, IoError> {
        let path = folder.join(self.name);
        match self.content {
            Content::Bytes(bytes) => atomic::prepare(&path, |file| atomic::write_all(file, &path, &bytes)),
            Content::By(content) => atomic::prepare(&path, content),
        }
    }
}

/// Checks that no file of these `names` in `folder`, nor another of the former result of this
/// `kind`, is anything but what touchcal wrote: the manifest lists it, or the manifest lists no
/// result of this kind and it is one of the files `without_manifest` that earlier versions wrote.
///
/// # Errors
/// [`IoError`] if there is another, or the manifest cannot be read.
pub fn check(folder: &Path, kind: ResultKind, names: &[&str], without_manifest: &[&str]) -> Result<(), IoError> {
    let manifest = Manifest::read(folder)?;
    let former = manifest.results.get(&kind);
    let is_own =
        |name: &str| former.map_or(without_manifest.contains(&name), |former| is_as_written(former, folder, name));
    let exists = |name: &&str| folder.join(name).symlink_metadata().is_ok();
    let listed = former.into_iter().flat_map(ListedResult::names);
    match names.iter().copied().chain(listed).filter(exists).find(|name| !is_own(name)) {
        None => Ok(()),
        Some(name) => {
            let place = Place::file(folder.join(name).display().to_string());
            let found = "another, or one that was changed since: move it, or choose another folder";
            Err(IoError::unexpected(place, "no file but those that touchcal wrote", found))
        }
    }
}

/// Whether a file is as it was written. In an unfinished result it may be that of either.
fn is_as_written(former: &ListedResult, folder: &Path, name: &str) -> bool {
    let has_sha256 = |expected: &String| sha256(&folder.join(name)).is_ok_and(|found| found == *expected);
    former.names().any(|known| known == name) && (former.unfinished || former.files.get(name).is_none_or(has_sha256))
}

fn sha256(path: &Path) -> std::io::Result<String> {
    bytes::Hashing::new(File::open(path)?).finish()
}

/// Writes the files of a result into `folder`, in place of a former one of the same kind, also of
/// one `without_manifest`. Missing folders are made.
///
/// # Errors
/// As [`check`]; and if another run is writing into the folder, or a file cannot be written.
pub fn write(
    folder: &Path,
    kind: ResultKind,
    files: Vec<ResultFile<'_>>,
    without_manifest: &[&str],
) -> Result<(), IoError> {
    std::fs::create_dir_all(folder).map_err(|source| IoError::file(folder, "make the folder", source))?;
    let handle = lock(folder)?;
    let settle = || settle(folder, handle.as_ref());
    let names: Vec<String> = files.iter().map(|file| file.name.clone()).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    check(folder, kind, &names, without_manifest)?;
    let mut manifest = Manifest::read(folder)?;
    let former = manifest.results.get(&kind).cloned().unwrap_or_default();
    let all = former.names().chain(names.iter().copied());
    let folders: BTreeSet<PathBuf> = all.filter_map(|name| Some(folder.join(name).parent()?.to_owned())).collect();
    folders.iter().for_each(|folder| atomic::remove_left_over(folder));
    let mut listed = ListedResult { unfinished: true, ..ListedResult::default() };
    let mut pending = Vec::with_capacity(files.len());
    for (name, file) in names.iter().zip(files) {
        let file = file.prepare(folder)?;
        listed.files.insert((*name).to_owned(), file.sha256()?);
        pending.push(file);
    }
    let known = former.names().chain(without_manifest.iter().copied());
    listed.obsolete = known.filter(|name| !listed.files.contains_key(*name)).map(str::to_owned).collect();
    list(&mut manifest, folder, kind, listed.clone())?;
    settle()?;
    for file in pending {
        file.replace()?;
    }
    for name in std::mem::take(&mut listed.obsolete) {
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
    settle()?;
    listed.unfinished = false;
    list(&mut manifest, folder, kind, listed)?;
    settle()
}

/// Writes the manifest with this list of a result, in place of its former list.
fn list(manifest: &mut Manifest, folder: &Path, kind: ResultKind, listed: ListedResult) -> Result<(), IoError> {
    manifest.schema = 1;
    manifest.results.insert(kind, listed);
    let path = folder.join(MANIFEST);
    let failed = |error: serde_json::Error| IoError::syntax(Place::file(path.display().to_string()), error.to_string());
    atomic::write(&path, &serde_json::to_vec_pretty(manifest).map_err(failed)?)
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

/// Ends when all changes of names so far are on the disk, so that those to come are not there
/// before them when the power fails; at once where the file system does not have this.
fn settle(folder: &Path, handle: Option<&File>) -> Result<(), IoError> {
    match handle.map_or(Ok(()), File::sync_all) {
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
        let files = files.iter().map(|&(name, text)| ResultFile::new(name, text));
        write(folder, KIND, files.collect(), &[])
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
        std::fs::write(folder.join("sub/.touchcal-left"), "over").unwrap();
        written(folder, &[("a", "2"), ("c", "2")]).unwrap();
        assert_eq!(["a", "c", "mine"].map(|name| content(folder, name)), ["2", "2", "kept"]);
        assert!(!folder.join("sub").exists());
        let expected = "mine: expected no file but those that touchcal wrote";
        assert!(refused(folder, &[("mine", "3")]).contains(expected));
        // Changed since, though the new result would only remove it.
        std::fs::write(folder.join("c"), "changed").unwrap();
        assert!(refused(folder, &[("a", "3")]).contains("c: expected no file but those that touchcal wrote"));
        let other = lock(folder).unwrap();
        let expected = "expected a folder that no other run writes into";
        assert!(refused(folder, &[("a", "3")]).contains(expected));
        drop(other);
        assert_eq!(["a", "c", "mine"].map(|name| content(folder, name)), ["2", "changed", "kept"]);
    }

    #[test]
    fn results_of_two_kinds_share_a_folder() {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path();
        let simulate = |files: Vec<ResultFile<'_>>| write(folder, ResultKind::Simulation, files, &[]);
        simulate(vec![ResultFile::new("log", "1"), ResultFile::new("problem", "1")]).unwrap();
        written(folder, &[("a", "1")]).unwrap();
        // Each replaces and removes only its own files.
        let by_parts = ResultFile::by("log", |file| atomic::write_all(file, Path::new("log"), b"2"));
        simulate(vec![by_parts]).unwrap();
        assert_eq!(["log", "problem", "a"].map(|name| content(folder, name)), ["2", "", "1"]);
        assert!(refused(folder, &[("log", "3")]).contains("log: expected no file but those that touchcal wrote"));
    }

    #[test]
    fn what_cannot_be_written_leaves_the_former_result() {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path();
        written(folder, &[("a", "1")]).unwrap();
        let fails = |_: &mut File| Err(IoError::syntax(Place::file("b"), "no".to_owned()));
        let files = vec![ResultFile::new("a", "2"), ResultFile::by("b", fails)];
        assert!(write(folder, KIND, files, &[]).is_err());
        assert!(content(folder, "a") == "1" && check_finished(&folder.join("a")).is_ok());
        assert_eq!(std::fs::read_dir(folder).unwrap().count(), 2);
    }

    #[test]
    fn files_of_earlier_versions_are_replaced_where_that_is_said() {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path();
        for name in ["a", "b"] {
            std::fs::write(folder.join(name), "1").unwrap();
        }
        assert!(refused(folder, &[("a", "2")]).contains("a: expected no file"));
        write(folder, KIND, vec![ResultFile::new("a", "2")], &["a", "b"]).unwrap();
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
        let listed = ListedResult { unfinished: true, files, obsolete: vec!["old".to_owned()] };
        list(&mut Manifest::default(), folder, KIND, listed).unwrap();
        std::fs::write(folder.join("a"), "2").unwrap();
        for name in names {
            let refused = bytes::open(&folder.join(name)).unwrap_err().to_string();
            assert!(refused.contains("expected a file of a finished result"), "{refused}");
        }
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
        for name in ["../mine", outside.to_str().unwrap()] {
            let listed = ListedResult { obsolete: vec![name.to_owned()], ..ListedResult::default() };
            list(&mut Manifest::default(), &inside, KIND, listed).unwrap();
            assert!(refused(&inside, &[("a", "2")]).contains("expected schema 1, and files in this folder"));
            assert!(outside.exists());
        }
    }
}

//! Paths without the folder that all have in common.

use std::path::{Path, PathBuf};

/// The deepest folder that contains all absolute ones of some paths. A page that is sent to others
/// does not tell where it is.
pub(super) struct CommonFolder(Option<PathBuf>);

impl CommonFolder {
    /// The folder of `paths`; relative ones do not count.
    pub fn of<'a>(paths: impl Iterator<Item = &'a str>) -> Self {
        let absolute: Vec<&Path> = paths.map(Path::new).filter(|path| path.is_absolute()).collect();
        let folders = absolute.first().map_or(Vec::new(), |path| path.ancestors().skip(1).collect());
        let common = folders.into_iter().find(|folder| absolute.iter().all(|path| path.starts_with(folder)));
        CommonFolder(common.map(Path::to_path_buf))
    }

    /// `path` without the folder; one that is not in it stays as it is.
    pub fn shown(&self, path: &str) -> String {
        let rest = self.0.as_ref().and_then(|folder| Path::new(path).strip_prefix(folder).ok());
        rest.map_or_else(|| path.to_owned(), |rest| rest.display().to_string())
    }

    /// A note, which may begin with the path of a file and a colon, with that path as it is shown.
    pub fn shown_in(&self, note: &str) -> String {
        note.split_once(": ").map_or_else(|| note.to_owned(), |(file, rest)| format!("{}: {rest}", self.shown(file)))
    }
}

#[cfg(test)]
mod tests {
    use super::CommonFolder;

    fn shown(paths: &[&str]) -> Vec<String> {
        let folder = CommonFolder::of(paths.iter().copied());
        paths.iter().map(|path| folder.shown(path)).collect()
    }

    #[test]
    fn absolute_paths_lose_their_common_folder() {
        let paths = ["/home/me/cell/arm.urdf", "/home/me/cell/logs/a.csv", "other/b.csv"];
        assert_eq!(shown(&paths), ["arm.urdf", "logs/a.csv", "other/b.csv"]);
        assert_eq!(shown(&["/a/one.csv"]), ["one.csv"]);
        assert_eq!(shown(&["/a/one.csv", "/ab/two.csv"]), ["a/one.csv", "ab/two.csv"]);
        assert_eq!(shown(&["problem.toml", "../b.csv"]), ["problem.toml", "../b.csv"]);
        assert!(shown(&[]).is_empty());
    }

    #[test]
    fn notes_name_files_as_they_are_shown() {
        let folder = CommonFolder::of(["/home/me/arm.urdf", "/home/me/logs/a.csv"].into_iter());
        assert_eq!(folder.shown_in("/home/me/logs/a.csv: assumed: degrees"), "logs/a.csv: assumed: degrees");
        assert_eq!(folder.shown_in("assumed: degrees"), "assumed: degrees");
        assert_eq!(folder.shown_in("b.csv: 3 rows"), "b.csv: 3 rows");
        assert_eq!(folder.shown_in("no colon"), "no colon");
    }
}

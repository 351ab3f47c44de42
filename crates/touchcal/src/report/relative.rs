//! Paths without the folder that all have in common.

use std::path::Path;

/// `paths`, those that are absolute without the deepest folder that contains all of these: a page
/// that is sent to others does not tell where the files lie. Other paths stay as they are.
pub(super) fn relative(paths: &[&str]) -> Vec<String> {
    let absolute: Vec<&Path> = paths.iter().map(Path::new).filter(|path| path.is_absolute()).collect();
    let folders = absolute.first().map_or(Vec::new(), |path| path.ancestors().skip(1).collect());
    let common = folders.into_iter().find(|folder| absolute.iter().all(|path| path.starts_with(folder)));
    let shorter = |path: &&str| {
        let rest = common.and_then(|folder| Path::new(path).strip_prefix(folder).ok());
        rest.map_or_else(|| (*path).to_owned(), |rest| rest.display().to_string())
    };
    paths.iter().map(shorter).collect()
}

#[cfg(test)]
mod tests {
    use super::relative;

    #[test]
    fn absolute_paths_lose_their_common_folder() {
        let paths = ["/home/me/cell/arm.urdf", "/home/me/cell/logs/a.csv", "other/b.csv"];
        assert_eq!(relative(&paths), ["arm.urdf", "logs/a.csv", "other/b.csv"]);
        assert_eq!(relative(&["/a/one.csv"]), ["one.csv"]);
        assert_eq!(relative(&["/a/one.csv", "/ab/two.csv"]), ["a/one.csv", "ab/two.csv"]);
        assert_eq!(relative(&["problem.toml", "../b.csv"]), ["problem.toml", "../b.csv"]);
        assert!(relative(&[]).is_empty());
    }
}

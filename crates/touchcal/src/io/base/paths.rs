//! Paths of files as other files name them.

use std::path::{Component, Path, PathBuf};

use super::error::IoError;

/// The path of `file`, which exists, relative to `folder`, which need not; absolute where they have
/// nothing in common.
///
/// # Errors
/// If one of them cannot be resolved.
pub(crate) fn relative(folder: &Path, file: &Path) -> Result<String, IoError> {
    let absolute = |path: &Path| path.canonicalize().map_err(|source| IoError::file(path, "find", source));
    let (folder, file) = (existing(folder).map_err(|source| IoError::file(folder, "find", source))?, absolute(file)?);
    let (from, to): (Vec<_>, Vec<_>) = (folder.components().collect(), file.components().collect());
    let common = from.iter().zip(&to).take_while(|(a, b)| a == b).count();
    if common == 0 {
        return Ok(file.display().to_string());
    }
    let up = std::iter::repeat_n(Component::ParentDir, from.len() - common);
    let path: PathBuf = up.chain(to[common..].iter().copied()).collect();
    Ok(path.display().to_string())
}

/// The absolute path of a folder, of which the end may not exist yet.
fn existing(folder: &Path) -> std::io::Result<PathBuf> {
    let folder = std::path::absolute(folder)?;
    match (folder.canonicalize(), folder.parent(), folder.file_name()) {
        (Ok(found), _, _) => Ok(found),
        (Err(_), Some(parent), Some(name)) => Ok(existing(parent)?.join(name)),
        (Err(error), _, _) => Err(error),
    }
}

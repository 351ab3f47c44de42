//! The manifest of a folder: which files touchcal wrote into it, and whether they are a finished
//! result.

use std::collections::BTreeMap;
use std::path::{Component, Path};

use serde::{Deserialize, Serialize};

use super::error::{IoError, Place};

/// Name of the manifest.
pub(crate) const MANIFEST: &str = "touchcal.json";
/// Version of the manifest's format.
const SCHEMA: u32 = 1;
/// Largest manifest read (bytes).
const MAX_BYTES: u64 = 16 << 20;
/// Most parts of a file's path in its folder.
const MAX_DEPTH: usize = 2;

/// What the files of a result are of. A folder may hold one result of each kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ResultKind {
    /// URDF, estimate and report.
    Calibration,
    /// Logs, problem, scenario and truth.
    Simulation,
    /// Statistics of simulated trials.
    Campaign,
    /// Statistics of campaigns that differ in one setting.
    Sweep,
    /// Trials with false declarations.
    Falsified,
    /// The paper's table.
    Table1,
    /// A trained network.
    Network,
}

/// The results in a folder.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Manifest {
    schema: u32,
    pub(crate) results: BTreeMap<ResultKind, ListedResult>,
}

/// The files of one result with their SHA-256, by their paths in the folder, with `/` between their
/// parts.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ListedResult {
    /// Whether files may be missing, or be those of the former result.
    pub(crate) unfinished: bool,
    pub(crate) files: BTreeMap<String, String>,
    /// Of an unfinished result: files that are replaced or removed.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub(crate) former: BTreeMap<String, String>,
}

impl ListedResult {
    pub(crate) fn names(&self) -> impl Iterator<Item = &str> {
        self.files.keys().chain(self.former.keys()).map(String::as_str)
    }
}

impl Default for Manifest {
    fn default() -> Self {
        Manifest { schema: SCHEMA, results: BTreeMap::new() }
    }
}

impl Manifest {
    /// The manifest of a folder; an empty one if the folder has none.
    pub(crate) fn read(folder: &Path) -> Result<Manifest, IoError> {
        let path = folder.join(MANIFEST);
        let Ok(found) = path.metadata() else { return Ok(Manifest::default()) };
        let failed = |message: String| IoError::syntax(Place::file(path.display().to_string()), message);
        if !found.is_file() || found.len() > MAX_BYTES {
            return Err(failed(format!("expected a file of at most {MAX_BYTES} bytes")));
        }
        let text = std::fs::read(&path).map_err(|source| IoError::file(&path, "read", source))?;
        let manifest: Manifest = serde_json::from_slice(&text).map_err(|error| failed(error.to_string()))?;
        let names = manifest.results.values().flat_map(ListedResult::names);
        if manifest.schema != SCHEMA || !names.into_iter().all(is_name) {
            return Err(failed(format!("expected schema {SCHEMA}, and files in this folder")));
        }
        Ok(manifest)
    }
}

/// Whether a result may have a file of this name: in its folder or a folder in that, and not its
/// manifest.
pub(crate) fn is_name(name: &str) -> bool {
    let mut parts = Path::new(name).components();
    let count = parts.clone().count();
    name != MANIFEST && (1..=MAX_DEPTH).contains(&count) && parts.all(|part| matches!(part, Component::Normal(_)))
}

/// Checks that a file that is read is of no unfinished result. Files that no manifest lists are of
/// no result.
///
/// # Errors
/// [`IoError`] if it is.
pub(crate) fn check_finished(path: &Path) -> Result<(), IoError> {
    let found = path.canonicalize().unwrap_or_else(|_| path.to_owned());
    for folder in found.ancestors().skip(1).take(MAX_DEPTH) {
        let Some(name) = found.strip_prefix(folder).ok().and_then(Path::to_str) else { continue };
        // A file of that name that is no manifest is of somebody else.
        let Ok(manifest) = Manifest::read(folder) else { continue };
        let name = name.replace('\\', "/");
        let lists = |result: &ListedResult| result.unfinished && result.names().any(|known| known == name);
        if manifest.results.values().any(lists) {
            let found = "a file of an unfinished one: writing it was interrupted, or another run is writing it";
            let place = Place::file(path.display().to_string());
            return Err(IoError::unexpected(place, "a file of a finished result", found));
        }
    }
    Ok(())
}

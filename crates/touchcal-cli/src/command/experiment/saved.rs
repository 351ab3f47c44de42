//! Results of single trials, a JSON file each, so that an interrupted experiment goes on where it
//! was.

use std::path::Path;

use serde::Serialize;
use serde::de::DeserializeOwned;
use touchcal::io::atomic;

use crate::failure::Failure;

/// Name of the folder of these files, within that of the experiment.
pub const ROWS: &str = "rows";

/// Largest file of a trial (bytes).
const MAX_BYTES: u64 = 1 << 16;

/// What is saved at `path`; none if that is missing, too large, or of another form.
pub fn load<T: DeserializeOwned>(path: &Path) -> Option<T> {
    let size = std::fs::metadata(path).ok()?.len();
    let text = (size <= MAX_BYTES).then(|| std::fs::read_to_string(path).ok()).flatten()?;
    serde_json::from_str(&text).ok()
}

/// Saves a result.
pub fn save<T: Serialize>(path: &Path, result: &T) -> Result<(), Failure> {
    atomic::write(path, (serde_json::to_string_pretty(result)? + "\n").as_bytes())?;
    Ok(())
}

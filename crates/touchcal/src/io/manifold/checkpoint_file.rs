//! `checkpoint.safetensors`: state of a training, schema 1.
//!
//! As a [weights file](crate::io::manifold::weights_file), with tensors `layers`, `first`, `second`
//! (means of the gradients and of their squares) and `best`, and one entry of metadata,
//! `touchcal_checkpoint`.

use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::io::base::bytes;
use crate::io::base::error::{IoError, Place};
use crate::io::manifold::network_entry::{NetworkEntry, Teacher};
use crate::io::manifold::{network_tensors, tensor_file};
use crate::manifold::learned::{AdamState, BestWeights, Checkpoint, Network};

/// The schema that this version writes and reads; others are refused.
pub const SCHEMA: u32 = 1;
/// Largest file read (bytes), 4 GiB.
pub const MAX_BYTES: u64 = 4 << 30;

const KEY: &str = "touchcal_checkpoint";
const LAYERS: &str = "layers";
const FIRST: &str = "first";
const SECOND: &str = "second";
const BEST: &str = "best";

/// State of a training, and what the projection is learned from.
#[derive(Clone, Debug, PartialEq)]
pub struct CheckpointFile {
    /// State of the training.
    pub checkpoint: Checkpoint,
    /// Manifold and pairs that the projection is learned from.
    pub teacher: Teacher,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Content {
    network: NetworkEntry,
    step: u64,
    best: Option<BestEntry>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct BestEntry {
    loss: f64,
    step: u64,
}

/// The bytes of a checkpoint file. Numbers must be finite, which is not checked; others make a file
/// that cannot be read back.
///
/// # Errors
/// [`IoError::Syntax`] if serialization fails.
pub fn to_bytes(checkpoint: &Checkpoint, teacher: &Teacher) -> Result<Vec<u8>, IoError> {
    let Checkpoint { options, scaling, network, adam, best } = checkpoint;
    let content = Content {
        network: NetworkEntry::new(scaling, options, teacher),
        step: adam.steps,
        best: best.as_ref().map(|best| BestEntry { loss: best.loss, step: best.step }),
    };
    let mut networks = vec![(LAYERS, network.layers()), (FIRST, &adam.first[..]), (SECOND, &adam.second[..])];
    networks.extend(best.as_ref().map(|best| (BEST, best.network.layers())));
    network_tensors::write(KEY, SCHEMA, content, &networks)
}

/// Reads the bytes of a checkpoint file; `file` is its name for messages.
///
/// # Errors
/// [`IoError`] if the bytes are more than [`MAX_BYTES`] or no complete file of this schema, do not
/// match their SHA-256, have an architecture, coordinates or scaling of another kind, lack a tensor
/// or have one of another shape than the metadata state, have a number that is not finite, or have
/// best weights of a later step than the last.
pub fn from_bytes(bytes: &[u8], file: &str) -> Result<CheckpointFile, IoError> {
    bytes::check_size(bytes.len() as u64, MAX_BYTES, file)?;
    let (tensors, Content { network: entry, step, best }) = network_tensors::read::<Content>(bytes, file, KEY, SCHEMA)?;
    entry.check(file)?;
    let widths = entry.widths();
    let misfit = |error| IoError::syntax(Place::file(file).field("tensors"), format!("{error}"));
    let network = |prefix| Network::new(tensors.layers(prefix, widths)?).map_err(misfit);
    let adam =
        AdamState { first: tensors.layers(FIRST, widths)?, second: tensors.layers(SECOND, widths)?, steps: step };
    let best = match best {
        Some(BestEntry { loss, step }) => Some(BestWeights { network: network(BEST)?, loss, step }),
        None => None,
    };
    if let Some(later) = best.as_ref().filter(|best| best.step > step) {
        let place = Place::file(file).field("metadata, best");
        return Err(IoError::unexpected(place, format!("a step up to {step}"), format!("{}", later.step)));
    }
    let checkpoint =
        Checkpoint { options: entry.options(), scaling: entry.scaling(), network: network(LAYERS)?, adam, best };
    Ok(CheckpointFile { checkpoint, teacher: entry.teacher().clone() })
}

/// Reads a checkpoint file.
///
/// # Errors
/// As [`from_bytes`], and if the file cannot be read.
pub fn read_file(path: &Path) -> Result<CheckpointFile, IoError> {
    let (bytes, input) = tensor_file::read_all(path, MAX_BYTES, KEY)?;
    from_bytes(&bytes, &input.path)
}

//! `weights.safetensors`: a learned projection, schema 1.
//!
//! Tensors `layers.K.weight` (F32, a row for each output) and `layers.K.bias`, K from 0, as
//! PyTorch's `Linear` has them. One entry of metadata, `touchcal_network`: JSON with architecture,
//! scaling, metric and units, how and from which manifold it learned, and the weights' fingerprint.

use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::io::base::bytes::{self, Input};
use crate::io::base::error::{IoError, Place};
use crate::io::manifold::network_entry::NetworkEntry;
pub use crate::io::manifold::network_entry::Teacher;
use crate::io::manifold::{network_tensors, tensor_file};
use crate::manifold::learned::{LearnedProjection, Network, TrainingOptions};

/// The schema that this version writes and reads; others are refused.
pub const SCHEMA: u32 = 1;
/// Largest file read (bytes), 1 GiB.
pub const MAX_BYTES: u64 = 1 << 30;

const KEY: &str = "touchcal_network";
const LAYERS: &str = "layers";

/// A learned projection, and how and from what it was learned.
#[derive(Clone, Debug, PartialEq)]
pub struct WeightsFile {
    /// The projection, with its weights and scaling.
    pub projection: LearnedProjection,
    /// Options of the training.
    pub options: TrainingOptions,
    /// Manifold and pairs that the projection was learned from.
    pub teacher: Teacher,
    /// Number of steps after which these weights were found.
    pub step: u64,
    /// Mean square of the network's output errors over the held-out pairs (no unit); `None` before
    /// the first evaluation.
    pub loss: Option<f64>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Content {
    network: NetworkEntry,
    step: u64,
    loss: Option<f64>,
}

impl WeightsFile {
    /// The bytes of a weights file. Numbers must be finite, which is not checked; others make a
    /// file that cannot be read back. The bounds of the projection are those of the teacher when
    /// read back.
    ///
    /// # Errors
    /// [`IoError::Syntax`] if serialization fails.
    pub fn to_bytes(&self) -> Result<Vec<u8>, IoError> {
        let network = NetworkEntry::new(self.projection.scaling(), &self.options, &self.teacher);
        let content = Content { network, step: self.step, loss: self.loss };
        network_tensors::write(KEY, SCHEMA, content, &[(LAYERS, self.projection.network().layers())])
    }

    /// Reads the bytes of a weights file; `file` is its name for messages.
    ///
    /// # Errors
    /// [`IoError`] if the bytes are more than [`MAX_BYTES`] or no complete file of this schema, do
    /// not match their SHA-256, have an architecture, coordinates or scaling of another kind, have
    /// tensors of other number or shapes than the metadata state, or have a weight that is not
    /// finite.
    pub fn from_bytes(bytes: &[u8], file: &str) -> Result<WeightsFile, IoError> {
        bytes::check_size(bytes.len() as u64, MAX_BYTES, file)?;
        let (tensors, Content { network: entry, step, loss }) =
            network_tensors::read::<Content>(bytes, file, KEY, SCHEMA)?;
        entry.check(file)?;
        let widths = entry.widths();
        let place = || Place::file(file).field("tensors");
        if tensors.len() != 2 * (widths.len() - 1) {
            let expected = format!("{} for widths {widths:?}", 2 * (widths.len() - 1));
            return Err(IoError::unexpected(place(), expected, format!("{}", tensors.len())));
        }
        let misfit = |error| IoError::syntax(place(), format!("{error}"));
        let network = Network::new(tensors.layers(LAYERS, widths)?).map_err(misfit)?;
        let teacher = entry.teacher().clone();
        let projection = LearnedProjection::new(network, entry.scaling(), teacher.bounds).map_err(misfit)?;
        Ok(WeightsFile { projection, options: entry.options(), teacher, step, loss })
    }

    /// Reads a weights file, and returns its path and SHA-256 too.
    ///
    /// # Errors
    /// As [`from_bytes`](WeightsFile::from_bytes), and if the file cannot be read.
    pub fn read_file(path: &Path) -> Result<(WeightsFile, Input), IoError> {
        let (bytes, input) = tensor_file::read_all(path, MAX_BYTES, KEY)?;
        Ok((WeightsFile::from_bytes(&bytes, &input.path)?, input))
    }
}

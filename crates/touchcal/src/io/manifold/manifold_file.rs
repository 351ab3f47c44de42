//! `manifold.safetensors`: a contact manifold as samples, with their origin, schema 1.
//!
//! One tensor, `poses`, of shape `[n, 6]` and 64-bit numbers: a row per sample, `fixture_from_tool`
//! as x, y, z (m), roll, pitch, yaw (rad). One entry of metadata, `touchcal_manifold`: JSON with
//! the [`Provenance`], units and names in it.

use std::collections::HashMap;
use std::path::Path;

use safetensors::Dtype;
use safetensors::tensor::TensorView;
use serde::{Deserialize, Serialize};

use crate::io::base::bytes::{self, Input};
use crate::io::base::error::{IoError, Place, quoted};
use crate::io::manifold::pose_file::{self, MAX_POSES, no_samples};
use crate::io::manifold::tensor_file;
use crate::manifold::PoseSamples;
use crate::manifold::coordinates::{Coordinates, Metric};

/// The schema that this version writes and reads; others are refused.
pub const SCHEMA: u32 = 1;
/// Largest file read (bytes): [`MAX_POSES`] samples of 48 bytes and a header of 1 MiB.
pub const MAX_BYTES: u64 = MAX_POSES as u64 * ROW as u64 + (1 << 20);

const TENSOR: &str = "poses";
const ENTRY: &str = "touchcal_manifold";
const POSE: &str = "fixture_from_tool";
const COLUMNS: [&str; 6] = ["x_m", "y_m", "z_m", "roll_rad", "pitch_rad", "yaw_rad"];
/// Bytes of a row.
const ROW: usize = 6 * size_of::<f64>();
/// Longest radian (m) of a metric.
const LONGEST_RADIAN: f64 = 1e3;

/// Samples of a contact manifold, and their origin.
#[derive(Clone, Debug, PartialEq)]
pub struct ManifoldFile {
    /// The samples `fixture_from_tool` (m, rad), in the order of the file.
    pub samples: PoseSamples,
    /// Origin of the samples.
    pub provenance: Provenance,
}

/// Origin of the samples of a contact manifold.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Provenance {
    /// Name of the fixture that was touched; empty if not known.
    pub fixture: String,
    /// Number of poses that were recorded, before thinning: at least that of the samples.
    pub recorded: u64,
    /// Distance (m, ≥ 0) to which the poses were thinned; 0 if not at all.
    pub spacing: f64,
    /// Length that a radian counts as in that distance (m/rad, > 0, at most 1000).
    pub metres_per_radian: f64,
    /// Files from which the samples were computed.
    pub inputs: Vec<Input>,
    /// Version of this crate that wrote the file.
    pub version: String,
}

impl Provenance {
    /// The metric in which the samples were thinned, of [`Provenance::metres_per_radian`].
    pub fn metric(&self) -> Metric {
        Metric { metres_per_radian: self.metres_per_radian }
    }
}

/// The metadata as written.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    schema: u32,
    pose: String,
    columns: Vec<String>,
    /// SHA-256 of the tensor's bytes: the format itself does not notice damaged numbers.
    sha256: String,
    provenance: Provenance,
}

impl ManifoldFile {
    /// The bytes of a manifold file. Numbers of the provenance must be finite and in their ranges,
    /// which is not checked; others make a file that cannot be read back.
    ///
    /// # Errors
    /// [`IoError::Syntax`] if serialization fails.
    pub fn to_bytes(&self) -> Result<Vec<u8>, IoError> {
        let failed = |error: String| IoError::syntax(Place::file("manifold"), error);
        let poses = self.samples.coordinates();
        let data: Vec<u8> = poses.iter().flatten().flat_map(|value| value.to_le_bytes()).collect();
        let entry = Entry {
            schema: SCHEMA,
            pose: POSE.to_owned(),
            columns: COLUMNS.map(str::to_owned).to_vec(),
            sha256: bytes::sha256(&data),
            provenance: self.provenance.clone(),
        };
        let entry = serde_json::to_string(&entry).map_err(|error| failed(error.to_string()))?;
        let tensor = TensorView::new(Dtype::F64, vec![poses.len(), 6], &data);
        let tensor = tensor.map_err(|error| failed(error.to_string()))?;
        let metadata = HashMap::from([(ENTRY.to_owned(), entry)]);
        safetensors::serialize([(TENSOR, tensor)], Some(metadata)).map_err(|error| failed(error.to_string()))
    }

    /// Reads the bytes of a manifold file; `file` is its name for messages.
    ///
    /// # Errors
    /// [`IoError`] if the bytes are more than [`MAX_BYTES`] or no complete file of this schema, the
    /// tensor has another kind or shape or does not match its SHA-256, a number of the provenance
    /// is out of its range, or there are fewer than two different poses or a coordinate that is not
    /// finite.
    pub fn from_bytes(bytes: &[u8], file: &str) -> Result<ManifoldFile, IoError> {
        bytes::check_size(bytes.len() as u64, MAX_BYTES, file)?;
        let (tensors, entry) = tensor_file::parse(bytes, file, ENTRY)?;
        let Entry { sha256, provenance, .. } = read_entry(&entry, file)?;
        let tensor = Place::file(file).field(format!("tensor `{TENSOR}`"));
        let Ok(poses) = tensors.tensor(TENSOR) else {
            return Err(IoError::unexpected(tensor, "one", "none"));
        };
        match (poses.dtype(), poses.shape()) {
            (Dtype::F64, [_, 6]) => {}
            (kind, shape) => {
                return Err(IoError::unexpected(tensor, "F64 of shape [n, 6]", format!("{kind:?} of shape {shape:?}")));
            }
        }
        if bytes::sha256(poses.data()) != sha256 {
            return Err(IoError::unexpected(tensor, format!("numbers of SHA-256 {sha256}"), "damaged ones"));
        }
        let samples = PoseSamples::new(rows(poses.data())).map_err(|error| no_samples(tensor, &error))?;
        if provenance.recorded < samples.len() as u64 {
            let expected = format!("at least the {} samples", samples.len());
            return Err(IoError::unexpected(
                Place::file(file).field("recorded"),
                expected,
                format!("{}", provenance.recorded),
            ));
        }
        Ok(ManifoldFile { samples, provenance })
    }

    /// Reads a manifold file, and returns its fingerprint too.
    ///
    /// # Errors
    /// As [`from_bytes`](ManifoldFile::from_bytes), and if the file cannot be read.
    pub fn read_file(path: &Path) -> Result<(ManifoldFile, Input), IoError> {
        let (bytes, input) = tensor_file::read_all(path, MAX_BYTES, ENTRY)?;
        Ok((ManifoldFile::from_bytes(&bytes, &input.path)?, input))
    }
}

/// Reads samples, by the extension of the path in any case: from a manifold file (`.safetensors`)
/// with the metric in which they were thinned, or from a file of poses (any other extension),
/// without a metric. Returns the file's fingerprint too.
///
/// # Errors
/// As [`ManifoldFile::read_file`] or [`pose_file::read_file`].
pub fn read_samples(path: &Path) -> Result<(PoseSamples, Option<Metric>, Input), IoError> {
    if path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("safetensors")) {
        let (file, input) = ManifoldFile::read_file(path)?;
        let metric = file.provenance.metric();
        return Ok((file.samples, Some(metric), input));
    }
    let (samples, input) = pose_file::read_file(path)?;
    Ok((samples, None, input))
}

/// The rows of a tensor; the format has already checked that they are whole.
fn rows(data: &[u8]) -> Vec<Coordinates> {
    let number = |row: &[u8], k: usize| row[8 * k..].first_chunk().map_or(f64::NAN, |bytes| f64::from_le_bytes(*bytes));
    data.chunks_exact(ROW).map(|row| std::array::from_fn(|k| number(row, k))).collect()
}

fn read_entry(text: &str, file: &str) -> Result<Entry, IoError> {
    /// Read first, so that a later schema gets the right message.
    #[derive(Deserialize)]
    struct Head {
        schema: u32,
    }
    let place = |field: &str| Place::file(file).field(format!("metadata, {field}"));
    let syntax = |error: serde_json::Error| IoError::syntax(place(ENTRY), error.to_string());
    let Head { schema } = serde_json::from_str(text).map_err(syntax)?;
    if schema != SCHEMA {
        return Err(IoError::unexpected(place("schema"), format!("schema {SCHEMA}"), format!("{schema}")));
    }
    let entry: Entry = serde_json::from_str(text).map_err(syntax)?;
    let Entry { pose, columns, provenance, .. } = &entry;
    if pose != POSE {
        return Err(IoError::unexpected(place("pose"), format!("{POSE:?}"), quoted(pose)));
    }
    if columns != &COLUMNS {
        return Err(IoError::unexpected(place("columns"), COLUMNS.join(","), quoted(&columns.join(","))));
    }
    let &Provenance { spacing, metres_per_radian, .. } = provenance;
    if !(spacing.is_finite() && spacing >= 0.0) {
        return Err(IoError::unexpected(place("spacing"), "a number of at least 0", format!("{spacing}")));
    }
    if !(metres_per_radian > 0.0 && metres_per_radian <= LONGEST_RADIAN) {
        let expected = format!("a positive number, at most {LONGEST_RADIAN}");
        return Err(IoError::unexpected(place("metres_per_radian"), expected, format!("{metres_per_radian}")));
    }
    Ok(entry)
}

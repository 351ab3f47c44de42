//! Layers as tensors of a safetensors file, with one entry of metadata: `layers.0.weight` (F32, a
//! row for each output), `layers.0.bias`, …

use std::collections::HashMap;

use safetensors::tensor::TensorView;
use safetensors::{Dtype, SafeTensors};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use crate::io::base::bytes;
use crate::io::base::error::{IoError, Place};
use crate::io::manifold::tensor_file;
use crate::manifold::learned::Layer;

/// The metadata as written.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry<T> {
    schema: u32,
    /// SHA-256 of the tensors' bytes in the order of their names: the format itself does not notice
    /// damaged numbers.
    sha256: String,
    content: T,
}

/// A file's bytes: `networks` with the prefixes of their tensors' names, `content` as JSON under
/// `key`.
pub(crate) fn write<T: Serialize>(
    key: &str,
    schema: u32,
    content: T,
    networks: &[(&str, &[Layer])],
) -> Result<Vec<u8>, IoError> {
    let failed = |error: String| IoError::syntax(Place::file(key), error);
    let mut data = Vec::new();
    for (prefix, layers) in networks {
        for (k, layer) in layers.iter().enumerate() {
            data.push((
                name(prefix, k, "weight"),
                vec![layer.outputs(), layer.inputs()],
                little_endian(layer.weights()),
            ));
            data.push((name(prefix, k, "bias"), vec![layer.outputs()], little_endian(layer.bias())));
        }
    }
    data.sort_by(|a, b| a.0.cmp(&b.0));
    let sha256 = bytes::sha256_of_parts(data.iter().map(|(_, _, data)| data.as_slice()));
    let entry = serde_json::to_string(&Entry { schema, sha256, content }).map_err(|error| failed(error.to_string()))?;
    let views = data.iter().map(|(name, shape, data)| {
        let view = TensorView::new(Dtype::F32, shape.clone(), data).map_err(|error| failed(error.to_string()))?;
        Ok((name.as_str(), view))
    });
    let views = views.collect::<Result<Vec<_>, IoError>>()?;
    safetensors::serialize(views, Some(HashMap::from([(key.to_owned(), entry)]))).map_err(|e| failed(e.to_string()))
}

fn name(prefix: &str, layer: usize, part: &str) -> String {
    format!("{prefix}.{layer}.{part}")
}

fn little_endian(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|value| value.to_le_bytes()).collect()
}

/// A file that was read and is whole.
pub(crate) struct Tensors<'b> {
    tensors: SafeTensors<'b>,
    file: &'b str,
}

/// Reads a file's bytes and the content under `key`; `file` is its name for messages.
pub(crate) fn read<'b, T: DeserializeOwned>(
    bytes: &'b [u8],
    file: &'b str,
    key: &str,
    schema: u32,
) -> Result<(Tensors<'b>, T), IoError> {
    /// Read first, so that a later schema gets the right message.
    #[derive(Deserialize)]
    struct Head {
        schema: u32,
    }
    let place = || Place::file(file);
    let (tensors, entry) = tensor_file::parse(bytes, file, key)?;
    let syntax =
        |error: serde_json::Error| IoError::syntax(place().field(format!("metadata, {key}")), error.to_string());
    let head: Head = serde_json::from_str(&entry).map_err(syntax)?;
    if head.schema != schema {
        let found = format!("{}", head.schema);
        return Err(IoError::unexpected(place().field("metadata, schema"), format!("schema {schema}"), found));
    }
    let entry: Entry<T> = serde_json::from_str(&entry).map_err(syntax)?;
    let mut named = tensors.tensors();
    named.sort_by(|a, b| a.0.cmp(&b.0));
    if bytes::sha256_of_parts(named.iter().map(|(_, view)| view.data())) != entry.sha256 {
        let expected = format!("numbers of SHA-256 {}", entry.sha256);
        return Err(IoError::unexpected(place().field("tensors"), expected, "damaged ones"));
    }
    Ok((Tensors { tensors, file }, entry.content))
}

impl Tensors<'_> {
    /// The layers of these widths.
    pub(crate) fn layers(&self, prefix: &str, widths: &[usize]) -> Result<Vec<Layer>, IoError> {
        let each = widths.windows(2).enumerate().map(|(k, pair)| {
            let weights = self.values(&name(prefix, k, "weight"), &[pair[1], pair[0]])?;
            let bias = self.values(&name(prefix, k, "bias"), &[pair[1]])?;
            Ok(Layer::new(pair[0], weights, bias))
        });
        each.collect()
    }

    /// Number of tensors.
    pub(crate) fn len(&self) -> usize {
        self.tensors.len()
    }

    fn values(&self, name: &str, shape: &[usize]) -> Result<Vec<f32>, IoError> {
        let place = Place::file(self.file).field(format!("tensor `{name}`"));
        let Ok(view) = self.tensors.tensor(name) else {
            return Err(IoError::unexpected(place, format!("one of shape {shape:?}"), "none"));
        };
        if view.dtype() != Dtype::F32 || view.shape() != shape {
            let found = format!("{:?} of shape {:?}", view.dtype(), view.shape());
            return Err(IoError::unexpected(place, format!("F32 of shape {shape:?}"), found));
        }
        let (numbers, _) = view.data().as_chunks::<4>();
        let values: Vec<f32> = numbers.iter().map(|bytes| f32::from_le_bytes(*bytes)).collect();
        match values.iter().find(|value| !value.is_finite()) {
            Some(value) => Err(IoError::unexpected(place, "finite numbers", format!("{value}"))),
            None => Ok(values),
        }
    }
}

//! Files of networks: read as written, everything else refused.

use crate::support::refused;
use proptest::prelude::*;
use touchcal::io::Input;
use touchcal::io::checkpoint_file::{self, CheckpointFile};
use touchcal::io::onnx;
use touchcal::io::weights_file::{Teacher, WeightsFile};
use touchcal::manifold::Projection;
use touchcal::manifold::coordinates::Metric;
use touchcal::manifold::learned::{
    AdamState, BestWeights, Checkpoint, Layer, LearnedProjection, Network, Output, Scaling, TrainingOptions,
};

fn teacher() -> Teacher {
    Teacher {
        manifold: Input { path: "m.safetensors".to_owned(), sha256: "0123".to_owned(), is_log: false },
        samples: 20,
        // Numbers that only exact reading brings back.
        bounds: [(-0.1, 0.3), (-1.0 / 3.0, 1e-17), (0.0, 0.1 + 0.2), (-3.0, 3.0), (0.0, 0.0), (-0.5, f64::EPSILON)],
        offsets: [0.01, 0.01, 0.01, 0.17, 0.17, 0.17],
        seed: u64::MAX,
    }
}

fn scaling() -> Scaling {
    Scaling {
        output: Output::Correction,
        metric: Metric::MILLIMETRE_PER_DEGREE,
        input_centre: [0.1, 0.2, 1.0 / 3.0, -0.1, 0.0, 3.0],
        input_scale: [0.1, 0.7, 1.0 / 3.0, 0.1, 1e-9, 3.0],
        output_centre: [0.3; 6],
        output_length: 0.1 + 0.2,
    }
}

fn options() -> TrainingOptions {
    TrainingOptions { hidden: vec![7, 5], output: Output::Correction, rate: 1.0 / 3.0, ..TrainingOptions::default() }
}

fn network(seed: u64) -> Network {
    Network::random(&[6, 7, 5, 6], seed).unwrap()
}

fn weights() -> WeightsFile {
    let projection = LearnedProjection::new(network(1), scaling(), teacher().bounds).unwrap();
    WeightsFile { projection, options: options(), teacher: teacher(), step: 17, loss: Some(0.1 + 0.7) }
}

fn checkpoint() -> CheckpointFile {
    let mut adam = AdamState::new(&network(1));
    adam.first = network(2).layers().to_vec();
    adam.second = network(3).layers().to_vec();
    adam.steps = 40;
    let best = Some(BestWeights { network: network(4), loss: 0.1 + 0.2, step: 30 });
    let checkpoint = Checkpoint { options: options(), scaling: scaling(), network: network(1), adam, best };
    CheckpointFile { checkpoint, teacher: teacher() }
}

fn checkpoint_bytes() -> Vec<u8> {
    let file = checkpoint();
    checkpoint_file::to_bytes(&file.checkpoint, &file.teacher).unwrap()
}

fn read(bytes: &[u8]) -> Result<WeightsFile, String> {
    WeightsFile::from_bytes(bytes, "w.safetensors").map_err(|error| error.to_string())
}

fn read_checkpoint(bytes: &[u8]) -> Result<CheckpointFile, String> {
    checkpoint_file::from_bytes(bytes, "c.safetensors").map_err(|error| error.to_string())
}

/// The file with `from` in its header changed to `to`.
fn changed(bytes: &[u8], from: &str, to: &str) -> Vec<u8> {
    let length = u64::from_le_bytes(*bytes.first_chunk().unwrap()) as usize;
    let header = std::str::from_utf8(&bytes[8..8 + length]).unwrap();
    assert!(header.contains(from), "no `{from}` in {header}");
    let mut header = header.trim_end().replacen(from, to, 1);
    while !header.len().is_multiple_of(8) {
        header.push(' ');
    }
    [&(header.len() as u64).to_le_bytes()[..], header.as_bytes(), &bytes[8 + length..]].concat()
}

#[test]
fn files_come_back_to_the_last_bit() {
    assert!(read(&weights().to_bytes().unwrap()).unwrap() == weights());
    let unlooked = WeightsFile { loss: None, ..weights() };
    assert!(read(&unlooked.to_bytes().unwrap()).unwrap() == unlooked);
    assert!(read_checkpoint(&checkpoint_bytes()).unwrap() == checkpoint());
    let mut early = checkpoint();
    early.checkpoint.best = None;
    let bytes = checkpoint_file::to_bytes(&early.checkpoint, &early.teacher).unwrap();
    assert!(read_checkpoint(&bytes).unwrap() == early);
    assert_eq!(weights().to_bytes().unwrap(), weights().to_bytes().unwrap());
}

#[test]
fn damaged_and_foreign_weights_are_refused() {
    let bytes = weights().to_bytes().unwrap();
    refused(read(&[]), &["w.safetensors: expected a whole safetensors file"]);
    refused(read(&bytes[..bytes.len() - 1]), &["a whole safetensors file"]);
    refused(read(&[&u64::MAX.to_le_bytes()[..], &bytes[8..]].concat()), &["a whole safetensors file", "large"]);
    let mut flipped = bytes.clone();
    *flipped.last_mut().unwrap() ^= 1;
    refused(read(&flipped), &["SHA-256", "damaged ones"]);
    refused(read(&checkpoint_bytes()), &["metadata", "entry `touchcal_network`"]);
    refused(read_checkpoint(&bytes), &["metadata", "entry `touchcal_checkpoint`"]);

    let with = |from: &str, to: &str| read(&changed(&bytes, from, to));
    refused(with("\\\"schema\\\":1", "\\\"schema\\\":2"), &["schema", "schema 1", "found 2"]);
    refused(with("\\\"relu\\\"", "\\\"tanh\\\""), &["metadata, activation", "relu", "tanh"]);
    refused(with("roll_rad", "roll_deg"), &["metadata, columns", "roll_deg"]);
    refused(with("[6,7,5,6]", "[6,8,5,6]"), &["tensor `layers.0.weight`", "F32 of shape [8, 6]", "shape [7, 6]"]);
    refused(with("[6,7,5,6]", "[6,7,6]"), &["tensors", "4 for widths", "found 6"]);
    refused(with("[6,7,5,6]", "[6,7,5,3]"), &["metadata, widths", "[6, 7, 5, 3]"]);
    refused(with("[6,7,5,6]", "[6,99999999999,5,6]"), &["metadata, widths"]);
    refused(with("\\\"output_length\\\":0.3", "\\\"output_length\\\":-0.3"), &["positive numbers", "-0.3"]);
    refused(with("\\\"correction\\\"", "\\\"poses\\\""), &["metadata, touchcal_network", "poses"]);
    refused(with("[-0.1,0.3]", "[0.4,0.3]"), &["metadata, bounds"]);
    refused(with("layers.1.bias", "layers.9.bias"), &["damaged ones"]);
}

/// A file of gigabytes costs no more than its header.
#[test]
fn a_file_that_its_header_contradicts_is_refused_unread() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("c.safetensors");
    let read = |bytes: &[u8]| {
        std::fs::write(&path, bytes).unwrap();
        std::fs::OpenOptions::new().write(true).open(&path).unwrap().set_len(3 << 30).unwrap();
        checkpoint_file::read_file(&path).map_err(|error| error.to_string())
    };
    let whole = checkpoint_bytes();
    refused(read(&whole), &[&format!("of {} bytes by its header, found 3221225472 bytes", whole.len())]);
    refused(read(&weights().to_bytes().unwrap()), &["metadata", "entry `touchcal_checkpoint`"]);
    refused(read(&[]), &["c.safetensors: expected a whole safetensors file"]);
    refused(read(&u64::MAX.to_le_bytes()), &["with a header of at most 1048576 bytes"]);
}

#[test]
fn weights_that_are_no_numbers_are_refused() {
    // With the right fingerprint, as a training gone wrong would write it.
    let mut layers = network(1).layers().to_vec();
    layers[1] = Layer::new(7, vec![f32::INFINITY; 35], vec![0.0; 5]);
    let mut file = checkpoint();
    file.checkpoint.adam.second = layers;
    let bytes = checkpoint_file::to_bytes(&file.checkpoint, &file.teacher).unwrap();
    refused(read_checkpoint(&bytes), &["tensor `second.1.weight`", "finite numbers", "inf"]);
}

#[test]
fn an_exported_network_names_its_parts() {
    let bytes = onnx::to_bytes(&weights().projection, &[("pose", "fixture_from_tool".to_owned())]);
    for part in ["touchcal", "projected", "layers.2.weight", "Gemm", "Relu", "fixture_from_tool"] {
        assert!(bytes.windows(part.len()).any(|window| window == part.as_bytes()), "{part}");
    }
    // All tensors are in it: weights, biases, three scales.
    let numbers = 4 * (6 * 7 + 7 + 7 * 5 + 5 + 5 * 6 + 6 + 3 * 6);
    assert!(bytes.len() > numbers && bytes.len() < numbers + 2000, "{}", bytes.len());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn mutated_files_are_answered(at in 0..9000usize, cut in 0..8usize, with in prop::collection::vec(any::<u8>(), 0..5)) {
        let mutated = |mut bytes: Vec<u8>| {
            let at = at % bytes.len();
            let end = (at + cut).min(bytes.len());
            bytes.splice(at..end, with.clone());
            bytes
        };
        // What is accepted has the weights that were written.
        if let Ok(read) = read(&mutated(weights().to_bytes().unwrap())) {
            prop_assert!(read.projection.network() == weights().projection.network());
            prop_assert!(read.projection.name() == "learned projection");
        }
        if let Ok(read) = read_checkpoint(&mutated(checkpoint_bytes())) {
            prop_assert!(read.checkpoint.network == checkpoint().checkpoint.network);
        }
    }
}

//! Labelled pairs as a network sees them, and their loss.

use std::ops::Range;

use rayon::prelude::*;

use super::network::{CHUNK, Network, Tape};
use super::scaling::Scaling;
use crate::manifold::projection::nearest::NearestSample;
use crate::manifold::projection::training_pairs::TrainingPairs;

/// Pairs made at a time.
pub(super) const PORTION: u64 = 1 << 16;

/// What a projection is learned from: pairs of poses, and the projection that labels them.
#[derive(Clone, Copy, Debug)]
pub struct TrainingSource<'t> {
    /// Projection that computes the target of each input; its samples are what the inputs are near
    /// to.
    pub projection: &'t NearestSample,
    /// Offsets of the inputs from the samples, and seed of the pairs.
    pub pairs: TrainingPairs,
}

/// Inputs and targets as the network sees them, six numbers a pair.
#[derive(Debug, Default)]
pub(super) struct PairSet {
    inputs: Vec<f32>,
    targets: Vec<f32>,
}

/// Some pairs of a set.
#[derive(Clone, Copy, Debug)]
pub(super) struct Batch<'s> {
    /// Inputs of the network, six numbers per pair.
    pub inputs: &'s [f32],
    /// Outputs that the network should have, six numbers per pair.
    pub targets: &'s [f32],
}

impl PairSet {
    /// Pairs number `range`.
    pub(super) fn new(scaling: &Scaling, source: &TrainingSource<'_>, range: Range<u64>) -> PairSet {
        let mut set = PairSet::default();
        let (mut inputs, mut targets) = (Vec::new(), Vec::new());
        let mut first = range.start;
        while first < range.end {
            let portion = first..range.end.min(first + PORTION);
            first = portion.end;
            source.pairs.fill(source.projection, portion, &mut inputs, &mut targets);
            set.inputs.extend(inputs.iter().flat_map(|c| scaling.input(c)));
            set.targets.extend(inputs.iter().zip(&targets).flat_map(|(c, target)| scaling.target(c, target)));
        }
        set
    }

    /// Number of pairs.
    pub(super) fn len(&self) -> usize {
        self.inputs.len() / 6
    }

    pub(super) fn batch(&self, range: Range<usize>) -> Batch<'_> {
        let numbers = 6 * range.start..6 * range.end;
        Batch { inputs: &self.inputs[numbers.clone()], targets: &self.targets[numbers] }
    }
}

impl Batch<'_> {
    /// Number of pairs.
    pub fn len(&self) -> usize {
        self.inputs.len() / 6
    }

    /// The derivative of the loss by an output, as a multiple of that output's error.
    pub fn slope(&self) -> f32 {
        2.0 / self.inputs.len() as f32
    }

    /// Mean square of the outputs' errors; `tapes` then hold the values and the derivatives by the
    /// outputs.
    pub fn loss(&self, network: &Network, tapes: &mut Vec<Tape>) -> f64 {
        tapes.resize(self.len().div_ceil(CHUNK), Tape::default());
        let slope = self.slope();
        let inputs = self.inputs.par_chunks(6 * CHUNK);
        let targets = self.targets.par_chunks(6 * CHUNK);
        let squares = tapes.par_iter_mut().zip(inputs).zip(targets).map(|((tape, inputs), targets)| {
            let Tape { values, deltas } = tape;
            values.reset(network, inputs.len() / 6);
            deltas.reset(network, inputs.len() / 6);
            values.first_mut().copy_from_slice(inputs);
            network.run(values);
            let mut sum = 0.0;
            for ((delta, y), target) in deltas.last_mut().iter_mut().zip(values.last()).zip(targets) {
                let error = y - target;
                *delta = slope * error;
                sum += f64::from(error * error);
            }
            sum
        });
        // Summed in order, whichever thread was first.
        squares.collect::<Vec<f64>>().iter().sum::<f64>() / self.inputs.len() as f64
    }
}

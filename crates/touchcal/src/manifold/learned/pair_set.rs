//! Labelled pairs as a network sees them, and their loss.

use std::ops::Range;

use rayon::prelude::*;

use super::network::{CHUNK, Network, Tape};
use super::{Lessons, Scaling};

/// Pairs made at a time.
pub(super) const PORTION: u64 = 1 << 16;

/// Inputs and targets as the network sees them, six numbers a pair.
#[derive(Debug, Default)]
pub(super) struct PairSet {
    inputs: Vec<f32>,
    targets: Vec<f32>,
}

impl PairSet {
    /// Pairs number `range`.
    pub(super) fn new(scaling: &Scaling, lessons: &Lessons<'_>, range: Range<u64>) -> PairSet {
        let mut set = PairSet::default();
        let (mut inputs, mut targets) = (Vec::new(), Vec::new());
        let mut first = range.start;
        while first < range.end {
            let portion = first..range.end.min(first + PORTION);
            first = portion.end;
            lessons.pairs.fill(lessons.projection, portion, &mut inputs, &mut targets);
            set.inputs.extend(inputs.iter().flat_map(|c| scaling.input(c)));
            set.targets.extend(inputs.iter().zip(&targets).flat_map(|(c, target)| scaling.target(c, target)));
        }
        set
    }

    /// Number of pairs.
    pub(super) fn len(&self) -> usize {
        self.inputs.len() / 6
    }

    /// Mean square of the outputs' errors for some pairs; `tapes` then hold the values and the derivatives by the outputs.
    pub(super) fn loss(&self, network: &Network, range: Range<usize>, tapes: &mut Vec<Tape>) -> f64 {
        tapes.resize(range.len().div_ceil(CHUNK), Tape::default());
        let numbers = 6 * range.start..6 * range.end;
        let slope = 2.0 / numbers.len() as f32;
        let inputs = self.inputs[numbers.clone()].par_chunks(6 * CHUNK);
        let targets = self.targets[numbers.clone()].par_chunks(6 * CHUNK);
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
        squares.collect::<Vec<f64>>().iter().sum::<f64>() / numbers.len() as f64
    }
}

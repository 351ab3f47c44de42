//! Learning a projection from labelled pairs.

use std::ops::ControlFlow;

use super::adam::AdamState;
use super::checkpoint::{BestWeights, Checkpoint, TrainingOptions};
use super::device::{Device, DeviceError};
use super::engine::Engine;
use super::engine_of::engine_of;
use super::learned_projection::LearnedProjection;
use super::network::{Network, NetworkError};
use super::pair_set::{PORTION, PairSet, TrainingSource};
use super::scaling::Scaling;
use crate::manifold::projection::projected::Projection;

/// Number of the first held-out pair: far beyond those learned from, each of which is a pose of its
/// own.
const HELD_OUT: u64 = 1 << 48;

/// Why training cannot begin or go on.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TrainingError {
    /// Widths.
    #[error(transparent)]
    Network(#[from] NetworkError),
    /// What it should run on.
    #[error(transparent)]
    Device(#[from] DeviceError),
    /// A number of steps, pairs, or the rate, that leaves nothing to do.
    #[error("expected {what} above zero, found {found}")]
    Option {
        /// Which.
        what: &'static str,
        /// What it was.
        found: f64,
    },
    /// Loss or weights are no longer finite.
    #[error("the loss is {loss} after {step} steps: the learning rate is too high")]
    Diverged {
        /// Steps done.
        step: u64,
        /// The loss.
        loss: f64,
    },
}

/// Where training stands, after a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// Steps done.
    pub step: u64,
    /// Steps in all.
    pub steps: u64,
    /// Mean square of the outputs' errors in this step's batch, before the step;
    /// [`Scaling::distance`] makes it a length.
    pub loss: f64,
    /// Of the held-out pairs, where this step looked at them.
    pub held_out: Option<f64>,
}

/// Why training ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ending {
    /// All steps are done.
    AllSteps,
    /// Held-out pairs got no better for as long as patience reached.
    NoGain,
    /// The observer said so.
    Interrupted,
}

/// Who watches, and may break off. On the processor the checkpoint is that of the step; elsewhere
/// it is that of the last look at held-out pairs, which is as good to go on from.
pub type Observer<'o> = &'o mut dyn FnMut(&Progress, &Checkpoint) -> ControlFlow<()>;

/// Training under way.
#[derive(Debug)]
pub struct Training {
    state: Checkpoint,
    learned: PairSet,
    held_out: PairSet,
    bounds: [(f64, f64); 6],
    engine: Box<dyn Engine>,
    /// Steps done, of which the state may not know yet.
    done: u64,
}

impl Training {
    /// Before the first step, on the processor.
    ///
    /// # Errors
    /// If an option leaves nothing to do.
    pub fn start(options: TrainingOptions, source: &TrainingSource<'_>) -> Result<Training, TrainingError> {
        check(&options)?;
        let widths: Vec<usize> = [6].into_iter().chain(options.hidden.iter().copied()).chain([6]).collect();
        let network = Network::random(&widths, options.seed)?;
        let (mut inputs, mut targets) = (Vec::new(), Vec::new());
        // Enough of them for the scaling.
        source.pairs.fill(source.projection, 0..options.pairs.min(PORTION), &mut inputs, &mut targets);
        let scaling = Scaling::of(options.output, source.projection.metric(), &inputs, &targets);
        let adam = AdamState::new(&network);
        Training::resume(Checkpoint { options, scaling, network, adam, best: None }, source)
    }

    /// From where `state` left off, with the source it learned from.
    ///
    /// # Errors
    /// If an option leaves nothing to do.
    pub fn resume(state: Checkpoint, source: &TrainingSource<'_>) -> Result<Training, TrainingError> {
        check(&state.options)?;
        let batch = state.options.batch as u64;
        let pairs = state.options.pairs.div_ceil(batch) * batch;
        let held_out = HELD_OUT..HELD_OUT + state.options.held_out as u64;
        Ok(Training {
            learned: PairSet::new(&state.scaling, source, 0..pairs),
            held_out: PairSet::new(&state.scaling, source, held_out),
            bounds: source.projection.bounds(),
            engine: engine_of(Device::Cpu, &state)?,
            done: state.adam.steps,
            state,
        })
    }

    /// The same from here on another device. Its sums are rounded in another order than the
    /// processor's, and may be from run to run.
    ///
    /// # Errors
    /// If this build or this machine lacks the device.
    pub fn on(mut self, device: Device) -> Result<Training, TrainingError> {
        self.engine.read(&mut self.state)?;
        self.engine = engine_of(device, &self.state)?;
        Ok(self)
    }

    /// Where it stood when it last ended.
    pub fn state(&self) -> &Checkpoint {
        &self.state
    }

    /// Goes on to the end, or until `observer` breaks it off after some step.
    ///
    /// # Errors
    /// If the loss is no longer finite, or the device fails.
    pub fn run(&mut self, observer: Observer<'_>) -> Result<Ending, TrainingError> {
        while self.done < self.state.options.steps {
            if self.out_of_patience() {
                return Ok(Ending::NoGain);
            }
            let loss = self.step()?;
            let step = self.done;
            if !loss.is_finite() {
                return Err(TrainingError::Diverged { step, loss });
            }
            let TrainingOptions { steps, check_every, .. } = self.state.options;
            let look = step.is_multiple_of(check_every) || step == steps;
            let held_out = if look { Some(self.look()?) } else { None };
            if observer(&Progress { step, steps, loss, held_out }, &self.state).is_break() {
                self.engine.read(&mut self.state)?;
                return Ok(Ending::Interrupted);
            }
        }
        Ok(Ending::AllSteps)
    }

    /// The best weights so far as a projection.
    ///
    /// # Errors
    /// If the network has not six inputs and outputs, which only a changed checkpoint can bring
    /// about.
    pub fn learned(&self) -> Result<LearnedProjection, NetworkError> {
        let network = self.state.best.as_ref().map_or(&self.state.network, |best| &best.network);
        LearnedProjection::new(network.clone(), self.state.scaling, self.bounds)
    }

    fn out_of_patience(&self) -> bool {
        let TrainingOptions { patience, check_every, .. } = self.state.options;
        let since = self.state.best.as_ref().map_or(0, |best| self.done - best.step);
        patience > 0 && since >= patience.saturating_mul(check_every)
    }

    /// One step; the loss before it.
    fn step(&mut self) -> Result<f64, DeviceError> {
        let options = &self.state.options;
        let batches = self.learned.len() / options.batch;
        let first = (self.done % batches as u64) as usize * options.batch;
        let batch = self.learned.batch(first..first + options.batch);
        let rate = options.rate_at(self.done);
        self.done += 1;
        self.engine.step(&mut self.state, &batch, rate)
    }

    /// The loss on the held-out pairs; keeps the weights if it is the least so far.
    fn look(&mut self) -> Result<f64, DeviceError> {
        // A batch at a time, so that memory is that of a step.
        let batch = self.state.options.batch;
        let count = self.held_out.len();
        let mut sum = 0.0;
        for first in (0..count).step_by(batch) {
            let batch = self.held_out.batch(first..count.min(first + batch));
            sum += batch.len() as f64 * self.engine.loss(&self.state, &batch)?;
        }
        let loss = sum / count as f64;
        self.engine.read(&mut self.state)?;
        let Checkpoint { network, adam, best, .. } = &mut self.state;
        if best.as_ref().is_none_or(|best| loss < best.loss) {
            *best = Some(BestWeights { network: network.clone(), loss, step: adam.steps });
        }
        Ok(loss)
    }
}

fn check(options: &TrainingOptions) -> Result<(), TrainingError> {
    let numbers = [
        ("the batch", options.batch as f64),
        ("the steps", options.steps as f64),
        ("the pairs", options.pairs as f64),
        ("the held-out pairs", options.held_out as f64),
        ("the steps between checks", options.check_every as f64),
        ("the learning rate", options.rate),
    ];
    match numbers.into_iter().find(|(_, found)| !(found.is_finite() && *found > 0.0)) {
        Some((what, found)) => Err(TrainingError::Option { what, found }),
        None => Ok(()),
    }
}

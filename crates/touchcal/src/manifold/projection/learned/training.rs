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

/// Why training cannot begin or continue, or its network cannot be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TrainingError {
    /// The widths of the hidden layers make no network, as one of them is zero; or the network of a
    /// changed checkpoint makes no projection ([`Training::learned`]).
    #[error(transparent)]
    Network(#[from] NetworkError),
    /// The device is missing or failed.
    #[error(transparent)]
    Device(#[from] DeviceError),
    /// An option that must be finite and above zero is not; the first one is reported.
    #[error("expected {what} above zero, found {found}")]
    Option {
        /// Name of the option: "the batch", "the steps", "the pairs", "the held-out pairs", "the
        /// steps between checks" or "the learning rate".
        what: &'static str,
        /// Value of the option, in its unit.
        found: f64,
    },
    /// The loss of a batch is no longer finite: the learning rate is too high.
    #[error("the loss is {loss} after {step} steps: the learning rate is too high")]
    Diverged {
        /// Number of steps done, with the one that failed.
        step: u64,
        /// The loss, NaN or infinite.
        loss: f64,
    },
}

/// Progress of training after a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// Number of steps done, 1 after the first; those before a checkpoint count.
    pub step: u64,
    /// Total number of steps: [`TrainingOptions::steps`].
    pub steps: u64,
    /// Mean square of the outputs' errors (no unit) in this step's batch, before the step;
    /// [`Scaling::distance`] converts it to a distance (m).
    pub loss: f64,
    /// Mean square of the outputs' errors (no unit) over the held-out pairs, after the step; `None`
    /// at steps without evaluation.
    pub held_out: Option<f64>,
}

/// Why [`Training::run`] ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ending {
    /// All steps are done.
    AllSteps,
    /// The held-out loss did not fall for [`TrainingOptions::patience`] successive evaluations.
    NoGain,
    /// The observer returned [`ControlFlow::Break`].
    Interrupted,
}

/// Callback after each step; [`ControlFlow::Break`] ends the training with [`Ending::Interrupted`].
/// On the processor the checkpoint is that of the step; on other devices it is that of the last
/// evaluation on held-out pairs, from which training can also be resumed.
pub type Observer<'o> = &'o mut dyn FnMut(&Progress, &Checkpoint) -> ControlFlow<()>;

/// A training in progress: begun by [`Training::start`] or [`Training::resume`], done by
/// [`Training::run`].
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
    /// Prepares training before the first step, on the processor: a random network
    /// ([`Network::random`]) from `options.seed`, and all pairs, computed here and held in memory,
    /// 48 bytes each.
    ///
    /// # Errors
    /// [`TrainingError::Option`] if an option that must be positive is not,
    /// [`TrainingError::Network`] if a hidden layer has width zero.
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

    /// Prepares training from a checkpoint, on the processor; `source` must be the one that the
    /// checkpoint was trained with, and the checkpoint's network and [`AdamState`] of the shape
    /// that [`start`](Training::start) gives them: neither is checked. The pairs are computed anew.
    ///
    /// # Errors
    /// [`TrainingError::Option`] if an option that must be positive is not.
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

    /// Moves the training to another device. Its sums are rounded in another order than the
    /// processor's, and possibly differently from run to run.
    ///
    /// # Errors
    /// [`TrainingError::Device`] if this build or this machine lacks the device, or one of the
    /// devices fails. The training is lost then; a clone of its [`state`](Training::state) can be
    /// resumed.
    pub fn on(mut self, device: Device) -> Result<Training, TrainingError> {
        self.engine.read(&mut self.state)?;
        self.engine = engine_of(device, &self.state)?;
        Ok(self)
    }

    /// Checkpoint of the training; on the processor that of the last step, on other devices that of
    /// the last evaluation on held-out pairs or of the end of [`run`](Training::run).
    pub fn state(&self) -> &Checkpoint {
        &self.state
    }

    /// Trains until all steps are done, patience is exhausted, or `observer` ends it after some
    /// step. After an interruption another call continues; after another [`Ending`] it ends at once
    /// in the same way.
    ///
    /// # Errors
    /// [`TrainingError::Diverged`] if the loss is no longer finite, [`TrainingError::Device`] if
    /// the device fails. The best weights of the [`state`](Training::state) so far are kept.
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

    /// The best weights so far as a projection; the current weights before the first evaluation on
    /// held-out pairs.
    ///
    /// # Errors
    /// [`NetworkError::Shape`] if the network has not six inputs and outputs, which only a changed
    /// checkpoint can cause.
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

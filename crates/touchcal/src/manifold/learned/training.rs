//! Learning a projection from labelled pairs.

use std::f64::consts::PI;
use std::ops::ControlFlow;

use super::engine::Engine;
use super::pair_set::{PORTION, PairSet};
use super::{Adam, Device, DeviceError, LearnedProjection, Network, NetworkError, Output, Scaling};
use crate::manifold::{NearestSample, Projection, TrainingPairs};

/// Number of the first held-out pair: far beyond those learned from, each of which is a pose of its
/// own.
const HELD_OUT: u64 = 1 << 48;
/// Share of the steps in which the rate rises from zero.
const WARM_UP: f64 = 0.02;
/// Rate at the end, as a share of the greatest.
const FINAL_RATE: f64 = 1e-3;

/// Pairs, and the projection that labels them.
#[derive(Clone, Copy, Debug)]
pub struct Lessons<'t> {
    /// The teacher.
    pub projection: &'t NearestSample,
    /// The pairs.
    pub pairs: TrainingPairs,
}

/// How to learn.
#[derive(Clone, Debug, PartialEq)]
pub struct TrainingOptions {
    /// Width of each hidden layer.
    pub hidden: Vec<usize>,
    /// What outputs stand for.
    pub output: Output,
    /// Pairs a step.
    pub batch: usize,
    /// Steps in all.
    pub steps: u64,
    /// Greatest learning rate. It rises linearly in the first 2 % of the steps and then falls to a
    /// thousandth along a cosine (Loshchilov & Hutter 2017, arXiv 1608.03983).
    pub rate: f64,
    /// Different pairs to learn from, rounded up to whole batches; they are taken in turn, again
    /// and again.
    pub pairs: u64,
    /// Held-out pairs on which the best weights are chosen.
    pub held_out: usize,
    /// Steps between two looks at them.
    pub check_every: u64,
    /// Looks in a row that may find no better weights before training stops early; 0 to go on
    /// always.
    pub patience: u64,
    /// Seed of the first weights; the pairs have their own.
    pub seed: u64,
}

impl Default for TrainingOptions {
    /// A network of four layers of 512 that learns in minutes on two cores.
    fn default() -> Self {
        TrainingOptions {
            hidden: vec![512; 4],
            output: Output::Pose,
            batch: 1024,
            steps: 20_000,
            rate: 1e-3,
            pairs: 1 << 20,
            held_out: 8192,
            check_every: 500,
            patience: 0,
            seed: 1,
        }
    }
}

impl TrainingOptions {
    /// Learning rate of step `k`, the first one being 0.
    pub fn rate_at(&self, k: u64) -> f64 {
        let rise = (WARM_UP * self.steps as f64).max(1.0);
        let done = k as f64 + 1.0;
        if done < rise {
            return self.rate * done / rise;
        }
        let share = ((done - rise) / (self.steps as f64 - rise).max(1.0)).min(1.0);
        self.rate * (FINAL_RATE + (1.0 - FINAL_RATE) * 0.5 * (1.0 + (PI * share).cos()))
    }
}

/// The best weights so far.
#[derive(Clone, Debug, PartialEq)]
pub struct Best {
    /// The weights.
    pub network: Network,
    /// Their loss on the held-out pairs.
    pub loss: f64,
    /// Steps after which they were found.
    pub step: u64,
}

/// All that training needs to go on: from the same one, the same weights follow, bit for bit.
#[derive(Clone, Debug, PartialEq)]
pub struct Checkpoint {
    /// How to learn.
    pub options: TrainingOptions,
    /// What the network's numbers mean.
    pub scaling: Scaling,
    /// The weights.
    pub network: Network,
    /// The gradients' means, and the number of steps done.
    pub adam: Adam,
    /// The best weights, after the first look at the held-out pairs.
    pub best: Option<Best>,
}

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
    pub fn start(options: TrainingOptions, lessons: &Lessons<'_>) -> Result<Training, TrainingError> {
        check(&options)?;
        let widths: Vec<usize> = [6].into_iter().chain(options.hidden.iter().copied()).chain([6]).collect();
        let network = Network::random(&widths, options.seed)?;
        let (mut inputs, mut targets) = (Vec::new(), Vec::new());
        // Enough of them for the scaling.
        lessons.pairs.fill(lessons.projection, 0..options.pairs.min(PORTION), &mut inputs, &mut targets);
        let scaling = Scaling::of(options.output, lessons.projection.metric(), &inputs, &targets);
        let adam = Adam::new(&network);
        Training::resume(Checkpoint { options, scaling, network, adam, best: None }, lessons)
    }

    /// From where `state` left off, with the lessons it learned from.
    ///
    /// # Errors
    /// If an option leaves nothing to do.
    pub fn resume(state: Checkpoint, lessons: &Lessons<'_>) -> Result<Training, TrainingError> {
        check(&state.options)?;
        let batch = state.options.batch as u64;
        let pairs = state.options.pairs.div_ceil(batch) * batch;
        let held_out = HELD_OUT..HELD_OUT + state.options.held_out as u64;
        Ok(Training {
            learned: PairSet::new(&state.scaling, lessons, 0..pairs),
            held_out: PairSet::new(&state.scaling, lessons, held_out),
            bounds: lessons.projection.bounds(),
            engine: Device::Cpu.engine(&state)?,
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
        self.engine = device.engine(&self.state)?;
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
            *best = Some(Best { network: network.clone(), loss, step: adam.steps });
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

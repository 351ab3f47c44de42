//! `touchcal train`.

mod summary;

use std::ops::ControlFlow;
use std::panic;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use touchcal::io::result_folder::{self, ResultFile, ResultKind};
use touchcal::io::weights_file::{Teacher, WeightsFile};
use touchcal::io::{atomic, checkpoint_file, manifold_file, onnx};
use touchcal::manifold::coordinates::Metric;
use touchcal::manifold::learned::{
    Checkpoint, Device, DeviceError, Ending, Output, Progress, Training, TrainingError, TrainingOptions,
    TrainingSource, accuracy,
};
use touchcal::manifold::{NearestSample, TrainingPairs};

use crate::args::TrainArgs;
use crate::failure::{Failure, Outcome};
use crate::output;
use crate::progress::{self, Counter, Spinner};
use summary::TrainingSummary;

/// Name of the file from which an interrupted training resumes.
pub const CHECKPOINT: &str = "checkpoint.safetensors";
const WEIGHTS: &str = "weights.safetensors";
const METRICS: &str = "metrics.json";
const ONNX: &str = "weights.onnx";
/// Poses per row of the accuracy table.
const ACCURACY_POSES: u64 = 10_000;
/// Time spent on measuring the duration of a step, and steps before it that are not counted.
const TIMING: Duration = Duration::from_secs(3);
const WARM_UP_STEPS: u64 = 5;

/// Reads samples, trains, writes the network, prints its accuracy.
pub fn run(args: &TrainArgs) -> Result<Outcome, Failure> {
    progress::defer_interrupts();
    atomic::remove_left_over(&args.out);
    result_folder::check(&args.out, ResultKind::Network, &[WEIGHTS, METRICS, ONNX], &[])?;
    probe(args.device.into()).map_err(TrainingError::from)?;
    let checkpoint = args.out.join(CHECKPOINT);
    let resumed = match (args.resume, checkpoint.exists()) {
        (true, _) => Some(checkpoint_file::read_file(&checkpoint)?),
        (false, true) => {
            let advice = "resume it (--resume), remove it, or choose another --out";
            return Err(Failure::Setup(format!("{} exists: {advice}", checkpoint.display())));
        }
        (false, false) => None,
    };
    let (samples, thinned_in, input) = manifold_file::read_samples(&args.manifold)?;
    let (state, pairs, metric) = match resumed {
        None => {
            let given = args.mm_per_deg.map(|mm| Metric { metres_per_radian: mm * 1e-3 / 1f64.to_radians() });
            (None, pairs(args), given.or(thinned_in).unwrap_or(Metric::MILLIMETRE_PER_DEGREE))
        }
        Some(file) if file.teacher.manifold.sha256 == input.sha256 => {
            let (pairs, metric) = (file.teacher.pairs(), file.checkpoint.scaling.metric);
            (Some(file.checkpoint), pairs, metric)
        }
        Some(file) => {
            let learned = format!("the manifold of {}, SHA-256 {}", checkpoint.display(), file.teacher.manifold.sha256);
            return Err(Failure::Setup(format!("{}: expected {learned}, found {}", input.path, input.sha256)));
        }
    };
    let projection = NearestSample::new(samples, metric);
    let teacher = Teacher {
        manifold: input.clone(),
        samples: projection.samples().len() as u64,
        bounds: projection.samples().bounds(),
        offsets: pairs.bounds,
        seed: pairs.seed,
    };
    let lessons = TrainingSource { projection: &projection, pairs };
    let training = begin(args, state, &lessons)?;
    let session = Session { args, checkpoint, teacher, lessons };
    session.train(training)
}

/// Tests the device before labels are computed. A driver's panic becomes an error, without its
/// backtrace.
fn probe(device: Device) -> Result<(), DeviceError> {
    let hook = panic::take_hook();
    panic::set_hook(Box::new(|_| {}));
    let result = touchcal::manifold::learned::probe(device);
    panic::set_hook(hook);
    result
}

fn pairs(args: &TrainArgs) -> TrainingPairs {
    let (place, turn) = (args.offset_mm * 1e-3, args.offset_deg.to_radians());
    TrainingPairs { bounds: [place, place, place, turn, turn, turn], seed: args.seed }
}

fn begin(args: &TrainArgs, state: Option<Checkpoint>, lessons: &TrainingSource<'_>) -> Result<Training, Failure> {
    let spinner = Spinner::new("Labelling pairs");
    spinner.run();
    if let Some(state) = state {
        return Ok(Training::resume(state, lessons)?.on(args.device.into())?);
    }
    let mut options = TrainingOptions {
        hidden: vec![args.width; args.depth],
        output: if args.correction { Output::Correction } else { Output::Pose },
        batch: args.batch,
        steps: args.steps,
        rate: args.learning_rate,
        pairs: args.pairs,
        patience: args.patience,
        seed: args.seed,
        ..TrainingOptions::default()
    };
    if let Some(minutes) = args.minutes {
        options.steps = steps_in(minutes, &options, lessons, args.device.into())?;
    }
    Ok(Training::start(options, lessons)?.on(args.device.into())?)
}

/// Number of steps that take this many minutes, measured on some steps.
fn steps_in(
    minutes: f64,
    options: &TrainingOptions,
    lessons: &TrainingSource<'_>,
    device: Device,
) -> Result<u64, TrainingError> {
    let few = TrainingOptions { pairs: options.batch as u64, held_out: 1, steps: u64::MAX, ..options.clone() };
    let mut start = Instant::now();
    let mut counted = 0;
    Training::start(few, lessons)?.on(device)?.run(&mut |progress, _| {
        if progress.step == WARM_UP_STEPS {
            start = Instant::now();
        }
        counted = progress.step.saturating_sub(WARM_UP_STEPS);
        let enough = counted > 0 && start.elapsed() >= TIMING;
        if enough || progress::interrupted() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    })?;
    let each = start.elapsed().as_secs_f64() / counted.max(1) as f64;
    Ok((60.0 * minutes / each).ceil().max(1.0) as u64)
}

/// A training with progress and checkpoints.
struct Session<'a> {
    args: &'a TrainArgs,
    checkpoint: PathBuf,
    teacher: Teacher,
    lessons: TrainingSource<'a>,
}

impl Session<'_> {
    fn train(&self, mut training: Training) -> Result<Outcome, Failure> {
        let start = Instant::now();
        let ending = self.run(&mut training)?;
        if ending == Ending::Interrupted {
            self.save(training.state())?;
            return Err(Failure::TrainingInterrupted {
                step: training.state().adam.steps,
                checkpoint: self.checkpoint.display().to_string(),
                command: self.command(),
            });
        }
        let weights = self.weights(&training)?;
        let rows = accuracy(&weights.projection, &self.lessons, ACCURACY_POSES);
        let summary =
            TrainingSummary { weights: &weights, ending, rows: &rows, seconds: start.elapsed().as_secs_f64() };
        let mut files = vec![ResultFile::new(WEIGHTS, weights.to_bytes()?), ResultFile::new(METRICS, summary.json()?)];
        let mut names = vec![WEIGHTS, METRICS];
        if self.args.onnx {
            files.push(ResultFile::new(ONNX, onnx::to_bytes(&weights.projection, &summary.properties())));
            names.push(ONNX);
        }
        result_folder::write(&self.args.out, ResultKind::Network, &files, &[])?;
        let written: Vec<PathBuf> = names.iter().map(|name| self.args.out.join(name)).collect();
        // The results that it protected are written.
        if self.checkpoint.exists() {
            atomic::remove(&self.checkpoint)?;
        }
        output::print(&if self.args.json { summary.json()? } else { summary.text(&written) })?;
        Ok(Outcome::Done)
    }

    fn run(&self, training: &mut Training) -> Result<Ending, Failure> {
        let state = training.state();
        let length = state.scaling.distance(1.0).powi(2);
        let line = Counter::new("Training", state.adam.steps, state.options.steps);
        let every = Duration::from_secs_f64(self.args.checkpoint_seconds);
        let mut saved = Instant::now();
        let mut failed = None;
        let ending = training.run(&mut |progress: &Progress, state| {
            let millimetres = |loss: f64| 1e3 * (length * loss).sqrt();
            line.set(progress.step);
            if let Some(held_out) = progress.held_out.map(millimetres) {
                // Root mean squares, of the batch and of the held-out pairs.
                line.message(format!(", error {:.3} mm, held out {held_out:.3} mm", millimetres(progress.loss)));
            }
            if saved.elapsed() >= every {
                failed = self.save(state).err();
                saved = Instant::now();
            }
            if failed.is_some() || progress::interrupted() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        })?;
        failed.map_or(Ok(ending), Err)
    }

    fn save(&self, state: &Checkpoint) -> Result<(), Failure> {
        Ok(atomic::write(&self.checkpoint, &checkpoint_file::to_bytes(state, &self.teacher)?)?)
    }

    fn weights(&self, training: &Training) -> Result<WeightsFile, Failure> {
        let state = training.state();
        Ok(WeightsFile {
            projection: training.learned().map_err(TrainingError::from)?,
            options: state.options.clone(),
            teacher: self.teacher.clone(),
            step: state.best.as_ref().map_or(state.adam.steps, |best| best.step),
            loss: state.best.as_ref().map(|best| best.loss),
        })
    }

    /// The command that resumes from the checkpoint.
    fn command(&self) -> String {
        let shown = |path: &Path| path.display().to_string();
        let onnx = if self.args.onnx { " --onnx" } else { "" };
        let device = match self.args.device.into() {
            Device::Cpu => String::new(),
            other => format!(" --device {}", Device::name(other)),
        };
        format!(
            "touchcal train --manifold {} --out {}{onnx}{device} --resume",
            shown(&self.args.manifold),
            shown(&self.args.out)
        )
    }
}

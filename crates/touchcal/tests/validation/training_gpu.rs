//! Training on a GPU beside the processor's engine: the same steps but for rounding, and all that
//! training does besides.

use std::ops::ControlFlow;

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use touchcal::io::Input;
use touchcal::io::checkpoint_file;
use touchcal::io::weights_file::{Teacher, WeightsFile};
use touchcal::manifold::coordinates::{Coordinates, Metric};
use touchcal::manifold::learned::{
    Checkpoint, Device, Ending, Layer, Output, Training, TrainingError, TrainingOptions, TrainingSource,
};
use touchcal::manifold::{NearestSample, PoseSamples, Projection, TrainingPairs};

/// Those of this build. Each must be there where this test runs.
const DEVICES: &[Device] = &[
    #[cfg(feature = "cuda")]
    Device::Cuda,
    #[cfg(feature = "wgpu")]
    Device::Wgpu,
];

/// Samples of a line: place anywhere up to 20 mm deep, all else zero.
fn line() -> NearestSample {
    let mut random = Pcg64::seed_from_u64(1);
    let each = (0..2000).map(|_| -> Coordinates { [0.0, 0.0, random.random_range(-0.02..=0.0), 0.0, 0.0, 0.0] });
    NearestSample::new(PoseSamples::new(each.collect()).unwrap(), Metric::MILLIMETRE_PER_DEGREE)
}

fn options() -> TrainingOptions {
    TrainingOptions {
        hidden: vec![48, 40],
        output: Output::Pose,
        batch: 300,
        steps: 200,
        rate: 1e-3,
        pairs: 6000,
        held_out: 500,
        check_every: 50,
        patience: 0,
        seed: 3,
    }
}

fn teacher() -> Teacher {
    Teacher {
        manifold: Input { path: "m.safetensors".to_owned(), sha256: "0123".to_owned(), is_log: false },
        samples: 2000,
        bounds: line().bounds(),
        offsets: TrainingPairs::new(1).bounds,
        seed: 1,
    }
}

/// Losses of all steps and looks, and where they end.
struct Run {
    losses: Vec<f64>,
    looks: Vec<f64>,
    state: Checkpoint,
}

fn run(mut training: Training) -> Run {
    let (mut losses, mut looks) = (Vec::new(), Vec::new());
    let ending = training.run(&mut |progress, _| {
        losses.push(progress.loss);
        looks.extend(progress.held_out);
        ControlFlow::Continue(())
    });
    assert_eq!(ending, Ok(Ending::AllSteps));
    Run { losses, looks, state: training.state().clone() }
}

/// Relative rounding of the numbers that a device multiplies. On CUDA burn picks the fastest
/// kernel, tensor cores with ten bits of mantissa too.
fn rounding(device: Device) -> f64 {
    if device == Device::Cuda { 2f64.powi(-11) } else { 2f64.powi(-24) }
}

/// Roundings by which sums of a few dozen products differ in another order, and what 200 steps make
/// of them; on a software Vulkan 2 and 13.
const FIRST: f64 = 20.0;
const LATER: f64 = 200.0;

/// Norm of the differences of some layers' numbers, relative to that of the numbers.
fn apart(a: &[Layer], b: &[Layer]) -> f64 {
    let numbers = |layers: &[Layer]| -> Vec<f64> {
        layers.iter().flat_map(|l| l.weights().iter().chain(l.bias())).map(|w| f64::from(*w)).collect()
    };
    let (a, b) = (numbers(a), numbers(b));
    assert_eq!(a.len(), b.len());
    let norm = |each: &mut dyn Iterator<Item = f64>| each.map(|x| x * x).sum::<f64>().sqrt();
    norm(&mut a.iter().zip(&b).map(|(a, b)| a - b)) / norm(&mut a.iter().copied())
}

#[test]
fn steps_are_those_of_the_processor() {
    let projection = line();
    let lessons = TrainingSource { projection: &projection, pairs: TrainingPairs::new(1) };
    for &device in DEVICES {
        let here = run(Training::start(options(), &lessons).unwrap());
        let there = run(Training::start(options(), &lessons).unwrap().on(device).unwrap());
        let relative = |(a, b): (&f64, &f64)| (a - b).abs() / a;
        let first = relative((&here.losses[0], &there.losses[0]));
        let losses = here.losses.iter().zip(&there.losses).map(relative).fold(0.0, f64::max);
        let looks = here.looks.iter().zip(&there.looks).map(relative).fold(0.0, f64::max);
        let weights = apart(here.state.network.layers(), there.state.network.layers());
        let means = apart(&here.state.adam.first, &there.state.adam.first);
        let squares = apart(&here.state.adam.second, &there.state.adam.second);
        println!("{device}: {first:.1e} {losses:.1e} {looks:.1e} {weights:.1e} {means:.1e} {squares:.1e}");
        assert!(first < FIRST * rounding(device), "{device}: {first:e}");
        for apart in [losses, looks, weights, means, squares] {
            assert!(apart < LATER * rounding(device), "{device}: {apart:e}");
        }
    }
}

#[test]
fn a_checkpoint_goes_on_there_and_here() {
    let projection = line();
    let lessons = TrainingSource { projection: &projection, pairs: TrainingPairs::new(1) };
    for &device in DEVICES {
        let mut training = Training::start(options(), &lessons).unwrap().on(device).unwrap();
        let ending = training.run(&mut |progress, state| {
            // What is shown in between is where the last look was, ...
            assert_eq!(state.adam.steps, progress.step / 50 * 50);
            if progress.step == 77 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        assert_eq!(ending, Ok(Ending::Interrupted));
        // ... and in the end all steps are there.
        assert_eq!(training.state().adam.steps, 77);
        let bytes = checkpoint_file::to_bytes(training.state(), &teacher()).unwrap();
        let read = || checkpoint_file::from_bytes(&bytes, "c.safetensors").unwrap().checkpoint;
        assert!(read() == *training.state());

        let whole = run(Training::start(options(), &lessons).unwrap().on(device).unwrap());
        let there = run(Training::resume(read(), &lessons).unwrap().on(device).unwrap());
        let here = run(Training::resume(read(), &lessons).unwrap());
        for gone_on in [there, here] {
            assert_eq!((gone_on.losses.len(), gone_on.looks.len(), gone_on.state.adam.steps), (123, 3, 200));
            let weights = apart(whole.state.network.layers(), gone_on.state.network.layers());
            println!("{device}, gone on: {weights:.1e}");
            assert!(weights < LATER * rounding(device), "{device}: {weights:e}");
        }
    }
}

#[test]
fn the_weights_file_is_the_same() {
    let projection = line();
    let lessons = TrainingSource { projection: &projection, pairs: TrainingPairs::new(1) };
    for &device in DEVICES {
        let mut training = Training::start(options(), &lessons).unwrap().on(device).unwrap();
        training.run(&mut |_, _| ControlFlow::Continue(())).unwrap();
        let best = training.state().best.clone().unwrap();
        let file = WeightsFile {
            projection: training.learned().unwrap(),
            options: options(),
            teacher: teacher(),
            step: best.step,
            loss: Some(best.loss),
        };
        let read = WeightsFile::from_bytes(&file.to_bytes().unwrap(), "w.safetensors").unwrap();
        assert!(read == file && *read.projection.network() == best.network);
    }
}

#[test]
fn training_there_ends_as_here() {
    let projection = line();
    let lessons = TrainingSource { projection: &projection, pairs: TrainingPairs::new(1) };
    for &device in DEVICES {
        // So high a rate that a loss soon found is not reached again.
        let restless = TrainingOptions { rate: 0.3, steps: 100_000, patience: 4, check_every: 5, ..options() };
        let mut training = Training::start(restless, &lessons).unwrap().on(device).unwrap();
        assert_eq!(training.run(&mut |_, _| ControlFlow::Continue(())), Ok(Ending::NoGain));
        let state = training.state();
        assert_eq!(state.adam.steps, state.best.as_ref().unwrap().step + 20);

        let wild = TrainingOptions { rate: 1e30, ..options() };
        let mut training = Training::start(wild, &lessons).unwrap().on(device).unwrap();
        let ending = training.run(&mut |_, _| ControlFlow::Continue(()));
        assert!(matches!(ending, Err(TrainingError::Diverged { .. })), "{ending:?}");
    }
}

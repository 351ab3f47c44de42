//! Learning a projection: it gets better, is the same for every number of threads, and goes on from
//! a checkpoint as if never interrupted.

use std::ops::ControlFlow;

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use touchcal::manifold::coordinates::{Coordinates, Metric};
use touchcal::manifold::learned::{
    Checkpoint, Ending, Output, Training, TrainingError, TrainingOptions, TrainingSource, accuracy,
};
use touchcal::manifold::{NearestSample, PoseSamples, Projection, TrainingPairs};

/// Samples of a line: place anywhere up to 20 mm deep, all else zero.
fn line() -> NearestSample {
    let mut random = Pcg64::seed_from_u64(1);
    let each = (0..2000).map(|_| -> Coordinates { [0.0, 0.0, random.random_range(-0.02..=0.0), 0.0, 0.0, 0.0] });
    NearestSample::new(PoseSamples::new(each.collect()).unwrap(), Metric::MILLIMETRE_PER_DEGREE)
}

fn options(output: Output) -> TrainingOptions {
    TrainingOptions {
        hidden: vec![48, 48],
        output,
        batch: 300,
        steps: 600,
        rate: 5e-3,
        pairs: 20_000,
        held_out: 500,
        check_every: 50,
        patience: 0,
        seed: 3,
    }
}

fn finish(mut training: Training) -> Checkpoint {
    assert_eq!(training.run(&mut |_, _| ControlFlow::Continue(())), Ok(Ending::AllSteps));
    training.state().clone()
}

#[test]
fn a_line_is_learned_as_pose_and_as_correction() {
    let projection = line();
    let lessons = TrainingSource { projection: &projection, pairs: TrainingPairs::new(1) };
    for output in [Output::Pose, Output::Correction] {
        let mut training = Training::start(options(output), &lessons).unwrap();
        let (mut first, mut looks) = (None, Vec::new());
        let ending = training.run(&mut |progress, state| {
            first.get_or_insert(progress.loss);
            looks.extend(progress.held_out);
            assert_eq!(state.adam.steps, progress.step);
            ControlFlow::Continue(())
        });
        assert_eq!(ending, Ok(Ending::AllSteps));
        assert_eq!(looks.len(), 12);
        let best = training.state().best.as_ref().unwrap();
        assert_eq!(best.loss, looks.iter().copied().fold(f64::INFINITY, f64::min));
        assert!(best.loss < 0.02 * first.unwrap(), "{} of {first:?}", best.loss);
        let learned = training.learned().unwrap();
        assert_eq!(learned.bounds(), projection.bounds());
        let rows = accuracy(&learned, &lessons, 500);
        let inside = &rows[3];
        assert!((inside.offset[0] - 0.01).abs() < 1e-12 && inside.poses == 500);
        // Offsets of 5 mm and 5° on average come down to less than a millimetre and a degree.
        assert!(inside.before.place.mean > 6e-3 && inside.to_target.place.mean < 1e-3, "{inside:?}");
        assert!(inside.to_target.turn.mean < 1f64.to_radians(), "{inside:?}");
        assert!(inside.to_manifold.place.mean <= inside.to_target.place.mean);
        assert!(rows.windows(2).all(|pair| pair[0].offset[0] < pair[1].offset[0]));
    }
}

#[test]
fn the_same_bits_whatever_the_number_of_threads() {
    let projection = line();
    let lessons = TrainingSource { projection: &projection, pairs: TrainingPairs::new(1) };
    let learned = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let few = TrainingOptions { steps: 40, hidden: vec![150, 48], ..options(Output::Pose) };
        pool.install(|| finish(Training::start(few, &lessons).unwrap()))
    };
    let one = learned(1);
    assert!(one == learned(2) && one == learned(5));
}

#[test]
fn going_on_is_never_having_stopped() {
    let projection = line();
    let lessons = TrainingSource { projection: &projection, pairs: TrainingPairs::new(1) };
    let few = TrainingOptions { steps: 130, ..options(Output::Pose) };
    let whole = finish(Training::start(few.clone(), &lessons).unwrap());
    for stop in [1, 50, 77, 129, 130] {
        let mut training = Training::start(few.clone(), &lessons).unwrap();
        let ending = training.run(&mut |progress, _| {
            if progress.step == stop { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        assert_eq!(ending, Ok(Ending::Interrupted));
        let state = training.state().clone();
        assert!(finish(Training::resume(state, &lessons).unwrap()) == whole, "stopped after {stop}");
    }
}

#[test]
fn training_stops_when_nothing_gets_better() {
    let projection = line();
    let lessons = TrainingSource { projection: &projection, pairs: TrainingPairs::new(1) };
    // So high a rate that a loss soon found is not reached again.
    let restless = TrainingOptions { rate: 0.3, steps: 100_000, patience: 4, check_every: 5, ..options(Output::Pose) };
    let mut training = Training::start(restless, &lessons).unwrap();
    assert_eq!(training.run(&mut |_, _| ControlFlow::Continue(())), Ok(Ending::NoGain));
    let state = training.state();
    assert_eq!(state.adam.steps, state.best.as_ref().unwrap().step + 20);
}

#[test]
fn what_leaves_nothing_to_do_is_refused() {
    let projection = line();
    let lessons = TrainingSource { projection: &projection, pairs: TrainingPairs::new(1) };
    let message = |options| Training::start(options, &lessons).unwrap_err().to_string();
    let usual = || options(Output::Pose);
    assert_eq!(message(TrainingOptions { batch: 0, ..usual() }), "expected the batch above zero, found 0");
    assert!(message(TrainingOptions { rate: f64::NAN, ..usual() }).contains("learning rate"));
    assert!(message(TrainingOptions { hidden: vec![8, 0], ..usual() }).contains("inputs and outputs"));
    let mut wild = Training::start(TrainingOptions { rate: 1e30, ..usual() }, &lessons).unwrap();
    let ending = wild.run(&mut |_, _| ControlFlow::Continue(()));
    assert!(matches!(ending, Err(TrainingError::Diverged { .. })), "{ending:?}");
}

#[test]
fn the_rate_rises_and_falls() {
    let options = TrainingOptions { steps: 1000, rate: 1.0, ..options(Output::Pose) };
    let rates: Vec<f64> = (0..1000).map(|k| options.rate_at(k)).collect();
    assert!((rates[0] - 0.05).abs() < 1e-12 && rates[19] > 0.999);
    assert!(rates[..20].is_sorted() && rates[20..].is_sorted_by(|a, b| a >= b));
    assert!((rates[999] - 1e-3).abs() < 1e-12 && (rates[509] - 0.5).abs() < 0.01);
}

//! How long training steps and projections with gradients take, for comparison with other programs
//! in the same session.
//!
//! `cargo bench -p touchcal --bench network` prints medians. With `-- --serve` it reads names of
//! cases from stdin and answers each with seconds per repetition: `network_pytorch.py` alternates
//! so between this and PyTorch. Threads: `RAYON_NUM_THREADS`. With `--features cuda` and `-- cuda`,
//! or `wgpu`, training runs on a GPU; projections, which never do, are left out.
#![allow(
    missing_docs,
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::print_stdout,
    reason = "a bench ends by panicking"
)]

use std::collections::HashMap;
use std::io::Write;
use std::ops::ControlFlow;
use std::time::Instant;

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use touchcal::manifold::coordinates::{Coordinates, Metric};
use touchcal::manifold::learned::{Device, Training, TrainingOptions, TrainingSource};
use touchcal::manifold::{LearnedProjection, NearestSample, PoseSamples, Projection, TrainingPairs};

/// Name, width, batch of a training step or none for a projection with gradient, repetitions timed
/// together on the processor; on a GPU twenty times as many.
const CASES: [(&str, usize, Option<usize>, u64); 4] = [
    ("train 4x512 batch 1024", 512, Some(1024), 10),
    ("train 4x4096 batch 256", 4096, Some(256), 1),
    ("project 3000 with gradient 4x512", 512, None, 5),
    ("project 3000 with gradient 4x4096", 4096, None, 1),
];
const ROUNDS: usize = 7;

/// One case, ready to be timed.
enum Case {
    Train(Box<Training>),
    Project(Box<LearnedProjection>, Vec<Coordinates>),
}

impl Case {
    fn new(width: usize, batch: Option<usize>, device: Device) -> Case {
        let mut random = Pcg64::seed_from_u64(1);
        let mut cloud = |count: usize| -> Vec<Coordinates> {
            (0..count).map(|_| std::array::from_fn(|_| random.random_range(-0.02..=0.02))).collect()
        };
        let samples = PoseSamples::new(cloud(1000)).unwrap();
        let projection = NearestSample::new(samples, Metric::MILLIMETRE_PER_DEGREE);
        let lessons = TrainingSource { projection: &projection, pairs: TrainingPairs::new(1) };
        let options = TrainingOptions {
            hidden: vec![width; 4],
            batch: batch.unwrap_or(1),
            pairs: 16 * batch.unwrap_or(1) as u64,
            held_out: 1,
            steps: u64::MAX,
            check_every: u64::MAX,
            ..TrainingOptions::default()
        };
        let training = Training::start(options, &lessons).unwrap();
        match batch {
            Some(_) => Case::Train(Box::new(training.on(device).unwrap())),
            None => Case::Project(Box::new(training.learned().unwrap()), cloud(3000)),
        }
    }

    /// Seconds of one of `count` repetitions; of training steps on a GPU without the weights' way
    /// back to the processor.
    fn time(&mut self, count: u64) -> f64 {
        let start = Instant::now();
        match self {
            Case::Train(training) => {
                let (mut done, mut seconds) = (0, 0.0);
                let mut enough = |_: &_, _: &_| {
                    done += 1;
                    seconds = start.elapsed().as_secs_f64();
                    if done == count { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
                };
                training.run(&mut enough).unwrap();
                return seconds / count as f64;
            }
            Case::Project(projection, poses) => {
                let mut pulled = Vec::new();
                for _ in 0..count {
                    projection.pull_back(poses, &mut |_, onto| onto.map(f64::signum), &mut pulled);
                }
            }
        }
        start.elapsed().as_secs_f64() / count as f64
    }
}

fn main() {
    let named = |device: &Device| std::env::args().any(|argument| argument == device.name());
    let device = Device::ALL.into_iter().find(named).unwrap_or_default();
    if std::env::args().any(|argument| argument == "--serve") {
        return serve(device);
    }
    for (name, width, batch, count) in CASES {
        if device != Device::Cpu && batch.is_none() {
            continue;
        }
        let mut case = Case::new(width, batch, device);
        let count = repetitions(count, device);
        case.time(count);
        let mut seconds: Vec<f64> = (0..ROUNDS).map(|_| case.time(count)).collect();
        seconds.sort_by(f64::total_cmp);
        println!("{name}: {:.1} ms", 1e3 * seconds[ROUNDS / 2]);
    }
}

fn repetitions(count: u64, device: Device) -> u64 {
    if device == Device::Cpu { count } else { 20 * count }
}

fn serve(device: Device) {
    let mut ready: HashMap<String, (Case, u64)> = HashMap::new();
    for line in std::io::stdin().lines() {
        let name = line.unwrap();
        let (case, count) = ready.entry(name.clone()).or_insert_with(|| {
            let &(_, width, batch, count) = CASES.iter().find(|case| case.0 == name).expect("the name of a case");
            (Case::new(width, batch, device), repetitions(count, device))
        });
        println!("{}", case.time(*count));
        std::io::stdout().flush().unwrap();
    }
}

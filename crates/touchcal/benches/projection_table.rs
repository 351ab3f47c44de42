//! The claim of Negi et al. (2025, arXiv 2505.19215), that a network projects 95 times faster and
//! 18 % more accurately than a search for nearest samples, tested: poses a second and accuracy of
//! each projection, in one table. `cargo bench -p touchcal --bench projection_table -- [WEIGHTS]`,
//! with weights from `touchcal train`; without them, no row of the network.
//!
//! Speed: poses projected a second on one core, median of several runs, the methods in turn. Off
//! the manifold: median |gap| (mm) of the projections, by exact geometry. Farther: mean distance
//! from poses to their projections over that to the nearest samples. Hole: error of a hole's place
//! (mm, degrees) found from 200 contacts of a recorded insertion with the true arm, from places up
//! to 3 mm and 3° off, median.
#![allow(
    missing_docs,
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::print_stdout,
    reason = "a bench prints, or ends by panicking"
)]

#[path = "../tests/support/mod.rs"]
mod support;

use std::fmt::{Debug, Formatter};
use std::ops::ControlFlow;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use kiddo::ImmutableKdTree;
use kiddo::dist::SquaredEuclidean;
use nalgebra::{Matrix6, Vector6};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use support::data;
use touchcal::contact::{ContactLog, Source};
use touchcal::estimate::{Loss, Method, Noise, PlacePrior, Problem, calibrate};
use touchcal::experiment::{Search, Trial};
use touchcal::geometry::{GapQuery, Parts, PrismPair, SignedGap, visit_features_within};
use touchcal::io::urdf::{self, Ends};
use touchcal::io::weights_file::WeightsFile;
use touchcal::io::{pose_file, trial_folder};
use touchcal::manifold::coordinates::{Coordinates, Metric, coordinates, pose};
use touchcal::manifold::{
    ContactManifold, NearestSample, PegInHole, PoseSamples, Projected, Projection, TrainingPairs,
};
use touchcal::parameter::ParameterId;
use touchcal::se3::{self, Twist};
use touchcal::sim::Preset;

/// Noise of recorded gaps, and of projections (learned), as `touchcal experiment table1` takes it.
const GAP_NOISE: Noise = Noise { encoder: 3.5e-5, contact: 0.02e-3, is_estimated: false };
const PROJECTION_NOISE: Noise = Noise { encoder: 0.0, contact: 1e-3, is_estimated: true };
/// Newton's method ends here (m), or after this many steps.
const TOUCHING: f64 = 1e-7;
const NEWTON_STEPS: usize = 50;
/// What the length of a Gauss–Newton step counts beside the walls.
const SHORT: f64 = 1e-3;
/// Poses that no network learned from.
const SEED: u64 = 99;
const METRIC: Metric = Metric::MILLIMETRE_PER_DEGREE;
/// Poses projected for each figure.
const QUERIES: u64 = 4000;
/// Timed runs of each method.
const RUNS: usize = 5;
/// How many times the paper's ±10 mm and ±10° the poses are off.
const OFFSETS: [f64; 3] = [0.1, 1.0, 3.0];
/// Contacts from which the hole is found, and first guesses of its place.
const CONTACTS: usize = 200;
const GUESSES: u64 = 20;
/// How far the guesses are off: each component up to this (m, rad).
const GUESS: (f64, f64) = (3e-3, 3.0 * std::f64::consts::PI / 180.0);

/// A projection of one pose at a time, constant from pose to pose.
struct OneByOne<F> {
    name: &'static str,
    bounds: [(f64, f64); 6],
    onto: F,
}

impl<F> Debug for OneByOne<F> {
    fn fmt(&self, to: &mut Formatter<'_>) -> std::fmt::Result {
        to.write_str(self.name)
    }
}

impl<F: Fn(&Coordinates) -> Coordinates + Send + Sync + 'static> Projection for OneByOne<F> {
    fn name(&self) -> &'static str {
        self.name
    }

    fn metric(&self) -> Metric {
        METRIC
    }

    fn bounds(&self) -> [(f64, f64); 6] {
        self.bounds
    }

    fn project(&self, poses: &[Coordinates], projected: &mut Vec<Coordinates>) {
        projected.clear();
        projected.extend(poses.iter().map(&self.onto));
    }

    fn linearize(&self, poses: &[Coordinates], projected: &mut Vec<Coordinates>, changes: &mut Vec<Matrix6<f64>>) {
        self.project(poses, projected);
        *changes = vec![Matrix6::zeros(); poses.len()];
    }

    fn pull_back(
        &self,
        _: &[Coordinates],
        _: &mut dyn FnMut(usize, &Coordinates) -> Coordinates,
        _: &mut Vec<Coordinates>,
    ) {
        unreachable!("nothing descends here")
    }
}

/// The nearest sample within the leaf of a k-d tree that the pose falls into: no search of other
/// leaves.
fn same_leaf(samples: PoseSamples) -> Arc<dyn Projection> {
    let bounds = samples.bounds();
    let points: Vec<[f64; 6]> = samples.coordinates().iter().map(|sample| METRIC.point(sample)).collect();
    let tree: ImmutableKdTree<f64, 6> = ImmutableKdTree::new_from_slice(&points).unwrap();
    let onto = move |pose: &Coordinates| {
        let near = tree.query(&METRIC.point(pose)).nearest_one::<SquaredEuclidean<f64>>().approx().execute();
        samples.coordinates()[near.item as usize]
    };
    Arc::new(OneByOne { name: "nearest in one leaf", bounds, onto })
}

/// Every sample looked at.
fn brute_force(samples: PoseSamples) -> Arc<dyn Projection> {
    let bounds = samples.bounds();
    let points: Vec<Vector6<f64>> = samples.coordinates().iter().map(|sample| METRIC.point(sample).into()).collect();
    let onto = move |pose: &Coordinates| {
        let from = Vector6::from(METRIC.point(pose));
        let squares = points.iter().map(|point| (point - from).norm_squared());
        let least = squares.enumerate().min_by(|(_, a), (_, b)| a.total_cmp(b)).unwrap();
        samples.coordinates()[least.0]
    };
    Arc::new(OneByOne { name: "every sample looked at", bounds, onto })
}

/// Gauss–Newton steps, short in the metric: out of all walls that the peg is in, or onto the wall
/// nearest to it.
fn exact(parts: PrismPair, bounds: [(f64, f64); 6]) -> Arc<dyn Projection> {
    let turn = METRIC.metres_per_radian.powi(2);
    let short = Matrix6::from_diagonal(&Vector6::new(1.0, 1.0, 1.0, turn, turn, turn)) * SHORT;
    let onto = move |from: &Coordinates| {
        let mut at = pose(from);
        for _ in 0..NEWTON_STEPS {
            let (mut slope, mut curvature) = (Twist::zeros(), short);
            let mut add = |gap: &SignedGap| {
                slope += gap.gradient * gap.value;
                curvature += gap.gradient * gap.gradient.transpose();
            };
            let least = visit_features_within(&parts, &at, 0.0, |gap, _| {
                if gap.value < 0.0 {
                    add(gap)
                }
            });
            if least.value.abs() < TOUCHING {
                break;
            }
            if least.value > 0.0 {
                add(&least);
            }
            at *= se3::exp(&-curvature.cholesky().unwrap().solve(&slope));
        }
        coordinates(&at)
    };
    Arc::new(OneByOne { name: "exact geometry", bounds, onto })
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_unstable_by(f64::total_cmp);
    values[values.len() / 2]
}

fn mean(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = values.len() as f64;
    values.sum::<f64>() / count
}

/// Poses a second of each projection on one core.
fn speeds(projections: &[Arc<dyn Projection>], poses: &[Coordinates]) -> Vec<f64> {
    let one_core = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let mut onto = Vec::new();
    let mut seconds = vec![Vec::new(); projections.len()];
    for _ in 0..RUNS {
        for (projection, seconds) in projections.iter().zip(&mut seconds) {
            let start = Instant::now();
            one_core.install(|| projection.project(poses, &mut onto));
            seconds.push(start.elapsed().as_secs_f64());
        }
    }
    seconds.into_iter().map(|seconds| poses.len() as f64 / median(seconds)).collect()
}

/// Median errors (mm, degrees) and seconds of a hole's place found from contacts of the true arm,
/// begun from many guesses.
fn hole(trial: &Trial, manifold: impl Fn() -> Box<dyn ContactManifold>, noise: Noise, loss: Loss) -> [f64; 3] {
    let stride = trial.contacts.len() / CONTACTS;
    let mut contacts = ContactLog::new(trial.robot.dof());
    for i in (0..trial.contacts.len()).step_by(stride) {
        contacts.push(trial.contacts.q(i), 0, Source { file: 0, line: i as u64 + 1 });
    }
    let mut found = [Vec::new(), Vec::new(), Vec::new()];
    for seed in 0..GUESSES {
        let mut chance = Pcg64::seed_from_u64(seed);
        let off = Twist::from_fn(|k, _| {
            let most = if k < 3 { GUESS.0 } else { GUESS.1 };
            chance.random_range(-most..most)
        });
        let search = Search { method: Method::LevenbergMarquardt, noise, loss };
        let mut problem = Problem {
            robot: trial.true_robot(),
            parameters: Vec::new(),
            contacts: contacts.clone(),
            ..trial.problem(manifold(), search)
        };
        let guess = trial.base_from_hole * se3::exp(&off);
        problem.fixtures[0].base_from_fixture = Some(guess);
        problem.fixtures[0].prior = PlacePrior::Flat;
        let start = Instant::now();
        let estimate = calibrate(&problem, &mut |_| ControlFlow::Continue(()));
        found[2].push(start.elapsed().as_secs_f64());
        let mut twist = Twist::zeros();
        for each in &estimate.parameters {
            if let ParameterId::Fixture(0, k) = each.parameter.id {
                twist[k] = each.value;
            }
        }
        let error = trial.base_from_hole.inverse() * guess * se3::exp(&twist);
        found[0].push(1e3 * error.translation.vector.norm());
        found[1].push(error.rotation.angle().to_degrees());
    }
    found.map(median)
}

fn main() {
    let weights = std::env::args().skip(1).find(|argument| !argument.starts_with("--"));
    let base = data().join("mujoco_iiwa14/extrusion");
    let samples = pose_file::read_file(&base.join("offline/contact_poses.csv.gz")).unwrap().0;
    let robot = urdf::read_builtin("iiwa14", Ends::default()).unwrap().robot;
    let scenario = Preset::Paper.scenario(robot.clone()).unwrap();
    let Parts::PegInHole(parts) = &scenario.touches[0].parts else { unreachable!("the paper's experiment has a hole") };
    let parts = parts.as_ref().clone();
    let trial = trial_folder::read(&base.join("rich"), &robot).unwrap().remove(0);
    let nearest = Arc::new(NearestSample::new(samples.clone(), METRIC));
    let mut projections: Vec<Arc<dyn Projection>> = vec![
        nearest.clone(),
        Arc::new(NearestSample::new(samples.clone(), METRIC).with_neighbours(8)),
        brute_force(samples.clone()),
        same_leaf(samples),
    ];
    match weights {
        Some(path) => projections.push(Arc::new(WeightsFile::read_file(Path::new(&path)).unwrap().0.projection)),
        None => println!("no row of the network: name a weights file after `--`"),
    }
    projections.push(exact(parts.clone(), nearest.bounds()));

    println!("{:<22}{:>42}{:>42}{:>42}", "", "±1 mm, ±1°", "±10 mm, ±10°", "±30 mm, ±30°");
    print!("{:<22}", "projection");
    OFFSETS.iter().for_each(|_| print!("{:>11}{:>9}{:>12}{:>10}", "poses/s", "times", "off by mm", "farther"));
    println!("{:>12}{:>8}{:>8}", "hole mm", "deg", "s");
    let mut lines: Vec<String> = projections.iter().map(|each| format!("{:<22}", each.name())).collect();
    for times in OFFSETS {
        let (mut poses, mut targets) = (Vec::new(), Vec::new());
        let TrainingPairs { bounds, .. } = TrainingPairs::new(SEED);
        let pairs = TrainingPairs { bounds: bounds.map(|bound| bound * times), seed: SEED };
        pairs.fill(&nearest, 0..QUERIES, &mut poses, &mut targets);
        let speeds = speeds(&projections, &poses);
        for ((line, projection), speed) in lines.iter_mut().zip(&projections).zip(&speeds) {
            let mut onto = Vec::new();
            projection.project(&poses, &mut onto);
            let off = 1e3 * median(onto.iter().map(|onto| parts.gap(&pose(onto)).value.abs()).collect());
            let far =
                |onto: &[Coordinates]| mean(poses.iter().zip(onto).map(|(pose, onto)| METRIC.distance(pose, onto)));
            let farther = far(&onto) / far(&targets);
            *line += &format!("{speed:>11.0}{:>9.2}{off:>12.4}{farther:>10.3}", speed / speeds[0]);
        }
    }
    let last = projections.len() - 1;
    for (i, (line, projection)) in lines.iter().zip(&projections).enumerate() {
        let [mm, deg, seconds] = if i == last {
            hole(&trial, || Box::new(PegInHole::new(parts.clone())), GAP_NOISE, Loss::GemanMcClure(3.0))
        } else {
            hole(&trial, || Box::new(Projected(Arc::clone(projection))), PROJECTION_NOISE, Loss::Huber(1.345))
        };
        println!("{line}{mm:>12.4}{deg:>8.4}{seconds:>8.3}");
    }
}

//! How long it takes to find nearest samples among 81,000, and to make training pairs with them.
//! `cargo bench -p touchcal --bench projection`
#![allow(missing_docs, clippy::unwrap_used, clippy::expect_used, reason = "a bench ends by panicking")]

#[path = "../tests/support/mod.rs"]
mod support;

use std::hint::black_box;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use support::data;
use touchcal::io::pose_file;
use touchcal::manifold::coordinates::{Coordinates, Metric};
use touchcal::manifold::{Coverage, NearestSample, Projection, TrainingPairs};

const METRIC: Metric = Metric::MILLIMETRE_PER_DEGREE;
const QUERIES: u64 = 20_000;

/// Pairs whose offsets are `times` those of the paper.
fn pairs(times: f64) -> TrainingPairs {
    let TrainingPairs { bounds, seed } = TrainingPairs::new(1);
    TrainingPairs { bounds: bounds.map(|bound| bound * times), seed }
}

fn projection(criterion: &mut Criterion) {
    let path = data().join("mujoco_iiwa14/extrusion/offline/contact_poses.csv.gz");
    let samples = pose_file::read_file(&path).unwrap().0;
    let (mut inputs, mut targets) = (Vec::new(), Vec::new());

    let mut group = criterion.benchmark_group("81,000 samples");
    group.sample_size(10);
    group.bench_function("tree", |bench| bench.iter(|| NearestSample::new(black_box(samples.clone()), METRIC)));
    group.bench_function("thinning to 1 mm", |bench| bench.iter(|| samples.thinned(1e-3, METRIC).unwrap().len()));
    group.bench_function("coverage", |bench| bench.iter(|| Coverage::of(&samples, METRIC).count));

    let nearest = NearestSample::new(samples, METRIC);
    group.throughput(Throughput::Elements(QUERIES));
    let one_core = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    for (times, name) in [(0.0, "on a sample"), (0.1, "±1 mm, ±1°"), (1.0, "±10 mm, ±10°"), (10.0, "±100 mm, ±100°")]
    {
        pairs(times).fill(&nearest, 0..QUERIES, &mut inputs, &mut targets);
        let mut onto: Vec<Coordinates> = Vec::new();
        group.bench_function(format!("nearest on one core, {name}"), |bench| {
            one_core.install(|| bench.iter(|| nearest.project(black_box(&inputs), &mut onto)));
        });
    }
    let nearest = nearest.with_neighbours(8);
    pairs(1.0).fill(&nearest, 0..QUERIES, &mut inputs, &mut targets);
    let mut onto: Vec<Coordinates> = Vec::new();
    group.bench_function("mean of 8 on one core, ±10 mm, ±10°", |bench| {
        one_core.install(|| bench.iter(|| nearest.project(black_box(&inputs), &mut onto)));
    });
    let nearest = nearest.with_neighbours(1);
    group.throughput(Throughput::Elements(1_000_000));
    group.bench_function("a million training pairs on all cores", |bench| {
        bench.iter(|| pairs(1.0).fill(&nearest, 0..1_000_000, &mut inputs, &mut targets));
    });
    group.finish();
}

criterion_group!(benches, projection);
criterion_main!(benches);

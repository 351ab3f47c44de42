//! Manifolds from samples: thinning, coverage, and the projection onto the nearest sample against a
//! search of all of them.

use nalgebra::Vector6;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use touchcal::manifold::coordinates::{Coordinates, Metric, pose};
use touchcal::manifold::{
    ContactManifold, Coverage, NearestSample, Neighbour, PoseSamples, Projected, Projection, Residual, SamplesError,
};
use touchcal::se3::{self, Twist};

const METRIC: Metric = Metric::MILLIMETRE_PER_DEGREE;

/// Poses within ± `size` (m), degrees as millimetres, about the origin turned by `yaw`; every third
/// one twice.
fn cloud(count: usize, size: f64, yaw: f64, seed: u64) -> Vec<Coordinates> {
    let mut random = Pcg64::seed_from_u64(seed);
    let mut all: Vec<Coordinates> = Vec::new();
    for i in 0..count {
        let mut next = || size * random.random_range(-1.0..=1.0);
        let place = [next(), next(), next()];
        let angles = [next(), next(), next()].map(|angle| angle / METRIC.metres_per_radian);
        let each = [place[0], place[1], place[2], angles[0], angles[1], angles[2] + yaw];
        all.push(if i % 3 == 2 { all[random.random_range(0..all.len())] } else { each });
    }
    all
}

fn brute(samples: &[Coordinates], at: &Coordinates) -> Vec<Neighbour> {
    let each = samples.iter().enumerate();
    let mut all: Vec<Neighbour> =
        each.map(|(index, sample)| Neighbour { index, distance: METRIC.distance(sample, at) }).collect();
    all.sort_by(|a, b| a.distance.total_cmp(&b.distance).then(a.index.cmp(&b.index)));
    all
}

#[test]
fn the_nearest_is_the_nearest_of_all() {
    for (count, size, yaw) in [(2, 0.01, 0.0), (17, 0.01, 0.0), (500, 0.01, 3.1), (3000, 0.02, 0.0), (400, 0.15, -3.0)]
    {
        let samples = PoseSamples::new(cloud(count, size, yaw, 1)).unwrap();
        let nearest = NearestSample::new(samples.clone(), METRIC);
        for (reach, queries) in [(0.001, 100), (0.01, 700), (0.1, 700)] {
            for (i, mut at) in cloud(queries, reach, yaw, 2).into_iter().enumerate() {
                if i % 4 == 0 {
                    at = samples.coordinates()[i % count];
                }
                let all = brute(samples.coordinates(), &at);
                let few = nearest.nearest_few(&at, 5);
                assert_eq!(nearest.nearest(&at), few.first().copied());
                assert_eq!(few.len(), 5.min(count));
                for (found, expected) in few.iter().zip(&all) {
                    let off = (found.distance - expected.distance).abs();
                    assert!(off <= 1e-15, "{found:?} {expected:?}");
                    let true_distance = METRIC.distance(&samples.coordinates()[found.index], &at);
                    assert!((found.distance - true_distance).abs() <= 1e-15);
                }
                // Of samples in the same place, the first.
                let same = samples.coordinates().iter().position(|each| each == &samples.coordinates()[few[0].index]);
                assert_eq!(same, Some(few[0].index));
            }
        }
    }
}

#[test]
fn angles_have_no_seam() {
    let turned = |yaw: f64| [0.0, 0.0, 0.0, 0.0, 0.0, yaw];
    let samples = PoseSamples::new(vec![turned(3.0), turned(-3.1), turned(0.0)]).unwrap();
    let nearest = NearestSample::new(samples.clone(), METRIC);
    for (yaw, expected) in [(3.1, 1), (-3.0, 1), (3.1 + std::f64::consts::TAU, 1), (3.05, 0), (1.6, 0), (-1.4, 2)] {
        assert_eq!(nearest.nearest(&turned(yaw)).unwrap().index, expected, "{yaw}");
    }
    let mut between = Vec::new();
    NearestSample::new(samples, METRIC).with_neighbours(2).project(&[turned(3.13), turned(-3.13)], &mut between);
    assert!(between.iter().all(|onto| onto[5].abs() > 3.0), "{between:?}");
}

#[test]
fn projecting_a_batch_is_projecting_each_whatever_the_threads() {
    let samples = PoseSamples::new(cloud(2000, 0.01, 0.0, 3)).unwrap();
    let mut poses = cloud(3000, 0.02, 0.0, 4);
    poses[7][2] = f64::NAN;
    poses[8][4] = f64::INFINITY;
    for k in [1, 4] {
        let nearest = NearestSample::new(samples.clone(), METRIC).with_neighbours(k);
        let mut all = Vec::new();
        nearest.project(&poses, &mut all);
        let mut alone = Vec::new();
        let one_thread = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        one_thread.install(|| nearest.project(&poses, &mut alone));
        let bits = |all: &[Coordinates]| all.iter().flatten().map(|value| value.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&all), bits(&alone));
        for (i, (pose, onto)) in poses.iter().zip(&all).enumerate() {
            assert_eq!(nearest.nearest(pose).is_none(), i == 7 || i == 8);
            assert_eq!(onto.iter().all(|value| value.is_nan()), i == 7 || i == 8);
            if let (1, Some(found)) = (k, nearest.nearest(pose)) {
                assert_eq!(onto, &samples.coordinates()[found.index]);
            }
        }
        let counted = nearest.nearest_of_each(&poses).iter().flatten().count();
        assert_eq!(counted, poses.len() - 2);
    }
}

#[test]
fn one_neighbour_has_no_slope_and_several_have_that_of_differences() {
    let samples = PoseSamples::new(cloud(300, 0.01, 0.0, 5)).unwrap();
    let poses = cloud(100, 0.02, 0.0, 6);
    let (mut onto, mut jacobians) = (Vec::new(), Vec::new());
    NearestSample::new(samples.clone(), METRIC).linearize(&poses, &mut onto, &mut jacobians);
    assert!(jacobians.iter().all(|jacobian| jacobian.norm() == 0.0));

    let nearest = NearestSample::new(samples.clone(), METRIC).with_neighbours(5);
    nearest.linearize(&poses, &mut onto, &mut jacobians);
    let at = |pose: &Coordinates| {
        let mut onto = Vec::new();
        nearest.project(std::slice::from_ref(pose), &mut onto);
        Vector6::from(onto[0])
    };
    let lengths = METRIC.point(&[1.0; 6]);
    for (pose, jacobian) in poses.iter().zip(&jacobians) {
        for k in 0..6 {
            let step = 1e-9 / lengths[k];
            let moved = |by: f64| std::array::from_fn(|i| if i == k { pose[i] + by } else { pose[i] });
            let slope = (at(&moved(step)) - at(&moved(-step))) / (2.0 * step);
            let off = (slope - jacobian.column(k)).component_mul(&Vector6::from(lengths)).norm() / lengths[k];
            assert!(off < 1e-4, "{pose:?} {k}: {slope} {jacobian}");
        }
    }

    let mut pulled = Vec::new();
    let y = |i: usize| -> Coordinates { std::array::from_fn(|k| (i + 7 * k) as f64 % 5.0 - 2.0) };
    let mut calls = 0;
    let mut cotangent = |i: usize, projected: &Coordinates| {
        assert_eq!((i, projected), (calls, &onto[i]));
        calls += 1;
        y(i)
    };
    nearest.pull_back(&poses, &mut cotangent, &mut pulled);
    for (i, (pulled, jacobian)) in pulled.iter().zip(&jacobians).enumerate() {
        assert_eq!(Vector6::from(*pulled), jacobian.transpose() * Vector6::from(y(i)));
    }
    nearest.project(samples.coordinates(), &mut onto);
    assert_eq!(onto, samples.coordinates());
}

#[test]
fn several_neighbours_project_without_jumps() {
    let samples = PoseSamples::new(cloud(500, 0.01, 0.0, 7)).unwrap();
    let nearest = NearestSample::new(samples, METRIC).with_neighbours(6);
    let ends = cloud(2, 0.012, 0.0, 8);
    let steps = 20_000;
    let along = |i: usize| {
        let t = i as f64 / steps as f64;
        std::array::from_fn(|k| ends[0][k] * (1.0 - t) + ends[1][k] * t)
    };
    let poses: Vec<Coordinates> = (0..=steps).map(along).collect();
    let mut onto = Vec::new();
    nearest.project(&poses, &mut onto);
    let moved = METRIC.distance(&poses[1], &poses[0]);
    let greatest = onto.windows(2).map(|pair| METRIC.distance(&pair[1], &pair[0])).fold(0.0, f64::max);
    assert!(greatest < 20.0 * moved, "{greatest} against {moved}");
}

#[test]
fn as_a_manifold_its_residual_is_the_way_to_the_sample() {
    let samples = PoseSamples::new(cloud(300, 0.01, 0.0, 9)).unwrap();
    let nearest = NearestSample::new(samples.clone(), METRIC);
    let at = pose(&cloud(1, 0.02, 0.0, 10)[0]);
    let found = nearest.nearest(&touchcal::manifold::coordinates::coordinates(&at)).unwrap();
    let manifold = Projected(std::sync::Arc::new(nearest));
    let residual = |twist: &Twist| {
        let mut rows = Residual::new();
        manifold.residual(&(at * se3::exp(twist)), 0.0, &mut rows);
        rows
    };
    let rows = residual(&Twist::zeros());
    assert!((Vector6::from_row_slice(rows.values()).norm() - found.distance).abs() < 1e-15);
    for k in 0..6 {
        let mut step = Twist::zeros();
        step[k] = 1e-7;
        for (i, row) in rows.jacobian().iter().enumerate() {
            let slope = (residual(&step).values()[i] - residual(&-step).values()[i]) / 2e-7;
            assert!((slope - row[k]).abs() < 1e-7);
        }
    }
}

#[test]
fn thinning_keeps_the_spacing_and_covers() {
    let samples = PoseSamples::new(cloud(1500, 0.01, 3.1, 11)).unwrap();
    for spacing in [1e-9, 0.002, 0.01] {
        let kept = samples.thinned(spacing, METRIC).unwrap();
        // As defined, one by one.
        let mut expected: Vec<Coordinates> = Vec::new();
        for each in samples.coordinates() {
            if expected.iter().all(|other| METRIC.distance(each, other) >= spacing) {
                expected.push(*each);
            }
        }
        assert_eq!(kept.coordinates(), expected);
    }
    assert_eq!(samples.thinned(0.0, METRIC).unwrap(), samples);
    assert_eq!(samples.thinned(1.0, METRIC), Err(SamplesError::TooFew { distinct: 1, count: 1 }));
}

#[test]
fn what_is_no_manifold_is_refused() {
    let message = |poses: Vec<Coordinates>| PoseSamples::new(poses).unwrap_err().to_string();
    assert_eq!(message(Vec::new()), "expected at least two different poses, found 0 in 0");
    assert_eq!(message(vec![[0.1; 6]]), "expected at least two different poses, found 1 in 1");
    assert_eq!(message(vec![[0.1; 6]; 9]), "expected at least two different poses, found 1 in 9");
    assert_eq!(message(vec![[0.0; 6], [f64::NAN; 6]]), "expected finite coordinates, found NaN in pose 1");
    let mut far = [0.0; 6];
    far[4] = f64::NEG_INFINITY;
    assert_eq!(message(vec![far]), "expected finite coordinates, found -inf in pose 0");
}

#[test]
fn coverage_says_how_densely_and_how_completely() {
    // A line of samples a millimetre apart: every other of a tenth's samples is up to a tenth's
    // length away.
    let line = |i: usize| [1e-3 * i as f64, 0.0, 0.0, 0.0, 0.0, 0.0];
    let coverage = Coverage::of(&PoseSamples::new((0..1001).map(line).collect()).unwrap(), METRIC);
    assert_eq!(coverage.count, 1001);
    let x = coverage.coordinates[0];
    let close = |a: f64, b: f64| (a - b).abs() < 1e-12;
    assert!(
        close(x.least, 0.0)
            && close(x.q05, 0.05)
            && close(x.median, 0.5)
            && close(x.q95, 0.95)
            && close(x.greatest, 1.0)
    );
    assert!(close(coverage.spacing.least, 1e-3) && close(coverage.spacing.greatest, 1e-3));
    // The first and the last tenth have neighbours on one side only.
    assert!(close(coverage.unseen.least, 1e-3) && close(coverage.unseen.greatest, 0.101), "{:?}", coverage.unseen);
    assert!((coverage.unseen.median - 0.03).abs() < 0.005, "{:?}", coverage.unseen);
    let two = Coverage::of(&PoseSamples::new(vec![line(0), line(3)]).unwrap(), METRIC);
    assert!(close(two.spacing.median, 3e-3) && close(two.unseen.median, 3e-3));
}

//! Training pairs: the same whatever is asked in which order, and distributed as said.

use touchcal::manifold::coordinates::{Coordinates, Metric, coordinates, pose};
use touchcal::manifold::{NearestSample, PoseSamples, TrainingPairs};

const METRIC: Metric = Metric::MILLIMETRE_PER_DEGREE;
/// Samples, so far apart that an offset's sample is known.
const COUNT: usize = 7;

fn nearest() -> NearestSample {
    let sample = |i: usize| [0.1 * i as f64, 0.0, 0.0, 0.2, -0.1, 0.3];
    NearestSample::new(PoseSamples::new((0..COUNT).map(sample).collect()).unwrap(), METRIC)
}

fn pairs(of: &TrainingPairs, range: std::ops::Range<u64>) -> (Vec<Coordinates>, Vec<Coordinates>) {
    let (mut inputs, mut targets) = (vec![[9.0; 6]; 3], Vec::new());
    of.fill(&nearest(), range, &mut inputs, &mut targets);
    (inputs, targets)
}

#[test]
fn a_pair_depends_on_seed_and_number_alone() {
    let list = TrainingPairs::new(1);
    let (inputs, targets) = pairs(&list, 0..1000);
    assert_eq!((inputs.len(), targets.len()), (1000, 1000));
    let one_thread = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    assert_eq!(one_thread.install(|| pairs(&list, 0..1000)), (inputs.clone(), targets.clone()));
    assert_eq!(pairs(&list, 321..400), (inputs[321..400].to_vec(), targets[321..400].to_vec()));
    assert_ne!(pairs(&TrainingPairs::new(2), 0..1000).0, inputs);
    assert!(pairs(&list, u64::MAX - 2..u64::MAX).0.len() == 2 && pairs(&list, 5..5).0.is_empty());
}

#[test]
fn offsets_are_uniform_on_the_right_of_a_uniform_sample() {
    let list = TrainingPairs::new(3);
    let count = 70_000;
    let (inputs, targets) = pairs(&list, 0..count as u64);
    let nearest = nearest();
    let samples = nearest.samples().coordinates();
    let mut chosen = [0usize; COUNT];
    let (mut sum, mut squares, mut greatest) = ([0.0; 6], [0.0; 6], [0.0f64; 6]);
    for (input, target) in inputs.iter().zip(&targets) {
        let index = samples.iter().position(|sample| sample == target).unwrap();
        assert_eq!(nearest.nearest(input).unwrap().index, index);
        chosen[index] += 1;
        let offset = coordinates(&(pose(target).inverse() * pose(input)));
        for k in 0..6 {
            let share = offset[k] / list.bounds[k];
            sum[k] += share;
            squares[k] += share * share;
            greatest[k] = greatest[k].max(share.abs());
        }
    }
    assert!(chosen.iter().all(|&times| (times as f64 / count as f64 - 1.0 / COUNT as f64).abs() < 0.006), "{chosen:?}");
    for k in 0..6 {
        assert!((sum[k] / count as f64).abs() < 0.01, "{sum:?}");
        assert!((squares[k] / count as f64 - 1.0 / 3.0).abs() < 0.006, "{squares:?}");
        assert!(greatest[k] > 0.999 && greatest[k] < 1.0 + 1e-9, "{greatest:?}");
    }
}

//! Projection onto the nearest sample.

use nalgebra::{Matrix6, Vector6};
use rayon::prelude::*;

use super::coordinates::{Coordinates, Metric, wrapped};
use super::projected::Projection;
use super::samples::PoseSamples;
use super::tree::{Point, Tree};

/// Poses that a thread takes at a time, and below which there is but one: a search takes some 20
/// µs.
const BATCH: usize = 64;

/// Projects a pose onto the sample nearest to it in a metric, or onto a mean of the nearest few.
///
/// The search is exact: the sample at the least [`Metric::distance`], of equally near ones the
/// first.
///
/// One neighbour: `F(c)` is the nearest sample, constant wherever the same sample is the nearest,
/// so `∂F/∂c` is zero.
///
/// `k` neighbours: `F(c) = Σ wᵢ sᵢ / Σ wᵢ` over the nearest samples `s₁ … s_k` at distances `dᵢ`,
/// with `wᵢ = (1/dᵢ − 1/d₍ₖ₊₁₎)²` (Franke & Nielson, *Smooth interpolation of large sets of
/// scattered data* (1980)). Angles are averaged the shorter way round from the nearest sample. A
/// sample projects onto itself, and `F` is continuous: a neighbour's weight vanishes where another
/// takes its place. Where all `k + 1` are equally far, `F(c)` is the first of them. `∂F/∂c` is the
/// derivative of the formula, and zero where a sample is the result.
///
/// A pose that is not finite projects onto NaN.
#[derive(Debug)]
pub struct NearestSample {
    samples: PoseSamples,
    metric: Metric,
    neighbours: usize,
    tree: Tree,
}

/// A sample near a pose, and its distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Neighbour {
    /// Index of the sample in [`PoseSamples::coordinates`], from 0.
    pub index: usize,
    /// Distance (m) between pose and sample in the metric.
    pub distance: f64,
}

impl NearestSample {
    /// Projection onto the nearest of `samples` in `metric`: one neighbour.
    pub fn new(samples: PoseSamples, metric: Metric) -> Self {
        let tree = Tree::new(samples.points(metric).into_iter().enumerate(), metric.circumference());
        NearestSample { samples, metric, neighbours: 1, tree }
    }

    /// Projects onto the weighted mean of this many nearest samples instead; clamped to at least
    /// one and at most the number of samples minus one, since one more bounds the weights.
    pub fn with_neighbours(mut self, neighbours: usize) -> Self {
        self.neighbours = neighbours.clamp(1, self.samples.len() - 1);
        self
    }

    /// The samples that are projected onto.
    pub fn samples(&self) -> &PoseSamples {
        &self.samples
    }

    /// Number of nearest samples that a projection is the mean of; at least 1.
    pub fn neighbours(&self) -> usize {
        self.neighbours
    }

    /// The sample nearest to a pose `fixture_from_tool` (m, rad; angles of any size), of equally
    /// near ones the first; `None` if the pose is not finite.
    pub fn nearest(&self, pose: &Coordinates) -> Option<Neighbour> {
        self.tree.nearest(&self.point(pose)).map(|(squared, index)| Neighbour { index, distance: squared.sqrt() })
    }

    /// The nearest sample of each pose (m, rad), one entry per pose in order, in parallel, as of
    /// [`nearest`](NearestSample::nearest); `None` where a pose is not finite.
    pub fn nearest_of_each(&self, poses: &[Coordinates]) -> Vec<Option<Neighbour>> {
        poses.par_iter().with_min_len(BATCH).map(|pose| self.nearest(pose)).collect()
    }

    /// The `k` samples nearest to a pose (m, rad), the nearest first and equally near ones in their
    /// order; all of them if there are fewer than `k`. Empty if the pose is not finite or `k` is 0.
    pub fn nearest_few(&self, pose: &Coordinates, k: usize) -> Vec<Neighbour> {
        let few = self.tree.nearest_few(&self.point(pose), k);
        few.into_iter().map(|(squared, index)| Neighbour { index, distance: squared.sqrt() }).collect()
    }

    /// The pose as a point that the tree knows.
    fn point(&self, pose: &Coordinates) -> Point {
        self.metric.point(&std::array::from_fn(|k| if k < 3 { pose[k] } else { wrapped(pose[k]) }))
    }

    /// `F(c)`; what is no number for a pose that is not finite.
    fn onto(&self, pose: &Coordinates) -> Coordinates {
        if self.neighbours > 1 {
            return self.mean(pose).0;
        }
        self.nearest(pose).map_or([f64::NAN; 6], |nearest| self.samples.coordinates()[nearest.index])
    }

    /// `F(c)` and `∂F/∂c`.
    fn onto_with_jacobian(&self, pose: &Coordinates) -> (Coordinates, Matrix6<f64>) {
        if self.neighbours > 1 { self.mean(pose) } else { (self.onto(pose), Matrix6::zeros()) }
    }

    /// The weighted mean of the neighbours, and its derivative.
    fn mean(&self, pose: &Coordinates) -> (Coordinates, Matrix6<f64>) {
        let few = self.nearest_few(pose, self.neighbours + 1);
        let (Some(first), Some(next)) = (few.first(), few.last()) else { return ([f64::NAN; 6], Matrix6::zeros()) };
        let base = &self.samples.coordinates()[first.index];
        // At a sample, and where all are equally far.
        if first.distance == 0.0 || first.distance == next.distance {
            return (*base, Matrix6::zeros());
        }
        let lengths = Vector6::from(self.metric.point(&[1.0; 6]));
        // d(1/d)/dc = −(c − s)/d³, in the metric.
        let slope = |neighbour: &Neighbour| {
            let difference = self.metric.difference(pose, &self.samples.coordinates()[neighbour.index]);
            -Vector6::from(difference).component_mul(&lengths) / neighbour.distance.powi(3)
        };
        let slope_of_next = slope(next);
        let (mut total, mut slope_of_total) = (0.0, Vector6::zeros());
        let (mut sum, mut slope_of_sum) = (Vector6::zeros(), Matrix6::zeros());
        for neighbour in &few[..self.neighbours] {
            let root = 1.0 / neighbour.distance - 1.0 / next.distance;
            let slope_of_weight = (slope(neighbour) - slope_of_next) * (2.0 * root);
            let sample = &self.samples.coordinates()[neighbour.index];
            // From the first sample, so that turns have no seam.
            let offset: [f64; 6] =
                std::array::from_fn(|k| if k < 3 { sample[k] - base[k] } else { wrapped(sample[k] - base[k]) });
            let offset = Vector6::from(offset);
            total += root * root;
            slope_of_total += slope_of_weight;
            sum += offset * (root * root);
            slope_of_sum += offset * slope_of_weight.transpose();
        }
        let mean = sum / total;
        let onto = Vector6::from(*base) + mean;
        let onto = std::array::from_fn(|k| if k < 3 { onto[k] } else { wrapped(onto[k]) });
        (onto, (slope_of_sum - mean * slope_of_total.transpose()) / total)
    }
}

impl Projection for NearestSample {
    fn name(&self) -> &'static str {
        if self.neighbours > 1 { "nearest samples" } else { "nearest sample" }
    }

    fn metric(&self) -> Metric {
        self.metric
    }

    fn bounds(&self) -> [(f64, f64); 6] {
        self.samples.bounds()
    }

    fn project(&self, poses: &[Coordinates], projected: &mut Vec<Coordinates>) {
        if poses.len() <= BATCH {
            projected.clear();
            projected.extend(poses.iter().map(|pose| self.onto(pose)));
        } else {
            poses.par_iter().with_min_len(BATCH).map(|pose| self.onto(pose)).collect_into_vec(projected);
        }
    }

    fn linearize(&self, poses: &[Coordinates], projected: &mut Vec<Coordinates>, jacobians: &mut Vec<Matrix6<f64>>) {
        if poses.len() <= BATCH {
            (*projected, *jacobians) = poses.iter().map(|pose| self.onto_with_jacobian(pose)).unzip();
        } else {
            let each = poses.par_iter().with_min_len(BATCH).map(|pose| self.onto_with_jacobian(pose));
            each.unzip_into_vecs(projected, jacobians);
        }
    }

    fn pull_back(
        &self,
        poses: &[Coordinates],
        cotangent: &mut dyn FnMut(usize, &Coordinates) -> Coordinates,
        pulled: &mut Vec<Coordinates>,
    ) {
        let (mut projected, mut jacobians) = (Vec::new(), Vec::new());
        self.linearize(poses, &mut projected, &mut jacobians);
        pulled.clear();
        pulled.extend(projected.iter().zip(&jacobians).enumerate().map(|(i, (onto, jacobian))| -> Coordinates {
            (jacobian.transpose() * Vector6::from(cotangent(i, onto))).into()
        }));
    }
}

//! How densely and how completely samples cover a contact manifold.

use rayon::prelude::*;

use super::coordinates::Metric;
use super::samples::PoseSamples;
use super::tree::Tree;

/// Parts of a record that are held out in turn.
const PARTS: usize = 10;

/// Quantiles of a set of values, in their unit: the quantile `p` (0 to 1) of `n` values is the one
/// of index `p (n − 1)`, rounded, in ascending order from 0, without interpolation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quantiles {
    /// The smallest value, in the unit of the values.
    pub least: f64,
    /// The 5 % quantile, in the unit of the values.
    pub q05: f64,
    /// The median (50 % quantile), in the unit of the values.
    pub median: f64,
    /// The 95 % quantile, in the unit of the values.
    pub q95: f64,
    /// The largest value, in the unit of the values.
    pub greatest: f64,
}

/// How densely and how completely samples cover a contact manifold.
#[derive(Clone, Debug, PartialEq)]
pub struct Coverage {
    /// Number of samples; at least two.
    pub count: usize,
    /// Quantiles of each coordinate `[x, y, z, α, β, γ]` over the samples (m for 0–2, rad for 3–5),
    /// angles within ±π.
    pub coordinates: [Quantiles; 6],
    /// Distance (m) of each sample from the nearest other one, 0 for one that is repeated: the
    /// density of the samples.
    pub spacing: Quantiles,
    /// Distance (m) of each sample from the nearest one outside its own tenth of the record (ten
    /// consecutive parts, held out in turn): how far from the samples a newly recorded contact
    /// would be. Where it is much greater than the spacing, the record covers only a part of the
    /// manifold.
    pub unseen: Quantiles,
}

impl Coverage {
    /// Coverage of samples, with distances in `metric`; computed in parallel, with the same result
    /// for every number of threads.
    pub fn of(samples: &PoseSamples, metric: Metric) -> Coverage {
        let points = samples.points(metric);
        let count = points.len();
        let tree = Tree::new(points.iter().copied().enumerate(), metric.circumference());
        let spacing = points.par_iter().enumerate().map(|(i, point)| {
            // The sample itself and one other.
            let two = tree.nearest_few(point, 2);
            two.iter().find(|(_, index)| *index != i).map_or(0.0, |(squared, _)| squared.sqrt())
        });
        let unseen = (0..PARTS).into_par_iter().flat_map_iter(|part| {
            let held_out = (part * count).div_ceil(PARTS)..((part + 1) * count).div_ceil(PARTS);
            let others = points.iter().copied().enumerate().filter(|(i, _)| !held_out.contains(i));
            let others = Tree::new(others, metric.circumference());
            let away = |point| others.nearest(point).map_or(0.0, |(squared, _)| squared.sqrt());
            points[held_out.clone()].iter().map(away).collect::<Vec<_>>()
        });
        Coverage {
            count,
            coordinates: std::array::from_fn(|k| {
                Quantiles::of(samples.coordinates().iter().map(|each| each[k]).collect())
            }),
            spacing: Quantiles::of(spacing.collect()),
            unseen: Quantiles::of(unseen.collect()),
        }
    }
}

impl Quantiles {
    /// Of finite values, at least one.
    fn of(mut values: Vec<f64>) -> Self {
        values.sort_unstable_by(f64::total_cmp);
        let at = |share: f64| values[(share * (values.len() - 1) as f64).round() as usize];
        Quantiles { least: at(0.0), q05: at(0.05), median: at(0.5), q95: at(0.95), greatest: at(1.0) }
    }
}

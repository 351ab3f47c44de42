//! Accuracy of a learned projection relative to the one that it was trained on, near the manifold
//! and far from it.

use rayon::prelude::*;

use super::pair_set::TrainingSource;
use crate::manifold::projection::coordinates::{Coordinates, pose};
use crate::manifold::projection::projected::Projection;
use crate::manifold::projection::training_pairs::TrainingPairs;

/// Offsets of each region as shares of those learned from: four inside, four outside, where an
/// estimate begins.
const REGIONS: [f64; 8] = [0.1, 0.25, 0.5, 1.0, 2.0, 3.0, 5.0, 10.0];
/// Greatest turn (rad) of a region outside: beyond it the nearest sample says little.
const MOST_TURN: f64 = std::f64::consts::PI / 6.0;
/// Number of the first pair that is neither learned from nor used to choose the weights.
const UNSEEN: u64 = 1 << 49;

/// Mean and 95 % quantile of a set of values, in their unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    /// The mean; 0 for an empty set.
    pub mean: f64,
    /// The 95 % quantile by nearest rank, without interpolation; NaN for an empty set.
    pub q95: f64,
}

/// Mean and 95 % quantile of the distances between the poses of two lists, pair by pair.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseDistance {
    /// Distance between the positions (m), in the fixture frame.
    pub place: Spread,
    /// Angle between the orientations (rad), from 0 to π.
    pub turn: Spread,
}

/// Accuracy of a projection for poses within one range of offsets from the manifold.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Accuracy {
    /// Largest offset from a sample in each coordinate `[x, y, z, α, β, γ]` (m, rad), in the tool's
    /// frame; offsets are uniform within ± these.
    pub offset: Coordinates,
    /// Number of poses tried: the `count` given to [`accuracy`].
    pub poses: usize,
    /// Distance of each pose from its nearest sample: the error without projection.
    pub before: PoseDistance,
    /// Distance of each projected pose from the sample nearest to it: how far from the manifold it
    /// still is.
    pub to_manifold: PoseDistance,
    /// Distance of each projected pose from the sample nearest to the original pose: the error as a
    /// projection.
    pub to_target: PoseDistance,
}

/// Accuracy of `learned` in eight ranges of offsets, the smallest first: 0.1, 0.25, 0.5, 1, 2, 3, 5
/// and 10 times those of the training pairs (angles at most 30°, or the training's own if larger).
/// `count` poses are tried in each range, on none of which it was trained. With a `count` of 0 the
/// means are 0 and the quantiles NaN.
pub fn accuracy(learned: &dyn Projection, source: &TrainingSource<'_>, count: u64) -> Vec<Accuracy> {
    let regions = REGIONS.iter().map(|share| {
        let offset = std::array::from_fn(|k| {
            let whole = source.pairs.bounds[k];
            if k < 3 { share * whole } else { (share * whole).min(MOST_TURN.max(whole)) }
        });
        let (mut poses, mut targets) = (Vec::new(), Vec::new());
        let pairs = TrainingPairs { bounds: offset, ..source.pairs };
        pairs.fill(source.projection, UNSEEN..UNSEEN + count, &mut poses, &mut targets);
        let (mut projected, mut back) = (Vec::new(), Vec::new());
        learned.project(&poses, &mut projected);
        source.projection.project(&projected, &mut back);
        Accuracy {
            offset,
            poses: poses.len(),
            before: apart(&poses, &targets),
            to_manifold: apart(&projected, &back),
            to_target: apart(&projected, &targets),
        }
    });
    regions.collect()
}

fn apart(all: &[Coordinates], others: &[Coordinates]) -> PoseDistance {
    let each = all.par_iter().zip(others).map(|(a, b)| {
        let a_from_b = pose(a).inv_mul(&pose(b));
        (a_from_b.translation.vector.norm(), a_from_b.rotation.angle())
    });
    let (places, turns): (Vec<f64>, Vec<f64>) = each.unzip();
    PoseDistance { place: spread(places), turn: spread(turns) }
}

fn spread(mut values: Vec<f64>) -> Spread {
    let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
    values.sort_by(f64::total_cmp);
    let at = (values.len() as f64 * 0.95).ceil() as usize;
    Spread { mean, q95: values.get(at.saturating_sub(1)).copied().unwrap_or(f64::NAN) }
}

//! A contact manifold as poses recorded on it.

use super::coordinates::{Coordinates, Metric, coordinates, wrapped};
use super::tree::{Point, Tree};
use crate::se3::Pose;

/// Poses `fixture_from_tool` at which the tool touched, in the order in which they were recorded;
/// all finite and at least two different ones.
#[derive(Clone, Debug, PartialEq)]
pub struct PoseSamples {
    coordinates: Vec<Coordinates>,
}

/// Why poses cannot be the samples of a manifold.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SamplesError {
    /// Fewer than two different poses: none at all, or one repeated. Poses are compared exactly,
    /// after angles were brought into ±π.
    #[error("expected at least two different poses, found {distinct} in {count}")]
    TooFew {
        /// Number of different poses, 0 or 1.
        distinct: usize,
        /// Number of all poses.
        count: usize,
    },
    /// A coordinate that is NaN or infinite; the first one is reported.
    #[error("expected finite coordinates, found {value} in pose {index}")]
    NotFinite {
        /// Index of the pose, 0 for the first.
        index: usize,
        /// The coordinate as found (m or rad).
        value: f64,
    },
}

impl PoseSamples {
    /// Samples from [`Coordinates`] `[x, y, z, α, β, γ]` (m, rad) of `fixture_from_tool`, in
    /// recorded order; angles are brought into ±π.
    ///
    /// # Errors
    /// [`SamplesError::NotFinite`] if a coordinate is not finite, else [`SamplesError::TooFew`] if
    /// there are fewer than two different poses.
    pub fn new(mut coordinates: Vec<Coordinates>) -> Result<Self, SamplesError> {
        for (index, each) in coordinates.iter_mut().enumerate() {
            if let Some(&value) = each.iter().find(|value| !value.is_finite()) {
                return Err(SamplesError::NotFinite { index, value });
            }
            each[3..].iter_mut().for_each(|angle| *angle = wrapped(*angle));
        }
        let count = coordinates.len();
        let distinct = usize::from(count > 0) + usize::from(coordinates.iter().any(|each| each != &coordinates[0]));
        if distinct < 2 {
            return Err(SamplesError::TooFew { distinct, count });
        }
        Ok(PoseSamples { coordinates })
    }

    /// Samples from poses `fixture_from_tool` (m), in recorded order.
    ///
    /// # Errors
    /// As [`new`](PoseSamples::new).
    pub fn from_poses<'p>(poses: impl IntoIterator<Item = &'p Pose>) -> Result<Self, SamplesError> {
        PoseSamples::new(poses.into_iter().map(coordinates).collect())
    }

    /// Coordinates `[x, y, z, α, β, γ]` (m, rad) of each sample, angles within ±π, in recorded
    /// order.
    pub fn coordinates(&self) -> &[Coordinates] {
        &self.coordinates
    }

    /// Number of samples; at least two.
    #[expect(clippy::len_without_is_empty, reason = "there are always some")]
    pub fn len(&self) -> usize {
        self.coordinates.len()
    }

    /// Least and greatest value, in this order, of each coordinate `[x, y, z, α, β, γ]` over the
    /// samples (m for 0–2, rad within ±π for 3–5). Angles on both sides of ±π are not joined.
    pub fn bounds(&self) -> [(f64, f64); 6] {
        let mut bounds = [(f64::INFINITY, f64::NEG_INFINITY); 6];
        for each in &self.coordinates {
            for (bound, value) in bounds.iter_mut().zip(each) {
                *bound = (bound.0.min(*value), bound.1.max(*value));
            }
        }
        bounds
    }

    /// Samples at least `spacing` (m, in `metric`) apart: goes through them in order and keeps each
    /// that is not nearer than `spacing` to a kept one. Every sample left out is nearer than
    /// `spacing` to a kept one. A spacing of 0 or less keeps all. The samples themselves are not
    /// changed.
    ///
    /// # Errors
    /// [`SamplesError::TooFew`] if fewer than two different ones are left.
    pub fn thinned(&self, spacing: f64, metric: Metric) -> Result<PoseSamples, SamplesError> {
        let points = self.points(metric);
        let tree = Tree::new(points.iter().copied().enumerate(), metric.circumference());
        let mut covered = vec![false; points.len()];
        let mut kept = Vec::new();
        for (i, point) in points.iter().enumerate() {
            if !covered[i] {
                kept.push(self.coordinates[i]);
                tree.within(point, spacing.max(0.0)).into_iter().for_each(|other| covered[other] = true);
            }
        }
        PoseSamples::new(kept)
    }

    /// The samples as points (m) of the metric's space.
    pub(super) fn points(&self, metric: Metric) -> Vec<Point> {
        self.coordinates.iter().map(|each| metric.point(each)).collect()
    }
}

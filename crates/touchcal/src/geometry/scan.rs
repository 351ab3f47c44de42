//! One sweep over the features of a peg and a hole at a pose.

use super::extrusion::{Feature, Gap, PegAndHole};
use super::silhouette::{Loop, displacement};
use crate::se3::{Pose, Twist, twist};
use nalgebra::{Matrix3, Vector2, Vector3};

/// Beyond this depth (m) of a peg end below the top face, its edges are no longer compared with the
/// rim from below: the walls are nearer.
pub(super) const RIM_DEPTH: f64 = 1e-3;
/// Cosine of the tilt beyond which a peg edge can run right through a wall unseen by the nearer
/// tests.
const LEANING: f64 = 0.99;

/// A signed distance. `normal` points from the solid into the peg, `point` lies on the peg; both
/// are in the peg frame if `in_peg`, else in the hole frame.
#[derive(Clone, Debug)]
pub(super) struct Candidate {
    pub(super) value: f64,
    pub(super) point: Vector3<f64>,
    pub(super) normal: Vector3<f64>,
    pub(super) in_peg: bool,
    pub(super) feature: Feature,
}

impl Candidate {
    /// Farther than anything.
    pub(super) const fn none() -> Self {
        Candidate {
            value: f64::INFINITY,
            point: Vector3::new(0.0, 0.0, 0.0),
            normal: Vector3::new(0.0, 0.0, 1.0),
            in_peg: false,
            feature: Feature::CornerFloor { peg_vertex: 0 },
        }
    }
}

impl Candidate {
    /// This overlap, or the one ended by moving the peg's `point` by `out` (hole frame) if that is
    /// shorter.
    pub(super) fn or_shallower(self, point: Vector3<f64>, out: Vector3<f64>, feature: Feature) -> Self {
        let distance = out.norm();
        if self.value < 0.0 && distance >= -self.value {
            return self;
        }
        let normal = if distance > 0.0 { out / distance } else { Vector3::z() };
        Candidate { value: -distance, point, normal, in_peg: false, feature }
    }
}

/// What becomes of the distances found.
pub(super) trait Sink {
    /// Whether near misses are wanted, or only the smallest.
    const ALL: bool;
    /// Distances from here on are of no interest.
    fn reach(&self) -> f64;
    /// Receives a distance below [`Sink::reach`].
    fn take(&mut self, candidate: Candidate);
}

/// A peg and a hole at a pose.
pub(super) struct Scan<'a> {
    pub(super) pair: &'a PegAndHole,
    pub(super) rotation: Matrix3<f64>,
    pub(super) translation: Vector3<f64>,
    /// The hole's origin in the peg frame.
    pub(super) hole_in_peg: Vector3<f64>,
}

pub(super) fn lift(v: &Vector2<f64>, z: f64) -> Vector3<f64> {
    Vector3::new(v.x, v.y, z)
}

impl<'a> Scan<'a> {
    pub(super) fn new(pair: &'a PegAndHole, hole_from_peg: &Pose) -> Self {
        let rotation = *hole_from_peg.rotation.to_rotation_matrix().matrix();
        let translation = hole_from_peg.translation.vector;
        Scan { pair, rotation, translation, hole_in_peg: -(rotation.tr_mul(&translation)) }
    }

    /// Reports the features to `sink`. Families that a peg above the top face cannot have are left
    /// out: it may be far away, where nothing else tells which are the nearest.
    pub(super) fn run<S: Sink>(&self, sink: &mut S) {
        let mut is_above = true;
        for end in [0.0, self.pair.length] {
            let limit = sink.reach().max(0.0);
            let (middle, spread) =
                (self.translation.z + self.rotation[(2, 2)] * end, self.tilt() * self.pair.peg_radius);
            is_above &= middle - spread > 0.0;
            if middle - spread >= limit {
                continue;
            }
            let (lowest, highest) =
                if middle + spread < 0.0 { (middle - spread, middle + spread) } else { self.heights(end) };
            if lowest >= limit {
                continue;
            }
            let ring = self.ring(end);
            self.corners(&ring, end, sink);
            if lowest <= 0.0 {
                self.wall_corners(&ring, end, sink);
            }
            if highest > -sink.reach().max(RIM_DEPTH) {
                self.end_edges(&ring, end, sink);
            }
            if lowest < 0.0 && highest > 0.0 {
                self.pierced_end(end, sink);
            }
        }
        let rim = self.rim();
        self.rim_corners(&rim, sink);
        let spread = rim.slope.norm() * self.pair.hole_radius;
        let is_beside_rim = rim.height + spread >= 0.0 && rim.height - spread <= self.pair.length;
        if !is_above || is_beside_rim {
            self.side_edges(&rim, sink);
        }
        self.crossing_corners(sink);
        if self.rotation[(2, 2)] < LEANING {
            self.pierced_walls(sink);
        }
    }

    /// Sine of the angle between the axes.
    pub(super) fn tilt(&self) -> f64 {
        Vector2::new(self.rotation[(2, 0)], self.rotation[(2, 1)]).norm()
    }

    /// The gap that a candidate stands for: with its gradient, and in the hole frame.
    pub(super) fn gap(&self, candidate: &Candidate) -> Gap {
        let Candidate { value, point, normal, in_peg, feature } = *candidate;
        let (point_in_hole, normal_in_hole) =
            if in_peg { (self.rotation * point + self.translation, self.rotation * normal) } else { (point, normal) };
        let gradient = self.gradient(candidate);
        Gap { value, gradient, point_in_hole: point_in_hole.into(), normal_in_hole, feature }
    }

    /// The gradient of a candidate's distance, as in [`Gap::gradient`].
    #[inline]
    pub(super) fn gradient(&self, candidate: &Candidate) -> Twist {
        let (point, normal) = if candidate.in_peg {
            (candidate.point, candidate.normal)
        } else {
            (self.rotation.tr_mul(&candidate.point) + self.hole_in_peg, self.rotation.tr_mul(&candidate.normal))
        };
        twist(&normal, &point.cross(&normal))
    }

    /// Least and greatest height of an end of the peg in the hole frame.
    fn heights(&self, end: f64) -> (f64, f64) {
        let pair = self.pair;
        let slope = Vector2::new(self.rotation[(2, 0)], self.rotation[(2, 1)]);
        let middle = self.translation.z + self.rotation[(2, 2)] * end;
        pair.peg_corners.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &i| {
            let z = middle + slope.dot(&pair.peg.vertices()[i].coords);
            (low.min(z), high.max(z))
        })
    }

    /// The outline of an end of the peg, seen along the hole's axis.
    fn ring(&self, end: f64) -> Loop<'a> {
        let (r, t) = (&self.rotation, &self.translation);
        let centre = t + r.column(2) * end;
        let linear = r.fixed_view::<2, 2>(0, 0).into_owned();
        let offset = centre.xy();
        Loop {
            profile: &self.pair.peg,
            linear,
            offset,
            slope: Vector2::new(r[(2, 0)], r[(2, 1)]),
            height: centre.z,
            moved: displacement(&self.pair.peg, &self.pair.peg_corners, &linear, &offset),
            turn: r[(2, 2)].signum(),
            near: &self.pair.hole_to_peg,
        }
    }

    /// The rim, seen along the peg's axis.
    fn rim(&self) -> Loop<'a> {
        let r = &self.rotation;
        let linear = r.fixed_view::<2, 2>(0, 0).transpose();
        let offset = self.hole_in_peg.xy();
        Loop {
            profile: &self.pair.hole,
            linear,
            offset,
            slope: Vector2::new(r[(0, 2)], r[(1, 2)]),
            height: self.hole_in_peg.z,
            moved: displacement(&self.pair.hole, &self.pair.hole_hull, &linear, &offset),
            turn: r[(2, 2)].signum(),
            near: &self.pair.peg_to_hole,
        }
    }
}

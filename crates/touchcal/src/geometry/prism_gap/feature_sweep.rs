//! A peg and a hole at a pose.

use super::feature::FeatureDistance;
use super::prism_pair::{EdgeRadii, PrismPair};
use super::projected_polygon::{ProjectedPolygon, displacement};
use crate::geometry::gap::SignedGap;
use crate::se3::{Pose, Twist, twist};
use nalgebra::{Matrix3, Vector2, Vector3};

/// An eroded peg and the hole in an eroded solid at a pose, each in a frame with its origin at the
/// tip or mouth after erosion; see [`PrismPair`], round edges.
pub(super) struct FeatureSweep<'a> {
    pub(super) pair: &'a PrismPair,
    pub(super) rotation: Matrix3<f64>,
    pub(super) translation: Vector3<f64>,
    /// The hole's origin in the peg frame.
    pub(super) hole_in_peg: Vector3<f64>,
}

pub(super) fn lift(v: &Vector2<f64>, z: f64) -> Vector3<f64> {
    Vector3::new(v.x, v.y, z)
}

impl<'a> FeatureSweep<'a> {
    pub(super) fn new(pair: &'a PrismPair, hole_from_peg: &Pose) -> Self {
        let rotation = *hole_from_peg.rotation.to_rotation_matrix().matrix();
        let EdgeRadii { peg, hole } = pair.edge_radii;
        let translation = hole_from_peg.translation.vector + rotation.column(2) * peg + Vector3::z() * hole;
        FeatureSweep { pair, rotation, translation, hole_in_peg: -(rotation.tr_mul(&translation)) }
    }

    /// Sine of the angle between the axes.
    pub(super) fn tilt(&self) -> f64 {
        Vector2::new(self.rotation[(2, 0)], self.rotation[(2, 1)]).norm()
    }

    /// Distance (m) of features of the eroded bodies that touch each other once dilated.
    pub(super) fn sum_of_radii(&self) -> f64 {
        self.pair.edge_radii.peg + self.pair.edge_radii.hole
    }

    /// The signed gap between two features, with its gradient and in the hole's declared frame.
    pub(super) fn signed_gap(&self, distance: &FeatureDistance) -> SignedGap {
        let FeatureDistance { value, point, normal, in_peg, .. } = *distance;
        let (point, normal) =
            if in_peg { (self.rotation * point + self.translation, self.rotation * normal) } else { (point, normal) };
        let EdgeRadii { peg, hole } = self.pair.edge_radii;
        SignedGap {
            value: value - self.sum_of_radii(),
            gradient: self.gradient(distance),
            point_in_fixture: (point - normal * peg - Vector3::z() * hole).into(),
            normal_in_fixture: normal,
        }
    }

    /// The gradient of a distance, as in [`SignedGap::gradient`], in the peg's declared frame.
    #[inline]
    pub(super) fn gradient(&self, distance: &FeatureDistance) -> Twist {
        let (point, normal) = if distance.in_peg {
            (distance.point, distance.normal)
        } else {
            (self.rotation.tr_mul(&distance.point) + self.hole_in_peg, self.rotation.tr_mul(&distance.normal))
        };
        let point = point + Vector3::z() * self.pair.edge_radii.peg;
        twist(&normal, &point.cross(&normal))
    }

    /// Least and greatest height of an end of the peg in the hole frame.
    pub(super) fn heights(&self, end: f64) -> (f64, f64) {
        let pair = self.pair;
        let slope = Vector2::new(self.rotation[(2, 0)], self.rotation[(2, 1)]);
        let middle = self.translation.z + self.rotation[(2, 2)] * end;
        pair.peg_corners.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &i| {
            let z = middle + slope.dot(&pair.eroded_peg.vertices()[i].coords);
            (low.min(z), high.max(z))
        })
    }

    /// The outline of an end of the peg, seen along the hole's axis.
    pub(super) fn ring(&self, end: f64) -> ProjectedPolygon<'a> {
        let (r, t) = (&self.rotation, &self.translation);
        let centre = t + r.column(2) * end;
        let linear = r.fixed_view::<2, 2>(0, 0).into_owned();
        let offset = centre.xy();
        ProjectedPolygon {
            polygon: &self.pair.eroded_peg,
            linear,
            offset,
            slope: Vector2::new(r[(2, 0)], r[(2, 1)]),
            height: centre.z,
            moved: displacement(&self.pair.eroded_peg, &self.pair.peg_corners, &linear, &offset),
            turn: r[(2, 2)].signum(),
            near: &self.pair.hole_to_peg,
        }
    }

    /// The rim, seen along the peg's axis.
    pub(super) fn rim(&self) -> ProjectedPolygon<'a> {
        let r = &self.rotation;
        let linear = r.fixed_view::<2, 2>(0, 0).transpose();
        let offset = self.hole_in_peg.xy();
        ProjectedPolygon {
            polygon: &self.pair.eroded_hole,
            linear,
            offset,
            slope: Vector2::new(r[(0, 2)], r[(1, 2)]),
            height: self.hole_in_peg.z,
            moved: displacement(&self.pair.eroded_hole, &self.pair.hole_hull, &linear, &offset),
            turn: r[(2, 2)].signum(),
            near: &self.pair.peg_to_hole,
        }
    }
}

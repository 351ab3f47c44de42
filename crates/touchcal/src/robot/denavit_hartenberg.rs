//! Denavit–Hartenberg parameters of a chain, with Hayati's where neighbouring axes are nearly
//! parallel.

use nalgebra::{Rotation3, Translation3, UnitQuaternion, Vector3};

use super::chain::{JointKind, Robot};
use crate::se3::Pose;

/// Sine of the angle between neighbouring axes, that of 10°, below which they count as nearly
/// parallel. The foot of their common normal, and so `d`, moves by up to `a / sin²` (m) per radian
/// of tilt: by 0.35 m for a degree at 10° where `a` is 0.6 m, by more where the angle is smaller.
pub const NEARLY_PARALLEL: f64 = 0.173_648_177_666_930_35;
/// Axes that intersect within this (m) in the plane of Hayati's parameters have `theta` = 0.
const COINCIDENT: f64 = 1e-12;
/// Least and greatest `theta` (rad) between axes, −100° and 80°: one of the two senses of the
/// common normal is within. Neither end is an angle at which arms are designed, so that a
/// calibrated arm has the sense of the nominal one.
const THETA: [f64; 2] = [-5.0 * std::f64::consts::PI / 9.0, 4.0 * std::f64::consts::PI / 9.0];
/// An axis of a frame whose component orthogonal to a joint's axis is shorter gives it no `x`.
const TOO_SHORT: f64 = 0.5;

/// The Denavit–Hartenberg form of a chain. With standard (distal) frames the pose of the tip in the
/// base is
///
/// `base_from_dh_base · Π Rz(theta) Tz(d) Tx(a) Rx(alpha) Ry(beta) · dh_last_from_tip`,
///
/// the product over `links`, base first. The position of a revolute joint is added to its `theta`,
/// that of a prismatic one to its `d`.
///
/// The modified (proximal) form (Craig, *Introduction to Robotics*, 1986) has the same numbers,
/// `a`, `alpha` and `beta` one link later: `Π Tx(a) Rx(alpha) Ry(beta) Rz(theta) Tz(d)`, with those
/// of the link before, 0 in the first one. Both have the same two end transforms, because the last
/// link's `a`, `alpha` and `beta` are 0.
#[derive(Clone, Debug, PartialEq)]
pub struct DenavitHartenberg {
    /// Pose in the base (m) of the frame before the first joint: z along its axis, at the point
    /// nearest to the base's origin.
    pub base_from_dh_base: Pose,
    /// One for each moving joint, base first.
    pub links: Vec<DhLink>,
    /// Pose of the tip (m) in the frame after the last joint, whose z is that joint's axis, at the
    /// point nearest to the tip.
    pub dh_last_from_tip: Pose,
}

/// From a joint's axis to that of the next joint, at position 0.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DhLink {
    /// Angle about the joint's axis (rad).
    pub theta: f64,
    /// Offset along the joint's axis (m); 0 if `is_nearly_parallel`.
    pub d: f64,
    /// Length along the new x (m), of either sign.
    pub a: f64,
    /// Angle about the new x (rad).
    pub alpha: f64,
    /// Angle about the new y (rad), 0 unless `is_nearly_parallel`.
    pub beta: f64,
    /// Whether the next axis is [`NEARLY_PARALLEL`], so that `beta` stands in place of `d` (Hayati,
    /// *Robot arm geometric link parameter estimation*, 1983).
    pub is_nearly_parallel: bool,
}

/// The Denavit–Hartenberg form of `robot`, without its compliances: exact for any chain of revolute
/// and prismatic joints. The axis of a prismatic joint, which is a direction only, is taken through
/// the joint's origin.
pub fn denavit_hartenberg(robot: &Robot) -> DenavitHartenberg {
    let mut base_from_link = Pose::identity();
    let mut axes = Vec::with_capacity(robot.dof());
    for joint in robot.joints() {
        base_from_link *= joint.parent_from_joint;
        if joint.kind != JointKind::Fixed {
            axes.push((base_from_link.translation.vector, base_from_link.rotation * *joint.axis));
        }
    }
    let base_from_dh_base = axes.first().map_or_else(Pose::identity, |(point, axis)| first_frame(point, axis));
    let mut base_from_frame = base_from_dh_base;
    let mut links = Vec::with_capacity(axes.len());
    for (point, axis) in axes.iter().skip(1) {
        let frame_from_base = base_from_frame.inverse();
        let link =
            DhLink::to_axis(&(frame_from_base * nalgebra::Point3::from(*point)).coords, &(frame_from_base * axis));
        base_from_frame *= link.pose();
        links.push(link);
    }
    let link = DhLink::to_tip(&base_from_frame.inv_mul(&base_from_link));
    base_from_frame *= link.pose();
    links.push(link);
    DenavitHartenberg { base_from_dh_base, links, dh_last_from_tip: base_from_frame.inv_mul(&base_from_link) }
}

/// The frame before the first joint: its x is the part of the base's x (or y, if x is too near the
/// axis) that is orthogonal to the axis.
fn first_frame(point: &Vector3<f64>, axis: &Vector3<f64>) -> Pose {
    let origin = point - axis * axis.dot(point);
    let orthogonal = |v: Vector3<f64>| v - axis * axis.dot(&v);
    let of_x = orthogonal(Vector3::x());
    let x = if of_x.norm() < TOO_SHORT { orthogonal(Vector3::y()) } else { of_x }.normalize();
    let rotation = Rotation3::from_basis_unchecked(&[x, axis.cross(&x), *axis]);
    Pose::from_parts(Translation3::from(origin), UnitQuaternion::from_rotation_matrix(&rotation))
}

impl DhLink {
    /// The link's pose at position 0.
    fn pose(&self) -> Pose {
        let about = |axis, angle| UnitQuaternion::from_axis_angle(&axis, angle);
        let turned = Pose::from_parts(Translation3::new(0.0, 0.0, self.d), about(Vector3::z_axis(), self.theta));
        let bent = about(Vector3::x_axis(), self.alpha) * about(Vector3::y_axis(), self.beta);
        turned * Pose::from_parts(Translation3::new(self.a, 0.0, 0.0), bent)
    }

    /// The link from the axis z through the origin to the one along the unit vector `next` through
    /// `point`.
    fn to_axis(point: &Vector3<f64>, next: &Vector3<f64>) -> DhLink {
        let sine = next.xy().norm();
        let is_nearly_parallel = sine < NEARLY_PARALLEL;
        // How far from `point` the next axis is met, by the plane z = 0 or the common normal.
        let along = if is_nearly_parallel { -point.z / next.z } else { -point.xy().dot(&next.xy()) / (sine * sine) };
        let met = point + next * along;
        let theta = match is_nearly_parallel {
            true if met.xy().norm() < COINCIDENT => 0.0,
            true => met.y.atan2(met.x),
            false => next.x.atan2(-next.y),
        };
        let theta = in_range(theta);
        let (sin, cos) = theta.sin_cos();
        let turned = Vector3::new(cos * next.x + sin * next.y, cos * next.y - sin * next.x, next.z);
        DhLink {
            theta,
            d: if is_nearly_parallel { 0.0 } else { met.z },
            a: cos * met.x + sin * met.y,
            alpha: (-turned.y).atan2(turned.z),
            beta: if is_nearly_parallel { turned.x.clamp(-1.0, 1.0).asin() } else { 0.0 },
            is_nearly_parallel,
        }
    }

    /// The link from the last axis, z through the origin, to the point on it next to the tip, with
    /// the tip's x (or y, if x is too near the axis) as far as it is orthogonal to the axis.
    fn to_tip(frame_from_tip: &Pose) -> DhLink {
        let of_x = frame_from_tip.rotation * Vector3::x();
        let x = if of_x.xy().norm() < TOO_SHORT { frame_from_tip.rotation * Vector3::y() } else { of_x };
        DhLink { theta: x.y.atan2(x.x), d: frame_from_tip.translation.vector.z, ..DhLink::default() }
    }
}

/// The angle, or the opposite sense, that is within [`THETA`].
fn in_range(theta: f64) -> f64 {
    let [least, greatest] = THETA;
    match theta {
        theta if theta < least => theta + std::f64::consts::PI,
        theta if theta > greatest => theta - std::f64::consts::PI,
        theta => theta,
    }
}

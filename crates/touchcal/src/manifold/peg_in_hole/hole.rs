//! A hole and its peg for every kind of shape: the envelope, and the symmetry of round parts.

use nalgebra::Vector3;

use crate::geometry::AxialSymmetry;
use crate::manifold::residual::Residual;
use crate::se3::{self, Pose, Twist, twist};

/// Default scale of the envelope's translation rows (m): half a millimetre.
pub(super) const TRANSLATION_SCALE: f64 = 0.5e-3;
/// Default scale of the envelope's rotation rows (rad): one degree.
pub(super) const ROTATION_SCALE: f64 = std::f64::consts::PI / 180.0;

/// Sine of the angle between rotations about two axes below which they are one.
const SAME_AXIS: f64 = 1e-9;

/// A hole and the peg that goes in: frames as in
/// [`PrismPair`](crate::geometry::PrismPair).
#[derive(Clone, Debug)]
pub(super) struct Hole {
    /// Depth (m) that the peg's tip reaches below the mouth.
    pub depth: f64,
    /// Distance (m) of the peg's surface from its axis, at most.
    pub peg_radius: f64,
    /// Sum of the radii (m) to which edges of peg and hole are rounded.
    pub sum_of_edge_radii: f64,
    /// Whether peg and hole are each round about their z axis.
    pub symmetry: AxialSymmetry,
}

impl Hole {
    /// Tool and fixture in words for people.
    pub fn name(&self, is_straight: bool) -> &'static str {
        match (self.symmetry.any(), is_straight) {
            (false, true) => "peg in hole",
            (false, false) => "peg in hole, not straight",
            (true, true) => "peg in hole, round",
            (true, false) => "peg in hole, round, not straight",
        }
    }

    /// A projection of gap derivatives (twists of the peg in its own frame) onto those that a round
    /// part can have: a rotation about the axis of a round part changes no gap. Facets would make
    /// that rotation observable.
    pub fn without_axial_rotation(&self, hole_from_peg: &Pose) -> impl Fn(Twist) -> Twist + use<> {
        // Lengths in units of the radius, so that a projection is no matter of units.
        let radius = self.peg_radius;
        let scaled = |twist: Twist, scale: f64| se3::twist(&se3::linear(&twist), &(se3::angular(&twist) * scale));
        let about_z = twist(&Vector3::zeros(), &Vector3::z());
        let unit = |turn: Twist| scaled(turn, radius).normalize();
        let of_peg = self.symmetry.peg.then(|| unit(about_z));
        let of_hole = self.symmetry.hole.then(|| unit(se3::adjoint(&hole_from_peg.inverse()) * about_z));
        // None if the axis is the same.
        let left_of_hole = of_hole.and_then(|turn| without(of_peg, turn).try_normalize(SAME_AXIS));
        move |gradient| match (of_peg, left_of_hole) {
            (None, None) => gradient,
            _ => scaled(without(left_of_hole, without(of_peg, scaled(gradient, 1.0 / radius))), radius),
        }
    }

    /// Pushes the envelope's six rows, divided by the scales of translation (m) and rotation (rad).
    pub fn push_envelope(&self, hole_from_peg: &Pose, scale: (f64, f64), rows: &mut Residual) {
        let tip = hole_from_peg.translation.vector;
        let outside = Vector3::new(tip.x, tip.y, tip.z - tip.z.clamp(-self.depth, 0.0));
        let rotation = hole_from_peg.rotation.to_rotation_matrix();
        for axis in 0..3 {
            let direction = rotation.matrix().row(axis).transpose();
            // Within the depth the z row is flat.
            let active = if axis < 2 || outside.z != 0.0 { 1.0 } else { 0.0 };
            rows.push(outside[axis] / scale.0, twist(&(direction * (active / scale.0)), &Vector3::zeros()));
        }
        if self.symmetry.any() {
            return self.push_tilt(hole_from_peg, scale.1, rows);
        }
        let vector = se3::rotation_log(&hole_from_peg.rotation);
        let change = se3::rotation_log_jacobian(&vector);
        for axis in 0..3 {
            let row = change.row(axis).transpose() / scale.1;
            rows.push(vector[axis] / scale.1, twist(&Vector3::zeros(), &row));
        }
    }

    /// Pushes three rows that do not depend on the rotation about the peg's axis: the peg's axis
    /// less that of the hole.
    fn push_tilt(&self, hole_from_peg: &Pose, scale: f64, rows: &mut Residual) {
        let rotation = hole_from_peg.rotation.to_rotation_matrix();
        for axis in 0..3 {
            let direction = rotation.matrix().row(axis).transpose();
            let of_hole = if axis == 2 { 1.0 } else { 0.0 };
            let row = twist(&Vector3::zeros(), &(Vector3::z().cross(&direction) / scale));
            rows.push((direction.z - of_hole) / scale, row);
        }
    }
}

/// The part of a twist that is orthogonal to another one of length 1.
fn without(along: Option<Twist>, twist: Twist) -> Twist {
    along.map_or(twist, |along| twist - along * along.dot(&twist))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rotation_about_the_axis_of_a_round_part_changes_no_gap() {
        let pose = Pose::new(Vector3::new(0.3e-3, -0.2e-3, -0.02), Vector3::new(0.01, -0.02, 2.0));
        let of_peg = twist(&Vector3::zeros(), &Vector3::z());
        let of_hole = se3::adjoint(&pose.inverse()) * of_peg;
        let gradient = Twist::new(0.8, -0.6, 0.1, 2e-3, -3e-3, 4e-3);
        for (peg, hole) in [(true, false), (false, true), (true, true)] {
            let symmetry = AxialSymmetry { peg, hole };
            let parts = Hole { depth: 0.03, peg_radius: 0.01, sum_of_edge_radii: 0.0, symmetry };
            let left = parts.without_axial_rotation(&pose)(gradient);
            for (turn, is_round) in [(of_peg, peg), (of_hole, hole)] {
                assert_eq!(left.dot(&turn).abs() < 1e-15, is_round, "{peg} {hole}: {:e}", left.dot(&turn));
            }
        }
        // Concentric, both turns are one.
        let symmetry = AxialSymmetry { peg: true, hole: true };
        let parts = Hole { depth: 0.03, peg_radius: 0.01, sum_of_edge_radii: 0.0, symmetry };
        let left = parts.without_axial_rotation(&Pose::translation(0.0, 0.0, -0.02))(gradient);
        assert_eq!(left, Twist::new(0.8, -0.6, 0.1, 2e-3, -3e-3, 0.0));
    }
}

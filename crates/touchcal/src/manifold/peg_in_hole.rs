//! A straight peg in a straight hole: the residual is the exact signed gap.

use super::{ContactManifold, Rows};
use crate::geometry::extrusion::PegAndHole;
use nalgebra::Vector3;

use crate::se3::{self, Pose, twist};

/// Default scale of the envelope's translation rows (m): half a millimetre.
pub const TRANSLATION_SCALE: f64 = 0.5e-3;
/// Default scale of the envelope's rotation rows (rad): one degree.
pub const ROTATION_SCALE: f64 = std::f64::consts::PI / 180.0;

/// Contact of a peg with the hole it goes into. Poses are `hole_from_peg`, frames as in [`PegAndHole`].
///
/// - Residual, one row: the signed gap (m), positive free, negative penetrating; blended over features that the resolution
///   cannot tell apart, see [`PegAndHole::blended_gap`].
/// - Envelope, six rows: place of the tip's origin in the hole — x and y towards zero, z outside `[−depth, 0]` (zero within) —
///   divided by `translation_scale`, then the rotation vector of `hole_from_peg` divided by `rotation_scale`. Its
///   Jacobian is exact and regular at every angle up to π, where the rotation vector itself jumps to its negative.
#[derive(Clone, Debug)]
pub struct PegInHole {
    /// Shapes of peg and hole.
    pub shapes: PegAndHole,
    /// Scale of the envelope's translation rows (m).
    pub translation_scale: f64,
    /// Scale of the envelope's rotation rows (rad).
    pub rotation_scale: f64,
}

impl PegInHole {
    /// With an envelope scale of half a millimetre and one degree.
    pub fn new(shapes: PegAndHole) -> Self {
        PegInHole { shapes, translation_scale: TRANSLATION_SCALE, rotation_scale: ROTATION_SCALE }
    }
}

impl ContactManifold for PegInHole {
    fn name(&self) -> &'static str {
        "peg in hole"
    }

    fn residual(&self, hole_from_peg: &Pose, resolution: f64, rows: &mut Rows) {
        let (value, gradient) = self.shapes.blended_gap(hole_from_peg, resolution);
        rows.push(value, gradient);
    }

    fn envelope(&self, hole_from_peg: &Pose, rows: &mut Rows) {
        let tip = hole_from_peg.translation.vector;
        let outside = Vector3::new(tip.x, tip.y, tip.z - tip.z.clamp(-self.shapes.depth(), 0.0));
        let rotation = hole_from_peg.rotation.to_rotation_matrix();
        for axis in 0..3 {
            let direction = rotation.matrix().row(axis).transpose();
            // Within the depth the z row is flat.
            let active = if axis < 2 || outside.z != 0.0 { 1.0 } else { 0.0 };
            let scale = self.translation_scale;
            rows.push(outside[axis] / scale, twist(&(direction * (active / scale)), &Vector3::zeros()));
        }
        let vector = se3::rotation_log(&hole_from_peg.rotation);
        let change = se3::rotation_log_jacobian(&vector);
        for axis in 0..3 {
            let row = change.row(axis).transpose() / self.rotation_scale;
            rows.push(vector[axis] / self.rotation_scale, twist(&Vector3::zeros(), &row));
        }
    }

    fn fixture_directions(&self) -> &'static [usize] {
        &[0, 1, 2, 3, 4, 5]
    }

    fn tool_directions(&self) -> &'static [usize] {
        &[0, 1, 2, 3, 4, 5]
    }

    fn has_interference(&self) -> bool {
        true
    }
}

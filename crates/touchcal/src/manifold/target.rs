//! A point of the tool at places that an instrument measures.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use super::contact_manifold::ContactManifold;
use super::residual::Residual;
use super::sketch::{Shape, Sketch};
use crate::se3::{self, Pose};

/// Contact manifold of a ball or point of the tool at *targets*: places in the fixture frame, one
/// for each contact ([`ContactLog::target`](crate::contact::ContactLog::target)), that an
/// instrument measures or a drawing gives. The fixture frame is that of the instrument or of the
/// drawing. Poses `fixture_from_tool` are those relative to the contact's target,
/// `target_from_tool`.
///
/// Tool frame: origin at the ball's centre. The envelope is the residual over 0.5 mm.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Target {
    /// The centre is at the target. Residual: their difference along the axes of the fixture frame
    /// if targets are not rotated, three rows x, y, z (m).
    Point,
    /// The ball touches a surface through the target, of which the target's +z is the normal.
    /// Residual: signed distance (m) of ball and tangent plane, positive apart, one row.
    AlongNormal {
        /// Radius of the ball (m, not negative); 0 for a point.
        radius: f64,
    },
}

/// Distance (m) that one unit of envelope stands for.
const ENVELOPE_LENGTH: f64 = 0.5e-3;

impl Target {
    fn push(self, target_from_tool: &Pose, scale: f64, rows: &mut Residual) {
        let rotation = target_from_tool.rotation.to_rotation_matrix();
        let place = &target_from_tool.translation.vector;
        let mut push = |k: usize, value: f64| {
            // `p(T · Exp(ξ)) ≈ p + R v`: row k of the derivative is row k of R.
            let row = rotation.matrix().row(k).transpose() * scale;
            rows.push(value * scale, se3::twist(&row, &Vector3::zeros()));
        };
        match self {
            Target::Point => (0..3).for_each(|k| push(k, place[k])),
            Target::AlongNormal { radius } => push(2, place.z - radius),
        }
    }
}

impl ContactManifold for Target {
    fn name(&self) -> &'static str {
        match self {
            Target::Point => "point at target",
            Target::AlongNormal { .. } => "ball on surface at target",
        }
    }

    fn residual(&self, target_from_tool: &Pose, _: f64, rows: &mut Residual) {
        self.push(target_from_tool, 1.0, rows);
    }

    fn envelope(&self, target_from_tool: &Pose, rows: &mut Residual) {
        self.push(target_from_tool, 1.0 / ENVELOPE_LENGTH, rows);
    }

    fn fixture_directions(&self) -> &'static [usize] {
        &[0, 1, 2, 3, 4, 5]
    }

    fn tool_directions(&self) -> &'static [usize] {
        &[0, 1, 2]
    }

    fn tool_at_target(&self) -> Option<Vector3<f64>> {
        match *self {
            Target::Point => Some(Vector3::zeros()),
            Target::AlongNormal { radius } => Some(radius * Vector3::z()),
        }
    }

    fn sketch(&self) -> Sketch {
        let tool = match *self {
            Target::AlongNormal { radius } if radius > 0.0 => Shape::Ball { radius },
            _ => Shape::Point,
        };
        Sketch { tool, fixture: Shape::Point }
    }
}

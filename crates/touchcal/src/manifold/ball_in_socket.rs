//! A ball that sits in a socket: their centres coincide.

use super::contact_manifold::{ContactManifold, ResidualKind};
use super::residual::Residual;
use crate::se3::{self, Pose};

/// Contact manifold of a ball in a socket. Residual: ball centre minus socket centre along the axes
/// of the fixture frame, three rows x, y, z (m), whatever the resolution.
///
/// Tool frame: origin at the ball's centre. Fixture frame: origin at the socket's centre. The
/// envelope is the residual over 0.5 mm. The radius does not matter.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BallInSocket;

/// Distance (m) that one unit of envelope stands for.
const ENVELOPE_LENGTH: f64 = 0.5e-3;

impl ContactManifold for BallInSocket {
    fn name(&self) -> &'static str {
        "ball in socket"
    }

    fn residual(&self, fixture_from_tool: &Pose, _: f64, rows: &mut Residual) {
        push_centre(fixture_from_tool, 1.0, rows);
    }

    fn envelope(&self, fixture_from_tool: &Pose, rows: &mut Residual) {
        push_centre(fixture_from_tool, 1.0 / ENVELOPE_LENGTH, rows);
    }

    fn fixture_directions(&self) -> &'static [usize] {
        &[0, 1, 2]
    }

    fn tool_directions(&self) -> &'static [usize] {
        &[0, 1, 2]
    }

    fn residual_kind(&self) -> ResidualKind {
        ResidualKind::PointOffset
    }
}

/// `p(T · Exp(ξ)) ≈ p + R v`, so row k of the derivative is row k of R.
fn push_centre(fixture_from_tool: &Pose, scale: f64, rows: &mut Residual) {
    let rotation = fixture_from_tool.rotation.to_rotation_matrix();
    for k in 0..3 {
        let row = rotation.matrix().row(k).transpose() * scale;
        rows.push(fixture_from_tool.translation.vector[k] * scale, se3::twist(&row, &nalgebra::Vector3::zeros()));
    }
}

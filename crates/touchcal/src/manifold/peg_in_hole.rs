//! A straight peg in a straight hole: the residual is the exact signed gap.

use super::{ContactManifold, MAX_ROWS, Rows, Shape, Sketch};
use crate::geometry::extrusion::PegAndHole;
use crate::geometry::profile::Profile;
use nalgebra::{Matrix6, Vector3};

use crate::se3::{self, Pose, Twist, twist};

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

/// How near (m) the end of a peg may come to the rim's height before its edges and the rim's take turns in touching.
const AT_RIM: f64 = 0.2e-3;

impl PegInHole {
    /// With an envelope scale of half a millimetre and one degree.
    pub fn new(shapes: PegAndHole) -> Self {
        PegInHole { shapes, translation_scale: TRANSLATION_SCALE, rotation_scale: ROTATION_SCALE }
    }
}

/// Whether the end of a peg that is `radius` wide reaches from below the rim to above it. Edge then rolls over edge, and which features there are depends on the noise.
pub(super) fn is_at_rim(hole_from_peg: &Pose, radius: f64) -> bool {
    let axis = hole_from_peg.rotation * Vector3::z();
    hole_from_peg.translation.z.abs() < radius * axis.xy().norm() + AT_RIM
}

/// Cosine of the angle between normals from which two features are of one wall.
const ALIKE: f64 = 0.95;
/// What the lesser of two distances that are the same but for noise of 1 is made larger by where they differ by `x`: `FLAT · exp(−x²/2)`, which is right on average: 1/√π.
const FLAT: f64 = 0.564_189_583_547_756_3;

/// The features that push in one direction: the nearest, and by how much it is too small on average if others are as near.
struct Wall {
    distance: f64,
    gradient: Twist,
    too_small_by: f64,
}

impl Wall {
    /// Takes another feature into account: with two that are really as near, the nearer one is too near by what noise tells between them.
    fn beside(&mut self, distance: f64, gradient: &Twist, covariance: &Matrix6<f64>) {
        let between = gradient - self.gradient;
        let variance = between.dot(&(covariance * between));
        let x2 = (distance - self.distance).powi(2) / variance.max(f64::MIN_POSITIVE);
        self.too_small_by = self.too_small_by.max(FLAT * variance.sqrt() * (-0.5 * x2).exp());
    }
}

/// Height of a normal below which it is none of a wall: nothing in a hole faces down by more than the peg is tilted. Edges that cross each other a little the wrong
/// way have such normals.
pub(super) const DOWN: f64 = -0.3;

/// Whether two features push in one direction.
fn alike(a: &Twist, b: &Twist) -> bool {
    se3::linear(a).dot(&se3::linear(b)) > ALIKE
}

/// The walls that features are of, each a distance and its gradient, the nearest first.
pub(super) fn push_walls(mut features: Vec<(f64, Twist)>, covariance: &Matrix6<f64>, rows: &mut Rows) {
    features.sort_unstable_by(|(a, _), (b, _)| a.total_cmp(b));
    let mut walls: Vec<Wall> = Vec::new();
    for (distance, gradient) in features {
        match walls.iter_mut().find(|wall| alike(&wall.gradient, &gradient)) {
            Some(wall) => wall.beside(distance, &gradient, covariance),
            None => walls.push(Wall { distance, gradient, too_small_by: 0.0 }),
        }
    }
    walls.iter().take(MAX_ROWS).for_each(|wall| rows.push(wall.distance + wall.too_small_by, wall.gradient));
}

/// The envelope of a hole `depth` (m) deep: its six rows, divided by the scales of translation and rotation.
pub(super) fn push_envelope(hole_from_peg: &Pose, depth: f64, scale: (f64, f64), rows: &mut Rows) {
    let tip = hole_from_peg.translation.vector;
    let outside = Vector3::new(tip.x, tip.y, tip.z - tip.z.clamp(-depth, 0.0));
    let rotation = hole_from_peg.rotation.to_rotation_matrix();
    for axis in 0..3 {
        let direction = rotation.matrix().row(axis).transpose();
        // Within the depth the z row is flat.
        let active = if axis < 2 || outside.z != 0.0 { 1.0 } else { 0.0 };
        rows.push(outside[axis] / scale.0, twist(&(direction * (active / scale.0)), &Vector3::zeros()));
    }
    let vector = se3::rotation_log(&hole_from_peg.rotation);
    let change = se3::rotation_log_jacobian(&vector);
    for axis in 0..3 {
        let row = change.row(axis).transpose() / scale.1;
        rows.push(vector[axis] / scale.1, twist(&Vector3::zeros(), &row));
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

    fn walls(&self, hole_from_peg: &Pose, within: f64, covariance: &Matrix6<f64>, rows: &mut Rows) {
        if is_at_rim(hole_from_peg, self.shapes.peg().bounding_radius()) {
            return;
        }
        let mut features: Vec<(f64, Twist)> = Vec::new();
        self.shapes.visit_below(hole_from_peg, within, |gap| {
            if gap.normal_in_hole.z > DOWN {
                features.push((gap.value, gap.gradient));
            }
        });
        push_walls(features, covariance, rows);
    }

    fn envelope(&self, hole_from_peg: &Pose, rows: &mut Rows) {
        push_envelope(hole_from_peg, self.shapes.depth(), (self.translation_scale, self.rotation_scale), rows);
    }

    fn fixture_directions(&self) -> &'static [usize] {
        &[0, 1, 2, 3, 4, 5]
    }

    fn tool_directions(&self) -> &'static [usize] {
        &[0, 1, 2, 3, 4, 5]
    }

    fn sketch(&self) -> Sketch {
        let prism = |outline: &Profile, from, to| Shape::Prism { outline: outline.vertices().to_vec(), from, to };
        let shapes = &self.shapes;
        Sketch { tool: prism(shapes.peg(), 0.0, shapes.length()), fixture: prism(shapes.hole(), -shapes.depth(), 0.0) }
    }

    fn has_interference(&self) -> bool {
        true
    }
}

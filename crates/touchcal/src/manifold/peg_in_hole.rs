//! A straight peg in a straight hole: the residual is the exact signed gap.

use super::{ContactManifold, MAX_ROWS, Reach, Rows, Shape, Sketch};
use crate::geometry::extrusion::{Gap, PegAndHole};
use crate::geometry::profile::Profile;
use nalgebra::Vector3;

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

    /// Number of the surface that a gap is of.
    fn surface(&self, gap: &Gap, hole_from_peg: &Pose) -> usize {
        let (normal, point) = (gap.normal_in_hole, gap.point_in_hole);
        let axis = normal.iamax();
        let is_at_rim = point.z.abs() < hole_from_peg.inverse_transform_point(&point).z.abs();
        let depth = (-hole_from_peg.translation.z / self.shapes.depth()).clamp(0.0, 1.0);
        let quarter = ((depth * QUARTERS as f64) as usize).min(QUARTERS - 1);
        SURFACES * quarter + 4 * axis + 2 * usize::from(normal[axis] < 0.0) + usize::from(is_at_rim)
    }

    /// Whether the peg's end reaches from below the rim to above it. Edge then rolls over edge, and which features there are depends on the noise.
    fn is_at_rim(&self, hole_from_peg: &Pose) -> bool {
        let axis = hole_from_peg.rotation * Vector3::z();
        let tilted_by = self.shapes.peg().bounding_radius() * axis.xy().norm();
        hole_from_peg.translation.z.abs() < tilted_by + AT_RIM
    }
}

/// Regions of a hole, by how deep the tip is: a peg that is hardly in leans otherwise than one that is deep in.
const QUARTERS: usize = 4;
/// Surfaces of each: those that push in each of six directions, near the peg's tip or at the rim.
const SURFACES: usize = 12;

/// Cosine of the angle between normals from which two features are of one wall.
const ALIKE: f64 = 0.95;
/// Two features of a wall whose distances differ by less than `TOGETHER` standard deviations of the noise between them are as near as each other, by more than `APART` they are not.
const TOGETHER: f64 = 2.0;
const APART: f64 = 4.0;

/// The features that push in one direction: the nearest of them, and the mean of all that are as near but for noise. Noise would choose among those, and the one that it chose
/// is too near.
struct Wall<'g> {
    nearest: &'g Gap,
    weight: f64,
    distance: f64,
    gradient: Twist,
}

impl<'g> Wall<'g> {
    fn new(nearest: &'g Gap) -> Self {
        Wall { weight: 1.0, distance: nearest.value, gradient: nearest.gradient, nearest }
    }

    /// Takes another feature into account.
    fn beside(&mut self, other: &Gap, reach: &Reach) {
        let between = other.gradient - self.nearest.gradient;
        let deviation = reach.covariance(&between, &between).max(f64::MIN_POSITIVE).sqrt();
        let apart = (((other.value - self.nearest.value) / deviation - TOGETHER) / (APART - TOGETHER)).clamp(0.0, 1.0);
        if apart < 1.0 {
            self.weight += 1.0 - apart;
            let share = (1.0 - apart) / self.weight;
            self.distance += share * (other.value - self.distance);
            self.gradient += (other.gradient - self.gradient) * share;
        }
    }
}

/// Height of a normal below which it is none of a wall: nothing in a hole faces down by more than the peg is tilted. Edges that cross each other a little the wrong
/// way have such normals.
const DOWN: f64 = -0.3;

/// Whether two features push in one direction.
fn alike(a: &Twist, b: &Twist) -> bool {
    se3::linear(a).dot(&se3::linear(b)) > ALIKE
}

impl ContactManifold for PegInHole {
    fn name(&self) -> &'static str {
        "peg in hole"
    }

    fn residual(&self, hole_from_peg: &Pose, resolution: f64, rows: &mut Rows) {
        let (value, gradient) = self.shapes.blended_gap(hole_from_peg, resolution);
        rows.push(value, gradient);
    }

    fn walls(&self, hole_from_peg: &Pose, reach: &Reach, rows: &mut Rows) {
        if self.is_at_rim(hole_from_peg) {
            return;
        }
        let mut features: Vec<Gap> = Vec::new();
        let radius = self.shapes.peg().bounding_radius().hypot(self.shapes.depth());
        self.shapes.visit_below(hole_from_peg, reach.farthest(radius), |gap| {
            if gap.normal_in_hole.z > DOWN && reach.holds(gap.value, &gap.gradient) {
                features.push(gap.clone());
            }
        });
        while let Some(nearest) = features.iter().min_by(|a, b| a.value.total_cmp(&b.value)).cloned() {
            let mut wall = Wall::new(&nearest);
            features.retain(|gap| {
                let of_wall = alike(&nearest.gradient, &gap.gradient);
                if of_wall && gap.feature != nearest.feature {
                    wall.beside(gap, reach);
                }
                !of_wall
            });
            rows.push_wall(wall.distance, wall.gradient, self.surface(&nearest, hole_from_peg));
            if rows.len() == MAX_ROWS {
                return;
            }
        }
    }

    fn surfaces(&self) -> (usize, usize) {
        (QUARTERS, SURFACES)
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

    fn sketch(&self) -> Sketch {
        let prism = |outline: &Profile, from, to| Shape::Prism { outline: outline.vertices().to_vec(), from, to };
        let shapes = &self.shapes;
        Sketch { tool: prism(shapes.peg(), 0.0, shapes.length()), fixture: prism(shapes.hole(), -shapes.depth(), 0.0) }
    }

    fn has_interference(&self) -> bool {
        true
    }
}

//! What pegs of every shape have in common in a hole: its walls, near which they are, and the way
//! in.

use nalgebra::{Matrix6, Point3, Vector3};

use super::{MAX_ROWS, Reach, Rows};
use crate::geometry::round::Round;
use crate::geometry::solids::Touch;
use crate::se3::{self, Pose, Twist, twist};

/// Default scale of the envelope's translation rows (m): half a millimetre.
pub const TRANSLATION_SCALE: f64 = 0.5e-3;
/// Default scale of the envelope's rotation rows (rad): one degree.
pub const ROTATION_SCALE: f64 = std::f64::consts::PI / 180.0;

/// How near (m) the end of a peg may come to the rim's height before its edges and the rim's take
/// turns in touching.
const AT_RIM: f64 = 0.2e-3;
/// Regions of a hole, by how deep the tip is: a peg that is hardly in leans otherwise than one that
/// is deep in.
const QUARTERS: usize = 4;
/// Surfaces of each: those that push in each of six directions, near the peg's tip or at the rim;
/// behind these, farther ones of a direction, at either end.
const SURFACES: usize = FARTHER + 2;
const FARTHER: usize = 12;
/// Regions of a hole, and surfaces of each, see
/// [`ContactManifold::surfaces`](super::ContactManifold::surfaces).
pub(super) const PARTS: (usize, usize) = (QUARTERS, SURFACES);

/// Cosine of the angle between normals from which two features are of one wall.
const ALIKE: f64 = 0.95;
/// Two features of a wall whose distances differ by less than `TOGETHER` standard deviations of the
/// noise between them are as near as each other, by more than `APART` they are not.
const TOGETHER: f64 = 2.0;
const APART: f64 = 4.0;
/// Least squared sine of the angle between two walls that may imply one between them.
const LEAST_APART: f64 = 0.05;
/// Share of a wall's standard deviation that counts as none where others imply it.
const LITTLE: f64 = 0.15;
/// Cosine of the angle between normals up to which the farther of two walls may be one with the
/// nearer, which is curved.
const TURNED: f64 = 0.5;
/// Cosine of the angle between that turn and the way from one wall to the other: on a circle it is
/// 1.
const ALONG: f64 = 0.9;
/// Largest radius of such a circle, over the peg's.
const LARGEST: f64 = 1.1;
/// Sine of the angle between turns about two axes below which they are one.
const ONE_AXIS: f64 = 1e-9;
/// Room for as many features near a pose as there mostly are.
const EXPECTED: usize = 32;
/// Height of a normal below which it is none of a wall: nothing in a hole faces down by more than
/// the peg is tilted. Edges that cross each other a little the wrong way have such normals.
const DOWN: f64 = -0.3;

/// A hole and the peg that goes in: frames as in
/// [`PegAndHole`](crate::geometry::extrusion::PegAndHole).
#[derive(Clone, Debug)]
pub(super) struct Hole {
    /// Depth (m).
    pub depth: f64,
    /// Distance (m) of the peg's surface from its axis, at most.
    pub peg_radius: f64,
    /// Which of them are round.
    pub round: Round,
}

impl Hole {
    /// What touches what, in words.
    pub fn name(&self, is_straight: bool) -> &'static str {
        match (self.round.any(), is_straight) {
            (false, true) => "peg in hole",
            (false, false) => "peg in hole, not straight",
            (true, true) => "peg in hole, round",
            (true, false) => "peg in hole, round, not straight",
        }
    }

    /// The derivatives of gaps by twists of the peg in its own frame without what facets of round
    /// parts add: turning about their axes changes no gap. Else noise and the files' facets would
    /// tell how far a round peg has turned.
    pub fn without_turns(&self, hole_from_peg: &Pose) -> impl Fn(Twist) -> Twist + use<> {
        // Lengths in units of the radius, so that a projection is no matter of units.
        let radius = self.peg_radius;
        let scaled = |twist: Twist, scale: f64| se3::twist(&se3::linear(&twist), &(se3::angular(&twist) * scale));
        let about_z = twist(&Vector3::zeros(), &Vector3::z());
        let unit = |turn: Twist| scaled(turn, radius).normalize();
        let of_peg = self.round.peg.then(|| unit(about_z));
        let of_hole = self.round.hole.then(|| unit(se3::adjoint(&hole_from_peg.inverse()) * about_z));
        // None if the axis is the same.
        let left_of_hole = of_hole.and_then(|turn| without(of_peg, turn).try_normalize(ONE_AXIS));
        move |gradient| match (of_peg, left_of_hole) {
            (None, None) => gradient,
            _ => scaled(without(left_of_hole, without(of_peg, scaled(gradient, 1.0 / radius))), radius),
        }
    }

    /// Whether the peg's end reaches from below the rim to above it. Edge then rolls over edge, and
    /// which features there are depends on the noise.
    fn is_at_rim(&self, hole_from_peg: &Pose) -> bool {
        let axis = hole_from_peg.rotation * Vector3::z();
        hole_from_peg.translation.z.abs() < self.peg_radius * axis.xy().norm() + AT_RIM
    }

    /// Number of the surface that a wall is of, where nearer walls have `taken` some. The farther
    /// of two walls of one direction and end moves with the nearer one, as alike corners do: that
    /// it is free does not say how often the nearer one is.
    fn surface(&self, wall: &Touch, hole_from_peg: &Pose, taken: &[usize]) -> usize {
        let (normal, point) = (wall.normal_in_fixture, wall.point_in_fixture);
        let axis = normal.iamax();
        let end = usize::from(is_near_rim(&point, hole_from_peg));
        let depth = (-hole_from_peg.translation.z / self.depth).clamp(0.0, 1.0);
        let quarter = ((depth * QUARTERS as f64) as usize).min(QUARTERS - 1);
        let first = SURFACES * quarter;
        let surface = first + 4 * axis + 2 * usize::from(normal[axis] < 0.0) + end;
        if taken.contains(&surface) { first + FARTHER + end } else { surface }
    }

    /// Pushes the walls that the peg is near, the nearest first. `visit_below(distance, visit)`
    /// calls `visit` for all features nearer than that.
    pub fn push_walls(
        &self,
        hole_from_peg: &Pose,
        reach: &Reach,
        visit_below: impl FnOnce(f64, &mut dyn FnMut(Touch)),
        rows: &mut Rows,
    ) {
        if self.is_at_rim(hole_from_peg) {
            return;
        }
        let mut features: Vec<Feature> = Vec::with_capacity(EXPECTED);
        visit_below(reach.farthest(self.peg_radius.hypot(self.depth)), &mut |touch| {
            let feature = Feature { shaken: reach.covariance * touch.gradient, touch };
            let variance = feature.touch.gradient.dot(&feature.shaken);
            if feature.touch.normal_in_fixture.z > DOWN && reach.holds(feature.touch.value, variance) {
                features.push(feature);
            }
        });
        let mut walls: Vec<Wall> = Vec::with_capacity(MAX_ROWS);
        let nearer = |(_, a): &(usize, &Feature), (_, b): &(usize, &Feature)| a.touch.value.total_cmp(&b.touch.value);
        while let Some((k, _)) = features.iter().enumerate().min_by(nearer) {
            let mut wall = Wall::new(features.swap_remove(k));
            features.retain(|feature| {
                let of_wall = alike(&wall.nearest.touch.gradient, &feature.touch.gradient);
                if of_wall {
                    wall.beside(feature);
                }
                !of_wall
            });
            walls.push(wall);
        }
        for k in (0..walls.len()).rev() {
            if is_implied(k, &walls, &reach.covariance, reach.own_variance) {
                walls.remove(k);
            }
        }
        for k in (1..walls.len()).rev() {
            if walls[..k].iter().any(|nearer| self.is_one_curve(nearer, &walls[k], hole_from_peg)) {
                walls.remove(k);
            }
        }
        let without_turns = self.without_turns(hole_from_peg);
        for wall in walls.iter().take(MAX_ROWS) {
            let surface = self.surface(&wall.nearest.touch, hole_from_peg, rows.surfaces());
            rows.push_wall(wall.distance, without_turns(wall.gradient), surface);
        }
    }

    /// Whether two walls are one that is curved, as in a round hole or in a corner with more radius
    /// than the peg's: a peg touches it in one place at a time. Beside that place it is near in
    /// every contact, and touched in none, as no wall of its own would be.
    fn is_one_curve(&self, a: &Wall, b: &Wall, hole_from_peg: &Pose) -> bool {
        let [a, b] = [a, b].map(|wall| &wall.nearest.touch);
        let turn = b.normal_in_fixture - a.normal_in_fixture;
        let way = b.point_in_fixture - a.point_in_fixture;
        a.normal_in_fixture.dot(&b.normal_in_fixture) > TURNED
            && is_near_rim(&a.point_in_fixture, hole_from_peg) == is_near_rim(&b.point_in_fixture, hole_from_peg)
            && turn.dot(&way).abs() > ALONG * turn.norm() * way.norm()
            && way.norm() < LARGEST * self.peg_radius * turn.norm()
    }

    /// Pushes the envelope's six rows, divided by the scales of translation and rotation.
    pub fn push_envelope(&self, hole_from_peg: &Pose, scale: (f64, f64), rows: &mut Rows) {
        let tip = hole_from_peg.translation.vector;
        let outside = Vector3::new(tip.x, tip.y, tip.z - tip.z.clamp(-self.depth, 0.0));
        let rotation = hole_from_peg.rotation.to_rotation_matrix();
        for axis in 0..3 {
            let direction = rotation.matrix().row(axis).transpose();
            // Within the depth the z row is flat.
            let active = if axis < 2 || outside.z != 0.0 { 1.0 } else { 0.0 };
            rows.push(outside[axis] / scale.0, twist(&(direction * (active / scale.0)), &Vector3::zeros()));
        }
        if self.round.any() {
            return self.push_tilt(hole_from_peg, scale.1, rows);
        }
        let vector = se3::rotation_log(&hole_from_peg.rotation);
        let change = se3::rotation_log_jacobian(&vector);
        for axis in 0..3 {
            let row = change.row(axis).transpose() / scale.1;
            rows.push(vector[axis] / scale.1, twist(&Vector3::zeros(), &row));
        }
    }

    /// Pushes three rows that do not know how far the peg has turned: its axis less that of the
    /// hole.
    fn push_tilt(&self, hole_from_peg: &Pose, scale: f64, rows: &mut Rows) {
        let rotation = hole_from_peg.rotation.to_rotation_matrix();
        for axis in 0..3 {
            let direction = rotation.matrix().row(axis).transpose();
            let of_hole = if axis == 2 { 1.0 } else { 0.0 };
            let row = twist(&Vector3::zeros(), &(Vector3::z().cross(&direction) / scale));
            rows.push((direction.z - of_hole) / scale, row);
        }
    }
}

/// What of a twist is not along another one of length 1.
fn without(along: Option<Twist>, twist: Twist) -> Twist {
    along.map_or(twist, |along| twist - along * along.dot(&twist))
}

/// What a peg may touch, and how the pose's noise moves it.
struct Feature {
    touch: Touch,
    /// The noise's covariance times the gradient.
    shaken: Twist,
}

/// The features that push in one direction: the nearest of them, and the mean of all that are as
/// near but for noise. Noise would choose among those, and the one that it chose is too near.
struct Wall {
    nearest: Feature,
    weight: f64,
    distance: f64,
    gradient: Twist,
}

impl Wall {
    fn new(nearest: Feature) -> Self {
        Wall { weight: 1.0, distance: nearest.touch.value, gradient: nearest.touch.gradient, nearest }
    }

    /// Takes another feature into account.
    fn beside(&mut self, other: &Feature) {
        let (touch, nearest) = (&other.touch, &self.nearest.touch);
        let variance = (touch.gradient - nearest.gradient).dot(&(other.shaken - self.nearest.shaken));
        let deviation = variance.max(f64::MIN_POSITIVE).sqrt();
        let apart = (((touch.value - nearest.value) / deviation - TOGETHER) / (APART - TOGETHER)).clamp(0.0, 1.0);
        if apart < 1.0 {
            self.weight += 1.0 - apart;
            let share = (1.0 - apart) / self.weight;
            self.distance += share * (touch.value - self.distance);
            self.gradient += (touch.gradient - self.gradient) * share;
        }
    }
}

/// Whether wall `k` pushes between two others and is passed only where one of them is: `n = α n_a +
/// β n_b` and `d ≥ α d_a + β d_b`, but for little noise, with neither `α` nor `β` negative. Where
/// peg and hole are rounded alike, a corner's directions are all touched with those of its two
/// sides: as walls of their own they would count the sides again.
fn is_implied(k: usize, walls: &[Wall], covariance: &Matrix6<f64>, own_variance: f64) -> bool {
    let wall = &walls[k];
    let deviation = (wall.gradient.dot(&(covariance * wall.gradient)) + own_variance).sqrt();
    let others = || walls.iter().enumerate().filter(|(other, _)| *other != k).map(|(_, wall)| wall);
    let is_between = |a: &Wall, b: &Wall| {
        let [normal, a_normal, b_normal] = [wall, a, b].map(|wall| se3::linear(&wall.gradient));
        let (by_a, by_b, both) = (normal.dot(&a_normal), normal.dot(&b_normal), a_normal.dot(&b_normal));
        let apart = 1.0 - both * both;
        let (alpha, beta) = ((by_a - both * by_b) / apart, (by_b - both * by_a) / apart);
        if apart < LEAST_APART || alpha < 0.0 || beta < 0.0 {
            return false;
        }
        let beyond = wall.distance - alpha * a.distance - beta * b.distance;
        let left = wall.gradient - a.gradient * alpha - b.gradient * beta;
        beyond > -LITTLE * deviation && left.dot(&(covariance * left)) < (LITTLE * deviation).powi(2)
    };
    others().enumerate().any(|(i, a)| others().skip(i + 1).any(|b| is_between(a, b)))
}

/// Whether a point of the peg's surface, in the hole's frame, is nearer to the rim than to the
/// peg's tip.
fn is_near_rim(point_in_hole: &Point3<f64>, hole_from_peg: &Pose) -> bool {
    point_in_hole.z.abs() < hole_from_peg.inverse_transform_point(point_in_hole).z.abs()
}

/// Whether two features push in one direction.
fn alike(a: &Twist, b: &Twist) -> bool {
    se3::linear(a).dot(&se3::linear(b)) > ALIKE
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A wall that pushes in the plane z = 0 along an angle (rad), at a point of the tool's axis at
    /// that height (m).
    fn wall(angle: f64, distance: f64, height: f64) -> Wall {
        let normal = Vector3::new(angle.cos(), angle.sin(), 0.0);
        let point = Vector3::new(0.0, 0.0, height);
        let touch = Touch {
            value: distance,
            gradient: twist(&normal, &point.cross(&normal)),
            point_in_fixture: point.into(),
            normal_in_fixture: normal,
        };
        Wall::new(Feature { shaken: Twist::zeros(), touch })
    }

    #[test]
    fn walls_between_two_others_are_implied_unless_they_are_nearer() {
        let covariance = Matrix6::from_diagonal(&Twist::new(4e-10, 4e-10, 4e-10, 1e-8, 1e-8, 1e-8));
        let is_implied = |middle: Wall| {
            let walls = [wall(0.0, 10e-6, 0.0), wall(std::f64::consts::FRAC_PI_2, 30e-6, 0.0), middle];
            let found = [0, 1, 2].map(|k| super::is_implied(k, &walls, &covariance, 2e-10));
            assert!(!found[0] && !found[1]);
            found[2]
        };
        let angle = 0.5_f64;
        let on_line = 10e-6 * angle.cos() + 30e-6 * angle.sin();
        assert!(is_implied(wall(angle, on_line, 0.0)));
        assert!(is_implied(wall(angle, on_line + 50e-6, 0.0)));
        assert!(!is_implied(wall(angle, on_line - 10e-6, 0.0)));
        // Noise turns the tool by 0.1 mrad.
        assert!(!is_implied(wall(angle, on_line, 0.2)));
        // Beside the two, not between them.
        assert!(!is_implied(wall(-angle, on_line, 0.0)));
    }

    #[test]
    fn turns_of_round_parts_move_nothing() {
        let pose = Pose::new(Vector3::new(0.3e-3, -0.2e-3, -0.02), Vector3::new(0.01, -0.02, 2.0));
        let of_peg = twist(&Vector3::zeros(), &Vector3::z());
        let of_hole = se3::adjoint(&pose.inverse()) * of_peg;
        let gradient = Twist::new(0.8, -0.6, 0.1, 2e-3, -3e-3, 4e-3);
        for (peg, hole) in [(true, false), (false, true), (true, true)] {
            let parts = Hole { depth: 0.03, peg_radius: 0.01, round: Round { peg, hole } };
            let left = parts.without_turns(&pose)(gradient);
            for (turn, is_round) in [(of_peg, peg), (of_hole, hole)] {
                assert_eq!(left.dot(&turn).abs() < 1e-15, is_round, "{peg} {hole}: {:e}", left.dot(&turn));
            }
        }
        // Concentric, both turns are one.
        let parts = Hole { depth: 0.03, peg_radius: 0.01, round: Round { peg: true, hole: true } };
        let left = parts.without_turns(&Pose::translation(0.0, 0.0, -0.02))(gradient);
        assert_eq!(left, Twist::new(0.8, -0.6, 0.1, 2e-3, -3e-3, 0.0));
    }
}

//! Candidate contacts of a peg in a hole: features that are near, grouped by the direction in which
//! they push.

use nalgebra::Matrix6;

use super::hole::Hole;
use super::surfaces::{is_near_rim, surface_of};
use crate::geometry::SignedGap;
use crate::manifold::gate::Gate;
use crate::manifold::residual::{MAX_ROWS, Residual};
use crate::se3::{self, Pose, Twist};

/// Cosine of the angle between normals from which two features push in one direction.
const ALIKE: f64 = 0.95;
/// Two features of one direction whose distances differ by less than `TOGETHER` standard deviations
/// of the noise between them are as near as each other, by more than `APART` they are not.
const TOGETHER: f64 = 2.0;
const APART: f64 = 4.0;
/// Least squared sine of the angle between two candidates that may imply one between them.
const LEAST_APART: f64 = 0.05;
/// Share of a candidate's standard deviation that counts as none where others imply it.
const LITTLE: f64 = 0.15;
/// Largest part of a candidate's normal out of the plane of the two that imply it: about the
/// sine of the angle within which features push in one direction.
const OUT_OF_PLANE: f64 = 0.3;
/// Cosine of the angle between normals up to which the farther of two candidates may be of one
/// curved surface with the nearer.
const TURNED: f64 = 0.5;
/// Cosine of the angle between that turn and the way from one candidate to the other: on a circle
/// it is 1.
const ALONG: f64 = 0.9;
/// Largest radius of such a circle, over the peg's.
const LARGEST: f64 = 1.1;
/// Room for as many features near a pose as there mostly are.
const EXPECTED: usize = 64;
/// Height of a normal below which it is of no surface: nothing in a hole faces down by more than
/// the peg is tilted. Edges that cross each other a little the wrong way have such normals.
const DOWN: f64 = -0.3;

/// Pushes the candidate contacts that `gate` accepts, the nearest first. `visit_below(cutoff,
/// visit)` calls `visit` for all features nearer than `cutoff` (m).
pub(super) fn push_candidates(
    hole: &Hole,
    hole_from_peg: &Pose,
    gate: &Gate,
    visit_below: impl FnOnce(f64, &mut dyn FnMut(&SignedGap)),
    rows: &mut Residual,
) {
    let mut features: Vec<NearFeature> = Vec::with_capacity(EXPECTED);
    visit_below(gate.cutoff(hole.peg_radius.hypot(hole.depth)), &mut |gap| {
        let covariance_gradient = gate.covariance * gap.gradient;
        let variance = gap.gradient.dot(&covariance_gradient);
        if gap.normal_in_fixture.z > DOWN && gate.accepts(gap.value, &gap.normal_in_fixture, variance) {
            features.push(NearFeature { covariance_gradient, gap: gap.clone() });
        }
    });
    let mut candidates = grouped(&features);
    for k in (0..candidates.len()).rev() {
        if is_implied(k, &candidates, &gate.covariance, gate.own_variance) {
            candidates.remove(k);
        }
    }
    for k in (1..candidates.len()).rev() {
        if candidates[..k].iter().any(|nearer| are_of_one_curve(nearer, &candidates[k], hole, hole_from_peg)) {
            candidates.remove(k);
        }
    }
    let without_axial_rotation = hole.without_axial_rotation(hole_from_peg);
    for candidate in candidates.iter().take(MAX_ROWS) {
        let surface = surface_of(hole, &candidate.nearest.gap, hole_from_peg, rows.surfaces());
        rows.push_candidate(candidate.distance, without_axial_rotation(candidate.gradient), surface);
    }
}

/// The candidates that features make, one for each direction, the nearest first.
fn grouped(features: &[NearFeature]) -> Vec<Candidate<'_>> {
    let mut candidates: Vec<Candidate<'_>> = Vec::with_capacity(MAX_ROWS);
    let mut ungrouped: Vec<&NearFeature> = features.iter().collect();
    let nearer = |(_, a): &(usize, &&NearFeature), (_, b): &(usize, &&NearFeature)| a.gap.value.total_cmp(&b.gap.value);
    while let Some((k, _)) = ungrouped.iter().enumerate().min_by(nearer) {
        let mut candidate = Candidate::new(ungrouped.swap_remove(k));
        ungrouped.retain(|feature| {
            let is_alike = alike(&candidate.nearest.gap.gradient, &feature.gap.gradient);
            if is_alike {
                candidate.merge(feature);
            }
            !is_alike
        });
        candidates.push(candidate);
    }
    candidates
}

/// Whether two candidates are of one curved surface, as in a round hole or in a corner with more
/// radius than the peg's: a peg touches it in one place at a time. Beside that place it is near in
/// every contact, and touched in none, as no surface of its own would be.
fn are_of_one_curve(a: &Candidate<'_>, b: &Candidate<'_>, hole: &Hole, hole_from_peg: &Pose) -> bool {
    let [a, b] = [a, b].map(|candidate| &candidate.nearest.gap);
    let turn = b.normal_in_fixture - a.normal_in_fixture;
    let way = b.point_in_fixture - a.point_in_fixture;
    a.normal_in_fixture.dot(&b.normal_in_fixture) > TURNED
        && is_near_rim(&a.point_in_fixture, hole_from_peg) == is_near_rim(&b.point_in_fixture, hole_from_peg)
        && turn.dot(&way).abs() > ALONG * turn.norm() * way.norm()
        && way.norm() < LARGEST * hole.peg_radius * turn.norm()
}

/// A pair of features that the gate accepts.
struct NearFeature {
    gap: SignedGap,
    /// The covariance of the pose's noise times the gradient.
    covariance_gradient: Twist,
}

/// The features that push in one direction: the nearest of them, and the mean of all that are as
/// near within the noise. Noise would choose among those, and the one chosen is too near.
struct Candidate<'f> {
    nearest: &'f NearFeature,
    weight: f64,
    distance: f64,
    gradient: Twist,
}

impl<'f> Candidate<'f> {
    fn new(nearest: &'f NearFeature) -> Self {
        Candidate { weight: 1.0, distance: nearest.gap.value, gradient: nearest.gap.gradient, nearest }
    }

    /// Takes another feature of this direction into the mean, with less weight the farther it is.
    fn merge(&mut self, other: &NearFeature) {
        let (gap, nearest) = (&other.gap, &self.nearest.gap);
        let variance =
            (gap.gradient - nearest.gradient).dot(&(other.covariance_gradient - self.nearest.covariance_gradient));
        let deviation = variance.max(f64::MIN_POSITIVE).sqrt();
        let apart = (((gap.value - nearest.value) / deviation - TOGETHER) / (APART - TOGETHER)).clamp(0.0, 1.0);
        if apart < 1.0 {
            self.weight += 1.0 - apart;
            let share = (1.0 - apart) / self.weight;
            self.distance += share * (gap.value - self.distance);
            self.gradient += (gap.gradient - self.gradient) * share;
        }
    }
}

/// Whether candidate `k` pushes between two others, near their plane, and is passed only where one
/// of them is: `n = α n_a + β n_b` and `d ≥ α d_a + β d_b`, but for little noise, with
/// neither `α` nor `β` negative. Where peg and hole are rounded alike, a corner's directions are
/// all touched with those of its two sides: as candidates of their own they would count the sides
/// again.
fn is_implied(k: usize, candidates: &[Candidate<'_>], covariance: &Matrix6<f64>, own_variance: f64) -> bool {
    let candidate = &candidates[k];
    let deviation = (candidate.gradient.dot(&(covariance * candidate.gradient)) + own_variance).sqrt();
    let others = || candidates.iter().enumerate().filter(|(other, _)| *other != k).map(|(_, other)| other);
    let is_between = |a: &Candidate<'_>, b: &Candidate<'_>| {
        let [normal, a_normal, b_normal] = [candidate, a, b].map(|each| se3::linear(&each.gradient));
        let (by_a, by_b, both) = (normal.dot(&a_normal), normal.dot(&b_normal), a_normal.dot(&b_normal));
        let apart = 1.0 - both * both;
        let (alpha, beta) = ((by_a - both * by_b) / apart, (by_b - both * by_a) / apart);
        if apart < LEAST_APART || alpha < 0.0 || beta < 0.0 {
            return false;
        }
        let beyond = candidate.distance - alpha * a.distance - beta * b.distance;
        let left = candidate.gradient - a.gradient * alpha - b.gradient * beta;
        let is_in_plane = se3::linear(&left).norm() < OUT_OF_PLANE;
        let is_passed_alike = left.dot(&(covariance * left)) < (LITTLE * deviation).powi(2);
        beyond > -LITTLE * deviation && is_in_plane && is_passed_alike
    };
    others().enumerate().any(|(i, a)| others().skip(i + 1).any(|b| is_between(a, b)))
}

/// Whether two features push in one direction.
fn alike(a: &Twist, b: &Twist) -> bool {
    se3::linear(a).dot(&se3::linear(b)) > ALIKE
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;
    use crate::se3::twist;

    /// A feature that pushes in the plane z = 0 along an angle (rad), at a point of the tool's axis
    /// at that height (m).
    fn feature(angle: f64, distance: f64, height: f64) -> NearFeature {
        let normal = Vector3::new(angle.cos(), angle.sin(), 0.0);
        let point = Vector3::new(0.0, 0.0, height);
        let gap = SignedGap {
            value: distance,
            gradient: twist(&normal, &point.cross(&normal)),
            point_in_fixture: point.into(),
            normal_in_fixture: normal,
        };
        NearFeature { covariance_gradient: Twist::zeros(), gap }
    }

    #[test]
    fn candidates_between_two_others_are_implied_unless_they_are_nearer() {
        let covariance = Matrix6::from_diagonal(&Twist::new(4e-10, 4e-10, 4e-10, 1e-8, 1e-8, 1e-8));
        let is_implied = |middle: NearFeature| {
            let features = [feature(0.0, 10e-6, 0.0), feature(std::f64::consts::FRAC_PI_2, 30e-6, 0.0), middle];
            let candidates = features.each_ref().map(Candidate::new);
            let found = [0, 1, 2].map(|k| super::is_implied(k, &candidates, &covariance, 2e-10));
            assert!(!found[0] && !found[1]);
            found[2]
        };
        let angle = 0.5_f64;
        let on_line = 10e-6 * angle.cos() + 30e-6 * angle.sin();
        assert!(is_implied(feature(angle, on_line, 0.0)));
        assert!(is_implied(feature(angle, on_line + 50e-6, 0.0)));
        assert!(!is_implied(feature(angle, on_line - 10e-6, 0.0)));
        // Noise turns the tool by 0.1 mrad.
        assert!(!is_implied(feature(angle, on_line, 0.2)));
        // A floor, out of the plane of the two; the pose is known better than the shapes.
        let is_implied_at = |elevation: f64| {
            let normal = Vector3::new(angle.cos(), angle.sin(), elevation.tan()).normalize();
            let mut raised = feature(angle, on_line, 0.0);
            raised.gap.gradient = twist(&normal, &Vector3::zeros());
            let features = [feature(0.0, 10e-6, 0.0), feature(std::f64::consts::FRAC_PI_2, 30e-6, 0.0), raised];
            super::is_implied(2, &features.each_ref().map(Candidate::new), &(covariance * 1e-4), 2e-10)
        };
        assert!([1.5_f64, 0.6, 0.35].into_iter().all(|elevation| !is_implied_at(elevation)));
        assert!(is_implied_at(0.0) && is_implied_at(0.25));
        // Beside the two, not between them.
        assert!(!is_implied(feature(-angle, on_line, 0.0)));
    }
}

//! What the measured load says of candidate contacts: which of them bear it.

use crate::manifold::MAX_ROWS;
use crate::se3::{self, Twist};

/// Least normal force of a candidate that bears the load, as a share (1) of the load's force.
/// Friction, the sensor's bias and missing candidates leave smaller shares to free candidates.
const LEAST_SHARE: f64 = 0.3;
/// The same as a share (1) of the sum of all normal forces: those of a wedged tool add up to a
/// small load.
const LEAST_SHARE_OF_SUM: f64 = 0.05;
/// Least lever (m) by which moments are compared with forces.
const LEAST_LEVER: f64 = 1e-3;
/// Weight of a candidate's squared force relative to that of its own row: several candidates may
/// bear the load in many ways.
const RIDGE: f64 = 0.01;
/// Sweeps over the candidates, and the change of a force over the load's at which they end.
const SWEEPS: usize = 50;
const SETTLED: f64 = 1e-3;

/// What the load says of a candidate contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Bearing {
    /// It does not bear the load, and would push against it or across: it is touched only where
    /// another contact presses the tool onto it. So are all candidates where the load is zero.
    Against,
    /// It does not bear the load, but pushes along it.
    Along,
    /// It bears a part of the load.
    Bears,
}

impl Bearing {
    /// Number of classes.
    pub const COUNT: usize = 3;
}

/// What the load `[f; τ]` (N, N m) of the fixture on the tool, in the tool frame about its origin,
/// says of each candidate. Which of them bear it is found by the normal forces `λ ≥ 0` of least
/// `‖load − Gᵀ λ‖² + 0.01 Σ ‖Gⱼ‖² λⱼ²`, with the derivative `Gⱼ` of each candidate's distance by
/// the tool's twist as a row of `gradients` (1, m), and moments over the mean lever of the
/// candidates.
///
/// Friction is not among the forces. It looks like the normal force of another surface, so that
/// bearing is evidence for a contact, not proof: each class of candidates has odds of its own.
/// Which class a candidate is of changes with the pose, and a contact's likelihood then jumps;
/// derivatives are those between jumps.
///
/// Source: the problem is that of Lawson & Hanson, *Solving least squares problems* (1974), chapter
/// 23; the solution is by coordinate descent.
pub(crate) fn bearing(load: &Twist, gradients: &[Twist]) -> [Bearing; MAX_ROWS] {
    let squared_levers = gradients.iter().map(|row| se3::angular(row).norm_squared()).sum::<f64>();
    let lever = (squared_levers / gradients.len().max(1) as f64).sqrt().max(LEAST_LEVER);
    let product = |a: &Twist, b: &Twist| {
        se3::linear(a).dot(&se3::linear(b)) + se3::angular(a).dot(&se3::angular(b)) / lever.powi(2)
    };
    let size = product(load, load).sqrt();
    let mut gram = [[0.0; MAX_ROWS]; MAX_ROWS];
    for (products, row) in gram.iter_mut().zip(gradients) {
        products.iter_mut().zip(gradients).for_each(|(entry, other)| *entry = product(row, other));
    }
    let along: [f64; MAX_ROWS] = std::array::from_fn(|k| gradients.get(k).map_or(0.0, |row| product(row, load)));
    let mut forces = [0.0; MAX_ROWS];
    for _ in 0..SWEEPS {
        let mut change: f64 = 0.0;
        for k in 0..gradients.len() {
            let others = gram[k].iter().zip(&forces).enumerate().filter(|(other, _)| *other != k);
            let borne: f64 = others.map(|(_, (product, force))| force * product).sum();
            let own = (1.0 + RIDGE) * gram[k][k];
            let found = ((along[k] - borne) / own.max(f64::MIN_POSITIVE)).max(0.0);
            change = change.max((found - forces[k]).abs());
            forces[k] = found;
        }
        if change <= SETTLED * size {
            break;
        }
    }
    let least = f64::max(LEAST_SHARE * se3::linear(load).norm(), LEAST_SHARE_OF_SUM * forces.iter().sum::<f64>());
    std::array::from_fn(|k| {
        let is_along = gradients.get(k).is_some_and(|row| se3::linear(row).dot(&se3::linear(load)) > 0.0);
        match (forces[k] > least, is_along) {
            (true, _) => Bearing::Bears,
            (false, true) => Bearing::Along,
            (false, false) => Bearing::Against,
        }
    })
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::Bearing::{Against, Along, Bears};
    use super::*;

    /// Gradient of the distance of the point `at` (m) of the tool along the unit `normal`.
    fn candidate(at: [f64; 3], normal: [f64; 3]) -> Twist {
        let (at, normal) = (Vector3::from(at), Vector3::from(normal));
        se3::twist(&normal, &at.cross(&normal))
    }

    /// A peg of 25 mm width in a hole: two walls that face each other, at its tip and at the rim,
    /// and the floor.
    fn peg() -> [Twist; 5] {
        let walls = [[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]];
        let at = |height: f64, wall: [f64; 3]| candidate([-0.0125 * wall[0], 0.0, height], wall);
        let floor = candidate([0.01, 0.0, 0.0], [0.0, 0.0, 1.0]);
        [at(0.0, walls[0]), at(0.0, walls[1]), at(0.03, walls[0]), at(0.03, walls[1]), floor]
    }

    #[test]
    fn those_that_press_bear() {
        let candidates = peg();
        let found = |forces: [f64; 5]| {
            let load: Twist = candidates.iter().zip(forces).map(|(row, force)| row * force).sum();
            let [tip, facing, rim, facing_rim, floor, _] = bearing(&load, &candidates);
            [tip, facing, rim, facing_rim, floor]
        };
        assert_eq!(found([10.0, 0.0, 0.0, 0.0, 0.0]), [Bears, Against, Along, Against, Against]);
        // Wedged: the moment of the pair tells which walls.
        assert_eq!(found([10.0, 0.0, 0.0, 8.0, 0.0]), [Bears, Against, Along, Bears, Against]);
        assert_eq!(found([0.0, 10.0, 10.0, 0.0, 15.0]), [Against, Bears, Bears, Against, Bears]);
        assert_eq!(found([0.0; 5]), [Against; 5]);
        // Pulled away from all: none bears.
        let pulled = se3::twist(&Vector3::new(0.0, 0.0, -5.0), &Vector3::zeros());
        assert_eq!(bearing(&pulled, &candidates), [Against; MAX_ROWS]);
    }

    /// Friction of 0.25 along a wall looks like a force of the floor, but of less than a third.
    #[test]
    fn friction_does_not_bear() {
        let candidates = peg();
        let along = candidate([-0.0125, 0.0, 0.0], [0.0, 0.0, 1.0]);
        let load = candidates[0] * 10.0 + along * 2.5;
        assert_eq!(bearing(&load, &candidates)[..5], [Bears, Against, Along, Against, Along]);
    }
}

//! Which candidate contacts bear the measured load.
//!
//! Where the load is known the likelihood is of the distances of these candidates alone. A surface
//! that bears a load is touched, whatever the parameters. Whether one of the other surfaces is
//! touched depends on the load in ways that odds do not describe: estimates of joint compliances,
//! and with friction those of encoder offsets, would be biased. The distances of these other
//! surfaces add little information: without them standard deviations are at most a seventh larger.

use crate::manifold::MAX_ROWS;
use crate::se3::{self, Twist};

/// Least normal force of a candidate that bears the load, as a share (1) of the load's force.
/// Friction with a coefficient up to 0.5, the sensor's bias and missing candidates leave smaller
/// shares to free candidates.
const LEAST_SHARE: f64 = 0.5;
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

/// Which of the candidate contacts bear the load `[f; τ]` (N, N m) of the fixture on the tool, in
/// the tool frame about its origin. These are found by the normal forces `λ ≥ 0` of least
/// `‖load − Gᵀ λ‖² + 0.01 Σ ‖Gⱼ‖² λⱼ²`, with the derivative `Gⱼ` of each candidate's distance by
/// the tool's twist as a row of `gradients` (1, m), and moments over the mean lever of the
/// candidates. No candidate bears a load of zero, or one that pulls.
///
/// Friction is not among the forces: it looks like the normal force of another surface.
///
/// Source: the problem is that of Lawson & Hanson, *Solving least squares problems* (1974), chapter
/// 23; the solution is by coordinate descent.
pub(crate) fn bearing(load: &Twist, gradients: &[Twist]) -> [bool; MAX_ROWS] {
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
    forces.map(|force| force > least)
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

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
        let (t, f) = (true, false);
        assert_eq!(found([10.0, 0.0, 0.0, 0.0, 0.0]), [t, f, f, f, f]);
        // Wedged: the moment of the pair tells which walls.
        assert_eq!(found([10.0, 0.0, 0.0, 8.0, 0.0]), [t, f, f, t, f]);
        assert_eq!(found([0.0, 10.0, 10.0, 0.0, 15.0]), [f, t, t, f, t]);
        assert_eq!(found([0.0; 5]), [f; 5]);
        // Pulled away from all: none bears.
        let pulled = se3::twist(&Vector3::new(0.0, 0.0, -5.0), &Vector3::zeros());
        assert_eq!(bearing(&pulled, &candidates), [f; MAX_ROWS]);
    }

    /// Friction of 0.5 along a wall looks like a force of the floor, but of less than half.
    #[test]
    fn friction_does_not_bear() {
        let candidates = peg();
        let along = candidate([-0.0125, 0.0, 0.0], [0.0, 0.0, 1.0]);
        let load = candidates[0] * 10.0 + along * 5.0;
        assert_eq!(bearing(&load, &candidates)[..5], [true, false, false, false, false]);
    }
}

//! Draws from the standard deviations that are declared by default.

use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;

use super::declare::{change_parts, change_positions, encoder_drift, move_fixtures, move_tool, with_hole};
use super::quantity::Quantity;
use crate::estimate::{DEFAULT_DISTANCE_SIGMA, PLAUSIBLE_HARMONIC, PlacePrior, Problem, ShapeTolerance};
use crate::parameter::{Prior, joint_trend};
use crate::robot::JointKind;
use crate::se3::Twist;
use crate::sim::{PartsError, Scenario};

/// Declares `quantity` wrong in `problem` by a draw from its default; see
/// [`Falsification::Drawn`](super::Falsification::Drawn).
pub(super) fn draw(
    problem: &mut Problem,
    scenario: &Scenario,
    quantity: Quantity,
    random: &mut Pcg64,
) -> Result<(), PartsError> {
    match quantity {
        Quantity::FixturePlaces => move_fixtures(problem, || place(PlacePrior::DEFAULT_FIXTURE, random)),
        Quantity::ToolPlace => move_tool(problem, &place(PlacePrior::DEFAULT_TOOL, random)),
        Quantity::Shapes => {
            let ShapeTolerance { clearance, depth, .. } = ShapeTolerance::DEFAULT;
            let (wider, deeper) = (clearance * normal(random), depth * normal(random));
            change_parts(problem, scenario, |parts| with_hole(parts, wider, deeper))?;
        }
        Quantity::Distances => {
            let each = problem.distances.iter_mut();
            each.for_each(|known| known.distance += DEFAULT_DISTANCE_SIGMA * normal(random));
        }
        Quantity::Trends => {
            for (joint, trend) in joint_trend(&problem.robot).iter().enumerate() {
                if let Prior::VarianceComponent { sigma, .. } = trend.prior {
                    encoder_drift(problem, joint, 2.0 * sigma * normal(random));
                }
            }
        }
        Quantity::UnseenEffects => harmonics(problem, random),
        Quantity::Wrench => {}
    }
    Ok(())
}

/// Each encoder of a turning joint reads too much by `a sin(q) + b cos(q)`, with Gaussian `a` and
/// `b` of plausible size.
fn harmonics(problem: &mut Problem, random: &mut Pcg64) {
    let amplitudes = problem.robot.moving().map(|joint| {
        let size = if joint.kind == JointKind::Prismatic { 0.0 } else { PLAUSIBLE_HARMONIC };
        [normal(random), normal(random)].map(|x| size * x)
    });
    let amplitudes: Vec<[f64; 2]> = amplitudes.collect();
    change_positions(problem, |_, q| {
        q.iter_mut().zip(&amplitudes).for_each(|(q, [a, b])| *q += a * q.sin() + b * q.cos());
    });
}

fn place(prior: PlacePrior, random: &mut Pcg64) -> Twist {
    match prior {
        PlacePrior::Gaussian { sigma, sigma_angle } => gaussian_twist(sigma, sigma_angle, random),
        PlacePrior::Fixed | PlacePrior::Flat => Twist::zeros(),
    }
}

/// A twist `[v; ω]` (m, rad) of Gaussian components with these standard deviations.
pub(super) fn gaussian_twist(length: f64, angle: f64, random: &mut Pcg64) -> Twist {
    Twist::from_fn(|k, _| normal(random) * if k < 3 { length } else { angle })
}

/// A standard normal number.
pub(super) fn normal(random: &mut Pcg64) -> f64 {
    StandardNormal.sample(random)
}

//! Parameters that are estimated with the arm and are no part of it.

use super::arm::VARIANCE_COMPONENT_STRENGTH;
use super::definition::{DRIFT_GROUP, Parameter, Prior, TREND_ANGLE_GROUP, TREND_LENGTH_GROUP, Unit};
use super::parameter_id::{DIRECTION_NAMES, ParameterId, WRENCH_NAMES};
use std::ops::RangeInclusive;

use crate::robot::{EncoderTerm, JointKind, Robot};

/// Standard deviation (rad) of the change over a log of an encoder that walks at random, where it
/// is estimated and none is declared: 0.02°.
pub const DEFAULT_WALK_SIGMA: f64 = 0.02 * std::f64::consts::PI / 180.0;
/// Prior standard deviations (rad) of each amplitude of an encoder's harmonics of once and twice a
/// turn.
const HARMONIC_SIGMA: f64 = 0.05 * std::f64::consts::PI / 180.0;
const HARMONIC_2_SIGMA: f64 = 0.02 * std::f64::consts::PI / 180.0;
/// Prior standard deviation of an error of a gear ratio, and a plausible size (1).
const GEAR_RATIO_SIGMA: f64 = 1e-4;
const GEAR_RATIO_SCALE: f64 = 1e-3;
/// Start of the drifts' variance component.
const DRIFT_SIGMA: f64 = 0.05 * std::f64::consts::PI / 180.0;
/// Start of the trends' variance component: half of 0.01° over a log.
const TREND_ANGLE_SIGMA: f64 = 0.005 * std::f64::consts::PI / 180.0;
const TREND_LENGTH_SIGMA: f64 = 5e-6;
/// That start counts little: encoders that do not drift must get none.
const TREND_STRENGTH: f64 = 0.01;
/// Half-waves over the log that the walk of an encoder has: less are a trend. What more would add,
/// an eighth of the rest's variance, is not estimated, but counts in uncertainties up to
/// [`joint_walk_rest`]'s last.
const WALK_HALF_WAVES: RangeInclusive<usize> = 2..=12;
const WALK_REST: RangeInclusive<usize> = 13..=36;
/// Plausible sizes of a bias of the wrench (N, N m) and of an error of its scale (1).
const FORCE_SCALE: f64 = 5.0;
const TORQUE_SCALE: f64 = 0.5;
const WRENCH_SCALE: f64 = 0.1;

/// The error (m) of the declared distance between the fixtures of these names, of index `number` in
/// [`Problem::distances`](crate::estimate::Problem::distances), named `distance.{a}.{b}`, see
/// [`ParameterId::Distance`].
pub fn distance_error(number: usize, [a, b]: [&str; 2]) -> Parameter {
    Parameter::length(format!("distance.{a}.{b}"), ParameterId::Distance(number))
}

/// An encoder offset (rad) for each revolute or continuous joint, base first, that holds in
/// placement number `placement` only, on top of the joint's offset; its prior is a variance
/// component that starts at 0.05°. Placements are numbered from 0 in the order of their first
/// fixture; names are `joint_drift.{joint}.{placement_name}`.
pub fn joint_drift(robot: &Robot, placement: usize, placement_name: &str) -> Vec<Parameter> {
    let revolute = robot.moving().enumerate().filter(|(_, joint)| joint.kind != JointKind::Prismatic);
    let prior =
        Prior::VarianceComponent { sigma: DRIFT_SIGMA, group: DRIFT_GROUP, strength: VARIANCE_COMPONENT_STRENGTH };
    let each = revolute.map(|(i, joint)| {
        let name = format!("joint_drift.{}.{placement_name}", joint.name);
        Parameter::angle(name, ParameterId::JointDrift(placement, i)).with_prior(prior)
    });
    each.collect()
}

/// A linear change of the encoder offset over the log for each moving joint (rad, or m for a
/// prismatic one), base first, named `joint_trend.{joint}`: minus its value at the first contact
/// and plus its value at the last, see [`ParameterId::JointTrend`]. Its prior is a variance
/// component that starts at 0.005°, or 5 µm.
pub fn joint_trend(robot: &Robot) -> Vec<Parameter> {
    let each = robot.moving().enumerate().map(|(i, joint)| {
        let (name, id) = (format!("joint_trend.{}", joint.name), ParameterId::JointTrend(i));
        let (parameter, sigma, group) = match joint.kind {
            JointKind::Prismatic => (Parameter::length(name, id), TREND_LENGTH_SIGMA, TREND_LENGTH_GROUP),
            _ => (Parameter::angle(name, id), TREND_ANGLE_SIGMA, TREND_ANGLE_GROUP),
        };
        parameter.with_prior(Prior::VarianceComponent { sigma, group, strength: TREND_STRENGTH })
    });
    each.collect()
}

/// [`joint_trend`] of each revolute or continuous joint, with this prior standard deviation (rad).
pub fn joint_trend_with_sigma(robot: &Robot, sigma: f64) -> Vec<Parameter> {
    let turning = joint_trend(robot).into_iter().filter(|trend| trend.unit == Unit::Radian);
    turning.map(|trend| trend.with_sigma(sigma)).collect()
}

/// Amplitudes (rad) of two to twelve half-waves of a cosine over the log for the encoder of each
/// revolute or continuous joint, base first, named `joint_walk.{joint}.{half_waves}`, see
/// [`ParameterId::JointWalk`]. Their prior is that of a random walk whose change over the log has
/// the standard deviation `sigma` (rad): `√2 sigma / (kπ)` for `k` half-waves. That of one
/// half-wave is [`joint_trend`], nearly.
///
/// Source: the Karhunen–Loève expansion of Brownian motion about its mean, as in Loève,
/// *Probability theory* (1955), section 34.5.
pub fn joint_walk(robot: &Robot, sigma: f64) -> Vec<Parameter> {
    half_waves(robot, sigma, WALK_HALF_WAVES)
}

/// What [`joint_walk`] leaves out of a walk of the same standard deviation: thirteen to thirty-six
/// half-waves.
pub(crate) fn joint_walk_rest(robot: &Robot, sigma: f64) -> Vec<Parameter> {
    half_waves(robot, sigma, WALK_REST)
}

fn half_waves(robot: &Robot, sigma: f64, numbers: RangeInclusive<usize>) -> Vec<Parameter> {
    let revolute = robot.moving().enumerate().filter(|(_, joint)| joint.kind != JointKind::Prismatic);
    let each = revolute.flat_map(|(i, joint)| {
        numbers.clone().map(move |k| {
            let name = format!("joint_walk.{}.{k}", joint.name);
            let sigma = std::f64::consts::SQRT_2 * sigma / (k as f64 * std::f64::consts::PI);
            Parameter::angle(name, ParameterId::JointWalk(i, k)).with_sigma(sigma)
        })
    });
    each.collect()
}

/// Two amplitudes (rad) of a harmonic of once a turn for the encoder of each revolute or continuous
/// joint, base first, named `joint_harmonic.{joint}.{sin|cos}`, with a prior standard deviation of
/// 0.05°, see [`ParameterId::EncoderError`]: a ring of 120 mm that is 0.05 mm off its axis.
pub fn joint_harmonic(robot: &Robot) -> Vec<Parameter> {
    harmonic(robot, "joint_harmonic", [EncoderTerm::Sine, EncoderTerm::Cosine], HARMONIC_SIGMA)
}

/// Two amplitudes (rad) of a harmonic of twice a turn, as of an oval ring, named
/// `joint_harmonic_2.{joint}.{sin|cos}`, with a prior standard deviation of 0.02°; otherwise as
/// [`joint_harmonic`].
pub fn joint_harmonic_2(robot: &Robot) -> Vec<Parameter> {
    harmonic(robot, "joint_harmonic_2", [EncoderTerm::SecondSine, EncoderTerm::SecondCosine], HARMONIC_2_SIGMA)
}

fn harmonic(robot: &Robot, block: &str, terms: [EncoderTerm; 2], sigma: f64) -> Vec<Parameter> {
    let revolute = robot.moving().enumerate().filter(|(_, joint)| joint.kind != JointKind::Prismatic);
    let each = revolute.flat_map(|(i, joint)| {
        let name = |phase: &str| format!("{block}.{}.{phase}", joint.name);
        let amplitude =
            |phase: &str, term| Parameter::angle(name(phase), ParameterId::EncoderError(i, term)).with_sigma(sigma);
        [amplitude("sin", terms[0]), amplitude("cos", terms[1])]
    });
    each.collect()
}

/// The relative error `r` (1) of the ratio between encoder and joint for each moving joint, base
/// first, named `joint_gear_ratio.{joint}`: the true position is `(1 + r)` times the measured one,
/// about its zero. Its prior standard deviation of 1e-4 is 0.018° over half a turn: teeth give an
/// exact ratio, what remains is that of belts, of screws (0.05 mm in 0.3 m would be 1.7e-4), and of
/// errors of slow change within the range of a joint.
pub fn joint_gear_ratio(robot: &Robot) -> Vec<Parameter> {
    let each = robot.moving().enumerate().map(|(i, joint)| {
        let (name, id) =
            (format!("joint_gear_ratio.{}", joint.name), ParameterId::EncoderError(i, EncoderTerm::GearRatio));
        Parameter {
            name,
            id,
            unit: Unit::One,
            prior: Prior::Gaussian { sigma: GEAR_RATIO_SIGMA },
            scale: GEAR_RATIO_SCALE,
        }
    });
    each.collect()
}

/// Mean measured gap (m), negative in penetration, at contacts with the fixture of index `fixture`
/// in [`Problem::fixtures`](crate::estimate::Problem::fixtures), named `gap_bias.{fixture_name}`,
/// without prior.
pub fn gap_bias(fixture_name: &str, fixture: usize) -> Parameter {
    Parameter::length(format!("gap_bias.{fixture_name}"), ParameterId::GapBias(fixture))
}

/// Gap bias (m), on top of [`gap_bias`], of contacts whose normal, from the fixture into the tool,
/// is nearest to axis direction `k` of the fixture with index `fixture`: 0 to 5 for +x, −x, +y, −y,
/// +z, −z; no contact has another. Named `gap_bias.{fixture_name}.{direction}`, without prior.
pub fn directional_gap_bias(fixture_name: &str, fixture: usize, k: usize) -> Parameter {
    let name = format!("gap_bias.{fixture_name}.{}", DIRECTION_NAMES[k.min(5)]);
    Parameter::length(name, ParameterId::DirectionalGapBias(fixture, k))
}

/// Radius (m) of the edges of the fixture with this index, and of the tool there, beyond the
/// declared, named `edge_radius.{fixture_name}`, without prior. It is not estimated, see
/// [`ParameterId::EdgeRadius`].
pub fn edge_radius(fixture_name: &str, fixture: usize) -> Parameter {
    Parameter::length(format!("edge_radius.{fixture_name}"), ParameterId::EdgeRadius(fixture))
}

/// Bias of component `k` (0 to 5; larger counts as 5) of the measured wrench `[f; τ]` in the tip
/// frame (N, N m), named `wrench_bias.{fx|fy|fz|tx|ty|tz}`, without prior, see
/// [`ParameterId::WrenchBias`].
pub fn wrench_bias(k: usize) -> Parameter {
    let (unit, scale) = if k < 3 { (Unit::Newton, FORCE_SCALE) } else { (Unit::NewtonMeter, TORQUE_SCALE) };
    let (name, id) = (format!("wrench_bias.{}", WRENCH_NAMES[k.min(5)]), ParameterId::WrenchBias(k));
    Parameter { name, id, unit, prior: Prior::Flat, scale }
}

/// Relative error (1) of the scale of the measured wrench, named `wrench_scale`, without prior, see
/// [`ParameterId::WrenchScale`]. It is common to forces and moments, as the gain of a sensor is.
pub fn wrench_scale() -> Parameter {
    let (name, id) = ("wrench_scale".to_owned(), ParameterId::WrenchScale);
    Parameter { name, id, unit: Unit::One, prior: Prior::Flat, scale: WRENCH_SCALE }
}

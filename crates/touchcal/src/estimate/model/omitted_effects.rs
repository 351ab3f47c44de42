//! The effects that a model leaves out, as parameters behind its own.

use super::calibration_model::CalibrationModel;
use super::layout::tool_directions;
use crate::estimate::problem::PlacePrior;
use crate::estimate::result::OmittedEffect;
use crate::parameter::{
    Block, Parameter, ParameterId, joint_compliance, joint_harmonic, joint_origin, joint_trend, segment_strain,
};
use crate::robot::{KinematicParameter, Kinematics};

/// Plausible sizes of what a model leaves out: what it takes for granted of a good arm.
const COMPLIANCE: f64 = 1e-5;
const STRAIN: f64 = 1e-3;
const ORIGIN_LENGTH: f64 = 0.1e-3;
const ORIGIN_ANGLE: f64 = 0.02 * std::f64::consts::PI / 180.0;
const HARMONIC: f64 = 0.01 * std::f64::consts::PI / 180.0;
const TREND: f64 = 0.01 * std::f64::consts::PI / 180.0;

/// An effect that a model leaves out, as parameters of an extended one.
pub(crate) struct OmittedParameters {
    pub effect: OmittedEffect,
    /// Indices in the extended layout.
    pub indices: Vec<usize>,
    /// Plausible size of each, in its unit (SI).
    pub sizes: Vec<f64>,
}

/// The model with the parameters of all effects that it leaves out behind its own, and those; noise
/// and contact modes are the model's.
pub(crate) fn with_omitted_effects<'p>(own: &CalibrationModel<'p>) -> (CalibrationModel<'p>, Vec<OmittedParameters>) {
    let mut parameters: Vec<Parameter> = Vec::new();
    let mut omitted = Vec::new();
    let mut add = |effect: OmittedEffect, more: Vec<Parameter>, size: &dyn Fn(ParameterId) -> f64| {
        let first = own.layout.len() + parameters.len();
        let sizes = more.iter().map(|parameter| size(parameter.id)).collect();
        omitted.push(OmittedParameters { effect, indices: (first..first + more.len()).collect(), sizes });
        parameters.extend(more);
    };
    let (problem, robot) = (own.problem, &own.problem.robot);
    let has = |block: Block| own.layout.parameters.iter().any(|parameter| parameter.id.block() == block);
    let has_torques = robot.gravity().norm() > 0.0 || problem.contacts.has_loads();
    if has_torques && !has(Block::JointCompliance) {
        add(OmittedEffect::JointCompliance, joint_compliance(robot), &|_| COMPLIANCE);
    }
    if !has(Block::SegmentStrain) && !has(Block::JointOrigin) {
        add(OmittedEffect::SegmentStrain, segment_strain(robot), &|_| STRAIN);
    }
    if !has(Block::JointOrigin) {
        add(OmittedEffect::JointOrigin, joint_origin(robot), &|id| twist_size(id, (ORIGIN_LENGTH, ORIGIN_ANGLE)));
    }
    if !has(Block::JointHarmonic) {
        add(OmittedEffect::JointHarmonic, joint_harmonic(robot), &|_| HARMONIC);
    }
    if !has(Block::JointTrend) {
        add(OmittedEffect::JointTrend, joint_trend(robot), &|_| TREND);
    }
    let place = |prior: PlacePrior, effect: OmittedEffect, directions: &[usize], default: PlacePrior| {
        let PlacePrior::Gaussian { sigma, sigma_angle } = default else { return None };
        (prior == PlacePrior::Fixed).then_some((effect, directions.to_vec(), (sigma, sigma_angle)))
    };
    let tool_directions = tool_directions(problem);
    let of_tool = place(problem.tool.prior, OmittedEffect::ToolPlace, &tool_directions, PlacePrior::DEFAULT_TOOL);
    if let Some((effect, directions, sizes)) = of_tool {
        let parameter = |&k: &usize| Parameter::twist("tool", ParameterId::tool(k), k);
        add(effect, directions.iter().map(parameter).collect(), &|id| twist_size(id, sizes));
    }
    for (f, fixture) in problem.fixtures.iter().enumerate() {
        let effect = OmittedEffect::FixturePlace { fixture: fixture.name.clone() };
        let directions = fixture.manifold.fixture_directions();
        let Some((effect, directions, sizes)) = place(fixture.prior, effect, directions, PlacePrior::DEFAULT_FIXTURE)
        else {
            continue;
        };
        let prefix = format!("fixture.{}", fixture.name);
        let parameter = |&k: &usize| Parameter::twist(&prefix, ParameterId::Fixture(f, k), k);
        add(effect, directions.iter().map(parameter).collect(), &|id| twist_size(id, sizes));
    }
    let layout = own.layout.extended(problem, parameters);
    let model = CalibrationModel {
        problem,
        base_from_fixture: own.base_from_fixture.clone(),
        kinematics: Kinematics::new(robot, &layout.kinematic(), problem.tool.tip_from_tool),
        noise: own.noise.clone(),
        mode_priors: own.mode_priors.clone(),
        layout,
    };
    (model, omitted)
}

/// Size of a component of a twist, from that of lengths (m) and that of angles (rad).
fn twist_size(id: ParameterId, (length, angle): (f64, f64)) -> f64 {
    match id {
        ParameterId::Kinematic(KinematicParameter::JointOrigin(_, k) | KinematicParameter::Tool(k))
        | ParameterId::Fixture(_, k)
            if k < 3 =>
        {
            length
        }
        _ => angle,
    }
}

//! The effects that a model leaves out, as parameters behind its own.

use super::calibration_model::CalibrationModel;
use super::layout::{tool_directions, wrench_parameters};
use crate::estimate::problem::{
    DEFAULT_DISTANCE_SIGMA, PLAUSIBLE_HARMONIC, PlacePrior, Problem, ShapeTolerance, WrenchTolerance,
};
use crate::estimate::result::OmittedEffect;
use crate::parameter::{
    Block, Parameter, ParameterId, Prior, distance_error, edge_radius, joint_compliance, joint_harmonic, joint_origin,
    joint_trend, joint_walk, segment_strain,
};
use crate::robot::KinematicParameter;

/// Plausible sizes of what a model leaves out: what it takes for granted of a good arm.
const COMPLIANCE: f64 = 1e-5;
const STRAIN: f64 = 1e-3;
const ORIGIN_LENGTH: f64 = 0.1e-3;
const ORIGIN_ANGLE: f64 = 0.02 * std::f64::consts::PI / 180.0;
const TREND: f64 = 0.01 * std::f64::consts::PI / 180.0;
/// Most half-waves over the log of a random walk that are tested: those that bias an estimate most.
const TESTED_HALF_WAVES: usize = 4;

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
        if more.is_empty() {
            return;
        }
        let first = own.layout.len() + parameters.len();
        let sizes = more.iter().map(|parameter| size(parameter.id)).collect();
        omitted.push(OmittedParameters { effect, indices: (first..first + more.len()).collect(), sizes });
        parameters.extend(more.into_iter().map(|parameter| parameter.with_prior(Prior::Flat)));
    };
    let (problem, robot) = (own.problem, &own.problem.robot);
    let has = |block: Block| own.layout.parameters.iter().any(|parameter| parameter.id.block() == block);
    if has_torques(problem) && !has(Block::JointCompliance) {
        add(OmittedEffect::JointCompliance, joint_compliance(robot), &|_| COMPLIANCE);
    }
    if !has(Block::SegmentStrain) && !has(Block::JointOrigin) {
        add(OmittedEffect::SegmentStrain, segment_strain(robot), &|_| STRAIN);
    }
    if !has(Block::JointOrigin) {
        add(OmittedEffect::JointOrigin, joint_origin(robot), &|id| twist_size(id, (ORIGIN_LENGTH, ORIGIN_ANGLE)));
    }
    if !has(Block::JointHarmonic) {
        add(OmittedEffect::JointHarmonic, joint_harmonic(robot), &|_| PLAUSIBLE_HARMONIC);
    }
    if !has(Block::JointTrend) {
        add(OmittedEffect::JointTrend, joint_trend(robot), &|_| TREND);
    }
    if !has(Block::JointWalk) {
        let is_tested = |id| matches!(id, ParameterId::JointWalk(_, k) if k <= TESTED_HALF_WAVES);
        let walk = joint_walk(robot, TREND).into_iter().filter(|parameter| is_tested(parameter.id));
        let walk: Vec<Parameter> = walk.collect();
        let size = |id| walk.iter().find(|known| known.id == id).and_then(Parameter::prior_sigma).unwrap_or(0.0);
        add(OmittedEffect::JointWalk, walk.clone(), &size);
    }
    let of_tool = exact_directions(problem.tool.prior, &tool_directions(problem));
    let parameter = |k: usize| Parameter::twist("tool", ParameterId::tool(k), k);
    let size = |id| twist_size(id, default_sizes(PlacePrior::DEFAULT_TOOL));
    add(OmittedEffect::ToolPlace, of_tool.into_iter().map(parameter).collect(), &size);
    for (f, fixture) in problem.fixtures.iter().enumerate() {
        let of_fixture = exact_directions(fixture.prior, fixture.manifold.fixture_directions());
        let prefix = format!("fixture.{}", fixture.name);
        let parameter = |k: usize| Parameter::twist(&prefix, ParameterId::Fixture(f, k), k);
        let size = |id| twist_size(id, default_sizes(PlacePrior::DEFAULT_FIXTURE));
        let effect = OmittedEffect::FixturePlace { fixture: fixture.name.clone() };
        add(effect, of_fixture.into_iter().map(parameter).collect(), &size);
        let edges = fixture.has_exact_edges().then(|| edge_radius(&fixture.name, f));
        let effect = OmittedEffect::EdgeRadius { fixture: fixture.name.clone() };
        add(effect, Vec::from_iter(edges), &|_| ShapeTolerance::DEFAULT.edge_radius);
    }
    for (d, distance) in problem.distances.iter().enumerate().filter(|(_, distance)| distance.is_nearly_exact()) {
        let between = [distance.between.0, distance.between.1].map(|f| problem.fixtures[f].name.as_str());
        let effect = OmittedEffect::Distance { between: between.map(str::to_owned) };
        add(effect, vec![distance_error(d, between)], &|_| DEFAULT_DISTANCE_SIGMA);
    }
    let size =
        |id| wrench_parameters(WrenchTolerance::DEFAULT).find(|(known, _)| known.id == id).map_or(0.0, |(_, s)| s);
    add(OmittedEffect::Wrench, exact_wrench(problem), &size);
    (own.extended(parameters), omitted)
}

/// Whether joints bear torques that are known.
fn has_torques(problem: &Problem) -> bool {
    let Problem { robot, contacts, .. } = problem;
    robot.gravity().norm() > 0.0 || contacts.has_loads() || contacts.has_joint_torques()
}

/// Whether anything that changes contacts is declared exact: a place in some direction, or the
/// wrench.
pub(crate) fn has_exact_declarations(problem: &Problem) -> bool {
    let mut of_fixtures = problem.fixtures.iter().map(|fixture| (fixture.prior, fixture.manifold.fixture_directions()));
    !exact_wrench(problem).is_empty()
        || !exact_directions(problem.tool.prior, &tool_directions(problem)).is_empty()
        || of_fixtures.any(|(prior, directions)| !exact_directions(prior, directions).is_empty())
}

/// Parameters of the wrench that are declared exact, where joints deflect under it.
fn exact_wrench(problem: &Problem) -> Vec<Parameter> {
    let each = wrench_parameters(problem.wrench).filter(|(_, sigma)| problem.deflects_under_loads() && *sigma == 0.0);
    each.map(|(parameter, _)| parameter).collect()
}

/// Those of `directions` in which a place is exact.
fn exact_directions(prior: PlacePrior, directions: &[usize]) -> Vec<usize> {
    let is_exact = |k: &usize| match prior {
        PlacePrior::Fixed => true,
        PlacePrior::Gaussian { sigma, sigma_angle } => (if *k < 3 { sigma } else { sigma_angle }) == 0.0,
        PlacePrior::Flat => false,
    };
    directions.iter().copied().filter(is_exact).collect()
}

/// Standard deviations of lengths (m) and angles (rad) of a default prior.
fn default_sizes(prior: PlacePrior) -> (f64, f64) {
    match prior {
        PlacePrior::Gaussian { sigma, sigma_angle } => (sigma, sigma_angle),
        PlacePrior::Fixed | PlacePrior::Flat => (0.0, 0.0),
    }
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

//! A log's model with all parameters that a calibration estimated, and their covariance.

use nalgebra::{DMatrix, DVector};

use crate::estimate::model::{CalibrationModel, LinearizationPoint, uncertain_edges};
use crate::estimate::problem::{Noise, PlacePrior, Problem};
use crate::estimate::result::ParameterPosterior;
use crate::manifold::ResidualKind;
use crate::parameter::{
    Block, Parameter, ParameterId, Prior, gap_bias, joint_backlash, joint_compliance, joint_drift, joint_gear_ratio,
    joint_harmonic, joint_harmonic_2, joint_offset, joint_origin, joint_trend, segment_strain, strain,
};

/// Distance (m) up to which two arms put the tool at the same place.
const SAME_PLACE: f64 = 1e-6;

/// A log's model with all parameters that may be off.
pub(super) struct PredictionModel<'p> {
    pub model: CalibrationModel<'p>,
    /// Parameters (SI) of the arm that is evaluated.
    pub theta: DVector<f64>,
    /// Covariance `Σ` of their errors (SI).
    pub covariance: DMatrix<f64>,
    /// Whether the place of each fixture is bounded, or contacts with it need none.
    pub is_bounded: Vec<bool>,
}

/// Which arm a problem has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ArmOf {
    /// The one that was calibrated: the estimates are still to be applied.
    Nominal,
    /// The one that the calibration found.
    Calibrated,
}

impl<'p> PredictionModel<'p> {
    /// The model of `problem` with the errors that `posterior` leaves, or without one with those of
    /// declared places and shapes and an exact arm.
    ///
    /// Encoders drift anew in each log: their trends and drifts have their priors. Fixtures without
    /// a nominal place have no error of it, since contacts with them are compared with each other.
    pub fn new(problem: &'p Problem, posterior: Option<&ParameterPosterior>, arm: ArmOf) -> Self {
        let own = CalibrationModel::new(problem);
        let edges = uncertain_edges(problem).filter(|edge| !is_of_calibration(edge, problem, posterior));
        let mut model = own.extended(further_parameters(&own, posterior).into_iter().chain(edges));
        if let (Some(sigma), true) = (posterior.and_then(|known| known.noise), problem.noise.is_estimated) {
            model = model.with_noise(&Noise { encoder: sigma.encoder, contact: sigma.contact, is_estimated: true });
        }
        let knowledge = Knowledge::new(&model, posterior);
        let size = model.layout.len();
        let theta = DVector::from_fn(size, |k, _| knowledge.value(k, arm));
        let mut covariance = DMatrix::from_fn(size, size, |k, l| knowledge.covariance(k, l));
        for error in model.shape_errors() {
            if (0..size).all(|k| error[k] == 0.0 || knowledge.indices[k].is_none()) {
                covariance += &error * error.transpose();
            }
        }
        let is_bounded = (0..problem.fixtures.len()).map(|f| knowledge.is_bounded(f)).collect();
        PredictionModel { theta, covariance, is_bounded, model }
    }

    /// Whether the tool is where the arm of `other`, a problem with the same contacts, has it in
    /// all of them.
    pub fn has_arm_of(&self, other: &Problem) -> bool {
        let other = CalibrationModel::new(other);
        let points = [(&self.model, &self.theta), (&other, &DVector::zeros(other.layout.len()))];
        let points = points.map(|(model, theta)| LinearizationPoint::new(model, theta));
        let contacts = &self.model.problem.contacts;
        (0..contacts.len()).all(|i| {
            let place = |point: &LinearizationPoint<'_>| point.base_from_tool(i).translation.vector;
            (place(&points[0]) - place(&points[1])).norm() < SAME_PLACE
        })
    }
}

/// Parameters that `own` lacks: those that the calibration estimated, drifts of the encoders, and
/// the places of all fixtures.
fn further_parameters(own: &CalibrationModel<'_>, posterior: Option<&ParameterPosterior>) -> Vec<Parameter> {
    let (problem, robot) = (own.problem, &own.problem.robot);
    let mut parameters = Vec::new();
    if let Some(posterior) = posterior {
        let tool = (0..6).map(|k| Parameter::twist("tool", ParameterId::tool(k), k)).collect();
        let of_links = [joint_offset(robot), joint_origin(robot), segment_strain(robot)];
        let of_torques = [joint_compliance(robot), joint_backlash(robot)];
        let of_encoders = [joint_harmonic(robot), joint_harmonic_2(robot), joint_gear_ratio(robot), joint_trend(robot)];
        let all = of_links.into_iter().chain(of_torques).chain(of_encoders).chain([vec![strain()], tool]).flatten();
        parameters.extend(all.filter(|parameter| posterior.index(&parameter.name).is_some()));
        let has_drift = ["joint_drift", "joint_trend", "joint_walk"]
            .iter()
            .any(|block| posterior.greatest_prior_sigma(block) > 0.0);
        for (f, fixture) in problem.fixtures.iter().enumerate().filter(|_| has_drift) {
            let placement = own.layout.placement[f];
            if !own.layout.placement[..f].contains(&placement) {
                parameters.extend(joint_drift(robot, placement, &fixture.placement));
            }
        }
    }
    for (f, fixture) in problem.fixtures.iter().enumerate() {
        let prefix = format!("fixture.{}", fixture.name);
        let parameter = |&k: &usize| Parameter::twist(&prefix, ParameterId::Fixture(f, k), k);
        parameters.extend(fixture.manifold.fixture_directions().iter().map(parameter));
    }
    let is_new = |parameter: &Parameter| own.layout.parameters.iter().all(|known| known.id != parameter.id);
    let flat = |parameter: Parameter| parameter.with_prior(Prior::Flat);
    parameters.into_iter().filter(is_new).map(flat).collect()
}

/// Whether the calibration was of contacts with these edges: its estimates are off by them, as
/// these contacts are, and the two cancel.
fn is_of_calibration(edge: &Parameter, problem: &Problem, posterior: Option<&ParameterPosterior>) -> bool {
    let ParameterId::EdgeRadius(f) = edge.id else { return false };
    posterior.is_some_and(|known| known.index(&gap_bias(&problem.fixtures[f].name, f).name).is_some())
}

/// Whether a parameter that no calibration knows is off by as much as its prior says.
fn is_assumed(id: ParameterId) -> bool {
    match id {
        ParameterId::Kinematic(_) => id.block() == Block::Tool,
        ParameterId::GapBias(_) | ParameterId::DirectionalGapBias(..) => false,
        _ => true,
    }
}

/// What is known of the parameters of a model.
struct Knowledge<'a, 'p> {
    model: &'a CalibrationModel<'p>,
    posterior: Option<&'a ParameterPosterior>,
    /// Index in the posterior of each parameter that means the same in this log.
    indices: Vec<Option<usize>>,
}

impl<'a, 'p> Knowledge<'a, 'p> {
    fn new(model: &'a CalibrationModel<'p>, posterior: Option<&'a ParameterPosterior>) -> Self {
        let is_same = |id: ParameterId| match id {
            ParameterId::Fixture(f, _) => model.problem.fixtures[f].base_from_fixture.is_some(),
            ParameterId::JointDrift(..) | ParameterId::JointTrend(_) | ParameterId::JointWalk(..) => false,
            _ => true,
        };
        let index = |parameter: &Parameter| posterior?.index(&parameter.name).filter(|_| is_same(parameter.id));
        let indices = model.layout.parameters.iter().map(index).collect();
        Knowledge { model, posterior, indices }
    }

    fn parameter(&self, k: usize) -> &Parameter {
        &self.model.layout.parameters[k]
    }

    /// Value of parameter `k` (SI) in the arm that is evaluated.
    fn value(&self, k: usize, arm: ArmOf) -> f64 {
        let estimate = || Some(self.posterior?.entries[self.indices[k]?].value);
        let is_applied = match self.parameter(k).id {
            ParameterId::Kinematic(_) | ParameterId::EncoderError(..) | ParameterId::Fixture(..) => {
                arm == ArmOf::Nominal
            }
            ParameterId::GapBias(_) | ParameterId::DirectionalGapBias(..) => true,
            _ => false,
        };
        estimate().filter(|_| is_applied).unwrap_or(0.0)
    }

    fn covariance(&self, k: usize, l: usize) -> f64 {
        let joint = || Some(self.posterior?.covariance[(self.indices[k]?, self.indices[l]?)]);
        let own = || if k == l { self.own_sigma(k).powi(2) } else { 0.0 };
        joint().unwrap_or_else(own)
    }

    /// Standard deviation (SI) of a parameter that the calibration does not know in this log: that
    /// of its prior; none of the arm, and none of gaps at contact, whose shapes have tolerances.
    fn own_sigma(&self, k: usize) -> f64 {
        let parameter = self.parameter(k);
        let prior = parameter.prior_sigma().unwrap_or(0.0);
        let Some(posterior) = self.posterior else { return if is_assumed(parameter.id) { prior } else { 0.0 } };
        let greatest = |block: &str, i: usize| {
            let joint = self.model.problem.robot.moving().nth(i);
            joint.map_or(0.0, |joint| posterior.greatest_prior_sigma(&format!("{block}.{}", joint.name)))
        };
        match parameter.id {
            ParameterId::JointTrend(i) => greatest("joint_trend", i),
            ParameterId::JointDrift(_, i) => {
                let of_log = greatest("joint_trend", i).hypot(greatest("joint_walk", i));
                posterior.greatest_prior_sigma("joint_drift").hypot(of_log)
            }
            id if is_assumed(id) => prior,
            _ => 0.0,
        }
    }

    fn is_bounded(&self, f: usize) -> bool {
        let fixture = &self.model.problem.fixtures[f];
        let parameters = || (0..self.model.layout.len()).filter(|&k| self.is_place_of(f, k));
        fixture.manifold.residual_kind() == ResidualKind::PointOffset
            || fixture.prior != PlacePrior::Flat
            || parameters().all(|k| self.indices[k].is_some())
    }

    fn is_place_of(&self, f: usize, k: usize) -> bool {
        matches!(self.parameter(k).id, ParameterId::Fixture(of, _) if of == f)
    }
}

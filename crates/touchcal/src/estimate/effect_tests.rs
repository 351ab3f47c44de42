//! Tests of what a model leaves out, at the minimum.

use nalgebra::{Cholesky, DMatrix, DVector};

use super::model::{
    CalibrationModel, Curvature, LinearizationPoint, Objective, OmittedParameters, add_distances, add_priors,
    contact_mode_statistics, distance_information, extended_or_own, prior_information, with_omitted_effects,
    with_unestimated_errors,
};
use super::options::WarningThresholds;
use super::result::{EffectTest, EffectValue, Estimate, OmittedEffect, ParameterEstimate, Warning};
use super::search::{SearchState, uses_contact_modes};
use super::uncertainty::{
    CalibratedTool, Derivatives, SAMPLED_POSITIONS, ScoreTest, ToolMotion, curvature_and_squares, score_test,
    tool_jacobians, tool_positions, unseen_changes, workspace_configurations,
};
use crate::parameter::{ParameterId, kinematic_part};
use crate::solver::{FreeParameters, NormalEquations, StopReason};

/// Number of contacts that the tests use, about evenly spread over the log.
const SUBSAMPLE: usize = 6000;
/// Largest number of parameters, with those that are left out, up to which there are tests: memory
/// grows with its square, for each of some dozens of blocks of contacts.
const MAX_PARAMETERS: usize = 400;
/// Standard deviation (m) of the radius of edges that are exact: contacts that are soft look like
/// edges that are rounder.
const EXACT_EDGE_RADIUS_SIGMA: f64 = 0.02e-3;
/// Length (m) by which rotations of the tool count as motion.
const LEVER: f64 = 0.1;
/// Root mean square motion (m) up to which the tool does not move.
const MOTIONLESS: f64 = 1e-6;
/// Radius of the ball that holds 95 % of a Gaussian with equal variances, over the square root of
/// the trace of its covariance: `√(χ²₃(0.95) / 3)`.
const RADIUS: f64 = 1.614;

/// Ratio of variances from which they differ by more than rounding.
const ROUNDING: f64 = 1.0 + 1e-9;

/// A test, and what its effect would do to the model's parameters.
pub(super) struct ModelTest {
    pub test: EffectTest,
    /// Change of the model's own parameters (SI) if the effect were estimated.
    pub change: DVector<f64>,
}

/// Tests of effects that the model leaves out, and what tests would miss.
#[derive(Default)]
pub(super) struct EffectTests {
    /// Those with the least p-value first.
    tests: Vec<ModelTest>,
    /// Covariance (SI) of the model's own parameters by errors of the arm that tests would miss.
    unseen: Option<DMatrix<f64>>,
    /// Effects that contacts cannot test.
    untested: Vec<OmittedEffect>,
}

impl EffectTests {
    /// The outcome of each test, that with the least p-value first.
    pub fn outcomes(&self) -> Vec<EffectTest> {
        self.tests.iter().map(|found| found.test.clone()).collect()
    }
}

/// Score tests of all effects that the model leaves out. None where the minimum was not reached or
/// is none, contacts have no likelihood, or parameters are too many.
pub(super) fn effect_tests(search: &mut SearchState<'_>, estimate: &Estimate) -> EffectTests {
    let problem = search.model.problem;
    if search.termination.reason != StopReason::Converged {
        return EffectTests::default();
    }
    let one_sided = (0..problem.contacts.len()).any(|i| search.model.is_one_sided(i));
    let has_likelihood = uses_contact_modes(search) || !one_sided;
    let extended = with_unestimated_errors(&search.model);
    let (own, errors) = extended_or_own(&search.model, extended.as_ref());
    let (model, omitted) = with_omitted_effects(own);
    let effects: Vec<OmittedEffect> = omitted.iter().map(|omitted| omitted.effect.clone()).collect();
    let is_applicable = has_likelihood
        && problem.has_uncertainty()
        && !problem.contacts.is_empty()
        && model.layout.len() <= MAX_PARAMETERS;
    let found = is_applicable.then(|| score_tests(search, estimate, (&model, omitted), errors)).flatten();
    let mut found = found.unwrap_or_default();
    let is_tested = |effect: &OmittedEffect| found.tests.iter().any(|of_effect| of_effect.test.effect == *effect);
    found.untested = effects.into_iter().filter(|effect| !is_tested(effect)).collect();
    found
}

/// The tests of effects that are parameters of the extended `model`; `errors` are indices and
/// standard deviations (SI) of parameters of it that are off and not estimated. `None` where the
/// cost is not convex: there is no minimum to test at.
fn score_tests(
    search: &mut SearchState<'_>,
    estimate: &Estimate,
    (model, omitted): (&CalibrationModel<'_>, Vec<OmittedParameters>),
    errors: &[(usize, f64)],
) -> Option<EffectTests> {
    let problem = search.model.problem;
    let theta = search.theta.clone().resize_vertically(model.layout.len(), 0.0);
    let stride = model.stride(SUBSAMPLE);
    let mut statistics = contact_mode_statistics(model, &theta, (stride, Curvature::Observed), &mut search.caches);
    statistics.scale(1.0 / stride as f64);
    let known = distance_information(model, &theta) + prior_information(model);
    let free = estimated(search, model, statistics.derivatives.gradient.len());
    let (curvature, squares) = curvature_and_squares(&statistics, &known, &model.mode_priors, &free);
    let at = Derivatives {
        gradient: gradient(model, &theta, &statistics.derivatives.gradient),
        curvature,
        squares,
        error_scores: error_scores(model, errors, &statistics.derivatives.information),
        block_scores: statistics.block_scores,
    };
    Cholesky::new(free.scaled_regular(&at.curvature))?;
    let inverse = free.covariance(&at.curvature);
    let positions = tool_positions(problem);
    let ids: Vec<ParameterId> = model.layout.parameters.iter().map(|parameter| parameter.id).collect();
    let mut kinematics = model.kinematics.clone().with_usual_torques(problem.usual_torques());
    kinematics.set(&kinematic_part(ids.iter().copied().zip(theta.iter().copied())).1);
    let motion = ToolMotion::new(&kinematics, &ids, &positions, problem.error_frame());
    let of_arm = omitted.iter().filter(|omitted| omitted.effect.is_arm_error());
    let changes = of_arm.flat_map(|omitted| unseen_changes(&at, &inverse, (&omitted.indices, &omitted.sizes)));
    let unseen = problem.allows_for_unseen_effects().then(|| {
        // A motion that a task of few poses does not see is an error of the arm all the same.
        let everywhere = workspace_configurations(&problem.robot, SAMPLED_POSITIONS);
        let over_workspace = tool_jacobians(&kinematics, &ids, everywhere.iter().map(Vec::as_slice));
        second_moment(&over_workspace, &changes.collect::<Vec<_>>())
    });
    let unseen = unseen.flatten().map(|moment| moment.view((0, 0), estimate.covariance.shape()).into_owned());
    let mut reported = estimate.clone();
    unseen.iter().for_each(|unseen| reported.covariance += unseen);
    let radius = tool_radius(search, &reported, &positions).hypot(problem.noise.contact);
    let count = omitted.len() as f64;
    let each = omitted.into_iter().filter_map(|omitted| {
        let mut found = score_test(&at, &inverse, (&omitted.indices, &omitted.sizes))?;
        if let OmittedEffect::EdgeRadius { .. } = omitted.effect {
            found = found.allowing_for(omitted.indices[0], EXACT_EDGE_RADIUS_SIGMA);
        }
        let displacement = motion.displacement(&found.change.rows(0, ids.len()).into_owned());
        Some(model_test(model, omitted, found, (count, displacement, radius)))
    });
    let mut tests: Vec<ModelTest> = each.collect();
    tests.sort_by(|a, b| a.test.p_value.total_cmp(&b.test.p_value));
    Some(EffectTests { tests, unseen, untested: Vec::new() })
}

/// Warnings about effects that contacts show. Standard deviations are widened by what those move
/// that keep the tool within its reported region, and by what tests would miss.
pub(super) fn apply_effect_tests(
    estimate: &mut Estimate,
    EffectTests { tests, unseen, untested }: EffectTests,
    thresholds: &WarningThresholds,
) -> Vec<Warning> {
    let mut warnings = Vec::new();
    let parameters = estimate.parameters.len();
    let variance = |covariance: &DMatrix<f64>, k: usize| covariance[(k, k)].max(0.0);
    // What parameters may be off beside their covariance, as by what is fixed.
    let beside = |(k, entry): (usize, &ParameterEstimate)| {
        let own = variance(&estimate.covariance, k);
        entry
            .sigma
            .map(|sigma| sigma * sigma)
            .filter(|square| *square > ROUNDING * own)
            .map_or(0.0, |square| square - own)
    };
    let beside: Vec<f64> = estimate.parameters.iter().enumerate().map(beside).collect();
    unseen.iter().for_each(|unseen| estimate.covariance += unseen);
    for ModelTest { test, change } in tests {
        if test.p_value < thresholds.effect_p_value {
            let usable = test.displacement <= test.radius;
            if usable {
                let change = change.rows(0, parameters);
                estimate.covariance += change * change.transpose();
            }
            let EffectTest { effect, p_value, displacement, .. } = test;
            warnings.push(Warning::OmittedEffect { effect, p_value, displacement, usable });
        }
    }
    estimate.untested.extend(untested.iter().map(OmittedEffect::name));
    for (k, entry) in estimate.parameters.iter_mut().enumerate() {
        let square = variance(&estimate.covariance, k) + beside[k];
        entry.sigma = entry.sigma.map(|sigma| sigma.max(square.sqrt()));
    }
    warnings
}

fn model_test(
    model: &CalibrationModel<'_>,
    omitted: OmittedParameters,
    found: ScoreTest,
    (count, displacement, radius): (f64, f64, f64),
) -> ModelTest {
    let values = omitted.indices.iter().zip(&found.sigma).map(|(&k, &sigma)| EffectValue {
        name: model.layout.parameters[k].name.clone(),
        unit: model.layout.parameters[k].unit,
        value: found.change[k],
        sigma,
    });
    let test = EffectTest {
        values: values.collect(),
        effect: omitted.effect,
        statistic: found.statistic,
        degrees_of_freedom: found.degrees_of_freedom,
        p_value: (found.p_value * count).min(1.0),
        displacement,
        radius,
    };
    ModelTest { test, change: found.change }
}

/// Change of the gradient of contacts, whose `information` has the odds behind the parameters, by
/// each error of the shapes, and by each of `errors`.
fn error_scores(
    model: &CalibrationModel<'_>,
    errors: &[(usize, f64)],
    information: &DMatrix<f64>,
) -> Vec<DVector<f64>> {
    let of_shapes = model.shape_errors().into_iter();
    let of_shapes = of_shapes.map(|error| information * error.resize_vertically(information.nrows(), 0.0));
    of_shapes.chain(errors.iter().map(|&(k, sigma)| information.column(k) * sigma)).collect()
}

/// Gradient of contacts, known distances and priors; that of the odds, which contacts do not enter
/// here, is zero.
fn gradient(model: &CalibrationModel<'_>, theta: &DVector<f64>, of_contacts: &DVector<f64>) -> DVector<f64> {
    let mut declared = NormalEquations::new(model.layout.len());
    add_distances(&LinearizationPoint::new(model, theta), &mut declared);
    add_priors(model, theta, Objective::ContactModes, &mut declared);
    of_contacts + declared.gradient.resize_vertically(of_contacts.len(), 0.0)
}

/// Which of `size` parameters and odds are estimated: those of the model itself, none of what it
/// leaves out, and the odds.
fn estimated(search: &SearchState<'_>, model: &CalibrationModel<'_>, size: usize) -> FreeParameters {
    let own = search.free.scale();
    let scale = |k: usize| match k {
        _ if k < own.len() => own[k],
        _ if k < model.layout.len() => 0.0,
        _ => 1.0,
    };
    FreeParameters::new(DVector::from_fn(size, |k, _| scale(k)))
}

/// Sum of the outer products of `changes` of the parameters (SI), without combinations that move
/// the tool nowhere: a joint's origin turned about its axis, and its offset turned back. `None` if
/// there are none or a number is not finite.
fn second_moment(jacobians: &[DMatrix<f64>], changes: &[DVector<f64>]) -> Option<DMatrix<f64>> {
    let parameters = jacobians.first()?.ncols();
    let own: Vec<DVector<f64>> = changes.iter().map(|change| change.rows(0, parameters).into_owned()).collect();
    if own.is_empty() {
        return None;
    }
    let changes = DMatrix::from_columns(&own);
    let mut squares = DMatrix::zeros(own.len(), own.len());
    for jacobian in jacobians {
        let mut motions = jacobian * &changes;
        motions.rows_mut(3, 3).scale_mut(LEVER);
        squares += motions.tr_mul(&motions) / jacobians.len() as f64;
    }
    if squares.iter().any(|entry| !entry.is_finite()) {
        return None;
    }
    let eigen = squares.symmetric_eigen();
    let moving: Vec<usize> = (0..own.len()).filter(|&k| eigen.eigenvalues[k] > MOTIONLESS.powi(2)).collect();
    let changes = changes * eigen.eigenvectors.select_columns(&moving);
    Some(&changes * changes.transpose())
}

/// Root mean square radius (m) of the tool's 95 % region.
fn tool_radius(search: &SearchState<'_>, estimate: &Estimate, positions: &[Vec<f64>]) -> f64 {
    let problem = search.model.problem;
    CalibratedTool::new(problem, estimate)
        .map_or(0.0, |tool| RADIUS * tool.motion(positions, problem.error_frame()).deviation(&tool.covariance))
}

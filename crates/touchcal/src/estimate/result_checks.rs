//! Warnings about a result.

use std::f64::consts::TAU;

use super::input_checks::input_warnings;
use super::model::{has_exact_declarations, unborne_share};
use super::options::{Method, WarningThresholds};
use super::problem::{Fixture, Problem};
use super::result::{DescentFailure, EffectTest, Estimate, OmittedEffect, ParameterEstimate, Severity, Warning};
use super::search::{SearchState, uses_contact_modes};
use super::uncertainty::{ArmUncertainty, CalibratedTool, tool_positions};
use crate::parameter::{Parameter, ParameterId};
use crate::robot::{JointKind, KinematicParameter};
use crate::se3::Pose;
use crate::solver::{StopReason, Termination};

/// Prior standard deviations from which a rotation of a part is ruled out.
const SYMMETRY_DEVIATIONS: f64 = 5.0;
/// Largest share (0 to 1) of contacts with a load that no surface bears: friction and missing
/// candidates leave some.
const MAX_UNBORNE: f64 = 0.5;
/// Largest noise (m) of contacts that is learned: real arms with backlash and printed sockets leave
/// two millimetres.
const MAX_LEARNED_NOISE: f64 = 10e-3;

/// Standard deviations by which a compliance or a backlash is below 0 from which its torques have
/// the other sign.
const AGAINST_TORQUE: f64 = 5.0;

/// Numbers by which warnings about a result are decided.
pub(super) struct FitStatistics {
    /// Number of residual rows and known distances.
    pub rows: usize,
    /// Share (0 to 1) of contacts that were rejected: of all, and of each fixture's.
    pub rejected_share: f64,
    pub rejected_of_fixtures: Vec<f64>,
    /// Measured over declared standard deviation of the noise (1).
    pub noise_factor: f64,
    /// Number of contacts that carry the information of an independent one; `None` without contact
    /// modes.
    pub design_effect: Option<f64>,
    /// Whether the covariance is that of least gaps, inflated.
    pub has_least_gap_inflation: bool,
    pub arm_uncertainty: ArmUncertainty,
}

/// Warnings about the problem and the result, those that forbid its use first.
pub(super) fn result_warnings(
    search: &SearchState<'_>,
    estimate: &Estimate,
    statistics: &FitStatistics,
) -> Vec<Warning> {
    let problem = search.model.problem;
    if let Some(warnings) = unfinished_descent(search, statistics.rows) {
        return warnings;
    }
    let mut warnings = input_warnings(&search.model);
    warnings.extend(search.contradiction.filter(|_| search.has_excess_scatter).map(|(k, deviations)| {
        let Parameter { name, prior, .. } = &search.model.layout.parameters[k];
        let has_prior = prior.sigma().is_some();
        Warning::ContradictedDeclarations { name: name.clone(), deviations, has_prior }
    }));
    warnings.extend(data_warnings(search, statistics.rows, statistics.arm_uncertainty));
    warnings.extend(fit_warnings(search, statistics, estimate));
    warnings.extend(few_contacts(search));
    if let Some(other) = estimate.competing_minima.first() {
        warnings.push(Warning::CompetingMinimum {
            minima: estimate.competing_minima.len(),
            tool_distance: other.tool_distance,
            parameter: estimate.parameters[other.parameter].parameter.name.clone(),
        });
    }
    if !problem.has_uncertainty() {
        warnings.push(Warning::NoUncertainty);
    }
    warnings.extend(joint_warnings(problem));
    let of_value = |entry: &ParameterEstimate| value_warning(entry, search);
    warnings.extend(estimate.parameters.iter().filter_map(of_value));
    warnings.extend(symmetric_parts(problem, estimate));
    warnings.extend(distance_warnings(search));
    warnings.extend(common_scale(problem, estimate));
    if let Some(motion) = estimate.tool_motion().filter(|_| !problem.tool_is_tip()) {
        warnings.push(Warning::ToolNotInRobot { tip_from_tool: problem.tool.tip_from_tool * motion });
    }
    warnings.extend(deflections_against_torque(problem, estimate));
    if estimate.robot.is_compliant() {
        warnings.push(Warning::ComplianceInRobot);
    }
    warnings.extend(encoder_errors(problem, estimate));
    warnings.extend(contradicted_descent(search, &warnings));
    warnings.sort_by_key(order);
    warnings
}

/// Those that forbid the use of the result first, of them that on the search.
fn order(warning: &Warning) -> (Severity, bool) {
    (warning.severity(), !matches!(warning, Warning::DescentFailed(_)))
}

/// Warnings after a gradient descent that has not converged: where it ended says nothing of the
/// data, so these are warnings about the problem alone.
fn unfinished_descent(search: &SearchState<'_>, rows: usize) -> Option<Vec<Warning>> {
    let problem = search.model.problem;
    let Termination { reason, measured, iterations: steps, .. } = search.termination;
    let decrease = match reason {
        StopReason::Converged | StopReason::Interrupted => return None,
        StopReason::NotFinite => None,
        StopReason::IterationLimit | StopReason::NoDescent => Some(measured),
    };
    if matches!(problem.method, Method::LevenbergMarquardt) {
        return None;
    }
    let mut warnings = vec![Warning::DescentFailed(DescentFailure { steps, decrease }), Warning::NoUncertainty];
    warnings.extend(input_warnings(&search.model));
    warnings.extend(row_warnings(search, rows));
    warnings.extend(joint_warnings(problem));
    warnings.sort_by_key(order);
    Some(warnings)
}

/// A warning where a gradient descent has converged, and contacts or declarations contradict where
/// it ended.
fn contradicted_descent(search: &SearchState<'_>, warnings: &[Warning]) -> Option<Warning> {
    let contradicts = |warning: &Warning| {
        let is_of_end = matches!(
            warning,
            Warning::ManyRejected { .. }
                | Warning::NoiseContradicted { .. }
                | Warning::NotTouching { .. }
                | Warning::Implausible { .. }
                | Warning::FarFromPrior { .. }
        );
        is_of_end && warning.severity() == Severity::Unusable
    };
    let descends = matches!(search.model.problem.method, Method::GradientDescent(_));
    let Termination { measured, iterations: steps, .. } = search.termination;
    let failure = DescentFailure { steps, decrease: Some(measured) };
    (descends && warnings.iter().any(contradicts)).then_some(Warning::DescentFailed(failure))
}

/// Whether the data determine the parameters: `rows` residual rows and known distances, which leave
/// distances between tool positions as uncertain as `arm` says.
pub(super) fn data_warnings(search: &SearchState<'_>, rows: usize, arm: ArmUncertainty) -> Vec<Warning> {
    let mut warnings = row_warnings(search, rows);
    if arm.remaining() > search.model.problem.options.thresholds.arm_uncertainty {
        warnings.push(Warning::ArmUndetermined { before: arm.before, after: arm.after });
    }
    warnings
}

/// Whether there are enough rows, and parameters that are fixed.
fn row_warnings(search: &SearchState<'_>, rows: usize) -> Vec<Warning> {
    let (parameters, problem) = (&search.model.layout.parameters, search.model.problem);
    let mut warnings = Vec::new();
    let without_prior = parameters.iter().filter(|parameter| parameter.prior_sigma().is_none()).count();
    if problem.contacts.is_empty() || rows < without_prior {
        warnings.push(Warning::TooFewContacts { rows, parameters: without_prior });
    }
    let pivots = search.fixed.pivots.iter().map(|&k| &parameters[k]);
    let names: Vec<String> = pivots.map(|pivot| pivot.name.clone()).collect();
    if !names.is_empty() {
        warnings.push(Warning::Unobservable { names });
    }
    warnings
}

/// So few one-sided contacts that their likelihood is not normal about its maximum.
fn few_contacts(search: &SearchState<'_>) -> Option<Warning> {
    let (contacts, enough) =
        (search.model.one_sided_contacts(), search.model.problem.options.thresholds.one_sided_contacts);
    (uses_contact_modes(search) && contacts < enough).then_some(Warning::FewContacts(contacts))
}

/// Whether the contacts fit.
fn fit_warnings(search: &SearchState<'_>, statistics: &FitStatistics, estimate: &Estimate) -> Vec<Warning> {
    let (problem, predictive_check) = (search.model.problem, estimate.predictive_check.as_ref());
    let thresholds = &problem.options.thresholds;
    let mut warnings = Vec::new();
    let (factor, declared) = (statistics.noise_factor, !problem.noise.is_estimated);
    let learned = estimate.noise.contact * factor;
    if factor > thresholds.noise_factor[1] && search.model.has_one_sided_contacts() && declared {
        warnings.push(Warning::NoiseContradicted { factor, declared });
    } else if learned > MAX_LEARNED_NOISE && !declared {
        warnings.push(Warning::NoiseContradicted { factor: learned / problem.noise.contact, declared });
    } else if factor > thresholds.noise_factor[0] {
        warnings.push(Warning::NoiseExceeded { factor, declared });
    }
    let share = statistics.rejected_share;
    if share > thresholds.rejected_share[0] {
        // False rows leave the others' scatter as it is.
        let is_outliers = factor <= thresholds.noise_factor[0];
        let usable = is_outliers && share <= thresholds.rejected_share[1];
        warnings.push(Warning::ManyRejected { fixture: None, share, usable });
    }
    warnings.extend(rejected_fixtures(problem, statistics));
    if let Some(design_effect) = statistics.design_effect.filter(|found| *found > thresholds.design_effect[0]) {
        // What biases all stretches of the log alike, no stretch shows.
        let is_measured = predictive_check.is_some_and(|found| found.p_value < thresholds.prediction_p_value);
        let is_unexplained = search.has_excess_scatter && !problem.allows_for_unseen_effects() && !is_measured;
        // A random walk of encoders correlates errors too. Its score test tells the displacement of
        // the tool.
        let is_walk = |test: &EffectTest| {
            test.effect == OmittedEffect::JointWalk
                && test.p_value < thresholds.effect_p_value
                && test.displacement <= test.radius
        };
        let is_explained = estimate.effect_tests.first().is_some_and(is_walk);
        let is_limited = design_effect < thresholds.design_effect[1] || is_explained;
        let usable = is_limited && !is_unexplained;
        warnings.push(Warning::CorrelatedErrors { design_effect, usable });
    }
    let stride = search.model.stride(problem.options.contact_mode.em_subsample[0]);
    if let Some(share) = unborne_share(&search.model, &search.theta, stride).filter(|&share| share > MAX_UNBORNE) {
        warnings.push(Warning::LoadNotBorne { share });
    }
    let informative = search.informative_share.filter(|_| statistics.has_least_gap_inflation);
    if let Some(informative_fraction) = informative.map(|share| share.of_all) {
        let inflation = problem.options.contact_mode.least_gap_inflation;
        // Without a likelihood nothing that is declared exact can be tested.
        let is_enough = informative_fraction > thresholds.informative_fraction;
        let usable = is_enough && !has_exact_declarations(problem);
        warnings.push(Warning::FewInformativeContacts { informative_fraction, inflation, usable });
    }
    if let Some(found) = predictive_check.filter(|found| found.p_value < thresholds.prediction_p_value) {
        // Without a minimum of the likelihood nothing tells what is wrong in all stretches alike.
        let usable = found.ratio < thresholds.prediction_ratio && !statistics.has_least_gap_inflation;
        warnings.push(Warning::PredictionContradicted { ratio: found.ratio, widening: found.widening, usable });
    }
    warnings
}

/// Fixtures most of whose contacts were rejected, where there are other fixtures: such a fixture is
/// not as it is declared, and no longer contributes to the result.
fn rejected_fixtures(problem: &Problem, statistics: &FitStatistics) -> Vec<Warning> {
    let most = problem.options.thresholds.rejected_share[1];
    let of_fixtures = problem.fixtures.iter().zip(&statistics.rejected_of_fixtures);
    let each = of_fixtures.filter(|(_, share)| **share > most && problem.fixtures.len() > 1);
    let warning = |(fixture, share): (&Fixture, &f64)| Warning::ManyRejected {
        fixture: Some(fixture.name.clone()),
        share: *share,
        usable: false,
    };
    each.map(warning).collect()
}

/// Joints that hardly moved.
fn joint_warnings(problem: &Problem) -> Vec<Warning> {
    let contacts = &problem.contacts;
    let mut warnings = Vec::new();
    for (i, joint) in problem.robot.moving().enumerate() {
        let positions = (0..contacts.len()).map(|c| contacts.q(c)[i]);
        let (least, most) = positions.fold((f64::MAX, f64::MIN), |(a, b), q| (a.min(q), b.max(q)));
        if most - least < problem.options.thresholds.joint_range && !contacts.is_empty() {
            warnings.push(Warning::LittleJointMotion { joint: joint.name.clone(), range: most - least });
        }
    }
    warnings
}

/// A warning if a `value` (SI), the deviation from what was declared, exceeds its standard
/// deviation `sigma` too many times. Where the standard deviation `own` of the estimate is larger,
/// it decides whether the result may be used: what is not estimated, such as worn edges, moves the
/// estimate.
fn far_from_prior(
    name: String,
    value: f64,
    (sigma, own): (f64, f64),
    thresholds: &WarningThresholds,
) -> Option<Warning> {
    let [doubtful, unusable] = thresholds.prior_deviations;
    let deviations = value.abs() / sigma.max(f64::MIN_POSITIVE);
    let usable = value.abs() <= unusable * sigma.max(own);
    (deviations > doubtful).then_some(Warning::FarFromPrior { name, deviations, usable })
}

/// Whether the distances of fixtures are within what was declared.
fn distance_warnings(search: &SearchState<'_>) -> Vec<Warning> {
    let (problem, point) = (search.model.problem, search.point());
    let each = problem.distances.iter().filter_map(|declared| {
        let (a, b) = declared.between;
        let [from, to] = [a, b].map(|f| point.fixtures[f].base_from_fixture.translation.vector);
        let value = (to - from).norm() - declared.distance;
        let name = format!("distance.{}.{}", problem.fixtures[a].name, problem.fixtures[b].name);
        far_from_prior(name, value, (declared.sigma, 0.0), &problem.options.thresholds)
    });
    each.collect()
}

/// Whether displacements `x` of joint origins with priors `σ` all follow the lengths `l` of the
/// arm: the strain `Σ x l/σ² / Σ l²/σ²` has the prior standard deviation `(Σ l²/σ²)^-½`.
fn common_scale(problem: &Problem, estimate: &Estimate) -> Option<Warning> {
    let mut lengths = Vec::new();
    let mut origin = Pose::identity();
    for joint in problem.robot.joints() {
        origin *= joint.parent_from_joint;
        if joint.kind != JointKind::Fixed {
            lengths.push(origin.rotation.inverse() * origin.translation.vector);
            origin = Pose::identity();
        }
    }
    let (mut along, mut information) = (0.0, 0.0);
    for entry in &estimate.parameters {
        if let (ParameterId::Kinematic(KinematicParameter::JointOrigin(i, k @ 0..3)), Some(sigma)) =
            (entry.parameter.id, entry.parameter.prior_sigma())
        {
            along += entry.value * lengths[i][k] / (sigma * sigma);
            information += (lengths[i][k] / sigma).powi(2);
        }
    }
    let deviations = along.abs() / information.max(f64::MIN_POSITIVE).sqrt();
    let [doubtful, unusable] = problem.options.thresholds.common_scale;
    let (strain, usable) = (along / information, deviations <= unusable);
    (deviations > doubtful).then_some(Warning::CommonScale { strain, deviations, usable })
}

/// Rotations of tool and fixtures by which no gap changes, and that their priors do not rule out.
fn symmetric_parts(problem: &Problem, estimate: &Estimate) -> impl Iterator<Item = Warning> {
    let orders = |f: usize| problem.fixtures[f].manifold.rotational_orders();
    let of_tool = move || (0..problem.fixtures.len()).map(|f| orders(f).tool).min().unwrap_or(1);
    estimate.parameters.iter().filter_map(move |entry| {
        let order = match entry.parameter.id {
            ParameterId::Fixture(f, 5) => orders(f).fixture,
            ParameterId::Kinematic(KinematicParameter::Tool(5)) => of_tool(),
            _ => 1,
        };
        let angle = TAU / order as f64;
        let is_possible = entry.parameter.prior_sigma().is_none_or(|sigma| angle < SYMMETRY_DEVIATIONS * sigma);
        (order > 1 && is_possible).then(|| Warning::SymmetricPart { name: entry.parameter.name.clone(), angle })
    })
}

/// Joints that deflect against torques that were measured.
fn deflections_against_torque(problem: &Problem, estimate: &Estimate) -> Vec<Warning> {
    let joint = |i: usize| estimate.robot.moving().nth(i);
    let against = |entry: &ParameterEstimate| {
        let value = match entry.parameter.id.kinematic()? {
            KinematicParameter::JointCompliance(i) => joint(i)?.compliance,
            KinematicParameter::JointBacklash(i) => joint(i)?.backlash,
            _ => return None,
        };
        let deviations = value / entry.sigma?;
        let name = entry.parameter.name.clone();
        (deviations < -AGAINST_TORQUE).then_some(Warning::DeflectionAgainstTorque { name, deviations })
    };
    let is_measured = problem.contacts.has_joint_torques();
    estimate.parameters.iter().filter(|_| is_measured).filter_map(against).collect()
}

/// How far estimated harmonics and gear ratios of the encoders move the tool.
fn encoder_errors(problem: &Problem, estimate: &Estimate) -> Option<Warning> {
    let tool = CalibratedTool::new(problem, estimate)?;
    let change = tool.encoder_errors();
    let displacement = tool.motion(&tool_positions(problem), problem.error_frame()).displacement(&change);
    (displacement > 0.0).then_some(Warning::HarmonicsNotInRobot { displacement })
}

/// Whether a parameter's value is one that a calibration finds.
fn value_warning(entry: &ParameterEstimate, search: &SearchState<'_>) -> Option<Warning> {
    let problem = search.model.problem;
    let thresholds = &problem.options.thresholds;
    let Parameter { name, id, unit, scale, .. } = &entry.parameter;
    let (name, value) = (name.clone(), entry.value);
    let (prior, own) = (entry.parameter.prior_sigma(), entry.sigma.unwrap_or(0.0));
    match id {
        _ if !id.block().is_nuisance() && value.abs() > thresholds.implausible_scales * scale => {
            Some(Warning::Implausible { name, value, unit: *unit })
        }
        ParameterId::GapBias(_) if prior.is_some_and(|prior| value.abs() > thresholds.prior_deviations[0] * prior) => {
            Some(Warning::NotTouching { name, gap: value })
        }
        // A clearance that is declared too wide lets parts float, and one too narrow penetrate.
        // The least of noisy gaps has a bias of its own.
        ParameterId::GapBias(f) if uses_contact_modes(search) => {
            // The standard deviation of the gap has that of the clearance already.
            let clearance = problem.fixtures[*f].tolerance.clearance.max(own);
            let sigma = clearance.hypot(thresholds.exact_gap_share * problem.noise.contact * search.model.noise.factor);
            far_from_prior(name, value, (sigma, 0.0), thresholds)
        }
        // The width of its prior is estimated from all directions. A bias within the tolerance of
        // the shape, or within its own standard deviation, contradicts nothing.
        ParameterId::DirectionalGapBias(f, k) => {
            let tolerance = problem.fixtures[*f].tolerance.towards(*k);
            far_from_prior(name, value, (prior.unwrap_or(0.0).max(tolerance).max(own), 0.0), thresholds)
        }
        _ => far_from_prior(name, value, (prior?, own), thresholds),
    }
}

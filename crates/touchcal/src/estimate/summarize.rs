//! The result at a minimum: verdicts, uncertainty, warnings and a status.

use nalgebra::{DMatrix, DVector};

use super::acceptance::acceptance;
use super::declaration_checks::declaration_warning;
use super::effect_tests::{apply_effect_tests, effect_tests};
use super::evaluate::score;
use super::model::{CalibrationModel, distance_information, whitened_norms};
use super::options::Method;
use super::prediction::held_out;
use super::prior_tests::prior_tests;
use super::problem::Problem;
use super::result::{
    CompetingMinimum, ContactCount, Estimate, NoiseSigma, ParameterEstimate, PredictiveCheck, Severity, Status,
    Verdict, Warning, WorkspaceUncertainty,
};
use super::result_checks::{FitStatistics, result_warnings};
use super::search::{SearchState, residual_prediction, sandwich, uses_contact_modes};
use super::uncertainty::{Posterior, Sandwich, arm_uncertainty, tool_distance, workspace_uncertainty};
use crate::manifold::ContactCache;
use crate::parameter::kinematic_part;
use crate::robot;
use crate::solver::{StopReason, Termination};

/// Smallest mean of ψ′: the loss is then concave for most contacts, and no longer a measure of
/// information.
const MIN_MEAN_SLOPE: f64 = 0.05;
/// Share of the nominal arm's expected error of distances (1) above which the calibrated arm is
/// hardly better.
const LITTLE_IMPROVEMENT: f64 = 0.9;

/// Statistics of the residuals of all contacts at a minimum.
struct PostfitStatistics {
    /// Information `A²/B · Σ JᵀJ` of all contacts, and that of the known distances.
    information: DMatrix<f64>,
    /// Robust weight or rejection of each contact.
    verdicts: Vec<Verdict>,
    /// Measured over declared standard deviation of the residuals.
    noise_factor: f64,
    /// Number of residual rows.
    rows: usize,
}

impl PostfitStatistics {
    fn new(model: &CalibrationModel<'_>, theta: &DVector<f64>, caches: &mut [ContactCache]) -> Self {
        let loss = model.problem.loss;
        let (mut slope, mut square, mut count) = (0.0, 0.0, 0);
        let mut verdicts = Vec::with_capacity(model.problem.contacts.len());
        let (information, norms, dimensions) = whitened_norms(model, theta, caches);
        for (squared, dimension) in norms.into_iter().zip(dimensions.into_iter().map(usize::from)) {
            let weight = loss.weight(squared);
            count += dimension;
            // ψ(r) = w(s) r with s = ‖r‖²: trace of ψ′ is d·w + 2 s w′.
            slope += dimension as f64 * weight + 2.0 * squared * loss.weight_slope(squared);
            square += weight * weight * squared;
            verdicts.push(if weight < model.problem.options.thresholds.rejected_weight {
                Verdict::Rejected { deviations: squared.sqrt() }
            } else {
                Verdict::Used { weight }
            });
        }
        let contacts = verdicts.len().max(1);
        let rows = count.max(1) as f64;
        let expected = loss.gaussian_variance((count + contacts / 2) / contacts);
        let (slope, square) = ((slope / rows).max(MIN_MEAN_SLOPE), square / rows);
        let noise_factor = (square / (slope * slope * expected)).max(0.0).sqrt();
        // The declared noise is a lower bound: a small scatter by chance makes nothing more
        // certain.
        let share = 1.0 / (expected * noise_factor.max(1.0).powi(2));
        let information = information * share + distance_information(model, theta);
        PostfitStatistics { information, verdicts, noise_factor, rows: count }
    }

    fn rejected(&self) -> usize {
        self.verdicts.iter().filter(|verdict| matches!(verdict, Verdict::Rejected { .. })).count()
    }

    /// Share (0 to 1) of the contacts of each fixture that were rejected.
    fn rejected_of_fixtures(&self, problem: &Problem) -> Vec<f64> {
        let mut counts = vec![(0.0, 0.0); problem.fixtures.len()];
        for (i, verdict) in self.verdicts.iter().enumerate() {
            let (rejected, all): &mut (f64, f64) = &mut counts[problem.contacts.fixture(i)];
            *rejected += f64::from(u8::from(matches!(verdict, Verdict::Rejected { .. })));
            *all += 1.0;
        }
        counts.into_iter().map(|(rejected, all)| rejected / all.max(1.0)).collect()
    }
}

/// The posterior, and what widened its covariance.
struct WidenedPosterior {
    posterior: Posterior,
    /// Design effect of one-sided contacts (1), if their marginal likelihood was fitted.
    design_effect: Option<f64>,
    /// Whether the covariance is that of least gaps, times the square of their inflation.
    has_least_gap_inflation: bool,
    predictive_check: Option<PredictiveCheck>,
}

fn posterior(search: &mut SearchState<'_>, postfit: &PostfitStatistics) -> WidenedPosterior {
    let mut posterior = Posterior::new(&search.model, &postfit.information, &search.free, &search.fixed);
    let (covariance, design_effect, predictive_check) = match sandwich(search) {
        Some((Sandwich { covariance, design_effect, .. }, check)) => (covariance, Some(design_effect), check),
        None => (None, None, residual_prediction(search)),
    };
    let has_least_gap_inflation = covariance.is_none() && search.informative_share.is_some();
    if has_least_gap_inflation {
        let inflation = search.model.problem.options.contact_mode.least_gap_inflation.powi(2);
        posterior.covariance *= inflation.max(design_effect.unwrap_or(1.0));
    }
    if let Some(covariance) = covariance {
        posterior.covariance = covariance;
    }
    if let Some(found) = &predictive_check {
        posterior.covariance *= found.widening.powi(2);
    }
    WidenedPosterior { posterior, design_effect, has_least_gap_inflation, predictive_check }
}

/// The result of a search that has ended. `declared` is its problem with all distances, by which
/// contacts are judged that are held out.
pub(super) fn summarize(mut search: SearchState<'_>, declared: &Problem) -> Estimate {
    let postfit = PostfitStatistics::new(&search.model, &search.theta, &mut search.caches);
    let WidenedPosterior { posterior, design_effect, has_least_gap_inflation, predictive_check } =
        posterior(&mut search, &postfit);
    let (model, theta, problem) = (&search.model, &search.theta, search.model.problem);
    // The least of several gaps scatters otherwise than each of them.
    let noise_factor = if uses_contact_modes(&search) { model.noise.mode_factor } else { postfit.noise_factor };
    let has_uncertainty = problem.has_uncertainty();
    let parameters = model.layout.parameters.iter().enumerate().map(|(k, parameter)| ParameterEstimate {
        parameter: parameter.clone(),
        value: theta[k],
        sigma: posterior.sigma(k).filter(|_| has_uncertainty),
        identifiable: posterior.identifiable[k],
    });
    let scales = model.layout.scale();
    let arm_uncertainty =
        arm_uncertainty(problem, &model.layout.parameters, &posterior.covariance_from_scales, &scales);
    let statistics = FitStatistics {
        rows: postfit.rows + problem.distances.len(),
        rejected_share: postfit.rejected() as f64 / postfit.verdicts.len().max(1) as f64,
        rejected_of_fixtures: postfit.rejected_of_fixtures(problem),
        noise_factor,
        design_effect,
        has_least_gap_inflation,
        arm_uncertainty,
    };
    let parameters: Vec<ParameterEstimate> = parameters.collect();
    let (columns, values) = kinematic_part(parameters.iter().map(|entry| (entry.parameter.id, entry.value)));
    let mut estimate = Estimate {
        status: Status::NotUsable,
        covariance: posterior.covariance,
        workspace_uncertainty: None,
        identifiability: posterior.identifiability,
        postfit: score(&search.point()),
        contacts: ContactCount {
            read: problem.contacts.rows_read(),
            used: postfit.verdicts.len() - postfit.rejected(),
            rejected: postfit.rejected(),
        },
        verdicts: postfit.verdicts,
        termination: search.termination,
        warnings: Vec::new(),
        effect_tests: Vec::new(),
        prior_tests: Vec::new(),
        untested: Vec::new(),
        freed_effects: Vec::new(),
        competing_minima: competing_minima(&search, predictive_check.is_some()),
        predictive_check,
        held_out: None,
        acceptance: None,
        noise_factor,
        noise: noise(&search),
        robot: robot::calibrated(&problem.robot, &columns, &values),
        parameters,
    };
    check(&mut estimate, &mut search, &statistics, declared);
    estimate.workspace_uncertainty = workspace_uncertainty(problem, &estimate);
    estimate.warnings.extend(little_improvement(&estimate));
    estimate.status = status(&estimate.termination, &estimate.warnings);
    estimate.acceptance = problem.acceptance.as_ref().map(|asked| acceptance(asked, problem, &estimate));
    estimate
}

/// Tests the estimate, and adds the warnings that follow.
fn check(estimate: &mut Estimate, search: &mut SearchState<'_>, statistics: &FitStatistics, declared: &Problem) {
    let tests = effect_tests(search, estimate);
    estimate.effect_tests = tests.outcomes();
    estimate.warnings.extend(declaration_warning(search));
    estimate.warnings.extend(result_warnings(search, estimate, statistics));
    let of_effects = apply_effect_tests(estimate, tests, &search.model.problem.options.thresholds);
    estimate.warnings.extend(of_effects);
    let (tests, untested) = prior_tests(search, estimate, statistics);
    estimate.prior_tests = tests;
    estimate.untested.extend(untested);
    if estimate.termination.reason == StopReason::Converged && assumes_no_friction(search) {
        estimate.untested.push("friction".to_owned());
    }
    if matches!(declared.method, Method::GradientDescent(_)) {
        // Contacts may well test what the end of a descent, which is no minimum, cannot.
        estimate.untested.clear();
    }
    estimate.held_out = held_out(declared, estimate);
    let contradictions = estimate.held_out.iter().flat_map(|found| found.contradictions.clone());
    estimate.warnings.extend(contradictions.map(Warning::HeldOutContradicted));
    estimate.warnings.sort_by_key(Warning::severity);
}

/// A warning if the calibrated arm is expected to be hardly better than the nominal one.
fn little_improvement(estimate: &Estimate) -> Option<Warning> {
    let WorkspaceUncertainty { distance, nominal_distance, .. } = estimate.workspace_uncertainty?;
    let is_little = nominal_distance > 0.0 && distance > LITTLE_IMPROVEMENT * nominal_distance;
    is_little.then_some(Warning::LittleImprovement { distance, nominal_distance })
}

/// Whether some one-sided contacts have no load that is used: contacts cannot tell then what the
/// tool rests on from what it sticks near.
fn assumes_no_friction(search: &SearchState<'_>) -> bool {
    let model = &search.model;
    let is_used = |i| uses_contact_modes(search) && model.has_load(i);
    (0..model.problem.contacts.len()).any(|i| model.is_one_sided(i) && !is_used(i))
}

/// Minima that contacts do not rule out, with the distance of the tool there from the result's.
fn competing_minima(search: &SearchState<'_>, is_predicted: bool) -> Vec<CompetingMinimum> {
    let (parameters, scales) = (&search.model.layout.parameters, search.model.layout.scale());
    let each = search.competing_minima(is_predicted).map(|other| {
        let change = (&other.theta - &search.theta).component_div(&scales);
        let of_tool = (0..parameters.len()).filter(|&k| parameters[k].id.kinematic().is_some() && scales[k] > 0.0);
        CompetingMinimum {
            values: other.theta.clone(),
            cost_ratio: other.cost_ratio,
            tool_distance: tool_distance(search.model.problem, parameters, &other.theta, &search.theta),
            parameter: of_tool.max_by(|&a, &b| change[a].abs().total_cmp(&change[b].abs())).unwrap_or(0),
        }
    });
    each.collect()
}

/// The noise as declared, or as estimated.
fn noise(search: &SearchState<'_>) -> NoiseSigma {
    let (declared, factor) = (search.model.problem.noise, estimated_noise_factor(search));
    NoiseSigma { encoder: factor * declared.encoder, contact: factor * declared.contact }
}

/// Estimated over declared standard deviation of the noise (1); 1 where it is not estimated.
pub(super) fn estimated_noise_factor(search: &SearchState<'_>) -> f64 {
    let noise = &search.model.noise;
    let of_modes = if uses_contact_modes(search) { noise.mode_factor } else { 1.0 };
    if search.model.problem.noise.is_estimated { noise.factor * of_modes } else { 1.0 }
}

fn status(termination: &Termination, warnings: &[Warning]) -> Status {
    match warnings.first().map(Warning::severity) {
        _ if termination.reason != StopReason::Converged => Status::NotUsable,
        Some(Severity::Unusable) => Status::NotUsable,
        Some(Severity::Doubtful) => Status::Doubtful,
        Some(Severity::Caution) | None => Status::Usable,
    }
}

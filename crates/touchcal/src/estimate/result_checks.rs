//! Warnings about a result.

use super::input_checks::input_warnings;
use super::options::WarningThresholds;
use super::problem::Problem;
use super::result::{Estimate, ParameterEstimate, Warning};
use super::search::SearchState;
use crate::parameter::{Parameter, ParameterId};

/// Numbers by which warnings about a result are decided.
pub(super) struct FitStatistics {
    /// Number of residual rows and known distances.
    pub rows: usize,
    /// Share (0 to 1) of contacts that were rejected.
    pub rejected_share: f64,
    /// Measured over declared standard deviation of the noise (1).
    pub noise_factor: f64,
    /// Number of contacts that carry the information of an independent one; `None` without contact
    /// modes.
    pub design_effect: Option<f64>,
    /// Uncertainty of distances between tool positions after over before the calibration (1).
    pub arm_uncertainty: f64,
}

/// Warnings about the problem and the result, those that forbid its use first.
pub(super) fn result_warnings(
    search: &SearchState<'_>,
    estimate: &Estimate,
    statistics: &FitStatistics,
) -> Vec<Warning> {
    let problem = search.model.problem;
    let mut warnings = input_warnings(&search.model);
    warnings.extend(data_warnings(search, statistics));
    warnings.extend(fit_warnings(search, statistics));
    if problem.has_projection() {
        warnings.push(Warning::NoUncertainty);
    }
    warnings.extend(joint_warnings(problem));
    let of_value = |entry: &ParameterEstimate| value_warning(entry, &problem.options.thresholds);
    warnings.extend(estimate.parameters.iter().filter_map(of_value));
    if let Some(motion) = estimate.tool_motion().filter(|_| !problem.tool_is_tip()) {
        warnings.push(Warning::ToolNotInRobot { tip_from_tool: problem.tool.tip_from_tool * motion });
    }
    if estimate.robot.is_compliant() {
        warnings.push(Warning::ComplianceInRobot);
    }
    warnings.sort_by_key(Warning::severity);
    warnings
}

/// Whether the data determine the parameters.
fn data_warnings(search: &SearchState<'_>, statistics: &FitStatistics) -> Vec<Warning> {
    let (parameters, thresholds) = (&search.model.layout.parameters, &search.model.problem.options.thresholds);
    let mut warnings = Vec::new();
    let without_prior = parameters.iter().filter(|parameter| parameter.prior_sigma().is_none()).count();
    if search.model.problem.contacts.is_empty() || statistics.rows < without_prior {
        warnings.push(Warning::TooFewContacts { rows: statistics.rows, parameters: without_prior });
    }
    if statistics.arm_uncertainty > thresholds.arm_uncertainty {
        warnings.push(Warning::ArmUndetermined { remaining: statistics.arm_uncertainty });
    }
    if !search.fixed.pivots.is_empty() {
        let names = search.fixed.pivots.iter().map(|&k| parameters[k].name.clone()).collect();
        warnings.push(Warning::Unobservable { names });
    }
    warnings
}

/// Whether the contacts fit.
fn fit_warnings(search: &SearchState<'_>, statistics: &FitStatistics) -> Vec<Warning> {
    let problem = search.model.problem;
    let thresholds = &problem.options.thresholds;
    let mut warnings = Vec::new();
    let (factor, declared) = (statistics.noise_factor, !problem.noise.is_estimated);
    if factor > thresholds.noise_factor[1] && search.model.has_one_sided_contacts() && declared {
        warnings.push(Warning::NoiseContradicted { factor });
    } else if factor > thresholds.noise_factor[0] {
        warnings.push(Warning::NoiseExceeded { factor, declared });
    }
    let share = statistics.rejected_share;
    if share > thresholds.rejected_share[0] {
        warnings.push(Warning::ManyRejected { share, usable: share <= thresholds.rejected_share[1] });
    }
    match (statistics.design_effect, search.informative_fraction) {
        (Some(design_effect), _) if design_effect > thresholds.design_effect[0] => {
            let usable = design_effect < thresholds.design_effect[1];
            warnings.push(Warning::CorrelatedErrors { design_effect, usable });
        }
        (None, Some(informative_fraction)) => {
            let inflation = problem.options.contact_mode.least_gap_inflation;
            warnings.push(Warning::FewInformativeContacts { informative_fraction, inflation });
        }
        _ => {}
    }
    if search.has_competing_minimum {
        warnings.push(Warning::CompetingMinimum);
    }
    warnings
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

/// Whether a parameter's value is one that a calibration finds.
fn value_warning(entry: &ParameterEstimate, thresholds: &WarningThresholds) -> Option<Warning> {
    let Parameter { name, id, scale, .. } = &entry.parameter;
    let (name, value) = (name.clone(), entry.value);
    let deviations = entry.parameter.prior_sigma().map_or(0.0, |sigma| value.abs() / sigma);
    match id {
        _ if !id.block().is_nuisance() && value.abs() > thresholds.implausible_scales * scale => {
            Some(Warning::Implausible { name, value })
        }
        ParameterId::GapBias(_) if deviations > thresholds.prior_deviations => {
            Some(Warning::NotTouching { name, gap: value })
        }
        _ if deviations > thresholds.prior_deviations => Some(Warning::FarFromPrior { name, deviations }),
        _ => None,
    }
}

//! Parameters, their correlations, and why some are not determined.

use serde::Serialize;

use crate::estimate::{Estimate, Identifiability, NullDirection, ParameterEstimate, Warning};
use crate::parameter::{Block, Parameter, ParameterId};

/// Largest number of parameters in the correlation matrix.
const MOST_CORRELATED: usize = 100;
/// A parameter belongs to a direction if its component is at least this, relative to the largest.
const SIGNIFICANT: f64 = 0.1;

/// The page's data of the parameters, in SI units.
#[derive(Serialize)]
pub(super) struct Parameters<'a> {
    each: Vec<ParameterEntry<'a>>,
    /// Indices of those in the correlation matrix, and its rows below the diagonal.
    correlated: Vec<usize>,
    correlation: Vec<Vec<f32>>,
    singular_values: &'a [f64],
    rank: usize,
    condition: f64,
    null_space: Vec<String>,
    /// Why the page does not state what the data determine; `None` where it does.
    unknown: Option<&'static str>,
}

#[derive(Serialize)]
struct ParameterEntry<'a> {
    name: &'a str,
    description: String,
    block: &'static str,
    unit: &'static str,
    value: f64,
    sigma: Option<f64>,
    prior_sigma: Option<f64>,
    /// Why the data do not determine it, if they do not.
    undetermined: Option<String>,
}

impl<'a> Parameters<'a> {
    /// The page's data of the parameters of `estimate`.
    pub fn new(estimate: &'a Estimate) -> Self {
        let fixed = estimate.warnings.iter().find_map(|warning| match warning {
            Warning::Unobservable { names } => Some(names.as_slice()),
            _ => None,
        });
        let fixed = fixed.unwrap_or_default();
        let is_stated = estimate.has_identifiability();
        let each = estimate.parameters.iter().enumerate().map(|(k, entry)| {
            let Parameter { name, id, unit, .. } = &entry.parameter;
            ParameterEntry {
                name,
                description: entry.parameter.description(),
                block: id.block().name(),
                unit: unit.symbol(),
                value: entry.value,
                sigma: entry.sigma,
                prior_sigma: entry.parameter.prior_sigma(),
                undetermined: (is_stated && !entry.identifiable).then(|| reason(estimate, k, entry, fixed)),
            }
        });
        let correlated = correlated(estimate);
        let covariance = &estimate.covariance;
        let correlation = |i: usize, j: usize| covariance[(i, j)] / (covariance[(i, i)] * covariance[(j, j)]).sqrt();
        let row = |(a, &i): (usize, &usize)| correlated[..a].iter().map(|&j| rounded(correlation(i, j))).collect();
        let identifiability = &estimate.identifiability;
        Parameters {
            each: each.collect(),
            correlation: correlated.iter().enumerate().map(row).collect(),
            correlated,
            singular_values: &identifiability.singular_values,
            rank: identifiability.rank,
            condition: identifiability.condition,
            null_space: identifiability.null_space.iter().filter(|_| is_stated).map(in_words).collect(),
            unknown: (!is_stated).then_some(Identifiability::UNKNOWN),
        }
    }
}

/// A direction that is not identifiable, and what would determine it.
fn in_words(null: &NullDirection) -> String {
    let remedy = null.remedy.as_ref().map_or_else(String::new, |remedy| format!(" → {remedy}"));
    null.description.clone() + &remedy
}

/// To hundredths.
fn rounded(value: f64) -> f32 {
    ((100.0 * value).round() / 100.0) as f32
}

/// Indices of the parameters of arm, tool and fixtures that have an uncertainty.
fn correlated(estimate: &Estimate) -> Vec<usize> {
    let each = estimate.parameters.iter().enumerate().filter(|(k, entry)| {
        let block = entry.parameter.id.block();
        let is_nuisance = matches!(block, Block::JointDrift | Block::JointTrend | Block::JointWalk | Block::GapBias);
        let of_wrench = matches!(block, Block::WrenchBias | Block::WrenchScale);
        !is_nuisance && !of_wrench && entry.sigma.is_some() && estimate.covariance[(*k, *k)] > 0.0
    });
    each.map(|(k, _)| k).take(MOST_CORRELATED).collect()
}

/// Why the data do not determine parameter `k`.
fn reason(estimate: &Estimate, k: usize, entry: &ParameterEstimate, fixed: &[String]) -> String {
    if matches!(entry.parameter.id, ParameterId::DirectionalGapBias(..)) {
        return "variation between surfaces, a nuisance parameter".to_owned();
    }
    let part =
        |direction: &[(usize, f64)]| direction.iter().find(|(of, _)| *of == k).map_or(0.0, |(_, part)| part.abs());
    let null_space = estimate.identifiability.null_space.iter();
    let directions = null_space.map(|null| (part(&null.direction), &null.description));
    let main = directions.filter(|(part, _)| *part >= SIGNIFICANT).max_by(|(a, _), (b, _)| a.total_cmp(b));
    let what = match (fixed.contains(&entry.parameter.name), entry.parameter.prior_sigma()) {
        (true, _) => "fixed at zero".to_owned(),
        (false, Some(prior)) => {
            let remaining = entry.sigma.map_or(1.0, |sigma| sigma / prior);
            format!("determined by the prior: the standard deviation is {:.0} % of the prior's", 100.0 * remaining)
        }
        (false, None) => "depends on parameters that are fixed".to_owned(),
    };
    match main {
        Some((_, description)) => format!("{what}: {description}"),
        None => what,
    }
}

//! Tests of what is declared with a standard deviation: the posterior against its prior.
//!
//! With a declared quantity `y = A θ` of prior covariance `Σ₀`, the estimate of `y` has the
//! covariance `Σ₀ − A C Aᵀ ≤ Σ₀` about the declared value, with the posterior covariance `C`, if
//! the declaration and the model are right. `yᵀ Σ₀⁻¹ y` over the directions of which contacts
//! determine more than half of the variance is then at most chi-squared distributed, also where `C`
//! is wider than that of the model.
//!
//! Source: Box, *Sampling and Bayes' inference in scientific modelling and robustness* (1980),
//! section 3.

use nalgebra::{Cholesky, DMatrix, DVector};
use statrs::distribution::{ChiSquared, ContinuousCDF};

use super::model::distance_row;
use super::result::{Declaration, DeclaredValue, Estimate, PriorTest};
use super::result_checks::FitStatistics;
use super::search::{SearchState, uses_contact_modes};
use super::uncertainty::{CalibratedTool, tool_positions};
use crate::manifold::AXIS_DIRECTIONS;
use crate::parameter::{Block, ParameterId, Prior, Unit};
use crate::solver::StopReason;

/// Share of the prior variance that contacts leave, up to which a direction is tested.
const MAX_SHARE: f64 = 0.5;

/// Standard deviation (1) of the scatter found over the declared one besides chance: least gaps and
/// contact modes are as far from Gaussian as that.
const MODEL_SIGMA: f64 = 0.025;

/// Something declared, as a linear function of the parameters.
struct DeclaredQuantity {
    declaration: Declaration,
    /// Derivative `A` of the values by the parameters (SI).
    map: DMatrix<f64>,
    values: Vec<DeclaredValue>,
    /// Covariance of the estimates about the declared values, if these are right.
    variance: DMatrix<f64>,
    /// Share of it that contacts may leave in a tested direction.
    max_share: f64,
}

impl DeclaredQuantity {
    /// Values that are priors of the cost.
    fn of_prior(declaration: Declaration, map: DMatrix<f64>, values: Vec<DeclaredValue>) -> Self {
        let variances = values.iter().map(|entry| entry.sigma.powi(2));
        let variance = DMatrix::from_diagonal(&DVector::from_iterator(values.len(), variances));
        DeclaredQuantity { declaration, map, values, variance, max_share: MAX_SHARE }
    }
}

/// Tests of all that is declared with a standard deviation and that contacts determine, the least
/// p-value first, and names of what they do not determine better than is declared. None where the
/// search did not converge, or the estimate has no uncertainty.
pub(super) fn prior_tests(
    search: &SearchState<'_>,
    estimate: &Estimate,
    statistics: &FitStatistics,
) -> (Vec<PriorTest>, Vec<String>) {
    let problem = search.model.problem;
    let tool = CalibratedTool::new(problem, estimate).filter(|_| estimate.termination.reason == StopReason::Converged);
    let Some(tool) = tool else { return (Vec::new(), Vec::new()) };
    let motion = tool.motion(&tool_positions(problem), problem.error_frame());
    let displacement = |change: &DVector<f64>| motion.displacement(&change.select_rows(&tool.indices));
    let shapes = if statistics.has_least_gap_inflation { Vec::new() } else { shapes(search, estimate) };
    let quantities = blocks(search, estimate).into_iter().chain(distances(search)).chain(shapes);
    let each = quantities.filter_map(|quantity| prior_test(quantity, &estimate.covariance, &displacement));
    let all = each.chain(noise_test(search, estimate, statistics));
    let (mut tests, untested): (Vec<PriorTest>, Vec<PriorTest>) = all.partition(|test| test.degrees_of_freedom > 0);
    let count = tests.len() as f64;
    tests.iter_mut().for_each(|test| test.p_value = (test.p_value * count).min(1.0));
    tests.sort_by(|a, b| a.p_value.total_cmp(&b.p_value));
    (tests, untested.into_iter().map(|test| test.declaration.name()).collect())
}

/// The test of one quantity, its p-value not yet corrected; without degrees of freedom if contacts
/// determine none of its directions. `None` if a number is not finite.
fn prior_test(
    quantity: DeclaredQuantity,
    covariance: &DMatrix<f64>,
    displacement: &dyn Fn(&DVector<f64>) -> f64,
) -> Option<PriorTest> {
    let DeclaredQuantity { declaration, map, values, variance, max_share } = quantity;
    let value = DVector::from_iterator(values.len(), values.iter().map(|entry| entry.value));
    let moved = covariance * map.transpose();
    let posterior = &map * &moved;
    if value.is_empty() || !variance.iter().chain(&posterior).chain(&value).all(|entry| entry.is_finite()) {
        return None;
    }
    let factor = Cholesky::new(variance)?.l();
    let whitened = factor.solve_lower_triangular(&value)?;
    let half = factor.solve_lower_triangular(&posterior)?;
    let shares = factor.solve_lower_triangular(&half.transpose())?;
    // Decompositions do not terminate on NaN.
    if !shares.iter().all(|entry| entry.is_finite()) {
        return None;
    }
    let shares = shares.symmetric_eigen();
    let tested: Vec<usize> = (0..value.len()).filter(|&k| shares.eigenvalues[k] < max_share).collect();
    let statistic = tested.iter().map(|&k| shares.eigenvectors.column(k).dot(&whitened).powi(2)).sum();
    let p_value = ChiSquared::new(tested.len() as f64).map_or(1.0, |distribution| distribution.sf(statistic));
    // Given that the values are those declared, the parameters differ by this.
    let is_held = !matches!(declaration, Declaration::Shape { .. });
    let change = Cholesky::new(posterior).filter(|_| is_held).map(|factor| moved * factor.solve(&value));
    let displacement = change.as_ref().map(displacement);
    Some(PriorTest { declaration, statistic, degrees_of_freedom: tested.len(), p_value, values, displacement })
}

/// Parameters with a Gaussian prior: those of a place, of the wrench, and of a block of the arm
/// together.
fn blocks(search: &SearchState<'_>, estimate: &Estimate) -> Vec<DeclaredQuantity> {
    let fixtures = &search.model.problem.fixtures;
    let declaration = |id: ParameterId| match id {
        ParameterId::Fixture(f, _) => Declaration::FixturePlace { fixture: fixtures[f].name.clone() },
        ParameterId::WrenchBias(_) | ParameterId::WrenchScale => Declaration::Wrench,
        _ if id.block() == Block::Tool => Declaration::ToolPlace,
        _ => Declaration::Parameters(id.block()),
    };
    let mut groups: Vec<(Declaration, Vec<usize>)> = Vec::new();
    for (k, entry) in estimate.parameters.iter().enumerate() {
        let id = entry.parameter.id;
        let is_fixed = estimate.covariance[(k, k)] <= 0.0;
        if is_fixed || id.block() == Block::GapBias || !matches!(entry.parameter.prior, Prior::Gaussian { .. }) {
            continue;
        }
        let declaration = declaration(id);
        match groups.iter_mut().find(|(known, _)| *known == declaration) {
            Some((_, members)) => members.push(k),
            None => groups.push((declaration, vec![k])),
        }
    }
    let value = |&k: &usize| {
        let entry = &estimate.parameters[k];
        let sigma = entry.parameter.prior_sigma().unwrap_or_default();
        DeclaredValue { name: entry.parameter.name.clone(), unit: entry.parameter.unit, value: entry.value, sigma }
    };
    let count = estimate.parameters.len();
    let each = groups.into_iter().map(|(declaration, members)| {
        let map = DMatrix::from_fn(members.len(), count, |row, k| f64::from(members[row] == k));
        DeclaredQuantity::of_prior(declaration, map, members.iter().map(value).collect())
    });
    each.collect()
}

/// Declared distances between fixtures that are not nearly exact.
fn distances(search: &SearchState<'_>) -> Vec<DeclaredQuantity> {
    let (problem, point) = (search.model.problem, search.point());
    let each = problem.distances.iter().filter(|declared| !declared.is_nearly_exact()).map(|declared| {
        let (row, length) = distance_row(&point, declared);
        let mut map = DMatrix::zeros(1, search.model.layout.len());
        row.iter().for_each(|&(k, slope)| map[(0, k)] = slope);
        let (a, b) = declared.between;
        let declaration = Declaration::Distance { between: [a, b].map(|f| problem.fixtures[f].name.clone()) };
        let (name, value, sigma) = (declaration.name(), length - declared.distance, declared.sigma);
        let values = vec![DeclaredValue { name, unit: Unit::Meter, value, sigma }];
        DeclaredQuantity::of_prior(declaration, map, values)
    });
    each.collect()
}

/// Mean gaps at contact, of all directions and of each that contacts tell from the others: errors
/// of outline, clearance and depth show in them. The posterior has the standard deviations of
/// shapes already; contacts are softer than exact shapes, each wall and all walls alike.
fn shapes(search: &SearchState<'_>, estimate: &Estimate) -> Vec<DeclaredQuantity> {
    let problem = search.model.problem;
    if !uses_contact_modes(search) {
        return Vec::new();
    }
    let softness = problem.options.thresholds.exact_gap_share * problem.noise.contact * search.model.noise.factor;
    let index = |id: ParameterId| estimate.parameters.iter().position(|entry| entry.parameter.id == id);
    let each = problem.fixtures.iter().enumerate().filter_map(|(f, fixture)| {
        let common = index(ParameterId::GapBias(f))?;
        let is_distinguished = |&(_, k): &(usize, usize)| {
            let prior = estimate.parameters[k].parameter.prior_sigma();
            prior.is_some_and(|prior| estimate.covariance[(k, k)] < MAX_SHARE * prior * prior)
        };
        let directions = (0..AXIS_DIRECTIONS).filter_map(|k| Some((k, index(ParameterId::DirectionalGapBias(f, k))?)));
        let gaps: Vec<(usize, usize)> =
            std::iter::once((0, common)).chain(directions.filter(is_distinguished)).collect();
        let common_value = estimate.parameters[common].value;
        let value = |&(direction, k): &(usize, usize)| DeclaredValue {
            name: estimate.parameters[k].parameter.name.clone(),
            unit: Unit::Meter,
            value: if k == common { common_value } else { common_value + estimate.parameters[k].value },
            sigma: fixture.tolerance.towards(direction),
        };
        let is_part = |row: usize, k: usize| k == common || k == gaps[row].1;
        let (size, count) = (gaps.len(), estimate.parameters.len());
        let map = DMatrix::from_fn(size, count, |row, k| f64::from(is_part(row, k)));
        let soft = DMatrix::identity(size, size).add_scalar(1.0) * softness.powi(2);
        Some(DeclaredQuantity {
            declaration: Declaration::Shape { fixture: fixture.name.clone() },
            variance: &map * &estimate.covariance * map.transpose() + soft,
            map,
            values: gaps.iter().map(value).collect(),
            max_share: f64::INFINITY,
        })
    });
    each.collect()
}

/// Declared noise: whether contacts scatter more. The logarithm of a standard deviation from `n`
/// independent contacts has the variance `1/(2n)`, besides what the model is off.
fn noise_test(search: &SearchState<'_>, estimate: &Estimate, statistics: &FitStatistics) -> Option<PriorTest> {
    if search.model.problem.noise.is_estimated || estimate.contacts.used == 0 {
        return None;
    }
    let independent = estimate.contacts.used as f64 / statistics.design_effect.unwrap_or(1.0).max(1.0);
    let sigma = (0.5 / independent).sqrt().hypot(MODEL_SIGMA);
    let value = statistics.noise_factor;
    let statistic = (value.max(1.0).ln() / sigma).powi(2);
    Some(PriorTest {
        declaration: Declaration::Noise,
        statistic,
        degrees_of_freedom: 1,
        p_value: ChiSquared::new(1.0).ok()?.sf(statistic),
        values: vec![DeclaredValue { name: "noise".to_owned(), unit: Unit::One, value, sigma: value * sigma }],
        displacement: None,
    })
}

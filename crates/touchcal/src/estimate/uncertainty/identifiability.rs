//! What the data determine, and in words what they do not.
//!
//! Parameters of different units are compared in units of their scale: the standard deviation of
//! their prior, or a plausible size without one. In these units the eigenvalues of the information
//! matrix are squared singular values of the whitened Jacobian.

use nalgebra::{DMatrix, DVector, SymmetricEigen};

use crate::estimate::options::IdentifiabilityOptions;
use crate::estimate::result::{Identifiability, NullDirection};
use crate::parameter::{Block, Parameter};
use crate::solver::FreeParameters;

/// Singular values are square roots of eigenvalues: below this share of the largest they are
/// rounding.
const ROUNDING: f64 = 3e-8;
/// Components below this size, relative to the largest of a direction, do not take part in it.
const MIN_COMPONENT: f64 = 1e-3;
/// Largest number of parameters named in one direction.
const MAX_NAMED: usize = 5;
/// Largest number of declarations named that would determine a direction.
const MAX_NAMED_DECLARATIONS: usize = 2;
/// Weight of a nuisance parameter as pivot of a direction against one of the arm, and that of a
/// parameter with a prior: a direction is described by, and resolved by fixing, a parameter of the
/// arm.
const NUISANCE_PIVOT_WEIGHT: f64 = 0.05;
const PRIOR_PIVOT_WEIGHT: f64 = 1e-3;
/// Pivots below this size are rounding.
const MIN_PIVOT: f64 = 1e-9;

/// Analyses the information matrix of the data (upper and lower triangle, SI); fixed parameters are
/// left out.
pub(crate) fn identifiability(
    information: &DMatrix<f64>,
    parameters: &[Parameter],
    free: &FreeParameters,
    options: &IdentifiabilityOptions,
) -> Identifiability {
    let indices: Vec<usize> = free.indices().collect();
    let (singular_values, basis) = spectrum(information, free, &indices);
    let rank = rank(&singular_values, options.min_singular_value);
    let condition = match rank {
        0 => f64::INFINITY,
        _ => singular_values[0] / singular_values[rank - 1],
    };
    let null = basis.columns(rank, indices.len() - rank).into_owned();
    let reduced = reduced_basis(&null, |row| {
        if parameters[indices[row]].id.block().is_nuisance() { NUISANCE_PIVOT_WEIGHT } else { 1.0 }
    });
    let null_space = reduced.iter().map(|part| describe(part, &indices, parameters)).collect();
    Identifiability { singular_values, rank, condition, null_space }
}

/// Parameters to fix at zero so that the rest are determined: one pivot for each direction that
/// neither data nor priors determine, preferably one of the arm: the places of tool and fixtures
/// then absorb what cannot be told apart.
#[derive(Clone, Debug, Default)]
pub(crate) struct GaugeFix {
    /// Indices of the parameters to fix.
    pub pivots: Vec<usize>,
    /// For each such direction the indices of the parameters that take part in it, with how far
    /// each moves, in its scale, if the one that is fixed moves by its scale.
    pub participants: Vec<(usize, f64)>,
}

impl GaugeFix {
    /// How far parameter `k` may be off, in its scale (1), if what is fixed is off by its scale.
    pub fn share(&self, k: usize) -> f64 {
        self.participants.iter().filter(|(index, _)| *index == k).map(|(_, size)| size * size).sum::<f64>().sqrt()
    }
}

/// Finds the parameters to fix, from the information of data and priors together.
pub(crate) fn gauge_fix(
    information: &DMatrix<f64>,
    parameters: &[Parameter],
    free: &FreeParameters,
    options: &IdentifiabilityOptions,
) -> GaugeFix {
    let indices: Vec<usize> = free.indices().collect();
    let (singular_values, basis) = spectrum(information, free, &indices);
    let rank = rank(&singular_values, options.min_bounded_singular_value);
    let null = basis.columns(rank, indices.len() - rank).into_owned();
    let has_prior = |row: usize| parameters[indices[row]].prior_sigma().is_some();
    let weight = |row: usize| match &parameters[indices[row]] {
        _ if has_prior(row) => PRIOR_PIVOT_WEIGHT,
        parameter if parameter.id.block().is_nuisance() => NUISANCE_PIVOT_WEIGHT,
        _ => 1.0,
    };
    // Of many parameters, the one with a prior that bounds them all may be a small part.
    let is_bounded = |vector: &DVector<f64>| {
        let with_prior: f64 = (0..vector.len()).filter(|&row| has_prior(row)).map(|row| vector[row].powi(2)).sum();
        with_prior > options.min_bounding_share.powi(2) * vector.norm_squared()
    };
    let mut result = GaugeFix::default();
    for part in reduced_basis(&null, weight).into_iter().filter(|part| !is_bounded(&part.vector)) {
        result.pivots.push(indices[part.pivot]);
        let takes_part = (0..part.vector.len()).filter(|&row| part.vector[row].abs() > MIN_COMPONENT);
        result.participants.extend(takes_part.map(|row| (indices[row], part.vector[row])));
    }
    result
}

/// Scaled singular values, largest first, and the directions they belong to as columns.
fn spectrum(information: &DMatrix<f64>, free: &FreeParameters, indices: &[usize]) -> (Vec<f64>, DMatrix<f64>) {
    let scale = free.scale();
    let scaled = DMatrix::from_fn(indices.len(), indices.len(), |i, j| {
        scale[indices[i]] * information[(indices[i], indices[j])] * scale[indices[j]]
    });
    if indices.is_empty() {
        // Nothing to decompose.
        return (Vec::new(), scaled);
    }
    let eigen = SymmetricEigen::new(scaled);
    let mut order: Vec<usize> = (0..indices.len()).collect();
    order.sort_by(|&a, &b| eigen.eigenvalues[b].total_cmp(&eigen.eigenvalues[a]));
    let values = order.iter().map(|&k| eigen.eigenvalues[k].max(0.0).sqrt()).collect();
    let basis = DMatrix::from_fn(indices.len(), indices.len(), |i, j| eigen.eigenvectors[(i, order[j])]);
    (values, basis)
}

/// Number of singular values of at least `least`, and larger than rounding.
fn rank(singular_values: &[f64], least: f64) -> usize {
    let least = singular_values.first().map_or(least, |largest| least.max(ROUNDING * largest));
    singular_values.iter().take_while(|&&value| value >= least).count()
}

struct ReducedDirection {
    pivot: usize,
    vector: DVector<f64>,
}

/// A basis of the same space in reduced echelon form: each direction has a pivot coordinate that no
/// other one has, so that few coordinates take part in each. Pivots are large coordinates, by their
/// `weight`.
fn reduced_basis(basis: &DMatrix<f64>, weight: impl Fn(usize) -> f64) -> Vec<ReducedDirection> {
    let mut vectors: Vec<DVector<f64>> = basis.column_iter().map(|column| column.into_owned()).collect();
    let mut reduced: Vec<ReducedDirection> = Vec::new();
    while !vectors.is_empty() {
        let mut best = (0, 0, 0.0);
        for (v, vector) in vectors.iter().enumerate() {
            for row in 0..vector.len() {
                let size = vector[row].abs() * weight(row);
                if size > best.2 {
                    best = (v, row, size);
                }
            }
        }
        let (v, pivot, size) = best;
        let vector = vectors.swap_remove(v);
        if size < MIN_PIVOT {
            continue;
        }
        let vector = &vector / vector[pivot];
        for other in vectors.iter_mut().chain(reduced.iter_mut().map(|direction| &mut direction.vector)) {
            let part = other[pivot];
            other.axpy(-part, &vector, 1.0);
        }
        reduced.push(ReducedDirection { pivot, vector });
    }
    reduced
}

fn describe(part: &ReducedDirection, indices: &[usize], parameters: &[Parameter]) -> NullDirection {
    let vector = &part.vector / part.vector.amax().max(f64::MIN_POSITIVE);
    let mut rows: Vec<usize> = (0..vector.len()).filter(|&row| vector[row].abs() > MIN_COMPONENT).collect();
    rows.sort_by(|&a, &b| vector[b].abs().total_cmp(&vector[a].abs()));
    let is_large = |row: usize| vector[row].abs() >= NullDirection::MIN_NAMED;
    let large = rows.iter().filter(|&&row| is_large(row) && row != part.pivot);
    let others: Vec<String> = large.map(|&row| parameters[indices[row]].description()).collect();
    let first = parameters[indices[part.pivot]].description();
    let description = match others.len() {
        0 => format!("nothing in the data depends on {first}"),
        n if n > MAX_NAMED => {
            format!("{first} cannot be told from {} and {} more", others[..MAX_NAMED].join(", "), n - MAX_NAMED)
        }
        _ => format!("{first} cannot be told from {}", joined(&others)),
    };
    let named = rows.iter().filter(|&&row| is_large(row) || row == part.pivot);
    let remedy = remedy(named.map(|&row| &parameters[indices[row]]));
    NullDirection { description, remedy, direction: rows.iter().map(|&row| (indices[row], vector[row])).collect() }
}

/// The declarations which, more accurate, would determine a direction in which these parameters
/// take part.
fn remedy<'a>(parameters: impl Iterator<Item = &'a Parameter>) -> Option<String> {
    let mut declared: Vec<String> = Vec::new();
    for parameter in parameters {
        let of = match parameter.id.block() {
            Block::Tool => "the tool's place".to_owned(),
            Block::Fixture => {
                // `fixture.NAME.x`; a name may have points of its own.
                let place = parameter.name.rsplit_once('.').map_or(parameter.name.as_str(), |(place, _)| place);
                format!("the place of fixture {}", place.strip_prefix("fixture.").unwrap_or(place))
            }
            Block::GapBias => "clearance and depth".to_owned(),
            _ => continue,
        };
        if !declared.contains(&of) {
            declared.push(of);
        }
    }
    let more = declared.len().saturating_sub(MAX_NAMED_DECLARATIONS);
    declared.truncate(MAX_NAMED_DECLARATIONS);
    if more > 0 {
        declared.push(format!("{more} more"));
    }
    (!declared.is_empty()).then(|| format!("smaller standard deviations of {}", joined(&declared)))
}

fn joined(names: &[String]) -> String {
    match names {
        [] => String::new(),
        [one] => one.clone(),
        [first @ .., last] => format!("{} and {last}", first.join(", ")),
    }
}

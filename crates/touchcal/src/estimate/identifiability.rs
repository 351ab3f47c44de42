//! What the data determine, and in words what they do not.
//!
//! Parameters of different units are compared in units of their scale: the standard deviation of their prior, or a plausible size
//! where they have none. In these units the eigenvalues of the information matrix are squared singular values of the
//! whitened Jacobian. A direction with a singular value below 1 is one along which the data know less than was known, or
//! plausible, before: it is called unidentifiable.

use nalgebra::{DMatrix, DVector, SymmetricEigen};

use crate::robot::Parameter;

/// A direction is identifiable if its singular value in units of the scales is at least this.
const NULL_BELOW: f64 = 1.0;
/// With priors counted in, a direction below this is bounded by nothing: a prior alone gives about 1.
const UNBOUNDED_BELOW: f64 = 0.7;
/// Part that parameters with a prior must have in a direction to bound it: what is left is then at most ten times plausible.
const BOUNDING_PART: f64 = 0.1;
/// Singular values are square roots of eigenvalues: below this share of the largest they are rounding.
const ROUNDING: f64 = 3e-8;
/// Parameters with a smaller part in a direction, relative to its largest, are not named.
const NAMED_FROM: f64 = 0.05;
/// How much less a direction is named after, or resolved by holding, a nuisance parameter than one of the arm.
const NUISANCE_PREFERENCE: f64 = 0.05;
/// Most parameters named in one direction.
const MOST_NAMED: usize = 5;

/// A direction in parameter space that the data cannot see.
#[derive(Clone, Debug, PartialEq)]
pub struct NullDirection {
    /// What it means.
    pub words: String,
    /// Indices of the parameters that take part, and their parts in units of their scale; the largest part is 1.
    pub direction: Vec<(usize, f64)>,
}

/// Scaled singular values and what follows from them.
#[derive(Clone, Debug, PartialEq)]
pub struct Identifiability {
    /// Singular values of the whitened Jacobian in units of the scales, largest first.
    pub singular_values: Vec<f64>,
    /// Number of directions that the data determine.
    pub rank: usize,
    /// Largest over smallest singular value of those directions.
    pub condition: f64,
    /// The others.
    pub null_space: Vec<NullDirection>,
}

impl Identifiability {
    /// Analyses the information matrix `information` of the data (upper and lower triangle, SI) with each parameter's scale.
    /// Parameters with scale 0 are left out.
    pub fn new(information: &DMatrix<f64>, parameters: &[Parameter], scale: &DVector<f64>) -> Self {
        let free: Vec<usize> = (0..scale.len()).filter(|&k| scale[k] > 0.0).collect();
        let (singular_values, basis) = spectrum(information, scale, &free);
        let rank = determined(&singular_values, NULL_BELOW);
        let condition = match rank {
            0 => f64::INFINITY,
            _ => singular_values[0] / singular_values[rank - 1],
        };
        let reduced = reduced_basis(&basis.columns(rank, free.len() - rank).into_owned(), |row| {
            if parameters[free[row]].column.block().is_nuisance() { NUISANCE_PREFERENCE } else { 1.0 }
        });
        let null_space = reduced.iter().map(|part| named(part, &free, parameters)).collect();
        Identifiability { singular_values, rank, condition, null_space }
    }

    /// The observability indices O1 to O5 of the singular values of the determined directions.
    ///
    /// Source: Sun & Hollerbach, *Observability index selection for robot calibration* (2008), section II; `n` contacts.
    pub fn observability(&self, contacts: usize) -> [f64; 5] {
        let s = &self.singular_values[..self.rank];
        let (Some(&largest), Some(&smallest)) = (s.first(), s.last()) else {
            return [0.0; 5];
        };
        let count = s.len() as f64;
        let mean_log = s.iter().map(|v| v.ln()).sum::<f64>() / count;
        let inverse: f64 = s.iter().map(|v| 1.0 / v).sum();
        [
            mean_log.exp() / (contacts.max(1) as f64).sqrt(),
            smallest / largest,
            smallest,
            smallest * smallest / largest,
            1.0 / inverse,
        ]
    }
}

/// Parameters to hold at zero so that the rest are determined: one for each direction without information, preferring the
/// arm's over tool and fixtures, whose places then take up what cannot be told apart. `participants` also take part
/// in such a direction.
pub(crate) struct Held {
    pub pivots: Vec<usize>,
    pub participants: Vec<usize>,
}

/// Finds what must be held, from data and priors together.
pub(crate) fn held(information: &DMatrix<f64>, parameters: &[Parameter], scale: &DVector<f64>) -> Held {
    let free: Vec<usize> = (0..scale.len()).filter(|&k| scale[k] > 0.0).collect();
    let (singular_values, basis) = spectrum(information, scale, &free);
    let rank = determined(&singular_values, UNBOUNDED_BELOW);
    let null = basis.columns(rank, free.len() - rank).into_owned();
    let preference = |row: usize| match &parameters[free[row]] {
        parameter if parameter.prior_sigma.is_some() => 1e-3,
        parameter if parameter.column.block().is_nuisance() => NUISANCE_PREFERENCE,
        _ => 1.0,
    };
    // Of many parameters, the one with a prior that bounds them all may be a small part.
    let has_prior = |row: usize| parameters[free[row]].prior_sigma.is_some();
    let is_bounded = |vector: &DVector<f64>| {
        let with_prior: f64 = (0..vector.len()).filter(|&row| has_prior(row)).map(|row| vector[row].powi(2)).sum();
        with_prior > BOUNDING_PART.powi(2) * vector.norm_squared()
    };
    let mut result = Held { pivots: Vec::new(), participants: Vec::new() };
    for part in reduced_basis(&null, preference).into_iter().filter(|part| !is_bounded(&part.vector)) {
        result.pivots.push(free[part.pivot]);
        let takes_part = (0..part.vector.len()).filter(|&row| part.vector[row].abs() > 1e-3);
        result.participants.extend(takes_part.map(|row| free[row]));
    }
    result
}

/// Scaled singular values, largest first, and the directions they belong to as columns.
fn spectrum(information: &DMatrix<f64>, scale: &DVector<f64>, free: &[usize]) -> (Vec<f64>, DMatrix<f64>) {
    let scaled = DMatrix::from_fn(free.len(), free.len(), |i, j| {
        scale[free[i]] * information[(free[i], free[j])] * scale[free[j]]
    });
    if free.is_empty() {
        // Nothing to decompose.
        return (Vec::new(), scaled);
    }
    let eigen = SymmetricEigen::new(scaled);
    let mut order: Vec<usize> = (0..free.len()).collect();
    order.sort_by(|&a, &b| eigen.eigenvalues[b].total_cmp(&eigen.eigenvalues[a]));
    let values = order.iter().map(|&k| eigen.eigenvalues[k].max(0.0).sqrt()).collect();
    let basis = DMatrix::from_fn(free.len(), free.len(), |i, j| eigen.eigenvectors[(i, order[j])]);
    (values, basis)
}

/// How many of these are at least `below`, and more than rounding.
fn determined(singular_values: &[f64], below: f64) -> usize {
    let least = singular_values.first().map_or(below, |largest| below.max(ROUNDING * largest));
    singular_values.iter().take_while(|&&value| value >= least).count()
}

struct ReducedDirection {
    pivot: usize,
    vector: DVector<f64>,
}

/// A basis of the same space in reduced echelon form: each direction has a pivot coordinate that no other one has, so that
/// few coordinates take part in each. Pivots go to large coordinates, weighted by `preference`.
fn reduced_basis(basis: &DMatrix<f64>, preference: impl Fn(usize) -> f64) -> Vec<ReducedDirection> {
    let mut vectors: Vec<DVector<f64>> = basis.column_iter().map(|column| column.into_owned()).collect();
    let mut reduced: Vec<ReducedDirection> = Vec::new();
    while !vectors.is_empty() {
        let mut best = (0, 0, 0.0);
        for (v, vector) in vectors.iter().enumerate() {
            for row in 0..vector.len() {
                let size = vector[row].abs() * preference(row);
                if size > best.2 {
                    best = (v, row, size);
                }
            }
        }
        let (v, pivot, size) = best;
        let vector = vectors.swap_remove(v);
        if size < 1e-9 {
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

fn named(part: &ReducedDirection, free: &[usize], parameters: &[Parameter]) -> NullDirection {
    let vector = &part.vector / part.vector.amax().max(f64::MIN_POSITIVE);
    let mut rows: Vec<usize> = (0..vector.len()).filter(|&row| vector[row].abs() > 1e-3).collect();
    rows.sort_by(|&a, &b| vector[b].abs().total_cmp(&vector[a].abs()));
    let large = rows.iter().filter(|&&row| vector[row].abs() >= NAMED_FROM && row != part.pivot);
    let others: Vec<String> = large.map(|&row| parameters[free[row]].words()).collect();
    let first = parameters[free[part.pivot]].words();
    let words = match others.len() {
        0 => format!("nothing in the data depends on {first}"),
        n if n > MOST_NAMED => {
            format!("{first} cannot be told from {} and {} more", others[..MOST_NAMED].join(", "), n - MOST_NAMED)
        }
        _ => format!("{first} cannot be told from {}", joined(&others)),
    };
    NullDirection { words, direction: rows.iter().map(|&row| (free[row], vector[row])).collect() }
}

fn joined(names: &[String]) -> String {
    match names {
        [] => String::new(),
        [one] => one.clone(),
        [first @ .., last] => format!("{} and {last}", first.join(", ")),
    }
}

//! Distances between fixtures, found and declared.

use nalgebra::{Cholesky, DMatrix, DVector, Vector3};

use super::location::{FixtureLocation, locations};
use super::prediction_model::PredictionModel;
use crate::estimate::problem::{PlacePrior, Problem};
use crate::estimate::result::{CommonStrain, DistanceSource, FixtureDistance, Scatter};

/// Distances between fixtures, and the strain common to them.
pub(super) struct FixtureDistances {
    pub each: Vec<FixtureDistance>,
    pub common: Option<CommonStrain>,
}

/// Distances between fixtures of `declared` whose contacts locate their origins: those that are
/// declared, then those of nominal places that are declared. `scatter` is that of each fixture.
pub(super) fn fixture_distances(
    prediction: &PredictionModel<'_>,
    declared: &Problem,
    scatter: &[Option<Scatter>],
) -> FixtureDistances {
    let pairs = declared_distances(declared);
    let locations = if pairs.is_empty() { Vec::new() } else { locations(prediction, scatter) };
    let each = pairs.into_iter().filter_map(|pair| LocatedPair::new(pair, &locations));
    let each: Vec<LocatedPair> = each.collect();
    let covariance = DMatrix::from_fn(each.len(), each.len(), |i, j| {
        each[i].covariance(&each[j], &prediction.covariance, &locations)
    });
    let distances = each.iter().enumerate().map(|(i, pair)| FixtureDistance {
        between: [pair.declared.between.0, pair.declared.between.1].map(|f| declared.fixtures[f].name.clone()),
        source: pair.declared.source,
        declared: pair.declared.distance,
        found: pair.span.norm(),
        sigma: covariance[(i, i)].max(0.0).sqrt(),
    });
    let distances: Vec<FixtureDistance> = distances.collect();
    FixtureDistances { common: common_strain(&distances, covariance), each: distances }
}

/// Share of each variance that is added: distances of many places depend on each other.
const REGULARIZATION: f64 = 1e-6;

/// The strain `e` that explains differences `d = e l` of distances of lengths `l` and covariance
/// `C` best: `e = lᵀC⁻¹d / lᵀC⁻¹l`.
fn common_strain(distances: &[FixtureDistance], mut covariance: DMatrix<f64>) -> Option<CommonStrain> {
    let lengths = DVector::from_iterator(distances.len(), distances.iter().map(|distance| distance.declared));
    let differences = distances.iter().map(FixtureDistance::difference);
    (0..distances.len()).for_each(|i| covariance[(i, i)] *= 1.0 + REGULARIZATION);
    let weighted = Cholesky::new(covariance)?.solve(&lengths);
    let information = weighted.dot(&lengths);
    (distances.len() > 1).then(|| CommonStrain {
        strain: weighted.dot(&DVector::from_iterator(distances.len(), differences)) / information,
        sigma: information.sqrt().recip(),
    })
}

/// A distance between two fixtures as declared.
struct DeclaredDistance {
    between: (usize, usize),
    source: DistanceSource,
    /// Length (m).
    distance: f64,
    /// Variance (m²) of the length itself.
    variance: f64,
    /// Variances (m²) of each component of the two places, where those declare it.
    of_places: [f64; 2],
}

fn declared_distances(problem: &Problem) -> Vec<DeclaredDistance> {
    let each = problem.distances.iter().map(|declared| DeclaredDistance {
        between: declared.between,
        source: DistanceSource::Distance,
        distance: declared.distance,
        variance: declared.sigma.powi(2),
        of_places: [0.0; 2],
    });
    let mut pairs: Vec<DeclaredDistance> = each.collect();
    let place = |f: usize| {
        let sigma = match problem.fixtures[f].prior {
            PlacePrior::Fixed => 0.0,
            PlacePrior::Gaussian { sigma, .. } => sigma,
            PlacePrior::Flat => return None,
        };
        Some((problem.fixtures[f].base_from_fixture?.translation.vector, sigma * sigma))
    };
    for b in 0..problem.fixtures.len() {
        for a in 0..b {
            let is_declared = pairs.iter().any(|pair| pair.between == (a, b) || pair.between == (b, a));
            if let (Some((from, from_variance)), Some((to, to_variance)), false) = (place(a), place(b), is_declared) {
                pairs.push(DeclaredDistance {
                    between: (a, b),
                    source: DistanceSource::Places,
                    distance: (to - from).norm(),
                    variance: 0.0,
                    of_places: [from_variance, to_variance],
                });
            }
        }
    }
    pairs
}

/// Two fixtures with a declared distance, both located.
struct LocatedPair {
    declared: DeclaredDistance,
    /// From the first to the second (m), and its direction.
    span: Vector3<f64>,
    along: Vector3<f64>,
    /// Derivative of the distance by the parameters.
    slope: DVector<f64>,
}

impl LocatedPair {
    /// `None` unless both are located, at different places.
    fn new(declared: DeclaredDistance, locations: &[Option<FixtureLocation>]) -> Option<Self> {
        let (a, b) = declared.between;
        let (from, to) = (locations[a].as_ref()?, locations[b].as_ref()?);
        let span = to.origin - from.origin;
        let along = span.try_normalize(0.0)?;
        let slope = (&to.sensitivity - &from.sensitivity).tr_mul(&along);
        Some(LocatedPair { declared, span, along, slope })
    }

    /// The two fixtures, each with the direction in which its motion lengthens the distance, and
    /// the variance of its declared place.
    fn ends(&self) -> [(usize, Vector3<f64>, f64); 2] {
        let ((a, b), [from, to]) = (self.declared.between, self.declared.of_places);
        [(a, -self.along, from), (b, self.along, to)]
    }

    /// Covariance (m²) of the differences of two pairs: of parameters with covariance
    /// `of_parameters`, of the noise of their locations, and of what is declared.
    fn covariance(
        &self,
        other: &LocatedPair,
        of_parameters: &DMatrix<f64>,
        locations: &[Option<FixtureLocation>],
    ) -> f64 {
        let mut sum = self.slope.dot(&(of_parameters * &other.slope));
        for (f, motion, variance) in self.ends() {
            for (_, other_motion, other_variance) in other.ends().into_iter().filter(|(of, ..)| *of == f) {
                let noise = locations[f].as_ref().map_or(0.0, |at| motion.dot(&(at.noise * other_motion)));
                sum += noise + variance.min(other_variance) * motion.dot(&other_motion);
            }
        }
        let is_same = self.declared.between == other.declared.between && self.declared.source == other.declared.source;
        sum + if is_same { self.declared.variance } else { 0.0 }
    }
}

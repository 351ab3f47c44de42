//! How well an arm explains contacts, in millimetres that need no estimator to understand.

use nalgebra::Vector3;
use rayon::prelude::*;

use super::problem::Problem;
use super::rows::At;

/// Mean, root mean square and maximum of distances (m).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Spread {
    /// Number of distances.
    pub count: usize,
    /// Mean.
    pub mean: f64,
    /// Root mean square.
    pub rms: f64,
    /// Maximum.
    pub max: f64,
}

/// Distances over all contacts and for each fixture.
///
/// A contact's distance is the size of its manifold's residual; for a socket, the distance of the ball's centre from the mean of
/// all centres computed for that socket, so that it needs neither the socket's place nor its spacing.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Score {
    /// Over all contacts.
    pub all: Spread,
    /// For each fixture of the problem, in order.
    pub per_fixture: Vec<Spread>,
}

impl Spread {
    fn add(&mut self, distance: f64) {
        let before = self.count as f64;
        self.count += 1;
        let after = self.count as f64;
        self.mean += (distance - self.mean) / after;
        self.rms = ((self.rms * self.rms * before + distance * distance) / after).sqrt();
        self.max = self.max.max(distance);
    }
}

/// Distances (m) of all contacts at `at`, in order.
pub(crate) fn distances(problem: &Problem, at: &At<'_>) -> Vec<f64> {
    let each = (0..problem.contacts.len()).into_par_iter();
    let values: Vec<Vector3<f64>> = each.map_init(|| at.rows(), |rows, i| at.residual_vector(i, rows)).collect();
    let mut mean = vec![(Vector3::zeros(), 0usize); problem.fixtures.len()];
    for (i, value) in values.iter().enumerate() {
        let f = problem.contacts.fixture(i);
        if problem.fixtures[f].manifold.is_point() {
            mean[f].0 += value;
            mean[f].1 += 1;
        }
    }
    let centred = values.iter().enumerate().map(|(i, value)| {
        let (sum, count) = mean[problem.contacts.fixture(i)];
        (value - sum / count.max(1) as f64).norm()
    });
    centred.collect()
}

/// The score of a problem's contacts at `at`.
pub(crate) fn score(problem: &Problem, at: &At<'_>) -> Score {
    let distances = distances(problem, at);
    let mut score = Score { all: Spread::default(), per_fixture: vec![Spread::default(); problem.fixtures.len()] };
    for (i, distance) in distances.into_iter().enumerate() {
        score.all.add(distance);
        score.per_fixture[problem.contacts.fixture(i)].add(distance);
    }
    score
}

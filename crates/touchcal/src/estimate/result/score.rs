//! How well an arm explains contacts, as distances.

use serde::{Deserialize, Serialize};

/// Number, mean, root mean square and maximum of distances (m); zeros for no distances.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Spread {
    /// Number of distances.
    pub count: usize,
    /// Mean distance (m).
    pub mean: f64,
    /// Root mean square distance (m).
    pub rms: f64,
    /// Largest distance (m).
    pub max: f64,
}

/// Distances (m) of contacts from their manifolds, over all contacts and for each fixture.
///
/// A contact's distance is the norm of its manifold's residual, of at most its first three rows,
/// see [`contact_distances`](crate::estimate::contact_distances). For a point manifold (ball in
/// socket) it is the distance from the mean of all centres computed for that socket, so that
/// neither the socket's place nor its spacing is needed.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Score {
    /// Distances over all contacts.
    pub all: Spread,
    /// Distances of the contacts with each fixture, in the order of
    /// [`Problem::fixtures`](crate::estimate::Problem::fixtures) and as many; zeros for one without
    /// contacts.
    pub per_fixture: Vec<Spread>,
}

impl Spread {
    /// Adds a distance (m).
    pub(crate) fn add(&mut self, distance: f64) {
        let before = self.count as f64;
        self.count += 1;
        let after = self.count as f64;
        self.mean += (distance - self.mean) / after;
        self.rms = ((self.rms * self.rms * before + distance * distance) / after).sqrt();
        self.max = self.max.max(distance);
    }
}

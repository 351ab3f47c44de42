//! The manifold that a simulated tool and fixture have.

use crate::manifold::{BallInSocket, ContactManifold, PegInHole, Plane};
use crate::sim::Parts;

/// The exact contact manifold of a tool and a fixture.
pub fn manifold_of(parts: &Parts) -> Box<dyn ContactManifold> {
    match parts {
        Parts::PegInHole(parts) => Box::new(PegInHole::new(parts.as_ref().clone())),
        Parts::BallInSocket => Box::new(BallInSocket),
        Parts::OnPlane { points, radius } => Box::new(Plane::new(points.clone(), *radius)),
    }
}

//! A tool and a fixture of known shape.

use nalgebra::Point3;

use super::prism_gap::PrismPair;

/// A tool and a fixture of known shape, each in its own frame (m);
/// [`exact_manifold`](crate::manifold::exact_manifold) makes a contact manifold of them.
#[derive(Clone, Debug)]
pub enum Parts {
    /// A straight peg (the tool) and a straight hole (the fixture), frames as in [`PrismPair`].
    PegInHole(Box<PrismPair>),
    /// A ball of any radius, centred at the tool's origin, in a socket of three faces like the
    /// inner corner of a cube, which seats the ball's centre at the fixture's origin; +z points out
    /// of the corner.
    BallInSocket,
    /// The convex hull of points in the tool frame (m) grown by a radius (m), over the plane z = 0
    /// of the fixture; +z points to the tool's side.
    OnPlane {
        /// Points in the tool frame (m), in any order: one for a ball or a stylus, the corners of
        /// the tip for a peg. [`Plane`](crate::manifold::Plane) takes none as the tool's origin.
        points: Vec<Point3<f64>>,
        /// Distance (m, not negative) of the tool's surface from the hull; 0 for a sharp tool.
        radius: f64,
    },
}

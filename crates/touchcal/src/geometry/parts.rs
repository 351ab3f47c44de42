//! What touches what: a tool and a fixture of known shape.

use nalgebra::Point3;

use super::prism_gap::PrismPair;

/// A tool and a fixture, each in its own frame.
#[derive(Clone, Debug)]
pub enum Parts {
    /// A straight peg and a straight hole.
    PegInHole(Box<PrismPair>),
    /// A ball, centred at the tool's origin, in a socket of three faces like the inner corner of a
    /// cube, which seats the ball's centre at the fixture's origin; +z points out of the corner.
    BallInSocket,
    /// The convex hull of points in the tool frame (m) grown by a radius (m), over the plane z = 0
    /// of the fixture.
    OnPlane {
        /// One point is a ball or a stylus, the corners of its tip a peg.
        points: Vec<Point3<f64>>,
        /// Distance (m) of the surface from the hull.
        radius: f64,
    },
}

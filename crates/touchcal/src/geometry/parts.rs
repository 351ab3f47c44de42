//! A tool and a fixture of known shape.

use nalgebra::Point3;

use super::prism_gap::PrismPair;

/// A tool and a fixture of known shape, each in its own frame (m).
#[derive(Clone, Debug)]
pub enum Parts {
    /// A straight peg (the tool) and a straight hole (the fixture).
    PegInHole(Box<PrismPair>),
    /// A ball, centred at the tool's origin, in a socket of three faces like the inner corner of a
    /// cube, which seats the ball's centre at the fixture's origin; +z points out of the corner.
    BallInSocket,
    /// The convex hull of points in the tool frame (m) grown by a radius (m), over the plane z = 0
    /// of the fixture.
    OnPlane {
        /// Points in the tool frame (m): one for a ball or a stylus, the corners of the tip for a
        /// peg; none means the tool's origin.
        points: Vec<Point3<f64>>,
        /// Distance (m) of the tool's surface from the hull; 0 for a sharp tool.
        radius: f64,
    },
}

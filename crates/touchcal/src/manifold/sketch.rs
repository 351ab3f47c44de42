//! What tool and fixture look like, for pictures.

use nalgebra::Point2;

/// A part as a picture shows it, in its own frame.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Shape {
    /// Nothing but where it is.
    Point,
    /// A ball of this radius (m) about the origin.
    Ball {
        /// Radius (m).
        radius: f64,
    },
    /// A straight piece of this outline (m), along z.
    Prism {
        /// Vertices in x and y (m).
        outline: Vec<Point2<f64>>,
        /// Lower end (m).
        from: f64,
        /// Upper end (m).
        to: f64,
    },
    /// The plane z = 0.
    Plane,
}

/// What touches what.
#[derive(Clone, Debug, PartialEq)]
pub struct Sketch {
    /// The tool, in its frame.
    pub tool: Shape,
    /// The fixture, in its frame; of a hole, the hollow.
    pub fixture: Shape,
}

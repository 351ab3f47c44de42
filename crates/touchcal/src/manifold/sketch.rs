//! What tool and fixture look like, for pictures and for telling how their frames lie.

use nalgebra::{Point2, center};

use crate::geometry::Polygon;

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

impl Shape {
    /// The middle (m) of a piece whose outline does not enclose the origin of its frame.
    pub fn aside(&self) -> Option<Point2<f64>> {
        let Shape::Prism { outline, .. } = self else { return None };
        let outline = Polygon::new(outline.clone()).ok()?;
        let least = outline.vertices().iter().fold(Point2::from([f64::MAX; 2]), |least, vertex| least.inf(vertex));
        let most = outline.vertices().iter().fold(Point2::from([f64::MIN; 2]), |most, vertex| most.sup(vertex));
        (!outline.contains(&Point2::origin())).then(|| center(&least, &most))
    }
}

/// What touches what.
#[derive(Clone, Debug, PartialEq)]
pub struct Sketch {
    /// The tool, in its frame.
    pub tool: Shape,
    /// The fixture, in its frame; of a hole, the hollow.
    pub fixture: Shape,
}

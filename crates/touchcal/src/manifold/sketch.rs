//! What tool and fixture look like, for pictures and to show how their frames lie.

use nalgebra::{Point2, center};

use crate::geometry::Polygon;

/// A part as a picture shows it, in its own frame.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Shape {
    /// A point at the origin of the frame; also a part of unknown shape.
    Point,
    /// A ball about the origin.
    Ball {
        /// Radius (m).
        radius: f64,
    },
    /// A prism along z.
    Prism {
        /// Vertices of the cross section in x and y (m), in order around it, either way round; the
        /// last is joined to the first.
        outline: Vec<Point2<f64>>,
        /// Height z of the lower end (m).
        from: f64,
        /// Height z of the upper end (m).
        to: f64,
    },
    /// The plane z = 0, seen from +z.
    Plane,
}

impl Shape {
    /// Middle (x and y, m, in the shape's frame) of the bounding box of a prism whose outline does
    /// not enclose the origin of its frame: a sign that the frame lies in the wrong place. `None`
    /// for other shapes, for an outline around the origin, and for an outline that is no valid
    /// [`Polygon`].
    pub fn aside(&self) -> Option<Point2<f64>> {
        let Shape::Prism { outline, .. } = self else { return None };
        let outline = Polygon::new(outline.clone()).ok()?;
        let least = outline.vertices().iter().fold(Point2::from([f64::MAX; 2]), |least, vertex| least.inf(vertex));
        let most = outline.vertices().iter().fold(Point2::from([f64::MIN; 2]), |most, vertex| most.sup(vertex));
        (!outline.contains(&Point2::origin())).then(|| center(&least, &most))
    }
}

/// Shapes of a tool and a fixture for a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Sketch {
    /// The tool, in the tool frame.
    pub tool: Shape,
    /// The fixture, in the fixture frame; for a hole, the hollow space.
    pub fixture: Shape,
}

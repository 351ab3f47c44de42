//! The shapes that a peg and a hole may have.

use crate::geometry::{
    AxialSymmetry, EdgeFaces, EdgeRadii, GapQuery, MeshPair, Polygon, PrismPair, is_surface_of_revolution,
    rotational_order,
};
use crate::manifold::contact_manifold::RotationalOrders;
use crate::manifold::sketch::{Shape, Sketch};

/// Surfaces farther from the axis than this multiple of the peg's radius are not of the hole.
const AROUND: f64 = 1.5;

/// Shapes of a peg and a hole, and the signed gap between them.
///
/// Frames: the peg's origin is the centre of its tip, +z points away from the tip into the peg; the
/// hole's origin is the centre of its mouth, +z points out of it; a seated peg has the axes of the
/// hole.
pub trait PegInHoleShapes: GapQuery {
    /// Whether peg and hole are straight along z, which only the name of the manifold tells.
    const IS_STRAIGHT: bool;

    /// Greatest distance (m) of the peg's surface from the z axis of the peg.
    fn peg_radius(&self) -> f64;

    /// Sum of the radii (m) to which edges of peg and hole are rounded; 0 unless overridden: round
    /// edges of meshes are part of these.
    fn sum_of_edge_radii(&self) -> f64 {
        0.0
    }

    /// What tells contacts at edges of peg and hole from those at faces; `None`, as unless
    /// overridden, where edges are part of the shapes.
    fn edge_faces(&self) -> Option<[EdgeFaces; 2]> {
        None
    }

    /// Whether peg and hole are each round about the z axis of their frame: the Jacobian then
    /// leaves out rotations about that axis.
    fn symmetry(&self) -> AxialSymmetry;

    /// Discrete rotational symmetry of peg (the tool) and hole; none where the symmetry is not
    /// known.
    fn rotational_orders(&self) -> RotationalOrders {
        RotationalOrders { tool: 1, fixture: 1 }
    }

    /// The same shapes with a hole `factor` (1, above 0) times as deep; `None`, as unless
    /// overridden, if there is none of that depth. Only prisms have a floor that moves with it.
    fn with_scaled_depth(&self, factor: f64) -> Option<Self>
    where
        Self: Sized,
    {
        let _ = factor;
        None
    }

    /// Outlines of peg (the tool) and hole (the fixture) as prisms for a picture, each in its frame
    /// (m), with the hole from z = −`depth` (m, positive) to 0.
    fn sketch(&self, depth: f64) -> Sketch;
}

impl PegInHoleShapes for PrismPair {
    const IS_STRAIGHT: bool = true;

    fn peg_radius(&self) -> f64 {
        PrismPair::peg_radius(self)
    }

    fn sum_of_edge_radii(&self) -> f64 {
        let EdgeRadii { peg, hole } = self.edge_radii();
        peg + hole
    }

    fn edge_faces(&self) -> Option<[EdgeFaces; 2]> {
        Some([self.peg(), self.hole()].map(EdgeFaces::new))
    }

    fn symmetry(&self) -> AxialSymmetry {
        PrismPair::symmetry(self)
    }

    fn rotational_orders(&self) -> RotationalOrders {
        RotationalOrders { tool: rotational_order(self.peg()), fixture: rotational_order(self.hole()) }
    }

    fn with_scaled_depth(&self, factor: f64) -> Option<Self> {
        self.with_hole(self.hole().clone(), factor * self.depth()).ok()
    }

    fn sketch(&self, depth: f64) -> Sketch {
        let prism = |outline: &Polygon, from, to| Shape::Prism { outline: outline.vertices().to_vec(), from, to };
        Sketch { tool: prism(self.peg(), 0.0, self.length()), fixture: prism(self.hole(), -depth, 0.0) }
    }
}

impl PegInHoleShapes for MeshPair {
    const IS_STRAIGHT: bool = false;

    fn peg_radius(&self) -> f64 {
        self.tool().vertices().map(|p| p.xy().coords.norm()).fold(0.0, f64::max)
    }

    fn symmetry(&self) -> AxialSymmetry {
        AxialSymmetry {
            peg: is_surface_of_revolution(self.tool(), f64::INFINITY),
            hole: is_surface_of_revolution(self.fixture(), AROUND * self.peg_radius()),
        }
    }

    fn with_scaled_depth(&self, _factor: f64) -> Option<Self> {
        Some(self.clone())
    }

    /// The shadow of the peg along its axis: as long as the peg, and as deep as the hole.
    fn sketch(&self, depth: f64) -> Sketch {
        let outline = self.tool().shadow();
        let length = self.tool().vertices().map(|p| p.z).fold(0.0, f64::max);
        let tool = Shape::Prism { outline: outline.clone(), from: 0.0, to: length };
        Sketch { tool, fixture: Shape::Prism { outline, from: -depth, to: 0.0 } }
    }
}

//! What touches what: the pairs of surface elements that are near each other at a pose.

use nalgebra::{Point3, Vector3};

use crate::geometry::extrusion::{Feature, PegAndHole};
use crate::se3::{Pose, Twist, twist};

/// A tool and a fixture.
#[derive(Clone, Debug)]
pub enum Parts {
    /// A straight peg and a straight hole.
    PegInHole(Box<PegAndHole>),
    /// A ball, centred at the tool's origin, in a socket of three faces like the inner corner of a
    /// cube, which seats the ball's centre at the fixture's origin; +z points out of the corner.
    BallInSocket,
    /// The convex hull of points in the tool frame (m) grown by a radius (m), over the plane z = 0
    /// of the fixture.
    OnPlane {
        /// One point is a ball or a stylus, the corners of its tip a peg.
        points: Vec<Point3<f64>>,
        /// How far the surface is from the points.
        radius: f64,
    },
}

/// Which surface elements: the same pair has the same name from row to row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Pair {
    /// Of a peg and a hole.
    Feature(Feature),
    /// A point of the tool and a face of the fixture.
    PointFace(usize, usize),
}

/// A pair of surface elements that touch or nearly do.
#[derive(Clone, Copy, Debug)]
pub(super) struct Near {
    pub pair: Pair,
    /// Signed distance (m), negative in penetration.
    pub gap: f64,
    /// `∂gap/∂ξ` for `fixture_from_tool · Exp(ξ)`: `[n; p × n]` in the tool frame.
    pub gradient: Twist,
    /// Where the tool is nearest (m, tool frame).
    pub point_in_tool: Point3<f64>,
    /// From the fixture into the tool (tool frame).
    pub normal_in_tool: Vector3<f64>,
}

impl Parts {
    /// Heights (m) of the tool's origin over the fixture's where it first touches, upright, and
    /// where it can go no deeper.
    pub(super) fn heights(&self) -> (f64, f64) {
        match self {
            Parts::PegInHole(parts) => (0.0, -parts.depth()),
            Parts::BallInSocket => (0.0, 0.0),
            Parts::OnPlane { points, radius } => {
                let lowest = points.iter().map(|point| point.z).fold(f64::INFINITY, f64::min);
                (radius - lowest, radius - lowest)
            }
        }
    }

    /// Pairs that linearisation must not jump past: a step must keep all points of the tool within
    /// this distance (m). None where the fixture is convex and linearisation is exact in
    /// translation.
    pub(super) fn reach(&self) -> Option<f64> {
        match self {
            Parts::PegInHole(_) => Some(0.3e-3),
            Parts::BallInSocket | Parts::OnPlane { .. } => None,
        }
    }

    /// Largest distance (m) of the tool's surface from its origin.
    pub(super) fn size(&self) -> f64 {
        match self {
            Parts::PegInHole(parts) => parts.peg().bounding_radius().hypot(parts.depth().min(parts.length())),
            Parts::BallInSocket => 0.0,
            Parts::OnPlane { points, radius } => points.iter().map(|p| p.coords.norm()).fold(0.0, f64::max) + radius,
        }
    }

    /// The pairs nearer than [`Parts::reach`], all of them where there is none.
    pub(super) fn visit_near(&self, fixture_from_tool: &Pose, mut visit: impl FnMut(Near)) {
        match self {
            Parts::PegInHole(parts) => {
                let reach = self.reach().unwrap_or(f64::INFINITY);
                parts.visit_below(fixture_from_tool, reach, |gap| {
                    visit(Near {
                        pair: Pair::Feature(gap.feature),
                        gap: gap.value,
                        gradient: gap.gradient,
                        point_in_tool: fixture_from_tool.inverse_transform_point(&gap.point_in_hole),
                        normal_in_tool: gap.gradient.fixed_rows::<3>(0).into_owned(),
                    });
                });
            }
            Parts::BallInSocket => {
                for (face, normal) in SOCKET.iter().enumerate() {
                    visit(point_and_face(fixture_from_tool, (0, &Point3::origin()), (face, normal), 0.0));
                }
            }
            Parts::OnPlane { points, radius } => {
                for (i, point) in points.iter().enumerate() {
                    visit(point_and_face(fixture_from_tool, (i, point), (0, &Vector3::z()), *radius));
                }
            }
        }
    }

    /// The least signed distance (m), as far as pairs are near; infinite where none is.
    pub fn gap(&self, fixture_from_tool: &Pose) -> f64 {
        match self {
            Parts::PegInHole(parts) => parts.gap(fixture_from_tool).value,
            _ => {
                let mut least = f64::INFINITY;
                self.visit_near(fixture_from_tool, |near| least = least.min(near.gap));
                least
            }
        }
    }
}

/// Normals of a socket's faces: perpendicular to each other, equally steep.
const SOCKET: [Vector3<f64>; 3] = [
    Vector3::new(0.816_496_580_927_726, 0.0, 0.577_350_269_189_625_8),
    Vector3::new(-0.408_248_290_463_863, 0.707_106_781_186_547_5, 0.577_350_269_189_625_8),
    Vector3::new(-0.408_248_290_463_863, -0.707_106_781_186_547_5, 0.577_350_269_189_625_8),
];

/// A ball of `radius` about a point of the tool, and a face through the fixture's origin.
fn point_and_face(
    fixture_from_tool: &Pose,
    (i, point): (usize, &Point3<f64>),
    (face, normal): (usize, &Vector3<f64>),
    radius: f64,
) -> Near {
    let normal_in_tool = fixture_from_tool.rotation.inverse() * normal;
    let point_in_tool = point - normal_in_tool * radius;
    Near {
        pair: Pair::PointFace(i, face),
        gap: normal.dot(&(fixture_from_tool * point).coords) - radius,
        gradient: twist(&normal_in_tool, &point_in_tool.coords.cross(&normal_in_tool)),
        point_in_tool,
        normal_in_tool,
    }
}

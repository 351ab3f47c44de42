//! What touches what: the pairs of surface elements that are near each other at a pose.

use nalgebra::{Point3, Vector3};

use crate::geometry::{Feature, Parts, visit_features_below};
use crate::se3::{Pose, Twist, twist};

/// Which surface elements: the same pair has the same name from row to row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Pair {
    /// Of a peg and a hole.
    Feature(Feature),
    /// Indices of a point of the tool and of a face of the fixture.
    PointFace(usize, usize),
}

/// A pair of surface elements that touch or nearly do.
#[derive(Clone, Copy, Debug)]
pub(super) struct Near {
    /// The surface elements.
    pub pair: Pair,
    /// Signed distance (m), negative in penetration.
    pub gap: f64,
    /// `∂gap/∂ξ` for `fixture_from_tool · Exp(ξ)`: `[n; p × n]` in the tool frame.
    pub gradient: Twist,
    /// Nearest point of the tool (m), in the tool frame.
    pub point_in_tool: Point3<f64>,
    /// Unit normal from the fixture into the tool, in the tool frame.
    pub normal_in_tool: Vector3<f64>,
}

/// The surface elements of tool and fixture that are close to each other.
pub(super) trait NearPairs {
    /// Heights (m) of the tool's origin over the fixture's where it first touches, upright, and
    /// where it can go no deeper.
    fn heights(&self) -> (f64, f64);

    /// Distance (m) by which a step may move points of the tool at most, so that linearisation does
    /// not jump past a pair. None where the fixture is convex and linearisation is exact in
    /// translation.
    fn reach(&self) -> Option<f64>;

    /// Largest distance (m) of the tool's surface from its origin.
    fn size(&self) -> f64;

    /// Visits the pairs nearer than [`NearPairs::reach`], all of them where there is none.
    fn visit_near(&self, fixture_from_tool: &Pose, visit: impl FnMut(Near));
}

impl NearPairs for Parts {
    fn heights(&self) -> (f64, f64) {
        match self {
            Parts::PegInHole(parts) => (0.0, -parts.depth()),
            Parts::BallInSocket => (0.0, 0.0),
            Parts::OnPlane { points, radius } => {
                let lowest = points.iter().map(|point| point.z).fold(f64::INFINITY, f64::min);
                (radius - lowest, radius - lowest)
            }
        }
    }

    fn reach(&self) -> Option<f64> {
        match self {
            Parts::PegInHole(_) => Some(0.3e-3),
            Parts::BallInSocket | Parts::OnPlane { .. } => None,
        }
    }

    fn size(&self) -> f64 {
        match self {
            Parts::PegInHole(parts) => parts.peg().bounding_radius().hypot(parts.depth().min(parts.length())),
            Parts::BallInSocket => 0.0,
            Parts::OnPlane { points, radius } => points.iter().map(|p| p.coords.norm()).fold(0.0, f64::max) + radius,
        }
    }

    fn visit_near(&self, fixture_from_tool: &Pose, mut visit: impl FnMut(Near)) {
        match self {
            Parts::PegInHole(parts) => {
                let reach = self.reach().unwrap_or(f64::INFINITY);
                visit_features_below(parts, fixture_from_tool, reach, |gap, feature| {
                    visit(Near {
                        pair: Pair::Feature(feature),
                        gap: gap.value,
                        gradient: gap.gradient,
                        point_in_tool: fixture_from_tool.inverse_transform_point(&gap.point_in_fixture),
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

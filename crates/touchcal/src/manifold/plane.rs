//! A tool that touches a plane.

use nalgebra::{Point3, Vector3};
use serde::{Deserialize, Serialize};

use super::contact_manifold::ContactManifold;
use super::residual::Residual;
use super::sketch::{Shape, Sketch};
use crate::se3::{self, Pose};

/// Contact manifold of a tool on a plane. Residual, one row whatever the resolution: signed
/// distance (m) from the plane to the nearest part of the tool, positive above the plane, negative
/// in penetration.
///
/// Fixture frame: the plane is z = 0, +z points to the side the tool is on. The tool is the convex
/// hull of points (in the tool frame) grown by a radius: one point and a radius is a ball, one
/// point and no radius a stylus, the vertices of a tip face a peg. Where two points are equally
/// near, the derivative is that of the first. The envelope is the residual over 0.5 mm.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Plane {
    points: Vec<Point3<f64>>,
    radius: f64,
}

/// Distance (m) that one unit of envelope stands for.
const ENVELOPE_LENGTH: f64 = 0.5e-3;

impl Plane {
    /// A tool that is the convex hull of points in the tool frame (m, in any order), grown by a
    /// radius (m, not negative). No points means the tool's origin. Neither is checked: points with
    /// a NaN are left out of the hull, and with a NaN in the radius or in all points the residual
    /// is not finite.
    pub fn new(points: Vec<Point3<f64>>, radius: f64) -> Self {
        let points = if points.is_empty() { vec![Point3::origin()] } else { points };
        Plane { points, radius }
    }

    /// A ball of this radius (m, not negative) about the tool's origin; with radius 0 a point.
    pub fn ball(radius: f64) -> Self {
        Plane::new(Vec::new(), radius)
    }

    fn push_distance(&self, plane_from_tool: &Pose, scale: f64, rows: &mut Residual) {
        let normal_in_tool = plane_from_tool.rotation.inverse() * Vector3::z();
        let mut nearest = (f64::INFINITY, Point3::origin());
        for point in &self.points {
            let height = normal_in_tool.dot(&point.coords);
            if height < nearest.0 {
                nearest = (height, *point);
            }
        }
        let (height, point_in_tool) = nearest;
        let distance = plane_from_tool.translation.z + height - self.radius;
        // d(T·Exp(ξ)) = d + n·(v + ω × p)
        let row = se3::twist(&normal_in_tool, &point_in_tool.coords.cross(&normal_in_tool));
        rows.push(distance * scale, row * scale);
    }
}

impl ContactManifold for Plane {
    fn name(&self) -> &'static str {
        "tool on plane"
    }

    fn residual(&self, fixture_from_tool: &Pose, _: f64, rows: &mut Residual) {
        self.push_distance(fixture_from_tool, 1.0, rows);
    }

    fn envelope(&self, fixture_from_tool: &Pose, rows: &mut Residual) {
        self.push_distance(fixture_from_tool, 1.0 / ENVELOPE_LENGTH, rows);
    }

    fn sketch(&self) -> Sketch {
        let is_ball = self.points.as_slice() == [Point3::origin()] && self.radius > 0.0;
        let tool = if is_ball { Shape::Ball { radius: self.radius } } else { Shape::Point };
        Sketch { tool, fixture: Shape::Plane }
    }

    fn fixture_directions(&self) -> &'static [usize] {
        &[2, 3, 4]
    }

    fn tool_directions(&self) -> &'static [usize] {
        if self.points.len() == 1 && self.points[0] == Point3::origin() { &[0, 1, 2] } else { &[0, 1, 2, 3, 4, 5] }
    }
}

//! Two edges, and where the lines that they lie on are nearest.

use nalgebra::Vector3;

use crate::geometry::mesh::ConvexEdge;

/// Sine of the angle below which edges are parallel.
const PARALLEL: f64 = 1e-9;

/// Places along two edges, 0 to 1 from one end to the other.
pub(super) type Places = (f64, f64);

/// An edge of the tool and one of the fixture, in the fixture frame.
pub(super) struct EdgePair<'e> {
    pub(super) of_tool: &'e ConvexEdge,
    pub(super) of_fixture: &'e ConvexEdge,
    pub(super) tool_ends: [Vector3<f64>; 2],
    pub(super) fixture_ends: [Vector3<f64>; 2],
    /// From end to end.
    u: Vector3<f64>,
    v: Vector3<f64>,
    /// From the first end of the fixture's to that of the tool's.
    w: Vector3<f64>,
    /// Square to both, not of unit length.
    across: Vector3<f64>,
}

impl<'e> EdgePair<'e> {
    pub(super) fn new(
        (of_tool, tool_ends): (&'e ConvexEdge, [Vector3<f64>; 2]),
        (of_fixture, fixture_ends): (&'e ConvexEdge, [Vector3<f64>; 2]),
    ) -> Self {
        let (u, v) = (tool_ends[1] - tool_ends[0], fixture_ends[1] - fixture_ends[0]);
        let w = tool_ends[0] - fixture_ends[0];
        EdgePair { of_tool, of_fixture, tool_ends, fixture_ends, u, v, w, across: u.cross(&v) }
    }

    fn are_parallel(&self) -> bool {
        self.across.norm_squared() <= PARALLEL * PARALLEL * self.u.norm_squared() * self.v.norm_squared()
    }

    /// Whether the lines, and with them the edges, are `limit` (m) apart or more.
    pub(super) fn are_apart(&self, limit: f64) -> bool {
        let along = self.across.dot(&self.w);
        along * along >= limit * limit * self.across.norm_squared() && !self.are_parallel()
    }

    /// Unit normal of both, either way; none if they are parallel.
    pub(super) fn normal(&self) -> Option<Vector3<f64>> {
        (!self.are_parallel()).then(|| self.across.normalize())
    }

    /// Where the lines are nearest; none if they are parallel.
    pub(super) fn nearest(&self) -> Option<Places> {
        if self.are_parallel() {
            return None;
        }
        let (uu, vv, uv) = (self.u.norm_squared(), self.v.norm_squared(), self.u.dot(&self.v));
        let (uw, vw) = (self.u.dot(&self.w), self.v.dot(&self.w));
        let square = self.across.norm_squared();
        Some(((uv * vw - vv * uw) / square, (uu * vw - uv * uw) / square))
    }

    /// Where the edges are nearest that come nearest at an end.
    pub(super) fn nearest_end(&self) -> Places {
        let [e0, e1] = self.tool_ends;
        let [f0, f1] = self.fixture_ends;
        let on_f = |p: &Vector3<f64>| (self.v.dot(&(p - f0)) / self.v.norm_squared()).clamp(0.0, 1.0);
        let on_e = |p: &Vector3<f64>| (self.u.dot(&(p - e0)) / self.u.norm_squared()).clamp(0.0, 1.0);
        let apart = |(s, t): Places| (self.w + self.u * s - self.v * t).norm_squared();
        let others = [(1.0, on_f(&e1)), (on_e(&f0), 0.0), (on_e(&f1), 1.0)];
        others.into_iter().fold((0.0, on_f(&e0)), |best, other| if apart(other) < apart(best) { other } else { best })
    }

    /// Whether the edges are nearer to each other than `limit` (m).
    pub(super) fn are_nearer(&self, limit: f64) -> bool {
        let (p, q) = self.points(self.nearest_end());
        // Where the lines are nearest within both edges, so are these.
        let within = || self.nearest().is_some_and(|places| self.reach(places, 0.0));
        !self.are_apart(limit) && ((p - q).norm() < limit || within())
    }

    /// The points at places.
    pub(super) fn points(&self, (s, t): Places) -> (Vector3<f64>, Vector3<f64>) {
        (self.tool_ends[0] + self.u * s, self.fixture_ends[0] + self.v * t)
    }

    /// Whether places are on the edges, or at most `beyond` (m) past an end where the body goes on.
    pub(super) fn reach(&self, (s, t): Places, beyond: f64) -> bool {
        self.of_tool.reaches(s, self.u.norm(), beyond) && self.of_fixture.reaches(t, self.v.norm(), beyond)
    }
}

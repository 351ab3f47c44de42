//! The contact manifold: the interface between the estimator and a pair of tool and fixture.

use std::any::Any;
use std::sync::Arc;

use nalgebra::Vector3;

use super::cache::ContactCache;
use super::gate::Gate;
use super::residual::{MAX_ROWS, Residual};
use super::sketch::{Shape, Sketch};
use crate::se3::{self, Pose, Twist};

/// Callback of [`ContactManifold::pull_back`]: `cotangent(i, residual, derivatives)` receives the
/// index `i` of a pose and its residual (m, one number per row) and writes `∂loss/∂residual[k]`
/// (unit of the loss per m) into `derivatives[k]`, which are zero before and of which those beyond
/// the residual's rows are ignored.
pub type Cotangent<'c> = &'c mut dyn FnMut(usize, &[f64], &mut [f64; MAX_ROWS]);

/// What a manifold's residual measures: the shape and frame of its rows, and with them what the
/// estimator may conclude from them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum ResidualKind {
    /// Signed distances (m) from the manifold, two-sided: positive and negative values are as
    /// likely. 1 to [`MAX_ROWS`] rows, as many at every pose; [`Plane`](super::plane::Plane) has
    /// one.
    #[default]
    Distance,
    /// Offset (m) of the tool's point from the one point that is the manifold, the fixture's
    /// origin: exactly three rows x, y, z along the axes of the fixture frame, because the rows of
    /// all contacts with a fixture are averaged row by row. The fixture's place may then be
    /// unknown, and contacts are scored by their distance from their mean, as
    /// [`contact_distances`](crate::estimate::contact_distances) says.
    PointOffset,
    /// The least of several one-sided gaps (m), of which any may be closed at a contact: the active
    /// set is latent. One row, positive apart and negative in penetration;
    /// [`candidate_contacts`](ContactManifold::candidate_contacts) has the gaps one by one. The
    /// least of noisy gaps is negative on average even at the true pose, and real contacts press
    /// parts into each other, so a mean gap at contact is fitted and subtracted from each row.
    LeastGap,
    /// Difference (m) between a pose `fixture_from_tool` and its projection onto the manifold. Six
    /// rows: x, y, z along the axes of the fixture frame, then the differences of roll, pitch and
    /// yaw (rad, the shorter way round), each times
    /// [`Metric::metres_per_radian`](super::coordinates::Metric::metres_per_radian). Motion along
    /// the manifold counts too, which contacts do not measure: no covariance follows from it.
    ProjectionError,
    /// Nothing: the shapes are not known and the residual has no rows.
    Unmodeled,
}

/// How many surfaces the candidate contacts of a manifold can belong to. How often a surface is
/// touched is estimated for each region and surface, because a tool tilts to different sides in
/// different regions. Surface `s` of region `r`, both from 0, has the number `r · per_region + s`
/// in [`Residual::surfaces`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SurfaceCounts {
    /// Number of regions into which the manifold is divided, such as ranges of depth; at least 1.
    pub regions: usize,
    /// Number of surfaces in each region; at least 1.
    pub per_region: usize,
}

/// Orders of the discrete rotational symmetry of tool and fixture, each about z of its own frame:
/// rotation by a whole turn over the order changes no residual. 1 for a part without such a
/// symmetry, and for a round part, whose rotation no contact measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RotationalOrders {
    /// Of the tool.
    pub tool: usize,
    /// Of the fixture.
    pub fixture: usize,
}

/// Poses at which a tool and a fixture can touch, as a residual and its derivatives.
///
/// Poses are `fixture_from_tool`, the tool's pose in the fixture's frame (m), or with
/// [`tool_at_target`](Self::tool_at_target) in that of the contact's target. Derivatives are by
/// the right perturbation `fixture_from_tool · Exp(ξ)` with `ξ = [v; ω]` in the tool's frame.
pub trait ContactManifold: Any + Send + Sync + std::fmt::Debug {
    /// Names of tool and fixture for messages and reports, such as "ball in socket".
    fn name(&self) -> &'static str;

    /// Appends to `residual` how far the pose is from touching (m): at most [`MAX_ROWS`] rows, as
    /// many at every pose, all zero on the manifold; their shape is that of
    /// [`residual_kind`](Self::residual_kind). A contact's distance in a
    /// [`Score`](crate::estimate::Score) is the norm of the first three rows.
    ///
    /// `resolution` (m, not negative) is the standard deviation to which gaps are known at the
    /// contact. Features whose gaps differ by less cannot be distinguished, and a manifold of
    /// several features may blend them; 0 asks for the exact distance.
    fn residual(&self, fixture_from_tool: &Pose, resolution: f64, residual: &mut Residual);

    /// Residuals of many poses: replaces the rows of `residuals[i]` by those that
    /// [`residual`](Self::residual) appends for `poses[i]` at this `resolution` (m). Both slices
    /// must have the same length; of different lengths the default leaves the surplus alone, an
    /// override may panic. A manifold that evaluates many poses faster together than one by one
    /// overrides this method.
    fn residuals(&self, poses: &[Pose], resolution: f64, residuals: &mut [Residual]) {
        for (pose, residual) in poses.iter().zip(residuals) {
            residual.clear();
            self.residual(pose, resolution, residual);
        }
    }

    /// What the residual measures, and with it the shape of its rows; [`ResidualKind::Distance`]
    /// unless overridden.
    fn residual_kind(&self) -> ResidualKind {
        ResidualKind::Distance
    }

    /// Appends the signed gaps (m) of the candidate contacts that `gate` accepts, the nearest
    /// first, at most [`MAX_ROWS`], each with its surface, to `candidates`, which is empty before.
    /// Only asked of manifolds of [`ResidualKind::LeastGap`].
    ///
    /// A candidate contact is a surface that can push in one direction, that of the linear part of
    /// its row's derivative; the gaps of all that are touched at once are zero, on average over the
    /// pose's noise. The default is the rows of the residual that `gate` accepts, which suits a
    /// manifold of one surface.
    ///
    /// `cache` belongs to the contact, which is evaluated many times at nearby poses; the result
    /// does not depend on it.
    fn candidate_contacts(
        &self,
        fixture_from_tool: &Pose,
        gate: &Gate,
        cache: &mut ContactCache,
        candidates: &mut Residual,
    ) {
        let _ = cache;
        self.residual(fixture_from_tool, 0.0, candidates);
        candidates.retain(|gap, gradient| {
            let normal_in_fixture = fixture_from_tool.rotation * se3::linear(gradient);
            gate.accepts(gap, &normal_in_fixture, gradient.dot(&(gate.covariance * gradient)))
        });
    }

    /// Whether the surfaces that are near at this pose can be distinguished; true unless
    /// overridden. Where they cannot, the marginal likelihood leaves the contact out. In the last
    /// steps of a search that may be decided once, so that
    /// [`candidate_contacts`](Self::candidate_contacts) is asked at such poses too.
    fn has_distinct_surfaces(&self, fixture_from_tool: &Pose) -> bool {
        let _ = fixture_from_tool;
        true
    }

    /// Whether the radius of edges can be another than that of the shapes; false unless overridden.
    fn has_edges(&self) -> bool {
        false
    }

    /// Derivative of a candidate's gap by the radius of all edges of tool and fixture, beyond those
    /// that they have (1, ≥ 0), where its unit normal, from the fixture into the tool, is this in
    /// both frames; 0, as unless overridden, where no edge is touched.
    fn gap_by_edge_radius(&self, normal_in_tool: &Vector3<f64>, normal_in_fixture: &Vector3<f64>) -> f64 {
        let _ = (normal_in_tool, normal_in_fixture);
        0.0
    }

    /// The same manifold with a hole `factor` (1, above 0) times as deep; `None`, as unless
    /// overridden, where it has no depth.
    fn with_scaled_depth(&self, factor: f64) -> Option<Arc<dyn ContactManifold>> {
        let _ = factor;
        None
    }

    /// Number of regions and of surfaces in each, by which candidate contacts are numbered: the
    /// same at every call, each number of a surface below their product. One region of one surface
    /// unless overridden.
    fn surface_counts(&self) -> SurfaceCounts {
        SurfaceCounts { regions: 1, per_region: 1 }
    }

    /// Gradient of a loss by a right twist `[v; ω]` (m, rad) of each pose: `gradients[i] = Jᵢᵀ yᵢ`,
    /// where `Jᵢ` (rows × 6) is the Jacobian of the residual of `poses[i]` and `yᵢ` what
    /// `cotangent`, called once for each pose in order, writes for it. `gradients` has one entry
    /// per pose, which is replaced; `resolution` (m) is as in [`residual`](Self::residual).
    fn pull_back(&self, poses: &[Pose], resolution: f64, cotangent: Cotangent<'_>, gradients: &mut [Twist]) {
        let mut residual = Residual::new();
        for (i, (pose, gradient)) in poses.iter().zip(gradients).enumerate() {
            residual.clear();
            self.residual(pose, resolution, &mut residual);
            let mut each = [0.0; MAX_ROWS];
            cotangent(i, residual.values(), &mut each);
            *gradient = residual.jacobian().iter().zip(each).map(|(row, y)| row * y).sum();
        }
    }

    /// Appends how far the pose lies outside the region in which contacts happen, at most
    /// [`MAX_ROWS`] rows, as many at every pose, each divided by its scale and so without unit.
    /// Nearly convex in the pose, so that the coarse stage converges from afar. The default is the
    /// residual in metres at resolution 0.
    fn envelope(&self, fixture_from_tool: &Pose, rows: &mut Residual) {
        self.residual(fixture_from_tool, 0.0, rows);
    }

    /// Indices (0–5, each once, ascending) of the components of a twist `[v; ω]` of the fixture in
    /// its own frame that move the manifold: 0–2 for a socket, which is a point; 2–4 for the plane
    /// z = 0, which is unchanged by motion in itself. Other components are not estimated.
    fn fixture_directions(&self) -> &'static [usize];

    /// Indices (0–5, each once, ascending) of the components of a twist `[v; ω]` of the tool in its
    /// own frame that change the residual; 0–2 for a ball about the tool's origin. Components that
    /// no fixture's manifold lists are not estimated.
    fn tool_directions(&self) -> &'static [usize];

    /// Position (m) of the tool's origin in the frame of a contact's target
    /// ([`ContactLog::target`](crate::contact::ContactLog::target)) where the tool touches it, for
    /// a manifold of which each contact has a target of its own; poses are then
    /// `target_from_tool`. `None`, as unless overridden: contacts touch the fixture itself.
    fn tool_at_target(&self) -> Option<Vector3<f64>> {
        None
    }

    /// Discrete rotational symmetry of tool and fixture; none unless overridden.
    fn rotational_orders(&self) -> RotationalOrders {
        RotationalOrders { tool: 1, fixture: 1 }
    }

    /// Shapes of tool and fixture for a picture, each in its own frame (m); two points unless
    /// overridden.
    fn sketch(&self) -> Sketch {
        Sketch { tool: Shape::Point, fixture: Shape::Point }
    }
}

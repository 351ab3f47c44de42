//! Residuals of contacts from the manifold that they touch.

use super::linearization::LinearizationPoint;
use super::objective::Objective;
use crate::manifold::Residual;
use crate::se3::Pose;

/// The rows of fixture `f`'s manifold at poses of contacts with it, written to `rows`, for an
/// envelope or residual objective.
pub(crate) fn residual_rows(
    point: &LinearizationPoint<'_>,
    f: usize,
    fixture_from_tool: &[Pose],
    objective: Objective,
    rows: &mut [Residual],
) {
    let manifold = &point.model.problem.fixtures[f].manifold;
    match objective {
        Objective::Residual(_) | Objective::ContactModes => {
            manifold.residuals(fixture_from_tool, point.model.noise.resolution, rows);
        }
        Objective::Envelope => fixture_from_tool.iter().zip(rows).for_each(|(pose, rows)| {
            rows.clear();
            manifold.envelope(pose, rows);
        }),
    }
}

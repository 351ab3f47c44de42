//! What the measured gaps of a contact's candidates are off by: gap biases, and edges.

use super::linearization::FixtureState;
use crate::manifold::{ContactManifold, MAX_ROWS, Residual, axis_direction};
use crate::parameter::ParameterId;
use crate::se3::{self, Pose};

/// What the gap of each row depends on besides the pose.
pub(super) struct RowBiases<'a> {
    fixture: &'a FixtureState,
    directions: [usize; MAX_ROWS],
    /// Derivatives of the gaps by the radius of all edges (1), if that is a parameter.
    by_edge_radius: [f64; MAX_ROWS],
}

impl<'a> RowBiases<'a> {
    /// Of the rows at this pose, of contacts with a fixture of this shape.
    pub fn new(
        rows: &Residual,
        fixture_from_tool: &Pose,
        (fixture, manifold): (&'a FixtureState, &dyn ContactManifold),
    ) -> Self {
        let mut biases = RowBiases { fixture, directions: [0; MAX_ROWS], by_edge_radius: [0.0; MAX_ROWS] };
        for (r, row) in rows.jacobian().iter().enumerate() {
            let in_tool = se3::linear(row);
            let in_fixture = fixture_from_tool.rotation * in_tool;
            biases.directions[r] = axis_direction(&in_fixture);
            if fixture.has_edge_radius {
                biases.by_edge_radius[r] = manifold.gap_by_edge_radius(&in_tool, &in_fixture);
            }
        }
        biases
    }

    /// Derivative of the residual of row `r` by a parameter; `None` of one that moves the tool.
    pub fn derivative(&self, id: ParameterId, r: usize) -> Option<f64> {
        match id {
            ParameterId::GapBias(_) => Some(-1.0),
            ParameterId::DirectionalGapBias(_, k) => Some(-f64::from(u8::from(self.directions[r] == k))),
            ParameterId::EdgeRadius(_) => Some(self.by_edge_radius[r]),
            _ => None,
        }
    }

    /// What the gap (m) of row `r` between the declared shapes is too large by.
    pub fn bias(&self, r: usize) -> f64 {
        self.fixture.gap_bias + self.fixture.directional_gap_bias[self.directions[r]]
    }
}

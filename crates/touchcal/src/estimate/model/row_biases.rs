//! What the measured gaps of a contact's candidates are off by: gap biases, and edges.

use super::linearization::FixtureState;
use crate::estimate::problem::Fixture;
use crate::manifold::{MAX_ROWS, Residual, axis_direction};
use crate::parameter::ParameterId;
use crate::se3::{self, Pose};

/// What the gap of each row depends on besides the pose.
pub(super) struct RowBiases {
    directions: [usize; MAX_ROWS],
    /// Derivatives of the gaps by the radius of all edges (1).
    by_edge_radius: [f64; MAX_ROWS],
}

impl RowBiases {
    /// Of the rows at this pose, of contacts with this fixture.
    pub fn new(rows: &Residual, fixture_from_tool: &Pose, fixture: &Fixture) -> Self {
        let mut biases = RowBiases { directions: [0; MAX_ROWS], by_edge_radius: [0.0; MAX_ROWS] };
        for (r, row) in rows.jacobian().iter().enumerate() {
            let in_tool = se3::linear(row);
            let in_fixture = fixture_from_tool.rotation * in_tool;
            biases.directions[r] = axis_direction(&in_fixture);
            if fixture.has_uncertain_edges() {
                biases.by_edge_radius[r] = fixture.manifold.gap_by_edge_radius(&in_tool, &in_fixture);
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
    pub fn bias(&self, fixture: &FixtureState, r: usize) -> f64 {
        let of_gap = fixture.gap_bias + fixture.directional_gap_bias[self.directions[r]];
        of_gap - fixture.edge_radius * self.by_edge_radius[r]
    }
}

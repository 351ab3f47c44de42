//! Contact between parts whose shapes are not known.

use super::contact_manifold::{ContactManifold, ResidualKind};
use super::residual::Residual;
use crate::se3::Pose;

/// Contact between parts whose shapes are not known: residual, envelope and candidate contacts
/// without rows. Such contacts can be recorded as samples of a manifold
/// ([`contact_poses`](crate::estimate::contact_poses)); by themselves they determine no parameter.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Unmodeled;

impl ContactManifold for Unmodeled {
    fn name(&self) -> &'static str {
        "touch of unknown shape"
    }

    fn residual(&self, _: &Pose, _: f64, _: &mut Residual) {}

    fn residual_kind(&self) -> ResidualKind {
        ResidualKind::Unmodeled
    }

    fn fixture_directions(&self) -> &'static [usize] {
        &[]
    }

    fn tool_directions(&self) -> &'static [usize] {
        &[]
    }
}

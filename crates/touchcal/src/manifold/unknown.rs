//! A touch of which nothing is known yet.

use super::{ContactManifold, Rows};
use crate::se3::Pose;

/// The contacts of parts whose shapes are not known: no rows. They can be recorded as samples of a
/// manifold, and determine nothing before that.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Unknown;

impl ContactManifold for Unknown {
    fn name(&self) -> &'static str {
        "touch of unknown shape"
    }

    fn residual(&self, _: &Pose, _: f64, _: &mut Rows) {}

    fn fixture_directions(&self) -> &'static [usize] {
        &[]
    }

    fn tool_directions(&self) -> &'static [usize] {
        &[]
    }

    fn is_unknown(&self) -> bool {
        true
    }
}

//! What deflects the joints of an arm at rest.

use crate::se3::Wrench;

/// What the joints of an arm at rest carry, beside what is measured of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum JointLoad<'a> {
    /// Gravity on the arm's masses, and the wrench `[f; τ]` (N, N m) exerted on the tip about its
    /// origin, in its frame.
    OnTip(&'a Wrench),
    /// The measured torque (N m) about each moving joint, or force (N) along a prismatic one, base
    /// first, that gravity and contact exert on what the joint carries. Missing ones are 0.
    Torques(&'a [f64]),
}

impl<'a> From<&'a Wrench> for JointLoad<'a> {
    fn from(wrench: &'a Wrench) -> Self {
        JointLoad::OnTip(wrench)
    }
}

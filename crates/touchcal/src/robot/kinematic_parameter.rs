//! The parameters that kinematics depend on.

use serde::{Deserialize, Serialize};

/// What a number changes in the kinematics of an arm with its tool; also the column of the Jacobian
/// that belongs to it. An index `i` counts the moving joints from the base, and `k` the components
/// of a twist `[v; ω]` (0 to 5) or the segments, all from 0. The formula that they enter is that of
/// [`Kinematics`](super::Kinematics).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum KinematicParameter {
    /// Strain `r` common to all joint origins (1): lengths are `l = (1 + r)·l₀`.
    Strain,
    /// `(k)`: strain of segment `k` of [`segments`](super::segments()) (1), on top of the common
    /// one: lengths are `l = (1 + r + r_k)·l₀`.
    SegmentStrain(usize),
    /// `(i)`: encoder offset `b` of joint `i` (rad, or m for a prismatic joint): true position =
    /// measured − offset.
    JointOffset(usize),
    /// `(i, k)`: component `k` of the local twist ξ on joint `i`'s origin (m, rad), in the joint's
    /// frame: `origin · Exp(ξ)`.
    JointOrigin(usize, usize),
    /// `(i)`: compliance `c` of joint `i` (rad/(N m)), on top of what the arm declares: true angle
    /// = measured − offset + compliance · torque of gravity and load. Without effect on a prismatic
    /// joint.
    JointCompliance(usize),
    /// `(i)`: half of the play `b` of joint `i` (rad, or m for a prismatic joint), on top of what
    /// the arm declares: true position = measured − offset + … + b s(τ), at the side `s` of its
    /// play to which the torque of gravity and load pushes the joint, −1 to 1.
    JointBacklash(usize),
    /// `(k)`: component `k` of the local twist ξ on the tool's pose on the tip link (m, rad), in
    /// the tool frame: `tip_from_tool · Exp(ξ)`.
    Tool(usize),
}

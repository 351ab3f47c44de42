//! The parameters that kinematics depend on.

/// What a number changes in the kinematics of an arm with its tool; also the column of the Jacobian
/// that belongs to it. Indices count the moving joints, and components `k` of twists `[v; ω]`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum KinematicParameter {
    /// Strain `r` common to all joint origins (1): `l = (1 + r)·l₀`.
    Strain,
    /// Strain of segment `k` of [`segments`](super::segments()) (1), on top of the common one.
    SegmentStrain(usize),
    /// Encoder offset `b` of joint `i` (rad or m): true position = measured − offset.
    JointOffset(usize),
    /// Component `k` of the local twist on joint `i`'s origin (m, rad): `origin · Exp(ξ)`.
    JointOrigin(usize, usize),
    /// Compliance `c` of joint `i` (rad/(N m)), on top of what the arm declares: true angle =
    /// measured − offset + compliance · torque of gravity and load.
    JointCompliance(usize),
    /// Component `k` of the local twist on the tool's pose on the tip link (m, rad).
    Tool(usize),
}

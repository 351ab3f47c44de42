//! Arms that come with the crate, as URDF text with the makers' published kinematics.

/// URDF text (m, rad) of the KUKA LBR iiwa 14 R820, 7 joints, from `base_link` to the media flange
/// `flange`: 0.360, 0.420, 0.400 and 0.126 m between base, shoulder, elbow, wrist and flange (KUKA
/// Sunrise.OS / LBR iiwa specification, 2015). Without masses and compliances.
pub const IIWA14: &str = include_str!("builtin/iiwa14.urdf");

/// URDF text (m, rad) of the Franka Emika Panda, 7 joints, from `panda_link0` to the flange
/// `panda_link8` (Franka Control Interface documentation, Denavit–Hartenberg parameters). Without
/// masses and compliances.
pub const PANDA: &str = include_str!("builtin/panda.urdf");

/// Name and URDF text of each built-in arm, as [`read_builtin`](crate::io::urdf::read_builtin)
/// knows it: [`IIWA14`], then [`PANDA`].
pub const ALL: [(&str, &str); 2] = [("iiwa14", IIWA14), ("panda", PANDA)];

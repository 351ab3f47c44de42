//! The nominal arm in `estimate.json`.

use std::fmt::Write;

use serde::{Deserialize, Serialize};

use crate::io::base::bytes::sha256;
use crate::io::base::error::quoted;
use crate::robot::{JointKind, Robot};

/// Digits of the fingerprint that messages show.
const SHOWN: usize = 8;

/// The nominal arm of a calibration, to recognize it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RobotEntry {
    /// Name of the robot.
    pub name: String,
    /// Name of the link where its chain begins.
    pub base: String,
    /// Name of the link where its chain ends.
    pub tip: String,
    /// SHA-256 of its kinematics (names, kinds, origins and axes of joints, numbers to 1e-9), 64
    /// hexadecimal digits in lower case. It is the same for URDFs whose numbers agree so far,
    /// whatever else is in them, masses and compliances included.
    pub sha256: String,
}

impl RobotEntry {
    /// That of an arm.
    pub fn of(robot: &Robot) -> RobotEntry {
        let mut kinematics = String::new();
        for joint in robot.joints() {
            let pose = &joint.parent_from_joint;
            let rotation = pose.rotation.to_rotation_matrix();
            // The axis of a fixed joint has no meaning.
            let axis = joint.axis.iter().filter(|_| joint.kind != JointKind::Fixed);
            let numbers = pose.translation.vector.iter().chain(rotation.matrix()).chain(axis);
            // Writing to a text cannot fail.
            let _ = write!(kinematics, "{:?} {:?}", joint.name, joint.kind);
            numbers.for_each(|number| {
                // Neither the last bits of a sine nor the sign of a zero make another arm.
                let _ = write!(kinematics, " {}", (number * 1e9).round() + 0.0);
            });
            kinematics.push('\n');
        }
        let [name, base, tip] = [robot.name(), robot.base(), robot.tip()].map(str::to_owned);
        RobotEntry { name, base, tip, sha256: sha256(kinematics) }
    }

    /// Whether both are the same chain of the same kinematics, whatever its name.
    pub fn is_same_arm(&self, other: &RobotEntry) -> bool {
        self.base == other.base && self.tip == other.tip && self.sha256 == other.sha256
    }

    /// Name and fingerprint for a message.
    pub(super) fn words(&self) -> String {
        let digits = self.sha256.get(..SHOWN).unwrap_or(&self.sha256);
        let [name, base, tip] = [&self.name, &self.base, &self.tip].map(|name| quoted(name));
        format!("a calibration of the robot {name} from {base} to {tip} whose kinematics have the hash {digits}…")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::robot::urdf::{Ends, read_builtin};
    use crate::robot::Joint;

    #[test]
    fn an_arm_is_recognized_by_its_kinematics() {
        let robot = read_builtin("iiwa14", Ends::default()).unwrap().robot;
        let changed = |change: fn(&mut Joint)| {
            let mut joints = robot.joints().to_vec();
            change(&mut joints[2]);
            RobotEntry::of(&Robot::new(robot.name(), robot.base(), joints).unwrap())
        };
        let entry = RobotEntry::of(&robot);
        assert_eq!(changed(|_| ()), entry);
        // The last bits, and what is no kinematics.
        assert_eq!(changed(|joint| joint.parent_from_joint.translation.vector.y += 1e-13), entry);
        assert_eq!(changed(|joint| joint.inertia = None), entry);
        for other in [
            changed(|joint| joint.parent_from_joint.translation.vector.y += 2e-9),
            changed(|joint| joint.axis = -joint.axis),
            changed(|joint| joint.name.push('b')),
        ] {
            assert_ne!(other.sha256, entry.sha256);
        }
    }
}

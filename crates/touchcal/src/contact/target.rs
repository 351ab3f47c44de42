//! Targets: places in a fixture's frame that contacts touch, one for each contact.

use nalgebra::{UnitQuaternion, UnitVector3, Vector3};

use crate::se3::Pose;

/// The pose `fixture_from_target` (m) of a target at `place` (m) whose +z is along `normal` (any
/// length), turned about that axis anyhow; not rotated without a normal. `None` if the normal has
/// no direction.
pub fn target_pose(place: Vector3<f64>, normal: Option<Vector3<f64>>) -> Option<Pose> {
    let rotation = match normal {
        None => UnitQuaternion::identity(),
        Some(normal) => {
            let normal = UnitVector3::try_new(normal, f64::MIN_POSITIVE)?;
            // The axis farthest from the normal has the longest part across it.
            UnitQuaternion::face_towards(&normal, &Vector3::ith(normal.iamin(), 1.0))
        }
    };
    Some(Pose::from_parts(place.into(), rotation))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn z_is_along_the_normal() {
        for normal in [Vector3::new(0.3, -2.0, 0.5), Vector3::z(), -Vector3::z(), Vector3::new(1e-9, 0.0, -1.0)] {
            let pose = target_pose(Vector3::new(1.0, 2.0, 3.0), Some(normal)).expect("a direction");
            let z = pose.rotation * Vector3::z();
            assert!((z - normal.normalize()).norm() < 1e-12, "{normal}: {z}");
            assert_eq!(pose.translation.vector, Vector3::new(1.0, 2.0, 3.0));
        }
        assert!(target_pose(Vector3::zeros(), Some(Vector3::zeros())).is_none());
        assert!(target_pose(Vector3::zeros(), Some(Vector3::repeat(f64::NAN))).is_none());
    }
}

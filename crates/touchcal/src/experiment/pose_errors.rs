//! Errors of an arm's poses, in base and apart from where the base is.

use nalgebra::Vector3;

use crate::se3::{self, Pose};

/// Root mean square and largest value.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RmsAndMax {
    /// Root mean square.
    pub rms: f64,
    /// Largest value.
    pub max: f64,
}

impl RmsAndMax {
    /// Of absolute values; zeros without any.
    fn of(values: impl Iterator<Item = f64>) -> Self {
        let (mut squares, mut count, mut max) = (0.0, 0, 0.0_f64);
        for value in values {
            (squares, count, max) = (squares + value * value, count + 1, max.max(value.abs()));
        }
        RmsAndMax { rms: (squares / f64::from(count.max(1))).sqrt(), max }
    }
}

/// Errors of modelled poses relative to true ones.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PoseErrors {
    /// Distance of the positions in base (m).
    pub position: RmsAndMax,
    /// Angle of the rotation between the orientations (rad).
    pub angle: RmsAndMax,
    /// The same distance (m), with the modelled base moved to where the positions agree best.
    pub aligned_position: RmsAndMax,
    /// The same angle (rad) with the base moved so.
    pub aligned_angle: RmsAndMax,
    /// Error of the distance between two successive positions (m).
    pub distance: RmsAndMax,
}

/// Errors of `model` relative to `truth`: poses `base_from_tool` (m), as many of both, at the same
/// encoder readings. The base is aligned by the rigid motion with the least squared distances of
/// positions (Arun, Huang & Blostein, *Least-squares fitting of two 3-D point sets* (1987)).
pub fn pose_errors(truth: &[Pose], model: &[Pose]) -> PoseErrors {
    let position = |poses: &[Pose]| poses.iter().map(|pose| pose.translation.vector).collect::<Vec<Vector3<f64>>>();
    let motion = se3::alignment(&position(truth), &position(model)).unwrap_or_default();
    let aligned: Vec<Pose> = model.iter().map(|pose| motion * pose).collect();
    let apart = |model: &[Pose]| {
        let both = || truth.iter().zip(model);
        let positions = both().map(|(a, b)| (a.translation.vector - b.translation.vector).norm());
        let angles = both().map(|(a, b)| a.rotation.angle_to(&b.rotation));
        (RmsAndMax::of(positions), RmsAndMax::of(angles))
    };
    let length = |pair: &[Pose]| (pair[1].translation.vector - pair[0].translation.vector).norm();
    let distances = truth.windows(2).zip(model.windows(2)).map(|(a, b)| length(a) - length(b));
    let (position, angle) = apart(model);
    let (aligned_position, aligned_angle) = apart(&aligned);
    PoseErrors { position, angle, aligned_position, aligned_angle, distance: RmsAndMax::of(distances) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::se3::{Twist, exp};

    fn pose(xi: [f64; 6]) -> Pose {
        exp(&Twist::from(xi))
    }

    /// With the base moved all errors are those of the motion, and none are left once it is
    /// aligned; with one arm 1 % longer distances are 1 % off.
    #[test]
    fn the_base_is_aligned() {
        let truth: Vec<Pose> = (0..20)
            .map(|k| pose([1.0, 0.2, -0.3, 0.1, 0.7, 0.4].map(|x| x * f64::sin(0.7 * f64::from(k) + 9.0 * x))))
            .collect();
        let motion = pose([0.01, -0.02, 0.03, 0.0, 0.0, 0.1]);
        let moved: Vec<Pose> = truth.iter().map(|pose| motion * pose).collect();
        let errors = pose_errors(&truth, &moved);
        assert!((errors.angle.rms - 0.1).abs() < 1e-12 && (errors.angle.max - 0.1).abs() < 1e-12, "{errors:?}");
        assert!(errors.position.rms > 0.03 && errors.position.max >= errors.position.rms, "{errors:?}");
        let left = [errors.aligned_position.max, errors.aligned_angle.max, errors.distance.max];
        assert!(left.iter().all(|error| *error < 1e-9), "{left:?}");
        let longer: Vec<Pose> =
            moved.iter().map(|pose| Pose::from_parts((1.01 * pose.translation.vector).into(), pose.rotation)).collect();
        let (errors, scale) = (pose_errors(&truth, &longer), pose_errors(&truth, &vec![Pose::identity(); 20]));
        assert!((errors.distance.rms - 0.01 * scale.distance.rms).abs() < 1e-12, "{errors:?}");
        assert!(errors.aligned_position.rms < 0.02 && errors.aligned_angle.max < 1e-9, "{errors:?}");
    }
}

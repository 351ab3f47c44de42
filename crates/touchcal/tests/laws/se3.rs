//! The laws of SE(3) that everything else leans on, near the identity, far from it and near π.

use nalgebra::Vector3;
use proptest::prelude::*;
use touchcal::se3::{self, Pose, Twist};

/// Twists whose angle is uniform, tiny (1e-9 to 1e-4), near the series switch, or within 1e-3 of π;
/// translations up to 10 m.
fn twists() -> impl Strategy<Value = Twist> {
    let direction = prop::array::uniform3(-1.0..1.0f64)
        .prop_filter("direction", |d| Vector3::from(*d).norm() > 1e-2)
        .prop_map(|d| Vector3::from(d).normalize());
    let angle = prop_oneof![
        0.0..3.1f64,
        (-9.0..-4.0f64).prop_map(|e| 10f64.powf(e)),
        0.09..0.21f64,
        (std::f64::consts::PI - 1e-3)..(std::f64::consts::PI - 1e-7),
    ];
    (direction, angle, prop::array::uniform3(-10.0..10.0f64))
        .prop_map(|(axis, angle, v)| se3::twist(&Vector3::from(v), &(axis * angle)))
}

fn difference(a: &Pose, b: &Pose) -> f64 {
    (a.to_homogeneous() - b.to_homogeneous()).amax()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(500))]

    #[test]
    fn log_inverts_exp(xi in twists()) {
        prop_assert!((se3::log(&se3::exp(&xi)) - xi).amax() < 1e-11);
    }

    #[test]
    fn exp_of_the_negative_is_the_inverse(xi in twists()) {
        prop_assert!(difference(&se3::exp(&-xi), &se3::exp(&xi).inverse()) < 1e-13);
    }

    #[test]
    fn exp_adds_along_one_twist(xi in twists()) {
        let parts = se3::exp(&(xi * 0.3)) * se3::exp(&(xi * 0.7));
        prop_assert!(difference(&parts, &se3::exp(&xi)) < 1e-13);
    }

    #[test]
    fn adjoint_moves_a_twist_to_the_other_side(xi in twists(), eta in twists()) {
        let pose = se3::exp(&xi);
        let moved = se3::exp(&(se3::adjoint(&pose) * eta)) * pose;
        prop_assert!(difference(&(pose * se3::exp(&eta)), &moved) < 1e-11);
    }

    #[test]
    fn right_jacobian_is_the_derivative_of_exp(xi in twists(), delta in twists()) {
        let delta = delta / delta.norm();
        let slope = |h: f64| {
            let ahead = se3::log(&(se3::exp(&xi).inverse() * se3::exp(&(xi + delta * h))));
            let behind = se3::log(&(se3::exp(&xi).inverse() * se3::exp(&(xi - delta * h))));
            (ahead - behind) / (2.0 * h)
        };
        let expected = se3::right_jacobian(&xi) * delta;
        // Central differences with one Richardson step: errors of order h⁴, rounding of order ε/h.
        let h = 1e-3;
        let measured = (slope(h / 2.0) * 4.0 - slope(h)) / 3.0;
        prop_assert!((measured - expected).amax() < 1e-9 * (1.0 + expected.amax()), "{measured} {expected}");
    }

    #[test]
    fn right_jacobian_does_not_jump_where_series_take_over(xi in twists()) {
        prop_assume!(se3::angular(&xi).norm() > 0.0);
        let axis = se3::angular(&xi).normalize();
        for switch in [0.1, 0.2] {
            let at = |angle: f64| se3::right_jacobian(&se3::twist(&se3::linear(&xi), &(axis * angle)));
            let jump = at(switch * (1.0 + 1e-13)) - at(switch * (1.0 - 1e-13));
            prop_assert!(jump.amax() < 1e-11);
        }
    }
}

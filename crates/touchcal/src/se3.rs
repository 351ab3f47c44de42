//! Rigid motions: exponential, logarithm, adjoint and right Jacobians of SE(3).
//!
//! Conventions, everywhere in this crate:
//!
//! - a pose `a_from_b` maps coordinates in frame `b` to coordinates in frame `a`:
//!   `p_a = a_from_b * p_b`;
//! - a twist is `[v; ω]`, translation first;
//! - perturbations are local (right): `T ⊕ ξ = T · Exp(ξ)`.
//!
//! Formulas follow Barfoot, *State Estimation for Robotics* (2017), chapter 7, reordered for right
//! perturbations, and Solà, Deray & Atchuthan, *A micro Lie theory for state estimation in
//! robotics* (2018), eqs. 143–182.

use nalgebra::{Isometry3, Matrix3, Matrix6, Rotation3, Translation3, UnitQuaternion, Vector3, Vector6};

/// A rigid motion `a_from_b`: the pose of frame b in frame a, with `p_a = a_from_b * p_b` for a
/// point `p` (m).
pub type Pose = Isometry3<f64>;
/// A twist `[v; ω]` = `[vx, vy, vz, ωx, ωy, ωz]`: translation (m), then rotation (rad).
pub type Twist = Vector6<f64>;
/// A wrench `[f; τ]` = `[fx, fy, fz, τx, τy, τz]`: force (N), then torque (N m) about the point and
/// in the frame that each use names.
pub type Wrench = [f64; 6];

/// Below this angle (rad) series replace the closed forms: the first neglected term is then under
/// 1e-14, and so is the cancellation of the closed forms above it.
const SERIES_BELOW: f64 = 0.1;

/// The antisymmetric 3×3 matrix `[a]×` with `[a]× b = a × b`, in the unit of `a`.
pub fn skew(a: &Vector3<f64>) -> Matrix3<f64> {
    Matrix3::new(0.0, -a.z, a.y, a.z, 0.0, -a.x, -a.y, a.x, 0.0)
}

/// Linear part of a twist `[v; ω]`, its first three components: `v` (m), or the force (N) of a
/// wrench given as a [`Twist`].
pub fn linear(twist: &Twist) -> Vector3<f64> {
    Vector3::new(twist[0], twist[1], twist[2])
}

/// Angular part of a twist `[v; ω]`, its last three components: `ω` (rad), or the torque (N m) of a
/// wrench given as a [`Twist`].
pub fn angular(twist: &Twist) -> Vector3<f64> {
    Vector3::new(twist[3], twist[4], twist[5])
}

/// The twist `[v; ω]` of a linear part `v` (m) and an angular part `w` = ω (rad).
pub fn twist(v: &Vector3<f64>, w: &Vector3<f64>) -> Twist {
    Vector6::new(v.x, v.y, v.z, w.x, w.y, w.z)
}

/// `Exp: ℝ⁶ → SE(3)`, the motion of moving along the constant twist `xi` = `[v; ω]` (m, rad) for
/// unit time (Solà et al. 2018, eq. 172). Exact for any angle ‖ω‖; series where it is small.
pub fn exp(xi: &Twist) -> Pose {
    let w = angular(xi);
    let translation = so3_left_jacobian(&w) * linear(xi);
    Pose::from_parts(Translation3::from(translation), UnitQuaternion::from_scaled_axis(w))
}

/// `Log: SE(3) → ℝ⁶`, the twist `[v; ω]` (m, rad) with ‖ω‖ ≤ π whose [`exp`] is `pose` (Solà et al.
/// 2018, eq. 173). At an angle of π either direction of the axis is a solution, and one of them is
/// returned.
pub fn log(pose: &Pose) -> Twist {
    let w = rotation_log(&pose.rotation);
    let v = so3_left_jacobian_inverse(&w) * pose.translation.vector;
    twist(&v, &w)
}

/// `Ad_T` of a pose `T`, 6×6 for twists `[v; ω]`, with `T · Exp(ξ) = Exp(Ad_T ξ) · T` (Solà et al.
/// 2018, eq. 175).
pub fn adjoint(pose: &Pose) -> Matrix6<f64> {
    let r = *pose.rotation.to_rotation_matrix().matrix();
    let mut ad = Matrix6::zeros();
    ad.fixed_view_mut::<3, 3>(0, 0).copy_from(&r);
    ad.fixed_view_mut::<3, 3>(3, 3).copy_from(&r);
    ad.fixed_view_mut::<3, 3>(0, 3).copy_from(&(skew(&pose.translation.vector) * r));
    ad
}

/// `Jr(ξ)` of SE(3) at the twist `xi` = `[v; ω]` (m, rad), 6×6, with
/// `Exp(ξ + δ) ≈ Exp(ξ) · Exp(Jr(ξ) δ)` for small δ (Solà et al. 2018, eqs. 179–182, with
/// `Jr(ξ) = Jl(−ξ)`). The identity at ξ = 0.
pub fn right_jacobian(xi: &Twist) -> Matrix6<f64> {
    let v = -linear(xi);
    let w = -angular(xi);
    let j = so3_left_jacobian(&w);
    let mut jacobian = Matrix6::zeros();
    jacobian.fixed_view_mut::<3, 3>(0, 0).copy_from(&j);
    jacobian.fixed_view_mut::<3, 3>(3, 3).copy_from(&j);
    jacobian.fixed_view_mut::<3, 3>(0, 3).copy_from(&coupling(&v, &w));
    jacobian
}

/// Logarithm of a rotation: its rotation vector φ (rad) with ‖φ‖ ≤ π, axis times angle (Solà et al.
/// 2018, appendix B). At an angle of π either direction of the axis is a solution, and one of them
/// is returned.
pub fn rotation_log(rotation: &UnitQuaternion<f64>) -> Vector3<f64> {
    let q = rotation.quaternion();
    let (vector, scalar) = if q.w < 0.0 { (-q.imag(), -q.w) } else { (q.imag(), q.w) };
    let sine = vector.norm();
    if sine < 1e-9 {
        return vector * 2.0;
    }
    vector * (2.0 * sine.atan2(scalar) / sine)
}

/// `∂φ/∂δ` = `Jr⁻¹(φ)` (3×3) of the rotation vector φ = `vector` (rad) for a local rotation δ
/// (rad): `Log(Exp(φ) · Exp(δ)) ≈ φ + Jr⁻¹(φ) δ` for small δ (Solà et al. 2018, eq. 144). Grows
/// without bound as ‖φ‖ → 2π.
pub fn rotation_log_jacobian(vector: &Vector3<f64>) -> Matrix3<f64> {
    so3_left_jacobian_inverse(&-vector)
}

/// `Jl(ω)` of SO(3): `I + (1−cos φ)/φ² [ω]× + (φ−sin φ)/φ³ [ω]×²`.
fn so3_left_jacobian(w: &Vector3<f64>) -> Matrix3<f64> {
    let (_, b, c) = series(w.norm());
    let s = skew(w);
    Matrix3::identity() + s * b + s * s * c
}

/// `Jl(ω)⁻¹` of SO(3), regular up to φ = 2π: `I − ½[ω]× + (1/φ² − (1+cos φ)/(2φ sin φ)) [ω]×²`.
fn so3_left_jacobian_inverse(w: &Vector3<f64>) -> Matrix3<f64> {
    let angle = w.norm();
    let s = skew(w);
    let factor = if angle < SERIES_BELOW {
        let a2 = angle * angle;
        1.0 / 12.0 + a2 / 720.0 * (1.0 + a2 / 42.0 * (1.0 + a2 / 40.0))
    } else {
        // (1+cos φ)/sin φ = cot(φ/2), regular at π.
        let half = 0.5 * angle;
        (1.0 - half / half.tan()) / (angle * angle)
    };
    Matrix3::identity() - s * 0.5 + s * s * factor
}

/// `(sin φ/φ, (1−cos φ)/φ², (φ−sin φ)/φ³)`.
fn series(angle: f64) -> (f64, f64, f64) {
    let a2 = angle * angle;
    if angle < SERIES_BELOW {
        (
            1.0 - a2 / 6.0 * (1.0 - a2 / 20.0 * (1.0 - a2 / 42.0)),
            0.5 - a2 / 24.0 * (1.0 - a2 / 30.0 * (1.0 - a2 / 56.0)),
            1.0 / 6.0 - a2 / 120.0 * (1.0 - a2 / 42.0 * (1.0 - a2 / 72.0)),
        )
    } else {
        let (sin, cos) = angle.sin_cos();
        (sin / angle, (1.0 - cos) / a2, (angle - sin) / (a2 * angle))
    }
}

/// The block `Q(v, ω)` of the left Jacobian of SE(3) (Solà et al. 2018, eq. 180; Barfoot 2017, eq.
/// 7.86b).
fn coupling(v: &Vector3<f64>, w: &Vector3<f64>) -> Matrix3<f64> {
    let angle = w.norm();
    let (_, _, c) = series(angle);
    let a2 = angle * angle;
    // d = (φ² + 2 cos φ − 2)/(2φ⁴), e = (2φ − 3 sin φ + φ cos φ)/(2φ⁵)
    let (d, e) = if angle < 2.0 * SERIES_BELOW {
        (
            1.0 / 24.0 - a2 / 720.0 * (1.0 - a2 / 56.0 * (1.0 - a2 / 90.0)),
            1.0 / 120.0 - a2 / 2520.0 * (1.0 - a2 / 48.0 * (1.0 - a2 / 82.5)),
        )
    } else {
        let (sin, cos) = angle.sin_cos();
        ((a2 + 2.0 * cos - 2.0) / (2.0 * a2 * a2), (2.0 * angle - 3.0 * sin + angle * cos) / (2.0 * a2 * a2 * angle))
    };
    let p = skew(v);
    let s = skew(w);
    let sp = s * p;
    let ps = p * s;
    let sps = sp * s;
    p * 0.5 + (sp + ps + sps) * c + (s * sp + ps * s - sps * 3.0) * d + (sps * s + s * sps) * e
}
/// The rigid motion `T` with the least `Σ ‖toᵢ − T fromᵢ‖²` over pairs of points (m), as many of
/// both; of points in a line one of many. `None` if a point is not finite.
///
/// Source: Arun, Huang & Blostein, *Least-squares fitting of two 3-D point sets* (1987).
pub fn alignment(to: &[Vector3<f64>], from: &[Vector3<f64>]) -> Option<Pose> {
    let mean = |points: &[Vector3<f64>]| points.iter().sum::<Vector3<f64>>() / points.len().max(1) as f64;
    let (mean_to, mean_from) = (mean(to), mean(from));
    let pairs = to.iter().zip(from);
    let covariance: Matrix3<f64> = pairs.map(|(a, b)| (a - mean_to) * (b - mean_from).transpose()).sum();
    if covariance.iter().any(|entry| !entry.is_finite()) {
        return None;
    }
    let svd = covariance.svd(true, true);
    let (u, v_t) = (svd.u?, svd.v_t?);
    // A reflection fits points in a plane as well.
    let hand = Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, (u * v_t).determinant().signum()));
    let rotation = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(u * hand * v_t));
    Some(Pose::from_parts((mean_to - rotation * mean_from).into(), rotation))
}

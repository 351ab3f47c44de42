//! Covariance of a contact's residual, and whitening with it.

use nalgebra::Matrix6;

use crate::estimate::contact_mode::CandidateMatrix;
use crate::se3::Twist;

/// Covariance of a contact's pose by encoder noise (right twists, m and rad), `J Σ_q Jᵀ`, with the
/// derivatives `J` of the pose by the `joints`; variances are multiplied by `variance_factor`.
pub(super) fn pose_covariance(joints: &[Twist], joint_variance: &[f64], variance_factor: f64) -> Matrix6<f64> {
    let mut covariance = Matrix6::zeros();
    for (joint, variance) in joints.iter().zip(joint_variance) {
        covariance.ger(variance_factor * variance, joint, joint, 1.0);
    }
    covariance
}

/// Covariance of residual rows (m²), errors in variables: `N C Nᵀ + v I`, with the derivatives `N`
/// of the rows by the pose, the pose's covariance `C`, and a variance `v` (m²) of each row's own.
pub(super) fn row_covariance(rows: &[Twist], of_pose: &Matrix6<f64>, own_variance: f64) -> CandidateMatrix {
    let mut covariance = CandidateMatrix::identity();
    for (a, row_a) in rows.iter().enumerate() {
        let product = of_pose * row_a;
        for (b, row_b) in rows[..=a].iter().enumerate() {
            let own = if a == b { own_variance } else { 0.0 };
            covariance[(a, b)] = row_b.dot(&product) + own;
            covariance[(b, a)] = covariance[(a, b)];
        }
    }
    covariance
}

/// Divides residual rows and their Jacobian (`width` columns, row by row) by the Cholesky factor of
/// their covariance; returns the standard deviation of the first row.
pub(super) fn whiten(mut covariance: CandidateMatrix, residual: &mut [f64], jacobian: &mut [f64], width: usize) -> f64 {
    let len = residual.len();
    // Factorization and forward substitution in place, lower triangle only.
    for a in 0..len {
        for b in 0..=a {
            let dot: f64 = (0..b).map(|k| covariance[(a, k)] * covariance[(b, k)]).sum();
            let rest = covariance[(a, b)] - dot;
            covariance[(a, b)] = if a == b { rest.max(f64::MIN_POSITIVE).sqrt() } else { rest / covariance[(b, b)] };
        }
    }
    let sigma = covariance[(0, 0)];
    for a in 0..len {
        for b in 0..a {
            let factor = covariance[(a, b)];
            residual[a] -= factor * residual[b];
            let (before, after) = jacobian.split_at_mut(a * width);
            for (entry, earlier) in after[..width].iter_mut().zip(&before[b * width..(b + 1) * width]) {
                *entry -= factor * earlier;
            }
        }
        let scale = 1.0 / covariance[(a, a)];
        residual[a] *= scale;
        jacobian[a * width..(a + 1) * width].iter_mut().for_each(|entry| *entry *= scale);
    }
    sigma
}

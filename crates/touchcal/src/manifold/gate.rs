//! Which surfaces are near enough to be candidate contacts.

use nalgebra::{Matrix3, Matrix6, Vector3};

/// Number of directions with a gap bias of their own, see [`axis_direction`].
pub const AXIS_DIRECTIONS: usize = 6;

/// A gate: how near a surface must be at a noisy pose to be a candidate contact. It accepts gaps
/// `d` with `d − b < deviations · √(gᵀ covariance g + own_variance)`, where `g` is the
/// derivative of the gap by the pose, and `b` the gap bias of the surface's direction.
#[derive(Clone, Debug)]
pub struct Gate {
    /// Covariance of the pose's noise as a right twist `[v; ω]` in the tool's frame (blocks m², m
    /// rad, rad²).
    pub covariance: Matrix6<f64>,
    /// Variance (m², not negative) of the part of a gap's noise that is independent from surface to
    /// surface.
    pub own_variance: f64,
    /// Mean measured gap (m) at contact for each [`axis_direction`] of the surface's normal;
    /// negative if the parts press into each other.
    pub gap_biases: [f64; AXIS_DIRECTIONS],
    /// Width of the gate in standard deviations of the gap (no unit, positive).
    pub deviations: f64,
}

impl Gate {
    /// Whether a surface with this normal (in the fixture's frame) at a signed gap (m) is a
    /// candidate, where the pose's noise contributes `variance` (`gᵀ covariance g`, m², not
    /// negative) to the gap. NaN is not accepted.
    pub fn accepts(&self, gap: f64, normal_in_fixture: &Vector3<f64>, variance: f64) -> bool {
        gap - self.gap_biases[axis_direction(normal_in_fixture)]
            < self.deviations * (variance + self.own_variance).sqrt()
    }

    /// Distance (m, not negative) beyond which the gate accepts no surface that touches the tool
    /// within `radius` (m, not negative) of the tool's origin, whatever the direction of the
    /// surface.
    pub fn cutoff(&self, radius: f64) -> f64 {
        let size = |k: usize| largest_eigenvalue(&self.covariance.fixed_view::<3, 3>(k, k).into()).max(0.0).sqrt();
        let deviation = (size(0) + radius * size(3)).hypot(self.own_variance.sqrt());
        self.gap_biases.iter().copied().fold(0.0, f64::max) + self.deviations * deviation
    }
}

/// Which of the axes +x, −x, +y, −y, +z and −z (0 to 5) of its frame a `normal` is nearest to.
pub fn axis_direction(normal: &Vector3<f64>) -> usize {
    2 * normal.iamax() + usize::from(normal[normal.iamax()] < 0.0)
}

/// The largest eigenvalue of a symmetric matrix, in closed form: Smith, *Eigenvalues of a symmetric
/// 3×3 matrix* (1961).
fn largest_eigenvalue(matrix: &Matrix3<f64>) -> f64 {
    let mean = matrix.trace() / 3.0;
    let deviation = matrix - Matrix3::from_diagonal_element(mean);
    let size = (deviation.norm_squared() / 6.0).sqrt();
    if size == 0.0 {
        return mean;
    }
    let half_determinant = 0.5 * (deviation / size).determinant();
    mean + 2.0 * size * (half_determinant.clamp(-1.0, 1.0).acos() / 3.0).cos()
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64;

    use super::*;
    use crate::se3::twist;

    #[test]
    fn the_largest_eigenvalue_is_that_of_an_iterative_decomposition() {
        let mut chance = Pcg64::seed_from_u64(2);
        for k in 0..1000 {
            let mut columns = Matrix3::from_fn(|_, _| chance.random_range(-1.0..=1.0));
            // Of full rank, of rank two, and of rank one.
            (k % 3..3).skip(1).for_each(|column| columns.fill_column(column, 0.0));
            let covariance = columns * columns.transpose();
            let expected = covariance.symmetric_eigenvalues().max();
            assert!((largest_eigenvalue(&covariance) / expected - 1.0).abs() < 1e-12, "{covariance}");
        }
        assert_eq!(largest_eigenvalue(&Matrix3::zeros()), 0.0);
        assert!(largest_eigenvalue(&Matrix3::from_element(f64::NAN)).is_nan());
    }

    #[test]
    fn no_surface_beyond_the_cutoff_is_accepted() {
        let mut chance = Pcg64::seed_from_u64(1);
        let mut most: f64 = 0.0;
        for k in 0..20_000 {
            let mut each = |size: f64| size * chance.random_range(-1.0..=1.0);
            // Of one joint far away, or of several.
            let mut covariance = Matrix6::zeros();
            for _ in 0..1 + k % 4 {
                let joint = twist(&Vector3::from_fn(|_, _| each(30e-6)), &Vector3::from_fn(|_, _| each(50e-6)));
                covariance += joint * joint.transpose();
            }
            let gate =
                Gate { covariance, own_variance: 1e-12, gap_biases: [each(20e-6); AXIS_DIRECTIONS], deviations: 4.0 };
            let (normal, out) = (Vector3::from_fn(|_, _| each(1.0)), Vector3::from_fn(|_, _| each(1.0)));
            let (normal, point) = (normal.normalize(), out.normalize() * each(0.05).abs());
            let gradient = twist(&normal, &point.cross(&normal));
            let variance = gradient.dot(&(covariance * gradient));
            let cutoff = gate.cutoff(0.05);
            assert!(!gate.accepts(cutoff, &normal, variance));
            most = most.max(variance.sqrt() / cutoff);
        }
        // Nor is the cutoff much greater than it must be.
        assert!(most > 0.24, "{most}");
        let covariance = Matrix6::identity() * 1e-10;
        let alike = Gate { covariance, own_variance: 0.0, gap_biases: [0.0; AXIS_DIRECTIONS], deviations: 4.0 };
        assert!((alike.cutoff(0.0) - 40e-6).abs() < 1e-12);
    }

    #[test]
    fn each_direction_has_its_own_bias() {
        let mut gate = Gate {
            covariance: Matrix6::zeros(),
            own_variance: 1e-12,
            gap_biases: [0.0; AXIS_DIRECTIONS],
            deviations: 4.0,
        };
        (gate.gap_biases[1], gate.gap_biases[4]) = (10e-6, 30e-6);
        let (floor, wall) = (Vector3::new(0.1, 0.0, 0.9), Vector3::new(-0.9, 0.0, 0.1));
        assert!(gate.accepts(33e-6, &floor, 0.0) && !gate.accepts(35e-6, &floor, 0.0));
        assert!(gate.accepts(13e-6, &wall, 0.0) && !gate.accepts(15e-6, &wall, 0.0));
        assert!(gate.accepts(3e-6, &-wall, 0.0) && !gate.accepts(5e-6, &-wall, 0.0));
        assert!(gate.cutoff(0.0) >= 34e-6);
    }
}

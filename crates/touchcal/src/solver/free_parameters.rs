//! Which parameters are estimated, and in what units they are compared.

use nalgebra::{Cholesky, DMatrix, DVector};

/// Relative singular value below which a direction is left out of a pseudo-inverse: rounding.
const PSEUDO_INVERSE_ROUNDING: f64 = 1e-14;

/// The scale `sₖ` of every parameter, the size of a plausible value in its unit, and which
/// parameters are free. Fixed parameters keep their value.
///
/// Matrices are scaled before they are factored, `S M S` with `S = diag(s)`, so that metres and
/// radians are no further apart than the parameters' plausible sizes.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct FreeParameters {
    /// Zero for fixed parameters.
    scale: DVector<f64>,
}

impl FreeParameters {
    /// All parameters free but those of scale zero; `scale` has one entry for each, in its unit
    /// (SI).
    pub fn new(scale: DVector<f64>) -> Self {
        FreeParameters { scale }
    }

    /// These parameters and, behind them, free ones of scale one, `size` in all.
    pub fn extended(&self, size: usize) -> Self {
        FreeParameters { scale: self.scale.clone().resize_vertically(size, 1.0) }
    }

    /// Number of parameters, free and fixed.
    pub fn len(&self) -> usize {
        self.scale.len()
    }

    /// Whether parameter `k` is free: estimated.
    pub fn is_free(&self, k: usize) -> bool {
        self.scale[k] != 0.0
    }

    /// Fixes parameter `k` at its value.
    pub fn fix(&mut self, k: usize) {
        self.scale[k] = 0.0;
    }

    /// Replaces the scales (SI, one for each parameter) of the free parameters; fixed ones stay
    /// fixed.
    pub fn rescale(&mut self, scale: &DVector<f64>) {
        for (own, new) in self.scale.iter_mut().zip(scale.iter()) {
            if *own != 0.0 {
                *own = *new;
            }
        }
    }

    /// Indices of the free parameters, ascending.
    pub fn indices(&self) -> impl Iterator<Item = usize> {
        (0..self.len()).filter(|&k| self.is_free(k))
    }

    /// The scales (SI), zero for fixed parameters.
    pub fn scale(&self) -> &DVector<f64> {
        &self.scale
    }

    /// `S M S` of a square `matrix` M over all parameters; rows and columns of fixed parameters are
    /// zero.
    pub fn scaled(&self, matrix: &DMatrix<f64>) -> DMatrix<f64> {
        let s = &self.scale;
        DMatrix::from_fn(self.len(), self.len(), |i, j| s[i] * matrix[(i, j)] * s[j])
    }

    /// `S M S` with ones on the diagonal for fixed parameters, so that it can be factored.
    pub fn scaled_regular(&self, matrix: &DMatrix<f64>) -> DMatrix<f64> {
        let mut scaled = self.scaled(matrix);
        for k in (0..self.len()).filter(|&k| !self.is_free(k)) {
            scaled[(k, k)] = 1.0;
        }
        scaled
    }

    /// Inverse (SI) of an information matrix over the free parameters; rows and columns of fixed
    /// parameters are zero. Of a singular matrix the pseudo-inverse (in scaled units); zero if an
    /// entry is not finite.
    pub fn covariance(&self, information: &DMatrix<f64>) -> DMatrix<f64> {
        let size = self.len();
        let scaled = DMatrix::from_fn(size, size, |i, j| {
            if self.is_free(i) && self.is_free(j) {
                self.scale[i] * information[(i, j)] * self.scale[j]
            } else {
                f64::from(u8::from(i == j))
            }
        });
        let inverse = Cholesky::new(scaled.clone()).map(|cholesky| cholesky.inverse());
        // The decomposition does not terminate on NaN.
        let is_finite = scaled.iter().all(|entry| entry.is_finite());
        let pseudo_inverse = || is_finite.then(|| scaled.pseudo_inverse(PSEUDO_INVERSE_ROUNDING).ok()).flatten();
        let inverse = inverse.or_else(pseudo_inverse).unwrap_or_else(|| DMatrix::zeros(size, size));
        self.scaled(&inverse)
    }
}

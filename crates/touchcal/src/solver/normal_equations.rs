//! Normal equations, accumulated row by row.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use super::free_parameters::FreeParameters;

/// `H = Σ w JᵀJ`, `g = Σ w Jᵀr` and the cost `Σ ρ` of a set of whitened rows.
///
/// The information starts at zero: a prior is a row like any other.
#[derive(Clone, Debug)]
pub(crate) struct NormalEquations {
    /// `H`; the upper triangle while accumulating, symmetric after [`NormalEquations::complete`].
    pub information: DMatrix<f64>,
    /// `g`, half the gradient of the cost.
    pub gradient: DVector<f64>,
    /// `Σ ρ`.
    pub cost: f64,
    /// `Σ w ‖r‖²` of the contacts.
    pub squares: f64,
    /// `Σ w · rows` of the contacts.
    pub rows: f64,
}

impl NormalEquations {
    pub fn new(size: usize) -> Self {
        NormalEquations {
            information: DMatrix::zeros(size, size),
            gradient: DVector::zeros(size),
            cost: 0.0,
            squares: 0.0,
            rows: 0.0,
        }
    }

    /// Adds one row: `weight · (residual + Σ jacobian[k] δ[index[k]])²`, indices ascending. The
    /// caller adds the cost.
    pub fn add_row(&mut self, index: &[usize], jacobian: &[f64], residual: f64, weight: f64) {
        for (b, (&column, &right)) in index.iter().zip(jacobian).enumerate() {
            let weighted = weight * right;
            if weighted == 0.0 {
                continue;
            }
            self.gradient[column] += weighted * residual;
            let mut target = self.information.column_mut(column);
            for (&row, &left) in index[..=b].iter().zip(jacobian) {
                target[row] += weighted * left;
            }
        }
    }

    /// Adds the quadratic form `score · J δ + ½ δᵀ Jᵀ K J δ`, the rows of `J` one after the other,
    /// the curvature `K` symmetric. The caller adds the cost.
    pub fn add_form(
        &mut self,
        index: &[usize],
        jacobian: &[f64],
        score: impl Fn(usize) -> f64,
        curvature: impl Fn(usize, usize) -> f64,
    ) {
        let width = index.len();
        let count = jacobian.len() / width.max(1);
        for (b, &column) in index.iter().enumerate() {
            self.gradient[column] += (0..count).map(|r| score(r) * jacobian[r * width + b]).sum::<f64>();
            let mut target = self.information.column_mut(column);
            for r in 0..count {
                let right: f64 = (0..count).map(|s| curvature(r, s) * jacobian[s * width + b]).sum();
                for (&row, &left) in index[..=b].iter().zip(&jacobian[r * width..]) {
                    target[row] += right * left;
                }
            }
        }
    }

    /// Multiplies all sums by `factor`.
    pub fn scale(&mut self, factor: f64) {
        self.information *= factor;
        self.gradient *= factor;
        self.cost *= factor;
        self.squares *= factor;
        self.rows *= factor;
    }

    /// Adds another set of rows.
    pub fn add(&mut self, other: &NormalEquations) {
        self.information += &other.information;
        self.gradient += &other.gradient;
        self.cost += other.cost;
        self.squares += other.squares;
        self.rows += other.rows;
    }

    /// Fills the lower triangle.
    pub fn complete(mut self) -> Self {
        self.information.fill_lower_triangle_with_upper_triangle();
        self
    }

    /// The factored matrix of Newton steps, `S H S + λ I` over the free parameters. `None` where it
    /// is not positive definite in floating point.
    pub fn damped(&self, free: &FreeParameters, damping: f64) -> Option<DampedInformation> {
        let mut scaled = free.scaled(&self.information);
        for k in 0..scaled.nrows() {
            scaled[(k, k)] += if free.is_free(k) { damping } else { 1.0 };
        }
        Some(DampedInformation { factor: Cholesky::new(scaled)?, scale: free.scale().clone() })
    }
}

/// A damped information matrix, factored.
pub(crate) struct DampedInformation {
    factor: Cholesky<f64, Dyn>,
    scale: DVector<f64>,
}

impl DampedInformation {
    /// The step against gradient `g`; zero for fixed parameters.
    pub fn step(&self, gradient: &DVector<f64>) -> DVector<f64> {
        let right = -gradient.component_mul(&self.scale);
        self.factor.solve(&right).component_mul(&self.scale)
    }

    /// Newton decrement `gᵀ(H + λS⁻²)⁻¹g` of gradient `g`.
    pub fn decrement(&self, gradient: &DVector<f64>) -> f64 {
        -gradient.dot(&self.step(gradient))
    }
}

//! Normal equations, accumulated contact by contact.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

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

    /// Adds one row: `weight · (residual + Σ jacobian[k] δ[index[k]])²`, indices ascending. The cost is the caller's.
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

    /// Adds `slope · J δ + ½ δᵀ Jᵀ K J δ`, the rows of `J` one after the other, `K` symmetric. The cost is the caller's.
    pub fn add_form(
        &mut self,
        index: &[usize],
        jacobian: &[f64],
        slope: impl Fn(usize) -> f64,
        form: impl Fn(usize, usize) -> f64,
    ) {
        let width = index.len();
        let count = jacobian.len() / width.max(1);
        for (b, &column) in index.iter().enumerate() {
            self.gradient[column] += (0..count).map(|r| slope(r) * jacobian[r * width + b]).sum::<f64>();
            let mut target = self.information.column_mut(column);
            for r in 0..count {
                let pull: f64 = (0..count).map(|s| form(r, s) * jacobian[s * width + b]).sum();
                for (&row, &left) in index[..=b].iter().zip(&jacobian[r * width..]) {
                    target[row] += pull * left;
                }
            }
        }
    }

    /// Counts all rows `factor` times.
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

    /// The factored matrix of Newton steps, `S H S + λ I` with `S = diag(scale)`; parameters with scale 0 are held.
    /// `None` where it is not positive definite in floating point.
    pub fn damped(&self, scale: &DVector<f64>, damping: f64) -> Option<Damped> {
        let mut scaled = self.scaled_information(scale);
        for k in 0..scaled.nrows() {
            scaled[(k, k)] += if scale[k] == 0.0 { 1.0 } else { damping };
        }
        Some(Damped { factor: Cholesky::new(scaled)?, scale: scale.clone() })
    }

    /// `S H S`.
    pub fn scaled_information(&self, scale: &DVector<f64>) -> DMatrix<f64> {
        scaled(&self.information, scale)
    }
}

/// `S M S` with `S = diag(scale)`.
pub(crate) fn scaled(matrix: &DMatrix<f64>, scale: &DVector<f64>) -> DMatrix<f64> {
    DMatrix::from_fn(scale.len(), scale.len(), |i, j| scale[i] * matrix[(i, j)] * scale[j])
}

/// A damped information matrix, factored.
pub(crate) struct Damped {
    factor: Cholesky<f64, Dyn>,
    scale: DVector<f64>,
}

impl Damped {
    /// The step against gradient `g`.
    pub fn step(&self, gradient: &DVector<f64>) -> DVector<f64> {
        let right = -gradient.component_mul(&self.scale);
        self.factor.solve(&right).component_mul(&self.scale)
    }

    /// Newton decrement `gᵀ(H + λS⁻²)⁻¹g` of gradient `g`.
    pub fn decrement(&self, gradient: &DVector<f64>) -> f64 {
        -gradient.dot(&self.step(gradient))
    }
}

//! Normal equations, accumulated row by row.

use nalgebra::{Cholesky, DMatrix, DMatrixView, DVector, Dyn};

use super::free_parameters::FreeParameters;

/// `H = Σ w JᵀJ`, `g = Σ w Jᵀr` and the cost `Σ ρ` of a set of whitened rows.
///
/// The information starts at zero: a prior is a row like any other.
#[derive(Clone, Debug)]
pub(crate) struct NormalEquations {
    /// `H`, square, one row for each parameter (inverse SI units): the upper triangle while
    /// accumulating, symmetric after [`NormalEquations::complete`].
    pub information: DMatrix<f64>,
    /// `g`, half the gradient of the cost by the parameters (inverse SI units).
    pub gradient: DVector<f64>,
    /// `Σ ρ` (1).
    pub cost: f64,
    /// `Σ w ‖r‖²` of the contacts (1).
    pub squares: f64,
    /// `Σ w · rows` of the contacts: their weighted number of residual rows.
    pub rows: f64,
}

impl NormalEquations {
    /// Zero sums over `size` parameters.
    pub fn new(size: usize) -> Self {
        NormalEquations {
            information: DMatrix::zeros(size, size),
            gradient: DVector::zeros(size),
            cost: 0.0,
            squares: 0.0,
            rows: 0.0,
        }
    }

    /// Adds one row to information and gradient: to the cost as a quadratic form
    /// `weight · (residual + Σ jacobian[k] δ[index[k]])²` in a change δ of all parameters (SI),
    /// with whitened `residual` (1) and `weight` (1). `index` holds the parameters that the row
    /// depends on, ascending; `jacobian`, of equal length, its derivatives by them (inverse SI
    /// units). Cost, squares and rows stay as they are: the caller adds the row's share.
    pub fn add_row(&mut self, index: &[usize], jacobian: &[f64], residual: f64, weight: f64) {
        let entries = Entries::new(index);
        for (b, (&column, &right)) in index.iter().zip(jacobian).enumerate() {
            let weighted = weight * right;
            if weighted == 0.0 {
                continue;
            }
            self.gradient[column] += weighted * residual;
            entries.add_scaled(self.information.column_mut(column).as_mut_slice(), &jacobian[..=b], weighted);
        }
    }

    /// Adds `score · J δ + ½ δᵀ Jᵀ K J δ`, a quadratic form of half the cost in a change δ of all
    /// parameters (SI), to gradient and information. `jacobian` holds `J` row by row, a column for
    /// each parameter in `index` (ascending); `score(r)` is the entry of row `r`, `curvature(r, s)`
    /// that of the symmetric `K`. Cost, squares and rows stay as they are: the caller adds its
    /// share.
    pub fn add_form(
        &mut self,
        index: &[usize],
        jacobian: &[f64],
        score: impl Fn(usize) -> f64,
        curvature: impl Fn(usize, usize) -> f64,
    ) {
        let width = index.len();
        let count = jacobian.len() / width.max(1);
        let entries = Entries::new(index);
        for (b, &column) in index.iter().enumerate() {
            self.gradient[column] += (0..count).map(|r| score(r) * jacobian[r * width + b]).sum::<f64>();
            let mut target = self.information.column_mut(column);
            for r in 0..count {
                let right: f64 = (0..count).map(|s| curvature(r, s) * jacobian[s * width + b]).sum();
                entries.add_scaled(target.as_mut_slice(), &jacobian[r * width..=r * width + b], right);
            }
        }
    }

    /// Adds `Σ a bᵀ` over the rows `a` of `left` and `b` of `right`, a column for each parameter in
    /// `index` (ascending), to the information, if that sum is symmetric.
    pub fn add_outer_products(&mut self, index: &[usize], left: &[f64], right: &[f64]) {
        let width = index.len();
        let count = left.len() / width.max(1);
        let columns = |rows| DMatrixView::from_slice(rows, width, count);
        let products = columns(left) * columns(right).transpose();
        let entries = Entries::new(index);
        for (b, &column) in index.iter().enumerate() {
            let target = &mut self.information.column_mut(column);
            entries.add_scaled(target.as_mut_slice(), &products.column(b).as_slice()[..=b], 1.0);
        }
    }

    /// Multiplies all sums by `factor` (1).
    pub fn scale(&mut self, factor: f64) {
        self.information *= factor;
        self.gradient *= factor;
        self.cost *= factor;
        self.squares *= factor;
        self.rows *= factor;
    }

    /// Adds the sums of another set of rows over the same parameters.
    pub fn add(&mut self, other: &NormalEquations) {
        self.information += &other.information;
        self.gradient += &other.gradient;
        self.cost += other.cost;
        self.squares += other.squares;
        self.rows += other.rows;
    }

    /// The sums by the first `size` parameters alone, the others held fixed.
    pub fn of_first(&self, size: usize) -> Self {
        NormalEquations {
            information: self.information.view((0, 0), (size, size)).into_owned(),
            gradient: self.gradient.rows(0, size).into_owned(),
            ..*self
        }
    }

    /// Fills the lower triangle of the information from the upper one.
    pub fn complete(mut self) -> Self {
        self.information.fill_lower_triangle_with_upper_triangle();
        self
    }

    /// The factored matrix of Newton steps, `S H S + λ I` over the free parameters with scales `S`
    /// and `damping` λ (1). `None` where it is not positive definite in floating point.
    pub fn damped(&self, free: &FreeParameters, damping: f64) -> Option<DampedInformation> {
        let mut scaled = free.scaled(&self.information);
        for k in 0..scaled.nrows() {
            scaled[(k, k)] += if free.is_free(k) { damping } else { 1.0 };
        }
        Some(DampedInformation { factor: Cholesky::new(scaled)?, scale: free.scale().clone() })
    }
}

/// The parameters that rows depend on, as entries of a column over all parameters.
struct Entries<'i> {
    /// Ascending.
    index: &'i [usize],
    /// The number of the first of them that follow each other without a gap: mostly all.
    successive: usize,
}

impl<'i> Entries<'i> {
    fn new(index: &'i [usize]) -> Self {
        let first = index.first().copied().unwrap_or(0);
        Entries { index, successive: index.iter().zip(first..).take_while(|(k, next)| **k == *next).count() }
    }

    /// Adds `factor` times `values`, those of the first of the entries, to a `column`.
    fn add_scaled(&self, column: &mut [f64], values: &[f64], factor: f64) {
        let (head, tail) = values.split_at(self.successive.min(values.len()));
        let first = self.index.first().copied().unwrap_or(0);
        column[first..].iter_mut().zip(head).for_each(|(sum, value)| *sum += factor * value);
        for (&k, value) in self.index[head.len()..].iter().zip(tail) {
            column[k] += factor * value;
        }
    }
}

/// A damped information matrix `S H S + λ I`, factored.
pub(crate) struct DampedInformation {
    factor: Cholesky<f64, Dyn>,
    scale: DVector<f64>,
}

impl DampedInformation {
    /// The step (SI) against `gradient`, one entry for each parameter; zero for fixed ones.
    pub fn step(&self, gradient: &DVector<f64>) -> DVector<f64> {
        let right = -gradient.component_mul(&self.scale);
        self.factor.solve(&right).component_mul(&self.scale)
    }

    /// Newton decrement `gᵀ(H + λS⁻²)⁻¹g` (1) of gradient `g`.
    pub fn decrement(&self, gradient: &DVector<f64>) -> f64 {
        -gradient.dot(&self.step(gradient))
    }
}

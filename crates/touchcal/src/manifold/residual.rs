//! Residuals and candidate contacts, with their derivatives.

use crate::se3::Twist;

/// Largest number of rows of any manifold's residual, envelope or list of candidate contacts.
pub const MAX_ROWS: usize = 6;

/// Up to [`MAX_ROWS`] values with their derivatives, held in place so that the evaluation of a
/// contact allocates nothing: a residual (m), an envelope (no unit), or the gaps of candidate
/// contacts (m). Without rows by default.
///
/// `jacobian()[k]` is `∂values()[k]/∂ξ` for the right perturbation `fixture_from_tool · Exp(ξ)`,
/// ordered `[v; ω]`, in the tool's frame; what the facets of round parts would add is left out.
/// `surfaces()[k]` is the surface of a candidate contact, numbered region by region (see
/// [`SurfaceCounts`](super::contact_manifold::SurfaceCounts)), and 0 for other rows.
#[derive(Clone, Debug, PartialEq)]
pub struct Residual {
    len: usize,
    value: [f64; MAX_ROWS],
    jacobian: [Twist; MAX_ROWS],
    surface: [usize; MAX_ROWS],
}

impl Residual {
    /// A residual without rows.
    pub fn new() -> Self {
        Residual { len: 0, value: [0.0; MAX_ROWS], jacobian: [Twist::zeros(); MAX_ROWS], surface: [0; MAX_ROWS] }
    }

    /// Keeps the rows for which `keep(value, derivative)` is true, in their order, with their
    /// surfaces. `keep` is called once for each row, in order.
    pub fn retain(&mut self, mut keep: impl FnMut(f64, &Twist) -> bool) {
        let before = std::mem::take(&mut self.len);
        for k in 0..before {
            let (value, jacobian, surface) = (self.value[k], self.jacobian[k], self.surface[k]);
            if keep(value, &jacobian) {
                self.push_candidate(value, jacobian, surface);
            }
        }
    }

    /// Removes all rows, without deallocation.
    pub fn clear(&mut self) {
        self.len = 0;
    }

    /// Appends a row: a value (m, in an envelope without unit) and its derivative `[v; ω]` (unit of
    /// the value per m, per rad), of surface 0. More than [`MAX_ROWS`] rows are a mistake of the
    /// manifold: a debug build panics, a release build leaves the row out.
    pub fn push(&mut self, value: f64, jacobian: Twist) {
        self.push_candidate(value, jacobian, 0);
    }

    /// Appends a candidate contact: its signed gap (m), the gap's derivative `[v; ω]` (no unit;
    /// m/rad), and the number of its surface as in
    /// [`SurfaceCounts`](super::contact_manifold::SurfaceCounts); all candidates of a pose belong
    /// to one region. Beyond [`MAX_ROWS`] as [`push`](Self::push).
    pub fn push_candidate(&mut self, gap: f64, jacobian: Twist, surface: usize) {
        debug_assert!(self.len < MAX_ROWS, "a manifold pushed more than {MAX_ROWS} rows");
        if self.len < MAX_ROWS {
            self.value[self.len] = gap;
            self.jacobian[self.len] = jacobian;
            self.surface[self.len] = surface;
            self.len += 1;
        }
    }

    /// Number of rows, 0 to [`MAX_ROWS`].
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether there are no rows.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Values of the rows, [`len`](Self::len) of them: metres, except in an envelope, whose rows
    /// are divided by their scales.
    pub fn values(&self) -> &[f64] {
        &self.value[..self.len]
    }

    /// Derivatives of the rows, a twist `[v; ω]` in the tool's frame for each value: unit of the
    /// value per m, per rad.
    pub fn jacobian(&self) -> &[Twist] {
        &self.jacobian[..self.len]
    }

    /// Number of the surface of each candidate contact, one per row; 0 for rows of a residual or
    /// envelope.
    pub fn surfaces(&self) -> &[usize] {
        &self.surface[..self.len]
    }
}

impl Default for Residual {
    fn default() -> Self {
        Residual::new()
    }
}

//! What the data determine and what they do not.

/// A direction in parameter space that the data do not determine.
#[derive(Clone, Debug, PartialEq)]
pub struct NullDirection {
    /// The direction in words: "the offset of joint_a1 cannot be told from the yaw of fixture
    /// hole".
    pub description: String,
    /// Indices of the parameters that take part, and their components in units of their scale; the
    /// largest component is ±1.
    pub direction: Vec<(usize, f64)>,
}

/// Singular values of the whitened Jacobian in units of the parameters' scales (prior standard
/// deviation, or plausible size without a prior), and what follows from them.
///
/// A direction with a singular value below 1 is one along which the data add less than was known
/// before: it is called unidentifiable.
#[derive(Clone, Debug, PartialEq)]
pub struct Identifiability {
    /// Singular values, largest first (1).
    pub singular_values: Vec<f64>,
    /// Number of identifiable directions.
    pub rank: usize,
    /// Condition number: largest over smallest singular value of those directions; infinite without
    /// any.
    pub condition: f64,
    /// The other directions, in reduced echelon form.
    pub null_space: Vec<NullDirection>,
}

impl Identifiability {
    /// The observability indices O1 to O5 of the singular values of the identifiable directions,
    /// for a number of contacts; zeros without any such direction.
    ///
    /// Source: Sun & Hollerbach, *Observability index selection for robot calibration* (2008),
    /// section II.
    pub fn observability(&self, contacts: usize) -> [f64; 5] {
        let s = &self.singular_values[..self.rank];
        let (Some(&largest), Some(&smallest)) = (s.first(), s.last()) else {
            return [0.0; 5];
        };
        let count = s.len() as f64;
        let mean_log = s.iter().map(|v| v.ln()).sum::<f64>() / count;
        let inverse: f64 = s.iter().map(|v| 1.0 / v).sum();
        [
            mean_log.exp() / (contacts.max(1) as f64).sqrt(),
            smallest / largest,
            smallest,
            smallest * smallest / largest,
            1.0 / inverse,
        ]
    }
}

//! What the data determine and what they do not.

use serde::{Deserialize, Serialize};

use crate::parameter::ParameterId;

/// A direction in parameter space that the data do not determine: moving along it by one scale
/// changes no contact by more than its noise.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NullDirection {
    /// The direction in words: "the encoder offset of joint_a1 cannot be told from the rz of
    /// fixture hole".
    pub description: String,
    /// What would determine it besides other contacts, in words: "smaller standard deviations of
    /// the tool's place"; `None` where nothing that is declared takes part.
    pub remedy: Option<String>,
    /// Pairs (index into [`Estimate::parameters`](crate::estimate::Estimate::parameters),
    /// component) of the parameters that take part, the largest component first, those below a
    /// thousandth left out. Components are in units of the parameters' scales (prior standard
    /// deviation, or plausible size without a prior); the largest is ±1.
    pub direction: Vec<(usize, f64)>,
}

impl NullDirection {
    /// Least component that is named in [`NullDirection::description`].
    pub(crate) const MIN_NAMED: f64 = 0.05;

    /// Indices into [`Estimate::parameters`](crate::estimate::Estimate::parameters) of the
    /// parameters with components large enough to be named in the description, which may leave some
    /// out.
    pub fn named(&self) -> impl Iterator<Item = usize> {
        self.direction.iter().filter(|(_, component)| component.abs() >= Self::MIN_NAMED).map(|&(k, _)| k)
    }
}

/// Singular values of the whitened Jacobian in units of the parameters' scales (prior standard
/// deviation, or plausible size without a prior), and what follows from them.
///
/// A direction with a singular value below 1 is one along which the data add less than was known
/// before: it is called unidentifiable.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Identifiability {
    /// Singular values (1), largest first: one for each parameter that [counts](Self::counts).
    pub singular_values: Vec<f64>,
    /// Number of identifiable directions: of singular values that are at least
    /// [`min_singular_value`](crate::estimate::IdentifiabilityOptions::min_singular_value) and not
    /// rounding.
    pub rank: usize,
    /// Condition number: largest over smallest singular value of the identifiable directions (1);
    /// infinite if there are none.
    pub condition: f64,
    /// The other directions, in reduced echelon form: each has a parameter that takes part in no
    /// other one.
    pub null_space: Vec<NullDirection>,
}

impl Identifiability {
    /// What summaries say in place of directions after a gradient descent that failed: those of
    /// where it ended are none of the data alone.
    pub const UNKNOWN: &str = "not stated, since the gradient descent did not end at a minimum";

    /// Whether directions are of this parameter too: of all but directional gap biases, errors of
    /// the measured wrench, and trends and walks of encoder offsets, by which measurements and
    /// parts are off and which are no question to the contacts.
    pub fn counts(id: ParameterId) -> bool {
        let of_wrench = matches!(id, ParameterId::WrenchBias(_) | ParameterId::WrenchScale);
        let of_log = matches!(id, ParameterId::JointTrend(_) | ParameterId::JointWalk(..));
        !(of_wrench || of_log || matches!(id, ParameterId::DirectionalGapBias(..)))
    }

    /// The observability indices O1 to O5 of the `m = rank` identifiable directions with singular
    /// values `s₁ ≥ … ≥ sₘ`, for a number of contacts `n` (0 counts as 1); zeros if `m` is 0.
    ///
    /// In this order: `(s₁ ⋯ sₘ)^(1/m) / √n`, `sₘ / s₁`, `sₘ`, `sₘ² / s₁` and `1 / Σ (1/sₖ)`;
    /// larger is better.
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

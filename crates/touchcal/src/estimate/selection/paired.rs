//! Comparison of models by their errors on the same groups.

/// A mean over groups, with its standard error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GroupMean {
    /// Mean (m); infinite where a group has no finite value.
    pub mean: f64,
    /// Standard error (m) of the mean, by the scatter of the groups; 0 of fewer than two.
    pub standard_error: f64,
}

impl GroupMean {
    pub(super) fn of(values: &[f64]) -> GroupMean {
        let count = values.len().max(1) as f64;
        let mean = values.iter().sum::<f64>() / count;
        let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
        GroupMean { mean, standard_error: (squares / (count - 1.0).max(1.0) / count).sqrt() }
    }

    /// Of `errors` less `others`, group by group.
    pub(super) fn of_difference(errors: &[f64], others: &[f64]) -> GroupMean {
        let differences: Vec<f64> = errors.iter().zip(others).map(|(error, other)| error - other).collect();
        GroupMean::of(&differences)
    }

    /// Whether the mean is above zero by more than its standard error.
    pub fn is_positive(&self) -> bool {
        self.mean > self.standard_error
    }
}

//! Quantiles and means of samples, each quantile with the name of its definition, and probabilities
//! as text.

/// The `percent` % quantile of `n` samples by nearest rank: the sample of index
/// `⌈percent · n / 100⌉ − 1`, the first for 0 % (type 1 of Hyndman & Fan 1996). `None` if there are
/// no samples or `percent` is above 100.
///
/// `sorted` holds the samples in ascending order, which is not checked, in any unit; the result has
/// the same unit.
pub fn nearest_rank(sorted: &[f64], percent: usize) -> Option<f64> {
    sorted.get((sorted.len() * percent).div_ceil(100).saturating_sub(1)).copied()
}

/// The sample of index `⌊percent · n / 100⌋` of `n` samples: the smallest of which more than
/// `percent` % of all are no larger. `None` if there are no samples or `percent` is 100 or more.
///
/// `sorted` holds the samples in ascending order, which is not checked, in any unit; the result has
/// the same unit.
pub fn floor_rank(sorted: &[f64], percent: usize) -> Option<f64> {
    sorted.get(sorted.len() * percent / 100).copied()
}

/// The upper median of `values`, in their unit: of an even number of values the larger of the
/// middle two. `values` may be in any order. `None` if there are no values. NaN counts as larger
/// than all numbers, NaN of negative sign as smaller.
pub fn upper_median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_unstable_by(f64::total_cmp);
    floor_rank(&values, 50)
}

/// Arithmetic mean of `values`, in their unit; 0 if there are none, NaN if any is NaN.
pub fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

/// Probabilities below this are shown as less than it: they are rounding, or have underflowed.
const LEAST_P_VALUE: f64 = 1e-300;

/// A probability `p` (0 to 1) that something is chance, for a table: `3e-5`, or `< 1e-300`.
pub fn p_value_text(p: f64) -> String {
    if p < LEAST_P_VALUE { format!("< {LEAST_P_VALUE:e}") } else { format!("{p:.0e}") }
}

/// A probability `p` (0 to 1) that something is chance, for a sentence: `p = 3e-5`, or
/// `p < 1e-300`.
pub fn p_value_statement(p: f64) -> String {
    let text = p_value_text(p);
    if text.starts_with('<') { format!("p {text}") } else { format!("p = {text}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn p_values_that_underflow_have_a_bound() {
        assert_eq!([3.2e-5, 1.0, 0.0].map(p_value_text), ["3e-5", "1e0", "< 1e-300"]);
        assert_eq!([3.2e-5, 0.0].map(p_value_statement), ["p = 3e-5", "p < 1e-300"]);
    }

    #[test]
    fn ranks_of_few_numbers() {
        let sorted: Vec<f64> = (1..=20).map(f64::from).collect();
        assert_eq!((nearest_rank(&sorted, 95), floor_rank(&sorted, 95)), (Some(19.0), Some(20.0)));
        assert_eq!((nearest_rank(&sorted, 0), nearest_rank(&sorted, 100)), (Some(1.0), Some(20.0)));
        assert_eq!((upper_median(vec![3.0, 1.0]), upper_median(vec![3.0, 1.0, 2.0])), (Some(3.0), Some(2.0)));
        assert_eq!((nearest_rank(&[], 50), floor_rank(&[], 50), upper_median(Vec::new())), (None, None, None));
        assert_eq!((mean(&[1.0, 2.0]), mean(&[])), (1.5, 0.0));
    }
}

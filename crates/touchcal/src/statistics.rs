//! Quantiles and means of samples; each quantile bears the name of its definition.

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

#[cfg(test)]
mod tests {
    use super::*;

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

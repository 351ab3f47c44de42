//! Sums over the trials of a campaign.

use super::campaign::{CampaignRow, HALF_WIDTHS, LEVELS};

/// Coverage, NEES and errors over the trials of a campaign, summed trial by trial; the default is
/// empty. Means and quantiles are over the usable trials; without any they are NaN.
#[derive(Clone, Debug, PartialEq)]
pub struct CampaignSummary {
    /// Number of trials added.
    pub trials: u64,
    /// Number of trials whose estimate is usable or doubtful; everything else is over these.
    pub usable: u64,
    /// Number of the arm's parameters ([`CampaignRow::parameters`]), summed over the usable
    /// trials.
    pub parameters: u64,
    /// Number of true values within their intervals ([`CampaignRow::inside`]), for each of
    /// [`LEVELS`], over the usable trials.
    pub inside: [u64; 4],
    /// Sums of squares of how many more of a trial's true values are inside than should be.
    scatter: [f64; 4],
    /// Sums of the rows' values.
    nees: f64,
    nees_of_bound: f64,
    strain_bound: f64,
    offset_bound: f64,
    tool_distance: f64,
    tool_angle: f64,
    offset: Histogram,
    strain: Histogram,
    tool: Histogram,
}

impl Default for CampaignSummary {
    fn default() -> Self {
        CampaignSummary {
            trials: 0,
            usable: 0,
            parameters: 0,
            inside: [0; 4],
            scatter: [0.0; 4],
            nees: 0.0,
            nees_of_bound: 0.0,
            strain_bound: 0.0,
            offset_bound: 0.0,
            tool_distance: 0.0,
            tool_angle: 0.0,
            offset: Histogram::new(),
            strain: Histogram::new(),
            tool: Histogram::new(),
        }
    }
}

/// Standard deviations of 99 % bounds.
const BOUND: f64 = HALF_WIDTHS[3];

impl CampaignSummary {
    /// Adds a trial. One that is not usable ([`CampaignRow::status`] 2) counts in
    /// [`CampaignSummary::trials`] only. The order of trials changes rounding only.
    pub fn add(&mut self, row: &CampaignRow) {
        self.trials += 1;
        if row.status > 1 {
            return;
        }
        self.usable += 1;
        self.parameters += row.parameters;
        for (k, inside) in row.inside.into_iter().enumerate() {
            self.inside[k] += inside;
            self.scatter[k] += (inside as f64 - LEVELS[k] * row.parameters as f64).powi(2);
        }
        self.nees += row.nees;
        self.nees_of_bound += row.nees_of_bound;
        self.strain_bound += row.strain_bound;
        self.offset_bound += row.offset_bound;
        self.tool_distance += row.tool_distance;
        self.tool_angle += row.tool_angle;
        self.offset.add(row.offset_error);
        self.strain.add(row.strain_error);
        self.tool.add(row.tool_distance);
    }

    /// Share (0 to 1) of true values within their intervals, for each of [`LEVELS`]; NaN without
    /// parameters.
    pub fn coverage(&self) -> [f64; 4] {
        self.inside.map(|inside| inside as f64 / self.parameters as f64)
    }

    /// Bounds `[least, greatest]` within which each share of [`CampaignSummary::coverage`] lies
    /// with a probability of 99 % if uncertainties are right, for each of [`LEVELS`]; NaN without
    /// parameters. A trial's parameters err together, so the bounds are as wide as the trials
    /// scatter, and at least as wide as if each parameter erred by itself (binomial); the greatest
    /// is at most 1.
    pub fn coverage_bounds(&self) -> [[f64; 2]; 4] {
        let count = self.parameters as f64;
        std::array::from_fn(|k| {
            let binomial = count * LEVELS[k] * (1.0 - LEVELS[k]);
            let chance = BOUND * self.scatter[k].max(binomial).sqrt() / count;
            [LEVELS[k] - chance, (LEVELS[k] + chance).min(1.0)]
        })
    }

    /// Mean NEES ([`CampaignRow::nees`]) over the number of parameters (1 if uncertainties are
    /// right), and the bounds `[least, greatest]` within which it then lies with a probability of
    /// 99 % (χ², normal approximation). NaN without parameters, or if a trial's NEES is.
    pub fn nees(&self) -> (f64, [f64; 2]) {
        let chance = BOUND * (2.0 / self.parameters as f64).sqrt();
        (self.nees / self.parameters as f64, [1.0 - chance, 1.0 + chance])
    }

    /// Root mean square error in standard deviations of the Cramér–Rao bound (1), by
    /// [`CampaignRow::nees_of_bound`]: 1 for an efficient estimator. NaN without parameters, or if
    /// a trial's value is.
    pub fn error_over_bound(&self) -> f64 {
        (self.nees_of_bound / self.parameters as f64).sqrt()
    }

    /// Means over the trials of [`CampaignRow::tool_distance`] (m) and [`CampaignRow::tool_angle`]
    /// (rad), in this order.
    pub fn tool(&self) -> (f64, f64) {
        (self.tool_distance / self.usable as f64, self.tool_angle / self.usable as f64)
    }

    /// Quantile `share` (above 0, up to 1) of the trials' [`CampaignRow::offset_error`] (rad, or m
    /// for prismatic joints), by nearest rank. Accurate to 1 % from 1e-12 to 1e3; 0 for a smaller
    /// value and for a `share` of 0, NaN for a `share` above 1.
    pub fn offset_error(&self, share: f64) -> f64 {
        self.offset.quantile(share)
    }

    /// Quantile `share` of the trials' [`CampaignRow::strain_error`] (1), with the range and
    /// accuracy of [`CampaignSummary::offset_error`].
    pub fn strain_error(&self, share: f64) -> f64 {
        self.strain.quantile(share)
    }

    /// Quantile `share` of the trials' [`CampaignRow::tool_distance`] (m), with the range and
    /// accuracy of [`CampaignSummary::offset_error`].
    pub fn tool_distance(&self, share: f64) -> f64 {
        self.tool.quantile(share)
    }

    /// Mean over the trials of [`CampaignRow::offset_bound`] (rad, or m for prismatic joints).
    pub fn offset_bound(&self) -> f64 {
        self.offset_bound / self.usable as f64
    }

    /// Mean over the trials of [`CampaignRow::strain_bound`] (1).
    pub fn strain_bound(&self) -> f64 {
        self.strain_bound / self.usable as f64
    }
}

/// Positive numbers counted in bins of 1 %, so that quantiles of a million need no more memory than
/// those of a thousand.
#[derive(Clone, Debug, PartialEq)]
struct Histogram {
    counts: Vec<u64>,
    total: u64,
}

/// Numbers from 1e-12 to 1e3.
const LEAST: f64 = 1e-12;
const BINS_PER_DECADE: f64 = 230.0;
const BINS: usize = 15 * 230;

impl Histogram {
    fn new() -> Self {
        Histogram { counts: vec![0; BINS], total: 0 }
    }

    fn add(&mut self, value: f64) {
        let bin = ((value / LEAST).log10() * BINS_PER_DECADE).max(0.0) as usize;
        self.counts[bin.min(BINS - 1)] += 1;
        self.total += 1;
    }

    fn quantile(&self, share: f64) -> f64 {
        let mut left = (share * self.total as f64).ceil() as u64;
        for (bin, count) in self.counts.iter().enumerate() {
            if left <= *count && self.total > 0 {
                return if bin == 0 { 0.0 } else { LEAST * 10f64.powf((bin as f64 + 0.5) / BINS_PER_DECADE) };
            }
            left -= *count;
        }
        f64::NAN
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64;

    use super::*;

    #[test]
    fn quantiles_are_those_of_sorted_numbers() {
        let mut histogram = Histogram::new();
        (1..=1000).for_each(|k| histogram.add(1e-6 * f64::from(k)));
        for (share, expected) in [(0.5, 500e-6), (0.95, 950e-6), (1.0, 1e-3)] {
            assert!(
                (histogram.quantile(share) / expected - 1.0).abs() < 0.01,
                "{share}: {}",
                histogram.quantile(share)
            );
        }
    }

    #[test]
    fn only_usable_trials_are_averaged() {
        let good =
            CampaignRow { parameters: 8, inside: [4, 7, 8, 8], nees: 8.0, nees_of_bound: 32.0, ..Default::default() };
        let mut summary = CampaignSummary::default();
        summary.add(&good);
        summary.add(&CampaignRow { status: 2, nees: 1e9, ..good });
        assert_eq!((summary.trials, summary.usable), (2, 1));
        assert_eq!(summary.coverage(), [0.5, 0.875, 1.0, 1.0]);
        assert_eq!(summary.coverage_bounds()[3][1], 1.0);
        assert!((summary.nees().0 - 1.0).abs() < 1e-12 && (summary.error_over_bound() - 2.0).abs() < 1e-12);
    }
    /// Bounds that are broken once in a hundred campaigns, be a trial's parameters independent or
    /// all the same.
    #[test]
    fn chance_breaks_bounds_of_coverage_once_in_a_hundred() {
        let mut random = Pcg64::seed_from_u64(1);
        let mut broken = |together: bool| {
            let campaign = |random: &mut Pcg64| {
                let mut summary = CampaignSummary::default();
                for _ in 0..200 {
                    let one = random.random_bool(LEVELS[1]);
                    let inside = (0..8).filter(|_| if together { one } else { random.random_bool(LEVELS[1]) }).count();
                    summary.add(&CampaignRow { parameters: 8, inside: [0, inside as u64, 0, 0], ..Default::default() });
                }
                let [least, most] = summary.coverage_bounds()[1];
                !(least..=most).contains(&summary.coverage()[1])
            };
            (0..2000).filter(|_| campaign(&mut random)).count()
        };
        for (together, count) in [(false, broken(false)), (true, broken(true))] {
            assert!((5..=60).contains(&count), "together {together}: {count} of 2000");
        }
    }
}

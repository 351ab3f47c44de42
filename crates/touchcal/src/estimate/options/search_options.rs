//! How minima are searched.

use serde::{Deserialize, Serialize};

use crate::solver::LevenbergMarquardtOptions;

/// Settings of the coarse-to-fine search.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SearchOptions {
    /// Maximum number (> 0) of searches from zero, each fixing the parameters that the one before
    /// found unobservable.
    pub max_restarts: usize,
    /// Number of contacts that the coarse stage and annealing use, about evenly spread over the
    /// log; 0 panics.
    pub fit_subsample: usize,
    /// Factor between the numbers of contacts of successive stages, from `fit_subsample` to all; at
    /// least 2 (with 1 the search does not end, 0 panics).
    pub subsample_growth: usize,
    /// Number (> 0) of independent measurements of the middle of an envelope
    /// ([`ContactManifold::envelope`](crate::manifold::ContactManifold::envelope)) that all
    /// contacts together count as in the coarse stage, however many they are: each has this number
    /// over that of the contacts as its weight, more than 1 where there are fewer. Priors keep
    /// theirs. Deviations from the middle are motion of the tool, not noise: counted as independent
    /// measurements they make parameters of little effect explain them (with a free hole, strains
    /// of −0.4).
    pub coarse_effective_contacts: f64,
    /// Factor (> 1; else the search does not end) by which the scale of the robust loss, or the
    /// noise of one-sided contacts, shrinks from step to step (graduated non-convexity: Yang,
    /// Antonante, Tzoumas & Carlone, *Graduated non-convexity for robust spatial perception*
    /// (2020); deterministic annealing: Ueda & Nakano, *Deterministic annealing EM algorithm*
    /// (1998)).
    pub annealing_factor: f64,
    /// Share (0 to below 1) of the contacts that lie within the scale of the first, widest cost;
    /// with 1 it is not widened.
    pub annealing_inliers: f64,
    /// Stopping rule of the coarse stage: of a subsample's distances from manifolds' envelopes.
    pub coarse: LevenbergMarquardtOptions,
    /// Stopping rule of the intermediate steps of annealing and subsamples. Its decrement is
    /// multiplied by the number of contacts for which one of the subsample stands.
    pub anneal: LevenbergMarquardtOptions,
    /// Stopping rule of annealing with one-sided contacts; its decrement is multiplied likewise.
    pub anneal_contact_modes: LevenbergMarquardtOptions,
    /// Stopping rule of the last stage, with all contacts, and after the variance components.
    pub fine: LevenbergMarquardtOptions,
    /// Stopping rule of the last step with the marginal likelihood of all contacts. As candidates
    /// enter and leave the gate the cost jumps by more than a step of some standard deviations
    /// gains, so steps are judged by the gradient from farther off. Its decrement is by the
    /// observed information (Louis 1982), where that is positive definite.
    pub fine_contact_modes: LevenbergMarquardtOptions,
    /// Prior standard deviation (m, > 0) of a fixture's gap bias: parts neither float nor penetrate
    /// by much more.
    pub gap_bias_sigma: f64,
}

impl Default for SearchOptions {
    fn default() -> Self {
        let fine = LevenbergMarquardtOptions { max_iterations: 60, decrement: 1e-2, gradient_test_below: 0.03 };
        let contact_modes = LevenbergMarquardtOptions { gradient_test_below: 0.1, ..fine };
        SearchOptions {
            max_restarts: 3,
            fit_subsample: 250,
            subsample_growth: 12,
            coarse_effective_contacts: 10.0,
            annealing_factor: 2.0,
            annealing_inliers: 0.9,
            coarse: LevenbergMarquardtOptions { max_iterations: 100, decrement: 1e-3, ..fine },
            anneal: LevenbergMarquardtOptions { decrement: 1e-1, ..fine },
            anneal_contact_modes: LevenbergMarquardtOptions { max_iterations: 15, decrement: 1e-1, ..contact_modes },
            fine,
            fine_contact_modes: contact_modes,
            gap_bias_sigma: 0.1e-3,
        }
    }
}

/// Settings of the search for competing minima, which is made for one-sided contacts with declared
/// noise.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct MultiStartOptions {
    /// Root mean square of the whitened least gaps (1) at their minimum, weighted by the loss, from
    /// which other starts are tried. At the right minimum it is below 1, since soft minima scatter
    /// less than single gaps.
    pub min_scatter: f64,
    /// Numbers of other starts, drawn from the posterior of the coarse stage with fixed seeds: at
    /// least `[0]`; up to `[1]` while contacts scatter too much at the best minimum, and only one
    /// search ended there. Two searches are made from each, and one from the end of that stage.
    pub starts: [u64; 2],
    /// Number of iterations of the whole calibration after which there are no more than `starts[0]`
    /// starts: a bound on work where minima are many and none is right.
    pub max_iterations_of_more: usize,
    /// Deviations (1) of a parameter from zero after the coarse stage, over its scale (prior
    /// standard deviation, or plausible size without a prior). Beyond `[0]` no more than
    /// `starts[0]` starts are tried: most likely a declaration is grossly wrong, and with it every
    /// minimum. Beyond `[1]`, if contacts scatter too much, none is tried, and the result has the
    /// warning `ContradictedDeclarations`; for that, parameters that have no prior and are not of
    /// the arm (tool, fixtures, gaps, wrench, changes of encoders) do not count.
    pub max_deviations: [f64; 2],
    /// Squared Mahalanobis distance (1) between two minima above which they count as different.
    pub min_squared_distance: f64,
    /// Ratio of another minimum's cost to the least one (1) below which it competes.
    pub max_cost_ratio: f64,
}

impl Default for MultiStartOptions {
    fn default() -> Self {
        MultiStartOptions {
            min_scatter: 0.9,
            starts: [4, 12],
            max_iterations_of_more: 3000,
            max_deviations: [2.5, 5.0],
            min_squared_distance: 100.0,
            max_cost_ratio: 1.25,
        }
    }
}

//! Tuning of the estimator. The defaults are what every figure of VALIDATION.md was measured with.

use crate::solver::LevenbergMarquardtOptions;

/// All tuning of the estimator.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EstimatorOptions {
    /// The search for the minimum.
    pub search: SearchOptions,
    /// The likelihood of one-sided contacts.
    pub contact_mode: ContactModeOptions,
    /// Variance components: prior widths and noise estimated from the data.
    pub variance_components: VarianceComponentOptions,
    /// The search for competing minima.
    pub multi_start: MultiStartOptions,
    /// What counts as determined by the data.
    pub identifiability: IdentifiabilityOptions,
    /// When a result deserves a warning, and when it must not be used.
    pub thresholds: WarningThresholds,
}

/// The coarse-to-fine search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SearchOptions {
    /// Maximum number of searches from the start, each fixing the parameters that the one before
    /// found unobservable.
    pub max_restarts: usize,
    /// Number of contacts that the coarse stage and graduated non-convexity use, about evenly
    /// spread.
    pub fit_subsample: usize,
    /// Factor between the numbers of contacts of successive stages, from `fit_subsample` to all.
    pub subsample_growth: usize,
    /// Number of independent measurements of the envelope's middle that all contacts together count
    /// as in the coarse stage. Deviations from the middle are motion of the tool, not noise:
    /// counted as independent measurements they make parameters of little effect explain them (with
    /// a free hole, strains of −0.4).
    pub coarse_effective_contacts: f64,
    /// Factor by which the scale of the robust loss shrinks from step to step (graduated
    /// non-convexity: Yang, Antonante, Tzoumas & Carlone, *Graduated non-convexity for robust
    /// spatial perception* (2020)).
    pub gnc_factor: f64,
    /// Share of the contacts that lie within the scale of the first, widest loss.
    pub gnc_initial_inliers: f64,
    /// Coarse stage: towards the manifolds' envelopes.
    pub coarse: LevenbergMarquardtOptions,
    /// Intermediate steps of graduated non-convexity and subsamples.
    pub anneal: LevenbergMarquardtOptions,
    /// Last step with all contacts.
    pub fine: LevenbergMarquardtOptions,
    /// Last step with the marginal likelihood of all contacts. Candidate contacts enter and leave
    /// the gate: the cost jumps by more than a step of some standard deviations gains, so the
    /// gradient judges steps from farther off.
    pub fine_contact_modes: LevenbergMarquardtOptions,
    /// Prior standard deviation (m) of a fixture's gap bias: parts neither float nor penetrate by
    /// much more.
    pub gap_bias_sigma: f64,
}

impl Default for SearchOptions {
    fn default() -> Self {
        let fine = LevenbergMarquardtOptions { max_iterations: 60, decrement: 1e-2, gradient_test_below: 0.03 };
        SearchOptions {
            max_restarts: 3,
            fit_subsample: 250,
            subsample_growth: 12,
            coarse_effective_contacts: 10.0,
            gnc_factor: 2.0,
            gnc_initial_inliers: 0.9,
            coarse: LevenbergMarquardtOptions { max_iterations: 100, decrement: 1e-3, ..fine },
            anneal: LevenbergMarquardtOptions { decrement: 1e-1, ..fine },
            fine,
            fine_contact_modes: LevenbergMarquardtOptions { gradient_test_below: 0.1, ..fine },
            gap_bias_sigma: 0.1e-3,
        }
    }
}

/// The marginal likelihood of one-sided contacts and its parameters, estimated by
/// expectation–maximisation. Distances in standard deviations of their noise unless said otherwise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactModeOptions {
    /// Distance up to which a candidate contact is considered. Farther ones must not count: how
    /// often a surface is free is to be known near zero, and a tool does not approach all of a
    /// surface's surroundings equally often.
    pub gate: f64,
    /// Distance from which candidates leave the gate smoothly.
    pub gate_fade: f64,
    /// Squared Mahalanobis distance above which an active set is left out.
    pub max_squared_distance: f64,
    /// Share of the likelihood below which an active set is left out.
    pub min_share: f64,
    /// Initial contact odds `κ` of every surface (m): probability of contact over the density of
    /// free distances.
    pub initial_odds: f64,
    /// Initial odds `η` that a contact touches nothing (1).
    pub initial_no_contact: f64,
    /// Numbers of contacts that the expectation step uses, first and last. From 500 the odds are so
    /// rough that they cost a third of the accuracy.
    pub em_subsample: [usize; 2],
    /// Maximum number of iterations for each subsample.
    pub em_max_iterations: usize,
    /// Mean relative change of the odds that ends the iterations with the last subsample: from
    /// other starts, results then differ by some hundredths of a standard deviation.
    pub em_tolerance: f64,
    /// Initial noise over the declared one. The search starts where the least gaps lead, where a
    /// surface that carries many contacts may be some standard deviations away; with the declared
    /// noise its odds would be estimated as zero.
    pub em_initial_inflation: f64,
    /// Newton decrement below which the parameters' step of an iteration is taken without a line
    /// search: one standard deviation.
    pub em_step_decrement: f64,
    /// Share of the one-sided contacts that must be informative, i.e. touch something with more
    /// probability than nothing. Below it the least gap of each contact is used instead.
    pub min_informative_fraction: f64,
    /// Number of candidate contacts that the mean odds of a region count as, for each of its
    /// surfaces.
    pub odds_strength: f64,
    /// Number of active contacts that the declared noise counts as.
    pub noise_strength: f64,
    /// Start of the standard deviation (m) of directional gap biases, a variance component.
    pub directional_bias_sigma: f64,
    /// Number of observed biases that this start counts as: little, because the estimate must go to
    /// zero for good parts.
    pub directional_bias_strength: f64,
    /// Factor on the standard deviations where least gaps are used: the ratio of errors to standard
    /// deviations of simulated pegs at the rim and in holes with little clearance.
    pub least_gap_inflation: f64,
}

impl Default for ContactModeOptions {
    fn default() -> Self {
        ContactModeOptions {
            gate: 4.0,
            gate_fade: 2.0,
            max_squared_distance: 60.0,
            min_share: 1e-9,
            initial_odds: 1e-4,
            initial_no_contact: 1e-4,
            em_subsample: [750, 3000],
            em_max_iterations: 10,
            em_tolerance: 0.04,
            em_initial_inflation: 3.0,
            em_step_decrement: 1.0,
            min_informative_fraction: 0.3,
            odds_strength: 5.0,
            noise_strength: 100.0,
            directional_bias_sigma: 1e-6,
            directional_bias_strength: 0.01,
            least_gap_inflation: 3.0,
        }
    }
}

/// Empirical Bayes for prior widths and noise, see
/// [`Prior::VarianceComponent`](crate::parameter::Prior).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VarianceComponentOptions {
    /// Maximum number of linearizations; between them the problem counts as linear.
    pub max_linearizations: usize,
    /// Maximum number of expectation–maximisation steps on one linearization.
    pub max_em_steps: usize,
    /// Relative change of all standard deviations that ends the steps: far less than their own
    /// uncertainty.
    pub tolerance: f64,
}

impl Default for VarianceComponentOptions {
    fn default() -> Self {
        VarianceComponentOptions { max_linearizations: 5, max_em_steps: 12, tolerance: 3e-3 }
    }
}

/// The search for competing minima.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MultiStartOptions {
    /// Scatter of whitened least gaps (root mean square) from which other starts are tried. At the
    /// right minimum it is below 1, since soft minima scatter less than single gaps.
    pub min_scatter: f64,
    /// Number of starts, drawn from the posterior of the coarse stage.
    pub starts: u64,
    /// Squared Mahalanobis distance from which two minima are different ones.
    pub min_squared_distance: f64,
    /// Ratio of costs up to which another minimum competes: where minima abound, the deepest need
    /// not be the right one.
    pub max_cost_ratio: f64,
}

impl Default for MultiStartOptions {
    fn default() -> Self {
        MultiStartOptions { min_scatter: 0.9, starts: 4, min_squared_distance: 100.0, max_cost_ratio: 4.0 }
    }
}

/// What counts as determined by the data. Singular values are of the whitened Jacobian in units of
/// the parameters' scales (prior standard deviation, or plausible size without a prior).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IdentifiabilityOptions {
    /// A direction is identifiable from this singular value on: the data add as much as was known.
    pub min_singular_value: f64,
    /// With the priors counted in, a direction below this value is bounded by nothing: a prior
    /// alone gives about 1.
    pub min_bounded_singular_value: f64,
    /// Share of a direction in parameters with a prior from which they bound it: the rest is then
    /// at most ten times plausible.
    pub min_bounding_share: f64,
    /// A parameter is identifiable if the data bring its standard deviation below this share of its
    /// scale.
    pub max_sigma_ratio: f64,
}

impl Default for IdentifiabilityOptions {
    fn default() -> Self {
        IdentifiabilityOptions {
            min_singular_value: 1.0,
            min_bounded_singular_value: 0.7,
            min_bounding_share: 0.1,
            max_sigma_ratio: 0.5,
        }
    }
}

/// When a result deserves a warning, and when it must not be used.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WarningThresholds {
    /// Robust weight below which a contact counts as rejected.
    pub rejected_weight: f64,
    /// Share of rejected contacts: warning, not usable. Above the second most contacts contradict
    /// the result.
    pub rejected_share: [f64; 2],
    /// Measured over declared noise: warning; not usable with one-sided contacts. So much scatter
    /// is no noise, but another shape or place.
    pub noise_factor: [f64; 2],
    /// Design effect: warning (standard deviations are doubled), not usable. Errors common to so
    /// many contacts bias the result, by how much no contact can tell.
    pub design_effect: [f64; 2],
    /// Range of a joint's positions (rad or m) below which its parameters resemble its neighbours'.
    pub joint_range: f64,
    /// Share of the arm's prior uncertainty that the data must remove for the result to be usable,
    /// as what they may leave.
    pub arm_uncertainty: f64,
    /// Number of plausible sizes beyond which a parameter of the arm is no calibration: strains of
    /// 25 %, offsets of 25°.
    pub implausible_scales: f64,
    /// Number of prior standard deviations: warning; for a gap bias not usable, since parts in
    /// contact touch: half a millimetre off is another place or part.
    pub prior_deviations: f64,
    /// Share of a declared distance by which the nominal arm may contradict it (or by its own
    /// scatter, if that is more).
    pub distance_contradiction: f64,
}

impl Default for WarningThresholds {
    fn default() -> Self {
        WarningThresholds {
            rejected_weight: 0.05,
            rejected_share: [0.2, 0.5],
            noise_factor: [1.5, 3.0],
            design_effect: [4.0, 9.0],
            joint_range: 0.035,
            arm_uncertainty: 0.5,
            implausible_scales: 5.0,
            prior_deviations: 4.0,
            distance_contradiction: 0.5,
        }
    }
}

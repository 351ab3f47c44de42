//! Tuning of the estimator. VALIDATION.md has the figures of the defaults, and names the revision
//! of those that were measured before.

use serde::{Deserialize, Serialize};

mod method;
mod search_options;

pub use method::{GradientDescent, Method, Optimizer};
pub use search_options::{MultiStartOptions, SearchOptions};

/// All settings of the estimator; `Default` holds the recommended values.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct EstimatorOptions {
    /// Settings of the search for the minimum.
    pub search: SearchOptions,
    /// Settings of the likelihood of one-sided contacts.
    pub contact_mode: ContactModeOptions,
    /// Settings of the estimation of variance components: prior widths and noise.
    pub variance_components: VarianceComponentOptions,
    /// Settings of the search for competing minima.
    pub multi_start: MultiStartOptions,
    /// Thresholds on singular values and standard deviations for what counts as determined by the
    /// data.
    pub identifiability: IdentifiabilityOptions,
    /// Thresholds of warnings.
    pub thresholds: WarningThresholds,
    /// Settings of the search for declarations that are wrong in kind.
    pub declaration_check: DeclarationCheckOptions,
    /// What is done about errors of the arm that are not estimated and that contacts cannot see.
    pub unseen_effects: UnseenEffects,
}

/// What is done about errors of the arm that the model leaves out (joint compliance, segment
/// strains, joint origins, encoder harmonics and random walks), in directions in which contacts
/// would not show them at a plausible size.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum UnseenEffects {
    /// They have a Gaussian prior of their plausible size and widen the covariance by what they
    /// change the estimates, wherever effects are tested; not where the places of the tool and of
    /// all fixtures are exact.
    #[default]
    Widen,
    /// The covariance does not allow for them.
    Ignore,
}

/// Settings of the marginal likelihood of one-sided contacts; its odds, noise and bias widths are
/// estimated by expectation–maximisation (Dempster, Laird & Rubin 1977).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ContactModeOptions {
    /// Distance (> 0), in standard deviations of its noise, up to which a candidate contact is
    /// considered. Farther ones must not count: the density of free distances is wanted near zero,
    /// and a tool does not approach all of a surface's surroundings equally often.
    pub gate: f64,
    /// Distance (0 to `gate`), in standard deviations of its noise, from which a candidate's
    /// likelihood fades out; it ends at `gate`.
    pub gate_fade: f64,
    /// Squared Mahalanobis distance (1, > 0) of its active candidates from contact from which an
    /// active set is left out.
    pub max_squared_distance: f64,
    /// Share (0 to 1) of a contact's likelihood, as summed over active sets so far, below which an
    /// active set is left out.
    pub min_share: f64,
    /// Initial contact odds `κ` of every surface (m, > 0): probability of contact over the density
    /// (1/m) of free distances.
    pub initial_odds: f64,
    /// Initial odds `η` (1, > 0) that a contact touches nothing.
    pub initial_no_contact: f64,
    /// Numbers of contacts that the expectation step uses: in the first iterations `[0]`, and in
    /// the last `[1]`; 0 panics. With 500 contacts the odds are so rough that they cost a third of
    /// the accuracy.
    pub em_subsample: [usize; 2],
    /// Maximum number of iterations of expectation–maximisation for each of the two subsamples.
    pub em_max_iterations: usize,
    /// Mean relative change of the odds (1), or that of the noise if it is larger, below which the
    /// iterations with the last subsample end: from other starts, results then differ by some
    /// hundredths of a standard deviation. For the first subsample it is larger by the ratio of
    /// their sizes.
    pub em_tolerance: f64,
    /// Ratio of the initial standard deviation of the noise to the declared one (1, > 0). The
    /// search starts where the least gaps lead, where a surface that carries many contacts may be
    /// some standard deviations away; with the declared noise its odds would be estimated as zero.
    pub em_initial_inflation: f64,
    /// Root mean square change (1) of the active candidates' distances, over their noise, up to
    /// which a step is taken without a line search; a line search ends at such a step, too.
    pub em_step_length: f64,
    /// Shares (0 to 1) of one-sided contacts that must be informative: the sum of the probabilities
    /// that they touch something, over the number of all, and over that of those whose surfaces can
    /// be distinguished. At or below either the least gap of each contact is used instead.
    pub min_informative_share: [f64; 2],
    /// Weight (> 0) of the mean odds of a fixture in the odds of each of its surfaces, as a number
    /// of active candidate contacts.
    pub odds_strength: f64,
    /// Weight (> 0) of the declared noise in the estimated one, as a number of active contacts.
    pub noise_strength: f64,
    /// Initial standard deviation (m, > 0) of directional gap biases, a variance component.
    pub directional_bias_sigma: f64,
    /// Weight (≥ 0) of `directional_bias_sigma` in the estimate of that standard deviation, as a
    /// number of observed biases: little, because the estimate must go to zero for good parts.
    pub directional_bias_strength: f64,
    /// Factor (1) on the parameters' standard deviations where least gaps are used, or where the
    /// likelihood has no covariance: the ratio of errors to standard deviations of simulated pegs
    /// at the rim and in holes with little clearance.
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
            em_step_length: 0.1,
            min_informative_share: [0.05, 0.5],
            odds_strength: 5.0,
            noise_strength: 100.0,
            directional_bias_sigma: 1e-6,
            directional_bias_strength: 0.01,
            least_gap_inflation: 3.0,
        }
    }
}

/// Settings of the empirical Bayes estimation of prior widths and noise (expectation–maximisation:
/// Dempster, Laird & Rubin 1977), see
/// [`Prior::VarianceComponent`](crate::parameter::Prior::VarianceComponent) and
/// [`Noise::is_estimated`](super::Noise::is_estimated).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct VarianceComponentOptions {
    /// Maximum number of linearizations of the problem; between them it is treated as linear. With
    /// 0 nothing is estimated.
    pub max_linearizations: usize,
    /// Maximum number of expectation–maximisation steps on one linearization.
    pub max_em_steps: usize,
    /// Largest relative change of any standard deviation in one step (1) below which the steps end,
    /// and the linearizations where it is the first step: far less than the standard deviations'
    /// own uncertainty.
    pub tolerance: f64,
}

impl Default for VarianceComponentOptions {
    fn default() -> Self {
        VarianceComponentOptions { max_linearizations: 5, max_em_steps: 12, tolerance: 3e-3 }
    }
}

/// Thresholds for what counts as determined by the data. Singular values (1) are of the whitened
/// Jacobian with each column multiplied by its parameter's scale (prior standard deviation, or
/// plausible size without a prior).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct IdentifiabilityOptions {
    /// Singular value from which a direction is identifiable; at 1 the data contribute as much
    /// information as was known before.
    pub min_singular_value: f64,
    /// Singular value of data and priors together below which a direction is not bounded: a prior
    /// alone gives about 1.
    pub min_bounded_singular_value: f64,
    /// Share (0 to 1) of a direction's norm in parameters with a prior above which they bound it:
    /// the rest is then at most ten times a plausible size.
    pub min_bounding_share: f64,
    /// Standard deviation that the data leave of a prior as wide as the scale, over the scale (0 to
    /// 1), below which a parameter is identifiable.
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

/// Thresholds from which a result gets a warning, and from which it must not be used.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct WarningThresholds {
    /// Robust weight (0 to 1) below which a contact counts as rejected.
    pub rejected_weight: f64,
    /// Shares (0 to 1) of rejected contacts above which there is a warning `[0]` and the result is
    /// not usable `[1]` ≥ `[0]`: most contacts then contradict it. Where the others scatter more
    /// than declared (`noise_factor[0]`) it is not usable above `[0]` already.
    pub rejected_share: [f64; 2],
    /// Ratios (1) of measured to declared noise, see
    /// [`Estimate::noise_factor`](super::Estimate::noise_factor), above which there is a warning
    /// `[0]` and, with one-sided contacts of declared noise, the result is not usable `[1]`: so
    /// much scatter is no noise, but another shape or place.
    pub noise_factor: [f64; 2],
    /// Design effects (1) above which there is a warning `[0]` (standard deviations are doubled at
    /// 4) and from which the result is not usable `[1]`: errors common to so many contacts bias it
    /// by an amount that contacts do not determine, unless tests show above all a random walk of
    /// encoders. It is not usable above `[0]` already where one-sided contacts scatter more than at
    /// a right minimum ([`MultiStartOptions::min_scatter`]), stretches of the log do not contradict
    /// each other, and standard deviations do not allow for effects that the model leaves out.
    pub design_effect: [f64; 2],
    /// Range of a joint's positions (rad, or m for a prismatic joint) below which its parameters
    /// resemble those of its neighbours and there is a warning.
    pub joint_range: f64,
    /// Ratio of the uncertainty of distances between tool positions after to before the calibration
    /// (0 to 1) above which the result is not usable.
    pub arm_uncertainty: f64,
    /// Absolute value of an arm's parameter, in its plausible size
    /// ([`Parameter::scale`](crate::parameter::Parameter::scale)), above which the result is not
    /// usable; at 5, strains of 25 % and offsets of 25°.
    pub implausible_scales: f64,
    /// Absolute values of a parameter or a declared distance, in prior standard deviations, above
    /// which there is a warning `[0]` and the result is not usable `[1]`: for the latter in those
    /// of the estimated parameter where these are larger, since what is not estimated, such as worn
    /// edges, moves it. For a gap bias it is not usable from the first on, since parts in contact
    /// touch: half a millimetre off is another place or part. A directional gap bias counts in the
    /// largest of its prior's, its own and the shape's standard deviation.
    pub prior_deviations: [f64; 2],
    /// Share (> 0) of the declared contact noise that counts as standard deviation of a gap bias
    /// where the clearance is exact: contacts are not harder than that.
    pub exact_gap_share: f64,
    /// Number of one-sided contacts below which there is a warning. Of simulated cells with unequal
    /// clearances (preset `workcell`, seeds 0 to 399), 8 of the 355 usable results from 60
    /// contacts, 9 of 391 from 100, 1 of 400 from 200 and none of 400 from 300 have an encoder
    /// offset more than 3.9 standard deviations off; the largest are 11.0, 4.8, 4.2 and 3.3.
    pub one_sided_contacts: usize,
    /// Share (0 to 1) of one-sided contacts that are informative, up to which a result from least
    /// gaps is not usable.
    pub informative_fraction: f64,
    /// Common strains of all lengths of the arm, in prior standard deviations, above which there is
    /// a warning `[0]` and the result is not usable `[1]`.
    pub common_scale: [f64; 2],
    /// Corrected p-value (0 to 1) of an effect that the model leaves out, below which there is a
    /// warning; the result is then not usable if the effect moves the tool out of its reported 95 %
    /// region. Small, since contacts never follow a likelihood exactly: of sixteen true problems
    /// with logs of another simulator (MuJoCo), two had effects at 1e-4.
    pub effect_p_value: f64,
    /// Corrected p-value (0 to 1) below which a test of something left out or declared is listed
    /// among what contacts say against the problem, without other consequences.
    pub listed_p_value: f64,
    /// Probability (0 to 1) of the predictive check
    /// ([`PredictiveCheck`](super::PredictiveCheck)) below which there is a
    /// warning.
    pub prediction_p_value: f64,
    /// Ratio (1) of the predictive check from which the result is not usable where it is
    /// significant; where contacts have no likelihood with a minimum, any that is
    /// significant.
    pub prediction_ratio: f64,
    /// Share (≥ 0) of the declared distance between two sockets by which the nominal arm may
    /// contradict it; where the contacts with both scatter by more (sum of root mean squares, m),
    /// that scatter is allowed.
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
            prior_deviations: [4.0, 5.0],
            exact_gap_share: 0.1,
            one_sided_contacts: 300,
            informative_fraction: 0.03,
            common_scale: [3.6, 5.0],
            effect_p_value: 1e-5,
            listed_p_value: 1e-3,
            prediction_p_value: 1e-3,
            prediction_ratio: 3.0,
            distance_contradiction: 0.5,
        }
    }
}

/// Settings of the search for declarations that are wrong in kind, see
/// [`Warning::MistakenDeclaration`](super::Warning::MistakenDeclaration).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct DeclarationCheckOptions {
    /// Maximum number (> 0; 0 panics) of contacts that declarations are compared on, about evenly
    /// spread over the log.
    pub contacts: usize,
    /// Maximum number of linearizations for each other declaration. The right one takes six to ten.
    pub max_iterations: usize,
    /// Root mean square of the envelopes' rows (1, in their own scale, half a millimetre or a
    /// degree) up to which contacts agree with the declarations. A peg that moves in a hole of 1 mm
    /// clearance has 1.6.
    pub max_envelope: f64,
    /// Deviation (1) of each parameter and distance from what is declared, in prior standard
    /// deviations or plausible sizes, up to which contacts agree with the declarations.
    pub max_deviations: f64,
    /// Difference (1) by which the cost with a mistake exceeds that without it: twice the logarithm
    /// of a likelihood ratio.
    pub min_cost_difference: f64,
    /// Ratio (1) by which it exceeds that.
    pub min_cost_ratio: f64,
}

impl Default for DeclarationCheckOptions {
    fn default() -> Self {
        DeclarationCheckOptions {
            contacts: 100,
            max_iterations: 15,
            max_envelope: 2.0,
            max_deviations: 4.0,
            min_cost_difference: 40.0,
            min_cost_ratio: 2.0,
        }
    }
}

//! Noise, priors and what is estimated.

use serde::Deserialize;
use toml::Spanned;

use super::value::{Number, Text};

/// What linear changes of encoder offsets follow.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum TrendOverToml {
    Log,
    Temperature,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct NoiseToml {
    /// Standard deviation of the noise of each joint position (of a prismatic joint: the same angle
    /// at a metre). Without it: 0.005, from which it is estimated unless `contact_mm` is declared.
    /// Example: `encoder_deg = 0.002`
    pub(crate) encoder_deg: Option<Number>,
    /// Standard deviation of the gap at contact. Without it: 0.05, from which it is estimated
    /// unless `encoder_deg` is declared.
    /// Example: `contact_mm = 0.02`
    pub(crate) contact_mm: Option<Number>,
    /// Standard deviation of half the change of each encoder's offset from the first to the last
    /// contact. Without it: estimated where encoder offsets or joint origins are, without
    /// `joint_drift`.
    /// Example: `encoder_trend_deg = 0`
    pub(crate) encoder_trend_deg: Option<Number>,
    /// What that change follows. Without it: log.
    /// Example: `encoder_trend_over = "temperature"`
    pub(crate) encoder_trend_over: Option<Spanned<TrendOverToml>>,
    /// Standard deviation of each encoder's random walk from the first to the last contact; above 0
    /// `joint_walk` is estimated. Without it: tested, not estimated; 0.02 if `joint_walk` is among
    /// the parameters.
    /// Example: `encoder_walk_deg = 0.01`
    pub(crate) encoder_walk_deg: Option<Number>,
    /// Whether the noise of encoders and contacts is estimated too, from the declared values on.
    /// Without it: true unless one of them is declared.
    /// Example: `estimated = true`
    pub(crate) estimated: Option<bool>,
    /// Standard deviation of the bias of each component of the force. Without it: 0.5.
    /// Example: `force_bias_n = 0.2`
    pub(crate) force_bias_n: Option<Number>,
    /// Standard deviation of the bias of each component of the torque. Without it: 0.05.
    /// Example: `torque_bias_nm = 0.02`
    pub(crate) torque_bias_nm: Option<Number>,
    /// Standard deviation of the noise of each component of the force in each row. Without it: 0.1.
    /// Example: `force_noise_n = 0.05`
    pub(crate) force_noise_n: Option<Number>,
    /// Standard deviation of the noise of each component of the torque in each row. Without it:
    /// 0.005.
    /// Example: `torque_noise_nm = 0.002`
    pub(crate) torque_noise_nm: Option<Number>,
    /// Standard deviation of the relative error of the wrench's scale. Without it: 0.02.
    /// Example: `wrench_scale = 0.01`
    pub(crate) wrench_scale: Option<Number>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct PriorToml {
    /// Standard deviation of the prior of `strain`. Without it: no prior.
    /// Example: `strain = 0.001`
    pub(crate) strain: Option<Number>,
    /// Of each `segment_strain`. Without it: no prior.
    /// Example: `segment_strain = 0.001`
    pub(crate) segment_strain: Option<Number>,
    /// Of the `joint_offset` of each turning joint. Without it: no prior.
    /// Example: `joint_offset_deg = 0.5`
    pub(crate) joint_offset_deg: Option<Number>,
    /// Of the `joint_offset` of each prismatic joint. Without it: no prior.
    /// Example: `joint_offset_mm = 0.5`
    pub(crate) joint_offset_mm: Option<Number>,
    /// Of each translation of a `joint_origin`. Without it: 0.5.
    /// Example: `joint_origin_mm = 1`
    pub(crate) joint_origin_mm: Option<Number>,
    /// Of each rotation of a `joint_origin`. Without it: 0.1; about the joint's axis estimated.
    /// Example: `joint_origin_deg = 0.2`
    pub(crate) joint_origin_deg: Option<Number>,
    /// Of each `joint_compliance`. Without it: estimated.
    /// Example: `joint_compliance_rad_per_nm = 1e-5`
    pub(crate) joint_compliance_rad_per_nm: Option<Number>,
    /// Of the `joint_backlash` of each turning joint. Without it: 0.01.
    /// Example: `joint_backlash_deg = 0.05`
    pub(crate) joint_backlash_deg: Option<Number>,
    /// Of the `joint_backlash` of each prismatic joint. Without it: the usual 0.01.
    /// Example: `joint_backlash_mm = 0.05`
    pub(crate) joint_backlash_mm: Option<Number>,
    /// Of each amplitude of a `joint_harmonic`. Without it: 0.05.
    /// Example: `joint_harmonic_deg = 0.02`
    pub(crate) joint_harmonic_deg: Option<Number>,
    /// Of each amplitude of a `joint_harmonic_2`. Without it: 0.02.
    /// Example: `joint_harmonic_2_deg = 0.01`
    pub(crate) joint_harmonic_2_deg: Option<Number>,
    /// Of each `joint_gear_ratio`. Without it: 0.0001.
    /// Example: `joint_gear_ratio = 1e-3`
    pub(crate) joint_gear_ratio: Option<Number>,
}

#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum LossToml {
    Squared,
    Huber,
    Cauchy,
    // Spelt out: the derived name would split "McClure".
    #[default]
    #[serde(rename = "geman_mcclure")]
    GemanMcClure,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum OptimiserToml {
    Adam,
    Plain,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct DescentToml {
    /// Rule of the step. Without it: adam.
    /// Example: `optimiser = "plain"`
    pub(crate) optimiser: Option<OptimiserToml>,
    /// Number of steps. Without it: 5000.
    /// Example: `steps = 10000`
    pub(crate) steps: Option<Number>,
    /// Size of the first step, in plausible sizes of the parameters. Without it: 0.05.
    /// Example: `rate = 0.001`
    pub(crate) rate: Option<Number>,
    /// Largest number of contacts that are used, evenly spread over the log and the same in all
    /// steps. Without it: 500.
    /// Example: `contacts = 3000`
    pub(crate) contacts: Option<Number>,
}

/// What is done about errors of the arm that are not estimated and that contacts cannot see.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub(crate) enum UnseenEffectsToml {
    #[default]
    Widen,
    Ignore,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct EstimateToml {
    /// Blocks of parameters to estimate. One of: `strain`, `segment_strain`, `joint_offset`,
    /// `joint_origin`, `joint_compliance`, `joint_backlash`, `joint_drift`, `joint_trend`,
    /// `joint_walk`, `joint_harmonic`, `joint_harmonic_2`, `joint_gear_ratio`, `tool`, `fixture`.
    /// Example: `parameters = ["strain", "joint_offset"]`
    pub(crate) parameters: Vec<Text>,
    /// Robust loss of a contact. Without it: geman_mcclure.
    /// Example: `loss = "huber"`
    #[serde(default)]
    pub(crate) loss: LossToml,
    /// Scale of the loss in standard deviations, at least 0.1; `squared` has none. Without it: 3
    /// (geman_mcclure), 2.385 (cauchy), 1.345 (huber).
    /// Example: `loss_scale = 4`
    pub(crate) loss_scale: Option<Number>,
    /// Names of parameters of the arm that stay at zero; `joint_origin.joint_a1` names all that
    /// begin so. Without it: none.
    /// Example: `freeze = ["joint_offset.joint_a7"]`
    #[serde(default)]
    pub(crate) freeze: Vec<Text>,
    /// Standard deviations of Gaussian priors about zero.
    /// Example: `prior = { strain = 0.001 }`
    #[serde(default)]
    pub(crate) prior: PriorToml,
    /// How the estimate is found; gradient descent minimizes the mean absolute distances of
    /// contacts. One of: `levenberg_marquardt`, `gradient_descent`. Without it:
    /// levenberg_marquardt.
    /// Example: `method = "gradient_descent"`
    pub(crate) method: Option<Text>,
    /// Whether intervals allow for errors of the arm that are not estimated and that contacts would
    /// not show. Without it: widen.
    /// Example: `unseen_effects = "ignore"`
    #[serde(default)]
    pub(crate) unseen_effects: UnseenEffectsToml,
    /// Settings of `gradient_descent`.
    /// Example: `descent = { steps = 10000 }`
    pub(crate) descent: Option<Spanned<DescentToml>>,
}

//! How often the surfaces of a region are touched.

use crate::estimate::options::ContactModeOptions;

/// Prior of the contact mode in one region of a manifold, estimated from the contacts.
///
/// The odds `κⱼ` (m) of surface `j` are the probability that it is touched over the density (1/m)
/// of its distance where it is free. A tool that is held leans to one side, so each surface has
/// odds of its own.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ContactModePrior {
    /// Odds `κⱼ` (m) of each surface of the region.
    pub odds: Vec<f64>,
    /// Odds `η` (1) that a contact touches nothing.
    pub no_contact: f64,
    /// Share (0 to 1) of each surface's candidates within the gate that are active.
    pub active_share: Vec<f64>,
    /// Number of candidates of each surface that were counted besides those of contacts.
    pub pseudo_candidates: f64,
}

impl ContactModePrior {
    /// The prior before any contact is evaluated, for a region of so many `surfaces`: the odds of
    /// `options` for each.
    pub fn initial(surfaces: usize, options: &ContactModeOptions) -> Self {
        ContactModePrior {
            odds: vec![options.initial_odds; surfaces],
            no_contact: options.initial_no_contact,
            active_share: vec![0.5; surfaces],
            pseudo_candidates: 2.0 * options.odds_strength,
        }
    }

    /// The prior for a noise `factor` times as large: with odds (m) in the same ratio to the noise,
    /// a contact counts as touching nothing from the same number of standard deviations on.
    pub fn with_noise(&self, factor: f64) -> Self {
        ContactModePrior { odds: self.odds.iter().map(|odds| factor * odds).collect(), ..self.clone() }
    }
}

//! Expected counts of contact modes in one region: the sufficient statistics of the odds.

use super::likelihood::MarginalLikelihood;
use super::prior::ContactModePrior;
use crate::estimate::options::ContactModeOptions;

/// Fixed-point iterations for the probabilities that surfaces are touched.
const FIXED_POINT_ITERATIONS: usize = 20;
/// Bounds of the odds `κ` (m): from a surface that is never touched to one that is never free.
const MIN_ODDS: f64 = 1e-8;
const MAX_ODDS: f64 = 1.0;
/// Largest probability that a surface is touched.
const MAX_PROBABILITY: f64 = 0.99;

/// Expected counts of the contacts in one region.
#[derive(Clone, Debug)]
pub(crate) struct ContactCounts {
    /// Contacts that touch something.
    in_contact: f64,
    /// Contacts with candidates within the gate that touch nothing.
    no_contact: f64,
    /// Candidates of each surface within the gate.
    candidates: Vec<f64>,
    /// Active candidates of each surface.
    active: Vec<f64>,
}

impl ContactCounts {
    /// Zero counts for a region of so many `surfaces`.
    pub fn new(surfaces: usize) -> Self {
        ContactCounts { in_contact: 0.0, no_contact: 0.0, candidates: vec![0.0; surfaces], active: vec![0.0; surfaces] }
    }

    /// Adds the responsibilities of one contact; `surfaces` is the surface of each of its
    /// candidates, an index within the region.
    pub fn add_contact(&mut self, likelihood: &MarginalLikelihood, surfaces: impl ExactSizeIterator<Item = usize>) {
        self.in_contact += likelihood.in_contact;
        self.no_contact += if surfaces.len() > 0 { 1.0 - likelihood.in_contact } else { 0.0 };
        for (k, surface) in surfaces.enumerate() {
            self.candidates[surface] += 1.0;
            self.active[surface] += likelihood.active[k];
        }
    }

    /// Adds the counts of other contacts in the same region.
    pub fn add(&mut self, other: &ContactCounts) {
        self.in_contact += other.in_contact;
        self.no_contact += other.no_contact;
        self.candidates.iter_mut().zip(&other.candidates).for_each(|(sum, more)| *sum += *more);
        self.active.iter_mut().zip(&other.active).for_each(|(sum, more)| *sum += *more);
    }

    /// Multiplies all counts by `factor`.
    pub fn scale(&mut self, factor: f64) {
        self.in_contact *= factor;
        self.no_contact *= factor;
        self.candidates.iter_mut().chain(&mut self.active).for_each(|count| *count *= factor);
    }

    /// Expected numbers of contacts that touch something, and of contacts with candidates that
    /// touch nothing.
    pub fn contacts(&self) -> (f64, f64) {
        (self.in_contact, self.no_contact)
    }

    /// Number of candidates within the gate, over all surfaces.
    pub fn candidates(&self) -> f64 {
        self.candidates.iter().sum()
    }

    /// Expected number of active candidates of each surface.
    pub fn active(&self) -> &[f64] {
        &self.active
    }

    /// Pseudo-counts of each surface's active and inactive candidates, in the ratio of the region.
    fn pseudo_counts(&self, strength: f64) -> (f64, f64) {
        let (candidates, active): (f64, f64) = (self.candidates(), self.active.iter().sum());
        (strength, strength * (candidates - active).max(1.0) / active.max(1.0))
    }

    /// The maximisation step: the prior with the greatest expected likelihood.
    ///
    /// Candidates within the gate have a mean range of `gate` (m); for each contact that touches
    /// something there are `no_contact` that touch nothing. That number is of the whole fixture: a
    /// region of its own with few contacts, or with surfaces that are not quite what they are taken
    /// for, would lose itself to touching nothing.
    ///
    /// With surfaces touched independently of each other with probabilities `q`, contacts are the
    /// poses that touch at least one, a share `z` of all. A free surface is seen only where another
    /// one is touched, or nothing is.
    fn maximize(&self, gate: f64, no_contact: f64, options: &ContactModeOptions) -> ContactModePrior {
        if self.in_contact < 1.0 {
            return ContactModePrior::initial(self.candidates.len(), options);
        }
        let contacts = self.in_contact;
        let (mut q, mut z) = (Vec::new(), 1.0);
        for _ in 0..FIXED_POINT_ITERATIONS {
            q = self.active.iter().map(|active| (z * active / contacts).min(MAX_PROBABILITY)).collect();
            z = 1.0 - q.iter().map(|q: &f64| 1.0 - q).product::<f64>();
        }
        let (more, free) = self.pseudo_counts(options.odds_strength);
        let of_surface = |((candidates, active), q): ((&f64, &f64), &f64)| {
            let seen = 1.0 - (1.0 - z) / (1.0 - q) + z * no_contact;
            (seen * gate * (active + more) / ((candidates - active).max(0.0) + free)).clamp(MIN_ODDS, MAX_ODDS)
        };
        let odds = self.candidates.iter().zip(&self.active).zip(&q).map(of_surface).collect();
        let share = |(candidates, active): (&f64, &f64)| (active + more) / (candidates.max(*active) + more + free);
        let active_share = self.candidates.iter().zip(&self.active).map(share).collect();
        ContactModePrior { odds, no_contact: no_contact * z / (1.0 - z), active_share }
    }

    /// The maximisation step, over-relaxed: odds move twice as far as from the `before` ones to the
    /// maximum, because steps of expectation–maximisation are short. Odds of surfaces without
    /// candidates are those of the maximum.
    pub fn m_step(
        &self,
        before: &ContactModePrior,
        gate: f64,
        no_contact: f64,
        options: &ContactModeOptions,
    ) -> ContactModePrior {
        let mut prior = self.maximize(gate, no_contact, options);
        for ((odds, before), candidates) in prior.odds.iter_mut().zip(&before.odds).zip(&self.candidates) {
            if *candidates > 0.0 {
                *odds = (*odds * *odds / before).clamp(MIN_ODDS, MAX_ODDS);
            }
        }
        prior
    }

    /// Complete-data information of each surface's `ln κⱼ`: of the contacts if their active sets
    /// were known, and of the pseudo-counts.
    pub fn complete_information(
        &self,
        prior: &ContactModePrior,
        options: &ContactModeOptions,
    ) -> impl Iterator<Item = (f64, f64)> {
        let (more, free) = self.pseudo_counts(options.odds_strength);
        self.candidates.iter().zip(&prior.active_share).map(move |(candidates, share)| {
            let of_candidate = share * (1.0 - share);
            (of_candidate * candidates, of_candidate * (more + free))
        })
    }
}

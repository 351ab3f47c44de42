//! Expected counts of contact modes in one region: the sufficient statistics of the odds.

use super::likelihood::MarginalLikelihood;
use super::prior::ContactModePrior;

/// Fixed-point iterations for the probabilities that surfaces are touched.
const FIXED_POINT_ITERATIONS: usize = 20;
/// Bounds of the odds `κ` (m): from a surface that is never touched to one that is never free.
const MIN_ODDS: f64 = 1e-8;
const MAX_ODDS: f64 = 1.0;
/// Largest probability that a surface is touched.
const MAX_PROBABILITY: f64 = 0.99;
/// Power of the ratio of the odds at the maximum to the odds before, by which odds move on beyond
/// the maximum. Steps of expectation–maximisation are short; with 1 odds that one step determines
/// would alternate about the maximum.
const OVER_RELAXATION: f64 = 0.5;

/// Least number of free candidates of a surface that are counted besides those of contacts, as by
/// the prior of Jeffreys, *An invariant form for the prior probability in estimation problems*
/// (1946), of a probability. Where no candidate was ever free, it is uncertain that none will be.
const LEAST_FREE: f64 = 0.5;

/// What each region of a fixture counts besides its own contacts: as many candidates for each
/// surface, active and free in the ratio of all regions of the fixture. A region with few contacts
/// then has the odds of the others.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PseudoCounts {
    /// Contacts that touch something.
    in_contact: f64,
    /// Candidates of each surface that are active, and that are free.
    active: f64,
    free: f64,
}

impl PseudoCounts {
    /// Of the counts of all `regions` of a fixture; as many candidates of each surface as hold
    /// `strength` active ones.
    pub fn new(regions: &[ContactCounts], strength: f64) -> Self {
        let surfaces = regions.first().map_or(0, |region| region.active.len());
        let sum = |of: fn(&ContactCounts) -> &[f64]| regions.iter().flat_map(of).sum::<f64>();
        let active = sum(|region| &region.active).max(1.0);
        let free = (sum(|region| &region.candidates) - active).max(1.0);
        let in_contact = regions.iter().map(|region| region.in_contact).sum::<f64>();
        PseudoCounts {
            in_contact: strength * surfaces as f64 * in_contact / active,
            active: strength,
            free: (strength * free / active).max(LEAST_FREE),
        }
    }
}

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

    /// Adds the responsibilities of one contact; `surfaces` is the index of each candidate's odds
    /// within the region.
    pub fn add_contact(&mut self, likelihood: &MarginalLikelihood, surfaces: &[usize]) {
        self.in_contact += likelihood.in_contact;
        self.no_contact += if surfaces.is_empty() { 0.0 } else { 1.0 - likelihood.in_contact };
        for (k, &surface) in surfaces.iter().enumerate() {
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
    fn maximize(&self, gate: f64, no_contact: f64, more: &PseudoCounts) -> ContactModePrior {
        let contacts = self.in_contact + more.in_contact;
        let counts = || self.candidates.iter().zip(&self.active);
        let (mut q, mut z) = (Vec::new(), 1.0);
        for _ in 0..FIXED_POINT_ITERATIONS {
            let touched = |active: &f64| (z * (active + more.active) / contacts).min(MAX_PROBABILITY);
            q = self.active.iter().map(touched).collect();
            z = 1.0 - q.iter().map(|q: &f64| 1.0 - q).product::<f64>();
        }
        let of_surface = |((candidates, active), q): ((&f64, &f64), &f64)| {
            let seen = 1.0 - (1.0 - z) / (1.0 - q) + z * no_contact;
            let free = (candidates - active).max(0.0) + more.free;
            (seen * gate * (active + more.active) / free).clamp(MIN_ODDS, MAX_ODDS)
        };
        let odds = counts().zip(&q).map(of_surface).collect();
        let pseudo_candidates = more.active + more.free;
        let share =
            |(candidates, active): (&f64, &f64)| (active + more.active) / (candidates.max(*active) + pseudo_candidates);
        let active_share = counts().map(share).collect();
        ContactModePrior { odds, no_contact: no_contact * z / (1.0 - z), active_share, pseudo_candidates }
    }

    /// The maximisation step, over-relaxed. Odds of surfaces without candidates are those of the
    /// maximum.
    pub fn m_step(
        &self,
        before: &ContactModePrior,
        gate: f64,
        no_contact: f64,
        more: &PseudoCounts,
    ) -> ContactModePrior {
        let mut prior = self.maximize(gate, no_contact, more);
        for ((odds, before), candidates) in prior.odds.iter_mut().zip(&before.odds).zip(&self.candidates) {
            if *candidates > 0.0 {
                *odds = (*odds * (*odds / before).powf(OVER_RELAXATION)).clamp(MIN_ODDS, MAX_ODDS);
            }
        }
        prior
    }

    /// Complete-data information of each surface's `ln κⱼ`: of the contacts if their active sets
    /// were known, and of the pseudo-counts.
    pub fn complete_information(&self, prior: &ContactModePrior) -> impl Iterator<Item = (f64, f64)> {
        let pseudo_candidates = prior.pseudo_candidates;
        self.candidates.iter().zip(&prior.active_share).map(move |(candidates, share)| {
            let of_candidate = share * (1.0 - share);
            (of_candidate * candidates, of_candidate * pseudo_candidates)
        })
    }
}

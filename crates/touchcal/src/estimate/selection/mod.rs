//! The choice of a model by how well it predicts contacts that it was not fitted to.
//!
//! Each model, a set of blocks of parameters and a width of the priors of encoders, is fitted
//! without one group of contacts after the other, and predicts the group that is left out. Groups
//! are placements, fixtures or regions of the workspace, never single contacts: neighbours of a
//! contact that is left out would show errors of the model around it.
//!
//! Chosen is the model with the fewest parameters whose mean error over the groups is not above
//! that of the best model by more than a standard error and 1 %: a smaller difference is of no
//! consequence, however certain. Groups differ in difficulty more than models do, so that is the
//! standard error of the difference, group by group. Of models with the same blocks that with
//! narrower priors counts as the simpler one.
//!
//! Source: Hastie, Tibshirani & Friedman, *The elements of statistical learning*, 2nd edition
//! (2009), section 7.10: cross-validation, and the one-standard-error rule.

mod candidates;
mod fits;
mod groups;
mod paired;

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;

use super::problem::Problem;
use crate::parameter::Block;
use candidates::{Model, neighbours, nested, with_model};
use fits::{FitToAll, fit_to_all, held_out_error};
pub use groups::GroupKind;
use groups::{Groups, LEAST_CONTACTS};
pub use paired::GroupMean;

/// Share (1) of an error up to which a difference is of no consequence, however certain.
const OF_NO_CONSEQUENCE: f64 = 0.01;

/// A model that was compared.
#[derive(Clone, Debug, PartialEq)]
pub struct ComparedModel {
    /// Blocks of parameters that it has beside those that all models have; empty for the nominal
    /// arm.
    pub blocks: Vec<Block>,
    /// Standard deviations of the priors of harmonics and gear ratios over the declared or usual
    /// ones (1).
    pub prior_width: f64,
    /// Number of parameters of the arm and its encoders.
    pub parameters: usize,
    /// Error (m) on each group, that was left out of the fit: root mean square distance of its
    /// contacts from their manifolds; infinite where the fit predicts none.
    pub errors: Vec<f64>,
    /// Mean of these errors.
    pub held_out: GroupMean,
    /// Root mean square distance (m) of all contacts by a fit to all.
    pub in_sample: f64,
}

impl ComparedModel {
    /// The names of the blocks with pluses between them, or `nominal`, and the width of the priors
    /// of encoders' errors where that is not the usual one.
    pub fn name(&self) -> String {
        let names: Vec<&str> = self.blocks.iter().map(|block| block.name()).collect();
        let width = if self.prior_width < 1.0 { format!(" (priors x {})", self.prior_width) } else { String::new() };
        if names.is_empty() { "nominal".to_owned() } else { names.join(" + ") + &width }
    }

    fn model(&self) -> Model {
        Model { blocks: self.blocks.clone(), width: self.prior_width }
    }

    /// Its errors (m) less those of `other`, group by group.
    pub fn difference(&self, other: &ComparedModel) -> GroupMean {
        GroupMean::of_difference(&self.errors, &other.errors)
    }

    /// Whether it predicts worse by more than the standard error and by more than 1 % of the error.
    fn is_worse_than(&self, other: &ComparedModel) -> bool {
        let difference = self.difference(other);
        difference.is_positive() && difference.mean > OF_NO_CONSEQUENCE * other.held_out.mean
    }

    fn is_richer_than(&self, other: &ComparedModel) -> bool {
        self.model().is_richer_than(&other.model())
    }
}

/// The predictive gain of a block of parameters beside the others of the chosen model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BlockGain {
    /// The block.
    pub block: Block,
    /// Whether the chosen model has it.
    pub is_chosen: bool,
    /// Errors (m) without the block less those with it.
    pub gain: GroupMean,
}

/// The choice of a model: the result of [`select`].
#[derive(Clone, Debug)]
pub struct ModelChoice {
    /// What the groups are.
    pub group_kind: GroupKind,
    /// Name of each group, of a region its number from 1.
    pub groups: Vec<String>,
    /// Contacts that all nested models reject as outliers: no error counts them.
    pub outliers: usize,
    /// The models, those with fewer parameters first, and then those with narrower priors.
    pub models: Vec<ComparedModel>,
    /// Index of the chosen model.
    pub chosen: usize,
    /// Index of the model with the least mean error.
    pub best: usize,
    /// The predictive gain of each block beside the others of the chosen model.
    pub gains: Vec<BlockGain>,
    /// Indices of models that have all blocks of the chosen one and more, fit all contacts better,
    /// and predict groups worse, by more than the standard error and 1 % of the error.
    pub extrapolate_worse: Vec<usize>,
    /// The problem with the chosen blocks, and a note among those of its contacts that says so.
    pub problem: Problem,
}

impl ModelChoice {
    /// How well the chosen model predicts, as a phrase.
    pub fn prediction(&self) -> String {
        let groups = match self.group_kind {
            GroupKind::Placements => "placements",
            GroupKind::Fixtures => "fixtures",
            GroupKind::Regions => "regions of the workspace",
        };
        let GroupMean { mean, standard_error } = self.models[self.chosen].held_out;
        let count = self.groups.len();
        let [mean, error] = [mean, standard_error].map(|metres| 1e3 * metres);
        format!("{count} {groups}, each left out of the fit once, are predicted to {mean:.3} ± {error:.3} mm rms")
    }
}

/// Fits of a selection so far.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SelectionProgress {
    /// Fits that ended.
    pub done: usize,
    /// Fits that are known to be necessary; more may follow.
    pub count: usize,
}

/// Why no model was chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum SelectionError {
    /// Neither three placements or fixtures nor enough contacts for regions of the workspace.
    #[error(
        "expected contacts with at least 3 placements or fixtures, or {LEAST_CONTACTS} contacts, to leave some out; found {contacts} contacts"
    )]
    TooFewContacts {
        /// Number of contacts.
        contacts: usize,
    },
    /// No model predicts all groups.
    #[error("expected a model that predicts the contacts of each group from the others, found none")]
    NoPrediction,
    /// The observer ended the selection.
    #[error("interrupted")]
    Interrupted,
}

/// Called at each step of a selection, from all threads; may end it.
pub type SelectionObserver<'o> = &'o (dyn Fn(&SelectionProgress) -> ControlFlow<()> + Sync);

/// Compares models of `problem` by how well they predict groups of its contacts that they are not
/// fitted to.
///
/// Models are the nominal arm, encoder offsets, joint origins, these with compliances, these with
/// harmonics of the encoders too, and the blocks that the problem declares; then those with one
/// block more or less than the model that is chosen among them, or with priors of harmonics and
/// gear ratios of half or twice the width, until there are no new ones. All have the problem's
/// other parameters (trends, walks), and declared priors where the problem declares the block. Fits
/// run in parallel; the result is the same for any number of threads. Panics if a contact or
/// distance has a fixture that is not in [`Problem::fixtures`].
pub fn select(problem: &Problem, observe: SelectionObserver<'_>) -> Result<ModelChoice, SelectionError> {
    let too_few = SelectionError::TooFewContacts { contacts: problem.contacts.len() };
    let groups = Groups::new(problem).ok_or(too_few)?;
    let work = Work { done: AtomicUsize::new(0), count: AtomicUsize::new(0), observe };
    let mut next = nested(problem);
    let fits = work.fit_to_all(problem, &next)?;
    let is_rejected = |i: usize| fits.iter().all(|fit| fit.is_rejected[i]);
    let is_scored: Vec<bool> = (0..problem.contacts.len()).map(|i| !is_rejected(i)).collect();
    let mut models = work.compare(problem, &groups, &is_scored, next.into_iter().zip(fits).collect())?;
    let (chosen, best) = loop {
        models.sort_by(|a, b| a.parameters.cmp(&b.parameters).then(a.prior_width.total_cmp(&b.prior_width)));
        let (chosen, best) = choose(&models).ok_or(SelectionError::NoPrediction)?;
        let is_new = |other: &Model| models.iter().all(|model| model.model() != *other);
        next = neighbours(problem, &models[chosen].model()).into_iter().filter(is_new).collect();
        if next.is_empty() {
            break (chosen, best);
        }
        let fits = work.fit_to_all(problem, &next)?;
        models.extend(work.compare(problem, &groups, &is_scored, next.into_iter().zip(fits).collect())?);
    };
    let selected = with_model(problem, &models[chosen].model());
    let mut choice = ModelChoice {
        group_kind: groups.kind,
        groups: groups.names,
        outliers: is_scored.iter().filter(|is_scored| !**is_scored).count(),
        gains: gains(&models, chosen),
        extrapolate_worse: extrapolate_worse(&models, chosen),
        models,
        chosen,
        best,
        problem: selected,
    };
    let note = format!("model: {}; {}", choice.models[chosen].name(), choice.prediction());
    choice.problem.contacts.note(note);
    Ok(choice)
}

/// Fits under way.
struct Work<'o> {
    done: AtomicUsize,
    count: AtomicUsize,
    observe: SelectionObserver<'o>,
}

impl Work<'_> {
    fn observe(&self) -> ControlFlow<()> {
        let [done, count] = [&self.done, &self.count].map(|number| number.load(Ordering::Relaxed));
        (self.observe)(&SelectionProgress { done, count })
    }

    /// `job` of each item, in parallel; an error if one was ended.
    fn run<T: Sync, R: Send>(
        &self,
        items: &[T],
        job: impl Fn(&T) -> Option<R> + Sync,
    ) -> Result<Vec<R>, SelectionError> {
        self.count.fetch_add(items.len(), Ordering::Relaxed);
        let results: Option<Vec<R>> = items
            .par_iter()
            .map(|item| {
                let result = job(item);
                self.done.fetch_add(1, Ordering::Relaxed);
                result.filter(|_| self.observe().is_continue())
            })
            .collect();
        results.ok_or(SelectionError::Interrupted)
    }

    fn fit_to_all(&self, problem: &Problem, models: &[Model]) -> Result<Vec<FitToAll>, SelectionError> {
        self.run(models, |model| fit_to_all(problem, model, &mut |_| self.observe()))
    }

    /// The models with their errors on each group.
    fn compare(
        &self,
        problem: &Problem,
        groups: &Groups,
        is_scored: &[bool],
        models: Vec<(Model, FitToAll)>,
    ) -> Result<Vec<ComparedModel>, SelectionError> {
        let of_model = |m: usize| (0..groups.names.len()).map(move |g| (m, g));
        let jobs: Vec<(usize, usize)> = (0..models.len()).flat_map(of_model).collect();
        let errors = self.run(&jobs, |&(m, g)| {
            held_out_error((problem, &models[m].0), (groups, g), is_scored, &mut |_| self.observe())
        })?;
        let each = models.into_iter().zip(errors.chunks(groups.names.len().max(1)));
        let compared = each.map(|((model, fit), errors)| {
            let scored = || fit.distances.iter().zip(is_scored).filter(|(_, is_scored)| **is_scored);
            let squares: f64 = scored().map(|(distance, _)| distance * distance).sum();
            ComparedModel {
                parameters: with_model(problem, &model).parameters.len(),
                errors: errors.to_vec(),
                held_out: GroupMean::of(errors),
                in_sample: (squares / scored().count().max(1) as f64).sqrt(),
                blocks: model.blocks,
                prior_width: model.width,
            }
        });
        Ok(compared.collect())
    }
}

/// Indices of the chosen and of the best of these models, those with fewer parameters first; `None`
/// if no error is finite.
fn choose(models: &[ComparedModel]) -> Option<(usize, usize)> {
    let finite = || (0..models.len()).filter(|&m| models[m].held_out.mean.is_finite());
    let best = finite().min_by(|&a, &b| models[a].held_out.mean.total_cmp(&models[b].held_out.mean))?;
    let is_worse = |m: usize| models[m].is_worse_than(&models[best]);
    Some((finite().find(|&m| !is_worse(m))?, best))
}

/// The gain of each block of which the chosen model with and without it was compared; with priors
/// of several widths the largest.
fn gains(models: &[ComparedModel], chosen: usize) -> Vec<BlockGain> {
    let chosen = &models[chosen];
    let of_neighbour = |other: &ComparedModel| {
        let (with, without) = if other.is_richer_than(chosen) { (other, chosen) } else { (chosen, other) };
        let is_neighbour = with.is_richer_than(without) && with.blocks.len() == without.blocks.len() + 1;
        let block = with.blocks.iter().find(|block| !without.blocks.contains(block)).filter(|_| is_neighbour)?;
        let gain = without.difference(with);
        Some(BlockGain { block: *block, is_chosen: std::ptr::eq(with, chosen), gain })
    };
    let mut gains: Vec<BlockGain> = Vec::new();
    for gain in models.iter().filter_map(of_neighbour) {
        match gains.iter_mut().find(|other| other.block == gain.block) {
            Some(other) if other.gain.mean < gain.gain.mean => *other = gain,
            Some(_) => {}
            None => gains.push(gain),
        }
    }
    gains
}

fn extrapolate_worse(models: &[ComparedModel], chosen: usize) -> Vec<usize> {
    let chosen = &models[chosen];
    let is_alarming = |model: &ComparedModel| {
        let is_better_in_sample = model.is_richer_than(chosen) && model.in_sample < chosen.in_sample;
        is_better_in_sample && model.is_worse_than(chosen)
    };
    (0..models.len()).filter(|&m| is_alarming(&models[m])).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn model(blocks: &[Block], parameters: usize, errors: [f64; 3]) -> ComparedModel {
        ComparedModel {
            blocks: blocks.to_vec(),
            prior_width: 1.0,
            parameters,
            errors: errors.to_vec(),
            held_out: GroupMean::of(&errors),
            in_sample: 1e-3,
        }
    }

    #[test]
    fn a_certain_gain_of_no_consequence_chooses_no_parameters() {
        let origins = [Block::JointOrigin];
        let bending = [Block::JointOrigin, Block::JointCompliance];
        // Each group better, by 0.5 % and by 2 %.
        for (gain, chosen) in [(0.005, 0), (0.02, 1)] {
            let errors = [1e-3, 1.1e-3, 1.2e-3];
            let better = errors.map(|error| error - gain * 1.1e-3);
            let models = [model(&origins, 36, errors), model(&bending, 42, better)];
            assert!(models[0].difference(&models[1]).is_positive());
            assert_eq!(choose(&models), Some((chosen, 1)), "{gain}");
        }
    }
}

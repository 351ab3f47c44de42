//! A search under way.

use nalgebra::DVector;

use crate::estimate::model::{
    CalibrationModel, ContactModeStatistics, InformativeShare, LinearizationPoint, Objective, contact_caches,
    normal_equations,
};
use crate::estimate::options::SearchOptions;
use crate::estimate::problem::Problem;
use crate::estimate::result::{Observer, Progress, Stage};
use crate::estimate::uncertainty::{GaugeFix, gauge_fix};
use crate::manifold::ContactCache;
use crate::solver::{
    FreeParameters, LevenbergMarquardtOptions, Loss, NormalEquations, StopReason, Termination, minimize,
};

/// A minimum of the least gaps other than that of the search.
#[derive(Clone)]
pub(crate) struct OtherMinimum {
    /// Parameters there (SI).
    pub theta: DVector<f64>,
    /// Its cost over that of the search's minimum (1).
    pub cost_ratio: f64,
    /// Whether it fits about as well, or neither fits.
    pub is_likely: bool,
}

/// The state of a search: model, present parameters, and what was fixed or estimated so far.
#[derive(Clone)]
pub(crate) struct SearchState<'p> {
    /// The problem with what is estimated of its noise and contact modes.
    pub model: CalibrationModel<'p>,
    /// Data that the manifolds keep of each contact between evaluations.
    pub caches: Vec<ContactCache>,
    /// Present parameters (SI), in the order of the model's layout.
    pub theta: DVector<f64>,
    /// Which parameters are free, and their scales.
    pub free: FreeParameters,
    /// Parameters that were fixed because nothing determines them.
    pub fixed: GaugeFix,
    /// How many one-sided contacts are informative; `None` where no contact modes were fitted.
    pub informative_share: Option<InformativeShare>,
    /// Sums over the contacts at the present parameters with their observed information, by
    /// [`with_unestimated_errors`](crate::estimate::model::with_unestimated_errors), where the last
    /// steps were Newton's.
    pub statistics: Option<ContactModeStatistics>,
    /// Minima of the least gaps that searches from other starts found, the one with the least cost
    /// first.
    pub other_minima: Vec<OtherMinimum>,
    /// Parameter that the coarse stage moved too far for searches from other starts, with its
    /// deviation from zero over its scale (1).
    pub contradiction: Option<(usize, f64)>,
    /// Whether the search continued from the end of a search from another start.
    pub is_from_other_start: bool,
    /// Whether one-sided contacts scatter more about the annealed parameters than the declared
    /// noise makes them scatter about the right ones.
    pub has_excess_scatter: bool,
    /// Why the last minimization stopped, with the iterations of all.
    pub termination: Termination,
}

impl<'p> SearchState<'p> {
    /// The search at its start: all parameters zero and free.
    pub fn new(problem: &'p Problem) -> Self {
        let model = CalibrationModel::new(problem);
        let scale = model.layout.scale();
        let threshold = problem.options.search.fine.decrement;
        SearchState {
            caches: contact_caches(&model),
            theta: DVector::zeros(scale.len()),
            free: FreeParameters::new(scale),
            fixed: GaugeFix::default(),
            informative_share: None,
            statistics: None,
            other_minima: Vec::new(),
            contradiction: None,
            is_from_other_start: false,
            has_excess_scatter: false,
            termination: Termination { reason: StopReason::Converged, measured: 0.0, threshold, iterations: 0 },
            model,
        }
    }

    /// Options of the search in the problem.
    pub fn options(&self) -> &'p SearchOptions {
        &self.model.problem.options.search
    }

    /// Difference of the indices of successive contacts in the smallest subsample.
    pub fn stride(&self) -> usize {
        self.model.stride(self.options().fit_subsample)
    }

    /// Whether the observer ended the search.
    pub fn is_interrupted(&self) -> bool {
        self.termination.reason == StopReason::Interrupted
    }

    /// Whether the last minimization converged or reached its limit of iterations.
    pub fn is_finished(&self) -> bool {
        matches!(self.termination.reason, StopReason::Converged | StopReason::IterationLimit)
    }

    /// Minima that contacts do not rule out: the likely ones; all of them, if the search continued
    /// from another start and stretches of the log were not predicted from each other
    /// (`is_predicted`).
    pub fn competing_minima(&self, is_predicted: bool) -> impl Iterator<Item = &OtherMinimum> {
        let is_unconfirmed = self.is_from_other_start && !is_predicted;
        self.other_minima.iter().filter(move |other| other.is_likely || is_unconfirmed)
    }

    /// The model at the present parameters.
    pub fn point(&self) -> LinearizationPoint<'_> {
        LinearizationPoint::new(&self.model, &self.theta)
    }

    /// Normal equations at `theta` of every `stride`-th contact.
    pub fn normal_equations(&mut self, theta: &DVector<f64>, objective: Objective, stride: usize) -> NormalEquations {
        normal_equations(&self.model, theta, (objective, stride), &mut self.caches)
    }

    /// Minimizes an objective of every `stride`-th contact from the present parameters.
    pub fn minimize(
        &mut self,
        objective: Objective,
        stride: usize,
        options: LevenbergMarquardtOptions,
        observe: Observer<'_>,
    ) {
        if self.is_interrupted() {
            return;
        }
        let (stage, tolerance) = match objective {
            Objective::Envelope => (Stage::Coarse, 1.0),
            // The minimum of a subsample need be no closer than the subsample determines it.
            _ => (Stage::Fine, stride as f64),
        };
        let options = LevenbergMarquardtOptions { decrement: options.decrement * tolerance, ..options };
        let (model, caches) = (&self.model, &mut self.caches);
        let linearize = |theta: &DVector<f64>| normal_equations(model, theta, (objective, stride), caches);
        let mut observe = |iteration, cost| observe(&Progress { stage, iteration, cost });
        let minimum = minimize(linearize, self.theta.clone(), &self.free, options, &mut observe);
        let iterations = self.termination.iterations + minimum.termination.iterations;
        self.theta = minimum.theta;
        self.statistics = None;
        self.termination = Termination { iterations, ..minimum.termination };
    }

    /// Fixes the parameters at zero that neither data nor priors determine; returns whether there
    /// are new ones and the search continues.
    pub fn fix_unobservable(&mut self) -> bool {
        let (theta, stride) = (self.theta.clone(), self.stride());
        let information = self.normal_equations(&theta, Objective::Residual(Loss::Squared), stride).information;
        let options = &self.model.problem.options.identifiability;
        let found = gauge_fix(&information, &self.model.layout.parameters, &self.free, options);
        for &k in &found.pivots {
            self.free.fix(k);
            self.theta[k] = 0.0;
        }
        let is_new = !found.pivots.is_empty();
        self.fixed.pivots.extend(found.pivots);
        self.fixed.participants.extend(found.participants);
        is_new && !self.is_interrupted()
    }
}

//! A problem with the parameters in order and what was estimated of its noise and contact modes.

use nalgebra::{DVector, Point3, Vector3};

use super::layout::ParameterLayout;
use super::noise::NoiseModel;
use super::trend_axis::TrendAxis;
use crate::estimate::contact_mode::{ContactModePrior, FixedMode};
use crate::estimate::problem::{Fixture, Noise, Problem, ShapeTolerance};
use crate::manifold::{Residual, ResidualKind, SurfaceCounts};
use crate::parameter::{Parameter, ParameterId};
use crate::robot::Kinematics;
use crate::se3::{self, Pose};

/// A problem with its parameters in order, and the present estimates of noise and contact modes.
#[derive(Clone)]
pub(crate) struct CalibrationModel<'p> {
    /// The problem.
    pub problem: &'p Problem,
    /// The parameters in order.
    pub layout: ParameterLayout,
    /// Nominal pose of every fixture in base (m), the mean tool position where none is declared.
    pub base_from_fixture: Vec<Pose>,
    /// Kinematics with all parameters at zero.
    pub kinematics: Kinematics,
    /// The axis along which encoder offsets change linearly.
    pub trend_axis: TrendAxis,
    /// Variances of the measurements, with estimated factors.
    pub noise: NoiseModel,
    /// Prior of the contact mode, for each fixture and each region of its manifold: those of
    /// contacts whose load is not known, and behind them those of contacts whose load is, if there
    /// are both.
    pub mode_priors: Vec<Vec<ContactModePrior>>,
    /// Indices, ascending, of contacts that are left out of the search but for its last steps, see
    /// [`gross_rows`](super::gross_rows).
    pub gross_rows: Vec<usize>,
    /// What is fixed of the mode of each contact, see [`fix_bearing`](super::fix_bearing) and
    /// [`fix_modes`](super::fix_modes). Empty before: all is found at each evaluation.
    pub fixed_modes: Vec<FixedMode>,
}

impl<'p> CalibrationModel<'p> {
    /// The model of `problem` before anything is estimated.
    pub fn new(problem: &'p Problem) -> Self {
        let layout = ParameterLayout::new(problem);
        let kinematics = Kinematics::new(&problem.robot, &layout.kinematic(), problem.tool.tip_from_tool);
        let mode_priors = problem.fixtures.iter().zip(kinds_of_contacts(problem)).map(|(fixture, kinds)| {
            let SurfaceCounts { regions, per_region } = fixture.manifold.surface_counts();
            vec![ContactModePrior::initial(per_region, &problem.options.contact_mode); kinds * regions]
        });
        CalibrationModel {
            problem,
            base_from_fixture: nominal_places(problem, &kinematics),
            trend_axis: TrendAxis::new(problem),
            noise: NoiseModel::new(&problem.robot, &problem.noise),
            mode_priors: mode_priors.collect(),
            gross_rows: Vec::new(),
            fixed_modes: Vec::new(),
            kinematics,
            layout,
        }
    }

    /// The same model with the parameters `more` behind its own.
    pub fn extended(&self, more: impl IntoIterator<Item = Parameter>) -> CalibrationModel<'p> {
        let layout = self.layout.extended(self.problem, more);
        let problem = self.problem;
        CalibrationModel {
            problem,
            base_from_fixture: self.base_from_fixture.clone(),
            kinematics: Kinematics::new(&problem.robot, &layout.kinematic(), problem.tool.tip_from_tool),
            trend_axis: self.trend_axis,
            noise: self.noise.clone(),
            mode_priors: self.mode_priors.clone(),
            gross_rows: self.gross_rows.clone(),
            fixed_modes: self.fixed_modes.clone(),
            layout,
        }
    }

    /// The same model with this noise, and factors of 1 on it.
    pub fn with_noise(self, noise: &Noise) -> CalibrationModel<'p> {
        CalibrationModel { noise: NoiseModel::new(&self.problem.robot, noise), ..self }
    }

    /// Difference of the indices of successive contacts in an even subsample of about `count` > 0
    /// contacts; at least 1.
    pub fn stride(&self, count: usize) -> usize {
        (self.problem.contacts.len() / count).max(1)
    }

    /// Whether any contact is one-sided, so that its mode is latent; false without encoder noise.
    pub fn has_one_sided_contacts(&self) -> bool {
        self.problem.noise.encoder > 0.0 && (0..self.problem.contacts.len()).any(|i| self.is_one_sided(i))
    }

    /// Number of one-sided contacts.
    pub fn one_sided_contacts(&self) -> usize {
        (0..self.problem.contacts.len()).filter(|&i| self.is_one_sided(i)).count()
    }

    /// Whether contact `i` is one-sided.
    pub fn is_one_sided(&self, i: usize) -> bool {
        self.problem.fixtures[self.problem.contacts.fixture(i)].manifold.residual_kind() == ResidualKind::LeastGap
    }

    /// Errors of one standard deviation (m) of the shapes that are declared uncertain, each over
    /// all parameters: of the clearance, common to all sides, and of the depth.
    pub fn shape_errors(&self) -> Vec<DVector<f64>> {
        let mut errors = Vec::new();
        for (f, fixture) in self.problem.fixtures.iter().enumerate() {
            let ShapeTolerance { clearance, depth, .. } = fixture.tolerance;
            for (sigma, directions) in [(clearance, 0..4), (depth, 4..6)].into_iter().filter(|(sigma, _)| *sigma > 0.0)
            {
                let is_of_error =
                    |id| matches!(id, ParameterId::DirectionalGapBias(of, k) if of == f && directions.contains(&k));
                let each =
                    self.layout.parameters.iter().map(|parameter| if is_of_error(parameter.id) { sigma } else { 0.0 });
                errors.push(DVector::from_iterator(self.layout.len(), each));
            }
        }
        errors
    }

    /// Index, among the priors of its fixture, of that of contact `i` with these candidates: of
    /// their region of the manifold, or of the first if there are none.
    pub fn region(&self, i: usize, candidates: &Residual) -> usize {
        let f = self.problem.contacts.fixture(i);
        let region = candidates.surfaces().first().map_or(0, |surface| surface / self.surfaces(f));
        let is_behind = self.has_load(i) && self.mode_priors[f].len() > self.regions(f);
        region + if is_behind { self.regions(f) } else { 0 }
    }

    /// Index, among the odds of its region, of those of a `surface` of fixture `f`'s manifold.
    pub fn odds_index(&self, f: usize, surface: usize) -> usize {
        surface % self.surfaces(f)
    }

    /// Whether the load of contact `i` is known, and says which candidates are touched.
    pub fn has_load(&self, i: usize) -> bool {
        self.problem.contacts.known_load(i).is_some()
    }

    /// Number of regions of fixture `f`'s manifold, at least 1.
    pub fn regions(&self, f: usize) -> usize {
        self.problem.fixtures[f].manifold.surface_counts().regions.max(1)
    }

    /// Number of surfaces in each region of fixture `f`'s manifold.
    fn surfaces(&self, f: usize) -> usize {
        self.mode_priors[f].first().map_or(1, |prior| prior.odds.len())
    }

    /// Column of the first `ln κⱼ` of a region of fixture `f` where the odds count as parameters
    /// too, all behind the parameters.
    pub fn odds_column(&self, f: usize, region: usize) -> usize {
        let before = self.mode_priors[..f].iter().flatten().chain(&self.mode_priors[f][..region]);
        self.layout.len() + before.map(|prior| prior.odds.len()).sum::<usize>()
    }
}

/// For each fixture 2 if the loads of some of its contacts are known and those of others are not,
/// and 1 otherwise.
fn kinds_of_contacts(problem: &Problem) -> Vec<usize> {
    let mut has = vec![[false; 2]; problem.fixtures.len()];
    for i in 0..problem.contacts.len() {
        let is_known = problem.contacts.known_load(i).is_some();
        has[problem.contacts.fixture(i)][usize::from(is_known)] = true;
    }
    has.iter().map(|[without, with]| if *without && *with { 2 } else { 1 }).collect()
}

/// Declared poses, and for fixtures without one those at which the nominal arm's tool is closest to
/// its targets; without targets the mean of its positions, with the axes of base.
fn nominal_places(problem: &Problem, kinematics: &Kinematics) -> Vec<Pose> {
    let contacts = &problem.contacts;
    let mut sums = vec![(Vector3::zeros(), 0usize); problem.fixtures.len()];
    let mut pairs = vec![(Vec::new(), Vec::new()); problem.fixtures.len()];
    for i in 0..contacts.len() {
        let f = contacts.fixture(i);
        if problem.fixtures[f].base_from_fixture.is_some() {
            continue;
        }
        let tool =
            kinematics.pose_under(contacts.q(i), contacts.load_on_joints(i, &contacts.load(i))).translation.vector;
        sums[f].0 += tool;
        sums[f].1 += 1;
        if let (Some(at_target), Some(target)) = (problem.fixtures[f].manifold.tool_at_target(), contacts.target(i)) {
            pairs[f].0.push(tool);
            pairs[f].1.push(target * Point3::from(at_target));
        }
    }
    let place = |(f, fixture): (usize, &Fixture)| {
        let (tools, targets) = &pairs[f];
        let targets: Vec<Vector3<f64>> = targets.iter().map(|target| target.coords).collect();
        let (sum, count) = sums[f];
        let searched = || match fixture.manifold.tool_at_target() {
            Some(_) => se3::alignment(tools, &targets).unwrap_or_default(),
            None => Pose::from_parts((sum / count.max(1) as f64).into(), nalgebra::UnitQuaternion::identity()),
        };
        fixture.base_from_fixture.unwrap_or_else(searched)
    };
    problem.fixtures.iter().enumerate().map(place).collect()
}

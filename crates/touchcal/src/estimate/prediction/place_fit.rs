//! Where contacts of an arm, taken as it is, put a fixture within what is declared of its place.

use std::ops::ControlFlow;

use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ChiSquared, ContinuousCDF};

use crate::estimate::evaluate::{apply_estimated_places, contact_poses};
use crate::estimate::model::{CalibrationModel, Objective, contact_caches, normal_equations};
use crate::estimate::problem::{PlacePrior, Problem, WrenchTolerance};
use crate::estimate::result::FixtureDisplacement;
use crate::parameter::{Block, Parameter, ParameterId};
use crate::robot::KinematicParameter;
use crate::se3::Pose;
use crate::solver::{FreeParameters, Loss, StopReason, minimize};

/// Standard deviations (m, rad) of the place at which a calibrated arm that is not exact sees a
/// fixture: half a millimetre is then the 95 % quantile of the distance.
const OF_ARM: [f64; 2] = [0.2e-3, 0.02 * std::f64::consts::PI / 180.0];
/// Contacts of a fit: places need no more.
const CONTACTS: usize = 2000;

/// A fixture and the tool where contacts put them, with the arm as it is.
pub(super) struct PlaceFit {
    /// The problem with the contacts of that fixture alone, and both places fixed there.
    pub placed: Problem,
    /// From the declared place to the found one.
    pub displacement: FixtureDisplacement,
}

impl PlaceFit {
    /// Fits the places of tool and fixture `f` to the contacts with that fixture, both with their
    /// priors, of which that of the fixture is widened by what a calibrated arm may be off. For an
    /// arm that is far off the fit need not converge: then the places are those where it stopped.
    /// `None` if the cost is not finite.
    pub fn new(problem: &Problem, f: usize) -> Option<PlaceFit> {
        let alone = with_arm_as_it_is(problem, f);
        let model = CalibrationModel::new(&alone);
        let is_place =
            |id: ParameterId| id.block() == Block::Tool || matches!(id, ParameterId::Fixture(of, _) if of == f);
        let parameters = &model.layout.parameters;
        let (free, theta) = fit_places(&model, is_place)?;
        let (mut caches, stride) = (contact_caches(&model), model.stride(CONTACTS));
        let objective = Objective::Residual(Loss::Squared);
        let covariance =
            free.covariance(&normal_equations(&model, &theta, (objective, stride), &mut caches).information);
        let p_value = places_p_value(parameters, &free, (&theta, &covariance));
        let mut placed = alone.clone();
        apply_estimated_places(&mut placed, |name| {
            let k = parameters.iter().position(|parameter| parameter.name == name)?;
            Some(theta[k])
        });
        let [distance, angle] = between(&contact_poses(&alone, f), &contact_poses(&placed, f));
        Some(PlaceFit { placed, displacement: FixtureDisplacement { fixture: f, distance, angle, p_value } })
    }
}

/// The problem with those fixtures whose places are not fixed where contacts put them, within what
/// is declared of them, and fixed there, with the arm and the tool as they are. `None` if the cost
/// is not finite.
pub(crate) fn with_fitted_places(mut problem: Problem) -> Option<Problem> {
    let model = CalibrationModel::new(&problem);
    let (_, theta) = fit_places(&model, |id| matches!(id, ParameterId::Fixture(..)))?;
    let names: Vec<String> = model.layout.parameters.iter().map(|parameter| parameter.name.clone()).collect();
    let places = model.base_from_fixture.clone();
    for (fixture, place) in problem.fixtures.iter_mut().zip(places) {
        fixture.base_from_fixture = Some(place);
    }
    apply_estimated_places(&mut problem, |name| Some(theta[names.iter().position(|known| known == name)?]));
    Some(problem)
}

/// Fits the parameters that are of a place to contacts and priors, from zero, the others fixed
/// there: which parameters are free, and the values of all (SI). For an arm that is far off they
/// need not be a minimum. `None` if the cost is not finite.
fn fit_places(
    model: &CalibrationModel<'_>,
    is_place: impl Fn(ParameterId) -> bool,
) -> Option<(FreeParameters, DVector<f64>)> {
    let mut free = FreeParameters::new(model.layout.scale());
    let others = model.layout.parameters.iter().enumerate().filter(|(_, parameter)| !is_place(parameter.id));
    others.for_each(|(k, _)| free.fix(k));
    let (mut caches, stride) = (contact_caches(model), model.stride(CONTACTS));
    let options = model.problem.options.search.coarse;
    let mut fit = |theta: DVector<f64>, objective: Objective| {
        let linearize = |theta: &DVector<f64>| normal_equations(model, theta, (objective, stride), &mut caches);
        minimize(linearize, theta, &free, options, &mut |_, _| ControlFlow::Continue(()))
    };
    let start = fit(DVector::zeros(model.layout.len()), Objective::Envelope).theta;
    let minimum = fit(start, Objective::Residual(Loss::Squared));
    (minimum.termination.reason != StopReason::NotFinite).then_some((free, minimum.theta))
}

/// Probability (0 to 1) that a position or a rotation of tool or fixture is as far from zero as it
/// is in `theta`, which its prior and contacts determine with this covariance: the least one times
/// their number.
fn places_p_value(
    parameters: &[Parameter],
    free: &FreeParameters,
    (theta, covariance): (&DVector<f64>, &DMatrix<f64>),
) -> f64 {
    let of = |id: ParameterId| match id {
        ParameterId::Fixture(_, component) => (Block::Fixture, component / 3),
        ParameterId::Kinematic(KinematicParameter::Tool(component)) => (Block::Tool, component / 3),
        other => (other.block(), 0),
    };
    let parts = [Block::Tool, Block::Fixture].into_iter().flat_map(|block| [(block, 0), (block, 1)]);
    let p_values = parts.filter_map(|part| {
        let (mut chi_squared, mut determined) = (0.0, 0.0);
        for k in free.indices().filter(|&k| of(parameters[k].id) == part) {
            let sigma = parameters[k].prior_sigma()?;
            chi_squared += (theta[k] / sigma).powi(2);
            determined += 1.0 - covariance[(k, k)] / (sigma * sigma);
        }
        // What contacts do not determine stays at zero.
        Some(ChiSquared::new(determined).ok()?.sf(chi_squared))
    });
    let p_values: Vec<f64> = p_values.collect();
    let least = p_values.iter().copied().fold(1.0, f64::min);
    (p_values.len() as f64 * least).min(1.0)
}

/// Root mean square distance (m) and angle (rad) between poses and those of another list.
fn between(some: &[Pose], others: &[Pose]) -> [f64; 2] {
    let (mut distance, mut angle) = (0.0, 0.0);
    for (one, other) in some.iter().zip(others) {
        distance += (one.translation.vector - other.translation.vector).norm_squared();
        angle += one.rotation.angle_to(&other.rotation).powi(2);
    }
    [distance, angle].map(|sum: f64| (sum / some.len().max(1) as f64).sqrt())
}

/// The problem with the contacts of fixture `f` alone, where nothing of the arm is estimated, and
/// with the prior of the fixture's place widened by what a calibrated arm may be off.
fn with_arm_as_it_is(problem: &Problem, f: usize) -> Problem {
    let contacts = problem.contacts.filtered(|i| problem.contacts.fixture(i) == f);
    let mut alone = Problem {
        noise: problem.noise,
        wrench: WrenchTolerance::EXACT.with_noise_of(&problem.wrench),
        options: problem.options,
        ..Problem::new(problem.robot.clone(), problem.tool.clone(), problem.fixtures.clone(), contacts)
    };
    let prior = &mut alone.fixtures[f].prior;
    *prior = match *prior {
        PlacePrior::Flat => PlacePrior::Flat,
        PlacePrior::Fixed => PlacePrior::Gaussian { sigma: OF_ARM[0], sigma_angle: OF_ARM[1] },
        PlacePrior::Gaussian { sigma, sigma_angle } => {
            PlacePrior::Gaussian { sigma: sigma.hypot(OF_ARM[0]), sigma_angle: sigma_angle.hypot(OF_ARM[1]) }
        }
    };
    alone
}

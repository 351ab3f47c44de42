//! A problem as a system of whitened rows: residual, derivative and weight of every contact at given parameters.

use std::sync::Mutex;

use nalgebra::{DMatrix, DVector, Vector3};
use rayon::prelude::*;

use super::loss::Loss;
use super::normal::NormalEquations;
use super::problem::{Fixture, Freedom, Problem};
use super::rows::{At, ContactRows, Rung};
use super::statistics::WALL_SIGMA;
use super::sums::Entry;
use super::walls::Odds;
use crate::manifold::Recall;
use crate::robot::{Column, JointKind, Kinematics, Parameter, joint_drift};
use crate::se3::Pose;

/// Contacts are summed in this many chunks, whatever the number of threads: the result does not depend on it.
const CHUNKS: usize = 64;
/// A chunk has at least this many contacts.
const SMALLEST_CHUNK: usize = 64;
/// Most contacts whose residuals are asked for together: as many as a network takes at a time.
const BATCH: usize = 128;
/// All contacts together say as much as this many independent ones of where the envelope's middle is: their deviations from it are
/// how the tool moved, not noise, and must not be explained away by parameters that hardly matter.
const ENVELOPE_SAY: f64 = 10.0;
/// Prior standard deviation of a gap manifold's interference (m): contacts neither float nor penetrate by much more.
const INTERFERENCE_SIGMA: f64 = 0.1e-3;

/// Directions in which walls push.
const DIRECTIONS: usize = 6;

/// A problem with its parameters in order.
pub(crate) struct System<'p> {
    pub problem: &'p Problem,
    pub parameters: Vec<Parameter>,
    /// Nominal place of every fixture.
    pub base_from_fixture: Vec<Pose>,
    /// Variance of each joint's measurement.
    pub joint_variance: Vec<f64>,
    pub kinematics: Kinematics,
    /// Measured over declared standard deviation of the noise.
    pub noise_factor: f64,
    /// How well a contact's pose is known (m): the noise of its residual, see [`ContactManifold::residual`](crate::manifold::ContactManifold).
    pub resolution: f64,
    /// How often walls are touched, of each fixture and region of it.
    pub odds: Vec<Vec<Odds>>,
    /// Standard deviation of walls' noise over what it was taken for.
    pub wall_noise: f64,
    /// Index of each fixture's placement.
    pub placement: Vec<usize>,
    /// For each fixture, the indices of all parameters that its contacts see, ascending.
    pub seen: Vec<Vec<usize>>,
    /// What is kept of each contact between looks at its walls: they are found sooner, and are the same.
    pub recalls: Vec<Mutex<Recall>>,
}

impl<'p> System<'p> {
    pub fn new(problem: &'p Problem) -> Self {
        let (placement_names, placement) = placements(problem);
        let parameters = all_parameters(problem, &placement_names);
        let columns: Vec<Column> = parameters.iter().map(|parameter| parameter.column).collect();
        let kinematics = Kinematics::new(&problem.robot, &columns, problem.tool.tip_from_tool);
        let seen = (0..problem.fixtures.len()).map(|fixture| seen_by(&columns, fixture, placement[fixture])).collect();
        let joint_variance = problem.robot.moving().map(|joint| match joint.kind {
            // An encoder of a slide is rated in metres; the declared angle is what a revolute joint has.
            JointKind::Prismatic => 0.0,
            _ => problem.noise.encoder.powi(2),
        });
        let joint_variance = joint_variance.collect();
        let base_from_fixture = nominal_places(problem, &kinematics);
        let start = |fixture: &Fixture| {
            let (regions, surfaces) = fixture.manifold.surfaces();
            vec![Odds::start(surfaces); regions]
        };
        System {
            problem,
            parameters,
            base_from_fixture,
            joint_variance,
            kinematics,
            noise_factor: 1.0,
            resolution: 0.0,
            odds: problem.fixtures.iter().map(start).collect(),
            wall_noise: 1.0,
            placement,
            seen,
            recalls: (0..problem.contacts.len()).map(|_| Mutex::default()).collect(),
        }
    }

    /// Where the `ln κ_j` of a region of fixture `f` stand, all those after the parameters.
    pub fn odds_column(&self, f: usize, region: usize) -> usize {
        let before = self.odds[..f].iter().flatten().chain(&self.odds[f][..region]);
        self.parameters.len() + before.map(|odds| odds.another.len()).sum::<usize>()
    }

    /// Scale of every parameter: its prior's standard deviation, else its plausible size.
    pub fn scale(&self) -> DVector<f64> {
        let each = self.parameters.iter().map(|parameter| parameter.prior_sigma.unwrap_or(parameter.scale));
        DVector::from_iterator(self.parameters.len(), each)
    }

    /// The system at parameters `theta`.
    pub fn at(&self, theta: &DVector<f64>) -> At<'_> {
        At::new(self, theta)
    }

    /// Every so many contacts there are about `enough`.
    pub fn stride(&self, enough: usize) -> usize {
        (self.problem.contacts.len() / enough).max(1)
    }

    /// Takes the noise of the contacts at `theta` as the resolution.
    pub fn set_resolution(&mut self, theta: &DVector<f64>, stride: usize) {
        let at = self.at(theta);
        let mut rows = at.rows();
        let each = (0..self.problem.contacts.len()).step_by(stride);
        let mut deviations: Vec<f64> = each.map(|i| at.deviation(i, &mut rows)).collect();
        deviations.sort_unstable_by(f64::total_cmp);
        self.resolution = deviations.get(deviations.len() / 2).copied().unwrap_or(0.0);
    }

    /// Normal equations at `theta` of every `stride`-th contact (weighted to stand for all), known distances and priors.
    pub fn linearize(&self, theta: &DVector<f64>, rung: Rung, stride: usize) -> NormalEquations {
        let mut total = self.contacts(theta, rung, stride);
        match rung {
            Rung::Residual(_) | Rung::Walls => self.at(theta).add_distances(&mut total),
            Rung::Envelope => total.scale(ENVELOPE_SAY / self.problem.contacts.len().max(1) as f64),
        }
        self.add_priors(theta, rung, &mut total);
        total.complete()
    }

    /// Normal equations of the contacts alone, upper triangle.
    pub fn contacts(&self, theta: &DVector<f64>, rung: Rung, stride: usize) -> NormalEquations {
        let at = self.at(theta);
        let entry = Entry { rung, share: stride as f64 };
        let add = |batch: &[usize], rows: &mut ContactRows, normal: &mut NormalEquations| {
            at.add_logged(batch, entry, rows, normal);
        };
        self.sum(stride, || at.rows(), add).0
    }

    /// Sums what `add(batch, room, sum)` adds for every `stride`-th contact, in parallel chunks of contacts; a batch is of one fixture.
    /// `room()` makes what a chunk works in. The rooms come back in the order of the contacts.
    pub fn sum<R: Send>(
        &self,
        stride: usize,
        room: impl Fn() -> R + Sync,
        add: impl Fn(&[usize], &mut R, &mut NormalEquations) + Sync,
    ) -> (NormalEquations, Vec<R>) {
        let contacts = &self.problem.contacts;
        let count = contacts.len().div_ceil(stride);
        let chunk = count.div_ceil(CHUNKS).max(SMALLEST_CHUNK);
        let parts: Vec<(NormalEquations, R)> = (0..count.div_ceil(chunk))
            .into_par_iter()
            .map(|part| {
                let mut normal = NormalEquations::new(self.parameters.len());
                let mut room = room();
                let which = part * chunk..((part + 1) * chunk).min(count);
                let which: Vec<usize> = which.map(|i| i * stride).collect();
                let of_fixture = which.chunk_by(|&a, &b| contacts.fixture(a) == contacts.fixture(b));
                of_fixture.flat_map(|which| which.chunks(BATCH)).for_each(|batch| add(batch, &mut room, &mut normal));
                (normal, room)
            })
            .collect();
        let mut total = NormalEquations::new(self.parameters.len());
        let mut rooms = Vec::with_capacity(parts.len());
        for (part, room) in parts {
            total.add(&part);
            rooms.push(room);
        }
        (total, rooms)
    }

    /// What the contacts say at `theta`: `Σ JᵀJ` of all, and each one's squared whitened residual with its number of rows.
    pub fn statistics(&self, theta: &DVector<f64>) -> (DMatrix<f64>, Vec<(f64, usize)>) {
        let at = self.at(theta);
        let room = || (at.rows(), Vec::new());
        let entry = Entry { rung: Rung::Residual(Loss::Squared), share: 1.0 };
        let (normal, rooms) =
            self.sum(1, room, |batch, (rows, norms), normal| norms.extend(at.add_logged(batch, entry, rows, normal)));
        (normal.complete().information, rooms.into_iter().flat_map(|(_, norms)| norms).collect())
    }

    /// Information of the known distances.
    pub fn distance_information(&self, theta: &DVector<f64>) -> DMatrix<f64> {
        let mut normal = NormalEquations::new(self.parameters.len());
        self.at(theta).add_distances(&mut normal);
        normal.complete().information
    }

    /// Information of the priors.
    pub fn prior_information(&self) -> DMatrix<f64> {
        let each = self.parameters.iter().map(|p| p.prior_sigma.map_or(0.0, |sigma| sigma.powi(-2)));
        DMatrix::from_diagonal(&DVector::from_iterator(self.parameters.len(), each))
    }

    /// Priors; towards the envelope, parameters without one stay within their plausible size, so that nothing collapses
    /// (an arm without lengths touches one free socket perfectly).
    pub fn add_priors(&self, theta: &DVector<f64>, rung: Rung, normal: &mut NormalEquations) {
        for (k, parameter) in self.parameters.iter().enumerate() {
            let plausible = (rung == Rung::Envelope).then_some(parameter.scale);
            if let Some(sigma) = parameter.prior_sigma.or(plausible) {
                let residual = theta[k] / sigma;
                normal.add_row(&[k], &[1.0 / sigma], residual, 1.0);
                normal.cost += residual * residual;
            }
        }
    }
}

/// Names of the placements in the order of their first fixture, and the placement of each fixture.
fn placements(problem: &Problem) -> (Vec<&str>, Vec<usize>) {
    let mut names: Vec<&str> = Vec::new();
    let mut index = Vec::with_capacity(problem.fixtures.len());
    for fixture in &problem.fixtures {
        let known = names.iter().position(|name| *name == fixture.placement);
        index.push(known.unwrap_or(names.len()));
        if known.is_none() {
            names.push(&fixture.placement);
        }
    }
    (names, index)
}

/// The arm's parameters, then the tool's, each fixture's and each interference.
fn all_parameters(problem: &Problem, placements: &[&str]) -> Vec<Parameter> {
    let mut parameters = problem.parameters.clone();
    // One placement's drift cannot be told from the offsets.
    if problem.joint_drift && placements.len() > 1 {
        for (p, name) in placements.iter().enumerate() {
            parameters.extend(joint_drift(&problem.robot, p, name));
        }
    }
    let mut tool_directions: Vec<usize> =
        problem.fixtures.iter().flat_map(|fixture| fixture.manifold.tool_directions().iter().copied()).collect();
    tool_directions.sort_unstable();
    tool_directions.dedup();
    add_place(&mut parameters, "tool", problem.tool.freedom, &tool_directions, Column::Tool);
    for (f, fixture) in problem.fixtures.iter().enumerate() {
        let prefix = format!("fixture.{}", fixture.name);
        let directions = fixture.manifold.fixture_directions();
        add_place(&mut parameters, &prefix, fixture.freedom, directions, |k| Column::Fixture(f, k));
    }
    for (f, fixture) in problem.fixtures.iter().enumerate() {
        if fixture.manifold.has_interference() {
            parameters.push(Parameter::interference(&fixture.name, f).with_prior(INTERFERENCE_SIGMA));
            let wall = |k| Parameter::wall(&fixture.name, f, k).with_prior(WALL_SIGMA);
            parameters.extend((0..DIRECTIONS).map(wall));
        }
    }
    parameters
}

fn add_place(
    parameters: &mut Vec<Parameter>,
    prefix: &str,
    freedom: Freedom,
    directions: &[usize],
    column: impl Fn(usize) -> Column,
) {
    for &k in directions {
        let parameter = Parameter::twist(prefix, column(k), k);
        match freedom {
            Freedom::Known => {}
            Freedom::Free => parameters.push(parameter),
            Freedom::Uncertain { sigma, sigma_angle } => {
                let sigma = if k < 3 { sigma } else { sigma_angle };
                if sigma > 0.0 {
                    parameters.push(parameter.with_prior(sigma));
                }
            }
        }
    }
}

fn seen_by(columns: &[Column], fixture: usize, placement: usize) -> Vec<usize> {
    let sees = |column: Column| match column {
        Column::Fixture(f, _) | Column::Interference(f) | Column::Wall(f, _) => f == fixture,
        Column::JointDrift(p, _) => p == placement,
        _ => true,
    };
    (0..columns.len()).filter(|&k| sees(columns[k])).collect()
}

/// Declared places, and for fixtures without one the mean tool position of their contacts by the nominal arm.
fn nominal_places(problem: &Problem, kinematics: &Kinematics) -> Vec<Pose> {
    let mut sums = vec![(Vector3::zeros(), 0usize); problem.fixtures.len()];
    for i in 0..problem.contacts.len() {
        let (sum, count) = &mut sums[problem.contacts.fixture(i)];
        if problem.fixtures[problem.contacts.fixture(i)].base_from_fixture.is_none() {
            *sum += kinematics.pose_under(problem.contacts.q(i), &problem.contacts.load(i)).translation.vector;
            *count += 1;
        }
    }
    let declared = problem.fixtures.iter().zip(sums);
    declared
        .map(|(fixture, (sum, count))| {
            let mean = || Pose::from_parts((sum / count.max(1) as f64).into(), nalgebra::UnitQuaternion::identity());
            fixture.base_from_fixture.unwrap_or_else(mean)
        })
        .collect()
}

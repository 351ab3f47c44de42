//! A problem as a system of whitened rows: residual, derivative and weight of every contact at given parameters.

use nalgebra::{DMatrix, DVector, Matrix6, SMatrix, Vector3};
use rayon::prelude::*;

use super::loss::Loss;
use super::normal::NormalEquations;
use super::problem::{Freedom, Problem};
use crate::manifold::{MAX_ROWS, Rows};
use crate::robot::{Column, JointKind, Kinematics, Parameter, Scratch, joint_drift};
use crate::se3::{self, Pose, Twist};

/// Contacts are summed in this many chunks, whatever the number of threads: the result does not depend on it.
const CHUNKS: usize = 64;
/// A chunk has at least this many contacts.
const SMALLEST_CHUNK: usize = 64;
/// Prior standard deviation of a gap manifold's interference (m): contacts neither float nor penetrate by much more.
const INTERFERENCE_SIGMA: f64 = 0.1e-3;

/// Which rows a contact gives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Rung {
    /// The envelope, in its own scale.
    Envelope,
    /// The residual, whitened, with this loss.
    Residual(Loss),
}

/// A problem with its parameters in order.
pub(crate) struct System<'p> {
    pub problem: &'p Problem,
    pub parameters: Vec<Parameter>,
    /// Nominal place of every fixture.
    base_from_fixture: Vec<Pose>,
    /// Variance of each joint's measurement.
    joint_variance: Vec<f64>,
    kinematics: Kinematics,
    /// Measured over declared standard deviation of the noise.
    pub noise_factor: f64,
    /// How well a contact's pose is known (m): the noise of its residual, see [`ContactManifold::residual`](crate::manifold::ContactManifold).
    pub resolution: f64,
    /// Index of each fixture's placement.
    placement: Vec<usize>,
    /// For each fixture, the indices of all parameters that its contacts see, ascending.
    seen: Vec<Vec<usize>>,
}

/// A system at given parameters.
pub(crate) struct At<'s> {
    system: &'s System<'s>,
    kinematics: Kinematics,
    fixtures: Vec<FixtureAt>,
    /// Drift of each joint in each placement (rad), one placement after the other.
    drift: Vec<f64>,
}

struct FixtureAt {
    fixture_from_base: Pose,
    base_from_fixture: Pose,
    right_jacobian: Matrix6<f64>,
    interference: f64,
}

/// One contact's whitened rows, in place.
pub(crate) struct ContactRows {
    q: Vec<f64>,
    scratch: Scratch,
    rows: Rows,
    /// Whitened derivatives, `MAX_ROWS` rows of as many columns as parameters are seen.
    jacobian: Vec<f64>,
    residual: [f64; MAX_ROWS],
    /// Standard deviation (m) of the first row before whitening.
    deviation: f64,
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
        System {
            problem,
            parameters,
            base_from_fixture,
            joint_variance,
            kinematics,
            noise_factor: 1.0,
            resolution: 0.0,
            placement,
            seen,
        }
    }

    /// Scale of every parameter: its prior's standard deviation, else its plausible size.
    pub fn scale(&self) -> DVector<f64> {
        let each = self.parameters.iter().map(|parameter| parameter.prior_sigma.unwrap_or(parameter.scale));
        DVector::from_iterator(self.parameters.len(), each)
    }

    /// The system at parameters `theta`.
    pub fn at(&self, theta: &DVector<f64>) -> At<'_> {
        let mut kinematics = self.kinematics.clone();
        kinematics.set(theta.as_slice());
        let mut twists = vec![Twist::zeros(); self.base_from_fixture.len()];
        let mut interference = vec![0.0; self.base_from_fixture.len()];
        let dof = self.kinematics.dof();
        let mut drift = vec![0.0; dof * (1 + self.placement.iter().max().copied().unwrap_or(0))];
        for (parameter, &value) in self.parameters.iter().zip(theta.iter()) {
            match parameter.column {
                Column::JointDrift(placement, i) => drift[placement * dof + i] = value,
                Column::Fixture(f, k) => twists[f][k] = value,
                Column::Interference(f) => interference[f] = value,
                _ => {}
            }
        }
        let fixtures = self.base_from_fixture.iter().zip(twists).zip(interference);
        let fixtures = fixtures.map(|((nominal, twist), interference)| {
            let base_from_fixture = nominal * se3::exp(&twist);
            FixtureAt {
                fixture_from_base: base_from_fixture.inverse(),
                base_from_fixture,
                right_jacobian: se3::right_jacobian(&twist),
                interference,
            }
        });
        At { system: self, kinematics, fixtures: fixtures.collect(), drift }
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
        if let Rung::Residual(_) = rung {
            self.at(theta).add_distances(&mut total);
        }
        self.add_priors(theta, &mut total);
        total.complete()
    }

    /// Normal equations of the contacts alone, upper triangle.
    pub fn contacts(&self, theta: &DVector<f64>, rung: Rung, stride: usize) -> NormalEquations {
        let at = self.at(theta);
        let size = self.parameters.len();
        let count = self.problem.contacts.len().div_ceil(stride);
        let chunk = count.div_ceil(CHUNKS).max(SMALLEST_CHUNK);
        let parts: Vec<NormalEquations> = (0..count.div_ceil(chunk))
            .into_par_iter()
            .map(|part| {
                let mut normal = NormalEquations::new(size);
                let mut rows = at.rows();
                for i in part * chunk..((part + 1) * chunk).min(count) {
                    at.add_contact(i * stride, rung, stride as f64, &mut rows, &mut normal);
                }
                normal
            })
            .collect();
        let mut total = NormalEquations::new(size);
        for part in &parts {
            total.add(part);
        }
        total
    }

    /// Information of the data: `share · Σ JᵀJ` of all contacts, and the known distances.
    pub fn information(&self, theta: &DVector<f64>, share: f64) -> DMatrix<f64> {
        let contacts = self.contacts(theta, Rung::Residual(Loss::Squared), 1);
        let mut total = NormalEquations::new(self.parameters.len());
        self.at(theta).add_distances(&mut total);
        total.information += contacts.information * share;
        total.complete().information
    }

    pub fn add_priors(&self, theta: &DVector<f64>, normal: &mut NormalEquations) {
        for (k, parameter) in self.parameters.iter().enumerate() {
            if let Some(sigma) = parameter.prior_sigma {
                let residual = theta[k] / sigma;
                normal.add_row(&[k], &[1.0 / sigma], residual, 1.0);
                normal.cost += residual * residual;
            }
        }
    }
}

impl ContactRows {
    /// Number of rows of the contact looked at last.
    pub fn len(&self) -> usize {
        self.rows.len()
    }
}

impl At<'_> {
    /// Room for one contact.
    pub fn rows(&self) -> ContactRows {
        let columns = self.system.parameters.len();
        ContactRows {
            q: vec![0.0; self.kinematics.dof()],
            scratch: self.kinematics.scratch(),
            rows: Rows::new(),
            jacobian: vec![0.0; MAX_ROWS * columns],
            residual: [0.0; MAX_ROWS],
            deviation: 0.0,
        }
    }

    /// The tool's pose in the frame of the fixture that contact `i` touches; drifts, which pass, are left out.
    pub fn fixture_from_tool(&self, i: usize) -> Pose {
        let contacts = &self.system.problem.contacts;
        self.fixtures[contacts.fixture(i)].fixture_from_base * self.kinematics.pose(contacts.q(i))
    }

    /// Residual of contact `i` (m), at most three rows of it, less the mean penetration.
    pub fn residual_vector(&self, i: usize, into: &mut ContactRows) -> Vector3<f64> {
        let f = self.system.problem.contacts.fixture(i);
        into.rows.clear();
        self.system.problem.fixtures[f].manifold.residual(&self.fixture_from_tool(i), 0.0, &mut into.rows);
        let value = |k: usize| into.rows.values().get(k).copied().unwrap_or(0.0);
        Vector3::new(value(0) - self.fixtures[f].interference, value(1), value(2))
    }

    /// Standard deviation (m) of the first row of contact `i`'s residual.
    fn deviation(&self, i: usize, into: &mut ContactRows) -> f64 {
        self.contact(i, Rung::Residual(Loss::Squared), into);
        into.deviation
    }

    /// Rows of contact `i`, whitened for [`Rung::Residual`]; returns their squared norm.
    pub fn contact(&self, i: usize, rung: Rung, into: &mut ContactRows) -> f64 {
        let system = self.system;
        let contacts = &system.problem.contacts;
        let f = contacts.fixture(i);
        let fixture = &self.fixtures[f];
        let manifold = &system.problem.fixtures[f].manifold;
        let drift = &self.drift[system.placement[f] * contacts.dof()..];
        for (q, (measured, drift)) in into.q.iter_mut().zip(contacts.q(i).iter().zip(drift)) {
            *q = measured - drift;
        }
        let base_from_tool = self.kinematics.pose_and_jacobian(&into.q, &mut into.scratch);
        let fixture_from_tool = fixture.fixture_from_base * base_from_tool;
        into.rows.clear();
        let whiten = match rung {
            Rung::Envelope => {
                manifold.envelope(&fixture_from_tool, &mut into.rows);
                false
            }
            Rung::Residual(_) => {
                manifold.residual(&fixture_from_tool, system.resolution, &mut into.rows);
                true
            }
        };
        let seen = &system.seen[f];
        // T_ft = T_bf⁻¹ T_bt: moving the fixture by Exp(ζ) moves the tool, in its own frame, by −Ad(T_ft⁻¹) ζ.
        let fixture_motion = seen
            .iter()
            .any(|&k| matches!(system.parameters[k].column, Column::Fixture(..)))
            .then(|| -(se3::adjoint(&fixture_from_tool.inverse()) * fixture.right_jacobian));
        for (r, row) in into.rows.jacobian().iter().enumerate() {
            into.residual[r] = into.rows.values()[r];
            let jacobian = &mut into.jacobian[r * seen.len()..(r + 1) * seen.len()];
            for (entry, &k) in jacobian.iter_mut().zip(seen) {
                *entry = match system.parameters[k].column {
                    Column::Fixture(_, component) => {
                        fixture_motion.as_ref().map_or(0.0, |motion| row.dot(&motion.column(component)))
                    }
                    Column::JointDrift(_, joint) => -row.dot(&into.scratch.joints[joint]),
                    Column::Interference(_) => {
                        if whiten {
                            into.residual[r] -= fixture.interference;
                            -1.0
                        } else {
                            0.0
                        }
                    }
                    _ => row.dot(&into.scratch.columns[k]),
                };
            }
        }
        if whiten {
            self.whiten(seen.len(), into);
        }
        into.residual[..into.rows.len()].iter().map(|r| r * r).sum()
    }

    /// Divides rows by the Cholesky factor of their errors-in-variables covariance
    /// `N (J Σ_q Jᵀ) Nᵀ + σ_c² I`: encoder noise reaches the residual through the arm.
    fn whiten(&self, width: usize, into: &mut ContactRows) {
        let len = into.rows.len();
        let factor = self.system.noise_factor.powi(2);
        let contact_variance = self.system.problem.noise.contact.powi(2);
        let mut covariance = SMatrix::<f64, MAX_ROWS, MAX_ROWS>::identity();
        for a in 0..len {
            for b in 0..=a {
                let (row_a, row_b) = (&into.rows.jacobian()[a], &into.rows.jacobian()[b]);
                let joints = into.scratch.joints.iter().zip(&self.system.joint_variance);
                let encoder: f64 = joints.map(|(joint, variance)| row_a.dot(joint) * row_b.dot(joint) * variance).sum();
                covariance[(a, b)] = factor * (encoder + if a == b { contact_variance } else { 0.0 });
            }
        }
        // Cholesky and forward substitution in place, lower triangle only.
        for a in 0..len {
            for b in 0..=a {
                let dot: f64 = (0..b).map(|k| covariance[(a, k)] * covariance[(b, k)]).sum();
                let rest = covariance[(a, b)] - dot;
                covariance[(a, b)] =
                    if a == b { rest.max(f64::MIN_POSITIVE).sqrt() } else { rest / covariance[(b, b)] };
            }
        }
        into.deviation = covariance[(0, 0)];
        for a in 0..len {
            for b in 0..a {
                let factor = covariance[(a, b)];
                into.residual[a] -= factor * into.residual[b];
                let (before, after) = into.jacobian.split_at_mut(a * width);
                for (entry, earlier) in after[..width].iter_mut().zip(&before[b * width..(b + 1) * width]) {
                    *entry -= factor * earlier;
                }
            }
            let scale = 1.0 / covariance[(a, a)];
            into.residual[a] *= scale;
            into.jacobian[a * width..(a + 1) * width].iter_mut().for_each(|entry| *entry *= scale);
        }
    }

    fn add_contact(&self, i: usize, rung: Rung, share: f64, rows: &mut ContactRows, normal: &mut NormalEquations) {
        let squared = self.contact(i, rung, rows);
        let loss = match rung {
            Rung::Envelope => Loss::Squared,
            Rung::Residual(loss) => loss,
        };
        let weight = share * loss.weight(squared);
        let seen = &self.system.seen[self.system.problem.contacts.fixture(i)];
        for r in 0..rows.rows.len() {
            let jacobian = &rows.jacobian[r * seen.len()..(r + 1) * seen.len()];
            normal.add_row(seen, jacobian, rows.residual[r], weight);
        }
        normal.cost += share * loss.cost(squared);
        normal.squares += weight * squared;
        normal.rows += weight * rows.rows.len() as f64;
    }

    /// Known distances between fixtures' origins.
    pub fn add_distances(&self, normal: &mut NormalEquations) {
        for distance in &self.system.problem.distances {
            let (a, b) = distance.between;
            let span = self.fixtures[b].base_from_fixture.translation.vector
                - self.fixtures[a].base_from_fixture.translation.vector;
            let length = span.norm();
            let along = span / length.max(f64::MIN_POSITIVE);
            let mut index = Vec::new();
            let mut jacobian = Vec::new();
            for (k, parameter) in self.system.parameters.iter().enumerate() {
                if let Column::Fixture(f, component) = parameter.column
                    && (f == a || f == b)
                {
                    let fixture = &self.fixtures[f];
                    let local: Twist = fixture.right_jacobian.column(component).into();
                    let moved = fixture.base_from_fixture.rotation * se3::linear(&local);
                    index.push(k);
                    jacobian.push(along.dot(&moved) * if f == b { 1.0 } else { -1.0 } / distance.sigma);
                }
            }
            let residual = (length - distance.distance) / distance.sigma;
            normal.add_row(&index, &jacobian, residual, 1.0);
            normal.cost += residual * residual;
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
        Column::Fixture(f, _) | Column::Interference(f) => f == fixture,
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
            *sum += kinematics.pose(problem.contacts.q(i)).translation.vector;
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

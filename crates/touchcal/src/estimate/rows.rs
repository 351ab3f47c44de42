//! One contact's rows: residual, derivative and weight at given parameters.

use std::sync::PoisonError;

use nalgebra::{DVector, Matrix6, Vector3};

use super::loss::Loss;
use super::system::System;
use super::walls::{self, Distances, Near, Said, Square};
use crate::manifold::{Cotangent, MAX_ROWS, Reach, Rows};
use crate::robot::{Column, Kinematics, Scratch};
use crate::se3::{self, Pose, Twist};

/// Which rows a contact gives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Rung {
    /// The envelope, in its own scale.
    Envelope,
    /// The residual, whitened, with this loss.
    Residual(Loss),
    /// What the walls near say, of one-sided contacts; of others the residual, whitened, with the problem's loss.
    Walls,
}

/// A system at given parameters.
pub(crate) struct At<'s> {
    pub(super) system: &'s System<'s>,
    kinematics: Kinematics,
    pub(super) fixtures: Vec<FixtureAt>,
    /// Drift of each joint in each placement (rad), one placement after the other.
    drift: Vec<f64>,
}

pub(super) struct FixtureAt {
    fixture_from_base: Pose,
    pub base_from_fixture: Pose,
    pub right_jacobian: Matrix6<f64>,
    interference: f64,
    /// Of the walls in each direction, on top of it.
    walls: [f64; 6],
}

/// One contact's whitened rows, in place.
pub(crate) struct ContactRows {
    pub(super) q: Vec<f64>,
    scratch: Scratch,
    pub(super) rows: Rows,
    /// Whitened derivatives, `MAX_ROWS` rows of as many columns as parameters are seen.
    pub(super) jacobian: Vec<f64>,
    pub(super) residual: [f64; MAX_ROWS],
    /// Standard deviation (m) of the first row before whitening.
    deviation: f64,
    /// Which walls were near, and what they said, if they were asked.
    reach: Reach,
    pub(super) said: Option<Said>,
    /// Whether sums are for the covariance: true second derivatives, squares of slopes, and what follows from how often walls are touched.
    pub(super) for_covariance: bool,
}

impl ContactRows {
    /// Number of rows of the contact looked at last.
    pub fn len(&self) -> usize {
        self.rows.len()
    }

    /// Squared norm of those rows.
    pub fn squared(&self) -> f64 {
        self.residual[..self.len()].iter().map(|r| r * r).sum()
    }
}

impl<'s> At<'s> {
    /// Takes over parameters `theta`.
    pub fn new(system: &'s System<'s>, theta: &DVector<f64>) -> Self {
        let mut kinematics = system.kinematics.clone();
        kinematics.set(theta.as_slice());
        let mut twists = vec![Twist::zeros(); system.base_from_fixture.len()];
        let mut interference = vec![(0.0, [0.0; 6]); system.base_from_fixture.len()];
        let dof = system.kinematics.dof();
        let mut drift = vec![0.0; dof * (1 + system.placement.iter().max().copied().unwrap_or(0))];
        for (parameter, &value) in system.parameters.iter().zip(theta.iter()) {
            match parameter.column {
                Column::JointDrift(placement, i) => drift[placement * dof + i] = value,
                Column::Fixture(f, k) => twists[f][k] = value,
                Column::Interference(f) => interference[f].0 = value,
                Column::Wall(f, k) => interference[f].1[k] = value,
                _ => {}
            }
        }
        let fixtures = system.base_from_fixture.iter().zip(twists).zip(interference);
        let fixtures = fixtures.map(|((nominal, twist), (interference, walls))| {
            let base_from_fixture = nominal * se3::exp(&twist);
            FixtureAt {
                fixture_from_base: base_from_fixture.inverse(),
                base_from_fixture,
                right_jacobian: se3::right_jacobian(&twist),
                interference,
                walls,
            }
        });
        At { system, kinematics, fixtures: fixtures.collect(), drift }
    }

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
            reach: Reach { covariance: Matrix6::zeros(), own_variance: 0.0, interference: 0.0, deviations: 0.0 },
            said: None,
            for_covariance: false,
        }
    }

    /// The tool's pose in the frame of the fixture that contact `i` touches; drifts, which pass, are left out.
    pub fn fixture_from_tool(&self, i: usize) -> Pose {
        let contacts = &self.system.problem.contacts;
        self.fixtures[contacts.fixture(i)].fixture_from_base
            * self.kinematics.pose_under(contacts.q(i), &contacts.load(i))
    }

    /// Exact residual of contact `i` (m), at most three rows of it.
    pub fn residual_vector(&self, i: usize, into: &mut ContactRows) -> Vector3<f64> {
        let f = self.system.problem.contacts.fixture(i);
        into.rows.clear();
        self.system.problem.fixtures[f].manifold.residual(&self.fixture_from_tool(i), 0.0, &mut into.rows);
        let value = |k: usize| into.rows.values().get(k).copied().unwrap_or(0.0);
        Vector3::new(value(0), value(1), value(2))
    }

    /// Standard deviation (m) of the first row of contact `i`'s residual.
    pub fn deviation(&self, i: usize, into: &mut ContactRows) -> f64 {
        self.contact(i, Rung::Residual(Loss::Squared), into);
        into.deviation
    }

    /// Rows of contact `i`, whitened for [`Rung::Residual`].
    pub fn contact(&self, i: usize, rung: Rung, into: &mut ContactRows) {
        let f = self.system.problem.contacts.fixture(i);
        let fixture_from_tool = self.locate(i, into);
        self.look(f, std::slice::from_ref(&fixture_from_tool), rung, std::slice::from_mut(&mut into.rows));
        self.whitened(i, &fixture_from_tool, rung, into);
    }

    /// What the manifold of fixture `f` says of poses, not whitened, in place of what `rows` held.
    pub(super) fn look(&self, f: usize, fixture_from_tool: &[Pose], rung: Rung, rows: &mut [Rows]) {
        let manifold = &self.system.problem.fixtures[f].manifold;
        match rung {
            // They are looked for when noise is known.
            Rung::Walls if manifold.has_interference() => rows.iter_mut().for_each(Rows::clear),
            Rung::Residual(_) | Rung::Walls => manifold.residuals(fixture_from_tool, self.system.resolution, rows),
            Rung::Envelope => fixture_from_tool.iter().zip(rows).for_each(|(pose, rows)| {
                rows.clear();
                manifold.envelope(pose, rows);
            }),
        }
    }

    /// Rows of contact `i`, which was located and looked at, by all parameters seen.
    pub(super) fn whitened(&self, i: usize, fixture_from_tool: &Pose, rung: Rung, into: &mut ContactRows) {
        let system = self.system;
        let f = system.problem.contacts.fixture(i);
        let whiten = rung != Rung::Envelope;
        let walls = rung == Rung::Walls && system.problem.fixtures[f].manifold.has_interference();
        if walls {
            self.find_walls(i, fixture_from_tool, into);
        }
        let seen = &system.seen[f];
        let fixture_motion = self.fixture_motion(f, fixture_from_tool);
        for (r, row) in into.rows.jacobian().iter().enumerate() {
            let jacobian = &mut into.jacobian[r * seen.len()..(r + 1) * seen.len()];
            let direction = walls.then(|| direction(&(fixture_from_tool.rotation * se3::linear(row))));
            for (entry, &k) in jacobian.iter_mut().zip(seen) {
                *entry = match system.parameters[k].column {
                    Column::Interference(_) if whiten => -1.0,
                    Column::Wall(_, k) => -f64::from(u8::from(direction == Some(k))),
                    _ => change(&system.parameters[k].column, row, fixture_motion.as_ref(), k, &into.scratch),
                };
            }
            let interference = if whiten { self.fixtures[f].interference } else { 0.0 };
            let of_wall = direction.map_or(0.0, |k| self.fixtures[f].walls[k]);
            into.residual[r] = into.rows.values()[r] - interference - of_wall;
        }
        into.said = walls.then(|| self.listen(f, into));
        if whiten && !walls {
            self.whiten(seen.len(), into);
        }
    }

    /// `∂ξ/∂ζ` of the tool's twist ξ in its own frame by fixture `f`'s parameters ζ; none if its place is known.
    ///
    /// `T_ft = T_bf⁻¹ T_bt`: moving the fixture by `Exp(ζ)` moves the tool by `−Ad(T_ft⁻¹) ζ`.
    fn fixture_motion(&self, f: usize, fixture_from_tool: &Pose) -> Option<Matrix6<f64>> {
        let moves = |k: &usize| matches!(self.system.parameters[*k].column, Column::Fixture(..));
        let motion = || -(se3::adjoint(&fixture_from_tool.inverse()) * self.fixtures[f].right_jacobian);
        self.system.seen[f].iter().any(moves).then(motion)
    }

    /// Adds to `gradient` the derivatives of a loss of the contacts `which`, all of one fixture, given by its derivative by their residuals.
    pub fn pull_back(&self, which: &[usize], cotangent: Cotangent<'_>, into: &mut ContactRows, gradient: &mut [f64]) {
        let Some(&first) = which.first() else { return };
        let contacts = &self.system.problem.contacts;
        let f = contacts.fixture(first);
        let manifold = &self.system.problem.fixtures[f].manifold;
        let poses: Vec<Pose> = which.iter().map(|&i| self.pose(i, &mut into.q)).collect();
        let mut twists = vec![Twist::zeros(); poses.len()];
        manifold.pull_back(&poses, self.system.resolution, cotangent, &mut twists);
        for ((&i, pose), twist) in which.iter().zip(&poses).zip(&twists) {
            self.locate(i, into);
            let fixture_motion = self.fixture_motion(f, pose);
            for &k in &self.system.seen[f] {
                let column = &self.system.parameters[k].column;
                gradient[k] += change(column, twist, fixture_motion.as_ref(), k, &into.scratch);
            }
        }
    }

    /// The tool's pose in the fixture that contact `i` touches; `q` is room for joint positions.
    pub(super) fn pose(&self, i: usize, q: &mut [f64]) -> Pose {
        let contacts = &self.system.problem.contacts;
        self.without_drift(i, q);
        self.fixtures[contacts.fixture(i)].fixture_from_base * self.kinematics.pose_under(q, &contacts.load(i))
    }

    /// The same pose, its derivatives left in `into`.
    pub(super) fn locate(&self, i: usize, into: &mut ContactRows) -> Pose {
        let contacts = &self.system.problem.contacts;
        self.without_drift(i, &mut into.q);
        let base_from_tool = self.kinematics.pose_and_jacobian_under(&into.q, &contacts.load(i), &mut into.scratch);
        self.fixtures[contacts.fixture(i)].fixture_from_base * base_from_tool
    }

    /// Joint positions of contact `i` as they would be without its placement's drift, left in `q`.
    fn without_drift(&self, i: usize, q: &mut [f64]) {
        let contacts = &self.system.problem.contacts;
        let (f, measured) = (contacts.fixture(i), contacts.q(i));
        let drift = &self.drift[self.system.placement[f] * measured.len()..];
        for (q, (measured, drift)) in q.iter_mut().zip(measured.iter().zip(drift)) {
            *q = measured - drift;
        }
    }

    /// The walls of contact `i` that are not free beyond doubt.
    fn find_walls(&self, i: usize, fixture_from_tool: &Pose, into: &mut ContactRows) {
        let f = self.system.problem.contacts.fixture(i);
        let variance = (self.system.noise_factor * self.system.wall_noise).powi(2);
        let mut covariance = Matrix6::zeros();
        for (joint, of_joint) in into.scratch.joints.iter().zip(&self.system.joint_variance) {
            covariance.ger(variance * of_joint, joint, joint, 1.0);
        }
        into.reach = Reach {
            covariance,
            own_variance: variance * self.system.problem.noise.contact.powi(2),
            interference: self.fixtures[f].interference,
            deviations: walls::REACH,
        };
        // Whatever a look that panicked left there will do.
        let mut recall = self.system.recalls[i].lock().unwrap_or_else(PoisonError::into_inner);
        self.system.problem.fixtures[f].manifold.walls(fixture_from_tool, &into.reach, &mut recall, &mut into.rows);
    }

    /// The region of fixture `f` that walls are of, and its number of surfaces.
    pub(super) fn region(&self, f: usize, walls: &Rows) -> (usize, usize) {
        let surfaces = self.system.odds[f].first().map_or(1, |odds| odds.another.len());
        (walls.surfaces().first().map_or(0, |surface| surface / surfaces), surfaces)
    }

    /// What the walls of fixture `f` in reach say.
    fn listen(&self, f: usize, into: &ContactRows) -> Said {
        let (region, _) = self.region(f, &into.rows);
        let odds = &self.system.odds[f][region];
        let (mut distances, mut another) = (Distances::zeros(), Distances::repeat(1.0));
        for (k, &surface) in into.rows.surfaces().iter().enumerate() {
            distances[k] = into.residual[k];
            another[k] = odds.another[surface % odds.another.len()];
        }
        let rows = into.rows.jacobian();
        let mut covariance = Square::identity();
        for (a, row_a) in rows.iter().enumerate() {
            let shaken = into.reach.covariance * row_a;
            for (b, row_b) in rows[..=a].iter().enumerate() {
                let own = if a == b { into.reach.own_variance } else { 0.0 };
                covariance[(a, b)] = row_b.dot(&shaken) + own;
                covariance[(b, a)] = covariance[(a, b)];
            }
        }
        walls::weigh(&Near {
            none: odds.none,
            count: into.len(),
            distances,
            covariance,
            another,
            by_odds: into.for_covariance,
        })
    }

    /// Covariance of a contact's rows, errors in variables: `N (J Σ_q Jᵀ) Nᵀ + σ_c² I`; encoder noise reaches the residual through the arm.
    fn covariance(&self, of: &ContactRows) -> Square {
        let rows = of.rows.jacobian();
        let mut covariance = Square::identity();
        for (a, row_a) in rows.iter().enumerate() {
            for (b, row_b) in rows[..=a].iter().enumerate() {
                covariance[(a, b)] = self.covariance_of((row_a, row_b), a == b, &of.scratch);
                covariance[(b, a)] = covariance[(a, b)];
            }
        }
        covariance
    }

    fn covariance_of(&self, (a, b): (&Twist, &Twist), own: bool, scratch: &Scratch) -> f64 {
        let joints = scratch.joints.iter().zip(&self.system.joint_variance);
        let encoder: f64 = joints.map(|(joint, variance)| a.dot(joint) * b.dot(joint) * variance).sum();
        let contact = if own { self.system.problem.noise.contact.powi(2) } else { 0.0 };
        self.system.noise_factor.powi(2) * (encoder + contact)
    }

    /// Divides rows by the Cholesky factor of their covariance.
    fn whiten(&self, width: usize, into: &mut ContactRows) {
        let len = into.rows.len();
        let mut covariance = self.covariance(into);
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
}

/// Number of the axis direction that a wall's normal is nearest to: +x, −x, +y, −y, +z, −z.
fn direction(normal: &Vector3<f64>) -> usize {
    2 * normal.iamax() + usize::from(normal[normal.iamax()] < 0.0)
}

/// Derivative by parameter `k` of what changes by `row · ξ` for a twist ξ of the tool in its own frame.
fn change(column: &Column, row: &Twist, fixture_motion: Option<&Matrix6<f64>>, k: usize, scratch: &Scratch) -> f64 {
    match *column {
        Column::Fixture(_, component) => fixture_motion.map_or(0.0, |motion| row.dot(&motion.column(component))),
        Column::JointDrift(_, joint) => -row.dot(&scratch.joints[joint]),
        Column::Interference(_) | Column::Wall(..) => 0.0,
        _ => row.dot(&scratch.columns[k]),
    }
}

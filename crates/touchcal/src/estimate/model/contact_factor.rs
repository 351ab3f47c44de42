//! The factor of one contact: its residual or likelihood, with derivatives by the parameters.

use nalgebra::Vector3;

use super::linearization::LinearizationPoint;
use super::objective::Objective;
use super::whitening::{pose_covariance, row_covariance, whiten};
use crate::estimate::contact_mode::{
    CandidateContacts, CandidateMatrix, CandidateVector, MarginalLikelihood, bearing, marginal_likelihood,
};
use crate::manifold::{ContactCache, Gate, MAX_ROWS, Residual};
use crate::parameter::ParameterId;
use crate::robot::KinematicsScratch;
use crate::se3::{self, Pose};

/// The factor of one contact, evaluated in place.
pub(crate) struct ContactFactor {
    q: Vec<f64>,
    kinematics: KinematicsScratch,
    rows: Residual,
    /// Derivatives of the rows, row by row, by the parameters that the contact depends on.
    jacobian: Vec<f64>,
    residual: [f64; MAX_ROWS],
    /// Standard deviation (m) of the first row before whitening.
    sigma: f64,
    likelihood: Option<MarginalLikelihood>,
    /// Index of each candidate's odds among those of its region.
    odds_indices: [usize; MAX_ROWS],
    /// Whether the surfaces of the candidate contacts can be distinguished.
    is_distinct: bool,
    /// Whether derivatives by the odds of contact modes are needed.
    with_odds_derivatives: bool,
}

impl ContactFactor {
    /// Scratch for the contacts of the model at `point`; `with_odds_derivatives` asks for
    /// derivatives by the odds of contact modes.
    pub fn new(point: &LinearizationPoint<'_>, with_odds_derivatives: bool) -> Self {
        ContactFactor {
            q: vec![0.0; point.dof()],
            kinematics: point.scratch(),
            rows: Residual::new(),
            jacobian: vec![0.0; MAX_ROWS * point.model.layout.len()],
            residual: [0.0; MAX_ROWS],
            sigma: 0.0,
            likelihood: None,
            odds_indices: [0; MAX_ROWS],
            is_distinct: true,
            with_odds_derivatives,
        }
    }

    /// Residual rows, whitened unless they are of candidate contacts.
    pub fn residual(&self) -> &[f64] {
        &self.residual[..self.rows.len()]
    }

    /// Derivatives of the residual rows by the parameters that the contact depends on, row by row,
    /// `width` columns.
    pub fn jacobian(&self, width: usize) -> &[f64] {
        &self.jacobian[..self.rows.len() * width]
    }

    /// Squared norm of the residual rows (1 if they are whitened).
    pub fn squared_norm(&self) -> f64 {
        self.residual().iter().map(|r| r * r).sum()
    }

    /// Standard deviation (m) of the first row before whitening.
    pub fn sigma(&self) -> f64 {
        self.sigma
    }

    /// The marginal likelihood of a one-sided contact, and its candidate contacts; `None` after the
    /// evaluation of a residual.
    pub fn likelihood(&self) -> Option<(&MarginalLikelihood, &Residual)> {
        self.likelihood.as_ref().map(|likelihood| (likelihood, &self.rows))
    }

    /// Index of each candidate's odds among those of its region.
    pub fn odds_indices(&self) -> &[usize] {
        &self.odds_indices[..self.rows.len()]
    }

    /// Whether the surfaces of the candidate contacts that were evaluated can be distinguished.
    pub fn is_distinct(&self) -> bool {
        self.is_distinct
    }

    /// Scratch for joint positions (rad, or m for a prismatic joint).
    pub fn joint_positions(&mut self) -> &mut [f64] {
        &mut self.q
    }

    /// Evaluates the residual of contact `i` for an envelope or residual objective.
    pub fn evaluate(&mut self, point: &LinearizationPoint<'_>, i: usize, objective: Objective) {
        let f = point.model.problem.contacts.fixture(i);
        let pose = point.pose_and_jacobian(i, &mut self.q, &mut self.kinematics);
        residual_rows(point, f, std::slice::from_ref(&pose), objective, std::slice::from_mut(&mut self.rows));
        self.finish_residual(point, i, &pose, objective);
    }

    /// Evaluates the residual of contact `i` from the manifold's `rows` at its pose, see
    /// [`residual_rows`].
    pub fn evaluate_rows(&mut self, point: &LinearizationPoint<'_>, i: usize, objective: Objective, rows: Residual) {
        let pose = point.pose_and_jacobian(i, &mut self.q, &mut self.kinematics);
        self.rows = rows;
        self.finish_residual(point, i, &pose, objective);
    }

    fn finish_residual(&mut self, point: &LinearizationPoint<'_>, i: usize, pose: &Pose, objective: Objective) {
        let f = point.model.problem.contacts.fixture(i);
        let is_whitened = objective != Objective::Envelope;
        let bias_derivative = if is_whitened { -1.0 } else { 0.0 };
        let bias = if is_whitened { point.fixtures[f].gap_bias } else { 0.0 };
        self.differentiate(point, i, pose, |id, _| match id {
            ParameterId::GapBias(_) => Some(bias_derivative),
            _ => None,
        });
        for (residual, value) in self.residual.iter_mut().zip(self.rows.values()) {
            *residual = value - bias;
        }
        self.likelihood = None;
        if is_whitened {
            let (len, width) = (self.rows.len(), point.model.layout.dependencies[f].len());
            let covariance = self.residual_noise(point);
            let (residual, jacobian) = (&mut self.residual[..len], &mut self.jacobian[..len * width]);
            self.sigma = whiten(covariance, residual, jacobian, width);
        }
    }

    /// Evaluates the exact residual of contact `i` with all its gap biases, not whitened (m), and
    /// returns the covariance of its rows by noise (m²).
    pub fn evaluate_with_noise(&mut self, point: &LinearizationPoint<'_>, i: usize) -> CandidateMatrix {
        let f = point.model.problem.contacts.fixture(i);
        let pose = point.pose_and_jacobian(i, &mut self.q, &mut self.kinematics);
        self.rows.clear();
        point.model.problem.fixtures[f].manifold.residual(&pose, 0.0, &mut self.rows);
        self.subtract_gap_biases(point, i, &pose);
        self.likelihood = None;
        self.residual_noise(point)
    }

    /// Covariance of the residual rows by noise (m²).
    fn residual_noise(&self, point: &LinearizationPoint<'_>) -> CandidateMatrix {
        let noise = &point.model.noise;
        let variance_factor = noise.residual_variance_factor();
        let of_pose = pose_covariance(&self.kinematics.joints, &noise.joint_variance, variance_factor);
        row_covariance(self.rows.jacobian(), &of_pose, variance_factor * noise.contact.powi(2))
    }

    /// Evaluates the marginal likelihood of contact `i`, which is one-sided; `cache` is that of the
    /// contact.
    pub fn evaluate_modes(&mut self, point: &LinearizationPoint<'_>, i: usize, cache: &mut ContactCache) {
        let candidates = self.evaluate_candidates(point, i, cache);
        let options = &point.model.problem.options.contact_mode;
        self.likelihood = Some(marginal_likelihood(&candidates, options));
    }

    /// Evaluates the candidate contacts of contact `i`, which is one-sided; `cache` is that of the
    /// contact. The rows are their distances, and [`gaps`](ContactFactor::gaps) those with their
    /// gap biases.
    pub fn evaluate_candidates(
        &mut self,
        point: &LinearizationPoint<'_>,
        i: usize,
        cache: &mut ContactCache,
    ) -> CandidateContacts {
        let model = point.model;
        let f = model.problem.contacts.fixture(i);
        let pose = point.pose_and_jacobian(i, &mut self.q, &mut self.kinematics);
        let (noise, variance_factor) = (&model.noise, model.noise.mode_variance_factor());
        let gate = Gate {
            covariance: pose_covariance(&self.kinematics.joints, &noise.joint_variance, variance_factor),
            own_variance: variance_factor * noise.contact.powi(2),
            gap_bias: point.fixtures[f].gap_bias,
            deviations: model.problem.options.contact_mode.gate,
        };
        self.rows.clear();
        let manifold = &model.problem.fixtures[f].manifold;
        self.is_distinct = manifold.candidate_contacts(&pose, &gate, cache, &mut self.rows);
        self.subtract_gap_biases(point, i, &pose);
        self.likelihood = None;
        self.candidates(point, i, &gate)
    }

    /// Distances (m) of the rows as the manifold has them, with their gap biases.
    pub fn gaps(&self) -> &[f64] {
        self.rows.values()
    }

    /// Residuals and derivatives of rows with the gap biases of their directions.
    fn subtract_gap_biases(&mut self, point: &LinearizationPoint<'_>, i: usize, fixture_from_tool: &Pose) {
        let fixture = &point.fixtures[point.model.problem.contacts.fixture(i)];
        let directions: [usize; MAX_ROWS] = std::array::from_fn(|r| {
            let normal = |row| fixture_from_tool.rotation * se3::linear(row);
            self.rows.jacobian().get(r).map_or(0, |row| axis_direction(&normal(row)))
        });
        self.differentiate(point, i, fixture_from_tool, |id, r| match id {
            ParameterId::GapBias(_) => Some(-1.0),
            ParameterId::DirectionalGapBias(_, k) => Some(-f64::from(u8::from(directions[r] == k))),
            _ => None,
        });
        for (r, value) in self.rows.values().iter().enumerate() {
            self.residual[r] = value - fixture.gap_bias - fixture.directional_gap_bias[directions[r]];
        }
    }

    fn candidates(&mut self, point: &LinearizationPoint<'_>, i: usize, gate: &Gate) -> CandidateContacts {
        let (model, f) = (point.model, point.model.problem.contacts.fixture(i));
        let prior = &model.mode_priors[f][model.region(f, &self.rows)];
        let bears = if model.has_bearing_odds(i) {
            bearing(&point.load_on_tool(i), self.rows.jacobian())
        } else {
            [false; MAX_ROWS]
        };
        let (mut distances, mut odds) = (CandidateVector::zeros(), CandidateVector::repeat(1.0));
        for (k, &surface) in self.rows.surfaces().iter().enumerate() {
            self.odds_indices[k] = model.odds_index(i, surface, bears[k]);
            distances[k] = self.residual[k];
            odds[k] = prior.odds[self.odds_indices[k]];
        }
        CandidateContacts {
            count: self.rows.len(),
            distances,
            covariance: row_covariance(self.rows.jacobian(), &gate.covariance, gate.own_variance),
            odds,
            no_contact: prior.no_contact,
            with_odds_derivatives: self.with_odds_derivatives,
        }
    }

    /// Derivatives of the rows of contact `i` by all parameters that it depends on;
    /// `of_bias(id, row)` for those that the pose does not depend on.
    fn differentiate(
        &mut self,
        point: &LinearizationPoint<'_>,
        i: usize,
        fixture_from_tool: &Pose,
        of_bias: impl Fn(ParameterId, usize) -> Option<f64>,
    ) {
        let (layout, f) = (&point.model.layout, point.model.problem.contacts.fixture(i));
        let dependencies = &layout.dependencies[f];
        let fixture_motion = point.fixture_motion(f, fixture_from_tool);
        let (rows, width) = (self.rows.jacobian(), dependencies.len());
        for (column, &k) in dependencies.iter().enumerate() {
            let id = layout.parameters[k].id;
            let motion = point.tool_motion((k, i), fixture_motion.as_ref(), &self.kinematics);
            for (r, row) in rows.iter().enumerate() {
                self.jacobian[r * width + column] = of_bias(id, r).unwrap_or_else(|| row.dot(&motion));
            }
        }
    }
}

/// The rows of fixture `f`'s manifold at poses of contacts with it, written to `rows`, for an
/// envelope or residual objective.
pub(crate) fn residual_rows(
    point: &LinearizationPoint<'_>,
    f: usize,
    fixture_from_tool: &[Pose],
    objective: Objective,
    rows: &mut [Residual],
) {
    let manifold = &point.model.problem.fixtures[f].manifold;
    match objective {
        Objective::Residual(_) | Objective::ContactModes => {
            manifold.residuals(fixture_from_tool, point.model.noise.resolution, rows);
        }
        Objective::Envelope => fixture_from_tool.iter().zip(rows).for_each(|(pose, rows)| {
            rows.clear();
            manifold.envelope(pose, rows);
        }),
    }
}

/// Number of the axis direction that a normal is nearest to: +x, −x, +y, −y, +z, −z.
fn axis_direction(normal: &Vector3<f64>) -> usize {
    2 * normal.iamax() + usize::from(normal[normal.iamax()] < 0.0)
}

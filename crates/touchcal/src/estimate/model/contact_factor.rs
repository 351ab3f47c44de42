//! The factor of one contact: its residual or likelihood, with derivatives by the parameters.

use nalgebra::{Matrix6, Vector3};

use super::deflection_by_load::deflection_by_load;
use super::linearization::LinearizationPoint;
use super::objective::Objective;
use super::residual_rows::residual_rows;
use super::row_biases::RowBiases;
use super::whitening::{pose_covariance, row_covariance, whiten};
use crate::estimate::contact_mode::{
    CandidateContacts, CandidateMatrix, CandidateVector, MarginalLikelihood, bearing, marginal_likelihood,
};
use crate::manifold::{ContactCache, Gate, MAX_ROWS, Residual};
use crate::parameter::ParameterId;
use crate::robot::KinematicsScratch;
use crate::se3::{self, Pose, Twist};

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
    /// What noise of the load adds to the derivatives of the likelihood, and to its cost.
    load_noise_score: Vec<f64>,
    load_noise_cost: f64,
    /// Index of the contact mode prior of the candidates, see
    /// [`region`](CalibrationModel::region), and of each one's odds in it.
    region: usize,
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
            load_noise_score: vec![0.0; point.model.layout.len()],
            load_noise_cost: 0.0,
            region: 0,
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

    /// The marginal likelihood of a one-sided contact; `None` after the evaluation of a residual.
    pub fn likelihood(&self) -> Option<&MarginalLikelihood> {
        self.likelihood.as_ref()
    }

    /// What noise of the load adds on average to the derivative of `−ln L` of the
    /// [`likelihood`](ContactFactor::likelihood) by each of the `width` parameters that the contact
    /// depends on, to be subtracted.
    ///
    /// A joint's compliance moves the distances by `G J τ`, with the gradients `G` of the
    /// distances and the joint's motion `J`. Noise `n` of the load is in the torque `τ`, as
    /// `tᵀ n`, and in the distances, as `G M n`. With the covariance `Σ` of the noise and the
    /// information `W` on the distances the mean is `(G J)ᵀ W G M Σ t`. Noisy loads would
    /// make joints seem stiffer than they are. The error of scale `s` moves the distances by
    /// `−G M w / (1 + s)`, for which the mean is `−tr(W G M Σ Mᵀ Gᵀ) / (1 + s)`.
    ///
    /// Source: Nakamura, *Corrected score function for errors-in-variables models* (1990).
    pub fn load_noise_score(&self, width: usize) -> &[f64] {
        &self.load_noise_score[..width]
    }

    /// What noise of the load adds to `−ln L` on average, to be subtracted:
    /// `½ tr(W G M Σ Mᵀ Gᵀ)`, whose derivatives are
    /// [`load_noise_score`](ContactFactor::load_noise_score).
    pub fn load_noise_cost(&self) -> f64 {
        self.load_noise_cost
    }

    /// Index of the contact mode prior of the candidates among those of their fixture.
    pub fn region(&self) -> usize {
        self.region
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
            let covariance = self.residual_noise(point, i);
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
        self.subtract_biases(point, i, &pose);
        self.likelihood = None;
        self.residual_noise(point, i)
    }

    /// Covariance of the residual rows of contact `i` by noise (m²).
    fn residual_noise(&self, point: &LinearizationPoint<'_>, i: usize) -> CandidateMatrix {
        let variance_factor = point.model.noise.residual_variance_factor();
        let of_pose = self.pose_covariance(point, i, variance_factor);
        row_covariance(self.rows.jacobian(), &of_pose, variance_factor * point.model.noise.contact.powi(2))
    }

    /// Covariance of the pose of contact `i` by noise of encoders, with variances multiplied by
    /// `variance_factor`, and of the load (right twist, m and rad).
    fn pose_covariance(&self, point: &LinearizationPoint<'_>, i: usize, variance_factor: f64) -> Matrix6<f64> {
        let KinematicsScratch { joints, load, .. } = &self.kinematics;
        let of_encoders = pose_covariance(joints, &point.model.noise.joint_variance, variance_factor);
        let variance = point.load_variance(i);
        if variance == Twist::zeros() {
            return of_encoders;
        }
        of_encoders + load * Matrix6::from_diagonal(&variance) * load.transpose()
    }

    /// Evaluates the marginal likelihood of contact `i`, which is one-sided; `cache` is that of the
    /// contact.
    pub fn evaluate_modes(&mut self, point: &LinearizationPoint<'_>, i: usize, cache: &mut ContactCache) {
        let candidates = self.evaluate_bearing(point, i, cache);
        let likelihood = marginal_likelihood(&candidates, &point.model.problem.options.contact_mode);
        self.find_load_noise_score(point, i, &likelihood.observed_information);
        self.likelihood = Some(likelihood);
    }

    /// Writes [`load_noise_score`](ContactFactor::load_noise_score) and
    /// [`load_noise_cost`](ContactFactor::load_noise_cost) of contact `i`.
    fn find_load_noise_score(&mut self, point: &LinearizationPoint<'_>, i: usize, information: &CandidateMatrix) {
        let (layout, contacts) = (&point.model.layout, &point.model.problem.contacts);
        let variance = point.load_variance(i);
        let (kinematics, gradients) = (&self.kinematics, self.rows.jacobian());
        // Mean product of the noise of distances with that of their derivative, `motion · tᵀ n`.
        let mean = |motion: &Twist, torque_by_load: &Twist| {
            let noise = kinematics.load * variance.component_mul(torque_by_load);
            distances_by(gradients, motion).dot(&(information * distances_by(gradients, &noise)))
        };
        let is_exact = variance == Twist::zeros();
        let of_component = |k: usize| mean(&kinematics.load.column(k).into_owned(), &Twist::ith(k, 1.0));
        let of_load: f64 = if is_exact { 0.0 } else { (0..6).map(of_component).sum() };
        let scores = layout.dependencies[contacts.fixture(i)].iter().map(|&k| match layout.parameters[k].id {
            _ if is_exact => 0.0,
            ParameterId::WrenchScale => -of_load / (1.0 + point.wrench_scale()),
            id => deflection_by_load(kinematics, id)
                .map_or(0.0, |(joint, by_load)| mean(&kinematics.joints[joint], &by_load)),
        });
        self.load_noise_score.iter_mut().zip(scores).for_each(|(score, of_noise)| *score = of_noise);
        self.load_noise_cost = 0.5 * of_load;
    }

    /// Visits the derivatives `(G Jₖ)ᵀ W (G Jₗ) · tₖᵀ Σ tₗ` of
    /// [`load_noise_score`](ContactFactor::load_noise_score) by the compliances `l` after `k`, both
    /// of the layout, where the last evaluation was of the likelihood of contact `i`.
    pub fn visit_load_noise_information(
        &self,
        point: &LinearizationPoint<'_>,
        i: usize,
        mut visit: impl FnMut((usize, usize), f64),
    ) {
        let (Some(likelihood), variance) = (&self.likelihood, point.load_variance(i)) else { return };
        if variance == Twist::zeros() {
            return;
        }
        let (layout, gradients) = (&point.model.layout, self.rows.jacobian());
        let dependencies = &layout.dependencies[point.model.problem.contacts.fixture(i)];
        let compliances = dependencies.iter().filter_map(|&k| {
            let (joint, by_load) = deflection_by_load(&self.kinematics, layout.parameters[k].id)?;
            Some((k, distances_by(gradients, &self.kinematics.joints[joint]), by_load))
        });
        let compliances: Vec<_> = compliances.collect();
        for (first, (k, distances, torque)) in compliances.iter().enumerate() {
            let weighted = likelihood.observed_information * distances;
            for (l, other, by_load) in &compliances[first..] {
                visit((*k, *l), weighted.dot(other) * torque.dot(&variance.component_mul(by_load)));
            }
        }
    }

    /// Evaluates all candidate contacts of contact `i`, which is one-sided; `cache` is that of the
    /// contact. The rows are their distances, and [`gaps`](ContactFactor::gaps) those with their
    /// gap biases.
    pub fn evaluate_candidates(
        &mut self,
        point: &LinearizationPoint<'_>,
        i: usize,
        cache: &mut ContactCache,
    ) -> CandidateContacts {
        let (pose, gate) = self.find_candidates(point, i, cache);
        self.candidates(point, i, (&pose, &gate))
    }

    /// As `evaluate_candidates`, with only the candidates that bear the load where it is known.
    pub fn evaluate_bearing(
        &mut self,
        point: &LinearizationPoint<'_>,
        i: usize,
        cache: &mut ContactCache,
    ) -> CandidateContacts {
        let (pose, gate) = self.find_candidates(point, i, cache);
        match point.model.fixed_modes.get(i) {
            _ if !point.model.has_load(i) => {}
            Some(fixed) => self.rows.retain(|_, row| fixed.is_bearing(&se3::linear(row))),
            None => {
                let mut bears = bearing(&point.load_on_tool(i), self.rows.jacobian()).into_iter();
                self.rows.retain(|_, _| bears.next() == Some(true));
            }
        }
        self.candidates(point, i, (&pose, &gate))
    }

    /// Normals (tool frame) of the candidates that bear the load of contact `i`.
    pub fn bearing_normals(&self, point: &LinearizationPoint<'_>, i: usize) -> impl Iterator<Item = Vector3<f64>> {
        let bears = bearing(&point.load_on_tool(i), self.rows.jacobian());
        self.rows.jacobian().iter().zip(bears).filter(|(_, bears)| *bears).map(|(row, _)| se3::linear(row))
    }

    /// The rows of the candidates of contact `i`, with its pose and their gate.
    fn find_candidates(&mut self, point: &LinearizationPoint<'_>, i: usize, cache: &mut ContactCache) -> (Pose, Gate) {
        let model = point.model;
        let f = model.problem.contacts.fixture(i);
        let pose = point.pose_and_jacobian(i, &mut self.q, &mut self.kinematics);
        let variance_factor = model.noise.mode_variance_factor();
        let gate = Gate {
            covariance: self.pose_covariance(point, i, variance_factor),
            own_variance: variance_factor * model.noise.contact.powi(2),
            gap_biases: point.fixtures[f].gap_biases(),
            deviations: model.problem.options.contact_mode.gate,
        };
        self.rows.clear();
        let manifold = &model.problem.fixtures[f].manifold;
        let fixed = model.fixed_modes.get(i).and_then(|fixed| fixed.is_distinct);
        self.is_distinct = fixed.unwrap_or_else(|| manifold.has_distinct_surfaces(&pose));
        if self.is_distinct {
            manifold.candidate_contacts(&pose, &gate, cache, &mut self.rows);
        }
        (pose, gate)
    }

    /// Distances (m) of the rows as the manifold has them, with their gap biases.
    pub fn gaps(&self) -> &[f64] {
        self.rows.values()
    }

    /// Residuals of rows with their gap biases, and derivatives.
    fn subtract_biases(&mut self, point: &LinearizationPoint<'_>, i: usize, fixture_from_tool: &Pose) {
        let f = point.model.problem.contacts.fixture(i);
        let manifold = point.model.problem.fixtures[f].manifold.as_ref();
        let biases = RowBiases::new(&self.rows, fixture_from_tool, (&point.fixtures[f], manifold));
        self.differentiate(point, i, fixture_from_tool, |id, r| biases.derivative(id, r));
        for (r, gap) in self.rows.values().iter().enumerate() {
            self.residual[r] = gap - biases.bias(r);
        }
    }

    /// The candidates in the rows, with all that depends on them.
    fn candidates(
        &mut self,
        point: &LinearizationPoint<'_>,
        i: usize,
        (pose, gate): (&Pose, &Gate),
    ) -> CandidateContacts {
        self.subtract_biases(point, i, pose);
        self.likelihood = None;
        let (model, f) = (point.model, point.model.problem.contacts.fixture(i));
        self.region = model.region(i, &self.rows);
        let prior = &model.mode_priors[f][self.region];
        let (mut distances, mut odds) = (CandidateVector::zeros(), CandidateVector::repeat(1.0));
        for (k, &surface) in self.rows.surfaces().iter().enumerate() {
            self.odds_indices[k] = model.odds_index(f, surface);
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
        let fixture_motion = point.fixture_motion(i, fixture_from_tool);
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

/// Derivatives of the distances with these `gradients` by a `motion` of the tool.
fn distances_by(gradients: &[Twist], motion: &Twist) -> CandidateVector {
    CandidateVector::from_fn(|r, _| gradients.get(r).map_or(0.0, |row| row.dot(motion)))
}

//! Poses at given parameters, and their derivatives.

use nalgebra::{DVector, Matrix6, Vector3};

use super::calibration_model::CalibrationModel;
use super::trend_axis::position_in_log;
use crate::estimate::problem::WrenchTolerance;
use crate::manifold::{AXIS_DIRECTIONS, Residual};
use crate::parameter::ParameterId;
use crate::robot::{EncoderTerm, Kinematics, KinematicsScratch, subtract_encoder_errors};
use crate::se3::{self, Pose, Twist, Wrench};

/// A model at given parameters.
pub(crate) struct LinearizationPoint<'m> {
    pub model: &'m CalibrationModel<'m>,
    kinematics: Kinematics,
    /// State of each fixture at these parameters.
    pub fixtures: Vec<FixtureState>,
    /// Drift of each joint in each placement (rad), one placement after the other.
    drift: Vec<f64>,
    /// Trend of each joint (rad, or m for a prismatic joint).
    trend: Vec<f64>,
    /// Joint, number of half-waves over the log, and amplitude (rad) of each cosine in an encoder's
    /// offset.
    walk: Vec<(usize, usize, f64)>,
    /// Joint, and amplitude (rad) of a term of its encoder's error.
    encoder_errors: Vec<(usize, EncoderTerm, f64)>,
    /// Bias (N, N m) of the measured wrench, and relative error of its scale (1).
    wrench_bias: Wrench,
    wrench_scale: f64,
    /// Whether the measured wrench has parameters, or noise.
    has_wrench_errors: bool,
}

/// A fixture at given parameters.
pub(crate) struct FixtureState {
    fixture_from_base: Pose,
    /// Pose in base (m).
    pub base_from_fixture: Pose,
    /// `Jr` of the twist on the fixture's pose (6×6).
    pub right_jacobian: Matrix6<f64>,
    /// Gap bias (m) common to all directions.
    pub gap_bias: f64,
    /// Gap bias (m) on top of `gap_bias` for contact normals nearest to +x, −x, +y, −y, +z and −z.
    pub directional_gap_bias: [f64; AXIS_DIRECTIONS],
    /// Whether the model has the radius of edges behind its parameters, as an error of value zero.
    pub has_edge_radius: bool,
}

impl FixtureState {
    /// Gap bias (m) for each [`axis_direction`](crate::manifold::axis_direction) of a normal.
    pub fn gap_biases(&self) -> [f64; AXIS_DIRECTIONS] {
        self.directional_gap_bias.map(|of_direction| self.gap_bias + of_direction)
    }
}

impl<'m> LinearizationPoint<'m> {
    /// At parameters `theta` (SI), in the order of the model's layout, that of
    /// [`Estimate::parameters`](crate::estimate::Estimate::parameters), and as many. Entries beyond
    /// them are ignored; those that are missing count as 0.
    pub fn new(model: &'m CalibrationModel<'m>, theta: &DVector<f64>) -> Self {
        let mut kinematics = model.kinematics.clone();
        let mut kinematic_values = Vec::new();
        let mut twists = vec![Twist::zeros(); model.base_from_fixture.len()];
        let mut biases = vec![(0.0, [0.0; AXIS_DIRECTIONS], false); model.base_from_fixture.len()];
        let dof = kinematics.dof();
        let placements = 1 + model.layout.placement.iter().max().copied().unwrap_or(0);
        let (mut drift, mut trend) = (vec![0.0; dof * placements], vec![0.0; dof]);
        let (mut walk, mut encoder_errors) = (Vec::new(), Vec::new());
        let (mut wrench_bias, mut wrench_scale) = ([0.0; 6], 0.0);
        for (parameter, &value) in model.layout.parameters.iter().zip(theta.iter()) {
            match parameter.id {
                ParameterId::Kinematic(_) => kinematic_values.push(value),
                ParameterId::JointDrift(placement, i) => drift[placement * dof + i] = value,
                ParameterId::JointTrend(i) => trend[i] = value,
                ParameterId::JointWalk(i, k) if value != 0.0 => walk.push((i, k, value)),
                ParameterId::JointWalk(..) => {}
                ParameterId::EncoderError(i, term) if value != 0.0 => encoder_errors.push((i, term, value)),
                ParameterId::EncoderError(..) => {}
                ParameterId::Fixture(f, k) => twists[f][k] = value,
                ParameterId::GapBias(f) => biases[f].0 = value,
                ParameterId::DirectionalGapBias(f, k) => biases[f].1[k] = value,
                ParameterId::EdgeRadius(f) => biases[f].2 = true,
                ParameterId::WrenchBias(k) => wrench_bias[k] = value,
                ParameterId::WrenchScale => wrench_scale = value,
                // A factor of its own, see `add_distances`.
                ParameterId::Distance(_) => {}
            }
        }
        kinematics.set(&kinematic_values);
        let fixtures = model.base_from_fixture.iter().zip(twists).zip(biases);
        let fixtures = fixtures.map(|((nominal, twist), (gap_bias, directional_gap_bias, has_edge_radius))| {
            let base_from_fixture = nominal * se3::exp(&twist);
            FixtureState {
                fixture_from_base: base_from_fixture.inverse(),
                base_from_fixture,
                right_jacobian: se3::right_jacobian(&twist),
                gap_bias,
                directional_gap_bias,
                has_edge_radius,
            }
        });
        let WrenchTolerance { force_noise, torque_noise, .. } = model.problem.wrench;
        let has_noise = model.problem.deflects_under_loads() && (force_noise > 0.0 || torque_noise > 0.0);
        LinearizationPoint {
            model,
            kinematics,
            fixtures: fixtures.collect(),
            drift,
            trend,
            walk,
            encoder_errors,
            wrench_bias,
            wrench_scale,
            has_wrench_errors: has_noise || model.layout.has_wrench(),
        }
    }

    /// Number of moving joints.
    pub fn dof(&self) -> usize {
        self.kinematics.dof()
    }

    /// Scratch for [`LinearizationPoint::pose_and_jacobian`].
    pub fn scratch(&self) -> KinematicsScratch {
        self.kinematics.scratch()
    }

    /// `base_from_tool` of contact `i` without the errors of encoders and wrench that are of one
    /// log alone.
    pub fn base_from_tool(&self, i: usize) -> Pose {
        let contacts = &self.model.problem.contacts;
        let load = contacts.load(i);
        let on_joints = contacts.load_on_joints(i, &load);
        if self.encoder_errors.is_empty() {
            return self.kinematics.pose_under(contacts.q(i), on_joints);
        }
        let mut q = contacts.q(i).to_vec();
        subtract_encoder_errors(&self.encoder_errors, contacts.q(i), &mut q);
        self.kinematics.pose_under(&q, on_joints)
    }

    /// Pose of the tool relative to what contact `i` touches, its target or else the fixture,
    /// without the errors of encoders and wrench that are of one log alone.
    pub fn pose_without_drift(&self, i: usize) -> Pose {
        self.touched_from_tool(i, self.base_from_tool(i))
    }

    /// Pose of the tool relative to what contact `i` touches, its target or else the fixture; `q`
    /// is scratch for joint positions.
    pub fn pose(&self, i: usize, q: &mut [f64]) -> Pose {
        self.correct(i, q);
        let contacts = &self.model.problem.contacts;
        self.touched_from_tool(i, self.kinematics.pose_under(q, contacts.load_on_joints(i, &self.load(i))))
    }

    /// The same of a pose `base_from_tool` in contact `i`.
    fn touched_from_tool(&self, i: usize, base_from_tool: Pose) -> Pose {
        let contacts = &self.model.problem.contacts;
        let fixture_from_tool = self.fixtures[contacts.fixture(i)].fixture_from_base * base_from_tool;
        contacts.target(i).map_or(fixture_from_tool, |target| target.inv_mul(&fixture_from_tool))
    }

    /// As [`pose`](LinearizationPoint::pose), with the derivatives of the tool pose written to
    /// `scratch`; `q` is scratch for joint positions.
    pub fn pose_and_jacobian(&self, i: usize, q: &mut [f64], scratch: &mut KinematicsScratch) -> Pose {
        let contacts = &self.model.problem.contacts;
        self.correct(i, q);
        let base_from_tool =
            self.kinematics.pose_and_jacobian_under(q, contacts.load_on_joints(i, &self.load(i)), scratch);
        if self.has_wrench_errors {
            match contacts.known_load(i) {
                Some(_) => self.kinematics.differentiate_by_load(scratch),
                None => scratch.load.fill(0.0),
            }
        }
        self.touched_from_tool(i, base_from_tool)
    }

    /// Writes the joint positions of contact `i` less drift, trend, walk and errors of the
    /// encoders to `q`.
    pub fn correct(&self, i: usize, q: &mut [f64]) {
        let contacts = &self.model.problem.contacts;
        let (f, measured) = (contacts.fixture(i), contacts.q(i));
        let drift = &self.drift[self.model.layout.placement[f] * measured.len()..];
        let position = self.trend_position(i);
        for (joint, (q, &measured)) in q.iter_mut().zip(measured).enumerate() {
            *q = measured - drift[joint] - self.trend[joint] * position;
        }
        subtract_encoder_errors(&self.encoder_errors, measured, q);
        self.walk.iter().for_each(|&(joint, k, amplitude)| q[joint] -= amplitude * self.half_waves(k, i));
    }

    /// Load of contact `i` (N, N m): the measured one less its bias, over its scale; zero where
    /// none is known.
    fn load(&self, i: usize) -> Wrench {
        let measured = self.model.problem.contacts.known_load(i);
        let actual =
            |measured: Wrench| std::array::from_fn(|k| (measured[k] - self.wrench_bias[k]) / (1.0 + self.wrench_scale));
        measured.map_or([0.0; 6], actual)
    }

    /// Relative error of the measured wrench's scale (1).
    pub fn wrench_scale(&self) -> f64 {
        self.wrench_scale
    }

    /// Variances (N², N² m²) of the noise of contact `i`'s load; zero where none is known.
    pub fn load_variance(&self, i: usize) -> Twist {
        let (contacts, wrench) = (&self.model.problem.contacts, &self.model.problem.wrench);
        if !self.has_wrench_errors || contacts.known_load(i).is_none() {
            return Twist::zeros();
        }
        let factor = contacts.load_noise_factor(i) / (1.0 + self.wrench_scale).powi(2);
        let (force, torque) = (factor * wrench.force_noise.powi(2), factor * wrench.torque_noise.powi(2));
        Twist::new(force, force, force, torque, torque, torque)
    }

    /// Load of contact `i` (N, N m) in the nominal tool frame about its origin; zero where none is
    /// known.
    pub fn load_on_tool(&self, i: usize) -> Twist {
        let tip_from_tool = &self.model.problem.tool.tip_from_tool;
        se3::adjoint(tip_from_tool).tr_mul(&Twist::from(self.load(i)))
    }

    /// Position of contact `i` on the axis of the trends, −1 to 1.
    fn trend_position(&self, i: usize) -> f64 {
        self.model.trend_axis.position(&self.model.problem.contacts, i)
    }

    /// Cosine with `k` half-waves over the log at contact `i`.
    fn half_waves(&self, k: usize, i: usize) -> f64 {
        (0.5 * std::f64::consts::PI * k as f64 * (position_in_log(&self.model.problem.contacts, i) + 1.0)).cos()
    }

    /// `∂ξ/∂ζ` of the tool's twist ξ in its own frame by the twist ζ on the pose of the fixture of
    /// contact `i`, with the tool at this [`pose`](LinearizationPoint::pose); none if that pose is
    /// fixed.
    ///
    /// `T_ft = T_bf⁻¹ T_bt`: moving the fixture by `Exp(ζ)` moves the tool by `−Ad(T_ft⁻¹) ζ`.
    pub fn fixture_motion(&self, i: usize, touched_from_tool: &Pose) -> Option<Matrix6<f64>> {
        let contacts = &self.model.problem.contacts;
        let f = contacts.fixture(i);
        let fixture_from_tool = contacts.target(i).map_or(*touched_from_tool, |target| target * touched_from_tool);
        let is_pose = |k: &usize| matches!(self.model.layout.parameters[*k].id, ParameterId::Fixture(..));
        let motion = || -(se3::adjoint(&fixture_from_tool.inverse()) * self.fixtures[f].right_jacobian);
        self.model.layout.dependencies[f].iter().any(is_pose).then(motion)
    }

    /// `∂ξ/∂θₖ` of the tool's twist ξ in its own frame, in contact `i`, by parameter `k`, given
    /// [`fixture_motion`](LinearizationPoint::fixture_motion).
    pub fn tool_motion(
        &self,
        (k, i): (usize, usize),
        fixture_motion: Option<&Matrix6<f64>>,
        scratch: &KinematicsScratch,
    ) -> Twist {
        match self.model.layout.parameters[k].id {
            ParameterId::Kinematic(_) => scratch.parameters[self.model.layout.kinematic_index[k]],
            ParameterId::Fixture(_, component) => {
                fixture_motion.map_or_else(Twist::zeros, |motion| motion.column(component).into_owned())
            }
            ParameterId::JointDrift(_, joint) => -scratch.joints[joint],
            ParameterId::JointTrend(joint) => scratch.joints[joint] * -self.trend_position(i),
            ParameterId::JointWalk(joint, k) => scratch.joints[joint] * -self.half_waves(k, i),
            ParameterId::EncoderError(joint, term) => {
                scratch.joints[joint] * -term.error(self.model.problem.contacts.q(i)[joint])
            }
            ParameterId::GapBias(_) | ParameterId::DirectionalGapBias(..) => Twist::zeros(),
            ParameterId::EdgeRadius(_) | ParameterId::Distance(_) => Twist::zeros(),
            ParameterId::WrenchBias(k) => scratch.load.column(k) / -(1.0 + self.wrench_scale),
            ParameterId::WrenchScale => scratch.load * Twist::from(self.load(i)) / -(1.0 + self.wrench_scale),
        }
    }

    /// Exact residual of contact `i` (m), at most three rows of it, without drift; `rows` is
    /// scratch.
    pub fn residual_vector(&self, i: usize, rows: &mut Residual) -> Vector3<f64> {
        let f = self.model.problem.contacts.fixture(i);
        rows.clear();
        self.model.problem.fixtures[f].manifold.residual(&self.pose_without_drift(i), 0.0, rows);
        let value = |k: usize| rows.values().get(k).copied().unwrap_or(0.0);
        Vector3::new(value(0), value(1), value(2))
    }
}

#[cfg(test)]
mod tests;

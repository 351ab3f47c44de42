//! Where a compliant peg comes to rest against stiff parts.

use nalgebra::{Cholesky, Matrix6, Vector6};

use crate::geometry::extrusion::PegAndHole;
use crate::se3::{self, Pose, Twist};

/// Stiffness of the controlled arm and of the contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Compliance {
    /// Translational stiffness of the controller (N/m).
    pub translation: f64,
    /// Rotational stiffness of the controller (Nm/rad).
    pub rotation: f64,
    /// Stiffness of each contact (N/m): force over penetration.
    pub contact: f64,
}

/// Gauss–Newton steps: a warm start needs three to six.
const STEPS: usize = 60;
/// Contacts that a step may open: features within this of touching take part in the search (m).
const NEAR: f64 = 0.2e-3;

impl Compliance {
    fn stiffness(&self) -> Matrix6<f64> {
        let (t, r) = (self.translation, self.rotation);
        Matrix6::from_diagonal(&Vector6::new(t, t, t, r, r, r))
    }

    /// The pose at rest, and the contact force (N), for a commanded `hole_from_command`, searched from `hole_from_peg`.
    ///
    /// Minimises `½ eᵀKe + ½ κ Σ min(0, gap)²` with `e = Log(command⁻¹ · peg)`, over every pair of features that touches. Quasi-static
    /// and frictionless: springs alone decide.
    pub(super) fn rest(&self, parts: &PegAndHole, hole_from_command: &Pose, hole_from_peg: Pose) -> (Pose, f64) {
        let stiffness = self.stiffness();
        let mut pose = hole_from_peg;
        let mut state = self.energy(parts, hole_from_command, &pose);
        for _ in 0..STEPS {
            let Some(cholesky) = Cholesky::new(stiffness + state.curvature) else { break };
            let step = -cholesky.solve(&state.gradient);
            let mut share = 1.0;
            let expected = -state.gradient.dot(&step);
            if expected < 1e-16 {
                break;
            }
            loop {
                let candidate = pose * se3::exp(&(step * share));
                let next = self.energy(parts, hole_from_command, &candidate);
                if next.energy < state.energy - 1e-4 * share * expected {
                    pose = candidate;
                    state = next;
                    break;
                }
                share *= 0.5;
                if share < 1e-6 {
                    return (pose, state.force);
                }
            }
        }
        (pose, state.force)
    }

    fn energy(&self, parts: &PegAndHole, hole_from_command: &Pose, pose: &Pose) -> State {
        let error = se3::log(&(hole_from_command.inverse() * pose));
        let spring = self.stiffness() * error;
        let mut state = State { energy: 0.5 * error.dot(&spring), gradient: spring, ..State::default() };
        let mut total = nalgebra::Vector3::zeros();
        parts.visit_within(pose, NEAR, |gap| {
            if gap.value < 0.0 {
                let force = -self.contact * gap.value;
                state.energy += 0.5 * force * -gap.value;
                state.gradient -= gap.gradient * force;
                state.curvature += gap.gradient * gap.gradient.transpose() * self.contact;
                total += gap.normal_in_hole * force;
            }
        });
        state.force = total.norm();
        state
    }
}

#[derive(Default)]
struct State {
    energy: f64,
    gradient: Twist,
    curvature: Matrix6<f64>,
    force: f64,
}

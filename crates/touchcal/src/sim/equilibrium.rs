//! Where a tool held by springs comes to rest against stiff parts.
//!
//! `min ½ ξᵀKξ` subject to `gap ≥ 0`, with `ξ` the tool's displacement from its command and the contact forces as multipliers. The constraints are
//! met by springs of [`CONTACT`] N/m, which 100 N press in by 0.1 µm. Friction is a tangential spring on each pair that touches, whose force stays within
//! μ times the normal force: it sticks until that is reached and then slides, opposing the motion (Cundall & Strack 1979, without damping).

use nalgebra::{Cholesky, Matrix3, Matrix3x6, Matrix6, Translation3, UnitQuaternion, Vector3};

use super::parts::{Near, Pair, Parts};
use crate::se3::{self, Pose, Twist};

/// How an arm under Cartesian impedance control yields at the tool's origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stiffness {
    /// Force over displacement (N/m).
    pub translation: f64,
    /// Torque over rotation (N m/rad).
    pub rotation: f64,
}

/// Normal stiffness of parts (N/m).
const CONTACT: f64 = 1e9;
/// Tangential stiffness of what sticks (N/m): 10 N shear it by 1 µm.
const STICKING: f64 = 1e7;
/// Linearisations of the parts before a search is given up: one that slides along a wall needs three to five.
const LINEARISATIONS: usize = 100;
/// Of these, the first bound friction anew by the normal forces just found. Where a tool jams they can chase each other: then the bounds stay.
const BOUNDINGS: usize = 30;
/// Newton steps within one linearisation.
const STEPS: usize = 100;
/// A search has ended when the next step moves no point of the tool further (m).
const SETTLED: f64 = 1e-9;
/// What is nearer than this touches (m).
const TOUCHING: f64 = 1e-7;
/// Energy (J) that no step need gain.
const NEGLIGIBLE: f64 = 1e-18;

/// A tool at rest.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rest {
    pub fixture_from_tool: Pose,
    /// `[f; τ]` (N, N m) of the fixture on the tool, in the tool frame about its origin.
    pub wrench: Twist,
    /// Whether any pair touches.
    pub touching: bool,
}

/// What a pair that touches bears.
#[derive(Clone, Copy, Debug)]
struct Load {
    pair: Pair,
    /// Normal force (N).
    normal: f64,
    /// Friction (N, fixture frame).
    friction: Vector3<f64>,
}

/// A pair as the linear model has it, at the present displacement.
#[derive(Clone, Copy, Debug)]
struct Linear {
    gap: f64,
    gradient: Twist,
    friction: Option<Friction>,
}

/// Forces and lengths in the tool frame.
#[derive(Clone, Copy, Debug)]
struct Friction {
    /// Tangential motion of the point for a displacement of the tool.
    slip_by: Matrix3x6<f64>,
    /// Force (N) if the pair sticks.
    trial: Vector3<f64>,
    /// Greatest force (N).
    most: f64,
}

impl Friction {
    fn force(&self, trial: &Vector3<f64>) -> Vector3<f64> {
        let size = trial.norm();
        if size <= self.most { *trial } else { trial * (self.most / size) }
    }

    /// Energy of the spring and of what slides.
    fn energy(&self) -> f64 {
        let size = self.trial.norm();
        let energy = if size <= self.most { 0.5 * size * size } else { self.most * (size - 0.5 * self.most) };
        energy / STICKING
    }
}

/// A tool that is pushed along a fixture, command by command.
pub(super) struct Equilibrium<'a> {
    parts: &'a Parts,
    stiffness: Stiffness,
    /// Coefficient of friction μ.
    friction: f64,
    /// Where the tool rests, and what it bears there.
    pose: Pose,
    loads: Vec<Load>,
    near: Vec<Near>,
    touches: Vec<Linear>,
}

impl<'a> Equilibrium<'a> {
    pub fn new(parts: &'a Parts, stiffness: Stiffness, friction: f64, fixture_from_tool: Pose) -> Self {
        let (loads, near, touches) = (Vec::new(), Vec::new(), Vec::new());
        Equilibrium { parts, stiffness, friction, pose: fixture_from_tool, loads, near, touches }
    }

    /// Where the tool comes to rest under a command, from where it is. None if no rest is found.
    pub fn settle(&mut self, fixture_from_command: &Pose) -> Option<Rest> {
        let before = self.pose;
        let mut pose = before;
        self.look(&pose, &before);
        let mut energy = self.energy(&pose, fixture_from_command);
        for round in 0..LINEARISATIONS {
            let spring = self.spring(&pose, fixture_from_command);
            let step = self.step(&spring)?;
            let length = se3::linear(&step).norm() + se3::angular(&step).norm() * self.parts.size();
            if length < SETTLED {
                return Some(self.rest(pose, spring));
            }
            if self.friction > 0.0 && round < BOUNDINGS {
                self.keep_normal_forces();
                self.look(&pose, &before);
                energy = self.energy(&pose, fixture_from_command);
            }
            let mut share = self.parts.reach().map_or(1.0, |reach| (reach / length).min(1.0));
            loop {
                let candidate = pose * se3::exp(&(step * share));
                self.look(&candidate, &before);
                let next = self.energy(&candidate, fixture_from_command);
                if next <= energy + NEGLIGIBLE {
                    (pose, energy) = (candidate, next);
                    break;
                }
                share *= 0.5;
                if share * length < SETTLED {
                    // An edge, where the nearest faces change: no way leads down from it.
                    self.look(&pose, &before);
                    return Some(self.rest(pose, spring));
                }
            }
        }
        None
    }

    fn rest(&mut self, pose: Pose, spring: Twist) -> Rest {
        self.keep_loads(&pose);
        self.pose = pose;
        let touching = self.near.iter().any(|near| near.gap < TOUCHING);
        Rest { fixture_from_tool: pose, wrench: spring, touching }
    }

    /// Force and torque (tool frame) by which the controller's springs resist: the gradient of their energy.
    fn spring(&self, pose: &Pose, command: &Pose) -> Twist {
        let (apart, turned) = apart(pose, command);
        se3::twist(&(pose.rotation.inverse() * apart * self.stiffness.translation), &(turned * self.stiffness.rotation))
    }

    fn energy(&self, pose: &Pose, command: &Pose) -> f64 {
        let (apart, turned) = apart(pose, command);
        let Stiffness { translation, rotation } = self.stiffness;
        let springs = 0.5 * (translation * apart.norm_squared() + rotation * turned.norm_squared());
        let touch = |touch: &Linear| {
            0.5 * CONTACT * touch.gap.min(0.0).powi(2) + touch.friction.map_or(0.0, |friction| friction.energy())
        };
        springs + self.touches.iter().map(touch).sum::<f64>()
    }

    /// Finds what is near at `pose`, having been at `before` when the last command ended.
    fn look(&mut self, pose: &Pose, before: &Pose) {
        self.near.clear();
        let near = &mut self.near;
        self.parts.visit_near(pose, |pair| near.push(pair));
        self.touches.clear();
        for near in &self.near {
            let load = if self.friction > 0.0 { self.loads.iter().find(|load| load.pair == near.pair) } else { None };
            let friction = load.map(|load| {
                let normal = near.normal_in_tool;
                let tangential = Matrix3::identity() - normal * normal.transpose();
                let mut slip_by = Matrix3x6::zeros();
                slip_by.fixed_columns_mut::<3>(0).copy_from(&tangential);
                slip_by.fixed_columns_mut::<3>(3).copy_from(&(-tangential * se3::skew(&near.point_in_tool.coords)));
                let moved = pose * near.point_in_tool - before * near.point_in_tool;
                let trial = pose.rotation.inverse() * (load.friction - moved * STICKING);
                Friction { slip_by, trial: tangential * trial, most: self.friction * load.normal }
            });
            self.touches.push(Linear { gap: near.gap, gradient: near.gradient, friction });
        }
    }

    /// Displacement of the tool (a right twist) to the least energy of the linear model: exact where the same pairs stay in touch.
    fn step(&mut self, spring: &Twist) -> Option<Twist> {
        let Stiffness { translation, rotation } = self.stiffness;
        let stiffness = Twist::new(translation, translation, translation, rotation, rotation, rotation);
        let mut moved = Twist::zeros();
        let mut touches = std::mem::take(&mut self.touches);
        let mut found = None;
        for _ in 0..STEPS {
            let mut gradient = spring + stiffness.component_mul(&moved);
            let mut curvature = Matrix6::from_diagonal(&stiffness);
            for touch in &touches {
                if touch.gap < 0.0 {
                    gradient += touch.gradient * (CONTACT * touch.gap);
                    curvature.ger(CONTACT, &touch.gradient, &touch.gradient, 1.0);
                }
                if let Some(friction) = touch.friction.filter(|friction| friction.most > 0.0) {
                    add_friction(&friction, &mut gradient, &mut curvature);
                }
            }
            let step = -Cholesky::new(curvature)?.solve(&gradient);
            if -gradient.dot(&step) < NEGLIGIBLE {
                found = Some(moved);
                break;
            }
            let share = share_of(&step, gradient.dot(&step), &stiffness, &touches);
            moved += step * share;
            for touch in &mut touches {
                touch.gap += share * touch.gradient.dot(&step);
                if let Some(friction) = &mut touch.friction {
                    friction.trial -= friction.slip_by * step * (share * STICKING);
                }
            }
        }
        self.touches = touches;
        found
    }

    /// Normal forces of the linear model just solved bound the friction of the next.
    fn keep_normal_forces(&mut self) {
        for (near, touch) in self.near.iter().zip(&self.touches) {
            let normal = -CONTACT * touch.gap.min(0.0);
            match self.loads.iter_mut().find(|load| load.pair == near.pair) {
                Some(load) => load.normal = normal,
                None => self.loads.push(Load { pair: near.pair, normal, friction: Vector3::zeros() }),
            }
        }
    }

    /// What the pairs bear at rest; those that no longer touch bear nothing.
    fn keep_loads(&mut self, pose: &Pose) {
        if self.friction == 0.0 {
            return;
        }
        self.loads.clear();
        for (near, touch) in self.near.iter().zip(&self.touches).filter(|(_, touch)| touch.gap < 0.0) {
            let friction = touch.friction.map_or_else(Vector3::zeros, |friction| friction.force(&friction.trial));
            let friction = pose.rotation * friction;
            self.loads.push(Load { pair: near.pair, normal: -CONTACT * touch.gap, friction });
        }
    }
}

/// How far a pose is from its command: displacement (m, fixture frame) and rotation vector (rad, tool frame).
fn apart(pose: &Pose, command: &Pose) -> (Vector3<f64>, Vector3<f64>) {
    let turned: UnitQuaternion<f64> = command.rotation.inverse() * pose.rotation;
    let Translation3 { vector } = pose.translation;
    (vector - command.translation.vector, se3::rotation_log(&turned))
}

fn add_friction(friction: &Friction, gradient: &mut Twist, curvature: &mut Matrix6<f64>) {
    let size = friction.trial.norm();
    *gradient -= friction.slip_by.tr_mul(&friction.force(&friction.trial));
    let sticking = (friction.most / size).min(1.0) * STICKING;
    *curvature += friction.slip_by.tr_mul(&friction.slip_by) * sticking;
    if size > friction.most {
        let along = friction.slip_by.tr_mul(&(friction.trial / size));
        curvature.ger(-sticking, &along, &along, 1.0);
    }
}

/// Share of a step at which the energy is least along it, whose slope at 0 is `start`.
fn share_of(step: &Twist, start: f64, stiffness: &Twist, touches: &[Linear]) -> f64 {
    let springs = step.component_mul(stiffness).dot(step);
    let resisted = |touch: &Linear| if touch.gap < 0.0 { CONTACT * touch.gap * touch.gradient.dot(step) } else { 0.0 };
    let rubbed = |friction: &Friction| -friction.force(&friction.trial).dot(&(friction.slip_by * step));
    let of = |touch: &Linear| resisted(touch) + touch.friction.as_ref().map_or(0.0, rubbed);
    let base = start - touches.iter().map(of).sum::<f64>();
    let slope = |share: f64| {
        let mut slope = base + share * springs;
        for touch in touches {
            let rate = touch.gradient.dot(step);
            slope += CONTACT * (touch.gap + share * rate).min(0.0) * rate;
            if let Some(friction) = &touch.friction {
                let slip = friction.slip_by * step;
                slope -= friction.force(&(friction.trial - slip * (share * STICKING))).dot(&slip);
            }
        }
        slope
    };
    let (mut low, mut high) = ((0.0, start), (1.0, slope(1.0)));
    if high.1 <= 0.0 {
        return 1.0;
    }
    // Regula falsi, the end that stays halved (Illinois).
    let mut share = 1.0;
    for _ in 0..40 {
        share = (low.0 * high.1 - high.0 * low.1) / (high.1 - low.1);
        let here = slope(share);
        if here.abs() < 1e-3 * start.abs() {
            break;
        }
        if here < 0.0 {
            low = (share, here);
            high.1 *= 0.5;
        } else {
            high = (share, here);
            low.1 *= 0.5;
        }
    }
    share
}

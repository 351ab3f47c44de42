//! Where a tool held by springs comes to rest against stiff parts.
//!
//! `min ½ ξᵀKξ` subject to `gap ≥ 0`, with `ξ` the tool's displacement from its command and the
//! contact forces as multipliers. The constraints are met by springs of [`CONTACT`] N/m, which 100
//! N press in by 0.1 µm. Friction is a tangential spring on each pair that touches, whose force
//! stays within μ times the normal force: it sticks until that is reached and then slides, opposing
//! the motion (Cundall & Strack 1979, without damping).

use nalgebra::{Cholesky, Matrix3, Matrix3x6, Matrix6, Translation3, UnitQuaternion, Vector3};

use super::friction::{Friction, Rubbing, STICKING, bounded};
use super::parts::{Near, NearPairs, Pair};
use crate::geometry::Parts;
use crate::se3::{self, Pose, Twist};

/// Isotropic stiffness of an arm under Cartesian impedance control, at the tool's origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stiffness {
    /// Force over displacement from the command (N/m, > 0).
    pub translation: f64,
    /// Torque over rotation from the command (N m/rad, > 0).
    pub rotation: f64,
}

/// Normal stiffness of parts (N/m).
const CONTACT: f64 = 1e9;
/// Linearisations of the parts before a search is given up: one that slides along a wall needs
/// three to five, one wedged in a narrow hole up to 150.
const LINEARISATIONS: usize = 1000;
/// Of these, the first bound friction anew by the normal forces just found. Where a tool jams they
/// can chase each other: then the bounds stay.
const BOUNDINGS: usize = 30;
/// After so many, steps that turn back are halved: they alternate between faces at an edge.
const ALTERNATING: usize = 500;
/// Newton steps within one linearisation.
const STEPS: usize = 100;
/// A search has ended when the next step moves no point of the tool further (m).
const SETTLED: f64 = 1e-9;
/// The same (m) at the last linearisation.
const AT_REST: f64 = 1e-7;
/// What is nearer than this touches (m).
const TOUCHING: f64 = 1e-7;
/// Cosine of the angle between normals within which pairs push in one direction.
const ONE_DIRECTION: f64 = 0.9;
/// Energy (J) that no step need gain.
const NEGLIGIBLE: f64 = 1e-18;

/// A tool at rest.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rest {
    /// Pose of the tool in the fixture's frame (m).
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

/// The gap of a pair as the linear model has it, at the present displacement.
#[derive(Clone, Copy, Debug)]
struct Linear {
    gap: f64,
    gradient: Twist,
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
    rubbing: Vec<Rubbing>,
    frictions: Vec<Friction>,
}

impl<'a> Equilibrium<'a> {
    /// A tool at rest at `fixture_from_tool`, with friction μ (1).
    pub fn new(parts: &'a Parts, stiffness: Stiffness, friction: f64, fixture_from_tool: Pose) -> Self {
        Equilibrium {
            parts,
            stiffness,
            friction,
            pose: fixture_from_tool,
            loads: Vec::new(),
            near: Vec::new(),
            touches: Vec::new(),
            rubbing: Vec::new(),
            frictions: Vec::new(),
        }
    }

    /// Where the tool comes to rest under a command, from where it is. None if no rest is found;
    /// the tool's pose is then as before.
    pub fn settle(&mut self, fixture_from_command: &Pose) -> Option<Rest> {
        let before = self.pose;
        let mut pose = before;
        let mut last = Twist::zeros();
        self.look(&pose);
        for round in 0..LINEARISATIONS {
            if round < BOUNDINGS {
                self.rub(&pose);
            }
            self.linearize_friction(&pose, &before);
            let energy = self.energy(&pose, &before, fixture_from_command);
            let spring = self.spring(&pose, fixture_from_command);
            let step = self.step(&spring)?;
            let length = se3::linear(&step).norm() + se3::angular(&step).norm() * self.parts.size();
            let settled = if round + 1 < LINEARISATIONS { SETTLED } else { AT_REST };
            if length < settled {
                return Some(self.rest(pose, spring));
            }
            if self.friction > 0.0 && round < BOUNDINGS {
                self.keep_normal_forces();
            }
            let mut share = self.parts.reach().map_or(1.0, |reach| (reach / length).min(1.0));
            if round > ALTERNATING && self.turns_back(&step, &last) {
                share *= 0.5;
            }
            last = step;
            loop {
                let candidate = pose * se3::exp(&(step * share));
                self.look(&candidate);
                if self.energy(&candidate, &before, fixture_from_command) <= energy + NEGLIGIBLE {
                    pose = candidate;
                    break;
                }
                share *= 0.5;
                if share * length < SETTLED {
                    // An edge, where the nearest faces change: no way leads down from it.
                    self.look(&pose);
                    self.linearize_friction(&pose, &before);
                    return Some(self.rest(pose, spring));
                }
            }
        }
        None
    }

    /// Whether a step moves the tool against the one before, rotations weighted by the tool's size.
    fn turns_back(&self, step: &Twist, last: &Twist) -> bool {
        let rotation = se3::angular(step).dot(&se3::angular(last)) * self.parts.size().powi(2);
        se3::linear(step).dot(&se3::linear(last)) + rotation < 0.0
    }

    fn rest(&mut self, pose: Pose, spring: Twist) -> Rest {
        self.keep_loads(&pose);
        self.pose = pose;
        Rest { fixture_from_tool: pose, wrench: spring, touching: self.near.iter().any(|near| near.gap < TOUCHING) }
    }

    /// Where the tool at `rest` is if each surface that it touches stands out by `form()` (m), and
    /// it keeps touching them all. Pairs that push in one direction are of one surface.
    pub fn on_forms(&mut self, rest: &Rest, mut form: impl FnMut() -> f64) -> Option<Pose> {
        self.look(&rest.fixture_from_tool);
        let Stiffness { translation, rotation } = self.stiffness;
        let mut curvature =
            Matrix6::from_diagonal(&Twist::new(translation, translation, translation, rotation, rotation, rotation));
        let mut gradient = Twist::zeros();
        let mut surfaces: Vec<(Vector3<f64>, f64)> = Vec::new();
        for near in self.near.iter().filter(|near| near.gap < TOUCHING) {
            let normal = near.normal_in_tool;
            let known = surfaces.iter().find(|(direction, _)| direction.dot(&normal) > ONE_DIRECTION);
            let stands_out = known.map_or_else(&mut form, |(_, stands_out)| *stands_out);
            if known.is_none() {
                surfaces.push((normal, stands_out));
            }
            gradient -= near.gradient * (CONTACT * stands_out);
            curvature.ger(CONTACT, &near.gradient, &near.gradient, 1.0);
        }
        Some(rest.fixture_from_tool * se3::exp(&-Cholesky::new(curvature)?.solve(&gradient)))
    }

    /// Force and torque (tool frame) by which the controller's springs resist: the gradient of
    /// their energy.
    fn spring(&self, pose: &Pose, command: &Pose) -> Twist {
        let (apart, turned) = apart(pose, command);
        se3::twist(&(pose.rotation.inverse() * apart * self.stiffness.translation), &(turned * self.stiffness.rotation))
    }

    /// Energy (J) of springs and parts, and of what rubs as last looked at.
    fn energy(&self, pose: &Pose, before: &Pose, command: &Pose) -> f64 {
        let (apart, turned) = apart(pose, command);
        let Stiffness { translation, rotation } = self.stiffness;
        let springs = 0.5 * (translation * apart.norm_squared() + rotation * turned.norm_squared());
        let parts = self.touches.iter().map(|touch| 0.5 * CONTACT * touch.gap.min(0.0).powi(2)).sum::<f64>();
        springs + parts + self.rubbing.iter().map(|rubbing| rubbing.energy(pose, before)).sum::<f64>()
    }

    /// Finds what is near at `pose`.
    fn look(&mut self, pose: &Pose) {
        self.near.clear();
        let near = &mut self.near;
        self.parts.visit_near(pose, |pair| near.push(pair));
        self.touches.clear();
        let linear = |near: &Near| Linear { gap: near.gap, gradient: near.gradient };
        self.touches.extend(self.near.iter().map(linear));
    }

    /// Finds what rubs: pairs near at `pose` whose normal force is known.
    fn rub(&mut self, pose: &Pose) {
        self.rubbing.clear();
        for load in self.loads.iter().filter(|load| load.normal > 0.0) {
            let Some(near) = self.near.iter().find(|near| near.pair == load.pair) else { continue };
            self.rubbing.push(Rubbing {
                pair: near.pair,
                point_in_tool: near.point_in_tool,
                normal: pose.rotation * near.normal_in_tool,
                carried: load.friction,
                most: self.friction * load.normal,
            });
        }
    }

    /// Friction about `pose`, the tool having been at `before` when the last command ended.
    fn linearize_friction(&mut self, pose: &Pose, before: &Pose) {
        let linear = |rubbing: &Rubbing| {
            let normal = pose.rotation.inverse() * rubbing.normal;
            let tangential = Matrix3::identity() - normal * normal.transpose();
            let mut slip_by = Matrix3x6::zeros();
            slip_by.fixed_columns_mut::<3>(0).copy_from(&tangential);
            slip_by.fixed_columns_mut::<3>(3).copy_from(&(-tangential * se3::skew(&rubbing.point_in_tool.coords)));
            let trial = pose.rotation.inverse() * rubbing.trial(pose, before);
            Friction { slip_by, trial, most: rubbing.most }
        };
        self.frictions.clear();
        self.frictions.extend(self.rubbing.iter().map(linear));
    }

    /// Displacement of the tool (a right twist) to the least energy of the linear model: exact
    /// where the same pairs stay in touch.
    fn step(&mut self, spring: &Twist) -> Option<Twist> {
        let Stiffness { translation, rotation } = self.stiffness;
        let stiffness = Twist::new(translation, translation, translation, rotation, rotation, rotation);
        let mut moved = Twist::zeros();
        let Equilibrium { touches, frictions, .. } = self;
        for _ in 0..STEPS {
            let mut gradient = spring + stiffness.component_mul(&moved);
            let mut curvature = Matrix6::from_diagonal(&stiffness);
            for touch in touches.iter() {
                if touch.gap < 0.0 {
                    gradient += touch.gradient * (CONTACT * touch.gap);
                    curvature.ger(CONTACT, &touch.gradient, &touch.gradient, 1.0);
                }
            }
            for friction in frictions.iter() {
                friction.add_to(&mut gradient, &mut curvature);
            }
            let step = -Cholesky::new(curvature)?.solve(&gradient);
            if -gradient.dot(&step) < NEGLIGIBLE {
                return Some(moved);
            }
            let share = share_of(&step, gradient.dot(&step), &stiffness, (touches, frictions));
            moved += step * share;
            for touch in touches.iter_mut() {
                touch.gap += share * touch.gradient.dot(&step);
            }
            for friction in frictions.iter_mut() {
                friction.trial -= friction.slip_by * step * (share * STICKING);
            }
        }
        None
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
        self.loads.clear();
        if self.friction == 0.0 {
            return;
        }
        for (near, touch) in self.near.iter().zip(&self.touches).filter(|(_, touch)| touch.gap < 0.0) {
            let mut rubbed = self.rubbing.iter().zip(&self.frictions);
            let friction = rubbed.find(|(rubbing, _)| rubbing.pair == near.pair).map(|(_, friction)| friction.force());
            let friction = pose.rotation * friction.unwrap_or_default();
            self.loads.push(Load { pair: near.pair, normal: -CONTACT * touch.gap, friction });
        }
    }
}

/// How far a pose is from its command: displacement (m, fixture frame) and rotation vector (rad,
/// tool frame).
fn apart(pose: &Pose, command: &Pose) -> (Vector3<f64>, Vector3<f64>) {
    let turned: UnitQuaternion<f64> = command.rotation.inverse() * pose.rotation;
    let Translation3 { vector } = pose.translation;
    (vector - command.translation.vector, se3::rotation_log(&turned))
}

/// Share of a step at which the energy is least along it, whose slope at 0 is `start`.
fn share_of(step: &Twist, start: f64, stiffness: &Twist, (touches, frictions): (&[Linear], &[Friction])) -> f64 {
    let springs = step.component_mul(stiffness).dot(step);
    let resisted = |share: f64| {
        let touched = touches.iter().map(|touch| {
            let rate = touch.gradient.dot(step);
            CONTACT * (touch.gap + share * rate).min(0.0) * rate
        });
        let rubbed = frictions.iter().map(|friction| {
            let slip = friction.slip_by * step;
            -bounded(&(friction.trial - slip * (share * STICKING)), friction.most).dot(&slip)
        });
        touched.sum::<f64>() + rubbed.sum::<f64>()
    };
    let base = start - resisted(0.0);
    let slope = |share: f64| base + share * springs + resisted(share);
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

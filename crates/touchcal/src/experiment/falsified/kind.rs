//! The battery: what is false, and what is declared beside it.

use Declared::{AllBut, Defaults, Exact, FixtureFree, FixtureSigma, Only};
use Falsification::{
    AllDrawn, ArmSize, Clearance, Depth, DepthInMetres, Drawn, EdgeWear, EncoderDrift, EncoderHarmonic, EncoderNoise,
    EncoderWalk, FalseContacts, FalseContactsOfAllKinds, FewContacts, FixtureInMetres, FixturesMoved, ForceLag,
    Friction, JointCompliance, JointSign, JointsExchanged, JointsInDegrees, JointsReversed, Nothing, Outline, Spacing,
    TightHole, ToolInMetres, ToolMoved, ToolOpposite, ToolTurned, UnequalClearance, WrenchBias,
};
use Quantity::{Distances, FixturePlaces, Shapes, ToolPlace, Trends, UnseenEffects, Wrench};

use super::excitation::Excitation;
use super::falsification::{Displacement, Falsification};
use super::quantity::Quantity;
use crate::estimate::{self, DEFAULT_DISTANCE_SIGMA, PlacePrior, Problem, ShapeTolerance, WrenchTolerance};
use crate::experiment::problem::posed;
use crate::parameter::{Block, joint_trend};
use crate::sim::{PartsError, Scenario, SimulatedTrial};

const DEG: f64 = std::f64::consts::PI / 180.0;
const MM: f64 = 1e-3;

/// Standard deviations that a problem declares. What has a standard deviation in the scenario
/// itself keeps that.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Declared {
    /// All is exact.
    Exact,
    /// Those that a problem file has where it says nothing.
    Defaults,
    /// The defaults, but this is exact.
    AllBut(Quantity),
    /// The default of this; all else is exact.
    Only(Quantity),
    /// The defaults, but places of fixtures have this standard deviation (m) and that of the
    /// default's angle.
    FixtureSigma(f64),
    /// The defaults, but nothing is known of the places of fixtures.
    FixtureFree,
}

/// One kind of trial: what is false, and the standard deviations that are declared.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FalsifiedKind {
    /// Name in files and arguments, unique in [`FalsifiedKind::ALL`].
    pub name: &'static str,
    /// What is false, in words.
    pub description: &'static str,
    /// What is false.
    pub falsification: Falsification,
    /// The declared standard deviations.
    pub declared: Declared,
    /// The excitations with which it is tried.
    pub excitations: &'static [Excitation],
}

const PEG: &[Excitation] = &[Excitation::Paper, Excitation::Rich];
const SOCKETS: &[Excitation] = &[Excitation::Sockets];
const ALL: &[Excitation] = &[Excitation::Paper, Excitation::Rich, Excitation::Sockets];

const fn kind(
    name: &'static str,
    description: &'static str,
    falsification: Falsification,
    declared: Declared,
) -> FalsifiedKind {
    FalsifiedKind { name, description, falsification, declared, excitations: PEG }
}

const fn tried(excitations: &'static [Excitation], kind: FalsifiedKind) -> FalsifiedKind {
    FalsifiedKind { excitations, ..kind }
}

const fn sized(length: f64, angle: f64) -> Displacement {
    Displacement { length, angle }
}

const DRAWN_WRENCH: Falsification = WrenchBias { force: 0.5, torque: 0.05 };
const FALSE: Falsification = FalseContacts { share: 0.2, deviation: 0.3 * DEG };

impl FalsifiedKind {
    /// The battery, in the order in which it is shown.
    #[rustfmt::skip]
    pub const ALL: [FalsifiedKind; 54] = [
        tried(ALL, kind("nothing_exact", "nothing; tool, hole and shapes declared exact", Nothing, Exact)),
        tried(ALL, kind("nothing", "nothing", Nothing, Defaults)),
        kind("hole_drawn", "hole off by a draw from the default, 1 mm and 0.5°; all else exact", Drawn(FixturePlaces), Only(FixturePlaces)),
        kind("tool_drawn", "tool off by a draw from the default, 0.3 mm and 0.2°; all else exact", Drawn(ToolPlace), Only(ToolPlace)),
        kind("shapes_drawn", "clearance, depth and edges off by draws from the default, 0.03 and 0.05 mm; all else exact", Drawn(Shapes), Only(Shapes)),
        kind("trends_drawn", "each encoder drifts by a draw from the default, 0.01° over the log; all else exact", Drawn(Trends), Only(Trends)),
        tried(SOCKETS, kind("spacing_drawn", "distances off by draws from the default, 0.1 mm; all else exact", Drawn(Distances), Only(Distances))),
        tried(ALL, kind("all_drawn", "places, shapes, distances, trends and encoder harmonics off by draws from their defaults", AllDrawn, Defaults)),
        kind("hole_1mm", "hole off by 1 mm", FixturesMoved(sized(MM, 0.0)), Defaults),
        kind("hole_0.3mm", "hole off by 0.3 mm", FixturesMoved(sized(0.3 * MM, 0.0)), Defaults),
        kind("hole_0.1mm", "hole off by 0.1 mm", FixturesMoved(sized(0.1 * MM, 0.0)), Defaults),
        kind("hole_exact_0.1mm", "hole declared exact, off by 0.1 mm", FixturesMoved(sized(0.1 * MM, 0.0)), AllBut(FixturePlaces)),
        kind("hole_exact_1mm", "hole declared exact, off by 1 mm", FixturesMoved(sized(MM, 0.0)), AllBut(FixturePlaces)),
        kind("hole_sigma_2mm", "hole declared to 2 mm, off by 2 mm", FixturesMoved(sized(2.0 * MM, 0.0)), FixtureSigma(2.0 * MM)),
        kind("hole_free", "nothing; the place of the hole is unknown", Nothing, FixtureFree),
        kind("tool_0.5mm", "tool off by 0.5 mm and 0.2°", ToolMoved(sized(0.5 * MM, 0.2 * DEG)), Defaults),
        kind("tool_0.1mm", "tool off by 0.1 mm and 0.05°", ToolMoved(sized(0.1 * MM, 0.05 * DEG)), Defaults),
        kind("tool_exact_0.5mm", "tool declared exact, off by 0.5 mm and 0.2°", ToolMoved(sized(0.5 * MM, 0.2 * DEG)), AllBut(ToolPlace)),
        tried(ALL, kind("tool_in_metres", "tool's position a thousandth of the true one", ToolInMetres, Defaults)),
        kind("clearance_wide_0.05mm", "hole declared 0.05 mm a side too wide", Clearance(0.05 * MM), Defaults),
        kind("clearance_narrow_0.05mm", "hole declared 0.05 mm a side too narrow", Clearance(-0.05 * MM), Defaults),
        kind("clearance_wide_0.02mm", "hole declared 0.02 mm a side too wide", Clearance(0.02 * MM), Defaults),
        kind("clearance_exact", "shapes declared exact, hole 0.05 mm a side too wide", Clearance(0.05 * MM), AllBut(Shapes)),
        kind("depth_0.05mm", "hole declared 0.05 mm too deep", Depth(0.05 * MM), Defaults),
        kind("outline_0.2_percent", "outlines of peg and hole declared 0.2 % too large", Outline(0.002), Defaults),
        kind("friction_0.25", "friction with a coefficient of 0.25", Friction(0.25), Defaults),
        kind("friction_0.5", "friction with a coefficient of 0.5", Friction(0.5), Defaults),
        kind("clearance_unequal_0.03mm", "hole wider or narrower along x, and along y, by draws of 0.03 mm a side", UnequalClearance(0.03 * MM), Defaults),
        kind("edges_worn_0.2mm", "edges of peg and hole round with a radius of 0.2 mm, declared sharp", EdgeWear(0.2 * MM), Defaults),
        kind("force_lag_0.3s", "contact left between presses, force filtered with a time constant of 0.3 s: rows after contacts count as contacts", ForceLag(0.3), Defaults),
        kind("compliance_2e-5", "joints give way by 2e-5 rad/(N m)", JointCompliance(2e-5), Defaults),
        kind("compliance_5e-6", "joints give way by 5e-6 rad/(N m)", JointCompliance(5e-6), Defaults),
        kind("encoder_drift", "one encoder drifts by 0.02° over the log", EncoderDrift(0.02 * DEG), Defaults),
        kind("encoder_walk", "one encoder walks at random by 0.02° over the log", EncoderWalk(0.02 * DEG), Defaults),
        kind("encoder_harmonic", "one encoder is off by 0.02° once a turn", EncoderHarmonic(0.02 * DEG), Defaults),
        kind("encoder_noise", "encoder noise three times the declared", EncoderNoise(3.0), Defaults),
        kind("false_contacts", "20 % of the contacts are none, joints off by 0.3°", FALSE, Defaults),
        kind("false_contacts_0.3", "30 % of the contacts are none: in free air, joints off by 0.3°, or with another object", FalseContactsOfAllKinds(0.3), Defaults),
        kind("clearance_0.25mm", "nothing; clearance of 0.25 mm a side", TightHole(0.25 * MM), Defaults),
        kind("few_contacts", "nothing; 300 contacts only", FewContacts(300), Defaults),
        tried(ALL, kind("joints_exchanged", "two joints exchanged in the log", JointsExchanged, Defaults)),
        tried(SOCKETS, kind("spacing_0.25_percent", "distances of sockets declared 0.25 % too large", Spacing(0.0025), Defaults)),
        tried(SOCKETS, kind("spacing_0.6_percent", "distances of sockets declared 0.6 % too large", Spacing(0.006), Defaults)),
        tried(SOCKETS, kind("spacing_2.5_percent", "distances of sockets declared 2.5 % too large", Spacing(0.025), Defaults)),
        kind("wrench_bias", "compliances from a wrench with a bias, drawn from the default, 0.5 N and 0.05 N m; all else exact", DRAWN_WRENCH, Only(Wrench)),
        kind("wrench_bias_exact", "wrench declared exact, with a bias of 0.5 N and 0.05 N m", DRAWN_WRENCH, AllBut(Wrench)),
        kind("tool_turned", "tool's frame turned by 180° about its x axis", ToolTurned, Defaults),
        tried(ALL, kind("tool_opposite", "tool's position with the opposite sign", ToolOpposite, Defaults)),
        kind("hole_in_metres", "hole's position a thousandth of the true one", FixtureInMetres, Defaults),
        kind("depth_in_metres", "hole's depth a thousandth of the true one", DepthInMetres, Defaults),
        tried(ALL, kind("joints_reversed", "joints in the opposite order in the log", JointsReversed, Defaults)),
        tried(ALL, kind("joints_degrees", "degrees in the log, taken as radians", JointsInDegrees, Defaults)),
        tried(ALL, kind("joint_sign", "one joint with the opposite sign in the log", JointSign, Defaults)),
        tried(ALL, kind("other_arm", "arm described with 0.9 times its lengths", ArmSize(0.9), Defaults)),
    ];

    /// The problem of a simulated trial: as [`experiment::problem`](crate::experiment::problem())
    /// poses it of `scenario`, with the measured loads, the declared standard deviations, and what
    /// [`Falsification::falsify_problem`] makes of it with `seed`. The trial is that of the
    /// scenario after [`Falsification::falsify_scenario`].
    ///
    /// # Errors
    /// If shapes that are to be declared are not valid.
    pub fn problem(&self, scenario: &Scenario, simulated: &SimulatedTrial, seed: u64) -> Result<Problem, PartsError> {
        let mut problem = posed(scenario, simulated, true);
        self.declared.apply(&mut problem);
        self.falsification.falsify_problem(&mut problem, scenario, seed)?;
        Ok(problem)
    }

    /// The kind of this name; `None` if there is none.
    pub fn by_name(name: &str) -> Option<FalsifiedKind> {
        FalsifiedKind::ALL.into_iter().find(|kind| kind.name == name)
    }
}

impl Declared {
    fn has_default(self, quantity: Quantity) -> bool {
        match self {
            Declared::Exact => false,
            Declared::AllBut(exact) => quantity != exact,
            Declared::Only(only) => quantity == only,
            _ => true,
        }
    }

    /// Declares these standard deviations in `problem`, which has those of its scenario.
    pub(super) fn apply(self, problem: &mut Problem) {
        if problem.tool.prior == PlacePrior::Fixed && self.has_default(ToolPlace) {
            problem.tool.prior = PlacePrior::DEFAULT_TOOL;
        }
        for fixture in &mut problem.fixtures {
            if self.has_default(Shapes) {
                fixture.tolerance = ShapeTolerance::DEFAULT.of(fixture.manifold.as_ref());
            }
            fixture.prior = match (fixture.prior, self) {
                (PlacePrior::Fixed, FixtureSigma(sigma)) => PlacePrior::Gaussian { sigma, sigma_angle: 0.5 * DEG },
                (PlacePrior::Fixed, FixtureFree) => PlacePrior::Flat,
                (PlacePrior::Fixed, _) if self.has_default(FixturePlaces) => PlacePrior::DEFAULT_FIXTURE,
                (known, _) => known,
            };
        }
        if self.has_default(Wrench) {
            problem.wrench = WrenchTolerance::DEFAULT.with_noise_of(&problem.wrench);
        }
        if self.has_default(Distances) {
            problem.distances.iter_mut().for_each(|known| known.sigma = DEFAULT_DISTANCE_SIGMA);
        }
        let has_unseen = self.has_default(UnseenEffects);
        problem.options.unseen_effects =
            if has_unseen { estimate::UnseenEffects::Widen } else { estimate::UnseenEffects::Ignore };
        let has_offsets = problem.parameters.iter().any(|parameter| parameter.id.block() == Block::JointOffset);
        if has_offsets && self.has_default(Trends) {
            problem.parameters.extend(joint_trend(&problem.robot));
        }
    }
}

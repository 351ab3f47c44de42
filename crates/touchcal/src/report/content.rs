//! The data of the page, apart from contacts, parameters and scene.

use serde::Serialize;

use super::contacts::Contacts;
use super::declarations::Declarations;
use super::page::{Template, page};
use super::parameters::Parameters;
use super::relative::CommonFolder;
use super::scene::Scene;
use super::settings::{Settings, Units, units};
use super::warning_text::{WarningText, sorted};
use crate::estimate::{
    Estimate, Evaluation, Problem, Progress, Score, Spread, Stage, Termination, ToolUncertainty, WorkspaceUncertainty,
    distance_uncertainty, tool_uncertainty, workspace_configurations,
};
use crate::manifold::ResidualKind;
use crate::robot::Kinematics;
use crate::se3::Pose;

/// The parts of a calibration that a report shows. `problem`, `estimate` and `prefit` are of one
/// calibration: [`Report::html`] may panic on parts of several.
#[derive(Clone, Copy, Debug)]
pub struct Report<'a> {
    /// The problem that was solved.
    pub problem: &'a Problem,
    /// The result of its calibration.
    pub estimate: &'a Estimate,
    /// Distances (m) of the contacts by the nominal arm: [`evaluate`](crate::estimate::evaluate())
    /// of the problem.
    pub prefit: &'a Score,
    /// Progress of the estimation at each step, as passed to its observer, in that order; may be
    /// empty.
    pub steps: &'a [Progress],
    /// When the calibration was made, as text that the page shows; `None` if that is not known.
    pub created: Option<&'a str>,
    /// Warnings, listed by gravity; may be empty.
    pub warnings: &'a [WarningText],
    /// Input files, in the order in which the page lists them; may be empty.
    pub inputs: &'a [Input],
}

impl Report<'_> {
    /// The text of the page: one HTML document in UTF-8. The same report gives the same text.
    ///
    /// # Errors
    /// If the data cannot be written as JSON, which no calibration is known to cause: numbers that
    /// are not finite become null.
    pub fn html(&self) -> serde_json::Result<String> {
        Ok(page(Template::Calibration, &serde_json::to_string(&Content::new(self))?))
    }
}

/// An input file with its checksum.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Input {
    /// Path of the file; the page shows absolute ones without the folder that all have in common
    /// with the logs.
    pub path: String,
    /// SHA-256 of the file's bytes, in hexadecimal (64 digits), as the page shows it.
    pub sha256: String,
}

/// Number of joint positions across the workspace at which the tool's uncertainty is computed.
const WORKSPACE_POSES: usize = 300;
/// Largest number of points of a minimisation's curve.
const MOST_STEPS: usize = 300;

/// The page's data.
#[derive(Serialize)]
pub(super) struct Content<'a> {
    version: &'static str,
    created: Option<&'a str>,
    robot: RobotEntry<'a>,
    status: &'static str,
    acceptance: Option<AcceptanceEntry>,
    held_out: Option<HeldOut>,
    warnings: Vec<&'a WarningText>,
    inputs: Vec<InputEntry<'a>>,
    settings: Settings,
    units: Units,
    all: Change,
    fixtures: Vec<FixtureEntry<'a>>,
    contacts: Contacts,
    declarations: Declarations<'a>,
    parameters: Parameters<'a>,
    /// Expected errors of the tool; `None` if they are not known.
    expected: Option<WorkspaceUncertainty>,
    uncertainty: Option<Uncertainty>,
    termination: TerminationEntry,
    pieces: Vec<Piece>,
    scene: Scene<'a>,
}

#[derive(Serialize)]
struct RobotEntry<'a> {
    name: &'a str,
    base: &'a str,
    tip: &'a str,
    joints: usize,
}

/// Whether the calibration reaches what is asked of it.
#[derive(Serialize)]
struct AcceptanceEntry {
    decision: &'static str,
    message: String,
    advice: String,
}

/// An input file as the page shows it.
#[derive(Serialize)]
pub(super) struct InputEntry<'a> {
    path: String,
    sha256: &'a str,
}

/// Scatter of contacts that were held out.
#[derive(Serialize)]
struct HeldOut {
    contacts: usize,
    /// Found over predicted, and the most that chance makes of it.
    ratio: f64,
    by_chance: f64,
}

/// Distances from contact (m).
#[derive(Serialize)]
struct SpreadEntry {
    mean: f64,
    rms: f64,
    max: f64,
}

/// With the nominal arm and with the calibrated one.
#[derive(Serialize)]
pub(super) struct Change {
    before: SpreadEntry,
    after: SpreadEntry,
}

#[derive(Serialize)]
struct FixtureEntry<'a> {
    name: &'a str,
    placement: &'a str,
    contact: &'a str,
    /// What the rows of its residual are.
    residual: &'static str,
    contacts: usize,
    rejected: usize,
    change: Change,
}

#[derive(Serialize)]
struct TerminationEntry {
    reason: &'static str,
    measured: f64,
    threshold: f64,
    iterations: usize,
}

/// Steps and costs of one minimisation, or of the estimation of variance components.
#[derive(Serialize)]
struct Piece {
    stage: &'static str,
    steps: Vec<(usize, f32)>,
}

/// Standard deviations of the calibrated arm's tool.
#[derive(Serialize)]
struct Uncertainty {
    /// In base, at a contact with each fixture.
    fixtures: Vec<(usize, PoseUncertainty)>,
    /// In base, across the workspace.
    workspace: Vec<PlacedUncertainty>,
    /// Of distances between poses across the workspace (m).
    distances: Vec<f32>,
}

/// An uncertainty with the tool's horizontal distance from the base's z axis and its height (m).
#[derive(Serialize)]
struct PlacedUncertainty {
    radius: f32,
    height: f32,
    #[serde(flatten)]
    pose: PoseUncertainty,
}

#[derive(Serialize)]
struct PoseUncertainty {
    /// Of the position (m).
    position: f32,
    /// Of the rotation (rad).
    angle: f32,
}

impl<'a> Content<'a> {
    /// The page's data of a report.
    pub fn new(report: &Report<'a>) -> Self {
        let Report { problem, estimate, prefit, .. } = *report;
        let robot = &problem.robot;
        let acceptance = estimate.acceptance.as_ref().zip(problem.acceptance.as_ref());
        let files = problem.contacts.files().iter().map(String::as_str);
        let folder = CommonFolder::of(report.inputs.iter().map(|input| &*input.path).chain(files));
        let contacts = Contacts::new(problem, estimate, &folder);
        let scene = Scene::new(problem, estimate, contacts.drawn());
        let Termination { reason, measured, threshold, iterations } = estimate.termination;
        let fixtures = problem.fixtures.iter().enumerate().map(|(f, fixture)| FixtureEntry {
            name: &fixture.name,
            placement: &fixture.placement,
            contact: fixture.manifold.name(),
            residual: residual_name(fixture.manifold.residual_kind()),
            contacts: prefit.per_fixture.get(f).map_or(0, |spread| spread.count),
            rejected: contacts.rejected_count(f),
            change: change(prefit.per_fixture.get(f), estimate.postfit.per_fixture.get(f)),
        });
        Content {
            version: env!("CARGO_PKG_VERSION"),
            created: report.created,
            robot: RobotEntry { name: robot.name(), base: robot.base(), tip: robot.tip(), joints: robot.dof() },
            status: estimate.status.name(),
            acceptance: acceptance.map(|(result, asked)| AcceptanceEntry {
                decision: result.decision.name(),
                message: result.message(asked),
                advice: result.advice(asked),
            }),
            held_out: estimate.held_out.as_ref().and_then(held_out),
            warnings: sorted(report.warnings),
            inputs: input_entries(report.inputs, &folder),
            settings: Settings::new(problem, estimate),
            units: units(),
            all: change(Some(&prefit.all), Some(&estimate.postfit.all)),
            fixtures: fixtures.collect(),
            declarations: Declarations::new(problem, estimate, &folder),
            parameters: Parameters::new(estimate),
            expected: estimate.workspace_uncertainty,
            uncertainty: uncertainty(problem, estimate),
            termination: TerminationEntry { reason: reason.name(), measured, threshold, iterations },
            pieces: pieces(report.steps),
            contacts,
            scene,
        }
    }
}

fn held_out(evaluation: &Evaluation) -> Option<HeldOut> {
    let scatter = evaluation.scatter?;
    let contacts = evaluation.score.all.count;
    Some(HeldOut { contacts, ratio: scatter.ratio(), by_chance: scatter.by_chance[1] })
}

/// The inputs with their paths as the page shows them.
pub(super) fn input_entries<'a>(inputs: &'a [Input], folder: &CommonFolder) -> Vec<InputEntry<'a>> {
    inputs.iter().map(|input| InputEntry { path: folder.shown(&input.path), sha256: &input.sha256 }).collect()
}

/// What the rows of a residual are.
fn residual_name(kind: ResidualKind) -> &'static str {
    match kind {
        ResidualKind::Distance => "distance",
        ResidualKind::PointOffset => "offset",
        ResidualKind::LeastGap => "gap",
        ResidualKind::ProjectionError => "projection",
        ResidualKind::Unmodeled => "none",
    }
}

/// Distances before and after.
pub(super) fn change(before: Option<&Spread>, after: Option<&Spread>) -> Change {
    let entry = |spread: Option<&Spread>| {
        let Spread { mean, rms, max, .. } = spread.copied().unwrap_or_default();
        SpreadEntry { mean, rms, max }
    };
    Change { before: entry(before), after: entry(after) }
}

/// The minimisations of a search: each counts its steps from one.
fn pieces(steps: &[Progress]) -> Vec<Piece> {
    let each = steps.chunk_by(|a, b| a.stage == b.stage && a.iteration < b.iteration).map(|steps| {
        let every = steps.len().div_ceil(MOST_STEPS).max(1);
        let kept = steps.iter().enumerate().filter(|(k, _)| k % every == 0 || k + 1 == steps.len());
        Piece {
            stage: match steps.first().map(|step| step.stage) {
                Some(Stage::Coarse) => "coarse",
                Some(Stage::Descent) => "descent",
                Some(Stage::Fine) | None => "fine",
            },
            steps: kept.map(|(_, step)| (step.iteration, step.cost as f32)).collect(),
        }
    });
    each.collect()
}

/// At one contact with each fixture, and across the workspace.
fn uncertainty(problem: &Problem, estimate: &Estimate) -> Option<Uncertainty> {
    let contacts = &problem.contacts;
    let mut touching: Vec<Vec<usize>> = vec![Vec::new(); problem.fixtures.len()];
    (0..contacts.len()).for_each(|i| touching[contacts.fixture(i)].push(i));
    let middle: Vec<(usize, usize)> =
        touching.iter().enumerate().filter_map(|(f, which)| Some((f, *which.get(which.len() / 2)?))).collect();
    let across = workspace_configurations(&problem.robot, WORKSPACE_POSES);
    let at_fixtures = tool_uncertainty(problem, estimate, middle.iter().map(|&(_, i)| contacts.q(i)))?;
    let tool = problem.tool.tip_from_tool * estimate.tool_motion().unwrap_or_else(Pose::identity);
    let kinematics = Kinematics::new(&estimate.robot, &[], tool);
    let placed = |(q, sigma): (&Vec<f64>, ToolUncertainty)| {
        let place = kinematics.pose(q).translation.vector;
        PlacedUncertainty { radius: place.xy().norm() as f32, height: place.z as f32, pose: entry(sigma) }
    };
    let in_workspace = tool_uncertainty(problem, estimate, across.iter().map(Vec::as_slice))?;
    Some(Uncertainty {
        fixtures: middle.iter().zip(at_fixtures).map(|(&(f, _), sigma)| (f, entry(sigma))).collect(),
        workspace: across.iter().zip(in_workspace).map(placed).collect(),
        distances: distance_uncertainty(problem, estimate, &across)?.into_iter().map(|sigma| sigma as f32).collect(),
    })
}

fn entry(sigma: ToolUncertainty) -> PoseUncertainty {
    PoseUncertainty { position: sigma.position as f32, angle: sigma.angle as f32 }
}

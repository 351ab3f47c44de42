//! The result of a calibration.

use std::path::PathBuf;

use nalgebra::DVector;
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use touchcal::estimate::{self, Verdict, apply_estimated_places, contact_distances};
use touchcal::io::calibration_folder::{self, Solved, Wanted};
use touchcal::io::estimate_file::EstimateFile;
use touchcal::io::urdf::{self, Ends};
use touchcal::io::{Export, SavedCalibration};
use touchcal::report::DeclarationTests;
use touchcal::robot::GRAVITY;

use crate::array::{fixed, numbers};
use crate::checks::{EffectTest, PredictiveCheck, PriorTest};
use crate::error::{io, optional_argument, unexpected};
use crate::estimate_tables;
use crate::evaluation::Evaluation;
use crate::frame::Frame;
use crate::list_of::ListOf;
use crate::pickle::{Reduced, reduced};
use crate::problem::Problem;
use crate::progress::Progress;
use crate::result::{
    Acceptance, CalibrationWarning, CompetingMinimum, NullDirection, Parameter, Termination, WorkspaceUncertainty,
};
use crate::robot::Robot;
use crate::score::Score;
use crate::summary::Summary;
use crate::threads::detached;

/// The result of a calibration. Check `usable` first.
///
/// `calibration["joint_offset.joint_a1"]` is the parameter of that name.
#[pyclass(frozen, module = "touchcal")]
#[derive(Debug)]
pub struct Calibration {
    problem: Py<Problem>,
    pub solved: Solved,
    pub file: EstimateFile,
}

#[pymethods]
impl Calibration {
    /// Whether the result may be used, with doubts or without: the search converged, and no warning
    /// forbids it.
    #[getter]
    fn usable(&self) -> bool {
        self.solved.estimate.status.is_usable()
    }

    /// "usable"; "doubtful" if contacts contradict something that `warnings` name, or are few; or
    /// "not_usable".
    #[getter]
    fn status(&self) -> &'static str {
        self.solved.estimate.status.name()
    }

    /// Estimated parameters, in order.
    #[getter]
    fn parameters(&self) -> Vec<Parameter> {
        self.file.parameters.iter().map(Into::into).collect()
    }

    /// Covariance of the parameters, in their order and units, shape (P, P).
    #[getter]
    fn covariance<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        estimate_tables::covariance(py, &self.file)
    }

    /// Number of directions of the parameters that the data determine.
    #[getter]
    fn rank(&self) -> usize {
        self.solved.estimate.identifiability.rank
    }

    /// Largest over smallest singular value of those directions.
    #[getter]
    fn condition(&self) -> f64 {
        self.solved.estimate.identifiability.condition
    }

    /// Singular values of the whitened Jacobian in units of the parameters' scales, largest first.
    #[getter]
    fn singular_values<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        fixed(py, self.solved.estimate.identifiability.singular_values.clone())
    }

    /// Directions of the parameters that the data do not determine.
    #[getter]
    fn null_space(&self) -> Vec<NullDirection> {
        NullDirection::each(&self.solved.estimate.identifiability, |k| self.file.parameters[k].name.clone())
    }

    /// Distances from contact with the nominal arm.
    #[getter]
    fn prefit(&self) -> Score {
        Score::new(&self.solved.prefit, &self.problem.get().loaded.problem.fixtures)
    }

    /// Distances from contact with the calibrated arm.
    #[getter]
    fn postfit(&self) -> Score {
        Score::new(&self.solved.estimate.postfit, &self.problem.get().loaded.problem.fixtures)
    }

    /// Weight of each contact, 0 to 1; 0 if it was rejected; shape (N,).
    #[getter]
    fn weights<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        let weight = |verdict: &Verdict| match verdict {
            Verdict::Used { weight } => *weight,
            Verdict::Rejected { .. } => 0.0,
        };
        fixed(py, self.solved.estimate.verdicts.iter().map(weight).collect())
    }

    /// Warnings, with advice.
    #[getter]
    fn warnings(&self) -> Vec<CalibrationWarning> {
        self.file.warnings.iter().cloned().map(CalibrationWarning::from).collect()
    }

    /// Score tests of effects that the model leaves out, the least p-value first; none where the
    /// search did not converge, or contacts have no likelihood.
    #[getter]
    fn effect_tests(&self) -> Vec<EffectTest> {
        self.solved.estimate.effect_tests.iter().map(EffectTest::from).collect()
    }

    /// Tests of what is declared with a standard deviation, the least p-value first; none where the
    /// search did not converge, or contacts are measured by a projection.
    #[getter]
    fn prior_tests(&self) -> Vec<PriorTest> {
        self.solved.estimate.prior_tests.iter().map(PriorTest::from).collect()
    }

    /// Names of effects and declarations that contacts cannot test: they would not show a plausible
    /// size of the effect, or determine nothing of what is declared better than that; and
    /// `friction`, where contacts with a hole have no known load.
    #[getter]
    fn untested(&self) -> Vec<String> {
        self.solved.estimate.untested.clone()
    }

    /// How well the tool is known across the workspace; None where contacts are measured by a
    /// projection.
    #[getter]
    fn workspace_uncertainty(&self) -> Option<WorkspaceUncertainty> {
        self.solved.estimate.workspace_uncertainty.map(WorkspaceUncertainty::from)
    }

    /// Minima that contacts do not rule out, the one with the least cost first.
    #[getter]
    fn competing_minima(&self) -> Vec<CompetingMinimum> {
        let estimate = &self.solved.estimate;
        estimate.competing_minima.iter().map(|other| CompetingMinimum::new(other, &estimate.parameters)).collect()
    }

    /// How far stretches of the log are from what the others predict; None where contacts are too
    /// few for two stretches, of sampled manifolds, or the search has not converged.
    #[getter]
    fn predictive_check(&self) -> Option<PredictiveCheck> {
        self.solved.estimate.predictive_check.as_ref().map(PredictiveCheck::from)
    }

    /// The result on contacts that were held out; None without any, and where contacts are measured
    /// by a projection.
    #[getter]
    fn held_out(&self) -> Option<Evaluation> {
        let fixtures = &self.problem.get().loaded.problem.fixtures;
        self.solved.estimate.held_out.clone().map(|evaluation| Evaluation::new(evaluation, fixtures))
    }

    /// Whether the calibration reaches what the table [accept] of its problem asks for; None if it
    /// asks nothing.
    #[getter]
    fn acceptance(&self) -> Option<Acceptance> {
        let asked = self.problem.get().loaded.problem.acceptance.as_ref();
        asked.zip(self.solved.estimate.acceptance.as_ref()).map(|(asked, result)| Acceptance::new(asked, result))
    }

    /// Why the search stopped.
    #[getter]
    fn termination(&self) -> Termination {
        (&self.solved.estimate.termination).into()
    }

    /// The steps of the search.
    #[getter]
    fn steps(&self) -> Vec<Progress> {
        self.solved.steps.iter().map(Into::into).collect()
    }

    /// Measured over declared standard deviation of the contacts.
    #[getter]
    fn noise_factor(&self) -> f64 {
        self.solved.estimate.noise_factor
    }

    /// Duration of the estimation (s).
    #[getter]
    fn seconds(&self) -> f64 {
        self.solved.seconds
    }

    /// The calibrated arm, as calibrated.urdf has it.
    #[getter]
    fn robot(&self) -> PyResult<Robot> {
        let nominal = &self.problem.get().loaded.problem.robot;
        let text = self.calibrated_urdf()?;
        let robot = urdf::read(
            &text,
            calibration_folder::CALIBRATED,
            Ends { base: Some(nominal.base()), tip: Some(nominal.tip()) },
        );
        Ok(Robot::new(robot.map_err(io)?.with_gravity(*nominal.gravity()), text, &[]))
    }

    /// Pose of the tool on the tip link of the nominal arm as estimated, shape
    /// (7,).
    #[getter]
    fn tip_from_tool<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        fixed(py, numbers(&self.with_estimated_poses().tool.tip_from_tool).to_vec())
    }

    /// Poses of the fixtures in the base frame as estimated, shape (7,), by name; only of
    /// those with a nominal pose.
    #[getter]
    fn base_from_fixture<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let places = PyDict::new(py);
        for fixture in self.with_estimated_poses().fixtures {
            if let Some(pose) = &fixture.base_from_fixture {
                places.set_item(&fixture.name, fixed(py, numbers(pose).to_vec()))?;
            }
        }
        Ok(places)
    }

    /// The result in some lines: the verdict and the expected error of the tool before and after
    /// the calibration, contacts, noise, ten parameters at most in mm and degrees, what is not
    /// determined, what contacts say against the problem (`effect_tests`, `prior_tests`,
    /// `untested`), and warnings.
    fn summary(&self) -> String {
        self.summary_of(10).text()
    }

    fn _repr_html_(&self) -> String {
        self.summary_of(100).html()
    }

    fn _ipython_key_completions_(&self) -> Vec<&str> {
        self.file.parameters.iter().map(|entry| entry.name.as_str()).collect()
    }

    fn __getitem__(&self, name: &str) -> PyResult<Parameter> {
        estimate_tables::parameter(&self.file, name)
    }

    /// A row a parameter: name, block, unit, value, sigma, prior_sigma, identifiable.
    fn to_pandas<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        estimate_tables::parameters_frame(py, &self.file)
    }

    /// The covariance with the names of the parameters as index and columns, in their units.
    fn covariance_frame<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        estimate_tables::covariance_frame(py, &self.file)
    }

    /// A row a contact: fixture, file, line, distance from contact (m) with the nominal and the
    /// calibrated arm, weight.
    fn contacts_to_pandas<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let problem = &self.problem.get().loaded.problem;
        let values = self.solved.estimate.values();
        let (before, after) = detached(py, || {
            (contact_distances(problem, &DVector::zeros(values.len())), contact_distances(problem, &values))
        });
        let log = &problem.contacts;
        let file = |i: usize| log.files().get(log.source(i).file as usize).map_or("", String::as_str);
        Frame::new(py)
            .column("fixture", (0..log.len()).map(|i| &problem.fixtures[log.fixture(i)].name).collect::<Vec<_>>())?
            .column("file", (0..log.len()).map(file).collect::<Vec<_>>())?
            .column("line", (0..log.len()).map(|i| log.source(i).line).collect::<Vec<_>>())?
            .column("before", fixed(py, before))?
            .column("after", fixed(py, after))?
            .column("weight", self.weights(py))?
            .build()
    }

    /// The text of calibrated.urdf.
    fn calibrated_urdf(&self) -> PyResult<String> {
        calibration_folder::calibrated_urdf(&self.problem.get().loaded, &self.solved.estimate).map_err(io)
    }

    /// The text of estimate.json.
    fn to_json(&self) -> PyResult<String> {
        self.file.to_json().map_err(io)
    }

    /// The text of report.html, a page that loads nothing.
    fn to_html(&self, py: Python<'_>) -> PyResult<String> {
        let loaded = &self.problem.get().loaded;
        detached(py, || calibration_folder::page(loaded, &self.solved, &self.file)).map_err(io)
    }

    /// Writes calibrated.urdf, estimate.json and report.html into a folder, as `touchcal calibrate
    /// --out` does, and correction.json where joints need corrections that no URDF can say.
    ///
    /// Args:
    ///     folder: where to write; it is made if missing.
    ///     export: formats of `touchcal calibrate --export` whose files are written too: "ur",
    ///         "dh", "xacro", "ros2_control".
    ///
    /// Returns:
    ///     the paths of calibrated.urdf, estimate.json and report.html.
    #[pyo3(signature = (folder, *, export=None))]
    fn save(
        &self,
        py: Python<'_>,
        folder: PathBuf,
        export: Option<Bound<'_, PyAny>>,
    ) -> PyResult<(PathBuf, PathBuf, PathBuf)> {
        let loaded = &self.problem.get().loaded;
        let export: Option<ListOf<String>> = optional_argument(export.as_ref(), "export")?;
        let exports =
            export.iter().flat_map(|names| &names.0).map(|name| export_named(name)).collect::<PyResult<_>>()?;
        let wanted = Wanted { exports, ..Wanted::default() };
        let write = || calibration_folder::write(&folder, loaded, &self.solved, &self.file, &wanted);
        let written = detached(py, write).map_err(io)?;
        Ok((written.urdf, written.estimate, written.report))
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Reduced<'py>> {
        reduced(py, "Calibration", &self.solved, Some(self.problem.clone_ref(py).into_any()))
    }

    fn __repr__(&self) -> String {
        let (parameters, rms) = (self.file.parameters.len(), 1e3 * self.solved.estimate.postfit.all.rms);
        format!("Calibration({:?}, {parameters} parameters, {rms:.3} mm rms)", self.status())
    }
}

impl Calibration {
    /// The result of a problem.
    pub fn new(problem: Py<Problem>, solved: Solved) -> Self {
        let file = calibration_folder::estimate_file(&problem.get().loaded, &solved);
        Calibration { problem, solved, file }
    }

    /// Its summary with `most` parameters.
    fn summary_of(&self, most: usize) -> Summary {
        let tests = DeclarationTests::new(&self.solved.estimate, &self.problem.get().loaded.problem);
        Summary::new(&self.file, Some(self.noise()), Some(tests), most)
    }

    /// Measured over declared noise, in words.
    fn noise(&self) -> String {
        let is_estimated = self.problem.get().loaded.problem.noise.is_estimated;
        let source = if is_estimated { "estimated" } else { "declared" };
        format!("{:.2} times the {source} noise", self.solved.estimate.noise_factor)
    }

    /// What its files would have, under a name for messages.
    pub fn as_saved(&self, name: &str) -> PyResult<SavedCalibration> {
        let mut urdf = self.robot()?.file;
        urdf.robot = urdf.robot.with_gravity(GRAVITY.into());
        Ok(SavedCalibration { name: name.to_owned(), file: self.file.clone(), urdf: Some(urdf) })
    }

    /// The problem with the estimated poses of tool and fixtures.
    fn with_estimated_poses(&self) -> estimate::Problem {
        let mut problem = self.problem.get().loaded.problem.clone();
        apply_estimated_places(&mut problem, |name| {
            self.solved.estimate.parameter(name).map(|parameter| parameter.value)
        });
        problem
    }
}

/// The export format of that name.
fn export_named(name: &str) -> PyResult<Export> {
    let found = Export::ALL.into_iter().find(|export| export.name() == name);
    found.ok_or_else(|| unexpected("export", Export::ALL.map(Export::name).join(", "), format!("{name:?}")))
}

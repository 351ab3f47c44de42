//! Errors of the tool relative to the true arm.

use std::collections::BTreeMap;
use std::path::Path;

use touchcal::estimate::{Problem, workspace_configurations};
use touchcal::experiment::{PoseErrors, RmsAndMax, pose_errors};
use touchcal::io::Input;
use touchcal::io::estimate_file::EstimateFile;
use touchcal::io::truth_file::{self, TruthFile};
use touchcal::parameter::Unit;
use touchcal::report::{ToolError, fixed, signed};
use touchcal::robot::{EncoderTerm, Kinematics, subtract_encoder_errors};
use touchcal::se3::Pose;

use crate::failure::Failure;
use crate::summary::millimetres;
use crate::table::Table;

/// Configurations over the workspace at which poses are compared.
const CONFIGURATIONS: usize = 1000;
/// Most parameters listed one by one.
const MOST_PARAMETERS: usize = 10;

/// Errors of encoders: index of the moving joint, base first, term, and amplitude (SI).
type EncoderErrors = [(usize, EncoderTerm, f64)];

/// The true arm.
pub struct TrueArm {
    /// Measured joint positions (rad, m).
    positions: Vec<Vec<f64>>,
    /// True poses `base_from_tool` there.
    poses: Vec<Pose>,
    /// True values (SI) of parameters by name.
    by_name: BTreeMap<String, f64>,
    /// The file with its fingerprint.
    pub input: Input,
}

/// A parameter's estimate beside its true value (SI).
pub struct ParameterError {
    /// Name of the parameter.
    pub name: String,
    pub unit: Unit,
    pub truth: f64,
    pub estimated: f64,
    /// Standard deviation of the estimate; none where nothing bounds it.
    pub sigma: Option<f64>,
    /// Whether contacts determine it.
    pub is_identifiable: bool,
}

impl ParameterError {
    /// Estimated minus true value.
    pub fn difference(&self) -> f64 {
        self.estimated - self.truth
    }

    /// The difference over the standard deviation; none where contacts do not determine the
    /// parameter.
    pub fn deviations(&self) -> Option<f64> {
        let sigma = self.sigma.filter(|sigma| self.is_identifiable && *sigma > 0.0)?;
        Some(self.difference() / sigma)
    }
}

/// Poses `base_from_tool` at measured joint positions.
fn poses(kinematics: &Kinematics, positions: &[Vec<f64>], encoder_errors: &EncoderErrors) -> Vec<Pose> {
    let pose = |measured: &Vec<f64>| {
        let mut q = measured.clone();
        subtract_encoder_errors(encoder_errors, measured, &mut q);
        kinematics.pose(&q)
    };
    positions.iter().map(pose).collect()
}

impl TrueArm {
    /// The arm and tool of `problem` with the errors in a file, which is refused where the tool was
    /// declared at another pose.
    pub fn read(path: &Path, problem: &Problem) -> Result<Self, Failure> {
        let truth = truth_file::read_file(path, &problem.robot)?;
        truth.check_tool(&problem.tool.tip_from_tool)?;
        let TruthFile { parameters, values, encoder_errors, by_name, input, .. } = truth;
        let mut kinematics = Kinematics::new(&problem.robot, &parameters, problem.tool.tip_from_tool);
        kinematics.set(&values);
        let positions = workspace_configurations(&problem.robot, CONFIGURATIONS);
        let poses = poses(&kinematics, &positions, &encoder_errors);
        Ok(TrueArm { positions, poses, by_name, input })
    }

    /// Errors of the arm and tool of `problem`, whose encoders are corrected by these errors.
    pub fn errors_of(&self, problem: &Problem, encoder_errors: &EncoderErrors) -> PoseErrors {
        let kinematics = Kinematics::new(&problem.robot, &[], problem.tool.tip_from_tool);
        pose_errors(&self.poses, &poses(&kinematics, &self.positions, encoder_errors))
    }

    /// The parameters of `estimate` whose true values are known, those that contacts determine
    /// first. Places of fixtures of `problem` without a declared one are left out: their estimates
    /// are relative to where the nominal arm has them.
    pub fn parameters(&self, problem: &Problem, estimate: &EstimateFile) -> Vec<ParameterError> {
        let unplaced = problem.fixtures.iter().filter(|fixture| fixture.base_from_fixture.is_none());
        let unplaced: Vec<String> = unplaced.map(|fixture| format!("fixture.{}", fixture.name)).collect();
        let known = estimate.parameters.iter().filter_map(|entry| {
            let is_relative = entry.name.rsplit_once('.').is_some_and(|(of, _)| unplaced.iter().any(|name| name == of));
            let truth = self.by_name.get(&entry.name).filter(|_| !is_relative)?;
            Some(ParameterError {
                name: entry.name.clone(),
                unit: Unit::from_symbol(&entry.unit)?,
                truth: *truth,
                estimated: entry.value,
                sigma: entry.sigma,
                is_identifiable: entry.identifiable,
            })
        });
        let mut known: Vec<ParameterError> = known.collect();
        known.sort_by_key(|error| !error.is_identifiable);
        known
    }
}

/// Errors with the nominal and the given arm, a row each.
pub fn rows([nominal, given]: &[PoseErrors; 2]) -> Vec<ToolError> {
    let row = |name: &'static str, unit: Unit, of: fn(&PoseErrors) -> RmsAndMax| {
        let [nominal, given] = [nominal, given].map(of).map(|errors| [errors.rms, errors.max]);
        ToolError { name, unit, nominal, given }
    };
    vec![
        row("position in base", Unit::Meter, |errors| errors.position),
        row("rotation in base", Unit::Radian, |errors| errors.angle),
        row("position, base aligned", Unit::Meter, |errors| errors.aligned_position),
        row("rotation, base aligned", Unit::Radian, |errors| errors.aligned_angle),
        row("distance of two positions", Unit::Meter, |errors| errors.distance),
    ]
}

/// A table of parameters, of which `all` or the first ten are listed; nothing where none is known.
pub fn parameter_table(errors: &[ParameterError], all: bool) -> String {
    if errors.is_empty() {
        return String::new();
    }
    let shown = if all { errors.len() } else { MOST_PARAMETERS };
    let mut table = Table::new(["parameter", "true", "estimated", "difference", "difference/sigma", "unit"]);
    for error in errors.iter().take(shown) {
        let (factor, symbol, decimals) = error.unit.in_user_units();
        let [truth, estimated, difference] =
            [error.truth, error.estimated, error.difference()].map(|value| signed(factor * value, decimals));
        let deviations = match error.is_identifiable {
            true => error.deviations().map_or_else(|| "-".to_owned(), |deviations| signed(deviations, 1)),
            false => "not identifiable".to_owned(),
        };
        table.row([error.name.clone(), truth, estimated, difference, deviations, symbol.to_owned()]);
    }
    let more = match errors.len().saturating_sub(shown) {
        0 => String::new(),
        more => {
            let unknown = errors.iter().skip(shown).filter(|error| !error.is_identifiable).count();
            format!("  … and {more} more, of which {unknown} are not identifiable (--all lists them)\n")
        }
    };
    format!(
        "Parameters of the calibration relative to the true ones\n{table}{more}  \
         Where directions are not identifiable, or errors of the true arm are not estimated and others make up for\n  them, single parameters do not compare: only the tool's errors above do.\n\n"
    )
}

/// A table of errors with the nominal and the given arm.
pub fn text(errors: &[PoseErrors; 2]) -> String {
    let mut table = Table::new(["", "nominal: rms", "max", "given: rms", "max", "unit"]);
    for ToolError { name, unit, nominal, given } in rows(errors) {
        let shown = |value: f64| if unit == Unit::Meter { millimetres(value) } else { fixed(value.to_degrees(), 4) };
        let numbers = [nominal, given].concat().into_iter().map(shown);
        let (_, symbol, _) = unit.in_user_units();
        table.row([name.to_owned()].into_iter().chain(numbers).chain([symbol.to_owned()]));
    }
    format!(
        "Error of the tool relative to the true arm, at {CONFIGURATIONS} configurations over the workspace\n{table}\n"
    )
}

//! The Python package `touchcal`: a thin layer over the library, one file for each idea.
//!
//! Arguments become the library's types at the door, with its own error texts; solves run without
//! the interpreter's lock; results are read-only. What is documented for Python users stands at the
//! classes and in `touchcal/_touchcal.pyi`.

mod array;
mod calibrate;
mod calibration;
mod campaign;
mod checks;
mod comparison;
mod error;
mod estimate_tables;
mod evaluate;
mod evaluation;
mod frame;
mod inspection;
mod list_of;
mod log;
mod log_options;
mod manifold;
mod parts;
mod pickle;
mod plausible;
mod problem;
mod problem_arguments;
mod problem_changes;
mod progress;
mod repr;
mod restore;
mod result;
mod robot;
mod saved;
mod score;
mod selection;
mod simulation;
mod summary;
mod threads;
mod toml_value;

/// Calibrate a robot arm by touch.
#[pyo3::pymodule]
mod _touchcal {
    #[pymodule_export]
    use crate::array::pose;
    #[pymodule_export]
    use crate::calibrate::calibrate;
    #[pymodule_export]
    use crate::calibration::Calibration;
    #[pymodule_export]
    use crate::campaign::Campaign;
    #[pymodule_export]
    use crate::checks::{EffectTest, PredictiveCheck, PriorTest};
    #[pymodule_export]
    use crate::comparison::{Comparison, ParameterChange, compare};
    #[pymodule_export]
    use crate::error::{Error, FileError, InputError, SimulationError};
    #[pymodule_export]
    use crate::evaluate::evaluate;
    #[pymodule_export]
    use crate::evaluation::{Evaluation, FixtureDistance, Scatter};
    #[pymodule_export]
    use crate::inspection::{Expected, Inspection, JointRange, inspect};
    #[pymodule_export]
    use crate::log::ContactLog;
    #[pymodule_export]
    use crate::manifold::{Manifold, extrusion25, offset_outline, project, read_outline};
    #[pymodule_export]
    use crate::parts::{Fixture, Tool};
    #[pymodule_export]
    use crate::problem::Problem;
    #[pymodule_export]
    use crate::progress::Progress;
    #[pymodule_export]
    use crate::result::{
        Acceptance, CalibrationWarning, CompetingMinimum, NullDirection, Parameter, Termination, WorkspaceUncertainty,
    };
    #[pymodule_export]
    use crate::robot::Robot;
    #[pymodule_export]
    use crate::saved::SavedCalibration;
    #[pymodule_export]
    use crate::score::{Score, Spread};
    #[pymodule_export]
    use crate::selection::{BlockGain, ComparedModel, ModelChoice, select};
    #[pymodule_export]
    use crate::simulation::{Simulation, simulate};
    use pyo3::prelude::*;

    #[pymodule_init]
    fn finish(module: &Bound<'_, PyModule>) -> PyResult<()> {
        crate::threads::imported();
        crate::restore::register(module)?;
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}

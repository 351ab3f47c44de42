//! Objects of the bytes that pickle sends to other processes: equal ones, if these have the same
//! version of touchcal.

use ciborium::from_reader;
use pyo3::PyTypeInfo;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyType;
use serde::de::DeserializeOwned;
use touchcal::estimate;
use touchcal::io::Loaded;
use touchcal::io::calibration_folder::Solved;

use crate::calibration::Calibration;
use crate::checks::{EffectTest, PredictiveCheck, PriorTest};
use crate::comparison::{Comparison, ParameterChange};
use crate::error::{refused, unexpected};
use crate::evaluation::{Evaluation, FixtureDistance, Scatter};
use crate::inspection::{Expected, Inspection, JointRange};
use crate::log::ContactLog;
use crate::manifold::Manifold;
use crate::parts::{Fixture, Tool};
use crate::pickle::{Reduced, check_version, reduced};
use crate::problem::{_rebuild, Problem};
use crate::progress::Progress;
use crate::result::{
    Acceptance, CalibrationWarning, CompetingMinimum, NullDirection, Parameter, Termination, WorkspaceUncertainty,
};
use crate::robot::Robot;
use crate::saved::SavedCalibration;
use crate::score::{Score, Spread};
use crate::selection::{BlockGain, Compared, ComparedModel, ModelChoice};

fn data<T: DeserializeOwned>(bytes: &[u8]) -> PyResult<T> {
    from_reader(bytes).map_err(|error| refused("pickle", error))
}

/// Classes whose objects are their own data.
macro_rules! classes_of_data {
    ($($class:ident),* $(,)?) => {
        /// What pickle takes of an object that is its own data.
        #[pyfunction]
        fn _reduce<'py>(object: &Bound<'py, PyAny>) -> PyResult<Reduced<'py>> {
            $(if let Ok(object) = object.cast::<$class>() {
                return reduced(object.py(), stringify!($class), object.get(), None);
            })*
            Err(PyTypeError::new_err(format!("cannot pickle {object}")))
        }

        fn own_data<'py>(py: Python<'py>, class: &str, bytes: &[u8]) -> PyResult<Bound<'py, PyAny>> {
            match class {
                $(stringify!($class) => Ok(Bound::new(py, data::<$class>(bytes)?)?.into_any()),)*
                other => Err(unexpected("pickle", "a class of touchcal", format!("{other:?}"))),
            }
        }

        /// Tells pickle of the classes whose objects are their own data, and gives it the functions
        /// that make objects again.
        pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
            let py = module.py();
            // Not among the names that a module exports.
            module.setattr("_rebuild", wrap_pyfunction!(_rebuild, module)?)?;
            module.setattr("_restore", wrap_pyfunction!(_restore, module)?)?;
            let (register, reduce) = (py.import("copyreg")?.getattr("pickle")?, wrap_pyfunction!(_reduce, module)?);
            let classes: Vec<Bound<'_, PyType>> = vec![$(<$class>::type_object(py)),*];
            classes.iter().try_for_each(|class| register.call1((class, &reduce)).map(drop))
        }
    };
}

classes_of_data!(
    Acceptance,
    BlockGain,
    CalibrationWarning,
    ComparedModel,
    Comparison,
    CompetingMinimum,
    ContactLog,
    EffectTest,
    Evaluation,
    Expected,
    Fixture,
    FixtureDistance,
    JointRange,
    Manifold,
    NullDirection,
    Parameter,
    ParameterChange,
    PredictiveCheck,
    PriorTest,
    Progress,
    Robot,
    SavedCalibration,
    Scatter,
    Score,
    Spread,
    Termination,
    Tool,
    WorkspaceUncertainty,
);

/// The object that `reduced` took apart.
#[pyfunction]
fn _restore<'py>(
    py: Python<'py>,
    class: &str,
    version: &str,
    bytes: &[u8],
    problem: Option<Py<Problem>>,
) -> PyResult<Bound<'py, PyAny>> {
    check_version(version)?;
    match (class, problem) {
        ("Calibration", Some(problem)) => {
            Ok(Bound::new(py, Calibration::new(problem, data::<Solved>(bytes)?))?.into_any())
        }
        ("Inspection", Some(problem)) => {
            let inspection = data::<estimate::Inspection>(bytes)?;
            Ok(Bound::new(py, Inspection { problem, inspection })?.into_any())
        }
        ("ModelChoice", Some(problem)) => {
            Ok(Bound::new(py, ModelChoice { problem, compared: data::<Compared>(bytes)? })?.into_any())
        }
        ("Problem", None) => Ok(Bound::new(py, Problem::of(data::<Loaded>(bytes)?)?)?.into_any()),
        (class, _) => own_data(py, class, bytes),
    }
}

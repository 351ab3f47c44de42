//! Logs of contacts: from arrays, data frames and files.

use std::collections::BTreeMap;
use std::ffi::CString;
use std::path::PathBuf;

use numpy::{PyArray1, PyArray2, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::exceptions::PyUserWarning;
use pyo3::prelude::*;
use pyo3::types::IntoPyDict;
use serde::{Deserialize, Serialize};
use touchcal::io::Input;
use touchcal::io::contact_log::{self, Columns, Options};

use crate::array::{Numbers, fixed, fixed_rows};
use crate::error::{Given, argument, io, optional_argument, unexpected};
use crate::list_of::ListOf;
use crate::log_options::options;
use crate::robot::Robot;
use crate::threads::detached;

const WRENCH: [&str; 6] = ["fx", "fy", "fz", "tx", "ty", "tz"];

/// Joint positions of an arm whose tool touched one fixture, a row a contact.
///
/// Rows are contacts where the force exceeds `force_threshold`, if it is given; else where they are
/// flagged, if there are flags; else all.
#[pyclass(frozen, module = "touchcal")]
#[derive(Debug, Serialize, Deserialize)]
pub struct ContactLog {
    pub log: touchcal::contact::ContactLog,
    pub input: Input,
}

impl ContactLog {
    /// From columns of numbers in memory.
    fn from_columns(columns: &Columns<'_>, name: &str, robot: &Robot, options: &Options) -> PyResult<ContactLog> {
        let robot = &robot.file.robot;
        let mut log = touchcal::contact::ContactLog::new(robot.dof());
        let input = contact_log::read_columns(columns, name, robot, options, &mut log).map_err(io)?;
        Ok(ContactLog { log, input })
    }

    /// With what was taken for granted said as warnings.
    fn with_warnings(self, py: Python<'_>) -> PyResult<ContactLog> {
        warn(py, self.log.notes())?;
        Ok(self)
    }
}

/// Says what was taken for granted in reading.
pub fn warn(py: Python<'_>, notes: &[String]) -> PyResult<()> {
    for note in notes {
        PyErr::warn(py, &py.get_type::<PyUserWarning>(), &CString::new(note.as_str())?, 1)?;
    }
    Ok(())
}

/// The parts of a log in arrays, each with the names of its columns.
struct Arrays<'a, 'py>(Vec<(&'a Numbers<'py>, Vec<String>)>);

impl<'a, 'py> Arrays<'a, 'py> {
    /// Appends an array of so many rows, or of any number if it is the first, with a column for
    /// each name.
    fn with(mut self, what: &str, array: &'a Numbers<'py>, names: Vec<String>) -> PyResult<Self> {
        let shape = array.shape();
        let rows = self.0.first().map(|(first, _)| first.shape()[0]);
        let (given, columns) = match *shape {
            [given] if names.len() == 1 => (given, 1),
            [given, columns] => (given, columns),
            _ => (usize::MAX, 0),
        };
        if columns != names.len() || rows.is_some_and(|rows| rows != given) {
            let rows = rows.map_or("N".to_owned(), |rows| rows.to_string());
            let expected =
                if names.len() == 1 { format!("shape ({rows},)") } else { format!("shape ({rows}, {})", names.len()) };
            return Err(unexpected(what, expected, format!("shape {shape:?}")));
        }
        self.0.push((array, names));
        Ok(self)
    }

    /// The log that they are.
    fn read(&self, name: &str, robot: &Robot, options: &Options) -> PyResult<ContactLog> {
        let names: Vec<String> = self.0.iter().flat_map(|(_, names)| names.iter().cloned()).collect();
        let rows = self.0.first().map_or(0, |(first, _)| first.shape()[0]);
        let views: Vec<_> = self.0.iter().map(|(array, _)| array.as_array()).collect();
        let places: Vec<(usize, usize)> =
            self.0.iter().enumerate().flat_map(|(part, (_, names))| (0..names.len()).map(move |k| (part, k))).collect();
        let value = |row: usize, column: usize| {
            let (part, k) = places[column];
            let view = &views[part];
            if view.ndim() == 1 { view[[row]] } else { view[[row, k]] }
        };
        ContactLog::from_columns(&Columns { names: &names, rows, value: &value }, name, robot, options)
    }
}

#[pymethods]
#[allow(clippy::too_many_arguments, reason = "most are keywords with a default")]
impl ContactLog {
    /// A log from arrays; those of float64 are read where they are.
    ///
    /// Args:
    ///     robot: whose joints these are.
    ///     q: joint positions (rad or m), shape (N, dof), columns in the order of `robot.joints`
    ///         unless `joints` says otherwise.
    ///     wrench: forces and torques `fx, fy, fz, tx, ty, tz` (N, N m), shape (N, 6).
    ///     joint_torques: measured torque about each joint (N m, or N of a prismatic one), shape
    ///         (N, dof), columns as in `q`; needs `tau_joint`.
    ///     contact: whether a row is a contact, shape (N,).
    ///     unit: of the revolute joints: "rad" or "deg"; default: radians, but guessed, with a
    ///         warning, if columns are named as KUKA's recorder does.
    ///     joints: names of the moving joints in the order of the columns.
    ///     force_threshold: force (N) above which contact begins; needs `wrench`.
    ///     release: force (N) below which it ends; default: the threshold.
    ///     debounce: rows in a row that either takes.
    ///     apart: how far (rad or m) some joint must have moved since the last contact for a row to
    ///         be another one; default: every row is.
    ///     load_on: what the wrench is exerted on, without the tool's weight: "tool" or "fixture";
    ///         it tells which surfaces of a hole are touched, and deflects compliant joints.
    ///         Default: the load is not known.
    ///     load_frame: the axes along which it is given, about the tip's origin: "tip" or "base";
    ///         default: "tip".
    ///     load_lag: rows by which the wrench lags behind the joint positions, at least 0; default:
    ///         0. A low-pass filter of time constant T has a lag of 1 / (exp(dt / T) - 1). All rows
    ///         must be there, those without contact too, at even distances in time.
    ///     tau_joint: side whose torques the log has, by which joints deflect in place of gravity
    ///         and a load: "load" (what gravity and contact exert) or "motor" (what the joints
    ///         exert).
    ///         Default: they are not known.
    ///     temperature: of the arm (degrees Celsius), shape (N,).
    ///     name: what stands for the file in messages, reports and estimate.json.
    ///
    /// Raises:
    ///     InputError: as for a file: numbers that are not finite, degrees where radians are
    ///         declared, and so on.
    #[staticmethod]
    #[pyo3(signature = (robot, q, *, wrench=None, joint_torques=None, contact=None, unit=None, joints=None, force_threshold=None, release=None, debounce=1, apart=None, load_on=None, load_frame=None, load_lag=None, tau_joint=None, temperature=None, name="array"))]
    fn from_numpy(
        robot: &Bound<'_, PyAny>,
        q: Numbers<'_>,
        wrench: Option<Numbers<'_>>,
        joint_torques: Option<Numbers<'_>>,
        contact: Option<Numbers<'_>>,
        unit: Option<&str>,
        joints: Option<Bound<'_, PyAny>>,
        force_threshold: Option<f64>,
        release: Option<f64>,
        debounce: usize,
        apart: Option<f64>,
        load_on: Option<&str>,
        load_frame: Option<&str>,
        load_lag: Option<f64>,
        tau_joint: Option<&str>,
        temperature: Option<Numbers<'_>>,
        name: &str,
    ) -> PyResult<ContactLog> {
        let robot = argument::<Given<Robot>>(robot, "robot")?.0;
        let robot = robot.get();
        let mut options = options(
            unit,
            joints.as_ref(),
            None,
            (force_threshold, release, debounce, apart),
            ((load_on, load_frame, load_lag), tau_joint),
        )?;
        let joints = (1..=robot.file.robot.dof()).map(|number| format!("q{number}")).collect();
        let mut arrays = Arrays(Vec::new()).with("q", &q, joints)?;
        if let Some(wrench) = &wrench {
            arrays = arrays.with("wrench", wrench, WRENCH.map(str::to_owned).to_vec())?;
        }
        match (&joint_torques, options.joint_torques) {
            (Some(torques), Some(_)) => {
                let names = (1..=robot.file.robot.dof()).map(|number| format!("tau_{number}")).collect();
                arrays = arrays.with("joint_torques", torques, names)?;
            }
            (None, None) => {}
            _ => return Err(unexpected("joint_torques", "`joint_torques` with `tau_joint`", "one without the other")),
        }
        if let Some(contact) = &contact {
            arrays = arrays.with("contact", contact, vec!["contact".to_owned()])?;
        }
        if let Some(temperature) = &temperature {
            arrays = arrays.with("temperature", temperature, vec!["temperature".to_owned()])?;
            options.temperature = Some("temperature".to_owned());
        }
        arrays.read(name, robot, &options)?.with_warnings(q.py())
    }

    /// A log from a pandas DataFrame, whose columns are named as in a file: joint names or `q1` to
    /// `qn`, `fx` to `tz`, `contact`; others are ignored.
    ///
    /// Args:
    ///     robot, unit, joints, force_threshold, release, debounce, apart, load_on, load_frame,
    ///         load_lag, tau_joint, name: as for `from_numpy`.
    ///     frame: the columns; joint positions in rad or m.
    ///     columns: by usual name, the frame's name for that column.
    ///     temperature: name of the column of the arm's temperature (degrees Celsius).
    #[staticmethod]
    #[pyo3(signature = (robot, frame, *, unit=None, joints=None, columns=None, force_threshold=None, release=None, debounce=1, apart=None, load_on=None, load_frame=None, load_lag=None, tau_joint=None, temperature=None, name="DataFrame"))]
    fn from_pandas(
        robot: &Bound<'_, PyAny>,
        frame: Bound<'_, PyAny>,
        unit: Option<&str>,
        joints: Option<Bound<'_, PyAny>>,
        columns: Option<BTreeMap<String, String>>,
        force_threshold: Option<f64>,
        release: Option<f64>,
        debounce: usize,
        apart: Option<f64>,
        load_on: Option<&str>,
        load_frame: Option<&str>,
        load_lag: Option<f64>,
        tau_joint: Option<&str>,
        temperature: Option<String>,
        name: &str,
    ) -> PyResult<ContactLog> {
        let robot = argument::<Given<Robot>>(robot, "robot")?.0;
        let robot = robot.get();
        let options = options(
            unit,
            joints.as_ref(),
            columns,
            (force_threshold, release, debounce, apart),
            ((load_on, load_frame, load_lag), tau_joint),
        )?;
        let options = Options { temperature, ..options };
        let labels: Vec<Bound<'_, PyAny>> = frame.getattr("columns")?.try_iter()?.collect::<PyResult<_>>()?;
        let names = labels.iter().map(|label| Ok(label.str()?.to_string())).collect::<PyResult<Vec<String>>>()?;
        let at = frame.getattr("iloc")?;
        // What is no number matters only if its column is asked for, and is then refused as not
        // finite.
        let numbers = (0..names.len()).map(|k| {
            let column = at.get_item((pyo3::types::PySlice::full(frame.py()), k)).ok()?;
            let numbers = column.call_method1("to_numpy", ("float64",)).or_else(|_| as_far_as_numbers(&column));
            numbers.ok()?.extract::<Numbers<'_>>().ok()
        });
        let numbers: Vec<Option<Numbers<'_>>> = numbers.collect();
        let views: Vec<_> = numbers.iter().map(|column| column.as_ref().map(|column| column.as_array())).collect();
        let value = |row: usize, column: usize| views[column].as_ref().map_or(f64::NAN, |column| column[[row]]);
        ContactLog::from_columns(&Columns { names: &names, rows: frame.len()?, value: &value }, name, robot, &options)?
            .with_warnings(frame.py())
    }

    /// A log from a file: CSV, plain or gzipped, Parquet, or a ROS 2 bag in MCAP.
    ///
    /// Args:
    ///     robot, unit, joints, force_threshold, release, debounce, apart, load_on, load_frame,
    ///         load_lag, tau_joint: as for `from_numpy`.
    ///     path: the file; a header names its columns, as for `from_pandas`; without one they are
    ///         the joints in order, or what `header` says.
    ///     header: names of the columns of a CSV file that has no header.
    ///     columns: by usual name, the file's name for that column, or for that joint in a bag.
    ///     temperature: name of the column of the arm's temperature (degrees Celsius); a bag has
    ///         none.
    ///     joint_topic, wrench_topic: topics of a bag; default: the only one of their type.
    #[staticmethod]
    #[pyo3(signature = (robot, path, *, unit=None, joints=None, header=None, columns=None, joint_topic=None, wrench_topic=None, force_threshold=None, release=None, debounce=1, apart=None, load_on=None, load_frame=None, load_lag=None, tau_joint=None, temperature=None))]
    fn from_file(
        py: Python<'_>,
        robot: &Bound<'_, PyAny>,
        path: PathBuf,
        unit: Option<&str>,
        joints: Option<Bound<'_, PyAny>>,
        header: Option<Bound<'_, PyAny>>,
        columns: Option<BTreeMap<String, String>>,
        joint_topic: Option<String>,
        wrench_topic: Option<String>,
        force_threshold: Option<f64>,
        release: Option<f64>,
        debounce: usize,
        apart: Option<f64>,
        load_on: Option<&str>,
        load_frame: Option<&str>,
        load_lag: Option<f64>,
        tau_joint: Option<&str>,
        temperature: Option<String>,
    ) -> PyResult<ContactLog> {
        let robot = argument::<Given<Robot>>(robot, "robot")?.0;
        let robot = robot.get();
        let options = options(
            unit,
            joints.as_ref(),
            columns,
            (force_threshold, release, debounce, apart),
            ((load_on, load_frame, load_lag), tau_joint),
        )?;
        let header = optional_argument::<ListOf<String>>(header.as_ref(), "header")?.map(|header| header.0);
        let options = Options { header, temperature, joint_topic, wrench_topic, ..options };
        let robot = &robot.file.robot;
        let mut log = touchcal::contact::ContactLog::new(robot.dof());
        let input = detached(py, || contact_log::read_file(&path, robot, &options, &mut log)).map_err(io)?;
        ContactLog { log, input }.with_warnings(py)
    }

    /// Temperature of the arm in each contact (degrees Celsius), shape (len,); NaN where it is not
    /// known.
    #[getter]
    fn temperature<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        fixed(py, (0..self.log.len()).map(|i| self.log.temperature(i).unwrap_or(f64::NAN)).collect())
    }

    /// Joint positions of the contacts (rad or m), shape (len, dof).
    #[getter]
    fn q<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        contact_positions(py, &self.log)
    }

    /// What the fixture exerted on the tool in each contact, about the tip's origin, along its axes
    /// (N, N m), shape (len, 6); zeros without `load_on`.
    #[getter]
    fn loads<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        fixed_rows(py, (0..self.log.len()).flat_map(|i| self.log.load(i)).collect(), WRENCH.len())
    }

    /// Measured torques that gravity and contact exerted about the joints in each contact (N m, or
    /// N of a prismatic joint), shape (len, dof); NaN without `tau_joint`.
    #[getter]
    fn joint_torques<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let dof = self.log.dof();
        let of = |i: usize| self.log.joint_torques(i).map_or_else(|| vec![f64::NAN; dof], <[f64]>::to_vec);
        fixed_rows(py, (0..self.log.len()).flat_map(of).collect(), dof)
    }

    /// Row of each contact in what was read, 1 for the first line of a file or the first row of an
    /// array; shape (len,).
    #[getter]
    fn lines<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u64>> {
        let lines = PyArray1::from_iter(py, (0..self.log.len()).map(|i| self.log.source(i).line));
        lines.readwrite().make_nonwriteable();
        lines
    }

    /// What was taken for granted in reading, as it was warned of.
    #[getter]
    fn notes(&self) -> Vec<String> {
        self.log.notes().to_vec()
    }

    /// Rows read, in contact or not.
    #[getter]
    fn rows_read(&self) -> u64 {
        self.log.rows_read()
    }

    fn __len__(&self) -> usize {
        self.log.len()
    }

    fn __repr__(&self) -> String {
        let (contacts, rows) = (self.log.len(), self.log.rows_read());
        format!("ContactLog({contacts} contacts of {rows} rows, {:?})", self.input.path)
    }
}

/// Joint positions of all contacts.
pub fn contact_positions<'py>(
    py: Python<'py>,
    log: &touchcal::contact::ContactLog,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    fixed_rows(py, (0..log.len()).flat_map(|i| log.q(i)).copied().collect(), log.dof())
}

/// A column of a data frame as numbers, NaN where it holds something else.
fn as_far_as_numbers<'py>(column: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    let errors = [("errors", "coerce")].into_py_dict(column.py())?;
    let numbers = column.py().import("pandas")?.call_method("to_numeric", (column,), Some(&errors))?;
    numbers.call_method1("to_numpy", ("float64",))
}

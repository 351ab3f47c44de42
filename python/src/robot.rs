//! A robot arm, read from a URDF.

use nalgebra::Vector3;
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;
use touchcal::io::Input;
use touchcal::io::urdf::{self, Ends, UrdfFile};
use touchcal::robot::{Kinematics, builtin};
use touchcal::se3::Pose;

use crate::array::{Numbers, fixed, fixed_rows, poses_array};
use crate::error::{ArgumentClass, io, unexpected};

/// Largest gravity (m/s²); a larger one is in another unit.
const MOST_GRAVITY: f64 = 100.0;

/// A serial chain from a base link to a tip link.
#[pyclass(frozen, module = "touchcal")]
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Robot {
    pub file: UrdfFile,
}

impl Robot {
    /// An arm with the text that describes it.
    pub fn new(robot: touchcal::robot::Robot, text: String, inputs: &[Input]) -> Robot {
        let own = Input::of(robot.name(), &text);
        let input = inputs.iter().find(|input| input.sha256 == own.sha256).cloned().unwrap_or(own);
        Robot { file: UrdfFile { robot, text, input } }
    }
}

impl ArgumentClass for Robot {
    const EXPECTED: &'static str = "a Robot, such as Robot.from_urdf(\"iiwa14\")";
}

#[pymethods]
impl Robot {
    /// Reads a robot from a URDF file, or takes a built-in one.
    ///
    /// Args:
    ///     source: path of a URDF file; or the name of a built-in arm (see `builtins`): a str
    ///         without `/` and `.`.
    ///     base: link where the chain begins; default: the root.
    ///     tip: link that carries the tool; default: the only leaf, of a built-in arm its flange.
    ///     gravity: shape (3,), m/s² in the base frame; default: (0, 0, -9.81).
    ///
    /// Raises:
    ///     FileError, InputError: if there is no such file or arm, or it is not a URDF of a serial
    ///         chain.
    #[staticmethod]
    #[pyo3(signature = (source, *, base=None, tip=None, gravity=None))]
    fn from_urdf(
        source: Bound<'_, PyAny>,
        base: Option<&str>,
        tip: Option<&str>,
        gravity: Option<[f64; 3]>,
    ) -> PyResult<Robot> {
        let ends = Ends { base, tip };
        let name: Option<String> = source.extract().ok().filter(|name: &String| !name.contains(['/', '\\', '.']));
        let mut file = match name {
            Some(name) => urdf::read_builtin(&name, ends),
            None => urdf::read_file(&source.extract::<PathBuf>()?, ends),
        }
        .map_err(io)?;
        if let Some(gravity) = gravity {
            if gravity.iter().any(|part| !part.is_finite()) {
                return Err(unexpected("gravity", "finite numbers", format!("{gravity:?}")));
            }
            let size = Vector3::from(gravity).norm();
            if size > MOST_GRAVITY {
                let expected = format!("at most {MOST_GRAVITY} m/s²");
                return Err(unexpected("gravity", expected, format!("{size} m/s²")));
            }
            file.robot = file.robot.with_gravity(gravity.into());
        }
        Ok(Robot { file })
    }

    /// Names of the built-in arms.
    #[staticmethod]
    fn builtins() -> Vec<&'static str> {
        builtin::ALL.iter().map(|(name, _)| *name).collect()
    }

    /// Name, as the URDF has it.
    #[getter]
    fn name(&self) -> &str {
        self.file.robot.name()
    }

    /// Link where the chain begins.
    #[getter]
    fn base(&self) -> &str {
        self.file.robot.base()
    }

    /// Link where it ends.
    #[getter]
    fn tip(&self) -> &str {
        self.file.robot.tip()
    }

    /// Number of moving joints.
    #[getter]
    fn dof(&self) -> usize {
        self.file.robot.dof()
    }

    /// Names of the moving joints, in order.
    #[getter]
    fn joints(&self) -> Vec<&str> {
        self.file.robot.moving().map(|joint| joint.name.as_str()).collect()
    }

    /// Least and greatest position of each moving joint (rad or m), shape (dof, 2); infinite where
    /// none is declared.
    #[getter]
    fn limits<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let each = self.file.robot.moving().flat_map(|joint| {
            joint.limits.map_or([f64::NEG_INFINITY, f64::INFINITY], |limits| [limits.lower, limits.upper])
        });
        fixed_rows(py, each.collect(), 2)
    }

    /// Gravity (m/s²) in the base frame, shape (3,).
    #[getter]
    fn gravity<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        let gravity: &Vector3<f64> = self.file.robot.gravity();
        fixed(py, gravity.iter().copied().collect())
    }

    /// Text of the URDF.
    #[getter]
    fn urdf(&self) -> &str {
        &self.file.text
    }

    /// Pose of the tip link in the base frame.
    ///
    /// Args:
    ///     q: joint positions (rad or m), shape (N, dof), or (dof,) for one.
    ///
    /// Returns:
    ///     shape (N, 7), rows `x, y, z, qw, qx, qy, qz` (m); (1, 7) for one.
    fn base_from_tip<'py>(&self, py: Python<'py>, q: Numbers<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let dof = self.file.robot.dof();
        let contiguous = q.as_array().as_standard_layout().into_owned();
        let (Some(values), [.., columns]) = (contiguous.as_slice(), contiguous.shape()) else {
            return Err(unexpected("q", format!("shape (N, {dof})"), "a number"));
        };
        if *columns != dof || contiguous.ndim() > 2 {
            return Err(unexpected("q", format!("shape (N, {dof})"), format!("shape {:?}", contiguous.shape())));
        }
        let kinematics = Kinematics::new(&self.file.robot, &[], Pose::identity());
        let poses: Vec<Pose> = values.chunks_exact(dof.max(1)).map(|q| kinematics.pose(q)).collect();
        poses_array(py, &poses)
    }

    fn __repr__(&self) -> String {
        let robot = &self.file.robot;
        format!("Robot({:?}, {} joints from {:?} to {:?})", robot.name(), robot.dof(), robot.base(), robot.tip())
    }
}

//! How tool and fixture touch.

use std::any::Any;
use std::path::PathBuf;
use std::sync::Arc;

use nalgebra::{Point2, Point3};
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use serde::{Deserialize, Serialize};
use touchcal::geometry::{EdgeRadii, MeshPair, Parts, Polygon, PrismPair};
use touchcal::io::Input;
use touchcal::io::IoError;
use touchcal::io::manifold_file;
use touchcal::io::mesh;
use touchcal::io::outline::Choice;
use touchcal::io::problem_file::Assumptions;
use touchcal::io::weights_file::WeightsFile;
use touchcal::manifold::coordinates::{self, Coordinates, Metric};
use touchcal::manifold::{
    ContactManifold, FITTING, Misfit, NearestSample, PoseSamples, Projected, Projection, Residual, check_fit,
    exact_manifold, manifold_data, peg_in_hole,
};
use touchcal::se3::Pose;

use crate::array::{Numbers, fixed, fixed_rows, many_poses, poses_array};
use crate::error::{ArgumentClass, io, refused, unexpected};
use crate::log::warn;
use crate::plausible;
use crate::threads::detached;

/// How a tool touches a fixture: the set of poses `fixture_from_tool` in which it does.
#[pyclass(frozen, module = "touchcal")]
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Manifold {
    #[serde(with = "manifold_data")]
    pub shape: Arc<dyn ContactManifold>,
    /// Files that it was read from.
    pub inputs: Vec<Input>,
}

impl Manifold {
    fn of(parts: &Parts) -> Manifold {
        Manifold { shape: exact_manifold(parts).into(), inputs: Vec::new() }
    }

    fn projected(projection: Arc<dyn Projection>, inputs: Vec<Input>) -> Manifold {
        Manifold { shape: Arc::new(Projected(projection)), inputs }
    }
}

impl ArgumentClass for Manifold {
    const EXPECTED: &'static str = "a Manifold, such as Manifold.ball_in_socket()";
}

#[pymethods]
#[allow(clippy::too_many_arguments, reason = "most are keywords with a default")]
impl Manifold {
    /// A ball, or a point, in a socket: the tool's origin is the fixture's.
    #[staticmethod]
    fn ball_in_socket() -> Manifold {
        Manifold::of(&Parts::BallInSocket)
    }

    /// Points of the tool above the plane z = 0 of the fixture, at least one on it.
    ///
    /// Args:
    ///     points: points in the tool's frame (m), shape (N, 3); default: its origin.
    ///     radius: of balls about the points (m).
    #[staticmethod]
    #[pyo3(signature = (points=None, *, radius=0.0))]
    fn plane(points: Option<Numbers<'_>>, radius: f64) -> PyResult<Manifold> {
        let points = match &points {
            None => vec![Point3::origin()],
            Some(points) => rows::<3>(points, "points")?.into_iter().map(Point3::from).collect(),
        };
        if points.is_empty() || !(radius >= 0.0 && radius.is_finite()) {
            let found = format!("{} and {radius}", points.len());
            return Err(unexpected("plane", "at least one point and a radius of at least 0", found));
        }
        plausible::length("plane, radius", radius, plausible::PART)?;
        let farthest = points.iter().map(|point| point.coords.norm()).fold(0.0, f64::max);
        plausible::length("plane, points", farthest, plausible::PART)?;
        Ok(Manifold::of(&Parts::OnPlane { points, radius }))
    }

    /// A straight peg in a straight hole. The peg's frame is at the centre of its tip face, z
    /// towards the arm; the hole's at the centre of its mouth, z outwards; a seated peg has the
    /// hole's axes.
    ///
    /// Args:
    ///     peg, hole: outlines, vertices x, y (m), shape (N, 2); see `extrusion25` and
    ///         `offset_outline`.
    ///     length: of the peg (m).
    ///     depth: of the hole (m).
    ///     peg_edge_radius, hole_edge_radius: to which edges are rounded (m); 0: they are sharp.
    #[staticmethod]
    #[pyo3(signature = (peg, hole, *, length, depth, peg_edge_radius=0.0, hole_edge_radius=0.0))]
    fn peg_in_hole(
        peg: Numbers<'_>,
        hole: Numbers<'_>,
        length: f64,
        depth: f64,
        peg_edge_radius: f64,
        hole_edge_radius: f64,
    ) -> PyResult<Manifold> {
        let (peg, hole) = (profile(&peg, "peg")?, profile(&hole, "hole")?);
        let sizes = [("length", length), ("depth", depth), ("peg", peg.bounding_radius())];
        sizes.into_iter().try_for_each(|(what, size)| plausible::length(what, size, plausible::PART))?;
        let sharp = PrismPair::new(peg, length, hole, depth);
        let edge_radii = EdgeRadii { peg: peg_edge_radius, hole: hole_edge_radius };
        let parts = sharp.and_then(|sharp| sharp.with_edge_radii(edge_radii));
        let parts = parts.map_err(|error| refused("peg_in_hole", error))?;
        let manifold = Manifold::of(&Parts::PegInHole(Box::new(parts)));
        check_fit(manifold.shape.as_ref(), depth).map_err(|misfit| unfitting("peg_in_hole", misfit))?;
        Ok(manifold)
    }

    /// A peg in a hole, both of any shape, as closed meshes; frames as for `peg_in_hole`. Issues a
    /// `UserWarning` if a mesh has several bodies.
    ///
    /// Args:
    ///     peg, hole: paths of STL or OBJ files; the hole's is the body around it.
    ///     depth: how far the peg goes in (m).
    ///     unit: length of the files' unit (m).
    #[staticmethod]
    #[pyo3(signature = (peg, hole, *, depth, unit=0.001))]
    fn meshes(py: Python<'_>, peg: PathBuf, hole: PathBuf, depth: f64, unit: f64) -> PyResult<Manifold> {
        positive("depth", depth)?;
        plausible::length("depth", depth, plausible::PART)?;
        positive("unit", unit)?;
        let (peg, of_peg) = mesh::read_file(&peg, unit).map_err(io)?;
        let (hole, of_hole) = mesh::read_file(&hole, unit).map_err(io)?;
        let mut assumptions = Assumptions::default();
        assumptions.several_bodies("peg", peg.body_count());
        assumptions.several_bodies("hole", hole.body_count());
        warn(py, &assumptions.notes(""))?;
        let shape = peg_in_hole(MeshPair::new(peg, hole), depth).map_err(|misfit| unfitting("meshes", misfit))?;
        Ok(Manifold { shape: shape.into(), inputs: vec![of_peg, of_hole] })
    }

    /// Distance from the nearest of recorded poses, or from a mean of the nearest few. No error
    /// bars follow from it.
    ///
    /// Args:
    ///     samples: path of a manifold from `touchcal manifold` or of a table of poses; or poses
    ///         `fixture_from_tool`, shape (N, 7) or (N, 4, 4).
    ///     neighbours: how many poses a projection is the mean of.
    ///     metres_per_radian: length that counts as much as a radian; default: that of the file,
    ///         else 1 mm a degree.
    #[staticmethod]
    #[pyo3(signature = (samples, *, neighbours=1, metres_per_radian=None))]
    fn nearest(samples: Bound<'_, PyAny>, neighbours: usize, metres_per_radian: Option<f64>) -> PyResult<Manifold> {
        let (samples, thinned_in, inputs) = match samples.extract::<PathBuf>() {
            Ok(path) => {
                let (samples, metric, input) = manifold_file::read_samples(&path).map_err(io)?;
                (samples, metric, vec![input])
            }
            Err(_) => {
                let poses = many_poses(&samples.extract()?, "samples")?;
                let farthest = poses.iter().map(|pose| pose.translation.vector.norm()).fold(0.0, f64::max);
                plausible::length("samples", farthest, plausible::REACH)?;
                (PoseSamples::from_poses(&poses).map_err(|error| refused("samples", error))?, None, Vec::new())
            }
        };
        if let Some(bad) = metres_per_radian.filter(|length| !(*length > 0.0 && length.is_finite())) {
            return Err(unexpected("metres_per_radian", "a positive length", format!("{bad}")));
        }
        metres_per_radian.map_or(Ok(()), |length| plausible::length("metres_per_radian", length, plausible::REACH))?;
        let given = metres_per_radian.map(|metres_per_radian| Metric { metres_per_radian });
        let metric = given.or(thinned_in).unwrap_or(Metric::MILLIMETRE_PER_DEGREE);
        let nearest = NearestSample::new(samples, metric).with_neighbours(neighbours);
        Ok(Manifold::projected(Arc::new(nearest), inputs))
    }

    /// Distance from where a network projects. No error bars follow from it.
    ///
    /// Args:
    ///     weights: path of `weights.safetensors` from `touchcal train`.
    #[staticmethod]
    fn learned(weights: PathBuf) -> PyResult<Manifold> {
        let (file, input) = WeightsFile::read_file(&weights).map_err(io)?;
        Ok(Manifold::projected(Arc::new(file.projection), vec![input]))
    }

    /// What touches what, in words: "ball in socket".
    #[getter]
    fn name(&self) -> &str {
        self.shape.name()
    }

    /// How far poses are from touching (m), shape (N,): the size of the residual; 0 on the
    /// manifold.
    ///
    /// Args:
    ///     poses: `fixture_from_tool`, shape (N, 7) or (N, 4, 4).
    fn distance<'py>(&self, py: Python<'py>, poses: Numbers<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let poses = many_poses(&poses, "poses")?;
        let distances = detached(py, || {
            let mut rows = vec![Residual::new(); poses.len()];
            self.shape.residuals(&poses, 0.0, &mut rows);
            let size = |rows: &Residual| rows.values().iter().map(|value| value * value).sum::<f64>().sqrt();
            rows.iter().map(size).collect()
        });
        Ok(fixed(py, distances))
    }

    /// The poses on the manifold that stand for these: only of `nearest` and `learned`.
    ///
    /// Args:
    ///     poses: `fixture_from_tool`, shape (N, 7) or (N, 4, 4).
    ///
    /// Returns:
    ///     shape (N, 7).
    fn project<'py>(&self, py: Python<'py>, poses: Numbers<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let shape: &dyn Any = self.shape.as_ref();
        let Some(Projected(projection)) = shape.downcast_ref() else {
            let found = format!("`{}`", self.shape.name());
            return Err(unexpected("project", "a manifold made by `nearest` or `learned`", found));
        };
        let poses = many_poses(&poses, "poses")?;
        let projected: Vec<Pose> = detached(py, || {
            let at: Vec<Coordinates> = poses.iter().map(coordinates::coordinates).collect();
            let mut onto = Vec::new();
            projection.project(&at, &mut onto);
            onto.iter().map(coordinates::pose).collect()
        });
        poses_array(py, &projected)
    }

    fn __repr__(&self) -> String {
        format!("Manifold({:?})", self.shape.name())
    }
}

/// `manifold.project(poses)`.
#[pyfunction]
pub fn project<'py>(py: Python<'py>, manifold: &Manifold, poses: Numbers<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
    manifold.project(py, poses)
}

/// Outline of a T-slot extrusion of 25 mm: vertices x, y (m), shape (N, 2).
#[pyfunction]
pub fn extrusion25(py: Python<'_>) -> PyResult<Bound<'_, PyArray2<f64>>> {
    outline(py, &Polygon::extrusion25())
}

/// An outline moved outwards, corners mitred, as of a hole for a peg.
///
/// Args:
///     outline: vertices x, y (m), shape (N, 2).
///     distance: how far (m).
#[pyfunction]
#[pyo3(name = "offset_outline", signature = (outline, distance))]
pub fn offset_outline<'py>(
    py: Python<'py>,
    outline: Numbers<'py>,
    distance: f64,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let outline = profile(&outline, "outline")?;
    let moved = outline.offset_mitred(distance).map_err(|error| refused("outline", error))?;
    plausible::length("distance", distance.abs(), plausible::GAP)?;
    self::outline(py, &moved)
}

/// The outline in a file: vertices as CSV, or a drawing as SVG or DXF.
///
/// Args:
///     path: of the file.
///     name: which part of a drawing: an id of the SVG, a layer of the DXF; default: the only
///         closed outline.
///     unit: length of the drawing's unit (m), where it does not say.
///
/// Returns:
///     Vertices x, y (m), shape (N, 2).
#[pyfunction]
#[pyo3(signature = (path, *, name=None, unit=None))]
pub fn read_outline<'py>(
    py: Python<'py>,
    path: PathBuf,
    name: Option<&str>,
    unit: Option<f64>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    unit.map_or(Ok(()), |unit| positive("unit", unit))?;
    let (profile, _) =
        touchcal::io::outline::read_file(&path, Choice { name, unit }).map_err(|error| io(by_argument(error)))?;
    self::outline(py, &profile)
}

/// An error that calls `name` and `unit` as they are called here, not by the keys of problem.toml.
fn by_argument(error: IoError) -> IoError {
    let called = |text: String| text.replace("`outline_name`", "`name`").replace("`outline_unit`", "`unit`");
    match error {
        IoError::Unexpected { place, expected, found } => {
            IoError::Unexpected { place, expected: called(expected), found: called(found) }
        }
        other => other,
    }
}

fn unfitting(what: &str, misfit: Misfit) -> PyErr {
    unexpected(what, FITTING, misfit.to_string())
}

fn positive(what: &str, length: f64) -> PyResult<()> {
    if length > 0.0 && length.is_finite() {
        return Ok(());
    }
    Err(unexpected(what, "a positive length (m)", format!("{length}")))
}

fn outline<'py>(py: Python<'py>, profile: &Polygon) -> PyResult<Bound<'py, PyArray2<f64>>> {
    fixed_rows(py, profile.vertices().iter().flat_map(|vertex| [vertex.x, vertex.y]).collect(), 2)
}

fn profile(outline: &Numbers<'_>, what: &str) -> PyResult<Polygon> {
    let vertices = rows::<2>(outline, what)?.into_iter().map(Point2::from).collect();
    Polygon::new(vertices).map_err(|error| refused(what, error))
}

/// Rows of `N` finite numbers.
fn rows<const N: usize>(array: &Numbers<'_>, what: &str) -> PyResult<Vec<[f64; N]>> {
    let view = array.as_array();
    match *view.shape() {
        [count, columns] if columns == N && view.iter().all(|value| value.is_finite()) => {
            Ok((0..count).map(|i| std::array::from_fn(|k| view[[i, k]])).collect())
        }
        ref shape => {
            Err(unexpected(what, format!("finite numbers of shape (N, {N})"), format!("shape {shape:?}, or others")))
        }
    }
}

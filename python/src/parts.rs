//! What touches and what is touched: tool and fixture.

use pyo3::prelude::*;
use serde::{Deserialize, Serialize};
use touchcal::estimate::{self, PlacePrior, ShapeTolerance};
use touchcal::io::Input;
use touchcal::io::problem_file::{self, Assumptions, DeclaredPrior, Settings};
use touchcal::manifold::{ContactManifold, ResidualKind};
use touchcal::se3::Pose;

use crate::array::{Numbers, one_pose};
use crate::error::{ArgumentClass, Given, argument, optional_argument, unexpected, wrong_type};
use crate::list_of::ListOf;
use crate::manifold::Manifold;
use crate::plausible;
use crate::repr;

/// The tool: its pose on the arm's tip link.
///
/// Args:
///     tip_from_tool: nominal pose of the tool's frame on the tip link, shape (7,) or (4, 4),
///         at most 10 m; default: the tip link itself.
///     sigma, sigma_angle: its prior: standard deviations of each translation (m) and
///         rotation (rad) component; default: 0.3 mm and 0.2 degrees.
///     free: flat prior, instead of sigma and sigma_angle.
///     exact: the pose is exactly known.
#[pyclass(frozen, module = "touchcal")]
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Tool {
    tip_from_tool: Pose,
    declared: DeclaredPrior,
}

impl ArgumentClass for Tool {
    const EXPECTED: &'static str = "a Tool";
}

#[pymethods]
impl Tool {
    #[new]
    #[pyo3(signature = (tip_from_tool=None, *, sigma=None, sigma_angle=None, free=false, exact=false))]
    fn new(
        tip_from_tool: Option<Numbers<'_>>,
        sigma: Option<f64>,
        sigma_angle: Option<f64>,
        free: bool,
        exact: bool,
    ) -> PyResult<Tool> {
        let tip_from_tool = match &tip_from_tool {
            None => Pose::identity(),
            Some(pose) => one_pose(pose, "tip_from_tool")?,
        };
        let declared = declared_prior("tool", (sigma, sigma_angle), free, exact, PlacePrior::DEFAULT_TOOL)?;
        Ok(Tool { tip_from_tool, declared })
    }

    fn __repr__(&self) -> String {
        format!("Tool({}, {})", repr::pose(&self.tip_from_tool), prior(self.declared.prior))
    }
}

impl Tool {
    /// The tool of a problem with these settings, and fixtures with these manifolds.
    pub fn nominal<'a>(
        &self,
        settings: &Settings,
        mut manifolds: impl Iterator<Item = &'a dyn ContactManifold>,
        assumptions: &mut Assumptions,
    ) -> estimate::Tool {
        let prior = settings.tool_prior(self.declared);
        if prior != PlacePrior::Flat {
            let is_rotation = |direction: &usize| *direction >= 3;
            let has_rotation = manifolds.any(|manifold| manifold.tool_directions().iter().any(is_rotation));
            assumptions.place("tool", self.declared, has_rotation);
        }
        estimate::Tool { tip_from_tool: self.tip_from_tool, prior }
    }
}

/// A fixture: a contact manifold at a pose.
///
/// Args:
///     name: unique; fixtures "left/0" and "left/1" are of the placement "left".
///     manifold: its contact manifold.
///     base_from_fixture: its nominal pose in the base frame, shape (7,) or (4, 4), at most 10 m. A
///         free socket needs none.
///     sigma, sigma_angle: its prior: standard deviations of each translation (m) and rotation
///         (rad) component; default: 1 mm and 0.5 degrees.
///     free: flat prior, instead of sigma and sigma_angle.
///     exact: whether pose and shape are exactly known, or a list of what is: "place", and of a
///         hole "outline", "clearance", "depth", "edge_radius".
///     clearance_sigma, depth_sigma: of a hole, standard deviations of the clearance on each side
///         and of the depth (m); default: 0.03 mm each.
///     edge_radius_sigma: of a hole, standard deviation of the radius of its edges, and of the
///         tool's there, beyond those of the manifold (m); default: 0.05 mm.
///     placement: fixtures that were recorded in one session share it; default: the name up to its
///         first "/".
#[pyclass(frozen, module = "touchcal")]
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Fixture {
    fixture: estimate::Fixture,
    declared: DeclaredPrior,
    shape_sigmas: [Option<f64>; 3],
    /// Files that its manifold was read from.
    inputs: Vec<Input>,
}

#[pymethods]
#[allow(clippy::too_many_arguments, reason = "most are keywords with a default")]
impl Fixture {
    #[new]
    #[pyo3(signature = (name, manifold, base_from_fixture=None, *, sigma=None, sigma_angle=None, free=false, exact=None, clearance_sigma=None, depth_sigma=None, edge_radius_sigma=None, placement=None), text_signature = "(name, manifold, base_from_fixture=None, *, sigma=None, sigma_angle=None, free=False, exact=False, clearance_sigma=None, depth_sigma=None, edge_radius_sigma=None, placement=None)")]
    fn new(
        name: &Bound<'_, PyAny>,
        manifold: &Bound<'_, PyAny>,
        base_from_fixture: Option<Numbers<'_>>,
        sigma: Option<f64>,
        sigma_angle: Option<f64>,
        free: bool,
        exact: Option<Bound<'_, PyAny>>,
        clearance_sigma: Option<f64>,
        depth_sigma: Option<f64>,
        edge_radius_sigma: Option<f64>,
        placement: Option<String>,
    ) -> PyResult<Fixture> {
        let name: String = argument(name, "name")?;
        let manifold = argument::<Given<Manifold>>(manifold, "manifold")?.0;
        let manifold = manifold.get();
        let title = format!("fixture `{name}`");
        let place = base_from_fixture.as_ref();
        let place = place.map(|pose| one_pose(pose, &format!("{title}, base_from_fixture"))).transpose()?;
        let is_hole = manifold.shape.residual_kind() == ResidualKind::LeastGap;
        let exact = optional_argument(exact.as_ref(), "exact")?;
        let exact = exact.unwrap_or(Exact::All(false)).parts(&title, is_hole)?;
        let is_exact = |part: &str| exact.iter().any(|name| name == part);
        let sigmas = (sigma, sigma_angle);
        let declared = declared_prior(&title, sigmas, free, is_exact("place"), PlacePrior::DEFAULT_FIXTURE)?;
        let shape = |sigma: Option<f64>, part: &str, default: f64| match sigma {
            Some(sigma) if !is_hole => {
                let expected = "what belongs to a manifold without a hole";
                Err(unexpected(format!("{title}, {part}_sigma"), expected, format!("{sigma}")))
            }
            Some(sigma) if sigma > 0.0 && is_exact(part) => {
                let expected = format!("{part}_sigma or exact with {part:?}");
                Err(unexpected(format!("{title}, {part}_sigma"), expected, "both"))
            }
            Some(sigma) => {
                plausible::length(format!("{title}, {part}_sigma"), sigma, plausible::SHAPE_SIGMA)?;
                not_negative(&title, &format!("{part}_sigma"), sigma)
            }
            None => Ok(if is_hole && !is_exact(part) { default } else { 0.0 }),
        };
        let default = ShapeTolerance::DEFAULT.of(manifold.shape.as_ref());
        let fixture = estimate::Fixture {
            manifold: manifold.shape.clone(),
            base_from_fixture: place,
            prior: declared.prior,
            tolerance: ShapeTolerance {
                clearance: shape(clearance_sigma, "clearance", default.clearance)?,
                depth: shape(depth_sigma, "depth", default.depth)?,
                edge_radius: shape(edge_radius_sigma, "edge_radius", default.edge_radius)?,
            },
            placement: placement.unwrap_or_else(|| problem_file::placement(&name).to_owned()),
            name,
        };
        let shape_sigmas = [clearance_sigma, depth_sigma, edge_radius_sigma];
        Ok(Fixture { fixture, declared, shape_sigmas, inputs: manifold.inputs.clone() })
    }

    /// Its name.
    #[getter]
    pub fn name(&self) -> &str {
        &self.fixture.name
    }

    fn __repr__(&self) -> String {
        let place = self.fixture.base_from_fixture.as_ref().map_or_else(|| "no place".to_owned(), repr::pose);
        let (name, manifold) = (&self.fixture.name, self.fixture.manifold.name());
        format!("Fixture({name:?}, {manifold:?}, {place}, {})", prior(self.declared.prior))
    }
}

impl Fixture {
    /// Its manifold.
    pub fn manifold(&self) -> &dyn ContactManifold {
        self.fixture.manifold.as_ref()
    }

    /// The files that its manifold was read from.
    pub fn inputs(&self) -> &[Input] {
        &self.inputs
    }

    /// The fixture of a problem with these settings.
    pub fn nominal(&self, settings: &Settings, assumptions: &mut Assumptions) -> PyResult<estimate::Fixture> {
        let mut fixture = self.fixture.clone();
        fixture.prior = settings.fixture_prior(self.declared);
        let title = format!("fixture `{}`", fixture.name);
        if let Some(expected) = problem_file::missing_place(&fixture) {
            return Err(unexpected(title, expected, "none"));
        }
        if fixture.prior != PlacePrior::Flat {
            let has_rotation = fixture.manifold.fixture_directions().iter().any(|&direction| direction >= 3);
            assumptions.place(&title, self.declared, has_rotation);
        }
        assumptions.shape(&title, self.shape_sigmas, fixture.tolerance);
        Ok(fixture)
    }
}

/// `True`, `False`, or names of what is exact.
enum Exact {
    All(bool),
    Parts(Vec<String>),
}

impl FromPyObject<'_, '_> for Exact {
    type Error = PyErr;

    fn extract(object: Borrowed<'_, '_, PyAny>) -> PyResult<Self> {
        let parts = || object.extract::<ListOf<String>>().map(|parts| Exact::Parts(parts.0));
        let all = object.extract::<bool>().map(Exact::All);
        all.or_else(|_| parts()).map_err(|_| wrong_type("True, False, or a list of names", &object))
    }
}

impl Exact {
    /// Names of what is exact of a fixture.
    fn parts(self, title: &str, is_hole: bool) -> PyResult<Vec<String>> {
        let known: &[&str] =
            if is_hole { &["place", "outline", "clearance", "depth", "edge_radius"] } else { &["place"] };
        match self {
            Exact::All(false) => Ok(Vec::new()),
            Exact::All(true) => Ok(known.iter().map(|name| (*name).to_owned()).collect()),
            Exact::Parts(names) => match names.iter().find(|name| !known.contains(&name.as_str())) {
                None => Ok(names),
                Some(name) => {
                    let expected = format!("True, False, or a list of {}", known.join(", "));
                    Err(unexpected(format!("{title}, exact"), expected, format!("{name:?}")))
                }
            },
        }
    }
}

/// A prior in words.
fn prior(prior: PlacePrior) -> String {
    match prior {
        PlacePrior::Fixed => "exact".to_owned(),
        PlacePrior::Flat => "free".to_owned(),
        PlacePrior::Gaussian { sigma, sigma_angle } => {
            format!("± {}, ± {}", repr::length(sigma), repr::angle(sigma_angle))
        }
    }
}

/// A standard deviation, if it is one.
fn not_negative(what: &str, argument: &str, sigma: f64) -> PyResult<f64> {
    if sigma >= 0.0 && sigma.is_finite() {
        return Ok(sigma);
    }
    Err(unexpected(format!("{what}, {argument}"), "a number of at least 0", format!("{sigma}")))
}

fn declared_prior(
    what: &str,
    (sigma, sigma_angle): (Option<f64>, Option<f64>),
    free: bool,
    exact: bool,
    default: PlacePrior,
) -> PyResult<DeclaredPrior> {
    for (argument, sigma) in [("sigma", sigma), ("sigma_angle", sigma_angle)] {
        sigma.map(|sigma| not_negative(what, argument, sigma)).transpose()?;
    }
    sigma.map_or(Ok(()), |sigma| plausible::length(format!("{what}, sigma"), sigma, plausible::PLACE_SIGMA))?;
    sigma_angle.map_or(Ok(()), |sigma| plausible::angle(format!("{what}, sigma_angle"), sigma, 0.5))?;
    DeclaredPrior::new((sigma, sigma_angle), free, exact, default)
        .map_err(|(expected, found)| unexpected(what, expected, found))
}

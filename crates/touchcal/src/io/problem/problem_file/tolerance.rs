//! How well places, shapes and distances are known: `sigma_mm`, `sigma_deg`, `free`, `exact`.

use std::ops::Range;

use serde::{Deserialize, Serialize};
use toml::{Spanned, Value};

use super::context::{Allowed, Context, DEG, MM};
use super::schema::{FixtureKind, Number};
use crate::estimate::{DEFAULT_DISTANCE_SIGMA, PlacePrior, ShapeTolerance};
use crate::io::base::error::{IoError, quoted};
use crate::io::base::suggest::{did_you_mean, list};

/// Prior of a place, and whether it was declared.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct DeclaredPrior {
    /// The declared prior, or the default one.
    pub prior: PlacePrior,
    /// Whether nothing was declared, so that `prior` is the default one.
    pub is_assumed: bool,
    /// Whether one of the two standard deviations was declared and the other is the default one.
    pub is_partly_assumed: bool,
    /// Whether a standard deviation of 0 was declared, without a word that the place is exact.
    pub is_exact_by_zero: bool,
}

impl DeclaredPrior {
    /// From standard deviations of each translation component `sigma` (m) and each rotation
    /// component `sigma_angle` (rad), `free` for a flat prior, and whether the place is `exact`.
    /// What is missing is taken from `default`; standard deviations of 0 are exact.
    ///
    /// # Errors
    /// What is allowed and what was found, as phrases for a message, if two of these contradict
    /// each other.
    pub fn new(
        (sigma, sigma_angle): (Option<f64>, Option<f64>),
        free: bool,
        exact: bool,
        default: PlacePrior,
    ) -> Result<DeclaredPrior, (&'static str, &'static str)> {
        let has_sigma = sigma.is_some() || sigma_angle.is_some();
        let is_positive = sigma.is_some_and(|sigma| sigma > 0.0) || sigma_angle.is_some_and(|sigma| sigma > 0.0);
        let declared = |prior| {
            Ok(DeclaredPrior {
                prior,
                is_assumed: false,
                is_partly_assumed: sigma.is_some() != sigma_angle.is_some() && !exact,
                is_exact_by_zero: !exact && (sigma == Some(0.0) || sigma_angle == Some(0.0)),
            })
        };
        match (free, exact, has_sigma) {
            (true, true, _) => Err(("free or exact", "both")),
            (true, false, true) => Err(("free or standard deviations", "both")),
            (false, true, _) if is_positive => Err(("exact or standard deviations above 0", "both")),
            (true, false, false) => declared(PlacePrior::Flat),
            (false, true, _) => declared(PlacePrior::Fixed),
            (false, false, false) => Ok(DeclaredPrior { is_assumed: true, ..declared(default)? }),
            (false, false, true) => {
                let PlacePrior::Gaussian { sigma: length, sigma_angle: angle } = default else {
                    return declared(default);
                };
                let (sigma, sigma_angle) = (sigma.unwrap_or(length), sigma_angle.unwrap_or(angle));
                let is_exact = sigma == 0.0 && sigma_angle == 0.0;
                declared(if is_exact { PlacePrior::Fixed } else { PlacePrior::Gaussian { sigma, sigma_angle } })
            }
        }
    }
}

/// What `exact` can name in `[tool]`.
pub(crate) const TOOL_PARTS: &[&str] = &["place", "outline"];

/// What `exact` can name in a `[[fixture]]`.
pub(crate) fn fixture_parts(kind: FixtureKind) -> &'static [&'static str] {
    match kind {
        FixtureKind::Hole => &["place", "outline", "clearance", "depth", "edge_radius"],
        FixtureKind::Socket | FixtureKind::Plane | FixtureKind::Target => &["place"],
    }
}

/// The parts of a table that `exact` names; all of them for `exact = true`.
pub(crate) fn exact_parts<'n>(
    exact: Option<&Spanned<Value>>,
    parts: &[&'n str],
    field: &str,
    context: &Context<'_>,
) -> Result<Vec<&'n str>, IoError> {
    let Some(exact) = exact else { return Ok(Vec::new()) };
    let expected = || format!("true, false, or a list of what is exact ({})", list(parts.iter().copied()));
    let unexpected = |found: String| Err(IoError::unexpected(context.place(exact.span(), field), expected(), found));
    match exact.get_ref() {
        Value::Boolean(all) => Ok(if *all { parts.to_vec() } else { Vec::new() }),
        Value::Array(names) => {
            let mut found = Vec::new();
            for name in names {
                let text = name.as_str().unwrap_or_default();
                match parts.iter().find(|part| **part == text) {
                    Some(part) => found.push(*part),
                    None => {
                        let text = name.as_str().map_or_else(|| name.type_str().to_owned(), quoted);
                        let hint = did_you_mean(name.as_str().unwrap_or_default(), parts.iter().copied());
                        return unexpected(format!("{text}{hint}"));
                    }
                }
            }
            Ok(found)
        }
        other => unexpected(other.type_str().to_owned()),
    }
}

/// The keys of a place's prior.
pub(crate) struct PlaceKeys<'t> {
    /// Standard deviations of translation (mm) and rotation (degrees).
    pub sigma_mm: Option<&'t Number>,
    pub sigma_deg: Option<&'t Number>,
    pub free: bool,
    /// Whether the place is exact.
    pub exact: bool,
    /// The table.
    pub span: Range<usize>,
}

/// The prior of a place.
pub(crate) fn place_prior(
    keys: &PlaceKeys<'_>,
    default: PlacePrior,
    field: &str,
    context: &Context<'_>,
) -> Result<DeclaredPrior, IoError> {
    let sigma = context.number(keys.sigma_mm, MM, Allowed::NotNegative, &format!("{field}, sigma_mm"))?;
    let sigma_angle = context.number(keys.sigma_deg, DEG, Allowed::NotNegative, &format!("{field}, sigma_deg"))?;
    let span = keys.sigma_mm.or(keys.sigma_deg).map_or(keys.span.clone(), Spanned::span);
    DeclaredPrior::new((sigma, sigma_angle), keys.free, keys.exact, default)
        .map_err(|(expected, found)| IoError::unexpected(context.place(span, field), expected, found))
}

/// The tolerance of a hole's shape: a standard deviation each, or the default one, or exact.
pub(crate) fn shape_tolerance(
    [clearance, depth, edge_radius]: [Option<&Number>; 3],
    exact: &[&str],
    default: ShapeTolerance,
    field: &str,
    context: &Context<'_>,
) -> Result<ShapeTolerance, IoError> {
    let sigma = |number: Option<&Number>, key: &str, part: &str, default: f64| {
        let field = format!("{field}, {key}");
        match (number, context.number(number, MM, Allowed::NotNegative, &field)?) {
            (Some(number), Some(sigma)) if sigma > 0.0 && exact.contains(&part) => {
                let place = context.place(number.span(), field);
                Err(IoError::unexpected(place, format!("{key} or `exact` with {}", quoted(part)), "both"))
            }
            (_, Some(sigma)) => Ok(sigma),
            (_, None) => Ok(if exact.contains(&part) { 0.0 } else { default }),
        }
    };
    Ok(ShapeTolerance {
        clearance: sigma(clearance, "clearance_sigma_mm", "clearance", default.clearance)?,
        depth: sigma(depth, "depth_sigma_mm", "depth", default.depth)?,
        edge_radius: sigma(edge_radius, "edge_radius_sigma_mm", "edge_radius", default.edge_radius)?,
    })
}

/// The standard deviation of a distance (m), 0 if it is exact, the default one if nothing is
/// declared.
pub(crate) fn distance_sigma(
    number: Option<&Number>,
    exact: Option<&Spanned<Value>>,
    context: &Context<'_>,
) -> Result<f64, IoError> {
    let sigma = context.number(number, MM, Allowed::NotNegative, "distance, sigma_mm")?;
    let is_exact = !exact_parts(exact, &["length"], "distance, exact", context)?.is_empty();
    if let (true, Some(number)) = (is_exact && sigma.is_some_and(|sigma| sigma > 0.0), number) {
        let place = context.place(number.span(), "distance, sigma_mm");
        return Err(IoError::unexpected(place, "sigma_mm or exact", "both"));
    }
    Ok(sigma.unwrap_or(if is_exact { 0.0 } else { DEFAULT_DISTANCE_SIGMA }))
}

//! The tool, the fixtures and the distances that a file declares.

use std::collections::HashMap;

use toml::Spanned;

use super::assumptions::Assumptions;
use super::context::{Allowed, Context, MM};
use super::schema::{DistanceToml, FixtureKind, FixtureToml, ToolKind, ToolToml};
use super::selection::{fixture_index, placement_of};
use super::settings::Settings;
use super::tolerance::{PlaceKeys, exact_parts, place_prior, shape_tolerance};
use super::touch::Shape;
use crate::estimate::{DEFAULT_DISTANCE_SIGMA, Distance, Fixture, PlacePrior, ShapeTolerance, Tool};
use crate::io::base::bytes::Input;
use crate::io::base::error::{IoError, quoted};
use crate::manifold::ResidualKind;
use crate::se3::Pose;

/// Standard deviation (m) of a distance that is declared exact: a micrometre, the weight that it
/// needs in the cost.
pub const EXACT_DISTANCE_SIGMA: f64 = 1e-6;

/// The tool, at its declared place.
pub(super) fn tool(
    table: &Spanned<ToolToml>,
    settings: &Settings,
    context: &Context<'_>,
    assumptions: &mut Assumptions,
) -> Result<Tool, IoError> {
    let tool = table.get_ref();
    let exact = exact_parts(tool.exact.as_ref(), &["place", "outline"], "tool, exact", context)?;
    let keys = PlaceKeys {
        sigma_mm: tool.sigma_mm.as_ref(),
        sigma_deg: tool.sigma_deg.as_ref(),
        free: tool.free,
        exact: exact.contains(&"place"),
        span: table.span(),
    };
    let declared = place_prior(&keys, PlacePrior::DEFAULT_TOOL, "tool", context)?;
    let prior = settings.tool_prior(declared);
    if prior != PlacePrior::Flat {
        // Where a ball or a point touches, only its position counts.
        assumptions.place("tool", declared, tool.kind == ToolKind::Peg);
    }
    let tip_from_tool = context.pose(tool.tip_from_tool.as_ref(), "tool, tip_from_tool")?;
    Ok(Tool { tip_from_tool: tip_from_tool.unwrap_or_else(Pose::identity), prior })
}

/// A fixture at its declared place.
pub(super) fn fixture(
    table: &Spanned<FixtureToml>,
    (settings, shape): (&Settings, &Shape),
    context: &Context<'_>,
    (inputs, assumptions): (&mut Vec<Input>, &mut Assumptions),
) -> Result<Fixture, IoError> {
    let manifold = shape.touching(table, context, inputs)?;
    let span = table.span();
    let table = table.get_ref();
    let name = format!("fixture `{}`", table.name.get_ref());
    let is_hole = table.kind == FixtureKind::Hole;
    let parts: &[&str] = if is_hole { &["place", "outline", "clearance", "depth"] } else { &["place"] };
    let exact = exact_parts(table.exact.as_ref(), parts, &format!("{name}, exact"), context)?;
    let keys = PlaceKeys {
        sigma_mm: table.sigma_mm.as_ref(),
        sigma_deg: table.sigma_deg.as_ref(),
        free: table.free,
        exact: exact.contains(&"place"),
        span: span.clone(),
    };
    let declared = place_prior(&keys, PlacePrior::DEFAULT_FIXTURE, &name, context)?;
    let prior = settings.fixture_prior(declared);
    if prior != PlacePrior::Flat {
        let has_rotation = manifold.fixture_directions().iter().any(|&direction| direction >= 3);
        assumptions.place(&name, declared, has_rotation);
    }
    let shape_keys = [table.clearance_sigma_mm.as_ref(), table.depth_sigma_mm.as_ref()];
    let mut tolerance = ShapeTolerance::EXACT;
    if is_hole {
        tolerance = shape_tolerance(shape_keys, &exact, &name, context)?;
    }
    // Of a projection or an unknown manifold it has no effect.
    if manifold.residual_kind() == ResidualKind::LeastGap {
        assumptions.shape(&name, shape_keys.map(|key| key.map(|number| *number.get_ref())), tolerance);
    }
    let fixture = Fixture {
        name: table.name.get_ref().clone(),
        manifold: manifold.into(),
        base_from_fixture: context.pose(table.base_from_fixture.as_ref(), &format!("{name}, base_from_fixture"))?,
        prior,
        tolerance,
        placement: placement_of(table).to_owned(),
    };
    match missing_place(&fixture) {
        Some(expected) => Err(IoError::unexpected(context.place(span, name), expected, "none")),
        None => Ok(fixture),
    }
}

/// Names the keys that a fixture lacks for its place to be known or searched, as a phrase for
/// messages; `None` if it lacks none. Only a socket, which is a point, can be found without a
/// nominal place, with [`PlacePrior::Flat`].
pub fn missing_place(fixture: &Fixture) -> Option<&'static str> {
    match (fixture.base_from_fixture, fixture.manifold.residual_kind() == ResidualKind::PointOffset, fixture.prior) {
        (Some(_), _, _) | (None, true, PlacePrior::Flat) => None,
        (None, true, _) => Some("`base_from_fixture`, or `free = true`"),
        (None, false, _) => Some("`base_from_fixture`, from where its place is looked for"),
    }
}

/// A declared distance, between indices of all fixtures of the file.
pub(super) fn distance(
    table: &Spanned<DistanceToml>,
    names: &HashMap<&str, usize>,
    context: &Context<'_>,
) -> Result<Distance, IoError> {
    let DistanceToml { between: [first, second], mm, sigma_mm, exact } = table.get_ref();
    let between = (
        fixture_index(first, names, context, "distance, between")?,
        fixture_index(second, names, context, "distance, between")?,
    );
    if between.0 == between.1 {
        let found = format!("{} twice", quoted(first.get_ref()));
        return Err(IoError::unexpected(context.place(second.span(), "distance, between"), "two fixtures", found));
    }
    let distance = context.required(Some(mm), MM, table.span(), "distance, mm")?;
    let sigma = context.number(sigma_mm.as_ref(), MM, Allowed::NotNegative, "distance, sigma_mm")?;
    let is_exact = !exact_parts(exact.as_ref(), &["length"], "distance, exact", context)?.is_empty();
    if let (true, Some(number)) = (is_exact && sigma.is_some_and(|sigma| sigma > 0.0), sigma_mm) {
        let place = context.place(number.span(), "distance, sigma_mm");
        return Err(IoError::unexpected(place, "sigma_mm or exact", "both"));
    }
    let default = if is_exact { EXACT_DISTANCE_SIGMA } else { DEFAULT_DISTANCE_SIGMA };
    Ok(Distance { between, distance, sigma: sigma.unwrap_or(default).max(EXACT_DISTANCE_SIGMA) })
}

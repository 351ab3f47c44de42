//! The tool, the fixtures and the distances that a file declares.

use std::collections::HashMap;

use toml::Spanned;

use super::assumptions::Assumptions;
use super::context::{Context, MM};
use super::schema::{DistanceToml, FixtureKind, FixtureToml, ToolKind, ToolToml};
use super::selection::{placement_of, two_fixtures};
use super::settings::Settings;
use super::tolerance::{
    PlaceKeys, TOOL_PARTS, distance_sigma, exact_parts, fixture_parts, place_prior, shape_tolerance,
};
use super::touch::Shape;
use crate::estimate::{Distance, EXACT_DISTANCE_SIGMA, Fixture, PlacePrior, ShapeTolerance, Tool};
use crate::io::base::bytes::Input;
use crate::io::base::error::IoError;
use crate::manifold::ResidualKind;
use crate::se3::Pose;

/// The tool, at its declared place.
pub(super) fn tool(
    table: &Spanned<ToolToml>,
    settings: &Settings,
    context: &Context<'_>,
    assumptions: &mut Assumptions,
) -> Result<Tool, IoError> {
    let tool = table.get_ref();
    let exact = exact_parts(tool.exact.as_ref(), TOOL_PARTS, "tool, exact", context)?;
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
    let manifold = shape.touching(table, context, (inputs, assumptions))?;
    let span = table.span();
    let table = table.get_ref();
    let name = format!("fixture `{}`", table.name.get_ref());
    let exact = exact_parts(table.exact.as_ref(), fixture_parts(table.kind), &format!("{name}, exact"), context)?;
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
    let shape_keys =
        [&table.clearance_sigma_mm, &table.depth_sigma_mm, &table.edge_radius_sigma_mm].map(Option::as_ref);
    let mut tolerance = ShapeTolerance::EXACT;
    if table.kind == FixtureKind::Hole {
        let default = ShapeTolerance::DEFAULT.of(manifold.as_ref());
        tolerance = shape_tolerance(shape_keys, &exact, default, &name, context)?;
    }
    check_edges(table, tolerance.edge_radius > 0.0 && !manifold.has_edges(), &name, context)?;
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
/// messages; `None` if it lacks none. Only a socket, which is a point, and the frame of
/// targets, whose coordinates each contact has, can be found without a nominal place, with
/// [`PlacePrior::Flat`].
pub fn missing_place(fixture: &Fixture) -> Option<&'static str> {
    let manifold = fixture.manifold.as_ref();
    let can_be_found = manifold.residual_kind() == ResidualKind::PointOffset || manifold.tool_at_target().is_some();
    match (fixture.base_from_fixture, can_be_found, fixture.prior) {
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
    let DistanceToml { between, mm, sigma_mm, exact } = table.get_ref();
    let between = two_fixtures(between, names, context)?;
    let distance = context.required(Some(mm), MM, table.span(), "distance, mm")?;
    let sigma = distance_sigma(sigma_mm.as_ref(), exact.as_ref(), context)?;
    Ok(Distance { between, distance, sigma: sigma.max(EXACT_DISTANCE_SIGMA) })
}

/// Refuses a tolerance of edges that `are_missing`.
fn check_edges(table: &FixtureToml, are_missing: bool, name: &str, context: &Context<'_>) -> Result<(), IoError> {
    match table.edge_radius_sigma_mm.as_ref().filter(|_| are_missing) {
        None => Ok(()),
        Some(number) => {
            let place = context.place(number.span(), format!("{name}, edge_radius_sigma_mm"));
            Err(IoError::unexpected(place, "exact contacts of outlines, which have edges", "others"))
        }
    }
}

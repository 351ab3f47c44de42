//! How well tool, fixtures and distances are known: the standard deviations from which their errors
//! are drawn, in the keys of `problem.toml`. Without these keys places and shapes have no errors.

use std::collections::HashMap;

use toml::Spanned;

use super::schema::{MeasuredDistanceToml, TouchToml};
use crate::estimate::{PlacePrior, ShapeTolerance};
use crate::io::base::error::IoError;
use crate::io::problem::problem_file::context::{Allowed, Context, MM};
use crate::io::problem::problem_file::schema::ToolToml;
use crate::io::problem::problem_file::selection::two_fixtures;
use crate::io::problem::problem_file::tolerance::{
    PlaceKeys, TOOL_PARTS, distance_sigma, exact_parts, fixture_parts, place_prior, shape_tolerance,
};
use crate::sim::{MeasuredDistance, PlaceError, Touch};

/// The error of the tool's place.
pub(super) fn tool_error(table: &Spanned<ToolToml>, context: &Context<'_>) -> Result<PlaceError, IoError> {
    let tool = table.get_ref();
    let exact = exact_parts(tool.exact.as_ref(), TOOL_PARTS, "tool, exact", context)?;
    let keys = PlaceKeys {
        sigma_mm: tool.sigma_mm.as_ref(),
        sigma_deg: tool.sigma_deg.as_ref(),
        free: false,
        exact: exact.contains(&"place"),
        span: table.span(),
    };
    place_error(&keys, "tool", context)
}

/// Sets the errors of a fixture's place and shape. The fixture stands on a block with those
/// `before` it that are named alike.
pub(super) fn set_errors(
    fixture: &mut Touch,
    table: &Spanned<TouchToml>,
    before: &[Touch],
    context: &Context<'_>,
) -> Result<(), IoError> {
    let touch = table.get_ref();
    let name = format!("fixture `{}`", fixture.name);
    let exact = exact_parts(touch.exact.as_ref(), fixture_parts(touch.kind), &format!("{name}, exact"), context)?;
    let is_exact_place = exact.contains(&"place");
    let keys = PlaceKeys {
        sigma_mm: touch.sigma_mm.as_ref(),
        sigma_deg: touch.sigma_deg.as_ref(),
        // Unlike in a problem, a place that is free has standard deviations: its error's.
        free: touch.free && is_exact_place,
        exact: is_exact_place,
        span: table.span(),
    };
    fixture.place_error = place_error(&keys, &name, context)?;
    let shape_keys =
        [&touch.clearance_sigma_mm, &touch.depth_sigma_mm, &touch.edge_radius_sigma_mm].map(Option::as_ref);
    let shape = shape_tolerance(shape_keys, &exact, ShapeTolerance::EXACT, &name, context)?;
    (fixture.clearance_sigma, fixture.depth_sigma) = (shape.clearance, shape.depth);
    fixture.edge_radius_sigma = shape.edge_radius;
    let (unequal, key) = (touch.unequal_clearance_sigma_mm.as_ref(), format!("{name}, unequal_clearance_sigma_mm"));
    fixture.unequal_clearance_sigma = context.number(unequal, MM, Allowed::NotNegative, &key)?.unwrap_or(0.0);
    let wear = (touch.edge_wear_mm.as_ref(), format!("{name}, edge_wear_mm"));
    fixture.edge_wear = context.number(wear.0, MM, Allowed::NotNegative, &wear.1)?.unwrap_or(0.0);
    let first = before.iter().find(|other| other.block() == fixture.block());
    match first.filter(|first| is_exact_place && first.place_error != PlaceError::default()) {
        None => Ok(()),
        Some(first) => {
            let span = touch.exact.as_ref().map_or(table.span(), Spanned::span);
            let expected = format!("`{}`, with which it is displaced, to be exact too", first.name);
            Err(IoError::unexpected(
                context.place(span, format!("{name}, exact")),
                expected,
                "standard deviations above 0",
            ))
        }
    }
}

fn place_error(keys: &PlaceKeys<'_>, field: &str, context: &Context<'_>) -> Result<PlaceError, IoError> {
    let without_error = PlacePrior::Gaussian { sigma: 0.0, sigma_angle: 0.0 };
    Ok(match place_prior(keys, without_error, field, context)?.prior {
        PlacePrior::Gaussian { sigma, sigma_angle } => PlaceError { length: sigma, angle: sigma_angle },
        PlacePrior::Fixed | PlacePrior::Flat => PlaceError::default(),
    })
}

/// The distances that are measured between `touches`.
pub(super) fn distances(
    tables: &[Spanned<MeasuredDistanceToml>],
    touches: &[Touch],
    context: &Context<'_>,
) -> Result<Vec<MeasuredDistance>, IoError> {
    let names: HashMap<&str, usize> = touches.iter().enumerate().map(|(f, touch)| (touch.name.as_str(), f)).collect();
    let each = tables.iter().map(|table| {
        let MeasuredDistanceToml { between, mm, sigma_mm, exact } = table.get_ref();
        if let Some(mm) = mm {
            let expected = "`sigma_mm` or `exact` alone, since the length is that of the simulated fixtures";
            return Err(IoError::unexpected(context.place(mm.span(), "distance, mm"), expected, "`mm`"));
        }
        let between = two_fixtures(between, &names, context)?;
        Ok(MeasuredDistance { between, sigma: distance_sigma(sigma_mm.as_ref(), exact.as_ref(), context)? })
    });
    each.collect()
}

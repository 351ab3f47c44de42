//! The placements of a problem that are read.

use std::collections::HashMap;

use toml::Spanned;

use super::context::Context;
use super::schema::{FixtureToml, Text};
use crate::io::base::error::{IoError, Place, quoted};
use crate::io::base::suggest::{did_you_mean, list};

/// Placements of a problem that are read, by their names
/// ([`Fixture::placement`](crate::estimate::Fixture::placement)); all by default.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Selection {
    /// Names of the placements to read; empty: all. A name that no fixture has is an error.
    pub only: Vec<String>,
    /// Names of placements to leave out, also of those in `only`. A name that no fixture has is an
    /// error.
    pub except: Vec<String>,
}

/// Name of the placement ([`Fixture::placement`](crate::estimate::Fixture::placement)) of the
/// fixture called `name` where its table declares none: the part of `name` before the first `/`,
/// all of it without one.
pub fn placement(name: &str) -> &str {
    name.split('/').next().unwrap_or("")
}

/// The placement of a fixture.
pub(super) fn placement_of(table: &FixtureToml) -> &str {
    table.placement.as_deref().unwrap_or_else(|| placement(table.name.get_ref()))
}

/// For each fixture its index among those that are selected; none if it is not.
pub(super) fn selected(
    tables: &[Spanned<FixtureToml>],
    selection: &Selection,
    context: &Context<'_>,
) -> Result<Vec<Option<usize>>, IoError> {
    let Selection { only, except } = selection;
    let mut known: Vec<&str> = tables.iter().map(|table| placement_of(table.get_ref())).collect();
    known.sort_unstable();
    known.dedup();
    if let Some(name) = only.iter().chain(except).find(|name| !known.contains(&name.as_str())) {
        let found = format!("{}{}", quoted(name), did_you_mean(name, known.iter().copied()));
        return Err(IoError::unexpected(Place::file(context.file), format!("a placement ({})", list(known)), found));
    }
    let has = |names: &[String], placement: &str| names.iter().any(|name| name == placement);
    let mut count = 0;
    let each = tables.iter().map(|table| {
        let placement = placement_of(table.get_ref());
        let is_selected = (only.is_empty() || has(only, placement)) && !has(except, placement);
        count += usize::from(is_selected);
        is_selected.then(|| count - 1)
    });
    let each: Vec<Option<usize>> = each.collect();
    if count == 0 {
        return Err(IoError::unexpected(Place::file(context.file), "at least one placement to be left", "none"));
    }
    Ok(each)
}

/// Index of the fixture that `field` names.
pub(super) fn fixture_index(
    name: &Text,
    names: &HashMap<&str, usize>,
    context: &Context<'_>,
    field: &str,
) -> Result<usize, IoError> {
    names.get(name.get_ref().as_str()).copied().ok_or_else(|| {
        let mut known: Vec<&str> = names.keys().copied().collect();
        known.sort_unstable();
        let found = format!("{}{}", quoted(name.get_ref()), did_you_mean(name.get_ref(), known.iter().copied()));
        IoError::unexpected(
            context.place(name.span(), field),
            format!("the name of a fixture ({})", list(known)),
            found,
        )
    })
}

/// Indices of the two fixtures that a distance is between.
pub(crate) fn two_fixtures(
    [first, second]: &[Text; 2],
    names: &HashMap<&str, usize>,
    context: &Context<'_>,
) -> Result<(usize, usize), IoError> {
    let index = |name| fixture_index(name, names, context, "distance, between");
    let between = (index(first)?, index(second)?);
    if between.0 == between.1 {
        let found = format!("{} twice", quoted(first.get_ref()));
        return Err(IoError::unexpected(context.place(second.span(), "distance, between"), "two fixtures", found));
    }
    Ok(between)
}

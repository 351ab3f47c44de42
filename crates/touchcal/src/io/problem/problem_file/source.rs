//! Where a part's shape comes from: a file, or what comes with the crate.

use toml::Spanned;

use super::assumptions::Assumptions;
use super::context::Context;
use super::schema::{LengthUnitToml, Text};
use crate::geometry::{Polygon, TriangleMesh};
use crate::io::base::bytes::Input;
use crate::io::base::error::{IoError, quoted};
use crate::io::base::suggest::did_you_mean;
use crate::io::shape::mesh;
use crate::io::shape::outline::{self, Choice};

/// The only outline that comes with the crate.
const EXTRUSION: &str = "extrusion25";

/// Outline of a peg or hole.
#[derive(Clone, Debug)]
pub(super) struct Outline {
    pub(super) profile: Polygon,
    /// The file it was read from, or its name.
    pub(super) file: String,
}

/// The keys that say what shape a part has.
pub(super) struct Sources<'a> {
    pub(super) outline: &'a Option<Text>,
    pub(super) outline_name: &'a Option<Text>,
    pub(super) outline_unit: &'a Option<Spanned<LengthUnitToml>>,
    pub(super) builtin: &'a Option<Text>,
    pub(super) mesh: &'a Option<Text>,
    pub(super) mesh_unit: &'a Option<Spanned<LengthUnitToml>>,
}

impl Sources<'_> {
    /// The first key that is there, and where.
    pub(super) fn key(&self) -> Option<(std::ops::Range<usize>, &'static str)> {
        let text = |value: &Option<Text>, key| value.as_ref().map(|value| (value.span(), key));
        text(self.outline, "outline")
            .or(text(self.builtin, "builtin"))
            .or(text(self.mesh, "mesh"))
            .or(text(self.outline_name, "outline_name"))
            .or(self.outline_unit.as_ref().map(|unit| (unit.span(), "outline_unit")))
            .or(self.mesh_unit.as_ref().map(|unit| (unit.span(), "mesh_unit")))
    }

    /// The outline, if the keys give one.
    pub(super) fn outline(
        &self,
        field: &str,
        context: &Context<'_>,
        inputs: &mut Vec<Input>,
    ) -> Result<Option<Outline>, IoError> {
        match (self.outline, self.builtin) {
            (None, builtin) => {
                let name = self.outline_name.as_ref().map(Spanned::span);
                if let Some(span) = name.or(self.outline_unit.as_ref().map(Spanned::span)) {
                    let found = "`outline_name` or `outline_unit` without it";
                    return Err(IoError::unexpected(context.place(span, field), "`outline`", found));
                }
                builtin.as_ref().map(|name| self::builtin(name, field, context)).transpose()
            }
            (Some(file), None) => self.drawn(file, field, context, inputs).map(Some),
            (Some(file), Some(_)) => {
                let place = context.place(file.span(), field);
                Err(IoError::unexpected(place, "`outline` or `builtin`", "both"))
            }
        }
    }

    /// The mesh, if the keys give one.
    pub(super) fn solid(
        &self,
        field: &str,
        context: &Context<'_>,
        (inputs, assumptions): (&mut Vec<Input>, &mut Assumptions),
    ) -> Result<Option<TriangleMesh>, IoError> {
        let Some(file) = self.mesh else {
            let Some(unit) = self.mesh_unit else { return Ok(None) };
            return Err(IoError::unexpected(context.place(unit.span(), field), "`mesh`", "`mesh_unit` without it"));
        };
        if self.outline.is_some() || self.builtin.is_some() {
            return Err(IoError::unexpected(context.place(file.span(), field), "an outline or a mesh", "both"));
        }
        let path = context.path(file, &format!("{field}, mesh"))?;
        let unit = self.mesh_unit.as_ref().map_or(LengthUnitToml::Mm, |unit| *unit.get_ref());
        let (solid, input) = mesh::read_file(&path, unit.metres())?;
        inputs.push(input);
        assumptions.several_bodies(field, solid.body_count());
        Ok(Some(solid))
    }

    fn drawn(
        &self,
        file: &Text,
        field: &str,
        context: &Context<'_>,
        inputs: &mut Vec<Input>,
    ) -> Result<Outline, IoError> {
        let unit = self.outline_unit.as_ref().map(|unit| unit.get_ref().metres());
        let name = self.outline_name.as_ref().map(|name| name.get_ref().as_str());
        let path = context.path(file, &format!("{field}, outline"))?;
        let (profile, input) = outline::read_file(&path, Choice { name, unit })?;
        let file = input.path.clone();
        inputs.push(input);
        Ok(Outline { profile, file })
    }
}

fn builtin(name: &Text, field: &str, context: &Context<'_>) -> Result<Outline, IoError> {
    if name.get_ref() == EXTRUSION {
        return Ok(Outline { profile: Polygon::extrusion25(), file: EXTRUSION.to_owned() });
    }
    let found = format!("{}{}", quoted(name.get_ref()), did_you_mean(name.get_ref(), [EXTRUSION]));
    let place = context.place(name.span(), format!("{field}, builtin"));
    Err(IoError::unexpected(place, format!("built-in outline `{EXTRUSION}`"), found))
}

//! Tool and fixture together: their shapes and contact manifold.

use std::ops::Range;
use std::rc::Rc;

use nalgebra::Point3;
use toml::Spanned;

use super::assumptions::Assumptions;
use super::context::{Allowed, Context, MM};
use super::projected;
use super::schema::{FixtureKind, FixtureToml, ManifoldToml, Number, Text, ToolKind, ToolToml};
use super::source::{Outline, Sources};
use crate::geometry::{EdgeRadii, MeshPair, Parts, PrismPair, PrismPairError, TriangleMesh};
use crate::io::base::bytes::Input;
use crate::io::base::error::{IoError, Place};
use crate::io::log::contact_log::TargetColumns;
use crate::manifold::{self, ContactManifold, FITTING, Misfit, Target, Unmodeled, check_fit, exact_manifold};

/// Name of the key of a peg's edges.
const PEG_EDGE: &str = "tool, edge_radius_mm";

/// What the tool table says of the tool's shape.
pub(crate) struct Shape {
    kind: ToolKind,
    outline: Option<Rc<Outline>>,
    solid: Option<Rc<TriangleMesh>>,
    length: Option<f64>,
    radius: Option<f64>,
    edge_radius: f64,
    span: Range<usize>,
}

impl Shape {
    pub(crate) fn of(
        tool: &Spanned<ToolToml>,
        context: &Context<'_>,
        (inputs, assumptions): (&mut Vec<Input>, &mut Assumptions),
    ) -> Result<Self, IoError> {
        let span = tool.span();
        let tool = tool.get_ref();
        let length = context.number(tool.length_mm.as_ref(), MM, Allowed::Positive, "tool, length_mm")?;
        let radius = context.number(tool.radius_mm.as_ref(), MM, Allowed::Positive, "tool, radius_mm")?;
        let edge_radius = tool.edge_radius_mm.as_ref();
        let edge_radius = context.number(edge_radius, MM, Allowed::NotNegative, PEG_EDGE)?.unwrap_or(0.0);
        let sources = Sources {
            outline: &tool.outline,
            outline_name: &tool.outline_name,
            outline_unit: &tool.outline_unit,
            builtin: &tool.builtin,
            mesh: &tool.mesh,
            mesh_unit: &tool.mesh_unit,
        };
        let number = |value: &Option<Number>, key| value.as_ref().map(|value| (value.span(), key));
        let (radius_mm, length_mm) = (number(&tool.radius_mm, "radius_mm"), number(&tool.length_mm, "length_mm"));
        let of_outline = length_mm.or(number(&tool.edge_radius_mm, "edge_radius_mm"));
        let foreign = match tool.kind {
            ToolKind::Peg => radius_mm.or(of_outline.filter(|_| tool.mesh.is_some())),
            ToolKind::Point => radius_mm.or(of_outline).or(sources.key()),
            ToolKind::Ball => of_outline.or(sources.key()),
        };
        if let Some((span, key)) = foreign {
            let has_mesh = tool.kind == ToolKind::Peg && tool.mesh.is_some();
            let name = if has_mesh { "peg's mesh" } else { tool_name(tool.kind) };
            let expected = format!("what belongs to a {name}");
            return Err(IoError::unexpected(context.place(span, "tool"), expected, format!("`{key}`")));
        }
        let outline = sources.outline("tool", context, inputs)?.map(Rc::new);
        let solid = sources.solid("tool", context, (inputs, assumptions))?.map(Rc::new);
        Ok(Shape { kind: tool.kind, outline, solid, length, radius, edge_radius, span })
    }

    /// How this tool touches a fixture.
    pub(super) fn touching(
        &self,
        fixture: &Spanned<FixtureToml>,
        context: &Context<'_>,
        (inputs, assumptions): (&mut Vec<Input>, &mut Assumptions),
    ) -> Result<Box<dyn ContactManifold>, IoError> {
        let name = format!("fixture `{}`", fixture.get_ref().name.get_ref());
        if (self.kind, fixture.get_ref().kind) == (ToolKind::Peg, FixtureKind::Hole) {
            projected::check_keys(fixture.get_ref(), &name, context)?;
            match fixture.get_ref().manifold.as_ref().map_or_else(Default::default, |chosen| *chosen.get_ref()) {
                ManifoldToml::Exact => {}
                ManifoldToml::Nearest => return projected::nearest(fixture, context, inputs),
                ManifoldToml::Learned => return projected::learned(fixture, context, inputs),
                ManifoldToml::Unknown => return Ok(Box::new(Unmodeled)),
            }
            if let Some(peg) = &self.solid {
                return solid_in_hole(peg, fixture, context, (inputs, assumptions));
            }
            let manifold = exact_manifold(&self.parts(fixture, context, inputs)?);
            let depth = context.required(fixture.get_ref().depth_mm.as_ref(), MM, fixture.span(), &name)?;
            return match check_fit(manifold.as_ref(), depth) {
                Ok(()) => Ok(manifold),
                Err(misfit) => Err(unfitting(misfit, context.place(fixture.span(), name))),
            };
        }
        if fixture.get_ref().kind == FixtureKind::Target && self.kind != ToolKind::Peg {
            return Ok(Box::new(self.at_target(fixture, context)?));
        }
        Ok(exact_manifold(&self.parts(fixture, context, inputs)?))
    }

    /// How a point or ball touches targets.
    fn at_target(&self, fixture: &Spanned<FixtureToml>, context: &Context<'_>) -> Result<Target, IoError> {
        check_keys(fixture.get_ref(), &format!("fixture `{}`", fixture.get_ref().name.get_ref()), context)?;
        match (target_columns(fixture.get_ref()), self.kind, self.radius) {
            (TargetColumns::Point, ..) => Ok(Target::Point),
            (TargetColumns::WithNormal, ToolKind::Ball, None) => Err(self.no_radius("a surface", context)),
            (TargetColumns::WithNormal, _, radius) => Ok(Target::AlongNormal { radius: radius.unwrap_or(0.0) }),
        }
    }

    /// That the ball has no radius, which `what` needs.
    fn no_radius(&self, what: &str, context: &Context<'_>) -> IoError {
        let place = context.place(self.span.clone(), "tool, radius_mm");
        IoError::unexpected(place, format!("the ball's radius, which {what} needs"), "none")
    }

    /// This tool and a fixture.
    pub(crate) fn parts(
        &self,
        fixture: &Spanned<FixtureToml>,
        context: &Context<'_>,
        inputs: &mut Vec<Input>,
    ) -> Result<Parts, IoError> {
        let name = format!("fixture `{}`", fixture.get_ref().name.get_ref());
        check_keys(fixture.get_ref(), &name, context)?;
        let on_plane = |points, radius| Ok(Parts::OnPlane { points, radius });
        match (self.kind, fixture.get_ref().kind) {
            (ToolKind::Peg, FixtureKind::Hole) => self.in_hole(self.outline(context)?, fixture, context, inputs),
            (ToolKind::Peg, FixtureKind::Plane) => {
                if let Some(solid) = &self.solid {
                    return on_plane(solid.corners(), 0.0);
                }
                self.tip_on_plane(self.outline(context)?, context)
            }
            (ToolKind::Ball, FixtureKind::Plane) => match self.radius {
                Some(radius) => on_plane(vec![Point3::origin()], radius),
                None => Err(self.no_radius("a plane", context)),
            },
            (ToolKind::Point, FixtureKind::Plane) => on_plane(vec![Point3::origin()], 0.0),
            (ToolKind::Ball | ToolKind::Point, FixtureKind::Socket) => Ok(Parts::BallInSocket),
            (ToolKind::Ball | ToolKind::Point, FixtureKind::Target) => {
                let expected = "a socket or plane, which can be simulated";
                Err(IoError::unexpected(context.place(fixture.span(), name), expected, "a target"))
            }
            (kind, _) => {
                let expected = match kind {
                    ToolKind::Peg => "a hole or plane, which a peg can touch",
                    ToolKind::Ball => "a socket, plane or target, which a ball can touch",
                    ToolKind::Point => "a socket, plane or target, which a point can touch",
                };
                let found = format!("a {}", fixture_name(fixture.get_ref().kind));
                Err(IoError::unexpected(context.place(fixture.span(), name), expected, found))
            }
        }
    }

    /// The tip of a peg of this outline, with its edges round, over a plane.
    fn tip_on_plane(&self, outline: &Outline, context: &Context<'_>) -> Result<Parts, IoError> {
        let radius = self.edge_radius;
        let eroded = if radius > 0.0 { outline.profile.offset_mitred(-radius) } else { Ok(outline.profile.clone()) };
        let eroded = eroded.map_err(|_| no_room(radius, context.place(self.span.clone(), PEG_EDGE)))?;
        let points = eroded.vertices().iter().map(|vertex| Point3::new(vertex.x, vertex.y, radius)).collect();
        Ok(Parts::OnPlane { points, radius })
    }

    /// The peg's outline.
    fn outline(&self, context: &Context<'_>) -> Result<&Outline, IoError> {
        self.outline.as_deref().ok_or_else(|| {
            let place = context.place(self.span.clone(), "tool");
            let found = if self.solid.is_some() { "`mesh`, which contacts alone can use" } else { "none" };
            IoError::unexpected(place, "`outline` or `builtin` of the peg", found)
        })
    }

    fn in_hole(
        &self,
        outline: &Outline,
        fixture: &Spanned<FixtureToml>,
        context: &Context<'_>,
        inputs: &mut Vec<Input>,
    ) -> Result<Parts, IoError> {
        let span = fixture.span();
        let fixture = fixture.get_ref();
        let name = format!("fixture `{}`", fixture.name.get_ref());
        let depth = context.required(fixture.depth_mm.as_ref(), MM, span.clone(), &format!("{name}, depth_mm"))?;
        let Some(length) = self.length else {
            let place = context.place(self.span.clone(), "tool, length_mm");
            return Err(IoError::unexpected(place, "the peg's length, which a hole needs", "none"));
        };
        let mesh = fixture.mesh.as_ref().map(Spanned::span);
        if let Some(span) = mesh.or(fixture.mesh_unit.as_ref().map(Spanned::span)) {
            let expected = "an outline of the hole, as the peg has, or a mesh of both";
            return Err(IoError::unexpected(context.place(span, name), expected, "a mesh of the hole alone"));
        }
        let own = fixture_sources(fixture).outline(&name, context, inputs)?;
        let field = format!("{name}, outline_offset_mm");
        let offset = context.number(fixture.outline_offset_mm.as_ref(), MM, Allowed::Positive, &field)?;
        let fault = |file: &str, message: String| IoError::syntax(Place::file(file), message);
        let hole = match (own, offset) {
            (Some(own), None) => own.profile,
            (None, Some(offset)) => {
                outline.profile.offset_mitred(offset).map_err(|error| fault(&outline.file, error.to_string()))?
            }
            (own, _) => {
                let found = if own.is_some() { "both" } else { "neither" };
                let expected = "either `outline_offset_mm` or the hole's own `outline`";
                return Err(IoError::unexpected(context.place(span, name), expected, found));
            }
        };
        let field = format!("{name}, edge_radius_mm");
        let rim = context.number(fixture.edge_radius_mm.as_ref(), MM, Allowed::NotNegative, &field)?;
        let edge_radii = EdgeRadii { peg: self.edge_radius, hole: rim.unwrap_or(0.0) };
        let sharp = PrismPair::new(outline.profile.clone(), length, hole, depth);
        let sharp = sharp.map_err(|error| fault(&outline.file, error.to_string()))?;
        let shapes = sharp.with_edge_radii(edge_radii).map_err(|error| match error {
            PrismPairError::EdgeRadius { part: "peg", found } => {
                no_room(found, context.place(self.span.clone(), PEG_EDGE))
            }
            _ => no_room(edge_radii.hole, context.place(span, field)),
        })?;
        Ok(Parts::PegInHole(Box::new(shapes)))
    }
}

/// That edges have no room for a radius (m).
fn no_room(radius: f64, place: Place) -> IoError {
    let expected = "a radius that each edge of the part is long enough for";
    IoError::unexpected(place, expected, format!("{} mm", 1e3 * radius))
}

/// A peg and a hole as meshes.
fn solid_in_hole(
    peg: &TriangleMesh,
    table: &Spanned<FixtureToml>,
    context: &Context<'_>,
    read: (&mut Vec<Input>, &mut Assumptions),
) -> Result<Box<dyn ContactManifold>, IoError> {
    let fixture = table.get_ref();
    let name = format!("fixture `{}`", fixture.name.get_ref());
    let offset = fixture.outline_offset_mm.as_ref().map(|offset| (offset.span(), "outline_offset_mm"));
    let sources = fixture_sources(fixture);
    let outline = sources.key().filter(|_| fixture.mesh.is_none());
    let edges = fixture.edge_radius_mm.as_ref().map(|radius| (radius.span(), "edge_radius_mm"));
    if let Some((span, key)) = offset.or(outline).or(edges) {
        let expected = "what belongs to a hole's `mesh`, as the peg has, or outlines of both";
        return Err(IoError::unexpected(context.place(span, name), expected, format!("`{key}`")));
    }
    let depth = context.required(fixture.depth_mm.as_ref(), MM, table.span(), &format!("{name}, depth_mm"))?;
    let place = || context.place(table.span(), &name);
    let Some(hole) = sources.solid(&name, context, read)? else {
        return Err(IoError::unexpected(place(), "`mesh` of the hole, as the peg has", "none"));
    };
    manifold::peg_in_hole(MeshPair::new(peg.clone(), hole), depth).map_err(|misfit| unfitting(misfit, place()))
}

fn unfitting(misfit: Misfit, place: Place) -> IoError {
    IoError::unexpected(place, FITTING, misfit.to_string())
}

fn fixture_sources(fixture: &FixtureToml) -> Sources<'_> {
    Sources {
        outline: &fixture.outline,
        outline_name: &fixture.outline_name,
        outline_unit: &fixture.outline_unit,
        builtin: &fixture.builtin,
        mesh: &fixture.mesh,
        mesh_unit: &fixture.mesh_unit,
    }
}

/// Only a hole has a depth, an outline and a choice of manifolds, and only targets have normals.
fn check_keys(fixture: &FixtureToml, name: &str, context: &Context<'_>) -> Result<(), IoError> {
    let normal =
        fixture.along_normal.as_ref().filter(|normal| *normal.get_ref() && fixture.kind != FixtureKind::Target);
    if fixture.kind == FixtureKind::Hole && normal.is_none() {
        return Ok(());
    }
    let number = |value: &Option<Number>, key| value.as_ref().map(|value| (value.span(), key));
    let text = |value: &Option<Text>, key| value.as_ref().map(|value| (value.span(), key));
    let of_normal = normal.map(|normal| (normal.span(), "along_normal"));
    let foreign = of_normal
        .or(number(&fixture.depth_mm, "depth_mm"))
        .or(number(&fixture.outline_offset_mm, "outline_offset_mm"))
        .or(number(&fixture.edge_radius_mm, "edge_radius_mm"))
        .or(number(&fixture.clearance_sigma_mm, "clearance_sigma_mm"))
        .or(number(&fixture.depth_sigma_mm, "depth_sigma_mm"))
        .or(number(&fixture.edge_radius_sigma_mm, "edge_radius_sigma_mm"))
        .or(fixture_sources(fixture).key())
        .or(fixture.manifold.as_ref().map(|manifold| (manifold.span(), "manifold")))
        .or(text(&fixture.samples, "samples"))
        .or(text(&fixture.weights, "weights"))
        .or(number(&fixture.neighbours, "neighbours"))
        .or(number(&fixture.mm_per_deg, "mm_per_deg"));
    match foreign {
        None => Ok(()),
        Some((span, key)) => {
            let expected = format!("what belongs to a {}", fixture_name(fixture.kind));
            Err(IoError::unexpected(context.place(span, name), expected, format!("`{key}`")))
        }
    }
}

/// Which columns of targets the logs of a fixture of that kind have.
pub(super) fn target_columns(fixture: &FixtureToml) -> TargetColumns {
    match fixture.along_normal.as_ref().is_some_and(|normal| *normal.get_ref()) {
        true => TargetColumns::WithNormal,
        false => TargetColumns::Point,
    }
}

fn tool_name(kind: ToolKind) -> &'static str {
    match kind {
        ToolKind::Peg => "peg",
        ToolKind::Ball => "ball",
        ToolKind::Point => "point",
    }
}

fn fixture_name(kind: FixtureKind) -> &'static str {
    match kind {
        FixtureKind::Hole => "hole",
        FixtureKind::Socket => "socket",
        FixtureKind::Plane => "plane",
        FixtureKind::Target => "target",
    }
}

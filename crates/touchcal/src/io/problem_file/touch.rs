//! Tool and fixture together: their shapes and contact manifold.

use std::ops::Range;
use std::rc::Rc;

use nalgebra::{Point2, Point3};
use toml::Spanned;

use super::context::{Allowed, Context, MM};
use super::projected;
use super::schema::{FixtureKind, FixtureToml, ManifoldToml, Number, Text, ToolKind, ToolToml};
use crate::experiment::manifold_of;
use crate::geometry::extrusion::PegAndHole;
use crate::geometry::profile::Profile;
use crate::io::bytes::Input;
use crate::io::error::{IoError, Place, quoted};
use crate::io::outline;
use crate::io::suggest::did_you_mean;
use crate::manifold::{ContactManifold, Unknown};
use crate::sim::Parts;

/// The only outline that comes with the crate.
const EXTRUSION: &str = "extrusion25";

/// Outline of a peg or hole.
#[derive(Clone, Debug)]
enum Outline {
    /// The T-slot extrusion of 25 mm.
    Extrusion25,
    /// Vertices (m), from a file.
    Polygon { vertices: Vec<[f64; 2]>, file: String },
}

/// Outline of a hole: its own, or the peg's moved outwards (m).
#[derive(Clone, Debug)]
enum HoleOutline {
    Own(Outline),
    Offset(f64),
}

/// What the tool table says of the tool's shape.
pub(in crate::io) struct Shape {
    kind: ToolKind,
    outline: Option<Rc<Outline>>,
    length: Option<f64>,
    radius: Option<f64>,
    span: Range<usize>,
}

impl Shape {
    pub(in crate::io) fn of(
        tool: &Spanned<ToolToml>,
        context: &Context<'_>,
        inputs: &mut Vec<Input>,
    ) -> Result<Self, IoError> {
        let span = tool.span();
        let tool = tool.get_ref();
        let length = context.number(tool.length_mm.as_ref(), MM, Allowed::Positive, "tool, length_mm")?;
        let radius = context.number(tool.radius_mm.as_ref(), MM, Allowed::Positive, "tool, radius_mm")?;
        let foreign = match tool.kind {
            ToolKind::Peg => [tool.radius_mm.as_ref().map(|v| (v.span(), "radius_mm")), None, None],
            ToolKind::Point => [
                tool.radius_mm.as_ref().map(|v| (v.span(), "radius_mm")),
                tool.length_mm.as_ref().map(|v| (v.span(), "length_mm")),
                tool.outline.as_ref().or(tool.builtin.as_ref()).map(|v| (v.span(), "outline")),
            ],
            ToolKind::Ball => [
                tool.length_mm.as_ref().map(|v| (v.span(), "length_mm")),
                tool.outline.as_ref().or(tool.builtin.as_ref()).map(|v| (v.span(), "outline")),
                None,
            ],
        };
        if let Some((span, key)) = foreign.into_iter().flatten().next() {
            let expected = format!("what belongs to a {}", tool_name(tool.kind));
            return Err(IoError::unexpected(context.place(span, "tool"), expected, format!("`{key}`")));
        }
        let sources = Sources { outline: &tool.outline, builtin: &tool.builtin, mesh: &tool.mesh };
        let outline = sources.read("tool", context, inputs)?.map(Rc::new);
        Ok(Shape { kind: tool.kind, outline, length, radius, span })
    }

    /// How this tool touches a fixture.
    pub(super) fn touching(
        &self,
        fixture: &Spanned<FixtureToml>,
        context: &Context<'_>,
        inputs: &mut Vec<Input>,
    ) -> Result<Box<dyn ContactManifold>, IoError> {
        let name = format!("fixture `{}`", fixture.get_ref().name.get_ref());
        if (self.kind, fixture.get_ref().kind) == (ToolKind::Peg, FixtureKind::Hole) {
            projected::check_keys(fixture.get_ref(), &name, context)?;
            match fixture.get_ref().manifold.as_ref().map_or_else(Default::default, |chosen| *chosen.get_ref()) {
                ManifoldToml::Exact => {}
                ManifoldToml::Nearest => return projected::nearest(fixture, context, inputs),
                ManifoldToml::Learned => return projected::learned(fixture, context, inputs),
                ManifoldToml::Unknown => return Ok(Box::new(Unknown)),
            }
        }
        Ok(manifold_of(&self.parts(fixture, context, inputs)?))
    }

    /// This tool and a fixture.
    pub(in crate::io) fn parts(
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
                let outline = self.outline(context)?;
                let tip = profile(outline).map_err(|message| place_outline(outline, message))?;
                on_plane(tip.vertices().iter().map(|vertex| Point3::new(vertex.x, vertex.y, 0.0)).collect(), 0.0)
            }
            (ToolKind::Ball, FixtureKind::Plane) => match self.radius {
                Some(radius) => on_plane(vec![Point3::origin()], radius),
                None => {
                    let place = context.place(self.span.clone(), "tool, radius_mm");
                    Err(IoError::unexpected(place, "the ball's radius, which a plane needs", "none"))
                }
            },
            (ToolKind::Point, FixtureKind::Plane) => on_plane(vec![Point3::origin()], 0.0),
            (ToolKind::Ball | ToolKind::Point, FixtureKind::Socket) => Ok(Parts::BallInSocket),
            (kind, _) => {
                let expected = match kind {
                    ToolKind::Peg => "a hole or plane, which a peg can touch",
                    ToolKind::Ball => "a socket or plane, which a ball can touch",
                    ToolKind::Point => "a socket or plane, which a point can touch",
                };
                let found = format!("a {}", fixture_name(fixture.get_ref().kind));
                Err(IoError::unexpected(context.place(fixture.span(), name), expected, found))
            }
        }
    }

    /// The peg's outline.
    fn outline(&self, context: &Context<'_>) -> Result<&Outline, IoError> {
        self.outline.as_deref().ok_or_else(|| {
            let place = context.place(self.span.clone(), "tool");
            IoError::unexpected(place, "`outline` or `builtin` of the peg", "none")
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
        let sources = Sources { outline: &fixture.outline, builtin: &fixture.builtin, mesh: &fixture.mesh };
        let own = sources.read(&name, context, inputs)?;
        let field = format!("{name}, outline_offset_mm");
        let offset = context.number(fixture.outline_offset_mm.as_ref(), MM, Allowed::Positive, &field)?;
        let hole = match (own, offset) {
            (Some(own), None) => HoleOutline::Own(own),
            (None, Some(offset)) => HoleOutline::Offset(offset),
            (own, _) => {
                let found = if own.is_some() { "both" } else { "neither" };
                let expected = "either `outline_offset_mm` or the hole's own `outline`";
                return Err(IoError::unexpected(context.place(span, name), expected, found));
            }
        };
        peg_in_hole(outline, &hole, depth, length).map_err(|message| place_outline(outline, message))
    }
}

/// The keys that name an outline.
struct Sources<'a> {
    outline: &'a Option<Text>,
    builtin: &'a Option<Text>,
    mesh: &'a Option<Text>,
}

impl Sources<'_> {
    fn read(&self, field: &str, context: &Context<'_>, inputs: &mut Vec<Input>) -> Result<Option<Outline>, IoError> {
        if let Some(mesh) = self.mesh {
            let found = format!("mesh {}, which is not supported yet", quoted(mesh.get_ref()));
            return Err(IoError::unexpected(context.place(mesh.span(), field), "an outline", found));
        }
        match (self.outline, self.builtin) {
            (None, None) => Ok(None),
            (Some(file), None) => {
                let (vertices, input) = outline::read_file(&context.path(file, &format!("{field}, outline"))?)?;
                let file = input.path.clone();
                inputs.push(input);
                Ok(Some(Outline::Polygon { vertices, file }))
            }
            (None, Some(builtin)) if builtin.get_ref() == EXTRUSION => Ok(Some(Outline::Extrusion25)),
            (None, Some(builtin)) => {
                let found = format!("{}{}", quoted(builtin.get_ref()), did_you_mean(builtin.get_ref(), [EXTRUSION]));
                let place = context.place(builtin.span(), format!("{field}, builtin"));
                Err(IoError::unexpected(place, format!("built-in outline `{EXTRUSION}`"), found))
            }
            (Some(file), Some(_)) => {
                let place = context.place(file.span(), field);
                Err(IoError::unexpected(place, "`outline` or `builtin`", "both"))
            }
        }
    }
}

/// Only a hole has a depth, an outline and a choice of manifolds.
fn check_keys(fixture: &FixtureToml, name: &str, context: &Context<'_>) -> Result<(), IoError> {
    if fixture.kind == FixtureKind::Hole {
        return Ok(());
    }
    let number = |value: &Option<Number>, key| value.as_ref().map(|value| (value.span(), key));
    let text = |value: &Option<Text>, key| value.as_ref().map(|value| (value.span(), key));
    let foreign = number(&fixture.depth_mm, "depth_mm")
        .or(number(&fixture.outline_offset_mm, "outline_offset_mm"))
        .or(text(&fixture.outline, "outline"))
        .or(text(&fixture.builtin, "builtin"))
        .or(text(&fixture.mesh, "mesh"))
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
    }
}

fn place_outline(outline: &Outline, message: String) -> IoError {
    let file = match outline {
        Outline::Extrusion25 => EXTRUSION,
        Outline::Polygon { file, .. } => file,
    };
    IoError::syntax(Place::file(file), message)
}

/// A peg of `length` (m) and a hole of `depth` (m).
fn peg_in_hole(outline: &Outline, hole_outline: &HoleOutline, depth: f64, length: f64) -> Result<Parts, String> {
    let peg = profile(outline)?;
    let hole = match hole_outline {
        HoleOutline::Own(own) => profile(own)?,
        HoleOutline::Offset(offset) => peg.offset_mitred(*offset).map_err(|error| error.to_string())?,
    };
    let shapes = PegAndHole::new(peg, length, hole, depth).map_err(|error| error.to_string())?;
    Ok(Parts::PegInHole(Box::new(shapes)))
}

fn profile(outline: &Outline) -> Result<Profile, String> {
    match outline {
        Outline::Extrusion25 => Ok(Profile::extrusion25()),
        Outline::Polygon { vertices, .. } => {
            let vertices = vertices.iter().map(|&[x, y]| Point2::new(x, y)).collect();
            Profile::new(vertices).map_err(|error| error.to_string())
        }
    }
}

//! Poses, the tool and the fixtures.

use serde::Deserialize;
use toml::{Spanned, Value};

use super::value::{Number, Text};

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct PoseToml {
    /// Translation. Without it: [0, 0, 0].
    /// Example: `xyz_mm = [0, 0, 150]`
    #[serde(default)]
    pub(crate) xyz_mm: [f64; 3],
    /// Rotation as a unit quaternion, w first. Without it: no rotation.
    /// Example: `quat_wxyz = [0, 0, 1, 0]`
    pub(crate) quat_wxyz: Option<[f64; 4]>,
    /// Instead of a quaternion: roll, pitch and yaw about the fixed axes x, y and z, as in a URDF.
    /// Without it: no rotation.
    /// Example: `rpy_deg = [180, 0, 90]`
    pub(crate) rpy_deg: Option<[f64; 3]>,
}

#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub(crate) enum ToolKind {
    Peg,
    Ball,
    Point,
}

/// The unit of a drawing or mesh.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum LengthUnitToml {
    Mm,
    Cm,
    M,
    Inch,
}

impl LengthUnitToml {
    /// How long it is (m).
    pub(crate) fn metres(self) -> f64 {
        match self {
            LengthUnitToml::Mm => 1e-3,
            LengthUnitToml::Cm => 1e-2,
            LengthUnitToml::M => 1.0,
            LengthUnitToml::Inch => 25.4e-3,
        }
    }
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ToolToml {
    /// Kind of tool.
    /// Example: `kind = "peg"`
    pub(crate) kind: ToolKind,
    /// Nominal pose of the tool frame in the frame of the tip link. Without it: the frame of the
    /// tip link.
    /// Example: `tip_from_tool = { xyz_mm = [0, 0, 150], quat_wxyz = [0, 0, 1, 0] }`
    pub(crate) tip_from_tool: Option<Spanned<PoseToml>>,
    /// Drawing of a peg's section: CSV with `x_mm,y_mm`, SVG or DXF. Without it: `builtin` or
    /// `mesh` is required for a peg.
    /// Example: `outline = "peg.svg"`
    pub(crate) outline: Option<Text>,
    /// The outline in a drawing of several: an id of the SVG, a layer of the DXF. Without it: the
    /// only closed outline.
    /// Example: `outline_name = "peg"`
    pub(crate) outline_name: Option<Text>,
    /// Unit of a drawing that does not state it. Without it: as the drawing states.
    /// Example: `outline_unit = "mm"`
    pub(crate) outline_unit: Option<Spanned<LengthUnitToml>>,
    /// Instead of a drawing: a built-in section. One of: `extrusion25`. Without it: `outline` or
    /// `mesh` is required for a peg.
    /// Example: `builtin = "extrusion25"`
    pub(crate) builtin: Option<Text>,
    /// Instead of a section: the peg as a closed mesh (STL or OBJ), at most 20,000 triangles.
    /// Without it: `outline` or `builtin` is required for a peg.
    /// Example: `mesh = "peg.stl"`
    pub(crate) mesh: Option<Text>,
    /// Unit of the mesh. Without it: mm.
    /// Example: `mesh_unit = "inch"`
    pub(crate) mesh_unit: Option<Spanned<LengthUnitToml>>,
    /// Length of a peg that is given by its section. Without it: required for such a peg in a hole
    /// whose `manifold` is `exact`.
    /// Example: `length_mm = 40`
    pub(crate) length_mm: Option<Number>,
    /// Radius of a peg's edges. Without it: 0.
    /// Example: `edge_radius_mm = 0.2`
    pub(crate) edge_radius_mm: Option<Number>,
    /// Radius of a ball. Without it: required for a ball on a plane.
    /// Example: `radius_mm = 10`
    pub(crate) radius_mm: Option<Number>,
    /// Standard deviation of each component of the tool's position on the tip link; not with
    /// `free`. Without it: 0.3, in `scenario.toml` 0; no prior if `tool` is among the parameters
    /// and nothing is declared of its pose.
    /// Example: `sigma_mm = 0.1`
    pub(crate) sigma_mm: Option<Number>,
    /// Standard deviation of each component of its rotation; not with `free`. Without it: 0.2, in
    /// `scenario.toml` 0; no prior if `tool` is among the parameters and nothing is declared of its
    /// pose.
    /// Example: `sigma_deg = 0.05`
    pub(crate) sigma_deg: Option<Number>,
    /// Whether the tool's pose has no prior; its nominal pose is where the search starts. Without
    /// it: false.
    /// Example: `free = true`
    #[serde(default)]
    pub(crate) free: bool,
    /// What of the tool is exact: `true`, or a list of `place` and `outline` (which always is).
    /// Without it: nothing but the outline.
    /// Example: `exact = ["place"]`
    pub(crate) exact: Option<Spanned<Value>>,
}

#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub(crate) enum FixtureKind {
    Hole,
    Socket,
    Plane,
    Target,
}

/// How the contact manifold of a hole is known.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub(crate) enum ManifoldToml {
    #[default]
    Exact,
    Nearest,
    Learned,
    Unknown,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct FixtureToml {
    /// Name, unique in the file; fixtures `A/0` and `A/1` are on one placement `A`.
    /// Example: `name = "hole"`
    pub(crate) name: Text,
    /// Kind of fixture.
    /// Example: `kind = "hole"`
    pub(crate) kind: FixtureKind,
    /// Whether rows of a target give a surface's normal too, `nx`, `ny`, `nz`, of which only the
    /// distance along it counts. Without it: false.
    /// Example: `along_normal = true`
    pub(crate) along_normal: Option<Spanned<bool>>,
    /// The placement to which the fixture belongs, for `--only` and `--except` and for
    /// `joint_drift`. Without it: the name up to its first `/`.
    /// Example: `placement = "left"`
    pub(crate) placement: Option<String>,
    /// Nominal pose of the fixture in the base frame. Without it: unknown, for a socket or a
    /// target's frame whose pose has no prior; required for others.
    /// Example: `base_from_fixture = { xyz_mm = [600, 100, 150], rpy_deg = [0, 0, 20] }`
    pub(crate) base_from_fixture: Option<Spanned<PoseToml>>,
    /// Drawing of a hole's section, as that of the tool. Without it: that of the peg, larger by
    /// `outline_offset_mm`.
    /// Example: `outline = "hole.dxf"`
    pub(crate) outline: Option<Text>,
    /// The outline in a drawing of several: an id of the SVG, a layer of the DXF. Without it: the
    /// only closed outline.
    /// Example: `outline_name = "hole"`
    pub(crate) outline_name: Option<Text>,
    /// Unit of a drawing that does not state it. Without it: as the drawing states.
    /// Example: `outline_unit = "mm"`
    pub(crate) outline_unit: Option<Spanned<LengthUnitToml>>,
    /// Instead of a section of its own: by how much the hole's is larger than the peg's, on each
    /// side. Without it: the hole's own section or mesh is required.
    /// Example: `outline_offset_mm = 0.5`
    pub(crate) outline_offset_mm: Option<Number>,
    /// Instead of a drawing: a built-in section. One of: `extrusion25`. Without it: that of the
    /// peg, larger by `outline_offset_mm`.
    /// Example: `builtin = "extrusion25"`
    pub(crate) builtin: Option<Text>,
    /// Instead of a section: the body around the hole as a closed mesh (STL or OBJ), where the tool
    /// has one too. Without it: none.
    /// Example: `mesh = "hole.stl"`
    pub(crate) mesh: Option<Text>,
    /// Unit of the mesh. Without it: mm.
    /// Example: `mesh_unit = "inch"`
    pub(crate) mesh_unit: Option<Spanned<LengthUnitToml>>,
    /// Depth of a hole; with a mesh how far the peg goes in. Without it: required for a hole whose
    /// `manifold` is `exact`.
    /// Example: `depth_mm = 30`
    pub(crate) depth_mm: Option<Number>,
    /// Radius of a hole's edges. Without it: 0.
    /// Example: `edge_radius_mm = 0.2`
    pub(crate) edge_radius_mm: Option<Number>,
    /// How the contact manifold of a hole is known. Without it: exact.
    /// Example: `manifold = "learned"`
    pub(crate) manifold: Option<Spanned<ManifoldToml>>,
    /// Recorded poses of the tool in the hole, for `nearest`. Without it: required for `nearest`.
    /// Example: `samples = "manifold.csv"`
    pub(crate) samples: Option<Text>,
    /// Trained network, for `learned`. Without it: required for `learned`.
    /// Example: `weights = "network.safetensors"`
    pub(crate) weights: Option<Text>,
    /// Number of nearest poses that are averaged, for `nearest`; 1 to 1000. Without it: 1.
    /// Example: `neighbours = 8`
    pub(crate) neighbours: Option<Number>,
    /// Length that counts as much as a degree, for `nearest`. Without it: as the samples were
    /// thinned, else 1.
    /// Example: `mm_per_deg = 2`
    pub(crate) mm_per_deg: Option<Number>,
    /// Standard deviation of each component of the fixture's position; not with `free`. Without it:
    /// 1; no prior if `fixture` is among the parameters and nothing is declared of its pose.
    /// Example: `sigma_mm = 0.2`
    pub(crate) sigma_mm: Option<Number>,
    /// Standard deviation of each component of its rotation; not with `free`. Without it: 0.5; no
    /// prior if `fixture` is among the parameters and nothing is declared of its pose.
    /// Example: `sigma_deg = 0.05`
    pub(crate) sigma_deg: Option<Number>,
    /// Standard deviation of a hole's clearance on each side, without effect on another `manifold`
    /// than `exact`. Without it: 0.03.
    /// Example: `clearance_sigma_mm = 0.01`
    pub(crate) clearance_sigma_mm: Option<Number>,
    /// Standard deviation of a hole's depth, without effect on another `manifold` than `exact`.
    /// Without it: 0.03.
    /// Example: `depth_sigma_mm = 0.02`
    pub(crate) depth_sigma_mm: Option<Number>,
    /// Standard deviation of a radius by which the edges of peg and hole are rounder than declared;
    /// not with meshes, nor with another `manifold` than `exact`. Without it: 0.05.
    /// Example: `edge_radius_sigma_mm = 0.1`
    pub(crate) edge_radius_sigma_mm: Option<Number>,
    /// Whether the fixture's pose has no prior; its nominal pose is where the search starts.
    /// Without it: false.
    /// Example: `free = true`
    #[serde(default)]
    pub(crate) free: bool,
    /// What of the fixture is exact: `true`, or a list of `place`, and of a hole `outline` (which
    /// always is), `clearance`, `depth` and `edge_radius`. Without it: nothing but the outline.
    /// Example: `exact = ["depth"]`
    pub(crate) exact: Option<Spanned<Value>>,
}

//! Outlines of pegs and holes: vertices as comma-separated values, or drawings as SVG or DXF.
//!
//! Curves of drawings become straight pieces, whose vertices lie on the curve and which are nowhere
//! farther from it than [`TOLERANCE`]; or than 6 µm, if there would be more than
//! [`MAX_POLYGON_VERTICES`].

mod csv;
mod curves;
mod dxf;
mod svg;

use std::path::Path;

use nalgebra::Point2;

use crate::geometry::{MAX_POLYGON_VERTICES, Polygon};
use crate::io::base::bytes::{self, Input};
use crate::io::base::error::{IoError, Place};

/// Largest outline file read (bytes), 16 MiB.
pub const MAX_BYTES: u64 = 16 << 20;
/// Largest coordinate (m). A larger one is in another unit.
const LARGEST: f64 = 10.0;
/// Largest distance (m) of the straight pieces from a curve of a drawing that needs no more than
/// [`MAX_POLYGON_VERTICES`] of them, and of ends of curves that are joined from each other.
pub const TOLERANCE: f64 = 1e-6;

/// What part of a drawing to read, and its unit; all `None` for files of vertices.
#[derive(Clone, Copy, Debug, Default)]
pub struct Choice<'a> {
    /// Id of an element of an SVG, or name of a layer of a DXF; `None`: the whole drawing. Either
    /// must have exactly one closed outline.
    pub name: Option<&'a str>,
    /// Length of the drawing's unit (m, > 0); `None` if the drawing states it. The two must not
    /// contradict each other, to 10⁻⁹ of the length.
    pub unit: Option<f64>,
}

/// Reads an outline file (m) as [`read`] does, and returns its fingerprint too.
///
/// # Errors
/// As [`read`], and if the file cannot be read.
pub fn read_file(path: &Path, choice: Choice<'_>) -> Result<(Polygon, Input), IoError> {
    let (bytes, input) = bytes::read_all(path, MAX_BYTES)?;
    Ok((read(&bytes, &input.path, choice)?, input))
}

/// Reads one closed outline (m), in the format of the extension of `file`, its name, in any case:
/// `.svg` or `.dxf` drawings, otherwise comma-separated values `x_mm,y_mm`, a vertex a line, the
/// header optional. `choice` is for drawings.
///
/// The origin is that of the file: of a drawing's own coordinates, not of its sheet, view box or
/// outline. x points to the right and y up: the y of an SVG, which points down, changes its sign.
/// Transforms of an SVG are applied. Vertices are as in [`Polygon::new`].
///
/// # Errors
/// [`IoError`] if there are more than [`MAX_BYTES`], the bytes are no such file or a coordinate is
/// beyond ±10 m; the extension is that of a mesh (`.stl`, `.obj`) or of a format that is not read
/// (`.step`, `.stp`, `.iges`, `.igs`, `.ply`, `.dwg`, `.3mf`); `choice` is given for
/// comma-separated values; there is not exactly one closed outline, which ends that join to no
/// other within [`TOLERANCE`] rule out; or the outline is no [`Polygon`]. For a drawing also if
/// nothing has the name in `choice`, its unit is unknown or contradicts that in `choice`, or a part
/// of it is not read: `<use>` and nested `<svg>` of an SVG; splines, helices, blocks, multilines,
/// regions and solids of a DXF.
pub fn read(bytes: &[u8], file: &str, choice: Choice<'_>) -> Result<Polygon, IoError> {
    let extension = Path::new(file).extension().and_then(|extension| extension.to_str()).unwrap_or_default();
    let extension = extension.to_ascii_lowercase();
    let refused = |found: String| Err(IoError::unexpected(Place::file(file), "an outline as CSV, SVG or DXF", found));
    bytes::check_size(bytes.len() as u64, MAX_BYTES, file)?;
    let vertices = match extension.as_str() {
        "svg" => svg::read(bytes::text_from(bytes, file)?, file, choice)?,
        "dxf" => dxf::read(bytes::text_from(bytes, file)?, file, choice)?,
        "stl" | "obj" => return refused("a mesh, which the key `mesh` takes".to_owned()),
        "step" | "stp" | "iges" | "igs" | "ply" | "dwg" | "3mf" => {
            return refused(format!("a .{extension} file, which is not supported"));
        }
        _ if choice.name.is_some() || choice.unit.is_some() => {
            return refused("`outline_name` or `outline_unit`, and vertices, which are one outline in mm".to_owned());
        }
        _ => csv::read(bytes::text_from(bytes, file)?, file)?,
    };
    let vertices = vertices.iter().map(|&[x, y]| Point2::new(x, y)).collect();
    Polygon::new(vertices).map_err(|error| IoError::syntax(Place::file(file), error.to_string()))
}

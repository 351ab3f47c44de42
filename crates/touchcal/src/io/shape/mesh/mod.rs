//! Bodies as triangles: STL, binary or as text, and OBJ.

mod obj;
mod stl;

use std::path::Path;

use nalgebra::Point3;

use crate::geometry::{MAX_TRIANGLES, TriangleMesh};
use crate::io::base::bytes::{self, Input};
use crate::io::base::error::{IoError, Place};

/// Largest mesh file read (bytes), 256 MiB.
pub const MAX_BYTES: u64 = 256 << 20;
/// Largest coordinate (m). A larger one is in another unit.
const LARGEST: f64 = 10.0;

/// Least extent (m) in some direction. A smaller part is in another unit.
const SMALLEST: f64 = 1e-4;

/// Triangles as a file has them, not yet put together; lengths in the file's unit.
#[derive(Default)]
struct Soup {
    vertices: Vec<Point3<f64>>,
    triangles: Vec<[u32; 3]>,
}

impl Soup {
    /// Adds a triangle with vertices of its own.
    fn push(&mut self, corners: [Point3<f64>; 3]) {
        let first = self.vertices.len() as u32;
        self.vertices.extend(corners);
        self.triangles.push([first, first + 1, first + 2]);
    }
}

/// Reads a mesh file as a body in the frame of its coordinates, and returns its fingerprint too.
/// `unit` (m, > 0) is the length of the file's unit, which no mesh file states: 0.001 for
/// millimetres.
///
/// # Errors
/// As [`read`], and if the file cannot be read.
pub fn read_file(path: &Path, unit: f64) -> Result<(TriangleMesh, Input), IoError> {
    let (bytes, input) = bytes::read_all(path, MAX_BYTES)?;
    Ok((read(&bytes, &input.path, unit)?, input))
}

/// Reads a mesh as STL (binary or text) or OBJ, by the extension of `file`, its name, in any case.
/// The body's frame (m) is that of the file's coordinates. `unit` (m, > 0) is the length of the
/// file's unit: 0.001 for millimetres. The order of a triangle's corners says which side is
/// outside; stated normals are not read.
///
/// # Errors
/// [`IoError`] if there are more than [`MAX_BYTES`] or [`MAX_TRIANGLES`], the extension is another,
/// the bytes are no such file, a face of an OBJ is cut into triangles that overlap, the part is
/// smaller than 0.1 mm in all directions or extends beyond 10 m from the origin, or
/// [`TriangleMesh::new`] refuses the triangles: if they are no closed surface, the message says
/// where it is open.
pub fn read(bytes: &[u8], file: &str, unit: f64) -> Result<TriangleMesh, IoError> {
    bytes::check_size(bytes.len() as u64, MAX_BYTES, file)?;
    let extension = Path::new(file).extension().and_then(|extension| extension.to_str()).unwrap_or_default();
    let mut soup = match extension.to_ascii_lowercase().as_str() {
        "stl" => stl::read(bytes, file)?,
        "obj" => obj::read(bytes::text_from(bytes, file)?, file)?,
        other => {
            let found =
                if other.is_empty() { "a file without extension".to_owned() } else { format!("a .{other} file") };
            return Err(IoError::unexpected(Place::file(file), "a mesh as STL or OBJ", found));
        }
    };
    let (mut least, mut most) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for (k, vertex) in soup.vertices.iter_mut().enumerate() {
        *vertex *= unit;
        if !vertex.iter().all(|c| c.abs() <= LARGEST) {
            let place = Place::file(file).field(format!("vertex {}", k + 1));
            let guess = if unit > 1e-3 { "looks like millimetres" } else { "looks like another unit" };
            let found = format!("({}, {}, {}) m: {guess}, see `mesh_unit`", vertex.x, vertex.y, vertex.z);
            return Err(IoError::unexpected(place, format!("coordinates within ±{LARGEST} m"), found));
        }
        for (i, coordinate) in vertex.iter().enumerate() {
            least[i] = coordinate.min(least[i]);
            most[i] = coordinate.max(most[i]);
        }
    }
    let across = (0..3).map(|i| most[i] - least[i]).fold(f64::NEG_INFINITY, f64::max);
    if (0.0..SMALLEST).contains(&across) {
        let expected = format!("a part at least {} mm across", 1e3 * SMALLEST);
        let found = format!("{:.3} mm: looks like metres, see `mesh_unit`", 1e3 * across);
        return Err(IoError::unexpected(Place::file(file), expected, found));
    }
    TriangleMesh::new(&soup.vertices, &soup.triangles)
        .map_err(|error| IoError::syntax(Place::file(file), error.to_string()))
}

fn too_many(place: Place) -> IoError {
    let found = "more: simplify the mesh; within 0.005 mm of the part it is accurate enough";
    IoError::unexpected(place, format!("a mesh of at most {MAX_TRIANGLES} triangles"), found)
}

//! Wavefront OBJ: vertices `v x y z` and faces `f a b c …`, which name them. Faces of more corners
//! are cut into triangles about their first one. Everything else a file may hold (normals,
//! textures, groups, materials) is passed over.

use nalgebra::{Point3, Vector3};

use super::{Soup, too_many};
use crate::geometry::MAX_TRIANGLES;
use crate::io::base::error::{IoError, Place, quoted};

pub(super) fn read(text: &str, file: &str) -> Result<Soup, IoError> {
    let mut soup = Soup::default();
    for (index, line) in text.lines().enumerate() {
        let place = || Place::file(file).line(index as u64 + 1);
        if line.trim_end().ends_with('\\') {
            return Err(IoError::unexpected(place(), "a line of its own for each element", "a line that goes on"));
        }
        let mut words = line.split('#').next().unwrap_or_default().split_ascii_whitespace();
        match words.next() {
            Some("v") => {
                // A fourth number is a weight, further ones a colour.
                let numbers: Vec<f64> = words.take(3).map_while(|word| word.parse().ok()).collect();
                match numbers.as_slice() {
                    &[x, y, z] if numbers.iter().all(|number| number.is_finite()) => {
                        soup.vertices.push(Point3::new(x, y, z));
                    }
                    _ => {
                        let expected = "`v` and three finite numbers";
                        return Err(IoError::unexpected(place(), expected, quoted(line.trim())));
                    }
                }
                if soup.vertices.len() > 3 * MAX_TRIANGLES {
                    return Err(too_many(place()));
                }
            }
            Some("f") => {
                let corners = words.map(|word| vertex(word, soup.vertices.len())).collect::<Option<Vec<u32>>>();
                let Some([first, rest @ ..]) = corners.as_deref().filter(|corners| corners.len() >= 3) else {
                    let expected = format!("`f` and three or more of the {} vertices so far", soup.vertices.len());
                    return Err(IoError::unexpected(place(), expected, quoted(line.trim())));
                };
                let face: Vec<[u32; 3]> = rest.windows(2).map(|pair| [*first, pair[0], pair[1]]).collect();
                if !turns_one_way(&face, &soup.vertices) {
                    let expected = "a face whose triangles about its first vertex do not overlap (export triangles)";
                    return Err(IoError::unexpected(place(), expected, quoted(line.trim())));
                }
                soup.triangles.extend(face);
                if soup.triangles.len() > MAX_TRIANGLES {
                    return Err(too_many(place()));
                }
            }
            _ => {}
        }
    }
    if soup.triangles.is_empty() {
        return Err(IoError::unexpected(Place::file(file), "faces, lines that begin with `f`", "none"));
    }
    Ok(soup)
}

/// Whether triangles of one face all look the same way.
fn turns_one_way(face: &[[u32; 3]], vertices: &[Point3<f64>]) -> bool {
    let normal = |&[a, b, c]: &[u32; 3]| {
        let [p, q, r] = [a, b, c].map(|i| vertices[i as usize]);
        (q - p).cross(&(r - p))
    };
    let total: Vector3<f64> = face.iter().map(normal).sum();
    face.len() == 1 || face.iter().all(|triangle| normal(triangle).dot(&total) >= 0.0)
}

/// The vertex that the corner of a face names: `7`, `7/1`, `7/1/3` or `7//3`, from 1, or from the
/// last one backwards, −1.
fn vertex(word: &str, count: usize) -> Option<u32> {
    let index: i64 = word.split('/').next()?.parse().ok()?;
    let index = if index < 0 { index + count as i64 } else { index - 1 };
    u32::try_from(index).ok().filter(|&index| (index as usize) < count)
}

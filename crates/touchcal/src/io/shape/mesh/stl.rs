//! STL: triangles without order, as 50 bytes each or as text. Their normals are not read; the order
//! of corners says which side is outside.

use nalgebra::Point3;

use super::{Soup, too_many};
use crate::geometry::MAX_TRIANGLES;
use crate::io::base::bytes;
use crate::io::base::error::{IoError, Place, quoted, shown_number};

/// Bytes of a binary file before its triangles: a comment and the number of triangles.
const HEADER: usize = 84;
/// Bytes of a triangle: a normal, three corners, an attribute.
const RECORD: usize = 50;

pub(super) fn read(bytes: &[u8], file: &str) -> Result<Soup, IoError> {
    // Binary files may begin with `solid` too; a file is binary if its size matches its number of
    // triangles.
    match stated_count(bytes) {
        Some(count) if bytes.len() == HEADER + RECORD * count => binary(bytes, count, file),
        _ if bytes.trim_ascii_start().starts_with(b"solid") => text(bytes::text_from(bytes, file)?, file),
        Some(count) => {
            let expected =
                format!("{} bytes, for the {count} triangles that the header states", HEADER + RECORD * count);
            Err(IoError::unexpected(Place::file(file), expected, format!("{} bytes", bytes.len())))
        }
        None => {
            let expected = "an STL file: `solid`, or a header of 84 bytes";
            Err(IoError::unexpected(Place::file(file), expected, format!("{} bytes of something else", bytes.len())))
        }
    }
}

fn stated_count(bytes: &[u8]) -> Option<usize> {
    let count = bytes.get(HEADER - 4..HEADER)?;
    Some(u32::from_le_bytes(count.try_into().ok()?) as usize)
}

fn binary(bytes: &[u8], count: usize, file: &str) -> Result<Soup, IoError> {
    if count > MAX_TRIANGLES {
        return Err(too_many(Place::file(file)));
    }
    let mut soup = Soup::default();
    for (k, record) in bytes[HEADER..].chunks_exact(RECORD).enumerate() {
        // Twelve bytes of normal come first.
        let number = |i: usize| {
            let at = 12 + 4 * i;
            f64::from(f32::from_le_bytes([record[at], record[at + 1], record[at + 2], record[at + 3]]))
        };
        let numbers: [f64; 9] = std::array::from_fn(number);
        if let Some(bad) = numbers.iter().find(|number| !number.is_finite()) {
            let place = Place::file(file).field(format!("triangle {}", k + 1));
            return Err(IoError::unexpected(place, "finite coordinates", shown_number(*bad)));
        }
        soup.push([0, 3, 6].map(|i| Point3::new(numbers[i], numbers[i + 1], numbers[i + 2])));
    }
    Ok(soup)
}

/// `solid`, then for each triangle `facet normal … outer loop vertex … vertex … vertex … endloop
/// endfacet`, then `endsolid`.
fn text(text: &str, file: &str) -> Result<Soup, IoError> {
    let mut soup = Soup::default();
    let mut corners: Vec<Point3<f64>> = Vec::with_capacity(3);
    let (mut has_ended, mut last) = (false, 1);
    for (index, line) in text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty()) {
        last = index as u64 + 1;
        let place = || Place::file(file).line(last);
        let mut words = line.split_ascii_whitespace();
        match words.next().unwrap_or_default() {
            "solid" => has_ended = false,
            "endsolid" => has_ended = true,
            "facet" | "outer" | "endloop" => {}
            "vertex" => {
                let numbers: Vec<f64> = words.map_while(|word| word.parse().ok()).collect();
                match numbers.as_slice() {
                    &[x, y, z] if numbers.iter().all(|number| number.is_finite()) && corners.len() < 3 => {
                        corners.push(Point3::new(x, y, z));
                    }
                    _ => {
                        let expected = "`vertex` and three finite numbers, three times in a facet";
                        return Err(IoError::unexpected(place(), expected, quoted(line.trim())));
                    }
                }
            }
            "endfacet" => {
                let Ok(triangle) = <[Point3<f64>; 3]>::try_from(corners.as_slice()) else {
                    let found = format!("{}", corners.len());
                    return Err(IoError::unexpected(place(), "three vertices in a facet", found));
                };
                if soup.triangles.len() == MAX_TRIANGLES {
                    return Err(too_many(place()));
                }
                soup.push(triangle);
                corners.clear();
            }
            _ => {
                let expected = "`facet`, `outer loop`, `vertex`, `endloop`, `endfacet` or `endsolid`";
                return Err(IoError::unexpected(place(), expected, quoted(line.trim())));
            }
        }
    }
    if has_ended && corners.is_empty() {
        return Ok(soup);
    }
    Err(IoError::unexpected(Place::file(file).line(last), "`endsolid` at the end", "nothing more"))
}

//! Outlines of pegs and holes as comma-separated values: `x_mm,y_mm`, a vertex a line.

use super::{LARGEST, MAX_POLYGON_VERTICES};
use crate::io::base::error::{IoError, Place, quoted};

/// Reads the vertices (m) of an outline; a first line without numbers is a header and must say
/// `x_mm,y_mm`.
pub(super) fn read(text: &str, file: &str) -> Result<Vec<[f64; 2]>, IoError> {
    let mut vertices = Vec::new();
    let mut begun = false;
    for (index, line) in text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty()) {
        let place = || Place::file(file).line(index as u64 + 1);
        let cells: Vec<&str> = line.split(',').map(|cell| cell.trim().trim_matches('"')).collect();
        let header = !begun && cells.iter().all(|cell| cell.parse::<f64>().is_err());
        begun = true;
        if header {
            let named = |cell: &str, name: &str| cell.eq_ignore_ascii_case(name);
            if cells.len() != 2 || !named(cells[0], "x_mm") || !named(cells[1], "y_mm") {
                return Err(IoError::unexpected(place(), "header `x_mm,y_mm`, or two numbers", quoted(line.trim())));
            }
            continue;
        }
        let [x, y] = cells.as_slice() else {
            return Err(IoError::unexpected(place(), "two numbers `x_mm,y_mm`", quoted(line.trim())));
        };
        let coordinate = |cell: &str, name: &str| match cell.parse::<f64>() {
            Ok(value) if value.abs() <= 1e3 * LARGEST => Ok(value * 1e-3),
            _ => {
                let expected = format!("a number of mm within ±{}", 1e3 * LARGEST);
                Err(IoError::unexpected(place().field(format!("column {name}")), expected, quoted(cell)))
            }
        };
        vertices.push([coordinate(x, "x_mm")?, coordinate(y, "y_mm")?]);
        if vertices.len() > MAX_POLYGON_VERTICES {
            return Err(IoError::unexpected(place(), format!("at most {MAX_POLYGON_VERTICES} vertices"), "more"));
        }
    }
    if vertices.len() < 3 {
        return Err(IoError::unexpected(Place::file(file), "at least 3 vertices", format!("{}", vertices.len())));
    }
    Ok(vertices)
}

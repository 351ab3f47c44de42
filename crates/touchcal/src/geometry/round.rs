//! Bodies of revolution, which come as polygons or triangles: their facets are none of theirs.

use std::f64::consts::TAU;

use nalgebra::Point3;

/// Which of peg and hole is round about its axis z, but for facets: turning about that axis changes no gap.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Round {
    /// The peg.
    pub peg: bool,
    /// The hole.
    pub hole: bool,
}

/// Widest turn (rad) between corners that stand for a circle: sixteen do, the twelve of a prism do not.
const WIDEST: f64 = TAU / 15.0;
/// How far from the circle they may be, over the body's size.
const TOLERANCE: f64 = 2e-4;

/// Corners of one height and distance from the axis.
struct Ring {
    height: f64,
    radius: f64,
    angles: Vec<f64>,
}

impl Ring {
    /// Whether they go all round.
    fn is_full(&mut self) -> bool {
        self.angles.sort_unstable_by(f64::total_cmp);
        let (Some(first), Some(last)) = (self.angles.first(), self.angles.last()) else { return false };
        let across = first + TAU - last;
        across <= WIDEST && self.angles.windows(2).all(|pair| pair[1] - pair[0] <= WIDEST)
    }
}

/// Whether corners (m) are those of a body of revolution about z: in full circles, or on the axis.
pub(crate) fn is_round(corners: impl Iterator<Item = Point3<f64>>) -> bool {
    let corners: Vec<Point3<f64>> = corners.collect();
    let size = corners.iter().map(|corner| corner.xy().coords.norm()).fold(0.0, f64::max);
    let near = TOLERANCE * size;
    let mut rings: Vec<Ring> = Vec::new();
    for corner in corners {
        let (radius, angle) = (corner.xy().coords.norm(), corner.y.atan2(corner.x));
        if radius < near {
            continue;
        }
        let of_ring = |ring: &&mut Ring| (ring.height - corner.z).abs() < near && (ring.radius - radius).abs() < near;
        match rings.iter_mut().find(of_ring) {
            Some(ring) => ring.angles.push(angle),
            None => rings.push(Ring { height: corner.z, radius, angles: vec![angle] }),
        }
    }
    !rings.is_empty() && rings.iter_mut().all(Ring::is_full)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A prism's ends, each of so many corners, the second with another radius (m).
    fn ends(corners: usize, second: f64) -> Vec<Point3<f64>> {
        let corner = |k: usize, radius: f64, z: f64| {
            let (sin, cos) = (TAU * k as f64 / corners as f64).sin_cos();
            Point3::new(radius * cos, radius * sin, z)
        };
        (0..corners).flat_map(|k| [corner(k, 0.01, 0.0), corner(k, second, 0.04)]).collect()
    }

    #[test]
    fn full_circles_are_round_and_prisms_are_not() {
        let is_round = |corners: &[Point3<f64>]| super::is_round(corners.iter().copied());
        assert!(is_round(&ends(16, 0.01)) && is_round(&ends(128, 0.009)));
        assert!(!is_round(&ends(12, 0.01)) && !is_round(&ends(6, 0.009)));
        let mut flattened = ends(128, 0.01);
        flattened.retain(|corner| corner.x < 0.009);
        assert!(!is_round(&flattened));
        let mut beside = ends(128, 0.01);
        beside.iter_mut().for_each(|corner| corner.x += 0.1e-3);
        assert!(!is_round(&beside));
        assert!(!is_round(&[]));
    }
}

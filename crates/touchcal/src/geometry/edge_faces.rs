//! How the gap between two prisms at an edge depends on the radius of the edge.

use nalgebra::{Vector2, Vector3};

use super::polygon::Polygon;

/// Faces whose normals differ by less (rad) are one.
const SAME: f64 = 1e-6;

/// Normals of the faces of a prism along z.
///
/// With all edges rounded to the radius ρ, a plane with the normal `n` touches the prism
/// `ρ (Σ aᵢ − 1)` farther inside. The coefficients `aᵢ ≥ 0` are those of `n = Σ aᵢ mᵢ`, with the
/// normals `mᵢ` of the faces that meet at the edge. The sum is 1 for a contact at a face.
#[derive(Clone, Debug)]
pub struct EdgeFaces {
    /// Different normals of the sides, by their angle.
    sides: Vec<Vector2<f64>>,
}

impl EdgeFaces {
    /// Of a prism with this outline.
    pub fn new(outline: &Polygon) -> Self {
        let mut angles: Vec<f64> = (0..outline.len())
            .map(|i| {
                let outward = outline.outward(i);
                outward.y.atan2(outward.x)
            })
            .collect();
        angles.sort_unstable_by(f64::total_cmp);
        angles.dedup_by(|a, b| (*a - *b).abs() < SAME);
        EdgeFaces { sides: angles.into_iter().map(|angle| Vector2::new(angle.cos(), angle.sin())).collect() }
    }

    /// `Σ aᵢ − 1` (1, ≥ 0) for the outward unit normal of the prism at a contact. The sides are the
    /// two whose normals enclose it, wherever they are on the outline. At a corner of an outline
    /// that is not convex, where a side elsewhere has a normal between those of the corner, the
    /// result is too small.
    pub fn excess(&self, normal: &Vector3<f64>) -> f64 {
        let across = normal.xy();
        let following = self.sides.iter().cycle().skip(1);
        let sums = self.sides.iter().zip(following).filter_map(|(first, second)| {
            // Cramer's rule.
            let area = first.perp(second);
            let parts = [across.perp(second) / area, first.perp(&across) / area];
            (area > 0.0 && parts[0] >= -SAME && parts[1] >= -SAME).then(|| parts[0] + parts[1])
        });
        let sides = sums.fold(f64::INFINITY, f64::min);
        let sides = if sides.is_finite() { sides } else { across.norm() };
        (sides + normal.z.abs() - 1.0).max(0.0)
    }
}

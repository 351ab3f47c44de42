//! How much farther two parts are apart where they touch at round edges.

use nalgebra::{Vector2, Vector3};

use super::polygon::Polygon;

/// Faces whose normals differ by less (rad) are one.
const SAME: f64 = 1e-6;

/// The faces of a prism along z, by which a contact at an edge is told from one at a face.
///
/// Rounding all edges of a prism to the radius ρ moves the point at which a plane of normal `n`
/// touches it back by `ρ (Σ aᵢ − 1)`, where `n = Σ aᵢ mᵢ` with the normals `mᵢ` of the faces that
/// meet there: nothing at a face, `ρ (|n_r| + |n_z| − 1)` at an edge of its end with a normal `n_r`
/// of a side.
#[derive(Clone, Debug)]
pub struct EdgeGauge {
    /// Different normals of the sides, by their angle.
    sides: Vec<Vector2<f64>>,
}

impl EdgeGauge {
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
        EdgeGauge { sides: angles.into_iter().map(|angle| Vector2::new(angle.cos(), angle.sin())).collect() }
    }

    /// `Σ aᵢ − 1` (1, ≥ 0) of a unit vector along the outward normal of the prism at a contact. The
    /// sides are those next to it by their angle, wherever they are on the outline: too small a
    /// number at a corner of an outline that has a side of an angle between those of the corner
    /// elsewhere, as outlines that are not convex may have.
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

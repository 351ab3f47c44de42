//! What is fixed of the mode of a contact while a search takes its last steps.

use nalgebra::Vector3;

/// Least cosine of the angle between the normals of candidates that are of one surface.
const ALIKE: f64 = 0.95;

/// What is fixed of the mode of a contact.
#[derive(Clone, Debug)]
pub(crate) struct FixedMode {
    /// Whether the contact has candidates, since its surfaces can be distinguished; `None` where
    /// this is found at each evaluation.
    pub is_distinct: Option<bool>,
    /// Normals (tool frame) of the surfaces that bear its load, where the load is known.
    pub bearing_normals: Vec<Vector3<f64>>,
}

impl FixedMode {
    /// Whether a candidate with this `normal` (tool frame) is of a surface that bears the load.
    pub fn is_bearing(&self, normal: &Vector3<f64>) -> bool {
        self.bearing_normals.iter().any(|bearing| bearing.dot(normal) > ALIKE)
    }
}

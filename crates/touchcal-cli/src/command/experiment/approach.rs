//! The approaches that are compared: what a contact says, and how parameters are searched for.

use std::sync::Arc;

use touchcal::estimate::{GradientDescent, Loss, Method, Noise};
use touchcal::experiment::Search;
use touchcal::geometry::extrusion::PegAndHole;
use touchcal::io::Input;
use touchcal::manifold::{ContactManifold, PegInHole, Projected, Projection};

const DEG: f64 = std::f64::consts::PI / 180.0;
const MM: f64 = 1e-3;
/// Encoder and contact noise of an exact gap, as the demonstration declares them.
const GAP_NOISE: Noise = Noise { encoder: 0.002 * DEG, contact: 0.02 * MM, is_estimated: false };
/// A projection is off by what lies between samples, or by what the network has not learned: of the
/// order of a millimetre, to be learned.
const PROJECTION_NOISE: Noise = Noise { encoder: 0.0, contact: MM, is_estimated: true };
/// Geman–McClure at three standard deviations, for gaps.
const GAP_LOSS: Loss = Loss::GemanMcClure(3.0);
/// Huber at 95 % efficiency (Zhang 1997, table 1): every contact keeps its say, as in a mean of
/// absolute distances.
const PROJECTION_LOSS: Loss = Loss::Huber(1.345);

/// What a contact says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Touch {
    /// The pose minus the network's projection.
    Learned,
    /// The pose minus the nearest sample.
    Nearest,
    /// The exact gap.
    Exact,
}

/// What is compared: a row of the table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Approach {
    /// What a contact says.
    pub touch: Touch,
    /// Gradient descent, else Levenberg–Marquardt.
    pub descends: bool,
    /// Name in files.
    pub key: &'static str,
    /// Name for people.
    pub label: &'static str,
}

/// All approaches, in the order of the table.
pub const ALL: [Approach; 5] = [
    approach(Touch::Learned, true, "learned_gd", "MLP + gradient descent"),
    approach(Touch::Learned, false, "learned_lm", "MLP + LM"),
    approach(Touch::Nearest, true, "nearest_gd", "nearest sample + gradient descent"),
    approach(Touch::Nearest, false, "nearest_lm", "nearest sample + LM"),
    approach(Touch::Exact, false, "exact_lm", "exact gap + LM"),
];

const fn approach(touch: Touch, descends: bool, key: &'static str, label: &'static str) -> Approach {
    Approach { touch, descends, key, label }
}

impl Approach {
    /// How it searches, with this descent if it descends.
    pub fn search(&self, descent: GradientDescent) -> Search {
        let method = if self.descends { Method::GradientDescent(descent) } else { Method::LevenbergMarquardt };
        match self.touch {
            Touch::Exact => Search { method, noise: GAP_NOISE, loss: GAP_LOSS },
            Touch::Learned | Touch::Nearest => Search { method, noise: PROJECTION_NOISE, loss: PROJECTION_LOSS },
        }
    }
}

/// What approaches project onto, as far as it was given.
pub struct Manifolds {
    /// Exact shapes.
    pub parts: PegAndHole,
    /// Samples.
    pub nearest: Option<Arc<dyn Projection>>,
    /// A trained network.
    pub learned: Option<Arc<dyn Projection>>,
    /// The files that they came from.
    pub inputs: Vec<(Touch, Input)>,
}

impl Manifolds {
    /// What `touch` measures with; none if its file was not given.
    pub fn manifold(&self, touch: Touch) -> Option<Box<dyn ContactManifold>> {
        let projected = |projection: &Arc<dyn Projection>| -> Box<dyn ContactManifold> {
            Box::new(Projected(Arc::clone(projection)))
        };
        match touch {
            Touch::Learned => self.learned.as_ref().map(projected),
            Touch::Nearest => self.nearest.as_ref().map(projected),
            Touch::Exact => Some(Box::new(PegInHole::new(self.parts.clone()))),
        }
    }
}

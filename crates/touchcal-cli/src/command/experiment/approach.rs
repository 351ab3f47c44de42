//! The approaches that are compared: contact model and optimizer.

use std::sync::Arc;

use touchcal::estimate::{GradientDescent, Loss, Method, Noise};
use touchcal::experiment::Search;
use touchcal::geometry::PrismPair;
use touchcal::io::Input;
use touchcal::manifold::{ContactManifold, PegInHole, Projected, Projection};

use crate::args::ApproachName;

const DEG: f64 = std::f64::consts::PI / 180.0;
const MM: f64 = 1e-3;
/// Encoder and contact noise of an exact gap, as the demonstration declares them.
const GAP_NOISE: Noise = Noise { encoder: 0.002 * DEG, contact: 0.02 * MM, is_estimated: false };
/// A projection's error is the distance between samples or the error of the network: of the order
/// of a millimetre, to be estimated.
const PROJECTION_NOISE: Noise = Noise { encoder: 0.0, contact: MM, is_estimated: true };
/// Geman–McClure at three standard deviations, for gaps.
const GAP_LOSS: Loss = Loss::GemanMcClure(3.0);
/// Huber at 95 % efficiency (Zhang 1997, table 1): every contact keeps its influence, as in a mean
/// of absolute distances.
const PROJECTION_LOSS: Loss = Loss::Huber(1.345);

/// How the misfit of a contact is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ContactModel {
    /// The pose minus the network's projection.
    Learned,
    /// The pose minus the nearest sample.
    Nearest,
    /// The exact gap.
    Exact,
}

/// A row of the table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Approach {
    /// How the misfit of a contact is measured.
    pub model: ContactModel,
    /// Gradient descent, else Levenberg–Marquardt.
    pub descends: bool,
    /// Name in arguments and files.
    pub name: ApproachName,
    /// Name for people.
    pub label: &'static str,
}

/// All approaches, in the order of the table.
pub const ALL: [Approach; 5] = [
    approach(ContactModel::Learned, true, ApproachName::LearnedGd, "MLP + gradient descent"),
    approach(ContactModel::Learned, false, ApproachName::LearnedLm, "MLP + LM"),
    approach(ContactModel::Nearest, true, ApproachName::NearestGd, "nearest sample + gradient descent"),
    approach(ContactModel::Nearest, false, ApproachName::NearestLm, "nearest sample + LM"),
    approach(ContactModel::Exact, false, ApproachName::ExactLm, "exact gap + LM"),
];

const fn approach(model: ContactModel, descends: bool, name: ApproachName, label: &'static str) -> Approach {
    Approach { model, descends, name, label }
}

impl Approach {
    /// The optimizer with noise and loss; `descent` is used by gradient descent.
    pub fn search(&self, descent: GradientDescent) -> Search {
        let method = if self.descends { Method::GradientDescent(descent) } else { Method::LevenbergMarquardt };
        match self.model {
            ContactModel::Exact => Search { method, noise: GAP_NOISE, loss: GAP_LOSS },
            ContactModel::Learned | ContactModel::Nearest => {
                Search { method, noise: PROJECTION_NOISE, loss: PROJECTION_LOSS }
            }
        }
    }
}

/// Contact manifolds of the approaches, as far as given.
pub struct Manifolds {
    /// Exact shapes.
    pub parts: PrismPair,
    /// Samples.
    pub nearest: Option<Arc<dyn Projection>>,
    /// A trained network.
    pub learned: Option<Arc<dyn Projection>>,
    /// The files that they came from.
    pub inputs: Vec<(ContactModel, Input)>,
}

impl Manifolds {
    /// The manifold of `model`; none if its file was not given.
    pub fn manifold(&self, model: ContactModel) -> Option<Box<dyn ContactManifold>> {
        let projected = |projection: &Arc<dyn Projection>| -> Box<dyn ContactManifold> {
            Box::new(Projected(Arc::clone(projection)))
        };
        match model {
            ContactModel::Learned => self.learned.as_ref().map(projected),
            ContactModel::Nearest => self.nearest.as_ref().map(projected),
            ContactModel::Exact => Some(Box::new(PegInHole::new(self.parts.clone()))),
        }
    }
}

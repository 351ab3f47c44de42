//! What is assumed where no standard deviations are declared, and other notes on parts.

use serde::{Deserialize, Serialize};

use super::tolerance::DeclaredPrior;
use crate::estimate::{PlacePrior, ShapeTolerance, WrenchTolerance};

/// Collects what is assumed of tool, fixtures, distances and wrench where nothing is declared,
/// which standard deviations are declared 0, and which meshes have several bodies.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Assumptions {
    of_parts: Vec<String>,
    exact_by_zero: Vec<String>,
    of_several_bodies: Vec<String>,
}

impl Assumptions {
    /// Notes what is assumed of the place of a part named `part` in messages. Without
    /// `has_rotation` its rotation has no effect on any contact and is not spoken of.
    pub fn place(&mut self, part: &str, declared: DeclaredPrior, has_rotation: bool) {
        let is_assumed = declared.is_assumed || declared.is_partly_assumed && has_rotation;
        if let (PlacePrior::Gaussian { sigma, sigma_angle }, true) = (declared.prior, is_assumed) {
            let angle = if has_rotation { format!(", {}°", rounded(sigma_angle.to_degrees())) } else { String::new() };
            self.of_parts.push(format!("{part}: place ± {} mm{angle}", rounded(1e3 * sigma)));
        }
        let has_zero = match declared.prior {
            PlacePrior::Gaussian { sigma, .. } => sigma == 0.0 || has_rotation,
            PlacePrior::Fixed | PlacePrior::Flat => true,
        };
        if declared.is_exact_by_zero && has_zero {
            self.exact_by_zero.push(part.to_owned());
        }
    }

    /// Notes what is assumed of the shape of a hole named `part` in messages, of whose clearance,
    /// depth and edges the standard deviations `declared` (m) are declared.
    pub fn shape(&mut self, part: &str, declared: [Option<f64>; 3], tolerance: ShapeTolerance) {
        let ShapeTolerance { clearance, depth, edge_radius } = tolerance;
        let sigmas = [("clearance", clearance), ("depth", depth), ("edge radius", edge_radius)];
        for (declared, (name, sigma)) in declared.into_iter().zip(sigmas) {
            match declared {
                None if sigma > 0.0 => self.of_parts.push(format!("{part}: {name} ± {} mm", rounded(1e3 * sigma))),
                Some(0.0) => self.exact_by_zero.push(format!("{part}: {name}")),
                _ => {}
            }
        }
    }

    /// Notes the assumed standard deviation `sigma` (m) of the distance of two fixtures, or that it
    /// is declared 0.
    pub fn distance(&mut self, between: [&str; 2], declared: Option<f64>, sigma: f64) {
        let part = format!("distance {}–{}", between[0], between[1]);
        match declared {
            None => self.of_parts.push(format!("{part}: ± {} mm", rounded(1e3 * sigma))),
            Some(0.0) => self.exact_by_zero.push(part),
            Some(_) => {}
        }
    }

    /// Notes what is assumed of the measured wrench; `declared` are the standard deviations that
    /// are declared of the biases of forces and moments, their noise (N, N m), and the scale (1).
    pub fn wrench(&mut self, declared: [Option<f64>; 5], tolerance: WrenchTolerance) {
        let WrenchTolerance { force, torque, scale, force_noise, torque_noise } = tolerance;
        let names =
            ["bias of the forces", "bias of the moments", "noise of the forces", "noise of the moments", "scale"];
        let sizes = [
            format!("{force} N"),
            format!("{torque} N m"),
            format!("{force_noise} N"),
            format!("{torque_noise} N m"),
            format!("{} %", rounded(100.0 * scale)),
        ];
        for ((declared, name), size) in declared.into_iter().zip(names).zip(sizes) {
            match declared {
                None => self.of_parts.push(format!("wrench: {name} ± {size}")),
                Some(0.0) => self.exact_by_zero.push(format!("wrench: {name}")),
                Some(_) => {}
            }
        }
    }

    /// Notes that the mesh of a part named `part` in messages has `count` bodies, if these are
    /// several.
    pub fn several_bodies(&mut self, part: &str, count: usize) {
        if count > 1 {
            self.of_several_bodies.push(format!("{part} ({count})"));
        }
    }

    /// Forgets what is assumed of the place of the part that is named `part` in messages, which is
    /// declared anew.
    pub fn forget_place(&mut self, part: &str) {
        self.of_parts.retain(|assumed| !assumed.strip_prefix(part).is_some_and(|rest| rest.starts_with(": place")));
        self.exact_by_zero.retain(|exact| exact != part);
    }

    /// Whether a mesh has several bodies that are apart, usually a mistake of the export.
    pub fn has_several_bodies(&self) -> bool {
        !self.of_several_bodies.is_empty()
    }

    /// Notes for people, as far as there is anything to say: what is assumed, how to declare it
    /// with the `keys`, what a standard deviation of 0 makes exact, and which meshes have several
    /// bodies.
    pub fn notes(&self, keys: &str) -> Vec<String> {
        let assumed = (!self.of_parts.is_empty()).then(|| {
            let parts = self.of_parts.join("; ");
            format!("assumed, since no standard deviations are declared: {parts}; declare them ({keys})")
        });
        let exact = (!self.exact_by_zero.is_empty())
            .then(|| format!("standard deviations of 0 are taken as exact: {}", self.exact_by_zero.join(", ")));
        let several = (!self.of_several_bodies.is_empty()).then(|| {
            let parts = self.of_several_bodies.join(", ");
            format!("meshes of several bodies, each of which can be touched: {parts}; export what is meant as one closed surface")
        });
        assumed.into_iter().chain(exact).chain(several).collect()
    }
}

/// Four digits after the point at most.
fn rounded(value: f64) -> f64 {
    (1e4 * value).round() / 1e4
}

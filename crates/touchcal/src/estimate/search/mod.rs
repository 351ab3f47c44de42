//! The search for the minimum.

mod annealing;
mod coarse_to_fine;
mod contact_modes;
mod gradient_descent;
mod multi_start;
mod newton;
mod state;
mod variance_components;

pub(crate) use coarse_to_fine::{coarse, coarse_to_fine};
pub(crate) use contact_modes::{approach_contact_modes, refine, residual_prediction, sandwich, uses_contact_modes};
pub(crate) use gradient_descent::descend;
pub(crate) use multi_start::fit_from_starts;
pub(crate) use state::SearchState;
pub(crate) use variance_components::estimate_variance_components;

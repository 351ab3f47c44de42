//! A problem as a function of its parameters: residuals, derivatives and weights of every factor of
//! the cost, and their sums.

mod assembly;
mod calibration_model;
mod contact_factor;
mod declared_factors;
mod deflection_by_load;
mod em_step;
mod false_rows;
mod fixed_modes;
mod gross_rows;
mod layout;
mod linearization;
mod mode_statistics;
mod noise;
mod objective;
mod omitted_effects;
mod residual_rows;
mod resolution;
mod row_biases;
mod stretches;
mod trend_axis;
mod unestimated_errors;
mod whitening;

pub(crate) use assembly::{contact_caches, contact_equations, normal_equations, whitened_norms};
pub(crate) use calibration_model::CalibrationModel;
pub(crate) use contact_factor::ContactFactor;
pub(crate) use declared_factors::{add_distances, add_priors, distance_information, distance_row, prior_information};
pub(crate) use em_step::{Expectation, em_step};
pub(crate) use false_rows::no_contact_bounds;
pub(crate) use fixed_modes::{fix_bearing, fix_modes, unborne_share};
pub(crate) use gross_rows::gross_rows;
pub(crate) use layout::{PriorGroup, parameter_count};
pub(crate) use linearization::LinearizationPoint;
pub(crate) use mode_statistics::{
    ContactModeStatistics, Curvature, InformativeShare, contact_mode_statistics, observed_equations,
};
pub(crate) use objective::Objective;
pub(crate) use omitted_effects::{OmittedParameters, has_exact_declarations, with_omitted_effects};
pub(crate) use resolution::set_resolution;
pub(crate) use stretches::{Stretch, residual_stretches};
pub(crate) use unestimated_errors::{extended_or_own, uncertain_edges, with_unestimated_errors};

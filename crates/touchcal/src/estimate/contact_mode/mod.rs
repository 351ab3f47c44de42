//! The likelihood of a one-sided contact whose active constraints are not known.
//!
//! A peg in a hole rests against one or several of the surfaces near it; which, is not measured.
//! The *contact mode* (the set of active constraints) is a latent variable, marginalized in the
//! likelihood of the contact; how often each surface is touched is estimated by
//! expectation–maximisation. Where the load is measured, candidates are those that bear it.

mod active_set;
mod bearing;
mod candidates;
mod counts;
mod fixed_mode;
mod likelihood;
mod prior;
mod soft_gate;

pub(crate) use bearing::bearing;
pub(crate) use candidates::{CandidateContacts, CandidateMatrix, CandidateVector};
pub(crate) use counts::{ContactCounts, PseudoCounts};
pub(crate) use fixed_mode::FixedMode;
pub(crate) use likelihood::{MarginalLikelihood, marginal_likelihood};
pub(crate) use prior::ContactModePrior;

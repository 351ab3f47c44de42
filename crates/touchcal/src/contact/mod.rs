//! Contacts: joint positions at which the tool touched a fixture, each with where it was read from.
//!
//! | file | holds |
//! |---|---|
//! | `log` | [`ContactLog`], the contacts |
//! | `detection` | [`Detector`], contact from force |
//! | `angle_unit` | [`AngleUnit`], and the check of joint positions against the joint limits |
//! | `load` | [`Load`], a measured wrench as the load on the arm; [`TorqueOf`], measured torques |
//! | `ingest` | [`ContactIngest`], which makes contacts of the rows of a log |
//! | `target` | [`target_pose`], places that contacts touch, one for each contact |
//! | `repetition` | [`repeated_contacts`], stretches of a log that are there twice |
//! | `wrap` | angles that a recorder wraps |

mod angle_unit;
mod detection;
mod ingest;
mod load;
mod log;
mod merged_notes;
mod repetition;
mod target;
mod wrap;

pub use angle_unit::AngleUnit;
pub(crate) use angle_unit::{UnitCheck, UnitGuess};
pub use detection::{Detection, Detector};
pub(crate) use ingest::Row;
pub use ingest::{ContactIngest, IngestOptions, KnownRows, LogFull, MAX_CONTACTS};
pub use load::{Load, LoadFrame, LoadOn, TorqueOf};
pub use log::{ContactLog, RowsLeftOut, Source};
pub use repetition::{note_repetition, repeated_contacts, repeated_rows_note};
pub use target::target_pose;

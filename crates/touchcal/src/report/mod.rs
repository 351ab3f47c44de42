//! A calibration, or the evaluation of one, as one HTML page that needs no other file; and what
//! summaries as text have in common: [`DeclarationTests`], [`fixed`] and [`signed`].
//!
//! All counts and statistics are computed here, over all contacts; the page draws them, and shows
//! SI units as millimetres and degrees. Single contacts are thinned to at most [`MOST_DRAWN`], so
//! the page of a million contacts is as small as that of three thousand. The same calibration gives
//! the same bytes.
//!
//! The data are JSON in a script element of type `application/json`, in which `<` is written
//! `\u003c`: no name that was read from a file can end the element. The page puts names into text
//! nodes only, and its `Content-Security-Policy` lets it load nothing.

mod contacts;
mod content;
mod declaration_tests;
mod declarations;
mod evaluation;
mod number_text;
mod page;
mod parameters;
mod relative;
mod scene;
mod settings;
mod warning_text;

pub use contacts::MOST_DRAWN;
pub use content::{Input, Report};
pub use declaration_tests::DeclarationTests;
pub use evaluation::{EvaluationReport, ToolError};
pub use number_text::{fixed, signed};
#[cfg(feature = "mcap")]
pub(crate) use scene::{places, positions};
pub use warning_text::WarningText;

//! What all readers and writers share: bytes with a bound, whole files, errors with their place.

pub mod atomic;
#[cfg(feature = "parquet")]
pub(super) mod bounded_pages;
pub(super) mod bytes;
pub(crate) mod csv;
pub(super) mod error;
pub(super) mod manifest;
#[cfg(feature = "parquet")]
pub(super) mod number_columns;
pub(super) mod paths;
pub mod result_folder;
pub(super) mod suggest;
pub(super) mod toml_text;
pub(super) mod tool_pose;
pub(crate) mod xml;

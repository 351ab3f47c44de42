//! Contact logs: which formats there are, and what is the same for all of them.
//!
//! A row is one moment: joint positions, and if there are any a wrench or a contact flag.
//!
//! | format | module | known by |
//! |---|---|---|
//! | comma-separated values, plain or gzipped | [`contact_csv`](crate::io::contact_csv) | what is none of the others |
//! | ROS 2 bag, MCAP (cargo feature `mcap`) | `mcap` | its first five bytes |
//! | Parquet (cargo feature `parquet`) | `parquet` | its first four bytes |
//! | columns in memory | [`Columns`] | |
//!
//! Contacts are the rows that a force threshold detects, if one is given; else those flagged, if
//! there are flags; else all.

mod columns;
pub(super) mod joints;
mod kuka;
pub(super) mod layout;
#[cfg(feature = "mcap")]
mod mcap;
mod numbers;
pub(super) mod options;
#[cfg(feature = "parquet")]
mod parquet;
mod reader;
pub(super) mod rows;
mod table;

pub use columns::{Columns, read_columns};
pub use options::{Options, TargetColumns};
pub use reader::{read_file, read_new};
pub use table::LogTable;

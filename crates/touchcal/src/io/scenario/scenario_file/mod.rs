//! `scenario.toml`: what to simulate. Every key overrides that of a preset; lengths are millimetres
//! and angles degrees, as the keys say.
//!
//! `[robot]` and `[tool]` are those of `problem.toml`; so is a `[[fixture]]`, with the joint
//! positions from which it is explored in addition, and a `[[distance]]`, without its length, which
//! is that of the simulated fixtures. Every unknown key, every name that does not resolve and every
//! number out of range is an error with line and column.

mod declared;
mod posed;
mod read;
mod schema;
mod vary;
mod write;

pub use posed::{
    PROBLEM, TRUE_URDF, TRUTH, check_folder, log_texts, problem_text, settings_text, truth_text, write_folder,
};
pub use read::{MAX_BYTES, ScenarioFile, preset, read, read_file};
pub use vary::varied_text;
pub use write::{SCENARIO, TextFile, scenario_text};

/// JSON Schema (draft 2020-12) of a scenario file, for editors.
pub const JSON_SCHEMA: &str = include_str!("../scenario.schema.json");

#![allow(clippy::print_stdout, reason = "a build script speaks to cargo on stdout")]
//! Sets `TOUCHCAL_VERSION`, and arguments for the linker of macOS, which refuses a library with
//! undefined symbols: Python has them.

#[path = "../crates/touchcal-cli/version.rs"]
mod version;

use std::path::Path;

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rerun-if-changed=../crates/touchcal-cli/version.rs");
    version::set(&Path::new(env!("CARGO_MANIFEST_DIR")).join(".."));
    pyo3_build_config::add_extension_module_link_args();
}

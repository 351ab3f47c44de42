#![allow(clippy::print_stdout, reason = "a build script speaks to cargo on stdout")]
//! Sets `TOUCHCAL_VERSION`.

mod version;

use std::path::Path;

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rerun-if-changed=version.rs");
    version::set(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../.."));
}

//! Arguments for the linker of macOS, which refuses a library with undefined symbols: Python has
//! them.

fn main() {
    pyo3_build_config::add_extension_module_link_args();
}

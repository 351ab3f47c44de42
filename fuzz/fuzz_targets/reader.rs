//! The reader that `TOUCHCAL_READER` names, for cargo-fuzz: `scripts/fuzz SECONDS [READER…]`.
#![no_main]

#[path = "../../crates/touchcal/tests/hostile/readers.rs"]
mod readers;

use std::path::PathBuf;
use std::sync::LazyLock;

use libfuzzer_sys::fuzz_target;
use readers::{READERS, Reader};

/// The reader, and the file that it reads.
static TARGET: LazyLock<(Reader, PathBuf)> = LazyLock::new(|| {
    let name = std::env::var("TOUCHCAL_READER").unwrap_or_default();
    let known: Vec<&str> = READERS.iter().map(|(known, _)| *known).collect();
    let (_, reader) = READERS.iter().find(|(known, _)| *known == name).unwrap_or_else(|| panic!("TOUCHCAL_READER: one of {known:?}"));
    // Panics of other crates that the library catches are no finding; one that comes through is,
    // whatever the hook.
    std::panic::set_hook(Box::new(|_| {}));
    let folder = tempfile::tempdir().expect("a temporary folder").keep();
    (*reader, folder.join("hostile"))
});

fuzz_target!(|bytes: &[u8]| {
    let (reader, path) = &*TARGET;
    std::fs::write(path, bytes).expect("a temporary file");
    let answer = reader(path);
    drop(answer);
});

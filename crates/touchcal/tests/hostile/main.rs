//! Readers against hostile files: the corpora in `fuzz/corpus`, and mutations of them drawn from a
//! seed. No reader panics, hangs, or takes memory that the file does not. `fuzz/` has the same
//! readers for cargo-fuzz, which looks for longer and finds its way.
#![cfg(all(feature = "mcap", feature = "parquet"))]
// Helpers of tests fail by panicking too; the exception in clippy.toml covers only the tests
// themselves.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod mutate;
mod readers;

use std::path::Path;
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::time::Duration;

use rand::SeedableRng;
use rand_pcg::Pcg64;

use readers::{READERS, Reader};

/// Where corpora are, from this crate.
const CORPUS: &str = "../../fuzz/corpus";
/// Number of mutations of a reader's corpus.
const MUTATIONS: u64 = 300;
/// Longest time for a file of some kB.
const PATIENCE: Duration = Duration::from_secs(20);
/// Most memory of all (MB), of which MCAP's largest record and zstd's largest window are 240.
const MOST_MEGABYTES: u64 = 600;

#[test]
fn readers_answer_whatever_they_are_given() {
    for (name, read) in READERS {
        let (told, heard) = channel();
        let trying = std::thread::spawn(move || attack(name, *read, &told));
        let mut now = "no file".to_owned();
        loop {
            match heard.recv_timeout(PATIENCE) {
                Ok(next) => now = next,
                Err(RecvTimeoutError::Disconnected) => break,
                Err(RecvTimeoutError::Timeout) => panic!("{name}: {now} took more than {PATIENCE:?}"),
            }
        }
        let Ok((refused, tried)) = trying.join() else { panic!("{name}: {now} made it panic") };
        println!("{name}: {tried} files, {refused} refused");
        assert!(peak_megabytes() < MOST_MEGABYTES, "{name}: {} MB", peak_megabytes());
    }
}

/// Reads the corpus and mutations of it; says before each which it is. How many were refused, of
/// how many.
fn attack(name: &str, read: Reader, told: &Sender<String>) -> (u64, u64) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("hostile");
    let files = files(name);
    let mut refused = 0;
    let mut tried = 0;
    let mut answer = |bytes: &[u8], what: String| {
        told.send(what).unwrap();
        std::fs::write(&path, bytes).unwrap();
        tried += 1;
        refused += u64::from(read(&path).is_err());
    };
    for (file, bytes) in &files {
        answer(bytes, file.clone());
    }
    for seed in 0..MUTATIONS {
        answer(&mutate::mutated(&files, &mut Pcg64::seed_from_u64(seed)), format!("mutation {seed}"));
    }
    (refused, tried)
}

/// The files of a corpus, in the order of their names.
fn files(name: &str) -> Vec<(String, Vec<u8>)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join(CORPUS).join(name);
    let mut files: Vec<_> = std::fs::read_dir(&folder)
        .unwrap_or_else(|error| panic!("{}: {error}", folder.display()))
        .map(|entry| entry.unwrap().path())
        .map(|path| (path.display().to_string(), std::fs::read(&path).unwrap()))
        .collect();
    assert!(!files.is_empty(), "no files in {}", folder.display());
    files.sort();
    files
}

/// Of each corpus, one file at least is good: mutations of what is refused at its first byte say
/// nothing.
#[test]
fn corpora_have_good_files_and_broken_ones() {
    for (name, read) in READERS {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("file");
        let answers: Vec<(String, bool)> = files(name)
            .into_iter()
            .map(|(file, bytes)| {
                std::fs::write(&path, bytes).unwrap();
                (file, read(&path).is_ok())
            })
            .collect();
        for (file, good) in &answers {
            let stem = Path::new(file).file_stem().unwrap_or_default().to_string_lossy().into_owned();
            assert_eq!(
                stem.starts_with("good"),
                *good,
                "{file}: {:?}",
                read(&path).err().map(|error| error.to_string())
            );
        }
        assert!(answers.iter().any(|(_, good)| *good) && answers.iter().any(|(_, good)| !good), "{name}");
    }
}

/// Most memory that this process had (MB), where the system says so.
fn peak_megabytes() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    line.and_then(|line| line.trim().trim_end_matches(" kB").parse::<u64>().ok()).unwrap_or(0) / 1024
}

//! Threads of computations, also in a process that was forked.

use std::process;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use pyo3::Python;
use pyo3::marker::Ungil;
use rayon::{ThreadPool, ThreadPoolBuilder};

/// The process in which the package was imported.
static IMPORTED_IN: OnceLock<u32> = OnceLock::new();
/// The threads of a process that was forked from it.
static FORKED: Mutex<Option<(u32, Arc<ThreadPool>)>> = Mutex::new(None);

/// Notes the process in which the package is imported.
pub fn imported() {
    IMPORTED_IN.get_or_init(process::id);
}

/// Runs `work` without the interpreter's lock. A process that was forked has no threads but one,
/// and would wait for those of the process before for ever: it gets its own.
pub fn detached<T: Ungil + Send>(py: Python<'_>, work: impl FnOnce() -> T + Ungil + Send) -> T {
    py.detach(|| match own_threads() {
        Some(threads) => threads.install(work),
        None => work(),
    })
}

/// The threads of this process, if it was forked.
fn own_threads() -> Option<Arc<ThreadPool>> {
    let this = process::id();
    if IMPORTED_IN.get().is_none_or(|first| *first == this) {
        return None;
    }
    let mut forked = FORKED.lock().unwrap_or_else(PoisonError::into_inner);
    match forked.as_ref().filter(|(process, _)| *process == this) {
        Some((_, threads)) => Some(threads.clone()),
        None => {
            let threads = Arc::new(ThreadPoolBuilder::new().build().ok()?);
            if let Some(before) = forked.replace((this, threads.clone())) {
                // Its threads are those of another process: there is nobody to end.
                std::mem::forget(before);
            }
            Some(threads)
        }
    }
}

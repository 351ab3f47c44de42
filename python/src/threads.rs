//! Threads of computations, also in a process that was forked.

use std::panic::resume_unwind;
use std::process;
use std::sync::mpsc::{self, RecvTimeoutError};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::time::Duration;

use pyo3::Python;
use pyo3::marker::Ungil;
use rayon::{ThreadPool, ThreadPoolBuilder};

/// The process in which the package was imported.
static IMPORTED_IN: OnceLock<u32> = OnceLock::new();
/// The threads of a process that was forked from it.
static FORKED: Mutex<Option<(u32, Arc<ThreadPool>)>> = Mutex::new(None);

/// Longest wait for a report before signals are looked at.
const PAUSE: Duration = Duration::from_millis(100);

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

/// As [`detached`], on another thread: `receive` has what `work` reports, and `None` in pauses of
/// [`PAUSE`], on the calling thread, which alone can handle signals.
pub fn detached_with_reports<T: Ungil + Send, M: Send>(
    py: Python<'_>,
    work: impl FnOnce(&(dyn Fn(M) + Sync)) -> T + Ungil + Send,
    mut receive: impl FnMut(Option<M>) + Ungil + Send,
) -> T {
    py.detach(|| {
        std::thread::scope(|scope| {
            let (sender, reports) = mpsc::channel();
            // Nobody reads the reports of a process that ends.
            let report = move |message| drop(sender.send(message));
            let worker = scope.spawn(move || match own_threads() {
                Some(threads) => threads.install(|| work(&report)),
                None => work(&report),
            });
            loop {
                match reports.recv_timeout(PAUSE) {
                    Ok(report) => receive(Some(report)),
                    Err(RecvTimeoutError::Timeout) => receive(None),
                    Err(RecvTimeoutError::Disconnected) => break,
                }
            }
            worker.join().unwrap_or_else(|panic| resume_unwind(panic))
        })
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

//! Progress on a terminal, and interruption.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, LazyLock, Mutex};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;
use touchcal::estimate::{Progress, Stage};

use crate::output::diagnostic;

/// Work shorter than this shows no progress.
const DELAY: Duration = Duration::from_secs(1);
/// Time between lines of progress where stderr is no terminal.
const INTERVAL: Duration = Duration::from_secs(10);
/// Exit code of a process that was interrupted.
const INTERRUPTED: i32 = 130;

static INTERRUPT: LazyLock<Arc<AtomicBool>> = LazyLock::new(Arc::default);
static ENDS_AT_ONCE: LazyLock<Arc<AtomicBool>> = LazyLock::new(|| Arc::new(AtomicBool::new(true)));

/// Makes Ctrl-C and SIGTERM end the process with the exit code of an interrupt: at once, or after
/// [`defer_interrupts`] at the next step of the work, where a second one still ends the process at
/// once. SIGHUP is left as it is: `nohup` ignores it.
pub fn catch_interrupts() {
    for signal in [SIGINT, SIGTERM] {
        let caught = flag::register_conditional_shutdown(signal, INTERRUPTED, Arc::clone(&ENDS_AT_ONCE))
            .and_then(|_| flag::register_conditional_shutdown(signal, INTERRUPTED, Arc::clone(&INTERRUPT)))
            .and_then(|_| flag::register(signal, Arc::clone(&INTERRUPT)));
        // Without a handler the signal ends the process as ever; files are still written whole or
        // not at all.
        drop(caught);
    }
}

/// Begins work that asks at each step whether it was [`interrupted`], or that writes files: from
/// now on an interrupt does not end the process at once.
pub fn defer_interrupts() {
    ENDS_AT_ONCE.store(false, Ordering::SeqCst);
}

/// Whether the user interrupted the program.
pub fn interrupted() -> bool {
    INTERRUPT.load(Ordering::SeqCst)
}

/// Progress where stderr is no terminal that bars are drawn on: a line every ten seconds.
struct PlainLines {
    label: &'static str,
    since: Instant,
    /// When the next line is due; `None` once the work has ended.
    due: Mutex<Option<Instant>>,
}

impl PlainLines {
    fn new(label: &'static str) -> Self {
        PlainLines { label, since: Instant::now(), due: Mutex::new(Some(Instant::now() + INTERVAL)) }
    }

    /// A line with `message`, given the seconds (> 0) since the start, if one is due and `bar` is
    /// not drawn.
    fn show(&self, bar: &ProgressBar, message: impl FnOnce(f64) -> String) {
        let Ok(mut due) = self.due.lock() else { return };
        if !bar.is_hidden() || due.is_none_or(|due| Instant::now() < due) {
            return;
        }
        *due = Some(Instant::now() + INTERVAL);
        let seconds = self.since.elapsed().as_secs_f64();
        diagnostic(&format!("{}, {seconds:.0} s: {}", self.label, message(seconds)));
    }

    /// No line follows.
    fn end(&self) {
        if let Ok(mut due) = self.due.lock() {
            *due = None;
        }
    }
}

/// A line on stderr that shows progress; a line every ten seconds where stderr is no terminal.
pub struct Spinner {
    bar: ProgressBar,
    plain: Arc<PlainLines>,
}

impl Spinner {
    /// A line that begins with `label`.
    pub fn new(label: &'static str) -> Self {
        let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::hidden());
        if let Ok(style) = ProgressStyle::with_template("{spinner} {prefix} {elapsed} {msg}") {
            bar.set_style(style);
        }
        bar.set_prefix(label);
        Spinner { bar, plain: Arc::new(PlainLines::new(label)) }
    }

    /// Shows a step of an estimation; breaks it off after an interrupt.
    pub fn observe(&self, progress: &Progress) -> ControlFlow<()> {
        let stage = match progress.stage {
            Stage::Coarse => "coarse",
            Stage::Fine => "fine",
            Stage::Descent => "descent",
        };
        self.show(|| format!("{stage} step {}, cost {:.4e}", progress.iteration, progress.cost));
        if interrupted() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    /// Shows elapsed time, for work without progress, once that takes longer than [`DELAY`].
    pub fn run(&self) {
        self.bar.enable_steady_tick(DELAY / 5);
        let (bar, plain) = (self.bar.clone(), Arc::clone(&self.plain));
        std::thread::spawn(move || {
            std::thread::sleep(DELAY);
            if !bar.is_finished() {
                bar.set_draw_target(ProgressDrawTarget::stderr());
            }
            while !bar.is_finished() {
                plain.show(&bar, |_| "not done yet".to_owned());
                std::thread::sleep(DELAY);
            }
        });
    }

    /// Shows a message, once the work takes longer than [`DELAY`].
    pub fn show(&self, message: impl FnOnce() -> String) {
        if self.plain.since.elapsed() >= DELAY {
            if self.bar.is_hidden() {
                self.bar.set_draw_target(ProgressDrawTarget::stderr());
            }
            let message = message();
            self.plain.show(&self.bar, |_| message.clone());
            self.bar.set_message(message);
            self.bar.tick();
        }
    }
}

impl Drop for Spinner {
    fn drop(&mut self) {
        self.plain.end();
        self.bar.finish_and_clear();
    }
}

/// A bar on stderr with count and remaining time; a line every ten seconds where stderr is no
/// terminal.
pub struct Counter {
    bar: ProgressBar,
    plain: PlainLines,
    /// Number of items that were done before.
    before: AtomicU64,
    count: u64,
}

impl Counter {
    /// A bar of `count` items that begins with `label`, at `done`.
    pub fn new(label: &'static str, done: u64, count: u64) -> Self {
        let bar = ProgressBar::with_draw_target(Some(count), ProgressDrawTarget::stderr());
        if let Ok(style) =
            ProgressStyle::with_template("{spinner} {prefix} {pos}/{len} {bar:30} {elapsed}, {eta} left{msg}")
        {
            bar.set_style(style);
        }
        bar.set_prefix(label);
        bar.set_position(done);
        bar.reset_eta();
        Counter { bar, plain: PlainLines::new(label), before: AtomicU64::new(done), count }
    }

    /// Sets the number of items done.
    pub fn set(&self, done: u64) {
        self.bar.set_position(done);
        self.show();
    }

    fn show(&self) {
        self.plain.show(&self.bar, |seconds| {
            let (done, count) = (self.bar.position(), self.count);
            let own = done.saturating_sub(self.before.load(Ordering::Relaxed));
            let left = seconds * count.saturating_sub(done) as f64 / own as f64;
            if left.is_finite() { format!("{done} of {count}, {left:.0} s left") } else { format!("{done} of {count}") }
        });
    }

    /// Sets the text after the bar.
    pub fn message(&self, message: String) {
        self.bar.set_message(message);
    }

    /// Adds items that were done before.
    #[cfg(feature = "parquet")]
    pub fn skip(&self, count: u64) {
        self.before.fetch_add(count, Ordering::Relaxed);
        self.bar.inc(count);
    }

    /// Adds to the number of items done.
    pub fn advance(&self, count: u64) {
        self.bar.inc(count);
        self.show();
    }
}

impl Drop for Counter {
    fn drop(&mut self) {
        self.plain.end();
        self.bar.finish_and_clear();
    }
}

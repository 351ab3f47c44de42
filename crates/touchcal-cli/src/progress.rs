//! What a waiting user sees, and the way out.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use touchcal::estimate::{Progress, Stage};

/// Work shorter than this shows nothing.
const PATIENCE: Duration = Duration::from_secs(1);
/// Exit code of a process that SIGINT ended.
const INTERRUPTED: i32 = 130;

static INTERRUPT: AtomicBool = AtomicBool::new(false);

/// Makes Ctrl-C end the work at its next step; a second one ends the process at once.
pub fn catch_interrupts() {
    let caught = ctrlc::set_handler(|| {
        if INTERRUPT.swap(true, Ordering::SeqCst) {
            std::process::exit(INTERRUPTED);
        }
    });
    // Without a handler Ctrl-C ends the process as ever; files are still written whole or not at
    // all.
    drop(caught);
}

/// Whether the user asked to stop.
pub fn interrupted() -> bool {
    INTERRUPT.load(Ordering::SeqCst)
}

/// A line on a terminal's stderr that says how far the work is; nothing where stderr is no
/// terminal.
pub struct Spinner {
    bar: ProgressBar,
    since: Instant,
}

impl Spinner {
    /// A line that begins with `what`.
    pub fn new(what: &'static str) -> Self {
        let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::hidden());
        if let Ok(style) = ProgressStyle::with_template("{spinner} {prefix} {elapsed} {msg}") {
            bar.set_style(style);
        }
        bar.set_prefix(what);
        Spinner { bar, since: Instant::now() }
    }

    /// Shows where an estimation stands; breaks it off when the user asked to.
    pub fn observe(&self, progress: &Progress) -> ControlFlow<()> {
        let stage = match progress.stage {
            Stage::Coarse => "coarse",
            Stage::Fine => "fine",
            Stage::Descent => "descent",
        };
        self.tell(|| format!("{stage} step {}, residual (cost) {:.4e}", progress.iteration, progress.cost));
        if interrupted() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    /// Shows the time running, for work that does not report.
    pub fn run(&self) {
        self.bar.set_draw_target(ProgressDrawTarget::stderr());
        self.bar.enable_steady_tick(PATIENCE / 5);
    }

    /// Shows how far the work is, once it takes long.
    pub fn tell(&self, message: impl FnOnce() -> String) {
        if self.since.elapsed() >= PATIENCE {
            if self.bar.is_hidden() {
                self.bar.set_draw_target(ProgressDrawTarget::stderr());
            }
            self.bar.set_message(message());
            self.bar.tick();
        }
    }
}

impl Drop for Spinner {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

/// A bar on a terminal's stderr that counts things done, and says how long the rest takes; nothing
/// where stderr is no terminal.
pub struct Counter {
    bar: ProgressBar,
}

impl Counter {
    /// A bar of `count` things that begins with `what`, `done` of which are done.
    pub fn new(what: &'static str, done: u64, count: u64) -> Self {
        let bar = ProgressBar::with_draw_target(Some(count), ProgressDrawTarget::stderr());
        if let Ok(style) =
            ProgressStyle::with_template("{spinner} {prefix} {pos}/{len} {bar:30} {elapsed}, left {eta}{msg}")
        {
            bar.set_style(style);
        }
        bar.set_prefix(what);
        bar.set_position(done);
        bar.reset_eta();
        Counter { bar }
    }

    /// So many things are done.
    pub fn show(&self, done: u64) {
        self.bar.set_position(done);
    }

    /// What else to say from now on.
    pub fn say(&self, message: String) {
        self.bar.set_message(message);
    }

    /// So many more are done.
    pub fn more(&self, count: u64) {
        self.bar.inc(count);
    }
}

impl Drop for Counter {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

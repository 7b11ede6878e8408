//! A progress bar with the time left, on standard error when that is a terminal.

use indicatif::{ProgressBar, ProgressStyle};

/// Steps of a bar.
const STEPS: u64 = 1000;

/// A bar that takes fractions.
#[derive(Debug)]
pub struct Progress(ProgressBar);

impl Progress {
    /// A bar that says what is being done.
    pub fn new(what: impl Into<String>) -> Self {
        let style = ProgressStyle::with_template("{msg} {bar:30} {percent:>3} %, {elapsed} passed, {eta} left");
        let bar = ProgressBar::new(STEPS).with_message(what.into());
        Self(bar.with_style(style.expect("the template is a constant")))
    }

    /// Moves to a fraction done in [0, 1]; never back, so that several threads may tell theirs.
    pub fn set(&self, fraction: f64) {
        let position = (fraction.clamp(0.0, 1.0) * STEPS as f64) as u64;
        if position > self.0.position() {
            self.0.set_position(position);
        }
    }

    /// Changes what is being done.
    pub fn name(&self, what: impl Into<String>) {
        self.0.set_message(what.into());
    }

    /// A line on standard error that stays.
    pub fn say(&self, line: &str) {
        self.0.suspend(|| eprintln!("{line}"));
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}

/// Does a piece of work that tells its progress with a bar.
pub fn with_progress<T>(what: &str, work: impl FnOnce(&(dyn Fn(f64) + Sync)) -> T) -> T {
    let bar = Progress::new(what);
    work(&|fraction| bar.set(fraction))
}

//! A progress bar with the time left, on standard error when that is a terminal.

use indicatif::{ProgressBar, ProgressStyle};

/// Steps of a bar.
const STEPS: u64 = 1000;

/// A bar that takes fractions.
pub struct Progress(ProgressBar);

impl Progress {
    /// A bar that says what is being done.
    pub fn new(what: impl Into<String>) -> Self {
        let style = ProgressStyle::with_template("{msg} {bar:30} {percent:>3} %, {eta} left");
        let bar = ProgressBar::new(STEPS).with_message(what.into());
        Self(bar.with_style(style.expect("the template is a constant")))
    }

    /// Moves to a fraction done in [0, 1].
    pub fn set(&self, fraction: f64) {
        self.0.set_position((fraction.clamp(0.0, 1.0) * STEPS as f64) as u64);
    }

    /// Changes what is being done.
    pub fn name(&self, what: String) {
        self.0.set_message(what);
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}

//! How far a walk is: a bar for people, lines for a farm.

use kit::Progress;
use std::cell::RefCell;
use std::io::Write;

/// How progress is told.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum Told {
    /// A bar on standard error, where that is a terminal.
    #[default]
    Bar,
    /// Lines on standard output as Open Job Description reads them: `openjd_progress: 12.5`, `openjd_status: …`.
    Openjd,
}

/// Tells how far a piece of work is.
pub(super) struct Meter {
    bar: Progress,
    told: Told,
    /// What was said last.
    said: RefCell<String>,
}

impl Meter {
    /// Of work of this name.
    pub fn new(what: &str, told: Told) -> Self {
        Self { bar: Progress::new(what), told, said: RefCell::default() }
    }

    /// Tells what is being done, and the share of the work that is done.
    pub fn at(&self, fraction: f64, what: String) {
        self.bar.name(what.clone());
        self.bar.set(fraction);
        if self.told == Told::Openjd && *self.said.borrow() != what {
            let mut out = std::io::stdout().lock();
            // Whoever reads them may have gone: the work goes on.
            let _ = writeln!(out, "openjd_progress: {:.1}\nopenjd_status: {what}", 100.0 * fraction);
            let _ = out.flush();
            *self.said.borrow_mut() = what;
        }
    }

    /// The bar, for the progress of a frame.
    pub fn bar(&self) -> &Progress {
        &self.bar
    }
}

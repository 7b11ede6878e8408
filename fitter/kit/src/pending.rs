//! Temporary files that are being written: a signal that ends the process removes them.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

static PENDING: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// A temporary file, for as long as the value lives.
#[derive(Debug)]
pub struct Pending(PathBuf);

impl Pending {
    /// Notes a file.
    pub fn new(path: &Path) -> Self {
        PENDING.lock().unwrap_or_else(PoisonError::into_inner).push(path.into());
        Self(path.into())
    }
}

impl Drop for Pending {
    fn drop(&mut self) {
        PENDING.lock().unwrap_or_else(PoisonError::into_inner).retain(|p| *p != self.0);
    }
}

/// What the first signal does in place of ending the process.
#[cfg(feature = "command")]
type Stop = Box<dyn FnOnce() + Send>;

#[cfg(feature = "command")]
static STOP: Mutex<Option<Stop>> = Mutex::new(None);

/// Has the next signal that would end the process call `stop`, which is to bring it to its end; one more ends it at once. Needs
/// [`watch`].
#[cfg(feature = "command")]
pub fn stop_with(stop: impl FnOnce() + Send + 'static) {
    *STOP.lock().unwrap_or_else(PoisonError::into_inner) = Some(Box::new(stop));
}

/// Sets the process up to be ended: what Ctrl-C and the like interrupt leaves no temporary file, and a file that grows
/// beyond what the shell's `ulimit -f` allows is an error of that file instead of the end of the process.
#[cfg(all(unix, feature = "command"))]
pub fn watch() {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM, SIGXFSZ};
    use signal_hook::{flag, iterator::Signals, low_level::emulate_default_handler};
    // Where a handler cannot be set, the default remains.
    let _ = flag::register(SIGXFSZ, Default::default());
    let heeded = [SIGINT, SIGTERM, SIGHUP].into_iter().filter(|s| !ignored(*s));
    let Ok(mut signals) = Signals::new(heeded) else { return };
    std::thread::spawn(move || {
        for signal in signals.forever() {
            let stop = STOP.lock().unwrap_or_else(PoisonError::into_inner).take();
            if let Some(stop) = stop {
                stop();
                continue;
            }
            // Held until the process is gone: no new file appears.
            let pending = PENDING.lock().unwrap_or_else(PoisonError::into_inner);
            for path in pending.iter() {
                let _ = std::fs::remove_file(path);
            }
            let _ = emulate_default_handler(signal);
        }
    });
}

/// Nothing to set up.
#[cfg(all(not(unix), feature = "command"))]
pub fn watch() {}

/// Whether whoever started the process has it ignore a signal (`nohup`, jobs in the background of a script).
#[cfg(all(unix, feature = "command"))]
fn ignored(signal: i32) -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    mask.is_some_and(|mask| mask >> (signal - 1) & 1 == 1)
}

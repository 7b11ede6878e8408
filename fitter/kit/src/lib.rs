//! What the commands of this workspace share, and nothing of what they compute: files that are written whole, numbers and
//! words for people; with the feature `command` usage, errors in one line and signals, with `figure` drawing in SVG, with
//! `progress` a bar.

#[cfg(feature = "figure")]
pub mod figure;
pub mod number;
pub mod output;
mod pending;
#[cfg(feature = "progress")]
mod progress;
#[cfg(feature = "command")]
mod report;
pub mod text;
#[cfg(feature = "command")]
mod usage;

pub use pending::Pending;
#[cfg(feature = "command")]
pub use pending::{stop_with, watch};
#[cfg(feature = "progress")]
pub use progress::{Progress, with_progress};
#[cfg(feature = "command")]
pub use report::one_line;
#[cfg(feature = "command")]
pub use usage::parse;

//! Walks: many frames of one scene through a camera that moves.
//!
//! First the caches are filled for all frames of the path, in an order that depends on the path and the settings alone; then frames
//! are drawn from them and add nothing. A frame depends on scene, path, settings and caches, not on the machine, its threads, or
//! the frames that are drawn beside it.

mod fill;
mod frames;
mod names;
mod path;
#[cfg(feature = "formats")]
mod table;
mod trial;

pub use fill::{Fill, Filled};
pub use frames::Source;
pub use names::{FrameFiles, FrameNumbers, LAST_FRAME, MAX_FRAMES};
pub use path::{Row, Walk};
#[cfg(feature = "formats")]
pub use table::{read_rows, write_rows};
pub use trial::{Denoising, Trial, choose_samples};

//! Walks: many frames of one scene through a camera that moves.

mod names;

pub use names::{FrameFiles, FrameNumbers, LAST_FRAME, MAX_FRAMES};

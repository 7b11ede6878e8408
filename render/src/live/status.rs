//! What a page is told of a frame.

use super::command::Shown;
use crate::integrator::cached::{Caches, Interpolation};
use serde::Serialize;

/// What is being done.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Stage {
    /// Getting a method ready: tables are looked up, or fitted.
    Preparing,
    /// Drawing while the camera moves.
    Moving,
    /// Making the records that the camera needs.
    Filling,
    /// Adding samples.
    Refining,
    /// The picture is there.
    Settled,
}

/// Figures of a frame, and the settings that it was drawn with.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Status {
    /// What is being done.
    pub stage: Stage,
    /// Frames in the last second; 0 where there are not two.
    pub fps: f64,
    /// Pixels of the frame.
    pub size: [u32; 2],
    /// Samples of a pixel, and of the picture when it is there.
    pub spp: [u32; 2],
    /// Share of the fill that is done.
    pub filled: f64,
    /// Records of the method, and their bytes.
    pub records: usize,
    /// Memory of the records.
    pub bytes: usize,
    /// Name of the method.
    pub method: String,
    /// Who sums the records of a pixel.
    pub interpolation: Interpolation,
    /// τ.
    pub tau: f32,
    /// Stops.
    pub stops: f32,
    /// How the screen shows light.
    pub view: Shown,
    /// Whether frames are denoised.
    pub denoise: bool,
    /// Whether dots and circles of records are drawn.
    pub marks: [bool; 2],
    /// Rows of the walk that is being recorded.
    pub recording: Option<usize>,
    /// What is in the way, for people.
    pub message: Option<String>,
}

impl Status {
    /// Counts records.
    pub(super) fn count(&mut self, caches: Option<&Caches>) {
        (self.records, self.bytes) = caches.map_or((0, 0), |caches| (caches.records(), caches.bytes()));
    }
}

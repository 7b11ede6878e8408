//! Which pixels read records, how far these are trusted, and how much is traced where they are not.

/// Which pixels of a picture read records.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Reading {
    /// All.
    #[default]
    Every,
    /// Few, where what they reflect is smooth: it is interpolated between them.
    Few,
    /// Fewer, for pictures that are shown for a moment.
    Rough,
}

impl Reading {
    /// Largest share of the light of a surface that is left to records which do not hold it finely, in place of a path.
    pub(super) fn untraced(self) -> f32 {
        if self == Self::Rough { 0.75 } else { 0.0 }
    }
}

/// How many paths a surface gets whose light is not all in records.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Paths {
    /// Where records are doubted altogether.
    pub doubted: f32,
    /// Where light is cached for the neighbours only.
    pub least: f32,
    /// However many samples of the pixel show the surface.
    pub most: f32,
}

impl Paths {
    /// The neighbours have no noise, so it must not have much.
    pub const SMOOTH: Self = Self { doubted: 64.0, least: 8.0, most: f32::INFINITY };
    /// A denoiser takes the noise away: in a staircase of rough plastics, a third of the time for less error.
    pub const DENOISED: Self = Self { doubted: 4.0, least: 2.0, most: f32::INFINITY };
    /// The next picture comes soon.
    pub const HASTY: Self = Self { doubted: 1.0, least: 1.0, most: 1.0 };
}

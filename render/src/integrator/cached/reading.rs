//! Which pixels read records, and how far these are trusted.

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

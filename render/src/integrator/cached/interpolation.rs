//! Who sums the records of a pixel.

use super::reading::Reading;

/// Who sums the records of a pixel. The pictures are the same to the last bit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Interpolation {
    /// Whoever is faster.
    #[default]
    Auto,
    /// Pixels look for records, in an octree.
    Octree,
    /// Records are drawn onto the tiles of pixels that they reach (Gautron et al. 2005).
    Splat,
}

impl Interpolation {
    /// Whether records are drawn. Where few pixels read them, tiles have little to share.
    pub(super) fn splats(self, reading: Reading) -> bool {
        match self {
            Self::Auto => reading == Reading::Every,
            Self::Octree => false,
            Self::Splat => true,
        }
    }
}

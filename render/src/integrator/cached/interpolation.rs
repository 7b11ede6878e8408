//! Who sums the records of a pixel.

use super::caches::Caches;
use super::kinds::Listed;
use super::splat::{Splats, Tile};
use crate::cache::{Drawn, Lookup};
use crate::record::irradiance::IrradianceRecord;

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
    /// Whether records are drawn.
    pub(super) fn splats(self) -> bool {
        match self {
            Self::Splat => true,
            Self::Auto | Self::Octree => false,
        }
    }
}

/// Where records about a surface are found.
pub(super) trait Records {
    /// Those of irradiance on diffuse surfaces.
    fn irradiance(&self) -> impl Lookup<IrradianceRecord>;
    /// Those of a kind.
    fn glossy<K: Listed>(&self) -> impl Lookup<K::Record>;
}

impl Records for Caches {
    #[inline(always)]
    fn irradiance(&self) -> impl Lookup<IrradianceRecord> {
        &self.irradiance
    }

    #[inline(always)]
    fn glossy<K: Listed>(&self) -> impl Lookup<K::Record> {
        K::cache(&self.glossy)
    }
}

/// Records that are drawn onto a tile.
pub(super) struct OnTile<'a> {
    pub splats: &'a Splats<'a>,
    pub tile: &'a Tile,
}

impl Records for OnTile<'_> {
    #[inline(always)]
    fn irradiance(&self) -> impl Lookup<IrradianceRecord> {
        Drawn { cache: &self.splats.caches.irradiance, near: &self.tile.irradiance }
    }

    #[inline(always)]
    fn glossy<K: Listed>(&self) -> impl Lookup<K::Record> {
        Drawn { cache: K::cache(&self.splats.caches.glossy), near: K::part(&self.tile.glossy) }
    }
}

//! Who sums the records of a pixel.

use super::caches::Caches;
use super::kinds::{self, EachKind, Listed};
use super::reading::Reading;
use core::convert::Infallible;
use serde::{Deserialize, Serialize};

/// Who sums the records of a pixel. The pictures of the processor are the same to the last bit, those of the card to 10⁻⁴ of their
/// mean.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Interpolation {
    /// Whoever is faster.
    #[default]
    Auto,
    /// Pixels look for records, in an octree.
    Octree,
    /// Records are drawn onto the tiles of pixels that they reach (Gautron et al. 2005).
    Splat,
    /// Records are drawn onto tiles, and summed on the graphics card ([`crate::gpu::shared`]).
    #[cfg(feature = "gpu")]
    Gpu,
}

impl Interpolation {
    /// Those that this build and this machine have. Looks for a graphics card.
    pub fn available() -> Vec<Self> {
        let all = [Self::Auto, Self::Octree, Self::Splat].into_iter();
        #[cfg(feature = "gpu")]
        let all = all.chain(crate::gpu::shared().is_ok().then_some(Self::Gpu));
        all.collect()
    }

    /// Whether the graphics card sums.
    pub(super) fn is_on_card(self) -> bool {
        #[cfg(feature = "gpu")]
        let on_card = self == Self::Gpu;
        #[cfg(not(feature = "gpu"))]
        let on_card = false;
        on_card
    }

    /// Whether records are drawn. It pays for those that surfaces read together, where all pixels read them: to find records is too
    /// small a part of the time to matter (`doc/measurements.md`, splatting).
    pub(super) fn splats(self, caches: &Caches, reading: Reading) -> bool {
        let mut together = Together { caches, any: false };
        let Ok(()) = kinds::each(&mut together);
        match self {
            Self::Auto => reading == Reading::Every && together.any,
            Self::Octree => false,
            Self::Splat => true,
            #[cfg(feature = "gpu")]
            Self::Gpu => true,
        }
    }
}

/// Whether there are records that surfaces read together.
struct Together<'a> {
    caches: &'a Caches,
    any: bool,
}

impl EachKind for Together<'_> {
    type Error = Infallible;

    fn run<K: Listed>(&mut self) -> Result<(), Infallible> {
        self.any |= K::TOGETHER && !K::cache(&self.caches.glossy).records().is_empty();
        Ok(())
    }
}

//! The caches of a picture.

use super::kinds::GlossyCaches;
use crate::cache::Cache;
use crate::record::irradiance::IrradianceRecord;
use crate::world::Counts;
use glam::Vec3A;

/// The caches of a picture.
#[derive(Clone, Debug)]
pub struct Caches {
    /// Coarse irradiance on all surfaces seen, which ends the paths of the gather.
    pub coarse: Cache<IrradianceRecord>,
    /// Irradiance on diffuse surfaces.
    pub irradiance: Cache<IrradianceRecord>,
    /// Records on glossy surfaces.
    pub glossy: GlossyCaches,
    /// What was traced for them, and what was dropped.
    pub counts: Counts,
}

impl Caches {
    /// No records yet, for a scene with these corners.
    pub fn new(min: Vec3A, max: Vec3A) -> Self {
        Self {
            coarse: Cache::new(min, max),
            irradiance: Cache::new(min, max),
            glossy: GlossyCaches::new(min, max),
            counts: Counts::default(),
        }
    }

    /// Memory of all records, bytes.
    pub fn bytes(&self) -> usize {
        let glossy: usize = self.glossy.figures().iter().map(|kind| kind.bytes).sum();
        self.coarse.bytes() + self.irradiance.bytes() + glossy
    }
}

/// Caches that were read, and whether they are all that the camera needs.
pub struct Loaded {
    /// The records.
    pub caches: Caches,
    /// Whether camera, τ and spacing are those the file was made for.
    pub complete: bool,
}

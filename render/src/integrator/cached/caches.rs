//! The caches of a picture.

use crate::cache::Cache;
use crate::record::eas::EasRecord;
use crate::record::harmonics::HarmonicsRecord;
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
    /// Sources on glossy surfaces.
    pub eas: Cache<EasRecord>,
    /// Incident radiance on glossy surfaces.
    pub harmonics: Cache<HarmonicsRecord>,
    /// What was traced for them, and what was dropped.
    pub counts: Counts,
}

impl Caches {
    /// No records yet, for a scene with these corners.
    pub fn new(min: Vec3A, max: Vec3A) -> Self {
        Self {
            coarse: Cache::new(min, max),
            irradiance: Cache::new(min, max),
            eas: Cache::new(min, max),
            harmonics: Cache::new(min, max),
            counts: Counts::default(),
        }
    }

    /// Memory of all records, bytes.
    pub fn bytes(&self) -> usize {
        self.coarse.bytes() + self.irradiance.bytes() + self.eas.bytes() + self.harmonics.bytes()
    }
}

//! The caches of a picture.

use super::file::WalkMark;
use super::kinds::{self, EachKind, GlossyCaches, Listed};
use crate::cache::Cache;
use crate::record::irradiance::IrradianceRecord;
use crate::world::Counts;
use core::convert::Infallible;
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
    /// The walk for which they were filled.
    pub walk: Option<WalkMark>,
}

impl Caches {
    /// No records yet, for a scene with these corners.
    pub fn new(min: Vec3A, max: Vec3A) -> Self {
        Self {
            coarse: Cache::new(min, max),
            irradiance: Cache::new(min, max),
            glossy: GlossyCaches::new(min, max),
            counts: Counts::default(),
            walk: None,
        }
    }

    /// Files all records anew: sums over them then have the order that they have in caches read from a file.
    pub fn refile(&mut self) {
        self.coarse.refile();
        self.irradiance.refile();
        let Ok(()) = kinds::each(&mut RefileEach(&mut self.glossy));
    }

    /// Number of records.
    pub fn records(&self) -> usize {
        let glossy: usize = self.glossy.figures().iter().map(|kind| kind.records).sum();
        self.coarse.records().len() + self.irradiance.records().len() + glossy
    }

    /// Memory of all records, bytes.
    pub fn bytes(&self) -> usize {
        let glossy: usize = self.glossy.figures().iter().map(|kind| kind.bytes).sum();
        self.coarse.bytes() + self.irradiance.bytes() + glossy
    }
}

struct RefileEach<'a>(&'a mut GlossyCaches);

impl EachKind for RefileEach<'_> {
    type Error = Infallible;

    fn run<K: Listed>(&mut self) -> Result<(), Infallible> {
        K::cache_mut(self.0).refile();
        Ok(())
    }
}

/// Caches that were read, and whether they are all that the camera needs.
pub struct Loaded {
    /// The records.
    pub caches: Caches,
    /// Whether camera, τ and spacing are those the file was made for.
    pub complete: bool,
    /// Whether τ and spacing are.
    pub alike: bool,
}

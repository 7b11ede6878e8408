//! Equivalent area light sources (eas-2015): sources about a point, read through a table of the mean BRDF.

mod file;
mod make;
mod shade;
mod want;

use crate::bsdf::Parts;
use crate::cache::{Drawn, Lookup};
use crate::color::mean_radiance;
use crate::integrator::cached::file::{CacheFileError, Reader};
use crate::integrator::cached::kind::{Asked, Found, GlossyKind, KindFigures, Shaded};
use crate::integrator::cached::settings::Quality;
use crate::integrator::cached::site::Site;
use crate::record::eas::EasRecord;
use crate::record::{Receiver, Reflector, Scratch, reflect};
use crate::scene::Rgb;
use crate::scene::checksum::Hash;
use crate::world::Counts;
use brdf_tables::brdf::Specular;
use brdf_tables::material::Material as Recipe;
use brdf_tables::real::LANES;
use brdf_tables::table::Table;
use glam::Vec3A;
#[cfg(feature = "gpu")]
pub(in crate::integrator::cached) use shade::Sum;
pub use want::{Held, Lobe, Sharpness};

/// Tables of a scene's materials.
#[derive(Clone, Debug, Default)]
pub struct Eas {
    /// Tables in use.
    pub lobes: Vec<Lobe>,
    sharpest: Sharpness,
}

/// Memory for as many points as are read at once.
#[derive(Debug, Default)]
pub struct Memory([Scratch; LANES]);

impl GlossyKind for Eas {
    const NAME: &'static str = "eas";
    const ABOUT: &'static str = "EAS on every glossy surface that a table can hold";
    const MEAN_KEY: &'static str = "eas_mean";
    const TABLES: bool = true;
    const SALT: u64 = 3;
    const TOGETHER: bool = true;

    type Settings = ();
    type Record = EasRecord;
    type Held = Held;
    type Scratch = Memory;

    fn settings(_: f32) {}

    fn ask(&mut self, asked: Asked<()>) -> bool {
        self.sharpest = match asked {
            Asked::Everywhere(()) => Sharpness::Any,
            Asked::Paying => Sharpness::Paying,
            Asked::No => return false,
        };
        true
    }

    fn hold<E>(
        &mut self,
        specular: Specular,
        table: &mut impl FnMut(&Recipe) -> Result<Table, E>,
    ) -> Result<(Option<Held>, String), E> {
        self.wanted(specular, table)
    }

    fn outlook(specular: &Specular) -> Option<String> {
        Some(want::outlook(specular))
    }

    fn key(&self, tables: &mut Hash, _: &mut Hash) {
        for lobe in &self.lobes {
            // A table that was too large for its file would have none to be told from.
            tables.bytes(&lobe.table.to_bytes().unwrap_or_default());
        }
    }

    #[inline(always)]
    fn lobe_width(&self, held: Held) -> f32 {
        self.lobes[held.lobe].width
    }

    fn serves(&self, _: Held, _: Vec3A) -> bool {
        true
    }

    #[inline]
    fn trust(&self, held: Held, record: &EasRecord, mirror: Vec3A) -> f32 {
        record.views.trust(mirror, self.lobes[held.lobe].width)
    }

    fn make(&self, held: Held, site: &Site) -> Option<(EasRecord, Counts)> {
        let (record, _, counts) = self.record(held, site)?;
        Some((record, counts))
    }

    fn light(
        &self,
        held: Held,
        record: &EasRecord,
        parts: &Parts,
        at: &Receiver,
        quality: &Quality,
        Memory(scratch): &mut Memory,
    ) -> Rgb {
        let lobe = &self.lobes[held.lobe];
        let reflector = Reflector::of(&lobe.table, parts);
        let found = reflect(record, at, &reflector, &lobe.albedo, quality.estimator, &mut scratch[0]);
        parts.diffuse * mean_radiance(found.irradiance) + found.specular
    }

    #[inline(always)]
    fn reflect(
        &self,
        held: Held,
        records: &impl Lookup<EasRecord>,
        at: &Shaded,
        quality: &Quality,
        Memory(scratch): &mut Memory,
    ) -> Found {
        self.interpolated(held, records, at, quality, &mut scratch[0])
    }

    fn splat(
        &self,
        held: Held,
        records: &Drawn<EasRecord>,
        surfaces: &[Shaded],
        quality: &Quality,
        memory: &mut Memory,
    ) -> Vec<Found> {
        self.splatted(held, records, surfaces, quality, memory)
    }

    fn write(record: &EasRecord, bytes: &mut Vec<u8>) {
        file::write(record, bytes);
    }

    fn read(reader: &mut Reader) -> Result<EasRecord, CacheFileError> {
        file::read(reader)
    }

    fn elements(record: &EasRecord) -> usize {
        record.sources.len()
    }

    fn sentence(figures: &KindFigures) -> String {
        format!("{} EAS records of {:.0} sources", figures.records, figures.mean())
    }
}

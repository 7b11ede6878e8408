//! Incident radiance as harmonics (radiance-caching-2005), read with the harmonics of the BRDF.

mod file;
mod make;
mod shade;
mod want;

use crate::bsdf::Parts;
use crate::cache::{Drawn, Lookup};
use crate::integrator::cached::file::{CacheFileError, Reader};
use crate::integrator::cached::kind::{Asked, Found, GlossyKind, KindFigures, Shaded};
use crate::integrator::cached::settings::Quality;
use crate::integrator::cached::site::Site;
use crate::record::Receiver;
use crate::record::harmonics::{
    Basis, Gradients, HarmonicBrdf, HarmonicsRecord, HarmonicsSettings, Reader as Functions,
};
use crate::scene::Rgb;
use crate::scene::checksum::Hash;
use crate::world::Counts;
use brdf_tables::brdf::Specular;
use brdf_tables::material::Material as Recipe;
use brdf_tables::table::Table;
use glam::Vec3A;
pub use want::Held;

/// BRDFs of a scene's materials.
#[derive(Clone, Debug, Default)]
pub struct Harmonics {
    /// BRDFs as harmonics, in use.
    pub brdfs: Vec<HarmonicBrdf>,
    /// How incident radiance is projected, where it is.
    pub projection: Option<HarmonicsSettings>,
}

impl GlossyKind for Harmonics {
    const NAME: &'static str = "sh";
    const ABOUT: &'static str = "Radiance caching with harmonics on every glossy surface that they can hold, irradiance records \
                                on diffuse ones";
    const MEAN_KEY: &'static str = "order_mean";
    const TABLES: bool = false;
    const SALT: u64 = 4;
    const TOGETHER: bool = false;

    type Settings = HarmonicsSettings;
    type Record = HarmonicsRecord;
    type Held = Held;
    type Scratch = Functions;

    fn settings(tolerance: f32) -> HarmonicsSettings {
        HarmonicsSettings::new(Basis::default(), Gradients::default(), tolerance, None)
    }

    fn ask(&mut self, asked: Asked<HarmonicsSettings>) -> bool {
        self.projection = match asked {
            Asked::Everywhere(settings) => Some(settings),
            Asked::Paying | Asked::No => None,
        };
        self.projection.is_some()
    }

    fn hold<E>(
        &mut self,
        specular: Specular,
        _: &mut impl FnMut(&Recipe) -> Result<Table, E>,
    ) -> Result<(Option<Held>, String), E> {
        Ok(self.wanted(specular))
    }

    fn outlook(_: &Specular) -> Option<String> {
        None
    }

    fn key(&self, _: &mut Hash, method: &mut Hash) {
        method.encoded(&self.projection);
    }

    #[inline(always)]
    fn lobe_width(&self, held: Held) -> f32 {
        self.brdfs[held.brdf].specular.lobe_width() as f32
    }

    /// Directions that no order holds are path traced.
    fn serves(&self, held: Held, wo: Vec3A) -> bool {
        self.brdfs[held.brdf].outgoing(wo).traced < 1.0
    }

    fn make(&self, held: Held, site: &Site) -> Option<(HarmonicsRecord, Counts)> {
        self.record(held, site)
    }

    fn light(
        &self,
        held: Held,
        record: &HarmonicsRecord,
        parts: &Parts,
        at: &Receiver,
        _: &Quality,
        scratch: &mut Functions,
    ) -> Rgb {
        self.reflected(held, record, parts, at, scratch)
    }

    #[inline(always)]
    fn reflect(
        &self,
        held: Held,
        records: &impl Lookup<HarmonicsRecord>,
        at: &Shaded,
        quality: &Quality,
        scratch: &mut Functions,
    ) -> Found {
        self.interpolated(held, records, at, quality, scratch)
    }

    fn splat(
        &self,
        held: Held,
        records: &Drawn<HarmonicsRecord>,
        surfaces: &[Shaded],
        quality: &Quality,
        scratch: &mut Functions,
    ) -> Vec<Found> {
        surfaces.iter().map(|at| self.interpolated(held, records, at, quality, scratch)).collect()
    }

    fn write(record: &HarmonicsRecord, bytes: &mut Vec<u8>) {
        file::write(record, bytes);
    }

    fn read(reader: &mut Reader) -> Result<HarmonicsRecord, CacheFileError> {
        file::read(reader)
    }

    fn elements(record: &HarmonicsRecord) -> usize {
        record.order()
    }

    fn sentence(figures: &KindFigures) -> String {
        format!("{} harmonic records of order {:.1}", figures.records, figures.mean())
    }
}

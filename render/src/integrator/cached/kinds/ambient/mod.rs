//! A kind for tests alone: it shows what one must tell of itself. A record keeps the mean radiance of its hemisphere, which
//! every surface reflects as if it came from everywhere.

mod tests;

use crate::bsdf::{Parts, Split};
use crate::cache::{Drawn, FOUND, Lookup};
use crate::hemisphere::nearest;
use crate::integrator::cached::file::{CacheFileError, Reader, write_numbers, write_words};
use crate::integrator::cached::kind::{Asked, Found, GlossyKind, KindFigures, Shaded};
use crate::integrator::cached::settings::Quality;
use crate::integrator::cached::site::Site;
use crate::record::{Receiver, Record, Zone};
use crate::scene::Rgb;
use crate::scene::checksum::Hash;
use crate::world::Counts;
use brdf_tables::brdf::Specular;
use brdf_tables::material::Material as Recipe;
use brdf_tables::table::Table;
use core::f32::consts::TAU;
use glam::Vec3A;

/// Knows nothing of any material.
#[derive(Clone, Debug, Default)]
pub struct Ambient;

/// Mean radiance about a point.
#[derive(Clone, Debug)]
pub struct AmbientRecord {
    zone: Zone,
    radiance: Rgb,
}

impl Record for AmbientRecord {
    fn zone(&self) -> &Zone {
        &self.zone
    }
    fn zone_mut(&mut self) -> &mut Zone {
        &mut self.zone
    }
    fn bytes(&self) -> usize {
        size_of::<Self>()
    }
    fn is_finite(&self) -> bool {
        self.zone.is_finite() && self.radiance.is_finite()
    }
}

impl GlossyKind for Ambient {
    const NAME: &'static str = "ambient";
    const ABOUT: &'static str = "The mean radiance about every glossy surface";
    const MEAN_KEY: &'static str = "ambient_mean";
    const TABLES: bool = false;
    const SALT: u64 = 5;
    const TOGETHER: bool = false;

    type Settings = ();
    type Record = AmbientRecord;
    type Held = ();
    type Scratch = ();

    fn settings(_: f32) {}

    fn ask(&mut self, asked: Asked<()>) -> bool {
        asked == Asked::Everywhere(())
    }

    fn hold<E>(
        &mut self,
        _: Specular,
        _: &mut impl FnMut(&Recipe) -> Result<Table, E>,
    ) -> Result<(Option<()>, String), E> {
        Ok((Some(()), "cached with ambient light".into()))
    }

    fn outlook(_: &Specular) -> Option<String> {
        None
    }

    fn key(&self, _: &mut Hash, _: &mut Hash) {}

    fn lobe_width(&self, (): ()) -> f32 {
        1.0
    }

    fn serves(&self, (): (), _: Vec3A) -> bool {
        true
    }

    fn make(&self, (): (), site: &Site) -> Option<(AmbientRecord, Counts)> {
        let (quality, frame) = (site.quality(), site.frame());
        let mut gather = site.gather(Self::SALT);
        let samples = gather.uniform(&frame, quality.irradiance_rays);
        let light: Rgb = samples.iter().map(|s| s.radiance * s.solid_angle).sum();
        let radius = quality.glossy.radius(nearest(&samples), site.point().footprint);
        let zone = Zone { radius, ..site.zone(&frame) };
        Some((AmbientRecord { zone, radiance: light / TAU }, gather.counts))
    }

    fn light(&self, (): (), record: &AmbientRecord, parts: &Parts, _: &Receiver, _: &Quality, (): &mut ()) -> Rgb {
        record.radiance * (parts.diffuse + parts.specular)
    }

    fn reflect(
        &self,
        (): (),
        records: &impl Lookup<AmbientRecord>,
        at: &Shaded,
        quality: &Quality,
        (): &mut (),
    ) -> Found {
        let (mut sum, mut weights) = (Rgb::ZERO, 0.0);
        records.interpolate(at.at.position, at.hemisphere, quality.weight, |record, w| {
            if at.finish.reads(record.zone().material) {
                sum += record.radiance * w;
                weights += w;
            }
        });
        let radiance = sum / weights;
        let light = (weights > FOUND)
            .then(|| Split { diffuse: at.parts.diffuse * radiance, glossy: at.parts.specular * radiance });
        Found { light, traced: 0.0, doubt: 0.0 }
    }

    fn splat(
        &self,
        (): (),
        records: &Drawn<AmbientRecord>,
        surfaces: &[Shaded],
        quality: &Quality,
        scratch: &mut (),
    ) -> Vec<Found> {
        surfaces.iter().map(|at| self.reflect((), records, at, quality, scratch)).collect()
    }

    fn write(record: &AmbientRecord, bytes: &mut Vec<u8>) {
        let Zone { position, normal, radius, material } = record.zone;
        let vectors = [position, normal, record.radiance];
        write_numbers(bytes, vectors.into_iter().flat_map(|v| v.to_array()).chain([radius]));
        write_words(bytes, [material]);
    }

    fn read(reader: &mut Reader) -> Result<AmbientRecord, CacheFileError> {
        let x: [f32; 10] = reader.numbers()?;
        let [position, normal, radiance] = core::array::from_fn(|i| Vec3A::from_slice(&x[3 * i..]));
        let material = reader.word()?;
        reader.check_material(material)?;
        Ok(AmbientRecord { zone: Zone { position, normal, radius: x[9], material }, radiance })
    }

    fn elements(_: &AmbientRecord) -> usize {
        1
    }

    fn sentence(figures: &KindFigures) -> String {
        format!("{} ambient records", figures.records)
    }
}

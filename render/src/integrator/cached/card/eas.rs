//! EAS records on the card.

use super::rows::{Row, back, number, word};
use crate::cache::Cache;
use crate::gpu::{Device, GpuError};
use crate::integrator::cached::kind::Shaded;
use crate::integrator::cached::kinds::eas::{Eas, Held, Lobe, Sum};
use crate::record::eas::EasRecord;
use crate::record::{Record, Reflector};
use crate::scene::Rgb;
use brdf_tables::brdf::{Fresnel, Specular};
use brdf_tables::wgsl::Tables;
use glam::Vec3A;
use wgpu::Buffer;

/// Rows of a surface, of a record, of a source, of a lobe, and of sums.
pub type SurfaceRows = [Row; 9];
type RecordRows = [Row; 5];
type SourceRows = [Row; 3];
type LobeRows = [Row; 3];
pub type SumRows = [Row; 3];

/// Records, sources, lobes and tables, in the order in which they are bound.
pub struct Records {
    pub records: Buffer,
    pub sources: Buffer,
    pub lobes: Buffer,
    pub tables: Buffer,
    /// Whether the card has the lobe.
    has: Vec<bool>,
}

impl Records {
    pub fn new(device: &Device, cache: &Cache<EasRecord>, eas: &Eas) -> Result<Self, GpuError> {
        let (mut records, mut sources) = (Vec::<RecordRows>::new(), Vec::<SourceRows>::new());
        for record in cache.records() {
            records.push(record_rows(record, sources.len() as u32));
            sources.extend(record.sources.iter().map(|source| {
                let [light, direction] = [source.light, source.direction].map(Vec3A::from_array);
                let direction = number(direction, source.inv_distance);
                [direction, number(light, source.solid_angle), number(source.mean_normal(), source.factor)]
            }));
        }
        let (mut tables, mut lobes, mut has) = (Tables::new(), Vec::<LobeRows>::new(), Vec::new());
        for lobe in &eas.lobes {
            let place = if is_grey_or_metal(&lobe.specular) { tables.push(&lobe.table).ok() } else { None };
            has.push(place.is_some());
            lobes.push(lobe_rows(lobe, place.unwrap_or(0)));
        }
        Ok(Self {
            records: device.upload("the EAS records", &records)?,
            sources: device.upload("the sources of EAS records", &sources)?,
            lobes: device.upload("the lobes", &lobes)?,
            tables: device.upload("the tables", tables.words())?,
            has,
        })
    }

    /// Whether the card has code for what holds a surface.
    pub fn has(&self, held: Held) -> bool {
        self.has[held.lobe]
    }
}

/// What was measured has colours in a lattice of their own.
fn is_grey_or_metal(specular: &Specular) -> bool {
    match specular {
        Specular::Measured(measured) => measured.tint_lattice().is_none(),
        _ => true,
    }
}

fn record_rows(record: &EasRecord, first_source: u32) -> RecordRows {
    [
        number(record.position(), record.radius()),
        word(record.normal(), record.zone().material),
        word(record.background, first_source),
        number(Vec3A::from_array(record.views.axis), record.views.half_angle),
        [record.sources.len() as u32, 0, 0, 0],
    ]
}

fn lobe_rows(lobe: &Lobe, place: u32) -> LobeRows {
    let (cos, sin) = lobe.albedo.support();
    let vector = |rgb: [f64; 3]| Rgb::from_array(rgb.map(|x| x as f32));
    let conductor = match lobe.specular.fresnel() {
        Some(Fresnel::Conductor { eta, k }) => Some((vector(*eta), vector(*k))),
        _ => None,
    };
    let (eta, k) = conductor.unwrap_or_default();
    let head = [place, conductor.is_some().into(), cos.to_bits(), sin.to_bits()];
    [head, number(eta, lobe.width), number(k, 0.0)]
}

/// A surface that is held by a lobe.
pub fn surface(eas: &Eas, held: Held, s: &Shaded) -> SurfaceRows {
    let lobe = &eas.lobes[held.lobe];
    let reflector = Reflector::of(&lobe.table, s.parts);
    let (normal, grazing, f0) = reflector.colors();
    let (everywhere, unit) = reflector.albedo(&lobe.albedo, s.at.wo);
    let [x, y, z] = s.at.frame.axes();
    let (first, class) = s.finish.classes();
    [
        word(s.at.position, first),
        word(s.hemisphere, class),
        word(x, held.lobe as u32),
        number(y, f0.unwrap_or(-1.0)),
        number(z, unit),
        number(s.at.wo, 0.0),
        number(normal, 0.0),
        number(grazing, 0.0),
        number(everywhere, 0.0),
    ]
}

/// What the records about a surface sum up to.
pub fn sum([light, shine, rest]: SumRows) -> Sum {
    let ((irradiance, weights), (specular, trust)) = (back(light), back(shine));
    Sum::of((irradiance, weights), (specular, trust), f32::from_bits(rest[0]), rest[1] != 0)
}

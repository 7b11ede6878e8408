//! Harmonic records on the card.

use super::rows::{Row, number, word};
use crate::cache::Cache;
use crate::gpu::{Device, GpuError};
use crate::integrator::cached::kind::{Found, Shaded};
use crate::integrator::cached::kinds::harmonics::{Harmonics, Held};
use crate::record::Record;
use crate::record::harmonics::flat::{FlatTexel, constants};
use crate::record::harmonics::{Basis, HarmonicsRecord, frame_of};
use crate::scene::Rgb;
use glam::Vec3A;
use wgpu::Buffer;

/// Rows of a surface, of a record, and of sums.
pub type SurfaceRows = [Row; 8];
type RecordRows = [Row; 5];
pub type SumRows = [Row; 2];

/// Records, their coefficients, maps and constants, in the order in which they are bound.
pub struct Records {
    pub records: Buffer,
    pub numbers: Buffer,
    pub lobes: Buffer,
    pub constants: Buffer,
    /// The texels of each map.
    maps: Vec<Vec<FlatTexel>>,
}

impl Records {
    pub fn new(device: &Device, cache: &Cache<HarmonicsRecord>, kind: &Harmonics) -> Result<Self, GpuError> {
        let (mut records, mut numbers) = (Vec::<RecordRows>::new(), Vec::new());
        for record in cache.records() {
            records.push(record_rows(record, numbers.len() as u32));
            numbers.extend_from_slice(record.numbers());
        }
        let mut lobes = Vec::new();
        let maps = kind.brdfs.iter().map(|brdf| brdf.flatten(&mut lobes)).collect();
        Ok(Self {
            records: device.upload("the harmonic records", &records)?,
            numbers: device.upload("the coefficients of harmonic records", &numbers)?,
            lobes: device.upload("the BRDFs as harmonics", &lobes)?,
            // Without records there is nothing to turn.
            constants: device
                .upload("the constants of harmonics", &if records.is_empty() { Vec::new() } else { constants() })?,
            maps,
        })
    }

    /// A surface that is held by a map.
    pub fn surface(&self, kind: &Harmonics, held: Held, s: &Shaded) -> SurfaceRows {
        let (brdf, map) = (&kind.brdfs[held.brdf], &self.maps[held.brdf]);
        let [x, y, z] = frame_of(brdf, &s.at).axes();
        let [sx, sy] = brdf.signs(s.at.wo).map(u32::from);
        let (first, class) = s.finish.classes();
        let blend = brdf.blend(s.at.wo);
        let texels = blend.map(|(i, _)| map[i]);
        [
            word(s.at.position, first),
            word(s.hemisphere, class),
            word(x, brdf.outgoing(s.at.wo).order as u32),
            word(y, (brdf.basis == Basis::Spherical).into()),
            word(z, sx | sy << 1),
            texels.map(|texel| texel.first),
            texels.map(|texel| texel.order << 1 | u32::from(texel.sines)),
            blend.map(|(_, share)| share.to_bits()),
        ]
    }
}

fn record_rows(record: &HarmonicsRecord, first_number: u32) -> RecordRows {
    let [x, y, normal] = record.frame().axes();
    let order = record.order();
    [
        number(record.position(), record.radius()),
        word(normal, record.zone().material),
        word(x, order as u32),
        word(y, first_number),
        [(record.numbers().len() / (order * order)) as u32, 0, 0, 0],
    ]
}

/// What the records say of a surface with these sums.
pub fn found(kind: &Harmonics, held: Held, s: &Shaded, [first, second]: SumRows) -> Found {
    let [a, b, c, d] = first.map(f32::from_bits);
    let [e, f, weights, _] = second.map(f32::from_bits);
    let (specular, irradiance): (Rgb, Rgb) = (Vec3A::new(a, b, c), Vec3A::new(d, e, f));
    kind.found(held, s, (irradiance, specular), weights)
}

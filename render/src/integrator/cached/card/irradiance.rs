//! Irradiance records on the card.

use super::rows::{Row, back, number};
use crate::cache::{Cache, FOUND};
use crate::gpu::{Device, GpuError};
use crate::integrator::cached::diffuse::Interpolated;
use crate::integrator::cached::surface::Surface;
use crate::record::Record;
use crate::record::irradiance::IrradianceRecord;
use glam::Vec3A;
use wgpu::Buffer;

/// Rows of a surface and of sums.
pub type SurfaceRows = [Row; 3];
pub type SumRows = [Row; 2];

/// All records.
pub fn records(device: &Device, cache: &Cache<IrradianceRecord>) -> Result<Buffer, GpuError> {
    let all: Vec<_> = cache.records().iter().map(rows).collect();
    device.upload("the irradiance records", &all)
}

/// A record as the shader has it.
pub fn rows(record: &IrradianceRecord) -> [[u32; 4]; 9] {
    let [tx, ty, tz] = record.translation.map(|v| number(v, 0.0));
    let [rx, ry, rz] = record.rotation.map(|v| number(v, 0.0));
    let irradiance = number(record.irradiance, 0.0);
    [number(record.position(), record.radius()), number(record.normal(), 0.0), irradiance, tx, ty, tz, rx, ry, rz]
}

/// A surface.
pub fn surface(s: &Surface) -> SurfaceRows {
    [s.mean_position(), s.point.hemisphere_normal(), s.mean_normal()].map(|v: Vec3A| number(v, 0.0))
}

/// What the records say of a surface.
pub fn found([light, rest]: SumRows) -> Option<Interpolated> {
    let ((irradiance, radius), weights) = (back(light), f32::from_bits(rest[0]));
    (weights > FOUND).then(|| Interpolated { irradiance: irradiance / weights, radius: radius / weights })
}

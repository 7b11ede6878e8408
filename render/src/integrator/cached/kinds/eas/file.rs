//! EAS records in a file: position, normal, radius, background, axis and half angle of the views (14 f32), material and count (u32),
//! sources of 40 bytes.

use crate::integrator::cached::file::{CacheFileError, Reader, write_numbers, write_words};
use crate::record::eas::{Eas as Source, EasRecord, ViewCone};
use crate::record::{Record, Zone};
use glam::Vec3A;

pub(super) fn write(record: &EasRecord, bytes: &mut Vec<u8>) {
    let Zone { position, normal, radius, material } = record.zone();
    write_numbers(bytes, position.to_array());
    write_numbers(bytes, normal.to_array());
    write_numbers(bytes, [*radius]);
    write_numbers(bytes, record.background.to_array());
    write_numbers(bytes, record.views.axis);
    write_numbers(bytes, [record.views.half_angle]);
    write_words(bytes, [*material, record.sources.len() as u32]);
    record.sources.iter().for_each(|s| bytes.extend(s.to_bytes()));
}

pub(super) fn read(reader: &mut Reader) -> Result<EasRecord, CacheFileError> {
    let [px, py, pz, nx, ny, nz, radius, r, g, b, vx, vy, vz, half_angle] = reader.numbers()?;
    let (material, count) = (reader.word()?, reader.word()?);
    let zone = Zone { position: Vec3A::new(px, py, pz), normal: Vec3A::new(nx, ny, nz), radius, material };
    reader.check_material(material)?;
    const SIZE: usize = size_of::<Source>();
    let bytes = reader.take(count as usize * SIZE)?;
    let sources = bytes.chunks_exact(SIZE).map(|b| Source::from_bytes(b.try_into().expect("40 bytes")));
    let sources: Option<Box<[Source]>> = sources.collect();
    let sources = sources.ok_or(CacheFileError::Format("a number is not finite"))?;
    Ok(EasRecord::restored(zone, ViewCone { axis: [vx, vy, vz], half_angle }, Vec3A::new(r, g, b), sources))
}

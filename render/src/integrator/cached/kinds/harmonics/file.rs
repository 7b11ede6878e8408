//! Harmonic records in a file: position, axes of the frame and radius (13 f32), material, order and count (u32), coefficients
//! (f32).

use crate::integrator::cached::file::{CacheFileError, Reader, write_numbers, write_words};
use crate::record::harmonics::HarmonicsRecord;
use crate::record::{Record, Zone};
use glam::Vec3A;

pub(super) fn write(record: &HarmonicsRecord, bytes: &mut Vec<u8>) {
    let zone = record.zone();
    let vectors = core::iter::once(zone.position).chain(record.frame().axes());
    write_numbers(bytes, vectors.flat_map(|v| v.to_array()));
    write_numbers(bytes, [zone.radius]);
    write_words(bytes, [zone.material, record.order() as u32, record.numbers().len() as u32]);
    write_numbers(bytes, record.numbers().iter().copied());
}

pub(super) fn read(reader: &mut Reader) -> Result<HarmonicsRecord, CacheFileError> {
    let vectors: [f32; 12] = reader.numbers()?;
    let [radius] = reader.numbers()?;
    let (material, order, count) = (reader.word()?, reader.word()?, reader.word()?);
    reader.check_material(material)?;
    let bytes = reader.take(count as usize * size_of::<f32>())?;
    let numbers: Box<[f32]> =
        bytes.chunks_exact(4).map(|b| f32::from_le_bytes(b.try_into().expect("four bytes"))).collect();
    if numbers.iter().any(|x| !x.is_finite()) {
        return Err(CacheFileError::Format("a number is not finite"));
    }
    let [position, x, y, normal] = core::array::from_fn(|i| Vec3A::from_slice(&vectors[3 * i..]));
    HarmonicsRecord::restored(Zone { position, normal, radius, material }, [x, y], order, numbers)
        .ok_or(CacheFileError::Format("a record of no order"))
}

//! Checksums of what a picture depends on, to tell whether figures and records on disk belong to a scene.
//!
//! They are of the scene's own encoding, so that no field can be forgotten: what does not count is named in
//! [`Checksums::new`], and a new field does not compile until it is put on one side or the other.

use super::{IntegratorSettings, Scene};
use serde::Serialize;
use std::io::{BufWriter, Write};

/// Checksums of the parts of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Checksums {
    /// Shapes, lights, environment, length of the paths.
    pub geometry: u64,
    /// Materials and textures.
    pub materials: u64,
    /// Camera and film, and what only the camera sees.
    pub camera: u64,
}

impl Checksums {
    /// Of a scene in memory: names, comments and the number of samples do not matter.
    pub fn new(scene: &Scene) -> Self {
        let Scene {
            shapes,
            groups,
            instances,
            materials,
            material_names: _,
            textures,
            lights,
            environment,
            camera,
            integrator,
        } = scene;
        let IntegratorSettings { max_depth, rr_depth, hide_emitters, hide_environment, soft_terminator, spp: _ } =
            integrator;
        let mut geometry = Hash::default();
        geometry.encoded(&(shapes, groups, instances, lights, environment, max_depth, rr_depth, soft_terminator));
        let mut surfaces = Hash::default();
        surfaces.encoded(&(materials, textures));
        let mut view = Hash::default();
        view.encoded(&(camera, hide_emitters, hide_environment));
        Self { geometry: geometry.finish(), materials: surfaces.finish(), camera: view.finish() }
    }
}

/// A checksum with the length of what it is of.
#[derive(Default)]
pub struct Hash(crc32fast::Hasher, u64);

impl Hash {
    /// Adds a text.
    pub fn text(&mut self, text: &str) {
        self.bytes(text.as_bytes());
    }

    /// Adds numbers.
    pub fn numbers(&mut self, numbers: &[f32]) {
        self.bytes(bytemuck::cast_slice(numbers));
    }

    /// Adds bytes.
    pub fn bytes(&mut self, bytes: &[u8]) {
        self.0.update(bytes);
        self.1 += bytes.len() as u64;
    }

    /// Adds every field of a value: no two values have the same encoding.
    pub fn encoded(&mut self, value: &impl Serialize) {
        // Numbers come one by one; the checksum is quicker over many.
        let mut writer = BufWriter::with_capacity(1 << 16, &mut *self);
        let written = bincode::serde::encode_into_std_write(value, &mut writer, bincode::config::legacy());
        let failed = written.is_err() || writer.flush().is_err();
        drop(writer);
        // Nothing fails to be written here; if it did, the checksum would still be another.
        self.text(if failed { "cut" } else { "" });
    }

    /// CRC-32 in the upper half, length in the lower.
    pub fn finish(self) -> u64 {
        u64::from(self.0.finalize()) << 32 | self.1 & 0xffff_ffff
    }
}

impl Write for Hash {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.bytes(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

#[cfg(test)]
mod tests;

//! Checksums of what a picture depends on, to tell whether figures and records on disk belong to a scene.

use super::{Environment, Geometry, Scene, Texture};

/// Checksums of the parts of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Checksums {
    /// Shapes, lights, environment, length of the paths.
    pub geometry: u64,
    /// Materials and textures.
    pub materials: u64,
    /// Camera and film.
    pub camera: u64,
}

impl Checksums {
    /// Of a scene in memory: comments and file names do not matter.
    pub fn new(scene: &Scene) -> Self {
        let mut geometry = Hash::default();
        for shape in scene.shapes.iter().chain(scene.groups.iter().flat_map(|g| &g.shapes)) {
            match &shape.geometry {
                Geometry::Mesh(m) => {
                    m.positions.iter().for_each(|p| geometry.numbers(&p.to_array()));
                    m.triangles.iter().for_each(|t| geometry.0.update(bytemuck::cast_slice(t)));
                }
                Geometry::Sphere(s) => geometry.text(&format!("{s:?}")),
            }
            geometry.text(&format!("{:?}{:?}", shape.material, shape.emitter));
        }
        geometry.text(&format!("{:?}{:?}{:?}", scene.instances, scene.lights, scene.integrator.max_depth));
        if let Some(Environment::Map(map)) = &scene.environment {
            (0..map.image.texels.len()).for_each(|i| geometry.numbers(&map.image.texels.get(i).to_array()));
            geometry.text(&format!("{:?}{}", map.to_world, map.scale));
        } else {
            geometry.text(&format!("{:?}", scene.environment));
        }
        let mut materials = Hash::default();
        materials.text(&format!("{:?}", scene.materials));
        for texture in &scene.textures {
            match texture {
                Texture::Bitmap(b) => (0..b.texels.len()).for_each(|i| materials.numbers(&b.texels.get(i).to_array())),
                other => materials.text(&format!("{other:?}")),
            }
        }
        let mut camera = Hash::default();
        camera.text(&format!("{:?}", scene.camera));
        Self { geometry: geometry.finish(), materials: materials.finish(), camera: camera.finish() }
    }
}

/// A checksum with the length of what it is of.
#[derive(Default)]
pub struct Hash(crc32fast::Hasher, u64);

impl Hash {
    /// Adds a text.
    pub fn text(&mut self, text: &str) {
        self.0.update(text.as_bytes());
        self.1 += text.len() as u64;
    }

    /// Adds numbers.
    pub fn numbers(&mut self, numbers: &[f32]) {
        self.0.update(bytemuck::cast_slice(numbers));
        self.1 += 1;
    }

    /// CRC-32 in the upper half, length in the lower.
    pub fn finish(self) -> u64 {
        u64::from(self.0.finalize()) << 32 | self.1 & 0xffff_ffff
    }
}

//! Glass: KHR_materials_transmission and KHR_materials_volume.
//!
//! What closed meshes enclose is glass throughout, which refracts, as Blender draws what it exports; with
//! KHR_materials_volume it absorbs, too. Other meshes are sheets, which the specification calls thin-walled, as are
//! closed ones whose volume has the thickness 0. The colour tints what passes: half of it (its square root) at each
//! boundary of a solid, as in Cycles, so that a way through has it once; all of it at a sheet, as the specification
//! has it, but in files of Blender, where a sheet is one boundary.

use super::placement::Posed;
use super::{Builder, sides};
use crate::scene::load::error::FileError;
use crate::scene::{ColorTexture, FloatTexture, Material, MaterialId, Rgb, TextureId};

/// An opaque material with what glass shares with it.
pub struct Opaque {
    pub id: MaterialId,
    /// What of it is metal, alone; `None` where nothing is.
    pub metal: Option<MaterialId>,
    /// Normal map with its scale.
    pub normal: Option<(TextureId, f32)>,
    pub base_color: ColorTexture,
    pub metallic: FloatTexture,
    pub roughness: FloatTexture,
    /// Whether its part that transmits encloses glass.
    pub solid: bool,
}

impl Builder<'_> {
    /// Whether a primitive encloses glass: alone, or with the others of its mesh.
    pub(super) fn is_solid(&mut self, mesh: &gltf::Mesh, primitive: &gltf::Primitive) -> Result<bool, FileError> {
        let material = primitive.material();
        let volume = material.volume();
        let thin = volume.as_ref().is_some_and(|v| v.thickness_factor() == 0.0);
        if thin || material.transmission().is_none() {
            return Ok(false);
        }
        let what = format!("mesh {} ({})", mesh.index(), mesh.name().unwrap_or("-"));
        let at_rest = Posed::at_rest(mesh.index());
        let alone = self.geometry(primitive, &at_rest, &[], &what)?;
        if alone.is_some_and(|m| sides::is_closed([&m])) {
            return Ok(true);
        }
        let mut all = Vec::new();
        for primitive in mesh.primitives() {
            all.extend(self.geometry(&primitive, &at_rest, &[], &what)?);
        }
        let closed = sides::is_closed(&all);
        if volume.is_some() && !closed {
            self.note("KHR_materials_volume of a mesh that is not closed: drawn as a sheet of glass", &what);
        }
        Ok(closed)
    }

    /// Glass in place of so much of an opaque material; what is metal stays metal.
    pub(super) fn glass(&mut self, source: &gltf::Material, opaque: &Opaque, weight: FloatTexture) -> MaterialId {
        let &Opaque { normal, base_color, metallic, roughness, solid, metal, .. } = opaque;
        let eta = index(source);
        let volume = source.volume().filter(|_| solid);
        let absorption = volume.map_or(Rgb::ZERO, |v| absorption(&v, self.blender));
        let crossings = if solid || self.blender { 2 } else { 1 };
        let glass = Material::Glass { base_color, crossings, roughness, eta, sheet: !solid, absorption };
        let glass = self.push(glass, source);
        let glass = self.bent(glass, normal, source);
        let second = match metal {
            None => glass,
            Some(metal) => self.push(Material::Blend { weight: metallic, first: glass, second: metal }, source),
        };
        self.push(Material::Blend { weight, first: opaque.id, second }, source)
    }
}

const MAX_INDEX: f32 = 1e4;

/// Index of refraction; one of 0 stands for an infinite one.
pub(super) fn index(source: &gltf::Material) -> f32 {
    match source.ior() {
        Some(0.0) => MAX_INDEX,
        ior => ior.filter(|n| *n > 0.0).map_or(1.5, |n| n.clamp(0.1, MAX_INDEX)),
    }
}

/// Absorption coefficient of which the attenuation colour is left after the attenuation distance. Blender's is (1 − colour)
/// times the density, and its exporter writes the colour as it is, and the density as a distance.
fn absorption(volume: &gltf::material::Volume, blender: bool) -> Rgb {
    let color = Rgb::from(volume.attenuation_color()).clamp(Rgb::splat(f32::MIN_POSITIVE), Rgb::ONE);
    let distance = volume.attenuation_distance();
    if distance.is_nan() || distance <= 0.0 {
        return Rgb::ZERO;
    }
    let per_distance = if blender { Rgb::ONE - color } else { -color.ln() };
    (per_distance / distance).clamp(Rgb::ZERO, Rgb::splat(f32::MAX))
}

//! A scene ready for rendering: acceleration structures, lights, and ray queries.

mod aggregate;
mod interaction;
mod masks;
mod primitives;
mod queries;
mod sphere;

use crate::bsdf::{CoatTable, FacetTable, FibreTable, GlassTable};
use crate::light::{FirstEmitter, Lights};
use crate::ray::{Hit, Ray};
use crate::scene::{FloatTexture, Material, MaterialId, Rgb, Scene, SceneError, Texture, TextureId};
use aggregate::{Aggregate, Context, Placement};
use glam::Vec3A;
pub use interaction::Interaction;
pub use primitives::Outline;
pub use queries::{Counts, Queries};
use std::collections::HashMap;
use std::sync::Arc;

/// A scene with everything derived from it.
#[derive(Clone)]
pub struct World {
    /// What was loaded.
    pub scene: Scene,
    /// Its lights.
    pub lights: Lights,
    aggregate: Aggregate,
    groups: Vec<Aggregate>,
    /// Whether a surface has holes.
    masked: bool,
    /// Emitters of every shape.
    first_emitter: Vec<Option<FirstEmitter>>,
    /// Whether a material asks for ∂p/∂u.
    needs_tangents: Vec<bool>,
    /// A large image that a material looks up, if any.
    images: Vec<Option<TextureId>>,
    /// Tables of the rough plastics, by material.
    coats: Vec<Option<Box<CoatTable>>>,
    /// Tables of the glasses that are rough somewhere, by material.
    glasses: Vec<Option<Arc<GlassTable>>>,
    /// Tables of the facets over layered bases, by material.
    facets: Vec<Option<Arc<FacetTable>>>,
    /// Tables of the fibres on a surface, by the material that has both.
    fibres: Vec<Option<Box<FibreTable>>>,
}

impl World {
    /// Checks the scene and builds its acceleration structures.
    ///
    /// # Errors
    /// What [`Scene::validate`] finds.
    pub fn new(scene: Scene) -> Result<Self, SceneError> {
        scene.validate()?;
        let context = |shapes| Context { scene: &scene, shapes, groups: &[] };
        let groups: Vec<_> = scene.groups.iter().map(|g| Aggregate::new(context(&g.shapes), &[])).collect();
        let placements: Vec<_> = scene
            .instances
            .iter()
            .enumerate()
            .map(|(i, p)| Placement { index: i as u32, group: p.group, to_world: p.to_world })
            .collect();
        let aggregate = Aggregate::new(Context { groups: &groups, ..context(&scene.shapes) }, &placements);
        let masked = aggregate.is_masked() || groups.iter().any(Aggregate::is_masked);
        let (lights, first_emitter) = Lights::new(&scene);
        let needs_tangents = (0..scene.materials.len()).map(|i| needs_tangents(&scene, i)).collect();
        let images = (0..scene.materials.len()).map(|i| large_image(&scene, i)).collect();
        let coat = |m: &Material| {
            let Material::RoughPlastic { distribution, alpha, eta, .. } = m else { return None };
            Some(Box::new(CoatTable::new(*distribution, *alpha, *eta)))
        };
        let coats = scene.materials.iter().map(coat).collect();
        let fibres = |m: &Material| {
            let Material::Sheen { fibres, .. } = m else { return None };
            scene.fibres(*fibres).map(|model| Box::new(FibreTable::new(&model)))
        };
        let fibres = scene.materials.iter().map(fibres).collect();
        let (glasses, facets) = (glasses(&scene), facets(&scene));
        Ok(Self {
            scene,
            lights,
            aggregate,
            groups,
            masked,
            first_emitter,
            needs_tangents,
            images,
            coats,
            glasses,
            facets,
            fibres,
        })
    }

    /// Smallest and largest corner of all surfaces; min > max without any.
    pub fn bounds(&self) -> (Vec3A, Vec3A) {
        self.aggregate.bounds()
    }

    /// The nearest surface within the bounds of the ray; the holes of masks are not there.
    #[inline(always)]
    pub fn intersect(&self, ray: &Ray) -> Hit {
        Queries::default().intersect(self, ray)
    }

    /// Whether something lies within the bounds of the ray.
    #[inline(always)]
    pub fn occluded(&self, ray: &Ray) -> bool {
        Queries::default().occluded(self, ray)
    }

    #[inline]
    pub(crate) fn material(&self, id: MaterialId) -> &Material {
        &self.scene.materials[id.0 as usize]
    }

    #[inline]
    pub(crate) fn needs_tangents(&self, id: MaterialId) -> bool {
        self.needs_tangents[id.0 as usize]
    }

    /// Begins to fetch what [`World::bsdf`] will look up at a surface: whoever has many surfaces begins with all of them, and waits
    /// for the memory once.
    #[inline(always)]
    pub(crate) fn fetch_texels(&self, at: &Interaction) {
        if let Some(id) = self.images[at.material.0 as usize]
            && let Texture::Bitmap(image) = &self.scene.textures[id.0 as usize]
        {
            image.touch(at.coordinates.uv[usize::from(image.second_uv)]);
        }
    }

    #[inline]
    pub(crate) fn coat(&self, id: MaterialId) -> Option<&CoatTable> {
        self.coats[id.0 as usize].as_deref()
    }

    #[inline]
    pub(crate) fn glass(&self, id: MaterialId) -> Option<&GlassTable> {
        self.glasses[id.0 as usize].as_deref()
    }

    #[inline]
    pub(crate) fn facets(&self, id: MaterialId) -> Option<&FacetTable> {
        self.facets[id.0 as usize].as_deref()
    }

    #[inline]
    pub(crate) fn fibres(&self, id: MaterialId) -> Option<&FibreTable> {
        self.fibres[id.0 as usize].as_deref()
    }

    /// Absorption coefficient behind a material that is a boundary of glass.
    #[inline]
    pub(crate) fn boundary(&self, id: MaterialId) -> Option<Rgb> {
        if let Material::Glass { sheet: false, absorption, .. } = *self.material(id) { Some(absorption) } else { None }
    }

    fn context(&self) -> Context<'_> {
        Context { scene: &self.scene, shapes: &self.scene.shapes, groups: &self.groups }
    }
}

/// A table for every glass that is rough somewhere; glasses of one index share it.
fn glasses(scene: &Scene) -> Vec<Option<Arc<GlassTable>>> {
    let mut known = HashMap::new();
    let mut table = |m: &Material| {
        let Material::Glass { roughness, eta, sheet, .. } = *m else { return None };
        let new = || Arc::new(GlassTable::new(eta, sheet));
        let rough = roughness != FloatTexture::Constant(0.0);
        rough.then(|| Arc::clone(known.entry((eta.to_bits(), sheet)).or_insert_with(new)))
    };
    scene.materials.iter().map(&mut table).collect()
}

/// A table for every layered surface; those of one index share it.
fn facets(scene: &Scene) -> Vec<Option<Arc<FacetTable>>> {
    let mut known = HashMap::new();
    let mut table = |m: &Material| {
        let (Material::MetallicRoughness { layered: Some(eta), .. } | Material::Principled { eta, .. }) = *m else {
            return None;
        };
        Some(Arc::clone(known.entry(eta.to_bits()).or_insert_with(|| Arc::new(FacetTable::new(eta)))))
    };
    scene.materials.iter().map(&mut table).collect()
}

/// Texels from which on an image may not stay in the cache.
const LARGE: usize = 1 << 16;

/// The first large image that material `i` or what it is made of looks up.
fn large_image(scene: &Scene, i: usize) -> Option<TextureId> {
    let material = &scene.materials[i];
    let is_large =
        |id: &TextureId| matches!(&scene.textures[id.0 as usize], Texture::Bitmap(b) if b.texels.len() >= LARGE);
    let own = material.textures().into_iter().find(is_large);
    own.or_else(|| material.children().find_map(|c| large_image(scene, c.0 as usize)))
}

/// Whether evaluating material `i` needs the direction of u: anisotropy, or a normal from a texture.
fn needs_tangents(scene: &Scene, i: usize) -> bool {
    match &scene.materials[i] {
        Material::NormalMap { .. } | Material::BumpMap { .. } | Material::Function { .. } => true,
        Material::Ward { alpha_u, alpha_v, .. }
        | Material::RoughConductor { alpha_u, alpha_v, .. }
        | Material::RoughDielectric { alpha_u, alpha_v, .. } => alpha_u != alpha_v,
        Material::Principled { anisotropic, .. } => *anisotropic != 0.0,
        m => m.children().any(|c| needs_tangents(scene, c.0 as usize)),
    }
}

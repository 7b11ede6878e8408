//! The promises a scene makes to the renderer: indices in range, finite numbers, no endless nesting.

use super::*;
use brdf_tables::Specular;
use brdf_tables::brdf::Sheen as Fibres;
use thiserror::Error;

/// What is wrong with a scene.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum SceneError {
    /// Something refers to an entry that is not there.
    #[error("{what} refers to {kind} {index}, of which there are {count}")]
    Dangling {
        /// Who refers.
        what: String,
        /// To what.
        kind: &'static str,
        /// Which one.
        index: u32,
        /// How many there are.
        count: usize,
    },
    /// A number is not finite, or outside its domain.
    #[error("{0}")]
    Value(String),
    /// Materials that contain each other.
    #[error("material {0} contains itself")]
    Cycle(String),
}

/// Nested materials deeper than this are taken for a cycle.
const MAX_NESTING: usize = 16;

fn check_index(what: impl Fn() -> String, kind: &'static str, index: u32, count: usize) -> Result<(), SceneError> {
    if (index as usize) < count { Ok(()) } else { Err(SceneError::Dangling { what: what(), kind, index, count }) }
}

fn require(ok: bool, message: impl Fn() -> String) -> Result<(), SceneError> {
    if ok { Ok(()) } else { Err(SceneError::Value(message())) }
}

impl Material {
    /// Materials this one is made of.
    pub fn children(&self) -> impl Iterator<Item = MaterialId> {
        let pair = match *self {
            Self::TwoSided { front, back } => [Some(front), Some(back)],
            Self::Blend { first, second, .. } => [Some(first), Some(second)],
            Self::Coat { coat: upper, base, .. } | Self::Sheen { fibres: upper, base, .. } => [Some(upper), Some(base)],
            Self::Mask { inner, .. }
            | Self::FrontAlone { inner, .. }
            | Self::NormalMap { inner, .. }
            | Self::BumpMap { inner, .. } => [Some(inner), None],
            Self::Diffuse { .. }
            | Self::Phong { .. }
            | Self::Ward { .. }
            | Self::Lobe { .. }
            | Self::Function { .. }
            | Self::Conductor { .. }
            | Self::RoughConductor { .. }
            | Self::Dielectric { .. }
            | Self::ThinDielectric { .. }
            | Self::RoughDielectric { .. }
            | Self::Glass { .. }
            | Self::Plastic { .. }
            | Self::RoughPlastic { .. }
            | Self::MetallicRoughness { .. }
            | Self::Principled { .. }
            | Self::ClearCoat { .. } => [None, None],
        };
        pair.into_iter().flatten()
    }

    /// Textures this material itself looks up.
    pub fn textures(&self) -> Vec<TextureId> {
        let (colors, floats): (&[&ColorTexture], &[&FloatTexture]) = match self {
            Self::Diffuse { reflectance } => (&[reflectance], &[]),
            Self::Phong { diffuse, specular, exponent } => (&[diffuse, specular], &[exponent]),
            Self::Ward { diffuse, specular, alpha_u, alpha_v, .. } => (&[diffuse, specular], &[alpha_u, alpha_v]),
            Self::Lobe { diffuse, specular, .. }
            | Self::Plastic { diffuse, specular, .. }
            | Self::RoughPlastic { diffuse, specular, .. } => (&[diffuse, specular], &[]),
            Self::Conductor { eta, k, specular } => (&[eta, k, specular], &[]),
            Self::RoughConductor { eta, k, specular, alpha_u, alpha_v, .. } => {
                (&[eta, k, specular], &[alpha_u, alpha_v])
            }
            Self::Dielectric { reflectance, transmittance, .. }
            | Self::ThinDielectric { reflectance, transmittance, .. } => (&[reflectance, transmittance], &[]),
            Self::RoughDielectric { reflectance, transmittance, alpha_u, alpha_v, .. } => {
                (&[reflectance, transmittance], &[alpha_u, alpha_v])
            }
            Self::Glass { base_color, roughness, .. } => (&[base_color], &[roughness]),
            Self::MetallicRoughness { base_color, f0, metallic, roughness, specular, .. } => {
                (&[base_color, f0], &[metallic, roughness, specular])
            }
            Self::Principled { base_color, metallic, roughness, spec_tint, sheen, sheen_tint, .. } => {
                (&[base_color], &[metallic, roughness, spec_tint, sheen, sheen_tint])
            }
            Self::ClearCoat { gloss: share }
            | Self::Mask { opacity: share, .. }
            | Self::Blend { weight: share, .. }
            | Self::Coat { weight: share, .. } => (&[], &[share]),
            Self::Sheen { color, .. } => (&[color], &[]),
            Self::NormalMap { texture, .. } | Self::BumpMap { texture, .. } => return vec![*texture],
            Self::TwoSided { .. } | Self::FrontAlone { .. } | Self::Function { .. } => return Vec::new(),
        };
        colors.iter().filter_map(|c| c.texture()).chain(floats.iter().filter_map(|f| f.texture())).collect()
    }
}

impl Scene {
    /// Checks every index and number.
    ///
    /// # Errors
    /// The first broken promise, in words that name the entry.
    pub fn validate(&self) -> Result<(), SceneError> {
        for (i, m) in self.materials.iter().enumerate() {
            let what = || format!("material {}", self.material_name(i));
            for child in m.children() {
                check_index(what, "material", child.0, self.materials.len())?;
            }
            for texture in m.textures() {
                check_index(what, "texture", texture.0, self.textures.len())?;
            }
            if let Material::Coat { added: true, coat, .. } = m {
                let clear = matches!(self.materials[coat.0 as usize], Material::ClearCoat { .. });
                require(clear, || format!("{}: a coat that is added is a clear coat", what()))?;
            }
            if let Material::Function { function } = m {
                require(function.get().is_some(), || format!("{}: its function is not there", what()))?;
            }
            if let Material::Sheen { fibres, .. } = m {
                let lobe = self.fibres(*fibres).is_some();
                require(lobe, || format!("{}: fibres are the model `sheen`", what()))?;
            }
            if let Material::Blend { .. } | Material::Coat { .. } | Material::Sheen { .. } = m {
                let holes = |m: &Material| matches!(m, Material::Mask { .. } | Material::FrontAlone { .. });
                let masked = m.children().any(|c| holes(&self.materials[c.0 as usize]));
                require(!masked, || format!("{}: a mask inside a blend; put the blend inside the mask", what()))?;
            }
        }
        for i in 0..self.materials.len() {
            self.check_nesting(i, 0)?;
        }
        for (i, texture) in self.textures.iter().enumerate() {
            if let Texture::Bitmap(b) = texture {
                b.check().map_err(|e| SceneError::Value(format!("texture {i}: {e}")))?;
            }
        }
        for (i, shape) in self.shapes.iter().enumerate() {
            self.check_shape(shape, || format!("shape {i}"))?;
        }
        for (g, group) in self.groups.iter().enumerate() {
            for (i, shape) in group.shapes.iter().enumerate() {
                self.check_shape(shape, || format!("shape {i} of group {g}"))?;
                require(shape.emitter.is_none(), || {
                    format!("shape {i} of group {g} emits light, which instances cannot")
                })?;
            }
        }
        for (i, instance) in self.instances.iter().enumerate() {
            check_index(|| format!("instance {i}"), "group", instance.group, self.groups.len())?;
            let inverse = instance.to_world.inverse();
            require(instance.to_world.is_finite() && inverse.is_finite(), || {
                format!("instance {i} has a singular transform")
            })?;
        }
        self.check_lights()?;
        self.check_camera()
    }

    /// The model of fibres behind what wraps it.
    pub(crate) fn fibres(&self, id: MaterialId) -> Option<Fibres> {
        let mut next = Some(id);
        for _ in 0..MAX_NESTING {
            next = match self.materials.get(next?.0 as usize)? {
                Material::Lobe { model: Specular::Sheen(sheen), .. } => return Some(*sheen),
                wrapper => wrapper.children().next(),
            };
        }
        None
    }

    fn material_name(&self, i: usize) -> String {
        self.material_names.get(i).cloned().unwrap_or_else(|| i.to_string())
    }

    fn check_nesting(&self, i: usize, depth: usize) -> Result<(), SceneError> {
        if depth > MAX_NESTING {
            return Err(SceneError::Cycle(self.material_name(i)));
        }
        self.materials[i].children().try_for_each(|c| self.check_nesting(c.0 as usize, depth + 1))
    }

    fn check_shape(&self, shape: &Shape, what: impl Fn() -> String + Copy) -> Result<(), SceneError> {
        check_index(what, "material", shape.material.0, self.materials.len())?;
        if let Some(AreaEmitter { radiance }) = &shape.emitter {
            if let Some(t) = radiance.texture() {
                check_index(what, "texture", t.0, self.textures.len())?;
            }
            let factor = radiance.factor();
            require(factor.is_finite() && factor.min_element() >= 0.0, || {
                format!("{}: emitted radiance must be finite, not negative", what())
            })?;
        }
        match &shape.geometry {
            Geometry::Mesh(m) => {
                let n = m.positions.len();
                for &i in m.triangles.iter().flatten() {
                    check_index(what, "vertex", i, n)?;
                }
                require(m.normals.is_empty() || m.normals.len() == n, || {
                    format!("{}: one normal per position", what())
                })?;
                for uvs in [&m.uvs, &m.second_uvs] {
                    require(uvs.is_empty() || uvs.len() == n, || format!("{}: one uv per position", what()))?;
                }
                require(m.colors.is_empty() || m.colors.len() == n, || format!("{}: one colour per position", what()))?;
                let finite = m.positions.iter().all(|p| p.is_finite())
                    && m.normals.iter().all(|p| p.is_finite())
                    && m.uvs.iter().chain(&m.second_uvs).all(|p| p.is_finite())
                    && m.colors.iter().flatten().all(|c| c.is_finite());
                require(finite, || format!("{}: a vertex is not finite", what()))
            }
            Geometry::Sphere(s) => require(s.radius > 0.0 && s.radius.is_finite() && s.center.is_finite(), || {
                format!("{}: a sphere needs a finite centre and a radius > 0", what())
            }),
        }
    }

    fn check_lights(&self) -> Result<(), SceneError> {
        for (i, light) in self.lights.iter().enumerate() {
            let (at, strength) = match *light {
                Light::Point { position, intensity } | Light::Spot { position, intensity, .. } => (position, intensity),
                Light::Directional { direction, irradiance } => (direction, irradiance),
            };
            require(at.is_finite() && strength.is_finite() && strength.min_element() >= 0.0, || {
                format!("light {i}: position and strength must be finite, strength not negative")
            })?;
        }
        match &self.environment {
            None => Ok(()),
            Some(Environment::Constant(c)) => require(c.is_finite() && c.min_element() >= 0.0, || {
                "environment radiance must be finite and ≥ 0".into()
            }),
            Some(Environment::Map(map)) => {
                map.image.check().map_err(|e| SceneError::Value(format!("environment map: {e}")))?;
                require(map.to_world.is_finite() && map.scale.is_finite() && map.scale >= 0.0, || {
                    "environment map: transform and scale must be finite, scale ≥ 0".into()
                })
            }
        }
    }

    fn check_camera(&self) -> Result<(), SceneError> {
        let (c, film) = (&self.camera, &self.camera.film);
        require(c.to_world.is_finite(), || "the camera's transform is not finite".into())?;
        match c.projection {
            Projection::Perspective { fov_x } => {
                require(fov_x > 0.0 && fov_x < core::f32::consts::PI, || format!("field of view {fov_x} rad"))?;
            }
            Projection::Orthographic { half_width } => {
                let visible = half_width > 0.0 && half_width.is_finite();
                require(visible, || format!("an orthographic camera that is {half_width} wide"))?;
            }
        }
        if let Some(lens) = c.lens {
            let perspective = matches!(c.projection, Projection::Perspective { .. });
            require(perspective, || "an orthographic camera has no lens".into())?;
            let Lens { radius, focus } = lens;
            let lens = Lens::new(radius, focus);
            require(lens.is_some(), || format!("a lens of radius {radius} that is focused at {focus}"))?;
        }
        require(c.near >= 0.0 && c.near < c.far, || format!("clip distances {} … {}", c.near, c.far))?;
        let pixels = u64::from(film.width) * u64::from(film.height);
        require(pixels > 0 && pixels <= 1 << 28, || format!("film of {} × {} pixels", film.width, film.height))?;
        let w = film.window();
        let inside =
            |start: u32, size: u32, whole: u32| size > 0 && u64::from(start) + u64::from(size) <= u64::from(whole);
        require(inside(w.x, w.width, film.width) && inside(w.y, w.height, film.height), || {
            format!("crop {},{} {}×{} leaves the film of {} × {}", w.x, w.y, w.width, w.height, film.width, film.height)
        })
    }
}

impl Bitmap {
    fn check(&self) -> Result<(), &'static str> {
        let expected = u64::from(self.width) * u64::from(self.height);
        if expected == 0 || expected > i32::MAX as u64 || self.texels.len() as u64 != expected {
            return Err("width × height texels needed");
        }
        if self.texels.is_finite() { Ok(()) } else { Err("a texel is not finite") }
    }
}

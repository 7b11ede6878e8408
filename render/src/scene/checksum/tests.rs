//! Each field of a scene, changed one at a time.

use super::super::{
    AreaEmitter, Bitmap, Camera, ColorTexture, Crop, Distribution, Environment, EnvironmentMap, Falloff, Film, Filter,
    FloatTexture, Function, Geometry, Group, Instance, Interpolation, Lens, Light, Material, MaterialId, Mesh,
    Projection, Reading, Reflection, Rgb, Rows, Shape, Sphere, Stored, Texels, Texture, TextureId, Transfer,
    WardVariant, Wrap,
};
use super::*;
use crate::image::{Channels, Raster, Samples};
use brdf_tables::brdf::{Sheen, Specular};
use glam::{Affine2, Affine3A, Mat3A, Vec2, Vec3, Vec3A};
use serde::de::{DeserializeOwned, IntoDeserializer, value::StrDeserializer};
use serde_json::Value;
use std::sync::Arc;

/// A surface that reflects nothing.
#[derive(Debug)]
struct Nothing;

impl Reflection for Nothing {
    fn eval(&self, _: Vec3A, _: Vec3A) -> (Rgb, f32) {
        (Rgb::ZERO, 0.0)
    }

    fn sample(&self, _: Vec3A, _: Vec2) -> Option<Vec3A> {
        None
    }
}

/// Scenes that together hold every variant of every type.
fn scenes() -> Vec<Scene> {
    let c = |x: f32| ColorTexture::Constant(Rgb::new(x, 0.5 * x, 0.25 * x));
    let f = FloatTexture::Constant;
    let (id, texture) = (MaterialId, TextureId);
    let scaled = ColorTexture::Scaled(texture(1), Rgb::new(0.5, 0.25, 0.75));
    let bitmap = |texels| Bitmap {
        width: 2,
        height: 1,
        texels,
        wrap: [Wrap::Repeat, Wrap::Clamp],
        second_uv: false,
        interpolation: Interpolation::Nearest,
        to_uv: Affine2::from_scale(Vec2::new(2.0, 3.0)),
    };
    let gray = bitmap(Texels::Gray(vec![0.25, 0.75]));
    let rgb = bitmap(Texels::Rgb(vec![[0.1, 0.2, 0.3], [0.4, 0.5, 0.6]]));
    let stored = |channels, samples, reading, transfer| {
        let raster = Raster { width: 2, height: 1, channels, samples };
        Texture::Bitmap(bitmap(Texels::Stored(Stored::new(raster.into(), reading, transfer))))
    };
    let (alpha_u, alpha_v) = (f(0.1), FloatTexture::Scaled(texture(0), 0.5));
    let (distribution, eta, nonlinear) = (Distribution::Ggx, 1.5, false);
    let (reflectance, transmittance, diffuse, specular) = (c(0.9), c(0.8), c(0.3), c(0.4));
    let materials = vec![
        Material::Diffuse { reflectance: scaled },
        Material::Phong { diffuse, specular, exponent: f(30.0) },
        Material::Ward { variant: WardVariant::Ward, diffuse, specular, alpha_u, alpha_v },
        Material::Lobe { diffuse, specular, model: Specular::Sheen(Sheen { alpha: 0.5 }) },
        Material::Function { function: Function::new(7, Arc::new(Nothing)) },
        Material::Conductor { eta: c(1.0), k: c(2.0), specular },
        Material::RoughConductor { distribution, alpha_u, alpha_v, eta: c(1.0), k: c(2.0), specular },
        Material::Dielectric { eta, reflectance, transmittance },
        Material::ThinDielectric { eta, reflectance, transmittance },
        Material::RoughDielectric { distribution, alpha_u, alpha_v, eta, reflectance, transmittance },
        Material::Glass {
            base_color: c(0.7),
            crossings: 2,
            roughness: f(0.1),
            eta,
            sheet: false,
            absorption: Rgb::new(0.1, 0.2, 0.3),
        },
        Material::Plastic { eta, diffuse, specular, nonlinear },
        Material::RoughPlastic { distribution, alpha: 0.2, eta, diffuse, specular, nonlinear },
        Material::MetallicRoughness {
            base_color: ColorTexture::Texture(texture(0)),
            metallic: FloatTexture::Texture(texture(0)),
            roughness: f(0.5),
            f0: ColorTexture::Painted(None, Rgb::splat(0.04)),
            specular: FloatTexture::Painted(Some(texture(0)), 0.5),
            layered: Some(eta),
        },
        Material::TwoSided { front: id(0), back: id(1) },
        Material::Mask { opacity: f(0.5), inner: id(0) },
        Material::Principled {
            base_color: c(0.1),
            metallic: f(0.5),
            roughness: f(0.4),
            anisotropic: 0.3,
            eta,
            spec_tint: f(0.1),
            sheen: f(0.2),
            sheen_tint: f(0.6),
        },
        Material::ClearCoat { gloss: f(0.5) },
        Material::FrontAlone { inner: id(0), hidden: true },
        Material::NormalMap { texture: texture(0), scale: 1.0, raised: true, inner: id(0) },
        Material::BumpMap { texture: texture(0), scale: 1.0, inner: id(0) },
        Material::Coat { added: false, weight: FloatTexture::PaintedStep(None, 0.5), coat: id(0), base: id(1) },
        Material::Sheen { color: c(0.5), fibres: id(3), base: id(1) },
        Material::Blend { weight: f(0.5), first: id(0), second: id(1) },
    ];
    let mesh = Mesh {
        triangles: vec![[0, 1, 2]],
        positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
        normals: vec![Vec3::Z; 3],
        uvs: vec![Vec2::ZERO, Vec2::X, Vec2::Y],
        second_uvs: vec![Vec2::ZERO, Vec2::X, Vec2::Y],
        colors: vec![[0.25, 0.5, 0.75, 1.0]; 3],
    };
    let sphere = Sphere { center: Vec3A::Y, radius: 2.0, rotation: Mat3A::IDENTITY, inward: false };
    let shape = |geometry, emitter| Shape { geometry, material: id(3), emitter };
    let position = Vec3A::new(1.0, 2.0, 3.0);
    let spot =
        |falloff| Light::Spot { position, direction: Vec3A::Z, intensity: Rgb::ONE, beam: 0.2, cutoff: 0.3, falloff };
    let one = Scene {
        shapes: vec![
            shape(Geometry::Mesh(mesh.clone()), Some(AreaEmitter { radiance: c(5.0) })),
            shape(Geometry::Sphere(sphere), None),
        ],
        groups: vec![Group { shapes: vec![shape(Geometry::Mesh(mesh), None)] }],
        instances: vec![Instance { group: 0, to_world: Affine3A::IDENTITY }],
        material_names: vec!["wall".into(); materials.len()],
        materials,
        textures: vec![
            Texture::Bitmap(gray.clone()),
            Texture::Bitmap(rgb.clone()),
            Texture::Checkerboard { color0: Rgb::ZERO, color1: Rgb::ONE, to_uv: Affine2::IDENTITY },
            stored(Channels::Gray, Samples::U8(vec![1, 2]), Reading::Color, Transfer::Srgb),
            stored(Channels::GrayAlpha, Samples::U16(vec![1, 2, 3, 4]), Reading::Step(0.5), Transfer::Linear),
            stored(Channels::Rgb, Samples::U8(vec![1, 2, 3, 4, 5, 6]), Reading::Luminance, Transfer::Gamma(2.0)),
            stored(Channels::Rgba, Samples::Half(vec![1, 2, 3, 4, 5, 6, 7, 8]), Reading::Channel(1), Transfer::Linear),
            stored(Channels::Rgb, Samples::F32(vec![0.5; 6]), Reading::Normal, Transfer::Linear),
        ],
        lights: vec![
            Light::Point { position, intensity: Rgb::ONE },
            spot(Falloff::Linear),
            spot(Falloff::Cosine),
            spot(Falloff::Smooth),
            Light::Directional { direction: Vec3A::Z, irradiance: Rgb::ONE },
        ],
        environment: Some(Environment::Map(EnvironmentMap {
            image: rgb,
            to_world: Mat3A::IDENTITY,
            scale: 2.0,
            rows: Rows::Bands,
        })),
        camera: Camera {
            film: Film {
                width: 32,
                height: 16,
                crop: Some(Crop { x: 1, y: 2, width: 3, height: 4 }),
                filter: Filter::Gaussian { stddev: 0.5 },
            },
            lens: Some(Lens { radius: 0.1, focus: 2.0 }),
            ..Camera::default()
        },
        integrator: IntegratorSettings { max_depth: 5, ..IntegratorSettings::default() },
    };
    let with = |projection, filter, environment| {
        let film = Film { filter, ..one.camera.film.clone() };
        let camera = Camera { projection, film, ..one.camera.clone() };
        Scene { camera, environment, ..one.clone() }
    };
    let parallel = Projection::Orthographic { half_width: 2.0 };
    let constant = Some(Environment::Constant(Rgb::ONE));
    let two = with(parallel, Filter::Box { radius: 0.5 }, constant);
    let three = with(one.camera.projection, Filter::Tent { radius: 1.0 }, None);
    vec![one, two, three]
}

/// The names of an enumeration's variants, from what it says of a name that it does not know.
#[derive(Debug)]
struct Variants(&'static [&'static str]);

impl std::fmt::Display for Variants {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        write!(f, "{:?}", self.0)
    }
}

impl std::error::Error for Variants {}

impl serde::de::Error for Variants {
    fn custom<T: std::fmt::Display>(_: T) -> Self {
        Self(&[])
    }

    fn unknown_variant(_: &str, expected: &'static [&'static str]) -> Self {
        Self(expected)
    }
}

fn variants<T: DeserializeOwned>() -> &'static [&'static str] {
    let name: StrDeserializer<Variants> = "?".into_deserializer();
    T::deserialize(name).err().map_or(&[], |e| e.0)
}

/// Variants of the types that have some without fields, which a scene's encoding writes as words.
fn words() -> Vec<&'static str> {
    [
        variants::<Channels>(),
        variants::<Reading>(),
        variants::<Transfer>(),
        variants::<Distribution>(),
        variants::<WardVariant>(),
        variants::<Wrap>(),
        variants::<Interpolation>(),
        variants::<Rows>(),
        variants::<Falloff>(),
    ]
    .concat()
}

/// Pointers to all values of an encoding that hold no others.
fn leaves(value: &Value, at: String, found: &mut Vec<String>) {
    match value {
        Value::Object(fields) => fields.iter().for_each(|(name, v)| leaves(v, format!("{at}/{name}"), found)),
        Value::Array(items) => items.iter().enumerate().for_each(|(i, v)| leaves(v, format!("{at}/{i}"), found)),
        // Nothing to change: another scene has something there.
        Value::Null => {}
        _ => found.push(at),
    }
}

/// The scene with one leaf changed.
fn changed(encoding: &Value, at: &str) -> Scene {
    let candidates = match encoding.pointer(at).unwrap() {
        Value::Bool(x) => vec![Value::Bool(!x)],
        Value::Number(x) if x.is_f64() => vec![(x.as_f64().unwrap() + 0.125).into()],
        Value::Number(x) => vec![x.as_u64().unwrap().wrapping_sub(1).into(), (x.as_u64().unwrap() + 1).into()],
        Value::String(name) if at.starts_with("/material_names") => vec![Value::String(name.clone() + "s")],
        other => words().into_iter().map(Value::from).filter(|v| v != other).collect(),
    };
    let scene = |candidate| {
        let mut encoding = encoding.clone();
        *encoding.pointer_mut(at).unwrap() = candidate;
        serde_json::from_value(encoding).ok()
    };
    candidates.into_iter().find_map(scene).unwrap_or_else(|| panic!("{at} cannot be changed"))
}

#[test]
fn every_field_counts() {
    let mut count = 0;
    for scene in scenes() {
        let encoding = serde_json::to_value(&scene).unwrap();
        let before = Checksums::new(&scene);
        assert_eq!(Checksums::new(&serde_json::from_value(encoding.clone()).unwrap()), before, "a copy is the same");
        let mut found = Vec::new();
        leaves(&encoding, String::new(), &mut found);
        for at in &found {
            let after = Checksums::new(&changed(&encoding, at));
            let differs =
                (after.geometry != before.geometry, after.materials != before.materials, after.camera != before.camera);
            let part = at.split('/').nth(1).unwrap();
            let expected = match (part, at.as_str()) {
                // What changes no light.
                ("material_names", _) | (_, "/integrator/spp") => (false, false, false),
                // What leaves records useful, but asks for more of them.
                ("camera", _) | (_, "/integrator/hide_emitters" | "/integrator/hide_environment") => {
                    (false, false, true)
                }
                ("materials" | "textures", _) => (false, true, false),
                _ => (true, false, false),
            };
            assert_eq!(differs, expected, "{at}");
        }
        count += found.len();
    }
    assert!(count > 500, "{count} fields");
}

/// The scenes above leave no variant out.
#[test]
fn every_variant_is_there() {
    let mut text = String::new();
    for scene in scenes() {
        text += &serde_json::to_string(&scene).unwrap();
    }
    let kinds = [
        variants::<Material>(),
        variants::<Texture>(),
        variants::<Texels>(),
        variants::<Samples>(),
        variants::<ColorTexture>(),
        variants::<FloatTexture>(),
        variants::<Light>(),
        variants::<Environment>(),
        variants::<Geometry>(),
        variants::<Projection>(),
        variants::<Filter>(),
    ];
    for kind in kinds {
        assert!(kind.len() > 1);
        for variant in kind {
            assert!(text.contains(&format!("\"{variant}\":")), "{variant}");
        }
    }
    for word in [variants::<Channels>(), variants::<Reading>(), variants::<Transfer>()].concat() {
        assert!(text.contains(&format!("\"{word}\"")), "{word}");
    }
    assert_eq!(words().len(), 26);
}

/// Numbers that move from one list to another do not cancel out.
#[test]
fn what_is_moved_counts() {
    let one = scenes().swap_remove(0);
    let checksum = |change: &dyn Fn(&mut Scene)| {
        let mut scene = one.clone();
        change(&mut scene);
        Checksums::new(&scene)
    };
    let before = checksum(&|_| ());
    assert_ne!(checksum(&|s| s.shapes.swap(0, 1)).geometry, before.geometry);
    assert_ne!(checksum(&|s| s.environment = None).geometry, before.geometry);
    assert_ne!(checksum(&|s| s.textures.swap(0, 2)).materials, before.materials);
    let face_normals = |s: &mut Scene| {
        if let Geometry::Mesh(mesh) = &mut s.shapes[0].geometry {
            mesh.normals.clear();
        }
    };
    assert_ne!(checksum(&face_normals).geometry, before.geometry);
}

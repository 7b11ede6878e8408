//! glTF, good, damaged and hostile.

use crate::{Folder, Loaded};
use base64::Engine;
use glam::Vec3A;
use render::scene::*;
use serde_json::{Value, json};
use std::f32::consts::FRAC_1_SQRT_2 as HALF;

/// Two triangles with normals and texture coordinates: 4 × 12, 4 × 12, 4 × 8 bytes, 6 × 2 bytes of indices.
pub fn buffer() -> Vec<u8> {
    let corners = [[-1f32, -1.], [1., -1.], [1., 1.], [-1., 1.]];
    let positions = corners.iter().flat_map(|c| [c[0], c[1], 0.0]);
    let normals = corners.iter().flat_map(|_| [0.0, 0.0, 1.0]);
    let uvs = corners.iter().flat_map(|c| [(c[0] + 1.0) / 2.0, (1.0 - c[1]) / 2.0]);
    let mut out: Vec<u8> = positions.chain(normals).chain(uvs).flat_map(f32::to_le_bytes).collect();
    out.extend([0u16, 1, 2, 0, 2, 3].iter().flat_map(|i| i.to_le_bytes()));
    out
}

/// A red-green image of 2 × 1 pixels.
pub fn png() -> Vec<u8> {
    let image = image::RgbaImage::from_fn(2, 1, |x, _| {
        if x == 0 { image::Rgba([255, 128, 0, 255]) } else { image::Rgba([0, 128, 255, 51]) }
    });
    let mut out = std::io::Cursor::new(Vec::new());
    image.write_to(&mut out, image::ImageFormat::Png).unwrap();
    out.into_inner()
}

pub fn data_uri(mime: &str, bytes: &[u8]) -> String {
    format!("data:{mime};base64,{}", base64::engine::general_purpose::STANDARD.encode(bytes))
}

/// As Blender writes it: a square drawn twice, a lamp, a camera, a point light, a sun, a spot.
pub fn document() -> Value {
    json!({
        "asset": {"version": "2.0", "generator": "by hand"},
        "extensionsUsed": ["KHR_lights_punctual", "KHR_materials_emissive_strength", "KHR_materials_transmission"],
        "extensions": {"KHR_lights_punctual": {"lights": [
            {"type": "point", "color": [1, 0.5, 0], "intensity": 683.0},
            {"type": "directional", "intensity": 1366.0},
            {"type": "spot", "intensity": 683.0, "spot": {"innerConeAngle": 0.2, "outerConeAngle": 0.4}},
        ]}},
        "scene": 0,
        "scenes": [{"nodes": [0, 1, 2, 3, 4, 5, 6]}],
        "nodes": [
            {"mesh": 0},
            {"mesh": 0, "translation": [0, 0, -5], "scale": [2, 2, 2]},
            {"mesh": 1, "translation": [0, 3, 0], "rotation": [HALF, 0, 0, HALF]},
            {"camera": 0, "translation": [0, 0, 10]},
            {"translation": [1, 2, 3], "extensions": {"KHR_lights_punctual": {"light": 0}}},
            {"rotation": [-HALF, 0, 0, HALF], "extensions": {"KHR_lights_punctual": {"light": 1}}},
            {"extensions": {"KHR_lights_punctual": {"light": 2}}},
        ],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 0.6, "aspectRatio": 1.5, "znear": 0.1, "zfar": 100}}],
        "meshes": [
            {"name": "square", "primitives": [{
                "attributes": {"POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2}, "indices": 3, "material": 0}]},
            {"name": "lamp", "primitives": [{"attributes": {"POSITION": 0}, "indices": 3, "material": 1}]},
        ],
        "materials": [
            {"name": "painted", "doubleSided": true, "alphaMode": "MASK", "alphaCutoff": 0.5,
             "normalTexture": {"index": 0, "scale": 0.5},
             "pbrMetallicRoughness": {
                "baseColorTexture": {"index": 0}, "baseColorFactor": [0.5, 1, 1, 1],
                "metallicRoughnessTexture": {"index": 0}, "roughnessFactor": 0.8}},
            {"name": "glow", "emissiveFactor": [1, 1, 0.5],
             "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 10}},
             "pbrMetallicRoughness": {"metallicFactor": 0}},
        ],
        "textures": [{"source": 0, "sampler": 0}],
        "samplers": [{"magFilter": 9728, "wrapS": 33071, "wrapT": 33071}],
        "images": [{"uri": data_uri("image/png", &png())}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [-1, -1, 0], "max": [1, 1, 0]},
            {"bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC3"},
            {"bufferView": 2, "componentType": 5126, "count": 4, "type": "VEC2"},
            {"bufferView": 3, "componentType": 5123, "count": 6, "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": 48},
            {"buffer": 0, "byteOffset": 48, "byteLength": 48},
            {"buffer": 0, "byteOffset": 96, "byteLength": 32},
            {"buffer": 0, "byteOffset": 128, "byteLength": 12},
        ],
        "buffers": [{"byteLength": 140, "uri": data_uri("application/octet-stream", &buffer())}],
    })
}

pub fn load(document: &Value) -> Loaded {
    Folder::new().with("s.gltf", document.to_string()).load("s.gltf", &[])
}

/// Half the width of the film at unit depth.
fn half_width(camera: &Camera) -> f32 {
    let Projection::Perspective { fov_x } = camera.projection else { panic!("{camera:?}") };
    (fov_x / 2.0).tan()
}

/// The binary form; `json` padded with blanks.
fn glb(document: &Value, blob: &[u8]) -> Vec<u8> {
    let mut text = document.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut out = b"glTF".to_vec();
    out.extend(2u32.to_le_bytes());
    out.extend((12 + 8 + text.len() as u32 + 8 + blob.len() as u32).to_le_bytes());
    out.extend((text.len() as u32).to_le_bytes());
    out.extend(b"JSON");
    out.extend(text);
    out.extend((blob.len() as u32).to_le_bytes());
    out.extend(b"BIN\0");
    out.extend(blob);
    out
}

#[test]
fn an_export_as_blender_writes_it() {
    let (scene, warnings) = load(&document()).unwrap();
    assert!(warnings.is_empty(), "{warnings:#?}");
    // The square, drawn twice, is a group; the lamp, which emits, a shape.
    assert_eq!((scene.groups.len(), scene.instances.len(), scene.shapes.len()), (1, 2, 1));
    assert_eq!(scene.instances[1].to_world.translation, Vec3A::new(0.0, 0.0, -5.0));
    assert_eq!(scene.shapes[0].emitter.as_ref().unwrap().radiance, ColorTexture::Constant(Vec3A::new(10., 10., 5.)));
    let Geometry::Mesh(lamp) = &scene.shapes[0].geometry else { panic!() };
    assert!(lamp.normals.is_empty() && lamp.positions.iter().all(|p| (p.y - 3.0).abs() < 1e-5));
    // Looking along −z with y up, x to the right.
    let camera = &scene.camera;
    assert_eq!((camera.film.width, camera.film.height), (1080, 720));
    assert!((camera.to_world.transform_vector3a(Vec3A::Z) + Vec3A::Z).length() < 1e-6);
    assert!((camera.to_world.transform_vector3a(Vec3A::X) + Vec3A::X).length() < 1e-6);
    assert!((half_width(camera) / 0.3f32.tan() - 1.5).abs() < 1e-5);
    assert_eq!(scene.lights[0], Light::Point { position: Vec3A::new(1., 2., 3.), intensity: Vec3A::new(1., 0.5, 0.) });
    assert!(matches!(scene.lights[1], Light::Directional { direction, irradiance }
        if (direction + Vec3A::Y).length() < 1e-5 && irradiance == Vec3A::splat(2.0)));
    assert!(
        matches!(scene.lights[2], Light::Spot { beam: 0.2, cutoff: 0.4, direction, .. } if direction == Vec3A::NEG_Z)
    );
}

#[test]
fn materials_and_textures() {
    let (scene, _) = load(&document()).unwrap();
    let id = scene.groups[0].shapes[0].material;
    let Material::Mask { opacity: FloatTexture::Texture(alpha), inner } = scene.materials[id.0 as usize] else {
        panic!()
    };
    let Material::TwoSided { front, .. } = scene.materials[inner.0 as usize] else { panic!() };
    let Material::NormalMap { texture: normal, scale: 0.5, raised: true, inner } = scene.materials[front.0 as usize]
    else {
        panic!()
    };
    let Material::MetallicRoughness { base_color, metallic, roughness, f0, specular, .. } =
        &scene.materials[inner.0 as usize]
    else {
        panic!()
    };
    let at = |u: f32| Coordinates::from(glam::Vec2::new(u, 0.5));
    let t = &scene.textures;
    assert!((base_color.eval(t, &at(0.2)) - Vec3A::new(0.5, 0.2159, 0.0)).abs().max_element() < 1e-3);
    assert!((roughness.eval(t, &at(0.2)) - 0.8 * 0.502).abs() < 1e-3 && metallic.eval(t, &at(0.7)) == 1.0);
    assert!((f0.factor() - Vec3A::splat(0.04)).abs().max_element() < 1e-6);
    assert_eq!(*specular, FloatTexture::Constant(1.0));
    assert_eq!((t[alpha.0 as usize].eval(&at(0.2)).x, t[alpha.0 as usize].eval(&at(0.7)).x), (1.0, 0.0));
    // Green points up in glTF and v down in this crate.
    assert!((t[normal.0 as usize].eval(&at(0.2)).y - 127.0 / 255.0).abs() < 1e-3);
    let Texture::Bitmap(bitmap) = &t[0] else { panic!() };
    assert_eq!((bitmap.wrap, bitmap.interpolation), ([Wrap::Clamp; 2], Interpolation::Nearest));
}

/// Colour, opacity, normals, metal and roughness of one image: its bytes are there once.
#[test]
fn textures_of_one_image_share_it() {
    let (scene, _) = load(&document()).unwrap();
    let images: Vec<_> = scene
        .textures
        .iter()
        .map(|texture| match texture {
            Texture::Bitmap(Bitmap { texels: Texels::Stored(stored), .. }) => stored.raster(),
            other => panic!("{other:?}"),
        })
        .collect();
    assert_eq!(images.len(), 5);
    assert!(images.iter().all(|image| std::sync::Arc::ptr_eq(image, images[0])));
    assert_eq!(images[0].samples.bytes(), 4 * 2);
}

#[test]
fn glass_and_transforms_of_textures() {
    let mut d = document();
    d["materials"][0] = json!({"extensions": {"KHR_materials_transmission": {"transmissionFactor": 1}},
        "pbrMetallicRoughness": {"roughnessFactor": 0, "baseColorTexture": {"index": 0, "extensions":
            {"KHR_texture_transform": {"offset": [0.5, 0.25], "rotation": 1.5707964, "scale": [2, 4]}}}}});
    let (scene, _) = load(&d).unwrap();
    assert!(scene.materials.iter().any(|m| matches!(m, Material::Glass { eta: 1.5, sheet: true, .. })));
    let Texture::Bitmap(bitmap) = &scene.textures[0] else { panic!() };
    // A quarter turn counter-clockwise, v down: u becomes −v.
    let p = bitmap.to_uv.transform_point2(glam::Vec2::X);
    assert!((p - glam::Vec2::new(0.5, 0.25 - 2.0)).length() < 1e-5, "{p}");
}

#[test]
fn binary_files_and_files_beside() {
    let mut d = document();
    d["buffers"][0].as_object_mut().unwrap().remove("uri");
    let file = glb(&d, &buffer());
    let reference = load(&document()).unwrap().0;
    let (scene, _) = Folder::new().with("s.glb", &file).load("s.glb", &[]).unwrap();
    assert_eq!((scene.shapes, scene.groups), (reference.shapes, reference.groups));
    d["buffers"][0]["uri"] = "my%20data.bin".into();
    d["images"][0]["uri"] = "t.png".into();
    let folder = Folder::new().with("s.gltf", d.to_string()).with("my data.bin", buffer());
    assert!(folder.load("s.gltf", &[]).unwrap_err().starts_with("t.png: cannot read: "));
    folder.with("t.png", png()).load("s.gltf", &[]).unwrap();
}

#[test]
fn every_mode_of_triangles() {
    let count = |mode: u32| {
        let mut d = document();
        d["meshes"][1]["primitives"][0]["mode"] = mode.into();
        load(&d).map(|(s, warnings)| (s.shapes.len(), warnings.len()))
    };
    // 0 1 2 0 2 3 as a strip or fan has triangles without area, of which the warning tells.
    assert_eq!((count(4).unwrap(), count(5).unwrap(), count(6).unwrap()), ((1, 0), (1, 1), (1, 1)));
    assert_eq!(count(1).unwrap(), (0, 1));
}

#[test]
fn attributes_of_an_application_are_skipped_and_darkness_is_announced() {
    let mut d = document();
    d["meshes"][0]["primitives"][0]["attributes"]["_weight"] = 2.into();
    assert!(load(&d).unwrap().1.is_empty());
    d["scenes"][0]["nodes"] = json!([0, 3]);
    let (_, warnings) = load(&d).unwrap();
    assert!(warnings.len() == 1 && warnings[0].contains("gives off light"), "{warnings:?}");
}

#[test]
fn without_a_camera_everything_is_in_the_picture() {
    let mut d = document();
    d["nodes"][3].as_object_mut().unwrap().remove("camera");
    let (scene, warnings) = load(&d).unwrap();
    assert!(warnings[0].contains("no camera"), "{warnings:?}");
    let to_camera = scene.camera.to_world.inverse();
    for instance in &scene.instances {
        let p = to_camera.transform_point3a(instance.to_world.translation);
        assert!(p.z > 0.0 && (p.x / p.z).abs() < half_width(&scene.camera), "{p}");
    }
}

#[test]
fn orthographic_cameras() {
    let mut d = document();
    d["cameras"][0] =
        json!({"type": "orthographic", "orthographic": {"xmag": 3.0, "ymag": 2.0, "znear": 0.0, "zfar": 50.0}});
    let (scene, warnings) = load(&d).unwrap();
    assert!(warnings.is_empty(), "{warnings:#?}");
    let camera = scene.camera;
    assert_eq!(camera.projection, Projection::Orthographic { half_width: 3.0 });
    assert_eq!((camera.film.width, camera.film.height, camera.near, camera.far), (1080, 720, 0.0, 50.0));
    assert!((camera.to_world.transform_vector3a(Vec3A::Z) + Vec3A::Z).length() < 1e-6);
    d["cameras"][0]["orthographic"]["ymag"] = json!(1e-9);
    assert!(load(&d).unwrap_err().contains("camera 0: a view of"));
}

/// A buffer after the first holds what a sparse accessor replaces: the second corner, and with it a normal.
fn sparse(indices: &[u8], component: u32) -> Value {
    let mut bytes = indices.to_vec();
    bytes.resize(bytes.len().next_multiple_of(4), 0);
    let values = bytes.len();
    bytes.extend([5f32, 6.0, 7.0].iter().flat_map(|x| x.to_le_bytes()));
    let mut d = document();
    let buffers = d["buffers"].as_array_mut().unwrap();
    buffers.push(json!({"byteLength": bytes.len(), "uri": data_uri("application/octet-stream", &bytes)}));
    let views = d["bufferViews"].as_array_mut().unwrap();
    views.push(json!({"buffer": 1, "byteLength": indices.len()}));
    views.push(json!({"buffer": 1, "byteOffset": values, "byteLength": 12}));
    d["accessors"][0]["sparse"] = json!({"count": 1,
        "indices": {"bufferView": 4, "componentType": component}, "values": {"bufferView": 5}});
    d
}

#[test]
fn sparse_accessors() {
    let positions = |d: &Value| {
        let (scene, warnings) = load(d).unwrap();
        assert!(warnings.is_empty(), "{warnings:#?}");
        let Geometry::Mesh(mesh) = &scene.groups[0].shapes[0].geometry else { panic!() };
        mesh.positions.clone()
    };
    let plain = positions(&document());
    for (indices, component) in [(&[1u8][..], 5121), (&[1, 0], 5123), (&[1, 0, 0, 0], 5125)] {
        let replaced = positions(&sparse(indices, component));
        assert_eq!(replaced[1], glam::Vec3::new(5.0, 6.0, 7.0));
        assert_eq!((replaced[0], &replaced[2..]), (plain[0], &plain[2..]));
    }
    // Without a view of its own, everything else is zero.
    let mut d = sparse(&[1], 5121);
    d["accessors"][1] = d["accessors"][0].take();
    d["accessors"][1].as_object_mut().unwrap().remove("bufferView");
    d["accessors"][0] = document()["accessors"][0].take();
    let (scene, _) = load(&d).unwrap();
    let Geometry::Mesh(mesh) = &scene.groups[0].shapes[0].geometry else { panic!() };
    let n = glam::Vec3::new(5.0, 6.0, 7.0).normalize();
    assert!((mesh.normals[1] - n).length() < 1e-6, "{:?}", mesh.normals);
    // Damage.
    assert!(load(&sparse(&[4], 5121)).unwrap_err().contains("accessor 0: a sparse index of 4"));
    for (pointer, value, what) in [
        ("/accessors/0/sparse/count", json!(2), "accessor 0: its sparse indices leave"),
        ("/accessors/0/sparse/count", json!(u64::MAX), "accessor 0: its sparse"),
        ("/accessors/0/sparse/indices/bufferView", json!(77), ""),
        ("/accessors/0/sparse/values/bufferView", json!(4), "accessor 0: its sparse values leave"),
    ] {
        let mut d = sparse(&[1], 5121);
        *d.pointer_mut(pointer).unwrap() = value;
        let e = load(&d).expect_err(pointer);
        assert!(e.contains(what), "{pointer}: {e}");
    }
    let mut d = sparse(&[1], 5121);
    d["accessors"][0].as_object_mut().unwrap().remove("bufferView");
    d["accessors"][0]["count"] = json!(1u64 << 60);
    assert!(load(&d).unwrap_err().contains("accessor 0: 1152921504606846976 elements"));
}

#[test]
fn damage_is_named() {
    for (pointer, value, what) in [
        ("/accessors/0/count", json!(5), "accessor 0: its elements leave their buffer view"),
        ("/accessors/0/count", json!(1u64 << 60), "accessor 0: its elements leave"),
        ("/accessors/0/byteOffset", json!(1u64 << 62), "accessor 0: its elements leave"),
        ("/accessors/1/count", json!(3), "attributes of different length"),
        ("/accessors/3/bufferView", json!(9), ""),
        ("/bufferViews/0/byteLength", json!(1000), "buffer view 0 leaves its buffer"),
        ("/bufferViews/0/byteOffset", json!(u64::MAX), ""),
        ("/buffers/0/byteLength", json!(141), "buffer 0: 140 bytes, but 141 are promised"),
        ("/buffers/0/uri", json!("data:,xyz"), "buffer 0: 3 bytes, but 140 are promised"),
        ("/buffers/0/uri", json!("data:;base64"), "buffer 0: a data URI without a comma"),
        ("/buffers/0/uri", json!("https://example.org/a.bin"), "a file of the network (https) is not fetched"),
        ("/images/0/uri", json!(null), "image 0: neither a file nor a buffer view"),
        ("/textures/0/source", json!(null), ""),
        ("/buffers/0/uri", json!("data:;base64,###"), "a data URI"),
        ("/buffers/0/uri", json!("gone.bin"), "gone.bin: cannot read"),
        ("/images/0/uri", json!("data:;base64,AAAA"), "image 0"),
        ("/meshes/0/primitives/0/attributes/POSITION", json!(99), "missing accessor"),
        ("/meshes/0/primitives/0/indices", json!(0), "accessor 0: 1 numbers per element are needed, not (Vec3, F32)"),
        ("/meshes/0/primitives/0/material", json!(7), ""),
        ("/nodes/0/children", json!([0]), "endless"),
        ("/nodes/0/mesh", json!(5), ""),
        ("/nodes/0/scale", json!([1e39, 1, 1]), ""),
        ("/nodes/3/scale", json!([1, 0, 1]), "camera 0: its transform is singular"),
        ("/cameras/0/perspective/yfov", json!(0), ""),
        ("/materials/1/emissiveFactor", json!([-1, 0, 0]), ""),
        ("/scenes", json!([]), ""),
        ("/extensionsRequired", json!(["KHR_draco_mesh_compression"]), "KHR_draco_mesh_compression is required"),
        ("/asset", json!({}), ""),
        ("/asset", json!({"version": "1.0"}), "glTF of version 1.0: only 2.x is read"),
        ("/asset", json!(format!("data:;base64,{}", "A".repeat(10_000))), "s.gltf:"),
        ("/cameras/0", json!({"type": "perspective"}), "camera 0: its projection is missing"),
        ("/extensions/KHR_lights_punctual/lights/2/spot", json!(null), "light 2: its cones are missing"),
        ("/nodes/4/extensions/KHR_lights_punctual/light", json!(3), "node 4: its light is missing"),
    ] {
        let mut d = document();
        match pointer {
            "/extensionsRequired" => d["extensionsRequired"] = value,
            "/nodes/0/scale" => d["nodes"][0]["scale"] = value,
            "/nodes/3/scale" => d["nodes"][3]["scale"] = value,
            "/nodes/0/children" => d["nodes"][0]["children"] = value,
            "/accessors/0/byteOffset" => d["accessors"][0]["byteOffset"] = value,
            _ => *d.pointer_mut(pointer).unwrap() = value,
        }
        let e = load(&d).expect_err(pointer);
        assert!(e.contains(what) && e.len() < 600, "{pointer}: {e}");
    }
    let e = Folder::new().with("s.gltf", "{}").load("s.gltf", &[("w", "1")]).unwrap_err();
    assert_eq!(e, "s.gltf: -D w: glTF scenes have no parameters");
}

#[test]
fn truncated_and_mutated_binary_files_never_panic() {
    let mut d = document();
    d["buffers"][0].as_object_mut().unwrap().remove("uri");
    let file = glb(&d, &buffer());
    let load = |bytes: &[u8]| Folder::new().with("s.glb", bytes).load("s.glb", &[]);
    for length in (0..64).chain((64..file.len()).step_by(97)) {
        load(&file[..length]).expect_err("truncated");
    }
    let mut damaged = file.clone();
    damaged[8..12].copy_from_slice(&3u32.to_le_bytes());
    load(&damaged).expect_err("a length below that of the header");
    // A deterministic sequence of damaged bytes.
    let mut state = 1u64;
    for _ in 0..300 {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        let mut damaged = file.clone();
        damaged[(state >> 33) as usize % file.len()] = (state >> 20) as u8;
        load(&damaged).ok();
    }
}

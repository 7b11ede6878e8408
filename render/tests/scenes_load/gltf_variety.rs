//! glTF as others write it: containers, what is wrong and does no harm, poses, extensions.

use crate::Folder;
use crate::gltf::{buffer, data_uri, document, load, png};
use glam::Vec3A;
use render::scene::{FloatTexture, Geometry, Material, Mesh, Shape, Texture, load};
use serde_json::{Value, json};
use std::f32::consts::FRAC_1_SQRT_2 as HALF;

#[test]
fn containers_as_they_come() {
    let mut d = document();
    d["buffers"][0].as_object_mut().unwrap().remove("uri");
    let chunks = |chunks: &[(&[u8; 4], &[u8])]| {
        let mut out = b"glTF\x02\0\0\0\0\0\0\0".to_vec();
        for (kind, bytes) in chunks {
            out.extend((bytes.len() as u32).to_le_bytes());
            out.extend(*kind);
            out.extend(*bytes);
        }
        let length = out.len() as u32;
        out[8..12].copy_from_slice(&length.to_le_bytes());
        out
    };
    let text = d.to_string().into_bytes();
    let with = |before: &[u8], after: &[u8]| [before, &text, after].concat();
    let own = document().to_string();
    for (name, file) in [
        ("s.glb", chunks(&[(b"JSON", &with(b"", b"\0\0\0")), (b"BIN\0", &buffer())])),
        ("s.glb", chunks(&[(b"JSON", &with(b"\xef\xbb\xbf", b" \n")), (b"BIN\0", &buffer())])),
        ("s.glb", chunks(&[(b"JSON", &text), (b"XTRA", b"abc"), (b"BIN\0", &buffer()), (b"BIN\0", b"")])),
        ("s.glb", [chunks(&[(b"JSON", &text), (b"BIN\0", &buffer())]), vec![0; 5]].concat()),
        ("s.gltf", chunks(&[(b"JSON", &text), (b"BIN\0", &buffer())])),
        ("s.glb", chunks(&[(b"JSON", own.as_bytes())])),
        ("s.glb", own.clone().into_bytes()),
        ("s.gltf", [b"\xef\xbb\xbf", own.as_bytes()].concat()),
    ] {
        let (scene, _) = Folder::new().with(name, &file).load(name, &[]).unwrap();
        assert_eq!(scene.shapes.len(), 1);
    }
    let without = chunks(&[(b"JSON", &text)]);
    let e = Folder::new().with("s.glb", without).load("s.glb", &[]).unwrap_err();
    assert_eq!(e, "s.glb: buffer 0: the binary chunk is missing");
    let e = Folder::new().with("s.glb", chunks(&[(b"BIN\0", b"")])).load("s.glb", &[]).unwrap_err();
    assert_eq!(e, "s.glb: a GLB file without JSON");
    let mut old = chunks(&[(b"JSON", &text)]);
    old[4] = 1;
    assert!(Folder::new().with("s.glb", old).load("s.glb", &[]).unwrap_err().contains("GLB of version 1"));
}

#[test]
fn what_no_picture_needs_may_be_wrong() {
    let mut d = document();
    let accessor = d["accessors"][0].as_object_mut().unwrap();
    accessor.remove("min");
    accessor.remove("max");
    d["meshes"][0]["primitives"][0]["attributes"]["BATCHID"] = 2.into();
    d["animations"] = json!([{"channels": [{"sampler": 0, "target": {"path": "pointer"}}], "samplers": []}]);
    let (scene, warnings) = load(&d).unwrap();
    assert_eq!(scene.groups.len(), 1);
    assert_eq!(warnings, ["s.gltf: animations are ignored: --frame or --time-of-animation picks a moment of them"]);
    d["scenes"] = json!([]);
    d.as_object_mut().unwrap().remove("scene");
    assert_eq!(load(&d).unwrap().0.instances.len(), 2);
}

#[test]
fn extensions_that_are_not_applied_are_named_once() {
    let mut d = document();
    d["extensionsUsed"] =
        json!(["KHR_materials_iridescence", "KHR_lights_punctual", "KHR_materials_iridescence", "EXT_x"]);
    let (_, warnings) = load(&d).unwrap();
    assert_eq!(
        warnings,
        ["s.gltf: the extension EXT_x is ignored", "s.gltf: the extension KHR_materials_iridescence is ignored"]
    );
}

#[test]
fn images_of_extensions_are_named_where_they_are_needed() {
    let mut d = document();
    d["textures"] = json!([{"extensions": {"KHR_texture_basisu": {"source": 0}}}]);
    let e = load(&d).unwrap_err();
    assert_eq!(e, "s.gltf: texture 0: its image is not of glTF itself, but of KHR_texture_basisu");
    // Neither a material that nothing has, nor a slot that nothing looks at, needs it.
    d["materials"].as_array_mut().unwrap().push(json!({"emissiveTexture": {"index": 0}}));
    d["materials"][0] = json!({"occlusionTexture": {"index": 0}, "emissiveTexture": {"index": 0}});
    load(&d).unwrap();
}

#[test]
fn rotations_are_made_unit_quaternions() {
    let mut d = document();
    d["nodes"][0]["rotation"] = json!([0, 0, 0.35, 0.35]);
    d["nodes"][1]["rotation"] = json!([0, 0, 3, 3]);
    let (scene, warnings) = load(&d).unwrap();
    let x = scene.instances[0].to_world.transform_vector3a(Vec3A::X);
    assert!((x - Vec3A::Y).length() < 1e-6, "{x}");
    let what = "the quaternion of a rotation is not of unit length: it is normalised";
    assert_eq!(warnings, [format!("s.gltf: node 0 (-) (and 1 more): {what}")]);
    d["nodes"][0]["rotation"] = json!([0, 0, 0, 0]);
    d["nodes"][1]["rotation"] = json!([0, 0, 0, 1]);
    let (scene, warnings) = load(&d).unwrap();
    assert_eq!(scene.instances[0].to_world.matrix3, glam::Mat3A::IDENTITY);
    assert_eq!(warnings, ["s.gltf: node 0 (-): a rotation of length zero is left out"]);
}

#[test]
fn cameras_ignore_the_scale_of_what_they_hang_on() {
    let mut d = document();
    let plain = load(&d).unwrap().0.camera;
    d["nodes"][3]["rotation"] = json!([0, HALF, 0, HALF]);
    let turned = load(&d).unwrap().0.camera;
    d["nodes"].as_array_mut().unwrap().push(json!({"children": [3], "scale": [1, 2, 1]}));
    d["scenes"][0]["nodes"] = json!([0, 1, 2, 4, 5, 6, 7]);
    assert_eq!(load(&d).unwrap().0.camera, turned);
    d["nodes"][7]["scale"] = json!([2, 2, 1]);
    let moved = load(&d).unwrap().0.camera;
    assert!((moved.to_world.matrix3.z_axis - turned.to_world.matrix3.z_axis).length() < 1e-6);
    d["nodes"][3].as_object_mut().unwrap().remove("rotation");
    d["nodes"][7]["scale"] = json!([-1, 1, 1]);
    assert_eq!(load(&d).unwrap().0.camera, plain);
}

#[test]
fn morph_targets_of_meshes_and_nodes() {
    let mut d = document();
    // Positions and normals of the square serve as deviations, too.
    d["meshes"][0]["primitives"][0]["targets"] = json!([{"POSITION": 1, "NORMAL": 0}, {"POSITION": 0}]);
    d["meshes"][0]["weights"] = json!([0.5, 0]);
    d["nodes"][1]["weights"] = json!([0, 2]);
    let (scene, warnings) = load(&d).unwrap();
    assert!(warnings.is_empty(), "{warnings:?}");
    // Two poses, so no group.
    let meshes: Vec<&Mesh> = scene
        .shapes
        .iter()
        .filter(|s| s.emitter.is_none())
        .map(|s| if let Geometry::Mesh(m) = &s.geometry { m } else { panic!() })
        .collect();
    let [node, mesh] = meshes.as_slice() else { panic!("{}", meshes.len()) };
    assert_eq!(mesh.positions[2], glam::Vec3::new(1.0, 1.0, 0.5));
    assert!((mesh.normals[2] - glam::Vec3::new(0.5, 0.5, 1.0).normalize()).length() < 1e-6);
    assert_eq!(node.positions[2], glam::Vec3::new(6.0, 6.0, -5.0));
    d["meshes"][0]["weights"] = json!([1e39]);
    assert!(load(&d).unwrap_err().contains("node 0: a weight is not finite"));
    d["meshes"][0]["weights"] = json!([1]);
    d["meshes"][0]["primitives"][0]["targets"] = json!([{"POSITION": 4}]);
    d["accessors"]
        .as_array_mut()
        .unwrap()
        .push(json!({"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}));
    assert!(load(&d).unwrap_err().contains("a morph target of different length"));
}

#[test]
fn specular_reflectance_has_a_strength_and_a_colour() {
    let fresnel = |extensions: Value| {
        let mut d = document();
        d["materials"][0]["extensions"] = extensions;
        let (scene, warnings) = load(&d).unwrap();
        assert!(warnings.is_empty(), "{warnings:?}");
        let found = scene.materials.iter().find_map(|m| match m {
            Material::MetallicRoughness { f0, specular: FloatTexture::Constant(f90), .. } => {
                Some(((f0.factor() * *f90).to_array(), *f90))
            }
            _ => None,
        });
        found.unwrap()
    };
    let near = |(a, x): ([f32; 3], f32), (b, y): ([f32; 3], f32)| {
        assert!((0..3).all(|i| (a[i] - b[i]).abs() < 1e-6) && (x - y).abs() < 1e-6, "{a:?} {x}")
    };
    near(fresnel(json!({"KHR_materials_specular": {}})), ([0.04; 3], 1.0));
    near(fresnel(json!({"KHR_materials_specular": {"specularFactor": 0.25}})), ([0.01; 3], 0.25));
    near(
        fresnel(json!({"KHR_materials_specular": {"specularFactor": 0.5, "specularColorFactor": [2, 0, 1000]}})),
        ([0.04, 0.0, 0.5], 0.5),
    );
    near(fresnel(json!({"KHR_materials_ior": {"ior": 0}})), ([1.0; 3], 1.0));
}

#[test]
fn missing_textures_may_be_skipped() {
    let mut d = document();
    d["images"][0]["uri"] = "gone.png".into();
    let folder = Folder::new().with("s.gltf", d.to_string()).with("Gone.PNG", png());
    let e = folder.load("s.gltf", &[]).unwrap_err();
    assert!(e.ends_with("did you mean Gone.PNG?; --skip-missing draws an even grey instead"), "{e}");
    let options = load::Options { skip_missing: true, ..load::Options::default() };
    let (scene, warnings) = folder.load_with("s.gltf", &options).unwrap();
    assert_eq!(warnings, ["--skip-missing: 1 textures are an even grey: no gone.png"]);
    assert!(scene.textures.iter().all(|t| matches!(t, Texture::Bitmap(b) if b.width == 1)));
}

#[test]
fn double_sided_lamps_shine_on_both_sides() {
    let mut d = document();
    d["materials"][1]["doubleSided"] = true.into();
    let (scene, _) = load(&d).unwrap();
    let [front, back] = scene.shapes.as_slice() else { panic!("{}", scene.shapes.len()) };
    let normal = |s: &Shape| {
        let Geometry::Mesh(m) = &s.geometry else { panic!() };
        let [a, b, c] = m.triangles[0].map(|i| m.positions[i as usize]);
        ((b - a).cross(c - a).normalize(), a)
    };
    let ((n, p), (opposite, q)) = (normal(front), normal(back));
    assert!((n + opposite).length() < 1e-3 && (p - q).dot(n) > 1e-5 && (p - q).length() < 1e-3);
    assert_eq!(front.emitter, back.emitter);
    // The inside of a closed lamp, here a tetrahedron, is not lit.
    let corners = [[0f32, 0., 0.], [1., 0., 0.], [0., 1., 0.], [0., 0., 1.]];
    let mut bytes: Vec<u8> = corners.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
    bytes.extend([0u16, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3].iter().flat_map(|i| i.to_le_bytes()));
    d["buffers"][0] = json!({"byteLength": bytes.len(), "uri": data_uri("application/octet-stream", &bytes)});
    d["bufferViews"] = json!([{"buffer": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 24}]);
    d["accessors"] = json!([
        {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 1]},
        {"bufferView": 1, "componentType": 5123, "count": 12, "type": "SCALAR"}]);
    d["meshes"] = json!([{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 1}]}]);
    d["nodes"] = json!([{"mesh": 0}]);
    d["scenes"] = json!([{"nodes": [0]}]);
    assert_eq!(load(&d).unwrap().0.shapes.len(), 1);
}

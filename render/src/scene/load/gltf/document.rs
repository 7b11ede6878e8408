//! JSON to a document of the `gltf` crate, which is stricter than files are, and trusts what it has not checked.

use crate::scene::load::error::FileError;
use gltf::Document;
use gltf::Semantic;
use gltf::json::accessor::sparse::{Indices, Sparse, Values};
use gltf::json::accessor::{ComponentType, IndexComponentType};
use gltf::json::camera::Type as CameraType;
use gltf::json::extensions::scene::khr_lights_punctual::Type as LightType;
use gltf::json::validation::{Checked, USize64};
use gltf::json::{Index, Root, image::MimeType};
use serde::Deserialize;
use serde_json::json;
use std::path::Path;

/// Extensions that are applied.
pub const SUPPORTED: [&str; 14] = [
    "EXT_mesh_gpu_instancing",
    "EXT_texture_webp",
    "KHR_lights_punctual",
    "KHR_materials_clearcoat",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_sheen",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_node_visibility",
    "KHR_texture_transform",
];

/// Extensions that keep geometry in a form of their own.
const DRACO: &str = "KHR_draco_mesh_compression";
const MESHOPT: [&str; 2] = ["EXT_meshopt_compression", "KHR_meshopt_compression"];

/// What tells the version, whatever else a file of another one holds.
#[derive(Deserialize)]
struct Head {
    asset: Asset,
}

#[derive(Deserialize)]
struct Asset {
    version: String,
}

/// A document in which every index that is followed exists, and the number of animations, which are left out of it.
/// With `skip_missing`, parts of the scene that extensions hold are left out.
pub fn parse(text: &str, path: &Path, skip_missing: bool) -> Result<(Document, usize), FileError> {
    let error = |what: String| FileError::new(path, what);
    if let Ok(head) = serde_json::from_str::<Head>(text)
        && !head.asset.version.trim().starts_with("2.")
    {
        return Err(error(format!("glTF of version {}: only 2.x is read", head.asset.version)));
    }
    let (mut json, animations) = root(text).map_err(|e| FileError::at(path, e.line(), e))?;
    for extension in &json.extensions_required {
        let skipped = skip_missing && holds_parts(extension);
        if !skipped && !SUPPORTED.contains(&extension.as_str()) {
            let compressed = extension == DRACO || MESHOPT.contains(&extension.as_str());
            let remedy = match extension {
                _ if compressed => ": export without compression",
                _ if holds_parts(extension) => "; --skip-missing draws the rest",
                _ => "",
            };
            return Err(error(format!("the extension {extension} is required, but not supported{remedy}")));
        }
    }
    if !skip_missing {
        no_part_is_left_out(&json).map_err(error)?;
    }
    not_compressed(&json).map_err(error)?;
    // The crate knows fewer.
    json.extensions_required.clear();
    repair(&mut json);
    check(&json).map_err(error)?;
    let document = Document::from_json(json).map_err(|e| error(e.to_string()))?;
    Ok((document, animations))
}

/// The JSON without its animations, and their number. Nothing moves, so that one which the crate does not understand (of
/// what an extension animates) is no reason to refuse the picture.
fn root(text: &str) -> Result<(Root, usize), serde_json::Error> {
    serde_json::from_str::<Root>(text)
        .map(|mut root| {
            let animations = std::mem::take(&mut root.animations).len();
            (root, animations)
        })
        .or_else(|error| {
            let mut value: serde_json::Value = serde_json::from_str(text)?;
            let animations = value.as_object_mut().and_then(|root| root.remove("animations")).ok_or(error)?;
            Ok((serde_json::from_value(value)?, animations.as_array().map_or(0, Vec::len)))
        })
}

/// Whether an extension of a node, a scene or a primitive holds what the picture then lacks: light or surfaces.
fn holds_parts(extension: &str) -> bool {
    extension != "KHR_lights_punctual" && ["_lights_", "environment", "splat"].iter().any(|w| extension.contains(w))
}

/// Refuses scenes of which a part would be missing.
fn no_part_is_left_out(json: &Root) -> Result<(), String> {
    let nodes = json.nodes.iter().enumerate();
    let nodes = nodes.filter_map(|(i, node)| Some(("node", i, &node.extensions.as_ref()?.others)));
    let scenes = json.scenes.iter().enumerate();
    let scenes = scenes.filter_map(|(i, scene)| Some(("scene", i, &scene.extensions.as_ref()?.others)));
    let meshes = json.meshes.iter().enumerate().flat_map(|(i, mesh)| mesh.primitives.iter().map(move |p| (i, p)));
    let meshes = meshes.filter_map(|(i, primitive)| Some(("mesh", i, &primitive.extensions.as_ref()?.others)));
    for (kind, i, extensions) in nodes.chain(scenes).chain(meshes) {
        if let Some(name) = extensions.keys().find(|name| holds_parts(name)) {
            let what = format!("{kind} {i}: what the extension {name} holds is not drawn");
            return Err(format!("{what}; --skip-missing draws the rest"));
        }
    }
    Ok(())
}

/// Refuses geometry that is there in compressed form only; files may have both.
fn not_compressed(json: &Root) -> Result<(), String> {
    let remedy = |name| format!("only {name} has the data: export without compression");
    for (i, mesh) in json.meshes.iter().enumerate() {
        for primitive in &mesh.primitives {
            let compressed = primitive.extensions.as_ref().is_some_and(|e| e.others.contains_key(DRACO));
            let used = primitive.attributes.values().chain(&primitive.indices);
            let empty = |a: &gltf::json::Accessor| a.buffer_view.is_none() && a.sparse.is_none();
            if compressed && used.filter_map(|a| json.accessors.get(a.value())).any(empty) {
                return Err(format!("mesh {i}: {}", remedy(DRACO)));
            }
        }
    }
    for (i, buffer) in json.buffers.iter().enumerate().filter(|(_, b)| b.uri.is_none()) {
        let extensions = buffer.extensions.as_ref().map(|e| &e.others);
        if let Some(name) = MESHOPT.into_iter().find(|name| extensions.is_some_and(|e| e.contains_key(*name))) {
            return Err(format!("buffer {i}: {}", remedy(name)));
        }
    }
    Ok(())
}

/// Gives what the specification asks for and no picture needs.
fn repair(json: &mut Root) {
    let position = Checked::Valid(Semantic::Positions);
    for primitive in json.meshes.iter_mut().flat_map(|m| &mut m.primitives) {
        // Attributes of an application must have names with an underscore, and often have not.
        primitive.attributes.retain(|semantic, _| *semantic != Checked::Invalid);
        let accessor = primitive.attributes.get(&position).and_then(|a| json.accessors.get_mut(a.value()));
        if let Some(accessor) = accessor {
            // Bounds are measured, not believed.
            (accessor.min, accessor.max) = (Some(json!([0.0, 0.0, 0.0])), Some(json!([0.0, 0.0, 0.0])));
        }
    }
    let first = Index::new(0);
    for accessor in json.accessors.iter_mut().filter(|a| a.buffer_view.is_none()) {
        // Without data it is all zeros, which the crate knows of sparse accessors only.
        accessor.sparse.get_or_insert(Sparse {
            count: USize64(0),
            indices: Indices {
                buffer_view: first,
                byte_offset: USize64(0),
                component_type: Checked::Valid(IndexComponentType(ComponentType::U8)),
                extensions: None,
                extras: None,
            },
            values: Values { buffer_view: first, byte_offset: USize64(0), extensions: None, extras: None },
            extensions: None,
            extras: None,
        });
    }
    for image in json.images.iter_mut().filter(|i| i.buffer_view.is_some() && i.mime_type.is_none()) {
        // The first bytes of an image tell what it is.
        image.mime_type = Some(MimeType("image/png".into()));
    }
}

/// What the crate's own validation leaves out, and its accessors rely on.
fn check(json: &Root) -> Result<(), String> {
    let position = Checked::Valid(Semantic::Positions);
    for primitive in json.meshes.iter().flat_map(|m| &m.primitives) {
        if primitive.attributes.get(&position).is_some_and(|a| a.value() >= json.accessors.len()) {
            return Err("a primitive refers to a missing accessor".into());
        }
    }
    for (i, image) in json.images.iter().enumerate() {
        if image.buffer_view.is_none() && image.uri.is_none() {
            return Err(format!("image {i}: neither a file nor a buffer view"));
        }
    }
    for (i, camera) in json.cameras.iter().enumerate() {
        let whole = match camera.type_ {
            Checked::Valid(CameraType::Perspective) => camera.perspective.is_some(),
            Checked::Valid(CameraType::Orthographic) => camera.orthographic.is_some(),
            Checked::Invalid => true,
        };
        if !whole {
            return Err(format!("camera {i}: its projection is missing"));
        }
    }
    let lights = json.extensions.as_ref().and_then(|e| e.khr_lights_punctual.as_ref()).map(|l| &l.lights);
    for (i, light) in lights.into_iter().flatten().enumerate() {
        if light.type_ == Checked::Valid(LightType::Spot) && light.spot.is_none() {
            return Err(format!("light {i}: its cones are missing"));
        }
    }
    for (i, node) in json.nodes.iter().enumerate() {
        let light = node.extensions.as_ref().and_then(|e| e.khr_lights_punctual.as_ref());
        if light.is_some_and(|l| l.light.value() >= lights.map_or(0, Vec::len)) {
            return Err(format!("node {i}: its light is missing"));
        }
    }
    Ok(())
}

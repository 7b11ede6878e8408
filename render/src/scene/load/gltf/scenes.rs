//! Scenes without nodes: exporters leave the list out where nothing was to be exported, and the `gltf` crate wants it.

use serde::Deserialize;
use serde::de::IgnoredAny;
use serde_json::{Value, json};

#[derive(Deserialize)]
struct Outline {
    #[serde(default)]
    scenes: Vec<Scene>,
}

#[derive(Deserialize)]
struct Scene {
    nodes: Option<IgnoredAny>,
}

/// The text with an empty list in every scene that has none.
pub fn with_nodes(text: String) -> String {
    let whole = |outline: Outline| outline.scenes.iter().all(|s| s.nodes.is_some());
    if serde_json::from_str(&text).map_or(true, whole) {
        return text;
    }
    let Ok(mut value) = serde_json::from_str::<Value>(&text) else { return text };
    for scene in value.get_mut("scenes").and_then(Value::as_array_mut).into_iter().flatten() {
        if let Some(scene) = scene.as_object_mut() {
            scene.entry("nodes").or_insert_with(|| json!([]));
        }
    }
    value.to_string()
}

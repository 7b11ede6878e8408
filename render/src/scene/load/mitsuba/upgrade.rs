//! Scenes of older versions, brought to the names of version 0.6 by the rules of Mitsuba's own upgrades.

use super::xml::Element;

/// Major and minor version of a scene file.
pub type Version = (u32, u32);

/// Brings an element and what it holds to version 0.6; called for inner elements first.
pub fn upgrade(element: &mut Element, version: Version) {
    if version < (0, 5) && element.tag == "bsdf" && element.attribute("type") == Some("bump") {
        element.set("type", "bumpmap");
    }
    if version >= (0, 4) {
        return;
    }
    match element.tag.as_str() {
        "camera" => camera(element),
        "luminaire" => {
            element.tag = "emitter".into();
            match element.attribute("type") {
                Some("area" | "constant") => rename(element, "intensity", "radiance"),
                Some("directional") => rename(element, "intensity", "irradiance"),
                _ => rename(element, "intensityScale", "scale"),
            }
        }
        "sampler" => rename(element, "depth", "dimension"),
        "film" => {
            match element.attribute("type") {
                Some("exrfilm") => element.set("type", "hdrfilm"),
                Some("pngfilm") => element.set("type", "ldrfilm"),
                _ => {}
            }
            // Whether the picture has an alpha channel.
            element.children.retain(|c| c.attribute("name") != Some("alpha"));
        }
        "blackbody" => {
            if let Some((name, _)) = element.attributes.iter_mut().find(|(n, _)| n == "multiplier") {
                *name = "scale".into();
            }
        }
        _ => {}
    }
}

/// A camera maps its field of view to the smaller side unless told otherwise, and its frame has x to the right.
fn camera(element: &mut Element) {
    element.tag = "sensor".into();
    rename(element, "focusDepth", "focusDistance");
    let smaller = |c: &Element| c.attribute("name") == Some("mapSmallerSide");
    let larger = element
        .children
        .iter()
        .any(|c| smaller(c) && c.attribute("value").is_some_and(|v| v.trim().eq_ignore_ascii_case("false")));
    element.children.retain(|c| !smaller(c));
    if element.attribute("type") == Some("perspective") {
        let axis = if larger { "larger" } else { "smaller" };
        element.children.push(element.child("string", &[("name", "fovAxis"), ("value", axis)]));
    }
    for transform in element.children.iter_mut().filter(|c| c.attribute("name") == Some("toWorld")) {
        let mirror = transform.child("scale", &[("x", "-1")]);
        transform.children.insert(0, mirror);
    }
}

fn rename(element: &mut Element, old: &str, new: &str) {
    for child in element.children.iter_mut().filter(|c| c.attribute("name") == Some(old)) {
        child.set("name", new);
    }
}

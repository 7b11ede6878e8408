//! Animations: what moves the nodes of a file, at any time.

use super::data::Data;
use super::keys::{Curve, Interpolation};
use super::pose::{Place, Pose};
use crate::scene::load::error::FileError;
use glam::DVec3;
use gltf::Document;
use serde::Deserialize;
use std::collections::HashSet;

/// More numbers are refused, so that channels that share an accessor cannot grow without end.
const MAX_NUMBERS: usize = 1 << 28;

/// The part of the file that is read here rather than by the `gltf` crate, which refuses what extensions animate.
#[derive(Deserialize)]
struct File {
    #[serde(default)]
    animations: Vec<Animation>,
}

#[derive(Deserialize)]
struct Animation {
    #[serde(default)]
    channels: Vec<ChannelText>,
    #[serde(default)]
    samplers: Vec<Sampler>,
}

#[derive(Deserialize)]
struct ChannelText {
    sampler: usize,
    target: Target,
}

#[derive(Deserialize)]
struct Target {
    node: Option<usize>,
    path: String,
}

#[derive(Deserialize)]
struct Sampler {
    input: usize,
    output: usize,
    #[serde(default)]
    interpolation: Interpolation,
}

/// What of a node moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Property {
    Translation,
    Rotation,
    Scale,
    Weights,
}

/// A property of a node and how it moves.
#[derive(Clone, Debug)]
struct Channel {
    node: usize,
    property: Property,
    curve: Curve,
}

/// All animations of a file, which run at the same time.
#[derive(Clone, Debug, Default)]
pub struct Animations {
    channels: Vec<Channel>,
    /// What is not applied: what it is, and where it is first.
    pub notes: Vec<(&'static str, String)>,
}

impl Animations {
    /// Reads the animations of a file, whose JSON is `text`. Of those that move the same property the first is kept.
    ///
    /// # Errors
    /// Channels that refer to nothing, keys that are none.
    pub fn read(text: &str, document: &Document, data: &Data) -> Result<Self, FileError> {
        let file: File = serde_json::from_str(text).map_err(|e| FileError::at(data.path, e.line(), e))?;
        let mut all = Self::default();
        let (mut moved, mut numbers) = (HashSet::new(), 0);
        for (a, animation) in file.animations.iter().enumerate() {
            for (c, ChannelText { sampler, target }) in animation.channels.iter().enumerate() {
                let place = format!("animation {a}, channel {c}");
                let error = |what: String| data.error(format_args!("{place}: {what}"));
                let property = match target.path.as_str() {
                    "translation" => Some(Property::Translation),
                    "rotation" => Some(Property::Rotation),
                    "scale" => Some(Property::Scale),
                    "weights" => Some(Property::Weights),
                    _ => None,
                };
                let Some((node, property)) = target.node.zip(property) else {
                    all.notes.push(("ignored, for it moves no node", place));
                    continue;
                };
                if node >= document.nodes().len() {
                    return Err(error(format!("node {node} is missing")));
                }
                if !moved.insert((node, property)) {
                    all.notes.push(("ignored, for one before it moves the same property of the node", place));
                    continue;
                }
                let sampler = animation.samplers.get(*sampler);
                let sampler = sampler.ok_or_else(|| error("its sampler is missing".into()))?;
                let accessor = |index: usize| {
                    document.accessors().nth(index).ok_or_else(|| error(format!("accessor {index} is missing")))
                };
                let (input, output) = (accessor(sampler.input)?, accessor(sampler.output)?);
                let (values, width) = match property {
                    Property::Translation | Property::Scale => (data.vectors::<3>(&output)?.into_flattened(), Some(3)),
                    Property::Rotation => (data.vectors::<4>(&output)?.into_flattened(), Some(4)),
                    Property::Weights => (data.vectors::<1>(&output)?.into_flattened(), None),
                };
                let times = data.vectors::<1>(&input)?.into_flattened();
                numbers += times.len() + values.len();
                if numbers > MAX_NUMBERS {
                    return Err(error("too many keys".into()));
                }
                let curve = Curve::new(times, values, width, sampler.interpolation)
                    .map_err(|what| error(format!("accessors {} and {}: {what}", sampler.input, sampler.output)))?;
                all.channels.push(Channel { node, property, curve });
            }
        }
        Ok(all)
    }

    /// Whether nothing moves.
    pub fn is_empty(&self) -> bool {
        self.channels.is_empty()
    }

    /// When the last key is, seconds.
    pub fn end(&self) -> f32 {
        self.channels.iter().map(|channel| channel.curve.end()).fold(0.0, f32::max)
    }

    /// Whether any of these nodes moves.
    pub fn move_node(&self, nodes: &[usize]) -> bool {
        self.channels.iter().any(|channel| nodes.contains(&channel.node))
    }

    /// Whether none but these nodes moves.
    pub fn move_only(&self, nodes: &[usize]) -> bool {
        self.channels.iter().all(|channel| nodes.contains(&channel.node))
    }

    /// How the nodes stand at a time in seconds; those that nothing moves stand as in `rest`. Before its first key and
    /// after its last one, nothing moves.
    pub fn pose(&self, time: f32, rest: &Pose) -> Pose {
        let mut pose = rest.clone();
        for Channel { node, property, curve } in &self.channels {
            let local = &mut pose.nodes[*node];
            if *property == Property::Weights {
                local.weights = Some(curve.at(time).into_iter().map(|w| w as f32).collect());
                continue;
            }
            let (mut translation, mut rotation, mut scale) = local.place.parts();
            match property {
                Property::Translation => translation = DVec3::from_slice(&curve.at(time)),
                Property::Scale => scale = DVec3::from_slice(&curve.at(time)),
                Property::Rotation | Property::Weights => rotation = curve.rotation_at(time),
            }
            local.place = Place::Parts { translation, rotation, scale };
        }
        pose
    }
}

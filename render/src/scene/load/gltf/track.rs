//! The way of an animated camera.

use super::Builder;
use super::animation::Animations;
use super::pose::Pose;
use crate::scene::Camera;
use crate::scene::load::error::FileError;

/// Most frames of a way.
const MAX_FRAMES: f64 = 100_000.0;

impl Builder<'_> {
    /// The camera that takes the picture at every frame of the animations, from the JSON of the file.
    pub(super) fn track(&mut self, text: &str, fps: f64) -> Result<Vec<Camera>, FileError> {
        let Some((camera, node)) = self.camera.clone() else {
            return Err(self.data.error("the file has no camera to follow"));
        };
        let animations = Animations::read(text, self.document, self.data)?;
        if !animations.move_node(&self.pose.line(node)) {
            return Err(self.data.error("nothing moves the camera: export it with its animation"));
        }
        if !animations.move_only(&self.pose.line(node)) {
            self.warn(
                "only the camera moves: all else stands as --frame or --time-of-animation has it, or as in the file",
            );
        }
        let frames = (f64::from(animations.end()) * fps + 1e-3).floor();
        if frames >= MAX_FRAMES {
            return Err(self.data.error(format_args!("more than {MAX_FRAMES} frames")));
        }
        let rest = Pose::of_nodes(self.document);
        let camera_of = |frame: u32| {
            let pose = animations.pose((f64::from(frame) / fps) as f32, &rest);
            self.camera_at(&camera, pose.to_world(node, self.data)?)
        };
        (0..=frames as u32).map(camera_of).collect()
    }
}

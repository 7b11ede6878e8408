//! Cameras of glTF.

use super::{Builder, Cameras};
use crate::scene::load::choose::{choose, list};
use crate::scene::load::error::FileError;
use crate::scene::load::framing::{HEIGHT, frame_everything};
use crate::scene::load::similarity::without_scale;
use crate::scene::{self, Camera, Film};
use glam::{DAffine3, DMat3, Vec3};
use gltf::camera::Projection;

/// A camera of the file and where it stands.
pub(super) struct Placed<'a> {
    camera: gltf::Camera<'a>,
    node: usize,
    /// Name of the node.
    name: Option<String>,
    to_world: DAffine3,
}

impl<'a> Builder<'a> {
    /// Keeps a camera until all are known.
    pub(super) fn camera(&mut self, node: &gltf::Node<'a>, to_world: DAffine3) {
        if let Some(camera) = node.camera() {
            self.cameras.push(Placed { camera, node: node.index(), name: node.name().map(Into::into), to_world });
        }
    }

    /// The camera that is asked for takes the picture, else the first; without any, one that sees everything.
    pub(super) fn take_picture(&mut self, wanted: Option<&str>) -> Result<Cameras, FileError> {
        let cameras = std::mem::take(&mut self.cameras);
        let names = |placed: &'_ Placed<'_>| -> Vec<String> {
            let mut own: Vec<String> =
                placed.name.clone().into_iter().chain(placed.camera.name().map(Into::into)).collect();
            own.dedup();
            own
        };
        let names: Vec<Vec<String>> = cameras.iter().map(names).collect();
        let chosen = match wanted {
            Some(wanted) => {
                choose("camera", wanted, &names).map_err(|what| self.data.error(format_args!("--camera: {what}")))?
            }
            None => 0,
        };
        if wanted.is_none() && cameras.len() > 1 {
            self.warn(format_args!("only the first camera takes a picture; --camera chooses from {}", list(&names)));
        }
        match cameras.get(chosen) {
            Some(Placed { camera, node, to_world, .. }) => {
                self.scene.camera = self.camera_at(camera, *to_world)?;
                self.camera = Some((camera.clone(), *node));
            }
            None => {
                self.warn("the file has no camera: the picture is taken from a corner, with everything in it");
                self.scene.camera = frame_everything(&self.scene, Vec3::Y).unwrap_or_default();
            }
        }
        Ok((names, (!cameras.is_empty()).then_some(chosen)))
    }

    /// A camera where its node stands.
    pub(super) fn camera_at(&self, camera: &gltf::Camera, to_world: DAffine3) -> Result<Camera, FileError> {
        let error = |what: String| self.data.error(format_args!("camera {}: {what}", camera.index()));
        // Scaling of a camera and of what it hangs on is ignored (glTF 3.10.2).
        let rotation = without_scale(to_world.matrix3).ok_or_else(|| error("its transform is singular".into()))?;
        let aspects = 0.01..=100.0;
        let (projection, aspect, near, far) = match camera.projection() {
            Projection::Perspective(p) => {
                let aspect = p.aspect_ratio().filter(|a| aspects.contains(a)).unwrap_or(16.0 / 9.0);
                let fov_x = 2.0 * (aspect * (0.5 * p.yfov()).tan()).atan();
                (scene::Projection::Perspective { fov_x }, aspect, p.znear(), p.zfar().unwrap_or(f32::MAX))
            }
            Projection::Orthographic(o) => {
                let (half_width, half_height) = (o.xmag().abs(), o.ymag().abs());
                let aspect = half_width / half_height;
                if !aspects.contains(&aspect) {
                    return Err(error(format!("a view of {half_width} × {half_height}")));
                }
                (scene::Projection::Orthographic { half_width }, aspect, o.znear(), o.zfar())
            }
        };
        // glTF looks along −z with x to the right, this crate's cameras along +z with x to the left.
        let turn = DMat3::from_diagonal(glam::DVec3::new(-1.0, 1.0, -1.0));
        Ok(Camera {
            to_world: DAffine3 { matrix3: rotation * turn, translation: to_world.translation }.as_affine3a(),
            projection,
            near,
            far,
            film: Film {
                width: ((HEIGHT as f32 * aspect).round() as u32).max(1),
                height: HEIGHT,
                ..Camera::default().film
            },
            ..Camera::default()
        })
    }
}

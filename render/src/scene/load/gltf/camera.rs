//! Cameras and punctual lights of glTF.

use super::Builder;
use crate::scene::load::error::FileError;
use crate::scene::load::similarity::without_scale;
use crate::scene::{self, Camera, Film, Geometry, Light, Rgb};
use glam::{Affine3A, DAffine3, DMat3, Vec3, Vec3A};
use gltf::camera::Projection;
use gltf::khr_lights_punctual::{self as punctual, Kind};

/// Rows of the picture, for which glTF has no field.
const HEIGHT: u32 = 720;
/// Blender's exporter multiplies radiometric by this to get photometric units, lm/W.
const LUMENS_PER_WATT: f32 = 683.0;

impl Builder<'_> {
    /// The first camera takes the picture.
    pub(super) fn camera(&mut self, camera: &gltf::Camera, to_world: DAffine3) -> Result<(), FileError> {
        if std::mem::replace(&mut self.has_camera, true) {
            self.warn(format_args!("camera {}: only the first camera takes a picture", camera.index()));
            return Ok(());
        }
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
        self.scene.camera = Camera {
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
        };
        Ok(())
    }

    /// A camera that sees the box around everything.
    pub(super) fn frame_everything(&mut self) {
        let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        let mut take = |shape: &scene::Shape, to_world: Affine3A| {
            if let Geometry::Mesh(mesh) = &shape.geometry {
                for &p in &mesh.positions {
                    let p = to_world.transform_point3(p);
                    (low, high) = (low.min(p), high.max(p));
                }
            }
        };
        self.scene.shapes.iter().for_each(|s| take(s, Affine3A::IDENTITY));
        for instance in &self.scene.instances {
            self.scene.groups[instance.group as usize].shapes.iter().for_each(|s| take(s, instance.to_world));
        }
        let radius = 0.5 * (high - low).length();
        if !radius.is_finite() || radius == 0.0 {
            return;
        }
        let center = 0.5 * (low + high);
        let film = Film { width: HEIGHT * 16 / 9, height: HEIGHT, ..Camera::default().film };
        let half_height = 0.36f32;
        let back = Vec3::new(0.5, 0.4, 1.0).normalize();
        let distance = radius / half_height.sin();
        let left = Vec3::Y.cross(-back).normalize();
        let rotation = glam::Mat3::from_cols(left, (-back).cross(left), -back);
        self.scene.camera = Camera {
            to_world: Affine3A::from_mat3_translation(rotation, center + distance * back),
            projection: scene::Projection::Perspective { fov_x: 2.0 * (half_height.tan() * 16.0 / 9.0).atan() },
            near: 1e-3 * radius,
            far: 10.0 * distance,
            film,
            ..Camera::default()
        };
    }

    pub(super) fn light(&mut self, light: &punctual::Light, to_world: DAffine3) -> Result<(), FileError> {
        let strength = Rgb::from(light.color()) * light.intensity() / LUMENS_PER_WATT;
        if !strength.is_finite() || strength.min_element() < 0.0 {
            return Err(self.data.error(format_args!("light {}: colour and intensity must be ≥ 0", light.index())));
        }
        let position = to_world.translation.as_vec3a();
        let direction = || -> Result<Vec3A, FileError> {
            let z = (-to_world.matrix3.z_axis).try_normalize();
            Ok(z.ok_or_else(|| self.data.error(format_args!("light {}: no direction", light.index())))?.as_vec3a())
        };
        let light = match light.kind() {
            Kind::Point => Light::Point { position, intensity: strength },
            Kind::Directional => Light::Directional { direction: direction()?, irradiance: strength },
            Kind::Spot { inner_cone_angle: beam, outer_cone_angle: cutoff } => {
                if !(0.0 <= beam && beam <= cutoff && cutoff <= core::f32::consts::PI) {
                    return Err(self.data.error(format_args!("light {}: cones of {beam} and {cutoff}", light.index())));
                }
                Light::Spot { position, direction: direction()?, intensity: strength, beam, cutoff }
            }
        };
        self.scene.lights.push(light);
        Ok(())
    }
}

//! Pieces of small scenes made in code.

use glam::{Affine3A, Mat3A, Vec3, Vec3A};
use render::scene::*;

/// A constant grey.
pub fn gray(x: f32) -> ColorTexture {
    ColorTexture::Constant(Rgb::splat(x))
}

/// A diffuse material.
pub fn diffuse(x: f32) -> Material {
    Material::Diffuse { reflectance: gray(x) }
}

/// A shape of a mesh.
pub fn mesh(mesh: Mesh, material: u32, radiance: Option<f32>) -> Shape {
    let emitter = radiance.map(|l| AreaEmitter { radiance: gray(l) });
    Shape { geometry: Geometry::Mesh(mesh), material: MaterialId(material), emitter }
}

/// A sphere.
pub fn sphere(center: Vec3A, radius: f32, inward: bool, material: u32, radiance: Option<f32>) -> Shape {
    let emitter = radiance.map(|l| AreaEmitter { radiance: gray(l) });
    let sphere = Sphere { center, radius, rotation: Mat3A::IDENTITY, inward };
    Shape { geometry: Geometry::Sphere(sphere), material: MaterialId(material), emitter }
}

/// A square camera at `eye` that looks at `target`.
pub fn camera(eye: Vec3, target: Vec3, fov_deg: f32, pixels: u32) -> Camera {
    let z = (target - eye).normalize();
    let x = Vec3::Y.cross(z).normalize();
    let to_world = Affine3A::from_mat3_translation(glam::Mat3::from_cols(x, z.cross(x), z), eye);
    let film = Film { width: pixels, height: pixels, crop: None, filter: Filter::Box { radius: 0.5 } };
    Camera { to_world, projection: Projection::Perspective { fov_x: fov_deg.to_radians() }, film, ..Camera::default() }
}

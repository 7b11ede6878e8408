//! Small scenes made in code.

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

/// A box [−1, 1]³ seen from inside, walls of material 0, lit by a small square under its ceiling.
pub fn lit_box(materials: Vec<Material>, content: Vec<Shape>) -> Scene {
    let light = Affine3A::from_scale_rotation_translation(
        Vec3::splat(0.3),
        glam::Quat::from_rotation_x(core::f32::consts::FRAC_PI_2),
        Vec3::new(0.0, 0.98, 0.0),
    );
    let mut shapes =
        vec![mesh(Mesh::cube(Affine3A::IDENTITY).flipped(), 0, None), mesh(Mesh::rectangle(light), 0, Some(8.0))];
    shapes.extend(content);
    Scene {
        shapes,
        material_names: (0..materials.len()).map(|i| format!("m{i}")).collect(),
        materials,
        camera: camera(Vec3::new(0.3, 0.1, 0.95), Vec3::new(-0.1, -0.2, -1.0), 80.0, 24),
        integrator: IntegratorSettings { max_depth: 6, ..IntegratorSettings::default() },
        ..Scene::default()
    }
}

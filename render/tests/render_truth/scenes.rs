//! Small scenes made in code.

pub use crate::pieces::*;
use glam::{Affine3A, Vec3};
use render::scene::*;

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

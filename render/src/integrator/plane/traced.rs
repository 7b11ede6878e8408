//! Hemispheres drawn onto a plane by rays: the readable twin of the rasteriser.

use super::{SurfaceLight, Viewpoint};
use crate::hemisphere::Plane;
use crate::ray::Ray;
use crate::scene::Rgb;
use crate::world::{Queries, World};
use rayon::prelude::*;

impl SurfaceLight {
    /// The pieces that the cells of a plane show, from each viewpoint; 0 where no surface is.
    pub fn pictures(&self, world: &World, viewpoints: &[Viewpoint], plane: &Plane) -> Vec<Vec<u32>> {
        viewpoints.par_iter().map_init(Queries::default, |queries, v| self.picture(world, v, plane, queries)).collect()
    }

    /// Irradiance at each viewpoint, W·m⁻².
    pub fn irradiances(&self, world: &World, viewpoints: &[Viewpoint], plane: &Plane) -> Vec<Rgb> {
        let weights = plane.weights();
        let pictures =
            viewpoints.par_iter().map_init(Queries::default, |queries, v| self.picture(world, v, plane, queries));
        pictures.map(|picture| self.sum(&picture, &weights)).collect()
    }

    /// Irradiance of a picture, given the weights of its cells.
    pub fn sum(&self, picture: &[u32], weights: &[f32]) -> Rgb {
        picture.iter().zip(weights).map(|(piece, weight)| self.radiance(*piece) * *weight).sum()
    }

    fn picture(&self, world: &World, v: &Viewpoint, plane: &Plane, queries: &mut Queries) -> Vec<u32> {
        let cell = |cell| {
            let ray = Ray::new(v.eye, v.frame.to_world(plane.direction(cell)));
            let hit = queries.intersect(world, &ray);
            self.piece(world, &ray, &hit)
        };
        (0..plane.len()).map(cell).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::Frame;
    use crate::hemisphere::Border;
    use crate::scene::{ColorTexture, Geometry, Light, Material, MaterialId, Scene, Shape, Sphere};
    use glam::{Mat3A, Vec3A};

    /// In a hollow sphere with a light of intensity I in its middle every place reflects ρI/πR², so that the irradiance is ρI/R² whichever
    /// way a hemisphere faces; a black border leaves some of it out.
    #[test]
    fn a_hollow_sphere_shines_evenly() {
        let (radius, albedo, intensity) = (2.0, 0.6, Rgb::new(3.0, 5.0, 7.0));
        let sphere = Sphere { center: Vec3A::X, radius, rotation: Mat3A::from_rotation_x(0.4), inward: true };
        let shape = Shape { geometry: Geometry::Sphere(sphere), material: MaterialId(0), emitter: None };
        let world = World::new(Scene {
            shapes: vec![shape],
            materials: vec![Material::Diffuse { reflectance: ColorTexture::Constant(Rgb::splat(albedo)) }],
            material_names: vec!["white".into()],
            lights: vec![Light::Point { position: Vec3A::X, intensity }],
            ..Scene::default()
        });
        let world = world.expect("the scene is valid");
        let light = SurfaceLight::new(&world, 100, 2).expect("it has no holes");
        let expected = albedo * intensity / (radius * radius);
        let facing = |normal: Vec3A, eye| Viewpoint { eye, frame: Frame::from_normal(normal), offset: 1e-6 };
        let viewpoints = [facing(Vec3A::Z, Vec3A::X), facing(Vec3A::new(0.6, 0.0, -0.8), Vec3A::new(0.4, -0.7, 0.9))];
        for border in [Border::Rescaled, Border::Extended, Border::Black] {
            let plane = Plane::new(16, 0.3, border);
            for found in light.irradiances(&world, &viewpoints, &plane) {
                let share = found / expected;
                let least = if border == Border::Black { 0.7 } else { 1.0 - 1e-4 };
                assert!(share.min_element() > least && share.max_element() < 1.0 + 1e-4, "{border:?}: {share}");
                assert!(border != Border::Black || share.max_element() < 0.95, "{share}");
            }
        }
    }
}

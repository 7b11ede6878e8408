//! Surfaces with holes: how much of a surface is there, and what a ray meets behind it.
//!
//! The nearest surface that is there at all decides by a coin whether it stops the ray; where it does not, the ray goes on
//! from beyond it, as if spawned there. So surfaces in the same place count once, in whatever order they are met, and
//! layers that are apart count each. Where a surface is wholly absent or wholly there, no coin and no second search is
//! needed.

use super::World;
use super::aggregate::{Aggregate, Context, Object, transform};
use super::interaction::OFFSET;
use crate::bvh::Stack;
use crate::ray::{Hit, NO_INSTANCE, Ray};
use crate::sampler::toss;
use crate::scene::{Geometry, Sphere};
use glam::{Vec2, Vec3A};

/// The part of a surface that a ray met.
struct Layer {
    opacity: f32,
    /// Where on its primitive: what the coin is thrown by.
    place: Vec2,
    /// Distance along the ray from which it goes on behind the surface.
    beyond: f32,
}

impl Aggregate {
    /// Opacity of triangle `id` at a point, for a ray.
    #[inline]
    pub(super) fn triangle_opacity(&self, context: Context, ray: &Ray, id: u32, b1: f32, b2: f32) -> f32 {
        let triangle = &self.triangles[id as usize];
        let Some(opacity) = &self.masks[triangle.shape as usize] else { return 1.0 };
        let Geometry::Mesh(mesh) = &context.shapes[triangle.shape as usize].geometry else { return 1.0 };
        let coordinates = mesh.coordinates(triangle.index, b1, b2);
        opacity.towards(&context.scene.textures, &coordinates, triangle.normal.into(), ray)
    }

    /// Opacity of a sphere where a ray meets it at distance `t`.
    pub(super) fn sphere_opacity(&self, context: Context, shape: u32, sphere: &Sphere, ray: &Ray, t: f32) -> f32 {
        let Some(Some(opacity)) = self.masks.get(shape as usize) else { return 1.0 };
        let outward = sphere.outward(ray, t);
        let normal = if sphere.inward { -outward } else { outward };
        opacity.towards(&context.scene.textures, &sphere.uv(outward).into(), normal, ray)
    }

    /// What lies at a hit on this aggregate; `None` where nothing passes. `away` adds to the coordinates that were rounded.
    fn layer(&self, context: Context, ray: &Ray, hit: &Hit, away: f32) -> Option<Layer> {
        let (shape, coordinates, place, normal, extent) = match self.triangles.get(hit.primitive as usize) {
            Some(t) => {
                let Geometry::Mesh(mesh) = &context.shapes[t.shape as usize].geometry else { return None };
                let place = Vec2::new(hit.b1, hit.b2);
                (t.shape, mesh.coordinates(t.index, hit.b1, hit.b2), place, Vec3A::from(t.normal), t.extent)
            }
            None => {
                let object = self.objects.get(hit.primitive as usize - self.triangles.len());
                let Some(&Object::Sphere { shape, sphere }) = object else { return None };
                let outward = sphere.outward(ray, hit.t);
                let uv = sphere.uv(outward);
                let normal = if sphere.inward { -outward } else { outward };
                (shape, uv.into(), uv, normal, sphere.center.abs().max_element() + sphere.radius)
            }
        };
        let opacity = self.masks.get(shape as usize)?.as_ref()?;
        let opacity = opacity.towards(&context.scene.textures, &coordinates, normal, ray);
        // As far from the surface as the start of a ray that leaves it; the distance of the hit has its own rounding.
        let clearance = OFFSET * (extent + away + hit.t * ray.direction.length());
        let step = clearance / normal.dot(ray.direction).abs().max(GRAZING * ray.direction.length());
        (opacity < 1.0).then(|| Layer { opacity, place, beyond: (hit.t + step).max(hit.t.next_up()) })
    }
}

/// Cosine below which a ray counts as passing a surface no more slowly.
const GRAZING: f32 = 1.0 / 1024.0;

impl World {
    /// The surface that stops a ray, given the nearest that is there at all. Traces on where coins fall so.
    #[inline(never)]
    pub(super) fn through_masks(&self, stack: &mut Stack, ray: &Ray, mut hit: Hit) -> Hit {
        let mut rest = *ray;
        while hit.exists()
            && let Some(layer) = self.layer(&rest, &hit)
            && !toss(layer.opacity, u64::from(hit.instance) << 32 | u64::from(hit.primitive), layer.place.to_array())
        {
            rest.t_min = layer.beyond;
            hit = Hit { t: ray.t_max, ..Hit::NONE };
            self.aggregate.intersect(self.context(), stack, &rest, &mut hit);
        }
        hit
    }

    fn layer(&self, ray: &Ray, hit: &Hit) -> Option<Layer> {
        if hit.instance == NO_INSTANCE {
            return self.aggregate.layer(self.context(), ray, hit, 0.0);
        }
        let instance = &self.scene.instances[hit.instance as usize];
        let to_group = instance.to_world.inverse();
        let shapes = &self.scene.groups[instance.group as usize].shapes;
        // The transform rounds too, in the coordinates of the world.
        let away = to_group.translation.abs().max_element();
        let context = Context { shapes, ..self.context() };
        self.groups[instance.group as usize].layer(context, &transform(&to_group, ray), hit, away)
    }
}

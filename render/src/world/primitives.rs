//! What rays meet, one by one, for whoever draws it in another way.

use super::World;
use super::aggregate::{Aggregate, Object};
use crate::ray::{Hit, NO_INSTANCE};
use glam::{Affine3A, Mat3A, Vec3A};

/// Where a primitive is, world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Outline {
    /// Three corners; hits count their barycentric coordinates in this order.
    Triangle([Vec3A; 3]),
    /// The points `center` + `axes` d of all unit vectors d, whose poles are on ±z.
    Ellipsoid {
        /// Middle.
        center: Vec3A,
        /// Images of the axes.
        axes: Mat3A,
    },
}

impl World {
    /// Whether a surface has holes, or is not there from some sides.
    pub fn has_holes(&self) -> bool {
        self.masked
    }

    /// All primitives, each with a hit that names it: first those of no instance, then those of each instance, both by their number.
    pub fn primitives(&self) -> impl Iterator<Item = (Hit, Outline)> {
        let placed = self.scene.instances.iter().zip(0..).flat_map(|(instance, number)| {
            let group = &self.groups[instance.group as usize];
            primitives(group, number, instance.to_world)
        });
        primitives(&self.aggregate, NO_INSTANCE, Affine3A::IDENTITY).chain(placed)
    }
}

fn primitives(of: &Aggregate, instance: u32, to_world: Affine3A) -> impl Iterator<Item = (Hit, Outline)> {
    let triangles = of.triangles.iter().map(move |triangle| {
        Outline::Triangle(triangle.positions.map(|p| to_world.transform_point3a(Vec3A::from_vec4(p))))
    });
    // Spheres come before the instances, which are no primitives.
    let spheres = of.objects.iter().filter_map(move |object| match object {
        Object::Sphere { sphere, .. } => Some(Outline::Ellipsoid {
            center: to_world.transform_point3a(sphere.center),
            axes: to_world.matrix3 * sphere.rotation * sphere.radius,
        }),
        Object::Instance { .. } => None,
    });
    let numbered = triangles.chain(spheres).zip(0..);
    numbered.map(move |(outline, primitive)| (Hit { primitive, instance, t: 1.0, ..Hit::NONE }, outline))
}

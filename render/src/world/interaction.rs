//! The surface where a ray ends.

use super::World;
use super::aggregate::{Object, TriangleRef, transform};
use crate::ray::{Hit, NO_INSTANCE, Ray};
use crate::scene::{Coordinates, Geometry, MaterialId, Mesh, Shape, Sphere};
use core::f32::consts::{PI, TAU};
use glam::{Affine3A, Vec2, Vec3A, Vec4};

/// Relative size of the step a ray starts away from its surface, in the largest coordinate of the triangle: a few
/// rounding errors of the intersection, so that no ray meets the surface it leaves.
pub(super) const OFFSET: f32 = 1.0 / (1 << 20) as f32;

/// A point of a surface.
#[derive(Clone, Copy, Debug)]
pub struct Interaction {
    /// Position.
    pub p: Vec3A,
    /// Unit geometric normal of the front.
    pub normal: Vec3A,
    /// Unit normal for shading (interpolated where the mesh has normals), not yet bent by textures.
    pub shading_normal: Vec3A,
    /// ∂p/∂u, zero where unknown.
    pub dpdu: Vec3A,
    /// ∂p/∂v, zero where unknown.
    pub dpdv: Vec3A,
    /// Texture coordinates, and colour of the vertices.
    pub coordinates: Coordinates,
    /// Unit direction to where the ray came from.
    pub wo: Vec3A,
    /// Length of the way to there.
    pub distance: f32,
    /// How the surface scatters.
    pub material: MaterialId,
    /// Number of the emitter, for [`crate::light::Lights`], if the surface emits.
    pub emitter: Option<u32>,
    /// Step that clears the rounding error of `p`.
    pub offset: f32,
}

impl Interaction {
    /// No surface.
    pub(crate) const NOWHERE: Self = Self {
        p: Vec3A::ZERO,
        normal: Vec3A::Z,
        shading_normal: Vec3A::Z,
        dpdu: Vec3A::ZERO,
        dpdv: Vec3A::ZERO,
        coordinates: Coordinates { uv: [Vec2::ZERO; 2], paint: Vec4::ONE },
        wo: Vec3A::Z,
        distance: 0.0,
        material: MaterialId(0),
        emitter: None,
        offset: 0.0,
    };

    /// Where a ray that leaves towards `direction` starts.
    #[inline]
    pub fn origin_towards(&self, direction: Vec3A) -> Vec3A {
        self.p + self.normal * self.offset.copysign(self.normal.dot(direction))
    }

    /// A ray from here in `direction`.
    #[inline]
    pub fn spawn(&self, direction: Vec3A) -> Ray {
        Ray::new(self.origin_towards(direction), direction)
    }

    /// A ray from here to the point `target`, which it does not reach: it ends `clearance` and a little before.
    #[inline]
    pub fn spawn_to(&self, target: Vec3A, clearance: f32) -> Ray {
        let origin = self.origin_towards(target - self.p);
        let direction = target - origin;
        let t_max = 1.0 - 1e-4 - clearance / direction.length().max(f32::MIN_POSITIVE);
        Ray { t_max, ..Ray::new(origin, direction) }
    }
}

impl World {
    /// The surface at a hit of `ray`.
    #[inline(always)]
    pub fn interaction(&self, ray: &Ray, hit: &Hit) -> Interaction {
        if hit.instance != NO_INSTANCE {
            return self.instanced_interaction(ray, hit);
        }
        let aggregate = &self.aggregate;
        match aggregate.triangles.get(hit.primitive as usize) {
            Some(t) => {
                let shape = &self.scene.shapes[t.shape as usize];
                let emitter = self.first_emitter[t.shape as usize].map(|first| first.of_triangle(t.index));
                self.on_triangle(shape, t, ray, hit, emitter)
            }
            None => {
                let Object::Sphere { shape, sphere } =
                    aggregate.objects[hit.primitive as usize - aggregate.triangles.len()]
                else {
                    unreachable!("hits on instances carry the instance")
                };
                let emitter = self.first_emitter[shape as usize].map(|first| first.of_triangle(0));
                on_sphere(&self.scene.shapes[shape as usize], &sphere, ray, hit, emitter)
            }
        }
    }

    #[inline(never)]
    fn instanced_interaction(&self, ray: &Ray, hit: &Hit) -> Interaction {
        let instance = &self.scene.instances[hit.instance as usize];
        let group = &self.groups[instance.group as usize];
        let shapes = &self.scene.groups[instance.group as usize].shapes;
        let to_group = instance.to_world.inverse();
        let local = transform(&to_group, ray);
        let inner = match group.triangles.get(hit.primitive as usize) {
            Some(t) => self.on_triangle(&shapes[t.shape as usize], t, &local, hit, None),
            None => {
                let Object::Sphere { shape, sphere } = group.objects[hit.primitive as usize - group.triangles.len()]
                else {
                    unreachable!("groups hold no instances")
                };
                on_sphere(&shapes[shape as usize], &sphere, &local, hit, None)
            }
        };
        let length = ray.direction.length();
        Interaction { wo: -ray.direction / length, distance: hit.t * length, ..inner.placed(&instance.to_world) }
    }

    #[inline(always)]
    fn on_triangle(
        &self,
        shape: &Shape,
        triangle: &TriangleRef,
        ray: &Ray,
        hit: &Hit,
        emitter: Option<u32>,
    ) -> Interaction {
        let [p0, p1, p2] = triangle.positions;
        let [n0, n1, n2] = triangle.normals;
        let b0 = 1.0 - hit.b1 - hit.b2;
        let (place, bent) = (p0 * b0 + p1 * hit.b1 + p2 * hit.b2, n0 * b0 + n1 * hit.b1 + n2 * hit.b2);
        let normal = Vec3A::from(triangle.normal);
        let shading_normal =
            if triangle.is_smooth { Vec3A::from_vec4(bent).try_normalize().unwrap_or(normal) } else { normal };
        let mesh = || match &shape.geometry {
            Geometry::Mesh(mesh) => mesh,
            Geometry::Sphere(_) => unreachable!("triangles belong to meshes"),
        };
        let [dpdu, dpdv] = if self.needs_tangents[shape.material.0 as usize] {
            let [e1, e2] = [p1, p2].map(|p| Vec3A::from_vec4(p) - Vec3A::from_vec4(p0));
            tangents(mesh(), triangle.index, e1, e2)
        } else {
            [Vec3A::ZERO; 2]
        };
        let coordinates = if triangle.has_more {
            mesh().coordinates(triangle.index, hit.b1, hit.b2)
        } else {
            Vec2::new(place.w, bent.w).into()
        };
        Interaction {
            p: Vec3A::from_vec4(place),
            normal,
            shading_normal,
            dpdu,
            dpdv,
            coordinates,
            wo: -ray.direction,
            distance: hit.t,
            material: shape.material,
            emitter,
            offset: triangle.extent * OFFSET,
        }
    }
}

/// Derivatives of the position by the texture coordinates of a triangle.
fn tangents(mesh: &Mesh, triangle: u32, e1: Vec3A, e2: Vec3A) -> [Vec3A; 2] {
    if mesh.uvs.is_empty() {
        return [e1, e2];
    }
    let [t0, t1, t2] = mesh.corners(triangle).map(|i| mesh.uvs[i]);
    let (d1, d2) = (t1 - t0, t2 - t0);
    let det = d1.perp_dot(d2);
    if det == 0.0 {
        return [Vec3A::ZERO; 2];
    }
    [(e1 * d2.y - e2 * d1.y) / det, (e2 * d1.x - e1 * d2.x) / det]
}

fn on_sphere(shape: &Shape, sphere: &Sphere, ray: &Ray, hit: &Hit, emitter: Option<u32>) -> Interaction {
    let outward = sphere.outward(ray, hit.t);
    let local = sphere.rotation.transpose() * outward;
    let normal = if sphere.inward { -outward } else { outward };
    let sin = local.x.hypot(local.y);
    let along = if sin > 0.0 { Vec2::new(local.x, local.y) / sin } else { Vec2::X };
    let dpdu = sphere.rotation * Vec3A::new(-local.y, local.x, 0.0) * (TAU * sphere.radius);
    let dpdv = sphere.rotation * Vec3A::new(local.z * along.x, local.z * along.y, -sin) * (PI * sphere.radius);
    Interaction {
        p: sphere.center + outward * sphere.radius,
        normal,
        shading_normal: normal,
        dpdu,
        dpdv,
        coordinates: sphere.uv(outward).into(),
        wo: -ray.direction,
        distance: hit.t,
        material: shape.material,
        emitter,
        offset: (sphere.center.abs() + sphere.radius).max_element() * OFFSET,
    }
}

impl Interaction {
    /// The same point after the transform of an instance; `wo` is left to the caller.
    fn placed(self, to_world: &Affine3A) -> Self {
        let m = to_world.matrix3;
        let cofactor =
            glam::Mat3A::from_cols(m.y_axis.cross(m.z_axis), m.z_axis.cross(m.x_axis), m.x_axis.cross(m.y_axis));
        let sign = m.determinant().signum();
        let normal = |n: Vec3A| (cofactor * n * sign).normalize();
        let scale = m.x_axis.abs().max(m.y_axis.abs()).max(m.z_axis.abs()).max_element();
        let p = to_world.transform_point3a(self.p);
        Self {
            p,
            normal: normal(self.normal),
            shading_normal: normal(self.shading_normal),
            dpdu: m * self.dpdu,
            dpdv: m * self.dpdv,
            offset: 2.0 * (self.offset * scale + p.abs().max_element() * OFFSET),
            ..self
        }
    }
}

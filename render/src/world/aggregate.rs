//! Shapes of one space under acceleration structures: triangles in one tree, spheres and instances in another.

use crate::bvh::{Stack, TriangleBvh};
use crate::ray::{Hit, Ray};
use crate::scene::{Coordinates, Geometry, Mesh, Opacity, Scene, Shape, Sphere};
use core::cell::Cell;
use glam::{Affine3A, Vec2, Vec3, Vec3A, Vec4};
use obvhs::aabb::Aabb;
use obvhs::bvh2::{Bvh2, builder::build_bvh2};
use obvhs::{Boundable, BvhBuildParams};
use rayon::prelude::*;
use std::time::Duration;

/// Triangles that are worth handing to another thread.
const BATCH: usize = 1 << 12;

/// A triangle of a shape, and all of it that most surfaces need, side by side: two lines of the cache in place of those of the
/// index, the indices, and three vertices in as many lists.
#[repr(C, align(64))]
#[derive(Clone, Copy, Debug)]
pub(super) struct TriangleRef {
    /// Positions, and the first coordinate of the texture.
    pub positions: [Vec4; 3],
    /// Normals, zero where there are none, and the second coordinate of the texture.
    pub normals: [Vec4; 3],
    /// Unit normal of the front; any without area.
    pub normal: [f32; 3],
    /// Largest coordinate.
    pub extent: f32,
    pub shape: u32,
    pub index: u32,
    /// Whether the vertices have normals.
    pub is_smooth: bool,
    /// Whether the vertices have more: a second set of coordinates, or colours.
    pub has_more: bool,
}

impl TriangleRef {
    fn new(shape: u32, index: u32, mesh: &Mesh) -> Self {
        let corners = mesh.corners(index);
        let [p0, p1, p2] = corners.map(|i| Vec3A::from(mesh.positions[i]));
        let uvs = if mesh.uvs.is_empty() { BARYCENTRIC } else { corners.map(|i| mesh.uvs[i]) };
        let is_smooth = !mesh.normals.is_empty();
        let normal = |k: usize| if is_smooth { mesh.normals[corners[k]] } else { Vec3::ZERO };
        Self {
            positions: [p0.extend(uvs[0].x), p1.extend(uvs[1].x), p2.extend(uvs[2].x)],
            normals: [0, 1, 2].map(|k| normal(k).extend(uvs[k].y)),
            normal: (p1 - p0).cross(p2 - p0).normalize_or(Vec3A::Z).to_array(),
            extent: p0.abs().max(p1.abs()).max(p2.abs()).max_element(),
            shape,
            index,
            is_smooth,
            has_more: !(mesh.second_uvs.is_empty() && mesh.colors.is_empty()),
        }
    }
}

/// Texture coordinates of the vertices of a triangle without any.
const BARYCENTRIC: [Vec2; 3] = [Vec2::ZERO, Vec2::X, Vec2::Y];

/// What the second tree holds.
#[derive(Clone, Copy, Debug)]
pub(super) enum Object {
    Sphere { shape: u32, sphere: Sphere },
    Instance { index: u32, group: u32, to_group: Affine3A },
}

/// A set of shapes ready for ray queries. Primitives are numbered: triangles first, then objects.
#[derive(Clone)]
pub(super) struct Aggregate {
    bvh: TriangleBvh,
    pub triangles: Vec<TriangleRef>,
    pub objects: Vec<Object>,
    object_bvh: Option<Bvh2>,
    bounds: (Vec3A, Vec3A),
    /// Opacity of the shapes that have holes; empty without such.
    pub masks: Vec<Option<Opacity>>,
}

/// What queries look up besides the trees: the scene, and the shapes of the aggregate.
#[derive(Clone, Copy)]
pub(super) struct Context<'a> {
    pub scene: &'a Scene,
    pub shapes: &'a [Shape],
    pub groups: &'a [Aggregate],
}

struct Bounds(Vec3A, Vec3A);

impl Boundable for Bounds {
    fn aabb(&self) -> Aabb {
        Aabb::new(self.0, self.1)
    }
}

/// The placement of an aggregate in the space of another.
pub(super) struct Placement {
    pub index: u32,
    pub group: u32,
    pub to_world: Affine3A,
}

impl Aggregate {
    /// Builds the trees over the context's shapes and over `placements` of its groups.
    pub fn new(context: Context, placements: &[Placement]) -> Self {
        let Context { scene, shapes, groups } = context;
        let (mut triangles, mut vertices, mut objects, mut boxes) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        for (shape, s) in shapes.iter().enumerate() {
            let shape = shape as u32;
            match &s.geometry {
                Geometry::Mesh(m) => {
                    let corners = |t: &[u32; 3]| t.map(|i| Vec3A::from(m.positions[i as usize]));
                    let list = m.triangles.par_iter().with_min_len(BATCH);
                    vertices.par_extend(list.clone().map(corners));
                    triangles.par_extend(list.enumerate().map(|(index, _)| TriangleRef::new(shape, index as u32, m)));
                }
                Geometry::Sphere(sphere) => {
                    objects.push(Object::Sphere { shape, sphere: *sphere });
                    boxes.push(Bounds(sphere.center - sphere.radius, sphere.center + sphere.radius));
                }
            }
        }
        for p in placements {
            let (min, max) = groups[p.group as usize].bounds;
            if min.cmple(max).all() {
                objects.push(Object::Instance { index: p.index, group: p.group, to_group: p.to_world.inverse() });
                boxes.push(placed_bounds(min, max, &p.to_world));
            }
        }
        let bvh = TriangleBvh::new(&vertices);
        let bounds = boxes.iter().fold(bvh.bounds(), |(min, max), b| (min.min(b.0), max.max(b.1)));
        let params = BvhBuildParams::medium_build();
        let object_bvh = (!boxes.is_empty()).then(|| build_bvh2(&boxes, params, &mut Duration::default()));
        let mut masks: Vec<_> = shapes.iter().map(|s| Opacity::of(scene, s.material)).collect();
        if masks.iter().all(Option::is_none) {
            masks.clear();
        }
        Self { bvh, triangles, objects, object_bvh, bounds, masks }
    }

    /// Smallest and largest corner; min > max without shapes.
    pub fn bounds(&self) -> (Vec3A, Vec3A) {
        self.bounds
    }

    /// Whether a surface has holes.
    pub fn is_masked(&self) -> bool {
        !self.masks.is_empty()
    }

    /// The tree that holds all there is, if nothing has holes.
    #[inline]
    pub fn triangles_alone(&self) -> Option<&TriangleBvh> {
        (self.masks.is_empty() && self.object_bvh.is_none()).then_some(&self.bvh)
    }

    /// Nearest intersection before `hit.t` with a surface that is not wholly absent there.
    #[inline(always)]
    pub fn intersect(&self, context: Context, stack: &mut Stack, ray: &Ray, hit: &mut Hit) {
        if self.masks.is_empty() {
            self.bvh.intersect(stack, ray, hit, |_, _, _| true);
        } else {
            self.bvh.intersect(stack, ray, hit, |id, b1, b2| self.triangle_opacity(context, ray, id, b1, b2) > 0.0);
        }
        if self.object_bvh.is_some() {
            self.intersect_objects(context, stack, ray, hit);
        }
    }

    /// Whether a surface that is not wholly absent lies within the ray's bounds. `partly` becomes true where the one found is
    /// there in part only: another may stop the ray for certain.
    #[inline(always)]
    pub fn occluded(&self, context: Context, stack: &mut Stack, ray: &Ray, partly: &Cell<bool>) -> bool {
        let by_triangle = if self.masks.is_empty() {
            self.bvh.occluded(stack, ray, |_, _, _| true)
        } else {
            self.bvh
                .occluded(stack, ray, |id, b1, b2| may_stop(self.triangle_opacity(context, ray, id, b1, b2), partly))
        };
        by_triangle || (self.object_bvh.is_some() && self.occluded_by_objects(context, stack, ray, partly))
    }

    #[inline(never)]
    fn occluded_by_objects(&self, context: Context, stack: &mut Stack, ray: &Ray, partly: &Cell<bool>) -> bool {
        let Some(bvh) = &self.object_bvh else { return false };
        let start = obvhs::ray::Ray::new(ray.origin, ray.direction, ray.t_min, ray.t_max);
        !bvh.ray_traverse_miss(start, |_, slot| {
            let occluded = match self.objects[bvh.primitive_indices[slot] as usize] {
                Object::Sphere { shape, sphere } => sphere
                    .hits(ray)
                    .into_iter()
                    .flatten()
                    .filter(|&t| t > ray.t_min && t < ray.t_max)
                    .any(|t| may_stop(self.sphere_opacity(context, shape, &sphere, ray, t), partly)),
                Object::Instance { group, to_group, .. } => {
                    let shapes = &context.scene.groups[group as usize].shapes;
                    let local = transform(&to_group, ray);
                    context.groups[group as usize].occluded(Context { shapes, ..context }, stack, &local, partly)
                }
            };
            // Any distance within the bounds ends the search.
            if occluded { ray.t_min } else { f32::INFINITY }
        })
    }

    #[inline(never)]
    fn intersect_objects(&self, context: Context, stack: &mut Stack, ray: &Ray, hit: &mut Hit) {
        let Some(bvh) = &self.object_bvh else { return };
        let mut scratch = obvhs::ray::RayHit::none();
        let start = obvhs::ray::Ray::new(ray.origin, ray.direction, ray.t_min, hit.t);
        bvh.ray_traverse(start, &mut scratch, |_, slot| {
            let index = bvh.primitive_indices[slot];
            match self.objects[index as usize] {
                Object::Sphere { shape, sphere } => {
                    let mut roots = sphere.hits(ray).into_iter().flatten();
                    let there = |t: f32| self.sphere_opacity(context, shape, &sphere, ray, t) > 0.0;
                    if let Some(t) = roots.find(|&t| t > ray.t_min && t < hit.t && there(t)) {
                        let primitive = self.triangles.len() as u32 + index;
                        *hit = Hit { t, primitive, ..Hit::NONE };
                    }
                }
                Object::Instance { index, group, to_group } => {
                    let shapes = &context.scene.groups[group as usize].shapes;
                    let mut inner = Hit { t: hit.t, ..Hit::NONE };
                    let local = transform(&to_group, ray);
                    context.groups[group as usize].intersect(Context { shapes, ..context }, stack, &local, &mut inner);
                    if inner.exists() {
                        *hit = Hit { instance: index, ..inner };
                    }
                }
            }
            hit.t
        });
    }
}

/// Whether a surface of this opacity may stop a ray; notes if that is not certain.
#[inline]
fn may_stop(opacity: f32, partly: &Cell<bool>) -> bool {
    partly.set(opacity < 1.0);
    opacity > 0.0
}

impl Mesh {
    /// Indices of the vertices of a triangle.
    #[inline]
    pub(super) fn corners(&self, triangle: u32) -> [usize; 3] {
        self.triangles[triangle as usize].map(|i| i as usize)
    }

    /// Texture coordinates and colour of a point of a triangle; barycentrics where the mesh has no coordinates.
    #[inline]
    pub(super) fn coordinates(&self, triangle: u32, b1: f32, b2: f32) -> Coordinates {
        let corners = self.corners(triangle);
        let uv = |uvs: &[Vec2]| {
            let [t0, t1, t2] = corners.map(|i| uvs[i]);
            t0 * (1.0 - b1 - b2) + t1 * b1 + t2 * b2
        };
        let first = if self.uvs.is_empty() { Vec2::new(b1, b2) } else { uv(&self.uvs) };
        let second = if self.second_uvs.is_empty() { first } else { uv(&self.second_uvs) };
        let paint = if self.colors.is_empty() {
            Vec4::ONE
        } else {
            let [c0, c1, c2] = corners.map(|i| Vec4::from_array(self.colors[i]));
            c0 * (1.0 - b1 - b2) + c1 * b1 + c2 * b2
        };
        Coordinates { uv: [first, second], paint }
    }
}

/// The ray in the space `t` leads to; distances along it stay the same.
pub(super) fn transform(t: &Affine3A, ray: &Ray) -> Ray {
    Ray { origin: t.transform_point3a(ray.origin), direction: t.transform_vector3a(ray.direction), ..*ray }
}

fn placed_bounds(min: Vec3A, max: Vec3A, to_world: &Affine3A) -> Bounds {
    let center = to_world.transform_point3a(0.5 * (min + max));
    let half = to_world.matrix3.abs() * (0.5 * (max - min));
    Bounds(center - half, center + half)
}

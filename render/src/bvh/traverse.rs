//! Ray queries: eight boxes or eight triangles per step, in the widest instructions the machine has.

use super::stack::{Lanes, Stack};
use super::{LEAF, Leaf, Node, TriangleBvh, WIDTH, turns};
use crate::ray::{Hit, Ray};
use crate::simd::prefetch;
use core::ops::ControlFlow;
use fearless_simd::{Simd, SimdBase, SimdMask, dispatch, f32x8, mask32x8};
use glam::Vec3A;

impl TriangleBvh {
    /// Nearest intersection between `ray.t_min` and `hit.t` of which `accept(triangle, b1, b2)` approves, written to `hit`.
    #[inline(always)]
    pub fn intersect(&self, stack: &mut Stack, ray: &Ray, hit: &mut Hit, accept: impl Fn(u32, f32, f32) -> bool) {
        let Some(root) = self.root else { return };
        dispatch!(self.level, simd => nearest(simd, self, root, stack, ray, hit, accept));
    }

    /// Whether anything of which `accept` approves lies between `ray.t_min` and `ray.t_max`.
    #[inline(always)]
    pub fn occluded(&self, stack: &mut Stack, ray: &Ray, accept: impl Fn(u32, f32, f32) -> bool) -> bool {
        let Some(root) = self.root else { return false };
        dispatch!(self.level, simd => any(simd, self, root, stack, ray, accept))
    }
}

impl TriangleBvh {
    /// [`TriangleBvh::intersect`] of the rays whose bit is set, whatever they meet.
    #[inline(always)]
    pub fn intersect_all<const N: usize>(&self, stack: &mut Stack, rays: &[Ray; N], which: u32, hits: &mut [Hit; N]) {
        let Some(root) = self.root else { return };
        dispatch!(self.level, simd => {
            if self.is_large() {
                turns::nearest(simd, self, root, rays, which, hits);
            } else {
                for i in Lanes(which) {
                    nearest(simd, self, root, stack, &rays[i], &mut hits[i], |_, _, _| true);
                }
            }
        });
    }

    /// [`TriangleBvh::occluded`] of the rays whose bit is set, whatever they meet: the bits of those that are.
    #[inline(always)]
    pub fn occluded_all<const N: usize>(&self, stack: &mut Stack, rays: &[Ray; N], which: u32) -> u32 {
        let Some(root) = self.root else { return 0 };
        dispatch!(self.level, simd => {
            if self.is_large() {
                turns::any(simd, self, root, rays, which)
            } else {
                let mut met = 0;
                for i in Lanes(which) {
                    met |= u32::from(any(simd, self, root, stack, &rays[i], |_, _, _| true)) << i;
                }
                met
            }
        })
    }
}

/// Bytes from which on a tree is much larger than the caches.
const LARGE: usize = 1 << 25;

impl TriangleBvh {
    /// Whether rays wait for the memory more than they compute.
    #[inline(always)]
    fn is_large(&self) -> bool {
        self.bytes() > LARGE
    }

    /// Begins to fetch what a reference leads to.
    #[inline(always)]
    pub(super) fn fetch(&self, child: u32) {
        if child & LEAF != 0 {
            let leaf = &self.leaves[(child & !LEAF) as usize];
            prefetch(&leaf.vertices[0][0]);
            prefetch(&leaf.vertices[0][2]);
            prefetch(&leaf.vertices[1][1]);
            prefetch(&leaf.vertices[2][0]);
            prefetch(&leaf.vertices[2][2]);
        } else {
            let node = &self.nodes[child as usize];
            prefetch(&node.bounds[0]);
            prefetch(&node.bounds[2]);
            prefetch(&node.bounds[4]);
            prefetch(&node.children);
        }
    }
}

/// What a ray needs in the box test.
struct BoxTest<S: Simd> {
    origin: [f32x8<S>; 3],
    inverse: [f32x8<S>; 3],
    /// Index into [`Node::bounds`] of the near and the far plane of each axis.
    near: [usize; 3],
    far: [usize; 3],
}

impl<S: Simd> BoxTest<S> {
    #[inline(always)]
    fn new(simd: S, ray: &Ray) -> Self {
        // A direction component near zero is replaced by one whose inverse is finite, so that no 0 · ∞ appears.
        let (o, d) = (ray.origin, ray.direction);
        let tiny = Vec3A::splat(1e-18);
        let d = Vec3A::select(d.abs().cmplt(tiny), tiny.copysign(d), d).recip();
        let sign = d.is_negative_bitmask() as usize;
        let near = [3 * (sign & 1), 1 + 3 * (sign >> 1 & 1), 2 + 3 * (sign >> 2 & 1)];
        Self {
            origin: [f32x8::splat(simd, o.x), f32x8::splat(simd, o.y), f32x8::splat(simd, o.z)],
            inverse: [f32x8::splat(simd, d.x), f32x8::splat(simd, d.y), f32x8::splat(simd, d.z)],
            near,
            far: [3 - near[0], 5 - near[1], 7 - near[2]],
        }
    }

    /// Distances to a plane of each child's box, on one axis.
    #[inline(always)]
    fn plane(&self, simd: S, node: &Node, plane: usize, axis: usize) -> f32x8<S> {
        (f32x8::load_array_ref(simd, &node.bounds[plane]) - self.origin[axis]) * self.inverse[axis]
    }

    /// Entry distances, and the lanes whose box meets (t_min, t_max). The far distance is enlarged by the rounding
    /// error of the test (Ize 2013, "Robust BVH ray traversal").
    #[inline(always)]
    fn test(&self, simd: S, node: &Node, t_min: f32, t_max: f32) -> (f32x8<S>, mask32x8<S>) {
        let near = self.plane(simd, node, self.near[0], 0).max(self.plane(simd, node, self.near[1], 1));
        let near = near.max(self.plane(simd, node, self.near[2], 2)).max(f32x8::splat(simd, t_min));
        let far = self.plane(simd, node, self.far[0], 0).min(self.plane(simd, node, self.far[1], 1));
        let far = far.min(self.plane(simd, node, self.far[2], 2)) * f32x8::splat(simd, 1.000_000_4);
        let far = far.min(f32x8::splat(simd, t_max));
        (near, near.simd_le(far))
    }
}

/// What a ray needs in the triangle test of Woop, Benthin and Wald 2013, "Watertight ray/triangle intersection".
struct TriangleTest<S: Simd> {
    /// Axes, the last the one along which the ray moves most.
    axes: [usize; 3],
    origin: [f32x8<S>; 3],
    shear: [f32x8<S>; 3],
}

impl<S: Simd> TriangleTest<S> {
    #[inline(always)]
    fn new(simd: S, ray: &Ray) -> Self {
        let d = ray.direction.abs();
        // The first of the largest, without branches.
        let kz = (d.cmpge(Vec3A::splat(d.max_element())).bitmask().trailing_zeros() as usize).min(2);
        let (kx, ky) = ([1, 2, 0][kz], [2, 0, 1][kz]);
        let inverse = 1.0 / ray.direction[kz];
        Self {
            axes: [kx, ky, kz],
            origin: [
                f32x8::splat(simd, ray.origin[kx]),
                f32x8::splat(simd, ray.origin[ky]),
                f32x8::splat(simd, ray.origin[kz]),
            ],
            shear: [
                f32x8::splat(simd, ray.direction[kx] * inverse),
                f32x8::splat(simd, ray.direction[ky] * inverse),
                f32x8::splat(simd, inverse),
            ],
        }
    }

    /// Vertices where the ray is the z axis: relative to its origin, sheared.
    #[inline(always)]
    fn vertex(&self, simd: S, v: &[[f32; WIDTH]; 3]) -> [f32x8<S>; 3] {
        let [kx, ky, kz] = self.axes;
        let x = f32x8::load_array_ref(simd, &v[kx]) - self.origin[0];
        let y = f32x8::load_array_ref(simd, &v[ky]) - self.origin[1];
        let z = f32x8::load_array_ref(simd, &v[kz]) - self.origin[2];
        [x - self.shear[0] * z, y - self.shear[1] * z, z]
    }

    /// Lanes hit in (t_min, t_max), with distances and the weights of the second and third vertex.
    #[inline(always)]
    fn test(&self, simd: S, leaf: &Leaf, t_min: f32, t_max: f32) -> (mask32x8<S>, [f32x8<S>; 3]) {
        let [ax, ay, az] = self.vertex(simd, &leaf.vertices[0]);
        let [bx, by, bz] = self.vertex(simd, &leaf.vertices[1]);
        let [cx, cy, cz] = self.vertex(simd, &leaf.vertices[2]);
        // Scaled barycentrics. No fused operation: the triangle beyond an edge must find the exact opposite.
        let (u, v, w) = (cx * by - cy * bx, ax * cy - ay * cx, bx * ay - by * ax);
        let zero = f32x8::splat(simd, 0.0);
        let (low, high) = (u.min(v).min(w), u.max(v).max(w));
        let det = u + v + w;
        let inside = (low.simd_ge(zero) | high.simd_le(zero)) & !det.simd_eq(zero);
        let inverse = f32x8::splat(simd, 1.0) / det;
        let t = (u * az + v * bz + w * cz) * self.shear[2] * inverse;
        let mask = inside & t.simd_gt(f32x8::splat(simd, t_min)) & t.simd_lt(f32x8::splat(simd, t_max));
        (mask, [t, v * inverse, w * inverse])
    }
}

/// The tests of a ray.
pub(super) struct Tests<S: Simd> {
    boxes: BoxTest<S>,
    triangles: TriangleTest<S>,
    t_min: f32,
}

impl<S: Simd> Tests<S> {
    #[inline(always)]
    pub fn new(simd: S, ray: &Ray) -> Self {
        Self { boxes: BoxTest::new(simd, ray), triangles: TriangleTest::new(simd, ray), t_min: ray.t_min }
    }

    /// Looks at what a reference leads to, and keeps the nearest hit of which `accept` approves; what to look at next.
    #[inline(always)]
    pub fn nearest(
        &self,
        simd: S,
        bvh: &TriangleBvh,
        stack: &mut Stack,
        current: u32,
        hit: &mut Hit,
        accept: &impl Fn(u32, f32, f32) -> bool,
    ) -> Option<u32> {
        if current & LEAF != 0 {
            // Take the nearest accepted triangle of the leaf.
            let leaf = &bvh.leaves[(current & !LEAF) as usize];
            let (mask, values) = self.triangles.test(simd, leaf, self.t_min, hit.t);
            let lanes = mask.to_bitmask() as u32;
            if lanes != 0 {
                let [mut t, mut b1, mut b2] = [[0f32; WIDTH]; 3];
                values[0].store_array(&mut t);
                values[1].store_array(&mut b1);
                values[2].store_array(&mut b2);
                for lane in Lanes(lanes) {
                    if t[lane] < hit.t && accept(leaf.ids[lane], b1[lane], b2[lane]) {
                        *hit = Hit { t: t[lane], b1: b1[lane], b2: b2[lane], primitive: leaf.ids[lane], ..*hit };
                    }
                }
            }
        } else {
            // Visit the children from near to far.
            let node = &bvh.nodes[current as usize];
            let (near, mask) = self.boxes.test(simd, node, self.t_min, hit.t);
            let mut lanes = mask.to_bitmask() as u32;
            if lanes != 0 {
                let mut t = [0f32; WIDTH];
                near.store_array(&mut t);
                let entry = |lane: usize| u64::from(t[lane].to_bits()) << 32 | u64::from(node.children[lane]);
                let mut best = entry(lanes.trailing_zeros() as usize);
                lanes &= lanes - 1;
                if lanes != 0 {
                    stack.push(Lanes(lanes).map(|lane| {
                        bvh.fetch(node.children[lane]);
                        let other = entry(lane);
                        let farther = best.max(other);
                        best = best.min(other);
                        farther
                    }));
                }
                return Some(best as u32);
            }
        }
        loop {
            let entry = stack.pop()?;
            if f32::from_bits((entry >> 32) as u32) <= hit.t {
                return Some(entry as u32);
            }
        }
    }

    /// Looks at what a reference leads to: what to look at next, or whether the ray meets anything of which `accept` approves
    /// before `t_max`.
    #[inline(always)]
    pub fn any(
        &self,
        simd: S,
        bvh: &TriangleBvh,
        stack: &mut Stack,
        current: u32,
        t_max: f32,
        accept: &impl Fn(u32, f32, f32) -> bool,
    ) -> ControlFlow<bool, u32> {
        if current & LEAF != 0 {
            let leaf = &bvh.leaves[(current & !LEAF) as usize];
            let (mask, [_, b1, b2]) = self.triangles.test(simd, leaf, self.t_min, t_max);
            for lane in Lanes(mask.to_bitmask() as u32) {
                if accept(leaf.ids[lane], b1.as_slice()[lane], b2.as_slice()[lane]) {
                    return ControlFlow::Break(true);
                }
            }
        } else {
            let node = &bvh.nodes[current as usize];
            let lanes = self.boxes.test(simd, node, self.t_min, t_max).1.to_bitmask() as u32;
            stack.push_any(Lanes(lanes).map(|lane| {
                bvh.fetch(node.children[lane]);
                u64::from(node.children[lane])
            }));
        }
        stack.pop().map_or(ControlFlow::Break(false), |entry| ControlFlow::Continue(entry as u32))
    }
}

/// Finds the nearest hit of a ray.
#[inline(always)]
fn nearest<S: Simd>(
    simd: S,
    bvh: &TriangleBvh,
    root: u32,
    stack: &mut Stack,
    ray: &Ray,
    hit: &mut Hit,
    accept: impl Fn(u32, f32, f32) -> bool,
) {
    let tests = Tests::new(simd, ray);
    stack.clear();
    let mut next = Some(root);
    while let Some(current) = next {
        next = tests.nearest(simd, bvh, stack, current, hit, &accept);
    }
}

/// Whether a ray hits anything.
#[inline(always)]
fn any<S: Simd>(
    simd: S,
    bvh: &TriangleBvh,
    root: u32,
    stack: &mut Stack,
    ray: &Ray,
    accept: impl Fn(u32, f32, f32) -> bool,
) -> bool {
    let tests = Tests::new(simd, ray);
    stack.clear();
    let mut current = root;
    loop {
        match tests.any(simd, bvh, stack, current, ray.t_max, &accept) {
            ControlFlow::Continue(next) => current = next,
            ControlFlow::Break(met) => return met,
        }
    }
}

//! Ray queries: eight boxes or eight triangles per step, in the widest instructions the machine has.

use super::stack::{Lanes, Stack};
use super::{LEAF, Leaf, Node, TriangleBvh, WIDTH};
use crate::ray::{Hit, Ray};
use fearless_simd::{Simd, SimdBase, SimdMask, dispatch, f32x8, mask32x8};
use glam::Vec3A;

impl TriangleBvh {
    /// Nearest intersection between `ray.t_min` and `hit.t` of which `accept(triangle, b1, b2)` approves, written to `hit`.
    #[inline(always)]
    pub fn intersect(
        &self,
        stack: &mut Stack,
        ray: &Ray,
        hit: &mut Hit,
        accept: impl Fn(u32, f32, f32) -> bool,
    ) -> bool {
        let Some(root) = self.root else { return false };
        dispatch!(self.level, simd => nearest(simd, self, root, stack, ray, hit, accept))
    }

    /// Whether anything of which `accept` approves lies between `ray.t_min` and `ray.t_max`.
    #[inline(always)]
    pub fn occluded(&self, stack: &mut Stack, ray: &Ray, accept: impl Fn(u32, f32, f32) -> bool) -> bool {
        let Some(root) = self.root else { return false };
        dispatch!(self.level, simd => any(simd, self, root, stack, ray, accept))
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

#[inline(always)]
fn nearest<S: Simd>(
    simd: S,
    bvh: &TriangleBvh,
    root: u32,
    stack: &mut Stack,
    ray: &Ray,
    hit: &mut Hit,
    accept: impl Fn(u32, f32, f32) -> bool,
) -> bool {
    let (boxes, triangles) = (BoxTest::new(simd, ray), TriangleTest::new(simd, ray));
    stack.clear();
    let mut current = root;
    let mut found = false;
    loop {
        if current & LEAF != 0 {
            // Take the nearest accepted triangle of the leaf.
            let leaf = &bvh.leaves[(current & !LEAF) as usize];
            let (mask, values) = triangles.test(simd, leaf, ray.t_min, hit.t);
            let lanes = mask.to_bitmask() as u32;
            if lanes != 0 {
                let [mut t, mut b1, mut b2] = [[0f32; WIDTH]; 3];
                values[0].store_array(&mut t);
                values[1].store_array(&mut b1);
                values[2].store_array(&mut b2);
                for lane in Lanes(lanes) {
                    if t[lane] < hit.t && accept(leaf.ids[lane], b1[lane], b2[lane]) {
                        *hit = Hit { t: t[lane], b1: b1[lane], b2: b2[lane], primitive: leaf.ids[lane], ..*hit };
                        found = true;
                    }
                }
            }
        } else {
            // Visit the children from near to far.
            let node = &bvh.nodes[current as usize];
            let (near, mask) = boxes.test(simd, node, ray.t_min, hit.t);
            let mut lanes = mask.to_bitmask() as u32;
            if lanes != 0 {
                let mut t = [0f32; WIDTH];
                near.store_array(&mut t);
                let entry = |lane: usize| u64::from(t[lane].to_bits()) << 32 | u64::from(node.children[lane]);
                let mut best = entry(lanes.trailing_zeros() as usize);
                lanes &= lanes - 1;
                if lanes != 0 {
                    stack.push(Lanes(lanes).map(|lane| {
                        let other = entry(lane);
                        let farther = best.max(other);
                        best = best.min(other);
                        farther
                    }));
                }
                current = best as u32;
                continue;
            }
        }
        loop {
            let Some(entry) = stack.pop() else { return found };
            if f32::from_bits((entry >> 32) as u32) <= hit.t {
                current = entry as u32;
                break;
            }
        }
    }
}

#[inline(always)]
fn any<S: Simd>(
    simd: S,
    bvh: &TriangleBvh,
    root: u32,
    stack: &mut Stack,
    ray: &Ray,
    accept: impl Fn(u32, f32, f32) -> bool,
) -> bool {
    let (boxes, triangles) = (BoxTest::new(simd, ray), TriangleTest::new(simd, ray));
    stack.clear();
    let mut next = Some(u64::from(root));
    while let Some(entry) = next {
        let current = entry as u32;
        if current & LEAF != 0 {
            let leaf = &bvh.leaves[(current & !LEAF) as usize];
            let (mask, [_, b1, b2]) = triangles.test(simd, leaf, ray.t_min, ray.t_max);
            for lane in Lanes(mask.to_bitmask() as u32) {
                if accept(leaf.ids[lane], b1.as_slice()[lane], b2.as_slice()[lane]) {
                    return true;
                }
            }
        } else {
            let node = &bvh.nodes[current as usize];
            let lanes = boxes.test(simd, node, ray.t_min, ray.t_max).1.to_bitmask() as u32;
            stack.push_any(Lanes(lanes).map(|lane| u64::from(node.children[lane])));
        }
        next = stack.pop();
    }
    false
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus as StdRng;

    /// The plain Möller–Trumbore test of one triangle: the readable twin of the vector code, used by the tests.
    fn intersect_triangle([a, b, c]: [Vec3A; 3], ray: &Ray) -> Option<f32> {
        let (e1, e2) = (b - a, c - a);
        let p = ray.direction.cross(e2);
        let det = e1.dot(p);
        let s = ray.origin - a;
        let q = s.cross(e1);
        let (u, v, t) = (s.dot(p) / det, ray.direction.dot(q) / det, e2.dot(q) / det);
        (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > ray.t_min && t < ray.t_max).then_some(t)
    }

    fn soup(n: usize, rng: &mut StdRng) -> Vec<[Vec3A; 3]> {
        let mut point = |s: f32| Vec3A::from_array(core::array::from_fn(|_| rng.random_range(-s..s)));
        (0..n)
            .map(|_| {
                let p = point(1.0);
                [p, p + point(0.2), p + point(0.2)]
            })
            .collect()
    }

    #[test]
    fn agrees_with_the_plain_test_of_every_triangle() {
        let mut rng = StdRng::seed_from_u64(1);
        for n in [0, 1, 2, 7, 8, 9, 65, 1000] {
            let triangles = soup(n, &mut rng);
            let bvh = TriangleBvh::new(&triangles);
            let mut stack = Stack::default();
            for i in 0..500 {
                let mut v = || Vec3A::from_array(core::array::from_fn(|_| rng.random_range(-1.5f32..1.5)));
                let (origin, direction) = (v(), if i % 5 == 0 { Vec3A::X } else { v().normalize() });
                let ray = Ray::new(origin, direction);
                let expected =
                    triangles.iter().filter_map(|t| intersect_triangle(*t, &ray)).fold(f32::INFINITY, f32::min);
                let mut hit = Hit { t: ray.t_max, ..Hit::NONE };
                assert_eq!(
                    bvh.intersect(&mut stack, &ray, &mut hit, |_, _, _| true),
                    expected.is_finite(),
                    "{n} triangles, ray {i}"
                );
                assert!(hit.t == expected || (hit.t - expected).abs() < 1e-5 * expected, "{} {expected}", hit.t);
                assert_eq!(bvh.occluded(&mut stack, &ray, |_, _, _| true), expected.is_finite());
                if hit.exists() {
                    let [a, b, c] = triangles[hit.primitive as usize];
                    let p = a * (1.0 - hit.b1 - hit.b2) + b * hit.b1 + c * hit.b2;
                    assert!((p - origin - direction * hit.t).length() < 1e-4);
                    assert!(!bvh.occluded(&mut stack, &Ray { t_max: hit.t * 0.999, ..ray }, |_, _, _| true));
                }
            }
        }
    }

    /// A closed, irregular surface seen from inside: every ray must hit it, also towards vertices and along edges.
    #[test]
    fn no_ray_leaves_a_closed_mesh() {
        let n = 40;
        let point = |i: usize, j: usize| {
            let (s, c) = (core::f32::consts::TAU * (i % n) as f32 / n as f32).sin_cos();
            let (st, ct) = (core::f32::consts::PI * j as f32 / n as f32).sin_cos();
            let r = 1.0 + 0.3 * ((7 * (i % n) + 3 * j) as f32).sin();
            if j == 0 || j == n { Vec3A::new(0.0, 0.0, ct.signum()) } else { Vec3A::new(st * c, st * s, ct) * r }
        };
        let mut triangles = Vec::new();
        for i in 0..n {
            for j in 0..n {
                let [a, b, c, d] = [point(i, j), point(i + 1, j), point(i + 1, j + 1), point(i, j + 1)];
                triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
        let bvh = TriangleBvh::new(&triangles);
        let mut stack = Stack::default();
        let origin = Vec3A::new(0.05, -0.02, 0.03);
        let targets =
            triangles.iter().flat_map(|[a, b, c]| [*a, (*a + *b) * 0.5, b.lerp(*c, 0.3), (*a + *b + *c) / 3.0]);
        for target in targets {
            assert!(bvh.occluded(&mut stack, &Ray::new(origin, target - origin), |_, _, _| true), "towards {target}");
        }
    }

    #[test]
    fn degenerate_input_ends() {
        let mut stack = Stack::default();
        let triangles = vec![[Vec3A::ONE; 3]; 5000];
        let bvh = TriangleBvh::new(&triangles);
        assert!(!bvh.occluded(&mut stack, &Ray::new(Vec3A::ZERO, Vec3A::ONE), |_, _, _| true));
        let stacked = vec![[Vec3A::ZERO, Vec3A::X, Vec3A::Y]; 5000];
        let bvh = TriangleBvh::new(&stacked);
        assert!(bvh.occluded(&mut stack, &Ray::new(Vec3A::new(0.2, 0.2, 1.0), Vec3A::NEG_Z), |_, _, _| true));
    }
}

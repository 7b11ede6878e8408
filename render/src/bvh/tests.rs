//! Queries against the plain test of every triangle.

use super::{Stack, TriangleBvh};
use crate::ray::{Hit, Ray};
use glam::Vec3A;
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
            let expected = triangles.iter().filter_map(|t| intersect_triangle(*t, &ray)).fold(f32::INFINITY, f32::min);
            let mut hit = Hit { t: ray.t_max, ..Hit::NONE };
            bvh.intersect(&mut stack, &ray, &mut hit, |_, _, _| true);
            assert_eq!(hit.exists(), expected.is_finite(), "{n} triangles, ray {i}");
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
    let targets = triangles.iter().flat_map(|[a, b, c]| [*a, (*a + *b) * 0.5, b.lerp(*c, 0.3), (*a + *b + *c) / 3.0]);
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

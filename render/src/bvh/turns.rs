//! Several rays in turns: while one waits for the memory, the others go on. For trees much larger than the caches.

use super::TriangleBvh;
use super::stack::{Lanes, Stack};
use super::traverse::Tests;
use crate::ray::{Hit, Ray};
use core::ops::ControlFlow;
use fearless_simd::Simd;

/// Rays under way at a time.
const TURNS: usize = 4;

/// A ray under way.
struct Turn<S: Simd> {
    /// Its number.
    ray: usize,
    tests: Tests<S>,
    stack: Stack,
    current: u32,
}

impl<S: Simd> Turn<S> {
    /// Of the next ray that waits.
    #[inline(always)]
    fn begin<const N: usize>(simd: S, root: u32, rays: &[Ray; N], waiting: &mut Lanes) -> Option<Self> {
        let ray = waiting.next()?;
        Some(Self { ray, tests: Tests::new(simd, &rays[ray]), stack: Stack::default(), current: root })
    }
}

/// Follows the rays whose bit is set, a step of each in turn, until `step` says that a ray is done. Closures that are not inlined would
/// compute without the vectors of the machine.
#[inline(always)]
fn in_turns<S: Simd, const N: usize>(
    simd: S,
    bvh: &TriangleBvh,
    root: u32,
    rays: &[Ray; N],
    which: u32,
    mut step: impl FnMut(&mut Turn<S>) -> Option<u32>,
) {
    let mut waiting = Lanes(which);
    let mut turns: [Option<Turn<S>>; TURNS] = [None, None, None, None];
    for turn in &mut turns {
        *turn = Turn::begin(simd, root, rays, &mut waiting);
    }
    let mut any = true;
    while any {
        any = false;
        for turn in &mut turns {
            let Some(ray) = turn else { continue };
            any = true;
            match step(ray) {
                Some(current) => {
                    bvh.fetch(current);
                    ray.current = current;
                }
                None => *turn = Turn::begin(simd, root, rays, &mut waiting),
            }
        }
    }
}

/// Nearest hits.
#[inline(always)]
pub(super) fn nearest<S: Simd, const N: usize>(
    simd: S,
    bvh: &TriangleBvh,
    root: u32,
    rays: &[Ray; N],
    which: u32,
    hits: &mut [Hit; N],
) {
    in_turns(
        simd,
        bvh,
        root,
        rays,
        which,
        #[inline(always)]
        |turn| turn.tests.nearest(simd, bvh, &mut turn.stack, turn.current, &mut hits[turn.ray], &|_, _, _| true),
    );
}

/// The bits of the rays that meet anything.
#[inline(always)]
pub(super) fn any<S: Simd, const N: usize>(simd: S, bvh: &TriangleBvh, root: u32, rays: &[Ray; N], which: u32) -> u32 {
    let mut met = 0;
    in_turns(
        simd,
        bvh,
        root,
        rays,
        which,
        #[inline(always)]
        |turn| match turn.tests.any(simd, bvh, &mut turn.stack, turn.current, rays[turn.ray].t_max, &|_, _, _| true) {
            ControlFlow::Continue(next) => Some(next),
            ControlFlow::Break(stopped) => {
                met |= u32::from(stopped) << turn.ray;
                None
            }
        },
    );
    met
}

#[cfg(test)]
mod tests {
    use super::*;
    use fearless_simd::{Level, dispatch};
    use glam::Vec3A;
    use rand::{RngExt, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    #[test]
    fn rays_in_turns_find_what_each_finds() {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(5);
        let mut v = |s: f32| Vec3A::from_array(core::array::from_fn(|_| rng.random_range(-s..s)));
        for n in [1, 9, 2000] {
            let triangles: Vec<_> =
                (0..n).map(|_| [v(1.0), v(1.0), v(1.0)]).map(|[p, a, b]| [p, p + 0.2 * a, p + 0.2 * b]).collect();
            let bvh = TriangleBvh::new(&triangles);
            let (root, mut stack) = (bvh.root.unwrap(), Stack::default());
            for which in [0xffff, 0, 1, 0x8001, 0x0ff0] {
                let rays: [Ray; 16] =
                    core::array::from_fn(|i| Ray { t_max: 0.5 * i as f32, ..Ray::new(v(1.5), v(1.0)) });
                let mut hits = rays.each_ref().map(|ray| Hit { t: ray.t_max, ..Hit::NONE });
                let met = dispatch!(Level::new(), simd => {
                    nearest(simd, &bvh, root, &rays, which, &mut hits);
                    any(simd, &bvh, root, &rays, which)
                });
                for (i, ray) in rays.iter().enumerate() {
                    let mut hit = Hit { t: ray.t_max, ..Hit::NONE };
                    let is_asked = which >> i & 1 != 0;
                    if is_asked {
                        bvh.intersect(&mut stack, ray, &mut hit, |_, _, _| true);
                    }
                    assert_eq!(hits[i], hit, "{n} triangles, ray {i}");
                    assert_eq!(met >> i & 1 != 0, hit.exists(), "{n} triangles, ray {i}");
                }
            }
        }
    }
}

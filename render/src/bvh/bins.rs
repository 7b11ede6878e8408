//! Where a set of boxes is best cut: candidates are the borders of equal bins of their middles, on each axis.

use super::WIDTH;
use super::binary::{BATCH, Primitive, Set};
use glam::Vec3A;
use obvhs::aabb::Aabb;
use rayon::prelude::*;

/// The cheapest cut of a set into two that both have boxes; `None` where all share a bin on every axis, or sizes are no numbers.
///
/// With 16 bins for all sets a room of large walls is cut a tenth worse (rays per second of the bench `rays`); with 32 for all,
/// building takes a sixth longer.
pub(super) fn cheapest(set: &Set) -> Option<Cut> {
    match set.primitives.len() {
        0..16 => Bins::<8>::new(set).cheapest(),
        16..64 => Bins::<16>::new(set).cheapest(),
        _ => Bins::<32>::new(set).cheapest(),
    }
}

/// Maps middles to bins.
#[derive(Clone, Copy)]
struct Places {
    low: Vec3A,
    scale: Vec3A,
    last: usize,
}

impl Places {
    fn new(middles: Aabb, bins: usize) -> Self {
        let extent = middles.max - middles.min;
        // A little less than the number of bins: the last middle falls into the last bin. Without extent, all into the first.
        let scale = Vec3A::select(extent.cmpgt(Vec3A::ZERO), 0.999 * bins as f32 / extent, Vec3A::ZERO);
        Self { low: middles.min, scale, last: bins - 1 }
    }

    /// The bin of each axis.
    #[inline(always)]
    fn of(&self, p: &Primitive) -> [usize; 3] {
        let place = (p.middle() - self.low) * self.scale;
        [place.x, place.y, place.z].map(|x| (x as usize).min(self.last))
    }
}

/// What goes to the first side: the bins of an axis up to one.
pub(super) struct Cut {
    places: Places,
    axis: usize,
    last: usize,
}

impl Cut {
    #[inline(always)]
    pub fn is_first(&self, p: &Primitive) -> bool {
        self.places.of(p)[self.axis] <= self.last
    }
}

/// Bounds and number of boxes.
#[derive(Clone, Copy)]
struct Bin {
    aabb: Aabb,
    count: u32,
}

impl Bin {
    const EMPTY: Self = Self { aabb: Aabb::INVALID, count: 0 };

    #[inline(always)]
    fn join(&mut self, other: &Self) {
        self.aabb = self.aabb.union(&other.aabb);
        self.count += other.count;
    }

    /// Surface times the leaves that the boxes fill; infinite without boxes, which is no side.
    fn cost(&self) -> f32 {
        if self.count == 0 {
            return f32::INFINITY;
        }
        self.aabb.half_area() * self.count.div_ceil(WIDTH as u32) as f32
    }
}

/// The boxes of a set, by axis and bin.
struct Bins<const N: usize> {
    bins: [[Bin; N]; 3],
    places: Places,
}

impl<const N: usize> Bins<N> {
    fn new(set: &Set) -> Self {
        let places = Places::new(set.middles, N);
        let sort = |list: &[Primitive]| {
            let mut bins = [[Bin::EMPTY; N]; 3];
            for p in list {
                for (bins, place) in bins.iter_mut().zip(places.of(p)) {
                    bins[place].join(&Bin { aabb: p.aabb, count: 1 });
                }
            }
            bins
        };
        let bins = if set.primitives.len() < 2 * BATCH {
            sort(set.primitives)
        } else {
            set.primitives.par_chunks(BATCH).map(sort).reduce(|| [[Bin::EMPTY; N]; 3], join)
        };
        Self { bins, places }
    }

    fn cheapest(&self) -> Option<Cut> {
        let (mut least, mut cheapest) = (f32::INFINITY, None);
        for (axis, bins) in self.bins.iter().enumerate() {
            let mut seconds = [f32::INFINITY; N];
            let mut side = Bin::EMPTY;
            for last in (0..N - 1).rev() {
                side.join(&bins[last + 1]);
                seconds[last] = side.cost();
            }
            let mut side = Bin::EMPTY;
            for last in 0..N - 1 {
                side.join(&bins[last]);
                let cost = side.cost() + seconds[last];
                if cost < least {
                    (least, cheapest) = (cost, Some((axis, last)));
                }
            }
        }
        cheapest.map(|(axis, last)| Cut { places: self.places, axis, last })
    }
}

fn join<const N: usize>(mut a: [[Bin; N]; 3], b: [[Bin; N]; 3]) -> [[Bin; N]; 3] {
    for (a, b) in a.iter_mut().flatten().zip(b.iter().flatten()) {
        a.join(b);
    }
    a
}

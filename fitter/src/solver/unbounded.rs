//! A change of variables that hides the bounds from methods that know none.
//!
//! Each bounded parameter p is a smooth function of a free variable u:
//! p = (lo + hi)/2 + (hi − lo)/2 · sin u between two bounds,
//! p = lo − 1 + √(u² + 1) above one, p = hi + 1 − √(u² + 1) below one
//! (James and Roos, MINUIT, 1975).

/// How far, relative to the box, a start on a bound is moved off it: there
/// dp/du vanishes and a gradient method could never leave.
const INSET: f64 = 1e-4;

#[derive(Clone, Copy)]
enum Map {
    Free,
    Above(f64),
    Below(f64),
    Between { middle: f64, half: f64 },
}

/// The maps of all parameters.
pub(super) struct Unbounded {
    maps: Vec<Map>,
    bounds: Vec<(f64, f64)>,
}

impl Unbounded {
    pub fn new(bounds: &[(f64, f64)]) -> Self {
        let map = |&(lo, hi): &(f64, f64)| match (lo.is_finite(), hi.is_finite()) {
            (false, false) => Map::Free,
            (true, false) => Map::Above(lo),
            (false, true) => Map::Below(hi),
            // Halves first: hi − lo may overflow.
            (true, true) => Map::Between { middle: 0.5 * lo + 0.5 * hi, half: 0.5 * hi - 0.5 * lo },
        };
        Self { maps: bounds.iter().map(map).collect(), bounds: bounds.to_vec() }
    }

    /// u of a point within the bounds, or of one near it if that is on a bound.
    pub fn inverse(&self, p: &[f64]) -> Vec<f64> {
        let one_sided = |distance: f64| {
            let d = distance.max(INSET);
            (d * (d + 2.0)).sqrt()
        };
        let inverse = |(&x, map): (&f64, &Map)| match *map {
            Map::Free => x,
            Map::Above(lo) => one_sided(x - lo),
            Map::Below(hi) => one_sided(hi - x),
            Map::Between { half: 0.0, .. } => 0.0,
            Map::Between { middle, half } => ((x - middle) / half).clamp(INSET - 1.0, 1.0 - INSET).asin(),
        };
        p.iter().zip(&self.maps).map(inverse).collect()
    }

    /// p(u), within the bounds in spite of rounding.
    pub fn forward(&self, u: &[f64]) -> Vec<f64> {
        let forward = |(&u, map): (&f64, &Map)| match *map {
            Map::Free => u,
            Map::Above(lo) => lo - 1.0 + (u * u + 1.0).sqrt(),
            Map::Below(hi) => hi + 1.0 - (u * u + 1.0).sqrt(),
            Map::Between { middle, half } => middle + half * u.sin(),
        };
        u.iter().zip(&self.maps).map(forward).zip(&self.bounds).map(|(p, (lo, hi))| p.clamp(*lo, *hi)).collect()
    }

    /// dp/du.
    pub fn slope(&self, u: &[f64]) -> Vec<f64> {
        let slope = |(&u, map): (&f64, &Map)| match *map {
            Map::Free => 1.0,
            Map::Above(_) => u / (u * u + 1.0).sqrt(),
            Map::Below(_) => -u / (u * u + 1.0).sqrt(),
            Map::Between { half, .. } => half * u.cos(),
        };
        u.iter().zip(&self.maps).map(slope).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const INF: f64 = f64::INFINITY;
    const BOUNDS: [(f64, f64); 5] = [(-INF, INF), (1.0, INF), (-INF, 2.0), (-3.0, 5.0), (4.0, 4.0)];

    #[test]
    fn inverse_undoes_forward() {
        let maps = Unbounded::new(&BOUNDS);
        let p = [7.5, 1.25, -6.0, 4.0, 4.0];
        for (a, b) in maps.forward(&maps.inverse(&p)).iter().zip(p) {
            assert!((a - b).abs() < 1e-12, "{a} {b}");
        }
    }

    #[test]
    fn every_image_is_within_the_bounds() {
        let maps = Unbounded::new(&BOUNDS);
        for i in -400..400 {
            let p = maps.forward(&[f64::from(i) * 0.31; 5]);
            for (x, (lo, hi)) in p.iter().zip(BOUNDS) {
                assert!((lo..=hi).contains(x));
            }
        }
    }

    #[test]
    fn slope_is_the_derivative() {
        let maps = Unbounded::new(&BOUNDS);
        let (u, e) = ([0.4, -0.7, 1.3, 0.9, 0.2], 1e-6);
        let above = maps.forward(&u.map(|x| x + e));
        let below = maps.forward(&u.map(|x| x - e));
        for (i, slope) in maps.slope(&u).iter().enumerate() {
            assert!((slope - (above[i] - below[i]) / (2.0 * e)).abs() < 1e-8);
        }
    }

    #[test]
    fn a_start_on_a_bound_can_leave_it() {
        let maps = Unbounded::new(&[(-3.0, 5.0), (1.0, INF), (-INF, 2.0)]);
        let u = maps.inverse(&[5.0, 1.0, 2.0]);
        assert!(maps.slope(&u).iter().all(|s| s.abs() > 1e-3));
    }
}

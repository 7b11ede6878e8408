//! Polygons of any number of corners as triangles.

use earcut::Earcut;
use glam::{DVec2, DVec3, Vec3};

/// Ear clipping may take time that grows with the square of the corners: larger concave polygons become fans.
const MAX_CONCAVE: usize = 1 << 14;

/// Sizes relative to the polygon's area: what counts as turning back, and what as no area at all.
const ROUNDING: f64 = 1e-6;

/// Splits polygons; keeps its memory from one to the next.
#[derive(Default)]
pub struct Splitter {
    earcut: Earcut<f64>,
    flat: Vec<[f64; 2]>,
    ears: Vec<u32>,
    too_large: usize,
}

impl Splitter {
    /// Appends the triangles of a polygon, wound as it is.
    ///
    /// A polygon that is whole from its first corner, as convex ones are, becomes a fan around that corner. Others are
    /// cut along the plane of their Newell normal. What encloses no area there, or is not finite, becomes a fan too.
    pub fn split(&mut self, corners: &[u32], positions: &[Vec3], triangles: &mut Vec<[u32; 3]>) {
        let concave = if corners.len() > 3 { backwards(corners, positions) } else { None };
        match concave {
            Some(normal) if corners.len() <= MAX_CONCAVE => self.cut(corners, positions, normal),
            concave => {
                self.too_large += usize::from(concave.is_some());
                self.ears.clear();
            }
        }
        if self.ears.is_empty() {
            // Triangles are written as quads with a corner twice: that is no loss to count.
            let whole = |t: &[u32; 3]| corners.len() == 3 || (t[0] != t[1] && t[1] != t[2] && t[2] != t[0]);
            triangles.extend(corners[1..].windows(2).map(|w| [corners[0], w[0], w[1]]).filter(whole));
        } else {
            let ears = self.ears.as_chunks().0;
            triangles.extend(ears.iter().map(|ear: &[u32; 3]| ear.map(|i| corners[i as usize])));
        }
    }

    /// Clips ears off the polygon seen along its normal.
    fn cut(&mut self, corners: &[u32], positions: &[Vec3], normal: DVec3) {
        let u = normal.normalize_or_zero().any_orthonormal_vector();
        let axes = (u, normal.normalize_or_zero().cross(u));
        let origin = positions[corners[0] as usize].as_dvec3();
        self.flat.clear();
        self.flat.extend(corners.iter().map(|&i| {
            let p = positions[i as usize].as_dvec3() - origin;
            DVec2::new(p.dot(axes.0), p.dot(axes.1)).to_array()
        }));
        self.earcut.earcut_slice(&self.flat, &[], &mut self.ears);
    }

    /// What was not split as it should be, for the user.
    pub fn warning(&self) -> Option<String> {
        let n = self.too_large;
        (n > 0).then(|| format!("{n} concave faces of more than {MAX_CONCAVE} corners are not drawn right"))
    }
}

/// The Newell normal (twice the area) of a polygon of which the fan around the first corner would fold back.
fn backwards(corners: &[u32], positions: &[Vec3]) -> Option<DVec3> {
    let at = |i: u32| positions.get(i as usize).map_or(DVec3::NAN, |p| p.as_dvec3());
    let origin = at(corners[0]);
    let twice = |b: u32, c: u32| (at(b) - origin).cross(at(c) - origin);
    // Most polygons are convex quads: two triangles that face alike.
    if let &[_, b, c, d] = corners
        && twice(b, c).dot(twice(c, d)) >= 0.0
    {
        return None;
    }
    let fan = || corners[1..].windows(2).map(|w| twice(w[0], w[1]));
    let normal: DVec3 = fan().sum();
    let area = normal.length_squared();
    let folds = area > 0.0 && area.is_finite() && fan().any(|n| n.dot(normal) < -ROUNDING * area);
    // A bow tie's halves cancel: along its normal there is nothing but rounding.
    let whole = || fan().map(DVec3::length).sum::<f64>();
    (folds && area.sqrt() > ROUNDING * whole()).then_some(normal)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn split(polygon: &[Vec3]) -> Vec<[u32; 3]> {
        let corners: Vec<_> = (0..polygon.len() as u32).collect();
        let mut triangles = Vec::new();
        Splitter::default().split(&corners, polygon, &mut triangles);
        triangles
    }

    /// Sum of the triangles' areas, and the polygon's.
    fn areas(polygon: &[Vec3]) -> (f64, f64) {
        let p: Vec<_> = polygon.iter().map(|p| p.as_dvec3()).collect();
        let cross = |a: usize, b: usize, c: usize| (p[b] - p[a]).cross(p[c] - p[a]);
        let newell: DVec3 = (1..p.len() - 1).map(|i| cross(0, i, i + 1)).sum();
        let facing = |t: [usize; 3]| cross(t[0], t[1], t[2]).dot(newell.normalize_or_zero());
        let each: Vec<_> = split(polygon).into_iter().map(|t| facing(t.map(|i| i as usize))).collect();
        assert!(each.iter().all(|&a| a >= -1e-6), "{each:?}");
        (each.iter().sum::<f64>() / 2.0, newell.length() / 2.0)
    }

    /// The shape in another plane, from every corner, both ways round.
    fn same_area_however_it_lies(outline: &[[f32; 2]]) {
        for first in 0..outline.len() {
            let mut turned: Vec<_> = outline.iter().map(|&[x, y]| Vec3::new(x + 3.0, y - 0.5 * x, 2.0 * y)).collect();
            turned.rotate_left(first);
            for _ in 0..2 {
                let (sum, area) = areas(&turned);
                assert!((sum - area).abs() < 1e-5 * area, "{outline:?} from {first}: {sum}, not {area}");
                turned.reverse();
            }
        }
    }

    #[test]
    fn triangles_cover_the_polygon_once() {
        // A dart, an L, a comb, a square with a hole by a bridge, collinear and repeated corners.
        same_area_however_it_lies(&[[-1., -1.], [0., -0.5], [1., -1.], [0., 1.]]);
        same_area_however_it_lies(&[[1., -1.], [1., 0.], [0., 0.], [0., 1.], [-1., 1.], [-1., -1.]]);
        same_area_however_it_lies(&[[0., 0.], [5., 0.], [5., 3.], [4., 1.], [3., 3.], [2., 1.], [1., 3.], [0., 1.]]);
        same_area_however_it_lies(&[
            [0., 0.],
            [3., 0.],
            [3., 3.],
            [0., 3.],
            [0., 0.],
            [1., 1.],
            [1., 2.],
            [2., 2.],
            [2., 1.],
            [1., 1.],
        ]);
        same_area_however_it_lies(&[[0., 0.], [1., 0.], [1., 0.], [2., 0.], [2., 2.], [1., 0.5], [0., 2.], [0., 1.]]);
        let star: Vec<_> = (0..200u32)
            .map(|i| {
                let (sin, cos) = (i as f32 * std::f32::consts::TAU / 200.0).sin_cos();
                let radius = 1.0 + (i * 7919 % 31) as f32;
                [radius * cos, radius * sin]
            })
            .collect();
        same_area_however_it_lies(&star);
    }

    #[test]
    fn time_is_bounded_and_the_user_told() {
        let n = 4 * MAX_CONCAVE as u32;
        let comb: Vec<_> =
            (0..n).map(|i| Vec3::new(i as f32, [0.0, 2.0, 1.0][(i % 2 + i / (n - 1)) as usize], 0.0)).collect();
        let mut splitter = Splitter::default();
        splitter.split(&(0..n).collect::<Vec<_>>(), &comb, &mut Vec::new());
        assert!(splitter.warning().is_some_and(|w| w.starts_with("1 concave faces")), "{:?}", splitter.warning());
    }

    #[test]
    fn what_has_no_area_is_a_fan() {
        let bow_tie = [[0., 0.], [1., 1.], [1., 0.], [0., 1.]].map(|[x, y]| Vec3::new(x, y, 0.0));
        for polygon in [bow_tie, [Vec3::ONE; 4], [Vec3::ZERO, Vec3::NAN, Vec3::X, Vec3::Y], [Vec3::INFINITY; 4]] {
            assert_eq!(split(&polygon), [[0, 1, 2], [0, 2, 3]]);
        }
        let mut triangles = Vec::new();
        Splitter::default().split(&[0, 1, 2, 9], &[Vec3::ZERO; 3], &mut triangles);
        assert_eq!(triangles.len(), 2);
    }
}

//! Normals that textures bend so far that a mirror would send light below the surface.

use glam::Vec3A;

/// `bent` turned back towards the unit normal `n`, in their plane, just so far that the mirror direction of `wo` keeps a
/// little above the surface, as Cycles does; unchanged where it is above. From behind, the same below the surface.
///
/// The diffuse part keeps the normal of the map.
///
/// Without it, surfaces seen at a grazing angle lose what their normals send below: black bands, and a tenth of the
/// light of a rough floor. Turning them keeps it, at the cost of flatter normals there. (The microfacets of Schüssler et
/// al. 2017 keep it too, but add a second bounce that Cycles does not have.)
///
/// For a normal at the angle θ from n, with z = n·wo and x the part of wo along the bend, the mirror direction is at the
/// height z cos 2θ + x sin 2θ = √(x² + z²) cos(2θ − φ), φ = atan2(x, z), which reaches t first at
/// θ = (φ + arccos(t/√(x² + z²)))/2.
pub(super) fn raised(n: Vec3A, bent: Vec3A, wo: Vec3A) -> Vec3A {
    let side = 1f32.copysign(n.dot(wo));
    let z = n.dot(wo).abs();
    let lowest = (0.9 * z).min(LOWEST);
    let Some(along) = (bent - n * n.dot(bent)).try_normalize() else { return n };
    let x = side * along.dot(wo);
    let length = x.hypot(z);
    if length == 0.0 {
        return n;
    }
    let most = 0.5 * (x.atan2(z) + (lowest / length).min(1.0).acos());
    if n.dot(bent) >= most.cos() {
        return bent;
    }
    let (sin, cos) = most.max(0.0).sin_cos();
    n * cos + along * sin
}

/// Share of diffuse light from `wi` that a normal map, or the smooth normal of a triangle, lets through, so that lobes of
/// normals which face the light more than the surface does end softly where the surface ends (Chiang, Li and Burley 2019, "Taming the shadow terminator"):
/// −g³ + g² + g with g = n·wi / (bent·wi · n·bent), in cosines.
#[inline]
pub(super) fn terminator(n_wi: f32, bent_wi: f32, n_bent: f32) -> f32 {
    let g = n_wi / (bent_wi * n_bent).max(f32::MIN_POSITIVE);
    if g >= 1.0 { 1.0 } else { (g * (1.0 + g * (1.0 - g))).max(0.0) }
}

/// Height above the surface that mirror directions keep.
const LOWEST: f32 = 0.01;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mirror_direction_keeps_above_the_surface() {
        let n = Vec3A::new(0.3, -0.2, 0.9).normalize();
        let directions = (0..400).map(|i| {
            let (z, a) = (1.0 - 2.0 * (i as f32 + 0.5) / 400.0, 2.399_963 * i as f32);
            let r = (1.0 - z * z).sqrt();
            Vec3A::new(r * a.cos(), r * a.sin(), z)
        });
        for wo in directions.clone().filter(|w| n.dot(*w).abs() > 1e-3) {
            for bent in directions.clone() {
                let side = n.dot(wo).signum();
                let found = raised(n, bent, wo);
                assert!((found.length() - 1.0).abs() < 1e-5);
                let height = |m: Vec3A| side * n.dot(2.0 * m.dot(wo) * m - wo);
                let lowest = (0.9 * n.dot(wo).abs()).min(LOWEST);
                assert!(height(found) > lowest - 1e-4, "{wo} {bent}: {}", height(found));
                // A normal on the side of the viewer that needs no turn is not turned.
                if n.dot(bent) > 0.0 && height(bent) > lowest + 1e-4 {
                    assert!((found - bent).length() < 1e-5, "{wo} {bent} {found}");
                }
            }
        }
    }
}

//! Where a ray meets a sphere.

use crate::ray::Ray;
use crate::scene::Sphere;
use core::f32::consts::{PI, TAU};
use glam::{DVec3, Vec2, Vec3A};

impl Sphere {
    /// Texture coordinates in the unit direction `outward` from the centre.
    pub(crate) fn uv(&self, outward: Vec3A) -> Vec2 {
        let local = self.rotation.transpose() * outward;
        let phi = local.y.atan2(local.x);
        Vec2::new(if phi < 0.0 { phi + TAU } else { phi } / TAU, local.z.clamp(-1.0, 1.0).acos() / PI)
    }

    /// Both distances along a ray, nearest first; none where it misses. In double precision: a sphere may be small beside
    /// its distance, or a ray start on it (Haines et al. 2019, "Precision improvements for ray/sphere intersection").
    pub(super) fn roots(&self, ray: &Ray) -> Option<[f64; 2]> {
        let (radius, direction) = (f64::from(self.radius), double(ray.direction));
        let f = double(ray.origin) - double(self.center);
        let a = direction.length_squared();
        let b = -f.dot(direction);
        let off_axis = f + direction * (b / a);
        let discriminant = radius * radius - off_axis.length_squared();
        // A direction of length 0 makes everything NaN, which meets nothing.
        if discriminant.is_nan() || discriminant < 0.0 {
            return None;
        }
        let c = (f.length() - radius) * (f.length() + radius);
        let q = b + (a * discriminant).sqrt().copysign(b);
        // A tangent that starts where it touches.
        if q == 0.0 {
            return Some([0.0; 2]);
        }
        let (t0, t1) = (c / q, q / a);
        Some(if t0 <= t1 { [t0, t1] } else { [t1, t0] })
    }

    /// Both distances as a hit keeps them.
    pub(super) fn hits(&self, ray: &Ray) -> [Option<f32>; 2] {
        self.roots(ray).map_or([None; 2], |roots| roots.map(|t| Some(t as f32)))
    }

    /// Unit direction from the centre to the point where a ray meets the sphere at distance `t`, which single precision has
    /// rounded.
    pub(super) fn outward(&self, ray: &Ray, t: f32) -> Vec3A {
        let rounded = f64::from(t);
        let [near, far] = self.roots(ray).unwrap_or([rounded; 2]);
        let t = if (far - rounded).abs() < (near - rounded).abs() { far } else { near };
        (double(ray.origin) - double(self.center) + double(ray.direction) * t).as_vec3a().normalize_or(Vec3A::Z)
    }
}

fn double(v: Vec3A) -> DVec3 {
    v.as_dvec3()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Mat3A;

    fn sphere(center: Vec3A, radius: f32) -> Sphere {
        Sphere { center, radius, rotation: Mat3A::IDENTITY, inward: false }
    }

    #[test]
    fn rays_that_start_on_a_sphere_have_numbers() {
        let s = sphere(Vec3A::ZERO, 1.0);
        // Outwards, inwards, and along the tangent, where everything is 0.
        let hits = |direction| s.hits(&Ray::new(Vec3A::X, direction)).map(Option::unwrap);
        assert_eq!(hits(Vec3A::X), [-2.0, 0.0]);
        assert_eq!(hits(Vec3A::NEG_X), [0.0, 2.0]);
        assert_eq!(hits(Vec3A::Y), [0.0, 0.0]);
        assert_eq!(s.hits(&Ray::new(Vec3A::X, Vec3A::ZERO)), [None, None]);
    }

    /// A sphere a millionth as large as its distance: the limb is where it is.
    #[test]
    fn small_and_far() {
        let s = sphere(Vec3A::ZERO, 1e-3);
        for (height, meets) in [(0.999e-3, true), (1.001e-3, false)] {
            let ray = Ray::new(Vec3A::new(height, 0.0, 1e3), Vec3A::NEG_Z);
            let [hit, _] = s.hits(&ray);
            assert_eq!(hit.is_some(), meets, "{height}");
            if let Some(t) = hit {
                let outward = s.outward(&ray, t);
                assert!((outward.x - 0.999).abs() < 1e-5 && outward.z > 0.04, "{outward}");
            }
        }
    }
}

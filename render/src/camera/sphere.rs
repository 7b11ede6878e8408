//! Where on the film a sphere appears, in closed form.
//!
//! Along one axis of the film the camera sees the shadow of the sphere in a plane through its axis of view: an ellipse, a circle
//! where the camera is not stretched. The lines through the eye that touch it bound it, and where it crosses the near plane so do
//! the ends of the chord (Mara and McGuire 2013, "2D Polyhedral Bounds of a Clipped, Perspective-Projected 3D Sphere").

use super::RayGenerator;
use glam::{DVec2, DVec3, Vec3A};

/// A part of the film in pixels from the top left: pixel (x, y) has its middle at (x + ½, y + ½). May reach beyond the film, to
/// infinity too.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Left and top.
    pub min: DVec2,
    /// Right and bottom.
    pub max: DVec2,
}

/// A camera, as spheres are put on its film through the middle of its lens.
#[derive(Clone, Debug)]
pub struct Silhouettes {
    eye: DVec3,
    /// Rows of the matrix from the world to the camera's frame.
    rows: [DVec3; 3],
    parallel: bool,
    clip: [f64; 2],
    /// From a slope, or a place in the camera's frame, to the film.
    scale: DVec2,
    center: DVec2,
}

impl Silhouettes {
    /// Those of a camera.
    pub fn new(generator: &RayGenerator) -> Self {
        let RayGenerator { to_world, parallel, half, center, inverse_size, clip, .. } = generator;
        let inverse = to_world.matrix3.as_dmat3().inverse();
        let size = inverse_size.as_dvec2().recip();
        Self {
            eye: to_world.translation.as_dvec3(),
            rows: [0, 1, 2].map(|i| inverse.row(i)),
            parallel: *parallel,
            // Slopes of what lies in the plane of the eye have no bound.
            clip: [f64::from(clip.0).max(f64::MIN_POSITIVE), f64::from(clip.1)],
            scale: -0.5 * size / half.as_dvec2(),
            center: center.as_dvec2() * size,
        }
    }

    /// The smallest part of the film that shows all of a sphere between the clip planes, if there is anything of it.
    pub fn bounds(&self, center: Vec3A, radius: f32) -> Option<Bounds> {
        let offset = center.as_dvec3() - self.eye;
        let square = f64::from(radius).powi(2);
        let [x, y, z] = self.rows;
        let depth = Extent { middle: z.dot(offset), square: square * z.length_squared() };
        let [near, far] = self.clip;
        if depth.middle + depth.reach() < near || depth.middle - depth.reach() > far {
            return None;
        }
        let along = |axis: DVec3| {
            let across = Extent { middle: axis.dot(offset), square: square * axis.length_squared() };
            let of = if self.parallel { places } else { slopes };
            of(across, depth, square * axis.dot(z), near)
        };
        let (x, y) = (along(x), along(y));
        let [a, b] = [0, 1].map(|i| self.center + self.scale * DVec2::new(x[i], y[i]));
        Some(Bounds { min: a.min(b), max: a.max(b) })
    }
}

/// The middle of an interval, and half its length squared.
#[derive(Clone, Copy)]
struct Extent {
    middle: f64,
    square: f64,
}

impl Extent {
    fn reach(self) -> f64 {
        self.square.sqrt()
    }
}

/// Smallest and largest x of an ellipse at depths z ≥ near; `mixed` as in [`slopes`].
fn places(x: Extent, z: Extent, mixed: f64, near: f64) -> [f64; 2] {
    let reach = x.reach();
    let chord = chord(x, z, mixed, near);
    [-1.0, 1.0].map(|side| {
        // Where it is that wide, it may lie in front of the near plane.
        let widest = z.middle + side * mixed / reach;
        match chord {
            Some((middle, half)) if widest < near => middle + side * half,
            _ => x.middle + side * reach,
        }
    })
}

/// Middle and half length of the chord of an ellipse at a depth, if there is any.
fn chord(x: Extent, z: Extent, mixed: f64, depth: f64) -> Option<(f64, f64)> {
    let to = depth - z.middle;
    let square = (x.square - mixed * mixed / z.square) * (1.0 - to * to / z.square);
    (to * to < z.square).then(|| (x.middle + mixed / z.square * to, square.max(0.0).sqrt()))
}

/// Smallest and largest x/z of an ellipse at depths z ≥ near > 0; `mixed` is the coefficient that makes it oblique, 0 for a circle.
/// The whole line if rounding leaves nothing of it.
fn slopes(x: Extent, z: Extent, mixed: f64, near: f64) -> [f64; 2] {
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    let mut meet = |slope: f64| (low, high) = (low.min(slope), high.max(slope));
    if let Some((middle, half)) = chord(x, z, mixed, near) {
        meet((middle - half) / near);
        meet((middle + half) / near);
    }
    // Lines of slope s through the eye touch where (x − s·z)² is the square of the ellipse's extent across them.
    let (a, b) = (z.middle * z.middle - z.square, x.middle * z.middle - mixed);
    let c = x.middle * x.middle - x.square;
    let discriminant = b * b - a * c;
    if discriminant >= 0.0 {
        let sum = b + discriminant.sqrt().copysign(b);
        for slope in [sum / a, c / sum] {
            let across = x.square - 2.0 * slope * mixed + slope * slope * z.square;
            let touching = z.middle - (mixed - slope * z.square) * (x.middle - slope * z.middle) / across;
            if slope.is_finite() && touching >= near {
                meet(slope);
            }
        }
    }
    if low <= high { [low, high] } else { [f64::NEG_INFINITY, f64::INFINITY] }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::uniform_sphere;
    use crate::scene::{Camera, Film, Filter, Projection};
    use glam::{Affine3A, Mat3, Vec2, Vec3};

    fn cameras() -> Vec<Camera> {
        let film = Film { width: 200, height: 120, crop: None, filter: Filter::Box { radius: 0.5 } };
        let placed = Affine3A::from_rotation_y(0.7) * Affine3A::from_translation(Vec3::new(1.0, -2.0, 3.0));
        let stretched =
            placed * Affine3A::from_mat3(Mat3::from_cols(Vec3::X, Vec3::new(0.2, 1.1, 0.0), Vec3::new(0.1, -0.3, 1.0)));
        let principal_point = Vec2::new(0.1, -0.05);
        let mut all = Vec::new();
        for projection in [Projection::Perspective { fov_x: 1.2 }, Projection::Orthographic { half_width: 3.0 }] {
            for to_world in [placed, stretched] {
                let (near, far) = (0.5, 20.0);
                all.push(Camera {
                    projection,
                    film: film.clone(),
                    to_world,
                    principal_point,
                    near,
                    far,
                    ..Camera::default()
                });
            }
        }
        all
    }

    /// Points of spheres of all places and sizes, the eye inside and the near plane across, appear within the bounds, and near
    /// their edges: the bounds are no larger than they must be.
    #[test]
    fn bounds_are_those_of_many_points() {
        let number = |i: u32, k: f32| (i as f32 * k + 17.0 * k).fract();
        for (index, camera) in cameras().iter().enumerate() {
            let generator = RayGenerator::new(camera);
            let silhouettes = Silhouettes::new(&generator);
            let (mut seen, mut across, mut inside, mut unseen) = (0, 0, 0, 0);
            for i in 0..300 {
                let direction = uniform_sphere(Vec2::new(number(i, 0.618_034), number(i, 0.754_878)));
                let local = direction * (8.0 * number(i, 0.324_718).powi(2)) + Vec3A::new(0.0, 0.0, 1.0);
                let center = camera.to_world.transform_point3a(local);
                let radius = 0.05 + 2.0 * number(i, 0.569_84).powi(3);
                let bounds = silhouettes.bounds(center, radius);
                let (mut low, mut high) = (Vec2::INFINITY, Vec2::NEG_INFINITY);
                let mut note = |p: Vec3A| {
                    if let Some((x, y)) = generator.project(p) {
                        (low, high) = (low.min(Vec2::new(x, y)), high.max(Vec2::new(x, y)));
                    }
                };
                // The surface, and the disk in which it crosses the near plane.
                let n = 20_000;
                for k in 0..n {
                    let u = Vec2::new((k as f32 + 0.5) / n as f32, (k as f32 * 0.618_034).fract());
                    note(center + radius * uniform_sphere(u));
                }
                let normal = generator.axis.normalize();
                let near_depth = generator.axis.length().recip() * camera.near * 1.0001;
                let offset = (near_depth - generator.depth(center) * generator.axis.length().recip()) * normal;
                if offset.length() < radius {
                    let rim = (radius * radius - offset.length_squared()).max(0.0).sqrt();
                    let (t, b) = normal.any_orthonormal_pair();
                    for k in 0..2000 {
                        let (s, c) = (core::f32::consts::TAU * k as f32 / 2000.0).sin_cos();
                        note(center + offset + rim * (t * c + b * s));
                    }
                }
                let Some(Bounds { min, max }) = bounds else {
                    unseen += 1;
                    assert!(low.x > high.x, "{index} {i}: points of it are seen");
                    continue;
                };
                if low.x > high.x {
                    // What is left between the planes is too little for a point to fall on it.
                    continue;
                }
                seen += 1;
                across += u32::from(offset.length() < radius);
                inside += u32::from((center - camera.to_world.translation).length() < radius);
                let size = (high - low).as_dvec2();
                let room = 0.02 * size + 0.05;
                assert!((min - 0.01 - 1e-4 * size).cmple(low.as_dvec2()).all(), "{index} {i}: {min} {low}");
                assert!((max + 0.01 + 1e-4 * size).cmpge(high.as_dvec2()).all(), "{index} {i}: {max} {high}");
                assert!((low.as_dvec2() - min).cmple(room).all(), "{index} {i}: {min} {low} {size}");
                assert!((max - high.as_dvec2()).cmple(room).all(), "{index} {i}: {max} {high} {size}");
            }
            println!(
                "camera {index}: {seen} seen, {across} across the near plane, {inside} about the eye, {unseen} unseen"
            );
            assert!(seen > 80 && across > 10 && inside > 5 && unseen > 20);
        }
    }
}

//! Primary rays.

mod sphere;

use crate::frame::concentric_disk;
use crate::ray::Ray;
use crate::sampler::Sampler;
use crate::scene::{Camera, Filter, Lens, Projection};
use glam::{Affine3A, Vec2, Vec3A};
pub use sphere::{Bounds, Silhouettes};

/// Intervals of the tabulated filter inverse.
const TABLE: usize = 256;

/// A camera ready to make rays.
#[derive(Clone, Debug)]
pub struct RayGenerator {
    to_world: Affine3A,
    /// What gives depth: z of the camera's frame.
    axis: Vec3A,
    /// Whether rays are parallel.
    parallel: bool,
    /// Half extents of what the film shows, at unit depth.
    half: Vec2,
    center: Vec2,
    inverse_size: Vec2,
    clip: (f32, f32),
    lens: Option<Lens>,
    offset: Offset,
}

/// Distribution of a sample's distance from the pixel's centre: proportional to the filter, so that every pixel is the
/// plain mean of its own samples.
#[derive(Clone, Debug)]
enum Offset {
    Box(f32),
    Tent(f32),
    /// Distance beyond which the mass (k/TABLE)² lies, by k.
    Table(Vec<f32>),
}

impl Offset {
    fn new(filter: Filter) -> Self {
        match filter {
            Filter::Box { radius } => Self::Box(radius),
            Filter::Tent { radius } => Self::Tent(radius),
            Filter::Gaussian { stddev } => {
                // Cumulate the filter from its end inwards, and note where the mass of one tail passes (k/TABLE)²/2:
                // the square gives the thin tail many entries.
                let steps = 64 * TABLE;
                let at = |i: usize| 4.0 - 4.0 * (i as f64 + 0.5) / steps as f64;
                let weights: Vec<f64> = (0..steps).map(|i| (-0.5 * at(i) * at(i)).exp() - (-8f64).exp()).collect();
                let total: f64 = weights.iter().sum();
                let mut quantiles = vec![4.0 * stddev];
                let mut sum = 0.0;
                for (i, w) in weights.iter().enumerate() {
                    sum += w;
                    while sum >= (quantiles.len() as f64 / TABLE as f64).powi(2) * total {
                        quantiles.push(stddev * at(i) as f32);
                    }
                }
                quantiles.resize(TABLE + 1, 0.0);
                Self::Table(quantiles)
            }
        }
    }

    /// The largest distance.
    fn reach(&self) -> f32 {
        match self {
            Self::Box(radius) | Self::Tent(radius) => *radius,
            Self::Table(quantiles) => quantiles[0],
        }
    }

    #[inline]
    fn sample(&self, u: f32) -> f32 {
        match self {
            Self::Box(r) => (2.0 * u - 1.0) * r,
            Self::Tent(r) if u < 0.5 => ((2.0 * u).sqrt() - 1.0) * r,
            Self::Tent(r) => (1.0 - (2.0 - 2.0 * u).sqrt()) * r,
            Self::Table(quantiles) => {
                let side = 2.0 * u - 1.0;
                let x = (1.0 - side.abs()).sqrt() * TABLE as f32;
                let i = (x as usize).min(TABLE - 1);
                (quantiles[i] + (quantiles[i + 1] - quantiles[i]) * (x - i as f32)).copysign(side)
            }
        }
    }
}

impl RayGenerator {
    /// Prepares the camera.
    pub fn new(camera: &Camera) -> Self {
        let size = Vec2::new(camera.film.width as f32, camera.film.height as f32);
        let (half_width, parallel) = match camera.projection {
            Projection::Perspective { fov_x } => ((0.5 * fov_x).tan(), false),
            Projection::Orthographic { half_width } => (half_width, true),
        };
        Self {
            to_world: camera.to_world,
            axis: camera.to_world.matrix3.inverse().transpose().z_axis,
            parallel,
            half: Vec2::new(half_width, half_width * size.y / size.x),
            center: 0.5 - camera.principal_point,
            inverse_size: size.recip(),
            clip: (camera.near, camera.far),
            lens: camera.lens,
            offset: Offset::new(camera.film.filter),
        }
    }

    /// A ray of pixel (x, y) of the whole film: its first point chooses the place on the film; the next one, where there is a lens,
    /// the place on the lens. The direction is a unit vector; the clip planes bound the ray.
    #[inline]
    pub fn sample(&self, x: u32, y: u32, sampler: &mut Sampler) -> Ray {
        let u = sampler.next_2d();
        match self.lens {
            None => self.ray(x, y, u),
            Some(lens) => self.through_lens(lens, self.place(x, y, u), concentric_disk(sampler.next_2d())),
        }
    }

    /// Where the ray through the middle of the lens passes the plane at unit depth, in the camera's frame.
    #[inline]
    fn place(&self, x: u32, y: u32, u: Vec2) -> Vec2 {
        let offset = Vec2::new(self.offset.sample(u.x), self.offset.sample(u.y));
        let film = (Vec2::new(x as f32, y as f32) + 0.5 + offset) * self.inverse_size;
        2.0 * (self.center - film) * self.half
    }

    /// The ray from a point of the lens, on the unit disk, to where all rays of a place meet.
    #[inline]
    fn through_lens(&self, lens: Lens, place: Vec2, on_lens: Vec2) -> Ray {
        let start = lens.radius * on_lens;
        let through = self.to_world.matrix3 * Vec3A::from((place - start / lens.focus).extend(1.0));
        let length = through.length();
        Ray {
            origin: self.to_world.transform_point3a(start.extend(0.0).into()),
            direction: through / length,
            t_min: self.clip.0 * length,
            t_max: self.clip.1 * length,
            from_camera: true,
        }
    }

    /// The ray through the middle of the lens of pixel (x, y) of the whole film, at the filter-distributed position of `u`. The
    /// direction is a unit vector; the clip planes bound the ray.
    #[inline]
    pub fn ray(&self, x: u32, y: u32, u: Vec2) -> Ray {
        let place = self.place(x, y, u);
        if self.parallel {
            return Ray {
                origin: self.to_world.transform_point3a(place.extend(0.0).into()),
                direction: self.to_world.matrix3.z_axis.normalize(),
                t_min: self.clip.0,
                t_max: self.clip.1,
                from_camera: true,
            };
        }
        let through = self.to_world.matrix3 * Vec3A::from(place.extend(1.0));
        let length = through.length();
        Ray {
            origin: self.to_world.translation,
            direction: through / length,
            t_min: self.clip.0 * length,
            t_max: self.clip.1 * length,
            from_camera: true,
        }
    }

    /// Where on the whole film a point appears, in pixels from the top left: pixel (x, y) has its middle at (x + ½, y + ½).
    /// The inverse of [`RayGenerator::ray`], through the middle of a lens; may lie outside the film, `None` outside the clip planes.
    pub fn project(&self, p: Vec3A) -> Option<(f32, f32)> {
        let local = self.to_world.matrix3.inverse() * (p - self.to_world.translation);
        if local.z <= 0.0 || self.depth(p) < self.clip.0 || self.depth(p) > self.clip.1 {
            return None;
        }
        let distance = if self.parallel { 1.0 } else { local.z };
        let film = self.center - Vec2::new(local.x, local.y) / (2.0 * distance * self.half);
        let pixel = film / self.inverse_size;
        pixel.is_finite().then_some((pixel.x, pixel.y))
    }

    /// How far from the middle of a pixel its samples lie at most, in pixels along either axis.
    pub fn filter_reach(&self) -> f32 {
        self.offset.reach()
    }

    /// Points of the rim of the lens, evenly spaced; none where everything is sharp.
    pub fn rim(&self, count: usize) -> impl Iterator<Item = Vec3A> {
        let on_rim = move |i: usize| Vec2::from_angle(core::f32::consts::TAU * i as f32 / count as f32);
        let world = |lens: Lens, p: Vec2| self.to_world.transform_point3a((lens.radius * p).extend(0.0).into());
        self.lens.into_iter().flat_map(move |lens| (0..count).map(move |i| world(lens, on_rim(i))))
    }

    /// Where the ray that sees `p` starts, at the middle of a lens.
    pub fn eye(&self, p: Vec3A) -> Vec3A {
        if self.parallel {
            p - self.to_world.matrix3.z_axis.normalize() * self.depth(p)
        } else {
            self.to_world.translation
        }
    }

    /// Depth along the axis of a point on a ray made by [`RayGenerator::ray`].
    #[inline]
    pub fn depth(&self, p: Vec3A) -> f32 {
        (p - self.to_world.translation).dot(self.axis)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Film;

    #[test]
    fn corners_lie_on_the_frustum_and_x_points_left() {
        let film = Film { width: 200, height: 100, crop: None, filter: Filter::Box { radius: 0.5 } };
        let projection = Projection::Perspective { fov_x: 90f32.to_radians() };
        let camera = Camera { projection, film, ..Camera::default() };
        let generator = RayGenerator::new(&camera);
        let d = generator.ray(0, 0, Vec2::ZERO).direction;
        assert!((d / d.z - Vec3A::new(1.0, 0.5, 1.0)).length() < 1e-6, "{d}");
        let d = generator.ray(199, 99, Vec2::ONE).direction;
        assert!((d / d.z - Vec3A::new(-1.0, -0.5, 1.0)).length() < 1e-6, "{d}");
    }

    #[test]
    fn projection_undoes_rays() {
        let film = Film { width: 200, height: 120, crop: None, filter: Filter::Box { radius: 0.5 } };
        let to_world = Affine3A::from_rotation_y(0.7) * Affine3A::from_translation(glam::Vec3::new(1.0, -2.0, 3.0));
        let principal_point = Vec2::new(0.1, -0.05);
        for projection in [Projection::Perspective { fov_x: 1.0 }, Projection::Orthographic { half_width: 3.0 }] {
            let camera = Camera { projection, film: film.clone(), to_world, principal_point, ..Camera::default() };
            let generator = RayGenerator::new(&camera);
            for (x, y) in [(0, 0), (199, 119), (57, 101)] {
                let ray = generator.ray(x, y, Vec2::new(0.5, 0.5));
                let p = ray.origin + 7.0 * ray.direction;
                let (u, v) = generator.project(p).unwrap();
                assert!((u - x as f32 - 0.5).abs() < 1e-2 && (v - y as f32 - 0.5).abs() < 1e-2, "{x} {y}: {u} {v}");
                assert_eq!(generator.project(ray.origin - 7.0 * ray.direction), None);
                assert!((generator.eye(p) - ray.origin).length() < 1e-4);
            }
        }
    }

    #[test]
    fn parallel_rays_start_on_the_film_and_x_points_left() {
        let film = Film { width: 200, height: 100, crop: None, filter: Filter::Box { radius: 0.5 } };
        let projection = Projection::Orthographic { half_width: 3.0 };
        let generator = RayGenerator::new(&Camera { projection, film, ..Camera::default() });
        for (pixel, u, corner) in [((0, 0), Vec2::ZERO, (3.0, 1.5)), ((199, 99), Vec2::ONE, (-3.0, -1.5))] {
            let ray = generator.ray(pixel.0, pixel.1, u);
            assert!((ray.origin - Vec3A::new(corner.0, corner.1, 0.0)).length() < 1e-5, "{}", ray.origin);
            assert_eq!((ray.direction, ray.t_min, ray.t_max), (Vec3A::Z, 1e-2, 1e4));
        }
    }

    /// Circle of confusion: the rays of a pixel fill a disk of radius R |1 − z/f| about its middle ray at depth z, which is a
    /// point at the focus distance, however the camera stands.
    #[test]
    fn rays_of_a_lens_meet_at_its_focus() {
        let film = Film { width: 200, height: 120, crop: None, filter: Filter::Box { radius: 1e-3 } };
        let to_world = Affine3A::from_rotation_y(0.7) * Affine3A::from_translation(glam::Vec3::new(1.0, -2.0, 3.0));
        let lens = Lens { radius: 0.25, focus: 4.0 };
        let camera = Camera { film, to_world, lens: Some(lens), ..Camera::default() };
        let generator = RayGenerator::new(&camera);
        for (x, y) in [(100, 60), (3, 110)] {
            let middle = generator.ray(x, y, Vec2::splat(0.5));
            let at = |ray: &Ray, z: f32| ray.origin + ray.direction * (z * ray.t_min / camera.near);
            for z in [0.0, 1.0, 4.0, 9.0] {
                let (mut squares, mut most, n) = (0.0, 0f32, 4096);
                for i in 0..n {
                    let ray = generator.sample(x, y, &mut Sampler::new(0, (x, y), i));
                    assert!((ray.direction.length() - 1.0).abs() < 1e-6);
                    assert!((generator.depth(at(&ray, z)) - z).abs() < 1e-5 * (1.0 + z));
                    let away = (at(&ray, z) - at(&middle, z)).length();
                    (squares, most) = (squares + away * away / n as f32, most.max(away));
                }
                let radius = lens.radius * (1.0 - z / lens.focus).abs();
                // Uniform over the disk: the mean square is half the square of the radius; a pixel has a width of its own.
                let pixel = 2e-5 * z;
                assert!((most - radius).abs() < 0.01 * radius + pixel, "{z}: {most} {radius}");
                assert!((squares - 0.5 * radius * radius).abs() < 0.002 * radius * radius + pixel, "{z}: {squares}");
            }
        }
        assert!(generator.rim(5).all(|p| ((p - camera.to_world.translation).length() - 0.25).abs() < 1e-6));
        assert_eq!(RayGenerator::new(&Camera::default()).rim(5).count(), 0);
    }

    #[test]
    fn offsets_follow_the_filter() {
        for (filter, variance) in [
            (Filter::Box { radius: 0.5 }, 1.0 / 12.0),
            (Filter::Tent { radius: 1.0 }, 1.0 / 6.0),
            (Filter::Gaussian { stddev: 0.5 }, 0.248_57), // a little below ¼: the tails are cut and lowered
        ] {
            let offset = Offset::new(filter);
            let n = 100_000;
            let moment = |k| {
                (0..n).map(|i| f64::from(offset.sample((i as f32 + 0.5) / n as f32)).powi(k)).sum::<f64>() / n as f64
            };
            assert!(moment(1).abs() < 1e-4, "{filter:?}");
            assert!((moment(2) - variance).abs() < 2e-4, "{filter:?} {}", moment(2));
        }
    }
}

//! Emitting surfaces.

use super::sphere::SphereLamp;
use super::tree::LightBounds;
use super::{LightSample, Target, mean};
use crate::scene::{AreaEmitter, ColorTexture, Coordinates, Mesh, Opacity, Rgb, Sphere, Texture};
use core::f32::consts::PI;
use glam::{Vec2, Vec3A, Vec4};

/// Shape of an emitter.
#[derive(Clone, Copy, Debug)]
enum Form {
    /// p0 + x e1 + y e2 over x, y ≥ 0, x + y ≤ 1.
    Triangle {
        p0: Vec3A,
        e1: Vec3A,
        e2: Vec3A,
    },
    /// p0 + x e1 + y e2 over the unit square.
    Parallelogram {
        p0: Vec3A,
        e1: Vec3A,
        e2: Vec3A,
    },
    Sphere(SphereLamp),
}

/// A surface that emits from its front.
#[derive(Clone, Debug)]
pub(super) struct Surface {
    form: Form,
    /// Unit normal of a flat surface.
    normal: Vec3A,
    area: f32,
    /// Bound of the rounding of its points.
    clearance: f32,
    /// Where values are looked up at the corners of a triangle.
    corners: Box<[Coordinates; 3]>,
    pub radiance: ColorTexture,
    mean_radiance: f32,
    /// Share of the surface that is there, where it has holes.
    opacity: Option<Opacity>,
}

/// An even flat lamp for code in lanes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FlatLamp {
    pub p0: Vec3A,
    pub e1: Vec3A,
    pub e2: Vec3A,
    pub normal: Vec3A,
    pub radiance: Rgb,
    pub area: f32,
    pub clearance: f32,
    /// A parallelogram, otherwise a triangle.
    pub square: bool,
}

/// Largest deviation of the fourth corner of a parallelogram, relative to its diagonal.
const PARALLEL: f32 = 1e-5;

/// Rounding of the points of a lamp and of the rays that meet it, relative to its largest coordinate.
const ROUNDING: f32 = 2.0 / (1 << 20) as f32;

impl Surface {
    /// The emitters of a mesh: one for a parallelogram of two triangles, otherwise one per triangle, or none if no
    /// triangle has an area. Triangles without area keep their place and are never chosen.
    pub fn of_mesh(mesh: &Mesh, emitter: &AreaEmitter, opacity: Option<&Opacity>, textures: &[Texture]) -> Vec<Self> {
        let radiance = emitter.radiance;
        let mean_radiance = mean_through(radiance, opacity, textures);
        let clearance = ROUNDING * mesh.positions.iter().fold(0f32, |e, p| e.max(p.abs().max_element()));
        let flat = |form, e1: Vec3A, e2: Vec3A, factor: f32, corners| {
            let cross = e1.cross(e2);
            let (normal, area, opacity) = (cross.normalize_or_zero(), factor * cross.length(), opacity.cloned());
            Self { form, normal, area, clearance, corners: Box::new(corners), radiance, mean_radiance, opacity }
        };
        let corner = |i: u32| Vec3A::from(mesh.positions[i as usize]);
        let coordinates = |i: u32, barycentric: Vec2| {
            let first = mesh.uvs.get(i as usize).copied().unwrap_or(barycentric);
            let second = mesh.second_uvs.get(i as usize).copied().unwrap_or(first);
            let paint = mesh.colors.get(i as usize).map_or(Vec4::ONE, |c| Vec4::from_array(*c));
            Coordinates { uv: [first, second], paint }
        };
        let triangle = |&[a, b, c]: &[u32; 3]| {
            let (p0, e1, e2) = (corner(a), corner(b) - corner(a), corner(c) - corner(a));
            let corners = [coordinates(a, Vec2::ZERO), coordinates(b, Vec2::X), coordinates(c, Vec2::Y)];
            flat(Form::Triangle { p0, e1, e2 }, e1, e2, 0.5, corners)
        };
        let even = matches!(radiance, ColorTexture::Constant(_)) && !opacity.is_some_and(Opacity::varies);
        if let (&[[a, b, c], [d, e, f]], true) = (&mesh.triangles[..], even) {
            // Two triangles (a, b, c), (a, c, x) with x = a + c − b.
            if d == a && e == c {
                let (p0, e1, e2) = (corner(a), corner(b) - corner(a), corner(f) - corner(a));
                let miss = (p0 + e1 + e2 - corner(c)).length();
                if miss <= PARALLEL * (corner(c) - p0).length() {
                    let surface = flat(Form::Parallelogram { p0, e1, e2 }, e1, e2, 1.0, [Vec2::ZERO.into(); 3]);
                    return vec![surface].into_iter().filter(|s| s.area > 0.0).collect();
                }
            }
        }
        let surfaces: Vec<_> = mesh.triangles.iter().map(triangle).collect();
        if surfaces.iter().any(|s| s.area > 0.0) { surfaces } else { Vec::new() }
    }

    /// An emitting sphere.
    pub fn sphere(sphere: Sphere, emitter: &AreaEmitter, opacity: Option<&Opacity>, textures: &[Texture]) -> Self {
        let lamp = SphereLamp::new(sphere);
        Self {
            form: Form::Sphere(lamp),
            normal: Vec3A::Z,
            area: lamp.area(),
            clearance: ROUNDING * (sphere.center.abs().max_element() + sphere.radius),
            corners: Box::new([Vec2::ZERO.into(); 3]),
            radiance: emitter.radiance,
            mean_radiance: mean_through(emitter.radiance, opacity, textures),
            opacity: opacity.cloned(),
        }
    }

    /// Bounds of position, direction and power for the light tree.
    pub fn bounds(&self) -> LightBounds {
        let power = PI * self.mean_radiance * self.area;
        match self.form {
            Form::Sphere(SphereLamp { sphere: Sphere { center, radius, .. }, .. }) => {
                LightBounds::new(center - radius, center + radius, power, Vec3A::Z, -1.0, 0.0)
            }
            Form::Triangle { p0, e1, e2 } => {
                let (a, b) = (p0 + e1, p0 + e2);
                LightBounds::new(p0.min(a).min(b), p0.max(a).max(b), power, self.normal, 1.0, 0.0)
            }
            Form::Parallelogram { p0, e1, e2 } => {
                let corners = [p0, p0 + e1, p0 + e2, p0 + e1 + e2];
                let min = corners.into_iter().reduce(Vec3A::min).unwrap_or(p0);
                let max = corners.into_iter().reduce(Vec3A::max).unwrap_or(p0);
                LightBounds::new(min, max, power, self.normal, 1.0, 0.0)
            }
        }
    }

    /// A direction from `p` to the front of the surface.
    #[inline(always)]
    pub fn sample(&self, textures: &[Texture], p: Vec3A, probability: f32, u: Vec2) -> Option<LightSample> {
        let (target, xy) = match self.form {
            Form::Parallelogram { p0, e1, e2 } => (p0 + e1 * u.x + e2 * u.y, u),
            Form::Triangle { p0, e1, e2 } => {
                // Fold the square along its diagonal (Heitz 2019, "A low-distortion map between triangle and square").
                let b = if u.x < u.y {
                    Vec2::new(0.5 * u.x, u.y - 0.5 * u.x)
                } else {
                    Vec2::new(u.x - 0.5 * u.y, 0.5 * u.y)
                };
                (p0 + e1 * b.x + e2 * b.y, b)
            }
            Form::Sphere(lamp) => {
                let s = lamp.sample(p, u)?;
                let Sphere { center, radius, .. } = lamp.sphere;
                let (target, at) = (center + s.outward * radius, lamp.sphere.uv(s.outward).into());
                return self.finish(textures, s.wi, target, probability, s.pdf, &at);
            }
        };
        let to_light = target - p;
        let distance = to_light.length();
        let wi = to_light / distance;
        let pdf = self.pdf(p, distance, -self.normal.dot(wi));
        let [a, b, c] = *self.corners;
        let at = a * (1.0 - xy.x - xy.y) + b * xy.x + c * xy.y;
        self.finish(textures, wi, target, probability, pdf, &at)
    }

    #[inline(always)]
    fn finish(
        &self,
        textures: &[Texture],
        wi: Vec3A,
        target: Vec3A,
        probability: f32,
        pdf: f32,
        at: &Coordinates,
    ) -> Option<LightSample> {
        // The shadow ray ends before the lamp, whose holes it does not meet: their share is taken off here.
        let opacity = self.opacity.as_ref().map_or(1.0, |o| o.at(textures, at));
        (pdf > 0.0 && pdf.is_finite() && opacity > 0.0).then(|| LightSample {
            wi,
            target: Target::Point { p: target, clearance: self.clearance },
            radiance: self.radiance.eval(textures, at) * opacity,
            pdf: pdf * probability,
            delta: false,
        })
    }

    /// What [`Surface::sample`] needs where the surface is flat, even and without holes.
    #[inline]
    pub fn flat(&self) -> Option<FlatLamp> {
        let (p0, e1, e2, square) = match self.form {
            Form::Parallelogram { p0, e1, e2 } => (p0, e1, e2, true),
            Form::Triangle { p0, e1, e2 } => (p0, e1, e2, false),
            Form::Sphere(_) => return None,
        };
        let ColorTexture::Constant(radiance) = self.radiance else { return None };
        let Self { normal, area, clearance, .. } = *self;
        (self.opacity.is_none() && area > 0.0).then_some(FlatLamp {
            p0,
            e1,
            e2,
            normal,
            radiance,
            area,
            clearance,
            square,
        })
    }

    /// Density in sr⁻¹ of [`Surface::sample`] at a point at `distance` whose normal makes the cosine `cos` with the
    /// direction back to `p`; 0 from behind.
    #[inline]
    pub fn pdf(&self, p: Vec3A, distance: f32, cos: f32) -> f32 {
        if cos <= 0.0 {
            return 0.0;
        }
        match self.form {
            Form::Sphere(lamp) => lamp.pdf(p, distance, cos),
            _ if self.area > 0.0 => distance * distance / (cos * self.area),
            _ => 0.0,
        }
    }
}

/// Mean radiance of a lamp with its holes.
fn mean_through(radiance: ColorTexture, opacity: Option<&Opacity>, textures: &[Texture]) -> f32 {
    mean(radiance.mean(textures)) * opacity.map_or(1.0, |o| o.mean(textures))
}

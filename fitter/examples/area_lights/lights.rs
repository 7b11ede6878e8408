//! Area lights of radiance 1 in the local frame of a surface, and what a BRDF reflects of them.

use brdf_tables::cap::projected_solid_angle;
use brdf_tables::{Brdf, CapBatch, Specular, Table};
use core::f64::consts::TAU;
use glam::{DVec2, DVec3, Vec3};
use rand::{Rng, RngExt};

/// Samples along each side of a light for the truth.
const SIDE: usize = 256;

/// A light.
#[derive(Clone, Copy)]
pub enum Light {
    /// A sphere, or any cap of directions: unit axis and half angle.
    Cap(DVec3, f64),
    /// A rectangle that shines from both sides: centre and half edges.
    Rectangle(DVec3, DVec3, DVec3),
}

/// Kinds of lights.
#[derive(Clone, Copy, PartialEq)]
pub enum Kind {
    Sphere,
    Rectangle,
    Cap,
}

impl Kind {
    pub const ALL: [Self; 3] = [Self::Sphere, Self::Rectangle, Self::Cap];

    pub fn name(self) -> &'static str {
        match self {
            Self::Sphere => "sphere",
            Self::Rectangle => "rectangle",
            Self::Cap => "cap",
        }
    }

    /// A light and a view; half of the lights are within a few widths of the lobe of the mirror direction.
    pub fn random(self, width: f64, rng: &mut impl Rng) -> (Light, DVec3) {
        let sphere = |rng: &mut dyn FnMut() -> f64| {
            let (z, (s, c)) = (2.0 * rng() - 1.0, (TAU * rng()).sin_cos());
            DVec3::new((1.0 - z * z).sqrt() * c, (1.0 - z * z).sqrt() * s, z)
        };
        loop {
            let mut number = || rng.random::<f64>();
            let (s, c) = (number() * 1.45).sin_cos();
            let (sp, cp) = (TAU * number()).sin_cos();
            let wo = DVec3::new(s * cp, s * sp, c);
            let mirror = DVec3::new(-wo.x, -wo.y, wo.z);
            let spread = sphere(&mut number);
            let toward = if number() < 0.5 { mirror + 3.0 * width * number() * spread } else { spread };
            let Some(toward) = toward.try_normalize() else { continue };
            let light = match self {
                // Of radius 1, or a cap from the size of the sun to a quarter of the sky.
                Self::Sphere => Light::Cap(toward, (1.0 / (1.05 + 9.0 * number() * number())).asin()),
                Self::Cap => Light::Cap(toward, 0.005 * 200f64.powf(number())),
                Self::Rectangle => {
                    let center = toward * (1.0 + 3.0 * number());
                    let x = sphere(&mut number);
                    let y = x.cross(sphere(&mut number)).normalize_or(x.any_orthonormal_vector());
                    Light::Rectangle(center, x * (0.1 + 0.9 * number()), y * (0.1 + 0.9 * number()))
                }
            };
            // Part of it above the horizon, and not through the surface's place.
            let seen = match light {
                Light::Cap(axis, sigma) => axis.z > -sigma.sin() && axis.z > -0.05,
                Light::Rectangle(center, x, y) => {
                    let nearest = center
                        - x * (center.dot(x) / x.length_squared()).clamp(-1.0, 1.0)
                        - y * (center.dot(y) / y.length_squared()).clamp(-1.0, 1.0);
                    center.z > 0.0
                        && nearest.length() > 0.3
                        && center.dot(x.cross(y)).abs() > 0.02 * x.cross(y).length()
                }
            };
            if seen {
                return (light, wo);
            }
        }
    }
}

impl Light {
    /// ∫ f_r cosθ over it by many samples.
    pub fn truth(&self, specular: &Specular, wo: DVec3) -> f64 {
        let place = |i: usize| DVec2::new((i % SIDE) as f64 + 0.5, (i / SIDE) as f64 + 0.5) / SIDE as f64;
        let reflected = |wi: DVec3| if wi.z > 0.0 { specular.eval(wi, wo) * wi.z } else { 0.0 };
        let sum: f64 = match *self {
            Self::Cap(axis, sigma) => {
                let (x, y) = axis.any_orthonormal_pair();
                let solid_angle = TAU * (1.0 - sigma.cos());
                let each = (0..SIDE * SIDE).map(|i| {
                    let u = place(i);
                    let z = 1.0 - u.x * solid_angle / TAU;
                    let (s, c) = (TAU * u.y).sin_cos();
                    reflected(axis * z + (x * c + y * s) * (1.0 - z * z).sqrt())
                });
                each.sum::<f64>() * solid_angle
            }
            Self::Rectangle(center, x, y) => {
                let normal = x.cross(y);
                let each = (0..SIDE * SIDE).map(|i| {
                    let u = 2.0 * place(i) - 1.0;
                    let p = center + x * u.x + y * u.y;
                    let distance = p.length();
                    reflected(p / distance) * (p.dot(normal)).abs() / distance.powi(3)
                });
                4.0 * each.sum::<f64>()
            }
        };
        sum / (SIDE * SIDE) as f64
    }

    /// By a table: the light as one cap, or a rectangle as caps of `side` × `side` parts of it.
    pub fn by_table(&self, table: &Table, wo: Vec3, side: usize, memory: &mut Memory) -> f32 {
        memory.clear();
        match *self {
            Self::Cap(axis, sigma) => {
                memory.add(axis.as_vec3(), (TAU * (1.0 - sigma.cos())) as f32, sigma.sin() as f32)
            }
            Self::Rectangle(center, x, y) => {
                let [center, x, y] = [center, x, y].map(|v| v.as_vec3());
                let step = 1.0 / side as f32;
                let (x, y) = (x * step, y * step);
                let parts = |i: usize| (2 * i + 1) as f32 - side as f32;
                for i in 0..side * side {
                    let p = center + x * parts(i % side) + y * parts(i / side);
                    let solid_angle =
                        2.0 * (triangle(p - x - y, p + x - y, p + x + y) + triangle(p - x - y, p + x + y, p - x + y));
                    let cap = (solid_angle * (0.5 / core::f32::consts::PI)).min(1.0);
                    memory.add(p.normalize(), solid_angle, (cap * (2.0 - cap)).sqrt());
                }
            }
        }
        memory.sum(table, wo)
    }
}

/// Half of the solid angle of a triangle (van Oosterom and Strackee 1983).
fn triangle(a: Vec3, b: Vec3, c: Vec3) -> f32 {
    let (x, y, z) = (a.length(), b.length(), c.length());
    let over = a.dot(b.cross(c)).abs();
    let under = x * y * z + a.dot(b) * z + a.dot(c) * y + b.dot(c) * x;
    over.atan2(under)
}

/// Caps of a light, their irradiances, and their means.
#[derive(Default)]
pub struct Memory {
    caps: CapBatch,
    irradiance: Vec<f32>,
    mean: Vec<f32>,
}

impl Memory {
    fn clear(&mut self) {
        self.caps.clear();
        self.irradiance.clear();
    }

    /// A cap whose half angle has this sine. As it sinks below the horizon it fades, and its axis stays on the horizon, which is
    /// what the caches of `render` do.
    fn add(&mut self, axis: Vec3, solid_angle: f32, sine: f32) {
        let fade = 1.0 - (-axis.z / sine.max(1e-6)).max(0.0);
        if fade > 0.0 {
            let axis = axis.with_z(axis.z.max(0.0)).normalize_or(Vec3::Z);
            let height = (solid_angle * (0.5 / core::f32::consts::PI)).min(1.0);
            self.caps.push_nearest(axis, solid_angle);
            self.irradiance.push(projected_solid_angle(axis.z, height) * fade * fade);
        }
    }

    fn sum(&mut self, table: &Table, wo: Vec3) -> f32 {
        self.mean.resize(self.caps.len(), 0.0);
        table.specular_values(&self.caps, wo, &mut self.mean);
        self.irradiance.iter().zip(&self.mean).map(|(e, f)| e * f).sum()
    }
}

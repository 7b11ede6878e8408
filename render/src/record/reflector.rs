//! What a record reflects with: a fitted table and the colours of its two parts.

use crate::scene::Rgb;
use brdf_tables::brdf::Specular;
use brdf_tables::cap::Cap;
use brdf_tables::table::Table;
use core::f32::consts::{FRAC_1_PI, FRAC_PI_2};
use glam::{DVec3, Vec3A};

/// kd/π + ks · tint · F(θe, Ω; ωo).
#[derive(Clone, Copy, Debug)]
pub struct Reflector<'a> {
    /// Mean BRDF of the specular part at unit strength.
    pub table: &'a Table,
    /// Albedo kd of the Lambertian part.
    pub diffuse: Rgb,
    /// Strength ks of the specular part.
    pub specular: Rgb,
}

impl Reflector<'_> {
    /// The whole mean BRDF in sr⁻¹ without tint, given the specular one at unit strength.
    #[inline]
    pub fn whole(&self, specular: f32) -> Rgb {
        self.diffuse * FRAC_1_PI + self.specular * specular
    }

    /// Colour of the Fresnel term for light from `wi`, both directions local.
    #[inline]
    pub fn tint(&self, wi: Vec3A, wo: Vec3A) -> Rgb {
        self.table.specular().map_or(Rgb::ONE, |s| fresnel_tint(s, wi, wo))
    }
}

/// Colour of the Fresnel term of a model for light from `wi`, both directions local.
#[inline]
pub fn fresnel_tint(specular: &Specular, wi: Vec3A, wo: Vec3A) -> Rgb {
    specular.fresnel().map_or(Rgb::ONE, |fresnel| {
        let tint = fresnel.tint(f64::from((0.5 * (wi + wo).length()).min(1.0)));
        Rgb::from_array(tint.map(|x| x as f32))
    })
}

/// Directional albedo and support of the specular part at unit strength, tabulated once per material.
#[derive(Clone, Debug)]
pub struct Albedo {
    /// ρ(ωo) at equidistant cosines 0 … 1 and, where the material is anisotropic, azimuths 0 … π/2.
    values: Vec<f32>,
    azimuths: usize,
    /// Cosine of the angle from the mirror direction beyond which a small cap does not matter.
    support: f32,
}

/// Intervals of the cosine.
const COSINES: usize = 64;

impl Albedo {
    /// Tabulates the albedo: π F of the whole hemisphere; zero for a diffuse table.
    pub fn new(table: &Table) -> Self {
        let azimuths = if table.specular().is_none_or(Specular::is_isotropic) { 1 } else { 17 };
        let mut values = Vec::with_capacity((COSINES + 1) * azimuths);
        for i in 0..=COSINES {
            // Grazing exactly, most models vanish.
            let z = (i as f64 / COSINES as f64).max(1e-3);
            for k in 0..azimuths {
                let phi = FRAC_PI_2 as f64 * k as f64 / (azimuths - 1).max(1) as f64;
                let r = (1.0 - z * z).sqrt();
                values.push(
                    table
                        .specular()
                        .map_or(0.0, |s| directional_albedo(s, DVec3::new(r * phi.cos(), r * phi.sin(), z))),
                );
            }
        }
        let small = |theta: f64| Cap::new(theta, 0.0, 1e-4).map_or(0.0, |cap| table.support(&cap));
        let support = [0.0, 0.4, 0.8, 1.1].into_iter().map(small).fold(0.0, f64::max);
        Self { values, azimuths, support: support.min(core::f64::consts::PI) as f32 }
    }

    /// ρ(ωo) for a local direction.
    pub fn at(&self, wo: Vec3A) -> f32 {
        let x = wo.z.clamp(0.0, 1.0) * COSINES as f32;
        let i = (x as usize).min(COSINES - 1);
        let row = |i: usize| {
            if self.azimuths == 1 {
                return self.values[i];
            }
            let y = wo.y.abs().atan2(wo.x.abs()) / FRAC_PI_2 * (self.azimuths - 1) as f32;
            let k = (y as usize).min(self.azimuths - 2);
            let row = &self.values[i * self.azimuths..];
            row[k] + (row[k + 1] - row[k]) * (y - k as f32)
        };
        row(i) + (row(i + 1) - row(i)) * (x - i as f32)
    }

    /// Cosine and sine of the angle from the mirror direction beyond which a small cap does not matter.
    #[inline]
    pub fn support(&self) -> (f32, f32) {
        (self.support.cos(), self.support.sin())
    }

    /// Cosine of the angle from the mirror direction beyond which a cap of solid angle Ω (sr) does not matter.
    #[inline]
    pub fn support_cosine(&self, solid_angle: f32) -> f32 {
        let angle = self.support + super::cap_half_angle(solid_angle);
        if angle >= core::f32::consts::PI { -1.0 } else { angle.cos() }
    }
}

/// ρ(ωo) = ∫ f_r cosθ dω by the model's own sampler over a regular grid.
fn directional_albedo(specular: &Specular, wo: DVec3) -> f32 {
    use brdf_tables::brdf::Brdf;
    const GRID: (u32, u32) = (48, 32);
    let mut sum = 0.0;
    for i in 0..GRID.0 * GRID.1 {
        let cell = glam::DVec2::new(f64::from(i / GRID.1) + 0.5, f64::from(i % GRID.1) + 0.5);
        let Some(wi) = specular.sample(wo, cell / glam::DVec2::new(GRID.0.into(), GRID.1.into())) else { continue };
        let pdf = specular.pdf(wi, wo);
        if wi.z > 0.0 && pdf > 0.0 {
            sum += specular.eval(wi, wo) * wi.z / pdf;
        }
    }
    (sum / f64::from(GRID.0 * GRID.1)) as f32
}

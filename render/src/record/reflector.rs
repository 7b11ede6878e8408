//! What a record reflects with: a fitted table and the colours of its two parts.

use super::schlick::{COSINES, Colors, Edge, edge, reflected};
use crate::bsdf::Parts;
use crate::scene::Rgb;
use brdf_tables::batch::CapBatch;
use brdf_tables::brdf::{Brdf, Fresnel, Microfacet, Specular};
use brdf_tables::cap::Cap;
use brdf_tables::table::{Representation, Table};
use brdf_tables::zonal::Zonal;
use core::f32::consts::{FRAC_1_PI, FRAC_PI_2};
use glam::{DVec3, Vec3A};

/// kd/π + ks · tint · F(θe, Ω; ωo).
#[derive(Clone, Copy, Debug)]
pub struct Reflector<'a> {
    /// Mean BRDF of the specular part at unit strength.
    pub table: &'a Table,
    /// Albedo kd of the Lambertian part.
    pub diffuse: Rgb,
    colors: Colors,
    /// The grey reflectance of facets, where it is not that of the table.
    gray: Option<Fresnel>,
}

impl<'a> Reflector<'a> {
    /// From a table, the albedo kd of the Lambertian part and the strength ks of the specular part.
    pub fn new(table: &'a Table, diffuse: Rgb, specular: Rgb) -> Self {
        Self { table, diffuse, colors: Colors { normal: specular, grazing: specular }, gray: None }
    }

    /// From the colours of a material. A table of facets with Schlick's reflectance takes that of the material in place of its
    /// own: its grey part is integrated over the caps, its hue taken at their axes.
    pub fn of(table: &'a Table, parts: &Parts) -> Self {
        if let Some(Specular::Microfacet(Microfacet { fresnel: Fresnel::Schlick { .. }, .. })) = table.specular() {
            let colors = Colors { normal: parts.specular, grazing: parts.grazing };
            return Self { table, diffuse: parts.diffuse, colors, gray: colors.gray() };
        }
        Self::new(table, parts.diffuse, parts.specular)
    }

    /// Colours of the specular part, of light along the half vector and of light that grazes it, and where they follow Schlick's
    /// formula the grey reflectance at normal incidence that stands for them in the integral.
    #[cfg(feature = "gpu")]
    pub(crate) fn colors(&self) -> (Rgb, Rgb, Option<f32>) {
        let f0 = match self.gray {
            Some(Fresnel::Schlick { f0 }) => Some(f0[0] as f32),
            _ => None,
        };
        (self.colors.normal, self.colors.grazing, f0)
    }

    /// The specular part for many caps; [`Reflector::tint`] makes it the mean BRDF in sr⁻¹.
    pub fn values(&self, caps: &CapBatch, wo: Vec3A, out: &mut [f32]) {
        match self.gray {
            Some(gray) => self.table.values_with_fresnel(gray, caps, wo.into(), out),
            None => self.table.specular_values(caps, wo.into(), out),
        }
    }

    /// The table of a lobe that is radial, and the tint, which is the same for all directions then.
    pub(super) fn zonal(&self) -> Option<(&'a Zonal, Rgb)> {
        match &self.table.representation {
            Representation::Zonal(table) if self.gray.is_none() => Some((table, self.colors.normal)),
            _ => None,
        }
    }

    /// The whole mean BRDF in sr⁻¹ but for hues that change with the angle, given one of [`Reflector::values`].
    #[inline]
    pub fn whole(&self, value: f32) -> Rgb {
        self.diffuse * FRAC_1_PI + self.colors.grazing * value
    }

    /// Factor on [`Reflector::values`] for light from `wi`, both directions local.
    #[inline]
    pub fn tint(&self, wi: Vec3A, wo: Vec3A) -> Rgb {
        match self.gray {
            Some(_) => self.colors.tint(edge(wi, wo)),
            None => self.colors.normal * self.table.specular().map_or(Rgb::ONE, |s| fresnel_tint(s, wi, wo)),
        }
    }

    /// f_r of the specular part in sr⁻¹, by the model itself.
    pub fn specular(&self, wi: Vec3A, wo: Vec3A) -> Rgb {
        let Some(model) = self.table.specular() else { return Rgb::ZERO };
        let model = match (self.gray, *model) {
            (Some(fresnel), Specular::Microfacet(facets)) => Specular::Microfacet(Microfacet { fresnel, ..facets }),
            (_, model) => model,
        };
        self.tint(wi, wo) * model.eval(wi.as_dvec3(), wo.as_dvec3()) as f32
    }

    /// Reflectance of the specular part for light from everywhere, and what [`Reflector::values`] sum up to under it.
    #[inline]
    pub fn albedo(&self, albedo: &Albedo, wo: Vec3A) -> (Rgb, f32) {
        let own = albedo.at(wo);
        match self.gray {
            Some(_) => {
                let s = albedo.edge.at(wo);
                let facets = own / albedo.edge.gray_at(s);
                (self.colors.at(s) * facets, self.colors.gray_at(s) * facets)
            }
            None => (self.tint(Vec3A::new(-wo.x, -wo.y, wo.z), wo) * own, own),
        }
    }
}

/// Colour of the Fresnel term of a model, or of what was measured, for light from `wi`, both directions local.
#[inline]
pub fn fresnel_tint(specular: &Specular, wi: Vec3A, wo: Vec3A) -> Rgb {
    if let Specular::Measured(measured) = specular {
        return Rgb::from_array(measured.tint(wi.as_dvec3(), wo.as_dvec3()).map(|x| x as f32));
    }
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
    /// Angle from the mirror direction beyond which a small cap does not matter; its cosine and sine.
    support: f32,
    support_at: (f32, f32),
    edge: Edge,
}

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
                let wo = DVec3::new(r * phi.cos(), r * phi.sin(), z);
                values.push(table.specular().map_or(0.0, |s| reflected(s, wo)[0]));
            }
        }
        let small = |theta: f64| Cap::new(theta, 0.0, 1e-4).map_or(0.0, |cap| table.support(&cap));
        let support = [0.0, 0.4, 0.8, 1.1].into_iter().map(small).fold(0.0, f64::max);
        let edge = table.specular().map_or_else(Edge::default, Edge::new);
        let support = support.min(core::f64::consts::PI) as f32;
        Self { values, azimuths, support, support_at: (support.cos(), support.sin()), edge }
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
        self.support_at
    }

    /// Cosine of the angle from the mirror direction beyond which a cap of solid angle Ω (sr) does not matter.
    #[inline]
    pub fn support_cosine(&self, solid_angle: f32) -> f32 {
        let angle = self.support + crate::hemisphere::cap_half_angle(solid_angle);
        if angle >= core::f32::consts::PI { -1.0 } else { angle.cos() }
    }
}

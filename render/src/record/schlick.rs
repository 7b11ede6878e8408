//! Schlick's reflectance over a lobe of facets: k0 + (k90 − k0) s with s = (1 − cos δ)⁵, δ between the half vector and either
//! direction. It is linear in both colours, so what a lobe reflects of light from everywhere needs two numbers per view.

use crate::scene::Rgb;
use brdf_tables::brdf::{Brdf, Fresnel, Microfacet, Specular};
use glam::{DVec2, DVec3, Vec3A};

/// Colours at normal and at grazing incidence of a half vector.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Colors {
    /// k0.
    pub normal: Rgb,
    /// k90.
    pub grazing: Rgb,
}

impl Colors {
    /// The grey term of the same shape that is 1 at grazing incidence; `None` where the colour there is black, as glTF has it
    /// only of what reflects nothing.
    pub fn gray(&self) -> Option<Fresnel> {
        let strength = self.grazing.element_sum();
        (strength > 0.0).then(|| Fresnel::Schlick { f0: [f64::from(self.normal.element_sum() / strength); 3] })
    }

    /// The colour where s has this value.
    #[inline]
    pub fn at(&self, s: f32) -> Rgb {
        self.normal + (self.grazing - self.normal) * s
    }

    /// The grey term of [`Colors::gray`] where s has this value.
    #[inline]
    pub fn gray_at(&self, s: f32) -> f32 {
        let ratio = self.normal.element_sum() / self.grazing.element_sum();
        ratio + (1.0 - ratio) * s
    }

    /// [`Colors::at`] over [`Colors::gray_at`]; that of grazing light where both vanish.
    #[inline]
    pub fn tint(&self, s: f32) -> Rgb {
        let gray = self.gray_at(s);
        if gray > 1e-12 { self.at(s) / gray } else { self.grazing }
    }
}

/// s for two local directions.
#[inline]
pub fn edge(wi: Vec3A, wo: Vec3A) -> f32 {
    (1.0 - 0.5 * (wi + wo).length()).max(0.0).powi(5)
}

/// Intervals of the cosine.
pub(super) const COSINES: usize = 64;

/// Mean of s over what facets would reflect of light from everywhere if they reflected all, by view.
#[derive(Clone, Debug)]
pub struct Edge {
    /// At equidistant cosines 0 … 1.
    values: [f32; COSINES + 1],
    /// f0 of the model's own Schlick term, grey; 1 where it has none.
    f0: f32,
}

impl Edge {
    /// For a model of isotropic facets; 0 for others, whose colours do not change with the angle.
    pub fn new(specular: &Specular) -> Self {
        let Specular::Microfacet(facets @ Microfacet { fresnel: Fresnel::Schlick { f0 }, .. }) = specular else {
            return Self::default();
        };
        let facets = Specular::Microfacet(Microfacet { fresnel: Fresnel::None, ..*facets });
        let values = core::array::from_fn(|i| {
            let z = (i as f64 / COSINES as f64).max(1e-3);
            let [all, edge] = reflected(&facets, DVec3::new((1.0 - z * z).sqrt(), 0.0, z));
            if all > 0.0 { edge / all } else { 0.0 }
        });
        Self { values, f0: (f0.iter().sum::<f64>() / 3.0) as f32 }
    }

    /// For a local direction to the eye.
    #[inline]
    pub fn at(&self, wo: Vec3A) -> f32 {
        let x = wo.z.clamp(0.0, 1.0) * COSINES as f32;
        let i = (x as usize).min(COSINES - 1);
        self.values[i] + (self.values[i + 1] - self.values[i]) * (x - i as f32)
    }

    /// The model's own grey reflectance where s has this value.
    #[inline]
    pub fn gray_at(&self, s: f32) -> f32 {
        (self.f0 + (1.0 - self.f0) * s).max(f32::MIN_POSITIVE)
    }
}

impl Default for Edge {
    fn default() -> Self {
        Self { values: [0.0; COSINES + 1], f0: 1.0 }
    }
}

/// ∫ f_r cosθ dω and ∫ f_r s cosθ dω by the model's own sampler over a regular grid.
pub(super) fn reflected(specular: &Specular, wo: DVec3) -> [f32; 2] {
    const GRID: (u32, u32) = (48, 32);
    let mut sums = [0.0; 2];
    for i in 0..GRID.0 * GRID.1 {
        let cell = DVec2::new(f64::from(i / GRID.1) + 0.5, f64::from(i % GRID.1) + 0.5);
        let Some(wi) = specular.sample(wo, cell / DVec2::new(GRID.0.into(), GRID.1.into())) else { continue };
        let pdf = specular.pdf(wi, wo);
        if wi.z > 0.0 && pdf > 0.0 {
            let value = specular.eval(wi, wo) * wi.z / pdf;
            sums[0] += value;
            sums[1] += value * f64::from(edge(wi.as_vec3a(), wo.as_vec3a()));
        }
    }
    sums.map(|sum| (sum / f64::from(GRID.0 * GRID.1)) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grey_times_tint_is_the_colour() {
        let colors = Colors { normal: Rgb::new(0.9, 0.5, 0.1), grazing: Rgb::new(1.0, 0.9, 0.8) };
        let Some(gray) = colors.gray() else { panic!("the colour changes") };
        for cos in [0.0f32, 0.3, 0.7, 1.0] {
            let s = (1.0 - cos).powi(5);
            let product = gray.gray(cos) * colors.tint(s);
            assert!((product - colors.at(s)).abs().max_element() < 1e-6, "{cos}: {product}");
        }
        assert_eq!(Colors { normal: Rgb::ZERO, grazing: Rgb::ZERO }.gray(), None);
    }
}

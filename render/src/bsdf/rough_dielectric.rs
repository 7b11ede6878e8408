//! Rough interface of two dielectrics (Walter, Marschner, Li and Torrance 2007, "Microfacet models for refraction through
//! rough surfaces").

use super::{Facets, Scatter, Split, Value, fresnel};
use crate::scene::Rgb;
use glam::{Vec2, Vec3A};

/// The interface with its facets.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RoughDielectric {
    pub facets: Facets,
    /// Index inside over outside.
    pub eta: f32,
    pub reflectance: Rgb,
    pub transmittance: Rgb,
}

impl RoughDielectric {
    /// Factor of the index of refraction along the path.
    #[inline]
    pub fn eta_along(&self, wo: Vec3A, wi: Vec3A) -> f32 {
        if wo.z * wi.z > 0.0 {
            1.0
        } else if wo.z > 0.0 {
            self.eta
        } else {
            1.0 / self.eta
        }
    }

    /// Half vector on the side of the normal (eqs. 13, 16).
    #[inline]
    fn half(&self, wo: Vec3A, wi: Vec3A) -> Option<Vec3A> {
        let h = (wo + wi * self.eta_along(wo, wi)).try_normalize()?;
        Some(if h.z < 0.0 { -h } else { h }).filter(|h| h.z > 0.0)
    }

    /// Equations 20 and 21, over the square of the index for transmitted radiance.
    pub fn value(&self, wo: Vec3A, wi: Vec3A) -> Value {
        let (Some(h), true) = (self.half(wo, wi), wo.z != 0.0 && wi.z != 0.0) else { return Value::default() };
        let (cos_o, cos_i) = (wo.dot(h), wi.dot(h));
        if cos_o * wo.z <= 0.0 || cos_i * wi.z <= 0.0 {
            return Value::default();
        }
        let r = fresnel::dielectric(cos_o, self.eta).reflectance;
        let dg = self.facets.d(h) * self.facets.g1(wo, h) * self.facets.g1(wi, h);
        // Facets are symmetric: the ones seen from below are those seen from the opposite point.
        let side = wo.z.signum();
        let density = self.facets.pdf(side * wo, h);
        let (glossy, pdf) = if wo.z * wi.z > 0.0 {
            (self.reflectance * (r * dg / (4.0 * wo.z * wi.z).abs()), r * density / (4.0 * cos_o.abs()))
        } else {
            let eta = self.eta_along(wo, wi);
            let jacobian = 1.0 / (cos_o + eta * cos_i).powi(2);
            let f = (1.0 - r) * dg * jacobian * (cos_o * cos_i / (wo.z * wi.z)).abs();
            (self.transmittance * f, (1.0 - r) * density * eta * eta * jacobian * cos_i.abs())
        };
        if !pdf.is_finite() {
            return Value::default();
        }
        Value { f: Split { diffuse: Rgb::ZERO, glossy }, pdf }
    }

    /// Visible facet, then reflection or refraction by its Fresnel share.
    pub fn sample(&self, wo: Vec3A, choice: f32, u: Vec2) -> Option<Scatter> {
        let side = wo.z.signum();
        let h = self.facets.sample(side * wo, u)?;
        let interface = fresnel::dielectric(wo.dot(h), self.eta);
        let wi = if choice < interface.reflectance {
            Some(2.0 * wo.dot(h) * h - wo).filter(|wi| wi.z * wo.z > 0.0)
        } else {
            Some(fresnel::refract(wo, h, &interface)).filter(|wi| wi.z * wo.z < 0.0)
        };
        wi.map(Scatter::Direction)
    }
}

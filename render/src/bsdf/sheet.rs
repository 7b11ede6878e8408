//! A surface of glass without thickness, as glTF has it: what it does not reflect passes straight on.

use super::{Facets, Scatter, Split, Value, fresnel, mirror};
use crate::scene::Rgb;
use glam::{Vec2, Vec3A};

/// A sheet, the same from both sides. Light passes it as it would be reflected, mirrored about the sheet.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sheet {
    /// `None` where it is smooth.
    pub facets: Option<Facets>,
    /// Index of the glass.
    pub eta: f32,
    pub reflectance: Rgb,
    pub transmittance: Rgb,
}

/// Mirrored about the sheet.
fn across(w: Vec3A) -> Vec3A {
    Vec3A::new(w.x, w.y, -w.z)
}

impl Sheet {
    pub fn value(&self, wo: Vec3A, wi: Vec3A) -> Value {
        let (Some(facets), true) = (&self.facets, wo.z != 0.0 && wi.z != 0.0) else { return Value::default() };
        let (passes, side) = (wo.z * wi.z < 0.0, wo.z.signum());
        let wo = side * wo;
        let wi = if passes { across(side * wi) } else { side * wi };
        let r = fresnel::dielectric((0.5 * (wo + wi).length()).min(1.0), self.eta).reflectance;
        let (share, tint) = if passes { (1.0 - r, self.transmittance) } else { (r, self.reflectance) };
        let glossy = tint * (share * facets.reflection(wo, wi));
        Value { f: Split { diffuse: Rgb::ZERO, glossy }, pdf: share * facets.reflection_pdf(wo, wi) }
    }

    /// Visible facet, then reflection or passage by its Fresnel share.
    pub fn sample(&self, wo: Vec3A, choice: f32, u: Vec2) -> Option<Scatter> {
        let side = wo.z.signum();
        let Some(facets) = &self.facets else {
            let reflected = choice < fresnel::dielectric(wo.z.abs(), self.eta).reflectance;
            let (wi, weight) = if reflected { (mirror(wo), self.reflectance) } else { (-wo, self.transmittance) };
            return Some(Scatter::Delta { wi, weight, eta: 1.0 });
        };
        let h = facets.sample(side * wo, u)?;
        let cos = h.dot(side * wo);
        let wi = Some(2.0 * cos * h - side * wo).filter(|wi| wi.z > 0.0)?;
        let reflected = choice < fresnel::dielectric(cos, self.eta).reflectance;
        Some(Scatter::Direction(side * if reflected { wi } else { across(wi) }))
    }
}

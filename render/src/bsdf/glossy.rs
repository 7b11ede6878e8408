//! A Lambertian part beside a lobe of `brdf-tables`: the models the cache has tables for.

use super::{Parts, Scatter, Split, Value, mirror};
use crate::frame::{Frame, cosine_hemisphere};
use crate::math::sin_cos_turn;
use crate::scene::Rgb;
use brdf_tables::brdf::{Brdf, Formula, Fresnel, Microfacet, Phong, Specular, Visitor, Ward};
use core::f32::consts::{FRAC_1_PI, PI};
use glam::{Vec2, Vec3A};

/// The specular part at unit strength.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Lobe<'a> {
    Phong(Phong),
    Ward(Ward),
    /// A model that nothing is known of here.
    Any(&'a Specular),
}

/// kd/π + ks · lobe.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Glossy<'a> {
    /// kd.
    pub diffuse: Rgb,
    /// ks.
    pub specular: Rgb,
    pub lobe: Lobe<'a>,
    /// Probability of sampling the diffuse part.
    pub p_diffuse: f32,
}

impl<'a> Glossy<'a> {
    pub fn new(diffuse: Rgb, specular: Rgb, lobe: Lobe<'a>) -> Self {
        let p_diffuse = super::share(super::mean(diffuse), super::mean(specular));
        Self { diffuse, specular, lobe, p_diffuse }
    }

    /// What records know it by. Facets whose reflectance is Schlick's have it in their colours, which a table of such facets takes in
    /// place of its own.
    pub fn parts(&self) -> Parts {
        match self.lobe {
            Lobe::Any(Specular::Microfacet(Microfacet { fresnel: Fresnel::Schlick { f0 }, .. })) => {
                let normal = self.specular * Rgb::from_array(f0.map(|x| x as f32));
                Parts { diffuse: self.diffuse, specular: normal, grazing: self.specular }
            }
            _ => Parts::even(self.diffuse, self.specular),
        }
    }

    #[inline(always)]
    pub fn value(&self, wo: Vec3A, wi: Vec3A) -> Value {
        let (f, pdf) = match &self.lobe {
            Lobe::Any(model) => return self.any(model, wo, wi),
            // The density of the cosine lobe is f (n+1)/(n+2).
            Lobe::Phong(m) => {
                let f = m.f(wi.to_array(), wo.to_array());
                let n = m.exponent as f32;
                (f, f * ((n + 1.0) / (n + 2.0)))
            }
            Lobe::Ward(m) => (m.f(wi.to_array(), wo.to_array()), ward_pdf(m, wo, wi)),
        };
        Value {
            f: Split { diffuse: self.diffuse * FRAC_1_PI, glossy: self.specular * f },
            pdf: self.p_diffuse * wi.z * FRAC_1_PI + (1.0 - self.p_diffuse) * pdf,
        }
    }

    /// The value for a model that has a Fresnel term of its own, perhaps, and does all but its formula in f64.
    fn any(&self, model: &Specular, wo: Vec3A, wi: Vec3A) -> Value {
        struct At(Vec3A, Vec3A);
        impl Visitor for At {
            type Output = f32;
            #[inline(always)]
            fn visit<M: Brdf + Formula>(self, model: &M) -> f32 {
                model.f(self.0.to_array(), self.1.to_array())
            }
        }
        let [i, o] = [wi, wo].map(|w| w.as_dvec3());
        let tint = model.tint(i, o).map(|x| x as f32);
        Value {
            f: Split {
                diffuse: self.diffuse * FRAC_1_PI,
                glossy: self.specular * Rgb::from_array(tint) * model.visit(At(wi, wo)),
            },
            pdf: self.p_diffuse * wi.z * FRAC_1_PI + (1.0 - self.p_diffuse) * model.pdf(i, o) as f32,
        }
    }

    #[inline(always)]
    pub fn sample(&self, wo: Vec3A, choice: f32, u: Vec2) -> Option<Scatter> {
        if choice < self.p_diffuse {
            return Some(Scatter::Direction(cosine_hemisphere(u)));
        }
        let wi = match &self.lobe {
            Lobe::Phong(m) => {
                let cos = u.x.powf(1.0 / (m.exponent as f32 + 1.0));
                let sin = (1.0 - cos * cos).max(0.0).sqrt();
                let (s, c) = sin_cos_turn(u.y);
                Frame::from_normal(mirror(wo)).to_world(Vec3A::new(sin * c, sin * s, cos))
            }
            // Gaussian slopes of the half vector (Walter 2005, "Notes on the Ward BRDF", eq. 6 and 7).
            Lobe::Ward(m) => {
                let radius = (-(1.0 - u.x).ln()).sqrt();
                let (s, c) = sin_cos_turn(u.y);
                let h = Vec3A::new(m.alpha_x as f32 * radius * c, m.alpha_y as f32 * radius * s, 1.0).normalize();
                if wo.dot(h) <= 0.0 {
                    return None;
                }
                2.0 * wo.dot(h) * h - wo
            }
            Lobe::Any(model) => model.sample(wo.as_dvec3(), u.as_dvec2())?.as_vec3a(),
        };
        (wi.z > 0.0).then_some(Scatter::Direction(wi))
    }
}

/// Density of the Ward lobe's sampling (Walter 2005, eq. 9).
fn ward_pdf(m: &Ward, wo: Vec3A, wi: Vec3A) -> f32 {
    let Some(h) = (wi + wo).try_normalize() else { return 0.0 };
    let (ax, ay) = (m.alpha_x as f32, m.alpha_y as f32);
    let slope2 = ((h.x / ax).powi(2) + (h.y / ay).powi(2)) / (h.z * h.z);
    (-slope2).exp() / (4.0 * PI * ax * ay * wo.dot(h) * h.z.powi(3))
}

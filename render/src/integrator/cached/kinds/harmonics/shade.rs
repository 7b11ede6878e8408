//! What harmonic records reflect (radiance-caching-2005, eqs. 12 and 13).

use super::{Functions, Harmonics, Held};
use crate::bsdf::{Parts, Split};
use crate::cache::{FOUND, Lookup};
use crate::color::mean_radiance;
use crate::integrator::cached::kind::{Found, Shaded};
use crate::integrator::cached::settings::Quality;
use crate::record::harmonics::HarmonicsRecord;
use crate::record::{Receiver, Record, Reflected};
use crate::scene::Rgb;

impl Harmonics {
    /// What one record reflects at a point.
    pub(super) fn reflected(
        &self,
        held: Held,
        record: &HarmonicsRecord,
        parts: &Parts,
        at: &Receiver,
        functions: &mut Functions,
    ) -> Rgb {
        let brdf = &self.brdfs[held.brdf];
        functions.look(brdf, at);
        let found = functions.read(record, at.position);
        parts.diffuse * mean_radiance(found.irradiance) + brdf.color(parts, at.wo) * found.specular
    }

    /// What the records about a point reflect, and the share of path tracing. Negative radiance of ringing is left as it is: it
    /// belongs to the sum.
    #[inline(always)]
    pub(super) fn interpolated(
        &self,
        held: Held,
        records: &impl Lookup<HarmonicsRecord>,
        surface: &Shaded,
        quality: &Quality,
        functions: &mut Functions,
    ) -> Found {
        let brdf = &self.brdfs[held.brdf];
        let at = &surface.at;
        let outgoing = functions.look(brdf, at);
        if outgoing.traced >= 1.0 {
            return Found::NOTHING;
        }
        let (mut sum, mut weights) = (Reflected::default(), 0.0);
        records.interpolate(at.position, surface.hemisphere, quality.weight, |record, w| {
            if surface.finish.reads(record.zone().material) {
                let part = functions.read(record, at.position);
                sum.irradiance += part.irradiance * w;
                sum.specular += part.specular * w;
                weights += w;
            }
        });
        self.judged(held, surface, (sum.irradiance, sum.specular), weights, outgoing.traced)
    }

    /// What sums of irradiance and of specular light at unit strength say, with the weights in them.
    #[inline(always)]
    fn judged(&self, held: Held, surface: &Shaded, sums: (Rgb, Rgb), weights: f32, traced: f32) -> Found {
        let (parts, (irradiance, specular)) = (surface.parts, sums);
        let light = (weights > FOUND).then(|| Split {
            diffuse: parts.diffuse * mean_radiance(irradiance / weights),
            glossy: self.brdfs[held.brdf].color(parts, surface.at.wo) * (specular / weights),
        });
        Found { light, traced, doubt: 0.0 }
    }

    /// The same of sums that another has taken.
    #[cfg(feature = "gpu")]
    pub(in crate::integrator::cached) fn found(
        &self,
        held: Held,
        surface: &Shaded,
        sums: (Rgb, Rgb),
        weights: f32,
    ) -> Found {
        let traced = self.brdfs[held.brdf].outgoing(surface.at.wo).traced;
        if traced >= 1.0 { Found::NOTHING } else { self.judged(held, surface, sums, weights, traced) }
    }
}

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
        let (at, parts) = (&surface.at, surface.parts);
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
        let light = (weights > FOUND).then(|| Split {
            diffuse: parts.diffuse * mean_radiance(sum.irradiance / weights),
            glossy: brdf.color(parts, at.wo) * (sum.specular / weights),
        });
        Found { light, traced: outgoing.traced, doubt: 0.0 }
    }
}

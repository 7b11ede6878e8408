//! What EAS records reflect (eas-2015, eq. 17).

use super::{Eas, Held};
use crate::bsdf::Split;
use crate::cache::{FOUND, Lookup};
use crate::color::mean_radiance;
use crate::integrator::cached::kind::{Found, Shaded};
use crate::integrator::cached::settings::Quality;
use crate::record::eas::EasRecord;
use crate::record::{Record, Reflected, Reflector, Scratch, reflect};
use crate::scene::Rgb;
use glam::Vec3A;

/// Doubt about records that is borne without tracing.
const DOUBT: f32 = 0.1;

/// Weight of the records made for a view, from which on they are relied on alone.
const SEEN: f32 = 0.1;

impl Eas {
    /// Eq. 17, and the share of it that is to be traced instead because records say little of this point.
    #[inline(always)]
    pub(super) fn interpolated(
        &self,
        held: Held,
        records: &impl Lookup<EasRecord>,
        surface: &Shaded,
        quality: &Quality,
        scratch: &mut Scratch,
    ) -> Found {
        let lobe = &self.lobes[held.lobe];
        let (at, parts) = (&surface.at, surface.parts);
        let reflector = Reflector::of(&lobe.table, parts);
        let (mut sum, mut weights) = (Reflected::default(), 0.0);
        // Weight of the records that are fine enough for this view, and whether there are others.
        let (mut seen, mut others) = (0.0, false);
        let mirror = at.frame.to_world(Vec3A::new(-at.wo.x, -at.wo.y, at.wo.z));
        // `sum.trust` is the weight of the specular sum.
        records.interpolate(at.position, surface.hemisphere, quality.weight, |record, w| {
            if surface.finish.reads(record.zone().material) {
                let part = reflect(record, at, &reflector, &lobe.albedo, quality.estimator, scratch);
                let view = w * record.views.trust(mirror, lobe.width);
                sum.irradiance += part.irradiance * w;
                sum.specular += part.specular * (view * part.trust);
                sum.trust += view * part.trust;
                weights += w;
                seen += view;
                others |= !record.views.is_all();
            }
        });
        let doubt = ((1.0 - sum.trust / seen) - DOUBT) / (1.0 - DOUBT);
        // Where all were made for other views, little is known.
        let unseen = if others { 1.0 - seen / SEEN } else { 0.0 };
        let doubt = doubt.max(unseen).max(0.0);
        let light = (weights > FOUND).then(|| Split {
            diffuse: parts.diffuse * mean_radiance(sum.irradiance.max(Rgb::ZERO) / weights),
            glossy: sum.specular.max(Rgb::ZERO) / sum.trust.max(f32::MIN_POSITIVE),
        });
        // Where nothing shines, the irradiance is all.
        let doubt = if parts.is_diffuse() { 0.0 } else { doubt };
        let traced = if parts.is_diffuse() { 0.0 } else { held.traced.max(doubt) };
        Found { light, traced, doubt }
    }
}

//! What EAS records reflect (eas-2015, eq. 17).

use super::{Eas, Held, Lobe, Memory};
use crate::bsdf::{Parts, Split};
use crate::cache::{Drawn, FOUND, Lookup};
use crate::color::mean_radiance;
use crate::integrator::cached::kind::{Found, Shaded};
use crate::integrator::cached::settings::Quality;
use crate::record::eas::{EasRecord, Estimator};
use crate::record::{Receiver, Record, Reflected, Reflector, Scratch, reflect, reflect_together};
use crate::scene::Rgb;
use brdf_tables::real::LANES;
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
        let reflector = Reflector::of(&lobe.table, surface.parts);
        let mut sum = Sum::about(surface);
        records.interpolate(surface.at.position, surface.hemisphere, quality.weight, |record, w| {
            if surface.finish.reads(record.zone().material) {
                let part = reflect(record, &surface.at, &reflector, &lobe.albedo, quality.estimator, scratch);
                sum.add(record, &part, w, lobe);
            }
        });
        sum.found(held, surface.parts)
    }

    /// The same at many surfaces, record by record: each is moved to as many of them at once as there are lanes.
    pub(super) fn splatted(
        &self,
        held: Held,
        records: &Drawn<EasRecord>,
        surfaces: &[Shaded],
        quality: &Quality,
        memory: &mut Memory,
    ) -> Vec<Found> {
        let Memory(scratches) = memory;
        if quality.estimator == Estimator::Paper {
            let one = |at: &Shaded| self.interpolated(held, records, at, quality, &mut scratches[0]);
            return surfaces.iter().map(one).collect();
        }
        let lobe = &self.lobes[held.lobe];
        let reflectors: Vec<_> = surfaces.iter().map(|s| Reflector::of(&lobe.table, s.parts)).collect();
        let mut sums: Vec<_> = surfaces.iter().map(Sum::about).collect();
        let mut reached = Vec::with_capacity(surfaces.len());
        let mut points: Vec<(&Receiver, &Reflector)> = Vec::with_capacity(LANES);
        for record in records.records() {
            reached.clear();
            for (i, s) in surfaces.iter().enumerate() {
                let w = quality.weight.of(record, s.at.position, s.hemisphere);
                if w > 0.0 && s.finish.reads(record.zone().material) {
                    reached.push((i, w));
                }
            }
            for block in reached.chunks(LANES) {
                points.clear();
                points.extend(block.iter().map(|&(i, _)| (&surfaces[i].at, &reflectors[i])));
                reflect_together(record, &points, &lobe.albedo, scratches, |lane, part| {
                    let (i, w) = block[lane];
                    sums[i].add(record, &part, w, lobe);
                });
            }
        }
        sums.iter().zip(surfaces).map(|(sum, s)| sum.found(held, s.parts)).collect()
    }
}

/// Sums over the records about a point.
pub(in crate::integrator::cached) struct Sum {
    /// Direction that the lobe is about, world space.
    mirror: Vec3A,
    /// `trust` is the weight of the specular sum.
    reflected: Reflected,
    weights: f32,
    /// Weight of the records that are fine enough for this view, and whether there are others.
    seen: f32,
    others: bool,
}

impl Sum {
    /// Nothing yet.
    #[inline(always)]
    fn about(surface: &Shaded) -> Self {
        let at = &surface.at;
        let mirror = at.frame.to_world(Vec3A::new(-at.wo.x, -at.wo.y, at.wo.z));
        Self { mirror, reflected: Reflected::default(), weights: 0.0, seen: 0.0, others: false }
    }

    /// As another has summed it: irradiance with its weight, the specular part with its own, that of the records made for such a
    /// view, and whether there are others.
    #[cfg(feature = "gpu")]
    pub(in crate::integrator::cached) fn of(
        (irradiance, weights): (Rgb, f32),
        (specular, trust): (Rgb, f32),
        seen: f32,
        others: bool,
    ) -> Self {
        Self { mirror: Vec3A::ZERO, reflected: Reflected { irradiance, specular, trust }, weights, seen, others }
    }

    /// Adds what a record of weight w reflects.
    #[inline(always)]
    fn add(&mut self, record: &EasRecord, part: &Reflected, w: f32, lobe: &Lobe) {
        let view = w * record.views.trust(self.mirror, lobe.width);
        self.reflected.irradiance += part.irradiance * w;
        self.reflected.specular += part.specular * (view * part.trust);
        self.reflected.trust += view * part.trust;
        self.weights += w;
        self.seen += view;
        self.others |= !record.views.is_all();
    }

    /// What the records say together.
    #[inline(always)]
    pub(in crate::integrator::cached) fn found(&self, held: Held, parts: &Parts) -> Found {
        let Self { reflected: sum, weights, seen, others, .. } = self;
        let doubt = ((1.0 - sum.trust / seen) - DOUBT) / (1.0 - DOUBT);
        // Where all were made for other views, little is known.
        let unseen = if *others { 1.0 - seen / SEEN } else { 0.0 };
        let doubt = doubt.max(unseen).max(0.0);
        let light = (*weights > FOUND).then(|| Split {
            diffuse: parts.diffuse * mean_radiance(sum.irradiance.max(Rgb::ZERO) / *weights),
            glossy: sum.specular.max(Rgb::ZERO) / sum.trust.max(f32::MIN_POSITIVE),
        });
        // Where nothing shines, the irradiance is all.
        let doubt = if parts.is_diffuse() { 0.0 } else { doubt };
        let traced = if parts.is_diffuse() { 0.0 } else { held.traced.max(doubt) };
        Found { light, traced, doubt }
    }
}

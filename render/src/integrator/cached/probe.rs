//! One record under the lens: made where a pixel looks, with everything that went into it.

use super::build::Builder;
use super::kind::GlossyKind;
use super::kinds::eas::Lobe;
use super::kinds::{Eas, Listed};
use super::points::Point;
use super::policy::Treatment;
use crate::bsdf::Parts;
use crate::cache::Cache;
use crate::frame::Frame;
use crate::hemisphere::GatherSample;
use crate::record::Reflector;
use crate::record::eas::EasRecord;
use thiserror::Error;

/// Why there is nothing to inspect at a pixel.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum ProbeError {
    /// Outside the film or its crop.
    #[error("pixel {0},{1} is outside the film: x from {2} to {3}, y from {4} to {5}")]
    Outside(u32, u32, u32, u32, u32, u32),
    /// No surface.
    #[error("pixel {0},{1} shows no surface")]
    Nothing(u32, u32),
    /// A surface of a material without table.
    #[error("pixel {0},{1} shows {2}, which has no EAS records ({3}); choose a pixel on a glossy surface")]
    NoTable(u32, u32, String, &'static str),
    /// Paths too short for any light in records.
    #[error("records hold no light with max_depth = {0}; render with more")]
    NoLight(u32),
}

/// What a pixel shows, gathered twice: as the 2015 paper does, and guided by the views.
#[derive(Clone, Debug)]
pub struct Probe<'a> {
    /// The surface.
    pub point: Point,
    /// Frame of the record.
    pub frame: Frame,
    /// Table of the material.
    pub lobe: &'a Lobe,
    /// Colours, as the pixel's view sees them.
    pub parts: Parts,
    /// Stratified samples, uniform in solid angle.
    pub uniform: Vec<GatherSample>,
    /// The record of a rendering of this quality.
    pub guided: EasRecord,
    /// The samples it was made of.
    pub guided_samples: Vec<GatherSample>,
    /// Rays traced for both records.
    pub rays: u64,
}

impl Probe<'_> {
    /// Table and colours.
    pub fn reflector(&self) -> Reflector<'_> {
        Reflector::of(&self.lobe.table, &self.parts)
    }
}

impl Builder<'_> {
    /// Makes records at the very point that the middle of `pixel` (of the whole film) shows: what any fill would make there,
    /// secondary hits answered by the same coarse irradiance cache. `count` samples are gathered uniformly.
    ///
    /// # Errors
    /// A pixel without a surface that EAS records can hold.
    pub fn probe(
        &self,
        (x, y): (u32, u32),
        count: u32,
        progress: &(dyn Fn(f64) + Sync),
    ) -> Result<Probe<'_>, ProbeError> {
        let scene = &self.world.scene;
        let window = scene.camera.film.window();
        let (right, bottom) = (window.x + window.width - 1, window.y + window.height - 1);
        if !(window.x..=right).contains(&x) || !(window.y..=bottom).contains(&y) {
            return Err(ProbeError::Outside(x, y, window.x, right, window.y, bottom));
        }
        let i = ((y - window.y) * window.width + x - window.x) as usize;
        let point = self.sight.at(i).ok_or(ProbeError::Nothing(x, y))?;
        let no_table = |reason| {
            let name = scene.material_names.get(point.material.0 as usize).filter(|n| !n.is_empty());
            let name = name.map_or_else(|| format!("material {}", point.material.0), |n| format!("material `{n}`"));
            ProbeError::NoTable(x, y, name, reason)
        };
        let eas = &self.policy.kinds.eas;
        let held = match self.policy.maker(point.finish) {
            Treatment::Glossy(glossy) => {
                Eas::held(glossy).ok_or_else(|| no_table("the policy holds it with records of another kind"))?
            }
            Treatment::Irradiance => return Err(no_table("it is diffuse: an irradiance record serves it")),
            Treatment::Traced => return Err(no_table("it is path traced")),
        };
        if !self.holds_light() {
            return Err(ProbeError::NoLight(scene.integrator.max_depth));
        }
        let (min, max) = self.world.bounds();
        let mut coarse = Cache::new(min, max);
        self.fill_coarse(&mut coarse, &mut self.courses().coarse, None, progress);
        let tracer = self.record_tracer(&coarse);
        let site = self.site(&tracer, point, i);
        let (lobe, frame) = (&eas.lobes[held.lobe], site.frame());
        let no_lobe = || no_table("its model has no separate lobe");
        let parts = site.parts().ok_or_else(no_lobe)?;
        let mut gather = site.gather(Eas::SALT);
        let uniform = gather.uniform(&frame, count);
        let (guided, guided_samples, counts) = eas.record(held, &site).ok_or_else(no_lobe)?;
        let rays = counts.rays + gather.counts.rays;
        Ok(Probe { point: *point, frame, lobe, parts, uniform, guided, guided_samples, rays })
    }
}

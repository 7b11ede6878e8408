//! Rendering with caches: direct light per pixel, indirect light from records.

mod budget;
mod build;
mod caches;
#[cfg(feature = "gpu")]
pub mod card;
mod components;
mod diffuse;
mod drawn;
pub mod file;
mod grades;
mod gradual;
mod incident;
mod indirect;
mod interpolation;
mod irradiance;
mod kind;
pub mod kinds;
mod materials;
mod pace;
mod passes;
mod points;
pub mod policy;
mod probe;
mod progressive;
mod reading;
mod rendering;
mod report;
mod settings;
mod shade;
mod site;
mod sparse;
mod splat;
mod split;
mod surface;
mod tiles;
mod views;

use crate::cache::Spacing;
use crate::picture::{Budget, Picture};
use crate::record::CutSettings;
use crate::record::eas::Estimator;
use crate::world::World;
pub(crate) use budget::{COST_EXPONENT, FIRST_TOLERANCE, SMALLEST_TOLERANCE};
use budget::{FILL_SHARE, Filled, Search};
pub use build::Builder;
pub use caches::Caches;
use file::Loaded;
pub use gradual::GradualFill;
pub use incident::IncidentTracer;
pub use interpolation::Interpolation;
pub use kind::{Asked, Found, GlossyKind, KindFigures, Shaded};
pub use kinds::{Description, EachKind, Listed, WithKind};
pub use passes::kept_pixels;
pub use points::{PixelCone, Point};
use policy::Policy;
pub use probe::{Probe, ProbeError};
pub use progressive::{Halt, Scenery, Sums};
pub use reading::Reading;
pub use rendering::Rendering;
pub use report::{Figures, Shading};
pub use settings::{Knobs, Quality, TOLERANCE};
pub use site::{Gather, Site};
pub use split::LightSplit;
use std::time::Instant;

/// What to render with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// τ; `None`: [`TOLERANCE`], or what the time allows.
    pub tolerance: Option<f32>,
    /// How sources are moved and summed.
    pub estimator: Estimator,
    /// How far records reach.
    pub spacing: Spacing,
    /// Sources of every EAS record, 7 + 3k as a tree has them; `None`: as few as τ allows.
    pub sources: Option<usize>,
    /// Samples per pixel, or seconds.
    pub budget: Budget,
    /// Seed of all sample points.
    pub seed: u64,
    /// Whether light that is scattered less than twice is left out.
    pub indirect_only: bool,
    /// Who sums the records of a pixel.
    pub interpolation: Interpolation,
}

impl Settings {
    /// What follows from them at a τ.
    fn quality(&self, knobs: &Knobs, tolerance: f32) -> Quality {
        let mut quality = Quality::with(knobs, tolerance, self.estimator, self.spacing);
        if let Some(max_eas) = self.sources {
            quality.cut = CutSettings { tolerance: 0.0, max_eas };
        }
        quality
    }
}

/// Fills caches for the camera of a world and renders with them. `progress` is told the share of the work done.
///
/// `kept` are caches of an earlier run: complete ones are used as they are, others get what the camera needs besides.
pub fn render_cached(
    world: &World,
    policy: &Policy,
    settings: &Settings,
    kept: Option<Loaded>,
    progress: &(dyn Fn(f64) + Sync),
) -> (Picture, Figures, Caches) {
    render_with(world, policy, settings, &Knobs::default(), kept, progress)
}

/// [`render_cached`] with other numbers behind its quality, to see what each costs and buys.
pub fn render_with(
    world: &World,
    policy: &Policy,
    settings: &Settings,
    knobs: &Knobs,
    kept: Option<Loaded>,
    progress: &(dyn Fn(f64) + Sync),
) -> (Picture, Figures, Caches) {
    let start = Instant::now();
    let rendering = Rendering::with(world, policy, settings, knobs);
    let filling = |x: f64| progress(FILL_SHARE * x);
    let search = Search { world, rendering: &rendering, start, progress: &filling };
    let Filled { tolerance, caches } = search.run(kept);
    let filled = Instant::now();
    let shading = |x: f64| progress(FILL_SHARE + (1.0 - FILL_SHARE) * x);
    let (picture, Shading { negative_pixels, indirect, card_failed }) =
        rendering.shade(world, tolerance, &caches, (settings.budget, settings.seed), start, &shading);
    let times = Figures { fill: filled - start, shade: filled.elapsed(), ..Figures::of(&caches, tolerance) };
    (picture, Figures { negative_pixels, indirect, card_failed, ..times }, caches)
}

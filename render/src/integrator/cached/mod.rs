//! Rendering with caches: direct light per pixel, indirect light from records.

mod build;
mod caches;
mod direct;
pub mod file;
mod harmonics;
mod incident;
mod pace;
mod points;
pub mod policy;
mod probe;
mod settings;
mod shade;
mod spacing;
mod surface;
mod views;

use crate::cache::Spacing;
use crate::camera::RayGenerator;
use crate::picture::{Budget, Picture, Pixel, summable};
use crate::record::eas::Estimator;
use crate::record::harmonics::HarmonicsRecord;
use crate::record::{CutSettings, Scratch};
use crate::sampler::Sampler;
use crate::scene::Rgb;
use crate::simd::widest;
use crate::world::{Counts, Queries, World};
pub use build::Builder;
pub use caches::Caches;
use fearless_simd::Level;
use file::Loaded;
pub use incident::IncidentTracer;
use pace::{PASS, Pace, TRIAL_ROWS};
pub use points::{PixelCone, Point};
use policy::Policy;
pub use probe::{Probe, ProbeError};
use rayon::prelude::*;
pub use settings::{Quality, TOLERANCE};
pub use shade::LightSplit;
use shade::Shader;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};
use surface::{Grouping, Surface};

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
}

impl Settings {
    /// What follows from them at a τ.
    fn quality(&self, tolerance: f32) -> Quality {
        let mut quality = Quality::new(tolerance, self.estimator, self.spacing);
        if let Some(max_eas) = self.sources {
            quality.cut = CutSettings { tolerance: 0.0, max_eas };
        }
        quality
    }
}

/// What a cached rendering did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Figures {
    /// Time to fill the caches.
    pub fill: Duration,
    /// Time from there to the picture.
    pub shade: Duration,
    /// EAS records.
    pub eas_records: usize,
    /// Irradiance records, coarse ones included.
    pub irradiance_records: usize,
    /// Sources of all EAS records.
    pub sources: usize,
    /// Bytes of the EAS records.
    pub eas_bytes: usize,
    /// Records of incident radiance as harmonics.
    pub harmonics_records: usize,
    /// Bands of all harmonic records.
    pub bands: usize,
    /// Bytes of the harmonic records.
    pub harmonics_bytes: usize,
    /// Pixels whose indirect light is negative in some channel: ringing.
    pub negative_pixels: u64,
    /// Bytes of all records.
    pub bytes: usize,
    /// τ in force.
    pub tolerance: f32,
}

/// Share of a time budget that filling may use.
const FILL_SHARE: f64 = 0.5;

/// τ of the first fill, from whose time that of a second is guessed. A coarser one is hardly cheaper (τ = 0.2 takes 0.6 to 0.9 of
/// the time, for a bias of 1 %).
const FIRST_TOLERANCE: f32 = 0.1;

/// Below that τ the time of a fill grows with τ^−1.1 (measured on the glossy box, the material preview, the dragon and the
/// staircase).
const COST_EXPONENT: f64 = 1.1;

/// Share of the time left that the second fill is planned for: the guess is rough.
const FILL_MARGIN: f64 = 0.8;

/// A second fill must bring τ below this share of the first one's.
const WORTH_A_SECOND_FILL: f32 = 0.7;

/// No budget of time asks for less.
const SMALLEST_TOLERANCE: f32 = 0.002;

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
    let start = Instant::now();
    let split = LightSplit::new(world, settings.indirect_only);
    let (kept, complete) = kept.map_or((None, false), |k| (Some(k.caches), k.complete));
    let build = |tolerance: f32, deadline: Option<Instant>, progress: &(dyn Fn(f64) + Sync)| {
        let quality = settings.quality(tolerance);
        (
            quality,
            Builder::new(world, policy, split.held.as_ref(), quality, settings.seed).build(
                kept.clone(),
                deadline,
                progress,
            ),
        )
    };
    let time = match settings.budget {
        Budget::Time(limit) => Some(limit),
        _ => None,
    };
    let deadline = time.map(|limit| start + limit.mul_f64(FILL_SHARE));
    let report = |x: f64| progress(FILL_SHARE * x);
    let whole = kept.clone().filter(|_| complete);
    let (tolerance, (quality, caches)) = match (settings.tolerance, deadline, whole) {
        (tolerance, _, Some(caches)) => {
            let tolerance = tolerance.unwrap_or(TOLERANCE);
            (tolerance, (settings.quality(tolerance), caches))
        }
        (Some(tolerance), ..) => (tolerance, build(tolerance, deadline, &report)),
        (None, None, None) => (TOLERANCE, build(TOLERANCE, None, &report)),
        (None, Some(end), None) => {
            let first = Instant::now();
            let filled = build(FIRST_TOLERANCE, Some(end), &report);
            let spent = first.elapsed().as_secs_f64();
            let left = end.saturating_duration_since(Instant::now()).as_secs_f64();
            let share = (spent / (FILL_MARGIN * left).max(1e-6)).powf(1.0 / COST_EXPONENT) as f32;
            if share < WORTH_A_SECOND_FILL {
                let tolerance = (FIRST_TOLERANCE * share).max(SMALLEST_TOLERANCE);
                (tolerance, build(tolerance, Some(end), &report))
            } else {
                (FIRST_TOLERANCE, filled)
            }
        }
    };
    let filled = Instant::now();
    let shader = Shader {
        world,
        policy,
        caches: &caches,
        split: &split,
        quality,
        indirect_only: settings.indirect_only,
        cone: PixelCone::new(world),
        grouping: Grouping::new(world.scene.camera.lens.is_some()),
    };
    let (picture, negative_pixels) =
        shade(&shader, settings, start, &|x| progress(FILL_SHARE + (1.0 - FILL_SHARE) * x));
    let figures = Figures {
        fill: filled - start,
        shade: filled.elapsed(),
        eas_records: caches.eas.records().len(),
        irradiance_records: caches.irradiance.records().len() + caches.coarse.records().len(),
        sources: caches.eas.records().iter().map(|r| r.sources.len()).sum(),
        eas_bytes: caches.eas.bytes(),
        harmonics_records: caches.harmonics.records().len(),
        bands: caches.harmonics.records().iter().map(HarmonicsRecord::order).sum(),
        harmonics_bytes: caches.harmonics.bytes(),
        negative_pixels,
        bytes: caches.bytes(),
        tolerance,
    };
    (picture, figures, caches)
}

/// Calls `f` with the film coordinates of every pixel of a row that begins at `start`, the pixel, and its surfaces, compiled
/// for the widest vectors of the machine.
#[inline(always)]
fn each_pixel<T>(
    start: (u32, u32),
    row: &mut [Pixel],
    surfaces: impl IntoIterator<Item = T>,
    mut f: impl FnMut((u32, u32), &mut Pixel, T),
) {
    widest(
        Level::new(),
        #[inline(always)]
        || {
            for (x, (pixel, surfaces)) in row.iter_mut().zip(surfaces).enumerate() {
                f((start.0 + x as u32, start.1), pixel, surfaces);
            }
        },
    );
}

/// The final pass: reads the caches only. Returns the number of pixels of negative indirect light too.
fn shade(shader: &Shader, settings: &Settings, start: Instant, progress: &(dyn Fn(f64) + Sync)) -> (Picture, u64) {
    let world = shader.world;
    let camera = RayGenerator::new(&world.scene.camera);
    let window = world.scene.camera.film.window();
    let count = window.width as usize * window.height as usize;
    let mut pixels = vec![Pixel::default(); count];
    let mut surfaces: Vec<Vec<Surface>> = vec![Vec::new(); count];
    let (mut spp, mut counts) = (0, shader.caches.counts);
    let width = window.width as usize;
    // Indirect light of a row: what was traced, and pixels where it is negative.
    let indirect_row = |y: usize, row: &mut [Pixel], surfaces: &[Vec<Surface>], scratch: &mut Scratch| {
        let (mut queries, mut negative) = (Queries::default(), 0);
        each_pixel(
            (window.x, window.y + y as u32),
            row,
            surfaces,
            #[inline(always)]
            |at, pixel, surfaces| {
                let samplers = |path: u32| Sampler::new(settings.seed.wrapping_add(1), at, path);
                let indirect = shader.indirect(surfaces, &samplers, scratch, &mut queries);
                if summable(indirect.sum()) {
                    pixel.sum.indirect = pixel.sum.indirect + indirect;
                    // Records may ring; a pixel never shines less than not at all.
                    let all = pixel.sum.indirect;
                    if indirect.diffuse.min(indirect.glossy).min(all.diffuse).min(all.glossy).min_element() < 0.0 {
                        negative += 1;
                        pixel.sum.indirect.glossy -= pixel.sum.sum().min(Rgb::ZERO);
                    }
                } else {
                    queries.counts.not_finite += surfaces.iter().map(Surface::samples).sum::<u64>();
                }
            },
        );
        (queries.counts, negative)
    };
    let mut pace = match settings.budget {
        Budget::Time(limit) => Some(Pace::new(start + limit)),
        _ => None,
    };
    // Direct light in passes, until the samples or the time left for them are used up.
    loop {
        let pass = match (settings.budget, &pace) {
            (Budget::Samples(n), _) => PASS.min(n.saturating_sub(spp)),
            (_, Some(pace)) => pace.next(),
            _ => 0,
        };
        if pass == 0 {
            break;
        }
        let passing = Instant::now();
        let traced: Counts = pixels
            .par_chunks_mut(width)
            .zip(surfaces.par_chunks_mut(width))
            .enumerate()
            .map_init(Scratch::default, |scratch, (y, (row, surfaces))| {
                let mut queries = Queries::default();
                each_pixel(
                    (window.x, window.y + y as u32),
                    row,
                    surfaces,
                    #[inline(always)]
                    |at, pixel, surfaces| {
                        for index in spp..spp + pass {
                            let mut sampler = Sampler::new(settings.seed, at, index);
                            let ray = camera.sample(at.0, at.1, &mut sampler);
                            queries.counts.paths += 1;
                            let mut sample = shader.direct(ray, &mut sampler, surfaces, scratch, &mut queries);
                            sample = sample.finite(&mut queries);
                            if sample.distance > 0.0 {
                                sample.distance = camera.depth(ray.origin + ray.direction * sample.distance);
                                pixel.surfaces += 1;
                            }
                            pixel.sum += sample;
                        }
                    },
                );
                queries.counts
            })
            .sum();
        counts += traced;
        spp += pass;
        if let Some(pace) = &mut pace {
            let (direct, trial) = (passing.elapsed(), Instant::now());
            let rows: Vec<_> = (TRIAL_ROWS / 2..window.height as usize).step_by(TRIAL_ROWS).collect();
            rows.par_iter().for_each_init(Scratch::default, |scratch, &y| {
                let row = y * width..(y + 1) * width;
                indirect_row(y, &mut pixels[row.clone()].to_vec(), &surfaces[row], scratch);
            });
            pace.note(pass, direct, trial.elapsed());
        }
        if let Budget::Samples(n) = settings.budget {
            progress(0.7 * f64::from(spp) / f64::from(n));
        }
    }
    // Indirect light once per surface in a pixel.
    let rows = AtomicU64::new(0);
    let (traced, negative) = pixels
        .par_chunks_mut(width)
        .zip(surfaces.par_chunks(width))
        .enumerate()
        .map_init(Scratch::default, |scratch, (y, (row, surfaces))| {
            let found = indirect_row(y, row, surfaces, scratch);
            let done = rows.fetch_add(1, Ordering::Relaxed) + 1;
            progress(0.7 + 0.3 * done as f64 / f64::from(window.height));
            found
        })
        .reduce(Default::default, |a, b| ([a.0, b.0].into_iter().sum(), a.1 + b.1));
    counts += traced;
    let picture = Picture {
        width: window.width,
        height: window.height,
        corner: [window.x, window.y],
        pixels,
        spp,
        passes: 0,
        counts,
    };
    (picture, negative)
}

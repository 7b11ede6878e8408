//! The final pass over pixels, which reads the caches only: direct light in passes, until the samples or the time left for
//! them are used up, then indirect light once per surface in a pixel.

use super::Settings;
#[cfg(feature = "gpu")]
use super::card::Card;
use super::kind::Found;
use super::kinds::Scratches;
use super::pace::{PASS, Pace, TRIAL_ROWS};
use super::progressive::{Halt, Sums};
use super::reading::Reading;
use super::report::Shading;
use super::shade::Shader;
use super::sparse;
use super::splat::{SIDE, Splats};
use super::surface::Surface;
use super::tiles::{Memory, Reader};
use crate::camera::RayGenerator;
use crate::picture::{Budget, Picture, Pixel, first_half};
use crate::sampler::Sampler;
use crate::scene::{Camera, Crop};
use crate::simd::widest;
use crate::world::{Counts, Queries};
use fearless_simd::Level;
use rayon::prelude::*;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Instant;

/// Share of the progress that direct light takes.
const DIRECT_SHARE: f64 = 0.7;

/// Pixels whose surfaces are kept at once, about, where the number of samples is known: with half a kilobyte a pixel they would take
/// four times as much memory as the film.
pub(super) const STRIP: usize = 1 << 20;

/// Pixels of a part of a film whose surfaces are kept at once: where the number of samples is known, whole rows of it.
pub fn kept_pixels(window: Crop, samples_are_known: bool) -> u64 {
    let rows = if samples_are_known { strip_rows(window.width, STRIP).min(window.height) } else { window.height };
    u64::from(rows) * u64::from(window.width)
}

/// Rows of a strip of about so many pixels, which is whole tiles.
fn strip_rows(width: u32, pixels: usize) -> u32 {
    (pixels / width.max(1) as usize).next_multiple_of(SIDE).max(SIDE) as u32
}

/// A picture in the making.
pub(super) struct Passes<'a> {
    shader: &'a Shader<'a>,
    settings: &'a Settings,
    camera: RayGenerator,
    window: Crop,
    /// Whether its rays come from a lens.
    lens: bool,
    sums: Sums,
    /// The records on the film, where they are drawn onto it; made when light is first read.
    splats: OnceLock<Option<Splats>>,
    /// The records on the graphics card, where it sums them; `None` if it failed.
    #[cfg(feature = "gpu")]
    card: OnceLock<Option<Card<'a>>>,
    /// Whether the card was to sum and did not.
    card_failed: AtomicBool,
    /// Asks it to leave off: what it sums is then of no use.
    halt: Option<&'a Halt>,
}

impl<'a> Passes<'a> {
    /// A picture of the camera of the world, whose sums take no memory before it is run.
    pub fn new(shader: &'a Shader<'a>, settings: &'a Settings) -> Self {
        Self::with(shader, settings, &shader.world.scene.camera, Sums::default(), None)
    }

    /// One that goes on with sums of the camera that the shader has, until it is asked to leave off.
    pub fn with(
        shader: &'a Shader<'a>,
        settings: &'a Settings,
        camera: &Camera,
        sums: Sums,
        halt: Option<&'a Halt>,
    ) -> Self {
        let (generator, window, lens) = (RayGenerator::new(camera), camera.film.window(), camera.lens.is_some());
        Self {
            shader,
            settings,
            camera: generator,
            window,
            lens,
            sums,
            splats: OnceLock::new(),
            #[cfg(feature = "gpu")]
            card: OnceLock::new(),
            card_failed: AtomicBool::new(false),
            halt,
        }
    }

    /// What has been summed.
    pub fn into_sums(self) -> Sums {
        let card_failed = self.sums.card_failed || self.card_failed.load(Ordering::Relaxed);
        Sums { card_failed, ..self.sums }
    }

    fn is_halted(&self) -> bool {
        self.halt.is_some_and(Halt::is_set)
    }

    /// Renders within the budget, which began at `start`; where it is samples, strips of so many pixels.
    pub fn run(mut self, start: Instant, strip: usize, progress: &(dyn Fn(f64) + Sync)) -> (Picture, Shading) {
        if let Budget::Samples(n) = self.settings.budget {
            return self.strips(n, strip, progress);
        }
        self.sums.clear(self.window);
        // A cached picture does not know its error.
        if let Budget::Time(limit) = self.settings.budget {
            let mut pace = Pace::new(start + limit);
            loop {
                let pass = pace.next();
                if pass == 0 {
                    break;
                }
                let passing = Instant::now();
                self.direct(pass);
                let (direct, trial) = (passing.elapsed(), Instant::now());
                self.try_indirect();
                pace.note(pass, direct, trial.elapsed());
            }
        }
        let reading = Instant::now();
        let negative_pixels = self.indirect(&|x| progress(DIRECT_SHARE + (1.0 - DIRECT_SHARE) * x));
        let card_failed = self.card_failed.load(Ordering::Relaxed);
        let Self { window, shader, sums: Sums { pixels, spp, counts, .. }, .. } = self;
        let counts = [shader.caches.counts, counts].into_iter().sum();
        let picture = Picture::of(window, pixels, spp, counts, true);
        (picture, Shading { negative_pixels, indirect: reading.elapsed(), card_failed })
    }

    /// Renders so many samples, strip by strip from the top.
    fn strips(mut self, samples: u32, strip: usize, progress: &(dyn Fn(f64) + Sync)) -> (Picture, Shading) {
        let window = self.window;
        let (rows, height) = (strip_rows(window.width, strip), f64::from(window.height));
        let mut pixels = Vec::with_capacity(window.width as usize * window.height as usize);
        let (mut counts, mut shading) = (self.shader.caches.counts, Shading::default());
        for top in (0..window.height).step_by(rows as usize) {
            let strip = Crop { y: window.y + top, height: rows.min(window.height - top), ..window };
            let progress = |x: f64| progress((f64::from(top) + x * f64::from(strip.height)) / height);
            self.window = strip;
            self.sums.clear(strip);
            while self.sums.spp < samples {
                self.direct(PASS.min(samples - self.sums.spp));
                progress(DIRECT_SHARE * f64::from(self.sums.spp) / f64::from(samples));
            }
            let reading = Instant::now();
            shading.negative_pixels += self.indirect(&|x| progress(DIRECT_SHARE + (1.0 - DIRECT_SHARE) * x));
            shading.indirect += reading.elapsed();
            pixels.append(&mut self.sums.pixels);
            counts += self.sums.counts;
        }
        shading.card_failed = self.card_failed.load(Ordering::Relaxed);
        (Picture::of(window, pixels, samples, counts, true), shading)
    }

    /// Adds direct light of so many samples to every pixel, and notes the surfaces that they show.
    pub fn direct(&mut self, pass: u32) {
        let Self { shader, settings, ref camera, window, halt, .. } = *self;
        let Sums { pixels, surfaces, spp, counts, .. } = &mut self.sums;
        let (spp, sums) = (*spp, (spp, counts));
        let width = window.width as usize;
        let middle = spp + first_half(spp + pass) - first_half(spp);
        let traced: Counts = pixels
            .par_chunks_mut(width)
            .zip(surfaces.par_chunks_mut(width))
            .enumerate()
            .map_init(Scratches::default, |scratch, (y, (row, surfaces))| {
                let mut queries = Queries::default();
                if halt.is_some_and(Halt::is_set) {
                    return queries.counts;
                }
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
                            pixel.add(sample, index < middle);
                        }
                    },
                );
                queries.counts
            })
            .sum();
        *sums.0 += pass;
        *sums.1 += traced;
    }

    /// Shades a few rows and forgets them, to know what all of them will take.
    fn try_indirect(&self) {
        let width = self.window.width as usize;
        let rows: Vec<_> = (TRIAL_ROWS / 2..self.window.height as usize).step_by(TRIAL_ROWS).collect();
        let (reader, unread) = (self.reader(), vec![None; width]);
        rows.par_iter().for_each_init(Memory::default, |memory, &y| {
            let row = y * width..(y + 1) * width;
            let mut pixels = self.sums.pixels[row.clone()].to_vec();
            let surfaces = &self.sums.surfaces[row];
            let card = self.on_card(&reader, self.place(y), surfaces);
            reader.rows(self.place(y), width, &mut pixels, (surfaces, &unread, card.as_deref()), memory);
        });
    }

    /// Adds indirect light. Returns the number of pixels where it is negative.
    fn indirect(&mut self, progress: &(dyn Fn(f64) + Sync)) -> u64 {
        let mut pixels = core::mem::take(&mut self.sums.pixels);
        let (traced, negative) = self.add_indirect(&mut pixels, progress);
        self.sums.pixels = pixels;
        self.sums.counts += traced;
        negative
    }

    /// Adds the indirect light of what has been seen so far to a copy of the sums. Returns what was traced too.
    pub fn add_indirect(&self, pixels: &mut [Pixel], progress: &(dyn Fn(f64) + Sync)) -> (Counts, u64) {
        let rows = AtomicU64::new(0);
        let (shader, surfaces, width) = (self.shader, &self.sums.surfaces, self.window.width as usize);
        let known = match shader.reading {
            Reading::Every => vec![None; surfaces.len()],
            _ if self.settings.interpolation.is_on_card() => vec![None; surfaces.len()],
            Reading::Few | Reading::Rough => sparse::between(shader, surfaces, width),
        };
        let reader = self.reader();
        let card = self.on_card(&reader, self.place(0), surfaces);
        let tiles = width.div_ceil(SIDE);
        pixels
            .par_chunks_mut(SIDE * width)
            .zip(surfaces.par_chunks(SIDE * width).zip(known.par_chunks(SIDE * width)))
            .enumerate()
            .map_init(Memory::default, |memory, (band, (pixels, surfaces))| {
                if self.is_halted() {
                    return Default::default();
                }
                let card = card.as_ref().map(|card| &card[band * tiles..][..tiles]);
                let work = (surfaces.0, surfaces.1, card);
                let found = reader.rows(self.place(SIDE * band), width, pixels, work, memory);
                let here = (pixels.len() / width) as u64;
                let done = rows.fetch_add(here, Ordering::Relaxed) + here;
                progress(done as f64 / f64::from(self.window.height));
                found
            })
            .reduce(Default::default, |a, b| ([a.0, b.0].into_iter().sum(), a.1 + b.1))
    }

    fn reader(&self) -> Reader<'_> {
        let Self { shader, settings, camera, lens, splats, sums, .. } = self;
        let drawn = settings.interpolation.splats(shader.caches, shader.reading);
        let splats = splats.get_or_init(|| drawn.then(|| Splats::new(shader.caches, camera, *lens)));
        Reader { shader, splats: splats.as_ref(), seed: settings.seed, spp: sums.spp }
    }

    /// What the graphics card says of the surfaces of whole rows, by tile, where it is to sum the records and can.
    #[cfg(feature = "gpu")]
    fn on_card(&self, reader: &Reader, place: (u32, u32), surfaces: &[Vec<Surface>]) -> Option<Vec<Vec<Found>>> {
        let splats = reader.splats.filter(|_| self.settings.interpolation.is_on_card())?;
        let card = self.card.get_or_init(|| Card::new(self.shader).ok());
        let found = card.as_ref().and_then(|c| c.found(splats, place, self.window.width as usize, surfaces).ok());
        if found.is_none() {
            self.card_failed.store(true, Ordering::Relaxed);
        }
        found
    }

    /// The same without one.
    #[cfg(not(feature = "gpu"))]
    fn on_card(&self, _: &Reader, _: (u32, u32), _: &[Vec<Surface>]) -> Option<Vec<Vec<Found>>> {
        None
    }

    /// Film coordinates of the first pixel of a row.
    fn place(&self, y: usize) -> (u32, u32) {
        (self.window.x, self.window.y + y as u32)
    }
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

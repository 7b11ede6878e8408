//! The final pass over pixels, which reads the caches only: direct light in passes, until the samples or the time left for
//! them are used up, then indirect light once per surface in a pixel.

use super::Settings;
use super::kinds::Scratches;
use super::pace::{PASS, Pace, TRIAL_ROWS};
use super::report::Shading;
use super::shade::{Reading, Shader};
use super::sparse;
use super::splat::{SIDE, Splats};
use super::surface::Surface;
use super::tiles::{Memory, Reader};
use crate::camera::RayGenerator;
use crate::picture::{Budget, Picture, Pixel, first_half};
use crate::sampler::Sampler;
use crate::scene::Crop;
use crate::simd::widest;
use crate::world::{Counts, Queries};
use fearless_simd::Level;
use rayon::prelude::*;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

/// Share of the progress that direct light takes.
const DIRECT_SHARE: f64 = 0.7;

/// A picture in the making.
pub(super) struct Passes<'a> {
    shader: &'a Shader<'a>,
    settings: &'a Settings,
    camera: RayGenerator,
    window: Crop,
    pixels: Vec<Pixel>,
    /// Of each pixel.
    surfaces: Vec<Vec<Surface>>,
    /// The records on the film, where they are drawn onto it.
    splats: Option<Splats>,
    spp: u32,
    counts: Counts,
}

impl<'a> Passes<'a> {
    /// A black picture.
    pub fn new(shader: &'a Shader<'a>, settings: &'a Settings) -> Self {
        let camera = &shader.world.scene.camera;
        let window = camera.film.window();
        let count = window.width as usize * window.height as usize;
        let generator = RayGenerator::new(camera);
        let splats = settings
            .interpolation
            .splats(shader.caches, shader.reading)
            .then(|| Splats::new(shader.caches, &generator, camera.lens.is_some()));
        Self {
            shader,
            settings,
            camera: generator,
            window,
            pixels: vec![Pixel::default(); count],
            surfaces: vec![Vec::new(); count],
            splats,
            spp: 0,
            counts: shader.caches.counts,
        }
    }

    /// Renders within the budget, which began at `start`.
    pub fn run(mut self, start: Instant, progress: &(dyn Fn(f64) + Sync)) -> (Picture, Shading) {
        match self.settings.budget {
            Budget::Samples(n) => {
                while self.spp < n {
                    self.direct(PASS.min(n - self.spp));
                    progress(DIRECT_SHARE * f64::from(self.spp) / f64::from(n));
                }
            }
            Budget::Time(limit) => {
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
            // A cached picture does not know its error.
            Budget::Error(_) => (),
        }
        let reading = Instant::now();
        let negative_pixels = self.indirect(&|x| progress(DIRECT_SHARE + (1.0 - DIRECT_SHARE) * x));
        let Self { window, pixels, spp, counts, .. } = self;
        let corner = [window.x, window.y];
        let (width, height) = (window.width, window.height);
        (
            Picture { width, height, corner, pixels, spp, passes: 0, counts, from_records: true, denoised: None },
            Shading { negative_pixels, indirect: reading.elapsed() },
        )
    }

    /// Adds direct light of so many samples to every pixel, and notes the surfaces that they show.
    fn direct(&mut self, pass: u32) {
        let Self { shader, settings, ref camera, window, spp, .. } = *self;
        let width = window.width as usize;
        let middle = spp + first_half(spp + pass) - first_half(spp);
        let traced: Counts = self
            .pixels
            .par_chunks_mut(width)
            .zip(self.surfaces.par_chunks_mut(width))
            .enumerate()
            .map_init(Scratches::default, |scratch, (y, (row, surfaces))| {
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
                            pixel.add(sample, index < middle);
                        }
                    },
                );
                queries.counts
            })
            .sum();
        self.counts += traced;
        self.spp += pass;
    }

    /// Shades a few rows and forgets them, to know what all of them will take.
    fn try_indirect(&self) {
        let width = self.window.width as usize;
        let rows: Vec<_> = (TRIAL_ROWS / 2..self.window.height as usize).step_by(TRIAL_ROWS).collect();
        let (reader, unread) = (self.reader(), vec![None; width]);
        rows.par_iter().for_each_init(Memory::default, |memory, &y| {
            let row = y * width..(y + 1) * width;
            let mut pixels = self.pixels[row.clone()].to_vec();
            reader.rows(self.place(y), width, &mut pixels, (&self.surfaces[row], &unread), memory);
        });
    }

    /// Adds indirect light. Returns the number of pixels where it is negative.
    fn indirect(&mut self, progress: &(dyn Fn(f64) + Sync)) -> u64 {
        let rows = AtomicU64::new(0);
        let width = self.window.width as usize;
        let known = match self.shader.reading {
            Reading::Every => vec![None; self.surfaces.len()],
            Reading::Few => sparse::between(self.shader, &self.surfaces, width),
        };
        let mut pixels = core::mem::take(&mut self.pixels);
        let reader = self.reader();
        let (traced, negative) = pixels
            .par_chunks_mut(SIDE * width)
            .zip(self.surfaces.par_chunks(SIDE * width).zip(known.par_chunks(SIDE * width)))
            .enumerate()
            .map_init(Memory::default, |memory, (band, (pixels, surfaces))| {
                let found = reader.rows(self.place(SIDE * band), width, pixels, surfaces, memory);
                let here = (pixels.len() / width) as u64;
                let done = rows.fetch_add(here, Ordering::Relaxed) + here;
                progress(done as f64 / f64::from(self.window.height));
                found
            })
            .reduce(Default::default, |a, b| ([a.0, b.0].into_iter().sum(), a.1 + b.1));
        self.pixels = pixels;
        self.counts += traced;
        negative
    }

    fn reader(&self) -> Reader<'_> {
        let Self { shader, settings, splats, spp, .. } = self;
        Reader { shader, splats: splats.as_ref(), seed: settings.seed, spp: *spp }
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

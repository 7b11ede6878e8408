//! What `--stats` says of a run.

use render::denoise::Bounded;
use render::integrator::cached::Figures;
use render::integrator::cached::kinds::{COUNT, KINDS};
use render::picture::Picture;
use render::world::Counts;
use serde::{Serialize, Serializer};
use std::time::Duration;

/// What `--stats` says; the keys of the cache stay zero without one.
#[derive(Debug, Default, Serialize)]
pub(super) struct Stats {
    method: &'static str,
    pub(super) seconds: Seconds,
    rays: u64,
    not_finite: u64,
    records: u64,
    #[serde(flatten)]
    means: Means,
    negative_pixels: u64,
    denoiser: &'static str,
    fireflies: Fireflies,
    bytes_per_record: f64,
    cache_bytes: u64,
    spp: u32,
    threads: usize,
    chosen: Chosen,
}

/// What was chosen for the picture by `auto` or by a budget of time.
#[derive(Debug, Serialize)]
struct Chosen {
    /// `path` or `records`.
    method: &'static str,
    /// τ of the records.
    tau: Option<f32>,
    /// Samples per pixel of direct light; without records, of all light.
    samples: u32,
    /// What was done with each glossy material, in words.
    materials: Vec<String>,
}

impl Default for Chosen {
    /// Path tracing.
    fn default() -> Self {
        Self { method: "path", tau: None, samples: 0, materials: Vec::new() }
    }
}

#[derive(Debug, Default, Serialize)]
pub(super) struct Seconds {
    load: f64,
    fit: f64,
    fill: f64,
    pub(super) shade: f64,
    /// The part of `shade` for the indirect light of surfaces.
    indirect: f64,
    denoise: f64,
    pub(super) write: f64,
    pub(super) total: f64,
}

/// Light that the denoiser was not shown: pixels, and share of the light that surfaces scatter.
#[derive(Debug, Default, Serialize)]
struct Fireflies {
    pixels: u64,
    share: f64,
}

/// Mean number of elements of a record, with a key for each kind.
#[derive(Debug, Default)]
struct Means([f64; COUNT]);

impl Serialize for Means {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        to.collect_map(KINDS.iter().map(|kind| kind.mean_key).zip(self.0))
    }
}

impl Stats {
    /// Of a method whose scene has been loaded.
    pub fn new(method: &'static str, threads: usize, load: Duration) -> Self {
        let seconds = Seconds { load: load.as_secs_f64(), ..Seconds::default() };
        Self { method, threads, seconds, denoiser: "off", ..Self::default() }
    }

    /// Notes what caches did.
    pub fn take(&mut self, figures: &Figures, fitting: Duration, materials: &[String]) {
        (self.chosen.method, self.chosen.tau) = ("records", Some(figures.tolerance));
        self.chosen.materials = materials.to_vec();
        self.seconds.fit = fitting.as_secs_f64();
        self.seconds.fill = figures.fill.as_secs_f64();
        self.seconds.shade = figures.shade.as_secs_f64();
        self.seconds.indirect = figures.indirect.as_secs_f64();
        self.records = figures.records() as u64;
        for (mean, kind) in self.means.0.iter_mut().zip(figures.glossy.iter()) {
            *mean = kind.mean();
        }
        self.negative_pixels = figures.negative_pixels;
        self.bytes_per_record = figures.all_glossy().mean_bytes();
        self.cache_bytes = figures.bytes as u64;
    }

    /// Notes what a denoiser did.
    pub fn denoised(&mut self, name: &'static str, seconds: f64, bounded: Bounded) {
        self.denoiser = name;
        self.seconds.denoise = seconds;
        self.fireflies = Fireflies { pixels: bounded.pixels, share: bounded.share };
    }

    /// Notes what was traced.
    pub fn count(&mut self, picture: &Picture) {
        let Counts { rays, not_finite, .. } = picture.counts;
        (self.rays, self.not_finite, self.spp) = (rays, not_finite, picture.spp);
        self.chosen.samples = picture.spp;
    }
}

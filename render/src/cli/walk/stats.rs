//! What `--stats` says of a walk.

use render::integrator::cached::Caches;
use render::picture::Picture;
use serde::Serialize;
use std::time::Duration;

/// What `--stats` says of a walk; the keys of the cache stay zero without one.
#[derive(Debug, Default, Serialize)]
pub(super) struct Stats {
    method: &'static str,
    pub seconds: Seconds,
    /// Frames of the path.
    pub path_frames: u32,
    /// Frames that were drawn, and that were there already.
    frames: u32,
    pub skipped: u32,
    pub rays: u64,
    not_finite: u64,
    denoiser: &'static str,
    pub records: usize,
    cache_bytes: usize,
    tau: f32,
    spp: u32,
    threads: usize,
}

/// Over all frames.
#[derive(Debug, Default, Serialize)]
pub(super) struct Seconds {
    load: f64,
    pub fit: f64,
    pub fill: f64,
    pub shade: f64,
    denoise: f64,
    pub write: f64,
    pub total: f64,
}

impl Stats {
    /// Of a scene that has been loaded.
    pub fn new(method: &'static str, threads: usize, load: Duration) -> Self {
        let seconds = Seconds { load: load.as_secs_f64(), ..Seconds::default() };
        Self { method, threads, seconds, denoiser: "off", ..Self::default() }
    }

    /// Notes what was filled.
    pub fn take(&mut self, caches: &Caches, tolerance: f32) {
        (self.records, self.cache_bytes, self.tau) = (caches.records(), caches.bytes(), tolerance);
    }

    /// Notes a frame.
    pub fn count(&mut self, picture: &Picture) {
        self.frames += 1;
        self.spp = picture.spp;
        self.rays += picture.counts.rays;
        self.not_finite += picture.counts.not_finite;
    }

    /// Notes what a denoiser did.
    pub fn denoised(&mut self, name: &'static str, time: Duration) {
        self.denoiser = name;
        self.seconds.denoise += time.as_secs_f64();
    }

    /// In words.
    pub fn sentence(&self) -> String {
        let Self { frames, skipped, spp, seconds, .. } = self;
        let Seconds { load, fit, fill, shade, denoise, write, .. } = seconds;
        let skipped = if *skipped > 0 { format!(", {skipped} were there") } else { String::new() };
        if *frames == 0 {
            return format!("0 frames{skipped}");
        }
        let mean = (fill + shade + denoise + write) / f64::from(*frames);
        let denoised = if *denoise > 0.0 { format!(", {denoise:.1} s to denoise") } else { String::new() };
        format!(
            "{frames} frames at {spp} samples per pixel{skipped}; {mean:.2} s a frame with its share of the fill ({load:.1} s to load, \
             {fit:.1} s to fit, {fill:.1} s to fill, {shade:.1} s to draw{denoised}, {write:.1} s to write)"
        )
    }
}

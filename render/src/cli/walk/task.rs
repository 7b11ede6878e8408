//! The work of a walk: filling, drawing, telling.

use super::Args;
use super::cache::Kept;
use super::files::{self, Files};
use super::meter::Meter;
use super::stats::Stats;
use crate::cli::caching::decide;
use crate::cli::image::not_finite_warning;
use crate::cli::job::{Caching, writing_seconds};
use crate::cli::method::Method;
use crate::cli::options;
use anyhow::{Context, Result, bail, ensure};
use kit::output::write;
use render::denoise::{Denoiser, Effort, Plan};
use render::image::{Look, write_picture};
use render::integrator::cached::file::{self, Chosen, Key};
use render::integrator::cached::{Caches, Reading, Rendering};
use render::picture::Budget;
use render::scene::checksum::Checksums;
use render::walk::{self, Source, Trial, Walk, choose_samples};
use render::world::World;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::{Duration, Instant};

/// Share of `--time-per-frame` for filling the caches, as it is planned; and at most, where even a coarse fill takes longer. What is not
/// filled is path traced in every frame, which takes more time than filling it.
const FILL_SHARE: f64 = 0.12;
const LONGEST_FILL: f64 = 0.6;

/// A walk, ready to be filled and drawn.
pub(super) struct Task<'a> {
    pub args: &'a Args,
    pub world: World,
    pub walk: Walk,
    pub files: Files,
    pub look: Look,
    pub denoiser: Option<Denoiser>,
    pub effort: Effort,
    pub seed: u64,
    pub indirect_only: bool,
    pub budget: Budget,
    pub start: Instant,
    pub stats: Stats,
}

impl Task<'_> {
    /// The frames that are asked for, all of the path.
    pub fn frames(&self) -> Result<Vec<u32>> {
        let range = self.walk.frames();
        let Some(frames) = &self.args.frames else { return Ok(range.collect()) };
        match frames.as_slice().iter().find(|frame| !range.contains(frame)) {
            Some(frame) => bail!(
                "--frames: frame {frame} is outside of the path {}, which has {} to {}",
                self.args.path.display(),
                range.start(),
                range.end()
            ),
            None => Ok(frames.as_slice().to_vec()),
        }
    }

    /// Frames of the path.
    fn count(&self) -> f64 {
        f64::from(self.walk.frames().end() - self.walk.frames().start() + 1)
    }

    /// How frames of so many seconds are denoised.
    fn denoising(&self, seconds: f64, from_records: bool) -> Result<Option<Plan>> {
        let Some(denoiser) = &self.denoiser else { return Ok(None) };
        let film = self.world.scene.camera.film.window();
        Ok(Some(denoiser.plan(u64::from(film.width) * u64::from(film.height), from_records, Some(seconds))?))
    }

    /// Chooses samples per pixel and how well to denoise, for frames of so many seconds each of which `spent` are gone for all.
    fn choose(&mut self, source: &Source, seconds: f64, spent: f64) -> Result<Chosen> {
        let plan = self.denoising(seconds, matches!(source, Source::Cached { .. }))?;
        let writing = writing_seconds(&self.args.image.output, &self.world.scene.camera.film);
        let fixed = writing + plan.map_or(0.0, |plan| plan.seconds);
        let count = self.count();
        let left = |trial: f64| seconds - (spent + trial) / count - fixed;
        let spp = choose_samples(&mut self.world, source, &self.walk, plan.is_some(), left);
        self.effort = plan.map_or(self.effort, |plan| plan.effort);
        self.budget = Budget::Samples(spp);
        Ok(Chosen { spp, effort: self.effort })
    }

    /// Whether frames of so many seconds are better path traced. Only for `auto` without a file of records, and only where a denoiser
    /// takes the noise away.
    fn better_traced(&mut self, trial: &Trial, rendering: &Rendering, seconds: f64) -> Result<bool> {
        let args = &self.args.image;
        if args.method != Method::Auto || args.cache.is_some() || options::for_records(args) {
            return Ok(false);
        }
        let (Some(denoiser), Some(together), Some(apart)) =
            (&self.denoiser, self.denoising(seconds, true)?, self.denoising(seconds, false)?)
        else {
            return Ok(false);
        };
        let writing = writing_seconds(&args.output, &self.world.scene.camera.film);
        let denoising = walk::Denoising { denoiser, plans: [together, apart], writing };
        Ok(trial.favours_paths(&mut self.world, rendering, &self.walk, seconds, &denoising)?)
    }

    /// Draws by path tracing, after some seconds of `--time-per-frame` were spent on all frames.
    pub fn traced(&mut self, frames: &[u32], spent: f64) -> Result<()> {
        let source = Source::Traced { seed: self.seed, indirect_only: self.indirect_only };
        if let Some(seconds) = self.args.time_per_frame {
            let Chosen { spp, .. } = self.choose(&source, seconds, spent)?;
            eprintln!("render: {spp} samples per pixel in {seconds} s a frame");
        }
        let scene = Checksums::new(&self.world.scene);
        let key = format!("path {:x} {:x}", scene.geometry, scene.materials);
        self.draw(&source, frames, &key)
    }

    /// Fills caches, and draws from them.
    pub fn cached(&mut self, caching: &Caching, frames: &[u32]) -> Result<()> {
        let (policy, fitting) = decide(caching, &self.world)?;
        self.stats.seconds.fit = fitting.as_secs_f64();
        let filling = Instant::now();
        let rendering = Rendering::new(&self.world, &policy, &caching.settings)
            .reading(Reading::Few)
            .denoised(self.denoiser.is_some());
        let mut tolerance = caching.tolerance;
        let key = Key::new(&self.world, &policy, &caching.settings, tolerance);
        let mut kept = Kept::open(caching.file.as_deref(), self.args.frames_only)?;
        let (mut caches, complete) = kept.read(&key, self)?;
        let range = self.range(frames)?;
        let done = complete && caches.walk.as_ref().is_some_and(|mark| mark.covers(range));
        if !done {
            match self.fill(&rendering, caches, tolerance, range, (&mut kept, &key))? {
                Some(filled) => (caches, tolerance) = filled,
                None => {
                    eprintln!(
                        "render: auto traces paths: in so many seconds a frame, they come nearer to the truth than records"
                    );
                    return self.traced(frames, filling.elapsed().as_secs_f64());
                }
            }
        }
        self.stats.take(&caches, tolerance);
        let counts = std::mem::take(&mut caches.counts);
        self.stats.rays += counts.rays;
        let mut changed = !done;
        if let Some(seconds) = self.args.time_per_frame {
            let source = Source::Cached { rendering: &rendering, tolerance, caches: &caches };
            let chosen = self.choose(&source, seconds, filling.elapsed().as_secs_f64())?;
            changed = true;
            if let Some(mark) = &mut caches.walk {
                mark.chosen = Some(chosen);
            }
            eprintln!("render: tau {tolerance:.4} and {} samples per pixel in {seconds} s a frame", chosen.spp);
        }
        self.stats.seconds.fill = filling.elapsed().as_secs_f64();
        if changed {
            kept.save(&key.at(tolerance), &caches)?;
        }
        drop(kept);
        eprintln!(
            "render: {:.2} s to fill for {} frames; {} records, {} KB; tau {tolerance:.4}",
            self.stats.seconds.fill,
            range[1] - range[0] + 1,
            caches.records(),
            caches.bytes() / 1000
        );
        if self.args.fill_only {
            return Ok(());
        }
        let made = format!("{:x} {:x}", key.at(tolerance).checksum()?, file::checksum(&caches));
        let source = Source::Cached { rendering: &rendering, tolerance, caches: &caches };
        self.draw(&source, frames, &made)
    }

    /// First and last of the frames to fill for, counted from the first of the path.
    fn range(&self, frames: &[u32]) -> Result<[u32; 2]> {
        let (first, last) = self.walk.frames().into_inner();
        if !self.args.fill_only || self.args.frames.is_none() {
            return Ok([0, last - first]);
        }
        let (from, to) = (frames.iter().min().unwrap_or(&first), frames.iter().max().unwrap_or(&last));
        ensure!((to - from) as usize + 1 == frames.len(), "--fill-only needs --frames A-B: frames in a row");
        Ok([from - first, to - first])
    }

    /// Adds to caches what a range of frames needs, and says at which τ; `None` where frames are better path traced.
    fn fill(
        &mut self,
        rendering: &Rendering,
        mut caches: Caches,
        mut tolerance: f32,
        range: [u32; 2],
        (kept, key): (&mut Kept, &Key),
    ) -> Result<Option<(Caches, f32)>> {
        let mut deadline = None;
        if let Some(seconds) = self.args.time_per_frame {
            let start = Instant::now();
            let [time, longest] =
                [FILL_SHARE, LONGEST_FILL].map(|share| Duration::from_secs_f64(share * seconds * self.count()));
            let trial = Trial::new(&mut self.world, rendering, &self.walk, time);
            if self.better_traced(&trial, rendering, seconds)? {
                return Ok(None);
            }
            let (chosen, tried) = trial.finish(&mut self.world, rendering, &self.walk);
            tolerance = chosen;
            caches = tried.filter(|_| caches.records() == 0).unwrap_or(caches);
            deadline = Some(start + longest);
        }
        let fill = walk::Fill { rendering, walk: &self.walk, tolerance, range, deadline };
        let meter = Meter::new("fill", self.args.progress);
        let key = key.at(tolerance);
        let progress = |filled: walk::Filled| {
            let what = format!("fill: frame {} of {}, {} records", filled.frames + 1, filled.all, filled.records);
            meter.at(f64::from(filled.frames) / f64::from(filled.all), what);
        };
        let caches = fill.run(&mut self.world, caches, |caches| kept.stage(&key, caches), &progress)?;
        Ok(Some((caches, tolerance)))
    }

    /// Draws and writes frames, in the order in which they were asked for.
    fn draw(&mut self, source: &Source, frames: &[u32], made: &str) -> Result<()> {
        let denoiser = self.denoiser.as_ref().map_or("off", Denoiser::name);
        let made = format!("{made} denoise {denoiser} {:?}", self.effort);
        let meter = Meter::new("frames", self.args.progress);
        let count = frames.len() as f64;
        for (i, &frame) in frames.iter().enumerate() {
            let Some(camera) = self.walk.camera(frame) else { continue };
            let records =
                if self.stats.records > 0 { format!(", {} records", self.stats.records) } else { String::new() };
            meter.at(i as f64 / count, format!("frame {frame}, {} of {}{records}", i + 1, frames.len()));
            let note = self.files.note(self.args, frame, camera, self.budget, &made);
            let missing: Vec<PathBuf> = self.files.of(frame).collect();
            if self.args.skip_existing && missing.iter().all(|path| files::is_whole(path, &note, camera)) {
                self.stats.skipped += 1;
                continue;
            }
            let shading = Instant::now();
            let bar = meter.bar();
            let progress = |x: f64| bar.set((i as f64 + x) / count);
            let mut picture =
                source.draw(&mut self.world, (frame, camera), (self.budget, self.denoiser.is_some()), &progress);
            self.stats.seconds.shade += shading.elapsed().as_secs_f64();
            self.stats.count(&picture);
            if let Some(warning) = not_finite_warning(picture.counts.not_finite, picture.counts.paths) {
                bar.say(&format!("render: warning: frame {frame}: {warning}"));
            }
            if let Some(denoiser) = &self.denoiser {
                let denoising = Instant::now();
                denoiser.denoise(&mut picture, self.effort)?;
                self.stats.denoised(denoiser.name(), denoising.elapsed());
            }
            let writing = Instant::now();
            let look = Look { note: Some(note), ..self.look.clone() };
            for path in &missing {
                write_picture(path, &picture, &look).with_context(|| path.display().to_string())?;
            }
            self.stats.seconds.write += writing.elapsed().as_secs_f64();
        }
        Ok(())
    }

    /// Tells what was done.
    pub fn finish(mut self) -> Result<ExitCode> {
        self.stats.seconds.total = self.start.elapsed().as_secs_f64();
        if !self.args.fill_only {
            eprintln!("render: {}", self.stats.sentence());
        }
        if let Some(path) = &self.args.image.stats {
            let text = serde_json::to_string_pretty(&self.stats)? + "\n";
            write(path, text.as_bytes())?;
        }
        Ok(ExitCode::SUCCESS)
    }

    /// No records yet.
    pub fn empty(&self) -> Caches {
        let (min, max) = self.world.bounds();
        Caches::new(min, max)
    }
}

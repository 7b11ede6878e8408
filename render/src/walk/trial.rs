//! What a budget of time for every frame buys, found out with a few of them.

use super::frames::{Source, seed_of};
use super::path::Walk;
use crate::cache::Density;
use crate::denoise::{DenoiseError, Denoiser, Plan};
use crate::integrator::cached::{COST_EXPONENT, Caches, FIRST_TOLERANCE, Rendering, SMALLEST_TOLERANCE, Settings};
use crate::metric::Verdict;
use crate::picture::Budget;
use crate::scene::Camera;
use crate::world::World;
use std::time::{Duration, Instant};

/// Times the fill of a whole path takes what that of three of its frames does, about (measured in the glossy box and two
/// staircases: 1.5 to 3).
const GROWTH: f64 = 2.0;
/// Share of the time for the fill that it is planned for: the guess is rough.
const MARGIN: f64 = 0.8;
/// Share of a frame's time that is planned for: others may take longer than those on trial.
const FRAME_MARGIN: f64 = 0.95;
/// How many times as long as a path traced frame a frame from records may take that does not fit into its time, both at one sample
/// per pixel. Measured: from 1.1 (sponza, where records are better at that) to 2.5 (a staircase of rough plastics, where they are not).
const TOO_SLOW: f64 = 1.5;
/// Samples of a path traced frame from which on it is better than one from records that is late. Measured: with 2 it is not (a hall), with
/// 4 it is (glossy box).
const ENOUGH: f64 = 3.0;
/// Largest share of the time for all frames that two of them and a judge may take.
const JUDGED: f64 = 0.1;
/// Samples per pixel on trial.
const TRIAL: [u32; 2] = [1, 4];
/// Most samples per pixel that a trial chooses.
const MAX_SPP: f64 = 65_536.0;

/// Times the fill of three frames takes what that of the one in the middle does, about (glossy box 2.2, hall 1.5, atrium 1.8, wooden
/// staircase 1.6).
const MORE_FRAMES: f64 = 1.8;

/// The frame in the middle of a path.
fn middle(walk: &Walk) -> u32 {
    let (first, last) = walk.frames().into_inner();
    first + (last - first) / 2
}

/// The first frame of a path, one in its middle, and the last, without repetitions.
fn on_trial(walk: &Walk) -> Vec<u32> {
    let mut frames = vec![*walk.frames().start(), middle(walk), *walk.frames().end()];
    frames.dedup();
    frames
}

/// How frames are denoised and written.
#[derive(Clone, Copy, Debug)]
pub struct Denoising<'a> {
    /// By what.
    pub denoiser: &'a Denoiser,
    /// Those from records, and path traced ones.
    pub plans: [Plan; 2],
    /// Seconds that writing one takes.
    pub writing: f64,
}

/// A coarse fill for a few frames of a path: first for the one in its middle, which tells whether records are worth it at all.
#[derive(Debug)]
pub struct Trial {
    /// The records of the trial, which are those of [`FIRST_TOLERANCE`].
    caches: Caches,
    /// Seconds that they took.
    spent: f64,
    /// Seconds for the fill of all frames.
    time: f64,
}

impl Trial {
    /// Fills the frame in the middle of a path, within the time that there is for the fill of all.
    pub fn new(world: &mut World, rendering: &Rendering, walk: &Walk, time: Duration) -> Self {
        let (min, max) = world.bounds();
        let trial = Self { caches: Caches::new(min, max), spent: 0.0, time: time.as_secs_f64() };
        trial.filled(world, rendering, walk, &[middle(walk)])
    }

    fn filled(self, world: &mut World, rendering: &Rendering, walk: &Walk, frames: &[u32]) -> Self {
        let start = Instant::now();
        let deadline = start + Duration::from_secs_f64((self.time - self.spent).max(0.0));
        let mut caches = self.caches;
        for &frame in frames {
            stand(world, walk, frame);
            let how = (Density::Every, seed_of(rendering.settings.seed, frame));
            caches = rendering.fill_frame(world, FIRST_TOLERANCE, caches, how, Some(deadline));
        }
        caches.refile();
        Self { caches, spent: self.spent + start.elapsed().as_secs_f64(), ..self }
    }

    /// Fills the other frames on trial: the τ whose fill for the whole path takes about what is left of the time, and the records to
    /// go on from, where they are as fine as those of that τ.
    pub fn finish(self, world: &mut World, rendering: &Rendering, walk: &Walk) -> (f32, Option<Caches>) {
        let mut frames = on_trial(walk);
        let few = frames.len() as u32 == walk.frames().end() - walk.frames().start() + 1;
        frames.retain(|frame| *frame != middle(walk));
        let Self { caches, spent, time } = self.filled(world, rendering, walk, &frames);
        let left = MARGIN * (time - spent).max(1e-3);
        let growth = if few { 1.0 } else { GROWTH };
        let share = (growth * spent / left).powf(1.0 / COST_EXPONENT) as f32;
        let tolerance = (FIRST_TOLERANCE * share).clamp(SMALLEST_TOLERANCE, FIRST_TOLERANCE);
        (tolerance, (tolerance >= FIRST_TOLERANCE).then_some(caches))
    }

    /// Whether a denoised frame is better path traced, where there are so many seconds for each, the fill included. Two are drawn and
    /// denoised, with as many samples as there is time for, and judged by a third ([`Verdict`]), unless that takes too
    /// much of a short walk. What cannot be told, the samples decide: that of more is taken; where even a coarse fill and frame do not fit
    /// into the time, the path traced one with enough of them.
    ///
    /// Measured in four rooms at half a second to two seconds a frame of two cores: path traced frames win
    /// with 4 samples against 1 and 13 against 9 (glossy box), records with 1 against 1 and up to 18 against 26 (sponza).
    ///
    /// # Errors
    /// A denoiser that fails.
    pub fn favours_paths(
        &self,
        world: &mut World,
        rendering: &Rendering,
        walk: &Walk,
        seconds: f64,
        denoising: &Denoising,
    ) -> Result<bool, DenoiseError> {
        let Settings { seed, indirect_only, .. } = rendering.settings;
        let records = Source::Cached { rendering, tolerance: FIRST_TOLERANCE, caches: &self.caches };
        let paths = Source::Traced { seed, indirect_only };
        let (frame, count) = (middle(walk), f64::from(walk.frames().end() - walk.frames().start() + 1));
        let Some(camera) = walk.camera(frame) else { return Ok(false) };
        let mut time = |source: &Source, spp: u32| seconds_of(world, source, (frame, camera), spp, true);
        let fill = GROWTH * MORE_FRAMES * self.spent / count;
        let once = [time(&records, TRIAL[0]), time(&paths, TRIAL[0])];
        let fixed = denoising.plans.map(|plan| plan.seconds + denoising.writing);
        let whole = [once[0] + fill + fixed[0], once[1] + fixed[1]];
        let late = whole[0] > seconds;
        if late && whole[0] > TOO_SLOW * whole[1] {
            return Ok(true);
        }
        let mut samples = |i: usize, source: &Source| {
            let slope = ((time(source, TRIAL[1]) - once[i]) / f64::from(TRIAL[1] - TRIAL[0])).max(1e-6);
            (f64::from(TRIAL[0]) + (seconds - whole[i]) / slope).clamp(1.0, MAX_SPP)
        };
        let [of_records, of_paths] = [samples(0, &records), samples(1, &paths)];
        if 3.0 * whole[0].max(seconds) <= JUDGED * seconds * count {
            let mut draw = |source: &Source, spp: f64, plan: Option<Plan>| {
                let budget = (Budget::Samples(spp as u32), plan.is_some());
                let mut picture = source.draw(world, (frame, camera), budget, &|_| ());
                if let Some(plan) = plan {
                    denoising.denoiser.denoise(&mut picture, plan.effort)?;
                }
                Ok(picture.image())
            };
            let [together, apart] = denoising.plans;
            let candidates = [draw(&records, of_records, Some(together))?, draw(&paths, of_paths, Some(apart))?];
            // Sample points that neither of the two has seen.
            let judge = draw(&Source::Traced { seed: !seed, indirect_only }, of_paths, None)?;
            let verdict = Verdict::of([&candidates[0], &candidates[1]], &judge);
            if let Some(order) = verdict.ok().and_then(|verdict| verdict.order()) {
                return Ok(order.is_gt());
            }
        }
        Ok(if late { of_paths >= ENOUGH } else { of_paths > of_records })
    }
}

/// Puts the camera where it is in a frame.
fn stand(world: &mut World, walk: &Walk, frame: u32) {
    if let Some(camera) = walk.camera(frame) {
        world.scene.camera.clone_from(camera);
    }
}

/// Seconds that a frame takes with so many samples per pixel.
fn seconds_of(world: &mut World, source: &Source, frame: (u32, &Camera), spp: u32, denoised: bool) -> f64 {
    let start = Instant::now();
    source.draw(world, frame, (Budget::Samples(spp), denoised), &|_| ());
    start.elapsed().as_secs_f64()
}

/// Samples per pixel that frames, denoised or not, can have, by drawing a few of them; `left` tells the seconds that there are for
/// each, without denoising, when that trial has taken so many. What a sample adds is found out in one frame; in others it is taken to be the same
/// share of their time.
pub fn choose_samples(
    world: &mut World,
    source: &Source,
    walk: &Walk,
    denoised: bool,
    left: impl FnOnce(f64) -> f64,
) -> u32 {
    let start = Instant::now();
    let frames: Vec<(u32, &Camera)> = on_trial(walk).into_iter().filter_map(|i| Some((i, walk.camera(i)?))).collect();
    let few: Vec<f64> = frames.iter().map(|frame| seconds_of(world, source, *frame, TRIAL[0], denoised)).collect();
    let middle = frames.len() / 2;
    let Some(frame) = frames.get(middle) else { return 1 };
    let more = seconds_of(world, source, *frame, TRIAL[1], denoised);
    let slope = (more - few[middle]) / f64::from(TRIAL[1] - TRIAL[0]);
    let mean = few.iter().sum::<f64>() / few.len() as f64;
    let each = (slope * mean / few[middle]).max(1e-6);
    let fixed = (mean - each * f64::from(TRIAL[0])).max(0.0);
    let spp = (FRAME_MARGIN * left(start.elapsed().as_secs_f64()) - fixed) / each;
    spp.clamp(1.0, MAX_SPP) as u32
}

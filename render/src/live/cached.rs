//! Frames from records, and the records for them.

use super::orders::Change;
use super::session::{NEXT_ORDER, Session};
use super::status::Stage;
use crate::cache::Density;
use crate::integrator::cached::policy::Policy;
use crate::integrator::cached::{Caches, GradualFill, Halt, Rendering, Scenery, Settings, Sums};
use crate::picture::Budget;
use crate::scene::Camera;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// Time for records between two frames.
const FILL: Duration = Duration::from_millis(90);
/// Spacing of the pixels for which records are made while the camera moves, and where it begins, frame by frame.
const SPACING: u32 = 8;
const OFFSETS: [[u32; 2]; 8] = [[0, 0], [4, 4], [4, 0], [0, 4], [2, 2], [6, 6], [6, 2], [2, 6]];
/// Most samples of a pixel while records are missing.
const FEW: u32 = 8;
/// Most samples of a pass, and the time that one is to take.
const PASS: u32 = 8;
const LONGEST_PASS: f64 = 0.2;
/// Samples of the first picture of full size, and the time after which one is shown anyway.
const FIRST: u32 = 4;
const PATIENCE: Duration = Duration::from_millis(700);

/// How frames of a method are drawn.
struct Work<'a> {
    fine: &'a Rendering<'a>,
    hasty: &'a Rendering<'a>,
    tolerance: f32,
}

impl Session<'_> {
    /// Draws from records until another method, another τ or the end is asked for.
    pub(super) fn cached(&mut self, policy: &Policy, tolerance: f32, caches: &mut Caches) -> Change {
        let budget = Budget::Samples(self.options.spp);
        let interpolation = self.status.interpolation;
        let settings = Settings { tolerance: Some(tolerance), budget, interpolation, ..self.options.settings };
        let fine = Rendering::new(self.world, policy, &settings);
        let hasty = fine.clone().hasty();
        let work = Work { fine: &fine, hasty: &hasty, tolerance };
        let mut sums = Sums::default();
        let mut change = self.heed(Duration::ZERO);
        let mut first = true;
        while !change.leave && !change.engine {
            if first || change.view {
                self.move_on(&work, caches, &mut sums, first);
                first = false;
                change = self.heed(NEXT_ORDER);
            } else {
                change = self.stand(&work, caches, &mut sums);
            }
        }
        change
    }

    /// Whether caches may grow. Tells if they may not, and if the graphics card did not sum what it was to.
    fn has_room(&mut self, caches: &Caches, sums: &Sums) -> bool {
        let room = caches.bytes() < self.options.most_bytes;
        self.status.message = match (room, sums.card_failed()) {
            (false, _) => Some("the caches are full: no more records are made".into()),
            (true, true) => Some("the graphics card failed: the processor sums the records".into()),
            (true, false) => None,
        };
        room
    }

    /// Draws a frame of a camera that moves.
    fn move_on(&mut self, work: &Work, caches: &mut Caches, sums: &mut Sums, first: bool) {
        let (world, seed, camera) = (self.world, self.next_seed(), self.quick_camera(true));
        if !first && self.has_room(caches, sums) && self.search.is_due() {
            let [x, y] = OFFSETS[(seed >> 32) as usize % OFFSETS.len()];
            let how = (Density::Scouted { spacing: SPACING, offset: [x, y] }, seed);
            let (before, end, all) = (caches.records(), Instant::now() + FILL, self.navigator.camera());
            GradualFill::scouting(work.fine, world, all, work.tolerance, how).step(caches, end, &|_| ());
            self.search.note(caches.records() - before);
        }
        // The next order is most often another move: frames must come nevertheless.
        let (begun, never) = (Instant::now(), Halt::default());
        sums.clear(camera.film.window());
        let from = Scenery { world, camera: &camera, tolerance: work.tolerance, caches };
        work.hasty.go_on(&from, sums, (1, seed), &never);
        if let Some(mut picture) = work.hasty.developed(&from, sums, seed, &never) {
            self.show(&mut picture, &camera, Some(caches), Stage::Moving);
        }
        let aim = self.aim();
        self.paces[1].note(begun.elapsed(), aim);
    }

    /// Fills the caches for a camera that stands still, and refines its picture.
    fn stand(&mut self, work: &Work, caches: &mut Caches, sums: &mut Sums) -> Change {
        let camera = self.navigator.camera().clone();
        let change = self.fill(work, caches, sums, &camera);
        if change.stops() { change } else { self.refine(work, caches, sums, &camera) }
    }

    fn fill(&mut self, work: &Work, caches: &mut Caches, sums: &mut Sums, camera: &Camera) -> Change {
        let (desk, seed) = (self.desk, self.next_seed());
        let mut fill = GradualFill::new(work.fine, self.world, camera, work.tolerance);
        let share = AtomicU64::new(0);
        let mut quick = self.quick_camera(true);
        sums.clear(quick.film.window());
        while self.has_room(caches, sums) {
            fill.step(caches, Instant::now() + FILL, &|x| share.store(x.to_bits(), Ordering::Relaxed));
            self.status.filled = f64::from_bits(share.load(Ordering::Relaxed));
            let change = self.heed(Duration::ZERO);
            if change.stops() {
                return change;
            }
            if fill.is_done() {
                break;
            }
            let begun = Instant::now();
            let resized = self.quick_camera(true);
            if resized.film != quick.film {
                quick = resized;
                sums.clear(quick.film.window());
            }
            let from = Scenery { world: self.world, camera: &quick, tolerance: work.tolerance, caches };
            let alone = sums.spp() == 0;
            let went_on = sums.spp() >= FEW || work.hasty.go_on(&from, sums, (1, seed), &desk.halt);
            let picture = if went_on { work.hasty.developed(&from, sums, seed, &desk.halt) } else { None };
            if let Some(mut picture) = picture {
                self.show(&mut picture, &quick, Some(caches), Stage::Filling);
                if alone {
                    let aim = self.aim();
                    self.paces[1].note(begun.elapsed(), aim);
                }
            }
        }
        self.status.filled = 1.0;
        Change::default()
    }

    fn refine(&mut self, work: &Work, caches: &Caches, sums: &mut Sums, camera: &Camera) -> Change {
        let (desk, seed, all) = (self.desk, self.options.settings.seed, self.options.spp);
        let from = Scenery { world: self.world, camera, tolerance: work.tolerance, caches };
        sums.clear(camera.film.window());
        let (mut shown, mut next, mut pass) = (Instant::now(), FIRST, 1);
        loop {
            let begun = Instant::now();
            work.fine.go_on(&from, sums, (pass.min(all - sums.spp()), seed), &desk.halt);
            let change = self.heed(Duration::ZERO);
            if change.stops() {
                return change;
            }
            if sums.spp() >= all {
                break;
            }
            let affordable = LONGEST_PASS * f64::from(pass) / begun.elapsed().as_secs_f64().max(1e-6);
            pass = (affordable as u32).clamp(1, PASS);
            // A denoiser takes its time; noise is seen to go away sample by sample.
            let waited = shown.elapsed() > PATIENCE && !self.status.denoise;
            if sums.spp() >= next || waited || change.look {
                if let Some(mut picture) = work.hasty.developed(&from, sums, seed, &desk.halt) {
                    self.show(&mut picture, camera, Some(caches), Stage::Refining);
                }
                (shown, next) = (Instant::now(), next.max(2 * sums.spp()));
            }
        }
        let picture = work.fine.developed(&from, sums, seed, &desk.halt);
        self.has_room(caches, sums);
        match picture {
            Some(picture) => self.rest(picture, camera, Some(caches)),
            None => self.heed(Duration::ZERO),
        }
    }
}

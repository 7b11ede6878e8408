//! Frames by path tracing.

use super::orders::Change;
use super::session::{NEXT_ORDER, Session};
use super::status::Stage;
use crate::film::{add_samples, black};
use crate::integrator::PathTracer;
use std::time::{Duration, Instant};

/// Time between pictures of a camera that stands still, and samples of the first.
const PATIENCE: Duration = Duration::from_millis(500);
const FIRST: u32 = 2;
/// Most samples of a pass, and the time that one is to take.
const PASS: u32 = 16;
const LONGEST_PASS: f64 = 0.3;

impl Session<'_> {
    /// Traces paths until another method or the end is asked for.
    pub(super) fn traced(&mut self) -> Change {
        let mut change = self.heed(Duration::ZERO);
        let mut first = true;
        while !change.leave && !change.engine {
            if first || change.view {
                self.trace_frame();
                first = false;
                change = self.heed(NEXT_ORDER);
            } else {
                change = self.trace_on();
            }
        }
        change
    }

    fn tracer(&self) -> PathTracer {
        let settings = self.world.scene.integrator;
        PathTracer { settings, indirect_only: self.options.settings.indirect_only }
    }

    /// Draws a frame of a camera that moves.
    pub(super) fn trace_frame(&mut self) {
        let (begun, seed, camera) = (Instant::now(), self.next_seed(), self.quick_camera(false));
        let mut picture = black(&camera);
        add_samples((self.world, &camera), &self.tracer(), &mut picture, (1, seed), &|| false, &|| ());
        self.show(&mut picture, &camera, None, Stage::Moving);
        let aim = self.aim();
        self.paces[0].note(begun.elapsed(), aim);
    }

    /// Adds samples to the picture of a camera that stands still.
    fn trace_on(&mut self) -> Change {
        let (desk, seed, all) = (self.desk, self.options.settings.seed, self.options.spp);
        let camera = self.navigator.camera().clone();
        let (tracer, mut picture) = (self.tracer(), black(&camera));
        let (mut shown, mut next, mut pass) = (Instant::now(), FIRST, 1);
        loop {
            let begun = Instant::now();
            let samples = (pass.min(all - picture.spp), seed);
            add_samples((self.world, &camera), &tracer, &mut picture, samples, &|| desk.halt.is_set(), &|| ());
            let change = self.heed(Duration::ZERO);
            if change.stops() {
                return change;
            }
            if picture.spp >= all {
                return self.rest(picture, &camera, None);
            }
            let affordable = LONGEST_PASS * f64::from(pass) / begun.elapsed().as_secs_f64().max(1e-6);
            pass = (affordable as u32).clamp(1, PASS);
            let waited = shown.elapsed() > PATIENCE && !self.status.denoise;
            if picture.spp >= next || waited || change.look {
                self.show(&mut picture, &camera, None, Stage::Refining);
                (shown, next) = (Instant::now(), next.max(2 * picture.spp));
            }
        }
    }
}

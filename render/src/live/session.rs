//! The loop of a live view: orders, frames, and what lies between them.

use super::canvas::{Marked, painted};
use super::clock::{Meter, Pace, Search};
use super::desk::{Answer, Desk};
use super::navigator::Navigator;
use super::orders::Change;
use super::recorder::Recorder;
use super::status::{Stage, Status};
use crate::camera::RayGenerator;
use crate::denoise::{Denoiser, Effort};
use crate::image::view::{Display, View};
use crate::inspect::overlay::Marks;
use crate::integrator::cached::policy::Policy;
use crate::integrator::cached::{Caches, Settings};
use crate::outlines::{self, GUIDES};
use crate::picture::Picture;
use crate::scene::{Camera, FovAxis};
use crate::world::{Queries, World};
use glam::Vec2;
use std::collections::HashMap;
use std::time::{Duration, Instant};

/// Time for a frame without its records: with them five come in a second, ten where none are missing. A denoiser takes its own.
const FRAME: Duration = Duration::from_millis(75);
const DENOISED_FRAME: Duration = Duration::from_millis(140);
/// Time in which a hand that moves gives its next order: the work for a camera that stands still is not begun before.
pub(super) const NEXT_ORDER: Duration = Duration::from_millis(25);
/// Time without orders after which a picture that is there looks for them anyway.
const LONG: Duration = Duration::from_secs(3600);
/// Seconds in which one walks as far as one sees, about.
const CROSSING: f64 = 3.0;
/// Walking pace in an empty scene.
const EMPTY_PACE: f64 = 1.0;

/// A way to render.
#[derive(Clone, Debug, PartialEq)]
pub struct Engine {
    /// As it is chosen.
    pub name: String,
    /// Whether it keeps records.
    pub cached: bool,
}

/// What a view begins with.
pub struct Options {
    /// Methods to choose from.
    pub engines: Vec<Engine>,
    /// The first of them.
    pub engine: usize,
    /// How records are used; samples of a pixel that stays are its budget.
    pub settings: Settings,
    /// τ.
    pub tolerance: f32,
    /// Samples of a pixel of the picture that is there when nothing moves.
    pub spp: u32,
    /// Stops.
    pub stops: f32,
    /// How the screen shows light.
    pub view: View,
    /// Takes noise out of frames.
    pub denoiser: Option<Denoiser>,
    /// Whether it does from the first frame on.
    pub denoise: bool,
    /// Along which axis of a film of this aspect rows of a path give the angle of view.
    pub fov: (FovAxis, f64),
    /// Bytes of records from which on no more are made.
    pub most_bytes: usize,
}

/// Decides on the materials for a method at a τ; an error is told to the page.
pub type Prepare<'a> = dyn FnMut(&Engine, f32) -> Result<Policy, String> + 'a;

/// A frame for whoever looks.
pub struct Frame<'a> {
    /// JPEG; `None` where only the status is new.
    pub jpeg: Option<Vec<u8>>,
    /// Figures and settings.
    pub status: &'a Status,
    /// Its light.
    pub picture: Option<&'a Picture>,
}

/// Who looks at frames.
pub trait Audience {
    /// A frame.
    fn show(&mut self, frame: Frame);
    /// An answer to an order.
    fn tell(&mut self, answer: Answer);
}

/// A live view of a scene.
pub struct Session<'a> {
    pub(super) world: &'a World,
    pub(super) desk: &'a Desk,
    pub(super) options: Options,
    pub(super) navigator: Navigator,
    pub(super) status: Status,
    /// Sizes of frames, by path tracing and from records.
    pub(super) paces: [Pace; 2],
    /// For records while the camera moves.
    pub(super) search: Search,
    pub(super) audience: &'a mut dyn Audience,
    prepare: &'a mut Prepare<'a>,
    pub(super) engine: usize,
    pub(super) display: Display,
    meter: Meter,
    pub(super) recorder: Option<Recorder>,
    /// When orders were last looked at, and whether the camera walked.
    pub(super) looked: (Instant, bool),
    /// Frames so far: each has sample points of its own.
    frames: u64,
    /// Records of methods that were left, by method and τ.
    pub(super) shelf: HashMap<(usize, u32), Caches>,
}

impl<'a> Session<'a> {
    /// Through the camera of the world. `caches` are records that the first method has already.
    pub fn new(
        world: &'a World,
        options: Options,
        caches: Option<Caches>,
        desk: &'a Desk,
        prepare: &'a mut Prepare<'a>,
        audience: &'a mut dyn Audience,
    ) -> Self {
        let (low, high) = world.bounds();
        let camera = &world.scene.camera;
        let navigator = Navigator::new(camera, [low.as_dvec3(), high.as_dvec3()], pace(world));
        let engine = options.engine;
        let shelf = caches.map(|caches| ((engine, options.tolerance.to_bits()), caches)).into_iter().collect();
        let status = Status {
            stage: Stage::Preparing,
            fps: 0.0,
            size: [0; 2],
            spp: [0, options.spp],
            filled: 0.0,
            records: 0,
            bytes: 0,
            method: options.engines[engine].name.clone(),
            interpolation: options.settings.interpolation,
            tau: options.tolerance,
            stops: options.stops,
            view: options.view.into(),
            denoise: options.denoise && options.denoiser.is_some(),
            marks: [false; 2],
            recording: None,
            message: None,
        };
        Self {
            world,
            desk,
            navigator,
            status,
            paces: [Pace::new(), Pace::new()],
            search: Search::default(),
            audience,
            prepare,
            engine,
            display: Display::new(options.view, options.stops),
            meter: Meter::default(),
            recorder: None,
            looked: (Instant::now(), false),
            frames: 0,
            shelf,
            options,
        }
    }

    /// Draws frames until it is told to leave; returns the records of the first method at the first τ.
    pub fn run(mut self) -> Option<Caches> {
        // Whatever the method has to get ready, there is something to see.
        self.trace_frame();
        loop {
            let engine = self.options.engines[self.engine].clone();
            let tolerance = self.status.tau;
            let change = if engine.cached {
                self.tell_stage(Stage::Preparing);
                match (self.prepare)(&engine, tolerance) {
                    Ok(policy) => {
                        self.status.message = None;
                        let key = (self.engine, tolerance.to_bits());
                        let (low, high) = self.world.bounds();
                        let mut caches = self.shelf.remove(&key).unwrap_or_else(|| Caches::new(low, high));
                        let change = self.cached(&policy, tolerance, &mut caches);
                        self.shelf.insert(key, caches);
                        change
                    }
                    Err(message) => {
                        self.status.message = Some(message);
                        self.traced()
                    }
                }
            } else {
                self.status.message = None;
                self.traced()
            };
            if change.leave {
                break;
            }
        }
        self.end_record();
        self.shelf.remove(&(self.options.engine, self.options.tolerance.to_bits()))
    }

    /// The camera now, with a film that is drawn in time.
    pub(super) fn quick_camera(&self, cached: bool) -> Camera {
        let camera = self.navigator.camera();
        Camera { film: self.paces[usize::from(cached)].film(&camera.film), ..camera.clone() }
    }

    /// What a frame may take.
    pub(super) fn aim(&self) -> Duration {
        if self.status.denoise { DENOISED_FRAME } else { FRAME }
    }

    /// A seed for the next frame: noise that stood still would look like dirt.
    pub(super) fn next_seed(&mut self) -> u64 {
        self.frames += 1;
        self.options.settings.seed.wrapping_add(self.frames.wrapping_mul(0x9e37_79b9_7f4a_7c15))
    }

    /// Shows a picture of a camera.
    pub(super) fn show(&mut self, picture: &mut Picture, camera: &Camera, caches: Option<&Caches>, stage: Stage) {
        picture.denoised = None;
        if let (true, Some(denoiser)) = (self.status.denoise, &self.options.denoiser) {
            let effort = if stage == Stage::Settled { Effort::High } else { Effort::Least };
            if stage == Stage::Settled && picture.outline_rays == 0 {
                let Settings { seed, indirect_only, .. } = self.options.settings;
                outlines::refine((self.world, camera), picture, (seed, indirect_only), GUIDES);
            }
            if let Err(error) = denoiser.denoise(picture, effort) {
                self.status.denoise = false;
                self.audience.tell(Answer::Error { message: error.to_string() });
            }
        }
        let [dots, zones] = self.status.marks;
        let marks = Marks { dots, zones };
        let marked = caches.filter(|_| dots || zones);
        let marked = marked.map(|caches| Marked { world: self.world, camera, caches, marks });
        let jpeg = painted(picture, &self.display, marked.as_ref(), stage == Stage::Settled);
        self.status.fps = self.meter.tick(Instant::now());
        self.status.stage = stage;
        self.status.size = [picture.width, picture.height];
        self.status.spp = [picture.spp, self.options.spp];
        self.status.count(caches);
        self.audience.show(Frame { jpeg, status: &self.status, picture: Some(picture) });
    }

    fn tell_stage(&mut self, stage: Stage) {
        self.status.stage = stage;
        self.audience.show(Frame { jpeg: None, status: &self.status, picture: None });
    }

    /// Waits at a picture that is there until another is asked for.
    pub(super) fn rest(&mut self, mut picture: Picture, camera: &Camera, caches: Option<&Caches>) -> Change {
        self.show(&mut picture, camera, caches, Stage::Settled);
        loop {
            let change = self.heed(LONG);
            if change.stops() {
                return change;
            }
            if change.look {
                self.show(&mut picture, camera, caches, Stage::Settled);
            }
        }
    }
}

/// Scene units in a second at which one crosses what the camera sees in some seconds.
fn pace(world: &World) -> f64 {
    const LATTICE: u32 = 16;
    let camera = &world.scene.camera;
    let (generator, window) = (RayGenerator::new(camera), camera.film.window());
    let mut queries = Queries::default();
    let mut depth = |i: u32| {
        let middle = |i: u32, of: u32| (2 * i + 1) * of / (2 * LATTICE);
        let (x, y) = (window.x + middle(i % LATTICE, window.width), window.y + middle(i / LATTICE, window.height));
        let hit = queries.intersect(world, &generator.ray(x, y, Vec2::splat(0.5)));
        hit.exists().then_some(f64::from(hit.t))
    };
    let mut depths: Vec<f64> = (0..LATTICE * LATTICE).filter_map(&mut depth).collect();
    depths.sort_by(f64::total_cmp);
    let (low, high) = world.bounds();
    let size = f64::from((high - low).length());
    let seen = depths.get(depths.len() / 2).copied().or(Some(size)).filter(|seen| seen.is_finite() && *seen > 0.0);
    seen.map_or(EMPTY_PACE, |seen| seen / CROSSING)
}

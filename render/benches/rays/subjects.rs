//! Scenes, and the rays that a path tracer sends through them.

use render::camera::RayGenerator;
use render::light::{LightSampleContext, Target};
use render::ray::Ray;
use render::sampler::{Sampler, Scrambles};
use render::scene::load::{Options, load};
use render::world::{Interaction, World};
use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::{LazyLock, Mutex};

/// What a ray is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Purpose {
    Camera,
    ThirdBounce,
    Shadow,
}

pub const PURPOSES: [Purpose; 3] = [Purpose::Camera, Purpose::ThirdBounce, Purpose::Shadow];

/// A scene and its rays, in the order in which pixels are drawn.
pub struct Subject {
    pub world: World,
    pub camera: Vec<Ray>,
    pub third_bounce: Vec<Ray>,
    /// From what camera rays meet to a sampled place on a light.
    pub shadow: Vec<Ray>,
}

impl Subject {
    pub fn rays(&self, purpose: Purpose) -> &[Ray] {
        match purpose {
            Purpose::Camera => &self.camera,
            Purpose::ThirdBounce => &self.third_bounce,
            Purpose::Shadow => &self.shadow,
        }
    }
}

/// Name, file below the project or below the folder of scenes beside it.
const SCENES: [(&str, &str); 6] = [
    ("box", "tests/scenes/cornell-glossy.xml"),
    ("dragon", "../shared/scenes/dragon/dragon.xml"),
    ("sponza", "../shared/scenes/sponza/sponza.xml"),
    ("kitchenette", "../shared/scenes/kitchenette/scene.xml"),
    ("wooden-staircase", "../shared/scenes/wooden-staircase/scene.xml"),
    ("matpreview", "../shared/scenes/matpreview/matpreview-n100.xml"),
];

fn file(name: &str) -> PathBuf {
    let path = SCENES.iter().find(|s| s.0 == name).expect("a name of the list").1;
    PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/..")).join(path)
}

/// The scenes that are there.
pub fn names() -> Vec<&'static str> {
    SCENES.iter().map(|s| s.0).filter(|name| file(name).exists()).collect()
}

/// Scenes with what they were asked for, kept from bench to bench.
pub fn subject(name: &str) -> &'static Subject {
    static KNOWN: LazyLock<Mutex<HashMap<String, &'static Subject>>> = LazyLock::new(Mutex::default);
    let mut known = KNOWN.lock().expect("no bench panics");
    known.entry(name.into()).or_insert_with(|| Box::leak(Box::new(make(name))))
}

/// Pixels of a picture, at most.
const PIXELS: u32 = 400 * 400;

fn make(name: &str) -> Subject {
    let (mut scene, _) = load(&file(name), &Options::default()).expect("a valid scene");
    let film = &mut scene.camera.film;
    film.crop = None;
    let scale = (f64::from(PIXELS) / (f64::from(film.width) * f64::from(film.height))).sqrt();
    film.width = (f64::from(film.width) * scale) as u32;
    film.height = (f64::from(film.height) * scale) as u32;
    let (width, height) = (film.width, film.height);
    let world = World::new(scene).expect("a valid scene");
    let generator = RayGenerator::new(&world.scene.camera);
    let mut subject = Subject { world, camera: Vec::new(), third_bounce: Vec::new(), shadow: Vec::new() };
    let mut scrambles = Scrambles::default();
    for y in 0..height {
        for x in 0..width {
            let mut sampler = Sampler::new(1, (x, y), 0);
            let ray = generator.sample(x, y, &mut sampler);
            subject.camera.push(ray);
            follow(&mut subject, ray, &mut sampler, &mut scrambles);
        }
    }
    subject
}

/// Follows a path to its third bounce.
fn follow(subject: &mut Subject, mut ray: Ray, sampler: &mut Sampler, scrambles: &mut Scrambles) {
    for bounce in 1..=3 {
        let hit = subject.world.intersect(&ray);
        if !hit.exists() {
            return;
        }
        let at = subject.world.interaction(&ray, &hit);
        let [choice, light, scattering, _] = sampler.next_4x2d(scrambles);
        if bounce == 1
            && let Some(shadow) = shadow_ray(&subject.world, &at, choice.x, light)
        {
            subject.shadow.push(shadow);
        }
        let Some(sample) = subject.world.bsdf(&at).sample(choice.y, scattering) else { return };
        ray = at.spawn(sample.wi);
    }
    subject.third_bounce.push(ray);
}

fn shadow_ray(world: &World, at: &Interaction, choice: f32, u: glam::Vec2) -> Option<Ray> {
    let bsdf = world.bsdf(at);
    let receiver = LightSampleContext { p: at.p, normal: bsdf.normal(), one_sided: bsdf.only_reflects() };
    let light = world.lights.sample(&world.scene.textures, &receiver, choice, u)?;
    Some(match light.target {
        Target::Point { p, clearance } => at.spawn_to(p, clearance),
        Target::Direction(d) => at.spawn(d),
    })
}

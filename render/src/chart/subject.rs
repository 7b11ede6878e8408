//! A scene with its reference.

use super::plan::{Plan, Reference};
use anyhow::{Context, Error, Result, bail, ensure};
use render::film;
use render::image::{Image, Look, read, read_noise, write_picture};
use render::integrator::PathTracer;
use render::integrator::cached::kept_pixels;
use render::picture::{Budget, require_memory};
use render::scene::checksum::{Checksums, Hash};
use render::scene::{Scene, load};
use render::world::World;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// What is rendered, and what it should look like.
pub struct Subject {
    /// Name in tables.
    pub name: String,
    /// The scene.
    pub world: World,
    /// Converged picture.
    pub reference: Image,
    /// Where it comes from, for a reader.
    pub reference_about: String,
    /// Its own noise as a rel_mse, where it is known.
    pub reference_noise: Option<f64>,
    /// Checksum of all of it.
    pub digest: String,
}

/// A scene that is loaded, before its reference is there.
pub struct Loaded {
    /// Name in tables.
    pub name: String,
    /// The scene.
    pub world: World,
    reference: Option<PathBuf>,
    digest: String,
}

/// Name of a scene in tables and file names: that of its file, in plain characters.
pub fn name(path: &Path) -> String {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    stem.chars().map(|c| if c.is_ascii_alphanumeric() || "._-+".contains(c) { c } else { '_' }).collect()
}

/// Loads a scene as the plan wants it; prints warnings.
///
/// # Errors
/// A scene that cannot be loaded.
pub fn load_scene(plan: &Plan, path: &Path, reference: Option<&PathBuf>) -> Result<Loaded> {
    let (mut scene, warnings) = load::load(path, &plan.load)?;
    warnings.iter().for_each(|warning| eprintln!("render: warning: {warning}"));
    scene.camera.film.resize(plan.width, None);
    let kept = kept_pixels(scene.camera.film.window(), false);
    require_memory(&scene.camera, kept, scene.camera.lens.is_some(), false)
        .map_err(Error::msg)
        .with_context(|| path.display().to_string())?;
    let digest = digest(&scene, plan.indirect_only);
    let world = World::new(scene).with_context(|| path.display().to_string())?;
    Ok(Loaded { name: name(path), world, reference: reference.cloned(), digest })
}

fn digest(scene: &Scene, indirect_only: bool) -> String {
    let Checksums { geometry, materials, camera } = Checksums::new(scene);
    let mut hash = Hash::default();
    let version = env!("CARGO_PKG_VERSION");
    hash.text(&format!("{version} {geometry} {materials} {camera} {:?} {indirect_only}", scene.integrator));
    format!("{:08x}", hash.finish() >> 32)
}

impl Loaded {
    /// Reads the reference, or traces and keeps it. `progress` is told the share of the work done.
    ///
    /// # Errors
    /// A reference that cannot be read or written, or is of another size.
    pub fn with_reference(self, plan: &Plan, progress: &(dyn Fn(f64) + Sync)) -> Result<Subject> {
        let traced = format!("{}-{}-{}.exr", self.name, self.digest, plan.reference.id());
        let path = self.reference.clone().unwrap_or_else(|| plan.output.join("references").join(traced));
        if self.reference.is_none() && !path.exists() {
            trace(&self.world, &path, plan, progress)?;
        }
        let reference = read(&path)?;
        let film = self.world.scene.camera.film.window();
        ensure!(
            (reference.width, reference.height) == (film.width, film.height),
            "{}: {}×{} pixels, but {} has {}×{}",
            path.display(),
            reference.width,
            reference.height,
            self.name,
            film.width,
            film.height
        );
        let noise = read_noise(&path)?;
        let file_name = path.file_name().unwrap_or_default().to_string_lossy();
        let reference_about = match &noise {
            Some(n) => format!("{file_name}, path traced with {} samples per pixel", n.spp),
            None => file_name.into_owned(),
        };
        let reference_noise = noise.map(|n| relative_noise(&n.variance, &reference));
        let mut hash = Hash::default();
        hash.text(&self.digest);
        hash.numbers(reference.pixels.as_flattened());
        let digest = format!("{:08x}", hash.finish() >> 32);
        Ok(Subject { name: self.name, world: self.world, reference, reference_about, reference_noise, digest })
    }
}

/// The rel_mse that a picture of this variance has for its noise alone.
fn relative_noise(variance: &Image, mean: &Image) -> f64 {
    let pairs = variance.pixels.iter().flatten().zip(mean.pixels.iter().flatten());
    let sum: f64 = pairs.map(|(v, m)| f64::from(*v) / (f64::from(*m).powi(2) + 0.01)).sum();
    sum / (3 * mean.pixels.len()).max(1) as f64
}

/// Samples per pixel from which the number for the error wanted is extrapolated.
const TRIAL_SPP: u32 = 64;
/// Fewest and most samples of a reference.
const SPP: (u32, u32) = (256, 1 << 17);
/// Keeps the reference's samples apart from those of any seed a person would choose.
const REFERENCE_SEED: u64 = 0x5eed_0000_0000;

/// Path traces the reference: as many samples as the error wanted needs, by a trial, or as the time allows.
fn trace(world: &World, path: &Path, plan: &Plan, progress: &(dyn Fn(f64) + Sync)) -> Result<()> {
    let Reference { error, seconds } = plan.reference;
    let integrator = PathTracer { settings: world.scene.integrator, indirect_only: plan.indirect_only };
    let seed = plan.seed.wrapping_add(REFERENCE_SEED);
    let start = Instant::now();
    let trial = film::render(world, &integrator, Budget::Samples(TRIAL_SPP), seed, &|_| ());
    let spent = start.elapsed().as_secs_f64();
    let noise = trial.pixels.iter().map(|p| trial.variance(p).unwrap_or_default().to_array()).collect();
    let image = trial.image();
    let found = relative_noise(&Image { pixels: noise, ..image.clone() }, &image);
    let wanted = f64::from(TRIAL_SPP) * found / (error * error);
    let affordable = f64::from(TRIAL_SPP) * seconds / spent.max(1e-6);
    // A power of two, so that the number does not hang on a fraction of a second.
    let spp = (wanted.min(affordable).max(1.0) as u32).clamp(1, SPP.1).next_power_of_two();
    let spp = if f64::from(spp) > affordable { spp / 2 } else { spp }.clamp(SPP.0, SPP.1);
    let picture = film::render(world, &integrator, Budget::Samples(spp), seed, progress);
    let folder = path.parent().context("a reference lies in a folder")?;
    if let Err(e) = std::fs::create_dir_all(folder) {
        bail!("{}: {e}", folder.display());
    }
    write_picture(path, &picture, &Look::default())?;
    Ok(())
}

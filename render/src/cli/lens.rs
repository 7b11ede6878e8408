//! Depth of field: the lens of the camera, from the scene and from the command line.

use anyhow::{Result, bail};
use glam::Vec2;
use kit::number::number;
use render::camera::RayGenerator;
use render::scene::{Camera, Lens, Projection};
use render::world::{Queries, World};

/// Options of depth of field.
#[derive(Debug, clap::Args)]
pub struct Optics {
    /// Radius of the lens in scene units: what is not at the distance of --focus is blurred, the more the larger it is; 0 makes
    /// everything sharp.
    ///
    /// A camera of focal length F and f-number N has F / (2 N): 50 mm at f/2.8 is 0.0089 where scenes are in metres
    /// [default: that of a `thinlens`, else 0].
    #[arg(long, value_name = "RADIUS", value_parser = number(0.0..=f32::MAX, "a number ≥ 0"))]
    aperture: Option<f32>,
    /// Distance of what is sharp, from the camera along the middle of the view [default: that of a `thinlens`; with --aperture
    /// on another camera, of what the middle of the picture shows].
    #[arg(long, value_name = "DISTANCE", value_parser = number(f32::MIN_POSITIVE..=f32::MAX, "a number > 0"))]
    focus: Option<f32>,
}

impl Optics {
    /// Refuses options that a camera cannot use; tells whether it will have a lens.
    ///
    /// # Errors
    /// One line with the option.
    pub fn check(&self, camera: &Camera) -> Result<bool> {
        let option = if self.aperture.is_some() { "--aperture" } else { "--focus" };
        if self.aperture.is_none() && self.focus.is_none() {
            return Ok(camera.lens.is_some());
        }
        if !matches!(camera.projection, Projection::Perspective { .. }) {
            bail!("{option} needs a perspective camera: an orthographic one has no lens");
        }
        let radius = self.aperture.or(camera.lens.map(|lens| lens.radius));
        let lens = radius.is_some_and(|radius| radius > 0.0);
        if self.focus.is_some() && !lens {
            bail!("--focus needs an --aperture > 0: the camera sees everything sharp");
        }
        Ok(lens)
    }

    /// Gives the camera of a world its lens; returns the distance where it had to be found.
    ///
    /// # Errors
    /// Nothing in the middle to focus on; a lens that is too wide.
    pub fn apply(&self, world: &mut World) -> Result<Option<f32>> {
        let old = world.scene.camera.lens;
        let Some(radius) = self.aperture.or(old.map(|lens| lens.radius)).filter(|radius| *radius > 0.0) else {
            world.scene.camera.lens = None;
            return Ok(None);
        };
        let (focus, found) = match self.focus.or(old.map(|lens| lens.focus)) {
            Some(focus) => (focus, None),
            None => {
                let Some(depth) = depth_of_middle(world) else {
                    bail!("--aperture needs --focus: the middle of the picture shows no surface to focus on");
                };
                (depth, Some(depth))
            }
        };
        let Some(lens) = Lens::new(radius, focus) else {
            bail!("a lens of radius {radius} cannot be focused at {focus}");
        };
        world.scene.camera.lens = Some(lens);
        Ok(found)
    }
}

/// Depth of the surface in the middle of the film.
fn depth_of_middle(world: &World) -> Option<f32> {
    let camera = &world.scene.camera;
    let generator = RayGenerator::new(camera);
    let ray = generator.ray(camera.film.width / 2, camera.film.height / 2, Vec2::splat(0.5));
    let hit = Queries::default().intersect(world, &ray);
    hit.exists().then(|| generator.depth(ray.origin + ray.direction * hit.t))
}

//! Drawing a frame.

use crate::film;
use crate::integrator::PathTracer;
use crate::integrator::cached::{Caches, Rendering};
use crate::outlines::{self, Of};
use crate::picture::{Budget, Picture};
use crate::scene::Camera;
use crate::world::World;
use std::time::Instant;

/// What frames are drawn from.
pub enum Source<'a> {
    /// Path tracing.
    Traced {
        /// Seed of all sample points.
        seed: u64,
        /// Whether light that is scattered less than twice is left out.
        indirect_only: bool,
    },
    /// Caches that were filled for τ.
    Cached {
        /// How pictures are rendered.
        rendering: &'a Rendering<'a>,
        /// τ.
        tolerance: f32,
        /// The records.
        caches: &'a Caches,
    },
}

impl Source<'_> {
    /// Draws what the camera of a frame sees, within the budget, `denoised`: for a denoiser. Each frame has sample points of its own: noise that stood still on
    /// the film would look like dirt on the lens.
    pub fn draw(
        &self,
        world: &mut World,
        (frame, camera): (u32, &Camera),
        (budget, denoised): (Budget, bool),
        progress: &(dyn Fn(f64) + Sync),
    ) -> Picture {
        world.scene.camera.clone_from(camera);
        let (mut picture, seed, indirect_only) = match *self {
            Self::Traced { seed, indirect_only } => {
                let integrator = PathTracer { settings: world.scene.integrator, indirect_only };
                let seed = seed_of(seed, frame);
                (film::render(world, &integrator, budget, seed, progress), seed, indirect_only)
            }
            Self::Cached { rendering, tolerance, caches } => {
                let seed = seed_of(rendering.settings.seed, frame);
                let (picture, _) = rendering.shade(world, tolerance, caches, (budget, seed), Instant::now(), progress);
                (picture, seed, rendering.settings.indirect_only)
            }
        };
        let of = Of { emission: !indirect_only, guides: denoised };
        outlines::refine((world, camera), &mut picture, (seed, indirect_only), of);
        picture
    }
}

/// The seed of a frame.
pub(super) fn seed_of(seed: u64, frame: u32) -> u64 {
    seed.wrapping_add(u64::from(frame).wrapping_mul(0x9e37_79b9_7f4a_7c15))
}

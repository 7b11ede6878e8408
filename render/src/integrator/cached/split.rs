//! The lights, divided between records and pixels.

use crate::light::Lights;
use crate::scene::Environment;
use crate::world::World;

/// The lights of a world, divided between records and pixels.
#[derive(Clone, Debug)]
pub struct LightSplit {
    /// What records hold: the dim part of the environment.
    pub held: Option<Environment>,
    /// All other lights, for the direct light of cached surfaces.
    pub rest: Lights,
}

impl LightSplit {
    /// Divides the lights; with `indirect_only` records hold none.
    pub fn new(world: &World, indirect_only: bool) -> Self {
        match &world.scene.environment {
            Some(environment) if !indirect_only => {
                let (held, rest) = environment.split();
                Self { held: Some(held), rest: world.lights.with_environment(rest) }
            }
            _ => Self { held: None, rest: world.lights.clone() },
        }
    }
}

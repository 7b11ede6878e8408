//! The methods a chart knows. A new one is a line of [`METHODS`].

use super::setting::Setting;
use render::integrator::cached::policy::Allowed;
use render::record::eas::Estimator;

/// What renders.
#[derive(Clone, Copy, Debug)]
pub enum Engine {
    /// The path tracer.
    Traced,
    /// Caches: what they may hold at a setting.
    Cached(fn(Setting) -> Allowed, Estimator),
}

/// A way to render, with all but its settings.
#[derive(Clone, Copy, Debug)]
pub struct Method {
    /// As typed, and as written in the CSV.
    pub name: &'static str,
    /// For a reader, after the name.
    pub about: &'static str,
    /// What renders.
    pub engine: Engine,
    /// Whether it is this project's own.
    pub ours: bool,
    /// Whether a sweep runs it unasked.
    pub swept: bool,
}

/// All methods, in the order in which they are run and drawn.
pub const METHODS: &[Method] = &[
    Method { name: "path", about: "path tracing", engine: Engine::Traced, ours: false, swept: true },
    Method {
        name: "irradiance",
        about: "irradiance records on diffuse surfaces, path tracing of glossy ones",
        engine: Engine::Cached(|_| Allowed::Irradiance, Estimator::Improved),

        ours: false,
        swept: true,
    },
    Method {
        name: "eas-paper",
        about: "EAS moved and summed as published in 2015",
        engine: Engine::Cached(|_| Allowed::Eas, Estimator::Paper),
        ours: false,
        swept: true,
    },
    Method {
        name: "eas",
        about: "EAS with our estimator",
        engine: Engine::Cached(|_| Allowed::Eas, Estimator::Improved),
        ours: true,
        swept: true,
    },
    Method {
        name: "auto",
        about: "our EAS where they pay, irradiance records on diffuse surfaces, path tracing for the rest",
        engine: Engine::Cached(|_| Allowed::Auto, Estimator::Improved),
        ours: true,
        swept: false,
    },
];

/// The method of a name.
pub fn find(name: &str) -> Option<&'static Method> {
    METHODS.iter().find(|m| m.name == name)
}

//! How `render image` renders.

use clap::ValueEnum;
use clap::builder::PossibleValue;
use render::integrator::cached::kinds::KINDS;
use render::integrator::cached::policy::Allowed;
use render::record::eas::Estimator;
use std::sync::LazyLock;

/// How to render.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Method {
    /// What pays.
    Auto,
    /// Path tracing: the reference.
    Path,
    /// Glossy records of the kind of this name.
    Kind(&'static str),
    /// Irradiance records on diffuse surfaces, path tracing of glossy ones.
    Irradiance,
}

/// All methods, in the order of the help.
static METHODS: LazyLock<Vec<Method>> = LazyLock::new(|| {
    let kinds = KINDS.iter().map(|kind| Method::Kind(kind.name));
    [Method::Auto, Method::Path].into_iter().chain(kinds).chain([Method::Irradiance]).collect()
});

impl Method {
    /// As typed.
    pub fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::Path => "path",
            Self::Kind(name) => name,
            Self::Irradiance => "irradiance",
        }
    }

    fn about(self) -> &'static str {
        match self {
            Self::Auto => {
                "EAS where they pay, irradiance records on diffuse surfaces, path tracing for the rest; path tracing alone for one \
                 picture with --time that Open Image Denoise denoises"
            }
            Self::Path => "Path tracing: the reference",
            Self::Kind(name) => KINDS.iter().find(|kind| kind.name == name).map_or("", |kind| kind.about),
            Self::Irradiance => "Irradiance records on diffuse surfaces, path tracing of glossy ones",
        }
    }

    /// What caches may hold at the tolerance τ, by the defaults of the kinds; `None` without caches.
    pub fn allowed(self, tolerance: f32) -> Option<Allowed> {
        match self {
            Self::Path => None,
            Self::Auto => Some(Allowed::Auto),
            Self::Irradiance => Some(Allowed::Irradiance),
            Self::Kind(name) => KINDS.iter().find(|kind| kind.name == name).map(|kind| (kind.alone)(tolerance)),
        }
    }

    /// Whether it is that of a kind of this name.
    pub fn is_kind(self, name: &str) -> bool {
        matches!(self, Self::Kind(own) if own == name)
    }
}

impl ValueEnum for Method {
    fn value_variants<'a>() -> &'a [Self] {
        &METHODS
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        Some(PossibleValue::new(self.name()).help(self.about()))
    }
}

/// What decides how far records reach.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum Reach {
    /// The distance of what they see.
    Distance,
    /// The curvature of the light.
    Hessian,
}

impl Reach {
    /// What suits an estimator, unless another is asked for.
    pub fn of(estimator: Estimator) -> Self {
        match estimator {
            Estimator::Paper => Self::Distance,
            Estimator::Improved => Self::Hessian,
        }
    }
}

//! How `render image` renders.

use render::record::eas::Estimator;

/// How to render.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum Method {
    /// EAS where they pay, irradiance records on diffuse surfaces, path tracing for the rest.
    Auto,
    /// Path tracing: the reference.
    Path,
    /// EAS on every glossy surface that a table can hold.
    Eas,
    /// Radiance caching with harmonics on every glossy surface that they can hold, irradiance records on diffuse ones.
    Sh,
    /// Irradiance records on diffuse surfaces, path tracing of glossy ones.
    Irradiance,
}

impl Method {
    /// As typed.
    pub fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::Path => "path",
            Self::Eas => "eas",
            Self::Sh => "sh",
            Self::Irradiance => "irradiance",
        }
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

//! The methods a chart knows. A new one is a line of [`METHODS`].

use super::setting::Setting;
use render::cache::{Spacing, WEBER_FRACTION};
use render::integrator::cached::TOLERANCE;
use render::integrator::cached::policy::Allowed;
use render::record::eas::Estimator;
use render::record::harmonics::{Basis, Gradients, HarmonicsSettings, OrderChoice};

/// What renders.
#[derive(Clone, Copy, Debug)]
pub enum Engine {
    /// The path tracer.
    Traced,
    /// Caches: what they may hold at a setting, how sources are summed, how far records reach.
    Cached(fn(Setting) -> Allowed, Estimator, Spacing),
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
        engine: Engine::Cached(|_| Allowed::Irradiance, Estimator::Improved, CURVATURE),
        ours: false,
        swept: true,
    },
    Method {
        name: "sh",
        about: "harmonics of the order that a view needs, path tracing of views that no order holds",
        engine: Engine::Cached(|setting| harmonics(setting, None), Estimator::Improved, CURVATURE),
        ours: false,
        swept: true,
    },
    Method {
        name: "sh-29",
        about: "harmonics of order 29 everywhere, whatever they lose",
        engine: Engine::Cached(|setting| harmonics(setting, Some(29)), Estimator::Improved, CURVATURE),
        ours: false,
        swept: false,
    },
    Method {
        name: "eas-paper",
        about: "EAS moved and summed as published in 2015",
        engine: Engine::Cached(|_| Allowed::Eas, Estimator::Paper, Spacing::DISTANCE),
        ours: false,
        swept: true,
    },
    Method {
        name: "eas",
        about: "EAS with our estimator",
        engine: Engine::Cached(|_| Allowed::Eas, Estimator::Improved, CURVATURE),
        ours: true,
        swept: true,
    },
    Method {
        name: "auto",
        about: "our EAS where they pay, irradiance records on diffuse surfaces, path tracing for the rest",
        engine: Engine::Cached(|_| Allowed::Auto, Estimator::Improved, CURVATURE),
        ours: true,
        swept: false,
    },
    Method {
        name: "irradiance-distance",
        about: "irradiance, radii by distance",
        engine: Engine::Cached(|_| Allowed::Irradiance, Estimator::Improved, Spacing::DISTANCE),
        ours: false,
        swept: false,
    },
    Method {
        name: "sh-adaptive",
        about: "sh, records that disagree shrink",
        engine: Engine::Cached(|setting| harmonics(setting, None), Estimator::Improved, ADAPTIVE),
        ours: false,
        swept: false,
    },
    Method {
        name: "eas-distance",
        about: "eas, radii by distance",
        engine: Engine::Cached(|_| Allowed::Eas, Estimator::Improved, Spacing::DISTANCE),
        ours: true,
        swept: false,
    },
    Method {
        name: "eas-adaptive",
        about: "eas, records that disagree shrink",
        engine: Engine::Cached(|_| Allowed::Eas, Estimator::Improved, ADAPTIVE),
        ours: true,
        swept: false,
    },
];

/// Radii by curvature; less where records differ by more than the eye lets pass.
const CURVATURE: Spacing = Spacing { hessian: true, adaptive: None };
const ADAPTIVE: Spacing = Spacing { hessian: true, adaptive: Some(WEBER_FRACTION) };

/// Hemispherical harmonics with analytic gradients, their order from τ unless it is given.
fn harmonics(setting: Setting, order: Option<usize>) -> Allowed {
    let tolerance = setting.tau().unwrap_or(TOLERANCE);
    let order = if let Setting::Order(order, _) = setting { Some(order.into()) } else { order };
    Allowed::Harmonics(HarmonicsSettings::new(Basis::default(), Gradients::default(), tolerance, order))
}

/// What the size of a glossy record is counted in, where a sweep may choose it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Size {
    /// Bands of harmonics.
    Order,
    /// EAS.
    Sources,
}

impl Method {
    /// How large its records are is counted in this; `None` for methods without such records, or with fixed ones.
    pub fn size(&self) -> Option<Size> {
        let Engine::Cached(allowed, ..) = self.engine else { return None };
        match allowed(Setting::Tau(TOLERANCE)) {
            Allowed::Harmonics(HarmonicsSettings { order: OrderChoice::Error(_), .. }) => Some(Size::Order),
            Allowed::Eas => Some(Size::Sources),
            _ => None,
        }
    }
}

/// The method of a name.
pub fn find(name: &str) -> Option<&'static Method> {
    METHODS.iter().find(|m| m.name == name)
}

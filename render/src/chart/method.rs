//! The methods a chart knows. A new kind of record is one by itself; others are a line of [`NAMED`].

use super::setting::Setting;
use core::convert::Infallible;
use render::cache::{Spacing, WEBER_FRACTION};
use render::integrator::cached::TOLERANCE;
use render::integrator::cached::kinds::{self, EachKind, Eas, Listed};
use render::integrator::cached::policy::Allowed;
use render::record::eas::Estimator;
use render::record::harmonics::{Basis, Gradients, HarmonicsSettings};
use std::sync::LazyLock;

/// What renders.
#[derive(Clone, Copy, Debug)]
pub enum Engine {
    /// The path tracer.
    Traced,
    /// Caches: what they may hold at a setting, how sources are summed, how far records reach.
    Cached(fn(Setting) -> Allowed, Estimator, Spacing),
}

/// What the size of a glossy record is counted in, where a sweep may choose it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Size {
    /// Bands of harmonics.
    Order,
    /// EAS.
    Sources,
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
    /// How large its records are is counted in this; `None` for methods without such records, or with fixed ones.
    pub size: Option<Size>,
    /// Whether it is this project's own.
    pub ours: bool,
    /// Whether a sweep runs it unasked.
    pub swept: bool,
    /// Whether its pictures are denoised.
    pub denoised: bool,
}

/// All methods, in the order in which they are run and drawn: those below, and every kind of record that has none of its name; each
/// followed by its denoised twin.
pub static METHODS: LazyLock<Vec<Method>> = LazyLock::new(|| {
    let mut methods = NAMED.to_vec();
    let Ok(()) = kinds::each(&mut Rest(&mut methods));
    methods.into_iter().flat_map(|method| [method, method.twin()]).collect()
});

/// Adds kinds that have no method of their name.
struct Rest<'a>(&'a mut Vec<Method>);

impl EachKind for Rest<'_> {
    type Error = Infallible;

    fn run<K: Listed>(&mut self) -> Result<(), Infallible> {
        if self.0.iter().all(|m| m.name != K::NAME) {
            self.0.push(Method::new(K::NAME, K::ABOUT, Engine::Cached(alone::<K>, Estimator::Improved, CURVATURE)));
        }
        Ok(())
    }
}

/// A kind with its own defaults.
fn alone<K: Listed>(setting: Setting) -> Allowed {
    K::alone(setting.tau().unwrap_or(TOLERANCE))
}

const NAMED: &[Method] = &[
    Method { swept: true, ..Method::new("path", "path tracing", Engine::Traced) },
    Method {
        swept: true,
        ..Method::new(
            "irradiance",
            "irradiance records on diffuse surfaces, path tracing of glossy ones",
            Engine::Cached(|_| Allowed::Irradiance, Estimator::Improved, CURVATURE),
        )
    },
    Method {
        swept: true,
        ..Method::harmonics(
            "sh",
            "harmonics of the order that a view needs, path tracing of views that no order holds",
            CURVATURE,
        )
    },
    Method::new(
        "sh-29",
        "harmonics of order 29 everywhere, whatever they lose",
        Engine::Cached(|setting| harmonics(setting, Some(29)), Estimator::Improved, CURVATURE),
    ),
    Method {
        swept: true,
        ..Method::eas("eas-paper", "EAS moved and summed as published in 2015", Estimator::Paper, Spacing::DISTANCE)
    },
    Method { ours: true, swept: true, ..Method::eas("eas", "EAS with our estimator", Estimator::Improved, CURVATURE) },
    Method {
        ours: true,
        ..Method::new(
            "auto",
            "our EAS where they pay, irradiance records on diffuse surfaces, path tracing for the rest",
            Engine::Cached(|_| Allowed::Auto, Estimator::Improved, CURVATURE),
        )
    },
    Method::new(
        "irradiance-distance",
        "irradiance, radii by distance",
        Engine::Cached(|_| Allowed::Irradiance, Estimator::Improved, Spacing::DISTANCE),
    ),
    Method::harmonics("sh-adaptive", "sh, records that disagree shrink", ADAPTIVE),
    Method {
        ours: true,
        ..Method::eas("eas-distance", "eas, radii by distance", Estimator::Improved, Spacing::DISTANCE)
    },
    Method {
        ours: true,
        ..Method::eas("eas-adaptive", "eas, records that disagree shrink", Estimator::Improved, ADAPTIVE)
    },
];

impl Method {
    /// Neither ours nor run unasked, of no size that a sweep may choose.
    const fn new(name: &'static str, about: &'static str, engine: Engine) -> Self {
        Self { name, about, engine, size: None, ours: false, swept: false, denoised: false }
    }

    /// The same, its pictures denoised. Made once, for the list.
    fn twin(self) -> Self {
        let [name, about] = [format!("{}-denoised", self.name), format!("{}; denoised", self.about)];
        Self { name: name.leak(), about: about.leak(), size: None, denoised: true, ..self }
    }

    /// Harmonics of the order that τ asks for.
    const fn harmonics(name: &'static str, about: &'static str, spacing: Spacing) -> Self {
        let engine = Engine::Cached(|setting| harmonics(setting, None), Estimator::Improved, spacing);
        Self { size: Some(Size::Order), ..Self::new(name, about, engine) }
    }

    /// EAS on every glossy surface.
    const fn eas(name: &'static str, about: &'static str, estimator: Estimator, spacing: Spacing) -> Self {
        let engine = Engine::Cached(alone::<Eas>, estimator, spacing);
        Self { size: Some(Size::Sources), ..Self::new(name, about, engine) }
    }
}

/// Radii by curvature; less where records differ by more than the eye lets pass.
const CURVATURE: Spacing = Spacing { hessian: true, adaptive: None };
const ADAPTIVE: Spacing = Spacing { hessian: true, adaptive: Some(WEBER_FRACTION) };

/// Hemispherical harmonics with analytic gradients, their order from τ unless it is given.
fn harmonics(setting: Setting, order: Option<usize>) -> Allowed {
    let tolerance = setting.tau().unwrap_or(TOLERANCE);
    let order = if let Setting::Order(order, _) = setting { Some(order.into()) } else { order };
    Allowed::Harmonics(HarmonicsSettings::new(Basis::default(), Gradients::default(), tolerance, order))
}

/// The method of a name.
pub fn find(name: &str) -> Option<&'static Method> {
    METHODS.iter().find(|m| m.name == name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kind_has_a_method_and_every_method_a_name() {
        for kind in kinds::KINDS {
            assert!(find(kind.name).is_some(), "{}", kind.name);
        }
        for (i, method) in METHODS.iter().enumerate() {
            assert!(METHODS[..i].iter().all(|other| other.name != method.name), "{}", method.name);
        }
    }
}

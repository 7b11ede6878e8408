//! Which materials are cached with harmonics: those of which they lose little enough in some view.

use super::Harmonics;
use crate::record::harmonics::{HarmonicBrdf, OrderChoice};
use brdf_tables::brdf::Specular;
use serde::Serialize;

/// A material held; directions that no order holds are path traced.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Held {
    /// Index into [`Harmonics::brdfs`].
    pub brdf: usize,
}

impl Harmonics {
    /// Whether harmonics hold a specular part, and for which views.
    pub(super) fn wanted(&mut self, specular: Specular) -> (Option<Held>, String) {
        let Some(settings) = self.projection else { return (None, "path traced".into()) };
        let known = self.brdfs.iter().position(|b| b.specular == specular);
        let brdf = known.unwrap_or_else(|| {
            self.brdfs.push(HarmonicBrdf::new(specular, settings.basis, settings.order));
            self.brdfs.len() - 1
        });
        let found = self.brdfs[brdf].summary();
        let percent = |x: f32| format!("{:.2} %", 100.0 * x);
        let note = match settings.order {
            OrderChoice::Fixed(order) => {
                format!("cached with harmonics of order {order}, which lose up to {}", percent(found.error))
            }
            OrderChoice::Error(_) if found.traced >= 1.0 => {
                format!("path traced (harmonics of order {} lose {} or more)", found.orders.0, percent(found.best))
            }
            OrderChoice::Error(error) => {
                let (low, high) = found.orders;
                let traced = if found.traced > 0.0 {
                    format!("; {:.0} % of the views path traced", 100.0 * found.traced)
                } else {
                    String::new()
                };
                format!("cached with harmonics of order {low} to {high}, which lose at most {}{traced}", percent(error))
            }
        };
        ((found.traced < 1.0).then_some(Held { brdf }), note)
    }
}

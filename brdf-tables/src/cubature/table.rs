//! The cubature as a table: the rule per cell of (θe, φe, Ω), chosen by the fitter as the cheapest that meets
//! the tolerance there.

use super::bins::Bins;
use super::lookup::{View, integrals, into_frame, lookup};
use super::rule::{NONE, Nodes, RULES, Rule};
use super::spread::numbers;
use super::{Node, Side, holds_pole, numerator};
use crate::axis::Axes;
use crate::batch::{CapBatch, MIN_HEIGHT};
use crate::brdf::{Brdf, Formula, FormulaVisitor, Fresnel, GrayPolynomial, Microfacet, Specular, Visitor};
use crate::cap::Cap;
use crate::mean::MeanBrdf;
use crate::parts::PartsError;
use fearless_simd::{Level, dispatch};
use glam::{DVec3, Vec3};
use std::sync::Arc;

/// Cap cubature of the model itself.
#[derive(Clone, Debug, PartialEq)]
pub struct Cubature {
    pub(super) specular: Specular,
    gray: Option<GrayPolynomial>,
    pub(super) isotropic: bool,
    axes: Axes,
    nodes: Arc<[Node]>,
    pub(super) bins: Bins,
}

impl Cubature {
    /// From the nodes of `axes`.
    ///
    /// # Errors
    /// The index of a rule or the count is wrong.
    pub fn new(specular: Specular, axes: Axes, nodes: &[Node]) -> Result<Self, PartsError> {
        Ok(Self::with_bins(specular, axes, nodes.into(), Bins::new(axes, nodes)?))
    }

    /// From nodes and the bins made of them.
    pub(crate) fn with_bins(specular: Specular, axes: Axes, nodes: Arc<[Node]>, bins: Bins) -> Self {
        let (gray, isotropic) = (specular.gray_polynomial(), specular.is_isotropic());
        Self { specular, gray, isotropic, axes, nodes, bins }
    }

    /// Grid and nodes, as [`Cubature::new`] takes them.
    pub fn parts(&self) -> (Axes, &[Node]) {
        (self.axes, &self.nodes)
    }

    /// Which rule each cap takes.
    #[cfg(feature = "wgsl")]
    pub(crate) fn bins(&self) -> &Bins {
        &self.bins
    }

    /// One rule of [`RULES`] everywhere.
    ///
    /// # Panics
    /// If the rule is not in that list.
    pub fn uniform(specular: Specular, rule: Rule) -> Self {
        let axes = Axes { theta: 2, phi: 1, omega: 2, sharpness: 1.0, stretch: 1.0 };
        let (disc, product) = match rule {
            Rule::Disc(_) => (rule.index(), RULES.len() as u8 - 1),
            Rule::Product(_) => (NONE, rule.index()),
        };
        let node = Node { disc, product, outer: u8::MAX, far: u8::MAX };
        Self::with_bins(specular, axes, [node; 4].into(), Bins::uniform(node))
    }

    /// [`MeanBrdf::values`] of facets of the same shape with another reflectance: the rules are of the shape.
    pub(crate) fn values_with(&self, fresnel: Fresnel, caps: &CapBatch, wo: Vec3, out: &mut [f32]) {
        match self.specular {
            Specular::Microfacet(facets) => {
                let specular = Specular::Microfacet(Microfacet { fresnel, ..facets });
                self.look_up(&specular, specular.gray_polynomial().as_ref(), caps, wo, out);
            }
            _ => self.values(caps, wo, out),
        }
    }

    fn look_up(&self, specular: &Specular, gray: Option<&GrayPolynomial>, caps: &CapBatch, wo: Vec3, out: &mut [f32]) {
        struct Run<'a>(&'a Cubature, &'a CapBatch, DVec3, &'a mut [f32]);
        impl FormulaVisitor for Run<'_> {
            type Output = ();
            fn visit<M: Formula>(self, model: &M) {
                let Run(table, caps, wo, out) = self;
                dispatch!(Level::new(), simd => lookup(simd, table, model, caps, wo, out));
            }
        }
        let out = &mut out[..caps.len()];
        if wo.z <= 0.0 {
            return out.fill(0.0);
        }
        specular.visit_formula(gray, Run(self, caps, wo.as_dvec3(), out));
    }

    /// For a cap that crosses the horizon, the numerator of eq. 9 from the integral over the `whole` cap (in which cosθi is
    /// negative below the horizon), by subtracting the part below: small, so that few nodes do. The formula must hold below
    /// the horizon.
    pub(crate) fn clip_value(&self, cap: &Cap, wo: DVec3, whole: f64) -> f64 {
        struct Run<'a>(&'a Cubature, &'a Cap, DVec3, f64);
        impl Visitor for Run<'_> {
            type Output = f64;
            fn visit<M: Brdf + Formula>(self, model: &M) -> f64 {
                let Run(table, cap, wo, whole) = self;
                let (view, Nodes::Product(grid)) = (View::new(table, wo), &numbers(table.bins.finest()).exact) else {
                    return whole;
                };
                let (axis, height) = (into_frame(cap.axis().to_array(), view.rotation), cap.height());
                let part = numerator(model, &view.lobe, view.turn, axis, height, Side::Below, grid);
                if holds_pole(axis, height) { part } else { whole - part }
            }
        }
        self.specular.visit(Run(self, cap, wo, whole))
    }
}

impl MeanBrdf for Cubature {
    fn name(&self) -> &'static str {
        "cubature"
    }

    fn value(&self, cap: &Cap, wo: DVec3) -> f64 {
        struct Run<'a>(&'a Cubature, &'a Cap, DVec3);
        impl Visitor for Run<'_> {
            type Output = f64;
            fn visit<M: Brdf + Formula>(self, model: &M) -> f64 {
                let Run(table, cap, wo) = self;
                let view = View::new(table, wo);
                let rule = table.bins.of(cap.axis().as_vec3(), cap.height() as f32, wo.as_vec3());
                let (axis, height) = (cap.axis().to_array(), cap.height().max(f64::from(MIN_HEIGHT)));
                let (sum, area) = integrals(model, &view, Side::Above, axis, height, &numbers(usize::from(rule)).exact);
                sum.max(0.0) / area.max(1e-30)
            }
        }
        if wo.z <= 0.0 {
            return 0.0;
        }
        self.specular.visit(Run(self, cap, wo))
    }

    fn values(&self, caps: &CapBatch, wo: Vec3, out: &mut [f32]) {
        self.look_up(&self.specular, self.gray.as_ref(), caps, wo, out);
    }
}

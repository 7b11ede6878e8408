//! A fitted table: what it is for, how it was made, how good it is, and the means to look it up.

use crate::axis::Axes;
use crate::batch::CapBatch;
use crate::brdf::{Fresnel, Specular};
use crate::cap::Cap;
use crate::cubature::Cubature;
use crate::errors::{Errors, Summary};
use crate::lobes::Lobes;
use crate::material::Material;
use crate::mean::MeanBrdf;
use crate::paper::Paper;
use crate::zonal::Zonal;
use core::f64::consts::{FRAC_1_PI, PI};
use glam::{DVec3, Vec3};
use serde::{Deserialize, Serialize};

/// Provenance and promise of a table.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Header {
    /// The material the table is for.
    pub material: Material,
    /// Program and version that made it.
    pub creator: String,
    /// Command line that made it.
    pub command: String,
    /// Seed of every random choice.
    pub seed: u64,
    /// Tolerance asked of rmse_lobe.
    pub tolerance: f64,
    /// Largest rmse_lobe, median, 95th percentile and worst, that the table promises on caps of its main domain (radius up
    /// to 2.5 lobe widths, θe up to 84°).
    pub promise: [f64; 3],
    /// Why this representation was chosen, and what the solver reported, one line each.
    pub notes: Vec<String>,
    /// Errors at the nodes of the error grid that belong to the main domain.
    pub at_nodes: Summary,
    /// Errors at random caps of the main domain.
    pub off_nodes: Summary,
    /// Errors at random caps that cross the horizon by up to 0.9 of their radius.
    pub clipped: Summary,
}

/// How a table evaluates the mean BRDF of its specular part.
#[derive(Clone, Debug, PartialEq)]
pub enum Representation {
    /// No specular part: nothing to look up.
    Diffuse,
    /// Exact integrals of a radial lobe.
    Zonal(Zonal),
    /// Cap cubature of the model.
    Cubature(Cubature),
    /// Fitted lobes, blended in the mirror frame.
    Lobes(Lobes),
    /// Fitted lobes as published in 2015.
    Paper(Paper),
}

/// What the fitter measured at one node of the error grid.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CellInfo {
    /// Errors there.
    pub errors: Errors,
    /// Angle from the mirrored cap axis beyond which F stays below 1/1000 of its maximum, radian.
    pub support: f32,
}

/// A table of the mean BRDF of one material.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// Provenance and promise.
    pub header: Header,
    /// How the values are stored.
    pub representation: Representation,
    /// Grid of the per-cell measurements.
    pub axes: Axes,
    /// Measurement per node of `axes`; empty for a diffuse material.
    pub cells: Vec<CellInfo>,
}

impl Table {
    /// The specular model, if there is one.
    pub fn specular(&self) -> Option<&Specular> {
        self.header.material.specular.as_ref()
    }

    /// The look-up of the specular part at unit strength; `None` for a diffuse material.
    pub fn mean(&self) -> Option<&dyn MeanBrdf> {
        match &self.representation {
            Representation::Diffuse => None,
            Representation::Zonal(t) => Some(t),
            Representation::Cubature(t) => Some(t),
            Representation::Lobes(t) => Some(t),
            Representation::Paper(t) => Some(t),
        }
    }

    /// Short name of the representation.
    pub fn representation_name(&self) -> &'static str {
        self.mean().map_or("diffuse", MeanBrdf::name)
    }

    /// The whole mean BRDF, diffuse part and colours included, RGB in sr⁻¹. The Fresnel tint is taken at the cap's axis.
    pub fn value(&self, cap: &Cap, wo: DVec3) -> [f64; 3] {
        let material = &self.header.material;
        let diffuse = material.kd.map(|kd| kd * FRAC_1_PI);
        let (Some(mean), Some(model)) = (self.mean(), &material.specular) else { return diffuse };
        let (specular, tint) = (mean.value(cap, wo), model.tint(cap.axis(), wo));
        core::array::from_fn(|c| diffuse[c] + material.ks[c] * tint[c] * specular)
    }

    /// The specular part at unit strength for many caps, into `out[..caps.len()]`; zero for a diffuse material.
    ///
    /// # Panics
    /// If `out` is shorter than the batch.
    pub fn specular_values(&self, caps: &CapBatch, wo: Vec3, out: &mut [f32]) {
        match self.mean() {
            Some(mean) => mean.values(caps, wo, out),
            None => out[..caps.len()].fill(0.0),
        }
    }

    /// [`Table::specular_values`] as if the facets had another reflectance (grey: [`Fresnel::gray`]). Exactly so for cubature,
    /// which evaluates the model; for what is stored otherwise, the reflectance at the cap's axis replaces that of the table.
    /// Without effect for models that are not of facets.
    ///
    /// # Panics
    /// If `out` is shorter than the batch.
    pub fn values_with_fresnel(&self, fresnel: Fresnel, caps: &CapBatch, wo: Vec3, out: &mut [f32]) {
        let (mean, Some(Specular::Microfacet(facets))) = (&self.representation, self.specular()) else {
            return self.specular_values(caps, wo, out);
        };
        if let Representation::Cubature(table) = mean {
            return table.values_with(fresnel, caps, wo, out);
        }
        self.specular_values(caps, wo, out);
        for (i, value) in out[..caps.len()].iter_mut().enumerate() {
            let cos = (0.5 * (caps.get(i).0 + wo).length()).min(1.0);
            let own = facets.fresnel.gray(cos);
            *value *= if own > 0.0 { fresnel.gray(cos) / own } else { 0.0 };
        }
    }

    /// Angle in radian from the mirrored axis beyond which the specular part stays below about 1/1000 of its maximum: the
    /// largest over the cell of the cap. Zero for a diffuse material.
    pub fn support(&self, cap: &Cap) -> f64 {
        self.corners(cap).map(|i| f64::from(self.cells[i].support)).fold(0.0, f64::max).min(PI)
    }

    /// The largest errors over the cell of the cap, as the fitter measured them at its nodes.
    pub fn cell_errors(&self, cap: &Cap) -> Errors {
        let worst = self.corners(cap).map(|i| self.cells[i].errors.to_array());
        Errors::from_array(worst.fold([0.0; 5], |a, b| core::array::from_fn(|i| a[i].max(b[i]))))
    }

    /// The nodes around a cap.
    fn corners(&self, cap: &Cap) -> impl Iterator<Item = usize> + '_ {
        let axes = self.axes;
        let (t, p) = (axes.theta_place(cap.theta()).index, axes.phi_place(cap.phi()).index);
        let o = axes.omega_place(cap.solid_angle()).index;
        let corner = move |i: usize| {
            let clamp = |x: usize, n: u32| x.min(n as usize - 1);
            axes.index(
                clamp(t + (i >> 2 & 1), axes.theta),
                clamp(p + (i >> 1 & 1), axes.phi),
                clamp(o + (i & 1), axes.omega),
            )
        };
        (0..8).map(corner).filter(|&i| i < self.cells.len())
    }
}

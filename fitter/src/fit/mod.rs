//! From a material to a table.

mod cell;
pub(crate) mod cubature;
mod lobes;
mod paper;

use crate::check::{Sampling, random_caps};
use crate::error::Directions;
use crate::solver::SolverKind;
use crate::zonal;
use brdf_tables::axis::Axes;
use brdf_tables::brdf::Specular;
use brdf_tables::cap::Cap;
use brdf_tables::cubature::{Cubature, Rule};
use brdf_tables::errors::{Errors, Summary};
use brdf_tables::material::{Material, MaterialError};
use brdf_tables::mean::MeanBrdf;
use brdf_tables::table::{CellInfo, Header, Representation, Table};
use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;
use std::fmt;
use std::str::FromStr;

/// Which representation to fit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Choice {
    /// The cheapest that meets the tolerance.
    Auto,
    /// Exact integrals of a radial lobe.
    Zonal,
    /// Cap cubature of the model, its rule per cell.
    Cubature,
    /// Signed lobes blended in the mirror frame.
    Lobes,
    /// Positive lobes on the grid of 2015.
    Paper,
}

impl Choice {
    /// Every choice.
    pub const ALL: [Self; 5] = [Self::Auto, Self::Zonal, Self::Cubature, Self::Lobes, Self::Paper];

    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::Zonal => "zonal",
            Self::Cubature => "cubature",
            Self::Lobes => "lobes",
            Self::Paper => "paper",
        }
    }
}

impl fmt::Display for Choice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for Choice {
    type Err = String;
    fn from_str(name: &str) -> Result<Self, String> {
        let known = Self::ALL.map(Self::name).join(", ");
        Self::ALL
            .into_iter()
            .find(|c| c.name() == name)
            .ok_or(format!("unknown representation `{name}`, expected one of {known}"))
    }
}

/// How to fit.
pub struct Options<'a> {
    /// Which representation.
    pub representation: Choice,
    /// Optimiser of the lobe fits.
    pub solver: SolverKind,
    /// Lobes per cell; `None`: as few as the tolerance needs.
    pub lobes: Option<usize>,
    /// Tolerance on rmse_lobe, a fraction.
    pub tolerance: f64,
    /// Seed of every random choice.
    pub seed: u64,
    /// Command line to record.
    pub command: String,
    /// Told the fraction done, from any thread.
    pub progress: &'a (dyn Fn(f64) + Sync),
}

/// Default tolerance on rmse_lobe.
pub const TOLERANCE: f64 = 0.005;

/// Why there is no table.
#[derive(Debug, thiserror::Error)]
pub enum FitError {
    /// The material is not valid.
    #[error(transparent)]
    Material(#[from] MaterialError),
    /// A zonal table of a model that is not radial.
    #[error(
        "a zonal table needs a lobe that is radial about the mirror direction (phong, or one lafortune lobe with cx = cy = -cz)"
    )]
    NotRadial,
    /// The grid of 2015 has no azimuth.
    #[error("the paper's grid has no azimuth: it holds isotropic materials only")]
    Anisotropic,
    /// A solver ran off to numbers that no table holds.
    #[error("a fitted lobe is not finite or out of the bounds of a table; try another --solver or fewer --lobes")]
    Diverged,
    /// More lobes than a look-up takes at once.
    #[error("{0} lobes per cell, 1 to 16 are possible")]
    Lobes(usize),
    /// The tolerance is out of range.
    #[error("tolerance {0} is not between 1e-5 and 1")]
    Tolerance(f64),
}

/// A fitted representation, and lines about how it came to be.
struct Fitted {
    representation: Representation,
    notes: Vec<String>,
}

impl Fitted {
    fn mean(&self) -> &dyn MeanBrdf {
        match &self.representation {
            Representation::Zonal(t) => t,
            Representation::Cubature(t) => t,
            Representation::Lobes(t) => t,
            Representation::Paper(t) => t,
            Representation::Diffuse => unreachable!("a diffuse material is not fitted"),
        }
    }
}

/// Fits a material. The bytes of the result depend on the arguments only, not on the number of threads.
///
/// # Errors
/// If the material or an option is out of range, or the representation cannot hold the material.
pub fn fit(material: &Material, options: &Options) -> Result<Table, FitError> {
    material.validate()?;
    if !(1e-5..=1.0).contains(&options.tolerance) {
        return Err(FitError::Tolerance(options.tolerance));
    }
    if let Some(lobes) = options.lobes.filter(|k| !(1..=16).contains(k)) {
        return Err(FitError::Lobes(lobes));
    }
    let mut header = Header {
        material: *material,
        creator: concat!("fitter ", env!("CARGO_PKG_VERSION")).into(),
        command: options.command.clone(),
        seed: options.seed,
        tolerance: options.tolerance,
        promise: [options.tolerance, 2.5 * options.tolerance, 5.0 * options.tolerance],
        notes: Vec::new(),
        at_nodes: Summary::default(),
        off_nodes: Summary::default(),
        clipped: Summary::default(),
    };
    let Some(specular) = material.specular else {
        header.notes.push("diffuse: the mean BRDF is kd/π for every cap, nothing is fitted".into());
        let axes = Axes { theta: 2, phi: 1, omega: 2, sharpness: 1.0, stretch: 1.0 };
        return Ok(Table { header, representation: Representation::Diffuse, axes, cells: Vec::new() });
    };
    let fitted = represent(&specular, options)?;
    header.notes.extend(fitted.notes.iter().cloned());

    let oracle = oracle(specular);
    let axes = error_axes(&specular);
    let measured: Vec<(CellInfo, bool)> = (0..axes.len())
        .into_par_iter()
        .map(|i| {
            let (o, rest) = (i % axes.omega as usize, i / axes.omega as usize);
            let cap = axes.cap_at(rest / axes.phi as usize, rest % axes.phi as usize, o);
            let (errors, support) = measure(&oracle, fitted.mean(), &specular, &cap);
            let main = cap.half_angle() <= 2.5 * specular.lobe_width() && cap.theta() <= 84f64.to_radians();
            (CellInfo { errors, support: support as f32 }, main)
        })
        .collect();
    let main: Vec<Errors> = measured.iter().filter(|m| m.1).map(|m| m.0.errors).collect();
    header.at_nodes = Summary::new(&main);

    // Off the nodes: what the table promises.
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(options.seed);
    let mut off = |sampling| {
        let caps = random_caps(&specular, sampling, 100, &mut rng);
        let errors: Vec<Errors> =
            caps.par_iter().map(|cap| measure(&oracle, fitted.mean(), &specular, cap).0).collect();
        Summary::new(&errors)
    };
    (header.off_nodes, header.clipped) = (off(Sampling::Main), off(Sampling::Clipped));
    let found = [header.off_nodes.median, header.off_nodes.p95, header.off_nodes.worst];
    let mut missed = false;
    for (promise, found) in header.promise.iter_mut().zip(found) {
        // What was not reached is promised as measured, with room for the spread between samples.
        let needed = 1.5 * f64::from(found.rmse_lobe);
        missed |= f64::from(found.rmse_lobe) > *promise;
        *promise = promise.max(needed);
    }
    if missed {
        header.notes.push(format!("tolerance {} not reached: promises what was measured instead", options.tolerance));
    }
    (options.progress)(1.0);
    let cells = measured.into_iter().map(|m| m.0).collect();
    Ok(Table { header, representation: fitted.representation, axes, cells })
}

/// The representation asked for, or the cheapest that meets the tolerance: the zonal table where the lobe is radial, else
/// cubature, which takes two to three times as long for a value (`cargo bench -p brdf-tables`) and fits every model. Lobes
/// cost as much as cubature of equal error at best (`fitter chart` draws it), so they are fitted on demand.
fn represent(specular: &Specular, options: &Options) -> Result<Fitted, FitError> {
    match options.representation {
        Choice::Auto if specular.radial_exponent().is_some() => {
            let mut fitted = zonal(specular, options).ok_or(FitError::NotRadial)?;
            fitted.notes.insert(
                0,
                "zonal: the lobe is radial about the mirror direction, so its mean is two functions of two \
                angles: exact, and the cheapest look-up"
                    .into(),
            );
            Ok(fitted)
        }
        Choice::Zonal => zonal(specular, options).ok_or(FitError::NotRadial),
        Choice::Auto => {
            let mut fitted = cubature::fit(specular, options);
            fitted
                .notes
                .insert(0, "cubature: the lobe is not radial, and lobes of equal error cost more per value".into());
            Ok(fitted)
        }
        Choice::Cubature => Ok(cubature::fit(specular, options)),
        Choice::Lobes => lobes::fit(specular, options),
        Choice::Paper if !specular.is_isotropic() => Err(FitError::Anisotropic),
        Choice::Paper => paper::fit(specular, options),
    }
}

/// The smallest zonal table of a few sizes that meets the tolerance off its nodes.
fn zonal(specular: &Specular, options: &Options) -> Option<Fitted> {
    let oracle = oracle(*specular);
    let caps = random_caps(specular, Sampling::Main, 60, &mut Xoshiro256PlusPlus::seed_from_u64(options.seed ^ 1));
    let mut last = None;
    for (rows, columns) in [(24, 16), (32, 24), (48, 32), (64, 48)] {
        let table = zonal::build(*specular, rows, columns)?;
        let errors: Vec<Errors> = caps.par_iter().map(|cap| measure(&oracle, &table, specular, cap).0).collect();
        let summary = Summary::new(&errors);
        let note = format!("{rows} × {columns} pairs of (T_P, T_R), 16 bits each");
        last = Some(Fitted { representation: Representation::Zonal(table), notes: vec![note] });
        // The tail and the energy are held to the same tolerance: bilinear errors are small but of one sign.
        let within = |error: f32, bound: f64| f64::from(error) <= bound * options.tolerance;
        let worst = summary.worst;
        if within(worst.rmse_lobe, 0.3) && within(worst.albedo, 0.6) && within(worst.l1, 1.2) {
            break;
        }
    }
    last
}

/// The reference used while fitting: cubature by the finest rule, which agrees with independent quadrature to better
/// than 1e-3 of the peak everywhere (tested) at a hundredth of its cost. `check` uses the independent one.
pub(crate) fn oracle(specular: Specular) -> Cubature {
    Cubature::uniform(specular, Rule::Product(16))
}

/// Grid of the per-cell measurements.
fn error_axes(specular: &Specular) -> Axes {
    let phi = if specular.is_isotropic() { 1 } else { 5 };
    Axes { theta: 10, phi, omega: 10, sharpness: specular.lobe_width().powi(-2), stretch: 0.5 }
}

/// Values of F over the directions.
fn values(mean: &dyn MeanBrdf, cap: &Cap, directions: &Directions) -> Vec<f64> {
    directions.wo.iter().map(|&wo| mean.value(cap, wo)).collect()
}

/// Errors and support angle for one cap.
fn measure(oracle: &Cubature, mean: &dyn MeanBrdf, specular: &Specular, cap: &Cap) -> (Errors, f64) {
    let directions = Directions::new(specular, cap);
    let exact = values(oracle, cap, &directions);
    let errors = directions.errors(&exact, &values(mean, cap, &directions));
    (errors, directions.support(cap, &exact))
}

#[cfg(test)]
mod tests {
    use super::*;
    use brdf_tables::brdf::{Phong, Ward, WardVariant};
    use std::sync::Mutex;

    fn attempt(
        specular: Specular,
        representation: Choice,
        tolerance: f64,
        lobes: Option<usize>,
    ) -> Result<Table, FitError> {
        let (solver, command) = (SolverKind::LevenbergMarquardt, String::new());
        let options = Options { representation, solver, lobes, tolerance, seed: 1, command, progress: &|_| () };
        super::fit(&Material::specular(specular), &options)
    }

    #[test]
    fn names_parse_back() {
        for choice in Choice::ALL {
            assert_eq!(choice.name().parse(), Ok(choice));
        }
        assert!("lobe".parse::<Choice>().unwrap_err().contains("zonal"));
    }

    #[test]
    fn what_cannot_be_fitted_is_refused() {
        let phong = Specular::Phong(Phong { exponent: 10.0 });
        let ward = Specular::Ward(Ward { alpha_x: 0.1, alpha_y: 0.5, variant: WardVariant::Ward1992 });
        for tolerance in [0.0, -1.0, 2.0, f64::NAN] {
            assert!(matches!(attempt(phong, Choice::Auto, tolerance, None), Err(FitError::Tolerance(_))));
        }
        for lobes in [0, 17] {
            assert!(matches!(attempt(phong, Choice::Lobes, 0.01, Some(lobes)), Err(FitError::Lobes(_))));
        }
        assert!(matches!(attempt(ward, Choice::Zonal, 0.01, None), Err(FitError::NotRadial)));
        assert!(matches!(attempt(ward, Choice::Paper, 0.01, None), Err(FitError::Anisotropic)));
        let broken = Specular::Phong(Phong { exponent: f64::NAN });
        assert!(matches!(attempt(broken, Choice::Auto, 0.01, None), Err(FitError::Material(_))));
    }

    /// The choice and its reason are in the notes, the promise holds what was measured, progress ends at 1.
    #[test]
    fn tables_state_what_they_are() {
        let done = Mutex::new(Vec::new());
        let options = Options {
            representation: Choice::Auto,
            solver: SolverKind::LevenbergMarquardt,
            lobes: None,
            tolerance: 1e-5,
            seed: 9,
            command: "a command".into(),
            progress: &|x| done.lock().unwrap().push(x),
        };
        let table = super::fit(&Material::specular(Specular::Phong(Phong { exponent: 10.0 })), &options).unwrap();
        let h = &table.header;
        assert_eq!((h.seed, h.command.as_str(), table.representation_name()), (9, "a command", "zonal"));
        assert!(h.notes[0].starts_with("zonal: the lobe is radial"), "{:?}", h.notes);
        // Sixteen bits do not reach 1e-5.
        assert!(h.notes.iter().any(|n| n.contains("not reached")), "{:?}", h.notes);
        assert!(h.promise[2] >= f64::from(h.off_nodes.worst.rmse_lobe) && h.promise[2] < 0.01, "{:?}", h.promise);
        assert!(h.off_nodes.caps > 50 && h.clipped.caps > 50 && h.at_nodes.caps > 5);
        assert_eq!(table.cells.len(), table.axes.len());
        let done = done.into_inner().unwrap();
        assert!(done.iter().all(|x| (0.0..=1.0).contains(x)) && done.last() == Some(&1.0));
    }
}

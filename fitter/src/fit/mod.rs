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
use std::ops::ControlFlow;
use std::str::FromStr;
use std::sync::atomic::{AtomicUsize, Ordering};

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
    /// What is fitted: what was `asked` for, else [`Choice::Auto`], or lobes where an option is set that only fits of lobes
    /// use; `lobe_option` is its name.
    ///
    /// # Errors
    /// The option has no use, or the material has nothing to fit.
    pub fn of(material: &Material, asked: Option<Self>, lobe_option: Option<&'static str>) -> Result<Self, FitError> {
        let choice = asked.unwrap_or(if lobe_option.is_some() { Self::Lobes } else { Self::Auto });
        match (lobe_option, choice) {
            (Some(option), Self::Auto | Self::Zonal | Self::Cubature) => Err(FitError::NoLobes { option, choice }),
            _ if material.specular.is_none() && choice != Self::Auto => Err(FitError::Diffuse(choice)),
            _ => Ok(choice),
        }
    }

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
    /// Told the fraction done, from any thread; where it breaks, the fit stops.
    pub progress: &'a (dyn Fn(f64) -> ControlFlow<()> + Sync),
}

impl Options<'_> {
    /// Tells the fraction done.
    fn tell(&self, fraction: f64) -> Result<(), FitError> {
        match (self.progress)(fraction) {
            ControlFlow::Continue(()) => Ok(()),
            ControlFlow::Break(()) => Err(FitError::Stopped),
        }
    }
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
    /// An option of lobes where none are fitted.
    #[error("{option} has no use with representation {choice}, which fits no lobes")]
    NoLobes {
        /// Its name.
        option: &'static str,
        /// What is fitted instead.
        choice: Choice,
    },
    /// A representation of a diffuse material.
    #[error("a diffuse material has nothing to fit, so {0} cannot hold it")]
    Diffuse(Choice),
    /// [`Options::progress`] asked for it.
    #[error("stopped")]
    Stopped,
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
    let done = AtomicUsize::new(0);
    let measured: Vec<(CellInfo, bool)> = (0..axes.len())
        .into_par_iter()
        .map(|i| {
            options.tell(0.9 + 0.05 * done.fetch_add(1, Ordering::Relaxed) as f64 / axes.len() as f64)?;
            let (o, rest) = (i % axes.omega as usize, i / axes.omega as usize);
            let cap = axes.cap_at(rest / axes.phi as usize, rest % axes.phi as usize, o);
            let (errors, support) = measure(&oracle, fitted.mean(), &specular, &cap);
            let main = cap.half_angle() <= 2.5 * specular.lobe_width() && cap.theta() <= 84f64.to_radians();
            Ok((CellInfo { errors, support: support as f32 }, main))
        })
        .collect::<Result<_, FitError>>()?;
    let main: Vec<Errors> = measured.iter().filter(|m| m.1).map(|m| m.0.errors).collect();
    header.at_nodes = Summary::new(&main);

    // Off the nodes: what the table promises.
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(options.seed);
    let mut off = |sampling| {
        let caps = random_caps(&specular, sampling, 100, &mut rng);
        measure_all(&oracle, fitted.mean(), &specular, &caps, options, 0.95)
    };
    (header.off_nodes, header.clipped) = (off(Sampling::Main)?, off(Sampling::Clipped)?);
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
    options.tell(1.0)?;
    let cells = measured.into_iter().map(|m| m.0).collect();
    Ok(Table { header, representation: fitted.representation, axes, cells })
}

/// The representation asked for, or the cheapest that meets the tolerance: the zonal table where the lobe is radial, else
/// cubature, which takes two to three times as long for a value (`cargo bench -p brdf-tables`) and fits every model. Lobes
/// cost as much as cubature of equal error at best (`fitter chart` draws it), so they are fitted on demand.
fn represent(specular: &Specular, options: &Options) -> Result<Fitted, FitError> {
    match options.representation {
        Choice::Auto if specular.radial_exponent().is_some() => {
            let mut fitted = zonal(specular, options)?;
            fitted.notes.insert(
                0,
                "zonal: the lobe is radial about the mirror direction, so its mean is two functions of two \
                angles: exact, and the cheapest look-up"
                    .into(),
            );
            Ok(fitted)
        }
        Choice::Zonal => zonal(specular, options),
        Choice::Auto => {
            let mut fitted = cubature::fit(specular, options)?;
            fitted
                .notes
                .insert(0, "cubature: the lobe is not radial, and lobes of equal error cost more per value".into());
            Ok(fitted)
        }
        Choice::Cubature => cubature::fit(specular, options),
        Choice::Lobes => lobes::fit(specular, options),
        Choice::Paper if !specular.is_isotropic() => Err(FitError::Anisotropic),
        Choice::Paper => paper::fit(specular, options),
    }
}

/// The smallest zonal table of a few sizes that meets the tolerance off its nodes.
fn zonal(specular: &Specular, options: &Options) -> Result<Fitted, FitError> {
    let oracle = oracle(*specular);
    let caps = random_caps(specular, Sampling::Main, 60, &mut Xoshiro256PlusPlus::seed_from_u64(options.seed ^ 1));
    let mut last = Err(FitError::NotRadial);
    for (i, (rows, columns)) in [(24, 16), (32, 24), (48, 32), (64, 48)].into_iter().enumerate() {
        let table = zonal::build(*specular, rows, columns).ok_or(FitError::NotRadial)?;
        let summary = measure_all(&oracle, &table, specular, &caps, options, 0.2 * (i + 1) as f64)?;
        let note = format!("{rows} × {columns} pairs of (T_P, T_R), 16 bits each");
        last = Ok(Fitted { representation: Representation::Zonal(table), notes: vec![note] });
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

/// The errors of a mean over caps; `fraction` of the fit is then done.
fn measure_all(
    oracle: &Cubature,
    mean: &dyn MeanBrdf,
    specular: &Specular,
    caps: &[Cap],
    options: &Options,
    fraction: f64,
) -> Result<Summary, FitError> {
    let errors = caps.par_iter().map(|cap| {
        options.tell(fraction)?;
        Ok(measure(oracle, mean, specular, cap).0)
    });
    Ok(Summary::new(&errors.collect::<Result<Vec<Errors>, FitError>>()?))
}

#[cfg(test)]
mod tests;

//! `fitter plot`: polar cuts, exact against table.

use super::Outcome;
use super::arguments::{self, SolidAngle};
use crate::plot::{Cut, figure};
use anyhow::{Context, ensure};
use brdf_tables::brdf::Specular;
use brdf_tables::cap::Cap;
use core::f64::consts::{FRAC_PI_2, PI};
use kit::Progress;
use kit::{number::number, output};
use rayon::prelude::*;
use std::path::PathBuf;
use std::sync::atomic::{AtomicUsize, Ordering};

const EXAMPLES: &str = "\
Examples:
  fitter plot phong-40.tbl phong-200.tbl -o fig4.svg
      the four cases of Figure 4 of the 2015 paper
  fitter plot ward.tbl -o ward.svg --theta-deg 60 --phi-deg 90 --omega pi/100
      across the brushing of a metal
  fitter plot lobes.tbl zonal.tbl -o both.svg
      two tables of a material, one above the other";

/// Draw polar cuts, exact against table
///
/// The specular mean BRDF in the plane of incidence as a function of the direction to the eye, with the five errors of each
/// cap over the whole hemisphere, as SVG.
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    /// Tables, as `fitter fit` writes them: one row of the figure each
    #[arg(required = true)]
    files: Vec<PathBuf>,
    /// SVG file to write
    #[arg(short, long, value_name = "FIG.svg")]
    output: PathBuf,
    /// Zenith angle of the caps, degrees in [0, 90]
    #[arg(long, value_name = "DEGREES", default_value_t = 45.0, value_parser = number(0.0..=90.0f64, "degrees from 0 to 90"))]
    theta_deg: f64,
    /// Azimuth of the caps, degrees; for anisotropic materials
    #[arg(long, value_name = "DEGREES", value_parser = number(f64::MIN..=f64::MAX, "degrees"))]
    phi_deg: Option<f64>,
    /// Solid angle of a cap in sr, such as 0.1 or pi/30; repeat for several [default: those of the paper for phong 40 and
    /// 200, else caps 1 and 2 lobe widths in radius]
    #[arg(long, value_name = "SR", allow_hyphen_values = true)]
    omega: Vec<SolidAngle>,
}

/// The paper's solid angles for its two materials; for others, caps one and two lobe widths in radius (the paper's are
/// 1.2 to 4.5).
fn default_solid_angles(specular: &Specular) -> Vec<SolidAngle> {
    let pi_over = |n: [u32; 2]| n.map(|n| SolidAngle { sr: PI / f64::from(n), text: format!("π/{n}") }).to_vec();
    match specular.radial_exponent() {
        Some((_, 40.0)) => pi_over([10, 30]),
        Some((_, 200.0)) => pi_over([10, 100]),
        _ => [2.0, 1.0]
            .map(|widths| {
                let sigma = (widths * specular.lobe_width()).min(FRAC_PI_2);
                let sr = 2.0 * PI * (1.0 - sigma.cos());
                SolidAngle { sr, text: format!("{sr:.3}") }
            })
            .to_vec(),
    }
}

/// Draws the figure.
pub fn run(args: Args) -> anyhow::Result<Outcome> {
    arguments::figure(&args.output, args.files.iter().map(PathBuf::as_path))?;
    let phi = args.phi_deg.unwrap_or(0.0);
    let mut rows = Vec::new();
    for file in &args.files {
        let table = arguments::table(file)?;
        let Some(specular) = table.specular().copied() else {
            anyhow::bail!("{}: a diffuse material, whose mean BRDF is the constant kd/pi", file.display());
        };
        ensure!(
            args.phi_deg.is_none() || !specular.is_isotropic(),
            "{}: --phi-deg has no use for an isotropic material",
            file.display()
        );
        let omegas = if args.omega.is_empty() { default_solid_angles(&specular) } else { args.omega.clone() };
        rows.push((file, table, omegas));
    }
    // Every panel is a cut of its own.
    let panels: Vec<_> = rows.iter().flat_map(|(_, table, omegas)| omegas.iter().map(move |o| (table, o))).collect();
    let (progress, done) = (Progress::new("plot"), AtomicUsize::new(0));
    let cuts: Vec<Cut> = panels
        .par_iter()
        .map(|(table, omega)| {
            let cap = Cap::new(args.theta_deg.to_radians(), phi.to_radians(), omega.sr)?;
            let caption = format!("Ω = {} sr, radius {:.2}°", omega.text, cap.half_angle().to_degrees());
            let cut = Cut::new(table, cap, caption);
            progress.set((done.fetch_add(1, Ordering::Relaxed) + 1) as f64 / panels.len() as f64);
            cut.context("the table has no specular part")
        })
        .collect::<anyhow::Result<_>>()?;
    drop(progress);
    let mut cuts = cuts.into_iter();
    let rows: Vec<(String, Vec<Cut>)> = rows
        .iter()
        .map(|(file, table, omegas)| {
            let title = format!("{} ({}, {})", table.header.material, table.representation_name(), file.display());
            (title, cuts.by_ref().take(omegas.len()).collect())
        })
        .collect();
    output::write(&args.output, figure(&rows)?.as_bytes())?;
    Ok(Outcome::Done)
}

//! `fitter albedo`: the directional albedo over roughness, as engines look it up.

use super::{Outcome, arguments};
use crate::export;
use brdf_tables::brdf::{Brdf, Distribution, Fresnel, Microfacet};
use brdf_tables::frame::spherical;
use clap::ValueEnum;
use glam::DVec2;
use kit::number::whole;
use kit::output::{self, Outputs};
use rayon::prelude::*;
use std::io::Write;
use std::path::PathBuf;

const EXAMPLES: &str = "\
Examples:
  fitter albedo ggx -o split-sum.exr
      64 x 64 pixels, for energy compensation and image-based lighting
  fitter albedo beckmann --size 128 -o beckmann.exr

Column x is cosθ = (x + 1/2)/N of the view, row y the roughness r = (y + 1/2)/N from
the top, with alpha = r². With Schlick's Fresnel term of normal reflectance f0 the
reflected part of a white sky is f0 R + G; B = R + G is that of facets that reflect
everything: 1 - B is what single scattering loses.";

/// Write the directional albedo of rough facets over angle and roughness: the split sum, as EXR
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    /// Distribution of the facets
    model: Facets,
    /// Picture to write
    #[arg(short, long, value_name = "FILE.exr")]
    output: PathBuf,
    /// Pixels a side
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = whole(2..=512u16, ""))]
    size: u16,
    #[command(flatten)]
    threads: arguments::Threads,
}

/// Models that have a split sum.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Facets {
    Ggx,
    Beckmann,
}

/// Samples of a pixel, a side of their grid.
const SIDE: usize = 128;
/// Smallest roughness of the models.
const SMALLEST: f64 = 1e-3;

/// (scale of f0, bias) of the albedo for a view.
fn split(distribution: Distribution, cos: f64, alpha: f64) -> [f64; 2] {
    let facets = Microfacet { distribution, alpha_x: alpha, alpha_y: alpha, fresnel: Fresnel::None };
    let wo = spherical(cos.acos(), 0.0);
    let mut sum = [0.0; 2];
    for i in 0..SIDE * SIDE {
        let u = (DVec2::new((i / SIDE) as f64, (i % SIDE) as f64) + 0.5) / SIDE as f64;
        let Some(wi) = facets.sample(wo, u) else { continue };
        let density = facets.pdf(wi, wo) * (SIDE * SIDE) as f64;
        if density > 0.0 {
            let weight = facets.eval(wi, wo) * wi.z / density;
            let grazing = (1.0 - (0.5 * (wi + wo).length()).min(1.0)).powi(5);
            sum[0] += weight * (1.0 - grazing);
            sum[1] += weight * grazing;
        }
    }
    sum
}

/// Computes the picture and writes it.
pub fn run(args: Args) -> anyhow::Result<Outcome> {
    args.threads.apply()?;
    Outputs::default().file_of(&args.output, &["exr"])?;
    let size = usize::from(args.size);
    let distribution = match args.model {
        Facets::Ggx => Distribution::Ggx,
        Facets::Beckmann => Distribution::Beckmann,
    };
    let at = |i: usize| (i as f64 + 0.5) / size as f64;
    let pixel = |i: usize| {
        let [scale, bias] = split(distribution, at(i % size), at(i / size).powi(2).max(SMALLEST));
        [scale, bias, scale + bias].map(|x| x as f32)
    };
    let pixels: Vec<[f32; 3]> = (0..size * size).into_par_iter().map(pixel).collect();
    output::write(&args.output, &export::exr_rgb(size, &pixels)?)?;
    writeln!(std::io::stdout().lock(), "{}: {size} x {size}, R f0 + G", args.output.display())?;
    Ok(Outcome::Done)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Smooth facets reflect everything; Schlick's polynomial is then the split. Rough ones lose some, more at grazing.
    #[test]
    fn known_values() {
        let [scale, bias] = split(Distribution::Ggx, 0.5, SMALLEST);
        assert!((scale + bias - 1.0).abs() < 2e-3 && (bias - 0.5f64.powi(5)).abs() < 1e-3, "{scale} {bias}");
        // With α = 1 and the view along the normal, f_r cosθi is cosθi/(2π(1 + cosθi)).
        let [scale, bias] = split(Distribution::Ggx, 1.0, 1.0);
        assert!((scale + bias - (1.0 - core::f64::consts::LN_2)).abs() < 1e-3, "{scale} {bias}");
    }
}

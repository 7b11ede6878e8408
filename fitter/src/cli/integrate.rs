//! `fitter integrate`: the whole mean BRDF by Monte Carlo, row by row.

use super::{Outcome, arguments};
use core::f64::consts::FRAC_1_PI;
use fitter::integrate::mean_brdf_mc_rgb;
use fitter::recipe;
use fitter::rows;
use kit::number::whole;
use std::io::{stdin, stdout};

const EXAMPLES: &str = "\
Examples:
  fitter integrate phong:exponent=100 --samples 100000 < caps.csv > truth.csv
  fitter integrate tables/ggx-0.3.toml --seed 2 < caps.csv";

/// Integrate caps and directions from CSV by Monte Carlo
///
/// Reads CSV on standard input and writes the same columns and r,g,b,stderr_r,stderr_g,stderr_b: the whole mean BRDF,
/// diffuse part included, and the standard error of each channel, in 1/sr.
#[derive(clap::Args)]
#[command(after_help = format!("{}\n\n{EXAMPLES}", rows::HELP))]
pub struct Args {
    /// Inline recipe such as phong:exponent=100,ks=1,kd=0, or a TOML file
    material: String,
    /// Directions per row, drawn from the cap and from the BRDF
    #[arg(long, value_name = "N", default_value_t = 65536, value_parser = whole(32..=1u64 << 32, ""))]
    samples: u64,
    /// Seed; every row has a sequence of its own
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = whole(0..=u64::MAX, ""))]
    seed: u64,
    #[command(flatten)]
    threads: arguments::Threads,
}

/// Answers standard input.
pub fn run(args: Args) -> anyhow::Result<Outcome> {
    args.threads.apply()?;
    let material = recipe::material(&args.material)?;
    let columns = ["r", "g", "b", "stderr_r", "stderr_g", "stderr_b"];
    rows::answer(stdin().lock(), stdout().lock(), columns, |row, cap, wo| {
        // The Lambertian part is known; only the specular one is estimated.
        let diffuse = material.kd.map(|kd| kd * FRAC_1_PI);
        let mut answer = [diffuse[0], diffuse[1], diffuse[2], 0.0, 0.0, 0.0];
        if let Some(specular) = &material.specular {
            let seed = args.seed.wrapping_add(row << 32);
            for (c, e) in mean_brdf_mc_rgb(specular, cap, wo, args.samples as usize, seed).into_iter().enumerate() {
                answer[c] += material.ks[c] * e.value;
                answer[3 + c] = material.ks[c] * e.stderr;
            }
        }
        answer
    })?;
    Ok(Outcome::Done)
}

//! `render compare`.

use anyhow::{Context, Result, bail};
use render::image::{read, write_png};
use render::metric::{Comparison, compare, false_color};
use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;

/// Arguments of `render compare`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Picture to judge (EXR, HDR or PNG).
    image: PathBuf,
    /// What it should look like.
    reference: PathBuf,
    /// Write the error of every pixel in false colours.
    #[arg(long, value_name = "OUT.png")]
    false_color: Option<PathBuf>,
    /// Print the figures as JSON.
    #[arg(long)]
    json: bool,
    /// Exit with 1 if rel_mse is above this.
    #[arg(long, value_name = "REL_MSE")]
    fail_above: Option<f64>,
}

/// Compares, prints, and judges.
pub fn run(args: &Args) -> Result<ExitCode> {
    if args.fail_above.is_some_and(|limit| limit.is_nan() || limit < 0.0) {
        bail!("--fail-above needs a number ≥ 0");
    }
    let (image, reference) = (read(&args.image)?, read(&args.reference)?);
    let place = || format!("{} and {}", args.image.display(), args.reference.display());
    let figures = compare(&image, &reference).with_context(place)?;
    if let Some(path) = &args.false_color {
        if path.extension().is_none_or(|e| !e.eq_ignore_ascii_case("png")) {
            bail!("{}: the name must end in .png", path.display());
        }
        write_png(path, &false_color(&image, &reference).with_context(place)?)?;
    }
    let text = if args.json {
        serde_json::to_string(&figures)? + "\n"
    } else {
        let Comparison { rmse, rel_mse, bias, max, flip } = figures;
        format!(
            "rmse     {rmse:.6}\nrel_mse  {rel_mse:.6}\nbias     {bias:+.6}\nmax      {max:.6}\nflip     {flip:.6}\n"
        )
    };
    // A reader that has seen enough is no error.
    match std::io::stdout().write_all(text.as_bytes()) {
        Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => return Err(e).context("standard output"),
        _ => {}
    }
    let failed = args.fail_above.is_some_and(|limit| figures.rel_mse > limit);
    Ok(if failed { ExitCode::from(1) } else { ExitCode::SUCCESS })
}

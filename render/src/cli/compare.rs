//! `render compare`.

use anyhow::{Context, Result, bail};
use kit::number::{number, whole};
use kit::output::Outputs;
use render::image::{Image, Pixels, read_noise, read_pixels, write_png};
use render::metric::defects::Defects;
use render::metric::z_scores::{ZScores, ZTest, z_test};
use render::metric::{Comparison, compare, false_color};
use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;

/// Arguments of `render compare`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Picture to judge (EXR, HDR, PNG or JPEG).
    image: PathBuf,
    /// What it should look like.
    reference: PathBuf,
    /// Write the error of every pixel in false colours.
    #[arg(long, value_name = "OUT.png")]
    false_color: Option<PathBuf>,
    /// Judge the differences by the noise: needs an EXR of `render image`, which holds the variance of every pixel.
    /// Exit with 1 if they are larger than chance allows.
    #[arg(long)]
    z_test: bool,
    /// Samples per pixel of the reference, for its share of the noise [default: what an EXR of `render image` says,
    /// otherwise no noise].
    #[arg(long, value_name = "N", requires = "z_test", value_parser = whole(1..=u32::MAX, ""))]
    reference_spp: Option<u32>,
    /// Print the figures as JSON.
    #[arg(long)]
    json: bool,
    /// Exit with 1 if rel_mse is above this.
    #[arg(long, value_name = "REL_MSE", value_parser = number(0.0..=f64::MAX, "a number ≥ 0"))]
    fail_above: Option<f64>,
}

/// What `--json` prints.
#[derive(serde::Serialize)]
struct Report {
    #[serde(flatten)]
    figures: Comparison,
    #[serde(flatten)]
    defects: Defects,
    #[serde(skip_serializing_if = "Option::is_none")]
    z_test: Option<ZTest>,
    /// What is not there, and why.
    #[serde(skip_serializing_if = "Option::is_none")]
    note: Option<&'static str>,
}

/// In place of an error that this build cannot measure.
const NO_FLIP: &str = "flip is not in this build (feature `flip`)";

/// The z-test of two pictures with what their files say of their noise.
fn judge(args: &Args, image: &Image, reference: &Image) -> Result<ZTest> {
    let Some(noise) = read_noise(&args.image)? else {
        bail!(
            "{}: no variance layer; --z-test needs an EXR of `render image`, not denoised, with more than 16 samples per pixel",
            args.image.display()
        );
    };
    let reference_spp = match args.reference_spp {
        Some(n) => Some(n),
        None => read_noise(&args.reference)?.map(|n| n.spp),
    };
    let share = reference_spp.map_or(0.0, |n| f64::from(noise.spp) / f64::from(n));
    z_test(image, &noise.variance, reference, share)
        .with_context(|| format!("{} and {}", args.image.display(), args.reference.display()))
}

/// A line of figures for people.
fn table(name: &str, z: &ZScores) -> String {
    let ZScores { count, mean, deviation, beyond_3, max, limit, finds } = *z;
    let verdict = if z.passed() { "passed" } else { "FAILED" };
    format!(
        "z of {count} {name}: mean {mean:+.3}, deviation {deviation:.3}, beyond 3: {:.3} % (normal: 0.270 %), \
         max {max:.2} (limit {limit:.2}): {verdict}; finds a bias of {:.2} % of one\n",
        100.0 * beyond_3,
        100.0 * finds
    )
}

/// Reads both pictures, which must not be different parts of one.
fn read_both(args: &Args) -> Result<(Image, Image)> {
    let read = |path: &PathBuf| -> Result<Pixels> {
        let pixels = read_pixels(path)?;
        for warning in &pixels.warnings {
            eprintln!("render: warning: {}: {warning}", path.display());
        }
        Ok(pixels)
    };
    let (image, reference) = (read(&args.image)?, read(&args.reference)?);
    if let (Some(a), Some(b)) = (&image.windows, &reference.windows)
        && a.are_other_parts_than(b)
    {
        let files = format!("{} and {}", args.image.display(), args.reference.display());
        if a.display != b.display {
            bail!("{files}: other parts of one picture: pixels {} and {} of the film", a.display, b.display);
        }
        bail!(
            "{files}: other parts of one picture: the data windows are {} and {}, the display window is {}",
            a.data,
            b.data,
            a.display
        );
    }
    Ok((image.into(), reference.into()))
}

/// Compares, prints, and judges.
pub fn run(args: &Args) -> Result<ExitCode> {
    if let Some(path) = &args.false_color {
        Outputs::beside([args.image.as_path(), &args.reference]).file_of(path, &["png"])?;
    }
    let (image, reference) = read_both(args)?;
    let place = || format!("{} and {}", args.image.display(), args.reference.display());
    let figures = compare(&image, &reference).with_context(place)?;
    let z_test = if args.z_test { Some(judge(args, &image, &reference)?) } else { None };
    let text = if args.json {
        serde_json::to_string(&Report {
            figures,
            defects: Defects::new(&image, &reference).with_context(place)?,
            z_test,
            note: figures.flip.is_none().then_some(NO_FLIP),
        })? + "\n"
    } else {
        let Comparison { rmse, rel_mse, bias, max, flip } = figures;
        let flip = flip.map_or(NO_FLIP.into(), |x| format!("flip     {x:.6}"));
        format!("rmse     {rmse:.6}\nrel_mse  {rel_mse:.6}\nbias     {bias:+.6}\nmax      {max:.6}\n{flip}\n")
    };
    let text = match &z_test {
        Some(z) if !args.json => {
            let scales = [("pixels", z.pixels), ("blocks", z.blocks), ("tiles", z.tiles), ("picture", z.whole)];
            scales.iter().fold(text, |text, (name, scores)| text + &table(name, scores))
        }
        _ => text,
    };
    // A reader that has seen enough is no error.
    match std::io::stdout().write_all(text.as_bytes()) {
        Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => return Err(e).context("standard output"),
        _ => {}
    }
    // After the figures: they do not depend on whether this file can be written.
    if let Some(path) = &args.false_color {
        write_png(path, &false_color(&image, &reference).with_context(place)?)?;
    }
    let failed = args.fail_above.is_some_and(|limit| figures.rel_mse > limit) || z_test.is_some_and(|z| !z.passed());
    Ok(if failed { ExitCode::from(1) } else { ExitCode::SUCCESS })
}

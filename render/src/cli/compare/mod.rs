//! `render compare`.

mod frames;
pub(super) mod strip;

use anyhow::{Context, Result, bail};
use kit::number::{number, whole};
use kit::output::Outputs;
use render::image::{Image, Pixels, read_noise, read_pixels, write_png};
use render::metric::defects::Defects;
use render::metric::z_scores::{ZScores, ZTest, z_test};
use render::metric::{Comparison, SizeMismatch, Truth, false_color};
use render::walk::FrameNumbers;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Arguments of `render compare`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Picture to judge (EXR, HDR, PNG or JPEG); with --frames, its name with #### for the number of the frame.
    image: PathBuf,
    /// What it should look like.
    reference: PathBuf,
    /// A second reference of another seed: rmse, rel_mse and trimmed are then free of the noise of both references, bias,
    /// max and flip are those from their mean.
    #[arg(long, value_name = "REFERENCE2", conflicts_with = "z_test")]
    second: Option<PathBuf>,
    /// Compare the frames of a walk, each with its own reference, and measure flicker: how much the error changes from frame
    /// to frame. As 1-60 or 1,5,9; all names need #### for the number.
    #[arg(long, value_name = "A-B", conflicts_with_all = ["z_test", "false_color"])]
    frames: Option<FrameNumbers>,
    /// Write the middle column of every frame side by side, and those of the references below: flicker is seen at a glance.
    #[arg(long, value_name = "OUT.png", requires = "frames")]
    strip: Option<PathBuf>,
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
    /// Exit with 1 if rel_mse is above this; with --frames, its mean.
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

/// Reads pictures, which must not be different parts of one.
fn read_all<const N: usize>(paths: [&Path; N]) -> Result<[Image; N]> {
    let mut read: Vec<Pixels> = Vec::with_capacity(N);
    for path in paths {
        let pixels = read_pixels(path)?;
        for warning in &pixels.warnings {
            eprintln!("render: warning: {}: {warning}", path.display());
        }
        if let Some(Pixels { windows: Some(a), .. }) = read.first()
            && let Some(b) = &pixels.windows
            && a.are_other_parts_than(b)
        {
            let files = format!("{} and {}", paths[0].display(), path.display());
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
        read.push(pixels);
    }
    let mut images = read.into_iter().map(Image::from);
    Ok(std::array::from_fn(|_| images.next().expect("one of each path")))
}

/// A picture, and what it is measured against.
struct Read {
    image: Image,
    references: Vec<Image>,
}

impl Read {
    fn new(image: &Path, reference: &Path, second: Option<&Path>) -> Result<Self> {
        let (image, references) = match second {
            None => {
                let [image, reference] = read_all([image, reference])?;
                (image, vec![reference])
            }
            Some(second) => {
                let [image, reference, second] = read_all([image, reference, second])?;
                (image, vec![reference, second])
            }
        };
        Ok(Self { image, references })
    }

    fn truth(&self) -> Result<Truth<'_>, SizeMismatch> {
        match &self.references[..] {
            [first, second] => Truth::two(first, second),
            _ => Ok(Truth::one(&self.references[0])),
        }
    }
}

/// Prints; a reader that has seen enough is no error.
pub(super) fn print(text: &str) -> Result<()> {
    match std::io::stdout().write_all(text.as_bytes()) {
        Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => Err(e).context("standard output"),
        _ => Ok(()),
    }
}

/// Compares, prints, and judges.
pub fn run(args: &Args) -> Result<ExitCode> {
    if let Some(frames) = &args.frames {
        return frames::run(args, frames);
    }
    let second = args.second.as_deref();
    if let Some(path) = &args.false_color {
        let inputs = [args.image.as_path(), &args.reference].into_iter().chain(second);
        Outputs::beside(inputs).file_of(path, &["png"])?;
    }
    let read = Read::new(&args.image, &args.reference, second)?;
    let place = || match second {
        Some(second) => format!("{}, {} and {}", args.image.display(), args.reference.display(), second.display()),
        None => format!("{} and {}", args.image.display(), args.reference.display()),
    };
    let truth = read.truth().with_context(place)?;
    let (image, reference) = (&read.image, truth.mean());
    let figures = truth.compare(image).with_context(place)?;
    let z_test = if args.z_test { Some(judge(args, image, reference)?) } else { None };
    let text = if args.json {
        serde_json::to_string(&Report {
            figures,
            defects: Defects::new(image, reference).with_context(place)?,
            z_test,
            note: figures.flip.is_none().then_some(NO_FLIP),
        })? + "\n"
    } else {
        let Comparison { rmse, rel_mse, trimmed, bias, max, flip } = figures;
        let flip = flip.map_or(NO_FLIP.into(), |x| format!("flip     {x:.6}"));
        format!(
            "rmse     {rmse:.6}\nrel_mse  {rel_mse:.6}\ntrimmed  {trimmed:.6}\nbias     {bias:+.6}\nmax      {max:.6}\n{flip}\n"
        )
    };
    let text = match &z_test {
        Some(z) if !args.json => {
            let scales = [("pixels", z.pixels), ("blocks", z.blocks), ("tiles", z.tiles), ("picture", z.whole)];
            scales.iter().fold(text, |text, (name, scores)| text + &table(name, scores))
        }
        _ => text,
    };
    print(&text)?;
    // After the figures: they do not depend on whether this file can be written.
    if let Some(path) = &args.false_color {
        write_png(path, &false_color(image, reference).with_context(place)?)?;
    }
    let failed = args.fail_above.is_some_and(|limit| figures.rel_mse > limit) || z_test.is_some_and(|z| !z.passed());
    Ok(if failed { ExitCode::from(1) } else { ExitCode::SUCCESS })
}

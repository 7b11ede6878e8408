//! Frames of a walk against their references.

use super::strip::Strip;
use super::{Args, NO_FLIP, Read, print};
use anyhow::{Context, Error, Result, ensure};
use kit::output::Outputs;
use render::image::write_png;
use render::metric::{Comparison, Flicker};
use render::walk::{FrameFiles, FrameNumbers};
use std::fmt::Write;
use std::path::Path;
use std::process::ExitCode;

/// A frame.
#[derive(serde::Serialize)]
struct Frame {
    frame: u32,
    #[serde(flatten)]
    figures: Comparison,
    /// From the frame before; none where that one is not there.
    flicker: Option<f64>,
}

/// What `--json` prints.
#[derive(serde::Serialize)]
struct Report {
    frames: Vec<Frame>,
    /// Of the figures of all frames.
    mean: Comparison,
    flicker: Option<f64>,
    /// What is not there, and why.
    #[serde(skip_serializing_if = "Option::is_none")]
    note: Option<&'static str>,
}

/// Mean figures of frames, but for the largest of `max`.
fn mean(frames: &[Frame]) -> Comparison {
    let mean =
        |figure: fn(&Comparison) -> f64| frames.iter().map(|f| figure(&f.figures)).sum::<f64>() / frames.len() as f64;
    Comparison {
        rmse: mean(|f| f.rmse),
        rel_mse: mean(|f| f.rel_mse),
        trimmed: mean(|f| f.trimmed),
        bias: mean(|f| f.bias),
        max: frames.iter().map(|f| f.figures.max).fold(0.0, f64::max),
        flip: frames.iter().all(|f| f.figures.flip.is_some()).then(|| mean(|f| f.flip.unwrap_or_default())),
    }
}

/// Compares every frame with its reference, in the order of their numbers.
pub(super) fn run(args: &Args, frames: &FrameNumbers) -> Result<ExitCode> {
    let files = |path: &Path| FrameFiles::new(path).map_err(Error::msg).with_context(|| path.display().to_string());
    let (images, references) = (files(&args.image)?, files(&args.reference)?);
    let seconds = args.second.as_deref().map(files).transpose()?;
    if let Some(path) = &args.strip {
        Outputs::default().file_of(path, &["png"])?;
    }
    let mut numbers = frames.as_slice().to_vec();
    numbers.sort_unstable();
    let (mut flicker, mut strip) = (Flicker::default(), Strip::default());
    let mut found = Vec::with_capacity(numbers.len());
    for frame in numbers {
        let (image, reference) = (images.of(frame), references.of(frame));
        let second = seconds.as_ref().map(|files| files.of(frame));
        let read = Read::new(&image, &reference, second.as_deref())?;
        let place = || format!("{} and {}", image.display(), reference.display());
        let truth = read.truth().with_context(place)?;
        let figures = truth.compare(&read.image).with_context(place)?;
        ensure!(figures.rel_mse.is_finite(), "{}: a pixel is not a number", place());
        if args.strip.is_some() {
            strip.add(&read.image, truth.mean());
        }
        let flicker = flicker.add(frame, &read.image, &truth)?;
        found.push(Frame { frame, figures, flicker });
    }
    let (mean, flicker) = (mean(&found), flicker.mean());
    let note = mean.flip.is_none().then_some(NO_FLIP);
    let text = if args.json {
        serde_json::to_string(&Report { frames: found, mean, flicker, note })? + "\n"
    } else {
        table(&found, &mean, flicker)
    };
    print(&text)?;
    if let Some(path) = &args.strip {
        write_png(path, &strip.image())?;
    }
    let failed = args.fail_above.is_some_and(|limit| mean.rel_mse > limit);
    Ok(if failed { ExitCode::from(1) } else { ExitCode::SUCCESS })
}

/// A line for every frame, and one for all.
fn table(frames: &[Frame], mean: &Comparison, flicker: Option<f64>) -> String {
    let line = |name: &str, f: &Comparison, flicker: Option<f64>| {
        let or_none = |x: Option<f64>| x.map_or("-".into(), |x| format!("{x:.6}"));
        let Comparison { rmse, rel_mse, trimmed, bias, max, flip } = *f;
        let (flip, flicker) = (or_none(flip), or_none(flicker));
        format!("{name:>7} {rmse:9.6} {rel_mse:9.6} {trimmed:9.6} {bias:+9.6} {max:10.6} {flip:>9} {flicker:>9}\n")
    };
    let mut text = String::new();
    // Writing to a string does not fail.
    let _ = writeln!(
        text,
        "{:>7} {:>9} {:>9} {:>9} {:>9} {:>10} {:>9} {:>9}",
        "frame", "rmse", "rel_mse", "trimmed", "bias", "max", "flip", "flicker"
    );
    text.extend(frames.iter().map(|f| line(&f.frame.to_string(), &f.figures, f.flicker)));
    text + &line("mean", mean, flicker)
}

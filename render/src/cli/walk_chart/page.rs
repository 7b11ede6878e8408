//! The page of a walk's chart: one HTML file that needs no other.

use super::Args;
use super::bars::ratios;
use super::curves::FIGURES;
use super::frame::Measured;
use crate::chart::page::html::{escape, page, picture, table};
use crate::chart::plot::plain;
use crate::cli::compare::strip::Strip;
use anyhow::{Context, Result};
use kit::output::write as write_file;
use render::image::{Image, write_png};
use render::metric::false_color;
use std::fmt::Write;

/// Side of a crop, pixels, at most.
const CROP: u32 = 72;

/// Writes the page and its figures.
pub(super) fn write(args: &Args, frames: &[u32], all: &[Measured], references: &[Vec<Image>; 2]) -> Result<()> {
    let mut body = format!(
        "<p>{}, {} frames of {}. References: two of {} samples per pixel, path traced; errors are free of their noise.</p>\n",
        escape(&args.scene.display().to_string()),
        frames.len(),
        escape(&args.path.display().to_string()),
        args.reference_spp
    );
    for &seconds in &args.time_per_frame {
        let methods: Vec<&Measured> = all.iter().filter(|m| m.seconds == seconds).collect();
        // Writing to a string does not fail.
        let _ = writeln!(body, "<h2>{seconds} s a frame</h2>\n{}<div class=\"figures\">", figures(all, &methods));
        for figure in &FIGURES {
            let svg = figure.draw(&methods);
            write_file(&args.output.join(format!("{}-{seconds}.svg", figure.name)), svg.as_bytes())?;
            let _ = writeln!(body, "<figure>{svg}<figcaption>{}, frame by frame</figcaption></figure>", figure.title);
        }
        body += "</div>\n";
        body += &pictures((args, seconds), frames, &methods, references)?;
    }
    body += MEASURES;
    write_file(&args.output.join("index.html"), page("Burnish: frames of a walk", &body).as_bytes())?;
    Ok(())
}

/// The figures of methods.
fn figures(all: &[Measured], methods: &[&Measured]) -> String {
    let head = [
        "method",
        "s a frame",
        "τ",
        "spp",
        "rel_mse",
        "trimmed",
        "bias",
        "flicker",
        "error over path + denoiser",
        "flicker over it",
    ];
    let or_none = |x: Option<f64>| x.map_or("–".into(), |x| plain(&x));
    let rows = methods.iter().map(|m| {
        let ratios = ratios(all, m);
        vec![
            escape(m.method.name),
            format!("{:.2}", m.spent),
            if m.tau > 0.0 { plain(&m.tau) } else { "–".into() },
            m.spp.to_string(),
            plain(&m.mean(|c| c.rel_mse)),
            plain(&m.mean(|c| c.trimmed)),
            format!("{:+.2} %", 100.0 * m.mean(|c| c.bias)),
            or_none(m.flicker),
            or_none(ratios.as_ref().map(|r| r.error)),
            or_none(ratios.as_ref().and_then(|r| r.flicker)),
        ]
    });
    table(&head, &rows.collect::<Vec<_>>())
}

/// Strips of pixels over time, and the middle of one frame with its error.
fn pictures(
    (args, seconds): (&Args, f64),
    frames: &[u32],
    methods: &[&Measured],
    references: &[Vec<Image>; 2],
) -> Result<String> {
    let folder = args.output.join("pictures");
    std::fs::create_dir_all(&folder).with_context(|| folder.display().to_string())?;
    let mut count = 0;
    let mut text = String::from("<h3>The middle column of every frame, side by side</h3>\n<div class=\"pictures\">\n");
    let mut figure = |image: &Image, about: &str| -> Result<String> {
        count += 1;
        let path = folder.join(format!("{seconds}-{count:02}.png"));
        write_png(&path, image)?;
        let bytes = std::fs::read(&path).with_context(|| path.display().to_string())?;
        Ok(format!("<figure>{}<figcaption>{}</figcaption></figure>\n", picture(&bytes, about), escape(about)))
    };
    for m in methods {
        let mut strip = Strip::default();
        m.images.iter().zip(&references[0]).for_each(|(image, reference)| strip.add(image, reference));
        text += &figure(&widened(&strip.image()), &format!("{}, above the reference", m.method.name))?;
    }
    let middle = frames.len() / 2;
    let _ = write!(text, "</div>\n<h3>Frame {}</h3>\n<div class=\"pictures\">\n", frames[middle]);
    text += &figure(&references[0][middle], "reference")?;
    for m in methods {
        text += &figure(&m.images[middle], m.method.name)?;
    }
    text += "</div>\n<h3>Its middle, and the error there</h3>\n<div class=\"pictures\">\n";
    let reference = crop(&references[0][middle]);
    text += &figure(&reference, "reference")?;
    for m in methods {
        let part = crop(&m.images[middle]);
        text += &figure(&part, m.method.name)?;
        text += &figure(&false_color(&part, &reference)?, &format!("error of {}", m.method.name))?;
    }
    Ok(text + "</div>\n")
}

/// A strip of few frames with every column several times, so that it is no narrower than half its height.
fn widened(strip: &Image) -> Image {
    let times = (strip.height / (2 * strip.width.max(1))).max(1);
    let width = strip.width * times;
    let pixels = (0..(width * strip.height) as usize).map(|i| {
        let (x, y) = (i % width as usize, i / width as usize);
        strip.pixels[y * strip.width as usize + x / times as usize]
    });
    Image { width, height: strip.height, pixels: pixels.collect() }
}

/// The middle of a picture.
fn crop(image: &Image) -> Image {
    let (width, height) = (image.width.min(CROP), image.height.min(CROP));
    let (left, top) = ((image.width - width) / 2, (image.height - height) / 2);
    let row = |y: u32| {
        let start = ((top + y) * image.width + left) as usize;
        image.pixels[start..start + width as usize].iter().copied()
    };
    Image { width, height, pixels: (0..height).flat_map(row).collect() }
}

const MEASURES: &str = "<h2>How to read it</h2>
<ul>
<li>Seconds a frame are those of drawing, denoising and writing, and for caches the share of a frame in the fill for the whole path.</li>
<li>rel_mse: mean of squared error / (reference² + 0.01); trimmed: over the 99.5 % best pixels. Bias: mean difference over the mean of
the reference. Flicker: mean of (e<sub>t</sub> − e<sub>t−1</sub>)² / (2 (reference² + 0.01)) from a frame to the next: 0 for an error
that stays in its place.</li>
<li>False colours: relative error of a pixel from 0 to 100 %, green at 25 %.<div class=\"scale\"></div></li>
</ul>
";

//! How pictures look: options for what people see, and for what a compositor lays over something else.

use super::choices::{PARTS, VIEWS, choices};
use anyhow::{Result, bail};
use kit::number::number;
use render::image::view::{Display, View};
use render::image::{Format, Look, Part};
use render::scene::Film;
use std::path::{Path, PathBuf};

/// Largest exposure either way, stops.
const MAX_EXPOSURE: f32 = 64.0;

/// Options of how pictures look.
#[derive(Debug, clap::Args)]
pub struct Looking {
    /// Brighten PNG, JPEG and WebP by so many stops: each is a factor of two on the light, −1 is half. EXR keeps the light
    /// [default: 0].
    #[arg(long, value_name = "EV", value_parser = number(-MAX_EXPOSURE..=MAX_EXPOSURE, "a number of stops from -64 to 64"))]
    exposure: Option<f32>,
    /// How PNG, JPEG and WebP show light that is brighter than a screen. EXR keeps the light [default: standard].
    #[arg(long, value_parser = choices(&VIEWS))]
    view: Option<View>,
    /// Leave the sky out where the camera looks straight into it, and write alpha: the share of a pixel that shows surfaces
    /// (EXR, PNG, WebP).
    ///
    /// The sky still lights the scene, and shows in mirrors and through glass, which therefore count as surfaces. The holes of
    /// masks do not. Edges are as soft as the film's filter makes them. Colours in EXR are multiplied by alpha, those in PNG
    /// and WebP are not, as these formats ask for.
    #[arg(long)]
    pub(super) transparent: bool,
    /// Layers that an EXR holds beside the picture, with commas between them [default: all that there are].
    ///
    /// In single precision are the picture, what is measured of it (noisy, variance) and depth; the others in half precision,
    /// unless a number does not fit: one beyond 65504, or a layer all below 1/64.
    #[arg(long, value_name = "LAYER,…", value_delimiter = ',', value_parser = choices(&PARTS))]
    layers: Option<Vec<Option<Part>>>,
}

impl Looking {
    /// Refuses options that none of the outputs can show. `others` tells of a PNG beside them.
    ///
    /// # Errors
    /// One line with the option.
    pub fn check(&self, outputs: &[PathBuf], others: bool) -> Result<()> {
        let formats = || outputs.iter().filter_map(|path| Some((path, Format::of(path)?)));
        let shown = others || formats().next().is_some();
        for (option, given) in [("--exposure", self.exposure.is_some()), ("--view", self.view.is_some())] {
            if given && !shown {
                bail!("{option} needs an output for a screen (.png, .jpg or .webp): EXR keeps the light as it is");
            }
        }
        if let Some(layers) = &self.layers {
            if !outputs.iter().any(|path| is_exr(path)) {
                bail!("--layers needs an output that has layers (.exr)");
            }
            if layers.len() > 1 && layers.contains(&None) {
                bail!("--layers none goes with no other layer");
            }
        }
        if self.transparent
            && let Some((path, format)) = formats().find(|(_, format)| !format.is_transparent())
        {
            bail!("{}: {} holds no transparency: write .png, .webp or .exr", path.display(), format.name());
        }
        Ok(())
    }

    /// As pictures are written.
    pub fn look(&self) -> Look {
        let display = Display::new(self.view.unwrap_or_default(), self.exposure.unwrap_or(0.0));
        let parts = match &self.layers {
            Some(layers) => layers.iter().copied().flatten().collect(),
            None => Part::ALL.to_vec(),
        };
        Look { display, alpha: self.transparent, note: None, parts }
    }
}

fn is_exr(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("exr"))
}

/// Refuses a film that is larger than a format of the outputs can be.
///
/// # Errors
/// One line with the file and the largest size.
pub(super) fn check_size(outputs: &[PathBuf], film: &Film) -> Result<()> {
    let window = film.window();
    for path in outputs {
        let Some(format) = Format::of(path) else { continue };
        let (name, most) = (format.name(), format.max_size());
        if window.width.max(window.height) > most {
            let (w, h) = (window.width, window.height);
            bail!("{}: {name} has at most {most} pixels either way, the film has {w} × {h}", path.display());
        }
    }
    Ok(())
}

//! From a noisy picture to one without noise.
//!
//! Light is denoised by the way it took (`layers`): emission seen directly has no noise and stays as it is; direct and
//! indirect light are denoised apart, guided by albedo and normal, and summed; but together where indirect light comes from
//! records. Either by Intel's Open Image Denoise, a neural network, where its library is found when the program runs ([`oidn`]), or by our own filter
//! (`builtin`).

mod builtin;
mod error;
mod fireflies;
mod layers;
mod level;
#[cfg(feature = "oidn")]
pub mod oidn;
mod plan;
mod strips;

use crate::picture::Picture;
pub use error::DenoiseError;
pub use fireflies::Bounded;
use fireflies::Loss;
use layers::{Layer, Layers};
use level::Level;
use plan::{EFFORTS, Rate};
pub use plan::{Effort, Plan};
use rayon::prelude::*;
use std::path::Path;
use strips::Strip;
pub use strips::seen;

/// Which denoiser to take.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Choice {
    /// Open Image Denoise where it is found, else our own.
    Auto,
    /// Open Image Denoise.
    Oidn,
    /// Our own.
    Builtin,
}

/// A denoiser, made once and used for any number of pictures.
#[derive(Debug)]
pub struct Denoiser {
    kind: Kind,
    /// What it costs on this machine.
    rate: Rate,
    note: Option<String>,
}

#[derive(Debug)]
enum Kind {
    #[cfg(feature = "oidn")]
    Oidn(oidn::Device),
    Builtin,
}

impl Denoiser {
    /// Opens a denoiser. `library` is the file of Open Image Denoise or a folder that holds it; without it, the environment
    /// variable `OIDN_LIBRARY` names it, or the system finds it. `threads`, 0: one for each core.
    ///
    /// # Errors
    /// [`Choice::Oidn`], or a `library`, that cannot be loaded.
    pub fn open(choice: Choice, library: Option<&Path>, threads: usize) -> Result<Self, DenoiseError> {
        let (kind, note) = match choice {
            Choice::Builtin => (Kind::Builtin, None),
            Choice::Oidn => (oidn_kind(library, threads)?, None),
            Choice::Auto => match oidn_kind(library, threads) {
                Ok(kind) => (kind, None),
                Err(error) if library.is_some() => return Err(error),
                Err(error) => (Kind::Builtin, Some(error.to_string())),
            },
        };
        Ok(Self { kind, rate: Rate::default(), note })
    }

    /// `oidn` or `builtin`.
    pub fn name(&self) -> &'static str {
        match &self.kind {
            #[cfg(feature = "oidn")]
            Kind::Oidn(_) => "oidn",
            Kind::Builtin => "builtin",
        }
    }

    /// Why [`Choice::Auto`] did not take Open Image Denoise.
    pub fn note(&self) -> Option<&str> {
        self.note.as_deref()
    }

    /// How to denoise a picture of so many pixels, from records or not: as well as can be, or with `seconds` for the whole picture,
    /// so that the time buys most. Measures what denoising costs on this machine, for about a twentieth of a second, unless it is
    /// known.
    ///
    /// # Errors
    /// A library that fails.
    pub fn plan(&self, pixels: u64, from_records: bool, seconds: Option<f64>) -> Result<Plan, DenoiseError> {
        // Our own has one way only.
        let efforts = if self.is_builtin() { &[Effort::Low][..] } else { &EFFORTS };
        let size = (pixels, plan::layers(from_records));
        let trial = |side| self.run(&Layers::example(side), Effort::Low, &|_| ()).map(drop);
        self.rate.plan(efforts, size, seconds, trial)
    }

    /// Takes the noise out of a picture: sets [`Picture::denoised`]. The noisy light stays as it is. Tells how much of it the
    /// denoiser was not shown.
    ///
    /// The result does not depend on the number of threads.
    ///
    /// # Errors
    /// A library that fails; the picture is as it was.
    pub fn denoise(&self, picture: &mut Picture, effort: Effort) -> Result<Bounded, DenoiseError> {
        self.denoise_telling(picture, effort, &|_| ())
    }

    /// [`Denoiser::denoise`], which tells the share of the work that is done.
    ///
    /// # Errors
    /// A library that fails; the picture is as it was.
    pub fn denoise_telling(
        &self,
        picture: &mut Picture,
        effort: Effort,
        progress: Progress,
    ) -> Result<Bounded, DenoiseError> {
        self.denoise_strips(picture, effort, strips::PIXELS, progress)
    }

    /// The same in strips of about so many pixels.
    fn denoise_strips(
        &self,
        picture: &mut Picture,
        effort: Effort,
        pixels: usize,
        progress: Progress,
    ) -> Result<Bounded, DenoiseError> {
        let effort = if self.is_builtin() { Effort::Low } else { effort };
        // Two kinds of noise are taken away better apart, and noise better in the midst of light that has none.
        let together = effort == Effort::Together || picture.from_records;
        let strips = Strip::of([picture.width as usize, picture.height as usize], pixels);
        let level = |kind: Option<layers::Kind>| kind.filter(|_| strips.len() > 1).map(|k| Level::of(picture, k));
        let levels = layers::Kind::of(together).map(level);
        let mut denoised = Vec::with_capacity(picture.pixels.len());
        let mut loss = Loss::default();
        let count = strips.len() as f64;
        for (i, strip) in strips.into_iter().enumerate() {
            let progress = |share: f64| progress((i as f64 + share) / count);
            let mut layers = Layers::new(picture, &strip, levels, together);
            loss += fireflies::bound(&mut layers, strip.inner());
            let light = self.rate.timed(layers.size(), effort, || self.run(&layers, effort, &progress))?;
            denoised.par_extend(layers.merge(picture, &strip, &light));
        }
        picture.denoised = Some(denoised);
        Ok(loss.into())
    }

    /// Whether it is our own.
    pub fn is_builtin(&self) -> bool {
        matches!(self.kind, Kind::Builtin)
    }

    /// Direct and indirect light without noise; `None` where a layer is black.
    #[cfg_attr(not(feature = "oidn"), expect(unused_variables, reason = "our own has one effort"))]
    fn run(&self, layers: &Layers, effort: Effort, progress: Progress) -> Result<[Denoised; 2], DenoiseError> {
        let each = |i: usize, layer: &Option<Layer>| {
            let share = |share: f64| progress(0.5 * (i as f64 + share));
            let Some(layer) = layer else { return Ok(None) };
            match &self.kind {
                #[cfg(feature = "oidn")]
                Kind::Oidn(device) => device.denoise(layers, layer, effort, &share).map(Some),
                Kind::Builtin => Ok(Some(builtin::denoise(layers, layer, &share))),
            }
        };
        Ok([each(0, &layers.direct)?, each(1, &layers.indirect)?])
    }
}

/// Light without noise, by pixel; `None` where there is none at all.
type Denoised = Option<Vec<[f32; 3]>>;

/// Is told the share of the work that is done.
type Progress<'a> = &'a (dyn Fn(f64) + Sync);

#[cfg(feature = "oidn")]
fn oidn_kind(library: Option<&Path>, threads: usize) -> Result<Kind, DenoiseError> {
    oidn::Device::open(library, threads).map(Kind::Oidn)
}

#[cfg(not(feature = "oidn"))]
fn oidn_kind(_: Option<&Path>, _: usize) -> Result<Kind, DenoiseError> {
    Err(DenoiseError::NotBuilt)
}

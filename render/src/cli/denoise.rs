//! `--denoise`: which denoiser, and what it did.

use super::job::Job;
use super::stats::Stats;
use anyhow::{Result, bail};
use kit::with_progress;
use render::denoise::{Choice, Denoiser, Effort};
use render::outlines::{self, GUIDES};
use render::picture::Picture;
use std::path::PathBuf;
use std::time::Instant;

/// Options of the denoiser.
#[derive(Debug, clap::Args)]
pub(super) struct Denoising {
    /// Take the grain out of the picture [default: auto with --time, off otherwise].
    ///
    /// A picture of few samples per pixel is grainy. A denoiser guesses the picture of many samples from it: mostly right and at a
    /// hundredth of the time, but a guess; leave it off for references and where noise is measured. Lamps and sky that are seen
    /// directly are left as they are. EXR keeps the noisy picture in the layer `noisy`.
    #[arg(long, value_enum)]
    denoise: Option<Mode>,
    /// Library of Open Image Denoise, or the folder that holds it [default: the environment variable OIDN_LIBRARY, else where
    /// the system finds libraries].
    ///
    /// `pip download --no-deps pyoidn` and `python3 -m zipfile -e pyoidn-*.whl oidn` leave it in oidn/pyoidn/oidn/lib.
    #[arg(long, value_name = "FILE|DIR")]
    oidn: Option<PathBuf>,
}

/// Which denoiser.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Mode {
    /// Open Image Denoise where it is found, else builtin.
    Auto,
    /// Intel's Open Image Denoise, a neural network: the better one. Its library is loaded when the program runs, and has to be
    /// there (see --oidn).
    Oidn,
    /// Our own: needs nothing.
    Builtin,
    /// Leave the noise in.
    Off,
}

impl Denoising {
    /// Whether the noise is to be left in.
    pub fn is_off(&self) -> bool {
        self.denoise == Some(Mode::Off)
    }

    /// Whether anything is asked for but to leave the noise in.
    pub fn is_given(&self) -> bool {
        self.oidn.is_some() || self.denoise.is_some_and(|mode| mode != Mode::Off)
    }

    /// Opens the denoiser, before the work begins; `None` for none.
    ///
    /// # Errors
    /// A library that is asked for and cannot be loaded, or is not asked for.
    pub fn open(&self, timed: bool, threads: usize) -> Result<Option<Denoiser>> {
        let choice = match self.denoise.unwrap_or(if timed { Mode::Auto } else { Mode::Off }) {
            Mode::Auto => Choice::Auto,
            Mode::Oidn => Choice::Oidn,
            Mode::Builtin if self.oidn.is_none() => Choice::Builtin,
            Mode::Off if self.oidn.is_none() => return Ok(None),
            Mode::Builtin | Mode::Off => bail!("--oidn needs --denoise oidn or auto: nothing else uses the library"),
        };
        Ok(Some(Denoiser::open(choice, self.oidn.as_deref(), threads)?))
    }
}

/// Denoises a picture of a job, and tells what was done; the picture stays noisy where that fails.
///
/// # Errors
/// What the library says.
pub(super) fn apply(
    denoiser: &Denoiser,
    effort: Effort,
    job: &Job,
    picture: &mut Picture,
    stats: &mut Stats,
) -> Result<()> {
    let start = Instant::now();
    outlines::refine((&job.world, &job.world.scene.camera), picture, (job.seed, job.indirect_only), GUIDES);
    let bounded = with_progress("denoise", |progress| denoiser.denoise_telling(picture, effort, progress))?;
    let seconds = start.elapsed().as_secs_f64();
    stats.denoised(denoiser.name(), seconds, bounded);
    let why = denoiser.note().map(|note| format!(" ({note})")).unwrap_or_default();
    eprintln!("render: denoised by {} in {seconds:.2} s{why}", denoiser.name());
    Ok(())
}

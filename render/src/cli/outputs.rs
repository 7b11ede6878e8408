//! The files of `render image`: looked at before the work begins, and every one of them tried at its end.

use super::image::Args;
use super::job::Job;
use super::stats::Stats;
use anyhow::{Result, bail};
use kit::output::{self, Outputs};
use render::image::{Format, write_picture, write_png};
use render::inspect::overlay::show_records;
use render::integrator::cached::policy::Policy;
use render::integrator::cached::{Caches, Settings, file};
use render::picture::Picture;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Refuses places that cannot be written, names that do not say which format, and the files `read` besides those that the
/// command line names.
///
/// # Errors
/// The first such place.
pub(super) fn check(args: &Args, read: &[PathBuf]) -> Result<()> {
    let extensions: Vec<_> = ["exr"].into_iter().chain(Format::EXTENSIONS).collect();
    let named = [args.scene.as_path()].into_iter().chain(args.reading.files());
    let mut outputs = Outputs::beside(named.chain(read.iter().map(PathBuf::as_path)));
    for path in &args.output {
        outputs.file_of(path, &extensions)?;
    }
    if let Some(path) = &args.show_records {
        outputs.file_of(path, &["png"])?;
    }
    for path in args.cache.iter().chain(&args.stats) {
        outputs.file(path)?;
    }
    args.looking.check(&args.output, args.show_records.is_some())
}

/// Records of a run, with what they were made for.
pub(super) struct Records {
    pub policy: Policy,
    pub settings: Settings,
    pub tolerance: f32,
    pub caches: Caches,
}

/// Writes the picture, then what belongs to it. One file that cannot be written does not take another with it.
///
/// # Errors
/// All files that could not be written.
pub(super) fn write(
    args: &Args,
    job: &Job,
    picture: &Picture,
    records: Option<&Records>,
    stats: &mut Stats,
    start: Instant,
) -> Result<()> {
    let writing = Instant::now();
    let Job { world, look, .. } = job;
    let mut failures = Vec::new();
    let mut tried = |path: &Path, result: Result<()>| {
        if let Err(error) = result {
            failures.push(kit::one_line(&error.context(path.display().to_string())));
        }
    };
    for path in &args.output {
        tried(path, write_picture(path, picture, look).map_err(Into::into));
    }
    if let Some(Records { policy, settings, tolerance, caches }) = records {
        if let Some(path) = &args.show_records {
            // Records keep their colours: the view is of the picture below them.
            let shown = show_records(&look.display.shown(&picture.image()), world, caches);
            tried(path, write_png(path, &shown).map_err(Into::into));
        }
        if let Some(path) = &args.cache {
            tried(path, file::save(path, world, policy, settings, *tolerance, caches).map_err(Into::into));
        }
    }
    stats.seconds.write = writing.elapsed().as_secs_f64();
    stats.seconds.total = start.elapsed().as_secs_f64();
    if let Some(path) = &args.stats {
        let text = serde_json::to_string_pretty(stats)? + "\n";
        tried(path, output::write(path, text.as_bytes()).map_err(Into::into));
    }
    if !failures.is_empty() {
        bail!("{}", failures.join("; "));
    }
    Ok(())
}

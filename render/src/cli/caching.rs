//! Rendering through caches, and what is told of it.

use super::job::Caching;
use super::outputs::Records;
use super::stats::Stats;
use anyhow::{Result, anyhow};
use kit::with_progress;
use render::integrator::cached::file::{self, CacheFileError};
use render::integrator::cached::kinds::KINDS;
use render::integrator::cached::policy::Policy;
use render::integrator::cached::{Figures, render_cached};
use render::picture::Picture;
use render::tables::Tables;
use render::world::World;
use std::time::{Duration, Instant};

/// Renders; tells what it does with each material.
///
/// # Errors
/// A table that cannot be fitted, a file of records that is of no use.
pub(super) fn render(caching: &Caching, world: &World, stats: &mut Stats) -> Result<(Picture, Records)> {
    let Caching { settings, tolerance, .. } = caching;
    let (policy, fitting) = decide(caching, world)?;
    let mut kept = None;
    if let Some(path) = caching.file.as_ref().filter(|p| p.exists()) {
        let loaded = file::load(path, world, &policy, settings, *tolerance);
        kept = Some(loaded.map_err(|e: CacheFileError| anyhow!("{}: {e}", path.display()))?);
    }
    let (picture, figures, caches) =
        with_progress("image", |progress| render_cached(world, &policy, settings, kept, progress));
    stats.take(&figures, fitting, &policy.notes);
    report(&figures);
    Ok((picture, Records { policy, settings: *settings, tolerance: *tolerance, caches }))
}

/// Decides on the materials, and how long what had to be fitted took.
pub(super) fn decide(caching: &Caching, world: &World) -> Result<(Policy, Duration)> {
    let mut tables = Tables::open(&caching.tables)?;
    let deciding = Instant::now();
    let policy = Policy::with_bases(&world.scene, caching.allowed, caching.bases, |recipe| tables.find(recipe))?;
    let fitting = if policy.is_without_tables() { deciding.elapsed() } else { tables.fitting };
    for note in tables.notes.iter().chain(&policy.notes) {
        eprintln!("render: {note}");
    }
    Ok((policy, fitting))
}

/// Times, records and their size, in words.
fn report(figures: &Figures) {
    if figures.card_failed {
        eprintln!("render: the graphics adapter failed; the processor summed the records");
    }
    if figures.negative_pixels > 0 {
        eprintln!("render: indirect light is negative in {} pixels: ringing", figures.negative_pixels);
    }
    let kinds = figures.glossy.iter().zip(&KINDS).filter(|(kind, _)| kind.records > 0);
    let glossy: String =
        kinds.map(|(kind, what)| format!("{} and {:.0} bytes, ", (what.sentence)(kind), kind.mean_bytes())).collect();
    eprintln!(
        "render: {:.2} s to fill, {:.2} s to shade; {glossy}{} irradiance records; {} KB in all; tau {:.4}",
        figures.fill.as_secs_f64(),
        figures.shade.as_secs_f64(),
        figures.irradiance_records,
        figures.bytes / 1000,
        figures.tolerance
    );
}

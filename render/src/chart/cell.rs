//! One cell of a sweep: a scene, a method, a setting.

use super::method::{Engine, Method};
use super::plan::Plan;
use super::row::Row;
use super::setting::Setting;
use super::subject::Subject;
use anyhow::{Context, Result};
use render::film;
use render::image::{Image, write_png};
use render::integrator::PathTracer;
use render::integrator::cached::policy::{Allowed, Policy};
use render::integrator::cached::{Figures, Interpolation, Settings, render_cached};
use render::metric::defects::Defects;
use render::metric::{compare, false_color};
use render::outlines::{self, GUIDES};
use render::picture::{Budget, Picture};
use render::tables::Tables;
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// Decisions on the materials of a scene, made once for all settings.
pub struct Policies<'a> {
    tables: &'a mut Tables,
    known: Vec<(Allowed, Policy)>,
}

impl<'a> Policies<'a> {
    /// None yet.
    pub fn new(tables: &'a mut Tables) -> Self {
        Self { tables, known: Vec::new() }
    }

    /// Makes sure that those of a cell are there: tables may have to be fitted.
    ///
    /// # Errors
    /// A material that cannot be fitted.
    pub fn prepare(&mut self, subject: &Subject, method: &Method, setting: Setting) -> Result<()> {
        let Engine::Cached(allowed, ..) = method.engine else { return Ok(()) };
        let allowed = allowed(setting);
        if !self.known.iter().any(|(a, _)| *a == allowed) {
            let policy = Policy::new(&subject.world.scene, allowed, |recipe| self.tables.find(recipe))?;
            self.known.push((allowed, policy));
        }
        Ok(())
    }

    fn of(&self, allowed: Allowed) -> Result<&Policy> {
        let found = self.known.iter().find(|(a, _)| *a == allowed);
        Ok(&found.context("the method was not prepared")?.1)
    }
}

/// Files of a cell: the picture, and its difference from the reference.
pub fn pictures(plan: &Plan, subject: &Subject, row: &Row) -> [PathBuf; 2] {
    let stem = format!("{}-{}-{}-{}-{}", row.scene, subject.digest, row.method, row.setting, row.seed);
    ["", "-difference"].map(|kind| plan.output.join("pictures").join(format!("{stem}{kind}.png")))
}

/// The row of a cell before it is run: what it is known by.
pub fn blank(plan: &Plan, subject: &Subject, method: &Method, setting: Setting) -> Row {
    let window = subject.world.scene.camera.film.window();
    Row {
        scene: subject.name.clone(),
        digest: subject.digest.clone(),
        method: method.name.into(),
        setting: setting.to_string(),
        seed: plan.seed,
        width: window.width,
        height: window.height,
        ..Row::default()
    }
}

/// Renders, compares, writes the pictures.
///
/// # Errors
/// Pictures that cannot be written.
pub fn run(
    plan: &Plan,
    subject: &Subject,
    policies: &Policies,
    (method, setting): (&Method, Setting),
    progress: &(dyn Fn(f64) + Sync),
) -> Result<Row> {
    let pixels = |row: &Row| u64::from(row.width) * u64::from(row.height);
    let mut row = blank(plan, subject, method, setting);
    let denoiser = plan.denoiser.as_ref().filter(|_| method.denoised);
    let from_records = matches!(method.engine, Engine::Cached(..));
    let total = if let Setting::Time(seconds) = setting { Some(seconds) } else { None };
    let denoising = denoiser.map(|d| d.plan(pixels(&row), from_records, total).map(|plan| (d, plan))).transpose()?;
    let budget = match setting {
        Setting::Time(seconds) => {
            let aside = denoising.map_or(0.0, |(_, plan)| plan.seconds + outlines::seconds(&subject.world, seconds));
            Budget::Time(Duration::from_secs_f64(seconds - aside.min(0.5 * seconds)))
        }
        Setting::Tau(_) | Setting::Order(..) | Setting::Sources(..) => Budget::Samples(plan.spp),
        Setting::Spp(n) => Budget::Samples(n),
    };
    let mut picture = match method.engine {
        Engine::Traced => {
            let start = Instant::now();
            let settings = subject.world.scene.integrator;
            let integrator = PathTracer { settings, indirect_only: plan.indirect_only };
            let picture = film::render(&subject.world, &integrator, budget, plan.seed, progress);
            row.shade = start.elapsed().as_secs_f64();
            picture
        }
        Engine::Cached(allowed, estimator, spacing) => {
            let sources = if let Setting::Sources(n, _) = setting { Some(usize::from(n)) } else { None };
            let settings = Settings {
                tolerance: setting.tau(),
                estimator,
                spacing,
                sources,
                budget,
                seed: plan.seed,
                indirect_only: plan.indirect_only,
                interpolation: Interpolation::Auto,
            };
            let policy = policies.of(allowed(setting))?;
            let (picture, figures, _) = render_cached(&subject.world, policy, &settings, None, progress);
            note_caches(&mut row, &figures);
            picture
        }
    };
    if let Some((denoiser, how)) = denoising {
        let start = Instant::now();
        let from = (&subject.world, &subject.world.scene.camera);
        outlines::refine(from, &mut picture, (plan.seed, plan.indirect_only), GUIDES);
        denoiser.denoise(&mut picture, how.effort)?;
        row.denoise = start.elapsed().as_secs_f64();
    }
    row.seconds = row.fill + row.shade + row.denoise;
    row.spp = picture.spp;
    judge(&mut row, &picture, &subject.reference)?;
    row.round();
    let image = picture.image();
    let [shown, difference] = pictures(plan, subject, &row);
    write_png(&shown, &image)?;
    write_png(&difference, &false_color(&image, &subject.reference)?)?;
    Ok(row)
}

fn note_caches(row: &mut Row, figures: &Figures) {
    (row.fill, row.shade) = (figures.fill.as_secs_f64(), figures.shade.as_secs_f64());
    row.tau = f64::from(figures.tolerance);
    let glossy = figures.all_glossy();
    row.records = figures.records() as u64;
    row.glossy_records = glossy.records as u64;
    row.size = glossy.mean();
    row.bytes_per_record = glossy.mean_bytes();
    // Before the picture was kept from it.
    row.negative = figures.negative_pixels as f64 / (f64::from(row.width) * f64::from(row.height)).max(1.0);
    row.bytes = figures.bytes as u64;
}

fn judge(row: &mut Row, picture: &Picture, reference: &Image) -> Result<()> {
    let image = picture.image();
    let figures = compare(&image, reference)?;
    (row.rmse, row.rel_mse, row.bias) = (figures.rmse, figures.rel_mse, figures.bias);
    (row.max, row.flip) = (figures.max, figures.flip);
    let defects = Defects::new(&image, reference)?;
    (row.blocks, row.worst, row.leaks) = (defects.blocks, defects.worst, defects.leaks);
    row.negative = row.negative.max(defects.negative);
    Ok(())
}

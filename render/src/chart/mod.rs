//! Speed against accuracy of all methods: a sweep, its table, its figures, its page.

mod cell;
mod figures;
mod machine;
pub mod method;
pub(crate) mod page;
pub mod plan;
pub(crate) mod plot;
mod row;
pub mod setting;
mod subject;

use anyhow::{Context, Result, ensure};
use cell::Policies;
use kit::Progress;
use kit::output;
use plan::Plan;
use render::tables::Tables;
use row::Row;
use setting::Setting;
use std::cell::Cell;
use subject::Subject;

/// Results of a chart.
pub struct Results<'a> {
    /// What was asked for.
    pub plan: &'a Plan,
    /// Scenes.
    pub subjects: Vec<Subject>,
    /// What is known of them: also what earlier runs and peers left in the folder.
    pub rows: Vec<Row>,
}

impl Results<'_> {
    /// Rows of a scene as it is now.
    pub fn of<'a>(&'a self, subject: &'a Subject) -> impl Iterator<Item = &'a Row> + Clone {
        self.rows.iter().filter(|r| r.scene == subject.name && r.digest == subject.digest && r.seed == self.plan.seed)
    }
}

/// Runs what is missing, row by row, and writes the figures and the page.
///
/// # Errors
/// Bad scenes, references, files of an earlier run; places that cannot be written.
pub fn run(plan: &Plan) -> Result<()> {
    let names: Vec<_> = plan.scenes.iter().map(|p| subject::name(p)).collect();
    for (i, name) in names.iter().enumerate() {
        ensure!(!names[..i].contains(name), "{name}: two scenes of this name; chart them into different folders");
    }
    // All that can be refused is looked at before any work is done.
    let table = plan.output.join("chart.csv");
    output::check_folder(&plan.output)?;
    let mut rows = row::load(&table)?;
    let mut tables = Tables::open(&plan.tables)?;
    let scenes = plan.scenes.iter().enumerate().map(|(i, p)| subject::load_scene(plan, p, plan.references.get(i)));
    let scenes = scenes.collect::<Result<Vec<_>>>()?;
    for folder in [plan.output.clone(), plan.output.join("pictures")] {
        std::fs::create_dir_all(&folder).with_context(|| folder.display().to_string())?;
    }
    let bar = Bar::new(plan, scenes.len());
    let mut subjects = Vec::new();
    for scene in scenes {
        bar.begin(format!("{}: reference", scene.name));
        let subject = scene.with_reference(plan, &bar.shares(REFERENCE_WEIGHT))?;
        bar.end(REFERENCE_WEIGHT);
        let mut policies = Policies::new(&mut tables);
        for (method, setting) in plan.cells() {
            let blank = cell::blank(plan, &subject, method, setting);
            let known = rows.iter().position(|r| r.key() == blank.key());
            let pictures = cell::pictures(plan, &subject, &blank);
            if known.is_none() || !pictures.iter().all(|p| p.exists()) {
                bar.begin(format!("{}: {} {setting}", subject.name, method.name));
                policies.prepare(&subject, method, setting)?;
                let row = cell::run(plan, &subject, &policies, (method, setting), &bar.shares(weight(setting)))?;
                bar.say(&format!(
                    "{}: {} {setting}: {:.2} s, rel_mse {:.5}",
                    row.scene, row.method, row.seconds, row.rel_mse
                ));
                match known {
                    Some(i) => rows[i] = row,
                    None => rows.push(row),
                }
                row::save(&table, &rows)?;
            }
            bar.end(weight(setting));
        }
        subjects.push(subject);
    }
    tables.notes.iter().for_each(|note| bar.say(note));
    drop(bar);
    page::write(&Results { plan, subjects, rows })
}

/// About the seconds of a reference and of a run, for the time left.
const REFERENCE_WEIGHT: f64 = 60.0;

fn weight(setting: Setting) -> f64 {
    match setting {
        Setting::Time(seconds) => seconds,
        Setting::Tau(tau) | Setting::Order(_, tau) | Setting::Sources(_, tau) => 0.5 + 0.04 / f64::from(tau),
        Setting::Spp(_) => 1.0,
    }
}

/// One bar for all the work, by weight.
struct Bar {
    bar: Progress,
    total: f64,
    /// Weight of what is done.
    done: Cell<f64>,
}

impl Bar {
    fn new(plan: &Plan, scenes: usize) -> Self {
        let cells: f64 = plan.cells().iter().map(|(_, s)| weight(*s)).sum();
        Self { bar: Progress::new("chart"), total: scenes as f64 * (cells + REFERENCE_WEIGHT), done: Cell::new(0.0) }
    }

    fn begin(&self, what: String) {
        self.bar.name(what);
    }

    /// Tells the shares of a piece of work of a weight.
    fn shares(&self, weight: f64) -> impl Fn(f64) + Sync {
        let (bar, total, done) = (&self.bar, self.total, self.done.get());
        move |share: f64| bar.set((done + share.clamp(0.0, 1.0) * weight) / total)
    }

    fn end(&self, weight: f64) {
        self.done.set(self.done.get() + weight);
        self.shares(0.0)(0.0);
    }

    /// A line that stays.
    fn say(&self, line: &str) {
        self.bar.say(&format!("render: {line}"));
    }
}

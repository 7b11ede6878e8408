//! `fitter info`: what a table holds, how it was made, how good it is.

use super::arguments::{self, File};
use super::{Outcome, family, report};
use brdf_tables::family::Family;
use brdf_tables::table::{Representation, Table};
use kit::text::percent;
use serde_json::{Value, json};
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::PathBuf;

const EXAMPLES: &str = "\
Examples:
  fitter info phong.tbl
  fitter info phong.tbl --json | jq .off_nodes.p95.rmse_lobe";

/// Show what a table holds, how it was made and how good it is
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    /// Table, as `fitter fit` writes it, or family, as `fitter fit-family` does
    file: PathBuf,
    /// Print JSON: errors as fractions
    #[arg(long)]
    json: bool,
}

/// Prints the description.
pub fn run(args: Args) -> anyhow::Result<Outcome> {
    let file = arguments::file(&args.file)?;
    let bytes = std::fs::metadata(&args.file)?.len();
    let text = match (file, args.json) {
        (File::Table(table), true) => format!("{:#}\n", json(&table, bytes)),
        (File::Table(table), false) => text(&table, bytes),
        (File::Family(family), true) => format!("{:#}\n", family_json(&family, bytes)),
        (File::Family(family), false) => family_text(&family, bytes),
    };
    std::io::stdout().lock().write_all(text.as_bytes())?;
    Ok(Outcome::Done)
}

fn text(table: &Table, bytes: u64) -> String {
    let header = &table.header;
    let axes = table.axes;
    let mut text = String::new();
    let mut line = |name: &str, value: String| {
        let _ = writeln!(text, "{name:<16}{value}");
    };
    line("material", header.material.to_string());
    line("representation", format!("{}, {}", table.representation_name(), grid(table)));
    line("size", format!("{bytes} bytes"));
    if !table.cells.is_empty() {
        line("error grid", format!("{} theta_e x {} phi_e x {} omega", axes.theta, axes.phi, axes.omega));
        let [median, p95, worst] = header.promise.map(percent);
        line("promise", format!("rmse_lobe median {median} %, p95 {p95} %, worst {worst} %"));
    }
    line("tolerance", format!("{} %", percent(header.tolerance)));
    line("made by", header.creator.clone());
    line("command", header.command.clone());
    line("seed", header.seed.to_string());
    for note in &header.notes {
        line("note", note.clone());
    }
    if !table.cells.is_empty() {
        let sets =
            [("at nodes", &header.at_nodes), ("off nodes", &header.off_nodes), ("across horizon", &header.clipped)];
        text.push_str(&report::errors_table(&sets));
    }
    text
}

/// Size of the representation in words.
fn grid(table: &Table) -> String {
    match &table.representation {
        Representation::Diffuse => "nothing to look up".into(),
        Representation::Zonal(t) => {
            let (rows, columns, ..) = t.parts();
            format!("{rows} x {columns} pairs")
        }
        Representation::Cubature(t) => format!("rules at {} nodes", t.parts().1.len()),
        Representation::Lobes(t) => {
            let (axes, lobes, _) = t.parts();
            format!("{lobes} lobes at {} x {} x {} nodes", axes.theta, axes.phi, axes.omega)
        }
        Representation::Paper(t) => {
            let (elevations, solid_angles, lobes, _) = t.parts();
            format!("{lobes} lobes at {elevations} x {solid_angles} cells")
        }
    }
}

fn json(table: &Table, bytes: u64) -> Value {
    let header = &table.header;
    let [median, p95, worst] = header.promise;
    json!({
        "material": header.material.to_string(),
        "representation": table.representation_name(),
        "grid": grid(table),
        "bytes": bytes,
        "error_grid": { "theta": table.axes.theta, "phi": table.axes.phi, "omega": table.axes.omega },
        "tolerance": header.tolerance,
        "promise": { "median": median, "p95": p95, "worst": worst },
        "creator": header.creator,
        "command": header.command,
        "seed": header.seed,
        "notes": header.notes,
        "at_nodes": report::summary_json(&header.at_nodes),
        "off_nodes": report::summary_json(&header.off_nodes),
        "clipped": report::summary_json(&header.clipped),
    })
}

fn family_text(found: &Family, bytes: u64) -> String {
    let header = &found.header;
    let [median, p95, worst] = header.promise.map(percent);
    let mut text = String::new();
    let mut line = |name: &str, value: String| {
        let _ = writeln!(text, "{name:<16}{value}");
    };
    line("family", family::name(found));
    line("representation", family::representation(found).into());
    line("size", format!("{bytes} bytes"));
    line("promise", format!("rmse_lobe median {median} %, p95 {p95} %, worst {worst} %"));
    line("tolerance", format!("{} %", percent(header.tolerance)));
    line("made by", header.creator.clone());
    line("command", header.command.clone());
    line("seed", header.seed.to_string());
    text + &family::text(found)
}

fn family_json(found: &Family, bytes: u64) -> Value {
    let header = &found.header;
    let [median, p95, worst] = header.promise;
    json!({
        "family": header.kin.name(),
        "representation": family::representation(found),
        "bytes": bytes,
        "widths": header.lattice.widths,
        "reach": header.lattice.reach,
        "tolerance": header.tolerance,
        "promise": { "median": median, "p95": p95, "worst": worst },
        "creator": header.creator,
        "command": header.command,
        "seed": header.seed,
        "notes": header.notes,
        "at_nodes": report::summary_json(&header.at_nodes),
        "off_nodes": report::summary_json(&header.off_nodes),
        "clipped": report::summary_json(&header.clipped),
    })
}

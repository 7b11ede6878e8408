//! `fitter check`: measures a table against an independent integration.

use super::arguments::{self, File};
use super::{Outcome, report};
use brdf_tables::cap::Cap;
use brdf_tables::errors::Errors;
use brdf_tables::family::Family;
use brdf_tables::material::Material;
use brdf_tables::table::Table;
use fitter::check::{Check, check};
use fitter::family::{self, FamilyCheck};
use kit::Progress;
use kit::number::whole;
use kit::text::percent;
use serde_json::{Value, json};
use std::io::Write;
use std::path::PathBuf;

const EXAMPLES: &str = "\
Examples:
  fitter check phong.tbl
  fitter check phong.tbl --points 5000 --seed 7
  fitter check phong.tbl --json | jq .passed
  fitter check brdf-tables/families/ggx.fam --points 100

JSON keys: file, material (family for a family), representation, points, seed,
passed, promise, main, clipped, wide, worst. Errors are fractions, angles radian,
solid angles sr.";

/// Measure a table, or a family of tables, against an independent integration
///
/// Draws random caps off the nodes of the table: of its main domain (radius up to 2.5 lobe widths, zenith up to 84
/// degrees), which the promise is about, and a quarter as many across the horizon and of any width. Of a family, each is
/// of another member, its roughness drawn off the nodes too. The exit code is 1 when the table is worse than it promises.
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    /// Table, as `fitter fit` writes it, or family, as `fitter fit-family` does
    file: PathBuf,
    /// Random caps of the main domain
    #[arg(long, value_name = "N", default_value_t = 500, value_parser = whole(1..=1_000_000u32, ""))]
    points: u32,
    /// Seed of the caps
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = whole(0..=u64::MAX, ""))]
    seed: u64,
    /// Print JSON
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    threads: arguments::Threads,
}

/// Checks and reports.
pub fn run(args: Args) -> anyhow::Result<Outcome> {
    args.threads.apply()?;
    let file = arguments::file(&args.file)?;
    let progress = Progress::new("check");
    let told = |fraction| progress.set(fraction);
    let (passed, text) = match file {
        File::Table(table) => {
            let check = check(&table, args.points as usize, args.seed, &told);
            let json = || format!("{:#}\n", json(&args, &table, &check));
            (check.passed, if args.json { json() } else { text(&args, &table, &check) })
        }
        File::Family(family) => {
            let check = family::check(&family, args.points as usize, args.seed, &told);
            let json = || format!("{:#}\n", family_json(&args, &family, &check));
            (check.passed, if args.json { json() } else { family_text(&args, &family, &check) })
        }
    };
    drop(progress);
    std::io::stdout().lock().write_all(text.as_bytes())?;
    Ok(if passed { Outcome::Done } else { Outcome::CheckFailed })
}

fn verdict(passed: bool) -> &'static str {
    if passed { "passed" } else { "FAILED" }
}

fn text(args: &Args, table: &Table, check: &Check) -> String {
    let (verdict, name, material) = (verdict(check.passed), table.representation_name(), table.header.material);
    let mut text = format!("{}: {verdict}, {name} {material}\n", args.file.display());
    let Some((cap, errors)) = &check.worst else {
        return text + "the mean BRDF is the constant kd/pi: there is nothing to measure\n";
    };
    let sets = [("main domain", &check.main), ("across horizon", &check.clipped), ("wide caps", &check.wide)];
    text += &report::errors_table(&sets);
    text + &worst_and_promise("", cap, errors, check.promise)
}

fn worst_and_promise(of: &str, cap: &Cap, errors: &Errors, promise: [f64; 3]) -> String {
    let [median, p95, worst] = promise.map(percent);
    let (theta, phi, omega) = (cap.theta(), cap.phi(), cap.solid_angle());
    let largest = percent(f64::from(errors.rmse_lobe));
    format!(
        "worst cap: {of}theta_e = {theta:.4} rad, phi_e = {phi:.4} rad, omega = {omega:.4e} sr, rmse_lobe {largest} %\n\
         promised rmse_lobe: median {median} %, p95 {p95} %, worst {worst} %\n"
    )
}

fn family_text(args: &Args, family: &Family, check: &FamilyCheck) -> String {
    let (specular, cap, errors) = &check.worst;
    let sets = [("main domain", &check.main), ("across horizon", &check.clipped), ("wide caps", &check.wide)];
    let promise = family.header.promise;
    let name = super::family::name(family);
    format!("{}: {}, family {name}\n", args.file.display(), verdict(check.passed))
        + &report::errors_table(&sets)
        + &worst_and_promise(&format!("{}, ", Material::specular(*specular)), cap, errors, promise)
}

/// As [`json`]; `worst` names the member.
fn family_json(args: &Args, family: &Family, check: &FamilyCheck) -> Value {
    let (specular, cap, errors) = &check.worst;
    let [median, p95, worst] = family.header.promise;
    json!({
        "file": args.file.display().to_string(),
        "family": super::family::name(family),
        "representation": super::family::representation(family),
        "points": args.points,
        "seed": args.seed,
        "passed": check.passed,
        "promise": { "median": median, "p95": p95, "worst": worst },
        "main": report::summary_json(&check.main),
        "clipped": report::summary_json(&check.clipped),
        "wide": report::summary_json(&check.wide),
        "worst": {
            "material": Material::specular(*specular).to_string(),
            "theta_e": cap.theta(),
            "phi_e": cap.phi(),
            "omega": cap.solid_angle(),
            "errors": report::errors_json(errors),
        },
    })
}

/// The report as JSON; `worst` is null when there is nothing to measure.
fn json(args: &Args, table: &Table, check: &Check) -> Value {
    let [median, p95, worst] = check.promise;
    json!({
        "file": args.file.display().to_string(),
        "material": table.header.material.to_string(),
        "representation": table.representation_name(),
        "points": args.points,
        "seed": args.seed,
        "passed": check.passed,
        "promise": { "median": median, "p95": p95, "worst": worst },
        "main": report::summary_json(&check.main),
        "clipped": report::summary_json(&check.clipped),
        "wide": report::summary_json(&check.wide),
        "worst": check.worst.map(|(cap, errors)| json!({
            "theta_e": cap.theta(),
            "phi_e": cap.phi(),
            "omega": cap.solid_angle(),
            "errors": report::errors_json(&errors),
        })),
    })
}

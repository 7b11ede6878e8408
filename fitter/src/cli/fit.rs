//! `fitter fit`: from a material to a table.

use super::{Outcome, arguments, report};
use anyhow::{Context, anyhow, bail};
use brdf_tables::material::Material;
use brdf_tables::table::Table;
use clap::ValueEnum;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use core::ops::{ControlFlow, RangeInclusive};
use fitter::fit::{Choice, FitError, Options, TOLERANCE, fit};
use fitter::recipe;
use fitter::solver::SolverKind;
use kit::Progress;
use kit::number::{number, whole};
use kit::output::{self, Outputs};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

const EXAMPLES: &str = "\
Examples:
  fitter fit phong:exponent=100
      the cheapest representation, to phong-exponent-100.tbl
  fitter fit tables/ward-0.1-0.5.toml
      a recipe in a file, to tables/ward-0.1-0.5.tbl
  fitter fit gold-metallic-paint.binary
      measured data: what was read and how it is kept, to gold-metallic-paint.tbl
  fitter fit ggx:alpha=0.1,f0=0.04,kd=0.3 --tolerance 0.001 -o plastic.tbl
      ten times the accuracy of an image
  fitter fit phong:exponent=40 --preset paper
      as published in 2015, the baseline
  fitter fit phong:exponent=40 --solver nelder-mead --lobes 3
      lobes by a solver of your choice

Models and their keys, beside kd and ks:
  lambert      reflectance (and no kd or ks)
  phong        exponent
  lafortune    lobes=[[cx,cy,cz,n],...]
  ward         alpha_x, alpha_y, variant
  beckmann     alpha (or alpha_x, alpha_y), f0 (or eta, k)
  ggx          as beckmann
  sheen        alpha (0.07 to 1), the fibres of velvet
A colour is one number or [r,g,b].

Measured data, by what the name ends in:
  .binary   MERL: 90 x 90 x 180 bins (or fewer) of half and difference angles
  .bsdf     RGL: adaptive parametrisation of Dupuy and Jakob 2018, RGB or spectral
  .brdf     text of Cornell: scattered directions, spectra
  .csv      theta_i,theta_o,phi,r,g,b; angles in radian, or _deg; phi = pi is the
            mirror direction
  .sgd .abc parameters fitted by others: kd, ks, alpha, p, f0, f1, kap, lambda, c, k,
            theta0 (Bagher et al. 2012); kd, a, b, c, ior (Low et al. 2012)
  .openpbr  parameters of OpenPBR: base_…, specular_…, coat_…, fuzz_…
The table holds the data themselves, isotropic and reciprocal; kd is the part
that all directions share.";

/// Fit a table of the mean BRDF of a material, and measure its errors
///
/// Prints the representation and why it was chosen, its size, the time, and the five errors of the mean BRDF (root
/// mean square over the hemisphere and over the lobe, L1, largest, albedo) at the nodes, at random caps off them, and at
/// random caps that cross the horizon. The file is written at the end, at once: an interrupted fit leaves none.
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    /// Inline recipe such as phong:exponent=100,ks=1,kd=0, a TOML file, or measured data
    material: String,
    /// Table to write [default: named after the material; beside the recipe when that is a file]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// How to store the mean BRDF [default: auto, the cheapest that meets the tolerance; lobes with --solver or --lobes]
    #[arg(long, value_name = "NAME", conflicts_with = "preset", value_parser = choices())]
    representation: Option<Choice>,
    /// Settings as a whole: paper is the lobe table of 2015, fitted by the genetic algorithm, polished
    #[arg(long, value_name = "NAME")]
    preset: Option<Preset>,
    /// Optimiser of the lobes [default: lm, the fastest and the most accurate]
    #[arg(long, value_name = "NAME", value_parser = solvers())]
    solver: Option<SolverKind>,
    /// Lobes per cell, 1 to 16, or auto: as few as the tolerance needs [default: auto; 1 with --preset paper]
    #[arg(long, value_name = "K|auto", allow_hyphen_values = true)]
    lobes: Option<Count>,
    /// Root mean square error over the lobe to reach, as a fraction of the peak
    #[arg(long, value_name = "T", default_value_t = TOLERANCE, value_parser = number(TOLERANCES, "a fraction between 0 and 1, 0.005 for 0.5 %"))]
    tolerance: f64,
    /// Seed of the random solvers and of the caps at which errors are measured
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = whole(0..=u64::MAX, ""))]
    seed: u64,
    #[command(flatten)]
    threads: arguments::Threads,
}

/// What `--tolerance` takes.
const TOLERANCES: RangeInclusive<f64> = f64::MIN_POSITIVE..=1.0 - f64::EPSILON;

/// Names that stand for several settings.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Preset {
    Default,
    Paper,
}

/// Number of lobes as typed.
#[derive(Clone, Copy)]
enum Count {
    Auto,
    Exactly(u8),
}

impl std::str::FromStr for Count {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.parse() {
            Ok(count @ 1..=16) => Ok(Self::Exactly(count)),
            _ if text == "auto" => Ok(Self::Auto),
            _ => Err("expected a number in 1..=16 or auto".into()),
        }
    }
}

fn choices() -> impl TypedValueParser<Value = Choice> {
    PossibleValuesParser::new(Choice::ALL.map(Choice::name)).try_map(|name| name.parse::<Choice>())
}

/// Solvers by name, for this command and for `chart`.
pub fn solvers() -> impl TypedValueParser<Value = SolverKind> {
    PossibleValuesParser::new(SolverKind::ALL.map(SolverKind::name)).try_map(|name| name.parse::<SolverKind>())
}

/// What is to be fitted, and how, after every flag has been found to have a meaning.
struct Job {
    material: Material,
    /// What is told of measured data.
    notes: Vec<String>,
    output: PathBuf,
    representation: Choice,
    solver: SolverKind,
    lobes: Option<usize>,
    command: String,
}

impl Args {
    fn validate(&self) -> anyhow::Result<Job> {
        let output = self.output.clone().unwrap_or_else(|| default_output(&self.material));
        Outputs::beside([Path::new(&self.material)]).file(&output)?;
        let (material, notes) = recipe::material_with_notes(&self.material)?;
        let flag = match (self.solver, self.lobes) {
            (Some(_), _) => Some("--solver"),
            (None, Some(_)) => Some("--lobes"),
            (None, None) => None,
        };
        let asked = self.representation.or(self.preset.map(|preset| match preset {
            Preset::Paper => Choice::Paper,
            Preset::Default => Choice::Auto,
        }));
        let representation = Choice::of(&material, asked, flag).map_err(|error| match error {
            FitError::Diffuse(_) => anyhow!("{}: {error}", self.material),
            error => error.into(),
        })?;
        let lobes = match self.lobes {
            Some(Count::Auto) if representation == Choice::Paper => {
                bail!("--lobes auto has no use on the grid of the paper, whose cells have equally many lobes");
            }
            Some(Count::Exactly(count)) => Some(usize::from(count)),
            Some(Count::Auto) | None => None,
        };
        let default = if self.preset == Some(Preset::Paper) {
            SolverKind::GeneticPolished
        } else {
            SolverKind::LevenbergMarquardt
        };
        let solver = self.solver.unwrap_or(default);
        Ok(Job { material, notes, output, representation, solver, lobes, command: self.command() })
    }

    /// The command line with every argument that shapes the bytes of the table: the output and the threads do not.
    fn command(&self) -> String {
        let mut words = vec!["fitter fit".to_string(), quoted(&self.material)];
        let mut flag = |name: &str, value: Option<String>| words.extend(value.map(|value| format!("--{name} {value}")));
        flag("representation", self.representation.map(|choice| choice.to_string()));
        flag("preset", self.preset.map(|preset| if preset == Preset::Paper { "paper" } else { "default" }.into()));
        flag("solver", self.solver.map(|solver| solver.to_string()));
        flag(
            "lobes",
            self.lobes.map(|lobes| match lobes {
                Count::Auto => "auto".into(),
                Count::Exactly(count) => count.to_string(),
            }),
        );
        flag("tolerance", (self.tolerance != TOLERANCE).then(|| self.tolerance.to_string()));
        flag("seed", Some(self.seed.to_string()));
        words.join(" ")
    }
}

/// A word for the shell.
fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_=:,./+".contains(c);
    if word.chars().all(plain) { word.into() } else { format!("'{}'", word.replace('\'', "'\\''")) }
}

/// The recipe's file with another extension, or the words of the inline recipe joined by hyphens.
fn default_output(material: &str) -> PathBuf {
    if material.ends_with(".toml") || Path::new(material).is_file() {
        return Path::new(material).with_extension("tbl");
    }
    let words = material.split(|c: char| !c.is_ascii_alphanumeric() && c != '.').filter(|word| !word.is_empty());
    let mut name = words.collect::<Vec<_>>().join("-");
    name.truncate(100);
    PathBuf::from(name + ".tbl")
}

/// Fits, writes and reports.
pub fn run(args: Args) -> anyhow::Result<Outcome> {
    args.threads.apply()?;
    let job = args.validate()?;
    let progress = Progress::new(format!("fit {}", job.representation));
    let start = Instant::now();
    let options = Options {
        representation: job.representation,
        solver: job.solver,
        lobes: job.lobes,
        tolerance: args.tolerance,
        seed: args.seed,
        command: job.command.clone(),
        progress: &|fraction| {
            progress.set(fraction);
            ControlFlow::Continue(())
        },
    };
    let mut table = fit(&job.material, &options).with_context(|| args.material.clone())?;
    table.header.notes.splice(0..0, job.notes.iter().cloned());
    let seconds = start.elapsed().as_secs_f64();
    drop(progress);
    let bytes = table.to_bytes().with_context(|| job.output.display().to_string())?;
    output::write(&job.output, &bytes)?;
    std::io::stdout().lock().write_all(text(&job, &table, bytes.len(), seconds).as_bytes())?;
    Ok(Outcome::Done)
}

fn text(job: &Job, table: &Table, bytes: usize, seconds: f64) -> String {
    let header = &table.header;
    let mut text =
        format!("{}: {}, {bytes} bytes, {seconds:.2} s\n", job.output.display(), table.representation_name());
    for note in &header.notes {
        text.push_str(&format!("  {note}\n"));
    }
    let sets = [("at nodes", &header.at_nodes), ("off nodes", &header.off_nodes), ("across horizon", &header.clipped)];
    if table.mean().is_some() {
        text.push_str(&report::errors_table(&sets));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn output_is_named_after_the_material() {
        let name = |material: &str| default_output(material).display().to_string();
        assert_eq!(name("phong:exponent=100,ks=0.5"), "phong-exponent-100-ks-0.5.tbl");
        assert_eq!(name("lafortune:lobes=[[-1, -1, 1, 20]]"), "lafortune-lobes-1-1-1-20.tbl");
        assert_eq!(name("some/ward-0.1.toml"), "some/ward-0.1.tbl");
    }

    #[test]
    fn words_are_quoted_for_the_shell() {
        assert_eq!(quoted("phong:exponent=100,ks=0.5"), "phong:exponent=100,ks=0.5");
        assert_eq!(quoted("it's [1, 2]"), "'it'\\''s [1, 2]'");
    }
}

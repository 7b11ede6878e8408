//! Arguments and values that several subcommands take.

use anyhow::{Context, bail, ensure};
use brdf_tables::Family;
use brdf_tables::format::FormatError;
use brdf_tables::table::Table;
use core::f64::consts::{PI, TAU};
use kit::{number::whole, output::Outputs};
use std::path::Path;

/// Number of worker threads; results do not depend on it.
#[derive(clap::Args)]
pub struct Threads {
    /// Worker threads [default: one per core]; the result is the same for any number
    #[arg(long, value_name = "N", value_parser = whole(1..=1024u16, ""))]
    threads: Option<u16>,
}

impl Threads {
    /// Sets up the thread pool of the process.
    pub fn apply(&self) -> anyhow::Result<()> {
        let Some(threads) = self.threads else { return Ok(()) };
        let pool = rayon::ThreadPoolBuilder::new().num_threads(usize::from(threads));
        pool.build_global().with_context(|| format!("--threads {threads}"))
    }
}

/// Loads a table, naming the file in an error.
pub fn table(path: &Path) -> anyhow::Result<Table> {
    match file(path)? {
        File::Table(table) => Ok(*table),
        File::Family(_) => {
            bail!("{}: a family of tables, where the table of one material is asked for", path.display())
        }
    }
}

/// What `fitter` makes.
pub enum File {
    /// Of `fitter fit`.
    Table(Box<Table>),
    /// Of `fitter fit-family`.
    Family(Box<Family>),
}

/// Loads a table or a family, naming the file in an error.
pub fn file(path: &Path) -> anyhow::Result<File> {
    let name = || path.display().to_string();
    let is_file = std::fs::metadata(path).with_context(name)?.is_file();
    ensure!(is_file, "{}: not a regular file", path.display());
    match Family::load(path) {
        Ok(family) => Ok(File::Family(family.into())),
        Err(FormatError::FamilyMagic) => Ok(File::Table(Table::load(path).with_context(name)?.into())),
        Err(error) => Err(error).with_context(name),
    }
}

/// Refuses an SVG file that cannot be written, or that is read besides, before any work is done for it.
pub fn figure<'a>(path: &Path, inputs: impl IntoIterator<Item = &'a Path>) -> anyhow::Result<Outputs> {
    let mut outputs = Outputs::beside(inputs);
    outputs.file_of(path, &["svg"])?;
    Ok(outputs)
}

/// A solid angle in (0, 2π] sr: a number, or a multiple of pi such as `pi/10` or `0.5pi`.
#[derive(Clone, Debug, PartialEq)]
pub struct SolidAngle {
    /// Its value, sr.
    pub sr: f64,
    /// How it is written in a caption.
    pub text: String,
}

impl std::str::FromStr for SolidAngle {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let number = |t: &str| t.trim().parse::<f64>().map_err(|_| "expected a number, pi/10 or 2pi".to_string());
        let sr = match text.split_once("pi") {
            None => number(text)?,
            Some((factor, rest)) => {
                let factor = if factor.trim().is_empty() { 1.0 } else { number(factor.trim_end_matches('*'))? };
                let divisor = match rest.trim().strip_prefix('/') {
                    Some(divisor) => number(divisor)?,
                    None if rest.trim().is_empty() => 1.0,
                    None => return Err("expected a number, pi/10 or 2pi".into()),
                };
                factor * PI / divisor
            }
        };
        if !(sr > 0.0 && sr <= TAU * (1.0 + 1e-12)) {
            return Err(format!("{sr} sr is outside (0, 2 pi]"));
        }
        Ok(Self { sr, text: text.replace("pi", "π") })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solid_angles_are_numbers_or_multiples_of_pi() {
        let sr = |text: &str| text.parse::<SolidAngle>().map(|s| s.sr).ok();
        for (text, value) in [("0.25", 0.25), ("pi/10", PI / 10.0), ("2pi", TAU), ("0.5*pi", PI / 2.0)] {
            assert_eq!(sr(text), Some(value), "{text}");
        }
        for bad in ["", "0", "-1", "7", "pi/0", "pi10", "nan", "inf", "x"] {
            assert_eq!(sr(bad), None, "{bad}");
        }
    }
}

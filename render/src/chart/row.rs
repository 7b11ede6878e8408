//! A line of the table: what was run, what it took, what came out.

use super::method;
use anyhow::{Context, Result, bail, ensure};
use render::image::write_whole;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// The result of one cell of a sweep. The fields, in this order, are the columns of the CSV.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// Name of the scene.
    pub scene: String,
    /// Checksum of the scene, its film and the reference: rows of another are not shown.
    pub digest: String,
    /// Name of the method.
    pub method: String,
    /// What was varied.
    pub setting: String,
    /// Seed of the samples.
    pub seed: u64,
    /// Film, pixels.
    pub width: u32,
    /// Film, pixels.
    pub height: u32,
    /// Samples per pixel.
    pub spp: u32,
    /// Time to fill the caches, s.
    pub fill: f64,
    /// Time from there to the picture, s.
    pub shade: f64,
    /// Their sum, and the time to denoise the picture, s.
    pub seconds: f64,
    /// Quality τ in force; 0 for a method without.
    pub tau: f64,
    /// Records of all kinds.
    pub records: u64,
    /// Records of glossy light.
    pub glossy_records: u64,
    /// Mean number of EAS, or the order of the harmonics, of a glossy record.
    pub size: f64,
    /// Mean bytes of a glossy record.
    pub bytes_per_record: f64,
    /// Bytes of all records.
    pub bytes: u64,
    /// Root mean square error.
    pub rmse: f64,
    /// Mean of squared error / (reference² + 0.01).
    pub rel_mse: f64,
    /// Mean difference over the mean of the reference.
    pub bias: f64,
    /// Largest difference of a channel.
    pub max: f64,
    /// Mean ꟻLIP error; empty where the program is built without.
    pub flip: Option<f64>,
    /// As rel_mse, of blocks of 4×4 pixels.
    pub blocks: f64,
    /// Largest relative error of a pixel.
    pub worst: f64,
    /// Share of blocks that are dark in the reference only.
    pub leaks: f64,
    /// Share of pixels with negative light.
    pub negative: f64,
    /// Time to denoise the picture, s.
    #[serde(default)]
    pub denoise: f64,
}

impl Row {
    /// What makes a row the same cell of a sweep as another.
    pub fn key(&self) -> (&str, &str, &str, &str, u64) {
        (&self.scene, &self.digest, &self.method, &self.setting, self.seed)
    }

    /// Leaves six digits of every measured number: more say nothing.
    pub fn round(&mut self) {
        let Self { fill, shade, denoise, seconds, tau, size, bytes_per_record, rmse, rel_mse, bias, .. } = self;
        let Self { max, flip, blocks, worst, leaks, negative, .. } = self;
        for x in [
            fill,
            shade,
            denoise,
            seconds,
            tau,
            size,
            bytes_per_record,
            rmse,
            rel_mse,
            bias,
            max,
            blocks,
            worst,
            leaks,
            negative,
        ]
        .into_iter()
        .chain(flip)
        {
            *x = format!("{x:.5e}").parse().unwrap_or(*x);
        }
    }

    /// Refuses what no run of this program or a peer's script writes.
    fn check(&self) -> Result<()> {
        for (column, name) in [("scene", &self.scene), ("method", &self.method), ("setting", &self.setting)] {
            let plain = |c: char| c.is_ascii_alphanumeric() || "._-+=,".contains(c);
            ensure!(
                !name.is_empty() && name.len() <= 200 && name.chars().all(plain),
                "{column}: `{}` is not a name of letters, digits and ._-+=,",
                name.escape_debug()
            );
        }
        let hexadecimal = self.digest.len() == 8 && self.digest.bytes().all(|b| b.is_ascii_hexdigit());
        ensure!(hexadecimal, "digest: `{}` is not of 8 hexadecimal digits", self.digest.escape_debug());
        let Self { fill, shade, denoise, seconds, tau, size, bytes_per_record, .. } = *self;
        let Self { rmse, rel_mse, max, flip, blocks, worst, leaks, negative, bias, .. } = *self;
        for (column, x) in [
            ("fill", fill),
            ("shade", shade),
            ("denoise", denoise),
            ("seconds", seconds),
            ("tau", tau),
            ("size", size),
            ("bytes_per_record", bytes_per_record),
            ("rmse", rmse),
            ("rel_mse", rel_mse),
            ("max", max),
            ("flip", flip.unwrap_or(0.0)),
            ("blocks", blocks),
            ("worst", worst),
            ("leaks", leaks),
            ("negative", negative),
        ] {
            ensure!(x >= 0.0 && x.is_finite(), "{column}: {x} is not a number ≥ 0");
        }
        ensure!(bias.is_finite(), "bias: {bias} is not a number");
        Ok(())
    }
}

/// Most bytes of a CSV that are read.
const MAX_BYTES: u64 = 64 << 20;

/// Reads the rows of a file; none where there is no file.
///
/// # Errors
/// Anything but a table of rows, naming file and line.
pub fn load(path: &Path) -> Result<Vec<Row>> {
    let place = || path.display().to_string();
    if !path.exists() {
        return Ok(Vec::new());
    }
    let size = std::fs::metadata(path).with_context(place)?.len();
    ensure!(size <= MAX_BYTES, "{}: {size} bytes are too many for a chart", place());
    let text = std::fs::read(path).with_context(place)?;
    let mut reader = csv::Reader::from_reader(&text[..]);
    let header = csv::StringRecord::from(columns()?);
    let found = reader.headers().with_context(place)?;
    ensure!(*found == header, "{}:1: not a table of this chart; move it away, or name another folder", place());
    let mut rows: Vec<Row> = Vec::new();
    for record in reader.records() {
        let record = record.with_context(place)?;
        let line = record.position().map_or(0, csv::Position::line);
        let place = || format!("{}:{line}", path.display());
        let row: Row = match record.deserialize(Some(&header)) {
            Ok(row) => row,
            Err(e) => match e.kind() {
                csv::ErrorKind::Deserialize { err, .. } => {
                    let column = err.field().and_then(|i| header.get(i as usize)).unwrap_or("row");
                    bail!("{}: {column}: {}", place(), err.kind())
                }
                _ => return Err(e).with_context(place),
            },
        };
        row.check().with_context(place)?;
        ensure!(rows.iter().all(|r| r.key() != row.key()), "{}: the same cell as an earlier line", place());
        rows.push(row);
    }
    Ok(rows)
}

/// Names of the columns.
fn columns() -> Result<Vec<String>> {
    let text = to_csv(&[Row::default()])?;
    Ok(text.lines().next().unwrap_or_default().split(',').map(str::to_owned).collect())
}

fn to_csv(rows: &[Row]) -> Result<String> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    for row in rows {
        writer.serialize(row)?;
    }
    Ok(String::from_utf8(writer.into_inner()?)?)
}

/// Writes all rows, whole or not at all: by scene, then method, then the order in which they were run.
///
/// # Errors
/// A file that cannot be written.
pub fn save(path: &Path, rows: &[Row]) -> Result<()> {
    let mut sorted = rows.to_vec();
    let place = |name: &str| method::METHODS.iter().position(|m| m.name == name).unwrap_or(method::METHODS.len());
    sorted.sort_by_key(|r| (r.scene.clone(), place(&r.method)));
    write_whole(path, to_csv(&sorted)?.as_bytes())?;
    Ok(())
}

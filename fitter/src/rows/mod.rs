//! Caps and directions as CSV (RFC 4180), answers as CSV.

mod records;
#[cfg(test)]
mod tests;

use anyhow::{Context, bail, ensure};
use brdf_tables::cap::Cap;
use glam::DVec3;
use rayon::prelude::*;
use records::{Next, Record, Records};
use std::io::{self, Read, Write};

/// The columns of a query: θe and φe of the cap in radian, Ω in sr, and the direction to the eye.
pub const COLUMNS: [&str; 6] = ["theta_e", "phi_e", "omega", "wo_x", "wo_y", "wo_z"];
/// How the columns are explained in `--help`.
pub const HELP: &str = "\
Columns, under a header that names them, in any order and beside others:
  theta_e, phi_e     zenith and azimuth of the cap's axis, radian; the zenith is
                     0 at the normal and at most pi/2
  omega              solid angle of the whole cap, sr, at most 2 pi
  wo_x, wo_y, wo_z   unit vector to the eye, above the horizon
Rows are answered as they arrive, so that a program can talk through pipes.";

/// Rows answered together, in parallel.
const BATCH: usize = 1024;
/// Largest deviation of |wo| from 1.
const UNIT_TOLERANCE: f64 = 1e-3;

/// One row as read.
struct Row {
    fields: Vec<String>,
    cap: Cap,
    wo: DVec3,
}

/// Reads all rows of `input` and writes each with the `N` numbers that `answer` has for its index (from 0), cap and
/// direction. Rows are answered as soon as no further complete row is waiting.
///
/// # Errors
/// A bad row, by its line, after the rows before it are answered; or the streams.
pub fn answer<const N: usize>(
    input: impl Read,
    output: impl Write,
    columns: [&str; N],
    answer: impl Fn(u64, &Cap, DVec3) -> [f64; N] + Sync,
) -> anyhow::Result<()> {
    let mut input = Records::new(input)?;
    let mut output = csv::WriterBuilder::new().flexible(true).from_writer(output);
    let header = match input.next(true)? {
        Next::Record(record) => Header::new(record, &columns)?,
        _ => Header::new(Record { line: 1, fields: Vec::new() }, &columns)?,
    };
    output.write_record(header.names.iter().map(String::as_str).chain(columns)).map_err(plain)?;

    let mut answered = 0;
    loop {
        // Gather the rows that are waiting, answer them, and only then complain about the next one.
        let mut rows = Vec::new();
        let mut end = None;
        while rows.len() < BATCH && end.is_none() {
            let next = input.next(rows.is_empty()).and_then(|next| match next {
                Next::Record(record) => header.row(record).map(Some),
                Next::Waiting => Ok(None),
                Next::End => {
                    end = Some(Ok(()));
                    Ok(None)
                }
            });
            match next {
                Ok(Some(row)) => rows.push(row),
                Ok(None) => break,
                Err(error) => end = Some(Err(error)),
            }
        }
        let answers: Vec<_> =
            rows.par_iter().enumerate().map(|(i, row)| answer(answered + i as u64, &row.cap, row.wo)).collect();
        for (row, numbers) in rows.iter().zip(answers) {
            let numbers = numbers.map(|number| format!("{number:?}"));
            output.write_record(row.fields.iter().chain(&numbers)).map_err(plain)?;
        }
        output.flush()?;
        answered += rows.len() as u64;
        if let Some(end) = end {
            return end;
        }
    }
}

/// What the stream says.
fn plain(error: csv::Error) -> io::Error {
    match error.into_kind() {
        csv::ErrorKind::Io(error) => error,
        other => io::Error::other(format!("{other:?}")),
    }
}

/// Names of the columns as read, and where among them those of [`COLUMNS`] are.
struct Header {
    names: Vec<String>,
    at: [usize; COLUMNS.len()],
}

impl Header {
    fn new(record: Record, answers: &[&str]) -> anyhow::Result<Self> {
        let names: Vec<String> = record.fields.iter().map(|name| name.trim().to_owned()).collect();
        let place = format!("standard input, line {}", record.line);
        let at = COLUMNS.map(|column| names.iter().position(|name| name == column));
        let missing: Vec<_> =
            COLUMNS.iter().zip(&at).filter(|(_, at)| at.is_none()).map(|(column, _)| *column).collect();
        ensure!(
            missing.is_empty(),
            "{place}: the header must be {}; {} is not there",
            COLUMNS.join(","),
            missing.join(",")
        );
        for (i, name) in names.iter().enumerate() {
            ensure!(!names[..i].contains(name), "{place}: two columns are called {:?}", shortened(name));
            ensure!(!answers.contains(&name.as_str()), "{place}: a column {name} would be there twice in the output");
        }
        Ok(Self { names, at: at.map(Option::unwrap_or_default) })
    }

    fn row(&self, record: Record) -> anyhow::Result<Row> {
        self.parse(record.fields).with_context(|| format!("standard input, line {}", record.line))
    }

    fn parse(&self, fields: Vec<String>) -> anyhow::Result<Row> {
        ensure!(fields.len() == self.names.len(), "{} columns, {} are needed", fields.len(), self.names.len());
        let mut numbers = [0.0; COLUMNS.len()];
        for ((number, &at), column) in numbers.iter_mut().zip(&self.at).zip(COLUMNS) {
            let field = fields[at].trim();
            *number = match field.parse::<f64>() {
                Ok(x) if x.is_finite() => x,
                Ok(x) => bail!("{column} is {x}, a finite number is needed"),
                Err(_) => bail!("{column} is {:?}, a number is needed", shortened(field)),
            };
        }
        let [theta, phi, omega, x, y, z] = numbers;
        let cap = Cap::new(theta, phi, omega)?;
        let wo = DVec3::new(x, y, z);
        let length = wo.length();
        ensure!((length - 1.0).abs() <= UNIT_TOLERANCE, "the length of (wo_x, wo_y, wo_z) is {length}, it must be 1");
        ensure!(z > 0.0, "wo_z = {z} is not above the horizon");
        Ok(Row { fields, cap, wo: wo / length })
    }
}

/// The start of a text, for a message.
fn shortened(text: &str) -> String {
    const MOST: usize = 30;
    if text.chars().count() <= MOST { text.into() } else { text.chars().take(MOST).chain(['…']).collect() }
}

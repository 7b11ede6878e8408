//! Caps and directions as CSV on standard input, answers as CSV on standard output.

use anyhow::{Context, bail, ensure};
use brdf_tables::cap::Cap;
use glam::DVec3;
use rayon::prelude::*;
use std::io::{BufRead, BufReader, BufWriter, Read, Write};

/// The columns of a query: θe and φe of the cap in radian, Ω in sr, and the direction to the eye.
pub const COLUMNS: [&str; 6] = ["theta_e", "phi_e", "omega", "wo_x", "wo_y", "wo_z"];
/// How the columns are explained in `--help`.
pub const HELP: &str = "\
Columns, under a header that names them in this order:
  theta_e, phi_e     zenith and azimuth of the cap's axis, radian; the zenith is
                     0 at the normal and at most pi/2
  omega              solid angle of the whole cap, sr, at most 2 pi
  wo_x, wo_y, wo_z   unit vector to the eye, above the horizon
Rows are answered as they arrive, so that a program can talk through pipes.";

/// Longest line, bytes.
const MAX_LINE: u64 = 4096;
/// Rows answered together, in parallel.
const BATCH: usize = 1024;
/// Largest deviation of |wo| from 1.
const UNIT_TOLERANCE: f64 = 1e-3;

/// One row as read.
struct Row {
    text: String,
    cap: Cap,
    wo: DVec3,
}

/// Reads all rows of `input` and writes each with the `N` numbers that `answer` has for its index (from 0), cap and
/// direction. Rows are answered as soon as no further complete line is waiting.
///
/// # Errors
/// A bad row, by its line, after the rows before it are answered; or the streams.
pub fn answer<const N: usize>(
    input: impl Read,
    output: impl Write,
    columns: [&str; N],
    answer: impl Fn(u64, &Cap, DVec3) -> [f64; N] + Sync,
) -> anyhow::Result<()> {
    let mut input = Lines { reader: BufReader::with_capacity(1 << 16, input), number: 0 };
    let mut output = BufWriter::new(output);
    let header = input.next()?.unwrap_or_default();
    ensure!(fields(&header).eq(COLUMNS), "standard input, line 1: the header must be {}", COLUMNS.join(","));
    writeln!(output, "{},{}", COLUMNS.join(","), columns.join(","))?;

    let mut answered = 0;
    loop {
        // Gather the rows that are waiting, answer them, and only then complain about the next one.
        let mut rows = Vec::new();
        let mut end = None;
        while rows.len() < BATCH && (rows.is_empty() || input.has_line()) {
            match input.row() {
                Ok(Some(row)) => rows.push(row),
                Ok(None) => end = Some(Ok(())),
                Err(error) => end = Some(Err(error)),
            }
            if end.is_some() {
                break;
            }
        }
        let answers: Vec<_> =
            rows.par_iter().enumerate().map(|(i, row)| answer(answered + i as u64, &row.cap, row.wo)).collect();
        for (row, numbers) in rows.iter().zip(answers) {
            output.write_all(row.text.as_bytes())?;
            for number in numbers {
                write!(output, ",{number:?}")?;
            }
            writeln!(output)?;
        }
        output.flush()?;
        answered += rows.len() as u64;
        if let Some(end) = end {
            return end;
        }
    }
}

/// Lines of bounded length, counted.
struct Lines<R> {
    reader: BufReader<R>,
    number: u64,
}

impl<R: Read> Lines<R> {
    /// Whether a complete line can be had without waiting for more input.
    fn has_line(&self) -> bool {
        self.reader.buffer().contains(&b'\n')
    }

    /// The next line without its end; `None` at the end of the input.
    fn next(&mut self) -> anyhow::Result<Option<String>> {
        let mut line = Vec::new();
        let read = self.reader.by_ref().take(MAX_LINE).read_until(b'\n', &mut line).context("standard input")?;
        self.number += 1;
        let place = || format!("standard input, line {}", self.number);
        ensure!((read as u64) < MAX_LINE, "{}: longer than {MAX_LINE} bytes", place());
        let line = String::from_utf8(line).ok().with_context(|| format!("{}: not UTF-8 text", place()))?;
        Ok((read > 0).then(|| line.trim().to_string()))
    }

    /// The next row; empty lines are skipped.
    fn row(&mut self) -> anyhow::Result<Option<Row>> {
        while let Some(text) = self.next()? {
            if !text.is_empty() {
                return parse(text).with_context(|| format!("standard input, line {}", self.number)).map(Some);
            }
        }
        Ok(None)
    }
}

fn fields(line: &str) -> impl Iterator<Item = &str> {
    line.split(',').map(str::trim)
}

/// The row of a line.
fn parse(text: String) -> anyhow::Result<Row> {
    let found = fields(&text).count();
    ensure!(found == COLUMNS.len(), "{found} columns, {} are needed", COLUMNS.len());
    let mut numbers = [0.0; COLUMNS.len()];
    for ((number, field), column) in numbers.iter_mut().zip(fields(&text)).zip(COLUMNS) {
        *number = match field.parse::<f64>() {
            Ok(x) if x.is_finite() => x,
            Ok(x) => bail!("{column} is {x}, a finite number is needed"),
            Err(_) => bail!("{column} is {field:?}, a number is needed"),
        };
    }
    let [theta, phi, omega, x, y, z] = numbers;
    let cap = Cap::new(theta, phi, omega)?;
    let wo = DVec3::new(x, y, z);
    let length = wo.length();
    ensure!((length - 1.0).abs() <= UNIT_TOLERANCE, "the length of (wo_x, wo_y, wo_z) is {length}, it must be 1");
    ensure!(z > 0.0, "wo_z = {z} is not above the horizon");
    Ok(Row { text, cap, wo: wo / length })
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEADER: &str = "theta_e,phi_e,omega,wo_x,wo_y,wo_z\n";

    /// Output and error for the rows under a good header.
    fn answers(rows: &str) -> (String, Option<String>) {
        let mut output = Vec::new();
        let input = format!("{HEADER}{rows}");
        let result = answer(input.as_bytes(), &mut output, ["index", "z"], |i, _, wo| [i as f64, wo.z]);
        (String::from_utf8(output).unwrap(), result.err().map(|e| format!("{e:#}")))
    }

    #[test]
    fn rows_come_back_with_their_answers() {
        let (output, error) = answers("0.5, 0, 1, 0, 0, 1\r\n\n0.5,0,1,0.6,0,0.8");
        let expected =
            "theta_e,phi_e,omega,wo_x,wo_y,wo_z,index,z\n0.5, 0, 1, 0, 0, 1,0.0,1.0\n0.5,0,1,0.6,0,0.8,1.0,0.8\n";
        assert_eq!((output.as_str(), error), (expected, None));
    }

    #[test]
    fn a_bad_row_is_one_error_with_its_line() {
        let bad = [
            ("1,0,1,0,0", "5 columns"),
            ("1,0,1,0,0,1,2", "7 columns"),
            ("1,0,x,0,0,1", "omega is \"x\""),
            ("1,0,nan,0,0,1", "omega is NaN"),
            ("1,0,inf,0,0,1", "omega is inf"),
            ("2,0,1,0,0,1", "theta_e = 2"),
            ("1,0,0,0,0,1", "omega = 0"),
            ("1,0,1,0,0,1.1", "length"),
            ("1,0,1,0,0,-1", "horizon"),
            ("1,0,1,1,0,0", "horizon"),
        ];
        for (row, what) in bad {
            let (output, error) = answers(&format!("1,0,1,0,0,1\n{row}\n1,0,1,0,0,1\n"));
            let error = error.unwrap();
            assert!(error.starts_with("standard input, line 3: ") && error.contains(what), "{row}: {error}");
            assert_eq!(output.lines().count(), 2, "the row before it is answered");
        }
    }

    #[test]
    fn a_line_without_end_is_refused() {
        let (_, error) = answers(&"1,".repeat(100_000));
        assert!(error.unwrap().contains("line 2: longer than 4096"));
        let result = answer(&b"theta,phi\n"[..], Vec::new(), ["x"], |_, _, _| [0.0]);
        assert!(format!("{:#}", result.unwrap_err()).contains("line 1: the header must be"));
    }
}

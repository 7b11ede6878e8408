//! Paths as CSV.

use super::path::Row;
use glam::DVec3;
use std::collections::BTreeMap;

/// Columns of a path, in any order and beside others; the last two may be missing.
const COLUMNS: [&str; 12] =
    ["frame", "eye_x", "eye_y", "eye_z", "look_x", "look_y", "look_z", "up_x", "up_y", "up_z", "fov", "width"];
const FOV: usize = 10;
const WIDTH: usize = 11;

/// Rows of a path by the number of their frame.
///
/// # Errors
/// One line with the line of the file: columns that are missing, numbers that are none, a frame that is there twice.
pub fn read_rows(text: &[u8]) -> Result<BTreeMap<u32, Row>, String> {
    let text = text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(text);
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).comment(Some(b'#')).from_reader(text);
    let plain = |e: csv::Error| {
        let line = e.position().map(|p| format!("line {}: ", p.line())).unwrap_or_default();
        match e.kind() {
            csv::ErrorKind::UnequalLengths { expected_len, len, .. } => {
                format!("{line}{len} columns instead of {expected_len}")
            }
            csv::ErrorKind::Utf8 { .. } => format!("{line}not text in UTF-8"),
            _ => format!("{line}not CSV"),
        }
    };
    let header = reader.headers().map_err(plain)?.clone();
    let at = COLUMNS.map(|name| header.iter().position(|column| column == name));
    let missing: Vec<_> =
        COLUMNS[..FOV].iter().zip(&at).filter(|(_, at)| at.is_none()).map(|(column, _)| *column).collect();
    if !missing.is_empty() {
        let header = COLUMNS[..=FOV].join(",");
        return Err(format!("line 1: the header must be {header}; {} is not there", missing.join(",")));
    }
    if let Some(twice) = COLUMNS.iter().find(|name| header.iter().filter(|column| column == *name).count() > 1) {
        return Err(format!("line 1: two columns are called {twice}"));
    }
    let mut rows = BTreeMap::new();
    for record in reader.records() {
        let record = record.map_err(plain)?;
        let line = record.position().map_or(0, csv::Position::line);
        let number = |column: usize| -> Result<f64, String> {
            let text = at[column].and_then(|i| record.get(i)).unwrap_or_default();
            let number: Option<f64> = text.parse().ok().filter(|x: &f64| x.abs() < 1e30);
            number.ok_or_else(|| format!("line {line}: {} must be a finite number", COLUMNS[column]))
        };
        let vector = |column: usize| -> Result<DVec3, String> {
            Ok(DVec3::new(number(column)?, number(column + 1)?, number(column + 2)?))
        };
        let frame = at[0].and_then(|i| record.get(i)).unwrap_or_default().parse::<u32>();
        let frame = frame.map_err(|_| format!("line {line}: frame must be a whole number ≥ 0"))?;
        let optional = |column: usize| at[column].map(|_| number(column)).transpose();
        let (fov, width) = (optional(FOV)?, optional(WIDTH)?);
        let row = Row { eye: vector(1)?, look: vector(4)?, up: vector(7)?, fov, width };
        if rows.insert(frame, row).is_some() {
            return Err(format!("line {line}: frame {frame} is there twice"));
        }
    }
    if rows.is_empty() { Err("there is no row below the header".into()) } else { Ok(rows) }
}

/// The path through rows, as [`read_rows`] reads it.
pub fn write_rows<'a>(rows: impl IntoIterator<Item = (u32, &'a Row)>) -> String {
    let rows: Vec<_> = rows.into_iter().collect();
    let all = |of: fn(&Row) -> Option<f64>| rows.iter().all(|(_, row)| of(row).is_some());
    let has = [all(|row| row.fov), all(|row| row.width)];
    let named = COLUMNS[FOV..].iter().zip(has).filter(|(_, has)| *has).map(|(column, _)| *column);
    let mut text = COLUMNS[..FOV].iter().copied().chain(named).collect::<Vec<_>>().join(",") + "\n";
    for (frame, Row { eye, look, up, fov, width }) in rows {
        let optional = [*fov, *width].into_iter().zip(has).filter_map(|(number, has)| number.filter(|_| has));
        let numbers = [eye, look, up].into_iter().flat_map(|v| v.to_array()).chain(optional);
        text +=
            &core::iter::once(frame.to_string()).chain(numbers.map(|x| x.to_string())).collect::<Vec<_>>().join(",");
        text.push('\n');
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEADER: &str = "frame,eye_x,eye_y,eye_z,look_x,look_y,look_z,up_x,up_y,up_z,fov";

    #[test]
    fn rows_are_read_by_the_names_of_columns() {
        let text = "\u{feff}up_x,up_y,up_z,note,frame,eye_x,eye_y,eye_z,look_x,look_y,look_z\r\n\
                    0,1,0,hall,7, 1,2,3, 4,5,6\r\n# a comment\r\n0,0,1,,3,1e1,2,3,4,5,-6\r\n";
        let rows = read_rows(text.as_bytes()).unwrap();
        assert_eq!(rows.keys().copied().collect::<Vec<_>>(), [3, 7]);
        assert_eq!(rows[&3].eye, DVec3::new(10.0, 2.0, 3.0));
        assert_eq!((rows[&7].look, rows[&7].fov), (DVec3::new(4.0, 5.0, 6.0), None));
        let rows = read_rows(format!("{HEADER}\n0,0,0,0,0,0,1,0,1,0,30\n").as_bytes()).unwrap();
        assert_eq!(rows[&0].fov, Some(30.0));
    }

    /// What is written is read again, to the last bit.
    #[test]
    fn rows_come_back() {
        let (look, up, width) = (DVec3::X, DVec3::Y, None);
        let row = |x: f64| Row { eye: DVec3::new(x, 1e-9, -3.25), look, up, fov: Some(x / 3.0), width };
        let rows = BTreeMap::from([(1, row(0.1)), (25, row(1e7 / 7.0))]);
        assert_eq!(read_rows(write_rows(rows.iter().map(|(f, r)| (*f, r))).as_bytes()).unwrap(), rows);
        for width in [None, Some(0.3)] {
            let flat = BTreeMap::from([(3, Row { fov: None, width, ..row(2.0) })]);
            assert_eq!(read_rows(write_rows(flat.iter().map(|(f, r)| (*f, r))).as_bytes()).unwrap(), flat);
        }
    }

    #[test]
    fn bad_rows_are_named_by_their_line() {
        let bad = |rows: &str| read_rows(format!("{HEADER}\n{rows}").as_bytes()).unwrap_err();
        for (rows, said) in [
            ("", "no row"),
            ("1,nan,0,0,0,0,1,0,1,0,30", "line 2: eye_x"),
            ("1,0,0,0,0,0,1,0,1,0,30\n2,0,0,0,0,inf,1,0,1,0,30", "line 3: look_y"),
            ("1,0,0,0,0,0,1,0,1,0,", "line 2: fov"),
            ("1,0,0,0,0,0,1,0,1,0", "line 2: 10 columns"),
            ("-1,0,0,0,0,0,1,0,1,0,30", "line 2: frame"),
            ("1.5,0,0,0,0,0,1,0,1,0,30", "line 2: frame"),
            ("99999999999,0,0,0,0,0,1,0,1,0,30", "line 2: frame"),
            ("1,0,0,0,0,0,1,0,1,0,30\n1,0,0,0,0,0,1,0,1,0,30", "line 3: frame 1 is there twice"),
        ] {
            assert!(bad(rows).starts_with(said) || bad(rows).contains(said), "{rows}: {}", bad(rows));
        }
        let header = read_rows(b"frame,eye_x\n1,2\n").unwrap_err();
        assert!(header.contains("eye_y,eye_z,look_x") && header.starts_with("line 1"), "{header}");
        assert!(read_rows(b"\xff\xfe\x00").is_err() && read_rows(b"").is_err());
    }
}

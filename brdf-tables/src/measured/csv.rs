//! CSV of `theta_i,theta_o,phi,r,g,b`, as the tables of UTIA are commonly passed on: zenith angles of both directions, the
//! azimuth between them (π is the mirror direction), f_r in sr⁻¹ of linear sRGB. Angles in radian, or in degrees where the name
//! of the column ends in `_deg`. Columns may stand in any order; lines that begin with `#` are remarks.

use super::lines::{MOST_LINES, number, text, zenith};
use super::{Format, Place, ReadError, Reading, scattered};
use crate::frame::spherical;

const COLUMNS: [&str; 6] = ["theta_i", "theta_o", "phi", "r", "g", "b"];

/// Reads the bytes of a file.
pub fn read(bytes: &[u8]) -> Result<Reading, ReadError> {
    let fail = |line: usize, what: String| ReadError::new(Place::Line(line), what);
    let lines = text(bytes)?.lines().enumerate().map(|(i, l)| (i + 1, l.trim()));
    let mut lines = lines.filter(|(_, l)| !l.is_empty() && !l.starts_with('#'));
    let header = format!("a first line of {}", COLUMNS.join(","));
    let (line, names) = lines.next().ok_or_else(|| ReadError::new(Place::File, format!("{header} is missing")))?;
    // Which column of ours each of the file is, and whether it is in degrees.
    let mut columns: Vec<(usize, bool)> = Vec::new();
    for name in names.split(',').map(str::trim) {
        let (plain, degrees) = name.strip_suffix("_deg").map_or((name, false), |plain| (plain, true));
        let known = COLUMNS.iter().position(|c| *c == plain).filter(|c| !degrees || *c < 3);
        let column = known.filter(|c| columns.iter().all(|(other, _)| other != c));
        columns
            .push((column.ok_or_else(|| fail(line, format!("{header} is needed (angles may end in _deg)")))?, degrees));
    }
    if columns.len() != COLUMNS.len() {
        return Err(fail(line, format!("{header} is needed (angles may end in _deg)")));
    }
    let mut points = Vec::new();
    for (line, words) in lines {
        let (mut row, mut found) = ([0.0; 6], 0);
        for word in words.split(',') {
            if let Some(&(column, degrees)) = columns.get(found) {
                let x = number(word, line)?;
                row[column] = if degrees { x.to_radians() } else { x };
            }
            found += 1;
        }
        if found != COLUMNS.len() {
            return Err(fail(line, format!("{found} values for {} columns", COLUMNS.len())));
        }
        let [theta_i, theta_o, phi, rgb @ ..] = row;
        if let Some(value) = rgb.iter().find(|x| !(0.0..=1e12).contains(*x)) {
            return Err(fail(line, format!("f_r is {value}")));
        }
        if points.len() == MOST_LINES {
            return Err(fail(line, format!("more than {MOST_LINES} lines")));
        }
        let (theta_i, theta_o) = (zenith(theta_i, "theta_i", line)?, zenith(theta_o, "theta_o", line)?);
        points.push((spherical(theta_i, 0.0), spherical(theta_o, phi), rgb));
    }
    let mut notes = vec![format!("CSV: {} pairs of directions", points.len())];
    let source = scattered::Scattered::new(&points, &mut notes)?;
    Ok(Reading { format: Format::Csv, source: Box::new(source), notes })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bad_lines_are_named() {
        let good = "theta_i,theta_o_deg,phi,r,g,b\n0.1,10,0,.1,.1,.1\n0.5,30,3.1,.2,.2,.2\n1.0,60,1.5,.1,.1,.1\n0.2,60,1.5,.1,.2,.1\n";
        let reading = read(good.as_bytes()).unwrap();
        assert!(reading.notes[0].contains("4 pairs"));
        let error = |from: &str, to: &str| read(good.replace(from, to).as_bytes()).err().unwrap().to_string();
        assert!(error("phi,r", "phi,x").contains("line 1: a first line of theta_i,theta_o,phi,r,g,b"));
        assert!(error("phi,r", "phi,phi").contains("line 1: "));
        assert!(error(",g,b", ",g").contains("line 1: "));
        assert!(error("0.5,30", "0.5,130").contains("line 3: theta_o is"));
        assert!(error(".2,.2,.2", ".2,.2").contains("line 3: 5 values"));
        assert!(error(".2,.2,.2", ".2,.2,inf").contains("line 3: `inf`"));
        assert!(error(".2,.2,.2", ".2,.2,-1").contains("line 3: f_r is -1"));
        assert!(read(b"").err().unwrap().to_string().contains("is missing"));
    }
}

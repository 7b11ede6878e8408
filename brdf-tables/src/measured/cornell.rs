//! The text files of Cornell's Program of Computer Graphics: how many wavelengths, the wavelengths in nm, then lines of
//! `theta_i phi_i theta_s phi_s` (radian, both directions away from the surface) and a value of f_r in sr⁻¹ per wavelength.
//! Lines that begin with `#` are remarks.

use super::lines::{MOST_LINES, number, text, zenith};
use super::{Format, Place, ReadError, Reading, scattered, spectrum};
use crate::frame::spherical;

/// Most wavelengths.
const MOST_WAVELENGTHS: usize = 4096;

/// Reads the bytes of a file.
pub fn read(bytes: &[u8]) -> Result<Reading, ReadError> {
    let fail = |line: usize, what: String| ReadError::new(Place::Line(line), what);
    let mut lines = text(bytes)?.lines().enumerate().map(|(i, l)| (i + 1, l.trim()));
    let mut lines = lines.by_ref().filter(|(_, l)| !l.is_empty() && !l.starts_with('#'));
    let (line, first) = lines.next().ok_or_else(|| ReadError::new(Place::File, "no number of wavelengths"))?;
    let count = number(first, line)?;
    if count.fract() != 0.0 || !(1.0..=MOST_WAVELENGTHS as f64).contains(&count) {
        return Err(fail(line, format!("{count} wavelengths, 1 to {MOST_WAVELENGTHS} are possible")));
    }
    let count = count as usize;

    // The wavelengths, on as many lines as they like.
    let mut wavelengths: Vec<f64> = Vec::new();
    let mut last = line;
    while wavelengths.len() < count {
        let Some((line, words)) = lines.next() else {
            return Err(fail(last, format!("{count} wavelengths are announced, {} are there", wavelengths.len())));
        };
        last = line;
        for word in words.split_whitespace() {
            let nm = number(word, line)?;
            if wavelengths.last().is_some_and(|before| nm <= *before) || !(100.0..=10_000.0).contains(&nm) {
                return Err(fail(line, format!("wavelength {nm} nm: they must rise, from 100 to 10000")));
            }
            wavelengths.push(nm);
        }
    }
    if wavelengths.len() > count {
        return Err(fail(last, format!("{count} wavelengths are announced, {} are there", wavelengths.len())));
    }

    let weights = spectrum::weights(&wavelengths);
    let mut points = Vec::new();
    for (line, words) in lines {
        let mut numbers = words.split_whitespace().map(|word| number(word, line));
        let mut angle = || numbers.next().unwrap_or_else(|| Err(fail(line, "a direction is missing".into())));
        let [theta_i, phi_i, theta_o, phi_o] = [angle()?, angle()?, angle()?, angle()?];
        let (theta_i, theta_o) = (zenith(theta_i, "theta_i", line)?, zenith(theta_o, "theta_s", line)?);
        let (mut rgb, mut found) = ([0.0; 3], 0);
        for value in numbers {
            let value = value?;
            if !(0.0..=1e12).contains(&value) {
                return Err(fail(line, format!("f_r is {value}")));
            }
            if let Some(weight) = weights.get(found) {
                (0..3).for_each(|c| rgb[c] += weight[c] * value);
            }
            found += 1;
        }
        if found != count {
            return Err(fail(line, format!("{found} values for {count} wavelengths")));
        }
        if points.len() == MOST_LINES {
            return Err(fail(line, format!("more than {MOST_LINES} lines")));
        }
        points.push((spherical(theta_i, phi_i), spherical(theta_o, phi_o), rgb.map(|x: f64| x.max(0.0))));
    }
    let mut notes = vec![format!(
        "Cornell: {} pairs of directions, {count} wavelengths from {} to {} nm, as linear sRGB under D65",
        points.len(),
        wavelengths[0],
        wavelengths[count - 1]
    )];
    let source = scattered::Scattered::new(&points, &mut notes)?;
    Ok(Reading { format: Format::Cornell, source: Box::new(source), notes })
}

#[cfg(test)]
mod tests {
    use super::*;

    const GOOD: &str = "# num wls\n2\n# wls\n500\n600\n\n0.1 0 0.2 0  0.1 0.2\n0.5 0 0.6 3.1  0.2 0.1\n0.9 0 0.3 1.0 .1 .1\n1.2 0 1.2 2.0 .1 .2\n";

    #[test]
    fn bad_lines_are_named() {
        assert!(read(GOOD.as_bytes()).is_ok());
        let error = |from: &str, to: &str| read(GOOD.replace(from, to).as_bytes()).err().unwrap().to_string();
        assert!(error("0.1 0.2\n", "0.1\n").contains("line 7: 1 values for 2"));
        assert!(error("0.1 0.2\n", "0.1 0.2 0.3\n").contains("line 7: 3 values for 2"));
        assert!(error("0.1 0.2\n", "0.1 nan\n").contains("line 7: `nan`"));
        assert!(error("0.1 0.2\n", "0.1 -0.2\n").contains("line 7: f_r is -0.2"));
        assert!(error("0.5 0 0.6", "1.7 0 0.6").contains("line 8: theta_i is 1.7"));
        assert!(error("600", "400").contains("line 5: wavelength 400"));
        assert!(error("\n2\n", "\n1e9\n").contains("line 2: "));
        assert!(error("\n2\n", "\n3\n").contains("line 7"));
        assert!(read(b"").err().unwrap().to_string().contains("no number"));
        assert!(read(b"\xff").err().unwrap().to_string().contains("line 1: not UTF-8"));
    }
}

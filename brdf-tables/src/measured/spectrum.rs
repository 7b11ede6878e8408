//! Spectra of reflectances as linear sRGB.

use super::cie::CIE;

/// Shortest wavelength of the table in nm, and their distance.
const FIRST: f64 = 360.0;
const STEP: f64 = 5.0;

/// What each of some wavelengths, in nm and rising, adds to linear sRGB per unit of reflectance, seen by the CIE 1931 observer
/// under daylight (CIE D65). Between the wavelengths the spectrum is linear, beyond them constant; a constant 1 is (1, 1, 1).
pub fn weights(wavelengths: &[f64]) -> Vec<[f64; 3]> {
    let mut weights = vec![[0.0; 3]; wavelengths.len()];
    let mut white = [0.0; 3];
    for i in 0..=(CIE.len() - 1) * STEP as usize {
        let at = i as f64 / STEP;
        let low = (at as usize).min(CIE.len() - 2);
        let f = at - low as f64;
        let [x, y, z, d65]: [f64; 4] = core::array::from_fn(|k| CIE[low][k] * (1.0 - f) + CIE[low + 1][k] * f);
        // XYZ to linear sRGB.
        let rgb = [
            3.240479 * x - 1.537150 * y - 0.498535 * z,
            -0.969256 * x + 1.875991 * y + 0.041556 * z,
            0.055648 * x - 0.204043 * y + 1.057311 * z,
        ];
        let nm = FIRST + i as f64;
        let next = wavelengths.partition_point(|w| *w <= nm);
        let share = |k: usize, part: f64, weights: &mut Vec<[f64; 3]>| {
            (0..3).for_each(|c| weights[k][c] += part * d65 * rgb[c]);
        };
        match (next.checked_sub(1), wavelengths.get(next)) {
            (Some(before), Some(&after)) => {
                let way = (nm - wavelengths[before]) / (after - wavelengths[before]);
                share(before, 1.0 - way, &mut weights);
                share(next, way, &mut weights);
            }
            (Some(before), None) => share(before, 1.0, &mut weights),
            (None, _) => share(0, 1.0, &mut weights),
        }
        (0..3).for_each(|c| white[c] += d65 * rgb[c]);
    }
    for weight in &mut weights {
        (0..3).for_each(|c| weight[c] /= white[c]);
    }
    weights
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn constant_is_white_and_long_waves_are_red() {
        let wavelengths: Vec<f64> = (0..31).map(|i| 400.0 + 10.0 * f64::from(i)).collect();
        let weights = weights(&wavelengths);
        for c in 0..3 {
            assert!((weights.iter().map(|w| w[c]).sum::<f64>() - 1.0).abs() < 1e-12);
        }
        let red: [f64; 3] = core::array::from_fn(|c| {
            weights.iter().zip(&wavelengths).filter(|(_, nm)| **nm > 600.0).map(|(w, _)| w[c]).sum()
        });
        assert!(red[0] > 0.5 && red[1] < 0.2 && red[2].abs() < 0.05, "{red:?}");
    }
}

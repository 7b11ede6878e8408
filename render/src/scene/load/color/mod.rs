//! Spectra as linear sRGB.

mod metals;

use crate::scene::Rgb;
use brdf_tables::measured::cie::CIE;
use glam::{DMat3, DVec3};

pub use metals::conductor;

/// Shortest wavelength of the tables in nm.
const FIRST: f64 = 360.0;
/// Distance of the table's wavelengths in nm.
const STEP: f64 = 5.0;

/// What light a spectrum is seen under.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Weighting {
    /// The spectrum is the light: a constant one is not quite white in sRGB.
    EqualEnergy,
    /// The spectrum is a reflectance under daylight (CIE D65): a constant one is grey.
    Daylight,
}

/// Linear sRGB of a spectrum given as (wavelength in nm, value), linear between and 0 outside; negative channels, of
/// colours that sRGB cannot show, become 0.
pub fn from_samples(samples: &[(f64, f64)], weighting: Weighting) -> Rgb {
    from_spectrum(|wavelength| interpolate(samples, wavelength), weighting)
}

/// Linear sRGB of black body radiation in W·m⁻²·sr⁻¹·nm⁻¹ (Planck's law), at `temperature` in kelvin.
pub fn blackbody(temperature: f64) -> Rgb {
    const H: f64 = 6.626_070_15e-34;
    const C: f64 = 2.997_924_58e8;
    const K: f64 = 1.380_649e-23;
    let planck = |nm: f64| {
        let m = nm * 1e-9;
        2e-9 * H * C * C / m.powi(5) / ((H * C / (m * K * temperature)).exp() - 1.0)
    };
    from_spectrum(planck, Weighting::EqualEnergy)
}

/// CIE XYZ to linear sRGB, not clipped.
pub fn from_xyz(xyz: [f64; 3]) -> Rgb {
    const SRGB: DMat3 = DMat3::from_cols_array(&[
        3.240479, -0.969256, 0.055648, -1.537150, 1.875991, -0.204043, -0.498535, 0.041556, 1.057311,
    ]);
    (SRGB * DVec3::from(xyz)).as_vec3a()
}

/// Integrates against the observer in steps of 1 nm; a constant 1 has luminance 1.
fn from_spectrum(value: impl Fn(f64) -> f64, weighting: Weighting) -> Rgb {
    let (mut xyz, mut norm) = (DVec3::ZERO, 0.0);
    for i in 0..=((CIE.len() - 1) * STEP as usize) {
        let at = i as f64 / STEP;
        let (low, f) = ((at as usize).min(CIE.len() - 2), at - (at as usize).min(CIE.len() - 2) as f64);
        let [x, y, z, d65]: [f64; 4] = std::array::from_fn(|k| CIE[low][k] * (1.0 - f) + CIE[low + 1][k] * f);
        let illuminant = if weighting == Weighting::Daylight { d65 } else { 1.0 };
        norm += y * illuminant;
        xyz += DVec3::new(x, y, z) * illuminant * value(FIRST + i as f64);
    }
    from_xyz((xyz / norm).to_array()).max(Rgb::ZERO)
}

fn interpolate(samples: &[(f64, f64)], at: f64) -> f64 {
    let next = samples.partition_point(|s| s.0 <= at);
    match (next.checked_sub(1).map(|i| samples[i]), samples.get(next)) {
        (Some((w0, v0)), Some(&(w1, v1))) => v0 + (v1 - v0) * (at - w0) / (w1 - w0),
        (Some((w, v)), None) if w == at => v,
        _ => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(a: Rgb, b: [f32; 3], tolerance: f32) {
        assert!((a - Rgb::from(b)).abs().max_element() < tolerance, "{a} is not {b:?}");
    }

    #[test]
    fn constant_reflectance_is_grey_and_constant_light_is_illuminant_e() {
        let flat = [(300.0, 0.5), (900.0, 0.5)];
        near(from_samples(&flat, Weighting::Daylight), [0.5; 3], 1e-3);
        near(from_samples(&flat, Weighting::EqualEnergy), [0.6024, 0.4742, 0.4544], 1e-3);
    }

    #[test]
    fn long_wavelengths_are_red() {
        let c = from_samples(&[(600.0, 0.0), (601.0, 1.0), (830.0, 1.0)], Weighting::Daylight);
        assert!(c.x > 0.5 && c.y < 0.1 && c.z < 0.1, "{c}");
    }

    #[test]
    fn black_bodies_have_the_colour_of_their_temperature() {
        // A black body of 6504 K is close to D65, a little more purple; 2700 K is far redder.
        let day = blackbody(6504.0);
        near(day / day.y, [1.0, 1.0, 1.0], 0.08);
        let warm = blackbody(2700.0);
        assert!(warm.x > 2.0 * warm.y && warm.y > 2.0 * warm.z);
        // Luminance-weighted radiance at 5000 K, near Planck's 12.8 kW·m⁻²·sr⁻¹·nm⁻¹ at 560 nm.
        let y = blackbody(5000.0).dot(Rgb::new(0.2126, 0.7152, 0.0722));
        assert!((12_000.0..13_000.0).contains(&y), "{y}");
    }
}

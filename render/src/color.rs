//! Linear light: its colour, as one number, on the curve of screens, and what a surface sends out that reflects all of it.

use core::f32::consts::FRAC_1_PI;

/// A linear RGB triple: reflectance, radiance, intensity.
pub type Rgb = glam::Vec3A;

/// Luminance Y of linear sRGB.
pub fn luminance(c: Rgb) -> f32 {
    c.dot(Rgb::new(0.2126, 0.7152, 0.0722))
}

/// Mean radiance of an irradiance: E/π.
pub fn mean_radiance(irradiance: Rgb) -> Rgb {
    irradiance * FRAC_1_PI
}

/// Linear value to the sRGB curve, clamped to [0, 1].
pub fn to_srgb(x: f32) -> f32 {
    let x = x.clamp(0.0, 1.0);
    if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 }
}

/// The inverse of [`to_srgb`].
pub fn from_srgb(x: f32) -> f32 {
    if x <= 0.040_45 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }
}

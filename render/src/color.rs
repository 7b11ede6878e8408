//! Linear light as one number, and what a surface sends out that reflects all of it.

use crate::scene::Rgb;
use core::f32::consts::FRAC_1_PI;

/// Luminance Y of linear sRGB.
pub fn luminance(c: Rgb) -> f32 {
    c.dot(Rgb::new(0.2126, 0.7152, 0.0722))
}

/// Mean radiance of an irradiance: E/π.
pub fn mean_radiance(irradiance: Rgb) -> Rgb {
    irradiance * FRAC_1_PI
}

//! A sphere of a material, as a picture within a page: lit by a sky with three soft lamps, whose light comes back once.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use brdf_tables::brdf::Brdf;
use brdf_tables::frame::basis;
use brdf_tables::material::Material;
use core::f64::consts::TAU;
use glam::{DVec2, DVec3};
use image::{ExtendedColorType, ImageEncoder, codecs::png::PngEncoder};
use rayon::prelude::*;
use sobol_burley::sample;

/// Side of the picture in pixels, and samples a pixel.
const SIDE: usize = 200;
const SAMPLES: u32 = 256;

/// Directions of the lamps, the cosine power of each, and its radiance.
const LAMPS: [(DVec3, f64, f64); 3] = [
    (DVec3::new(-0.6, 0.6, 0.55), 60.0, 6.0),
    (DVec3::new(0.75, 0.35, 0.4), 150.0, 8.0),
    (DVec3::new(0.1, -0.5, 0.9), 30.0, 0.8),
];

/// Radiance from a direction: y is up, z towards the eye.
fn sky(w: DVec3) -> f64 {
    let lamps = LAMPS.iter().map(|(axis, power, radiance)| radiance * axis.normalize().dot(w).max(0.0).powf(*power));
    0.25 + 0.2 * w.y + lamps.sum::<f64>()
}

/// The radiance of each pixel, row by row from the top.
pub fn sphere(material: &Material) -> Vec<[f64; 3]> {
    let pixel = |i: usize| {
        let mut sum = [0.0; 3];
        for k in 0..SAMPLES {
            let u = |dimension| f64::from(sample(k, dimension, i as u32));
            let x = ((i % SIDE) as f64 + u(0)) / SIDE as f64 * 2.1 - 1.05;
            let y = 1.05 - ((i / SIDE) as f64 + u(1)) / SIDE as f64 * 2.1;
            let radius2 = x * x + y * y;
            let radiance = if radius2 < 0.9999 {
                let normal = DVec3::new(x, y, (1.0 - radius2).sqrt());
                reflected(material, normal, [u(2), u(3), u(4)])
            } else {
                [0.18; 3]
            };
            (0..3).for_each(|c| sum[c] += radiance[c] / f64::from(SAMPLES));
        }
        sum
    };
    (0..SIDE * SIDE).into_par_iter().map(pixel).collect()
}

/// One sample of the light that a point reflects to the eye, which is far away along z.
fn reflected(material: &Material, normal: DVec3, u: [f64; 3]) -> [f64; 3] {
    let frame = basis(normal);
    let wo = frame.transpose() * DVec3::Z;
    if wo.z <= 0.0 {
        return [0.0; 3];
    }
    // Both parts of the material are drawn from, by halves, and weighted by their densities together.
    let specular = material.specular.as_ref();
    let half = if specular.is_some() { 0.5 } else { 0.0 };
    let wi = if u[0] < half {
        specular.and_then(|s| s.sample(wo, DVec2::new(u[1], u[2])))
    } else {
        let (r, (s, c)) = (u[1].sqrt(), (TAU * u[2]).sin_cos());
        Some(DVec3::new(r * c, r * s, (1.0 - u[1]).max(0.0).sqrt()))
    };
    let Some(wi) = wi.filter(|wi| wi.z > 0.0) else { return [0.0; 3] };
    let density = half * specular.map_or(0.0, |s| s.pdf(wi, wo)) + (1.0 - half) * wi.z * core::f64::consts::FRAC_1_PI;
    let scale = sky(frame * wi) * wi.z / density;
    material.eval(wi, wo).map(|f| if scale.is_finite() { f * scale } else { 0.0 })
}

/// Pixels as a `data:` address of a PNG in sRGB.
///
/// # Errors
/// What the encoder says.
pub fn address(pixels: &[[f64; 3]]) -> anyhow::Result<String> {
    let encode = |x: f64| {
        let x = x.clamp(0.0, 1.0);
        let x = if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 };
        (255.0 * x).round() as u8
    };
    let bytes: Vec<u8> = pixels.iter().flatten().map(|x| encode(*x)).collect();
    let mut png = Vec::new();
    PngEncoder::new(&mut png).write_image(&bytes, SIDE as u32, SIDE as u32, ExtendedColorType::Rgb8)?;
    Ok(format!("data:image/png;base64,{}", STANDARD.encode(png)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A white Lambertian under the sky reflects its mean: the sum over the sphere agrees with an integral.
    #[test]
    fn pixels_are_what_the_sky_gives() {
        let pixels = sphere(&Material::lambert([1.0; 3]));
        // Of the pixels about the middle, whose normals are about the same.
        let about = || SIDE / 2 - 3..SIDE / 2 + 3;
        let sum: f64 = about().flat_map(|y| about().map(move |x| (x, y))).map(|(x, y)| pixels[y * SIDE + x][0]).sum();
        let centre = sum / 36.0;
        let n = 300;
        let mut right = 0.0;
        for i in 0..n * n {
            let (x, y) = (((i % n) as f64 + 0.5) / n as f64, ((i / n) as f64 + 0.5) / n as f64);
            let (r, (s, c)) = (x.sqrt(), (TAU * y).sin_cos());
            right += sky(DVec3::new(r * c, r * s, (1.0 - x).sqrt())) / (n * n) as f64;
        }
        assert!((centre / right - 1.0).abs() < 0.05, "{centre} {right}");
        assert!(address(&pixels).unwrap().starts_with("data:image/png;base64,iVBOR"));
    }
}

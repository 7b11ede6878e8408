//! Functions of the hemisphere as pictures on its projected disk: x to the right, y up, the normal in the middle.

use crate::color::luminance;
use crate::hemisphere::GatherSample;
use crate::image::Image;
use crate::metric::{SizeMismatch, false_color};
use crate::scene::Rgb;
use glam::{Vec2, Vec3A};
use rayon::prelude::*;

/// The pixels of a square picture that lie on the disk.
#[derive(Clone, Debug)]
pub struct Disk {
    size: u32,
    /// Index of a pixel and its unit direction, local frame.
    pixels: Vec<(usize, Vec3A)>,
}

impl Disk {
    /// The disk of a picture `size` pixels wide and high.
    pub fn new(size: u32) -> Self {
        let center = |i: u32| 2.0 * (i as f32 + 0.5) / size as f32 - 1.0;
        let pixels = (0..size * size)
            .filter_map(|i| {
                let p = Vec2::new(center(i % size), -center(i / size));
                let z2 = 1.0 - p.length_squared();
                (z2 > 0.0).then(|| (i as usize, Vec3A::new(p.x, p.y, z2.sqrt())))
            })
            .collect();
        Self { size, pixels }
    }

    /// Directions of the pixels on the disk.
    pub fn directions(&self) -> Vec<Vec3A> {
        self.pixels.iter().map(|p| p.1).collect()
    }

    /// The picture of one value per direction, times `exposure`; white around.
    pub fn image(&self, values: &[Rgb], exposure: f32) -> Image {
        let mut pixels = vec![[1.0; 3]; (self.size * self.size) as usize];
        for ((i, _), value) in self.pixels.iter().zip(values) {
            pixels[*i] = (*value * exposure).to_array();
        }
        Image { width: self.size, height: self.size, pixels }
    }

    /// The relative difference of two pictures of this disk in false colours; white around.
    ///
    /// # Errors
    /// Pictures of different sizes.
    pub fn difference(&self, image: &Image, reference: &Image) -> Result<Image, SizeMismatch> {
        let colors = false_color(image, reference)?;
        let on: Vec<Rgb> = self.pixels.iter().map(|(i, _)| Rgb::from_array(colors.pixels[*i])).collect();
        Ok(self.image(&on, 1.0))
    }

    /// Radiance of the sample nearest to every direction.
    pub fn nearest(&self, samples: &[GatherSample]) -> Vec<Rgb> {
        let nearest = |d: &Vec3A| samples.iter().max_by(|a, b| a.direction.dot(*d).total_cmp(&b.direction.dot(*d)));
        self.pixels.par_iter().map(|(_, d)| nearest(d).map_or(Rgb::ZERO, |s| s.radiance)).collect()
    }
}

/// Factor that takes all but the brightest hundredth of some radiances to the range of a screen; 1 for black.
pub fn exposure(values: &[Rgb]) -> f32 {
    let mut sorted: Vec<f32> = values.iter().map(|v| luminance(*v)).collect();
    sorted.sort_by(f32::total_cmp);
    let bright = sorted.get(sorted.len() * 99 / 100).copied().unwrap_or(0.0);
    if bright > 0.0 { 1.0 / bright } else { 1.0 }
}

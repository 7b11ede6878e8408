//! What is denoised: light by the way it took, and the guides that tell where it may change.

use crate::outlines::GUIDE_RAYS;
use crate::picture::{Picture, Pixel, first_half};
use crate::scene::Rgb;
use rayon::prelude::*;

/// Light of one kind, by pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct Layer {
    /// Mean of the samples.
    pub mean: Vec<[f32; 3]>,
    /// Means of the halves of the samples; `None` with one sample, which has no halves.
    pub halves: Option<[Vec<[f32; 3]>; 2]>,
}

/// A picture as denoisers see it, row by row from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Layers {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Samples of a pixel.
    pub spp: u32,
    /// Light that was scattered once, or all scattered light. `None` where all is black.
    pub direct: Option<Layer>,
    /// Light that was scattered more often, if that is apart.
    pub indirect: Option<Layer>,
    /// Reflectance, 0 to 1, of the surface that a pixel shows, perhaps through mirrors.
    pub albedo: Vec<[f32; 3]>,
    /// Mean of its unit normals; zero where there is none.
    pub normal: Vec<[f32; 3]>,
    /// Whether albedo and normals have little noise.
    pub clean_guides: bool,
    /// Whether `direct` is all scattered light.
    pub together: bool,
}

impl Layers {
    /// Of a rendering; with direct and indirect light `together`, or as is best.
    pub fn new(picture: &Picture, together: bool) -> Self {
        // Two kinds of noise are taken away better apart, and noise better in the midst of light that has none.
        let together = together || picture.from_records;
        let scattered = |p: &Pixel| p.sum().direct.sum() + p.sum().indirect.sum();
        let (direct, indirect) = if together {
            (Layer::new(picture, |p| sum_of_halves(p.half), scattered), None)
        } else {
            (
                Layer::new(picture, |p| Rgb::from_array(p.half[0]), |p| p.sum().direct.sum()),
                Layer::new(picture, |p| Rgb::from_array(p.half[1]), |p| p.sum().indirect.sum()),
            )
        };
        let albedo = picture.mean(|p| p.sum().albedo.clamp(Rgb::ZERO, Rgb::splat(picture.spp as f32)));
        Self {
            width: picture.width as usize,
            height: picture.height as usize,
            spp: picture.spp,
            direct,
            indirect,
            albedo,
            normal: picture.mean(|p| p.sum().normal),
            clean_guides: picture.spp.max(picture.outline_rays) >= GUIDE_RAYS,
            together,
        }
    }

    /// A square of anything, to see what it costs.
    pub fn example(side: usize) -> Self {
        let pixels = |k: usize| -> Vec<[f32; 3]> {
            (0..side * side).map(|i| [((i * k) % 101) as f32 / 100.0, 0.5, (i % side) as f32 / side as f32]).collect()
        };
        let layer = |k| Some(Layer { mean: pixels(k), halves: Some([pixels(k), pixels(k + 2)]) });
        Self {
            width: side,
            height: side,
            spp: 2,
            direct: layer(37),
            indirect: layer(41),
            albedo: pixels(1),
            normal: pixels(1),
            clean_guides: true,
            together: false,
        }
    }

    /// Pixels, and layers that are not black.
    pub fn size(&self) -> (usize, usize) {
        (self.width * self.height, [&self.direct, &self.indirect].into_iter().flatten().count())
    }

    /// The picture `self` was made of, from its light without noise, and emission as it is.
    pub fn merge(&self, picture: &Picture, light: &[Option<Vec<[f32; 3]>>; 2]) -> Vec<[f32; 3]> {
        let scale = 1.0 / picture.spp.max(1) as f32;
        let at = |layer: &Option<Vec<[f32; 3]>>, i: usize, noisy: Rgb| {
            let clean = layer.as_ref().and_then(|l| l.get(i)).map(|l| Rgb::from_array(*l));
            clean.filter(|l| l.is_finite()).unwrap_or(noisy)
        };
        let pixel = |(i, p): (usize, &Pixel)| {
            let (direct, indirect) = (p.sum().direct.sum() * scale, p.sum().indirect.sum() * scale);
            let scattered = if self.together {
                at(&light[0], i, direct + indirect)
            } else {
                at(&light[0], i, direct) + at(&light[1], i, indirect)
            };
            (p.sum().emission * scale + scattered).max(Rgb::ZERO).to_array()
        };
        picture.pixels.par_iter().enumerate().map(pixel).collect()
    }
}

impl Layer {
    /// Of light whose sum over all samples of a pixel, and over the first half of them, is this.
    fn new(picture: &Picture, half: impl Fn(&Pixel) -> Rgb, light: impl Fn(&Pixel) -> Rgb) -> Option<Self> {
        let mean = picture.mean(&light);
        if mean.iter().all(|p| *p == [0.0; 3]) {
            return None;
        }
        let first = first_half(picture.spp);
        let second = picture.spp - first;
        let halves = (second > 0).then(|| {
            [
                picture.pixels.iter().map(|p| (half(p) / first as f32).to_array()).collect(),
                picture.pixels.iter().map(|p| ((light(p) - half(p)) / second as f32).to_array()).collect(),
            ]
        });
        Some(Self { mean, halves })
    }
}

/// Direct and indirect light of the first half of the samples.
fn sum_of_halves([direct, indirect]: [[f32; 3]; 2]) -> Rgb {
    Rgb::from_array(direct) + Rgb::from_array(indirect)
}

//! What is denoised: light by the way it took, and the guides that tell where it may change.

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
    /// Light that was scattered once; `None` where all is black.
    pub direct: Option<Layer>,
    /// Light that was scattered more often.
    pub indirect: Option<Layer>,
    /// Reflectance, 0 to 1, of the surface that a pixel shows, perhaps through mirrors.
    pub albedo: Vec<[f32; 3]>,
    /// Mean of its unit normals; zero where there is none.
    pub normal: Vec<[f32; 3]>,
}

/// From this share of traced samples on the indirect light of a pixel is denoised wholly: below, what records hold is kept. (As
/// good as denoising it everywhere where records are all there is; from a quarter on, staircases have a tenth more error.)
const TRACED: f32 = 0.01;

impl Layers {
    /// Of a rendering.
    pub fn new(picture: &Picture) -> Self {
        let albedo = picture.mean(|p| p.sum().albedo.clamp(Rgb::ZERO, Rgb::splat(picture.spp as f32)));
        Self {
            width: picture.width as usize,
            height: picture.height as usize,
            spp: picture.spp,
            direct: Layer::new(picture, 0, |p| p.sum().direct.sum()),
            indirect: Layer::new(picture, 1, |p| p.sum().indirect.sum()),
            albedo,
            normal: picture.mean(|p| p.sum().normal),
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
        }
    }

    /// Pixels, and layers that are not black.
    pub fn size(&self) -> (usize, usize) {
        (self.width * self.height, [&self.direct, &self.indirect].into_iter().flatten().count())
    }

    /// The picture `self` was made of, from its light without noise: emission as it is, and the light of records too.
    pub fn merge(&self, picture: &Picture, light: &[Option<Vec<[f32; 3]>>; 2]) -> Vec<[f32; 3]> {
        let scale = 1.0 / picture.spp.max(1) as f32;
        let at = |layer: &Option<Vec<[f32; 3]>>, i: usize, noisy: Rgb| {
            let clean = layer.as_ref().and_then(|l| l.get(i)).map(|l| Rgb::from_array(*l));
            clean.filter(|l| l.is_finite()).unwrap_or(noisy)
        };
        let pixel = |(i, p): (usize, &Pixel)| {
            let (noisy, indirect) = (p.sum().direct.sum() * scale, p.sum().indirect.sum() * scale);
            let traced = ((1.0 - p.held * scale) / TRACED).clamp(0.0, 1.0);
            let indirect = indirect.lerp(at(&light[1], i, indirect), traced);
            (p.sum().emission * scale + at(&light[0], i, noisy) + indirect).max(Rgb::ZERO).to_array()
        };
        picture.pixels.par_iter().enumerate().map(pixel).collect()
    }
}

impl Layer {
    fn new(picture: &Picture, half: usize, light: impl Fn(&Pixel) -> Rgb) -> Option<Self> {
        let mean = picture.mean(&light);
        if mean.iter().all(|p| *p == [0.0; 3]) {
            return None;
        }
        let first = first_half(picture.spp);
        let second = picture.spp - first;
        let halves = (second > 0).then(|| {
            let of = |p: &Pixel| Rgb::from_array(p.half[half]);
            [
                picture.pixels.iter().map(|p| (of(p) / first as f32).to_array()).collect(),
                picture.pixels.iter().map(|p| ((light(p) - of(p)) / second as f32).to_array()).collect(),
            ]
        });
        Some(Self { mean, halves })
    }
}

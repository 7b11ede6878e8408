//! What is denoised: light by the way it took, and the guides that tell where it may change.

use super::level::Level;
use super::strips::Strip;
use crate::outlines::GUIDE_RAYS;
use crate::picture::{Picture, Pixel, first_half};
use crate::scene::Rgb;
use rayon::prelude::*;

/// Which scattered light is denoised in one piece.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// What was scattered once.
    Direct,
    /// What was scattered more often.
    Indirect,
    /// All.
    Both,
}

impl Kind {
    /// Layers of a picture: with direct and indirect light `together`, or apart.
    pub fn of(together: bool) -> [Option<Self>; 2] {
        if together { [Some(Self::Both), None] } else { [Some(Self::Direct), Some(Self::Indirect)] }
    }

    /// The light of this kind of all samples of a pixel.
    pub fn sum(self, pixel: &Pixel) -> Rgb {
        let sum = pixel.sum();
        match self {
            Self::Direct => sum.direct.sum(),
            Self::Indirect => sum.indirect.sum(),
            Self::Both => sum.direct.sum() + sum.indirect.sum(),
        }
    }

    /// That of the first half of them.
    fn half(self, pixel: &Pixel) -> Rgb {
        let [direct, indirect] = pixel.half.map(Rgb::from_array);
        match self {
            Self::Direct => direct,
            Self::Indirect => indirect,
            Self::Both => direct + indirect,
        }
    }
}

/// Light of one kind, by pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct Layer {
    /// Mean of the samples.
    pub mean: Vec<[f32; 3]>,
    /// Means of the halves of the samples; `None` with one sample, which has no halves.
    pub halves: Option<[Vec<[f32; 3]>; 2]>,
    /// How bright the picture is that this is a part of; `None` where it is the whole.
    pub level: Option<Level>,
}

/// A picture, or a strip of one, as denoisers see it, row by row from the top.
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
    /// Of what the denoiser sees of a strip of a rendering, with `levels` of the whole where there are more strips; with direct and
    /// indirect light `together` or apart.
    pub fn new(picture: &Picture, strip: &Strip, levels: [Option<Level>; 2], together: bool) -> Self {
        let (pixels, spp) = (&picture.pixels[strip.seen_pixels()], picture.spp);
        let kinds = Kind::of(together);
        let layer = |i: usize| kinds[i].and_then(|kind| Layer::new(pixels, spp, kind, levels[i]));
        Self {
            width: picture.width as usize,
            height: strip.seen.len(),
            spp,
            direct: layer(0),
            indirect: layer(1),
            albedo: mean(pixels, spp, |p| p.sum().albedo.clamp(Rgb::ZERO, Rgb::splat(spp as f32))),
            normal: mean(pixels, spp, |p| p.sum().normal),
            clean_guides: spp.max(picture.outline_rays) >= GUIDE_RAYS,
            together,
        }
    }

    /// A square of anything, to see what it costs.
    pub fn example(side: usize) -> Self {
        let pixels = |k: usize| -> Vec<[f32; 3]> {
            (0..side * side).map(|i| [((i * k) % 101) as f32 / 100.0, 0.5, (i % side) as f32 / side as f32]).collect()
        };
        let layer = |k| Some(Layer { mean: pixels(k), halves: Some([pixels(k), pixels(k + 2)]), level: None });
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

    /// The pixels of the strip that `self` was made of, from their light without noise, and emission as it is.
    pub fn merge<'a>(
        &'a self,
        picture: &'a Picture,
        strip: &Strip,
        light: &'a [Option<Vec<[f32; 3]>>; 2],
    ) -> impl IndexedParallelIterator<Item = [f32; 3]> + 'a {
        let scale = 1.0 / picture.spp.max(1) as f32;
        let clean = move |layer: usize, i: usize, p: &Pixel| {
            let Some(kind) = Kind::of(self.together)[layer] else { return Rgb::ZERO };
            let clean = light[layer].as_ref().and_then(|l| l.get(i)).map(|l| Rgb::from_array(*l));
            clean.filter(|l| l.is_finite()).unwrap_or_else(|| kind.sum(p) * scale)
        };
        let pixel = move |(i, p): (usize, &Pixel)| {
            let scattered = clean(0, i, p) + clean(1, i, p);
            (p.sum().emission * scale + scattered).max(Rgb::ZERO).to_array()
        };
        strip.inner().into_par_iter().zip(strip.pixels(picture)).map(pixel)
    }
}

impl Layer {
    /// Of pixels of so many samples.
    fn new(pixels: &[Pixel], spp: u32, kind: Kind, level: Option<Level>) -> Option<Self> {
        let mean = mean(pixels, spp, |p| kind.sum(p));
        if mean.iter().all(|p| *p == [0.0; 3]) {
            return None;
        }
        let first = first_half(spp);
        let second = spp - first;
        let halves = (second > 0).then(|| {
            [
                pixels.iter().map(|p| (kind.half(p) / first as f32).to_array()).collect(),
                pixels.iter().map(|p| ((kind.sum(p) - kind.half(p)) / second as f32).to_array()).collect(),
            ]
        });
        Some(Self { mean, halves, level })
    }
}

/// Mean over the samples of a sum that pixels hold.
fn mean(pixels: &[Pixel], spp: u32, of: impl Fn(&Pixel) -> Rgb) -> Vec<[f32; 3]> {
    let scale = 1.0 / spp.max(1) as f32;
    pixels.iter().map(|p| (of(p) * scale).to_array()).collect()
}

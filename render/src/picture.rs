//! What a rendering is while it is made: light by the way it took, sums of a pixel, a picture of them, and when it is done.

use crate::bsdf::Split;
use crate::denoise;
use crate::memory;
use crate::scene::{Camera, Crop, Rgb};
use crate::world::{Counts, Queries};
use glam::Vec3A;
use std::time::Duration;

/// When to stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Budget {
    /// After this many samples per pixel.
    Samples(u32),
    /// Before this much time has passed, but not before one sample per pixel.
    Time(Duration),
    /// When the root of the estimated relative mean square error (see [`Picture::relative_error`]) is at most this.
    Error(f32),
}

/// Sums over the samples of a pixel.
#[derive(Clone, Copy, Debug, Default)]
pub struct Pixel {
    /// Everything, summed, without the gaps that vectors leave.
    sums: [f32; RADIANCE],
    /// Sum of the squares of the samples' mean channel.
    pub squares: f32,
    /// Over the passes, sum of (the samples' sum)² / (their number).
    pub pass_squares: [f32; 3],
    /// Number of samples that met a surface.
    pub surfaces: u32,
    /// Direct and indirect light of the first half of the samples.
    pub half: [[f32; 3]; 2],
}

impl Pixel {
    /// Everything, summed; distances are depths along the camera's axis.
    #[inline(always)]
    pub fn sum(&self) -> Radiance {
        Radiance::unpacked(&self.sums)
    }

    /// Puts other sums in their place.
    #[inline(always)]
    pub(crate) fn set_sum(&mut self, sum: &Radiance) {
        self.sums = sum.packed();
    }

    /// Adds the sum of the samples of a pass.
    #[inline(always)]
    pub(crate) fn add_pass(&mut self, pass: Rgb, samples: f32) {
        self.pass_squares = (Rgb::from_array(self.pass_squares) + pass * pass / samples).to_array();
    }

    /// Adds the light of a sample; `first` tells its half.
    #[inline(always)]
    pub(crate) fn add(&mut self, sample: Radiance, first: bool) {
        if first {
            self.add_to_half([sample.direct.sum(), sample.indirect.sum()]);
        }
        for (sum, value) in self.sums.iter_mut().zip(sample.packed()) {
            *sum += value;
        }
    }

    /// Adds direct and indirect light of samples of the first half, which is in the sum on its own.
    #[inline(always)]
    pub(crate) fn add_to_half(&mut self, light: [Rgb; 2]) {
        for (sum, light) in self.half.iter_mut().zip(light) {
            *sum = (Rgb::from_array(*sum) + light).to_array();
        }
    }
}

/// Samples of the first half, of so many.
pub(crate) fn first_half(spp: u32) -> u32 {
    spp.div_ceil(2)
}

/// A rendering.
#[derive(Clone, Debug)]
pub struct Picture {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Column and row of the first pixel in the whole film.
    pub corner: [u32; 2],
    /// Row by row from the top.
    pub pixels: Vec<Pixel>,
    /// Samples of every pixel.
    pub spp: u32,
    /// Passes that took them.
    pub passes: u32,
    /// Camera rays that tell of what a pixel at an outline shows, where they are more than its samples
    /// ([`crate::outlines::refine`]).
    pub outline_rays: u32,
    /// Rays, and how many paths were dropped.
    pub counts: Counts,
    /// Whether indirect light comes from records, which have no noise, wherever they reach.
    pub from_records: bool,
    /// The whole light without its noise, by pixel, where a [`crate::denoise::Denoiser`] has been at work.
    pub denoised: Option<Vec<[f32; 3]>>,
}

/// Radiance along a ray, by the way the light took, and what the ray meets first.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Radiance {
    /// From emitters the ray itself meets.
    pub emission: Rgb,
    /// From emitters, scattered once; by the part of the first surface that scattered it.
    pub direct: Split,
    /// Scattered more than once; by the part of the first surface.
    pub indirect: Split,
    /// Reflectance of the first surface that is not perfectly specular, as mirrors and clear glass show it.
    pub albedo: Rgb,
    /// Its unit shading normal, towards where the light goes; zero without surface.
    pub normal: Vec3A,
    /// Distance to the first surface; 0 without surface.
    pub distance: f32,
}

/// Numbers of a [`Radiance`].
const RADIANCE: usize = 22;

impl Radiance {
    /// No light and no surface.
    pub const NONE: Self = Self {
        emission: Rgb::ZERO,
        direct: Split::ZERO,
        indirect: Split::ZERO,
        albedo: Rgb::ZERO,
        normal: Vec3A::ZERO,
        distance: 0.0,
    };

    /// Its numbers, one after the other.
    #[inline(always)]
    fn packed(&self) -> [f32; RADIANCE] {
        let (direct, indirect) = (self.direct, self.indirect);
        let colors =
            [self.emission, direct.diffuse, direct.glossy, indirect.diffuse, indirect.glossy, self.albedo, self.normal];
        let mut packed = [0.0; RADIANCE];
        for (i, c) in colors.into_iter().enumerate() {
            packed[3 * i..3 * i + 3].copy_from_slice(&c.to_array());
        }
        packed[RADIANCE - 1] = self.distance;
        packed
    }

    /// What has these numbers.
    #[inline(always)]
    fn unpacked(packed: &[f32; RADIANCE]) -> Self {
        let color = |i: usize| Rgb::new(packed[3 * i], packed[3 * i + 1], packed[3 * i + 2]);
        Self {
            emission: color(0),
            direct: Split { diffuse: color(1), glossy: color(2) },
            indirect: Split { diffuse: color(3), glossy: color(4) },
            albedo: color(5),
            normal: color(6),
            distance: packed[RADIANCE - 1],
        }
    }

    /// Light of all ways.
    #[inline]
    pub fn sum(&self) -> Rgb {
        self.emission + self.direct.sum() + self.indirect.sum()
    }

    /// Whether every number is finite, and so will be the sum over the samples of a pixel.
    #[inline]
    pub fn is_finite(&self) -> bool {
        summable(self.sum() + self.albedo + self.normal + Vec3A::splat(self.distance))
    }

    /// The same, or nothing where a number is not finite: nothing of a broken sample enters a picture. `queries` counts it.
    #[inline]
    pub fn finite(self, queries: &mut Queries) -> Self {
        if self.is_finite() {
            return self;
        }
        queries.counts.not_finite += 1;
        Self::default()
    }
}

/// Whether millions of such numbers have a sum; not so where one is NaN.
#[inline]
pub(crate) fn summable(x: Rgb) -> bool {
    x.abs().cmplt(Vec3A::splat(1e30)).all()
}

/// Bytes that a pixel takes while a file of it is made, beside the film: what a screen shows, in single precision and as it is
/// written. An EXR is made line by line.
const FILE_BYTES: u64 = 24;
/// Bytes of the surfaces that a cached rendering keeps of a pixel, about: a lens shows more of them.
const SURFACE_BYTES: [u64; 2] = [1024, 3072];

/// Bytes of a pixel without noise, and of what denoising a strip takes for each pixel that it sees.
const DENOISED_BYTES: u64 = 12;
const DENOISING_BYTES: u64 = 200;

/// Refuses a film for which there is not enough memory, with the surfaces of so many pixels kept at once, with a lens and with a
/// denoiser or without.
///
/// # Errors
/// One line with what it needs and what there is.
pub fn require_memory(camera: &Camera, kept: u64, lens: bool, denoised: bool) -> Result<(), String> {
    let window = camera.film.window();
    let Crop { width, height, .. } = window;
    let pixels = u64::from(width) * u64::from(height);
    let pixel = size_of::<Pixel>() as u64 + FILE_BYTES + if denoised { DENOISED_BYTES } else { 0 };
    let surfaces = kept.saturating_mul(SURFACE_BYTES[usize::from(lens)]);
    let denoising = if denoised { DENOISING_BYTES * denoise::seen(window) } else { 0 };
    // The surfaces are gone before the denoiser begins.
    let need = pixels.saturating_mul(pixel).saturating_add(surfaces.max(denoising));
    memory::require(&format!("a film of {width} × {height} pixels"), need)
        .map_err(|what| format!("{what}; choose a smaller one with --width, or a part of it with --crop"))
}

impl Picture {
    /// Sums over so many samples of every pixel of a part of a film, and what they took; without passes, and not denoised.
    pub(crate) fn of(window: Crop, pixels: Vec<Pixel>, spp: u32, counts: Counts, from_records: bool) -> Self {
        let Crop { x, y, width, height } = window;
        let (corner, passes, outline_rays) = ([x, y], 0, 0);
        Self { width, height, corner, pixels, spp, passes, outline_rays, counts, from_records, denoised: None }
    }

    /// Share of a pixel's samples that met a surface.
    pub fn alpha(&self, pixel: &Pixel) -> f32 {
        pixel.surfaces as f32 / self.spp.max(1) as f32
    }

    /// Variance of a pixel's mean, from the differences between passes, which see the even distribution of the samples
    /// inside each; `None` with less than two passes.
    pub fn variance(&self, pixel: &Pixel) -> Option<Rgb> {
        let (n, degrees) = (self.spp as f32, self.passes.checked_sub(1).filter(|d| *d > 0)? as f32);
        let sum = pixel.sum().sum();
        Some((Rgb::from_array(pixel.pass_squares) - sum * sum / n).max(Rgb::ZERO) / (degrees * n))
    }

    /// Root of the mean over the pixels of (variance of the pixel's mean)/(mean² + 0.01), in the mean of the channels.
    /// The variance is that of independent samples, so well distributed ones have less error than this says.
    pub fn relative_error(&self) -> f32 {
        let n = self.spp as f32;
        let of_pixel = |p: &Pixel| {
            let mean = p.sum().sum().element_sum() / (3.0 * n);
            let variance = (p.squares / n - mean * mean).max(0.0) / (n - 1.0).max(1.0);
            f64::from(variance / (mean * mean + 0.01))
        };
        let sum: f64 = self.pixels.iter().map(of_pixel).sum();
        (sum / self.pixels.len().max(1) as f64).sqrt() as f32
    }
}

//! Indirect light of rows of pixels, tile by tile, once their surfaces are known.

use super::indirect::Indirect;
use super::interpolation::{OnTile, Records};
use super::kinds::Scratches;
use super::shade::Shader;
use super::splat::{SIDE, Splats, Tile};
use super::surface::Surface;
use crate::bsdf::Split;
use crate::picture::{Pixel, first_half, summable};
use crate::sampler::Sampler;
use crate::scene::{Crop, Rgb};
use crate::simd::widest;
use crate::world::{Counts, Queries};
use fearless_simd::Level;

/// Memory of a thread.
#[derive(Default)]
pub(super) struct Memory {
    scratch: Scratches,
    tile: Tile,
}

/// What the indirect light of pixels takes.
pub(super) struct Reader<'a> {
    pub shader: &'a Shader<'a>,
    /// Records drawn onto the film; without them pixels look for records.
    pub splats: Option<&'a Splats<'a>>,
    pub seed: u64,
    /// Samples of every pixel.
    pub spp: u32,
}

/// Light of records that is known, for all samples of each pixel.
pub(super) type Known = Option<Split>;

impl Reader<'_> {
    /// Adds the indirect light of whole rows, but where it is known: what was traced, and pixels where it is negative. `place` is
    /// the first pixel on the film.
    pub fn rows(
        &self,
        place: (u32, u32),
        width: usize,
        pixels: &mut [Pixel],
        (surfaces, known): (&[Vec<Surface>], &[Known]),
        memory: &mut Memory,
    ) -> (Counts, u64) {
        let (mut queries, mut negative) = (Queries::default(), 0);
        let Memory { scratch, tile } = memory;
        for left in (0..width).step_by(SIDE) {
            let columns = left..(left + SIDE).min(width);
            let rows = surfaces.chunks(width).map(|row| &row[columns.clone()]);
            let start = (place.0 + left as u32, place.1);
            if let Some(splats) = self.splats {
                let (width, height) = (columns.len() as u32, surfaces.len().div_ceil(width) as u32);
                let crop = Crop { x: start.0, y: start.1, width, height };
                splats.draw(&crop, rows.clone().flatten().flatten(), tile);
            }
            let known = known.chunks(width).map(|row| &row[columns.clone()]);
            let pixels = pixels.chunks_mut(width).map(|row| &mut row[columns.clone()]);
            for (y, ((row, surfaces), known)) in (start.1..).zip(pixels.zip(rows).zip(known)) {
                let (place, row) = ((start.0, y), (row, surfaces, known));
                negative += match self.splats {
                    Some(splats) => self.row(place, row, &OnTile { splats, tile }, scratch, &mut queries),
                    None => self.row(place, row, self.shader.caches, scratch, &mut queries),
                };
            }
        }
        (queries.counts, negative)
    }

    /// The same of a part of a row: pixels where light is negative.
    fn row(
        &self,
        (x, y): (u32, u32),
        (pixels, surfaces, known): (&mut [Pixel], &[Vec<Surface>], &[Known]),
        records: &impl Records,
        scratch: &mut Scratches,
        queries: &mut Queries,
    ) -> u64 {
        let mut negative = 0;
        let share_of_first = first_half(self.spp) as f32 / self.spp.max(1) as f32;
        widest(
            Level::new(),
            #[inline(always)]
            || {
                for (x, (pixel, (surfaces, known))) in (x..).zip(pixels.iter_mut().zip(surfaces.iter().zip(known))) {
                    let samplers = |path: u32| Sampler::new(self.seed.wrapping_add(1), (x, y), path);
                    let indirect = match known {
                        Some(light) => Indirect::held(*light),
                        None => self.shader.indirect(surfaces, records, &samplers, scratch, queries),
                    };
                    if summable(indirect.light.sum()) {
                        let mut sum = pixel.sum();
                        sum.indirect = sum.indirect + indirect.light;
                        pixel.add_to_half([Rgb::ZERO, indirect.half * share_of_first]);
                        // Records may ring; a pixel never shines less than not at all.
                        let (here, all) = (indirect.light, sum.indirect);
                        if here.diffuse.min(here.glossy).min(all.diffuse).min(all.glossy).min_element() < 0.0 {
                            negative += 1;
                            sum.indirect.glossy -= sum.sum().min(Rgb::ZERO);
                        }
                        pixel.set_sum(&sum);
                    } else {
                        queries.counts.not_finite += surfaces.iter().map(Surface::samples).sum::<u64>();
                    }
                }
            },
        );
        negative
    }
}

//! Indirect light of rows of pixels, tile by tile, once their surfaces are known.

use super::drawn;
use super::indirect::Indirect;
use super::kind::Found;
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
    pub splats: Option<&'a Splats>,
    pub seed: u64,
    /// Samples of every pixel.
    pub spp: u32,
}

/// What the card says of the surfaces of each tile of a band, from the left; without one the processor looks.
pub(super) type OnCard<'a> = Option<&'a [Vec<Found>]>;

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
        (surfaces, known, card): (&[Vec<Surface>], &[Known], OnCard),
        memory: &mut Memory,
    ) -> (Counts, u64) {
        let (mut queries, mut negative) = (Queries::default(), 0);
        let Memory { scratch, tile } = memory;
        let splats = self.splats.filter(|_| card.is_none());
        if let Some(splats) = splats {
            splats.enter(place.1..place.1 + surfaces.len().div_ceil(width) as u32, tile);
        }
        for left in (0..width).step_by(SIDE) {
            let columns = left..(left + SIDE).min(width);
            let rows = surfaces.chunks(width).map(|row| &row[columns.clone()]);
            let known = known.chunks(width).map(|row| &row[columns.clone()]);
            let start = (place.0 + left as u32, place.1);
            let mut on_tile = splats.map(|splats| {
                let pixels = rows.clone().flatten().zip(known.clone().flatten());
                let all = pixels.filter(|(_, known)| known.is_none()).flat_map(|(surfaces, _)| surfaces);
                let all: Vec<&Surface> = all.filter(|s| self.shader.has_indirect(s)).collect();
                let (width, height) = (columns.len() as u32, surfaces.len().div_ceil(width) as u32);
                splats.draw(&Crop { x: start.0, y: start.1, width, height }, &all, tile);
                drawn::found(self.shader, tile, &all, scratch).into_iter()
            });
            if let Some(card) = card {
                on_tile = Some(card[left / SIDE].clone().into_iter());
            }
            let pixels = pixels.chunks_mut(width).map(|row| &mut row[columns.clone()]);
            for (y, ((row, surfaces), known)) in (start.1..).zip(pixels.zip(rows).zip(known)) {
                let (place, row) = ((start.0, y), (row, surfaces, known));
                negative += match &mut on_tile {
                    Some(found) => {
                        let next = |_: &Surface| found.next().unwrap_or(Found::NOTHING);
                        self.row(place, row, next, &mut queries)
                    }
                    None => {
                        let look = |s: &Surface| self.shader.found(s, &s.parts, scratch);
                        self.row(place, row, look, &mut queries)
                    }
                };
            }
        }
        (queries.counts, negative)
    }

    /// The same of a part of a row, `find` as in [`Shader::indirect`]: pixels where light is negative.
    fn row(
        &self,
        (x, y): (u32, u32),
        (pixels, surfaces, known): (&mut [Pixel], &[Vec<Surface>], &[Known]),
        mut find: impl FnMut(&Surface) -> Found,
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
                        None => self.shader.indirect(surfaces, &mut find, &samplers, queries),
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

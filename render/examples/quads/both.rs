//! Both ways on the same records and surfaces.

use super::Surface;
use super::card::Card;
use bytemuck::cast_slice;
use glam::Vec3A;
use render::integrator::cached::card::{IRRADIANCE_RUN, irradiance_rows};
use render::record::Record;
use render::record::irradiance::IrradianceRecord;
use std::error::Error;
use std::time::Instant;
use wgpu::*;

/// Sides of tiles, pixels, and threads of a group, as in the library.
const SIDE: usize = 16;
const THREADS: usize = 64;
/// Frames of which the fastest counts.
const FRAMES: usize = 5;

/// Irradiance times weight and weight of each pixel, and the milliseconds that they took.
type Frame = (Vec<[f32; 4]>, f64);

/// A card with both ways.
pub struct Both(Card);

/// Surfaces tile by tile, and the records near them.
#[derive(Default)]
struct Tiles {
    tiles: Vec<[u32; 4]>,
    near: Vec<u32>,
    surfaces: Vec<Surface>,
    /// Pixels of the surfaces.
    pixels: Vec<usize>,
}

impl Tiles {
    fn new(
        records: &[IrradianceRecord],
        rectangles: &[[f32; 4]],
        surfaces: &[Surface],
        (width, height): (usize, usize),
    ) -> Self {
        let mut all = Self::default();
        for top in (0..height).step_by(SIDE) {
            for left in (0..width).step_by(SIDE) {
                let firsts = [all.surfaces.len() as u32, all.near.len() as u32];
                let (right, bottom) = ((left + SIDE).min(width), (top + SIDE).min(height));
                let pixels = (top..bottom).flat_map(|y| (left..right).map(move |x| x + y * width));
                all.pixels.extend(pixels);
                let (first, pixels) = (firsts[0] as usize, &all.pixels[firsts[0] as usize..]);
                all.surfaces.extend(pixels.iter().map(|i| surfaces[*i]));
                let points = || all.surfaces[first..].iter().map(|s| Vec3A::from_slice(&s[0]));
                let seen = || points().filter(|p| p.x < 1e14);
                let low = seen().fold(Vec3A::INFINITY, Vec3A::min);
                let high = seen().fold(Vec3A::NEG_INFINITY, Vec3A::max);
                let reaches = |(i, r): (usize, &[f32; 4])| {
                    let meets = r[0] < right as f32 && r[2] > left as f32 && r[1] < bottom as f32 && r[3] > top as f32;
                    let (center, radius) = (records[i].position(), records[i].radius());
                    (meets && low.x <= high.x && center.clamp(low, high).distance_squared(center) <= radius * radius)
                        .then_some(i as u32)
                };
                let near: Vec<u32> = rectangles.iter().enumerate().filter_map(reaches).collect();
                all.near.extend(&near);
                all.tiles.push([firsts[0], (all.surfaces.len() - first) as u32, firsts[1], near.len() as u32]);
            }
        }
        all
    }
}

impl Both {
    pub fn open() -> Result<Self, Box<dyn Error>> {
        Card::open().map(Self)
    }

    pub fn name(&self) -> &str {
        &self.0.name
    }

    /// Head of the table.
    pub fn head(&self) -> String {
        let formats =
            self.0.quads.iter().map(|(format, _)| format!(" {format:?}: ms | off by | other order: other bytes |"));
        let formats: Vec<String> = formats.collect();
        let lines = "---|".repeat(4 + 3 * formats.len());
        format!("| records | pixels | records of a tile | tiles, ms |{}\n|{lines}", formats.concat())
    }

    /// A row of the table.
    pub fn compare(
        &self,
        records: &[IrradianceRecord],
        rectangles: &[[f32; 4]],
        surfaces: &[Surface],
        (width, height): (u32, u32),
    ) -> Result<String, Box<dyn Error>> {
        let limit = self.0.device.limits().max_storage_buffer_binding_size;
        if size_of_val(surfaces) as u64 > limit {
            return Err(
                format!("{width} × {height} surfaces are more than the adapter binds at once ({limit} bytes)").into()
            );
        }
        let rows: Vec<_> = records.iter().map(irradiance_rows).collect();
        let rows = self.0.upload(&rows);
        let tiles = Tiles::new(records, rectangles, surfaces, (width as usize, height as usize));
        let (walked, in_tiles) = self.by_tiles(&tiles, &rows)?;
        let in_order: Vec<u32> = (0..records.len() as u32).collect();
        let backwards: Vec<u32> = in_order.iter().rev().copied().collect();
        let mean =
            walked.iter().map(|sum| f64::from(sum[0] + sum[1] + sum[2]) / 3.0).sum::<f64>() / walked.len() as f64;
        let difference =
            |(a, b): (&[f32; 4], &[f32; 4])| (0..3).map(|i| f64::from((a[i] - b[i]).abs())).fold(0.0, f64::max);
        let longest = tiles.tiles.iter().map(|tile| tile[3]).max().unwrap_or(0);
        let mut row = format!(
            "| {} | {width} × {height} | {:.0}, at most {longest} | {in_tiles:.1} |",
            records.len(),
            tiles.near.len() as f64 / tiles.tiles.len() as f64,
        );
        for pipeline in &self.0.quads {
            let quads = |order: &[u32]| self.by_quads(pipeline, &rows, rectangles, surfaces, order, (width, height));
            let (blended, time) = quads(&in_order)?;
            let (other, _) = quads(&backwards)?;
            let off = walked.iter().zip(&blended).map(difference).fold(0.0, f64::max) / mean;
            let differ = blended.iter().zip(&other).filter(|(a, b)| a != b).count();
            row += &format!(" {time:.1} | {off:.1e} | {:.0} % |", 100.0 * differ as f64 / blended.len() as f64);
        }
        Ok(row)
    }

    /// Sums by tiles, pixel by pixel, and milliseconds of a frame.
    fn by_tiles(&self, all: &Tiles, records: &Buffer) -> Result<Frame, Box<dyn Error>> {
        let Self(card) = self;
        let [tiles, near, surfaces] = [cast_slice::<_, u32>(&all.tiles), &all.near, cast_slice(&all.surfaces)]
            .map(|numbers| card.upload(numbers));
        let bytes = 32 * all.surfaces.len() as u64;
        let sums = card.upload(&vec![0u32; bytes as usize / 4]);
        let layout = card.tiles.get_bind_group_layout(0);
        let most = all.tiles.iter().map(|tile| tile[3]).max().unwrap_or(0);
        let runs: Vec<_> = (0..most)
            .step_by(IRRADIANCE_RUN as usize)
            .map(|first| {
                let first = card.upload(&[first]);
                let bound = [(0, &tiles), (1, &near), (2, &surfaces), (3, records), (4, &sums), (5, &first)];
                card.bind(&layout, &bound)
            })
            .collect();
        let time = fastest(|| {
            let mut commands = card.device.create_command_encoder(&Default::default());
            commands.clear_buffer(&sums, 0, None);
            for run in &runs {
                let mut pass = commands.begin_compute_pass(&Default::default());
                pass.set_pipeline(&card.tiles);
                pass.set_bind_group(0, run, &[]);
                pass.dispatch_workgroups(all.tiles.len() as u32, 1, (SIDE * SIDE / THREADS) as u32);
            }
            card.submit(commands)
        })?;
        let bytes = card.read(bytes, |commands, to| commands.copy_buffer_to_buffer(&sums, 0, to, 0, bytes))?;
        let mut pixels = vec![[0.0; 4]; all.surfaces.len()];
        // Irradiance, radius, weights, and room.
        for (sum, pixel) in bytemuck::pod_collect_to_vec::<u8, [f32; 8]>(&bytes).iter().zip(&all.pixels) {
            pixels[*pixel] = [sum[0], sum[1], sum[2], sum[4]];
        }
        Ok((pixels, time))
    }

    /// The same by quads, drawn in this order.
    fn by_quads(
        &self,
        (format, quads): &(TextureFormat, RenderPipeline),
        records: &Buffer,
        rectangles: &[[f32; 4]],
        surfaces: &[Surface],
        order: &[u32],
        (width, height): (u32, u32),
    ) -> Result<Frame, Box<dyn Error>> {
        let Self(card) = self;
        let [surfaces, rectangles, drawn, size] =
            [cast_slice::<_, u32>(surfaces), cast_slice(rectangles), order, &[width, height]].map(|n| card.upload(n));
        let layout = quads.get_bind_group_layout(0);
        let bound = [(2, &surfaces), (3, records), (6, &rectangles), (7, &drawn), (8, &size)];
        let group = card.bind(&layout, &bound);
        let extent = Extent3d { width, height, depth_or_array_layers: 1 };
        let picture = card.device.create_texture(&TextureDescriptor {
            label: None,
            size: extent,
            mip_level_count: 1,
            sample_count: 1,
            dimension: TextureDimension::D2,
            format: *format,
            usage: TextureUsages::RENDER_ATTACHMENT | TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        let view = picture.create_view(&Default::default());
        let time = fastest(|| {
            let mut commands = card.device.create_command_encoder(&Default::default());
            {
                let ops = Operations { load: LoadOp::Clear(Color::TRANSPARENT), store: StoreOp::Store };
                let target = RenderPassColorAttachment { view: &view, depth_slice: None, resolve_target: None, ops };
                let mut pass = commands.begin_render_pass(&RenderPassDescriptor {
                    color_attachments: &[Some(target)],
                    ..Default::default()
                });
                pass.set_pipeline(quads);
                pass.set_bind_group(0, &group, &[]);
                pass.draw(0..4, 0..order.len() as u32);
            }
            card.submit(commands)
        })?;
        let pixel = format.block_copy_size(None).unwrap_or(16);
        let row = (width * pixel).next_multiple_of(COPY_BYTES_PER_ROW_ALIGNMENT);
        let bytes = card.read(u64::from(row * height), |commands, to| {
            let layout = TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row), rows_per_image: None };
            let buffer = TexelCopyBufferInfo { buffer: to, layout };
            commands.copy_texture_to_buffer(picture.as_image_copy(), buffer, extent);
        })?;
        let rows =
            bytes.chunks(row as usize).flat_map(|bytes| bytes[..(width * pixel) as usize].chunks(pixel as usize));
        Ok((rows.map(numbers).collect(), time))
    }
}

/// The numbers of a pixel.
fn numbers(pixel: &[u8]) -> [f32; 4] {
    if pixel.len() == 16 {
        bytemuck::pod_read_unaligned(pixel)
    } else {
        let halves: [u16; 4] = bytemuck::pod_read_unaligned(pixel);
        halves.map(from_half)
    }
}

/// Half precision as single, without infinities, which no sum here is.
fn from_half(bits: u16) -> f32 {
    let (exponent, mantissa) = (i32::from(bits >> 10 & 31), f32::from(bits & 1023));
    let magnitude =
        if exponent == 0 { mantissa * 2f32.powi(-24) } else { (1024.0 + mantissa) * 2f32.powi(exponent - 25) };
    if bits >> 15 == 1 { -magnitude } else { magnitude }
}

/// Milliseconds of the fastest of some frames, after one that does not count.
fn fastest(mut frame: impl FnMut() -> Result<(), Box<dyn Error>>) -> Result<f64, Box<dyn Error>> {
    frame()?;
    let mut best = f64::INFINITY;
    for _ in 0..FRAMES {
        let begun = Instant::now();
        frame()?;
        best = best.min(1e3 * begun.elapsed().as_secs_f64());
    }
    Ok(best)
}

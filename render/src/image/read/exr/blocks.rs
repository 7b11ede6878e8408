//! Lines of samples from the blocks of one part.
//!
//! The `exr` crate parses headers and decompresses; its own way to whole images refuses subsampled channels, reads
//! parts and channels that nobody asked for, and allocates what the header says before it looks at the blocks.

use super::super::one_line;
use exr::block::chunk::TileCoordinates;
use exr::math::Vec2;
use exr::meta::attribute::{ChannelDescription, IntegerBounds, SampleType};
use exr::meta::header::Header;
use exr::meta::{BlockDescription, MetaData};
use exr::prelude::{Compression, f16};
use rayon::prelude::*;

/// Blocks decompressed at a time, for all threads together.
const BATCH: usize = 64;

/// A compressed block, and where it lies.
struct Block<'a> {
    tile: TileCoordinates,
    data: &'a [u8],
}

/// Samples of one channel: the row, the column of the first, in samples of that channel.
pub struct Line<'a> {
    /// Index into the channels wanted.
    pub channel: usize,
    /// Column and row of the first sample.
    pub at: [usize; 2],
    /// The samples.
    pub samples: &'a [f32],
}

/// Blocks of one part, all of them there and of a plausible size.
pub struct Blocks<'a> {
    header: &'a Header,
    blocks: Vec<Block<'a>>,
}

/// Little-endian integers at the front of some bytes.
struct Cursor<'a>(&'a [u8]);

impl<'a> Cursor<'a> {
    fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let (taken, rest) = self.0.split_at_checked(count)?;
        self.0 = rest;
        Some(taken)
    }

    fn i32(&mut self) -> Option<i32> {
        Some(i32::from_le_bytes(self.take(4)?.try_into().ok()?))
    }

    fn usize(&mut self) -> Option<usize> {
        usize::try_from(self.i32()?).ok()
    }
}

impl<'a> Blocks<'a> {
    /// Finds the blocks of the largest level of a part. `tables` is where the offset tables begin.
    ///
    /// # Errors
    /// Headers and blocks that contradict each other, blocks that are missing, what the crate cannot decompress.
    pub fn find(bytes: &'a [u8], meta: &'a MetaData, part: usize, tables: usize) -> Result<Self, String> {
        let header = &meta.headers[part];
        check(header)?;
        let before: usize = meta.headers[..part].iter().map(|h| h.chunk_count).fold(0, usize::saturating_add);
        let size = header.max_block_pixel_size();
        let [columns, rows] = [header.layer_size.x().div_ceil(size.x()), header.layer_size.y().div_ceil(size.y())];
        let count = columns.saturating_mul(rows);
        let start = before.checked_mul(8).and_then(|n| n.checked_add(tables));
        let length = count.saturating_mul(8);
        let table = start.and_then(|s| bytes.get(s..)).and_then(|b| b.get(..length));
        let table = table.ok_or("its table of blocks is cut off")?.as_chunks::<8>().0;
        let multipart = meta.requirements.is_multilayer().then_some(part);
        let find = |(i, offset): (usize, &[u8; 8])| {
            let tile = TileCoordinates { tile_index: Vec2(i % columns, i / columns), level_index: Vec2(0, 0) };
            let offset = usize::try_from(u64::from_le_bytes(*offset)).ok();
            let data = offset.and_then(|o| bytes.get(o..)).and_then(|b| data(b, header, tile, multipart));
            data.map(|data| Block { tile, data }).ok_or_else(|| format!("block {} of {count} is missing", i + 1))
        };
        let blocks: Vec<_> = table.iter().enumerate().map(find).collect::<Result<_, _>>()?;
        let stored = blocks.iter().map(|b| b.data.len()).sum::<usize>();
        let samples =
            |c: &ChannelDescription| c.sample_type.bytes_per_sample() * c.subsampled_pixels(header.layer_size);
        let claimed = header.channels.list.iter().map(samples).fold(0, usize::saturating_add);
        if claimed / most_per_byte(header.compression) > stored {
            return Err(format!("{stored} bytes of blocks cannot hold the {claimed} that its header claims"));
        }
        Ok(Self { header, blocks })
    }

    /// Decompresses all blocks and hands out the lines of the `wanted` channels.
    ///
    /// # Errors
    /// Damaged blocks.
    pub fn lines(&self, wanted: &[usize], mut sink: impl FnMut(Line)) -> Result<(), String> {
        for batch in self.blocks.chunks(BATCH) {
            let decompressed: Vec<_> = batch.par_iter().map(|b| self.decompress(b)).collect::<Result<_, _>>()?;
            for (section, bytes) in decompressed {
                self.split(section, &bytes, wanted, &mut sink).ok_or("a block is too short")?;
            }
        }
        Ok(())
    }

    fn decompress(&self, block: &Block) -> Result<(IntegerBounds, Vec<u8>), String> {
        let text = |e: exr::error::Error| one_line(&e.to_string());
        let section = self.header.get_absolute_block_pixel_coordinates(block.tile).map_err(text)?;
        // The crate sizes a block by the bytes of a pixel; where channels are subsampled, this is its mean in the block.
        let mut header = std::borrow::Cow::Borrowed(self.header);
        let (bytes, pixels) = (self.bytes(section), section.size.area());
        if bytes != pixels * header.channels.bytes_per_pixel {
            if pixels == 0 || bytes % pixels != 0 {
                return Err("subsampling other than by 2 is not read".into());
            }
            header.to_mut().channels.bytes_per_pixel = bytes / pixels;
        }
        if matches!(header.compression, Compression::DWAA(_) | Compression::DWAB(_)) {
            let whole = section.size.x().next_multiple_of(8) * section.size.y().next_multiple_of(8);
            check_dwa(block.data, whole.saturating_mul(header.channels.list.len()))?;
        }
        let data = block.data.to_vec();
        let bytes = header.compression.decompress_image_section_from_le(&header, data, section, false);
        Ok((section, bytes.map_err(text)?))
    }

    /// Rows of a section, and which channels have samples in them.
    fn rows(&self, section: IntegerBounds) -> impl Iterator<Item = (usize, usize, usize)> {
        let (start, height) = (section.position.y() as usize, section.size.y());
        (start..start + height).flat_map(move |y| {
            let channels = self.header.channels.list.iter().enumerate();
            let here = channels.filter(move |(_, c)| y % c.sampling.y() == 0);
            here.map(move |(i, c)| (y, i, section.size.x() / c.sampling.x()))
        })
    }

    /// Uncompressed size of a section.
    fn bytes(&self, section: IntegerBounds) -> usize {
        let size = |i: usize| self.header.channels.list[i].sample_type.bytes_per_sample();
        self.rows(section).map(|(_, channel, samples)| samples * size(channel)).sum()
    }

    fn split(&self, section: IntegerBounds, bytes: &[u8], wanted: &[usize], sink: &mut impl FnMut(Line)) -> Option<()> {
        let mut rest = Cursor(bytes);
        let mut samples = Vec::with_capacity(section.size.x());
        for (y, i, count) in self.rows(section) {
            let description = &self.header.channels.list[i];
            let raw = rest.take(count * description.sample_type.bytes_per_sample())?;
            // Decompressed samples are in the machine's order of bytes. One channel may serve for several.
            for channel in (0..wanted.len()).filter(|c| wanted[*c] == i) {
                samples.clear();
                match description.sample_type {
                    SampleType::F16 => {
                        samples.extend(raw.as_chunks().0.iter().map(|b| f16::from_ne_bytes(*b).to_f32()))
                    }
                    SampleType::F32 => samples.extend(raw.as_chunks().0.iter().map(|b| f32::from_ne_bytes(*b))),
                    SampleType::U32 => samples.extend(raw.as_chunks().0.iter().map(|b| u32::from_ne_bytes(*b) as f32)),
                }
                let at = [section.position.x() as usize / description.sampling.x(), y / description.sampling.y()];
                sink(Line { channel, at, samples: &samples });
            }
        }
        Some(())
    }
}

/// What the crate asserts or gets wrong, before it is asked.
fn check(header: &Header) -> Result<(), String> {
    match header.compression {
        Compression::HTJ2K32 | Compression::HTJ2K256 => {
            return Err(format!("{} is not read", header.compression));
        }
        _ => {}
    }
    let mut whole = header.clone();
    for channel in &mut whole.channels.list {
        let Vec2(x, y) = channel.sampling;
        if (x, y) == (1, 1) {
            continue;
        }
        let even = |a: Vec2<usize>| x > 0 && y > 0 && a.x().is_multiple_of(x) && a.y().is_multiple_of(y);
        let position = header.own_attributes.layer_position;
        let position = Vec2(position.x().unsigned_abs() as usize, position.y().unsigned_abs() as usize);
        if !even(header.layer_size) || !even(position) || header.blocks != BlockDescription::ScanLines {
            return Err(format!("channel {}: the subsampling does not fit the data window", channel.name));
        }
        if matches!(header.compression, Compression::B44 | Compression::B44A) {
            return Err(format!("subsampled channels with {} are not read", header.compression));
        }
        channel.sampling = Vec2(1, 1);
    }
    // The crate's own checks refuse subsampling.
    whole.validate(false, &mut false, false).map_err(|e| one_line(&e.to_string()))?;
    let block = header.max_block_pixel_size();
    if header.layer_size.area() == 0 || block.area() == 0 || header.channels.bytes_per_pixel == 0 {
        return Err("an image without pixels".into());
    }
    Ok(())
}

/// The compressed bytes of a block, if what stands before them names this tile (of this part, where there are several).
fn data<'a>(bytes: &'a [u8], header: &Header, tile: TileCoordinates, part: Option<usize>) -> Option<&'a [u8]> {
    let mut cursor = Cursor(bytes);
    if part.is_some_and(|part| cursor.usize() != Some(part)) {
        return None;
    }
    let named = match header.blocks {
        BlockDescription::ScanLines => {
            let line = tile.tile_index.y().checked_mul(header.compression.scan_lines_per_block())?;
            let first = header.own_attributes.layer_position.y();
            i64::from(cursor.i32()?) == i64::from(first) + i64::try_from(line).ok()?
        }
        BlockDescription::Tiles(_) => {
            let [x, y, level_x, level_y] = [cursor.usize()?, cursor.usize()?, cursor.usize()?, cursor.usize()?];
            (Vec2(x, y), Vec2(level_x, level_y)) == (tile.tile_index, tile.level_index)
        }
    };
    let length = cursor.usize()?;
    cursor.take(length).filter(|data| named && !data.is_empty())
}

/// The crate allocates what the counters before a DWA block say; each counts bytes or coefficients of so many samples
/// of at most four bytes.
fn check_dwa(data: &[u8], samples: usize) -> Result<(), String> {
    let counters = data.as_chunks::<8>().0.iter().take(10).skip(1).map(|b| u64::from_le_bytes(*b));
    let most = samples.saturating_mul(4) as u64;
    if counters.max().is_some_and(|c| c > most) { Err("a DWA block is broken".into()) } else { Ok(()) }
}

/// Bytes that one compressed byte can stand for: deflate repeats 1032 times at most, and DWA keeps 2 bytes of 128 before
/// that; PIZ and the run lengths repeat less.
fn most_per_byte(compression: Compression) -> usize {
    match compression {
        Compression::Uncompressed => 1,
        Compression::DWAA(_) | Compression::DWAB(_) => 1 << 17,
        _ => 1 << 11,
    }
}

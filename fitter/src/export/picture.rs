//! OpenEXR, in single precision.

use exr::prelude::{Image, SpecificChannels, Vec2, WritableImage};
use std::io::Cursor;

/// One channel, Y, row by row.
///
/// # Errors
/// What the encoder says.
pub fn exr(width: usize, values: &[f32]) -> anyhow::Result<Vec<u8>> {
    let pixel = |p: Vec2<usize>| (values[p.y() * width + p.x()],);
    let channels = SpecificChannels::build().with_channel("Y").with_pixel_fn(pixel);
    let mut file = Cursor::new(Vec::new());
    Image::from_channels((width, values.len() / width), channels).write().to_buffered(&mut file)?;
    Ok(file.into_inner())
}

/// R, G and B, row by row.
///
/// # Errors
/// What the encoder says.
pub fn exr_rgb(width: usize, values: &[[f32; 3]]) -> anyhow::Result<Vec<u8>> {
    let pixel = |p: Vec2<usize>| {
        let [r, g, b] = values[p.y() * width + p.x()];
        (r, g, b)
    };
    let mut file = Cursor::new(Vec::new());
    Image::from_channels((width, values.len() / width), SpecificChannels::rgb(pixel)).write().to_buffered(&mut file)?;
    Ok(file.into_inner())
}

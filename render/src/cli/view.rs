//! What part of the scene is drawn, and how large.

use anyhow::{Result, anyhow};
use render::film::Pixel;
use render::memory;
use render::scene::{Camera, Crop};

/// Largest width or height.
pub(super) const MAX_SIZE: u32 = 1 << 15;

/// Applies `--width`, `--height` and `--crop`. A new size drops the crop of the file, whose pixels are others.
pub(super) fn change(camera: &mut Camera, width: Option<u32>, height: Option<u32>, crop: Option<Crop>) {
    resize(camera, width, height);
    if let Some(crop) = crop {
        camera.film.crop = Some(crop);
    }
}

/// Sets the size of the film; one number alone keeps the aspect.
pub(crate) fn resize(camera: &mut Camera, width: Option<u32>, height: Option<u32>) {
    let film = &mut camera.film;
    let scaled = |x: u32, to: u32, from: u32| {
        ((u64::from(x) * u64::from(to) + u64::from(from) / 2) / u64::from(from)).clamp(1, u64::from(MAX_SIZE)) as u32
    };
    let (width, height) = match (width, height) {
        (None, None) => (film.width, film.height),
        (Some(w), Some(h)) => (w, h),
        (Some(w), None) => (w, scaled(film.height, w, film.width)),
        (None, Some(h)) => (scaled(film.width, h, film.height), h),
    };
    if (width, height) != (film.width, film.height) {
        (film.width, film.height, film.crop) = (width, height, None);
    }
}

/// Bytes that a pixel takes while an EXR of it is made, beside the film: channels, and the file twice while it grows.
const EXR_BYTES: u64 = 28 * 4 * 3;
/// Bytes of the surfaces that a cached rendering keeps of a pixel, about: a lens shows more of them.
const SURFACE_BYTES: [u64; 2] = [1024, 3072];

/// Refuses a film for which there is not enough memory, with caches and with a lens or without.
///
/// # Errors
/// One line with what it needs and what there is.
pub(crate) fn require_memory(camera: &Camera, cached: bool, lens: bool) -> Result<()> {
    let Crop { width, height, .. } = camera.film.window();
    let pixel = size_of::<Pixel>() as u64 + if cached { SURFACE_BYTES[usize::from(lens)] } else { EXR_BYTES };
    let need = (u64::from(width) * u64::from(height)).saturating_mul(pixel);
    memory::require(&format!("a film of {width} × {height} pixels"), need)
        .map_err(|what| anyhow!("{what}; choose a smaller one with --width, or a part of it with --crop"))
}

pub(super) fn parse_crop(text: &str) -> Result<Crop, String> {
    let numbers: Result<Vec<u32>, _> = text.split(',').map(|n| n.trim().parse()).collect();
    match numbers.as_deref() {
        Ok(&[x, y, width, height]) => Ok(Crop { x, y, width, height }),
        _ => Err("expected X,Y,WIDTH,HEIGHT: four whole numbers ≥ 0".into()),
    }
}

//! What part of the scene is drawn, and how large.

use render::scene::{Camera, Crop};

/// Applies `--width`, `--height` and `--crop`. A new size drops the crop of the file, whose pixels are others.
pub(super) fn change(camera: &mut Camera, width: Option<u32>, height: Option<u32>, crop: Option<Crop>) {
    camera.film.resize(width, height);
    if let Some(crop) = crop {
        camera.film.crop = Some(crop);
    }
}

pub(super) fn parse_crop(text: &str) -> Result<Crop, String> {
    let numbers: Result<Vec<u32>, _> = text.split(',').map(|n| n.trim().parse()).collect();
    match numbers.as_deref() {
        Ok(&[x, y, width, height]) => Ok(Crop { x, y, width, height }),
        _ => Err("expected X,Y,WIDTH,HEIGHT: four whole numbers ≥ 0".into()),
    }
}

//! From a picture to what a browser shows.

use crate::image::view::Display;
use crate::image::{Image, jpeg};
use crate::inspect::overlay::{Marks, show_marks};
use crate::integrator::cached::Caches;
use crate::picture::Picture;
use crate::scene::Camera;
use crate::world::World;

/// Quality of JPEG: of frames that the next one follows at once, and of a picture that stays.
const QUICK: u8 = 80;
const FINE: u8 = 95;

/// Records to be drawn over a picture.
pub(super) struct Marked<'a> {
    pub world: &'a World,
    pub camera: &'a Camera,
    pub caches: &'a Caches,
    pub marks: Marks,
}

/// A picture as JPEG.
pub(super) fn painted(picture: &Picture, display: &Display, marked: Option<&Marked>, stays: bool) -> Option<Vec<u8>> {
    let quality = if stays { FINE } else { QUICK };
    let image = picture.image();
    let Some(Marked { world, camera, caches, marks }) = marked else { return jpeg(&image, display, quality) };
    // Records keep their colours: the view is of the picture below them.
    let shown: Image = show_marks(&display.shown(&image), (world, camera), caches, *marks);
    jpeg(&shown, &Display::STANDARD, quality)
}

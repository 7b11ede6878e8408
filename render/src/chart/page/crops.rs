//! Crops of all pictures side by side, of where they differ most from the reference.

use super::html::{escape, picture};
use anyhow::Result;
use image::imageops::crop_imm;
use image::{ImageFormat, RgbImage, load_from_memory};
use std::fmt::Write;
use std::io::Cursor;

/// Part of the longer side of a picture that a crop shows, and its least side in pixels.
const PART: u32 = 5;
const LEAST: u32 = 24;

/// A picture as PNG, with what is said below it.
pub struct Shown {
    pub about: String,
    pub png: Vec<u8>,
}

/// The section; empty where there are no two pictures to compare.
///
/// # Errors
/// A picture that cannot be read.
pub fn section(reference: &[u8], shown: &[Shown]) -> Result<String> {
    let truth = load_from_memory(reference)?.into_rgb8();
    let images = shown.iter().map(|s| Ok(load_from_memory(&s.png)?.into_rgb8())).collect::<Result<Vec<_>>>()?;
    let (width, height) = truth.dimensions();
    let side = (width.max(height) / PART).max(LEAST);
    if images.len() < 2 || side >= width || side >= height || images.iter().any(|i| i.dimensions() != (width, height)) {
        return Ok(String::new());
    }
    let (x, y) = worst(&truth, &images, side);
    let cut = |image: &RgbImage| -> Result<Vec<u8>> {
        let mut png = Cursor::new(Vec::new());
        crop_imm(image, x, y, side, side).to_image().write_to(&mut png, ImageFormat::Png)?;
        Ok(png.into_inner())
    };
    let mut text = format!(
        "<h3>Crops</h3>\n<p>{side} × {side} pixels from column {x}, row {y}: there the pictures differ most from the \
         reference.</p>\n<div class=\"pictures\">\n<figure>{}<figcaption>reference</figcaption></figure>\n",
        picture(&cut(&truth)?, "crop of the reference")
    );
    for (s, image) in shown.iter().zip(&images) {
        let about = escape(&s.about);
        let crop = picture(&cut(image)?, &format!("crop of {}", s.about));
        let _ = writeln!(text, "<figure>{crop}<figcaption>{about}</figcaption></figure>");
    }
    Ok(text + "</div>\n")
}

/// The corner of the square of this side in which the pictures together differ most from the truth, on a lattice of half a side.
fn worst(truth: &RgbImage, images: &[RgbImage], side: u32) -> (u32, u32) {
    let (width, height) = truth.dimensions();
    let places = |size: u32| (0..=size - side).step_by((side / 2) as usize);
    let difference = |x: u32, y: u32| -> u64 {
        let of = |image: &RgbImage| -> u64 {
            let (a, b) = (image.get_pixel(x, y).0, truth.get_pixel(x, y).0);
            a.into_iter().zip(b).map(|(a, b)| u64::from(a.abs_diff(b))).sum()
        };
        images.iter().map(of).sum()
    };
    let sum = |(left, top): (u32, u32)| -> u64 {
        (top..top + side).flat_map(|y| (left..left + side).map(move |x| difference(x, y))).sum()
    };
    // The first of equal ones.
    let all = places(height).flat_map(|y| places(width).map(move |x| (x, y)));
    all.max_by_key(|corner| (sum(*corner), core::cmp::Reverse(*corner))).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::Rgb;

    #[test]
    fn crops_show_where_pictures_are_wrong() {
        let truth = RgbImage::new(200, 120);
        let mut wrong = truth.clone();
        (140..150).for_each(|x| wrong.put_pixel(x, 70, Rgb([200, 0, 0])));
        let (x, y) = worst(&truth, &[truth.clone(), wrong], 40);
        assert!((100..=140).contains(&x) && (31..=70).contains(&y), "{x} {y}");
        let png = |image: &RgbImage| {
            let mut bytes = Cursor::new(Vec::new());
            image.write_to(&mut bytes, ImageFormat::Png).unwrap();
            bytes.into_inner()
        };
        let shown = ["path", "eas"].map(|about| Shown { about: about.into(), png: png(&truth) });
        let text = section(&png(&truth), &shown).unwrap();
        assert!(text.contains("Crops") && text.matches("<img").count() == 3, "{text:.200}");
        assert!(section(&png(&truth), &shown[..1]).unwrap().is_empty());
    }
}

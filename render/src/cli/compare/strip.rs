//! A column of every frame beside that of the next: what flickers is seen at a glance.

use render::image::Image;

/// Rows between the strip of the frames and that of the references.
const GAP: u32 = 4;

/// The middle columns of frames from left to right, and those of their references below.
#[derive(Default)]
pub(in crate::cli) struct Strip {
    columns: Vec<Vec<[f32; 3]>>,
}

impl Strip {
    /// Adds a frame with its reference.
    pub fn add(&mut self, image: &Image, reference: &Image) {
        let column = |image: &Image| -> Vec<[f32; 3]> {
            let x = (image.width / 2) as usize;
            image.pixels.chunks_exact(image.width.max(1) as usize).map(|row| row[x]).collect()
        };
        let gap = [[1.0; 3]; GAP as usize];
        self.columns.push([column(image), gap.to_vec(), column(reference)].concat());
    }

    /// The picture; frames that are less high are black below.
    pub fn image(&self) -> Image {
        let (width, height) = (self.columns.len(), self.columns.iter().map(Vec::len).max().unwrap_or(0));
        let pixel = |i: usize| self.columns[i % width].get(i / width).copied().unwrap_or_default();
        Image { width: width as u32, height: height as u32, pixels: (0..width * height).map(pixel).collect() }
    }
}

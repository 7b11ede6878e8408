//! Images one number deep, with a rim, so that what looks at neighbours needs not ask where the picture ends.

use crate::denoise::layers::{Layer, Layers};

/// Columns and rows of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Size {
    pub width: usize,
    pub height: usize,
}

/// How far neighbours are looked for each way, and the patches around them that are compared.
pub(super) const REACH: usize = 8;
pub(super) const PATCH: usize = 2;

/// Width of the rim.
const RIM: usize = REACH + PATCH;

/// Numbers row by row, with a rim.
#[derive(Clone, Debug)]
pub(super) struct Plane {
    values: Vec<f32>,
    stride: usize,
}

impl Plane {
    /// Of the pixels; the rim repeats the outermost ones.
    pub fn new(size: Size, pixel: impl Fn(usize) -> f32) -> Self {
        let at = |padded: usize, end: usize| padded.saturating_sub(RIM).min(end - 1);
        let columns: Vec<usize> = (0..size.width + 2 * RIM).map(|x| at(x, size.width)).collect();
        let rows = (0..size.height + 2 * RIM).map(|y| at(y, size.height) * size.width);
        let values = rows.flat_map(|row| columns.iter().map(move |x| row + x)).map(pixel).collect();
        Self { values, stride: size.width + 2 * RIM }
    }

    /// 1 in the picture, 0 in the rim.
    fn inside(size: Size) -> Self {
        let is = |padded: usize, end: usize| (RIM..RIM + end).contains(&padded);
        let row = |y| (0..size.width + 2 * RIM).map(move |x| f32::from(is(x, size.width) && is(y, size.height)));
        Self { values: (0..size.height + 2 * RIM).flat_map(row).collect(), stride: size.width + 2 * RIM }
    }

    /// So many numbers from column `x` and row `y` on, which may lie in the rim.
    #[inline(always)]
    pub fn row(&self, x: isize, y: isize, count: usize) -> &[f32] {
        let start = (y + RIM as isize) as usize * self.stride + (x + RIM as isize) as usize;
        &self.values[start..start + count]
    }
}

/// Albedo and normal, each scaled so that a squared difference of 1 sets pixels apart.
pub(super) struct Guides {
    pub size: Size,
    pub planes: [Plane; 6],
    pub inside: Plane,
}

/// Squared differences of albedo and normal that set pixels apart (measured: four times as much or as little is worse by a tenth).
const ALBEDO: f32 = 0.03;
const NORMAL: f32 = 0.1;

impl Guides {
    pub fn new(layers: &Layers) -> Self {
        let size = Size { width: layers.width, height: layers.height };
        let plane = |c: usize| {
            let (guide, far) = if c < 3 { (&layers.albedo, ALBEDO) } else { (&layers.normal, NORMAL) };
            Plane::new(size, |i| guide[i][c % 3] / far.sqrt())
        };
        Self { size, planes: [0, 1, 2, 3, 4, 5].map(plane), inside: Plane::inside(size) }
    }
}

/// The halves of a layer, by channel, and the variance of one half.
pub(super) struct Light {
    pub halves: [[Plane; 3]; 2],
    pub variance: [Plane; 3],
    /// Squared differences far below this are none.
    pub least: f32,
}

/// The same over the squared mean of the layer.
const LEAST: f64 = 2e-5;

impl Light {
    pub fn new(size: Size, layer: &Layer) -> Self {
        let [a, b] = match &layer.halves {
            Some([a, b]) => [a, b],
            None => [&layer.mean, &layer.mean],
        };
        let half = |half: &[[f32; 3]]| [0, 1, 2].map(|c| Plane::new(size, |i| half[i][c]));
        let variance = |c: usize| {
            let values: Vec<f32> = match &layer.halves {
                // Two numbers say little of their variance: nine pixels say more.
                Some(_) => around(size, 1, |i| 0.5 * (a[i][c] - b[i][c]).powi(2)),
                None => {
                    let mean = around(size, 3, |i| a[i][c]);
                    let square = around(size, 3, |i| a[i][c] * a[i][c]);
                    mean.iter().zip(square).map(|(mean, square)| (square - mean * mean).max(0.0)).collect()
                }
            };
            Plane::new(size, |i| values[i])
        };
        let own = || layer.mean.iter().flatten().map(|x| f64::from(*x)).sum::<f64>() / (3.0 * layer.mean.len() as f64);
        let mean = layer.level.map_or_else(own, |level| f64::from(level.mean));
        let least = ((LEAST * mean * mean) as f32).max(f32::MIN_POSITIVE);
        Self { halves: [half(a), half(b)], variance: [0, 1, 2].map(variance), least }
    }
}

/// Means over squares of so many pixels each way.
fn around(size: Size, reach: usize, pixel: impl Fn(usize) -> f32) -> Vec<f32> {
    let mean = |at: usize, end: usize, value: &dyn Fn(usize) -> f32| {
        let range = at.saturating_sub(reach)..(at + reach + 1).min(end);
        let count = range.len() as f32;
        range.map(value).sum::<f32>() / count
    };
    let Size { width, height } = size;
    let rows: Vec<f32> =
        (0..width * height).map(|i| mean(i % width, width, &|x| pixel(i / width * width + x))).collect();
    (0..width * height).map(|i| mean(i / width, height, &|y| rows[y * width + i % width])).collect()
}

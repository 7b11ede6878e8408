//! Filmic, Blender's view before AgX ("Filmic sRGB", look "None", which is its medium contrast), by Troy Sobotka.
//!
//! Blender's configuration reads it from two tables: linear Rec. 709 in logarithms through one that takes colour from bright
//! light (33³), then 16.5 of the 25 stops through a curve of 4096 entries. What they hold, found by looking at them:
//!
//! - bright light: with m the largest channel, every channel c becomes c + a (m − c), where
//!   a = ((m − 0.18·2⁶) / (0.18·2¹⁵ − 0.18·2⁶))^1.1 above six stops over middle grey, 0 below. Of the table's logarithms,
//!   which span 0 … 1, this meets all within 0.0022;
//! - curve: no formula is published. [`CURVE`] is a polynomial of degree 12, by least squares at the 4096 entries; the
//!   largest difference is 0.09 of an 8-bit level.
//!
//! `tests/peers/blender_views.py` measures both together against Blender.

use super::grid::{GREY, Grid, log_encoded};

/// Samples along an edge of Blender's table.
const SIZE: usize = 33;

/// Part of the cube's 25 stops, from the bottom, that the curve takes.
const LATITUDE: f32 = 0.66;

/// Coefficients of the Chebyshev polynomials of 2x − 1.
const CURVE: [f32; 13] = [
    0.435_027_2,
    0.574_115_3,
    0.095_922_7,
    -0.084_332_4,
    -0.040_408_9,
    0.010_734_9,
    0.011_744_8,
    -0.000_118_3,
    -0.002_835,
    -0.000_472,
    0.000_574_4,
    0.000_226_1,
    -0.000_155_5,
];

/// The view, ready to be read.
#[derive(Clone, Debug)]
pub(super) struct Filmic {
    grid: Grid,
}

impl Filmic {
    /// Tabulates the formula.
    pub fn new() -> Self {
        Self { grid: Grid::new(SIZE, |c| paled(c).map(|x| f64::from(log_encoded(x as f32)))) }
    }

    /// The display value, 0 … 1, of linear Rec. 709.
    pub fn display(&self, linear: [f32; 3]) -> [f32; 3] {
        self.grid.at(linear).map(|x| curve((x / LATITUDE).clamp(0.0, 1.0)))
    }
}

/// Bright light loses its colour.
fn paled(c: [f64; 3]) -> [f64; 3] {
    let stops = |n: i32| GREY * f64::from(n).exp2();
    let largest = c.into_iter().fold(0.0, f64::max);
    let share = ((largest - stops(6)).max(0.0) / (stops(15) - stops(6))).powf(1.1);
    c.map(|x| x + share * (largest - x))
}

/// Clenshaw's sum.
fn curve(x: f32) -> f32 {
    let x = 2.0 * x - 1.0;
    let (mut first, mut second) = (0.0, 0.0);
    for c in CURVE[1..].iter().rev() {
        (first, second) = (2.0 * x * first - second + c, first);
    }
    (x * first - second + CURVE[0]).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_curve_rises_from_black_to_white() {
        let values: Vec<f32> = (0..=4095).map(|i| curve(i as f32 / 4095.0)).collect();
        assert!(values.windows(2).all(|w| w[0] <= w[1]));
        assert!(values[0] < 0.2 / 255.0 && values[4095] > 1.0 - 0.2 / 255.0, "{} {}", values[0], values[4095]);
    }

    /// Middle grey lies 10 of 16.5 stops up; six stops above it colour begins to go, at fifteen none is left.
    #[test]
    fn only_bright_light_pales() {
        let dim = [0.18 * 40.0, 0.1, 2.0];
        assert_eq!(paled(dim), dim);
        let white = 0.18 * 32768.0;
        assert!(paled([white, 0.0, 1.0]).iter().all(|x| (x - white).abs() < 1e-9));
        let grey = Filmic::new().display([0.18; 3]);
        assert!((grey[0] - curve(10.0 / 16.5)).abs() < 1e-5 && grey[0] == grey[2], "{grey:?}");
    }
}

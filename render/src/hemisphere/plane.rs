//! The hemisphere as a picture on a plane above the record, as a rasteriser draws it ("Radiance Cache Splatting", 2005, §5.2).
//!
//! The plane is a square of half width 1 at height h. What it covers of the hemisphere is known in closed form, cell by cell; what it
//! does not cover, down to the horizon, is left out, made up for by its share, or seen as the cells of the border see it.

use core::f64::consts::PI;
use glam::{DVec2, DVec3, Vec3A};

/// What is done with the directions below the plane's border.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Border {
    /// They are black.
    Black,
    /// They are as bright as the mean of the plane (Larsen and Christensen 2004).
    Rescaled,
    /// They are as bright as the cells of the border at their azimuth (Gautron et al. 2005).
    Extended,
}

/// A square of n × n cells at a height over its half width.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    side: u32,
    height: f64,
    border: Border,
}

/// A measure of directions.
#[derive(Clone, Copy)]
enum Measure {
    /// ∫ cosθ dω.
    Projected,
    /// ∫ dω.
    SolidAngle,
}

impl Plane {
    /// Of at least one cell; `height` is over the half width of the square, > 0.
    pub fn new(side: u32, height: f64, border: Border) -> Self {
        Self { side: side.max(1), height: height.max(f64::MIN_POSITIVE), border }
    }

    /// Number of cells.
    pub fn len(&self) -> u32 {
        self.side * self.side
    }

    /// Never.
    pub fn is_empty(&self) -> bool {
        false
    }

    /// Cells along an edge.
    pub fn side(&self) -> u32 {
        self.side
    }

    /// Height over half the width of the square.
    pub fn height(&self) -> f64 {
        self.height
    }

    /// [`Plane::projected`] of all cells.
    pub fn weights(&self) -> Vec<f32> {
        (0..self.len()).map(|cell| self.projected(cell) as f32).collect()
    }

    /// Unit direction of the middle of a cell, counted row by row, in the local frame.
    pub fn direction(&self, cell: u32) -> Vec3A {
        let [x, y] = self.corners(cell);
        let middle = |[low, high]: [f64; 2]| 0.5 * (low + high);
        DVec3::new(middle(x), middle(y), self.height).normalize().as_vec3a()
    }

    /// ∫ cosθ dω of the directions that a cell stands for: all cells together have π unless the border is black.
    pub fn projected(&self, cell: u32) -> f64 {
        self.measured(cell, Measure::Projected, PI)
    }

    /// ∫ dω of them: 2π together unless the border is black.
    pub fn solid_angle(&self, cell: u32) -> f64 {
        self.measured(cell, Measure::SolidAngle, 2.0 * PI)
    }

    fn measured(&self, cell: u32, measure: Measure, whole: f64) -> f64 {
        let [x, y] = self.corners(cell);
        let on_plane = self.inside(x, y, measure);
        match self.border {
            Border::Black => on_plane,
            Border::Rescaled => on_plane * whole / self.inside([-1.0, 1.0], [-1.0, 1.0], measure),
            Border::Extended => {
                let last = self.side - 1;
                let [column, row] = [cell % self.side, cell / self.side];
                let sides = [(column == 0, y), (column == last, y), (row == 0, x), (row == last, x)];
                let beyond = sides.into_iter().filter(|(at_border, _)| *at_border);
                on_plane
                    + beyond.map(|(_, [from, to])| self.beyond(to, measure) - self.beyond(from, measure)).sum::<f64>()
            }
        }
    }

    /// The intervals of x and y of a cell.
    fn corners(&self, cell: u32) -> [[f64; 2]; 2] {
        let edge = |i: u32| 2.0 * f64::from(i) / f64::from(self.side) - 1.0;
        [cell % self.side, cell / self.side].map(|i| [edge(i), edge(i + 1)])
    }

    /// Directions through a rectangle of the plane, from those through rectangles about the middle.
    fn inside(&self, [x0, x1]: [f64; 2], [y0, y1]: [f64; 2], measure: Measure) -> f64 {
        let about = |x: f64, y: f64| self.quarter(DVec2::new(x, y), measure);
        about(x1, y1) - about(x0, y1) - about(x1, y0) + about(x0, y0)
    }

    /// Directions through the rectangle with corners at the middle and at `p`, signed.
    fn quarter(&self, p: DVec2, measure: Measure) -> f64 {
        let DVec2 { x, y } = p / self.height;
        match measure {
            Measure::Projected => {
                let part = |x: f64, y: f64| {
                    let root = (1.0 + x * x).sqrt();
                    x / root * (y / root).atan()
                };
                0.5 * (part(x, y) + part(y, x))
            }
            Measure::SolidAngle => (x * y / (1.0 + x * x + y * y).sqrt()).atan(),
        }
    }

    /// Directions between the border and the horizon, from the middle of a side to a place on it, signed: those of the wedge of
    /// azimuth φ, tan φ = `place`, less those through the triangle below it.
    fn beyond(&self, place: f64, measure: Measure) -> f64 {
        let phi = place.atan();
        let slope = (1.0 + self.height * self.height).sqrt().recip();
        match measure {
            Measure::Projected => 0.5 * (phi - slope * (slope * place).atan()),
            Measure::SolidAngle => (self.height * slope * phi.sin()).asin(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whatever the height and the number of cells, the weights add up to the whole hemisphere.
    #[test]
    fn weights_add_up_to_the_hemisphere() {
        for height in [0.05, 0.2, 1.0, 3.0] {
            for side in [1, 2, 7, 64] {
                for border in [Border::Rescaled, Border::Extended] {
                    let plane = Plane::new(side, height, border);
                    let sum = |of: fn(&Plane, u32) -> f64| (0..plane.len()).map(|cell| of(&plane, cell)).sum::<f64>();
                    let (projected, solid) = (sum(Plane::projected), sum(Plane::solid_angle));
                    assert!(
                        (projected - PI).abs() < 1e-9 && (solid - 2.0 * PI).abs() < 1e-9,
                        "{height} {side} {border:?}"
                    );
                }
                let black = Plane::new(side, height, Border::Black);
                let covered: f64 = (0..black.len()).map(|cell| black.projected(cell)).sum();
                assert!(covered < PI, "{height} {side}: {covered}");
            }
        }
    }

    /// Each weight against the directions that fall on its cell, or below its part of the border, counted.
    #[test]
    fn weights_are_those_of_counted_directions() {
        let (side, height) = (5, 0.4);
        let [black, extended] = [Border::Black, Border::Extended].map(|border| Plane::new(side, height, border));
        let mut counts = vec![[0.0; 4]; 25];
        let n = 2_000_000;
        for i in 0..n {
            let z = (f64::from(i) + 0.5) / f64::from(n);
            let phi = 2.0 * PI * (f64::from(i) * 0.618_033_988_749_895).fract();
            let radius = (1.0 - z * z).sqrt() / z * height;
            let p = radius * DVec2::new(phi.cos(), phi.sin());
            let outside = p.abs().max_element() > 1.0;
            let on = if outside { p / p.abs().max_element() } else { p };
            let index = |x: f64| (((x + 1.0) / 2.0 * f64::from(side)) as usize).min(side as usize - 1);
            let count = &mut counts[index(on.y) * side as usize + index(on.x)];
            let share = 2.0 * PI / f64::from(n);
            count[0] += z * share;
            count[1] += share;
            if !outside {
                count[2] += z * share;
                count[3] += share;
            }
        }
        for (cell, count) in (0..).zip(counts) {
            let found =
                [extended.projected(cell), extended.solid_angle(cell), black.projected(cell), black.solid_angle(cell)];
            for (a, b) in found.into_iter().zip(count) {
                assert!((a - b).abs() < 2e-4 + 1e-3 * b, "{cell}: {found:?} {count:?}");
            }
            assert!((extended.direction(cell).length() - 1.0).abs() < 1e-6 && extended.direction(cell).z > 0.0);
        }
    }
}

//! Functions over the unit square that depend on further parameters: values, and warps between the uniform density and theirs.
//!
//! A function is bilinear between the nodes of a grid and linear between the values of its parameters. Its marginal density over
//! y and the conditional ones over x are integrated exactly (trapezoids), and inverted by a search and a quadratic equation
//! (Dupuy and Jakob 2018, supplement). What is linear in the values is interpolated between parameters: so is every integral.

/// A grid of `size` = [columns, rows] nodes for every combination of parameters.
pub struct Warp {
    size: [usize; 2],
    /// Values of each parameter, the first the slowest.
    parameters: Vec<Vec<f32>>,
    values: Vec<f32>,
    /// Integrals along x up to each node, in cells of the grid, where it warps.
    conditional: Vec<f32>,
    /// Integrals over y up to each row.
    marginal: Vec<f32>,
}

/// Most slices that are blended: two of each parameter.
const MOST: usize = 8;

/// Slices of the parameters' combinations and their weights.
#[derive(Clone, Copy)]
struct Blend {
    slices: [(usize, f32); MOST],
    count: usize,
}

impl Blend {
    fn of(&self, values: &[f32], slice: usize, at: usize) -> f32 {
        self.slices[..self.count].iter().map(|(k, weight)| weight * values[k * slice + at]).sum()
    }
}

impl Warp {
    /// A function that is looked up only.
    pub fn values(size: [usize; 2], parameters: Vec<Vec<f32>>, values: Vec<f32>) -> Self {
        Self { size, parameters, values, conditional: Vec::new(), marginal: Vec::new() }
    }

    /// A density: every slice is scaled to the integral 1. `None` where one has no positive integral.
    pub fn density(size: [usize; 2], parameters: Vec<Vec<f32>>, mut values: Vec<f32>) -> Option<Self> {
        let [columns, rows] = size;
        let (mut conditional, mut marginal) = (vec![0.0; values.len()], Vec::new());
        let mut kept = Vec::new();
        for (slice, along) in values.chunks_exact_mut(columns * rows).zip(conditional.chunks_exact_mut(columns * rows))
        {
            for (row, along) in slice.chunks_exact(columns).zip(along.chunks_exact_mut(columns)) {
                let mut sum = 0.0f64;
                for x in 1..columns {
                    sum += 0.5 * (f64::from(row[x - 1]) + f64::from(row[x]));
                    along[x] = sum as f32;
                }
            }
            let total = |row: usize| f64::from(along[row * columns + columns - 1]);
            let mut sums = vec![0.0f64];
            for y in 1..rows {
                sums.push(sums[y - 1] + 0.5 * (total(y - 1) + total(y)));
            }
            let all = *sums.last()?;
            if !(all > 0.0 && all.is_finite()) {
                return None;
            }
            let scale = (1.0 / all) as f32;
            slice.iter_mut().for_each(|x| *x *= scale);
            along.iter_mut().for_each(|x| *x *= scale);
            kept.extend(sums.iter().map(|x| (x / all) as f32));
        }
        marginal.extend(kept);
        Some(Self { size, parameters, values, conditional, marginal })
    }

    fn blend(&self, parameters: &[f32]) -> Blend {
        let mut blend = Blend { slices: [(0, 0.0); MOST], count: 1 };
        blend.slices[0] = (0, 1.0);
        for (known, &x) in self.parameters.iter().zip(parameters) {
            let low = known.partition_point(|p| *p <= x).saturating_sub(1).min(known.len().saturating_sub(2));
            let way = match known.get(low + 1) {
                Some(next) => ((x - known[low]) / (next - known[low])).clamp(0.0, 1.0),
                None => 0.0,
            };
            let count = blend.count;
            for i in 0..count {
                let (slice, weight) = blend.slices[i];
                blend.slices[i] = (slice * known.len() + low, weight * (1.0 - way));
                if way > 0.0 && 2 * count <= MOST {
                    blend.slices[blend.count] = (slice * known.len() + low + 1, weight * way);
                    blend.count += 1;
                }
            }
        }
        blend
    }

    /// Cell and place in it of a point of the unit square.
    fn cell(&self, x: [f32; 2]) -> ([usize; 2], [f32; 2]) {
        let mut cell = [0; 2];
        let mut way = [0.0; 2];
        for k in 0..2 {
            let at = x[k].clamp(0.0, 1.0) * (self.size[k] - 1) as f32;
            cell[k] = (at as usize).min(self.size[k] - 2);
            way[k] = at - cell[k] as f32;
        }
        (cell, way)
    }

    /// Values at the left and at the right side of a cell at the height `y` in it.
    fn sides(&self, blend: &Blend, cell: [usize; 2], y: f32) -> (f32, f32) {
        let [columns, rows] = self.size;
        let at = cell[1] * columns + cell[0];
        let value = |offset: usize| blend.of(&self.values, columns * rows, at + offset);
        let side = |offset: usize| (1.0 - y) * value(offset) + y * value(offset + columns);
        (side(0), side(1))
    }

    /// Integral along x up to a column, and over the whole row, at the height `y` in a row of cells.
    fn row(&self, blend: &Blend, row: usize, column: usize, y: f32) -> f32 {
        let [columns, rows] = self.size;
        let at = row * columns + column;
        let value = |offset: usize| blend.of(&self.conditional, columns * rows, at + offset);
        (1.0 - y) * value(0) + y * value(columns)
    }

    /// Cells per unit square: a density over cells times this is one over the square.
    fn cells(&self) -> f32 {
        ((self.size[0] - 1) * (self.size[1] - 1)) as f32
    }

    /// The value at a point; of a density, over the unit square.
    pub fn eval(&self, x: [f32; 2], parameters: &[f32]) -> f32 {
        let blend = self.blend(parameters);
        let (cell, way) = self.cell(x);
        let (left, right) = self.sides(&blend, cell, way[1]);
        let value = (1.0 - way[0]) * left + way[0] * right;
        if self.conditional.is_empty() { value } else { value * self.cells() }
    }

    /// From the uniform density to this one: a point, and its density.
    pub fn sample(&self, u: [f32; 2], parameters: &[f32]) -> ([f32; 2], f32) {
        let blend = self.blend(parameters);
        let [columns, rows] = self.size;
        let u = u.map(|u| u.clamp(1e-7, 1.0 - 1e-7));
        // The row of cells, then the height in it: its density is linear between those of the two rows.
        let below = |row: usize| blend.of(&self.marginal, rows, row);
        let row = last(rows - 1, |row| below(row) <= u[1]);
        let (low, high) = (self.row(&blend, row, columns - 1, 0.0), self.row(&blend, row, columns - 1, 1.0));
        let y = invert(u[1] - below(row), low, high);
        // The same along x.
        let target = u[0] * self.row(&blend, row, columns - 1, y);
        let column = last(columns - 1, |column| self.row(&blend, row, column, y) <= target);
        let (left, right) = self.sides(&blend, [column, row], y);
        let x = invert(target - self.row(&blend, row, column, y), left, right);
        let density = ((1.0 - x) * left + x * right) * self.cells();
        ([(column as f32 + x) / (columns - 1) as f32, (row as f32 + y) / (rows - 1) as f32], density)
    }

    /// The way back: the point of the uniform density that [`Warp::sample`] takes to `x`, and the density there.
    pub fn invert(&self, x: [f32; 2], parameters: &[f32]) -> ([f32; 2], f32) {
        let blend = self.blend(parameters);
        let [columns, rows] = self.size;
        let (cell, way) = self.cell(x);
        let (left, right) = self.sides(&blend, cell, way[1]);
        let density = ((1.0 - way[0]) * left + way[0] * right) * self.cells();
        let within = way[0] * (left + 0.5 * way[0] * (right - left));
        let all = self.row(&blend, cell[1], columns - 1, way[1]);
        let along = if all > 0.0 { (self.row(&blend, cell[1], cell[0], way[1]) + within) / all } else { 0.0 };
        let (low, high) = (self.row(&blend, cell[1], columns - 1, 0.0), self.row(&blend, cell[1], columns - 1, 1.0));
        let up = blend.of(&self.marginal, rows, cell[1]) + way[1] * (low + 0.5 * way[1] * (high - low));
        ([along, up], density)
    }
}

/// The last of `0..count` that holds, where the first do and the others do not; 0 if none does.
fn last(count: usize, holds: impl Fn(usize) -> bool) -> usize {
    let (mut low, mut high) = (0, count);
    while high - low > 1 {
        let middle = low + (high - low) / 2;
        if holds(middle) { low = middle } else { high = middle }
    }
    low
}

/// t ∈ [0, 1] where ∫₀ᵗ of the line from `a` to `b` is `area`.
fn invert(area: f32, a: f32, b: f32) -> f32 {
    let t = if (a - b).abs() <= 1e-4 * (a + b) {
        2.0 * area / (a + b).max(f32::MIN_POSITIVE)
    } else {
        // The root of b − a, written without cancellation.
        2.0 * area / (a + (a * a + 2.0 * area * (b - a)).max(0.0).sqrt()).max(f32::MIN_POSITIVE)
    };
    t.clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sampling and inversion are inverse, the density is that of the points and integrates to 1.
    #[test]
    fn warps_are_inverse() {
        let size = [7, 5];
        let values: Vec<f32> = (0..4 * 35).map(|i| 0.1 + ((i * 37 % 23) as f32).powi(2)).collect();
        let warp = Warp::density(size, vec![vec![0.0, 1.0], vec![-1.0, 3.0]], values).unwrap();
        for parameters in [[0.0, 0.0], [0.3, 2.0], [1.0, 3.0], [5.0, -9.0]] {
            let (n, mut sum) = (120, 0.0);
            for i in 0..n * n {
                let u = [((i % n) as f32 + 0.5) / n as f32, ((i / n) as f32 + 0.5) / n as f32];
                sum += warp.eval(u, &parameters);
                let (x, density) = warp.sample(u, &parameters);
                assert!((density / warp.eval(x, &parameters) - 1.0).abs() < 1e-3);
                let (back, again) = warp.invert(x, &parameters);
                assert!((back[0] - u[0]).abs() < 1e-3 && (back[1] - u[1]).abs() < 1e-3, "{u:?} {back:?}");
                assert!((density / again - 1.0).abs() < 1e-3);
            }
            assert!((sum / (n * n) as f32 - 1.0).abs() < 0.01, "{sum}");
        }
        assert!(Warp::density([2, 2], vec![], vec![0.0; 4]).is_none());
    }
}

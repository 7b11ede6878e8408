//! What records reflect, read at few pixels and interpolated between them where it is smooth.
//!
//! What a record reflects changes with the position and the view, slowly beside a pixel; to read it costs more than to look at the
//! neighbours. So the corners of square cells of pixels are read. Where all pixels of a cell show the surface that its corners
//! show, and what the corners reflect differs little, the cell is filled by bilinear interpolation, else it is divided. What no
//! cell fills is read pixel by pixel. Textures are not interpolated: of the diffuse part the irradiance is.

use super::kinds::Scratches;
use super::reading::Reading;
use super::shade::Shader;
use super::surface::Surface;
use crate::bsdf::Split;
use crate::scene::Rgb;
use crate::simd::widest;
use fearless_simd::Level;
use rayon::prelude::*;

/// Sides of cells, pixels, and the largest difference between the corners of one that is filled, over their mean: bilinear
/// interpolation errs by a small part of that. Measured: `doc/measurements.md`, what is denoised.
const CELLS: [(usize, f32); 2] = [(4, 0.08), (2, 0.16)];
/// The same for pictures that are shown for a moment.
const ROUGH_CELLS: [(usize, f32); 3] = [(8, 0.25), (4, 0.35), (2, 0.5)];

/// Distance between pixels of a cell, in widths of a pixel for each pixel between them: seen at a grazing angle, they are long.
const REACH: f32 = 6.0;
/// Distance of a pixel from the plane of a corner, in widths of a pixel.
const OFF_PLANE: f32 = 0.5;
/// How much nearer things may be at a pixel than at a corner: where it is more, a dark gap may lie between corners that do not know it.
const NEARER: f32 = 4.0;
/// Cosine between normals, and between views, within a cell.
const SAME_NORMAL: f32 = 0.999;
const SAME_VIEW: f32 = 0.99;
/// Difference between specular colours within a cell, over the colour.
const SAME_COLOR: f32 = 0.01;

/// What records say of the only surface of a pixel.
#[derive(Clone, Copy, Debug)]
struct Node {
    /// Radiance reflected by a white Lambertian surface.
    mean: Rgb,
    /// Radiance reflected by the specular part.
    glossy: Rgb,
}

/// Light of records for all samples of each pixel, row by row; `None` where it is to be read there.
pub(super) fn between(shader: &Shader, surfaces: &[Vec<Surface>], width: usize) -> Vec<Option<Split>> {
    let cells: &[(usize, f32)] = if shader.reading == Reading::Rough { &ROUGH_CELLS } else { &CELLS };
    let grid = Grid { shader, surfaces, width, height: surfaces.len() / width.max(1) };
    let mut nodes: Vec<Option<Node>> = vec![None; surfaces.len()];
    let mut was_read = vec![false; surfaces.len()];
    let mut light: Vec<Option<Split>> = vec![None; surfaces.len()];
    let mut open = grid.cells(cells[0].0);
    for (level, &(side, tolerance)) in cells.iter().enumerate() {
        let mut wanted: Vec<usize> = open.iter().flat_map(|cell| grid.corners(*cell, side)).collect();
        wanted.sort_unstable();
        wanted.dedup();
        wanted.retain(|&i| !was_read[i]);
        let read = |scratch: &mut Scratches, &i: &usize| grid.read(i, scratch);
        let found: Vec<Option<Node>> = wanted.par_iter().map_init(Scratches::default, read).collect();
        for (i, node) in wanted.into_iter().zip(found) {
            (was_read[i], nodes[i]) = (true, node);
        }
        let filled: Vec<_> = open.par_iter().map(|cell| grid.fill(*cell, side, tolerance, &nodes)).collect();
        let mut left = Vec::new();
        for (cell, filled) in open.iter().zip(filled) {
            match (filled, cells.get(level + 1)) {
                (Some(filled), _) => filled.into_iter().for_each(|(i, found)| light[i] = Some(found)),
                (None, Some(&(finer, _))) => left.extend(grid.divided(*cell, side, finer)),
                (None, None) => (),
            }
        }
        open = left;
    }
    for ((light, node), surfaces) in light.iter_mut().zip(nodes).zip(surfaces) {
        if let (None, Some(node), [surface]) = (&light, node, &surfaces[..]) {
            *light = Some(node.at(surface));
        }
    }
    light
}

impl Node {
    /// The light for all samples of a surface.
    fn at(&self, surface: &Surface) -> Split {
        Split { diffuse: surface.parts.diffuse * self.mean, glossy: self.glossy * surface.samples }
    }
}

/// Pixels and what they show.
struct Grid<'a> {
    shader: &'a Shader<'a>,
    surfaces: &'a [Vec<Surface>],
    width: usize,
    height: usize,
}

impl Grid<'_> {
    /// Column and row of the first pixel of every cell.
    fn cells(&self, side: usize) -> Vec<[usize; 2]> {
        let rows = (0..self.height.saturating_sub(1)).step_by(side);
        rows.flat_map(|y| (0..self.width.saturating_sub(1)).step_by(side).map(move |x| [x, y])).collect()
    }

    /// The cells of a finer side in a cell.
    fn divided(&self, [x, y]: [usize; 2], side: usize, finer: usize) -> impl Iterator<Item = [usize; 2]> {
        let columns = move |y: usize| (x..x + side).step_by(finer).map(move |x| [x, y]);
        let (right, bottom) = (self.width - 1, self.height - 1);
        (y..y + side).step_by(finer).flat_map(columns).filter(move |[x, y]| *x < right && *y < bottom)
    }

    /// Last column and row of a cell: the first of the next one, or the last of the picture.
    fn end(&self, [x, y]: [usize; 2], side: usize) -> [usize; 2] {
        [(x + side).min(self.width - 1), (y + side).min(self.height - 1)]
    }

    /// The pixels at the corners of a cell.
    fn corners(&self, [x, y]: [usize; 2], side: usize) -> [usize; 4] {
        let [right, bottom] = self.end([x, y], side);
        [(x, y), (right, y), (x, bottom), (right, bottom)].map(|(x, y)| y * self.width + x)
    }

    /// The only surface of a pixel.
    fn surface(&self, i: usize) -> Option<&Surface> {
        match &self.surfaces[i][..] {
            [surface] => Some(surface),
            _ => None,
        }
    }

    /// What records say of a pixel; `None` where they do not say all.
    fn read(&self, i: usize, scratch: &mut Scratches) -> Option<Node> {
        let surface = self.surface(i)?;
        let white = widest(
            Level::new(),
            #[inline(always)]
            || self.shader.held_on_white(surface, scratch),
        )?;
        let node = Node { mean: white.diffuse, glossy: white.glossy / surface.samples };
        // Where records ring below zero the pixel is told so.
        (node.mean.is_finite() && node.glossy.is_finite() && node.mean.min(node.glossy).min_element() >= 0.0)
            .then_some(node)
    }

    /// The pixels of a cell that are like its corners, and their light; `None` where the corners differ.
    fn fill(
        &self,
        cell: [usize; 2],
        side: usize,
        tolerance: f32,
        nodes: &[Option<Node>],
    ) -> Option<Vec<(usize, Split)>> {
        let corners = self.corners(cell, side);
        let [a, b, c, d] = corners.map(|i| nodes[i]);
        let nodes = [a?, b?, c?, d?];
        let [first, others @ ..] = corners.map(|i| self.surface(i));
        let first = first?;
        let alike = |other: &Surface| is_like(other, first, side as f32);
        if !others.iter().all(|other| other.is_some_and(alike)) {
            return None;
        }
        let albedo = first.parts.diffuse / first.samples;
        let mean = nodes.iter().map(|n| n.mean).sum::<Rgb>() * 0.25;
        let glossy = nodes.iter().map(|n| n.glossy).sum::<Rgb>() * 0.25;
        let all = (mean * albedo + glossy).max_element();
        let range = |of: fn(&Node) -> Rgb| {
            let (low, high) =
                nodes.iter().map(of).fold((Rgb::INFINITY, Rgb::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
            (high - low).max_element()
        };
        if range(|n| n.mean) > tolerance * mean.max_element() || range(|n| n.glossy) > tolerance * all {
            return None;
        }
        let [x0, y0] = cell;
        let [right, bottom] = self.end(cell, side);
        // The last column and row of the picture belong to the cells beside them.
        let (x_end, y_end) = (
            if right + 1 == self.width { self.width } else { right },
            if bottom + 1 == self.height { self.height } else { bottom },
        );
        let mut filled = Vec::with_capacity((x_end - x0) * (y_end - y0));
        for y in y0..y_end {
            for x in x0..x_end {
                let i = y * self.width + x;
                let Some(surface) = self.surface(i).filter(|surface| alike(surface)) else { continue };
                let (u, v) = ((x - x0) as f32 / (right - x0) as f32, (y - y0) as f32 / (bottom - y0) as f32);
                let weights = [(1.0 - u) * (1.0 - v), u * (1.0 - v), (1.0 - u) * v, u * v];
                let sum = |of: fn(&Node) -> Rgb| nodes.iter().zip(weights).map(|(n, w)| of(n) * w).sum::<Rgb>();
                filled.push((i, Node { mean: sum(|n| n.mean), glossy: sum(|n| n.glossy) }.at(surface)));
            }
        }
        Some(filled)
    }
}

/// Whether a pixel shows what another one does, so many pixels away.
fn is_like(a: &Surface, b: &Surface, pixels: f32) -> bool {
    let offset = a.point.at.p - b.point.at.p;
    let normal = b.point.frame.normal();
    let same_color = |of: fn(&Surface) -> Rgb| {
        let (a, b) = (of(a) / a.samples, of(b) / b.samples);
        (a - b).abs().max_element() <= SAME_COLOR * b.max_element()
    };
    a.point.material == b.point.material
        && (a.point.component, a.finish()) == (b.point.component, b.finish())
        && a.closeness * b.samples <= NEARER * b.closeness * a.samples
        && a.point.segments == b.point.segments
        && a.point.frame.normal().dot(normal) > SAME_NORMAL
        && a.point.at.wo.dot(b.point.at.wo) > SAME_VIEW
        && offset.dot(normal).abs() < OFF_PLANE * b.point.footprint
        && offset.length_squared() < (REACH * pixels * b.point.footprint).powi(2)
        && same_color(|s| s.parts.specular)
        && same_color(|s| s.parts.grazing)
}

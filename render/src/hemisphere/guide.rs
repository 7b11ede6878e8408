//! Where a record looks closely: at what the views that will read it reflect.

use super::cell::Cell;
use crate::frame::Frame;
use core::f32::consts::TAU;
use glam::Vec3A;

/// A view of the surface near a record, world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Unit shading normal, on the side of the eye.
    pub normal: Vec3A,
    /// Unit direction to the eye.
    pub wo: Vec3A,
}

impl View {
    /// The direction that a mirror would show it.
    pub fn mirror(&self) -> Vec3A {
        2.0 * self.normal.dot(self.wo) * self.normal - self.wo
    }
}

/// Sizes of the cells of a record: fine, at a set ratio to the lobe's width, about the mirror directions of the views, and
/// coarser with the distance from them. Without views, fine everywhere.
#[derive(Clone, Debug)]
pub struct Guide {
    /// Mirror directions of the views, local frame.
    mirrors: Vec<Vec3A>,
    /// Width of the lobe, radian.
    lobe_width: f32,
    /// y: half angle of a cell over the lobe's width where it matters. Caps in place of cells err by 0.05 to 0.5 % at 0.6,
    /// by 5 % at 1.3 (design measurements of the furnace ripple).
    fineness: f32,
}

/// Cells of the farthest parts, radian: about a dozen hold the hemisphere's irradiance.
const COARSEST: f32 = 0.4;

/// Distance from the mirror direction, in lobe widths, within which the lobe is bright: e^(−½ 2²) of its peak.
const BRIGHT: f32 = 2.0;

/// Growth of the cells with the distance beyond.
const GROWTH: f32 = 0.5;

impl Guide {
    /// Looks at what `views` reflect.
    pub fn new(frame: &Frame, views: &[View], lobe_width: f32, fineness: f32) -> Self {
        let mirror = |v: &View| frame.to_local(v.mirror());
        Self { mirrors: views.iter().map(mirror).collect(), lobe_width, fineness }
    }

    /// The partition of the hemisphere with at most `max_cells` cells: coarser than asked for where that does not fit.
    pub fn cells(&self, max_cells: usize) -> Vec<Cell> {
        let mut fineness = self.fineness;
        loop {
            let mut cells = Vec::with_capacity(256);
            self.divide(&Cell::HEMISPHERE, fineness, &mut cells, max_cells);
            if cells.len() <= max_cells.max(7) {
                return cells;
            }
            fineness *= 1.15;
        }
    }

    /// The same with the rays of each cell: so many in the smallest, up to four times as many in larger ones.
    pub fn cells_with_rays(&self, max_cells: usize, rays: u32) -> Vec<(Cell, u32)> {
        let cells = self.cells(max_cells);
        let smallest = cells.iter().map(Cell::solid_angle).fold(f32::INFINITY, f32::min);
        let per_cell = |c: &Cell| {
            let larger = (c.solid_angle() / smallest).sqrt().clamp(1.0, 4.0);
            (rays as f32 * larger).round() as u32
        };
        cells.into_iter().map(|c| (c, per_cell(&c))).collect()
    }

    fn divide(&self, cell: &Cell, fineness: f32, cells: &mut Vec<Cell>, max_cells: usize) {
        for child in cell.children() {
            if cells.len() > max_cells.max(7) {
                return;
            }
            if child.half_angle() > self.wanted(&child, fineness) {
                self.divide(&child, fineness, cells, max_cells);
            } else {
                cells.push(child);
            }
        }
    }

    /// Largest half angle that a cell may have, radian.
    fn wanted(&self, cell: &Cell, fineness: f32) -> f32 {
        let fine = fineness * self.lobe_width;
        if self.mirrors.is_empty() {
            return fine.min(COARSEST);
        }
        let center = cell.center();
        let nearest = self.mirrors.iter().map(|m| m.dot(center)).fold(-1.0, f32::max).clamp(-1.0, 1.0);
        let beyond = (nearest.acos() - cell.half_angle()) / self.lobe_width - BRIGHT;
        (fine * (1.0 + GROWTH * beyond.max(0.0))).min(COARSEST)
    }
}

/// Views lower than this (cosine) see too little of a record to be asked.
const LOWEST_VIEW: f32 = 0.02;

/// Directions to the eye of the views that a record is cut for, local frame.
pub fn view_directions(frame: &Frame, views: &[View]) -> Vec<Vec3A> {
    views.iter().map(|v| frame.to_local(v.wo)).filter(|d| d.z > LOWEST_VIEW).collect()
}

/// `count` directions over the hemisphere, uniform in solid angle, off the horizon: views for a record that any may read.
pub fn hemisphere_directions(count: usize) -> Vec<Vec3A> {
    // A golden-angle spiral.
    let golden = TAU * 0.381_966;
    (0..count)
        .map(|i| {
            let z = (i as f32 + 0.5) / count as f32;
            let (s, c) = (golden * i as f32).sin_cos();
            let r = (1.0 - z * z).sqrt();
            Vec3A::new(r * c, r * s, z)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_tile_and_are_fine_where_the_views_look() {
        let frame = Frame::from_normal(Vec3A::Z);
        let wo = Vec3A::new(0.6, 0.0, 0.8);
        let guide = Guide::new(&frame, &[View { normal: Vec3A::Z, wo }], 0.1, 0.6);
        let cells = guide.cells(1000);
        let sum: f32 = cells.iter().map(Cell::solid_angle).sum();
        assert!((sum / TAU - 1.0).abs() < 1e-5);
        let mirror = Vec3A::new(-0.6, 0.0, 0.8);
        for cell in &cells {
            if cell.center().dot(mirror) > 0.1f32.cos() {
                assert!(cell.half_angle() <= 0.06, "{cell:?}");
            }
        }
        assert!(cells.len() < 300, "{}", cells.len());
        let everywhere = Guide::new(&frame, &[], 0.1, 0.6).cells(10_000);
        assert!(everywhere.iter().all(|c| c.half_angle() <= 0.06));
        // A bound on the number is kept, whatever was asked for.
        assert!(Guide::new(&frame, &[], 0.01, 0.6).cells(500).len() <= 500);
    }
}

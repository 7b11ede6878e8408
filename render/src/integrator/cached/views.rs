//! The views that will read a record: those of pixels about it, and through all of a lens.

use super::points::{Point, Sight};
use crate::cache::{Grid, RadiusPolicy};
use crate::hemisphere::View;
use glam::Vec3A;

/// Where the views of a record are taken, in quarters of its reach.
const VIEWS: [(i32, i32); 16] = [
    (-4, 0),
    (4, 0),
    (0, -4),
    (0, 4),
    (-3, -3),
    (3, -3),
    (-3, 3),
    (3, 3),
    (-2, 0),
    (2, 0),
    (0, -2),
    (0, 2),
    (-1, -2),
    (2, -1),
    (-2, 1),
    (1, 2),
];

/// Points of the rim of a lens from which a record is looked at too.
pub(super) const RIM_VIEWS: usize = 8;

/// Largest angle between the mirror directions of a record's views, in lobe widths.
const MAX_SPREAD: f32 = 5.0;

/// What the pixels of a picture show, and through what lens.
#[derive(Clone, Copy)]
pub(super) struct Pixels<'a> {
    /// What the middle of every pixel shows.
    pub sight: &'a Sight<'a>,
    /// Their rows and columns.
    pub grid: Grid,
    /// Points of the rim of the lens.
    pub rim: &'a [Vec3A],
}

impl Pixels<'_> {
    /// Views of the same surface that will read the record of pixel `i`, and how far they reach in pixels: less where the
    /// surface is so curved that its mirror directions leave the region that a record can hold finely.
    pub fn views(&self, point: &Point, i: usize, reach: RadiusPolicy, lobe_width: f32) -> (Vec<View>, f32) {
        let RadiusPolicy { min_pixels, max_pixels, .. } = reach;
        let mut reach = max_pixels;
        loop {
            let views = self.views_within(point, i, reach);
            let center = views[0].mirror();
            let spread = views.iter().map(|v| v.mirror().dot(center)).fold(1.0, f32::min).clamp(-1.0, 1.0).acos();
            if reach <= min_pixels || spread <= MAX_SPREAD * lobe_width {
                // What is seen in mirrors is seen by another lens than this.
                let direct = self.rim.iter().filter(|_| point.segments == 1);
                let view = |eye: &Vec3A| View { wo: (*eye - point.at.p).normalize_or(point.at.wo), ..point.view() };
                let views = views.into_iter().chain(direct.map(view)).collect();
                return (views, reach);
            }
            reach = (0.7 * reach).max(min_pixels);
        }
    }

    fn views_within(&self, point: &Point, i: usize, reach: f32) -> Vec<View> {
        let pixels = reach.ceil() as i32;
        let (x, y) = ((i as u32 % self.grid.width) as i32, (i as u32 / self.grid.width) as i32);
        let mut views = vec![point.view()];
        for (dx, dy) in VIEWS {
            let (px, py) = (x + dx * pixels / 4, y + dy * pixels / 4);
            let inside = px >= 0 && py >= 0 && px < self.grid.width as i32 && py < self.grid.height as i32;
            if !inside || (px, py) == (x, y) {
                continue;
            }
            let Some(other) = self.sight.at(py as usize * self.grid.width as usize + px as usize) else { continue };
            let near = other.at.p.distance(point.at.p) <= 1.5 * reach * point.footprint;
            if near && other.material == point.material {
                views.push(other.view());
            }
        }
        views
    }
}

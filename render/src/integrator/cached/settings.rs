//! One knob for the quality of a cached rendering.

use crate::cache::{RadiusPolicy, Spacing, Weight};
use crate::record::CutSettings;
use crate::record::eas::Estimator;

/// τ of the images of the 2015 paper.
pub const TOLERANCE: f32 = 0.02;

/// Everything that follows from τ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quality {
    /// Whether records and sums are those of the 2015 paper.
    pub estimator: Estimator,
    /// Rays of an irradiance record.
    pub irradiance_rays: u32,
    /// Spacing of irradiance records.
    pub irradiance: RadiusPolicy,
    /// Rays of the coarse irradiance records that end paths.
    pub coarse_rays: u32,
    /// Spacing of those.
    pub coarse: RadiusPolicy,
    /// Rays in the smallest cell of an EAS record; larger cells have up to four times as many.
    pub rays_per_cell: u32,
    /// Rays of an EAS record of the paper.
    pub paper_rays: u32,
    /// Largest half angle of a cell over the width of the lobe, where the lobe is bright.
    pub fineness: f32,
    /// Most cells of the hemisphere.
    pub max_cells: usize,
    /// Spacing of EAS records.
    pub eas: RadiusPolicy,
    /// Cut through the tree.
    pub cut: CutSettings,
    /// Reflected directions #D of the cut, where no views are known.
    pub directions: usize,
    /// Weights of the records.
    pub weight: Weight,
    /// What else decides how far they reach.
    pub spacing: Spacing,
    /// Mean error, over the light, that the second-order term may have within a radius that follows the Hessian.
    pub curvature: f32,
}

impl Quality {
    /// Rays, spacing and number of sources for the tolerance τ: the error of independent records falls with the root of the
    /// rays, so half the tolerance takes four times as many, spread over records that are closer and rays of each.
    pub fn new(tolerance: f32, estimator: Estimator, spacing: Spacing) -> Self {
        let finer = TOLERANCE / tolerance;
        let rays = |n: f32| (n * finer).round().clamp(1.0, 65_536.0) as u32;
        // Areas, not radii, are inverse to the number of records.
        let closer = finer.sqrt().sqrt();
        let radius = |scale: f32, min: f32, max: f32| RadiusPolicy {
            scale: scale / closer,
            min_pixels: (min / closer).max(0.75),
            max_pixels: (max / closer).max(2.0),
        };
        Self {
            estimator,
            irradiance_rays: rays(1600.0).max(64),
            irradiance: radius(0.5, 3.0, 24.0),
            coarse_rays: rays(160.0).max(64),
            coarse: radius(0.7, 8.0, 40.0),
            rays_per_cell: rays(4.0),
            paper_rays: 4096,
            fineness: 0.7 / closer.clamp(0.7, 1.4),
            max_cells: 1024,
            eas: match estimator {
                Estimator::Improved => radius(0.6, 2.5, 14.0),
                Estimator::Paper => radius(0.6, 2.5, 20.0),
            },
            cut: CutSettings {
                // A record is read by other points than it was made for: the improved cut leaves room for them.
                tolerance: if estimator == Estimator::Paper { tolerance } else { 0.1 * tolerance },
                max_eas: 1024,
            },
            directions: 64,
            weight: match estimator {
                Estimator::Improved => Weight::Smooth,
                Estimator::Paper => Weight::Ward,
            },
            spacing,
            curvature: 2.0 * tolerance,
        }
    }
}

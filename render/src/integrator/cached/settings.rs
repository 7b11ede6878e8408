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
    /// Spacing of glossy records.
    pub glossy: RadiusPolicy,
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

/// The numbers that the quality of a picture hangs on, as they are at τ = [`TOLERANCE`]. All cost time to fill; what they buy
/// is said with each. `cargo run --release -p burnish-render --example knobs` prints the curve of each: rays, records, memory and error
/// where it is made smaller and larger; `doc/measurements.md` has those of the glossy Cornell box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Knobs {
    /// Rays of an irradiance record. Half of the rays of a picture; noise of the records of diffuse surfaces falls with the root
    /// until other errors are left: twice as many take a tenth off the error, four times hardly more.
    pub irradiance_rays: f32,
    /// Spacing of irradiance records. Closer ones follow contact shadows. Where light bends, `curvature` bounds the radius first:
    /// the scale and the largest radius count on what is smooth and far from all else.
    pub irradiance: RadiusPolicy,
    /// Rays of a coarse irradiance record. Every gather averages over many, but all average over the same: what is left is a bias
    /// of the whole picture, one to three percent at a tenth of the rays of the others, none in the box at a fifth.
    pub coarse_rays: f32,
    /// Spacing of those. About twice as far as that of the others: closer ones buy nothing, twice as far costs a tenth.
    pub coarse: RadiusPolicy,
    /// Rays in the smallest cell of a glossy record: the rays of these records are in proportion, a third of all as it is. Noise
    /// of its sources falls with the root; it is seen where the irradiance is smoother than in the box.
    pub rays_per_cell: f32,
    /// Largest half angle of a cell over the width of the lobe, where the lobe is bright. Finer cells take rays with 1/angle² and
    /// keep edges of what is mirrored sharp: half of it takes 5 % off the error for three times the rays of glossy records, four times
    /// doubles the error.
    pub fineness: f32,
    /// Spacing of glossy records. Closer ones follow mirrored things that are near. The smallest radius decides their number and
    /// memory: less buys nothing, twice of it costs a fifth.
    pub glossy: RadiusPolicy,
    /// Largest radius of a glossy record of the paper, pixels: its weights need overlap.
    pub paper_reach: f32,
    /// Tolerance of the improved cut over τ. A record is read by other points than it was made for: the cut leaves room for
    /// them, in bytes: a quarter of it has 17 % more of them and 2 % less error.
    pub cut: f32,
    /// Error over the light that the second-order term may have within a radius, over τ. Less means more records where light
    /// bends: half of it takes a fifth off the error and two thirds off the bias, for 40 % more rays.
    pub curvature: f32,
}

impl Default for Knobs {
    fn default() -> Self {
        Self {
            irradiance_rays: 1600.0,
            irradiance: RadiusPolicy { scale: 0.5, min_pixels: 3.0, max_pixels: 24.0 },
            coarse_rays: 320.0,
            coarse: RadiusPolicy { scale: 0.7, min_pixels: 8.0, max_pixels: 40.0 },
            rays_per_cell: 4.0,
            fineness: 0.7,
            glossy: RadiusPolicy { scale: 0.6, min_pixels: 2.5, max_pixels: 14.0 },
            paper_reach: 20.0,
            cut: 0.1,
            curvature: 2.0,
        }
    }
}

/// Irradiance records have no fewer rays: their gradients would be noise.
const LEAST_RAYS: u32 = 64;
/// Nor have coarse ones fewer than these: with a quarter, pictures at τ = 0.1 have 5 % (sponza) to 45 % (box) more error for .7 to .9 of
/// the rays; twice as many gain nothing more.
const LEAST_COARSE_RAYS: u32 = 256;
/// Samples are numbered by so many.
const MOST_RAYS: f32 = 65_536.0;
/// No radius is less of a pixel, however small τ: records would be closer than what reads them.
const LEAST_PIXELS: f32 = 0.75;
/// The largest radius is at least so many pixels.
const LEAST_REACH: f32 = 2.0;
/// Cells become finer and coarser with τ within these factors: beyond, more rays in a cell buy more.
const FINER_CELLS: [f32; 2] = [0.7, 1.4];
/// Rays of a record of the paper (eas-2015, §3.2).
const PAPER_RAYS: u32 = 4096;
/// Reflected directions #D of the paper's cut (eas-2015, §3.2.2).
const PAPER_DIRECTIONS: usize = 64;
/// Most cells of the hemisphere, and most sources: bounds of time and memory that few records meet.
const MOST_CELLS: usize = 1024;
const MOST_SOURCES: usize = 1024;

impl Quality {
    /// [`Quality::with`] the numbers that pictures are rendered with.
    pub fn new(tolerance: f32, estimator: Estimator, spacing: Spacing) -> Self {
        Self::with(&Knobs::default(), tolerance, estimator, spacing)
    }

    /// Rays, spacing and number of sources for the tolerance τ: the error of independent records falls with the root of the
    /// rays, so half the tolerance takes four times as many, spread over records that are closer and rays of each.
    pub fn with(knobs: &Knobs, tolerance: f32, estimator: Estimator, spacing: Spacing) -> Self {
        let finer = TOLERANCE / tolerance;
        let rays = |n: f32| (n * finer).round().clamp(1.0, MOST_RAYS) as u32;
        // Areas, not radii, are inverse to the number of records.
        let closer = finer.sqrt().sqrt();
        let radius = |at: RadiusPolicy| RadiusPolicy {
            scale: at.scale / closer,
            min_pixels: (at.min_pixels / closer).max(LEAST_PIXELS),
            max_pixels: (at.max_pixels / closer).max(LEAST_REACH),
        };
        let [least_fine, most_fine] = FINER_CELLS;
        let (glossy, cut, weight) = match estimator {
            Estimator::Improved => (knobs.glossy, knobs.cut * tolerance, Weight::Smooth),
            Estimator::Paper => {
                (RadiusPolicy { max_pixels: knobs.paper_reach, ..knobs.glossy }, tolerance, Weight::Ward)
            }
        };
        Self {
            estimator,
            irradiance_rays: rays(knobs.irradiance_rays).max(LEAST_RAYS),
            irradiance: radius(knobs.irradiance),
            coarse_rays: rays(knobs.coarse_rays).max(LEAST_COARSE_RAYS),
            coarse: radius(knobs.coarse),
            rays_per_cell: rays(knobs.rays_per_cell),
            paper_rays: PAPER_RAYS,
            fineness: knobs.fineness / closer.clamp(least_fine, most_fine),
            max_cells: MOST_CELLS,
            glossy: radius(glossy),
            cut: CutSettings { tolerance: cut, max_eas: MOST_SOURCES },
            directions: PAPER_DIRECTIONS,
            weight,
            spacing,
            curvature: knobs.curvature * tolerance,
        }
    }
}

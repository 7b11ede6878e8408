//! Which τ a rendering takes: the one asked for, or the finest that fits into a budget of time.

use super::caches::Caches;
use super::file::Loaded;
use super::rendering::Rendering;
use super::settings::TOLERANCE;
use crate::picture::Budget;
use crate::world::World;
use std::time::Instant;

/// Share of a time budget that filling may use.
pub(super) const FILL_SHARE: f64 = 0.5;

/// τ of the first fill, from whose time that of a second is guessed. A coarser one is hardly cheaper (τ = 0.2 takes 0.6 to 0.9 of
/// the time, for a bias of 1 %).
pub(crate) const FIRST_TOLERANCE: f32 = 0.1;

/// Below that τ the time of a fill grows with τ^−1.1 (measured on the glossy box, the material preview, the dragon and the
/// staircase).
pub(crate) const COST_EXPONENT: f64 = 1.1;

/// Share of the time left that the second fill is planned for: the guess is rough.
const FILL_MARGIN: f64 = 0.8;

/// A second fill must bring τ below this share of the first one's.
const WORTH_A_SECOND_FILL: f32 = 0.7;

/// No budget of time asks for less.
pub(crate) const SMALLEST_TOLERANCE: f32 = 0.002;

/// Caches that were filled, with the τ they were filled for.
pub(super) struct Filled {
    pub tolerance: f32,
    pub caches: Caches,
}

/// Fills caches.
pub(super) struct Search<'a> {
    pub world: &'a World,
    pub rendering: &'a Rendering<'a>,
    /// When the rendering began.
    pub start: Instant,
    /// Told the share of the fill that is done.
    pub progress: &'a (dyn Fn(f64) + Sync),
}

impl Search<'_> {
    /// Caches at the τ in force; `kept` are those of an earlier run.
    pub fn run(&self, kept: Option<Loaded>) -> Filled {
        let (kept, complete) = kept.map_or((None, false), |k| (Some(k.caches), k.complete));
        if complete && let Some(caches) = kept {
            return Filled { tolerance: self.rendering.settings.tolerance.unwrap_or(TOLERANCE), caches };
        }
        let end = match self.rendering.settings.budget {
            Budget::Time(limit) => Some(self.start + limit.mul_f64(FILL_SHARE)),
            Budget::Samples(_) | Budget::Error(_) => None,
        };
        match (self.rendering.settings.tolerance, end) {
            (Some(tolerance), end) => self.fill(tolerance, kept, end),
            (None, None) => self.fill(TOLERANCE, kept, None),
            (None, Some(end)) => self.finest(kept, end),
        }
    }

    /// A first fill, and where there is time for one that is much finer, a second.
    fn finest(&self, kept: Option<Caches>, end: Instant) -> Filled {
        let first = Instant::now();
        let filled = self.fill(FIRST_TOLERANCE, kept.clone(), Some(end));
        let spent = first.elapsed().as_secs_f64();
        let left = end.saturating_duration_since(Instant::now()).as_secs_f64();
        let share = (spent / (FILL_MARGIN * left).max(1e-6)).powf(1.0 / COST_EXPONENT) as f32;
        if share < WORTH_A_SECOND_FILL {
            self.fill((FIRST_TOLERANCE * share).max(SMALLEST_TOLERANCE), kept, Some(end))
        } else {
            filled
        }
    }

    fn fill(&self, tolerance: f32, kept: Option<Caches>, end: Option<Instant>) -> Filled {
        Filled { tolerance, caches: self.rendering.fill(self.world, tolerance, kept, end, self.progress) }
    }
}

//! How many samples per pixel a time budget still allows, with the time set aside that the indirect light will take.

use std::time::{Duration, Instant};

/// Most samples per pixel of one pass.
pub(super) const PASS: u32 = 8;

/// Samples of the first pass, which tells what one costs.
const FIRST: u32 = 2;

/// Rows of which one is shaded on trial.
pub(super) const TRIAL_ROWS: usize = 16;

/// What a trial of few rows misses, and the end of the last pass.
const MARGIN: f64 = 1.1;

/// Times of the passes so far.
pub(super) struct Pace {
    end: Instant,
    spp: u32,
    /// Seconds of the passes of direct light.
    direct: f64,
    /// Seconds that indirect light would take now, and what each further sample adds: where surfaces are path traced, they
    /// take a path per sample.
    indirect: f64,
    per_sample: f64,
}

impl Pace {
    /// A budget that ends at `end`.
    pub fn new(end: Instant) -> Self {
        Self { end, spp: 0, direct: 0.0, indirect: 0.0, per_sample: 0.0 }
    }

    /// Notes a pass of direct light, and what a trial of the indirect light of one row in [`TRIAL_ROWS`] took after it.
    pub fn note(&mut self, pass: u32, direct: Duration, trial: Duration) {
        let indirect = MARGIN * TRIAL_ROWS as f64 * trial.as_secs_f64();
        if self.spp > 0 {
            self.per_sample = ((indirect - self.indirect) / f64::from(pass)).max(0.0);
        }
        self.indirect = indirect;
        self.direct += direct.as_secs_f64();
        self.spp += pass;
    }

    /// Samples of the next pass; 0 when it is time for the indirect light.
    pub fn next(&self) -> u32 {
        self.after(self.end.saturating_duration_since(Instant::now()).as_secs_f64())
    }

    fn after(&self, left: f64) -> u32 {
        if self.spp == 0 {
            return FIRST;
        }
        let cost = self.direct / f64::from(self.spp) + self.per_sample;
        (((left - self.indirect) / cost).max(0.0) as u32).min(PASS)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_is_left_for_indirect_light() {
        let mut pace = Pace::new(Instant::now());
        assert_eq!(pace.after(0.0), FIRST);
        // 0.1 s per sample; indirect light would take 0.176 s.
        pace.note(2, Duration::from_millis(200), Duration::from_millis(10));
        assert_eq!((pace.after(0.17), pace.after(0.5), pace.after(9.0)), (0, 3, PASS));
        // After eight more it would take 0.352 s: each costs 0.022 s more.
        pace.note(8, Duration::from_millis(800), Duration::from_millis(20));
        assert_eq!((pace.after(0.35), pace.after(0.48), pace.after(0.6)), (0, 1, 2));
    }
}

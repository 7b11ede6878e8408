//! How large a frame may be to come in time, and how many come in a second.

use crate::scene::Film;
use std::collections::VecDeque;
use std::time::{Duration, Instant};

/// Sizes between which frames change, in parts of the film: few, so that they do not change all the time.
const PARTS: u32 = 16;
/// The smallest, and the one of the first frame.
const LEAST: u32 = 2;
const FIRST: u32 = 4;
/// Share of a size by which more must be possible before frames grow.
const MARGIN: f64 = 1.1;
/// Weight of the last frame in what is known of a pixel's time.
const NEWEST: f64 = 0.4;

/// Sizes of frames that take a given time.
#[derive(Debug)]
pub(super) struct Pace {
    parts: u32,
    /// Seconds for the pixels of the whole film, once they are known.
    whole: Option<f64>,
}

impl Pace {
    pub fn new() -> Self {
        Self { parts: FIRST, whole: None }
    }

    /// The film of a frame.
    pub fn film(&self, film: &Film) -> Film {
        let longest = film.width.max(film.height);
        film.at_most((longest * self.parts / PARTS).max(1))
    }

    /// Notes what a frame took, which was to take `aim`.
    pub fn note(&mut self, took: Duration, aim: Duration) {
        let share = (f64::from(self.parts) / f64::from(PARTS)).powi(2);
        let seconds = took.as_secs_f64() / share;
        let whole = self.whole.map_or(seconds, |known| known * (seconds / known).powf(NEWEST)).max(1e-9);
        self.whole = Some(whole);
        let wanted = f64::from(PARTS) * (aim.as_secs_f64() / whole).sqrt();
        let parts = f64::from(self.parts);
        if wanted < parts || wanted >= MARGIN * parts || wanted >= f64::from(PARTS) {
            self.parts = (wanted as u32).clamp(LEAST, PARTS);
        }
    }
}

/// Records of a frame that are worth the search for more.
const WORTH: usize = 8;
/// Frames without a search where the last one was not worth it.
const REST: u32 = 3;

/// Which frames of a camera that moves are searched for missing records: to find that none is missing takes time too.
#[derive(Debug, Default)]
pub(super) struct Search {
    /// Frames without one before the next.
    rest: u32,
}

impl Search {
    /// Whether the next frame is searched.
    pub fn is_due(&mut self) -> bool {
        let due = self.rest == 0;
        self.rest = self.rest.saturating_sub(1);
        due
    }

    /// Notes how many records came of a search.
    pub fn note(&mut self, records: usize) {
        self.rest = if records < WORTH { REST } else { 0 };
    }
}

/// Frames of the last second.
#[derive(Debug, Default)]
pub(super) struct Meter(VecDeque<Instant>);

impl Meter {
    /// Notes a frame; returns how many come in a second.
    pub fn tick(&mut self, now: Instant) -> f64 {
        self.0.push_back(now);
        while self.0.len() > 2 && self.0.front().is_some_and(|first| now - *first > Duration::from_secs(1)) {
            self.0.pop_front();
        }
        match (self.0.front(), self.0.len()) {
            (Some(first), n) if n > 1 => (n - 1) as f64 / (now - *first).as_secs_f64().max(1e-3),
            _ => 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Filter;

    fn film() -> Film {
        Film { width: 512, height: 256, crop: None, filter: Filter::Box { radius: 0.5 } }
    }

    /// Frames settle at a size that takes the time there is, whatever a pixel costs, and stay in bounds.
    #[test]
    fn sizes_follow_the_time() {
        let aim = Duration::from_millis(75);
        for microseconds in [0.001, 0.1, 0.6, 2.0, 1e6] {
            let mut pace = Pace::new();
            let time = |film: &Film| Duration::from_secs_f64(f64::from(film.width * film.height) * microseconds * 1e-6);
            let mut sizes = Vec::new();
            for _ in 0..30 {
                let film = pace.film(&film());
                pace.note(time(&film), aim);
                sizes.push(film.width);
            }
            let last = pace.film(&film());
            assert!(sizes[25..].iter().all(|s| *s == last.width), "{microseconds}: {sizes:?}");
            assert!(time(&last) <= aim || last.width == 512 * LEAST / PARTS, "{microseconds}: {sizes:?}");
            assert!(last.width == 512 || time(&last).mul_f64(2.6) > aim, "{microseconds}: {sizes:?}");
        }
    }

    /// Where nothing is found few frames are searched, but never none.
    #[test]
    fn searches_follow_what_they_find() {
        let mut search = Search::default();
        for (records, searched) in [(100, 40), (0, 10), (100, 40)] {
            let mut count = 0;
            for _ in 0..40 {
                if search.is_due() {
                    search.note(records);
                    count += 1;
                }
            }
            assert_eq!(count, searched, "{records}");
        }
    }

    #[test]
    fn frames_are_counted() {
        let (start, mut meter) = (Instant::now(), Meter::default());
        assert_eq!(meter.tick(start), 0.0);
        let mut rate = 0.0;
        for i in 1..50 {
            rate = meter.tick(start + Duration::from_millis(100 * i));
        }
        assert!((rate - 10.0).abs() < 1e-6, "{rate}");
    }
}

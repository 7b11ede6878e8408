//! The way of the camera, noted while one walks.

use crate::walk::{MAX_FRAMES, Row, write_rows};
use std::collections::BTreeMap;
use std::time::Instant;

/// Frames per second of the path.
pub(super) const FPS: f64 = 24.0;
/// Frames from one row to the next, at least.
const APART: u32 = 2;
/// Frames of the longest walk: a quarter of what a path may have.
const LONGEST: u32 = MAX_FRAMES as u32 / 4;

/// Notes where the camera is.
#[derive(Debug)]
pub(super) struct Recorder {
    start: Instant,
    rows: BTreeMap<u32, Row>,
}

impl Recorder {
    /// Begins with a row.
    pub fn new(start: Instant, row: Row) -> Self {
        Self { start, rows: BTreeMap::from([(1, row)]) }
    }

    /// Notes where the camera is now; `false` where the walk is as long as it may be.
    pub fn note(&mut self, now: Instant, row: Row) -> bool {
        let frame = 1 + ((now - self.start).as_secs_f64() * FPS).min(f64::from(LONGEST)) as u32;
        let last = self.rows.last_key_value().map_or(0, |(frame, _)| *frame);
        if frame >= last + APART {
            self.rows.insert(frame, row);
        }
        frame < LONGEST
    }

    /// Rows so far.
    pub fn rows(&self) -> usize {
        self.rows.len()
    }

    /// As CSV for `render walk`.
    pub fn csv(&self) -> String {
        write_rows(self.rows.iter().map(|(frame, row)| (*frame, row)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::walk::read_rows;
    use glam::DVec3;
    use std::time::Duration;

    #[test]
    fn rows_have_the_numbers_of_their_frames() {
        let (up, fov, width) = (DVec3::Y, Some(40.0), None);
        let row = |x: f64| Row { eye: DVec3::splat(x), look: DVec3::splat(x + 1.0), up, fov, width };
        let start = Instant::now();
        let mut recorder = Recorder::new(start, row(0.0));
        for i in 1..=100 {
            assert!(recorder.note(start + Duration::from_millis(20 * i), row(i as f64)));
        }
        let rows = read_rows(recorder.csv().as_bytes()).unwrap();
        assert_eq!((rows.len(), *rows.keys().max().unwrap()), (recorder.rows(), 49));
        assert!(rows.keys().zip(rows.keys().skip(1)).all(|(a, b)| b - a >= APART));
        assert!(!recorder.note(start + Duration::from_secs(1 << 20), row(0.0)));
    }
}

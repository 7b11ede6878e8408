//! For which walk caches were filled, and how far.

use crate::denoise::Effort;
use serde::{Deserialize, Serialize};

/// For which walk caches were filled, and how far. Frames are counted from the first of the path.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct WalkMark {
    /// Checksum of the path with its film.
    pub path: u64,
    /// Frames of the path.
    pub frames: u32,
    /// First and last of the frames that are filled, in order and apart.
    pub filled: Vec<[u32; 2]>,
    /// First and last of the frames that are being filled, and how many of them are.
    pub current: Option<([u32; 2], u32)>,
    /// What a budget of time chose.
    pub chosen: Option<Chosen>,
}

/// How frames are drawn by the choice of a budget of time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Chosen {
    /// Samples per pixel.
    pub spp: u32,
    /// How well they are denoised.
    pub effort: Effort,
}

impl WalkMark {
    /// Of a path that nothing is filled for yet.
    pub fn new(path: u64, frames: u32) -> Self {
        Self { path, frames, filled: Vec::new(), current: None, chosen: None }
    }

    /// Notes that frames are filled.
    pub fn fill(&mut self, range: [u32; 2]) {
        self.filled.push(range);
        self.filled.sort_unstable();
        let mut joined: Vec<[u32; 2]> = Vec::with_capacity(self.filled.len());
        for &[first, last] in &self.filled {
            match joined.last_mut() {
                Some(before) if first <= before[1].saturating_add(1) => before[1] = before[1].max(last),
                _ => joined.push([first, last]),
            }
        }
        self.filled = joined;
    }

    /// Whether all of these frames are filled.
    pub fn covers(&self, [first, last]: [u32; 2]) -> bool {
        self.filled.iter().any(|[from, to]| *from <= first && last <= *to)
    }

    /// Whether all frames of the path are filled.
    pub fn is_complete(&self) -> bool {
        self.frames > 0 && self.covers([0, self.frames - 1])
    }

    /// Notes what another cache of the same path is filled for.
    pub fn join(&mut self, other: &Self) {
        other.filled.iter().for_each(|range| self.fill(*range));
        self.current = None;
        self.chosen = self.chosen.zip(other.chosen).map(|(a, b)| if a.spp <= b.spp { a } else { b });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_join() {
        let mut mark = WalkMark::new(1, 30);
        mark.fill([10, 19]);
        mark.fill([0, 4]);
        assert_eq!(mark.filled, [[0, 4], [10, 19]]);
        assert!(mark.covers([12, 19]) && !mark.covers([4, 10]) && !mark.is_complete());
        let mut other = WalkMark::new(1, 30);
        other.fill([20, 29]);
        other.fill([3, 9]);
        mark.join(&other);
        assert_eq!(mark.filled, [[0, 29]]);
        assert!(mark.is_complete());
    }
}

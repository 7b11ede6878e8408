//! How well to denoise in the time there is.

use super::DenoiseError;
use serde::{Deserialize, Serialize};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

/// How much work a denoiser puts into a picture. Our own has one way only.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Effort {
    /// Open Image Denoise's fast network.
    Least,
    /// Its usual one.
    Low,
    /// Its large one.
    High,
    /// The fast network, with direct and indirect light in one piece.
    Together,
}

/// All, the best first.
pub(super) const EFFORTS: [Effort; 4] = [Effort::High, Effort::Low, Effort::Least, Effort::Together];

impl Effort {
    /// Time for so many layers, in that of the usual network for one layer (measured: .48 to .51 for the fast one, 2.3 to 2.6 for
    /// the large one).
    fn cost(self, layers: usize) -> f64 {
        let layers = layers as f64;
        match self {
            Self::Least => 0.5 * layers,
            Self::Low => layers,
            Self::High => 2.5 * layers,
            Self::Together => 0.5,
        }
    }

    /// Largest share of a time budget that it is worth. Measured with clean guides, six scenes, 8 to 300 samples: the large network
    /// has .76 to 1 of the error of the usual one (.9 in the mean), the fast one 1.07 to 1.4 times that; samples that the same time would
    /// buy lower it with time^−0.6. Where two layers of the fast one would take half of a budget, one of both leaves time for a third to a
    /// half more samples, and keeps the budget.
    fn worth(self) -> f64 {
        match self {
            Self::Together => 1.0,
            Self::Least => 0.5,
            Self::Low => 0.4,
            Self::High => 0.2,
        }
    }
}

/// How a picture will be denoised.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plan {
    /// How well.
    pub effort: Effort,
    /// What it will take, seconds.
    pub seconds: f64,
}

/// What is set aside for a guess that is too low.
const MARGIN: f64 = 1.15;

/// Side of the square that is denoised to see what it costs, at most; and of the one before it, which loads what is needed.
const TRIAL: usize = 128;
const FIRST: usize = 32;
/// Layers of such a square.
const EXAMPLE_LAYERS: usize = 2;

/// Layers of a picture: direct and indirect light apart, and together where that comes from records.
pub(super) fn layers(from_records: bool) -> usize {
    if from_records { 1 } else { 2 }
}

/// Seconds for a pixel of a layer at the least effort, once they are known.
#[derive(Debug, Default)]
pub(super) struct Rate(Mutex<Option<f64>>);

impl Rate {
    /// Does work on so many pixels and layers, and notes how long it takes.
    pub fn timed<T>(
        &self,
        (pixels, layers): (usize, usize),
        effort: Effort,
        work: impl FnOnce() -> Result<T, DenoiseError>,
    ) -> Result<T, DenoiseError> {
        let start = Instant::now();
        let done = work()?;
        if pixels > 0 && layers > 0 {
            let rate = start.elapsed().as_secs_f64() / (pixels as f64 * effort.cost(layers));
            *self.0.lock().unwrap_or_else(PoisonError::into_inner) = Some(rate);
        }
        Ok(done)
    }

    /// The first of these efforts that `seconds` for the whole picture are worth, or the last; `trial` denoises a square of the given
    /// side.
    pub fn plan(
        &self,
        efforts: &[Effort],
        (pixels, layers): (u64, usize),
        seconds: Option<f64>,
        trial: impl Fn(usize) -> Result<(), DenoiseError>,
    ) -> Result<Plan, DenoiseError> {
        let known = *self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let rate = match known {
            Some(rate) => rate,
            None => {
                trial(FIRST)?;
                let side = (pixels as f64).sqrt().ceil().clamp(1.0, TRIAL as f64) as usize;
                self.timed((side * side, EXAMPLE_LAYERS), Effort::Low, || trial(side))?;
                let measured = *self.0.lock().unwrap_or_else(PoisonError::into_inner);
                measured.unwrap_or_default()
            }
        };
        Ok(choose(efforts, MARGIN * rate * pixels as f64, layers, seconds))
    }
}

/// The effort for so many layers where the usual network takes `unit` seconds for one.
fn choose(efforts: &[Effort], unit: f64, layers: usize, seconds: Option<f64>) -> Plan {
    let plan = |effort: Effort| Plan { effort, seconds: unit * effort.cost(layers) };
    let pays = |effort: &Effort| seconds.is_none_or(|s| unit * effort.cost(layers) <= s * effort.worth());
    let best = efforts.iter().copied().find(pays).or(efforts.last().copied());
    plan(best.unwrap_or(Effort::Low))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn effort_follows_the_time() {
        let efforts = [0.1, 0.21, 0.51, 2.4, 2.6].map(|s| choose(&EFFORTS, 0.1, 2, Some(s)).effort);
        assert_eq!(efforts, [Effort::Together, Effort::Least, Effort::Low, Effort::Low, Effort::High]);
        assert_eq!(choose(&EFFORTS, 0.1, 2, None).effort, Effort::High);
        assert!((choose(&EFFORTS, 0.1, 2, Some(1.0)).seconds - 0.2).abs() < 1e-9);
        assert!((choose(&EFFORTS, 0.1, 2, Some(0.3)).seconds - 0.1).abs() < 1e-9);
    }
}
